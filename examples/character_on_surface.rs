//! The hero walks over a wavy ring, flat on its surface, and the light follows him. Up lets him walk, Left and Right turn him; without a key for three
//! seconds he goes on by himself, in bends. He keeps his size and his direction wherever the way leads: what is up for him is carried along.
//!
//! `cargo run --release --features render,characters --example character_on_surface -- [--pictures DIR]` (with pictures it writes `on-surface-0.png`
//! to `on-surface-7.png`, eight steps of the way, and ends by itself)

use std::f64::consts::FRAC_PI_2;
use std::path::PathBuf;

use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy_surface_splines::plugin::{
    BezierCharacter, CharacterAsset, CharacterFailed, CharacterReady, LaidState, mesh_from,
};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::shapes;
use glam::DVec3;

const SPEED: f64 = 0.35; // local units a second; the hero is about half a unit tall

#[derive(Resource, Default)]
struct Options {
    pictures: Option<PathBuf>,
    taken: u32,
}

fn main() -> AppExit {
    let mut words = std::env::args().skip_while(|word| word != "--pictures");
    let pictures = words.nth(1).map(PathBuf::from);
    let renderer = RenderPlugin { synchronous_pipeline_compilation: true, ..default() }; // no picture before all is there
    let window = Window { title: "Up walks, Left and Right turn".into(), ..default() };
    App::new()
        .add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }).set(renderer))
        .add_plugins(SurfaceSplinePlugins)
        .insert_resource(Options { pictures, ..default() })
        .add_systems(Startup, setup)
        .add_systems(Update, (walk, look, say).chain())
        .add_systems(Update, take_pictures)
        .add_observer(put_down)
        .add_observer(start)
        .add_observer(|failed: On<SurfaceFailed>| error!("no surface: {}", failed.reason))
        .add_observer(|failed: On<CharacterFailed>| error!("no hero: {}", failed.reason))
        .run()
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let mut ring = shapes::torus(1.0, 0.5, 320, 160);
    for p in &mut ring.positions {
        let around = p.y.atan2(p.x);
        *p *= 1.0 + 0.04 * (5.0 * around).sin() * (3.0 * p.z).cos();
    }
    let clay = materials.add(StandardMaterial { perceptual_roughness: 0.9, ..Color::srgb(0.75, 0.72, 0.66).into() });
    commands.spawn((Mesh3d(meshes.add(mesh_from(&ring))), MeshMaterial3d(clay), SplineSurface::default()));
    let sun = (
        DirectionalLight { illuminance: 6_000.0, ..default() },
        Transform::default().looking_to(Vec3::new(0.4, -0.5, -1.0), Vec3::Y),
    );
    let ambient = AmbientLight { brightness: 500.0, ..default() };
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, -3.0, 3.0).looking_at(Vec3::ZERO, Vec3::Z),
        ambient,
        children![sun],
    ));
}

/// Puts the hero onto the ring when it is ready.
fn put_down(
    ready: On<SurfaceReady>,
    mut commands: Commands,
    surfaces: Query<&BuiltSurface>,
    assets: Res<AssetServer>,
) -> Result {
    let surface = surfaces.get(ready.entity)?;
    let at = surface.closest_point(DVec3::new(0.0, -1.2, 1.0)).ok_or("it has a place")?.point;
    let place = Placement { at, up: Vec3::Y, scale: 0.001 };
    commands.spawn((BezierCharacter(assets.load("hero.character.ron")), OnSurface(ready.entity), place));
    Ok(())
}

fn start(
    ready: On<CharacterReady>,
    assets: Res<Assets<CharacterAsset>>,
    mut heroes: Query<(&BezierCharacter, &mut AnimationPlayer)>,
) -> Result {
    let (character, mut player) = heroes.get_mut(ready.entity)?;
    let walk = assets.get(&character.0).and_then(|asset| asset.node("walk")).ok_or("he can walk")?;
    player.play(walk).repeat();
    Ok(())
}

/// Moves him along the surface: he looks to the right in his drawing.
fn walk(
    (time, keys, options): (Res<Time>, Res<ButtonInput<KeyCode>>, Res<Options>),
    surfaces: Query<&BuiltSurface>,
    mut heroes: Query<(&OnSurface, &mut Placement, &mut AnimationPlayer)>,
    mut alone: Local<f32>,
) -> Result {
    let delta = if options.pictures.is_some() { 1.0 / 60.0 } else { time.delta_secs_f64() };
    let held = |key| f64::from(u8::from(keys.pressed(key)));
    let [ahead, left, right] = [KeyCode::ArrowUp, KeyCode::ArrowLeft, KeyCode::ArrowRight].map(held);
    *alone = if ahead + left + right > 0.0 { 0.0 } else { *alone + delta as f32 };
    let by_himself = *alone > 3.0 || options.pictures.is_some();
    for (on, mut place, mut player) in &mut heroes {
        let surface = surfaces.get(on.0)?;
        let turn = if by_himself { 0.3 * f64::from(alone.sin()) } else { 1.5 * (left - right) };
        let far = SPEED * delta * if by_himself { 1.0 } else { ahead };
        if turn != 0.0 {
            place.turn(surface, turn * delta)?;
        }
        if far > 0.0 {
            place.walk(surface, -FRAC_PI_2, far)?;
            player.resume_all();
        } else {
            player.pause_all();
        }
    }
    Ok(())
}

/// Looks at him from above.
fn look(
    surfaces: SurfaceQueries,
    heroes: Query<(&OnSurface, &Placement), With<BezierCharacter>>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
) {
    let Ok((on, place)) = heroes.single() else { return };
    let Some(view) = surfaces.get(on.0) else { return };
    let at = view.position(place.at);
    let above = view.to_world().transform_vector3(view.surface().normal(&place.at).as_vec3()).normalize_or(Vec3::Z);
    let wanted =
        Transform::from_translation(at + 1.4 * above - 0.5 * place.up.normalize_or_zero()).looking_at(at, place.up);
    camera.translation = camera.translation.lerp(wanted.translation, 0.2);
    camera.rotation = camera.rotation.slerp(wanted.rotation, 0.2);
}

fn say(laid: Query<&LaidState, Changed<LaidState>>) {
    for state in &laid {
        match state {
            LaidState::Ready { clipped: 1.., off } => info!("{off} vertices are off the surface and cut"),
            LaidState::Failed { reason } => warn!("{reason}"),
            _ => {}
        }
    }
}

/// With `--pictures`: takes one every half second of his time, and ends.
fn take_pictures(mut commands: Commands, options: Res<Options>, laid: Query<&LaidState>, mut frames: Local<u32>) {
    *frames += u32::from(laid.iter().any(|state| matches!(state, LaidState::Ready { .. })));
    let Some(folder) = options.pictures.as_ref().filter(|_| (30..=240).contains(&*frames) && frames.is_multiple_of(30))
    else {
        return;
    };
    let (number, last) = (*frames / 30 - 1, *frames == 240);
    let mut shot = commands.spawn(Screenshot::primary_window());
    shot.observe(save_to_disk(folder.join(format!("on-surface-{number}.png")))).observe(
        move |_: On<ScreenshotCaptured>, mut options: ResMut<Options>, mut exits: MessageWriter<AppExit>| {
            options.taken += 1;
            if last {
                exits.write(AppExit::Success);
            }
        },
    );
}
