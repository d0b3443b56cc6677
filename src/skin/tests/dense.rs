//! The solver's answers another way: all control points of all segments as unknowns, joins as constraints with multipliers, Gaussian
//! elimination with pivots.

use glam::{DAffine3, DMat3, DVec3};

use super::*;
use crate::skin::turn::orthogonal_factor;

/// What to measure a change of control points by.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Metric {
    /// By the energy of the chain.
    Energy,
    /// By the distances that control points move.
    Points,
}

/// The multiplier system of a chain in a pose.
pub(super) struct Dense {
    d: usize,
    segments: usize,
    /// Rows of constraints over coordinates of segments' control points, and their right sides.
    constraints: Vec<(Vec<(usize, f64)>, f64)>,
    factors: Vec<Vec<f64>>,
    order: Vec<usize>,
}

impl Dense {
    pub(super) fn new(bound: &BoundChain, weights: &Shepard, pose: &[DAffine3], metric: Metric) -> Self {
        let chain = bound.chain();
        let (segments, d) = (chain.segment_count(), bound.dimension());
        let constraints = constraints(bound, weights, pose);
        let size = 4 * d * segments;
        let mut matrix = vec![vec![0.0; size + constraints.len()]; size + constraints.len()];
        for segment in 0..segments {
            for k in 0..4 {
                for l in 0..4 {
                    let entry = match metric {
                        Metric::Energy => bound.lengths()[segment] * GRAM[k][l] / 420.0,
                        Metric::Points => f64::from(k == l),
                    };
                    for axis in 0..d {
                        matrix[(4 * segment + k) * d + axis][(4 * segment + l) * d + axis] = entry;
                    }
                }
            }
        }
        for (i, (row, _)) in constraints.iter().enumerate() {
            for (at, by) in row {
                matrix[size + i][*at] += by;
                matrix[*at][size + i] += by;
            }
        }
        let order = eliminate(&mut matrix);
        Self { d, segments, constraints, factors: matrix, order }
    }

    /// The change of segments that is as near to a wished one as constraints allow. `wished` are segments, in the energy's metric by their
    /// curves; `homogeneous` asks for changes instead of places.
    pub(super) fn nearest(
        &self,
        bound: &BoundChain,
        metric: Metric,
        wished: &[[DVec3; 4]],
        homogeneous: bool,
    ) -> Vec<[DVec3; 4]> {
        let d = self.d;
        let mut side = Vec::new();
        for (segment, wished) in wished.iter().enumerate() {
            for k in 0..4 {
                let sum: DVec3 = match metric {
                    Metric::Energy => {
                        let length = bound.lengths()[segment];
                        (0..4).map(|l| wished[l] * (length * GRAM[k][l] / 420.0)).sum()
                    }
                    Metric::Points => wished[k],
                };
                side.extend(&sum.to_array()[..d]);
            }
        }
        side.extend(self.constraints.iter().map(|(_, value)| if homogeneous { 0.0 } else { *value }));
        let solution = substitute(&self.factors, &self.order, &side);
        let read = |at: usize| DVec3::new(solution[at], solution[at + 1], if d == 3 { solution[at + 2] } else { 0.0 });
        (0..self.segments).map(|s| std::array::from_fn(|k| read((4 * s + k) * d))).collect()
    }

    /// By how much segments miss the constraints.
    pub(super) fn missed(&self, segments: &[[DVec3; 4]]) -> f64 {
        let value = |at: usize| segments[at / (4 * self.d)][at / self.d % 4][at % self.d];
        let miss = |(row, wished): &(Vec<(usize, f64)>, f64)| {
            (row.iter().map(|(at, by)| by * value(*at)).sum::<f64>() - wished).abs()
        };
        self.constraints.iter().map(miss).fold(0.0, worse)
    }
}

/// ∫ of products of Bernstein polynomials, times 420.
const GRAM: [[f64; 4]; 4] =
    [[60.0, 30.0, 12.0, 3.0], [30.0, 36.0, 27.0, 12.0], [12.0, 27.0, 36.0, 30.0], [3.0, 12.0, 30.0, 60.0]];

fn constraints(bound: &BoundChain, weights: &Shepard, pose: &[DAffine3]) -> Vec<(Vec<(usize, f64)>, f64)> {
    let chain = bound.chain();
    let (segments, d) = (chain.segment_count(), bound.dimension());
    let mut out = Vec::new();
    for (anchor, join) in chain.joins().iter().enumerate() {
        let before = if anchor > 0 { Some(anchor - 1) } else { chain.is_closed().then(|| segments - 1) };
        let at = |segment: usize, k: usize, axis: usize| (4 * segment + k) * d + axis;
        if let Some(pinned) = join.pinned {
            for axis in 0..d {
                let place = if anchor < segments { at(anchor, 0, axis) } else { at(anchor - 1, 3, axis) };
                out.push((vec![(place, 1.0)], pinned[axis]));
            }
        }
        let Some(before) = before.filter(|_| anchor < segments) else { continue };
        for axis in 0..d {
            out.push((vec![(at(before, 3, axis), 1.0), (at(anchor, 0, axis), -1.0)], 0.0));
        }
        if join.kind == JoinKind::Corner {
            continue;
        }
        let points = chain.points();
        let place = points[3 * anchor];
        let p = points[if anchor > 0 { 3 * anchor - 1 } else { points.len() - 1 }] - place;
        let q = points[3 * anchor + 1] - place;
        let matrix = match join.kind {
            JoinKind::Angle => {
                let normal = p.cross(q).normalize();
                let angle = p.angle_between(q);
                let mut turned = DMat3::from_axis_angle(normal, angle);
                if d == 3 {
                    let mut w = vec![0.0; pose.len()];
                    weights.weights_at(place, &mut w);
                    let sum: f64 = w.iter().sum();
                    let blend = pose.iter().zip(w).fold(DMat3::ZERO, |m, (t, w)| m + t.matrix3 * (w / sum));
                    let along = orthogonal_factor(blend).unwrap();
                    turned = along * turned * along.transpose();
                }
                turned * (q.length() / p.length())
            }
            _ => -DMat3::IDENTITY * (q.length() / p.length()),
        };
        // h_out − a − M (h_in − a) = 0.
        for axis in 0..d {
            let mut row = vec![(at(anchor, 1, axis), 1.0), (at(anchor, 0, axis), -1.0)];
            for other in 0..d {
                let by = matrix.col(other)[axis];
                row.extend([(at(before, 2, other), -by), (at(before, 3, other), by)]);
            }
            out.push((row, 0.0));
        }
    }
    out
}

/// Factors in place, and gives the order of rows.
fn eliminate(matrix: &mut [Vec<f64>]) -> Vec<usize> {
    let n = matrix.len();
    let mut order: Vec<usize> = (0..n).collect();
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| matrix[*a][k].abs().total_cmp(&matrix[*b][k].abs())).unwrap();
        matrix.swap(k, pivot);
        order.swap(k, pivot);
        let (above, below) = matrix.split_at_mut(k + 1);
        let row = &above[k];
        for other in below {
            let by = other[k] / row[k];
            if by != 0.0 {
                other[k] = by;
                other[k + 1..].iter_mut().zip(&row[k + 1..]).for_each(|(x, y)| *x -= by * y);
            }
        }
    }
    order
}

fn substitute(factors: &[Vec<f64>], order: &[usize], side: &[f64]) -> Vec<f64> {
    let n = factors.len();
    let mut x: Vec<f64> = order.iter().map(|i| side[*i]).collect();
    for i in 0..n {
        let sum: f64 = factors[i][..i].iter().zip(&x).map(|(a, b)| a * b).sum();
        x[i] -= sum;
    }
    for i in (0..n).rev() {
        let sum: f64 = factors[i][i + 1..].iter().zip(&x[i + 1..]).map(|(a, b)| a * b).sum();
        x[i] = (x[i] - sum) / factors[i][i];
    }
    x
}

/// The segments of a list of control points.
pub(super) fn segments(chain: &Chain, points: &[DVec3]) -> Vec<[DVec3; 4]> {
    (0..chain.segment_count()).map(|s| chain.places(s).map(|at| points[at])).collect()
}

/// The control points of segments that meet.
pub(super) fn joined(chain: &Chain, segments: &[[DVec3; 4]]) -> Vec<DVec3> {
    let mut points = chain.points().to_vec();
    for (s, segment) in segments.iter().enumerate() {
        for (at, p) in chain.places(s).into_iter().zip(segment) {
            points[at] = *p;
        }
    }
    points
}
