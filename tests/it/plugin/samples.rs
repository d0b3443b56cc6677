//! The programs that users should be able to write, for 60 frames each. A system that returns an error panics here.

use bevy::diagnostic::DiagnosticsStore;
use bevy::prelude::*;
use bevy_surface_splines::plugin::SplineDiagnosticsPlugin;
use bevy_surface_splines::plugin::testing::{headless_app, update_until};
use bevy_surface_splines::prelude::*;

use super::{app_with_camera, spawn_spline, spawn_surface};

#[derive(Resource, Default)]
struct Seen(Vec<&'static str>);

/// Runs 60 frames, and more until nothing is pending.
fn run(app: &mut App) {
    for _ in 0..60 {
        app.update();
    }
    assert!(update_until(app, |world| {
        let ready = world.query::<&SurfaceState>().iter(world).all(|s| *s == SurfaceState::Ready);
        ready && world.query::<&SplineState>().iter(world).all(|s| *s != SplineState::Pending)
    }));
}

#[test]
fn a_curve_on_a_model() {
    fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
        let planet = commands.spawn((Mesh3d(meshes.add(Sphere::new(1.0))), SplineSurface::default())).id();
        commands.spawn((OnSurface(planet), SplineSource::smooth_through([Vec3::X, Vec3::Y, Vec3::Z]).closed()));
    }
    let mut app = headless_app();
    app.init_resource::<Seen>()
        .add_systems(Startup, setup)
        .add_observer(|_: On<SurfaceReady>, mut seen: ResMut<Seen>| seen.0.push("ready"))
        .add_observer(|_: On<SurfaceFailed>, mut seen: ResMut<Seen>| seen.0.push("failed"))
        .add_observer(|changed: On<TraceChanged>, mut seen: ResMut<Seen>| {
            assert_eq!(changed.retraced, 3);
            seen.0.push("traced");
        });
    run(&mut app);
    assert_eq!(app.world().resource::<Seen>().0, ["ready", "traced"]);
    let world = app.world_mut();
    let (state, trace) = world.query::<(&SplineState, &SplineTrace)>().single(world).expect("one spline");
    assert_eq!(*state, SplineState::Ready);
    assert!(trace.polyline().iter().all(|p| (p.length() - 1.0).abs() < 0.02));
    assert!((trace.length() - 1.5 * std::f64::consts::PI).abs() < 1.0, "{}", trace.length());
    let measured = |path| world.resource::<DiagnosticsStore>().get(&path).and_then(|d| d.value());
    assert_eq!(measured(SplineDiagnosticsPlugin::SEGMENTS_RETRACED), Some(3.0));
    assert!(measured(SplineDiagnosticsPlugin::TRACE_TIME).is_some_and(|ms| ms > 0.0));
}

#[test]
fn ask_the_surface() {
    #[derive(Component)]
    struct Planet;
    fn shoot(surfaces: SurfaceQueries, planet: Single<Entity, With<Planet>>, mut seen: ResMut<Seen>) -> Result {
        let Some(surface) = surfaces.get(*planet) else { return Ok(()) };
        let Some(hit) = surface.ray(Ray3d::new(Vec3::Z * 5.0, Dir3::NEG_Z)) else { return Ok(()) };
        let Some(goal) = surface.closest_point(Vec3::X) else { return Ok(()) };
        let path = surface.shortest_path(hit.point, goal.point)?;
        let there = surface.walk(hit.point, Vec3::Y, 2.5)?;
        assert!(path.length() > 1.0 && there.stopped.is_none());
        seen.0.push("asked");
        Ok(())
    }
    let mut app = headless_app();
    app.init_resource::<Seen>().add_systems(Update, shoot);
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(Sphere::new(1.0));
    app.world_mut().spawn((Planet, Mesh3d(mesh), SplineSurface::default()));
    run(&mut app);
    assert!(!app.world().resource::<Seen>().0.is_empty());
}

#[test]
fn change_it_from_game_code() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    app.init_resource::<Seen>()
        .add_observer(|_: On<TraceChanged>, mut seen: ResMut<Seen>| seen.0.push("traced"))
        .add_observer(|refused: On<SplineEditRefused>, mut seen: ResMut<Seen>| {
            assert!(refused.reason.to_string().contains("no anchor 99"), "{}", refused.reason);
            seen.0.push("refused");
        });
    let planet = spawn_surface(&mut app, Sphere::new(1.0));
    let spline = spawn_spline(&mut app, planet, SplineSource::smooth_through([Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X]));
    let to = super::surface_of(&app, planet).closest_point(Vec3::ONE.as_dvec3()).expect("a place").point;
    app.add_systems(Update, move |mut edits: MessageWriter<EditSpline>, mut frame: Local<u32>| {
        *frame += 1;
        match *frame {
            5 => drop(edits.write(EditSpline::new(spline, SplineEdit::MoveAnchor { anchor: 2, to }))),
            10 => drop(edits.write(EditSpline::new(spline, SplineEdit::Delete { anchor: 1 }).undoable())),
            15 => drop(edits.write(EditSpline::new(spline, SplineEdit::Delete { anchor: 99 }))),
            _ => {}
        }
    });
    app.world_mut().entity_mut(spline).insert(Editable);
    run(&mut app);
    assert_eq!(app.world().resource::<Seen>().0, ["traced", "traced", "traced", "refused"]);
    let anchors = app.world().get::<SurfaceSpline>(spline).expect("a spline").anchors().len();
    assert_eq!(anchors, 3);
    let world = app.world_mut();
    assert_eq!(world.query::<&ControlPoint>().iter(world).count(), 3 + 4);
    world.entity_mut(spline).remove::<Editable>();
    app.update();
    let world = app.world_mut();
    assert_eq!(world.query::<&ControlPoint>().iter(world).count(), 0);
}

#[test]
fn sources_that_make_no_spline_say_why() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    let planet = spawn_surface(&mut app, Cuboid::new(1.0, 1.0, 1.0));
    for (positions, why) in [
        (vec![], "two distinct"),
        (vec![Vec3::X], "two distinct"),
        (vec![Vec3::X, Vec3::X, Vec3::X], "two distinct"),
        (vec![Vec3::X, Vec3::NAN], "finite"),
        (vec![Vec3::X, Vec3::INFINITY, Vec3::Y], "finite"),
        (vec![Vec3::ONE, 2.0 * Vec3::ONE], "two distinct"),
    ] {
        let spline = app.world_mut().spawn((OnSurface(planet), SplineSource::smooth_through(positions))).id();
        run(&mut app);
        let Some(SplineState::Failed { reason }) = app.world().get(spline) else { panic!("not failed") };
        assert!(reason.contains(why), "{reason}");
        // A better source heals it.
        app.world_mut().entity_mut(spline).insert(SplineSource::smooth_through([Vec3::X, Vec3::Y]));
        app.update();
        assert_eq!(app.world().get(spline), Some(&SplineState::Ready));
    }
}

#[test]
fn splines_follow_a_changed_surface_and_go_with_it() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    let planet = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(32, 18));
    let source = SplineSource::smooth_through([Vec3::X, Vec3::Y, Vec3::Z]).closed();
    let spline = spawn_spline(&mut app, planet, source);
    app.world_mut().entity_mut(spline).insert(Editable);
    let before = app.world().get::<SplineTrace>(spline).expect("a trace").clone();
    let mesh = app.world().get::<Mesh3d>(planet).expect("a mesh").0.clone();
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&mesh).expect("loaded") =
        Sphere::new(1.5).mesh().uv(48, 24);
    assert!(update_until(&mut app, |world| {
        let trace = world.get::<SplineTrace>(spline);
        trace.is_some_and(|trace| (trace.length() / before.length() - 1.5).abs() < 0.1)
    }));
    let spline_now = app.world().get::<SurfaceSpline>(spline).expect("a spline");
    assert!(spline_now.is_closed() && spline_now.anchors().len() == 3);
    app.world_mut().despawn(planet);
    app.update();
    assert!(app.world().get_entity(spline).is_err());
    let world = app.world_mut();
    assert_eq!(world.query::<&ControlPoint>().iter(world).count(), 0);
}

#[test]
fn a_spline_of_another_surface_says_so() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    let fine = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(64, 36));
    let coarse = spawn_surface(&mut app, Cuboid::new(1.0, 1.0, 1.0));
    let spline = spawn_spline(&mut app, fine, SplineSource::smooth_through([Vec3::X, Vec3::Y, Vec3::Z]));
    app.world_mut().entity_mut(spline).insert((OnSurface(coarse), Editable));
    run(&mut app);
    let Some(SplineState::Failed { reason }) = app.world().get(spline) else { panic!("not failed") };
    assert!(reason.contains("does not exist"), "{reason}");
    assert!(app.world().get::<SplineTrace>(spline).is_none());
    app.world_mut().entity_mut(spline).insert(OnSurface(fine));
    run(&mut app);
    assert_eq!(app.world().get(spline), Some(&SplineState::Ready));
    let world = app.world_mut();
    assert_eq!(world.query::<&ControlPoint>().iter(world).count(), 3 + 4);
}
