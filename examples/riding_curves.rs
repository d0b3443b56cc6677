//! An eel that sways, with an orange spiral and a wavy ring on its skin: curves on the mesh as it was made, which stay on it whatever the
//! joints do. Where the mouse points, a white ring lies flat on the skin as it is seen at that moment; a click leaves a bead
//! there, which rides along from then on.
//!
//! `cargo run --release --features render,engine_gltf --example riding_curves -- [FILE.glb] [--pictures DIR]` (any glTF file with joints, morph
//! targets or moving nodes will do; with pictures it writes `riding-0.png` to `riding-2.png`, three times of the clip, and ends by itself)

use std::path::{Path, PathBuf};

use bevy::camera::RenderTarget;
use bevy::camera::primitives::MeshAabb;
use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::{Location, PointerAction, PointerId, PointerInput};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::window::{PrimaryWindow, WindowRef};
use bevy::world_serialization::WorldInstanceReady;
use bevy_surface_splines::plugin::{RidingCurve, SurfaceHit};
use bevy_surface_splines::prelude::*;

/// The file, what is written, and how large the model is.
#[derive(Resource)]
struct Options {
    file: String,
    gltf: Handle<Gltf>,
    pictures: Option<PathBuf>,
    bounds: (Vec3, Vec3),
}

/// Something at a place of the skin.
#[derive(Component)]
struct Bead(Entity, SurfacePoint);

fn main() -> AppExit {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let option = words.iter().position(|word| word == "--pictures");
    let pictures = option.and_then(|at| words.get(at + 1)).map(PathBuf::from);
    let path = words.first().filter(|word| !word.starts_with("--")).map(|file| Path::new(file).to_owned());
    let file = path.as_ref().and_then(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned());
    let folder = path.as_ref().and_then(|path| path.canonicalize().ok()?.parent().map(Path::to_owned));
    let assets = folder.map_or_else(AssetPlugin::default, |folder| AssetPlugin {
        file_path: folder.to_string_lossy().into_owned(),
        ..default()
    });
    let renderer = RenderPlugin { synchronous_pipeline_compilation: true, ..default() }; // no picture before all is there
    let title = "Point at the skin; a click leaves a bead".into();
    let window = Window { title, resolution: (800, 600).into(), ..default() };
    let options = Options {
        file: file.unwrap_or("eel.glb".into()),
        gltf: default(),
        pictures,
        bounds: (Vec3::INFINITY, Vec3::NEG_INFINITY),
    };
    App::new()
        .add_plugins(
            DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }).set(assets).set(renderer),
        )
        .add_plugins(SurfaceSplinePlugins)
        .insert_resource(options)
        .insert_resource(ClearColor(Color::srgb(0.16, 0.18, 0.22)))
        .add_systems(Startup, setup)
        .add_systems(Update, (put_curves, take_pictures))
        .add_systems(PostUpdate, (mark, ride).in_set(SurfaceSplineSystems::Draw))
        .add_observer(play)
        .add_observer(drop_bead)
        .add_observer(|failed: On<SurfaceFailed>| error!("no surface: {}", failed.reason))
        .run()
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut options: ResMut<Options>,
    mut gizmos: ResMut<GizmoConfigStore>,
) {
    options.gltf = assets.load(options.file.clone());
    commands.spawn(WorldAssetRoot(assets.load(GltfAssetLabel::Scene(0).from_asset(options.file.clone()))));
    gizmos.config_mut::<SplineGizmos>().0.line.width = 5.0;
    let sun = (
        DirectionalLight { illuminance: 6_000.0, ..default() },
        Transform::default().looking_to(Vec3::new(-0.5, -0.6, -1.0), Vec3::Y),
    );
    commands.spawn((Camera3d::default(), AmbientLight { brightness: 500.0, ..default() }, children![sun]));
}

/// Plays the last clip, and asks for surfaces of all meshes: nothing else is needed for curves to ride on them.
fn play(
    ready: On<WorldInstanceReady>,
    mut commands: Commands,
    options: Res<Options>,
    (gltfs, mut graphs): (Res<Assets<Gltf>>, ResMut<Assets<AnimationGraph>>),
    children: Query<&Children>,
    meshes: Query<(), With<Mesh3d>>,
    mut players: Query<&mut AnimationPlayer>,
) {
    let clip = gltfs.get(&options.gltf).and_then(|gltf| gltf.animations.last().cloned());
    for entity in children.iter_descendants(ready.entity) {
        if meshes.contains(entity) {
            commands.entity(entity).insert(SplineSurface::default());
        }
        if let (Ok(mut player), Some(clip)) = (players.get_mut(entity), &clip) {
            let (graph, node) = AnimationGraph::from_clip(clip.clone());
            player.play(node).repeat();
            commands.entity(entity).insert(AnimationGraphHandle(graphs.add(graph)));
        }
    }
}

/// A spiral and a ring about each mesh, at the places of its surface that are nearest to them; and the camera shows it all.
fn put_curves(
    mut commands: Commands,
    built: Query<(Entity, &BuiltSurface, &Mesh3d), Added<BuiltSurface>>,
    (surfaces, meshes): (SurfaceQueries, Res<Assets<Mesh>>),
    mut options: ResMut<Options>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
) {
    for (entity, surface, mesh) in &built {
        let Some(bounds) = meshes.get(mesh).and_then(Mesh::compute_aabb) else { continue };
        let half = Vec3::from(bounds.half_extents);
        let long = half.max_position();
        let about = |along: f32, angle: f32| {
            let mut at = Vec3::ZERO;
            at[(long + 1) % 3] = 0.8 * half[(long + 1) % 3] * angle.cos();
            at[(long + 2) % 3] = 0.8 * half[(long + 2) % 3] * angle.sin();
            at[long] = along * half[long];
            Vec3::from(bounds.center) + at
        };
        let spiral = (0..=24).map(|k| about(-0.85 + 0.055 * k as f32, 0.8 * k as f32));
        let ring = (0..8).map(|k| about(if k % 2 == 0 { 0.62 } else { 0.72 }, std::f32::consts::FRAC_PI_4 * k as f32));
        commands.spawn((OnSurface(entity), SplineSource::smooth_through(spiral)));
        commands.spawn((OnSurface(entity), SplineSource::smooth_through(ring).closed()));
        let Some(view) = surfaces.get(entity) else { continue };
        for face in (0..surface.face_count() as u32).map(FaceId) {
            let at = view.position(SurfacePoint { face, weights: [0.3, 0.3, 0.4] });
            options.bounds = (options.bounds.0.min(at), options.bounds.1.max(at));
        }
        let (middle, size) = (options.bounds.0.midpoint(options.bounds.1), options.bounds.0.distance(options.bounds.1));
        **camera = Transform::from_translation(middle + size * Vec3::new(0.4, 0.25, 1.2)).looking_at(middle, Vec3::Y);
    }
}

/// A ring where the mouse points: picking knows the place of the skin, and the skin where that is by now.
fn mark(mut gizmos: Gizmos, hovered: Res<HoverMap>, surfaces: SurfaceQueries, options: Res<Options>) {
    let radius = 0.03 * options.bounds.0.distance(options.bounds.1);
    for (entity, hit) in hovered.values().flatten() {
        let (Some(hit), Some(view)) = (hit.extra_as::<SurfaceHit>(), surfaces.get(*entity)) else { continue };
        let (at, normal) = (view.position(hit.point), view.normal(hit.point));
        let turn = Quat::from_rotation_arc(Vec3::Z, normal);
        gizmos.circle(Isometry3d::new(at + 0.1 * radius * normal, turn), radius, Color::WHITE);
        gizmos.line(at, at + 2.0 * radius * normal, Color::WHITE);
    }
}

fn drop_bead(
    click: On<Pointer<Click>>,
    mut commands: Commands,
    (mut meshes, mut materials): (ResMut<Assets<Mesh>>, ResMut<Assets<StandardMaterial>>),
    options: Res<Options>,
) {
    // The event goes on to the parents of what was hit.
    let Some(hit) = click.hit.extra_as::<SurfaceHit>().filter(|_| click.entity == click.original_event_target()) else {
        return;
    };
    let radius = 0.014 * options.bounds.0.distance(options.bounds.1);
    let red = materials.add(Color::srgb(0.9, 0.15, 0.2));
    commands.spawn((Bead(click.entity, hit.point), Mesh3d(meshes.add(Sphere::new(radius))), MeshMaterial3d(red)));
}

/// Beads ride where curves do: after transforms are propagated, so that they are where the skin is in the same frame.
fn ride(surfaces: SurfaceQueries, mut beads: Query<(&Bead, &mut GlobalTransform), Without<BuiltSurface>>) {
    for (Bead(on, point), mut place) in &mut beads {
        if let Some(view) = surfaces.get(*on) {
            *place = GlobalTransform::from_translation(view.position(*point));
        }
    }
}

/// With `--pictures`: at three times of the clip, clicks at a place of the skin each, takes a picture, and ends.
fn take_pictures(
    mut commands: Commands,
    options: Res<Options>,
    (riding, surfaces): (Query<&OnSurface, With<RidingCurve>>, SurfaceQueries),
    camera: Single<(&Camera, &GlobalTransform)>,
    (mut players, window): (Query<&mut AnimationPlayer>, Single<Entity, With<PrimaryWindow>>),
    mut pointer: MessageWriter<PointerInput>,
    mut frames: Local<u32>,
) {
    let (Some(folder), Some(on)) = (&options.pictures, riding.iter().next()) else { return };
    let number = *frames / 30;
    for mut player in &mut players {
        player.playing_animations_mut().for_each(|(_, active)| {
            active.pause().seek_to(1.3 * number as f32 + 0.4);
        });
    }
    *frames += 1;
    let Some(view) = surfaces.get(on.0) else { return };
    let height = [2.2, 3.0, 1.4][number.min(2) as usize];
    let Some(place) = view.surface().closest_point(glam::DVec3::new(0.3, height, 0.9)) else { return };
    let Ok(pixel) = camera.0.world_to_viewport(camera.1, view.position(place.point)) else { return };
    let Some(target) = RenderTarget::Window(WindowRef::Primary).normalize(Some(*window)) else { return };
    let location = Location { target, position: pixel };
    let mut send = |action| {
        pointer.write(PointerInput::new(PointerId::Mouse, location.clone(), action));
    };
    match *frames % 30 {
        10 => send(PointerAction::Press(PointerButton::Primary)),
        12 => send(PointerAction::Release(PointerButton::Primary)),
        20 if number < 3 => {
            let mut shot = commands.spawn(Screenshot::primary_window());
            shot.observe(save_to_disk(folder.join(format!("riding-{number}.png")))).observe(
                move |_: On<ScreenshotCaptured>, mut exits: MessageWriter<AppExit>| {
                    if number == 2 {
                        exits.write(AppExit::Success);
                    }
                },
            );
        }
        _ => send(PointerAction::Move { delta: Vec2::ZERO }),
    }
}
