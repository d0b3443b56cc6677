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

use std::ops::Range;

use glam::{DVec3, Vec3, Vec3Swizzles};

mod closest;
mod ray;

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
    /// Builds the tree. O(F log F) for faces in Morton order (0.3 s for 1.3 M), at most O([`MAX_DEPTH`] · F) for any.
    pub(crate) fn build(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let frame = Frame::around(positions, triangles);
        let faces = 0..triangles.len();
        let bounds: Vec<Bounds> = faces.clone().map(|face| frame.bounds(positions, triangles, face as u32)).collect();
        let mut splitter = Splitter { areas_right: vec![0.0; bounds.len()], bounds, nodes: Vec::new() };
        splitter.node(faces, MAX_DEPTH as u32);
        let mut bvh = Self { frame, nodes: splitter.nodes };
        bvh.fit_boxes(positions, triangles);
        bvh
    }

    fn fit_boxes(&mut self, positions: &[DVec3], triangles: &[[u32; 3]]) {
        // Children stand behind their parent, so that going backwards meets them first.
        for at in (0..self.nodes.len()).rev() {
            let fitted = self.nodes[at].0.map(|child| {
                let bounds = if child.count == NODE {
                    let [left, right] = &self.nodes[child.first as usize].0;
                    left.bounds.union(right.bounds)
                } else {
                    let bounds = child.faces().map(|face| self.frame.bounds(positions, triangles, face));
                    bounds.fold(Bounds::EMPTY, Bounds::union)
                };
                Child { bounds, ..child }
            });
            self.nodes[at] = Node(fitted);
        }
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

impl Child {
    fn faces(&self) -> Range<u32> {
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

/// The coordinates in which boxes are kept: from the mesh's centre, in units of a power of two near half its extent.
#[derive(Clone, Copy, Debug)]
struct Frame {
    centre: DVec3,
    /// What a length is multiplied with.
    scale: f64,
}

impl Frame {
    fn around(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        // Corners, not all positions: unused ones may lie anywhere.
        for &index in triangles.as_flattened() {
            if let Some(&p) = positions.get(index as usize) {
                (min, max) = (min.min(p), max.max(p));
            }
        }
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

/// Cuts ranges of faces into nodes.
struct Splitter {
    bounds: Vec<Bounds>,
    /// For every cut of the range at hand, the area of the box on its right.
    areas_right: Vec<f32>,
    nodes: Vec<Node>,
}

impl Splitter {
    /// Makes the node of a range, with its subtree below it, at most `levels` nodes deep; the boxes stay empty.
    fn node(&mut self, range: Range<usize>, levels: u32) -> u32 {
        let at = self.nodes.len();
        self.nodes.push(Node([Child { bounds: Bounds::EMPTY, first: 0, count: 0 }; 2]));
        let cut = self.cut(range.clone(), levels);
        let children = [range.start..cut, cut..range.end].map(|part| {
            let (first, count) = if part.len() <= LEAF {
                (part.start as u32, part.len() as u32)
            } else {
                (self.node(part, levels - 1), NODE)
            };
            Child { bounds: Bounds::EMPTY, first, count }
        });
        self.nodes[at] = Node(children);
        at as u32
    }

    /// Where to cut a range: least sum of area · faces of the two boxes, or the middle if the levels would not suffice.
    fn cut(&mut self, range: Range<usize>, levels: u32) -> usize {
        let middle = range.start + range.len() / 2;
        // Halving needs this many levels below; a heuristic cut may take all the faces but one along.
        let needed = range.len().div_ceil(LEAF).next_power_of_two().ilog2();
        if needed >= levels || range.len() <= 2 {
            return middle;
        }
        let bounds = &self.bounds[range.clone()];
        let areas_right = &mut self.areas_right[range.clone()];
        let mut right = Bounds::EMPTY;
        for (area, face) in areas_right.iter_mut().zip(bounds).rev() {
            right = right.union(*face);
            *area = right.area();
        }
        let half = bounds.len() / 2;
        let (mut best, mut least) = (half, f32::INFINITY);
        let mut left = bounds[0];
        for cut in 1..bounds.len() {
            let cost = left.area() * cut as f32 + areas_right[cut] * (bounds.len() - cut) as f32;
            // Where all boxes are alike, the middle: a chain would be as cheap by this count.
            if cost < least || (cost == least && cut.abs_diff(half) < best.abs_diff(half)) {
                (best, least) = (cut, cost);
            }
            left = left.union(bounds[cut]);
        }
        range.start + best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions and triangles.
    pub(super) type Mesh = (Vec<DVec3>, Vec<[u32; 3]>);

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
            let bvh = Bvh::build(&mesh.0, &mesh.1);
            assert_eq!(check_boxes(&bvh, &mesh, 0, EVERYWHERE, 1), 300);
        }
    }

    fn depth(nodes: &[Node], node: u32) -> usize {
        let below = nodes[node as usize].0.map(|child| if child.count == NODE { depth(nodes, child.first) } else { 0 });
        1 + below[0].max(below[1])
    }

    #[test]
    fn depth_is_bounded_where_areas_ask_for_a_chain() {
        // Every box dwarfs all before it: the heuristic cuts off one at a time.
        let boxes = |faces: i32, growth: f32| -> Vec<Bounds> {
            (0..faces).map(|face| Bounds { min: Vec3::ZERO, max: Vec3::splat(growth.powi(face)) }).collect()
        };
        let split = |bounds: Vec<Bounds>, levels: u32| {
            let faces = bounds.len();
            let mut splitter = Splitter { areas_right: vec![0.0; faces], bounds, nodes: Vec::new() };
            splitter.node(0..faces, levels);
            let leaves = splitter.nodes.iter().flat_map(|node| node.0).filter(|child| child.count != NODE);
            let mut found: Vec<u32> = leaves.flat_map(|leaf| leaf.faces()).collect();
            found.sort_unstable();
            assert!(found.into_iter().eq(0..faces as u32));
            depth(&splitter.nodes, 0)
        };
        assert_eq!(split(boxes(20, 8.0), 64), 16);
        for levels in 3..=16 {
            assert!(split(boxes(20, 8.0), levels) <= levels as usize);
        }
        // Equal boxes leave no cut better than another.
        assert_eq!(split(boxes(1024, 1.0), 64), 8);
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
            let bvh = Bvh::build(positions, triangles);
            for round in 0..2 {
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
                if round == 0 {}
            }
        }
    }
}
