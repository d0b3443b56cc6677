//! Drags whose edits are computed in the background: they end as those that are applied at once.

use std::time::Duration;

use bevy::prelude::*;
use bevy_surface_splines::curve::{Spline, TraceWorkspace};
use bevy_surface_splines::plugin::testing::{PointerScript, pixel_of, update_until};
use bevy_surface_splines::plugin::{GestureEnded, SplineEdited};
use bevy_surface_splines::prelude::*;

use super::drags::bits;
use super::{Random, app_with_camera, spawn_spline, spawn_surface, surface_of};

/// Moves of control points are computed in the background, and so are traces.
const NO_TIME: TraceBudget = TraceBudget { per_frame: Duration::ZERO, preview_after: Duration::ZERO };

/// What was told of edits, in order.
#[derive(Resource, Default)]
struct Told(Vec<String>);

struct Stage {
    app: App,
    camera: Entity,
    surface: Entity,
    spline: Entity,
}

impl Stage {
    /// A sphere and a spline of four automatic anchors on the side that the camera sees; from here on, the budget holds.
    fn new(budget: TraceBudget, jumps: JumpPolicy) -> Self {
        let (mut app, camera) = app_with_camera(Vec3::X * 4.0);
        app.init_resource::<Told>()
            .add_observer(|refused: On<SplineEditRefused>, mut told: ResMut<Told>| {
                told.0.push(refused.reason.to_string());
            })
            .add_systems(Last, listen);
        let surface = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(72, 36));
        let places = [(-0.5, -0.3), (-0.1, 0.5), (0.3, -0.4), (0.5, 0.4)];
        let source = SplineSource::smooth_through(places.map(|(y, z)| Vec3::new(0.8, y, z)));
        let spline = spawn_spline(&mut app, surface, source);
        for anchor in 1..3 {
            let edit = SplineEdit::SetJoin { anchor, join: Join::Automatic };
            app.world_mut().write_message(EditSpline::new(spline, edit));
        }
        app.world_mut().write_message(EditSpline::new(spline, SplineEdit::SetJumps(jumps)));
        app.world_mut().entity_mut(spline).insert(Editable);
        (0..3).for_each(|_| app.update());
        app.world_mut().resource_mut::<Told>().0.clear();
        app.insert_resource(budget);
        Self { app, camera, surface, spline }
    }

    fn spline(&self) -> Spline {
        (**self.app.world().get::<SurfaceSpline>(self.spline).expect("a spline")).clone()
    }

    fn pending(&self) -> Option<&PendingEdit> {
        self.app.world().get(self.spline)
    }

    /// The edit that moves an anchor to some place that the camera sees.
    fn edit(&self, anchor: u32, random: &mut Random) -> SplineEdit {
        let place = Vec3::new(0.8, 0.6 * random.signed(), 0.6 * random.signed());
        let to = surface_of(&self.app, self.surface).closest_point(place.as_dvec3()).expect("a place").point;
        SplineEdit::MoveAnchor { anchor, to }
    }

    fn send(&mut self, edit: SplineEdit, gesture: Option<GestureId>) {
        let message = EditSpline { spline: self.spline, edit, undoable: true, gesture };
        self.app.world_mut().write_message(message);
    }

    fn end(&mut self, gesture: GestureId, cancel: bool) {
        self.app.world_mut().write_message(bevy_surface_splines::plugin::EndGesture { gesture, cancel });
    }

    /// Waits until nothing is under way; gives the spline and its trace, which is that from scratch.
    fn rest(&mut self) -> (Spline, Vec<u64>) {
        let spline = self.spline;
        assert!(update_until(&mut self.app, |world| {
            world.get::<PendingEdit>(spline).is_none() && world.get(spline) == Some(&SplineState::Ready)
        }));
        let trace = self.app.world().get::<SplineTrace>(spline).expect("a trace").trace().clone();
        let surface = surface_of(&self.app, self.surface);
        let scratch = self.spline().trace(surface, &mut TraceWorkspace::default(), None).expect("a trace");
        assert_eq!(bits(&trace), bits(&scratch));
        (self.spline(), bits(&trace))
    }
}

fn listen(mut edited: MessageReader<SplineEdited>, mut ended: MessageReader<GestureEnded>, mut told: ResMut<Told>) {
    told.0.extend(edited.read().map(|edited| format!("edited {}", edited.gesture.is_some())));
    told.0.extend(ended.read().map(|ended| format!("ended {}", ended.cancelled)));
}

/// Drags with the pointer along some places; gives the number of frames in which an edit was pending.
fn drag(stage: &mut Stage, kind: ControlKind, random: &mut Random, escape: bool) -> u32 {
    let mut frames = 0;
    let mut pointer = PointerScript::mouse(&mut stage.app).expect("a window");
    let point = kind.point(&stage.spline()).expect("a control point");
    let position = surface_of(&stage.app, stage.surface).position(&point).as_vec3();
    let from = pixel_of(stage.app.world(), stage.camera, position).expect("on screen");
    pointer.move_to(&mut stage.app, from);
    pointer.press(&mut stage.app);
    assert_eq!(stage.app.world().resource::<DragState>().held().map(|grip| grip.kind), Some(kind));
    for _ in 0..40 {
        let to = from.lerp(Vec2::new(640.0, 360.0), 0.5) + 60.0 * Vec2::new(random.signed(), random.signed());
        pointer.move_to(&mut stage.app, to);
        if let Some(pending) = stage.pending() {
            frames += 1;
            // What is dragged can be shown where the pointer is.
            let (moved, at) = pending.moved().expect("a move");
            assert_eq!(moved, kind);
            assert_eq!(kind.shown(&stage.spline(), Some(pending)), Some(at));
            let position = surface_of(&stage.app, stage.surface).position(&at).as_vec3();
            let pixel = pixel_of(stage.app.world(), stage.camera, position).expect("on screen");
            assert!(pixel.distance(to) < 0.5, "{pixel} should be {to}");
        }
    }
    if escape {
        pointer.escape(&mut stage.app);
    }
    pointer.release(&mut stage.app);
    frames
}

#[test]
fn a_slow_drag_ends_as_a_fast_one() {
    for jumps in [JumpPolicy::Allow, JumpPolicy::Sticky, JumpPolicy::AutoSplit] {
        for kind in [ControlKind::Anchor(1), ControlKind::Handle(2, HandleSide::Outgoing)] {
            for escape in [false, true] {
                let [fast, slow] = [TraceBudget::UNLIMITED, NO_TIME].map(|budget| {
                    let mut stage = Stage::new(budget, jumps);
                    let before = stage.rest();
                    let frames = drag(&mut stage, kind, &mut Random(9), escape);
                    assert_eq!(frames > 10, budget == NO_TIME, "{frames} frames with a pending edit");
                    let after = stage.rest();
                    assert_eq!(before == after, escape);
                    let told = &stage.app.world().resource::<Told>().0;
                    assert_eq!(told.last(), Some(&format!("ended {escape}")));
                    after
                });
                assert!(fast == slow, "{jumps:?}, {kind:?}, escape: {escape}");
            }
        }
    }
}

#[test]
fn what_comes_after_a_slow_edit_waits_for_it() {
    let outcomes = [TraceBudget::UNLIMITED, NO_TIME].map(|budget| {
        let mut stage = Stage::new(budget, JumpPolicy::Allow);
        let mut random = Random(4);
        let [first, second] = [GestureId::next(), GestureId::next()];
        for _ in 0..3 {
            let edit = stage.edit(1, &mut random);
            stage.send(edit, Some(first));
        }
        stage.send(SplineEdit::SetJoin { anchor: 2, join: Join::Corner }, None);
        stage.send(SplineEdit::Delete { anchor: 9 }, None);
        stage.end(first, false);
        stage.app.update();
        let edit = stage.edit(0, &mut random);
        stage.send(edit, Some(second));
        stage.app.update();
        stage.send(SplineEdit::SetScheme(Scheme::lane_riesenfeld()), None);
        stage.end(second, false);
        let after = stage.rest();
        let told = std::mem::take(&mut stage.app.world_mut().resource_mut::<Told>().0);
        (after, told)
    });
    assert!(outcomes[0].0 == outcomes[1].0);
    let told = &outcomes[1].1;
    let place = |text: &str| told.iter().position(|line| line.contains(text));
    assert!(place("edited true") < place("edited false") && place("no anchor 9").is_some(), "{told:?}");
    assert_eq!(told.iter().filter(|line| *line == "ended false").count(), 2);
    assert_eq!(told.last().map(String::as_str), Some("ended false"));
}

#[test]
fn a_gesture_whose_name_is_used_again_while_it_waits_loses_no_edit() {
    let splines = [TraceBudget::UNLIMITED, NO_TIME].map(|budget| {
        let mut stage = Stage::new(budget, JumpPolicy::Allow);
        let mut random = Random(7);
        let gesture = GestureId::next();
        for _ in 0..10 {
            for (anchor, ends) in [(1, false), (1, true), (0, true)] {
                let edit = stage.edit(anchor, &mut random);
                stage.send(edit, Some(gesture));
                if ends {
                    stage.end(gesture, false);
                }
                stage.app.update();
            }
        }
        let told =
            |stage: &Stage| stage.app.world().resource::<Told>().0.iter().filter(|t| *t == "ended false").count();
        let after = stage.rest();
        assert_eq!(told(&stage), 20);
        after
    });
    assert!(splines[0] == splines[1]);
}

#[test]
fn what_goes_during_a_slow_edit_is_no_trouble() {
    for gone in 0..4 {
        let mut stage = Stage::new(NO_TIME, JumpPolicy::Allow);
        let gesture = GestureId::next();
        for _ in 0..2 {
            let edit = stage.edit(1, &mut Random(gone));
            stage.send(edit, Some(gesture));
        }
        stage.app.update();
        assert!(stage.pending().is_some());
        let world = stage.app.world_mut();
        match gone {
            0 => drop(world.despawn(stage.spline)),
            1 => drop(world.despawn(stage.surface)),
            2 => drop(world.entity_mut(stage.spline).remove::<SurfaceSpline>()),
            _ => drop(world.entity_mut(stage.surface).remove::<(BuiltSurface, SplineSurface)>()),
        }
        stage.end(gesture, gone == 3);
        for _ in 0..20 {
            stage.app.update();
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(stage.pending().is_none());
    }
}

#[test]
fn a_surface_that_changes_during_a_slow_edit_drops_it() {
    let mut stage = Stage::new(NO_TIME, JumpPolicy::Allow);
    let edit = stage.edit(1, &mut Random(3));
    stage.send(edit, Some(GestureId::next()));
    stage.app.update();
    assert!(stage.pending().is_some());
    let other = spawn_surface(&mut stage.app, Sphere::new(1.2).mesh().uv(36, 18));
    let other = stage.app.world().get::<BuiltSurface>(other).expect("a surface").clone();
    stage.app.world_mut().entity_mut(stage.surface).insert(other);
    let (spline, _) = stage.rest();
    let surface = surface_of(&stage.app, stage.surface);
    assert!(spline.anchors().iter().all(|anchor| surface.position(&anchor.point()).length() > 1.1));
}

#[test]
fn a_control_polygon_follows_behind_a_slow_drag() {
    let polygons = [TraceBudget::UNLIMITED, NO_TIME].map(|budget| {
        let mut stage = Stage::new(budget, JumpPolicy::Allow);
        stage.send(SplineEdit::SetScheme(Scheme::b_spline()), None);
        stage.app.update();
        let gesture = GestureId::next();
        let mut random = Random(6);
        for _ in 0..30 {
            let edit = stage.edit(1, &mut random);
            stage.send(edit, Some(gesture));
            stage.app.update();
        }
        stage.end(gesture, false);
        stage.rest();
        let (spline, anchors) = (stage.spline, stage.spline().anchors().to_vec());
        let surface = stage.app.world().get::<BuiltSurface>(stage.surface).expect("a surface").clone();
        let ends = |polygon: &ControlPolygon| {
            let place = |i: usize| surface.position(&anchors[i].point()).as_vec3();
            polygon
                .legs()
                .enumerate()
                .all(|(i, leg)| leg.first() == Some(&place(i)) && leg.last() == Some(&place(i + 1)))
        };
        assert!(update_until(&mut stage.app, |world| world.get::<ControlPolygon>(spline).is_some_and(ends)));
        let polygon = stage.app.world().get::<ControlPolygon>(spline).expect("a polygon");
        polygon.legs().map(<[Vec3]>::to_vec).collect::<Vec<_>>()
    });
    assert_eq!(polygons[0].len(), 3);
    assert_eq!(polygons[0], polygons[1]);
}
