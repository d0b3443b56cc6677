//! Turning faces so that neighbours agree, and cutting where they cannot.

use super::{
    BuildProgress, FaceId, HalfEdge, NonOrientable, SurfaceError,
    adjacency::Adjacency,
    arranged::Arranged,
    options::SurfaceOptions,
    parallel::{self, PIECE},
    surface::DROPPED,
};

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
    /// Edges where neighbours could not be made to agree, by the two sides there; they were cut.
    pub(crate) cuts: Vec<[HalfEdge; 2]>,
}

/// Walks each sheet breadth first and gives every face a parity; the minority is to be flipped (ties keep the first face).
/// Sheets are numbered and begun in the order of the input, which `inner_of` gives.
///
/// Edges whose faces need both parities are cut, which leaves an orientable surface with a seam.
///
/// # Errors
/// [`SurfaceError::NonOrientable`] where the options refuse such sheets; [`SurfaceError::Cancelled`].
pub(crate) fn orient(
    arranged: &Arranged,
    adjacency: &mut Adjacency,
    inner_of: &[u32],
    options: &SurfaceOptions,
    progress: &BuildProgress,
) -> Result<Orientation, SurfaceError> {
    let triangles = &arranged.triangles;
    let faces = triangles.len();
    let mut out = Orientation {
        flip: vec![false; faces],
        sheet: vec![u32::MAX; faces],
        sheets: 0,
        consistent: true,
        cuts: Vec::new(),
    };
    let mut queue: Vec<u32> = Vec::new();
    for first in inner_of.iter().copied().filter(|inner| *inner != DROPPED) {
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
            if head % PIECE == 0 {
                progress.check()?;
            }
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
                        let face = FaceId(arranged.outer_of[face as usize]);
                        return Err(SurfaceError::NonOrientable { face });
                    }
                    out.cuts.push([h, twin]);
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

/// Turns the faces over that are to be flipped. Flipping swaps the second and third corner, so that side k becomes side
/// 2 − k.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn turn_over(
    flip: &[bool],
    triangles: &mut [[u32; 3]],
    twins: &mut [[HalfEdge; 3]],
    progress: &BuildProgress,
) -> Result<(), SurfaceError> {
    parallel::update(triangles, progress, |face, t| {
        if flip[face] {
            t.swap(1, 2);
        }
    })?;
    parallel::update(twins, progress, |face, row| {
        *row = row.map(|twin| turned(flip, twin));
        if flip[face] {
            row.swap(0, 2);
        }
    })
}

/// The name of a side after its face was turned over, if it was.
#[inline]
pub(crate) fn turned(flip: &[bool], h: HalfEdge) -> HalfEdge {
    if h.is_some() && flip[h.face() as usize] { HalfEdge::new(h.face(), 2 - h.side() as u32) } else { h }
}

fn origin(triangles: &[[u32; 3]], h: HalfEdge) -> u32 {
    triangles[h.face() as usize][h.side()]
}
