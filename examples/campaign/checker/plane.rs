//! Unfolding faces into the plane, and pulling a string taut in what was unfolded.
//!
//! Heights and angles come from cross products of corner differences, not from side lengths: differences of nearby 32-bit
//! positions are exact in 64 bits, so that needles keep their thickness, which rounding to lengths would lose.

use glam::{DVec2, DVec3};

use super::topology::Topology;

/// A side that a path crosses in the plane, by its ends as seen in the direction of travel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portal {
    pub(crate) right: DVec2,
    pub(crate) left: DVec2,
}

/// A crossing of side `leave` of one face, which is side `enter` of the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passage {
    pub(crate) leave: usize,
    pub(crate) enter: usize,
}

/// More portals than this are not pulled taut (only faces without area make such windows).
const MOST_PORTALS: usize = 48;

/// Angle between two vectors.
pub(crate) fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Where `p` lies relative to the segment from `a` to `b`: along it (in shares of its length) and beside it (likewise).
fn beside(a: DVec3, b: DVec3, p: DVec3) -> (f64, f64) {
    let (e, d) = (b - a, p - a);
    let squared = e.length_squared();
    (e.dot(d) / squared, e.cross(d).length() / squared)
}

/// Lays a strip of faces flat. `faces` has one more entry than `passages`; both end points are weights in the first and
/// the last face.
pub(crate) fn unfold(
    topology: &Topology,
    faces: &[u32],
    passages: &[Passage],
    from: [f64; 3],
    to: [f64; 3],
) -> Option<(DVec2, Vec<Portal>, DVec2)> {
    let (&first, &leave) = (faces.first()?, &passages.first()?.leave);
    // The first face lies above the x axis and is left downwards: corner `leave` is on the right, at the origin.
    let p = topology.places(first);
    let (k, l, m) = (leave, (leave + 1) % 3, (leave + 2) % 3);
    let length = p[k].distance(p[l]);
    let (along, aside) = beside(p[k], p[l], p[m]);
    let mut flat = [DVec2::ZERO; 3];
    flat[l] = DVec2::new(length, 0.0);
    flat[m] = DVec2::new(along, aside) * length;
    let start = blend(&flat, from);
    let mut portals = Vec::with_capacity(passages.len());
    let mut ends = [topology.corners[first as usize][k], topology.corners[first as usize][l]];
    let mut portal = Portal { right: flat[k], left: flat[l] };
    for (i, passage) in passages.iter().enumerate() {
        let face = faces[i + 1];
        if i > 0 {
            // Leaving through the side that keeps the left or the right end.
            let t = topology.corners[faces[i] as usize];
            let (a, b) = (passage.leave, (passage.leave + 1) % 3);
            let apex = flat[t.iter().position(|v| !ends.contains(v))?];
            let apex_name = *t.iter().find(|v| !ends.contains(v))?;
            if t[a] == ends[1] || t[b] == ends[1] {
                (portal.right, ends[0]) = (apex, apex_name);
            } else {
                (portal.left, ends[1]) = (apex, apex_name);
            }
        }
        portals.push(portal);
        let t = topology.corners[face as usize];
        let (a, b) = (passage.enter, (passage.enter + 1) % 3);
        let (right, left) = if t[a] == ends[0] { (a, b) } else { (b, a) };
        let apex = 3 - a - b;
        let p = topology.places(face);
        let (along, aside) = beside(p[right], p[left], p[apex]);
        let e = portal.left - portal.right;
        flat[right] = portal.right;
        flat[left] = portal.left;
        flat[apex] = portal.right + e * along + DVec2::new(e.y, -e.x) * aside;
    }
    Some((start, portals, blend(&flat, to)))
}

fn blend(corners: &[DVec2; 3], weights: [f64; 3]) -> DVec2 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// Length of the shortest line from `a` through the portals to `c`; none where there are too many portals to say.
pub(crate) fn taut(a: DVec2, portals: &[Portal], c: DVec2) -> Option<f64> {
    if passes(a, portals, c) {
        return Some(a.distance(c));
    }
    if portals.len() > MOST_PORTALS {
        return None;
    }
    // Shortest distances from `a` to the ends of each portal, by straight pieces; a taut line bends nowhere else.
    let mut best: Vec<[f64; 2]> = Vec::with_capacity(portals.len());
    let reach = |q: DVec2, before: &[Portal], best: &[[f64; 2]]| {
        let mut shortest = if passes(a, before, q) { a.distance(q) } else { f64::INFINITY };
        for (i, portal) in before.iter().enumerate() {
            for (p, so_far) in [portal.right, portal.left].into_iter().zip(best[i]) {
                if passes(p, &before[i + 1..], q) {
                    shortest = shortest.min(so_far + p.distance(q));
                }
            }
        }
        shortest
    };
    for (i, portal) in portals.iter().enumerate() {
        let ends = [portal.right, portal.left].map(|q| reach(q, &portals[..i], &best));
        best.push(ends);
    }
    Some(reach(c, portals, &best))
}

/// Whether the straight line from `a` to `c` passes every portal between its ends.
fn passes(a: DVec2, portals: &[Portal], c: DVec2) -> bool {
    let d = c - a;
    portals.iter().all(|p| {
        let (right, left) = (d.perp_dot(p.right - a), d.perp_dot(p.left - a));
        right <= 0.0 && left >= 0.0 && !runs_beside(a, d, p, left - right)
    })
}

/// Whether a line runs along a portal without reaching it, as it may where faces have no area: the sides that the portal's ends
/// are on say nothing then.
fn runs_beside(a: DVec2, d: DVec2, portal: &Portal, apart: f64) -> bool {
    const PARALLEL: f64 = 1e-9;
    const NEAR: f64 = 1e-9;
    if apart > PARALLEL * d.length() * portal.right.distance(portal.left) {
        return false;
    }
    let along = [portal.right, portal.left].map(|p| d.dot(p - a) / d.length_squared());
    along.iter().all(|s| *s < -NEAR) || along.iter().all(|s| *s > 1.0 + NEAR)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_surface_splines::surface::shapes;

    #[test]
    fn a_taut_line_is_the_chord_or_bends_at_ends() {
        let portal = |x: f64, low: f64, high: f64| Portal { right: DVec2::new(x, low), left: DVec2::new(x, high) };
        let (a, c) = (DVec2::ZERO, DVec2::new(4.0, 0.0));
        assert_eq!(taut(a, &[portal(1.0, -1.0, 1.0), portal(2.0, -1.0, 1.0)], c), Some(4.0));
        let up = taut(a, &[portal(2.0, 1.0, 2.0)], c).unwrap();
        assert!((up - 2.0 * 5.0_f64.sqrt()).abs() < 1e-15);
        let zigzag = taut(a, &[portal(1.0, 1.0, 2.0), portal(3.0, -2.0, -1.0)], c).unwrap();
        assert!((zigzag - (2.0 * 2.0_f64.sqrt() + 8.0_f64.sqrt())).abs() < 1e-15);
    }

    #[test]
    fn a_taut_line_goes_to_a_portal_that_it_could_run_beside() {
        let portal = |x: f64, y: f64| Portal { right: DVec2::new(x, y), left: DVec2::new(-2.0, 0.0) };
        // A face without area lies between the first two.
        let portals = [portal(0.3, 0.0), portal(0.0, 0.0), Portal { right: DVec2::ZERO, left: DVec2::Y }];
        let (a, c) = (DVec2::new(-0.5, -0.1), DVec2::X);
        assert!((taut(a, &portals, c).unwrap() - (a.length() + 1.0)).abs() < 1e-15);
    }

    #[test]
    fn two_sides_of_a_cube_unfold_to_a_rectangle() {
        let topology = Topology::new(&shapes::cube());
        // The first face and whatever lies across each of its sides: the far corners' distance must agree with the angle.
        for k in 0..3 {
            let (other, side) = topology.across(0, k).unwrap();
            let mut from = [0.0; 3];
            from[(k + 2) % 3] = 1.0;
            let mut to = [0.0; 3];
            to[(side + 2) % 3] = 1.0;
            let (a, portals, c) =
                unfold(&topology, &[0, other], &[Passage { leave: k, enter: side }], from, to).unwrap();
            let share = |f: u32, k: usize| topology.places(f)[k];
            let p = [share(0, k), share(0, (k + 1) % 3), share(0, (k + 2) % 3), share(other, (side + 2) % 3)];
            let flat = [portals[0].right, portals[0].left, a, c];
            for (i, j) in [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3)] {
                assert!((flat[i].distance(flat[j]) - p[i].distance(p[j])).abs() < 1e-15);
            }
            assert!(a.y > 0.0 && c.y < 0.0);
        }
    }
}
