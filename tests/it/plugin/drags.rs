//! Twenty seeded drags: after every frame the trace is what tracing from scratch gives, bit for bit, and only the
//! segments that were touched were traced.

use std::sync::Arc;

use bevy::prelude::*;
use bevy_surface_splines::curve::{SegmentTrace, Spline, Trace, TraceWorkspace};
use bevy_surface_splines::geodesic::GeodesicPath;
use bevy_surface_splines::plugin::testing::{PointerScript, pixel_of};
use bevy_surface_splines::plugin::{GestureEnded, SplineEdited};
use bevy_surface_splines::prelude::*;

use super::{Random, app_with_camera, spawn_spline, spawn_surface, surface_of};

/// Half the window.
const CENTRE: Vec2 = Vec2::new(640.0, 360.0);
/// The unit sphere's radius on the screen, seen from a distance of 4 (a little less).
const RADIUS: f32 = 215.0;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Course {
    Anchor,
    SmoothHandle,
    CornerHandle,
    Seam,
    OffTheModel,
    Escape,
}

const COURSES: [Course; 6] =
    [Course::Anchor, Course::SmoothHandle, Course::CornerHandle, Course::Seam, Course::OffTheModel, Course::Escape];

struct Stage {
    app: App,
    camera: Entity,
    surface: Entity,
    spline: Entity,
}

impl Stage {
    /// A UV sphere and a spline of five anchors on the side that the camera sees; the texture seam runs through the middle.
    fn new(random: &mut Random, join: Join, closed: bool) -> Self {
        let (mut app, camera) = app_with_camera(Vec3::X * 4.0);
        let surface = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(32, 18));
        let positions: Vec<Vec3> = (0..5u16)
            .map(|i| {
                let angle = f32::from(i) / 5.0 * std::f32::consts::TAU + 0.3 * random.signed();
                let radius = 0.45 + 0.15 * random.signed();
                Vec3::new(1.0, radius * angle.cos(), radius * angle.sin()).normalize()
            })
            .collect();
        let source = SplineSource::smooth_through(positions);
        let source = if closed { source.closed() } else { source };
        let spline = spawn_spline(&mut app, surface, source);
        for anchor in 0..5 {
            app.world_mut().write_message(EditSpline::new(spline, SplineEdit::SetJoin { anchor, join }));
        }
        app.world_mut().entity_mut(spline).insert(Editable);
        for _ in 0..3 {
            app.update();
        }
        Self { app, camera, surface, spline }
    }

    fn spline(&self) -> Spline {
        (**self.app.world().get::<SurfaceSpline>(self.spline).expect("a spline")).clone()
    }

    fn trace(&self) -> Arc<Trace> {
        self.app.world().get::<SplineTrace>(self.spline).expect("a trace").trace().clone()
    }

    fn pixel_of(&self, kind: ControlKind) -> Vec2 {
        let point = kind.point(&self.spline()).expect("a control point");
        let position = surface_of(&self.app, self.surface).position(&point).as_vec3();
        pixel_of(self.app.world(), self.camera, position).expect("on screen")
    }

    /// Compares the trace with one from scratch, and with the one before.
    fn check(&self, before: &(Spline, Arc<Trace>)) {
        let (spline, trace) = (self.spline(), self.trace());
        let surface = surface_of(&self.app, self.surface);
        let scratch = spline.trace(surface, &mut TraceWorkspace::default(), None).expect("a trace");
        assert_eq!(bits(&trace), bits(&scratch), "the trace depends on the document alone");
        assert_eq!(trace.segments().len(), before.1.segments().len());
        let untouched = |i: usize| same_segment(&spline, &before.0, i);
        for (i, (new, old)) in trace.segments().iter().zip(before.1.segments()).enumerate() {
            assert!(!untouched(i) || Arc::ptr_eq(new, old), "segment {i} was traced in vain");
        }
        if !Arc::ptr_eq(&trace, &before.1) {
            assert!(trace.retraced().iter().all(|i| !untouched(*i as usize)), "only touched segments are traced");
        }
    }
}

/// Whether a segment has the same control points and legs in two splines.
fn same_segment(a: &Spline, b: &Spline, i: usize) -> bool {
    let next = (i + 1) % a.anchors().len();
    let ends = |s: &Spline| {
        let (first, last) = (&s.anchors()[i], &s.anchors()[next]);
        (first.point(), first.outgoing().clone(), last.incoming().clone(), last.point())
    };
    ends(a) == ends(b) && a.scheme() == b.scheme()
}

/// All numbers of a trace, bit for bit.
pub(crate) fn bits(trace: &Trace) -> Vec<u64> {
    fn point(p: &SurfacePoint, out: &mut Vec<u64>) {
        out.push(u64::from(p.face.0));
        out.extend(p.weights.map(f64::to_bits));
    }
    fn path(p: &GeodesicPath, out: &mut Vec<u64>) {
        point(&p.start(), out);
        point(&p.end(), out);
        out.extend(p.crossings().iter().flat_map(|c| [u64::from(c.face.0), u64::from(c.side), c.at.to_bits()]));
        out.push(p.length().to_bits());
    }
    fn segment(s: &SegmentTrace, out: &mut Vec<u64>) {
        s.points().iter().for_each(|p| point(p, out));
        out.extend(s.parameters().iter().map(|t| t.to_bits()));
        s.paths().iter().for_each(|p| path(p, out));
    }
    let mut out = Vec::new();
    trace.segments().iter().for_each(|s| segment(s, &mut out));
    out
}

/// Where the pointer goes: at least thirty places, never back into the dead zone at once.
fn places(course: Course, from: Vec2, random: &mut Random) -> Vec<Vec2> {
    let somewhere = |random: &mut Random, radius: f32| {
        let angle = random.share() * std::f32::consts::TAU;
        CENTRE + RADIUS * radius * random.share().sqrt() * Vec2::from_angle(angle)
    };
    let mut stops = match course {
        Course::Seam => {
            let y = CENTRE.y + 0.5 * RADIUS * random.signed();
            vec![Vec2::new(CENTRE.x - 80.0, y), Vec2::new(CENTRE.x + 80.0, y), Vec2::new(CENTRE.x, y - 60.0)]
        }
        Course::OffTheModel => {
            let out = Vec2::from_angle(random.share() * std::f32::consts::TAU);
            vec![CENTRE + 1.6 * RADIUS * out, CENTRE + 1.5 * RADIUS * out.perp(), somewhere(random, 0.7)]
        }
        _ => (0..3).map(|_| somewhere(random, 0.75)).collect(),
    };
    stops.insert(0, from);
    let mut places = Vec::new();
    for pair in stops.windows(2) {
        for i in 1..=11 {
            let jitter = Vec2::new(random.signed(), random.signed());
            places.push(pair[0].lerp(pair[1], i as f32 / 11.0) + jitter);
        }
    }
    places
}

fn drag(seed: u64, course: Course) {
    println!("seed {seed}, {course:?}");
    let mut random = Random(seed);
    let join = if course == Course::CornerHandle { Join::Corner } else { Join::Smooth };
    let closed = random.below(2) == 0;
    let mut stage = Stage::new(&mut random, join, closed);
    let index = 1 + random.below(3);
    let side = if random.below(2) == 0 { HandleSide::Incoming } else { HandleSide::Outgoing };
    let kind = match course {
        Course::SmoothHandle | Course::CornerHandle => ControlKind::Handle(index, side),
        Course::Escape if random.below(2) == 0 => ControlKind::Handle(index, side),
        _ => ControlKind::Anchor(index),
    };
    let mut pointer = PointerScript::mouse(&mut stage.app).expect("a window");
    let at = stage.pixel_of(kind);
    let offset = 3.0 * Vec2::new(random.signed(), random.signed());
    let start = (stage.spline(), stage.trace());
    pointer.move_to(&mut stage.app, at + offset);
    pointer.press(&mut stage.app);
    let held = stage.app.world().resource::<DragState>().held().map(|g| (g.spline, g.kind));
    assert_eq!(held, Some((stage.spline, kind)), "the press grabs the control point");
    // Within the dead zone nothing happens.
    pointer.move_to(&mut stage.app, at + offset + Vec2::new(2.0, -2.0));
    assert_eq!(stage.spline(), start.0);
    assert!(Arc::ptr_eq(&stage.trace(), &start.1));

    let mut frames_with_change = 0;
    let mut before = start.clone();
    for place in places(course, at + offset, &mut random) {
        pointer.move_to(&mut stage.app, place);
        stage.check(&before);
        frames_with_change += u32::from(!Arc::ptr_eq(&stage.trace(), &before.1));
        before = (stage.spline(), stage.trace());
        let target = place - offset;
        if target.distance(CENTRE) < 0.9 * RADIUS && matches!(kind, ControlKind::Anchor(_)) {
            let shown = stage.pixel_of(kind);
            assert!(shown.distance(target) < 0.5, "{shown} should be {target}: the point must not jump");
        }
    }
    assert!(frames_with_change >= 8, "only {frames_with_change} frames changed anything");
    assert!(stage.app.world().resource::<DragState>().dragged().is_some());
    if course == Course::Escape {
        pointer.escape(&mut stage.app);
        stage.check(&before);
        before = (stage.spline(), stage.trace());
        assert_eq!(stage.spline(), start.0, "Escape restores the spline");
        assert_eq!(bits(&stage.trace()), bits(&start.1), "Escape restores the trace");
        let place = pointer.position() + Vec2::new(40.0, 0.0);
        pointer.move_to(&mut stage.app, place);
        assert_eq!(stage.spline(), start.0, "the rest of the gesture does nothing");
    }
    pointer.release(&mut stage.app);
    assert_eq!(*stage.app.world().resource::<DragState>(), DragState::Idle);
    assert_eq!(stage.spline(), before.0);
    stage.check(&before);
}

#[test]
fn twenty_seeded_drags() {
    for seed in 0..20 {
        drag(seed, COURSES[seed as usize % COURSES.len()]);
    }
}

#[test]
fn a_drag_does_not_depend_on_the_way() {
    let end = CENTRE + Vec2::new(70.0, -40.0);
    let mut ends = Vec::new();
    for detours in [0, 5, 40] {
        let mut random = Random(7);
        let mut stage = Stage::new(&mut random, Join::Smooth, true);
        let mut pointer = PointerScript::mouse(&mut stage.app).expect("a window");
        let at = stage.pixel_of(ControlKind::Anchor(1));
        pointer.move_to(&mut stage.app, at);
        pointer.press(&mut stage.app);
        for _ in 0..detours {
            let to = CENTRE + 150.0 * Vec2::new(random.signed(), random.signed());
            pointer.move_to(&mut stage.app, to);
        }
        pointer.move_to(&mut stage.app, end);
        pointer.release(&mut stage.app);
        ends.push((stage.spline(), bits(&stage.trace())));
    }
    assert!(ends.iter().all(|e| *e == ends[0]));
}

#[test]
fn one_gesture_has_one_inverse() {
    let mut stage = Stage::new(&mut Random(3), Join::Smooth, false);
    let before = stage.spline();
    let mut pointer = PointerScript::mouse(&mut stage.app).expect("a window");
    let at = stage.pixel_of(ControlKind::Anchor(2));
    pointer.move_to(&mut stage.app, at);
    pointer.press(&mut stage.app);
    let mut last = None;
    for i in 1..=30u16 {
        pointer.move_to(&mut stage.app, at.lerp(CENTRE, f32::from(i) / 30.0));
        let mut messages = stage.app.world_mut().resource_mut::<Messages<SplineEdited>>();
        last = messages.drain().last().or(last);
    }
    pointer.release(&mut stage.app);
    let ended: Vec<_> = stage.app.world_mut().resource_mut::<Messages<GestureEnded>>().drain().collect();
    let last = last.expect("edits");
    assert_eq!(ended.len(), 1);
    assert_eq!((Some(ended[0].gesture), ended[0].cancelled), (last.gesture, false));
    assert!(last.undoable);
    stage.app.world_mut().write_message(EditSpline::new(stage.spline, last.inverse));
    stage.app.update();
    assert_eq!(stage.spline(), before);
}

#[test]
fn another_piece_is_refused_once_and_the_last_place_holds() {
    #[derive(Resource, Default)]
    struct Refusals(Vec<String>);
    let (mut app, camera) = app_with_camera(Vec3::Z * 6.0);
    app.init_resource::<Refusals>().add_observer(|refused: On<SplineEditRefused>, mut log: ResMut<Refusals>| {
        log.0.push(refused.reason.to_string());
    });
    let mut mesh: Mesh = Sphere::new(0.8).mesh().uv(24, 12).translated_by(Vec3::X * -1.0);
    mesh.merge(&Sphere::new(0.8).mesh().uv(24, 12).translated_by(Vec3::X)).expect("like attributes");
    let surface = spawn_surface(&mut app, mesh);
    assert_eq!(surface_of(&app, surface).report().sheets, 2);
    let left = |x: f32, y: f32| Vec3::new(-1.0 + x, y, 0.7);
    let spline = spawn_spline(&mut app, surface, SplineSource::smooth_through([left(-0.3, 0.0), left(0.3, 0.0)]));
    app.world_mut().entity_mut(spline).insert(Editable);
    app.update();
    app.update();
    let mut stage = Stage { app, camera, surface, spline };
    let mut pointer = PointerScript::mouse(&mut stage.app).expect("a window");
    let at = stage.pixel_of(ControlKind::Anchor(1));
    let goal = pixel_of(stage.app.world(), camera, Vec3::new(1.0, 0.0, 0.8)).expect("on screen");
    pointer.move_to(&mut stage.app, at);
    pointer.press(&mut stage.app);
    for i in 1..=30u16 {
        pointer.move_to(&mut stage.app, at.lerp(goal, f32::from(i) / 30.0));
        let sheet = surface_of(&stage.app, surface).sheet(stage.spline().anchors()[1].point().face);
        assert_eq!(sheet, surface_of(&stage.app, surface).sheet(stage.spline().anchors()[0].point().face));
    }
    let refusals = &stage.app.world().resource::<Refusals>().0;
    assert_eq!(refusals.len(), 1, "{refusals:?}");
    assert!(refusals[0].contains("another piece"));
    let back = at.lerp(goal, 0.1);
    pointer.move_to(&mut stage.app, back);
    assert!(stage.pixel_of(ControlKind::Anchor(1)).distance(back) < 0.5, "back on its piece it follows again");
}

#[test]
fn what_is_behind_the_model_is_grabbed_with_see_through_alone() {
    use bevy_surface_splines::plugin::SplinePickingSettings;
    let (mut app, camera) = app_with_camera(Vec3::X * 4.0);
    let surface = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(32, 18));
    let behind = [Vec3::new(-1.0, 0.2, 0.1), Vec3::new(-1.0, -0.3, 0.1)];
    let spline = spawn_spline(&mut app, surface, SplineSource::smooth_through(behind));
    app.world_mut().entity_mut(spline).insert(Editable);
    app.update();
    app.update();
    let mut stage = Stage { app, camera, surface, spline };
    let mut pointer = PointerScript::mouse(&mut stage.app).expect("a window");
    let at = stage.pixel_of(ControlKind::Anchor(0));
    pointer.move_to(&mut stage.app, at);
    for see_through in [false, true] {
        stage.app.world_mut().resource_mut::<SplinePickingSettings>().see_through = see_through;
        pointer.press(&mut stage.app);
        assert_eq!(stage.app.world().resource::<DragState>().held().is_some(), see_through);
        pointer.release(&mut stage.app);
    }
}
