//! A chain bound to handles: everything that does not depend on the pose, in double precision.

use glam::{DAffine3, DMat4, DVec3, DVec4};

use super::quadrature::{bernstein, bernstein_slopes};
use super::system::{Gram, Link};
use super::turn::{Tie, turn_between};
use super::{Chain, JoinKind, Quadrature, SkinError, WeightField};

/// What is the same about a deviation: along parameters, or along the curve at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub enum Measure {
    /// All parameters of a segment count the same; segments count by their length.
    #[default]
    Parameter,
    /// All places of the curve at rest count the same.
    ArcLength,
}

/// How chains are bound to handles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct BindOptions {
    /// How integrals are taken; what the weights ask for if not given.
    pub quadrature: Option<Quadrature>,
    /// What counts.
    pub measure: Measure,
}

/// ∫ w [B; 1] mᵀ of a segment and a handle, times the segment's weight: rows x, y, z and 1.
pub(crate) type Moment = [[f64; 4]; 4];

/// A chain bound to handles.
#[derive(Clone, Debug)]
pub struct BoundChain {
    pub(crate) chain: Chain,
    /// Handles that there are.
    pub(crate) handle_count: usize,
    /// Handles that move some of it.
    pub(crate) handles: Vec<u32>,
    /// Lengths of segments, none of them zero.
    pub(crate) lengths: Vec<f64>,
    pub(crate) grams: Vec<Gram>,
    /// Of all handles of the first segment, then of the second, …
    pub(crate) moments: Vec<Moment>,
    /// At each anchor.
    pub(crate) ties: Vec<Option<Tie>>,
    /// Weights of the handles at each anchor, where turns go along with the pose.
    pub(crate) anchor_weights: Vec<f64>,
}

impl BoundChain {
    /// Binds a chain to handles. `number` is the chain's place in a list, for errors.
    ///
    /// # Errors
    /// [`SkinError::NoHandles`], [`SkinError::NoWeights`].
    pub fn new(
        chain: &Chain,
        number: usize,
        weights: &dyn WeightField,
        options: &BindOptions,
    ) -> Result<Self, SkinError> {
        let count = weights.handle_count();
        if count == 0 {
            return Err(SkinError::NoHandles);
        }
        let rule = options.quadrature.unwrap_or_else(|| weights.quadrature()).rule();
        let all = Self::sample(chain, number, weights, &rule)?;
        let mut bound = Self::of_samples(chain, count, &rule, &all, options.measure);
        if bound.turns_along() {
            let mut at_node = vec![0.0; count];
            for anchor in 0..chain.anchor_count() {
                let place = chain.points()[3 * anchor];
                normalised(weights, place, &mut at_node)
                    .ok_or(SkinError::NoWeights { chain: number, segment: anchor.min(chain.segment_count() - 1) })?;
                bound.anchor_weights.extend(bound.handles.iter().map(|handle| at_node[*handle as usize]));
            }
        }
        Ok(bound)
    }

    /// Weights at all places that integrals ask for: those of all handles at the first, then at the second, …; each time they sum to one.
    pub(crate) fn sample(
        chain: &Chain,
        number: usize,
        weights: &dyn WeightField,
        rule: &[(f64, f64)],
    ) -> Result<Vec<f64>, SkinError> {
        let count = weights.handle_count();
        let mut all = vec![0.0; chain.segment_count() * rule.len() * count];
        for (segment, of_segment) in all.chunks_exact_mut((rule.len() * count).max(1)).enumerate() {
            let control = chain.segment(segment);
            for ((t, _), out) in rule.iter().zip(of_segment.chunks_exact_mut(count)) {
                normalised(weights, point(&control, &bernstein(*t)), out)
                    .ok_or(SkinError::NoWeights { chain: number, segment })?;
            }
        }
        Ok(all)
    }

    /// Binds a chain by weights that were sampled; one in space that keeps angles needs those of its anchors besides.
    pub(crate) fn of_samples(chain: &Chain, count: usize, rule: &[(f64, f64)], all: &[f64], measure: Measure) -> Self {
        let moves = |handle: &u32| all.chunks_exact(count).any(|node| node[*handle as usize] > 0.0);
        let handles: Vec<u32> = (0..count as u32).filter(moves).collect();
        let mut bound = Self {
            chain: chain.clone(),
            handle_count: count,
            handles,
            lengths: segment_lengths(chain),
            grams: Vec::with_capacity(chain.segment_count()),
            moments: Vec::with_capacity(chain.segment_count()),
            ties: (0..chain.anchor_count()).map(|anchor| tie(chain, anchor)).collect(),
            anchor_weights: Vec::new(),
        };
        for (segment, of_segment) in all.chunks_exact((rule.len() * count).max(1)).enumerate() {
            bound.integrate(segment, rule, of_segment, count, measure);
        }
        bound
    }

    /// The chain bound to some of more handles: `handles` has the number of each one that it is bound to, in ascending order.
    #[cfg(all(feature = "svg", feature = "document"))]
    pub(crate) fn among(mut self, handles: &[u32], count: usize) -> Self {
        self.handles.iter_mut().for_each(|handle| *handle = handles[*handle as usize]);
        self.handle_count = count;
        self
    }

    /// The chain at rest.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Lengths of its segments at rest; those of segments without length are a millionth of the mean.
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// Number of handles that it is bound to; some may not move it.
    pub fn handle_count(&self) -> usize {
        self.handle_count
    }

    /// Refuses poses that do not fit.
    pub(crate) fn check(&self, transforms: &[DAffine3]) -> Result<(), SkinError> {
        if transforms.len() != self.handle_count {
            return Err(SkinError::PoseLength { handles: self.handle_count, found: transforms.len() });
        }
        match transforms.iter().position(|transform| !transform.is_finite()) {
            Some(handle) => Err(SkinError::PoseNotFinite { handle }),
            None => Ok(()),
        }
    }

    /// Number of coordinates.
    pub(crate) fn dimension(&self) -> usize {
        if self.chain.is_spatial() { 3 } else { 2 }
    }

    /// Moments of a segment; not zero.
    pub(crate) fn stride(&self) -> usize {
        self.handles.len().max(1)
    }

    /// Whether a join has an angle that is not a half turn.
    pub(crate) fn is_turned(&self) -> bool {
        self.ties.iter().flatten().any(|tie| tie.turned)
    }

    /// Whether turns depend on the pose.
    pub(crate) fn turns_along(&self) -> bool {
        self.chain.is_spatial() && self.is_turned()
    }

    /// How many coordinates hang together in a regular solve: all, or each for itself.
    pub(crate) fn coupled(&self) -> usize {
        if self.is_turned() { self.dimension() } else { 1 }
    }

    /// What ties the handles of an anchor at rest.
    pub(crate) fn rest_link(&self, anchor: usize) -> Link {
        self.ties[anchor].map_or(Link::Free, |tie| Link::Tied(tie.turn * tie.ratio))
    }

    /// The right side of the system in a pose, for all control points: coordinate after coordinate.
    pub(crate) fn sides(&self, transforms: &[DAffine3], out: &mut Vec<f64>) {
        let d = self.dimension();
        out.clear();
        out.resize(self.chain.points().len() * d, 0.0);
        for (segment, moments) in self.moments.chunks_exact(self.stride()).enumerate() {
            let sums = self.segment_sides(moments, transforms);
            for (place, sum) in self.chain.places(segment).into_iter().zip(sums) {
                out[place * d..][..d].iter_mut().zip(sum.to_array()).for_each(|(x, y)| *x += y);
            }
        }
    }

    /// The segments that would be nearest to the skinned curve if nothing held them together.
    pub(crate) fn loose(&self, transforms: &[DAffine3], out: &mut Vec<[DVec3; 4]>) {
        out.clear();
        let segments = self.grams.iter().zip(self.moments.chunks_exact(self.stride())).zip(&self.lengths);
        for ((gram, moments), length) in segments {
            // The fourth power of a length would leave the range of numbers long before the length does.
            let one = gram.map(|row| row.map(|entry| entry / length));
            let inverse = DMat4::from_cols_array_2d(&one).inverse().to_cols_array_2d();
            let sums = self.segment_sides(moments, transforms);
            out.push(inverse.map(|row| row.iter().zip(sums).map(|(a, sum)| sum * (*a / length)).sum()));
        }
    }

    fn segment_sides(&self, moments: &[Moment], transforms: &[DAffine3]) -> [DVec3; 4] {
        let mut sums = [DVec3::ZERO; 4];
        for (moment, handle) in moments.iter().zip(&self.handles) {
            let transform = &transforms[*handle as usize];
            let linear = transform.matrix3;
            for (k, sum) in sums.iter_mut().enumerate() {
                let [x, y, z, one] = moment.map(|row| row[k]);
                *sum += linear * DVec3::new(x, y, z) + transform.translation * one;
            }
        }
        if !self.chain.is_spatial() {
            sums.iter_mut().for_each(|sum| sum.z = 0.0);
        }
        sums
    }

    /// By how much control points miss the loose segments: the energy above the least that cubics can have.
    pub(crate) fn excess(&self, points: &[f64], loose: &[[DVec3; 4]]) -> f64 {
        let d = self.dimension();
        let mut sum = 0.0;
        for (segment, (gram, loose)) in self.grams.iter().zip(loose).enumerate() {
            let places = self.chain.places(segment);
            let off: [DVec3; 4] = std::array::from_fn(|k| read(points, places[k], d) - loose[k]);
            for (row, a) in gram.iter().zip(off) {
                sum += row.iter().zip(off).map(|(g, b)| *g * b).sum::<DVec3>().dot(a);
            }
        }
        sum
    }

    fn integrate(&mut self, segment: usize, rule: &[(f64, f64)], weights: &[f64], count: usize, measure: Measure) {
        let control = self.chain.segment(segment);
        let length = self.lengths[segment];
        let mut gram = [DVec4::ZERO; 4];
        let first = self.moments.len();
        self.moments.resize(first + self.handles.len(), [[0.0; 4]; 4]);
        let moments = &mut self.moments[first..];
        for ((t, share), weights) in rule.iter().zip(weights.chunks_exact(count)) {
            let m = bernstein(*t);
            let by = match measure {
                Measure::Parameter => share * length,
                // A part that has no length still counts a little, or it would be anywhere.
                Measure::ArcLength => share * point(&control, &bernstein_slopes(*t)).length().max(1e-6 * length),
            };
            let place = point(&control, &m).extend(1.0);
            let m = DVec4::from_array(m);
            let weighted = m * by;
            gram.iter_mut().zip(weighted.to_array()).for_each(|(row, k)| *row += m * k);
            for (moment, handle) in moments.iter_mut().zip(&self.handles) {
                let of_handle = weighted * weights[*handle as usize];
                for (row, coordinate) in moment.iter_mut().zip(place.to_array()) {
                    row.iter_mut().zip(of_handle.to_array()).for_each(|(x, y)| *x += coordinate * y);
                }
            }
        }
        self.grams.push(gram.map(|row| row.to_array()));
    }
}

/// A control point of a list of coordinates.
#[inline]
pub(crate) fn read(points: &[f64], place: usize, dimension: usize) -> DVec3 {
    let at = place * dimension;
    DVec3::new(points[at], points[at + 1], if dimension == 3 { points[at + 2] } else { 0.0 })
}

#[inline]
pub(crate) fn point(control: &[DVec3; 4], m: &[f64; 4]) -> DVec3 {
    control[0] * m[0] + control[1] * m[1] + control[2] * m[2] + control[3] * m[3]
}

/// Weights at a place, brought to a sum of one; none if there are none.
fn normalised(field: &dyn WeightField, place: DVec3, out: &mut [f64]) -> Option<()> {
    field.weights_at(place, out);
    let sum: f64 = out.iter().sum();
    let fine = sum > 0.0 && sum.is_finite() && out.iter().all(|w| *w >= 0.0);
    fine.then(|| out.iter_mut().for_each(|w| *w /= sum))
}

/// Lengths at rest, by sixteen nodes; a segment without length has a millionth of the mean.
fn segment_lengths(chain: &Chain) -> Vec<f64> {
    let rule = Quadrature::SMOOTH.rule();
    let slopes: Vec<([f64; 4], f64)> = rule.iter().map(|(t, w)| (bernstein_slopes(*t), *w)).collect();
    let of_segment = |segment| {
        let control = chain.segment(segment);
        slopes.iter().map(|(slopes, w)| w * point(&control, slopes).length()).sum()
    };
    let mut lengths: Vec<f64> = (0..chain.segment_count()).map(of_segment).collect();
    let mean = lengths.iter().sum::<f64>() / lengths.len().max(1) as f64;
    let least = if mean > 0.0 { 1e-6 * mean } else { 1.0 };
    lengths.iter_mut().for_each(|length| *length = length.max(least));
    lengths
}

fn tie(chain: &Chain, anchor: usize) -> Option<Tie> {
    let [incoming, outgoing] = chain.handles(anchor)?;
    let kind = chain.join(anchor).kind;
    let ratio = outgoing.length() / incoming.length();
    if kind == JoinKind::Corner || !(ratio > 0.0 && ratio.is_finite()) {
        return None;
    }
    let half = -glam::DMat3::IDENTITY;
    let turn = if kind == JoinKind::Angle { turn_between(incoming, outgoing, chain.is_spatial()) } else { half };
    let ratio = if kind == JoinKind::Mirrored { 1.0 } else { ratio };
    Some(Tie { ratio, turn, flexible: kind != JoinKind::Mirrored, turned: kind == JoinKind::Angle && turn != half })
}
