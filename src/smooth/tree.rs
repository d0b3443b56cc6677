//! The nearest place of a line in space.

use glam::DVec3;

/// Stretches in a leaf.
const LEAF: usize = 4;
/// Most levels of a tree of 2³² stretches, and a stack that always suffices.
const DEPTH: usize = 64;

/// The nearest place of a line to a position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub(crate) distance: f64,
    pub(crate) place: DVec3,
    pub(crate) stretch: usize,
    /// Whether it is an end of that stretch.
    pub(crate) at_end: bool,
}

/// A line in space with a tree of boxes over its stretches, which are near one another because they follow one another: the
/// tree halves ranges and permutes nothing.
#[derive(Debug, Default)]
pub(crate) struct LineTree {
    points: Vec<DVec3>,
    /// In heap order: node k covers half of what node k / 2 does. Boxes of nodes that cover nothing are inside out.
    boxes: Vec<[DVec3; 2]>,
    leaves: usize,
}

impl LineTree {
    /// Builds the tree over the stretches between consecutive points. Cost: linear.
    pub(crate) fn build(&mut self, points: &[DVec3]) {
        self.points.clear();
        self.points.extend_from_slice(points);
        let stretches = points.len().saturating_sub(1);
        self.leaves = stretches.div_ceil(LEAF).max(1).next_power_of_two();
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.boxes.clear();
        self.boxes.resize(2 * self.leaves, empty);
        for leaf in 0..self.leaves {
            let (first, end) = (leaf * LEAF, ((leaf + 1) * LEAF).min(stretches));
            if first < end {
                let within = &points[first..=end];
                self.boxes[self.leaves + leaf] =
                    within.iter().fold(empty, |[low, high], p| [low.min(*p), high.max(*p)]);
            }
        }
        for k in (1..self.leaves).rev() {
            let [a, b] = [self.boxes[2 * k], self.boxes[2 * k + 1]];
            self.boxes[k] = [a[0].min(b[0]), a[1].max(b[1])];
        }
    }

    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.points.clone_from(&other.points);
        self.boxes.clone_from(&other.boxes);
        self.leaves = other.leaves;
    }

    pub(crate) fn points(&self) -> &[DVec3] {
        &self.points
    }

    fn stretches(&self) -> usize {
        self.points.len().saturating_sub(1)
    }

    /// The nearest place on some stretches.
    fn on(&self, p: DVec3, first: usize, end: usize, best: &mut Option<(f64, Near)>) {
        for k in first..end {
            let (a, way) = (self.points[k], self.points[k + 1] - self.points[k]);
            let share = ((p - a).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let place = a + share * way;
            let squared = p.distance_squared(place);
            if best.is_none_or(|(least, _)| squared < least) {
                *best =
                    Some((squared, Near { distance: 0.0, place, stretch: k, at_end: share <= 0.0 || share >= 1.0 }));
            }
        }
    }

    /// The nearest place near a stretch that was nearest before: right for small moves, never nearer than the nearest.
    pub(crate) fn near(&self, p: DVec3, stretch: usize) -> Option<Near> {
        let mut best = None;
        self.on(p, stretch.saturating_sub(1), (stretch + 2).min(self.stretches()), &mut best);
        best.map(|(squared, near)| Near { distance: squared.sqrt(), ..near })
    }

    /// The nearest place of one stretch.
    pub(crate) fn of(&self, p: DVec3, stretch: usize) -> Option<Near> {
        let mut best = None;
        self.on(p, stretch, (stretch + 1).min(self.stretches()), &mut best);
        best.map(|(squared, near)| Near { distance: squared.sqrt(), ..near })
    }

    /// The nearest place; a stretch that may be near saves work.
    pub(crate) fn nearest(&self, p: DVec3, hint: Option<usize>) -> Option<Near> {
        let mut best = None;
        if let Some(hint) = hint {
            self.on(p, hint.min(self.stretches()), (hint + 1).min(self.stretches()), &mut best);
        }
        let mut stack = [(0.0, 1_usize); DEPTH];
        let mut height = usize::from(self.stretches() > 0);
        while height > 0 {
            height -= 1;
            let (beyond, node) = stack[height];
            if best.is_some_and(|(least, _)| beyond >= least) {
                continue;
            }
            if node >= self.leaves {
                let first = (node - self.leaves) * LEAF;
                self.on(p, first, (first + LEAF).min(self.stretches()), &mut best);
                continue;
            }
            let mut children = [2 * node, 2 * node + 1].map(|k| (self.beyond(p, k), k));
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            for child in children {
                if child.0.is_finite() && height < DEPTH {
                    stack[height] = child;
                    height += 1;
                }
            }
        }
        best.map(|(squared, near)| Near { distance: squared.sqrt(), ..near })
    }

    /// Squared distance from a box.
    #[inline]
    fn beyond(&self, p: DVec3, node: usize) -> f64 {
        let [low, high] = self.boxes[node];
        (p.max(low).min(high) - p).length_squared()
    }

    /// Visits all stretches whose boxes are within a distance of a box.
    pub(crate) fn visit_near(&self, low: DVec3, high: DVec3, reach: f64, mut visit: impl FnMut(DVec3, DVec3)) {
        let mut stack = [1_usize; DEPTH];
        let mut height = usize::from(self.stretches() > 0);
        while height > 0 {
            height -= 1;
            let node = stack[height];
            let [a, b] = self.boxes[node];
            let gap = (a - high).max(low - b).max(DVec3::ZERO);
            if gap.length_squared() > reach * reach {
                continue;
            }
            if node >= self.leaves {
                let first = (node - self.leaves) * LEAF;
                for k in first..(first + LEAF).min(self.stretches()) {
                    visit(self.points[k], self.points[k + 1]);
                }
            } else if height + 2 <= DEPTH {
                stack[height] = 2 * node;
                stack[height + 1] = 2 * node + 1;
                height += 2;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smooth::tests::Random;

    #[test]
    fn the_nearest_place_is_that_of_all_stretches() {
        let mut random = Random(21);
        let mut point = || DVec3::new(random.next(), random.next(), random.next());
        for count in [2, 3, 9, 200] {
            let points: Vec<DVec3> = (0..count).map(|_| point()).collect();
            let mut tree = LineTree::default();
            tree.build(&points);
            for _ in 0..200 {
                let p = 2.0 * point() - 0.5;
                let found = tree.nearest(p, None).unwrap();
                let mut all = None;
                tree.on(p, 0, points.len() - 1, &mut all);
                let least = all.unwrap().0.sqrt();
                assert!((found.distance - least).abs() < 1e-15 && p.distance(found.place) == found.distance);
                assert!((tree.nearest(p, Some(count / 2)).unwrap().distance - least).abs() < 1e-15);
                let mut seen = f64::INFINITY;
                tree.visit_near(p, p, least + 1e-12, |a, b| {
                    let way = b - a;
                    let share = ((p - a).dot(way) / way.length_squared()).clamp(0.0, 1.0);
                    seen = seen.min(p.distance(a + share * way));
                });
                assert!((seen - least).abs() < 1e-12);
            }
        }
        assert!(LineTree::default().nearest(DVec3::ZERO, None).is_none());
    }
}
