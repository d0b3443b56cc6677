//! Where one stretch of a path ends and the next begins.

use super::{Fault, Stretch, plane::Passage, topology::Topology};

/// How far weights may be off.
pub(crate) const WEIGHT: f64 = 1e-9;
/// A crossing this near to an end of its side (in shares of the side) passes through the vertex.
pub(crate) const AT_VERTEX: f64 = 1e-12;
/// A crossing this near to an end of its side is looked at together with its neighbours about the same vertex.
const NEAR_VERTEX: f64 = 1e-6;

/// How a path goes from one stretch to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Joint {
    /// It stays in the face.
    Inside,
    /// It crosses a side.
    Across(Passage),
    /// It changes to some other face of the fan about a vertex.
    Corner,
}

/// A joint, with the vertex that it is near to, if any, and how near (in shares of the side or face).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Located {
    pub(crate) joint: Joint,
    pub(crate) near: Option<(u32, f64)>,
}

/// Finds how `before` goes over into `after`.
///
/// # Errors
/// [`Fault::Torn`] unless the two meet in one place of a face, of a side with exactly these two faces, or of a vertex about
/// which one can turn from one face to the other.
pub(crate) fn locate(topology: &Topology, at: usize, before: &Stretch, after: &Stretch) -> Result<Located, Fault> {
    let (p, q) = (before.to, after.from);
    if before.face == after.face {
        let apart = (0..3).any(|k| (p[k] - q[k]).abs() > WEIGHT);
        return if apart { Err(Fault::Torn { joint: at }) } else { Ok(inside(topology, before.face, p)) };
    }
    let corners = topology.corners[before.face as usize];
    for leave in 0..3 {
        let (k, l, m) = (leave, (leave + 1) % 3, (leave + 2) % 3);
        let Some((face, enter)) = topology.across(before.face, leave) else { continue };
        if face != after.face || p[m].abs() > WEIGHT || q[(enter + 2) % 3].abs() > WEIGHT {
            continue;
        }
        let same_way = topology.corners[face as usize][enter] == corners[k];
        let (a, b) = if same_way { (enter, (enter + 1) % 3) } else { ((enter + 1) % 3, enter) };
        if (p[k] - q[a]).abs() <= WEIGHT && (p[l] - q[b]).abs() <= WEIGHT {
            let near = if p[l] <= NEAR_VERTEX {
                Some((corners[k], p[l].abs()))
            } else if p[k] <= NEAR_VERTEX {
                Some((corners[l], p[k].abs()))
            } else {
                None
            };
            return Ok(Located { joint: Joint::Across(Passage { leave, enter }), near });
        }
    }
    for (k, &vertex) in corners.iter().enumerate().filter(|(k, _)| p[*k] >= 1.0 - WEIGHT) {
        let other = topology.corner_of(after.face, vertex);
        if other.is_some_and(|j| q[j] >= 1.0 - WEIGHT) && topology.same_fan(vertex, before.face, after.face) {
            return Ok(Located { joint: Joint::Corner, near: Some((vertex, 1.0 - p[k].min(1.0))) });
        }
    }
    Err(Fault::Torn { joint: at })
}

fn inside(topology: &Topology, face: u32, weights: [f64; 3]) -> Located {
    let near = (0..3).find(|k| weights[*k] >= 1.0 - NEAR_VERTEX);
    let near = near.map(|k| (topology.corners[face as usize][k], 1.0 - weights[k].min(1.0)));
    Located { joint: Joint::Inside, near }
}

/// Whether two spellings name one place: in one face, on a side that just these two faces share, or at a vertex about
/// which one can turn from one face to the other.
pub(crate) fn same_place(topology: &Topology, a: (u32, [f64; 3]), b: (u32, [f64; 3])) -> bool {
    let spot = |(face, weights)| Stretch { face, from: weights, to: weights };
    topology.has(a.0) && topology.has(b.0) && locate(topology, 0, &spot(a), &spot(b)).is_ok()
}
