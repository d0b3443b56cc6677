//! Which faces can be part of a surface.

use std::collections::HashSet;

use glam::DVec3;

use super::{
    BuildProgress, FaceId, SurfaceError, TriangleMesh, parallel,
    report::DropReason,
    weld::{NOT_FINITE, without_negative_zero},
};

/// Faces that are kept, and those that are not.
pub(crate) struct Sifted {
    /// Input faces that are kept, in order.
    pub(crate) kept: Vec<u32>,
    /// The others, in order, with the reason.
    pub(crate) dropped: Vec<(FaceId, DropReason)>,
    /// Lower and upper corner of the kept faces' bounding box.
    pub(crate) min: DVec3,
    pub(crate) max: DVec3,
}

/// Drops faces with a corner that is not finite, or with a repeated corner.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn sift(mesh: &TriangleMesh, welded: &[u32], progress: &BuildProgress) -> Result<Sifted, SurfaceError> {
    let empty = |capacity| Sifted {
        kept: Vec::with_capacity(capacity),
        dropped: Vec::new(),
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };
    let pieces = parallel::map_pieces(mesh.faces.len(), progress, |faces| {
        let mut out = empty(faces.len());
        for face in faces {
            let corners = mesh.faces[face];
            match flaw(corners.map(|v| welded[v as usize])) {
                Some(reason) => out.dropped.push((FaceId(face as u32), reason)),
                None => {
                    out.kept.push(face as u32);
                    for p in corners.map(|v| without_negative_zero(mesh.positions[v as usize])) {
                        (out.min, out.max) = (out.min.min(p), out.max.max(p));
                    }
                }
            }
        }
        out
    })?;
    Ok(pieces.into_iter().fold(empty(mesh.faces.len()), |mut all, piece| {
        all.kept.extend(piece.kept);
        all.dropped.extend(piece.dropped);
        Sifted { min: all.min.min(piece.min), max: all.max.max(piece.max), ..all }
    }))
}

fn flaw(corners: [u32; 3]) -> Option<DropReason> {
    let [a, b, c] = corners;
    if corners.contains(&NOT_FINITE) {
        Some(DropReason::NotFinite)
    } else {
        (a == b || b == c || c == a).then_some(DropReason::RepeatedCorner)
    }
}

/// Faces that have their three corners in common with others.
pub(crate) struct Copies {
    /// Faces whose three corners an earlier face of the input has too, in whatever order.
    pub(crate) duplicates: usize,
    /// Those that have them in the same cyclic order as the earlier face.
    pub(crate) superfluous: HashSet<u32>,
}

/// Looks through groups of faces that have the same corners each; the earliest in `outer_of` of each orientation stays.
pub(crate) fn copies(groups: &mut [Vec<u32>], triangles: &[[u32; 3]], outer_of: &[u32]) -> Copies {
    let mut out = Copies { duplicates: 0, superfluous: HashSet::new() };
    for group in groups {
        group.sort_unstable_by_key(|face| outer_of[*face as usize]);
        out.duplicates += group.len() - 1;
        let mut seen = [false; 2];
        for &face in group.iter() {
            let turn = usize::from(is_odd(triangles[face as usize]));
            if std::mem::replace(&mut seen[turn], true) {
                out.superfluous.insert(face);
            }
        }
    }
    out
}

/// Whether going round the corners, from the smallest, meets the largest before the middle one.
fn is_odd([a, b, c]: [u32; 3]) -> bool {
    let [_, second, third] = if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    };
    second > third
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_with_missing_or_repeated_corners_are_dropped() {
        let positions = (0..6).map(|i| DVec3::splat(f64::from(i))).collect();
        let mesh = TriangleMesh { positions, faces: vec![[3, 3, 4], [0, 1, 2], [5, 2, 4], [0, 2, 1], [1, 2, 4]] };
        let welded = [0, 1, 2, 3, 0, NOT_FINITE];
        let sifted = sift(&mesh, &welded, &BuildProgress::default()).unwrap();
        assert_eq!(sifted.kept, [1, 3, 4]);
        assert_eq!(sifted.dropped, [(FaceId(0), DropReason::RepeatedCorner), (FaceId(2), DropReason::NotFinite)]);
        assert_eq!((sifted.min, sifted.max), (DVec3::ZERO, DVec3::splat(4.0)));
    }

    #[test]
    fn later_copies_are_superfluous_and_turned_ones_are_not() {
        let triangles = [[1, 2, 0], [0, 1, 2], [0, 2, 1], [2, 1, 0], [3, 4, 5]];
        let copies = copies(&mut [vec![0, 1, 2, 3]], &triangles, &[7, 1, 2, 0, 4]);
        assert_eq!(copies.duplicates, 3);
        assert_eq!(copies.superfluous, HashSet::from([0, 2]));
    }
}
