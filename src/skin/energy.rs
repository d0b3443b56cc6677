//! How far curves are from the skinned ones, and how well joins are kept: measured, not solved for.

use glam::{DAffine3, DVec3};

use super::bound::{Measure, point};
use super::quadrature::{bernstein, bernstein_slopes};
use super::{BindOptions, BoundChain, JoinKind, WeightField};

/// Where weights bring a place, with one transform for each handle. NaN where no handle moves it.
pub fn skinned(weights: &dyn WeightField, transforms: &[DAffine3], place: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
    scratch.resize(weights.handle_count(), 0.0);
    weights.weights_at(place, scratch);
    let sum: f64 = scratch.iter().sum();
    let moved = scratch.iter().zip(transforms).map(|(w, transform)| transform.transform_point3(place) * (w / sum));
    moved.sum()
}

impl BoundChain {
    /// The energy of control points in a pose: squared distances to the skinned curve, integrated over the chain by the rule that it was bound
    /// with; in units of length cubed. `weights` and `options` are those that it was bound with. Infinite if there are fewer control points than
    /// the chain has.
    pub fn energy(
        &self,
        weights: &dyn WeightField,
        options: &BindOptions,
        transforms: &[DAffine3],
        points: &[DVec3],
    ) -> f64 {
        let chain = self.chain();
        if points.len() < chain.points().len() {
            return f64::INFINITY;
        }
        let segments = (0..chain.segment_count()).map(|s| chain.places(s).map(|at| points[at])).collect::<Vec<_>>();
        self.energy_of_segments(weights, options, transforms, &segments)
    }

    /// The same of segments that need not meet.
    pub fn energy_of_segments(
        &self,
        weights: &dyn WeightField,
        options: &BindOptions,
        transforms: &[DAffine3],
        segments: &[[DVec3; 4]],
    ) -> f64 {
        let rule = options.quadrature.unwrap_or_else(|| weights.quadrature()).rule();
        let (mut sum, mut scratch) = (0.0, Vec::new());
        for (segment, moved) in segments.iter().enumerate().take(self.chain.segment_count()) {
            let (rest, length) = (self.chain.segment(segment), self.lengths[segment]);
            for (t, share) in &rule {
                let m = bernstein(*t);
                let by = match options.measure {
                    Measure::Parameter => share * length,
                    Measure::ArcLength => share * point(&rest, &bernstein_slopes(*t)).length().max(1e-6 * length),
                };
                let mut wished = skinned(weights, transforms, point(&rest, &m), &mut scratch);
                if !self.chain.is_spatial() {
                    wished.z = 0.0;
                }
                sum += by * point(moved, &m).distance_squared(wished);
            }
        }
        sum
    }

    /// How far control points miss what the joins keep, as the largest distance by which the end of a handle, or a pinned anchor, is off. With
    /// `free_ratios` the lengths of handles do not count where a flexible pose may change them. Infinite if points or transforms do not fit the
    /// chain, or a point is not finite.
    pub fn violation(&self, transforms: &[DAffine3], points: &[DVec3], free_ratios: bool) -> f64 {
        let mut turns = Vec::new();
        let fits = points.len() == self.chain.points().len() && points.iter().all(|p| p.is_finite());
        if !fits || self.check(transforms).is_err() {
            return f64::INFINITY;
        }
        if self.turns_along() {
            self.turn(transforms, &mut turns);
        }
        let n = points.len();
        let mut worst: f64 = 0.0;
        for (anchor, join) in self.chain.joins().iter().enumerate() {
            let at = 3 * anchor;
            let Some(place) = points.get(at) else { return f64::INFINITY };
            worst = worst.max(join.pinned.map_or(0.0, |pinned| pinned.distance(*place)));
            let Some(tie) = self.ties[anchor] else { continue };
            let before = if at > 0 { at - 1 } else { n - 1 };
            let (p, q) = (points[before] - *place, points[at + 1] - *place);
            let turned = self.posed_turn(anchor, &turns) * p;
            let off = if !free_ratios || join.kind == JoinKind::Mirrored {
                (turned * tie.ratio).distance(q)
            } else if p.length() > q.length() {
                (turned.normalize_or_zero() * q.length()).distance(q)
            } else {
                turned.distance(q.normalize_or_zero() * p.length())
            };
            worst = worst.max(off);
        }
        worst
    }
}
