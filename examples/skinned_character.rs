//! A hero made of curves, who stands about, walks and waves: keys 1, 2 and 3. Smooth joins stay smooth and corners stay corners, because all that moves
//! are the control points of splines. N shows beside him what becomes of him if control points are moved like any other places: limbs get thin
//! at joints and outlines wobble. C shows the control points, T the skinned curves that splines come as near to as they can.
//!
//! `cargo run --release --features render,characters --example skinned_character -- [--pictures DIR]` (with pictures it writes `walk-0.png` to
//! `walk-7.png`, eight times of the walk with the naive way beside, and ends by itself)

use std::path::PathBuf;

use bevy::camera::ScalingMode;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy_surface_splines::character::WeightSource;
use bevy_surface_splines::plugin::{
    BezierCharacter, BezierPaths, CharacterAsset, CharacterFailed, CharacterReady, CharacterSystems, SkinBinding,
    SkinPose,
};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::skin::{HandleShape, NaiveWay, Shepard, skinned};
use glam::DVec3;

const AWAY: f32 = 320.0; // the naive figure stands so far to the right

#[derive(Resource, Default)]
struct Options {
    pictures: Option<PathBuf>,
    taken: u32,
    points: bool,
    target: bool,
}

/// How much each joint moves each place of a path, for the naive way and the target.
#[derive(Component)]
struct Weights(Vec<(Shepard, Vec<usize>)>);

/// The figure that is moved the naive way.
#[derive(Component)]
struct Naive;

fn main() -> AppExit {
    let mut words = std::env::args().skip_while(|word| word != "--pictures");
    let pictures = words.nth(1).map(PathBuf::from);
    let renderer = RenderPlugin { synchronous_pipeline_compilation: true, ..default() }; // no picture before all is there
    let window = Window { title: "1 idle, 2 walk, 3 wave; N naive, C control points, T target".into(), ..default() };
    App::new()
        .add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }).set(renderer))
        .add_plugins(SurfaceSplinePlugins)
        .insert_resource(ClearColor(Color::srgb(0.93, 0.92, 0.88)))
        .insert_resource(Options { pictures, ..default() })
        .add_systems(Startup, setup)
        .add_systems(Update, (choose, take_pictures))
        .add_systems(PostUpdate, move_naively.after(CharacterSystems::Pose).before(CharacterSystems::Tessellate))
        .add_systems(PostUpdate, draw.in_set(SurfaceSplineSystems::Draw))
        .add_observer(begin)
        .add_observer(|failed: On<CharacterFailed>| error!("no hero: {}", failed.reason))
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn(BezierCharacter(assets.load("hero.character.ron")));
    let scaling_mode = ScalingMode::AutoMin { min_width: 800.0, min_height: 620.0 };
    let lens =
        Projection::Orthographic(OrthographicProjection { scaling_mode, ..OrthographicProjection::default_3d() });
    commands.spawn((Camera3d::default(), lens, Transform::from_xyz(360.0, -270.0, 500.0)));
}

/// Lets him walk, and makes ready what the comparison needs: the weights that his file asks for.
fn begin(
    ready: On<CharacterReady>,
    mut commands: Commands,
    assets: Res<Assets<CharacterAsset>>,
    mut heroes: Query<(&BezierCharacter, &mut AnimationPlayer, &SkinBinding)>,
    naive: Query<Entity, With<Naive>>,
    options: Res<Options>,
) -> Result {
    let (character, mut player, binding) = heroes.get_mut(ready.entity)?;
    let asset = assets.get(&character.0).ok_or("its file is loaded")?;
    player.play(asset.node("walk").ok_or("he can walk")?).repeat();
    let character = asset.character();
    let handle = |joint: usize| {
        let joint = &character.joints[joint];
        let at = joint.at.extend(0.0);
        joint.tip.map_or(HandleShape::Point(at), |tip| HandleShape::Bone(at, tip.extend(0.0)))
    };
    let mut weights = Vec::new();
    for path in 0..binding.picture().path_count() {
        let joints: Vec<usize> =
            (0..character.joints.len()).filter(|joint| binding.is_influenced(path, *joint)).collect();
        let WeightSource::Shepard { power } = character.weights else {
            return Err("weights by distance are shown".into());
        };
        let handles: Vec<HandleShape> = joints.iter().map(|joint| handle(*joint)).collect();
        weights.push((Shepard::with_power(&handles, power)?, joints));
    }
    commands.entity(ready.entity).insert(Weights(weights));
    naive.iter().for_each(|old| commands.entity(old).despawn());
    let seen = if options.pictures.is_some() { Visibility::Visible } else { Visibility::Hidden };
    let place = Transform::from_xyz(AWAY, 0.0, 0.0);
    commands.spawn((Naive, BezierPaths::new(binding.picture().clone()), place, seen));
    Ok(())
}

fn choose(
    keys: Res<ButtonInput<KeyCode>>,
    assets: Res<Assets<CharacterAsset>>,
    mut options: ResMut<Options>,
    mut heroes: Query<(&BezierCharacter, &mut AnimationPlayer)>,
    mut naive: Query<&mut Visibility, With<Naive>>,
) {
    options.points ^= keys.just_pressed(KeyCode::KeyC);
    options.target ^= keys.just_pressed(KeyCode::KeyT);
    if keys.just_pressed(KeyCode::KeyN) {
        naive.iter_mut().for_each(|mut seen| seen.toggle_visible_hidden());
    }
    let clips = [(KeyCode::Digit1, "idle"), (KeyCode::Digit2, "walk"), (KeyCode::Digit3, "wave")];
    let Some((_, clip)) = clips.into_iter().find(|(key, _)| keys.just_pressed(*key)) else { return };
    for (character, mut player) in &mut heroes {
        if let Some(node) = assets.get(&character.0).and_then(|asset| asset.node(clip)) {
            player.stop_all();
            player.play(node).repeat();
        }
    }
}

fn move_naively(
    heroes: Query<(&SkinBinding, &SkinPose, &Weights), With<BezierCharacter>>,
    mut naive: Query<(&mut BezierPaths, &Visibility), With<Naive>>,
) {
    let Ok((binding, pose, weights)) = heroes.single() else { return };
    for (mut paths, _) in naive.iter_mut().filter(|(_, seen)| **seen != Visibility::Hidden) {
        for (chain, path) in binding.skin().chains().iter().zip(binding.paths()) {
            let (weights, joints) = &weights.0[*path as usize];
            let moved: Vec<_> = joints.iter().filter_map(|joint| pose.transforms().get(*joint).copied()).collect();
            let points = NaiveWay::ControlPoints.pose(chain.chain(), weights, &moved);
            paths.set_points(*path as usize, points.iter().map(|p| p.as_vec3()));
        }
    }
}

/// Draws control points and targets.
fn draw(mut gizmos: Gizmos, options: Res<Options>, heroes: Query<(&BezierPaths, &SkinBinding, &SkinPose, &Weights)>) {
    let Ok((paths, binding, pose, weights)) = heroes.single() else { return };
    let above = Vec3::Z * 50.0;
    for (chain, path) in binding.skin().chains().iter().zip(binding.paths()) {
        if options.points {
            let points = paths.points_of(*path as usize);
            gizmos.linestrip(points.iter().map(|p| *p + above), Color::srgba(0.0, 0.3, 0.9, 0.4));
            points.iter().step_by(3).for_each(|p| drop(gizmos.circle(*p + above, 2.0, Color::srgb(0.0, 0.3, 0.9))));
        }
        if options.target {
            let (weights, joints) = &weights.0[*path as usize];
            let moved: Vec<_> = joints.iter().filter_map(|joint| pose.transforms().get(*joint).copied()).collect();
            let (points, mut scratch) = (chain.chain().points(), Vec::new());
            let n = points.len();
            for first in (0..n.saturating_sub(2)).step_by(3) {
                let [a, b, c, d] = [0, 1, 2, 3].map(|k| points[(first + k) % n]);
                let at =
                    |t: f64| a * (1.0 - t).powi(3) + (b * (1.0 - t) + c * t) * (3.0 * t * (1.0 - t)) + d * t.powi(3);
                let mut place = |t: f64| -> DVec3 { skinned(weights, &moved, at(t), &mut scratch) };
                let line: Vec<Vec3> = (0..=8).map(|k| place(f64::from(k) / 8.0).as_vec3() + above).collect();
                gizmos.linestrip(line, Color::srgb(0.9, 0.1, 0.3));
            }
        }
    }
}

/// With `--pictures`: drives the time of the walk by hand, takes eight of them, and ends.
fn take_pictures(
    mut commands: Commands,
    options: Res<Options>,
    assets: Res<Assets<CharacterAsset>>,
    mut heroes: Query<(&BezierCharacter, &mut AnimationPlayer), With<Weights>>,
    mut frames: Local<u32>,
) {
    let (Some(folder), Ok((character, mut player))) = (options.pictures.clone(), heroes.single_mut()) else { return };
    let walk =
        assets.get(&character.0).and_then(|asset| asset.character().clips.get(asset.character().clip_named("walk")?));
    let duration = walk.map_or(1.0, |walk| walk.duration as f32);
    player.playing_animations_mut().for_each(|(_, active)| {
        active.pause().seek_to(options.taken as f32 / 8.0 * duration);
    });
    *frames += 1;
    if frames.is_multiple_of(10) && options.taken < 8 {
        let last = options.taken == 7;
        let mut shot = commands.spawn(Screenshot::primary_window());
        shot.observe(save_to_disk(folder.join(format!("walk-{}.png", options.taken)))).observe(
            move |_: On<ScreenshotCaptured>, mut options: ResMut<Options>, mut exits: MessageWriter<AppExit>| {
                options.taken += 1;
                if last {
                    exits.write(AppExit::Success);
                }
            },
        );
    }
}
