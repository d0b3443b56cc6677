//! The shortest line through a strip that was laid out in the plane: a string pulled taut.

use glam::DVec2;

use super::unfold::Unfolded;

/// A vertex at which the line bends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bend {
    /// One of the portals that end at the vertex.
    pub(super) portal: usize,
    pub(super) vertex: u32,
    pub(super) place: DVec2,
}

fn turn(origin: DVec2, a: DVec2, b: DVec2) -> f64 {
    (a - origin).perp_dot(b - origin)
}

/// Writes the bends of the shortest line, in order: the funnel that starts again at each of them.
pub(super) fn pull(unfolded: &Unfolded, bends: &mut Vec<Bend>) {
    bends.clear();
    let portals = &unfolded.portals;
    let mut apex = unfolded.start;
    let (mut left, mut right) = (portals[0].left, portals[0].right);
    let (mut left_at, mut right_at) = (0, 0);
    let mut i = 1;
    while i <= portals.len() {
        let (next_left, next_right) = portals.get(i).map_or((unfolded.end, unfolded.end), |p| (p.left, p.right));
        if turn(apex, right, next_right) >= 0.0 {
            if turn(apex, left, next_right) <= 0.0 {
                (right, right_at) = (next_right, i);
            } else {
                bends.push(Bend { portal: left_at, vertex: portals[left_at].left_vertex, place: left });
                (apex, right, right_at) = (left, left, left_at);
                i = left_at + 1;
                continue;
            }
        }
        if turn(apex, left, next_left) <= 0.0 {
            if turn(apex, right, next_left) >= 0.0 {
                (left, left_at) = (next_left, i);
            } else {
                bends.push(Bend { portal: right_at, vertex: portals[right_at].right_vertex, place: right });
                (apex, left, left_at) = (right, right, right_at);
                i = right_at + 1;
                continue;
            }
        }
        i += 1;
    }
}
