//! The nearest place of a line in space.

use glam::DVec3;

/// Stretches in a leaf.
const LEAF: usize = 4;
/// A stack that suffices for a tree of 2³² stretches, gone through depth first.
const DEPTH: usize = 34;

/// The nearest place of a line to a position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub(crate) distance: f64,
    pub(crate) place: DVec3,
    pub(crate) stretch: usize,
    /// Whether it is an end of that stretch.
    pub(crate) at_end: bool,
}

/// The nearest place as long as it is looked for.
#[derive(Clone, Copy, Debug)]
struct Best {
    squared: f64,
    share: f64,
    stretch: usize,
}

impl Best {
    const NONE: Self = Self { squared: f64::INFINITY, share: 0.0, stretch: usize::MAX };
}

/// A stretch of a line.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    from: DVec3,
    way: DVec3,
    /// One over its squared length; nothing where it has none.
    inverse: f64,
}

/// A line in space with a tree of boxes over its stretches, which are near one another because they follow one another: the
/// tree halves ranges and permutes nothing.
#[derive(Debug, Default)]
pub(crate) struct LineTree {
    points: Vec<DVec3>,
    stretches: Vec<Stretch>,
    /// In heap order: node k covers half of what node k / 2 does. Boxes of nodes that cover nothing are inside out.
    boxes: Vec<[DVec3; 2]>,
    leaves: usize,
}

impl LineTree {
    /// Builds the tree over the stretches between consecutive points. Cost: linear.
    pub(crate) fn build(&mut self, points: &[DVec3]) {
        self.points.clear();
        self.points.extend_from_slice(points);
        self.stretches.clear();
        self.stretches.extend(points.windows(2).map(|pair| {
            let way = pair[1] - pair[0];
            let squared = way.length_squared();
            Stretch { from: pair[0], way, inverse: if squared > f64::MIN_POSITIVE { 1.0 / squared } else { 0.0 } }
        }));
        let stretches = self.stretches.len();
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
        self.stretches.clone_from(&other.stretches);
        self.boxes.clone_from(&other.boxes);
        self.leaves = other.leaves;
    }

    pub(crate) fn points(&self) -> &[DVec3] {
        &self.points
    }

    fn stretches(&self) -> usize {
        self.stretches.len()
    }

    /// The squared length of the part of a vector that points along a stretch.
    #[inline]
    pub(crate) fn squared_along(&self, stretch: usize, vector: DVec3) -> f64 {
        self.stretches.get(stretch).map_or(0.0, |s| s.way.dot(vector).powi(2) * s.inverse)
    }

    /// The nearest place on some stretches.
    #[inline]
    fn on(&self, p: DVec3, first: usize, end: usize, best: &mut Best) {
        let Some(stretches) = self.stretches.get(first..end) else { return };
        for (k, Stretch { from, way, inverse }) in (first..).zip(stretches) {
            let share = ((p - *from).dot(*way) * inverse).clamp(0.0, 1.0);
            let squared = p.distance_squared(*from + share * *way);
            if squared < best.squared {
                *best = Best { squared, share, stretch: k };
            }
        }
    }

    /// What was found, if anything.
    #[inline]
    fn found(&self, best: &Best) -> Option<Near> {
        let Stretch { from, way, .. } = self.stretches.get(best.stretch)?;
        Some(Near {
            distance: 0.0,
            place: *from + best.share * *way,
            stretch: best.stretch,
            at_end: best.share <= 0.0 || best.share >= 1.0,
        })
    }

    /// The nearest place near a stretch that was nearest before, its distance left out: right for small moves.
    #[inline]
    pub(crate) fn near(&self, p: DVec3, stretch: usize) -> Option<Near> {
        let mut best = Best::NONE;
        self.on(p, stretch.saturating_sub(1), (stretch + 2).min(self.stretches()), &mut best);
        self.found(&best)
    }

    /// The nearest place of one stretch, its distance left out.
    #[inline]
    pub(crate) fn of(&self, p: DVec3, stretch: usize) -> Option<Near> {
        let mut best = Best::NONE;
        self.on(p, stretch, (stretch + 1).min(self.stretches()), &mut best);
        self.found(&best)
    }

    /// The nearest place; a stretch that may be near saves most of the work: from there the tree is climbed.
    pub(crate) fn nearest(&self, p: DVec3, hint: Option<usize>) -> Option<Near> {
        let mut best = Best::NONE;
        match hint.filter(|hint| *hint < self.stretches()) {
            None => self.search(p, 1, &mut best),
            Some(hint) => {
                let mut node = self.leaves + hint / LEAF;
                self.in_leaf(p, node, &mut best);
                while node > 1 {
                    self.search(p, node ^ 1, &mut best);
                    node >>= 1;
                }
            }
        }
        let near = self.found(&best)?;
        Some(Near { distance: best.squared.sqrt(), ..near })
    }

    #[inline]
    fn in_leaf(&self, p: DVec3, node: usize, best: &mut Best) {
        let first = (node - self.leaves) * LEAF;
        self.on(p, first, (first + LEAF).min(self.stretches()), best);
    }

    /// Looks for something nearer below a node.
    fn search(&self, p: DVec3, node: usize, best: &mut Best) {
        let is_near = |beyond: f64, best: &Best| beyond.is_finite() && beyond < best.squared;
        let beyond = self.boxes.get(node).map_or(f64::INFINITY, |_| self.beyond(p, node));
        if !is_near(beyond, best) {
            return;
        }
        let mut stack = [(beyond, node); DEPTH];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (beyond, node) = stack[height];
            if !is_near(beyond, best) {
                continue;
            }
            if node >= self.leaves {
                self.in_leaf(p, node, best);
                continue;
            }
            let mut children = [2 * node, 2 * node + 1].map(|k| (self.beyond(p, k), k));
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            for child in children {
                if is_near(child.0, best) && height < DEPTH {
                    stack[height] = child;
                    height += 1;
                }
            }
        }
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
                let mut all = Best::NONE;
                tree.on(p, 0, points.len() - 1, &mut all);
                let least = all.squared.sqrt();
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
