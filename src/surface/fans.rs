//! One vertex per fan of faces: finding fans, splitting vertices that have several.

use super::{
    BuildProgress, FaceId, HalfEdge, NonManifoldVertices, SurfaceError,
    arranged::Arranged,
    options::SurfaceOptions,
    parallel::{self, PIECE},
};

/// In place of a vertex that has no number yet.
const UNSEEN: u32 = u32::MAX;

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
    faces: &Arranged,
    twins: &[[HalfEdge; 3]],
    inner_of: &[u32],
    options: &SurfaceOptions,
    progress: &BuildProgress,
) -> Result<Fans, SurfaceError> {
    // First in the order of memory, where a fan's faces are near each other.
    let fans = find(faces, twins, options, progress)?;
    number_by_input(fans, inner_of, progress)
}

/// Fans numbered by first use in memory.
fn find(
    faces: &Arranged,
    twins: &[[HalfEdge; 3]],
    options: &SurfaceOptions,
    progress: &BuildProgress,
) -> Result<Fans, SurfaceError> {
    let vertices = faces.input_vertex.len();
    let mut out = Fans {
        triangles: vec![[UNSEEN; 3]; faces.triangles.len()],
        welded: Vec::with_capacity(vertices),
        outgoing: Vec::with_capacity(vertices),
    };
    let mut met = vec![false; vertices];
    for (face, corners) in faces.triangles.iter().enumerate() {
        if face % PIECE == 0 {
            progress.check()?;
        }
        for (corner, &welded) in corners.iter().enumerate() {
            if out.triangles[face][corner] != UNSEEN {
                continue;
            }
            if std::mem::replace(&mut met[welded as usize], true)
                && options.nonmanifold_vertices == NonManifoldVertices::Refuse
            {
                // Two are enough to refuse.
                return Err(SurfaceError::NonManifoldVertex { face: FaceId(faces.outer_of[face]), fans: 2 });
            }
            let id = out.welded.len() as u32;
            let name = |h: HalfEdge| out.triangles[h.face() as usize][h.side()] = id;
            out.outgoing.push(walk_fan(twins, HalfEdge::new(face as u32, corner as u32), name));
            out.welded.push(welded);
        }
    }
    Ok(out)
}

/// Renumbers vertices by their first use in input order, which is what [`VertexId`](super::VertexId) promises.
fn number_by_input(fans: Fans, inner_of: &[u32], progress: &BuildProgress) -> Result<Fans, SurfaceError> {
    let vertices = fans.welded.len();
    let mut number = vec![UNSEEN; vertices];
    let mut order = Vec::with_capacity(vertices);
    for (outer, &inner) in inner_of.iter().enumerate() {
        if outer % PIECE == 0 {
            progress.check()?;
        }
        // A dropped face has no place.
        for &v in fans.triangles.get(inner as usize).into_iter().flatten() {
            if number[v as usize] == UNSEEN {
                number[v as usize] = order.len() as u32;
                order.push(v);
            }
        }
    }
    let Fans { mut triangles, welded, outgoing } = fans;
    parallel::update(&mut triangles, progress, |_, t| *t = t.map(|v| number[v as usize]))?;
    let welded = parallel::table(vertices, 0, progress, |v| welded[order[v] as usize])?;
    let outgoing = parallel::table(vertices, HalfEdge::NONE, progress, |v| outgoing[order[v] as usize])?;
    Ok(Fans { triangles, welded, outgoing })
}

/// Visits the outgoing half-edges of a fan, each once, and returns the one to turn counter-clockwise from: the most
/// clockwise one at a boundary, else `start`.
fn walk_fan(twins: &[[HalfEdge; 3]], start: HalfEdge, mut visit: impl FnMut(HalfEdge)) -> HalfEdge {
    // Sides are linked in pairs, so turning is a permutation of corners: it ends at a boundary or comes back to its start.
    let mut h = start;
    while h.is_some() {
        visit(h);
        h = counter_clockwise(twins, h);
        if h == start {
            return start;
        }
    }
    let mut first = start;
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
