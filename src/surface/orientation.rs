//! Turning faces so that neighbours agree, and cutting where they cannot.

use super::{FaceId, HalfEdge, NonOrientable, SurfaceError, adjacency::Adjacency, options::SurfaceOptions};

/// What orienting found and did.
pub(crate) struct Orientation {
    /// Faces to turn over.
    pub(crate) flip: Vec<bool>,
    /// The sheet (piece joined by sides) of each face.
    pub(crate) sheet: Vec<u32>,
    /// How many sheets there are.
    pub(crate) sheets: usize,
    /// Whether all neighbours agreed as given.
    pub(crate) consistent: bool,
    /// Edges where neighbours could not be made to agree; they were cut.
    pub(crate) cuts: usize,
}

/// Walks each sheet breadth first and gives every face a parity; the minority is to be flipped (ties keep the first face).
///
/// Edges whose faces need both parities are cut, which leaves an orientable surface with a seam.
///
/// # Errors
/// [`SurfaceError::NonOrientable`] where the options refuse such sheets.
pub(crate) fn orient(
    triangles: &[[u32; 3]],
    adjacency: &mut Adjacency,
    options: &SurfaceOptions,
) -> Result<Orientation, SurfaceError> {
    let faces = triangles.len();
    let mut out =
        Orientation { flip: vec![false; faces], sheet: vec![u32::MAX; faces], sheets: 0, consistent: true, cuts: 0 };
    let mut queue: Vec<u32> = Vec::new();
    for first in 0..faces as u32 {
        if out.sheet[first as usize] != u32::MAX {
            continue;
        }
        queue.clear();
        queue.push(first);
        let sheet = out.sheets as u32;
        out.sheets += 1;
        out.sheet[first as usize] = sheet;
        let mut flipped = 0;
        let mut head = 0;
        while let Some(&face) = queue.get(head) {
            head += 1;
            for k in 0..3 {
                let h = HalfEdge::new(face, k);
                let twin = adjacency.twins[face as usize][k as usize];
                if !twin.is_some() {
                    continue;
                }
                let clash = origin(triangles, h) == origin(triangles, twin);
                out.consistent &= !clash;
                let parity = out.flip[face as usize] ^ clash;
                let neighbour = twin.face() as usize;
                if out.sheet[neighbour] == u32::MAX {
                    out.sheet[neighbour] = sheet;
                    out.flip[neighbour] = parity;
                    flipped += usize::from(parity);
                    queue.push(neighbour as u32);
                } else if out.flip[neighbour] != parity {
                    if options.non_orientable == NonOrientable::Refuse {
                        return Err(SurfaceError::NonOrientable { face: FaceId(face) });
                    }
                    out.cuts += 1;
                    adjacency.twins[face as usize][k as usize] = HalfEdge::NONE;
                    adjacency.twins[neighbour][twin.side()] = HalfEdge::NONE;
                }
            }
        }
        if 2 * flipped > queue.len() {
            for &face in &queue {
                out.flip[face as usize] ^= true;
            }
        }
    }
    Ok(out)
}

fn origin(triangles: &[[u32; 3]], h: HalfEdge) -> u32 {
    triangles[h.face() as usize][h.side()]
}
