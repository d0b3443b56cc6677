//! Drawings in a headless app: loaded, placed, moved, replaced, refused.

use std::path::PathBuf;
use std::sync::Arc;

use bevy::prelude::*;
use bevy_surface_splines::plugin::testing::{headless_app, update_until};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::vector::import_svg;

use super::{spawn_surface, surface_of};

const TWO_CIRCLES: &str = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="-10 -10 20 20">
    <circle r="10"/><circle cx="2" cy="-3" r="4" fill="red"/></svg>"#;

fn asset(text: &str) -> SvgDrawing {
    let import = import_svg(text.as_bytes()).unwrap();
    SvgDrawing { drawing: Arc::new(import.drawing), report: import.report }
}

/// A place on the unit sphere, and a drawing there whose unit is a hundredth.
fn placed_at(app: &App, planet: Entity, towards: Vec3) -> Placement {
    let at = surface_of(app, planet).closest_point(towards.as_dvec3()).expect("a place").point;
    Placement { at, up: Vec3::Y, scale: 0.01 }
}

fn state(app: &App, drawing: Entity) -> DrawingState {
    app.world().get::<DrawingState>(drawing).expect("a drawing").clone()
}

fn splines(app: &App, drawing: Entity) -> Vec<Entity> {
    app.world().get::<DrawingSplines>(drawing).map(|splines| splines.iter().collect()).unwrap_or_default()
}

fn is_ready(world: &mut World, drawing: Entity) -> bool {
    matches!(world.get::<DrawingState>(drawing), Some(DrawingState::Ready { .. }))
}

/// The mean of the anchors of a spline.
fn middle(app: &App, planet: Entity, spline: Entity) -> Vec3 {
    let anchors = app.world().get::<SurfaceSpline>(spline).expect("a spline").anchors();
    let sum: Vec3 = anchors.iter().map(|a| surface_of(app, planet).position(&a.point()).as_vec3()).sum();
    sum / anchors.len() as f32
}

#[test]
fn a_drawing_on_a_surface() {
    // The asset server reads from a folder of the test's own.
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("a_drawing_on_a_surface");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("tattoo.svg"), TWO_CIRCLES).unwrap();
    std::fs::write(folder.join("broken.svg"), "<svg").unwrap();
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        AssetPlugin { file_path: folder.to_string_lossy().into_owned(), ..default() },
        ImagePlugin::default(),
        bevy::mesh::MeshPlugin,
        SurfaceSplinePlugins,
    ));
    app.finish();
    app.cleanup();
    let planet = spawn_surface(&mut app, Sphere::new(1.0));
    let placement = placed_at(&app, planet, Vec3::Z);
    let load = |app: &App, name: &'static str| app.world().resource::<AssetServer>().load(name);
    let drawing = load(&app, "tattoo.svg");
    let broken = load(&app, "broken.svg");
    let missing = load(&app, "missing.svg");
    let drawing = app.world_mut().spawn((OnSurface(planet), Drawing(drawing), placement)).id();
    let refused =
        [broken, missing].map(|handle| app.world_mut().spawn((OnSurface(planet), Drawing(handle), placement)).id());
    assert_eq!(state(&app, drawing), DrawingState::Pending);
    assert!(update_until(&mut app, |world| is_ready(world, drawing)));
    assert_eq!(splines(&app, drawing).len(), 2);
    for refused in refused {
        assert!(update_until(&mut app, |world| {
            matches!(world.get(refused), Some(DrawingState::Failed { reason }) if reason.contains("file"))
        }));
    }
    // Its splines are traced like all others.
    let ring = splines(&app, drawing)[0];
    assert!(update_until(&mut app, |world| world.get::<SplineTrace>(ring).is_some()));
    let trace = app.world().get::<SplineTrace>(ring).expect("a trace");
    assert!((trace.length() - std::f64::consts::TAU * 0.1_f64.sin()).abs() < 0.02, "{}", trace.length());
    assert_eq!(app.world().get::<DrawnPath>(ring), Some(&DrawnPath { shape: 0, path: 0 }));
    // The smaller circle lies up and to the right.
    let small = middle(&app, planet, splines(&app, drawing)[1]);
    assert!((small - Vec3::new(0.02, 0.03, 1.0)).length() < 0.01, "{small}");
}

#[test]
fn drawings_follow_their_placement_file_and_surface() {
    let mut app = headless_app();
    let planet = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(32, 18));
    let handle = app.world_mut().resource_mut::<Assets<SvgDrawing>>().add(asset(TWO_CIRCLES));
    let placement = placed_at(&app, planet, Vec3::Z);
    let drawing = app.world_mut().spawn((OnSurface(planet), Drawing(handle.clone()), placement)).id();
    assert!(update_until(&mut app, |world| is_ready(world, drawing)));
    let first = splines(&app, drawing);

    // Moved: the same entities elsewhere, in the same frame.
    let moved = placed_at(&app, planet, Vec3::X);
    app.world_mut().entity_mut(drawing).insert(moved);
    app.update();
    assert_eq!(splines(&app, drawing), first);
    assert!((middle(&app, planet, first[0]) - Vec3::X).length() < 0.05);

    // Another file: one path less.
    *app.world_mut().resource_mut::<Assets<SvgDrawing>>().get_mut(&handle).expect("there") =
        asset(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="-10 -10 20 20"><rect width="5" height="5"/></svg>"#);
    assert!(update_until(&mut app, |world| world
        .get::<DrawingSplines>(drawing)
        .is_some_and(|s| s.iter().count() == 1)));
    assert_eq!(splines(&app, drawing), first[..1]);
    assert!(app.world().get_entity(first[1]).is_err());

    // A larger planet: the drawing is on it.
    let mesh = app.world().get::<Mesh3d>(planet).expect("a mesh").0.clone();
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&mesh).expect("there") = Sphere::new(1.5).mesh().uv(48, 24);
    assert!(update_until(&mut app, |world| {
        let spline = world.get::<SurfaceSpline>(first[0]).expect("a spline").anchors()[0].point();
        world.get::<BuiltSurface>(planet).is_some_and(|s| s.position(&spline).length() > 1.4)
    }));
    assert!(update_until(&mut app, |world| is_ready(world, drawing)));
    let at = app.world().get::<Placement>(drawing).expect("a placement").at;
    assert!((surface_of(&app, planet).position(&at).as_vec3() - 1.5 * Vec3::X).length() < 0.05);

    // Nonsense is refused, and mended.
    app.world_mut().entity_mut(drawing).insert(Placement { at, up: Vec3::Y, scale: 0.0 });
    app.update();
    assert!(matches!(state(&app, drawing), DrawingState::Failed { reason } if reason.contains("scale")));
    app.update();
    assert!(splines(&app, drawing).is_empty());
    app.world_mut().entity_mut(drawing).insert(Placement { at, up: Vec3::Y, scale: 0.02 });
    app.update();
    assert!(is_ready(app.world_mut(), drawing));
    app.world_mut().entity_mut(drawing).remove::<Placement>().insert(Drawing(handle));
    app.update();
    assert!(matches!(state(&app, drawing), DrawingState::Failed { reason } if reason.contains("Placement")));
    app.world_mut().entity_mut(drawing).insert(Placement { at, up: Vec3::Y, scale: 0.02 });
    app.update();

    // All goes with the drawing, or with the planet.
    let left = splines(&app, drawing);
    assert_eq!(left.len(), 1);
    app.world_mut().entity_mut(drawing).remove::<Drawing>();
    app.update();
    assert!(app.world().get_entity(left[0]).is_err());
    app.world_mut().despawn(planet);
    app.update();
    assert!(app.world().get_entity(drawing).is_err());
}

#[test]
fn large_drawings_are_placed_in_the_background() {
    let mut app = headless_app();
    let planet = spawn_surface(&mut app, Sphere::new(1.0).mesh().ico(60).expect("few enough"));
    let circles: String = (0..400).map(|i| format!("<circle cx='{}' cy='{}' r='0.4'/>", i % 20, i / 20)).collect();
    let text = format!("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 20 20'>{circles}</svg>");
    let handle = app.world_mut().resource_mut::<Assets<SvgDrawing>>().add(asset(&text));
    let placement = placed_at(&app, planet, Vec3::Z);
    let drawing = app.world_mut().spawn((OnSurface(planet), Drawing(handle), placement)).id();
    app.update();
    assert_eq!(state(&app, drawing), DrawingState::Placing);
    // A newer place while it is under way: the newest counts.
    let newest = placed_at(&app, planet, Vec3::X);
    app.world_mut().entity_mut(drawing).insert(newest);
    assert!(update_until(&mut app, |world| is_ready(world, drawing)));
    let all = splines(&app, drawing);
    assert_eq!(all.len(), 400);
    let mean: Vec3 = all.iter().map(|spline| middle(&app, planet, *spline)).sum::<Vec3>() / 400.0;
    assert!((mean - Vec3::X).length() < 0.05, "{mean}");
}
