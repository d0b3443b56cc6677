//! B-splines have no handles to grab, and a control polygon to look at; torn curves are torn for all.

use std::time::Duration;

use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::PointerId;
use bevy::prelude::*;
use bevy_surface_splines::plugin::SplinePickingSettings;
use bevy_surface_splines::plugin::testing::{PointerScript, headless_app, pixel_of, update_until};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::shapes;

use super::{spawn_spline, spawn_surface, surface_of};

const POSITIONS: [Vec3; 5] = [
    Vec3::new(-0.6, 0.0, 0.8),
    Vec3::new(-0.3, 0.5, 0.8),
    Vec3::new(0.1, -0.4, 0.9),
    Vec3::new(0.4, 0.3, 0.9),
    Vec3::new(0.7, -0.1, 0.7),
];

struct Stage {
    app: App,
    camera: Entity,
    surface: Entity,
    spline: Entity,
}

impl Stage {
    fn new(mesh: impl Into<Mesh>, eye: Vec3, source: SplineSource) -> Self {
        let mut app = headless_app();
        let look = Transform::from_translation(eye).looking_at(Vec3::ZERO, Vec3::Y);
        let camera = app.world_mut().spawn((Camera3d::default(), look)).id();
        let surface = spawn_surface(&mut app, mesh);
        let spline = spawn_spline(&mut app, surface, source);
        app.world_mut().entity_mut(spline).insert(Editable);
        let mut stage = Self { app, camera, surface, spline };
        stage.update();
        stage
    }

    fn sphere(source: SplineSource) -> Self {
        Self::new(Sphere::new(1.0).mesh().uv(48, 24), 4.0 * Vec3::Z, source)
    }

    fn update(&mut self) {
        for _ in 0..3 {
            self.app.update();
        }
    }

    fn edit(&mut self, edit: SplineEdit) {
        self.app.world_mut().write_message(EditSpline::new(self.spline, edit));
        self.update();
    }

    fn spline(&self) -> &SurfaceSpline {
        self.app.world().get(self.spline).expect("a spline")
    }

    fn controls(&mut self) -> Vec<ControlKind> {
        let world = self.app.world_mut();
        world.query::<&ControlPoint>().iter(world).map(|control| control.kind).collect()
    }

    /// The ends of the control polygon's legs.
    fn legs(&self) -> Option<Vec<[Vec3; 2]>> {
        let polygon = self.app.world().get::<ControlPolygon>(self.spline)?;
        Some(polygon.legs().map(|leg| [leg[0], leg[leg.len() - 1]]).collect())
    }

    /// What joins the anchors.
    fn chords(&self) -> Vec<[Vec3; 2]> {
        let surface = surface_of(&self.app, self.surface);
        let anchors: Vec<Vec3> =
            self.spline().anchors().iter().map(|a| surface.position(&a.point()).as_vec3()).collect();
        let count = anchors.len() - usize::from(!self.spline().is_closed());
        (0..count).map(|i| [anchors[i], anchors[(i + 1) % anchors.len()]]).collect()
    }

    fn hovered(&mut self, at: Vec2) -> Vec<Entity> {
        let mut pointer = PointerScript::mouse(&mut self.app).expect("a window");
        pointer.move_to(&mut self.app, at);
        self.app.world().resource::<HoverMap>()[&PointerId::Mouse].keys().copied().collect()
    }

    fn pixel(&self, local: Vec3) -> Vec2 {
        pixel_of(self.app.world(), self.camera, local).expect("on screen")
    }
}

#[test]
fn handles_go_with_the_scheme_and_come_back() {
    let mut stage = Stage::sphere(SplineSource::smooth_through(POSITIONS));
    assert_eq!((stage.controls().len(), stage.legs()), (5 + 8, None));
    for scheme in [Scheme::b_spline(), Scheme::quadratic_b_spline()] {
        stage.edit(SplineEdit::SetScheme(scheme));
        let controls = stage.controls();
        assert!(controls.len() == 5 && controls.iter().all(|kind| matches!(kind, ControlKind::Anchor(_))));
        assert_eq!(ControlKind::Handle(1, HandleSide::Incoming).point(stage.spline()), None);
    }
    stage.edit(SplineEdit::SetScheme(Scheme::direct()));
    assert_eq!((stage.controls().len(), stage.legs()), (5 + 8, None));
}

#[test]
fn the_control_polygon_follows_the_anchors() {
    let mut stage = Stage::sphere(SplineSource::control_points(POSITIONS));
    assert_eq!(stage.legs(), Some(stage.chords()));
    assert_eq!(stage.chords().len(), 4);
    let to = surface_of(&stage.app, stage.surface).closest_point(glam::DVec3::new(0.1, 0.1, 1.0)).expect("a place");
    stage.edit(SplineEdit::MoveAnchor { anchor: 2, to: to.point });
    assert_eq!(stage.legs(), Some(stage.chords()));
    stage.edit(SplineEdit::Delete { anchor: 0 });
    assert_eq!(stage.legs(), Some(stage.chords()));
    // Legs are geodesics, not chords through the sphere.
    let polygon = stage.app.world().get::<ControlPolygon>(stage.spline).expect("a polygon");
    assert!(polygon.legs().flatten().all(|p| (p.length() - 1.0).abs() < 0.02));
    // What nobody edits shows none.
    stage.app.world_mut().entity_mut(stage.spline).remove::<Editable>();
    stage.update();
    assert_eq!((stage.controls().len(), stage.legs()), (0, None));
    stage.app.world_mut().entity_mut(stage.spline).insert(Editable);
    stage.update();
    assert_eq!(stage.legs(), Some(stage.chords()));
}

#[test]
fn on_large_surfaces_no_frame_searches_a_control_polygon() {
    let source = SplineSource::control_points(POSITIONS);
    let mut stage = Stage::new(Sphere::new(1.0).mesh().uv(128, 64), 4.0 * Vec3::Z, source);
    let long = Duration::from_secs(1000);
    stage.app.insert_resource(TraceBudget { per_frame: long, preview_after: long });
    let before = stage.legs();
    assert_eq!(before, Some(stage.chords()));
    let to = surface_of(&stage.app, stage.surface).closest_point(glam::DVec3::new(0.1, 0.1, 1.0)).expect("a place");
    let edit = SplineEdit::MoveAnchor { anchor: 2, to: to.point };
    stage.app.world_mut().write_message(EditSpline::new(stage.spline, edit));
    stage.app.update();
    assert_ne!(before, Some(stage.chords()));
    assert_eq!(stage.legs(), before);
    let (spline, ends) = (stage.spline, stage.chords());
    assert!(update_until(&mut stage.app, |world| {
        let polygon = world.get::<ControlPolygon>(spline).expect("a polygon");
        polygon.legs().map(|leg| [leg[0], leg[leg.len() - 1]]).eq(ends.iter().copied())
    }));
}

#[test]
fn no_handle_of_a_b_spline_is_grabbed() {
    let mut stage = Stage::sphere(SplineSource::smooth_through(POSITIONS));
    let (anchor, handle) = (ControlKind::Anchor(2), ControlKind::Handle(2, HandleSide::Outgoing));
    let surface = surface_of(&stage.app, stage.surface);
    let [anchor_at, handle_at] = [anchor, handle]
        .map(|kind| surface.position(&kind.point(stage.spline()).expect("a point")).as_vec3())
        .map(|position| stage.pixel(position));
    let held = |stage: &mut Stage, at: Vec2| {
        let mut pointer = PointerScript::mouse(&mut stage.app).expect("a window");
        pointer.move_to(&mut stage.app, at);
        pointer.press(&mut stage.app);
        let held = stage.app.world().resource::<DragState>().held().map(|grip| grip.kind);
        pointer.release(&mut stage.app);
        held
    };
    assert_eq!(held(&mut stage, handle_at), Some(handle));
    stage.edit(SplineEdit::SetScheme(Scheme::b_spline()));
    assert_eq!(held(&mut stage, handle_at), None);
    assert_eq!(held(&mut stage, anchor_at), Some(anchor));
}

#[test]
fn a_handle_that_no_longer_counts_falls_out_of_the_hand() {
    let mut stage = Stage::sphere(SplineSource::smooth_through(POSITIONS));
    let handle = ControlKind::Handle(2, HandleSide::Outgoing);
    let position = surface_of(&stage.app, stage.surface).position(&handle.point(stage.spline()).expect("a point"));
    let at = stage.pixel(position.as_vec3());
    let mut pointer = PointerScript::mouse(&mut stage.app).expect("a window");
    pointer.move_to(&mut stage.app, at);
    pointer.press(&mut stage.app);
    pointer.move_to(&mut stage.app, at + Vec2::new(20.0, 10.0));
    assert!(stage.app.world().resource::<DragState>().dragged().is_some());
    stage.edit(SplineEdit::SetScheme(Scheme::b_spline()));
    pointer.move_to(&mut stage.app, at + Vec2::new(40.0, 10.0));
    assert_eq!(*stage.app.world().resource::<DragState>(), DragState::Idle);
}

#[test]
fn control_points_make_a_b_spline() {
    let mut stage = Stage::sphere(SplineSource::control_points(POSITIONS));
    assert_eq!((stage.spline().scheme(), stage.spline().segment_count()), (Scheme::b_spline(), 2));
    let closed = SplineSource::control_points(POSITIONS).scheme(Scheme::quadratic_b_spline().adaptive()).closed();
    stage.app.world_mut().entity_mut(stage.spline).insert(closed);
    stage.update();
    assert_eq!((stage.spline().is_closed(), stage.spline().segment_count()), (true, 5));
    assert_eq!((stage.legs(), stage.chords().len()), (Some(stage.chords()), 5));
    // Three are enough for a quadratic one.
    let quadratic = SplineSource::control_points(POSITIONS[..3].to_vec()).scheme(Scheme::quadratic_b_spline());
    stage.app.world_mut().entity_mut(stage.spline).insert(quadratic);
    stage.update();
    assert_eq!(stage.spline().segment_count(), 1);
    // Through positions, and C²: the control points are found.
    let through = SplineSource::smooth_through(POSITIONS).scheme(Scheme::b_spline());
    stage.app.world_mut().entity_mut(stage.spline).insert(through);
    stage.update();
    assert_eq!((stage.spline().scheme(), stage.spline().segment_count()), (Scheme::b_spline(), POSITIONS.len() - 1));
    let trace = stage.app.world().get::<SplineTrace>(stage.spline).expect("a trace").clone();
    for p in POSITIONS {
        let surface = surface_of(&stage.app, stage.surface);
        let place = surface.closest_point(p.as_dvec3()).expect("a place").position;
        assert!(trace.nearest(surface, place).expect("a trace").distance < 2e-2, "{p}");
    }
    for (source, why) in [
        (SplineSource::control_points(POSITIONS[..3].to_vec()), "needs 4"),
        (SplineSource::control_points(POSITIONS[..2].to_vec()).closed(), "needs 3"),
        (SplineSource::control_points([]), "needs 4"),
        (SplineSource::control_points([Vec3::X, Vec3::NAN, Vec3::Y, Vec3::Z]), "finite"),
    ] {
        let surface = stage.surface;
        let failed = stage.app.world_mut().spawn((OnSurface(surface), source)).id();
        stage.update();
        let Some(SplineState::Failed { reason }) = stage.app.world().get(failed) else { panic!("not failed") };
        assert!(reason.contains(why), "{reason}");
    }
}

#[test]
fn the_path_across_a_jump_is_not_on_the_curve() {
    let torus = bevy_surface_splines::plugin::mesh_from(&shapes::torus(1.0, 0.45, 48, 24));
    // Wide enough for direct de Casteljau to break; the eye looks through the hole from above.
    let near = |u: f32, v: f32| {
        let (u, v) = (2.25 * u, 0.45 * v + 1.0);
        Vec3::new((1.0 + 0.45 * v.cos()) * u.sin(), 0.45 * v.sin(), (1.0 + 0.45 * v.cos()) * u.cos())
    };
    let mut stage = Stage::new(torus, Vec3::new(0.0, 5.0, 0.1), SplineSource::smooth_through([Vec3::X, Vec3::Z]));
    // Bridges may lie below the torus.
    stage.app.world_mut().resource_mut::<SplinePickingSettings>().see_through = true;
    let surface = surface_of(&stage.app, stage.surface);
    let polygon = [near(-1.0, -0.5), near(-0.45, 1.0), near(0.45, -1.0), near(1.0, 0.5)]
        .map(|p| surface.closest_point(p.as_dvec3()).expect("a place").point);
    let mut bridges = 0;
    for (method, torn) in Method::ALL.map(|method| (method, method.is_for_comparison())) {
        let source = SplineSource::bezier(polygon).scheme(Scheme::of(method));
        stage.app.world_mut().entity_mut(stage.spline).insert(source);
        stage.update();
        let trace = stage.app.world().get::<SplineTrace>(stage.spline).expect("a trace").clone();
        if method.is_b_spline() {
            assert_eq!(trace.segments().len(), 0, "two anchors are too few");
            continue;
        }
        let pieces: Vec<&[Vec3]> = trace.pieces().collect();
        assert_eq!(pieces.len() > 1, torn, "{method:?}");
        for pair in pieces.windows(2) {
            let (from, to) = (pair[0][pair[0].len() - 1], pair[1][0]);
            let bridge = trace.polyline().iter().skip_while(|p| **p != from).take_while(|p| **p != to);
            let bridge: Vec<Vec3> = bridge.copied().collect();
            let middle = bridge[bridge.len() / 2];
            let at = stage.pixel(middle);
            let clear = pieces.iter().flat_map(|piece| piece.iter()).all(|p| stage.pixel(*p).distance(at) > 14.0);
            if clear {
                bridges += 1;
                assert!(!stage.hovered(at).contains(&stage.spline), "{method:?}: nothing to grab at {middle}");
            }
        }
    }
    assert!(bridges > 0, "a bridge was looked at");
}
