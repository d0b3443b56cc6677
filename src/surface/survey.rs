//! Counting what is wrong with welded triangles before anything is repaired.

use super::{FaceId, report::DropReason, weld::NOT_FINITE};

/// Faces that are kept, and those that are not.
pub(crate) struct Sifted {
    /// Welded corners of the faces that are kept.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Their input faces.
    pub(crate) faces: Vec<FaceId>,
    /// The others, with the reason.
    pub(crate) dropped: Vec<(FaceId, DropReason)>,
    /// Faces whose three corners an earlier face has too, in whatever order.
    pub(crate) duplicates: usize,
}

/// Drops faces that cannot be part of a surface: a corner that is not finite, a repeated corner, an earlier face's corners
/// in the same cyclic order.
pub(crate) fn sift(corners: impl Iterator<Item = [u32; 3]>, count: usize) -> Sifted {
    let mut out = Sifted {
        triangles: Vec::with_capacity(count),
        faces: Vec::with_capacity(count),
        dropped: Vec::new(),
        duplicates: 0,
    };
    let mut keys: Vec<([u32; 3], u32)> = Vec::with_capacity(count);
    for (i, t) in corners.enumerate() {
        let face = FaceId(i as u32);
        if t.contains(&NOT_FINITE) {
            out.dropped.push((face, DropReason::NotFinite));
        } else if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
            out.dropped.push((face, DropReason::RepeatedCorner));
        } else {
            let mut key = t;
            key.sort_unstable();
            keys.push((key, out.triangles.len() as u32));
            out.triangles.push(t);
            out.faces.push(face);
        }
    }
    super::sort::sort_distinct(&mut keys);
    let mut doubled = vec![false; out.triangles.len()];
    for run in keys.chunk_by(|a, b| a.0 == b.0) {
        out.duplicates += run.len() - 1;
        let mut seen = [false; 2];
        for &(key, i) in run {
            let turn = usize::from(is_odd(out.triangles[i as usize], key));
            doubled[i as usize] = seen[turn];
            seen[turn] = true;
        }
    }
    if out.duplicates > 0 {
        let mut keep = doubled.iter().map(|d| !d);
        let faces = &out.faces;
        out.dropped
            .extend(doubled.iter().zip(faces).filter(|(d, _)| **d).map(|(_, face)| (*face, DropReason::Duplicate)));
        out.triangles.retain(|_| keep.next().unwrap_or(true));
        let mut keep = doubled.iter().map(|d| !d);
        out.faces.retain(|_| keep.next().unwrap_or(true));
        out.dropped.sort_unstable_by_key(|d| d.0);
    }
    out
}

/// Whether `t` is an odd permutation of its sorted corners.
fn is_odd(t: [u32; 3], sorted: [u32; 3]) -> bool {
    let at = sorted.iter().position(|v| *v == t[0]).unwrap_or(0);
    t[1] != sorted[(at + 1) % 3]
}

/// Sets of things joined one pair at a time.
pub(crate) struct UnionFind(Vec<u32>);

impl UnionFind {
    pub(crate) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    pub(crate) fn find(&mut self, mut x: u32) -> u32 {
        while self.0[x as usize] != x {
            self.0[x as usize] = self.0[self.0[x as usize] as usize];
            x = self.0[x as usize];
        }
        x
    }

    pub(crate) fn union(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    pub(crate) fn is_root(&self, x: u32) -> bool {
        self.0[x as usize] == x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_copies_are_dropped_and_turned_ones_are_kept() {
        let sifted = sift([[0, 1, 2], [1, 2, 0], [0, 2, 1], [3, 3, 4], [5, NOT_FINITE, 4]].into_iter(), 5);
        assert_eq!(sifted.faces, [FaceId(0), FaceId(2)]);
        assert_eq!(sifted.duplicates, 2);
        assert_eq!(
            sifted.dropped,
            [
                (FaceId(1), DropReason::Duplicate),
                (FaceId(3), DropReason::RepeatedCorner),
                (FaceId(4), DropReason::NotFinite)
            ]
        );
    }
}
