//! A handle dragged around a ring, past the place where the shortest way to it changes sides.

use std::f64::consts::PI;

use glam::DVec3;

use super::*;
use crate::curve::*;
use crate::geodesic::GeodesicPath;

const RADIUS: f64 = 2.5;

fn ring() -> Surface {
    built(&shapes::torus(2.0, 0.5, 96, 24))
}

/// A place on the outer equator, a little off the rows of vertices.
fn on_ring(surface: &Surface, angle: f64) -> SurfacePoint {
    at(surface, DVec3::new(RADIUS * angle.cos(), RADIUS * angle.sin(), 0.07))
}

fn spline(surface: &Surface, jumps: JumpPolicy) -> Spline {
    let polygon = [0.0, 0.4, 0.8, 1.2].map(|angle| on_ring(surface, angle));
    let mut spline = Spline::bezier(surface, &mut PathFinder::new(), polygon).unwrap();
    spline.apply(surface, &mut PathFinder::new(), &SplineEdit::SetJumps(jumps)).unwrap();
    spline
}

/// The splines of a drag of the second handle from 0.8 to some angle, each made from the first by the whole way so far.
fn drag_of(surface: &Surface, before: &Spline, to: f64) -> Vec<Spline> {
    let mut finder = PathFinder::new();
    let steps = 60;
    let mut along: GeodesicPath = surface.shortest_path(&on_ring(surface, 0.8), &on_ring(surface, 0.8)).unwrap();
    (1..=steps)
        .map(|k| {
            let angle = 0.8 + (to - 0.8) * f64::from(k) / f64::from(steps);
            along = finder.continued(surface, &along, &on_ring(surface, angle)).unwrap();
            let edit = SplineEdit::DragHandle { anchor: 1, side: HandleSide::Incoming, along: along.clone() };
            let mut spline = before.clone();
            let inverse = spline.apply(surface, &mut finder, &edit).unwrap();
            let mut back = spline.clone();
            back.apply(surface, &mut finder, &inverse).unwrap();
            assert_eq!(format!("{back:?}"), format!("{before:?}"));
            spline
        })
        .collect()
}

/// Largest distance between places of two curves at equal shares of their lengths.
fn step(surface: &Surface, a: &Spline, b: &Spline) -> f64 {
    let mut workspace = TraceWorkspace::default();
    let mut place = |spline: &Spline, share: f64| {
        let trace = spline.trace(surface, &mut workspace, None).unwrap();
        surface.position(&trace.at_distance(surface, share * trace.length()).unwrap())
    };
    (0..=20).map(|k| f64::from(k) / 20.0).map(|share| place(a, share).distance(place(b, share))).fold(0.0, f64::max)
}

fn middle_length(surface: &Surface, spline: &Spline) -> f64 {
    let [_, p, q, _] = spline.polygon(0).unwrap()[..] else { unreachable!() };
    spline.anchors()[0].middle().map_or_else(|| surface.shortest_path(&p, &q).unwrap().length(), GeodesicPath::length)
}

#[test]
fn allowed_jumps_happen() {
    let surface = ring();
    let before = spline(&surface, JumpPolicy::Allow);
    let drag = drag_of(&surface, &before, 0.4 + PI + 0.7);
    let steps: Vec<f64> = drag.windows(2).map(|w| step(&surface, &w[0], &w[1])).collect();
    let largest = steps.iter().fold(0.0_f64, |m, s| m.max(*s));
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    assert!(largest > 10.0 * sorted[sorted.len() / 2], "{steps:?}");
    // The trace depends on the control points alone.
    let last = &drag[drag.len() - 1];
    assert!(last.anchors().iter().all(|a| a.middle().is_none()));
    assert!(middle_length(&surface, last) < RADIUS * PI);
}

#[test]
fn sticky_legs_stay() {
    let surface = ring();
    let mut finder = PathFinder::new();
    let before = spline(&surface, JumpPolicy::Sticky);
    let angle = 0.4 + PI + 0.7;
    let there = drag_of(&surface, &before, angle);
    let steps: Vec<f64> = there.windows(2).map(|w| step(&surface, &w[0], &w[1])).collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let allowed = spline(&surface, JumpPolicy::Allow);
    let jumping = drag_of(&surface, &allowed, angle);
    let jump = jumping.windows(2).map(|w| step(&surface, &w[0], &w[1])).fold(0.0, f64::max);
    assert!(sorted[sorted.len() - 1] < 0.3 * jump, "{jump} {steps:?}");
    let last = &there[there.len() - 1];
    let excess = last.excess(&surface, &mut finder, 0).unwrap();
    assert!(excess > 0.1, "{excess}");
    assert_eq!(before.excess(&surface, &mut finder, 0).unwrap(), 0.0);
    // The middle leg belongs to the document: it is traced, and survives what does not touch it.
    let trace = last.trace(&surface, &mut TraceWorkspace::default(), None).unwrap();
    assert_eq!(trace, last.clone().trace(&surface, &mut TraceWorkspace::default(), None).unwrap());
    let mut more = last.clone();
    let append = SplineEdit::Append { end: SplineEnd::End, at: on_ring(&surface, 1.6) };
    more.apply(&surface, &mut finder, &append).unwrap();
    assert_eq!(more.anchors()[0].middle(), last.anchors()[0].middle());
    assert!(more.anchors()[1].middle().is_some() && more.anchors()[2].middle().is_none());
    // Letting go of it searches the shortest way.
    more.apply(&surface, &mut finder, &SplineEdit::SetJumps(JumpPolicy::Allow)).unwrap();
    assert!(middle_length(&surface, &more) < 0.95 * middle_length(&surface, last));
    // Step by step, each from the one before, leads to the same way around.
    let mut stepped = before.clone();
    for k in 1..=60 {
        let from = stepped.anchors()[1].incoming().point();
        let to = on_ring(&surface, 0.8 + (angle - 0.8) * f64::from(k) / 60.0);
        let along = surface.shortest_path(&from, &to).unwrap();
        let edit = SplineEdit::DragHandle { anchor: 1, side: HandleSide::Incoming, along };
        stepped.apply(&surface, &mut finder, &edit).unwrap();
    }
    let [a, b] = [&stepped, last].map(|s| middle_length(&surface, s));
    assert!((a - b).abs() < 0.02 * b, "{a} {b}");
}

#[test]
fn sticky_legs_follow_anchors_and_partners() {
    let surface = ring();
    let mut finder = PathFinder::new();
    let points = [0.0, 1.4, 2.4].map(|angle| on_ring(&surface, angle));
    let mut spline = Spline::smooth_through(&surface, &mut finder, &points, false).unwrap();
    spline.apply(&surface, &mut finder, &SplineEdit::SetJumps(JumpPolicy::Sticky)).unwrap();
    // The last anchor goes all the way around and beyond the first; its handles and the middle leg with it.
    for k in 1..=60 {
        let from = spline.anchors()[2].point();
        let to = on_ring(&surface, 2.4 + 5.0 * f64::from(k) / 60.0);
        let along = surface.shortest_path(&from, &to).unwrap();
        spline.apply(&surface, &mut finder, &SplineEdit::DragAnchor { anchor: 2, along }).unwrap();
    }
    let middle = spline.anchors()[1].middle().unwrap();
    assert!(middle.length() > 0.6 * 5.0 * RADIUS * 0.6, "{}", middle.length());
    assert!(spline.excess(&surface, &mut finder, 1).unwrap() > 0.5);
    // A partner that turns with its handle takes its middle leg along.
    let to = on_ring(&surface, 1.7);
    spline.apply(&surface, &mut finder, &SplineEdit::MoveHandle { anchor: 1, side: HandleSide::Outgoing, to }).unwrap();
    for (i, anchor) in spline.anchors().iter().enumerate().take(2) {
        let middle = anchor.middle().unwrap();
        assert!(surface.same_place(&middle.start(), &anchor.outgoing().point()));
        assert!(surface.same_place(&middle.end(), &spline.anchors()[i + 1].incoming().point()));
    }
    assert!(spline.excess(&surface, &mut finder, 1).unwrap() > 0.5);
}

#[test]
fn splits_come_before_jumps() {
    let surface = ring();
    let before = spline(&surface, JumpPolicy::AutoSplit);
    let drag = drag_of(&surface, &before, 0.4 + PI + 0.7);
    let counts: Vec<usize> = drag.iter().map(|s| s.anchors().len()).collect();
    assert!(counts[0] == 2 && counts.is_sorted(), "{counts:?}");
    let last = &drag[drag.len() - 1];
    assert!((3..=8).contains(&last.anchors().len()), "{counts:?}");
    // The first new anchor was put on the old curve, in its middle. The handle stays under the pointer while its segment gets
    // shorter, which moves the curve, but by far less than a jump.
    let middle = before.evaluate(&surface, &mut TraceWorkspace::default(), SplineT(0.5)).unwrap();
    assert!(surface.same_place(&last.anchors()[1].point(), &middle));
    let steps: Vec<f64> = drag.windows(2).map(|w| step(&surface, &w[0], &w[1])).collect();
    let largest = steps.iter().fold(0.0_f64, |m, s| m.max(*s));
    let jumping = drag_of(&surface, &spline(&surface, JumpPolicy::Allow), 0.4 + PI + 0.7);
    let jump = jumping.windows(2).map(|w| step(&surface, &w[0], &w[1])).fold(0.0, f64::max);
    assert!(largest < 0.3 * jump, "{jump} {steps:?}");
    // The handle that was dragged is where the drag led it, and its new middle leg does not reach half around.
    let [_, _, q, _] = last.polygon(last.segment_count() - 1).unwrap()[..] else { unreachable!() };
    assert!(surface.same_place(&q, &on_ring(&surface, 0.4 + PI + 0.7)));
}

/// A whole spline may come from a file: its middle legs were believed.
#[test]
fn middle_legs_of_whole_splines_join_their_handles() {
    let surface = ring();
    let mut finder = PathFinder::new();
    let good = spline(&surface, JumpPolicy::Sticky);
    let mut broken = good.clone();
    broken.anchors[0].middle = Some(surface.shortest_path(&on_ring(&surface, 2.0), &on_ring(&surface, 2.5)).unwrap());
    let mut spline = good.clone();
    spline.apply(&surface, &mut finder, &SplineEdit::Replace(broken.clone())).unwrap();
    assert_eq!(spline, good);
    broken.jumps = JumpPolicy::Allow;
    spline.apply(&surface, &mut finder, &SplineEdit::Replace(broken)).unwrap();
    assert!(spline.anchors()[0].middle().is_none());
}
