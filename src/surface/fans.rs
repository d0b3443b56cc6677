//! One vertex per fan of faces: finding fans, splitting vertices that have several.

use super::{
    BuildProgress, FaceId, HalfEdge, NonManifoldVertices, SurfaceError, options::SurfaceOptions, parallel::PIECE,
};

/// Corners grouped into fans.
pub(crate) struct Fans {
    /// Triangles with one vertex a fan, numbered by first use in the input.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The welded vertex each new vertex came from.
    pub(crate) welded: Vec<u32>,
    /// An outgoing half-edge of each vertex: the most clockwise one at a boundary, so that turning counter-clockwise from
    /// it meets all faces; elsewhere the first in memory.
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

/// Gives every fan of faces a vertex of its own. `inner_of` gives the input's order of faces.
///
/// # Errors
/// [`SurfaceError::NonManifoldVertex`] where the options refuse vertices with several fans; [`SurfaceError::Cancelled`].
pub(crate) fn split(
    triangles: &[[u32; 3]],
    twins: &[[HalfEdge; 3]],
    inner_of: &[u32],
    welded_count: usize,
    options: &SurfaceOptions,
    progress: &BuildProgress,
) -> Result<Fans, SurfaceError> {
    const UNSEEN: u32 = u32::MAX;
    let mut out = Fans {
        triangles: vec![[UNSEEN; 3]; triangles.len()],
        welded: Vec::with_capacity(welded_count),
        outgoing: Vec::with_capacity(welded_count),
    };
    let mut met = vec![false; welded_count];
    for (outer, &inner) in inner_of.iter().enumerate() {
        if outer % PIECE == 0 {
            progress.check()?;
        }
        let Some(&corners) = triangles.get(inner as usize) else { continue }; // dropped
        for (corner, &welded) in (0..3).zip(&corners) {
            if out.triangles[inner as usize][corner as usize] != UNSEEN {
                continue;
            }
            if std::mem::replace(&mut met[welded as usize], true)
                && options.nonmanifold_vertices == NonManifoldVertices::Refuse
            {
                // Two are enough to refuse.
                return Err(SurfaceError::NonManifoldVertex { face: FaceId(outer as u32), fans: 2 });
            }
            let id = out.welded.len() as u32;
            let name = |h: HalfEdge| out.triangles[h.face() as usize][h.side()] = id;
            out.outgoing.push(walk_fan(twins, HalfEdge::new(inner, corner), name));
            out.welded.push(welded);
        }
    }
    out.welded.shrink_to_fit();
    out.outgoing.shrink_to_fit();
    Ok(out)
}

/// Visits the outgoing half-edges of a fan, each once, and returns the one to turn counter-clockwise from.
fn walk_fan(twins: &[[HalfEdge; 3]], start: HalfEdge, mut visit: impl FnMut(HalfEdge)) -> HalfEdge {
    // Sides are linked in pairs, so turning is a permutation of corners: it ends at a boundary or comes back to its start.
    let (mut first, mut h) = (start, start);
    loop {
        visit(h);
        first = first.min(h);
        h = counter_clockwise(twins, h);
        if h == start {
            return first;
        }
        if !h.is_some() {
            break;
        }
    }
    first = start;
    while let before = clockwise(twins, first)
        && before.is_some()
    {
        visit(before);
        first = before;
    }
    first
}

/// Counts boundary loops by following boundary sides from vertex to vertex.
pub(crate) fn boundary_loops(fans: &Fans, boundary: &[bool]) -> usize {
    let mut left = boundary.to_vec();
    let mut loops = 0;
    for start in 0..boundary.len() {
        loops += usize::from(left[start]);
        let mut v = start;
        while std::mem::replace(&mut left[v], false) {
            // A fan has one boundary side that leaves it, and that is the most clockwise.
            let h = fans.outgoing[v].next();
            v = fans.triangles[h.face() as usize][h.side()] as usize;
        }
    }
    loops
}

/// Whether each vertex lies on the boundary: there its outgoing half-edge is open.
pub(crate) fn boundary(outgoing: &[HalfEdge], twins: &[[HalfEdge; 3]]) -> Vec<bool> {
    outgoing.iter().map(|h| !twins[h.face() as usize][h.side()].is_some()).collect()
}
