//! The jagged boundary of a region of a mesh becomes smooth: thin, where it was; wide, what it is now, blue where it turns to the right and
//! red where it turns to the left. The closeness goes up and down by itself until one takes it over by the keys Up and Down; the
//! title says what the line is like. The region is what somebody reaches in time who walks through each face at a random pace.
//!
//! `cargo run --release --features render,formats --example smoothing -- [MESH] [--z-up] [--pictures DIR]` (with pictures it writes
//! `before.png` and `after.png` and ends by itself)

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};
use std::f32::consts::FRAC_PI_2;
use std::path::PathBuf;

use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy_surface_splines::format::read_mesh;
use bevy_surface_splines::plugin::mesh_from;
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::Surface;
use glam::DVec3;

const FRONT: Vec3 = Vec3::new(0.35, 0.3, 1.0); // from where one sees the model at first
const REACH: f64 = 0.16; // how far the region reaches, as a share of the model's diagonal
const AWAY: f32 = 1.0; // from how far one looks at it; the diagonal is 2

#[derive(Resource)]
struct Options {
    mesh: PathBuf,
    z_up: bool,
    pictures: Option<PathBuf>,
}

fn main() -> AppExit {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let pictures = words.iter().skip_while(|word| *word != "--pictures").nth(1).cloned();
    let mesh = words.iter().find(|word| !word.starts_with("--") && pictures.as_ref() != Some(word)).cloned();
    let z_up = words.iter().any(|word| word == "--z-up");
    let mesh = mesh.unwrap_or(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/pebble.obj").into()).into();
    let renderer = RenderPlugin { synchronous_pipeline_compilation: true, ..default() }; // no picture before all is there
    let window = Window { title: "Smoothing".into(), resolution: (800, 600).into(), ..default() };
    let line = |width, depth_bias| {
        let line = GizmoLineConfig { width, joints: GizmoLineJoint::Round(4), ..default() };
        GizmoConfig { depth_bias, line, ..default() }
    };
    App::new()
        .add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }).set(renderer))
        .add_plugins(SurfaceSplinePlugins)
        .insert_gizmo_config(SplineGizmos { drawn_line: Color::NONE, ..default() }, line(4.5, -0.004))
        .insert_gizmo_config(DefaultGizmoConfigGroup, line(1.5, -0.003))
        .insert_resource(Options { mesh, z_up, pictures: pictures.map(PathBuf::from) })
        .add_systems(Startup, setup)
        .add_systems(Update, (slide.run_if(|options: Res<Options>| options.pictures.is_none()), say))
        .add_systems(PostUpdate, (draw_before, take_pictures).in_set(SurfaceSplineSystems::Draw))
        .add_observer(choose_region)
        .add_observer(|failed: On<SurfaceFailed>| error!("no surface: {}", failed.reason))
        .run()
}

fn setup(
    (mut commands, options): (Commands, Res<Options>),
    (mut meshes, mut materials): (ResMut<Assets<Mesh>>, ResMut<Assets<StandardMaterial>>),
) -> Result {
    let triangles = read_mesh(&options.mesh)?;
    let (low, high) = triangles.positions.iter().fold((DVec3::MAX, DVec3::MIN), |(a, b), p| (a.min(*p), b.max(*p)));
    let scale = 2.0 / low.distance(high);
    let turn = Quat::from_rotation_x(if options.z_up { -FRAC_PI_2 } else { 0.0 });
    let place = Transform::from_translation(turn * (-scale * low.midpoint(high)).as_vec3());
    let place = place.with_rotation(turn).with_scale(Vec3::splat(scale as f32));
    let clay = materials.add(StandardMaterial { perceptual_roughness: 0.9, ..Color::srgb(0.42, 0.44, 0.47).into() });
    commands.spawn((Mesh3d(meshes.add(mesh_from(&triangles))), MeshMaterial3d(clay), place, SplineSurface::default()));
    let sun = (
        DirectionalLight { illuminance: 7_000.0, ..default() },
        Transform::default().looking_to(Vec3::new(0.5, -0.7, -1.0), Vec3::Y),
    );
    let ambient = AmbientLight { brightness: 400.0, ..default() };
    commands.spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 3.0), ambient, children![sun]));
    Ok(())
}

/// Takes a region in the middle of what one sees from the front, and goes near.
fn choose_region(
    ready: On<SurfaceReady>,
    mut commands: Commands,
    surfaces: Query<(&BuiltSurface, &Transform), Without<Camera>>,
    (mut camera, mut gizmos): (Single<&mut Transform, With<Camera>>, ResMut<GizmoConfigStore>),
) -> Result {
    let (surface, place) = surfaces.get(ready.entity)?;
    let (low, high) = surface.bounds();
    let front = (place.rotation.inverse() * FRONT.normalize()).as_dvec3();
    let reach = REACH * surface.diagonal();
    let hit = surface.ray(low.midpoint(high) + surface.diagonal() * front, -front).ok_or("nothing is in the middle")?;
    let line = LineSource::around_faces(region(surface, hit.point.face, reach));
    commands.spawn((OnSurface(ready.entity), line, LineSmoothing { enabled: false, ..default() }));
    gizmos.config_mut::<SplineGizmos>().1.full_curvature = Some(3.0 / reach as f32);
    let at = place.transform_point(hit.position.as_vec3());
    let eye = at + AWAY * (place.rotation * (hit.normal + front).as_vec3()).normalize(); // the normal of a single face says little
    **camera = Transform::from_translation(eye).looking_at(at, Vec3::Y);
    Ok(())
}

fn region(surface: &Surface, first: FaceId, reach: f64) -> Vec<FaceId> {
    let sides = |face| {
        let v = surface.vertices(face).unwrap_or_default();
        [(v[0], v[1]), (v[1], v[2]), (v[2], v[0])].map(|(a, b)| (a.min(b), a.max(b)))
    };
    let mut beside = HashMap::<_, Vec<FaceId>>::new();
    for face in (0..surface.face_count() as u32).map(FaceId) {
        sides(face).into_iter().for_each(|side| beside.entry(side).or_default().push(face));
    }
    let noise = |face: FaceId| (face.0 + 7).wrapping_mul(0x9e37_79b1).rotate_left(15).wrapping_mul(0x85eb_ca6b) >> 8;
    // Times are whole numbers, a million of them for the reach.
    let takes =
        |face| 5e5 / reach * surface.mean_edge_length(face).unwrap_or(reach) * (0.2 + 1.5e-7 * f64::from(noise(face)));
    let (mut reached, mut queue) = (HashSet::new(), BinaryHeap::from([(Reverse(0), first)]));
    while let Some((Reverse(time), face)) = queue.pop().filter(|(Reverse(time), _)| *time < 1_000_000) {
        if reached.insert(face) {
            let next = sides(face).into_iter().filter_map(|side| beside.get(&side)).flatten();
            queue.extend(next.map(|next| (Reverse(time + takes(*next) as u64), *next)));
        }
    }
    reached.into_iter().collect()
}

/// Moves the slider, whose places are 0 to 1: by itself, until a key is pressed.
fn slide(
    (time, keys): (Res<Time>, Res<ButtonInput<KeyCode>>),
    (mut place, mut is_taken): (Local<f64>, Local<bool>),
    mut lines: Query<&mut LineSmoothing>,
) {
    let held = |key| f64::from(u8::from(keys.pressed(key)));
    let by = 0.3 * time.delta_secs_f64() * (held(KeyCode::ArrowUp) - held(KeyCode::ArrowDown));
    *is_taken |= by != 0.0;
    let own = 0.5 + 0.5 * (0.5 * time.elapsed_secs_f64()).sin();
    *place = if *is_taken { (*place + by).clamp(0.0, 1.0) } else { own };
    let [low, high] = LineSmoothing::SLIDER;
    lines.iter_mut().for_each(|mut line| *line = LineSmoothing::tether(low * (high / low).powf(*place)));
}

fn say(lines: Query<&SmoothedLine, Changed<SmoothedLine>>, mut window: Single<&mut Window>) {
    for line in &lines {
        let how = line.closeness.map_or("as drawn".into(), |closeness| format!("closeness {closeness:.1}"));
        let (count, turn, was) = (line.line.crossings().len(), line.after.total_turn, line.before.total_turn);
        let far = line.after.max_distance;
        window.title =
            format!("{how}: {count} crossings, turns by {turn:.1} of {was:.1} rad, at most {far:.4} from where it was");
    }
}

/// Draws the line as it was, thin; the plugin draws it as it is.
fn draw_before(mut gizmos: Gizmos, surfaces: SurfaceQueries, lines: Query<(&SmoothedLine, &OnSurface)>) {
    for (line, on) in lines.iter().filter(|(line, _)| line.by().is_some()) {
        let Some(view) = surfaces.get(on.0) else { continue };
        let before = line.drawn_polyline().iter().map(|p| view.to_world().transform_point3(*p));
        gizmos.linestrip(before, Color::srgb(0.1, 0.1, 0.1));
    }
}

/// With `--pictures`: takes them when all has settled, and ends.
fn take_pictures(
    mut commands: Commands,
    options: Res<Options>,
    lines: Query<&LineState>,
    window: Single<&Window>,
    mut frames: Local<u32>,
) {
    *frames += u32::from(lines.iter().any(|state| *state == LineState::Ready));
    let (Some(folder), 20 | 50) = (&options.pictures, *frames) else { return };
    info!("{}", window.title);
    let mut shot = commands.spawn(Screenshot::primary_window());
    if *frames == 20 {
        shot.observe(save_to_disk(folder.join("before.png"))).observe(
            |_: On<ScreenshotCaptured>, mut lines: Query<&mut LineSmoothing>| {
                lines.iter_mut().for_each(|mut line| line.enabled = true);
            },
        );
    } else {
        let end = |_: On<ScreenshotCaptured>, mut exits: MessageWriter<AppExit>| _ = exits.write(AppExit::Success);
        shot.observe(save_to_disk(folder.join("after.png"))).observe(end);
    }
}
