//! A leaf with four yellow handles. Drag one, and the leaf bends along; let go, and it settles: the solve that runs while one drags keeps the ratios
//! of handle lengths at joins, the one that runs on release frees them and comes nearer to what the handles ask for. The right button turns a handle.
//! R brings all back.
//!
//! `cargo run --release --features render,characters --example pose_by_hand -- [--pictures DIR]` (with pictures it bends the leaf by itself, writes
//! `dragged.png` and `released.png`, and ends)

use std::path::PathBuf;

use bevy::camera::ScalingMode;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy_surface_splines::plugin::{BezierPaths, FlexibleSolve, JointWeights, SkinState, SplineSkin, SvgDrawing};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::vector::{Picture, PictureOptions};

const HANDLES: [Vec2; 4] = [Vec2::new(50.0, 96.0), Vec2::new(50.0, 66.0), Vec2::new(50.0, 36.0), Vec2::new(50.0, 6.0)];

#[derive(Resource, Default)]
struct Options {
    pictures: Option<PathBuf>,
    taken: u32,
}

#[derive(Resource)]
struct Leaf(Handle<SvgDrawing>);

/// A place to hold the leaf by.
#[derive(Component)]
struct Grip(Vec2);

fn main() -> AppExit {
    let mut words = std::env::args().skip_while(|word| word != "--pictures");
    let pictures = words.nth(1).map(PathBuf::from);
    let renderer = RenderPlugin { synchronous_pipeline_compilation: true, ..default() }; // no picture before all is there
    let window = Window { title: "Drag the handles; right button turns, R resets".into(), ..default() };
    App::new()
        .add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }).set(renderer))
        .add_plugins(SurfaceSplinePlugins)
        .insert_resource(ClearColor(Color::srgb(0.95, 0.94, 0.9)))
        .insert_resource(Options { pictures, ..default() })
        .add_systems(Startup, |mut commands: Commands, assets: Res<AssetServer>| {
            let scaling_mode = ScalingMode::AutoMin { min_width: 160.0, min_height: 130.0 };
            let lens = OrthographicProjection { scaling_mode, ..OrthographicProjection::default_3d() };
            // The drawing has y down, and so is looked at.
            let place = Transform::from_xyz(50.0, 50.0, -100.0).looking_at(Vec3::new(50.0, 50.0, 0.0), Vec3::NEG_Y);
            commands.spawn((Camera3d::default(), Projection::Orthographic(lens), place));
            commands.insert_resource(Leaf(assets.load("leaf.svg")));
        })
        .add_systems(Update, (make, drag, bend_by_itself))
        .add_systems(PostUpdate, draw.in_set(SurfaceSplineSystems::Draw))
        .run()
}

/// Makes the picture when its drawing is loaded: handles first, the skin of them then.
fn make(mut commands: Commands, leaf: Res<Leaf>, drawings: Res<Assets<SvgDrawing>>, made: Query<(), With<SplineSkin>>) {
    let Some(drawing) = drawings.get(&leaf.0).filter(|_| made.is_empty()) else { return };
    let picture = Picture::of_drawing(&drawing.drawing, &PictureOptions::default());
    let mut grip = |at: Vec2| commands.spawn((Grip(at), Transform::from_translation(at.extend(0.0)))).id();
    let joints = HANDLES.map(&mut grip);
    let inverse = HANDLES.map(|at| Mat4::from_translation(-at.extend(0.0)));
    let (weights, flexible) = (JointWeights::Joints(4.0), FlexibleSolve::OnRelease);
    commands.spawn((BezierPaths::new(picture), SplineSkin { weights, flexible, ..SplineSkin::new(joints, inverse) }));
}

fn drag(
    (buttons, keys): (Res<ButtonInput<MouseButton>>, Res<ButtonInput<KeyCode>>),
    window: Single<&Window>,
    camera: Single<(&Camera, &GlobalTransform)>,
    mut grips: Query<(Entity, &Grip, &mut Transform)>,
    mut held: Local<Option<(Entity, Vec2)>>,
) {
    if keys.just_pressed(KeyCode::KeyR) {
        grips.iter_mut().for_each(|(_, grip, mut place)| *place = Transform::from_translation(grip.0.extend(0.0)));
    }
    let (camera, place) = *camera;
    let cursor = window.cursor_position().and_then(|at| camera.viewport_to_world_2d(place, at).ok());
    let Some(at) = cursor else { return };
    let pressed = [MouseButton::Left, MouseButton::Right].map(|button| buttons.pressed(button));
    if pressed == [false, false] {
        *held = None;
    } else if held.is_none() {
        let far = |place: &Transform| place.translation.truncate().distance(at);
        let nearest = grips.iter().map(|(entity, _, place)| (entity, far(place))).min_by(|a, b| a.1.total_cmp(&b.1));
        *held = nearest.filter(|(_, far)| *far < 6.0).map(|(entity, _)| (entity, at));
    }
    let Some((entity, from)) = &mut *held else { return };
    let Ok((.., mut place)) = grips.get_mut(*entity) else { return };
    if pressed[0] {
        place.translation += (at - *from).extend(0.0);
    } else {
        place.rotate_z(0.03 * (at.x - from.x));
    }
    *from = at;
}

fn draw(mut gizmos: Gizmos, grips: Query<&Transform, With<Grip>>) {
    for place in &grips {
        let at = place.translation - Vec3::Z;
        gizmos.circle(Isometry3d::from_translation(at), 1.6, Color::srgb(0.9, 0.65, 0.0));
        gizmos.line(at, at + place.rotation * Vec3::X * 4.0, Color::srgb(0.9, 0.65, 0.0));
    }
}

/// With `--pictures`: bends the leaf, takes a picture while it still moves, lets go, takes another, and ends.
fn bend_by_itself(
    mut commands: Commands,
    options: Res<Options>,
    ready: Query<&SkinState>,
    mut grips: Query<(&Grip, &mut Transform)>,
    mut frames: Local<u32>,
) {
    let Some(folder) = &options.pictures else { return };
    *frames += u32::from(ready.iter().any(|state| *state == SkinState::Ready));
    if (1..=40).contains(&*frames) {
        for (grip, mut place) in grips.iter_mut().filter(|(grip, _)| grip.0.y < 40.0) {
            let share = *frames as f32 / 40.0 * (60.0 - grip.0.y) / 54.0;
            place.translation = (grip.0 + Vec2::new(38.0, 10.0) * share).extend(0.0);
            place.rotation = Quat::from_rotation_z(1.2 * share);
        }
    }
    if *frames == 39 || *frames == 60 {
        let (name, last) = if *frames == 39 { ("dragged.png", false) } else { ("released.png", true) };
        let mut shot = commands.spawn(Screenshot::primary_window());
        shot.observe(save_to_disk(folder.join(name))).observe(
            move |_: On<ScreenshotCaptured>, mut options: ResMut<Options>, mut exits: MessageWriter<AppExit>| {
                options.taken += 1;
                if last {
                    exits.write(AppExit::Success);
                }
            },
        );
    }
}
