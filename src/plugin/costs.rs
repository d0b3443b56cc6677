//! What traces and edits are expected to take.
//!
//! Work is modelled in seconds, from lengths in units of the mesh's mean edge. The model is rough: curves of one size differ by a
//! factor of three on either side. So it is not trusted for more than proportions: what was measured before, of the same
//! spline if possible, says how the model relates to the truth ([`Pace`]).

use glam::DVec3;

use crate::curve::{Sampling, Scheme, Spline};
use crate::surface::Surface;

/// Seconds for each geodesic of a trace, however short.
const PER_PIECE: f64 = 1e-6;
/// Seconds for each edge length along the control polygon: strips are straightened level after level.
const PER_EDGE: f64 = 4e-6;
/// Seconds for each square edge length: long legs are searched, and a search looks at what lies around the way. Medians of
/// random curves on models of 6,000 to 1,400,000 faces are between 1.0e-7 and 2.4e-7.
const PER_SQUARE: f64 = 1e-7;
/// Schemes for comparison search all legs between points that others make by continuing known ones.
const COMPARISON: f64 = 30.0;
/// Geodesics of a segment under an adaptive sampling, mostly fewer.
const ADAPTIVE_PIECES: f64 = 64.0;

/// How long things take, as a multiple of what the model says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace(f64);

impl Default for Pace {
    fn default() -> Self {
        Self(1.0)
    }
}

impl Pace {
    /// What some work is expected to take, in seconds.
    pub(crate) fn expect(self, work: f64) -> f64 {
        // Points that do not belong to the surface have no positions: such a trace fails at once.
        (self.0 * work).max(0.0)
    }

    /// Learns from what some work took. A slow one counts at once, a fast one by and by: to be wrong in that direction costs
    /// a frame its time.
    pub(crate) fn learn(&mut self, work: f64, seconds: f64) {
        let measured = seconds / work;
        if measured.is_finite() {
            self.0 = measured.max(0.5 * self.0);
        }
    }
}

/// Modelled work of tracing some segments.
pub(crate) fn trace_work(surface: &Surface, spline: &Spline, segments: &[usize]) -> f64 {
    segments.iter().map(|segment| segment_work(surface, spline, *segment)).sum()
}

/// The segments of a spline that another, which was traced, does not have.
pub(crate) fn segments_to_trace(spline: &Spline, traced: Option<&Spline>) -> Vec<usize> {
    let has = |traced: &Spline, i| segment_in(traced, spline, i).is_some();
    (0..spline.segment_count()).filter(|i| !traced.is_some_and(|traced| has(traced, *i))).collect()
}

/// Where another spline has the same segment, as far as can be seen from outside: at its place, or shifted by one.
pub(crate) fn segment_in(other: &Spline, spline: &Spline, segment: usize) -> Option<usize> {
    let near = [Some(segment), segment.checked_sub(1), segment.checked_add(1)];
    near.into_iter().flatten().find(|k| *k < other.segment_count() && is_same(spline, segment, other, *k))
}

fn is_same(a: &Spline, i: usize, b: &Spline, k: usize) -> bool {
    if a.scheme() != b.scheme() {
        return false;
    }
    if a.scheme().method.is_b_spline() {
        return a.segment_count() == b.segment_count() && a.polygon(i) == b.polygon(k);
    }
    let ends = |s: &Spline, i: usize| [i, (i + 1) % s.anchors().len()];
    let ([a0, a1], [b0, b1]) = (ends(a, i).map(|i| &a.anchors()[i]), ends(b, k).map(|k| &b.anchors()[k]));
    a0.outgoing().leg() == b0.outgoing().leg()
        && a1.incoming().leg() == b1.incoming().leg()
        && a0.middle() == b0.middle()
}

fn segment_work(surface: &Surface, spline: &Spline, segment: usize) -> f64 {
    let polygon = spline.polygon(segment).unwrap_or_default();
    let Some(edge) = polygon.first().and_then(|p| surface.mean_edge_length(p.face).ok()) else { return 0.0 };
    let positions: Vec<DVec3> = polygon.iter().map(|p| surface.position(p)).collect();
    // Straight through space, which on closed models is a third less than along the surface.
    let length: f64 = positions.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    let across = length / edge;
    let scheme = spline.scheme();
    let factor = if scheme.method.is_for_comparison() { COMPARISON } else { 1.0 };
    factor * (PER_PIECE * pieces(scheme, length) + PER_EDGE * across + PER_SQUARE * across * across)
}

/// About how many geodesics the trace of a segment has.
fn pieces(scheme: Scheme, length: f64) -> f64 {
    match scheme.sampling {
        Sampling::Levels(levels) => 3.0 * f64::from(levels.min(Scheme::MAX_LEVELS)).exp2(),
        Sampling::Length(longest) => (length / longest.max(f64::MIN_POSITIVE)).min(12_288.0),
        Sampling::Adaptive { .. } => ADAPTIVE_PIECES,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{HandleSide, SplineEdit, SplineEnd};
    use crate::geodesic::PathFinder;
    use crate::surface::{SurfaceOptions, shapes};

    fn spline(surface: &Surface, finder: &mut PathFinder) -> Spline {
        let places = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y];
        let points = places.map(|p| surface.closest_point(p).expect("a place").point);
        Spline::smooth_through(surface, finder, &points, false).expect("a spline")
    }

    #[test]
    fn segments_that_an_edit_touches_are_to_be_traced() {
        let surface = Surface::build(&shapes::icosphere(3), &SurfaceOptions::default()).expect("a surface");
        let mut finder = PathFinder::new();
        let before = spline(&surface, &mut finder);
        assert_eq!(segments_to_trace(&before, None), [0, 1, 2, 3]);
        assert!(segments_to_trace(&before, Some(&before)).is_empty());
        let place = surface.closest_point(DVec3::new(1.0, 1.0, 1.0)).expect("a place").point;
        let mut after = |edit| {
            let mut after = before.clone();
            after.apply(&surface, &mut finder, &edit).expect("applied");
            segments_to_trace(&after, Some(&before))
        };
        let handle = SplineEdit::MoveHandle { anchor: 0, side: HandleSide::Outgoing, to: place };
        assert_eq!(after(handle), [0]);
        assert_eq!(after(SplineEdit::MoveAnchor { anchor: 2, to: place }), [1, 2]);
        assert_eq!(after(SplineEdit::Append { end: SplineEnd::End, at: place }), [4]);
        assert_eq!(after(SplineEdit::Append { end: SplineEnd::Start, at: place }), [0]);
        assert_eq!(after(SplineEdit::SetScheme(Scheme::lane_riesenfeld())), [0, 1, 2, 3]);
    }

    #[test]
    fn work_grows_with_the_mesh() {
        let mut finder = PathFinder::new();
        let work = [3, 5].map(|level| {
            let surface = Surface::build(&shapes::icosphere(level), &SurfaceOptions::default()).expect("a surface");
            trace_work(&surface, &spline(&surface, &mut finder), &[1, 2])
        });
        assert!(work[1] > 2.0 * work[0], "{work:?}");
    }

    #[test]
    fn what_was_slow_is_expected_to_be_slow() {
        let mut pace = Pace::default();
        pace.learn(1e-3, 8e-3);
        assert_eq!(pace.expect(2e-3), 1.6e-2);
        pace.learn(1e-3, 1e-3);
        assert_eq!(pace.expect(1e-3), 4e-3);
        pace.learn(0.0, 0.0);
        assert_eq!(pace.expect(1e-3), 4e-3);
        assert_eq!(pace.expect(f64::NAN), 0.0);
    }
}
