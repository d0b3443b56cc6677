//! Lane–Riesenfeld subdivision of B-splines with uniform knots (Mancinelli et al. 2022, sec. 3.6, with the stencils for the
//! first levels and the corrected index ranges): cubic and quadratic, with clamped ends and periodic.
//!
//! A clamped chain of n intervals has n + degree control points, a periodic one n. Interval i is governed by points
//! i … i + degree, and its children are intervals 2i and 2i + 1 of the next level. A Bézier polygon is a clamped chain of one
//! interval.

use super::{
    average::{Averager, Span},
    casteljau::Legs,
};
use crate::geodesic::{
    PathError,
    inner::{InnerPath, Place},
    path_list::PathList,
};
use crate::surface::InnerPoint;

/// The knots of a B-spline: consecutive integers, repeated at clamped ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Knots {
    /// 2 or 3.
    pub(crate) degree: usize,
    /// Number of intervals.
    pub(crate) intervals: usize,
    pub(crate) periodic: bool,
}

impl Knots {
    /// Those of a Bézier polygon of some degree.
    pub(crate) const fn bezier(degree: usize) -> Self {
        Self { degree, intervals: 1, periodic: false }
    }

    /// Those of the next level.
    const fn doubled(self) -> Self {
        Self { intervals: 2 * self.intervals, ..self }
    }

    /// The shortest chain in which an interval has the same neighbourhood, and its place there: whatever is computed from
    /// that does not depend on what lies further away.
    pub(crate) fn around(self, interval: usize) -> (Self, usize) {
        if self.periodic {
            // No ends are near.
            return (Self { degree: self.degree, intervals: 2 * self.degree + 1, periodic: false }, self.degree);
        }
        let before = interval.min(self.degree);
        let after = (self.intervals - 1 - interval).min(self.degree);
        (Self { intervals: before + 1 + after, ..self }, before)
    }

    /// The knot at `i` intervals from the first, which may be negative.
    fn knot(self, i: isize) -> f64 {
        let clamped = if self.periodic { i } else { i.clamp(0, self.intervals as isize) };
        clamped as f64
    }

    /// Shares of the leg between the middle control points of an interval of a cubic at which its inner Bézier points lie.
    pub(crate) fn middle_shares(self, interval: usize) -> (f64, f64) {
        let i = interval as isize;
        let [before, after] = [-1, 2].map(|k| self.knot(i + k) - self.knot(i));
        (-before / (after - before), (1.0 - before) / (after - before))
    }

    /// Parameter of control point `i` in intervals: the mean of its knots (Greville).
    pub(crate) fn greville(self, i: usize) -> f64 {
        let (i, degree) = (i as isize, self.degree as isize);
        (0..degree).map(|k| self.knot(i + k + 1 - degree)).sum::<f64>() / degree as f64
    }
}

/// How a point of the next level is made from the legs of this one; leg j joins points j and j + 1.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stencil {
    /// The first point.
    First,
    /// The point at a share of leg j.
    On(usize, f64),
    /// The middle of the path from a share of leg j to a share of leg j + 1.
    Across(usize, f64, f64),
    /// The last point.
    Last,
}

/// The stencil of point `i` of the level that follows.
fn stencil(knots: Knots, i: usize) -> Stencil {
    use Stencil::{Across, First, Last, On};
    let n = knots.intervals;
    let regular = match (knots.degree, i % 2) {
        (2, 0) => On(i / 2, 0.25),
        (2, _) => On(i / 2, 0.75),
        (_, 0) => On(i / 2, 0.5),
        (_, _) => Across(i / 2, 0.75, 0.25),
    };
    if knots.periodic {
        return regular;
    }
    if knots.degree == 2 {
        return match i {
            0 => First,
            1 => On(0, 0.5),
            i if i > 2 * n => Last,
            i if i == 2 * n => On(n, 0.5),
            _ => regular,
        };
    }
    let last = 2 * n + 2;
    match (n, i) {
        (_, 0) => First,
        (_, i) if i >= last => Last,
        (1, i) => On(i - 1, 0.5),
        (_, 1) => On(0, 0.5),
        (_, 2) => On(1, 0.25),
        (2, 3) => Across(1, 0.625, 0.375),
        (_, 3) => Across(1, 0.625, 0.25),
        (_, i) if i == last - 1 => On(n + 1, 0.5),
        (_, i) if i == last - 2 => On(n, 0.75),
        (_, i) if i == last - 3 => Across(n - 1, 0.75, 0.375),
        _ => regular,
    }
}

/// A point of the next level.
#[derive(Clone, Copy, Debug)]
struct Made {
    stencil: Stencil,
    /// On its leg, or on the path that it is the middle of.
    place: Place,
    /// Where the path that it is the middle of begins and ends, on the two legs.
    ends: [Place; 2],
}

/// Makes point `i` of the next level; `legs[0]` is leg `offset` of this one. A point made of two legs is the middle of the path
/// `across`.
fn make(
    averager: &mut Averager<'_>,
    knots: Knots,
    i: usize,
    legs: &[InnerPath],
    offset: usize,
    across: &mut InnerPath,
) -> Result<Made, PathError> {
    let (surface, stencil) = (averager.surface, stencil(knots, i));
    let at_one = |place: Place| Made { stencil, place, ends: [place; 2] };
    Ok(match stencil {
        Stencil::First => at_one(legs[0].first()),
        Stencil::Last => at_one(legs[legs.len() - 1].last()),
        Stencil::On(j, share) => at_one(legs[j - offset].at_share(surface, share)),
        Stencil::Across(j, from, to) => {
            let (first, second) = (&legs[j - offset], &legs[j + 1 - offset]);
            let ends = [first.at_share(surface, from), second.at_share(surface, to)];
            let to_joint = Span { leg: first, from: ends[0], to: first.last() };
            averager.bridge_into(to_joint, Span { leg: second, from: second.first(), to: ends[1] }, across)?;
            Made { stencil, place: across.at_share(surface, 0.5), ends }
        }
    })
}

/// Point `i` of the next level, if no level follows.
fn last_point(
    averager: &mut Averager<'_>,
    knots: Knots,
    i: usize,
    legs: &[InnerPath],
    across: &mut InnerPath,
) -> Result<InnerPoint, PathError> {
    Ok(match stencil(knots, i) {
        Stencil::On(j, share) => legs[j].at_share(averager.surface, share).1,
        _ => make(averager, knots, i, legs, 0, across)?.place.1,
    })
}

/// The leg between two consecutive points of the next level, cut out of or bridged over legs of this one, and the paths `across`
/// that the points are the middles of.
fn join(
    averager: &mut Averager<'_>,
    [from, to]: [&Made; 2],
    across: [&InnerPath; 2],
    legs: &[InnerPath],
    offset: usize,
    out: &mut InnerPath,
) -> Result<(), PathError> {
    use Stencil::{Across, First, Last, On};
    let surface = averager.surface;
    let leg = |j: usize| &legs[j - offset];
    match (from.stencil, to.stencil) {
        (First, On(j, _)) | (On(j, _), Last) => leg(j).piece_into(surface, from.place, to.place, out),
        (On(j, _), On(k, _)) if j == k => leg(j).piece_into(surface, from.place, to.place, out),
        (On(j, _), On(k, _)) => {
            let (first, second) = (leg(j), leg(k));
            let to_joint = Span { leg: first, from: from.place, to: first.last() };
            averager.bridge_into(to_joint, Span { leg: second, from: second.first(), to: to.place }, out)?;
        }
        (On(j, _), Across(..)) => {
            let (first, second) = (leg(j), across[1]);
            let to_joint = Span { leg: first, from: from.place, to: to.ends[0] };
            averager.bridge_into(to_joint, Span { leg: second, from: second.first(), to: to.place }, out)?;
        }
        (Across(..), On(k, _)) => {
            let (first, second) = (across[0], leg(k));
            let to_joint = Span { leg: first, from: from.place, to: first.last() };
            averager.bridge_into(to_joint, Span { leg: second, from: from.ends[1], to: to.place }, out)?;
        }
        _ => averager.leg_into(&from.place.1, &to.place.1, out)?,
    }
    Ok(())
}

/// Scratch memory of a trace.
#[derive(Debug, Default)]
pub(crate) struct Levels {
    /// Legs of the level that is reached.
    pub(crate) legs: PathList,
    next: PathList,
    /// For each point of the next level the path that it is the middle of, where there is one.
    across: PathList,
    made: Vec<Made>,
}

/// The points of the level after `levels` steps of a clamped chain, of which `scratch` holds the legs; it then holds the legs
/// between the points if `joined`, else those of the level before.
pub(crate) fn trace(
    averager: &mut Averager<'_>,
    scratch: &mut Levels,
    mut knots: Knots,
    levels: u8,
    joined: bool,
    points: &mut Vec<InnerPoint>,
) -> Result<(), PathError> {
    let Levels { legs, next, across, made } = scratch;
    points.clear();
    points.extend(legs.iter().map(|leg| leg.start));
    points.extend(legs.last().map(|leg| leg.end));
    for level in 0..levels {
        let count = 2 * knots.intervals + knots.degree;
        made.clear();
        across.clear();
        points.clear();
        if !joined && level + 1 == levels {
            let path = across.place();
            for i in 0..count {
                points.push(last_point(averager, knots, i, legs, path)?);
            }
            break;
        }
        for i in 0..count {
            made.push(make(averager, knots, i, legs, 0, across.place())?);
        }
        points.extend(made.iter().map(|m| m.place.1));
        next.clear();
        for (i, pair) in made.windows(2).enumerate() {
            join(averager, [&pair[0], &pair[1]], [&across[i], &across[i + 1]], legs, 0, next.place())?;
        }
        std::mem::swap(legs, next);
        knots = knots.doubled();
    }
    Ok(())
}

/// One interval of a B-spline, with the legs between its control points.
#[derive(Clone, Debug)]
pub(crate) struct Interval {
    pub(crate) knots: Knots,
    pub(crate) index: usize,
    pub(crate) legs: Legs,
}

impl Interval {
    /// The two intervals of the next level.
    pub(crate) fn halve(&self, averager: &mut Averager<'_>) -> Result<[Self; 2], PathError> {
        let (first, degree) = (2 * self.index, self.knots.degree);
        let mut across = vec![InnerPath::default(); degree + 2];
        let mut made = Vec::with_capacity(degree + 2);
        for (k, path) in across.iter_mut().enumerate() {
            made.push(make(averager, self.knots, first + k, &self.legs, self.index, path)?);
        }
        let mut left = vec![InnerPath::default(); degree + 1];
        for (k, leg) in left.iter_mut().enumerate() {
            let (made, across) = ([&made[k], &made[k + 1]], [&across[k], &across[k + 1]]);
            join(averager, made, across, &self.legs, self.index, leg)?;
        }
        let right = left[1..].to_vec();
        left.truncate(degree);
        let knots = self.knots.doubled();
        Ok([Self { knots, index: first, legs: left }, Self { knots, index: first + 1, legs: right }])
    }

    /// The Bézier polygon of the interval by its blossom; exact in the plane.
    ///
    /// Control point f(u, v, w) belongs to three consecutive knots; the Bézier points of [a, b] are f(a, a, a), f(a, a, b),
    /// f(a, b, b), f(b, b, b), and f is affine in each of its arguments.
    pub(crate) fn bezier(&self, averager: &mut Averager<'_>) -> Result<Legs, PathError> {
        let surface = averager.surface;
        // Knots are counted from a = 0, b = 1, which keeps shares equal wherever the interval lies.
        let i = self.index as isize;
        let knot = |k: isize| self.knots.knot(i + k) - self.knots.knot(i);
        let (before, after) = (knot(-1), knot(2));
        if self.knots.degree == 2 {
            let (from, to) = (-before / (1.0 - before), 1.0 / after);
            return Ok(vec![self.legs[0].piece(surface, from, 1.0), self.legs[1].piece(surface, 0.0, to)]);
        }
        let [l0, l1, l2] = [&self.legs[0], &self.legs[1], &self.legs[2]];
        let (from, to) = self.knots.middle_shares(self.index);
        let middle = l1.piece(surface, from, to);
        let share = -knot(-2) / (1.0 - knot(-2)); // of f(before, a, a) on the first leg
        let left = if from == 0.0 {
            l0.piece(surface, share, 1.0)
        } else {
            let path = averager.bridge(Span::new(surface, l0, share, 1.0), Span::new(surface, l1, 0.0, from))?;
            path.piece(surface, -before / (1.0 - before), 1.0)
        };
        let share = 1.0 / knot(3); // of f(b, b, after) on the last leg
        let right = if to == 1.0 {
            l2.piece(surface, 0.0, share)
        } else {
            let path = averager.bridge(Span::new(surface, l1, to, 1.0), Span::new(surface, l2, 0.0, share))?;
            path.piece(surface, 0.0, 1.0 / after)
        };
        Ok(vec![left, middle, right])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Applies the stencils to numbers on a line.
    fn subdivide(knots: Knots, points: &[f64]) -> Vec<f64> {
        let m = points.len();
        let on = |j: usize, share: f64| points[j % m] + share * (points[(j + 1) % m] - points[j % m]);
        let count = if knots.periodic { 2 * m } else { 2 * knots.intervals + knots.degree };
        (0..count)
            .map(|i| match stencil(knots, i) {
                Stencil::First => points[0],
                Stencil::Last => points[m - 1],
                Stencil::On(j, share) => on(j, share),
                Stencil::Across(j, a, b) => 0.5 * (on(j, a) + on(j + 1, b)),
            })
            .collect()
    }

    fn clamped(degree: usize, intervals: usize) -> Knots {
        Knots { degree, intervals, periodic: false }
    }

    /// Knot insertion at all middles (Oslo/Boehm), one knot at a time.
    fn insert_knots(degree: usize, points: &[f64]) -> Vec<f64> {
        let n = points.len() - degree;
        let ends = |at: f64| vec![at; degree];
        let mut knots: Vec<f64> = [ends(0.0), (0..=n).map(|k| k as f64).collect(), ends(n as f64)].concat();
        let mut points = points.to_vec();
        for k in 0..n {
            let u = k as f64 + 0.5;
            let span = knots.partition_point(|x| *x <= u) - 1;
            let old = points.clone();
            points.insert(span, 0.0);
            for i in span + 1 - degree..=span {
                let a = (u - knots[i]) / (knots[i + degree] - knots[i]);
                points[i] = (1.0 - a) * old[i - 1] + a * old[i];
            }
            points[span + 1..].copy_from_slice(&old[span..]);
            knots.insert(span + 1, u);
        }
        points
    }

    #[test]
    fn stencils_are_knot_insertion() {
        for (degree, n) in [2, 3].into_iter().flat_map(|d| [1, 2, 3, 4, 5, 6, 7, 8, 9, 16].map(|n| (d, n))) {
            for one in 0..n + degree {
                let points: Vec<f64> = (0..n + degree).map(|i| f64::from(u8::from(i == one))).collect();
                let (ours, exact) = (subdivide(clamped(degree, n), &points), insert_knots(degree, &points));
                assert_eq!(ours.len(), exact.len());
                for (i, (a, b)) in ours.iter().zip(&exact).enumerate() {
                    assert!((a - b).abs() < 1e-15, "degree {degree}, n {n}, point {one} of {i}: {a} for {b}");
                }
            }
        }
    }

    #[test]
    fn periodic_chains_are_the_middle_of_long_ones() {
        for degree in [2, 3] {
            let points = [3.0, -1.0, 4.0, 1.0, -5.0];
            let long: Vec<f64> = points.iter().cycle().take(20).copied().collect();
            let around = subdivide(Knots { degree, intervals: 5, periodic: true }, &points);
            let along = subdivide(clamped(degree, long.len() - degree), &long);
            assert_eq!(around[..], along[10..20]);
        }
    }

    #[test]
    fn stencils_are_symmetric() {
        for (degree, n) in [(2, 1), (2, 2), (2, 5), (3, 1), (3, 2), (3, 3), (3, 4), (3, 5), (3, 8)] {
            let points: Vec<f64> = (0..n + degree).map(|i| ((i * i * 7 + 3 * i) % 11) as f64).collect();
            let reversed: Vec<f64> = points.iter().rev().copied().collect();
            let mut mirrored = subdivide(clamped(degree, n), &reversed);
            mirrored.reverse();
            assert_eq!(subdivide(clamped(degree, n), &points), mirrored);
        }
    }

    #[test]
    fn parameters_are_means_of_knots() {
        let of = |knots: Knots, count: usize| (0..count).map(|i| knots.greville(i)).collect::<Vec<_>>();
        assert_eq!(of(clamped(3, 1), 4), [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]);
        assert_eq!(of(clamped(3, 4), 7), [0.0, 1.0 / 3.0, 1.0, 2.0, 3.0, 11.0 / 3.0, 4.0]);
        assert_eq!(of(clamped(2, 3), 5), [0.0, 0.5, 1.5, 2.5, 3.0]);
    }

    #[test]
    fn neighbourhoods_are_cut_short() {
        assert_eq!(clamped(3, 1).around(0), (clamped(3, 1), 0));
        assert_eq!(clamped(3, 5).around(4), (clamped(3, 4), 3));
        assert_eq!(clamped(3, 100).around(50), (clamped(3, 7), 3));
        assert_eq!(clamped(2, 100).around(1), (clamped(2, 4), 1));
        assert_eq!(Knots { degree: 3, intervals: 3, periodic: true }.around(2), (clamped(3, 7), 3));
    }
}
