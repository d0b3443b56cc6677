//! Characters on surfaces.

use bevy::camera::primitives::Aabb;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_surface_splines::placement;
use bevy_surface_splines::plugin::testing::{headless_app, update_until};
use bevy_surface_splines::plugin::{BezierPaths, LaidState, mesh_from};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::{Surface, shapes};
use bevy_surface_splines::vector::{Picture, PictureOptions};
use glam::{DVec2, DVec3};

use super::characters;
use super::{spawn_surface, surface_of};

fn positions(app: &App, entity: Entity) -> Vec<Vec3> {
    let handle = &app.world().get::<Mesh3d>(entity).expect("a mesh").0;
    let mesh = app.world().resource::<Assets<Mesh>>().get(handle).expect("an asset");
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        panic!("no positions")
    };
    positions.iter().copied().map(Vec3::from_array).collect()
}

fn triangles(app: &App, entity: Entity) -> usize {
    let handle = &app.world().get::<Mesh3d>(entity).expect("a mesh").0;
    let mesh = app.world().resource::<Assets<Mesh>>().get(handle).expect("an asset");
    mesh.indices().expect("indices").len() / 3
}

/// Whether all vertices are where polar coordinates say, and as far above the surface as they should be.
fn check(app: &App, entity: Entity, surface: &Surface) {
    let placement: placement::Placement = (*app.world().get::<Placement>(entity).expect("a place")).into();
    let on: Vec<Vec3> = positions(app, entity);
    let lift = 1e-3 * surface.diagonal();
    for place in on.iter().step_by(7) {
        let near = surface.closest_point(place.as_dvec3()).expect("a place");
        let far = surface.position(&near.point).distance(place.as_dvec3());
        assert!((far - lift).abs() < 0.06 * lift, "{place} is {far} away, and should be {lift}");
    }
    let _ = placement;
}

#[test]
fn a_character_walks_on_a_sphere() {
    let (mut app, _) = characters::app();
    let sphere = spawn_surface(&mut app, mesh_from(&shapes::icosphere(5)));
    let at = surface_of(&app, sphere).closest_point(DVec3::X).expect("a place").point;
    let place = Placement { at, up: Vec3::Z, scale: 0.004 };
    let doll = characters::spawn(&mut app, (OnSurface(sphere), place));
    let laid = |world: &mut World| matches!(world.get::<LaidState>(doll), Some(LaidState::Ready { .. }));
    assert!(update_until(&mut app, laid));
    assert_eq!(app.world().get::<LaidState>(doll), Some(&LaidState::Ready { off: 0, clipped: 0 }));
    check(&app, doll, surface_of(&app, sphere));
    let before = positions(&app, doll);
    // A great circle comes back to where it began.
    let surface = app.world().get::<BuiltSurface>(sphere).expect("a surface").clone();
    let steps = 60;
    for step in 0..steps {
        let mut place = app.world_mut().get_mut::<Placement>(doll).expect("a place");
        let walked = place.walk(&surface, -0.5 * std::f64::consts::PI, std::f64::consts::TAU / f64::from(steps));
        assert_eq!(walked, Ok(None));
        app.update();
        if step % 20 == 0 {
            check(&app, doll, &surface);
            let aabb = app.world().get::<Aabb>(doll).expect("bounds");
            let all = positions(&app, doll);
            let low = all.iter().copied().reduce(Vec3::min).expect("vertices");
            assert!(Vec3::from(aabb.min()).distance(low) < 1e-4);
        }
    }
    let after = positions(&app, doll);
    let far = before.iter().zip(&after).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(far < 0.05, "once around is where it was, up to the facets: {far}");
    // Half a turn on the spot.
    let mut place = app.world_mut().get_mut::<Placement>(doll).expect("a place");
    place.turn(&surface, std::f64::consts::PI).expect("it turns");
    let up = place.up;
    assert!(up.normalize().z < -0.99, "{up}");
    app.update();
    check(&app, doll, &surface);
    // It follows its surface about.
    app.world_mut().get_mut::<Transform>(sphere).expect("a place").translation = Vec3::new(1.0, 2.0, 3.0);
    app.update();
    // In the same frame, also where something else carries it.
    let there = |app: &App| app.world().get::<GlobalTransform>(doll).expect("a place").translation();
    assert_eq!(there(&app), Vec3::new(1.0, 2.0, 3.0));
    let carrier = app.world_mut().spawn((Transform::from_xyz(50.0, 0.0, 0.0), Visibility::default())).id();
    app.world_mut().entity_mut(doll).insert(ChildOf(carrier));
    for _ in 0..3 {
        app.update();
        assert_eq!(there(&app), Vec3::new(1.0, 2.0, 3.0));
    }
    app.world_mut().entity_mut(doll).remove::<ChildOf>();
    assert!(place_is_kept(&mut app, doll, sphere));
}

/// Whether the picture despawns with its surface.
fn place_is_kept(app: &mut App, doll: Entity, surface: Entity) -> bool {
    app.world_mut().entity_mut(surface).despawn();
    app.update();
    app.world().get_entity(doll).is_err()
}

fn square(half: f64) -> Picture {
    let mut pen = bevy_surface_splines::vector::PathBuilder::default();
    pen.move_to(DVec2::new(-half, -half));
    for (x, y) in [(half, -half), (half, half), (-half, half)] {
        pen.line_to(DVec2::new(x, y));
    }
    pen.close();
    let paths = pen.finish();
    let style = bevy_surface_splines::vector::Style {
        fill: Some(bevy_surface_splines::vector::Paint::Color(bevy_surface_splines::vector::Color::BLACK)),
        opacity: 1.0,
        ..default()
    };
    let options = PictureOptions { spacing: Some(0.1 * half as f32), ..default() };
    Picture::planar([(&paths[..], &style)], &[], &options)
}

#[test]
fn what_leaves_a_surface_is_cut_and_said_so() {
    let mut app = headless_app();
    let sheet = spawn_surface(&mut app, mesh_from(&shapes::grid(20, 20, 2.0, 2.0)));
    let surface = surface_of(&app, sheet);
    let (low, high) = surface.bounds();
    let at = |x: f64| surface.closest_point(DVec3::new(low.x + x * (high.x - low.x), 0.5 * (low.y + high.y), 0.0));
    let places = [0.5, 0.9].map(|x| at(x).expect("a place").point);
    let make = |app: &mut App, at, scale| {
        let place = Placement { at, up: Vec3::Y, scale };
        let entity = app.world_mut().spawn((BezierPaths::new(square(1.0)), OnSurface(sheet), place)).id();
        app.update();
        app.update();
        entity
    };
    let whole = make(&mut app, places[0], 0.5);
    assert_eq!(app.world().get::<LaidState>(whole), Some(&LaidState::Ready { off: 0, clipped: 0 }));
    let full = triangles(&app, whole);
    let area = |app: &App, entity| {
        let all = positions(app, entity);
        let (l, h) = all.iter().fold((Vec3::MAX, Vec3::MIN), |(l, h), p| (l.min(*p), h.max(*p)));
        (h - l).truncate()
    };
    assert!(area(&app, whole).distance(Vec2::ONE) < 1e-4, "on a flat sheet it is flat");
    let cut = make(&mut app, places[1], 0.5);
    let Some(LaidState::Ready { off, clipped: 1 }) = app.world().get::<LaidState>(cut).cloned() else {
        panic!("{:?}", app.world().get::<LaidState>(cut))
    };
    assert!(off > 0 && triangles(&app, cut) < full);
    assert!(positions(&app, cut).iter().all(|p| f64::from(p.x) < high_x(&app, sheet) + 1e-4), "nothing sticks out");
    // A placement that makes no sense says so, and one that does is laid again.
    app.world_mut().get_mut::<Placement>(cut).expect("a place").up = Vec3::Z;
    app.update();
    assert!(
        matches!(app.world().get::<LaidState>(cut), Some(LaidState::Failed { reason }) if reason.contains("upright"))
    );
    app.world_mut().get_mut::<Placement>(cut).expect("a place").up = Vec3::X;
    app.update();
    assert!(matches!(app.world().get::<LaidState>(cut), Some(LaidState::Ready { .. })));
    // Taken off the surface, it is what was drawn.
    app.world_mut().entity_mut(cut).remove::<Placement>();
    app.update();
    assert_eq!(app.world().get::<LaidState>(cut), None);
    assert!(area(&app, cut).distance(Vec2::splat(2.0)) < 1e-5 && triangles(&app, cut) == full);
    assert!(positions(&app, cut).iter().all(|p| p.z == 0.0));
}

fn high_x(app: &App, sheet: Entity) -> f64 {
    surface_of(app, sheet).bounds().1.x
}
