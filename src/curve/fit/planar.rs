//! The two lengths of a planar Bézier segment whose ends and tangents are given, by least squares.

use glam::DVec2;

/// The planar problem: samples, and what of the segment is known.
pub(super) struct Planar<'a> {
    pub(super) points: &'a [DVec2],
    pub(super) ends: [DVec2; 2],
    /// Unit directions of the two handles, both away from their ends.
    pub(super) headings: [DVec2; 2],
    /// Length of the line that the samples were taken from.
    pub(super) length: f64,
}

/// Two lengths, and how well they do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lengths {
    pub(super) lengths: [f64; 2],
    /// Largest distance of a sample from the segment.
    pub(super) error: f64,
    /// The sample that is farthest.
    pub(super) worst: usize,
}

/// No more rounds than this.
const ROUNDS: u32 = 24;

impl Planar<'_> {
    /// The lengths whose segment is nearest to the samples.
    ///
    /// Gauss–Newton on distances: each round finds every sample's nearest parameter, and the change of the lengths that makes
    /// the distances across the segment smallest; `shares` are first guesses of the parameters and become the ones found.
    pub(super) fn fit(&self, shares: &mut [f64], enough: f64) -> Lengths {
        let mut lengths = [self.length / 3.0; 2];
        let (mut best, mut change) = self.judge(lengths, shares);
        let (mut sum, mut damping) = (best.1, 1e-6);
        for _ in 0..ROUNDS {
            if best.0.error <= enough {
                break;
            }
            let next = self.within_bounds([0, 1].map(|k| lengths[k] + change.step(damping)[k]));
            let (judged, then) = self.judge(next, shares);
            let gain = sum - judged.1;
            if gain > 0.0 {
                (lengths, change, damping) = (next, then, damping * 0.3);
                best = judged;
                let is_done = gain < 1e-3 * sum;
                sum = judged.1;
                if is_done {
                    break;
                }
            } else {
                damping = (damping * 20.0).max(1e-3);
                if damping > 10.0 {
                    break;
                }
            }
        }
        best.0
    }

    /// Lengths that are positive and no longer than the line.
    pub(super) fn within_bounds(&self, lengths: [f64; 2]) -> [f64; 2] {
        lengths.map(|l| l.clamp(0.02 * self.length, 1.2 * self.length))
    }

    /// How far the samples are from the segment of some lengths, the sum of squares too, and the equations for a change.
    fn judge(&self, lengths: [f64; 2], shares: &mut [f64]) -> ((Lengths, f64), Equations) {
        let [p0, p3] = self.ends;
        let [h0, h1] = self.headings;
        let segment = Segment([p0, p0 + lengths[0] * h0, p3 + lengths[1] * h1, p3]);
        let mut equations = Equations::default();
        let (mut error, mut worst, mut sum) = (0.0_f64, 0, 0.0);
        for (i, (point, t)) in self.points.iter().zip(shares).enumerate() {
            *t = segment.nearest(*point, *t);
            let missing = *point - segment.at(*t);
            let distance = missing.length();
            if distance > error {
                (error, worst) = (distance, i);
            }
            sum += distance * distance;
            equations.add(*t, self.headings, segment.derivative(*t), missing);
        }
        ((Lengths { lengths, error, worst }, sum), equations)
    }
}

/// Normal equations for a change of the two lengths.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Equations {
    a: [f64; 3],
    b: [f64; 2],
}

impl Equations {
    /// Adds a sample: at parameter `t`, where the curve runs along `tangent`, `missing` leads from it to the sample.
    ///
    /// What is missing along the curve is a matter of the parameter, and hardly counts.
    pub(super) fn add(&mut self, t: f64, headings: [DVec2; 2], tangent: DVec2, missing: DVec2) {
        const ALONG: f64 = 1e-3;
        let tangent = tangent.normalize_or_zero();
        let s = 1.0 - t;
        let weights = [3.0 * s * s * t, 3.0 * s * t * t];
        for (axis, weight) in [(tangent.perp(), 1.0), (tangent, ALONG)] {
            let [u, v] = [0, 1].map(|k| weights[k] * headings[k].dot(axis));
            let m = missing.dot(axis);
            self.a[0] += weight * u * u;
            self.a[1] += weight * u * v;
            self.a[2] += weight * v * v;
            self.b[0] += weight * u * m;
            self.b[1] += weight * v * m;
        }
    }

    /// The change of the lengths, the smaller the larger `damping`; zero where nothing can be said.
    pub(super) fn step(&self, damping: f64) -> [f64; 2] {
        let lift = (damping + 1e-9) * (self.a[0] + self.a[2]) + f64::MIN_POSITIVE;
        let (a, b, c) = (self.a[0] + lift, self.a[1], self.a[2] + lift);
        let determinant = a * c - b * b;
        let step = [(c * self.b[0] - b * self.b[1]) / determinant, (a * self.b[1] - b * self.b[0]) / determinant];
        if step.iter().all(|d| d.is_finite()) { step } else { [0.0; 2] }
    }
}

struct Segment([DVec2; 4]);

impl Segment {
    fn at(&self, t: f64) -> DVec2 {
        let [a, b, c, d] = self.0;
        let s = 1.0 - t;
        s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d
    }

    fn derivative(&self, t: f64) -> DVec2 {
        let [a, b, c, d] = self.0;
        let s = 1.0 - t;
        3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c))
    }

    /// The parameter near `t` whose place is nearest to a point, after two steps towards it (Schneider 1990).
    fn nearest(&self, point: DVec2, t: f64) -> f64 {
        let [a, b, c, d] = self.0;
        let mut t = t;
        for _ in 0..2 {
            let (off, first) = (self.at(t) - point, self.derivative(t));
            let second = 6.0 * ((1.0 - t) * (c - 2.0 * b + a) + t * (d - 2.0 * c + b));
            let (slope, bend) = (off.dot(first), first.length_squared() + off.dot(second));
            // Where the distance is not convex, its linear part is.
            let bend = if bend > 0.1 * first.length_squared() { bend } else { first.length_squared() };
            if bend <= 0.0 {
                break;
            }
            t = (t - (slope / bend).clamp(-0.2, 0.2)).clamp(0.0, 1.0);
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_a_segment_are_found_again() {
        let headings = [DVec2::from_angle(1.0), DVec2::from_angle(2.5)];
        for lengths in [[0.3, 0.5], [0.8, 0.2], [0.05, 0.6]] {
            let ends = [DVec2::ZERO, DVec2::X];
            let segment = Segment([ends[0], lengths[0] * headings[0], ends[1] + lengths[1] * headings[1], ends[1]]);
            let places: Vec<_> = (0..=400).map(|k| segment.at(f64::from(k) / 400.0)).collect();
            let mut along = vec![0.0];
            places.windows(2).for_each(|p| along.push(along[along.len() - 1] + p[0].distance(p[1])));
            let length = along[400];
            // Samples even in length: what a drawn line gives.
            let (mut points, mut shares) = (Vec::new(), Vec::new());
            for k in 1..40 {
                let share = f64::from(k) / 40.0;
                points.push(places[along.partition_point(|d| *d < share * length)]);
                shares.push(share);
            }
            let found = Planar { points: &points, ends, headings, length }.fit(&mut shares, 0.0);
            assert!(found.error < 1e-4, "{found:?} for {lengths:?}");
            assert!(found.lengths.iter().zip(lengths).all(|(a, b)| (a - b).abs() < 1e-2), "{found:?} for {lengths:?}");
        }
    }
}
