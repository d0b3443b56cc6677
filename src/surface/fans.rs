//! One vertex per fan of faces: finding fans, splitting vertices that have several.

use super::{FaceId, HalfEdge, NonManifoldVertices, SurfaceError, options::SurfaceOptions};

/// Corners grouped into fans.
pub(crate) struct Fans {
    /// Triangles with one vertex a fan, numbered by first use.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The welded vertex each new vertex came from.
    pub(crate) welded: Vec<u32>,
    /// An outgoing half-edge of each vertex: the most clockwise one at a boundary, so that turning counter-clockwise from
    /// it meets all faces.
    pub(crate) outgoing: Vec<HalfEdge>,
}

/// The next outgoing half-edge counter-clockwise about the same origin, or [`HalfEdge::NONE`] at the boundary.
#[inline]
pub(crate) fn counter_clockwise(twins: &[[HalfEdge; 3]], h: HalfEdge) -> HalfEdge {
    let side = h.prev();
    twins[side.face() as usize][side.side()]
}

/// The next outgoing half-edge clockwise about the same origin, or [`HalfEdge::NONE`] at the boundary.
#[inline]
pub(crate) fn clockwise(twins: &[[HalfEdge; 3]], h: HalfEdge) -> HalfEdge {
    let twin = twins[h.face() as usize][h.side()];
    if twin.is_some() { twin.next() } else { HalfEdge::NONE }
}

/// Gives every fan of faces a vertex of its own.
///
/// # Errors
/// [`SurfaceError::NonManifoldVertex`] where the options refuse vertices with several fans.
pub(crate) fn split(
    triangles: &[[u32; 3]],
    twins: &[[HalfEdge; 3]],
    welded_count: usize,
    options: &SurfaceOptions,
) -> Result<Fans, SurfaceError> {
    const UNSEEN: u32 = u32::MAX;
    let mut out = Fans { triangles: vec![[UNSEEN; 3]; triangles.len()], welded: Vec::new(), outgoing: Vec::new() };
    let mut fans_of = vec![0_u32; welded_count];
    for (face, corners) in triangles.iter().enumerate() {
        for (corner, &welded) in corners.iter().enumerate() {
            if out.triangles[face][corner] != UNSEEN {
                continue;
            }
            let start = HalfEdge::new(face as u32, corner as u32);
            // Turn clockwise to the boundary, or once around. Sides are linked in pairs, so turning is a permutation of
            // corners and comes back to its start.
            let mut first = start;
            loop {
                let before = clockwise(twins, first);
                if !before.is_some() || before == start {
                    break;
                }
                first = before;
            }
            if clockwise(twins, first).is_some() {
                first = start;
            }
            let id = out.welded.len() as u32;
            out.welded.push(welded);
            out.outgoing.push(first);
            let mut h = first;
            loop {
                out.triangles[h.face() as usize][h.side()] = id;
                h = counter_clockwise(twins, h);
                if !h.is_some() || h == first {
                    break;
                }
            }
            fans_of[welded as usize] += 1;
            if fans_of[welded as usize] > 1 && options.nonmanifold_vertices == NonManifoldVertices::Refuse {
                return Err(SurfaceError::NonManifoldVertex {
                    face: FaceId(face as u32),
                    fans: fans_of[welded as usize] as usize,
                });
            }
        }
    }
    Ok(out)
}

/// Counts boundary loops by following boundary sides; `twins` must be consistently oriented.
pub(crate) fn boundary_loops(twins: &[[HalfEdge; 3]]) -> usize {
    let mut seen = vec![false; twins.len() * 3];
    let mut loops = 0;
    for face in 0..twins.len() as u32 {
        for k in 0..3 {
            let start = HalfEdge::new(face, k);
            if twins[face as usize][k as usize].is_some() || seen[start.index()] {
                continue;
            }
            loops += 1;
            let mut h = start;
            while !seen[h.index()] {
                seen[h.index()] = true;
                // The next boundary side leaves from this one's target: turn clockwise-outward until a side is open.
                h = h.next();
                while let twin = twins[h.face() as usize][h.side()]
                    && twin.is_some()
                {
                    h = twin.next();
                }
            }
        }
    }
    loops
}
