//! A tree of boxes over the faces: what a ray hits, and what lies closest to a point.
//!
//! The faces come sorted along a Morton curve, so every node is a range of consecutive faces: the tree permutes
//! nothing, and a leaf reads neighbouring memory. Where a range is cut is decided by the surface area heuristic over
//! all its cuts (MacDonald & Booth 1990). Faces in another order give a slower tree and the same answers.
//!
//! Boxes are `f32` in a frame where the mesh spans about −1 to 1; all else is `f64`. Three things make every box
//! conservative, so that answers do not depend on the tree: the frame's scale is a power of two (exact), boxes are
//! larger than their faces by [`BOX_PAD`], and each query widens them by what its own arithmetic can lose
//! ([`Frame::pad`]).

use glam::{DVec3, Vec3, Vec3Swizzles};

use super::{ArrayMemory, BuildProgress, SurfaceError, memory, parallel};

mod closest;
mod ray;
mod refit;
mod split;

/// Most faces in a leaf.
const LEAF: usize = 4;
/// Most nodes on a way from the root to a leaf, 2^30 faces included; bounds the stack of a query.
const MAX_DEPTH: usize = 64;
/// In place of a leaf's face count: the child is a node.
const NODE: u32 = u32::MAX;
/// Boxes are larger than their faces by this on every side: 2^−23, twice the rounding of a number below 2 to `f32`.
const BOX_PAD: f64 = 1.0 / 8_388_608.0;

/// A bounding volume hierarchy over the triangles of a mesh.
///
/// It holds no geometry: every call takes the positions and triangles that it was built with.
/// Triangles that do not exist, or whose corners do not, are passed over. 64 bytes a node, about one node for every two
/// or three faces. Queries allocate nothing.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    frame: Frame,
    /// Parents before their children; the root first.
    nodes: Vec<Node>,
}

impl Bvh {
    /// Builds the tree. O(F log F) for faces in Morton order (0.3 s for 1.3 M on one thread), at most O([`MAX_DEPTH`] · F)
    /// for any. The same tree on however many threads.
    ///
    /// # Errors
    /// [`SurfaceError::Cancelled`].
    pub(crate) fn build(
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        progress: &BuildProgress,
    ) -> Result<Self, SurfaceError> {
        let frame = Frame::around(positions, triangles, progress)?;
        let bounds = |face: usize| frame.bounds(positions, triangles, face as u32);
        let bounds = parallel::table(triangles.len(), Bounds::EMPTY, progress, bounds)?;
        Ok(Self { frame, nodes: split::nodes(bounds, MAX_DEPTH as u32, progress)? })
    }

    /// What the tree holds in memory.
    pub(crate) fn memory(&self) -> ArrayMemory {
        memory::array("tree of boxes", &self.nodes)
    }

    /// Visits the faces of all boxes that are not beyond a limit, nearer boxes first.
    ///
    /// `near` bounds from below what `test` can find in a box, or is NaN if that is nothing; `test` gets a face and the
    /// limit, and returns the limit from there on, which is no NaN.
    #[inline]
    fn walk(&self, mut limit: f64, near: impl Fn(&Bounds) -> f64, mut test: impl FnMut(u32, f64) -> f64) {
        // A node takes one entry off and puts at most two on, so that the way down to a leaf leaves one a node.
        let mut stack = [(0.0, 0, NODE); MAX_DEPTH + 1];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (at_least, first, count) = stack[height];
            if at_least > limit {
                continue;
            }
            if count != NODE {
                for face in first..first + count {
                    limit = test(face, limit);
                }
                continue;
            }
            let [left, right] = &self.nodes[first as usize].0;
            let (near_left, near_right) = (near(&left.bounds), near(&right.bounds));
            let mut push = |at_least: f64, child: &Child| {
                if at_least <= limit {
                    stack[height] = (at_least, child.first, child.count);
                    height += 1;
                }
            };
            if near_right < near_left {
                push(near_left, left);
                push(near_right, right);
            } else {
                push(near_right, right);
                push(near_left, left);
            }
        }
    }
}

/// Two children side by side: one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Node([Child; 2]);

/// A leaf of the faces `first .. first + count`, or, with `count` = [`NODE`], the node `first`.
#[derive(Clone, Copy, Debug)]
struct Child {
    bounds: Bounds,
    first: u32,
    count: u32,
}

#[cfg(test)]
impl Child {
    fn faces(&self) -> std::ops::Range<u32> {
        self.first..self.first + self.count
    }
}

/// A box in the tree's frame.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    min: Vec3,
    max: Vec3,
}

impl Bounds {
    const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    #[inline]
    fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Half the surface area.
    #[inline]
    fn area(&self) -> f32 {
        let size = self.max - self.min;
        size.dot(size.yzx())
    }

    /// Squared distance from a place to the box widened by `pad`.
    #[inline]
    fn distance_squared(&self, at: DVec3, pad: f64) -> f64 {
        let outside = (self.min.as_dvec3() - at).max(at - self.max.as_dvec3()) - DVec3::splat(pad);
        outside.max(DVec3::ZERO).length_squared()
    }
}

/// The corners of a box around nothing.
const NOWHERE: (DVec3, DVec3) = (DVec3::INFINITY, DVec3::NEG_INFINITY);

/// The coordinates in which boxes are kept: from the mesh's centre, in units of a power of two near half its extent.
#[derive(Clone, Copy, Debug)]
struct Frame {
    centre: DVec3,
    /// What a length is multiplied with.
    scale: f64,
}

impl Frame {
    fn around(positions: &[DVec3], triangles: &[[u32; 3]], progress: &BuildProgress) -> Result<Self, SurfaceError> {
        // Corners, not all positions: unused ones may lie anywhere.
        let pieces = parallel::map_pieces(triangles.len(), progress, |faces| {
            let corners = triangles[faces].as_flattened().iter().filter_map(|index| positions.get(*index as usize));
            corners.fold(NOWHERE, |(min, max), &p| (min.min(p), max.max(p)))
        })?;
        let (min, max) = pieces.into_iter().fold(NOWHERE, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        Ok(Self::of_box(min, max))
    }

    fn of_box(min: DVec3, max: DVec3) -> Self {
        // Halves first: the sum of two large coordinates may overflow.
        let (centre, half) = (min * 0.5 + max * 0.5, (max * 0.5 - min * 0.5).max_element());
        if !centre.is_finite() || !(1e-200..1e300).contains(&half) {
            // No faces, one place, or nothing that arithmetic could save.
            return Self { centre: if centre.is_finite() { centre } else { DVec3::ZERO }, scale: 1.0 };
        }
        // The exponent bits of 2^−e, where half is in [2^e, 2^(e + 1)).
        Self { centre, scale: f64::from_bits((2046 - (half.to_bits() >> 52)) << 52) }
    }

    /// A place in the frame; `None` if squares would leave the range of `f64`.
    fn place(&self, p: DVec3) -> Option<DVec3> {
        let at = (p - self.centre) * self.scale;
        (at.abs().max_element() < 1e150 && at.is_finite()).then_some(at)
    }

    /// A greatest distance in the frame's unit; `None` if negative or NaN (−1e-320 must not become −0).
    fn limit(&self, max_distance: f64) -> Option<f64> {
        (max_distance >= 0.0).then_some(max_distance * self.scale)
    }

    /// What a query from `at` may lose to rounding, in every coordinate.
    ///
    /// Differences of a corner and `at` are at most |at| + 4 long, and a query's results are a dozen rounded operations
    /// away from those; 64 ulp cover them.
    fn pad(&self, at: DVec3) -> f64 {
        64.0 * f64::EPSILON * (at.length() + 4.0)
    }

    /// The box of a face, larger by [`BOX_PAD`].
    #[inline]
    fn bounds(&self, positions: &[DVec3], triangles: &[[u32; 3]], face: u32) -> Bounds {
        let Some([a, b, c]) = corners(positions, triangles, face) else { return Bounds::EMPTY };
        let min = (a.min(b).min(c) - self.centre) * self.scale;
        let max = (a.max(b).max(c) - self.centre) * self.scale;
        Bounds { min: (min - DVec3::splat(BOX_PAD)).as_vec3(), max: (max + DVec3::splat(BOX_PAD)).as_vec3() }
    }
}

/// The corners of a face, if they exist.
#[inline]
fn corners(positions: &[DVec3], triangles: &[[u32; 3]], face: u32) -> Option<[DVec3; 3]> {
    let [a, b, c] = *triangles.get(face as usize)?;
    Some([*positions.get(a as usize)?, *positions.get(b as usize)?, *positions.get(c as usize)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions and triangles.
    pub(super) type Mesh = (Vec<DVec3>, Vec<[u32; 3]>);

    pub(super) fn tree(mesh: &Mesh) -> Bvh {
        Bvh::build(&mesh.0, &mesh.1, &BuildProgress::default()).unwrap()
    }

    /// Splitmix64.
    pub(super) struct Random(pub(super) u64);

    impl Random {
        /// Uniform in −1 to 1.
        pub(super) fn number(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        pub(super) fn place(&mut self) -> DVec3 {
            DVec3::new(self.number(), self.number(), self.number())
        }
    }

    /// Triangles of many sizes all over the cube −1 to 1, in no order; every seventh has no area.
    pub(super) fn soup(faces: usize, random: &mut Random) -> Mesh {
        let mut mesh = Mesh::default();
        for face in 0..faces {
            let (at, size) = (random.place(), 0.02 + 0.3 * random.number().powi(4));
            let (side, other) = (random.place() * size, random.place() * size);
            let other = match face % 21 {
                0 => side * 0.3,
                7 => DVec3::ZERO,
                14 => side,
                _ => other,
            };
            let first = mesh.0.len() as u32;
            mesh.0.extend([at, at + side, at + other]);
            mesh.1.push([first, first + 1, first + 2]);
        }
        mesh
    }

    /// A unit sphere: the octahedron, each face cut into four `levels` times, in the order of cutting.
    pub(super) fn sphere(levels: u32) -> Mesh {
        let positions = vec![DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
        let triangles = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
        let mut mesh = (positions, triangles);
        for _ in 0..levels {
            let mut middles = std::collections::HashMap::new();
            let (mut positions, mut finer) = (mesh.0, Vec::new());
            for [a, b, c] in mesh.1 {
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(i, j)| {
                    *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                        positions.push((positions[i as usize] + positions[j as usize]).normalize());
                        positions.len() as u32 - 1
                    })
                });
                finer.extend([[a, ab, ca], [ab, b, bc], [ab, bc, ca], [ca, bc, c]]);
            }
            mesh = (positions, finer);
        }
        mesh
    }

    /// The same mesh elsewhere and in another size.
    pub(super) fn moved((positions, triangles): &Mesh, scale: f64, by: DVec3) -> Mesh {
        (positions.iter().map(|p| *p * scale + by).collect(), triangles.clone())
    }

    /// Every box against the corners below it, and the depth.
    fn check_boxes(bvh: &Bvh, mesh: &Mesh, node: u32, outer: Bounds, depth: usize) -> usize {
        let (positions, triangles) = mesh;
        assert!(depth <= MAX_DEPTH);
        let inside = |inner: &Bounds| outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all();
        let mut faces = 0;
        for child in &bvh.nodes[node as usize].0 {
            assert!(inside(&child.bounds));
            if child.count == NODE {
                faces += check_boxes(bvh, mesh, child.first, child.bounds, depth + 1);
                continue;
            }
            faces += child.faces().len();
            for p in child.faces().flat_map(|face| corners(positions, triangles, face).unwrap()) {
                let at = bvh.frame.place(p).unwrap();
                let (min, max) = (child.bounds.min.as_dvec3(), child.bounds.max.as_dvec3());
                assert!(min.cmplt(at).all() && max.cmpgt(at).all(), "{at} is outside {min}..{max}");
            }
        }
        faces
    }

    const EVERYWHERE: Bounds = Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };

    #[test]
    fn boxes_hold_their_faces() {
        let mut random = Random(1);
        let soup = soup(300, &mut random);
        for (scale, by) in [(1.0, DVec3::ZERO), (1e-3, DVec3::splat(1e6)), (1e60, DVec3::ZERO), (1e-60, DVec3::ZERO)] {
            let mesh = moved(&soup, scale, by);
            let bvh = tree(&mesh);
            assert_eq!(check_boxes(&bvh, &mesh, 0, EVERYWHERE, 1), 300);
        }
    }

    #[test]
    fn nothing_panics() {
        let odd = [0.0, 1.0, -1e-320, 1e60, -1e308, f64::INFINITY, f64::NAN];
        let mut meshes = vec![Mesh::default(), (Vec::new(), vec![[0, 1, 2]])];
        for x in odd {
            for y in odd {
                let positions = vec![DVec3::new(x, y, 1.0), DVec3::splat(x), DVec3::new(1.0, x, y), DVec3::ZERO];
                meshes.push((positions, vec![[0, 1, 2], [3, 2, 1], [0, 0, 0], [0, 3, 9], [1, 2, 0], [3, 3, 1]]));
            }
        }
        for (positions, triangles) in &meshes {
            let bvh = Bvh::build(positions, triangles, &BuildProgress::default()).unwrap();
            for (x, y) in odd.iter().flat_map(|x| odd.map(|y| (*x, y))) {
                let (p, d) = (DVec3::new(x, y, 0.3), DVec3::new(y, x, x));
                let hit = bvh.ray(positions, triangles, p, d, y);
                assert!(hit.is_none_or(|hit| hit.weights.iter().all(|w| *w >= 0.0)), "{hit:?}");
                bvh.ray_all(positions, triangles, p, d, y, &mut |hit| assert!(hit.distance >= 0.0));
                let closest = bvh.closest(positions, triangles, p, y);
                assert!(closest.is_none_or(|c| c.weights.iter().all(|w| *w >= 0.0)), "{closest:?}");
                if !p.is_finite() || y.is_nan() || y < 0.0 {
                    assert!(hit.is_none() && closest.is_none());
                }
            }
        }
    }
}
