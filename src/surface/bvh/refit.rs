//! The same tree about faces that have moved.

use glam::DVec3;

use super::{Bounds, Bvh, Frame, NODE, NOWHERE};

impl Bvh {
    /// Fits the boxes to other positions of the same faces; which faces share a box stays.
    ///
    /// Answers stay exact, but the further faces have moved apart, the slower they come. O(F), nothing is allocated.
    pub(crate) fn refit(&mut self, positions: &[DVec3], triangles: &[[u32; 3]]) {
        let corners = triangles.as_flattened().iter().filter_map(|index| positions.get(*index as usize));
        let (min, max) = corners.fold(NOWHERE, |(min, max), &p| (min.min(p), max.max(p)));
        self.frame = Frame::of_box(min, max);
        // Parents come before their children.
        for node in (0..self.nodes.len()).rev() {
            for side in 0..2 {
                let child = &self.nodes[node].0[side];
                let bounds = if child.count == NODE {
                    let [left, right] = &self.nodes[child.first as usize].0;
                    left.bounds.union(right.bounds)
                } else {
                    let faces = child.first..child.first + child.count;
                    let bounds = |face| self.frame.bounds(positions, triangles, face);
                    faces.map(bounds).fold(Bounds::EMPTY, Bounds::union)
                };
                self.nodes[node].0[side].bounds = bounds;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Random, soup, tree};
    use super::*;

    #[test]
    fn a_refitted_tree_answers_as_a_new_one() {
        let mut random = Random(5);
        let (mut positions, triangles) = soup(700, &mut random);
        let mut bvh = tree(&(positions.clone(), triangles.clone()));
        for size in [1.0, 1e-3, 1e4] {
            for p in &mut positions {
                *p = size * (*p + 0.3 * random.place()) + size * DVec3::splat(3.0);
            }
            bvh.refit(&positions, &triangles);
            let anew = tree(&(positions.clone(), triangles.clone()));
            for _ in 0..500 {
                let from = size * DVec3::splat(3.0) + 2.0 * size * random.place();
                let ray = |bvh: &Bvh| bvh.ray(&positions, &triangles, from, random_direction(from), f64::INFINITY);
                assert_eq!(ray(&bvh), ray(&anew));
                let closest = |bvh: &Bvh| bvh.closest(&positions, &triangles, from, f64::INFINITY);
                assert_eq!(closest(&bvh), closest(&anew));
            }
        }
    }

    /// Some direction that follows from a place.
    fn random_direction(from: DVec3) -> DVec3 {
        DVec3::new((from.x * 1e3).sin(), (from.y * 1e3).sin(), (from.z * 1e3).cos())
    }
}
