//! What edits are expected to take, modelled as [`costs`](super::costs) does it for traces.

use super::costs::trace_work;
use crate::curve::{Coordinates, Join, JumpPolicy, SelectionTransform, Spline, SplineEdit};
use crate::geodesic::GeodesicPath;
use crate::surface::{Surface, SurfacePoint};

/// Seconds for an edit, whatever it does.
const PER_EDIT: f64 = 1e-5;
/// Seconds for each edge length along a known way that is straightened.
const PER_EDGE: f64 = 1e-6;
/// Seconds for each square edge length that a search is across: medians of random pairs are between 2e-7 and 9e-7.
const PER_SQUARE: f64 = 5e-7;

/// Modelled work of an edit that moves control points, in seconds; none of other edits.
pub(crate) fn edit_work(surface: &Surface, spline: &Spline, edit: &SplineEdit) -> Option<f64> {
    let point = |anchor: u32| Some(spline.anchors().get(anchor as usize)?.point());
    let (anchor, direct) = match edit {
        SplineEdit::MoveAnchor { anchor, to }
        | SplineEdit::MoveHandle { anchor, to, .. }
        | SplineEdit::FreeHandle { anchor, to, .. } => (*anchor, search_work(surface, point(*anchor)?, *to)),
        SplineEdit::DragAnchor { anchor, along } | SplineEdit::DragHandle { anchor, along, .. } => {
            (*anchor, PER_EDGE * along.length() / edge(surface, point(*anchor)?))
        }
        SplineEdit::Transform(transform) => return Some(transform_work(surface, spline, transform)),
        _ => return None,
    };
    let around = around(spline, anchor as usize);
    Some(PER_EDIT + direct + automatic_work(surface, spline, &around) + middles_work(surface, spline, &around))
}

/// A transform looks for a way to every anchor it takes along: from the centre, or from the one before.
fn transform_work(surface: &Surface, spline: &Spline, transform: &SelectionTransform) -> f64 {
    let anchors = spline.anchors();
    let chosen: Vec<usize> = match &transform.anchors {
        Some(chosen) => chosen.iter().map(|i| *i as usize).filter(|i| *i < anchors.len()).collect(),
        None => (0..anchors.len()).collect(),
    };
    let mut from = transform.centre;
    let mut work = PER_EDIT + search_work(surface, transform.centre, transform.to);
    for i in &chosen {
        let to = anchors[*i].point();
        work += search_work(surface, from, to);
        if transform.coordinates == Coordinates::Chained {
            from = to;
        }
    }
    work + automatic_work(surface, spline, &chosen) + middles_work(surface, spline, &chosen)
}

/// An anchor and two on either side, in order.
fn around(spline: &Spline, anchor: usize) -> Vec<usize> {
    let n = spline.anchors().len();
    if spline.is_closed() && n > 5 {
        return (0..5).map(|k| (anchor + n - 2 + k) % n).collect();
    }
    (anchor.saturating_sub(2)..(anchor + 3).min(n)).collect()
}

/// Handles of automatic joins are placed by searches to both neighbours.
fn automatic_work(surface: &Surface, spline: &Spline, around: &[usize]) -> f64 {
    let anchors = spline.anchors();
    let automatic = around.iter().filter(|i| anchors[**i].join() == Join::Automatic).count();
    let ways = around.windows(2).map(|pair| search_work(surface, anchors[pair[0]].point(), anchors[pair[1]].point()));
    2.0 * ways.fold(0.0, f64::max) * automatic as f64
}

/// Middle legs are led, or looked at for jumps, where the spline asks for that.
fn middles_work(surface: &Surface, spline: &Spline, around: &[usize]) -> f64 {
    if spline.jumps() == JumpPolicy::Allow || spline.scheme().method.is_b_spline() {
        return 0.0;
    }
    let segments: Vec<usize> = around.iter().copied().filter(|i| *i < spline.segment_count()).collect();
    trace_work(surface, spline, &segments)
}

/// Modelled work of continuing a way through some places.
pub(crate) fn lead_work(surface: &Surface, way: &GeodesicPath, places: &[SurfacePoint]) -> f64 {
    let mut last = way.end();
    let searches = places.iter().map(|to| search_work(surface, std::mem::replace(&mut last, *to), *to));
    let straightening = PER_EDGE * way.length() / edge(surface, way.end());
    searches.sum::<f64>() + places.len() as f64 * (PER_EDIT + straightening)
}

/// Modelled work of the search for a way between two points.
pub(crate) fn search_work(surface: &Surface, from: SurfacePoint, to: SurfacePoint) -> f64 {
    let across = surface.position(&from).distance(surface.position(&to)) / edge(surface, from);
    PER_SQUARE * across * across
}

/// The mean edge length around a point; endless for one of another surface, of which nothing is computed.
fn edge(surface: &Surface, point: SurfacePoint) -> f64 {
    surface.mean_edge_length(point.face).unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesic::PathFinder;
    use crate::surface::{SurfaceOptions, shapes};
    use glam::DVec3;

    #[test]
    fn work_grows_with_mesh_and_joins() {
        let mut finder = PathFinder::new();
        let [coarse, fine] = [3, 5].map(|level| {
            let surface = Surface::build(&shapes::icosphere(level), &SurfaceOptions::default()).expect("a surface");
            let near = |p| surface.closest_point(p).expect("a place").point;
            let points = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X].map(near);
            let mut spline = Spline::smooth_through(&surface, &mut finder, &points, false).expect("a spline");
            let edit = SplineEdit::MoveAnchor { anchor: 1, to: near(DVec3::ONE) };
            let smooth = edit_work(&surface, &spline, &edit).expect("a move");
            let join = SplineEdit::SetJoin { anchor: 2, join: Join::Automatic };
            assert_eq!(edit_work(&surface, &spline, &join), None);
            spline.apply(&surface, &mut finder, &join).expect("applied");
            [smooth, edit_work(&surface, &spline, &edit).expect("a move")]
        });
        assert!(fine[0] > 8.0 * coarse[0] && fine[1] > 2.0 * fine[0], "{coarse:?} {fine:?}");
    }
}
