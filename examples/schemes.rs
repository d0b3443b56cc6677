//! Six tori with the same control polygon (thin lines) and the curve that each scheme makes of it (orange). The slider, or the
//! arrow keys, draw the polygon apart: while it is small the curves are alike; when it is large the two schemes for
//! comparison break, and their labels say so.
//!
//! `cargo run --release --features editor --example schemes -- [--picture FILE]` (then it ends by itself)

use bevy::camera::ScalingMode;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy_egui::{EguiContexts, EguiPlugin, EguiPrimaryContextPass, egui};
use bevy_surface_splines::prelude::*;

const CURVE: Color = Color::srgb(1.0, 0.55, 0.1);
const POLYGON: Color = Color::srgb(0.55, 0.8, 1.0);
const CELL: Vec2 = Vec2::new(5.0, 2.95); // from torus to torus, in the plane of the picture

/// How far apart the control points are, and the polygon in a torus's space.
#[derive(Resource)]
struct Stage {
    spread: f32,
    points: Vec<Vec3>,
    legs: Vec<Vec3>,
}

#[derive(Component)]
struct Shown(Method);

#[derive(Default, Reflect, GizmoConfigGroup)]
struct Behind;

fn main() -> AppExit {
    let renderer = RenderPlugin { synchronous_pipeline_compilation: true, ..default() }; // no picture before all is there
    let window = Window { title: "Schemes".into(), resolution: (1200, 500).into(), ..default() };
    let line = |width, depth_bias| {
        let line = GizmoLineConfig { width, joints: GizmoLineJoint::Round(3), ..default() };
        GizmoConfig { depth_bias, line, ..default() }
    };
    App::new()
        .add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }).set(renderer))
        .add_plugins((EguiPlugin::default(), SurfaceSplinePlugins))
        .insert_resource(Stage { spread: 1.0, points: vec![], legs: vec![] })
        .insert_gizmo_config(SplineGizmos { curve: CURVE, ..default() }, line(3.5, -0.003))
        .insert_gizmo_config(DefaultGizmoConfigGroup, line(1.5, -0.002))
        .insert_gizmo_config(Behind, line(1.5, -0.9))
        .add_systems(Startup, setup)
        .add_systems(Update, shape.run_if(resource_changed::<Stage>.or_else(not(any_with_component::<SplineTrace>))))
        .add_systems(PostUpdate, (draw, take_picture).in_set(SurfaceSplineSystems::Draw))
        .add_systems(EguiPrimaryContextPass, show_panel)
        .run()
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let torus = meshes.add(Torus::new(0.55, 1.45).mesh().major_resolution(48).minor_resolution(24));
    let clay = materials.add(Color::srgb(0.3, 0.32, 0.36));
    let eye = Transform::from_xyz(0.0, 8.5, 3.5).looking_at(Vec3::ZERO, Vec3::Y);
    for (i, method) in (0u8..).zip(Method::ALL) {
        let cell = CELL * Vec2::new(f32::from(i % 3) - 0.83, 0.56 - f32::from(i / 3));
        let place = Transform::from_translation(eye.rotation * cell.extend(0.0));
        let look = (Mesh3d(torus.clone()), MeshMaterial3d(clay.clone()), place);
        commands.spawn((look, SplineSurface::default(), related!(SurfaceItems[Shown(method)])));
    }
    let scaling_mode = ScalingMode::FixedHorizontal { viewport_width: 3.0 * CELL.x };
    let lens = OrthographicProjection { scaling_mode, near: 0.0, far: 20.0, ..OrthographicProjection::default_3d() };
    commands.spawn((Camera3d::default(), Projection::Orthographic(lens), eye));
    commands.spawn((DirectionalLight::default(), Transform::from_xyz(-3.0, 8.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y)));
}

/// Lays the control polygon on the torus, and gives it to all curves.
fn shape(
    mut commands: Commands,
    mut stage: ResMut<Stage>,
    curves: Query<(Entity, &Shown, &OnSurface)>,
    surfaces: Query<&BuiltSurface>,
) {
    let Some(surface) = curves.iter().find_map(|(_, _, on)| surfaces.get(on.0).ok()) else { return };
    let stage = stage.bypass_change_detection();
    let places = [(-2.2, -0.5), (1.0, 0.6), (-0.6, 0.6), (1.8, -0.7)].map(|(around, across)| {
        let (u, v) = (stage.spread * around, 1.1 + stage.spread * across);
        let out = 1.0 + 0.45 * v.cos();
        surface.closest_point(Vec3::new(out * u.sin(), 0.45 * v.sin(), out * u.cos()).as_dvec3())
    });
    let [Some(a), Some(b), Some(c), Some(d)] = places else { return };
    let polygon = [a, b, c, d].map(|place| place.point);
    stage.points = [a, b, c, d].map(|place| place.position.as_vec3()).to_vec();
    let legs = polygon.windows(2).flat_map(|ends| surface.shortest_path(&ends[0], &ends[1]));
    stage.legs = legs.flat_map(|leg| leg.positions(surface)).map(|p| p.as_vec3()).collect();
    for (entity, Shown(method), _) in &curves {
        let controls = SplineSource::control_points(stage.points.clone());
        let source = if method.is_b_spline() { controls } else { SplineSource::bezier(polygon) };
        commands.entity(entity).insert(source.scheme(Scheme::of(*method)));
    }
}

/// Draws what the plugin does not: the control polygon, and what a torus hides.
fn draw(
    (mut lines, mut behind): (Gizmos, Gizmos<Behind>),
    stage: Res<Stage>,
    curves: Query<(&SplineTrace, &OnSurface)>,
    places: Query<&GlobalTransform>,
) {
    for (trace, on) in &curves {
        let Ok(place) = places.get(on.0) else { continue };
        let world = |line: &[Vec3]| line.iter().map(|p| place.transform_point(*p)).collect::<Vec<_>>();
        lines.linestrip(world(&stage.legs), POLYGON);
        behind.linestrip(world(&stage.legs), POLYGON.with_alpha(0.3));
        trace.pieces().for_each(|piece| behind.linestrip(world(piece), CURVE.with_alpha(0.6)));
        world(&stage.points).iter().for_each(|at| drop(lines.sphere(*at, 0.03, Color::WHITE).resolution(8)));
    }
}

/// Shows slider and labels.
fn show_panel(
    mut contexts: EguiContexts,
    stage: ResMut<Stage>,
    curves: Query<(&Shown, &SplineTrace, &OnSurface)>,
    camera: Single<(&Camera, &GlobalTransform)>,
    places: Query<&GlobalTransform>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    let mut spread = stage.spread;
    egui::Area::new("spread".into()).anchor(egui::Align2::CENTER_BOTTOM, [0.0, -8.0]).show(ctx, |ui| {
        ui.spacing_mut().slider_width = 500.0;
        ui.add(egui::Slider::new(&mut spread, 0.1..=1.2).text("spread of the control points (or arrow keys)"));
    });
    let held = |key| f32::from(ctx.input(|input| input.key_down(key)));
    spread += 0.004 * (held(egui::Key::ArrowRight) - held(egui::Key::ArrowLeft));
    stage.map_unchanged(|stage| &mut stage.spread).set_if_neq(spread.clamp(0.1, 1.2));
    for (Shown(method), trace, on) in &curves {
        let corner = places.get(on.0)?.translation() + camera.1.rotation() * Vec3::new(-3.2, 1.1, 0.0);
        let at = camera.0.world_to_viewport(camera.1, corner)?;
        let points: usize = trace.segments().iter().map(|segment| segment.points().len()).sum();
        let torn: usize = trace.segments().iter().map(|segment| segment.jumps().len()).sum();
        let verdict = ["unbroken", "torn in one place", "torn in two places"].get(torn).unwrap_or(&"torn to pieces");
        let text = format!("{}\nlength {:.2}, {points} points\n{verdict}", method.name(), trace.length());
        let color = if torn > 0 { egui::Color32::from_rgb(255, 120, 100) } else { egui::Color32::WHITE };
        let painter = ctx.layer_painter(egui::LayerId::background());
        painter.text(egui::pos2(at.x, at.y), egui::Align2::LEFT_TOP, text, egui::FontId::proportional(14.0), color);
    }
    Ok(())
}

/// With `--picture`: takes it when all has settled, and ends.
fn take_picture(mut commands: Commands, traces: Query<&SplineTrace>, mut frames: Local<u32>) {
    *frames += u32::from(traces.iter().len() == Method::ALL.len());
    if let Some(file) = std::env::args().skip_while(|word| word != "--picture").nth(1).filter(|_| *frames == 30) {
        let end = |_: On<ScreenshotCaptured>, mut exits: MessageWriter<AppExit>| _ = exits.write(AppExit::Success);
        commands.spawn(Screenshot::primary_window()).observe(save_to_disk(file)).observe(end);
    }
}
