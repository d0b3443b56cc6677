//! Cutting paths where they leave the surface.

use glam::DVec2;

use super::frame::Frame;
use crate::geodesic::inner::InnerPath;
use crate::vector::VectorPath;

/// A cut is this close to the boundary, as a share of its segment's parameters.
const HALVINGS: u32 = 40;

/// The parts of a path whose anchors are on the surface, cut at the boundary; and how many of its segments are gone whole.
///
/// Whether a segment leaves the surface and comes back between two anchors that are on it is not looked at.
pub(super) fn parts(frame: &Frame<'_>, path: &VectorPath, spare: &mut InnerPath) -> (Vec<VectorPath>, u32) {
    let mut is_on = |point: DVec2| frame.land(point, spare).is_ok();
    let on: Vec<bool> = (0..path.anchor_count()).map(|i| path.anchor(i).is_some_and(&mut is_on)).collect();
    let (count, anchors) = (path.segment_count(), on.len());
    // A closed path is begun where it is off the surface, so that no part runs through its beginning.
    let first = if path.is_closed() { on.iter().position(|on| !on).unwrap_or(0) } else { 0 };
    let mut parts = Vec::new();
    let mut part: Vec<DVec2> = Vec::new();
    let mut gone = 0;
    for i in (0..count).map(|k| (first + k) % count) {
        let (from_on, to_on) = (on[i], on[(i + 1) % anchors]);
        let (from, to) = match (from_on, to_on) {
            (true, true) => (0.0, 1.0),
            (true, false) => (0.0, boundary(path, i, 0.0, 1.0, &mut is_on)),
            (false, true) => (boundary(path, i, 1.0, 0.0, &mut is_on), 1.0),
            (false, false) => {
                gone += 1;
                continue;
            }
        };
        if from < to {
            let [a, b, c, d] = path.part(i, from, to);
            if part.is_empty() {
                part.push(a);
            }
            part.extend([b, c, d]);
        }
        if !to_on {
            parts.extend(VectorPath::from_points(std::mem::take(&mut part), false));
        }
    }
    parts.extend(VectorPath::from_points(part, false));
    (parts, gone)
}

/// The last parameter of a segment that is on the surface, between one that is and one that is not.
fn boundary(path: &VectorPath, segment: usize, on: f64, off: f64, is_on: &mut impl FnMut(DVec2) -> bool) -> f64 {
    let (mut on, mut off) = (on, off);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (on + off);
        if is_on(path.point_at(segment, middle)) {
            on = middle;
        } else {
            off = middle;
        }
    }
    on
}
