//! Lines made by code and by hand: from places, around faces, drawn with the pointer; found under it, and turned into splines.

use std::collections::HashSet;

use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::PointerId;
use bevy::prelude::*;
use bevy_surface_splines::curve::{FitOptions, TraceWorkspace};
use bevy_surface_splines::plugin::testing::{PointerScript, headless_app, pixel_of, update_until};
use bevy_surface_splines::plugin::{LineHit, Picker, SplinePickingSettings};
use bevy_surface_splines::prelude::*;
use glam::DVec3;

use super::{app_with_camera, spawn_surface, surface_of};

/// What was said of lines.
#[derive(Resource, Default)]
struct Heard {
    drawn: Vec<Entity>,
    failed: Vec<(Entity, String)>,
}

fn listen(app: &mut App) {
    app.init_resource::<Heard>()
        .add_observer(|drawn: On<LineDrawn>, mut heard: ResMut<Heard>| heard.drawn.push(drawn.entity))
        .add_observer(|failed: On<LineFailed>, mut heard: ResMut<Heard>| {
            heard.failed.push((failed.entity, failed.reason.clone()));
        });
}

/// An app with a camera at (0, 0, 4) and a sphere at the origin.
fn stage() -> (App, Entity, Entity) {
    let (mut app, camera) = app_with_camera(Vec3::Z * 4.0);
    listen(&mut app);
    let surface = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(96, 48));
    for _ in 0..3 {
        app.update();
    }
    (app, camera, surface)
}

fn zigzag() -> impl Iterator<Item = Vec3> {
    (0..31_u8).map(|k| Vec3::new(f32::from(k) / 20.0 - 0.75, if k % 2 == 0 { 0.05 } else { -0.05 }, 0.7))
}

fn smoothed(app: &App, line: Entity) -> &SmoothedLine {
    app.world().get(line).expect("a smoothed line")
}

/// The lines under a pixel.
fn lines_under(app: &mut App, camera: Entity, pixel: Vec2) -> Vec<(Entity, LineHit)> {
    app.world_mut()
        .run_system_cached_with(
            |In((camera, pixel)): In<(Entity, Vec2)>, picker: Picker| picker.lines_under(camera, pixel),
            (camera, pixel),
        )
        .expect("it runs")
}

#[test]
fn a_source_becomes_a_line_when_its_surface_is_ready() {
    let mut app = headless_app();
    listen(&mut app);
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(Sphere::new(1.0).mesh().uv(96, 48));
    let planet = app.world_mut().spawn((Mesh3d(mesh), SplineSurface::default())).id();
    let source = LineSource::through(zigzag());
    let line = app.world_mut().spawn((OnSurface(planet), source.clone(), LineSmoothing::default())).id();
    let closed = app.world_mut().spawn((OnSurface(planet), source.closed())).id();
    let bad = app.world_mut().spawn((OnSurface(planet), LineSource::through([Vec3::X, Vec3::NAN]))).id();
    let short = app.world_mut().spawn((OnSurface(planet), LineSource::through([Vec3::X]))).id();
    app.update();
    assert_eq!(app.world().get(line), Some(&LineState::Pending));
    assert!(update_until(&mut app, |world| world.get(closed) == Some(&LineState::Ready)));
    assert!(app.world().get::<LineSource>(line).is_none());
    assert!(smoothed(&app, line).by().is_some() && !smoothed(&app, line).line.is_closed());
    assert!(smoothed(&app, closed).by().is_none() && smoothed(&app, closed).line.is_closed());
    for (entity, word) in [(bad, "position 1"), (short, "two points")] {
        let Some(LineState::Failed { reason }) = app.world().get(entity) else { panic!("it cannot be made") };
        assert!(reason.contains(word), "{reason}");
    }
    assert_eq!(app.world().resource::<Heard>().failed.len(), 2);
    // Who asks anew is answered.
    app.world_mut().entity_mut(bad).insert(LineSource::through([Vec3::X, Vec3::Y]));
    app.update();
    assert_eq!(app.world().get(bad), Some(&LineState::Ready));
}

#[test]
fn lines_run_around_faces() {
    let (mut app, _, planet) = stage();
    let surface = surface_of(&app, planet);
    let centre = |face: u32| surface.corners(FaceId(face)).map(|corners| (corners[0] + corners[1] + corners[2]) / 3.0);
    let faces: Vec<FaceId> = (0..surface.face_count() as u32).map(FaceId).collect();
    // A ring about an axis that no row of faces follows: two jagged boundaries, the one at its equator is the longer.
    let up = DVec3::new(0.5, 0.3, 0.8).normalize();
    let height = |f: &FaceId| centre(f.0).map_or(-1.0, |c| c.dot(up));
    let ring: Vec<FaceId> = faces.iter().copied().filter(|f| (0.0..0.8).contains(&height(f))).collect();
    let chosen: HashSet<FaceId> = ring.iter().copied().collect();
    app.world_mut().commands().spawn_lines_around(planet, ring.clone(), (LineSmoothing::tether(10.0), Editable));
    app.world_mut().commands().spawn_lines_around(planet, [FaceId(1_000_000)], ());
    app.world_mut().commands().spawn_lines_around(planet, [], ());
    let first = app.world_mut().spawn((OnSurface(planet), LineSource::around_faces(ring))).id();
    app.update();
    let world = app.world_mut();
    let mut found = world.query_filtered::<(Entity, &SurfaceLine, &SmoothedLine), With<Editable>>();
    let lines: Vec<_> = found.iter(world).map(|(e, line, s)| (e, line.line().clone(), s.clone())).collect();
    assert_eq!(lines.len(), 2);
    let surface = surface_of(&app, planet);
    let of_source = app.world().get::<SurfaceLine>(first).expect("a line").line();
    assert_eq!(of_source, &lines[0].1, "the longest");
    let lengths: Vec<f64> = lines.iter().map(|(_, line, _)| line.length(surface)).collect();
    assert!(lengths[0] > lengths[1], "{lengths:?}");
    for (_, line, smoothed) in &lines {
        assert!(line.is_closed());
        // It runs along sides between a face that was chosen and one that was not: in chosen ones.
        assert!(line.crossings().iter().all(|crossing| chosen.contains(&crossing.face)));
        assert!(smoothed.after.square_curvature < 0.5 * smoothed.before.square_curvature, "{:?}", smoothed.after);
    }
    let failed = &app.world().resource::<Heard>().failed;
    assert!(failed.len() == 2 && failed.iter().all(|(entity, _)| *entity == planet), "{failed:?}");
    assert!(failed[0].1.contains("1000000") && failed[1].1.contains("at least three"), "{failed:?}");
}

#[test]
fn a_line_becomes_a_spline() {
    let (mut app, _, planet) = stage();
    for closed in [false, true] {
        let source = LineSource::through(zigzag());
        let source = if closed { source.closed() } else { source };
        let line = app.world_mut().spawn((OnSurface(planet), source, LineSmoothing::tether(10.0))).id();
        app.update();
        let before = smoothed(&app, line).clone();
        let surface = surface_of(&app, planet);
        let fit = before.fit(surface, &mut TraceWorkspace::default(), &FitOptions::within(0.01)).expect("a spline");
        assert!(fit.max_distance <= 0.01);
        app.world_mut().commands().turn_into_spline(line, FitOptions::within(0.01));
        app.update();
        let entity = app.world().entity(line);
        let spline = entity.get::<SurfaceSpline>().expect("a spline");
        assert!(**spline == fit.spline && spline.is_closed() == closed);
        assert!(!entity.contains::<SurfaceLine>() && !entity.contains::<SmoothedLine>());
        assert_eq!(entity.get::<SplineState>(), Some(&SplineState::Ready));
        // Its trace is near the line.
        let trace = entity.get::<SplineTrace>().expect("a trace");
        let surface = surface_of(&app, planet);
        for place in before.polyline() {
            let near = trace.nearest(surface, place.as_dvec3()).expect("a place");
            let distance = surface.position(&near.point).distance(place.as_dvec3());
            assert!(distance < 0.0101, "{distance}");
        }
        // What is no line says so.
        app.world_mut().commands().turn_into_spline(line, FitOptions::default());
        app.update();
        assert!(
            app.world_mut()
                .resource_mut::<Heard>()
                .failed
                .pop()
                .is_some_and(|(e, why)| e == line && why.contains("no line"))
        );
    }
}

#[test]
fn lines_are_found_under_a_pixel() {
    let (mut app, camera, planet) = stage();
    app.world_mut().entity_mut(planet).insert(Transform::from_xyz(0.2, -0.1, 0.3).with_scale(Vec3::splat(1.1)));
    let source = LineSource::through(zigzag());
    let line = app.world_mut().spawn((OnSurface(planet), source.clone(), LineSmoothing::tether(10.0))).id();
    let behind = source.clone();
    let plain = app.world_mut().spawn((OnSurface(planet), behind)).id();
    for _ in 0..3 {
        app.update();
    }
    let place = *app.world().get::<GlobalTransform>(planet).expect("a place");
    let built = app.world().get::<BuiltSurface>(planet).expect("a surface").clone();
    let at = smoothed(&app, line).at_distance(&built, 0.4).expect("a place");
    let pixel = |app: &App, local: DVec3| {
        pixel_of(app.world(), camera, place.transform_point(local.as_vec3())).expect("on screen")
    };
    let on_line = pixel(&app, built.position(&at.point));
    assert!(lines_under(&mut app, camera, on_line).is_empty(), "only what can be picked");
    app.world_mut().entity_mut(line).insert(Pickable::default());
    let hits = lines_under(&mut app, camera, on_line + Vec2::new(2.0, 3.0));
    assert_eq!(hits.len(), 1);
    assert_eq!(hits[0].0, line);
    assert!((hits[0].1.distance - 0.4).abs() < 0.02, "{}", hits[0].1.distance);
    assert!(built.position(&hits[0].1.point).distance(built.position(&at.point)) < 0.02);
    app.world_mut().entity_mut(plain).insert(Editable);
    assert_eq!(lines_under(&mut app, camera, on_line).len(), 2);
    app.world_mut().despawn(plain);
    // Not from farther than the radius.
    let radius = app.world().resource::<SplinePickingSettings>().grab_radius;
    assert!(lines_under(&mut app, camera, on_line + Vec2::Y * (radius + 6.0)).is_empty());
    // The back end says the same, before the surface.
    let mut pointer = PointerScript::mouse(&mut app).expect("a window");
    pointer.move_to(&mut app, on_line);
    let hovered = &app.world().resource::<HoverMap>()[&PointerId::Mouse];
    let (entity, hit) = hovered.iter().next().expect("something");
    assert_eq!((*entity, hovered.len()), (line, 1));
    assert_eq!(
        hit.extra_as::<LineHit>().map(|hit| hit.point),
        lines_under(&mut app, camera, on_line).first().map(|(_, hit)| hit.point)
    );
    // What is behind the sphere is hidden, unless it is looked through.
    app.world_mut().entity_mut(camera).insert(Transform::from_xyz(0.0, 0.0, -4.0).looking_at(Vec3::ZERO, Vec3::Y));
    app.update();
    app.update();
    let from_behind = pixel_of(app.world(), camera, place.transform_point(built.position(&at.point).as_vec3()));
    let from_behind = from_behind.expect("on screen");
    assert!(lines_under(&mut app, camera, from_behind).is_empty());
    app.world_mut().resource_mut::<SplinePickingSettings>().see_through = true;
    assert_eq!(lines_under(&mut app, camera, from_behind).len(), 1);
}

#[test]
fn the_pointer_draws_lines() {
    let (mut app, camera, planet) = stage();
    app.world_mut().entity_mut(planet).insert(LinePen::default());
    let mut pointer = PointerScript::mouse(&mut app).expect("a window");
    let pixel = |app: &App, x: f32, y: f32| {
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        pixel_of(app.world(), camera, Vec3::new(x, y, z)).expect("on screen")
    };
    let lines = |app: &mut App| {
        let world = app.world_mut();
        world
            .query::<(Entity, &SurfaceLine)>()
            .iter(world)
            .map(|(e, line)| (e, line.line().clone()))
            .collect::<Vec<_>>()
    };
    // An open one, with a tremor.
    let start = pixel(&app, -0.6, 0.0);
    pointer.move_to(&mut app, start);
    pointer.press(&mut app);
    for k in 1..=40_u8 {
        let tremor = if k % 2 == 0 { 0.03 } else { -0.03 };
        let to = pixel(&app, -0.6 + 0.03 * f32::from(k), tremor);
        pointer.move_to(&mut app, to);
        if k == 20 {
            let drawn = lines(&mut app);
            assert_eq!(drawn.len(), 1, "it is there while it is drawn");
            assert!(app.world().get::<LineSmoothing>(drawn[0].0).is_none());
        }
    }
    pointer.release(&mut app);
    app.update();
    let drawn = lines(&mut app);
    assert_eq!(app.world().resource::<Heard>().drawn, [drawn[0].0]);
    let (entity, line) = &drawn[0];
    assert!(!line.is_closed() && line.crossings().len() > 15, "{}", line.crossings().len());
    let ends = line.ends().map(|end| surface_of(&app, planet).position(&end));
    assert!((ends[0].x + 0.6).abs() < 0.02 && (ends[1].x - 0.6).abs() < 0.02, "{ends:?}");
    let smooth = smoothed(&app, *entity);
    assert!(smooth.by().is_some() && smooth.after.total_turn < 0.3 * smooth.before.total_turn, "{:?}", smooth.after);
    app.world_mut().despawn(*entity);
    // One that comes back to its start is closed.
    let at = |app: &App, k: u8| {
        let a = std::f32::consts::TAU * f32::from(k) / 36.0;
        pixel(app, 0.5 * a.cos(), 0.5 * a.sin())
    };
    let start = at(&app, 0);
    pointer.move_to(&mut app, start);
    pointer.press(&mut app);
    for k in 1..=36 {
        let to = at(&app, k);
        pointer.move_to(&mut app, to);
    }
    pointer.release(&mut app);
    app.update();
    let drawn = lines(&mut app);
    assert!(drawn.len() == 1 && drawn[0].1.is_closed());
    app.world_mut().despawn(drawn[0].0);
    // One that is cancelled is gone, and one whose surface goes.
    for step in 0..2 {
        pointer.move_to(&mut app, start);
        pointer.press(&mut app);
        for k in 1..=9 {
            let to = at(&app, k);
            pointer.move_to(&mut app, to);
        }
        assert_eq!(lines(&mut app).len(), 1);
        if step == 0 {
            pointer.cancel(&mut app);
        } else {
            app.world_mut().despawn(planet);
            pointer.release(&mut app);
        }
        app.update();
        assert!(lines(&mut app).is_empty(), "step {step}");
    }
}
