//! Splitting segments that are too long to follow the handles.

use glam::{DAffine3, DVec3};

use super::bound::point;
use super::energy::skinned;
use super::quadrature::bernstein;
use super::{BindOptions, BoundChain, Chain, ChainJoin, JoinKind, SkinError, SolveWorkspace, WeightField};

/// When segments are split.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct SplitOptions {
    /// How far a curve may be from the skinned one, at the same parameter, in units of length.
    pub tolerance: f64,
    /// How often a segment may be split in turn, eight times at most.
    pub levels: u32,
}

impl Default for SplitOptions {
    /// A quarter of a unit, for drawings whose unit is a pixel.
    fn default() -> Self {
        Self { tolerance: 0.25, levels: 4 }
    }
}

/// A chain with some segments split.
#[derive(Clone, Debug)]
pub struct SplitChain {
    /// The same curve in more segments.
    pub chain: Chain,
    /// For each segment, the one that it was a part of, and the range of parameters there.
    pub parts: Vec<(usize, [f64; 2])>,
    /// The largest distance to the skinned curves of all poses that is left, at places that were looked at.
    pub left: f64,
}

/// Places of a segment that are looked at, the ends among them.
const SAMPLES: u32 = 9;
/// Levels at most: a segment in 256.
const MOST_LEVELS: u32 = 8;

impl SplitChain {
    /// Splits segments where they miss a skinned curve of some poses most, until none misses by more than the tolerance or has been split as
    /// often as it may. Joins that this makes are smooth and keep their ratio, so that the curve at rest stays the same; a mirrored join beside a
    /// cut becomes one of those.
    ///
    /// # Errors
    /// As [`BoundChain::new`] and [`BoundChain::solve`].
    pub fn new(
        chain: &Chain,
        weights: &dyn WeightField,
        bind: &BindOptions,
        poses: &[Vec<DAffine3>],
        options: &SplitOptions,
    ) -> Result<Self, SkinError> {
        let parts = (0..chain.segment_count()).map(|segment| (segment, [0.0, 1.0])).collect();
        let mut split = Self { chain: chain.clone(), parts, left: 0.0 };
        let levels = options.levels.min(MOST_LEVELS);
        for level in 0..=levels {
            let worst = split.misses(weights, bind, poses)?;
            split.left = worst.iter().map(|(miss, _)| *miss).fold(0.0, f64::max);
            let at = |(miss, t): &(f64, f64)| (*miss > options.tolerance).then_some(*t);
            let cuts: Vec<Option<f64>> = worst.iter().map(at).collect();
            if level == levels || cuts.iter().all(Option::is_none) {
                break;
            }
            split.cut(&cuts);
        }
        Ok(split)
    }

    /// The largest miss of each segment in all poses, and the inner parameter where segments are to be cut.
    fn misses(
        &self,
        weights: &dyn WeightField,
        bind: &BindOptions,
        poses: &[Vec<DAffine3>],
    ) -> Result<Vec<(f64, f64)>, SkinError> {
        let bound = BoundChain::new(&self.chain, 0, weights, bind)?;
        let (mut workspace, mut points, mut scratch) = (SolveWorkspace::default(), Vec::new(), Vec::new());
        let mut worst = vec![(0.0, 0.5); self.chain.segment_count()];
        for transforms in poses {
            bound.solve(transforms, &mut workspace, &mut points)?;
            for (segment, worst) in worst.iter_mut().enumerate() {
                let rest = self.chain.segment(segment);
                let moved = self.chain.places(segment).map(|at| points[at]);
                for i in 0..SAMPLES {
                    let t = f64::from(i) / f64::from(SAMPLES - 1);
                    let m = bernstein(t);
                    let mut wished = skinned(weights, transforms, point(&rest, &m), &mut scratch);
                    if !self.chain.is_spatial() {
                        wished.z = 0.0;
                    }
                    let miss = point(&moved, &m).distance(wished);
                    if miss > worst.0 {
                        // A miss at an end asks for a cut near it, not at it.
                        *worst = (miss, t.clamp(0.25, 0.75));
                    }
                }
            }
        }
        Ok(worst)
    }

    /// Cuts segments at a parameter where one is given.
    fn cut(&mut self, cuts: &[Option<f64>]) {
        let (mut points, mut joins, mut parts) = (Vec::new(), Vec::new(), Vec::new());
        for (segment, cut) in cuts.iter().enumerate() {
            let control = self.chain.segment(segment);
            let (of, [from, to]) = self.parts[segment];
            let mut join = self.chain.join(segment);
            let before = if segment > 0 { segment - 1 } else { cuts.len() - 1 };
            // A part is shorter than the whole, and so is its handle.
            if join.kind == JoinKind::Mirrored && (cut.is_some() || cuts[before].is_some()) {
                join.kind = JoinKind::Smooth;
            }
            joins.push(join);
            match cut {
                None => {
                    points.extend(&control[..3]);
                    parts.push((of, [from, to]));
                }
                Some(t) => {
                    let [before, behind] = halves(&control, *t);
                    points.extend(&before[..3]);
                    points.extend(&behind[..3]);
                    let middle = from + (to - from) * t;
                    parts.extend([(of, [from, middle]), (of, [middle, to])]);
                    // Handles without length have no direction to keep.
                    let is_directed = before[2] != before[3] && behind[1] != behind[0];
                    let kind = if is_directed { JoinKind::Smooth } else { JoinKind::Corner };
                    joins.push(ChainJoin { kind, pinned: None });
                }
            }
        }
        if !self.chain.is_closed() {
            points.extend(self.chain.points().last());
            joins.extend(self.chain.joins().last());
        }
        self.chain = self.chain.rebuilt(points, joins);
        self.parts = parts;
    }
}

/// A segment in two, by de Casteljau's construction.
fn halves([a, b, c, d]: &[DVec3; 4], t: f64) -> [[DVec3; 4]; 2] {
    let (ab, bc, cd) = (a.lerp(*b, t), b.lerp(*c, t), c.lerp(*d, t));
    let (abc, bcd) = (ab.lerp(bc, t), bc.lerp(cd, t));
    let middle = abc.lerp(bcd, t);
    [[*a, ab, abc, middle], [middle, bcd, cd, *d]]
}
