//! What a pointer grabs: handles before anchors before curves before surfaces, and nothing through other things.

use bevy::picking::backend::{HitData, PointerHits};
use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::{Location, PointerAction, PointerId, PointerInput};
use bevy::picking::{PickingSystems, backend::ray::RayMap};
use bevy::prelude::*;
use bevy_surface_splines::plugin::testing::{
    PointerScript, headless_app, pixel_of, unfinished_headless_app, update_until,
};
use bevy_surface_splines::plugin::{BuiltSurface, CurveHit, SurfaceHit};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::{Surface, SurfaceOptions, shapes};

use super::{spawn_spline, spawn_surface, surface_of};

struct Stage {
    app: App,
    camera: Entity,
    surface: Entity,
    spline: Entity,
    pointer: PointerScript,
}

fn stage(mut app: App, place: Transform) -> Stage {
    let camera = app.world_mut().spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 4.0))).id();
    let surface = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(48, 24));
    app.world_mut().entity_mut(surface).insert(place);
    let source =
        SplineSource::smooth_through([Vec3::new(-0.5, 0.1, 0.8), Vec3::new(0.1, 0.4, 0.9), Vec3::new(0.5, -0.2, 0.8)]);
    let spline = spawn_spline(&mut app, surface, source);
    app.world_mut().entity_mut(spline).insert(Editable);
    for _ in 0..3 {
        app.update();
    }
    let pointer = PointerScript::mouse(&mut app).expect("a window");
    Stage { app, camera, surface, spline, pointer }
}

impl Stage {
    fn pixel(&self, local: Vec3) -> Vec2 {
        let place = self.app.world().get::<GlobalTransform>(self.surface).expect("a place");
        pixel_of(self.app.world(), self.camera, place.transform_point(local)).expect("on screen")
    }

    fn pixel_of(&self, kind: ControlKind) -> Vec2 {
        let spline = self.app.world().get::<SurfaceSpline>(self.spline).expect("a spline");
        let point = kind.point(spline).expect("a control point");
        self.pixel(surface_of(&self.app, self.surface).position(&point).as_vec3())
    }

    fn hovered(&mut self, at: Vec2) -> (Entity, HitData) {
        self.pointer.move_to(&mut self.app, at);
        let hits = &self.app.world().resource::<HoverMap>()[&PointerId::Mouse];
        assert_eq!(hits.len(), 1, "{hits:?}");
        hits.iter().next().map(|(e, hit)| (*e, hit.clone())).expect("one")
    }

    fn control(&self, entity: Entity) -> Option<ControlKind> {
        self.app.world().get::<ControlPoint>(entity).map(|c| c.kind)
    }
}

#[test]
fn the_order_of_what_is_grabbed() {
    let mut stage = stage(headless_app(), Transform::from_xyz(0.3, 0.1, 0.0).with_scale(Vec3::splat(1.2)));
    let anchor = stage.pixel_of(ControlKind::Anchor(1));
    let handle = stage.pixel_of(ControlKind::Handle(1, HandleSide::Outgoing));
    let (entity, _) = stage.hovered(handle + Vec2::new(-2.0, 3.0));
    assert_eq!(stage.control(entity), Some(ControlKind::Handle(1, HandleSide::Outgoing)));
    let (entity, _) = stage.hovered(anchor + Vec2::new(2.0, 1.0));
    assert_eq!(stage.control(entity), Some(ControlKind::Anchor(1)));
    // On the curve between two anchors.
    let trace = stage.app.world().get::<SplineTrace>(stage.spline).expect("a trace").clone();
    let on = trace.point_at(surface_of(&stage.app, stage.surface), SplineT(0.5)).expect("a point");
    let at = stage.pixel(surface_of(&stage.app, stage.surface).position(&on).as_vec3());
    let (entity, hit) = stage.hovered(at + Vec2::new(0.5, 0.5));
    assert_eq!(entity, stage.spline);
    let t = hit.extra_as::<CurveHit>().expect("a curve hit").t;
    assert!((t.0 - 0.5).abs() < 0.02, "{t:?}");
    // Beside everything.
    let beside = stage.pixel(Vec3::new(0.0, -0.6, 0.8));
    let (entity, hit) = stage.hovered(beside);
    assert_eq!(entity, stage.surface);
    assert!(hit.extra_as::<SurfaceHit>().is_some());
}

#[test]
fn a_handle_on_its_anchor_is_grabbed_before_it() {
    let mut stage = stage(headless_app(), Transform::default());
    let surface = surface_of(&stage.app, stage.surface);
    let spline = stage.app.world().get::<SurfaceSpline>(stage.spline).expect("a spline");
    let near = surface.position(&spline.anchors()[2].point());
    let to = surface.closest_point(near + 0.02).expect("a place").point;
    let edit = SplineEdit::MoveHandle { anchor: 2, side: HandleSide::Incoming, to };
    stage.app.world_mut().write_message(EditSpline::new(stage.spline, edit));
    stage.app.update();
    stage.app.update();
    let at = stage.pixel_of(ControlKind::Anchor(2));
    let (entity, _) = stage.hovered(at);
    assert_eq!(stage.control(entity), Some(ControlKind::Handle(2, HandleSide::Incoming)));
    stage.pointer.press(&mut stage.app);
    let held = stage.app.world().resource::<DragState>().held().map(|grip| grip.kind);
    assert_eq!(held, Some(ControlKind::Handle(2, HandleSide::Incoming)));
}

#[test]
fn a_press_that_stays_in_the_dead_zone_changes_nothing() {
    let mut stage = stage(headless_app(), Transform::default());
    let before = stage.app.world().get::<SurfaceSpline>(stage.spline).cloned();
    let at = stage.pixel_of(ControlKind::Anchor(1));
    stage.pointer.move_to(&mut stage.app, at);
    stage.pointer.press(&mut stage.app);
    stage.pointer.move_to(&mut stage.app, at + Vec2::new(3.0, 2.0));
    assert!(matches!(stage.app.world().resource::<DragState>(), DragState::Pressed(_)));
    stage.pointer.release(&mut stage.app);
    assert_eq!(stage.app.world().get::<SurfaceSpline>(stage.spline).cloned(), before);
    assert_eq!(*stage.app.world().resource::<DragState>(), DragState::Idle);
}

#[test]
fn a_cancelled_pointer_restores() {
    let mut stage = stage(headless_app(), Transform::default());
    let before = stage.app.world().get::<SurfaceSpline>(stage.spline).cloned();
    let at = stage.pixel_of(ControlKind::Anchor(1));
    stage.pointer.move_to(&mut stage.app, at);
    stage.pointer.press(&mut stage.app);
    stage.pointer.move_to(&mut stage.app, at + Vec2::new(30.0, 20.0));
    assert_ne!(stage.app.world().get::<SurfaceSpline>(stage.spline).cloned(), before);
    stage.pointer.cancel(&mut stage.app);
    assert_eq!(stage.app.world().get::<SurfaceSpline>(stage.spline).cloned(), before);
}

#[test]
fn a_whole_drag_within_one_frame_works() {
    let mut stage = stage(headless_app(), Transform::default());
    let at = stage.pixel_of(ControlKind::Anchor(1));
    stage.pointer.move_to(&mut stage.app, at);
    let window = stage.app.world_mut().query_filtered::<Entity, With<Window>>().single(stage.app.world()).expect("one");
    let target =
        bevy::camera::RenderTarget::Window(bevy::window::WindowRef::Primary).normalize(Some(window)).expect("one");
    let mut send = |position: Vec2, action| {
        let location = Location { target: target.clone(), position };
        stage.app.world_mut().write_message(PointerInput::new(PointerId::Mouse, location, action));
    };
    send(at, PointerAction::Press(PointerButton::Primary));
    for i in 1..=5u16 {
        send(at + f32::from(i) * Vec2::new(10.0, -6.0), PointerAction::Move { delta: Vec2::new(10.0, -6.0) });
    }
    send(at + Vec2::new(50.0, -30.0), PointerAction::Release(PointerButton::Primary));
    stage.app.update();
    assert!(stage.pixel_of(ControlKind::Anchor(1)).distance(at + Vec2::new(50.0, -30.0)) < 0.5);
    assert_eq!(*stage.app.world().resource::<DragState>(), DragState::Idle);
}

#[test]
fn a_panel_in_front_keeps_the_press() {
    #[derive(Component)]
    struct Panel;
    let mut app = unfinished_headless_app();
    app.add_plugins(SurfaceSplinePlugins).add_systems(
        PreUpdate,
        (|rays: Res<RayMap>, panels: Query<Entity, With<Panel>>, mut out: MessageWriter<PointerHits>| {
            for (id, _) in rays.iter() {
                let picks = panels.iter().map(|panel| (panel, HitData::new(id.camera, 0.0, None, None))).collect();
                out.write(PointerHits::new(id.pointer, picks, 0.6));
            }
        })
        .in_set(PickingSystems::Backend),
    );
    app.finish();
    app.cleanup();
    let mut stage = stage(app, Transform::default());
    let panel = stage.app.world_mut().spawn(Panel).id();
    let at = stage.pixel_of(ControlKind::Anchor(1));
    assert_eq!(stage.hovered(at).0, panel);
    stage.pointer.press(&mut stage.app);
    assert_eq!(*stage.app.world().resource::<DragState>(), DragState::Idle);
    stage.pointer.release(&mut stage.app);
    stage.app.world_mut().despawn(panel);
    stage.app.update();
    stage.pointer.press(&mut stage.app);
    assert!(stage.app.world().resource::<DragState>().held().is_some());
}

#[test]
fn a_spline_that_goes_during_a_drag_ends_it() {
    let mut stage = stage(headless_app(), Transform::default());
    let at = stage.pixel_of(ControlKind::Anchor(1));
    stage.pointer.move_to(&mut stage.app, at);
    stage.pointer.press(&mut stage.app);
    stage.pointer.move_to(&mut stage.app, at + Vec2::new(30.0, 0.0));
    stage.app.world_mut().despawn(stage.surface);
    stage.pointer.move_to(&mut stage.app, at + Vec2::new(60.0, 0.0));
    stage.pointer.release(&mut stage.app);
    assert_eq!(*stage.app.world().resource::<DragState>(), DragState::Idle);
}

#[test]
fn a_surface_given_by_hand_behaves_like_a_built_one() {
    #[derive(Resource, Default)]
    struct Ready(u32);
    let mut app = headless_app();
    app.init_resource::<Ready>().add_observer(|_: On<SurfaceReady>, mut ready: ResMut<Ready>| ready.0 += 1);
    let surface = Surface::build(&shapes::icosphere(3), &SurfaceOptions::default()).expect("a surface");
    let planet = app.world_mut().spawn(BuiltSurface(surface.into())).id();
    let source = SplineSource::smooth_through([Vec3::X, Vec3::Y, Vec3::Z]);
    let spline = app.world_mut().spawn((OnSurface(planet), source)).id();
    assert!(update_until(&mut app, |world| world.get::<SplineTrace>(spline).is_some()));
    assert_eq!(app.world().resource::<Ready>().0, 1);
}
