//! Surfaces: building, sharing, changing, failing, asking, picking.

use std::sync::Arc;

use bevy::asset::RenderAssetUsages;
use bevy::ecs::system::RunSystemOnce;
use bevy::mesh::PrimitiveTopology;
use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::PointerId;
use bevy::prelude::*;
use bevy_surface_splines::plugin::testing::{PointerScript, pixel_of, unfinished_headless_app, update_until};
use bevy_surface_splines::plugin::{self, SurfaceHit, SurfaceQueryError};
use bevy_surface_splines::prelude::*;

use super::{app_with_camera, spawn_surface, surface_of};

#[derive(Resource, Default)]
struct Log(Vec<String>);

fn log_events(app: &mut App) {
    app.init_resource::<Log>()
        .add_observer(|event: On<SurfaceReady>, mut log: ResMut<Log>| log.0.push(format!("ready {}", event.entity)))
        .add_observer(|event: On<SurfaceFailed>, mut log: ResMut<Log>| log.0.push(format!("failed {}", event.reason)))
        .add_observer(|event: On<SurfaceChanged>, mut log: ResMut<Log>| {
            log.0.push(format!("changed {}", event.entity))
        });
}

fn take_log(app: &mut App) -> Vec<String> {
    std::mem::take(&mut app.world_mut().resource_mut::<Log>().0)
}

#[test]
fn one_mesh_is_built_once_and_freed_with_its_last_user() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    log_events(&mut app);
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(Sphere::new(1.0).mesh().uv(32, 18));
    let spawn = |app: &mut App| app.world_mut().spawn((Mesh3d(mesh.clone()), SplineSurface::default())).id();
    let (a, b) = (spawn(&mut app), spawn(&mut app));
    assert!(update_until(&mut app, |world| world.get::<BuiltSurface>(b).is_some()));
    for _ in 0..5 {
        app.update();
    }
    assert_eq!(take_log(&mut app), [format!("ready {a}"), format!("ready {b}")]);
    let shared = app.world().get::<BuiltSurface>(a).unwrap().0.clone();
    assert!(Arc::ptr_eq(&shared, &app.world().get::<BuiltSurface>(b).unwrap().0));
    let weak = Arc::downgrade(&shared);
    drop(shared);
    app.world_mut().despawn(a);
    app.update();
    assert!(weak.strong_count() > 0);
    app.world_mut().despawn(b);
    app.update();
    assert_eq!(weak.strong_count(), 0);
}

#[test]
fn a_mesh_that_cannot_be_read_fails_with_the_remedy() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    log_events(&mut app);
    let lines = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::default());
    let mut gone = Mesh::from(Sphere::new(1.0));
    gone.asset_usage = RenderAssetUsages::RENDER_WORLD;
    gone.take_gpu_data().unwrap();
    let mut reasons = Vec::new();
    for mesh in [lines, gone] {
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
        let surface = app.world_mut().spawn((Mesh3d(mesh), SplineSurface::default())).id();
        let item = app.world_mut().spawn((OnSurface(surface), SplineSource::smooth_through([Vec3::X, Vec3::Y]))).id();
        for _ in 0..60 {
            app.update();
        }
        let Some(SurfaceState::Failed { reason }) = app.world().get(surface) else { panic!("not failed") };
        assert!(matches!(app.world().get(item), Some(SplineState::Failed { .. })));
        reasons.push(reason.clone());
    }
    assert!(reasons[0].contains("TriangleList") && reasons[1].contains("RenderAssetUsages"), "{reasons:?}");
    assert_eq!(take_log(&mut app).len(), 2, "each fails once");
}

#[test]
fn a_missing_mesh_stays_pending() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    let surface = app.world_mut().spawn((Mesh3d(Handle::default()), SplineSurface::default())).id();
    let bare = app.world_mut().spawn(SplineSurface::default()).id();
    for _ in 0..10 {
        app.update();
    }
    for entity in [surface, bare] {
        assert_eq!(app.world().get(entity), Some(&SurfaceState::Pending { progress: 0.0 }));
    }
}

#[test]
fn a_modified_mesh_is_built_anew() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    log_events(&mut app);
    let surface = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(32, 18));
    app.update();
    take_log(&mut app);
    let mesh = app.world().get::<Mesh3d>(surface).unwrap().0.clone();
    app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap().scale_by(Vec3::splat(2.0));
    let before = app.world().get::<BuiltSurface>(surface).unwrap().0.clone();
    assert!(update_until(&mut app, |world| { !Arc::ptr_eq(&world.get::<BuiltSurface>(surface).unwrap().0, &before) }));
    app.update();
    assert_eq!(take_log(&mut app), [format!("changed {surface}")]);
    assert!((surface_of(&app, surface).diagonal() / before.diagonal() - 2.0).abs() < 1e-6);
    assert_eq!(app.world().get(surface), Some(&SurfaceState::Ready));
    // Other normals are no other surface.
    app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap().compute_area_weighted_normals();
    let before = app.world().get::<BuiltSurface>(surface).unwrap().0.clone();
    for _ in 0..60 {
        app.update();
        assert_eq!(app.world().get(surface), Some(&SurfaceState::Ready));
    }
    assert!(Arc::ptr_eq(&app.world().get::<BuiltSurface>(surface).unwrap().0, &before));
    assert!(take_log(&mut app).is_empty());
}

#[test]
fn queries_speak_world_space() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    let surface = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(64, 36));
    let turn = Quat::from_rotation_y(0.7);
    let place = Transform::from_xyz(3.0, 0.0, 0.0).with_rotation(turn).with_scale(Vec3::splat(2.0));
    app.world_mut().entity_mut(surface).insert(place);
    app.update();
    let ask = move |surfaces: SurfaceQueries| {
        let view = surfaces.get(surface).expect("ready");
        let hit = view.ray(Ray3d::new(Vec3::new(3.0, 0.1, 10.0), Dir3::NEG_Z)).expect("a hit");
        assert!((hit.distance - 8.0).abs() < 0.02 && hit.normal.z > 0.98, "{hit:?}");
        assert!(hit.position.distance(Vec3::new(3.0, 0.1, 2.0)) < 0.02, "{hit:?}");
        let near = view.closest_point(Vec3::new(3.0, 9.0, 0.0)).expect("a place");
        assert!((near.distance - 7.0).abs() < 0.02, "{near:?}");
        let path = view.shortest_path(hit.point, near.point).expect("a path");
        assert!((path.length() - std::f64::consts::FRAC_PI_2).abs() < 0.06, "local units: {}", path.length());
        let there = view.walk(hit.point, Vec3::X, 1.0).expect("a walk");
        assert!((there.direction.length() - 1.0).abs() < 1e-5 && there.position.x > 4.5, "{there:?}");
        assert!(view.position(there.point).distance(there.position) < 1e-6);
    };
    app.world_mut().run_system_once(ask).expect("ran");
}

#[test]
fn a_non_uniform_scale_is_refused_with_the_remedy() {
    let (mut app, _) = app_with_camera(Vec3::Z * 5.0);
    let surface = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(16, 9));
    app.world_mut().entity_mut(surface).insert(Transform::from_scale(Vec3::new(1.0, 2.0, 1.0)));
    app.update();
    let ask = move |surfaces: SurfaceQueries| {
        assert!(surfaces.get(surface).is_none());
        let error = surfaces.try_get(surface).map(|_| ()).unwrap_err();
        assert_eq!(error, SurfaceQueryError::NonUniformScale(surface));
        assert!(error.to_string().contains("scaled_by"));
        assert_eq!(
            surfaces.try_get(Entity::PLACEHOLDER).unwrap_err(),
            SurfaceQueryError::NotReady(Entity::PLACEHOLDER)
        );
    };
    app.world_mut().run_system_once(ask).expect("ran");
}

#[test]
fn hits_carry_face_and_weights() {
    let (mut app, camera) = app_with_camera(Vec3::Z * 5.0);
    let surface = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(32, 18));
    let place = Transform::from_xyz(0.5, 0.0, 0.0).with_scale(Vec3::splat(0.5));
    app.world_mut().entity_mut(surface).insert(place);
    app.update();
    let aim = Vec3::new(0.6, 0.1, 0.47);
    let pixel = pixel_of(app.world(), camera, aim).expect("on screen");
    let mut pointer = PointerScript::mouse(&mut app).expect("a window");
    pointer.move_to(&mut app, pixel);
    let hit = app.world().resource::<HoverMap>()[&PointerId::Mouse][&surface].clone();
    let extra = hit.extra_as::<SurfaceHit>().expect("extra data");
    let local = surface_of(&app, surface).position(&extra.point).as_vec3();
    assert!(place.transform_point(local).distance(hit.position.unwrap()) < 1e-5);
    assert!(hit.position.unwrap().distance(aim) < 0.02, "{hit:?}");
    pointer.move_to(&mut app, Vec2::splat(3.0));
    assert!(!app.world().resource::<HoverMap>()[&PointerId::Mouse].contains_key(&surface));
}

#[test]
fn every_plugin_can_be_added_alone() {
    fn alone<P: Plugin + Default>(_: P) {
        let mut bare = App::new();
        bare.add_plugins(MinimalPlugins);
        for mut app in [bare, unfinished_headless_app()] {
            app.add_plugins(P::default());
            app.finish();
            app.cleanup();
            for _ in 0..3 {
                app.update();
            }
        }
    }
    alone(plugin::SurfacePlugin);
    alone(plugin::SplinePlugin);
    alone(plugin::EditPlugin);
    alone(plugin::RetracePlugin);
    alone(plugin::ControlsPlugin);
    alone(plugin::PolygonPlugin);
    alone(plugin::PickPlugin);
    alone(plugin::DragPlugin);
    alone(plugin::SplineDiagnosticsPlugin);
    alone(plugin::DebugDrawPlugin);
    // And all of them where there is nothing but time and tasks.
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SurfaceSplinePlugins));
    app.finish();
    app.cleanup();
    for _ in 0..3 {
        app.update();
    }
}
