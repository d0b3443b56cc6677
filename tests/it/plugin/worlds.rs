//! Worlds with surfaces and splines: saved, loaded, cloned.

use std::sync::Arc;

use bevy::camera::visibility::VisibilityClass;
use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use bevy::world_serialization::serde::WorldDeserializer;
use bevy::world_serialization::{DynamicWorld, DynamicWorldBuilder};
use bevy_surface_splines::plugin::Controls;
use bevy_surface_splines::plugin::testing::{headless_app, update_until};
use bevy_surface_splines::prelude::*;
use serde::de::DeserializeSeed;

use super::{app_with_camera, spawn_spline, spawn_surface};

/// Everything that a world with surfaces and splines is made of; meshes are assets, and not saved with it.
pub(super) fn saved(app: &App, entities: impl IntoIterator<Item = Entity>) -> String {
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let world: DynamicWorld = DynamicWorldBuilder::from_world(app.world(), &registry)
        .allow_all_components()
        .deny_component::<Mesh3d>()
        .deny_component::<VisibilityClass>() // Bevy cannot serialise it
        .extract_entities(entities.into_iter())
        .build();
    world.serialize(&registry).expect("serialises")
}

#[test]
fn a_world_survives_saving_and_loading() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    let planet = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(32, 18));
    let spline = spawn_spline(&mut app, planet, SplineSource::smooth_through([Vec3::X, Vec3::Y, Vec3::Z]).closed());
    app.world_mut().entity_mut(spline).insert(Editable);
    app.world_mut().spawn((OnSurface(planet), SplineSource::smooth_through([Vec3::NAN])));
    let zigzag = (0..20_u8).map(|k| Vec3::new(f32::from(k) / 10.0 - 1.0, f32::from(k % 2) / 10.0, 1.0));
    let line = (OnSurface(planet), LineSource::through(zigzag), LineSmoothing::tether(7.0));
    let line = app.world_mut().spawn(line).id();
    for _ in 0..3 {
        app.update();
    }
    let world = app.world_mut();
    let everything: Vec<Entity> = world
        .query_filtered::<Entity, Or<(With<SplineSurface>, With<OnSurface>, With<ControlPoint>)>>()
        .iter(world)
        .collect();
    assert_eq!(everything.len(), 4 + 9);
    for with_controls in [true, false] {
        let is_control = |e: &Entity| app.world().get::<ControlPoint>(*e).is_some();
        let entities: Vec<Entity> = everything.iter().copied().filter(|e| with_controls || !is_control(e)).collect();
        let text = saved(&app, entities);
        let mut other = headless_app();
        other.world_mut().spawn_empty(); // so that entities cannot keep their numbers
        let mut map = EntityHashMap::default();
        let loaded = {
            let registry = other.world().resource::<AppTypeRegistry>().clone();
            let registry = registry.read();
            let mut server = other.world().resource::<AssetServer>().clone();
            let mut ron = ron::de::Deserializer::from_str(&text).expect("RON");
            WorldDeserializer { type_registry: &registry, load_from_path: &mut server }
                .deserialize(&mut ron)
                .expect("deserialises")
        };
        loaded.write_to_world(other.world_mut(), &mut map).expect("spawns");
        let mesh = other.world_mut().resource_mut::<Assets<Mesh>>().add(Sphere::new(1.0).mesh().uv(32, 18));
        let (planet2, spline2) = (map[&planet], map[&spline]);
        other.world_mut().entity_mut(planet2).insert(Mesh3d(mesh));
        assert_eq!(other.world().get::<OnSurface>(spline2), Some(&OnSurface(planet2)));
        assert!(update_until(&mut other, |world| world.get::<SplineTrace>(spline2).is_some()));
        other.update();
        other.update();
        let (a, b) = (app.world().get::<SurfaceSpline>(spline), other.world().get::<SurfaceSpline>(spline2));
        assert_eq!(a, b, "the spline is the same, bit for bit");
        let segments = |app: &App, e| app.world().get::<SplineTrace>(e).map(|t| t.segments().to_vec());
        assert_eq!(segments(&app, spline), segments(&other, spline2));
        let parts = |app: &App, e: Entity| {
            let entity = app.world().entity(e);
            let parts = (entity.get::<SurfaceLine>().cloned(), entity.get::<LineSmoothing>().copied());
            (parts, entity.get::<SmoothedLine>().expect("a smoothed line").line.clone())
        };
        assert_eq!(parts(&app, line), parts(&other, map[&line]), "the line is the same, bit for bit");
        let world = other.world_mut();
        let controls: Vec<_> = world.query::<&ControlPoint>().iter(world).copied().collect();
        assert_eq!(controls.len(), 9);
        assert!(controls.iter().all(|c| c.spline == spline2));
        world.despawn(planet2);
        assert!(world.get_entity(spline2).is_err());
        assert_eq!(world.query::<&ControlPoint>().iter(world).count(), 0);
    }
}

#[test]
fn clones_are_complete_and_independent() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    let planet = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(32, 18));
    let spline = spawn_spline(&mut app, planet, SplineSource::smooth_through([Vec3::X, Vec3::Y, Vec3::Z]).closed());
    app.world_mut().entity_mut(spline).insert(Editable);
    app.update();
    // The spline alone: a second one on the same planet.
    let second = app.world_mut().entity_mut(spline).clone_and_spawn();
    app.update();
    app.update();
    assert_eq!(app.world().get::<OnSurface>(second), Some(&OnSurface(planet)));
    assert_eq!(app.world().get::<SurfaceSpline>(second), app.world().get::<SurfaceSpline>(spline));
    assert_eq!(controls_of(&mut app, second), 9);
    let to = super::surface_of(&app, planet).closest_point(Vec3::ONE.as_dvec3()).expect("a place").point;
    let before = app.world().get::<SurfaceSpline>(spline).cloned();
    app.world_mut().write_message(EditSpline::new(second, SplineEdit::MoveAnchor { anchor: 0, to }));
    app.update();
    assert_eq!(app.world().get::<SurfaceSpline>(spline), before.as_ref());
    assert_ne!(app.world().get::<SurfaceSpline>(second), before.as_ref());
    // The planet with all that lies on it.
    let planet2 = app.world_mut().entity_mut(planet).clone_and_spawn_with_opt_out(|builder| {
        builder.linked_cloning(true);
    });
    for _ in 0..3 {
        app.update();
    }
    let built = |e| app.world().get::<BuiltSurface>(e).expect("a surface").0.clone();
    assert!(Arc::ptr_eq(&built(planet), &built(planet2)), "the surface is shared");
    let items: Vec<Entity> = app.world().get::<SurfaceItems>(planet2).expect("items").iter().collect();
    assert_eq!(items.len(), 2);
    for item in items {
        assert_eq!(app.world().get::<OnSurface>(item), Some(&OnSurface(planet2)));
        assert_eq!(app.world().get::<SplineState>(item), Some(&SplineState::Ready));
        assert_eq!(controls_of(&mut app, item), 9);
        assert_eq!(app.world().get::<Controls>(item).expect("controls").iter().count(), 9);
    }
    app.world_mut().despawn(planet);
    app.update();
    assert!(app.world().get_entity(planet2).is_ok() && app.world().get_entity(second).is_err());
}

fn controls_of(app: &mut App, spline: Entity) -> usize {
    let world = app.world_mut();
    world.query::<&ControlPoint>().iter(world).filter(|c| c.spline == spline).count()
}
