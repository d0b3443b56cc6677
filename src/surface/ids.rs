//! Names of faces, vertices and, inside the crate, half-edges.

use std::fmt;

/// A face of the **input** mesh, counted from zero in input order.
///
/// Faces are reordered and sometimes flipped inside a [`Surface`](super::Surface); none of that shows in a `FaceId`:
/// number and corners are those of the mesh that was given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct FaceId(pub u32);

/// A vertex of the surface after welding and splitting.
///
/// Vertices with one position are one `VertexId`; a non-manifold vertex becomes several. Numbers follow the first use in
/// the input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct VertexId(pub u32);

impl fmt::Display for FaceId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "face {}", self.0)
    }
}

impl fmt::Display for VertexId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "vertex {}", self.0)
    }
}

/// A directed side of an inner face, packed as `face << 2 | side`.
///
/// Side `k` of a face with corners `(v0, v1, v2)` runs from `v_k` to `v_{k+1}`; the face lies on its left.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct HalfEdge(pub(crate) u32);

impl HalfEdge {
    /// "No neighbour": the side lies on the boundary.
    pub(crate) const NONE: Self = Self(u32::MAX);

    #[inline]
    pub(crate) const fn new(face: u32, side: u32) -> Self {
        Self(face << 2 | side)
    }

    #[inline]
    pub(crate) const fn face(self) -> u32 {
        self.0 >> 2
    }

    #[inline]
    pub(crate) const fn side(self) -> usize {
        (self.0 & 3) as usize
    }

    /// Sparse index `4 · face + side`.
    #[inline]
    pub(crate) const fn bits(self) -> usize {
        self.0 as usize
    }

    /// Dense index `3 · face + side`, for arrays with one entry a half-edge.
    #[inline]
    pub(crate) const fn index(self) -> usize {
        (self.0 - (self.0 >> 2)) as usize
    }

    /// The side that follows counter-clockwise in the same face.
    #[inline]
    pub(crate) const fn next(self) -> Self {
        Self(if self.0 & 3 == 2 { self.0 - 2 } else { self.0 + 1 })
    }

    /// The side that precedes counter-clockwise in the same face.
    #[inline]
    pub(crate) const fn prev(self) -> Self {
        Self(if self.0 & 3 == 0 { self.0 + 2 } else { self.0 - 1 })
    }

    #[inline]
    pub(crate) const fn is_some(self) -> bool {
        self.0 != u32::MAX
    }
}

impl fmt::Debug for HalfEdge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_some() { write!(f, "{}/{}", self.face(), self.side()) } else { f.write_str("none") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_go_round() {
        for k in 0..3 {
            let h = HalfEdge::new(7, k);
            assert_eq!(h.next().prev(), h);
            assert_eq!(h.next().next().next(), h);
            assert_eq!(h.index(), 21 + k as usize);
            assert_eq!((h.face(), h.side()), (7, k as usize));
        }
    }
}
