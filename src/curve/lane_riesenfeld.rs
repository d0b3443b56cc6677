//! Open-uniform Lane–Riesenfeld subdivision (Mancinelli et al. 2022, sec. 3.6, with the stencils for the first levels and
//! the corrected index ranges).
//!
//! A level with N intervals has N + 3 control points; interval i is governed by points i … i + 3, and its children are
//! intervals 2i and 2i + 1 of the next level.

use super::{
    average::{Averager, Span},
    casteljau::{self, Legs},
};
use crate::geodesic::{PathError, inner::InnerPath};
use crate::surface::InnerPoint;

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

/// The stencil of point `i` of the level that follows one with `n` intervals.
fn stencil(n: usize, i: usize) -> Stencil {
    use Stencil::{Across, First, Last, On};
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
        (_, i) if i % 2 == 0 => On(i / 2, 0.5),
        (_, i) => Across(i / 2, 0.75, 0.25),
    }
}

/// A point of the next level, with the path it is the middle of, if it is made of two legs.
struct Made {
    stencil: Stencil,
    point: InnerPoint,
    across: Option<InnerPath>,
}

/// Makes point `i` of the next level; `legs[0]` is leg `offset` of this one.
fn make(averager: &mut Averager<'_>, n: usize, i: usize, legs: &[InnerPath], offset: usize) -> Result<Made, PathError> {
    let stencil = stencil(n, i);
    let (point, across) = match stencil {
        Stencil::First => (legs[0].start, None),
        Stencil::Last => (legs[legs.len() - 1].end, None),
        Stencil::On(j, share) => (averager.point(&legs[j - offset], share), None),
        Stencil::Across(j, from, to) => {
            let (first, second) = (&legs[j - offset], &legs[j + 1 - offset]);
            let path = averager.bridge(Span::new(first, from, 1.0), Span::new(second, 0.0, to))?;
            (averager.point(&path, 0.5), Some(path))
        }
    };
    Ok(Made { stencil, point, across })
}

/// The leg between two consecutive points of the next level, cut out of or bridged over legs of this one.
fn join(
    averager: &mut Averager<'_>,
    made: [&Made; 2],
    legs: &[InnerPath],
    offset: usize,
) -> Result<InnerPath, PathError> {
    use Stencil::{Across, First, Last, On};
    let surface = averager.surface;
    let leg = |j: usize| &legs[j - offset];
    let [from, to] = made;
    match (from.stencil, &from.across, to.stencil, &to.across) {
        (First, _, On(j, share), _) => Ok(leg(j).piece(surface, 0.0, share)),
        (On(j, share), _, Last, _) => Ok(leg(j).piece(surface, share, 1.0)),
        (On(j, a), _, On(k, b), _) if j == k => Ok(leg(j).piece(surface, a, b)),
        (On(j, a), _, On(k, b), _) => averager.bridge(Span::new(leg(j), a, 1.0), Span::new(leg(k), 0.0, b)),
        (On(j, a), _, Across(_, b, _), Some(path)) => {
            averager.bridge(Span::new(leg(j), a, b), Span::new(path, 0.0, 0.5))
        }
        (Across(_, _, a), Some(path), On(k, b), _) => {
            averager.bridge(Span::new(path, 0.5, 1.0), Span::new(leg(k), a, b))
        }
        _ => averager.leg(&from.point, &to.point),
    }
}

/// The points of the level after `levels` steps; `legs` receives the legs between them if `joined`, else those of the
/// level before.
pub(crate) fn trace(
    averager: &mut Averager<'_>,
    legs: &mut Vec<InnerPath>,
    levels: u8,
    joined: bool,
    points: &mut Vec<InnerPoint>,
) -> Result<(), PathError> {
    points.clear();
    points.extend(legs.iter().map(|leg| leg.start));
    points.extend(legs.last().map(|leg| leg.end));
    for level in 0..levels {
        let n = 1_usize << level;
        let made: Vec<Made> =
            (0..2 * n + 3).map(|i| make(averager, n, i, legs, 0)).collect::<Result<_, PathError>>()?;
        points.clear();
        points.extend(made.iter().map(|m| m.point));
        if joined || level + 1 < levels {
            *legs = made
                .windows(2)
                .map(|pair| join(averager, [&pair[0], &pair[1]], legs, 0))
                .collect::<Result<_, PathError>>()?;
        }
    }
    Ok(())
}

/// Parameter of control point `i` of a level with `n` intervals: the mean of its three knots (Greville).
pub(crate) fn parameter(n: usize, i: usize) -> f64 {
    let knot = |k: usize| k.saturating_sub(2).min(n) as f64;
    (knot(i) + knot(i + 1) + knot(i + 2)) / (3.0 * n as f64)
}

/// The limit curve's point at `t`: descends into the interval of `t` until its polygon is short and nearly straight, turns
/// that into a Bézier polygon, and averages directly.
pub(crate) fn evaluate(averager: &mut Averager<'_>, legs: Legs, t: f64) -> Result<InnerPoint, PathError> {
    const MAX_LEVELS: u32 = 12;
    let t = t.clamp(0.0, 1.0);
    if t == 0.0 {
        return Ok(legs[0].start);
    }
    if t == 1.0 {
        return Ok(legs[2].end);
    }
    let (mut n, mut i, mut legs) = (1_usize, 0_usize, legs);
    for level in 0..MAX_LEVELS {
        // The rules that turn an interval into a Bézier polygon hold from four intervals on.
        if level >= 2 && casteljau::is_flat(averager, &legs) {
            break;
        }
        let child = ((t * (2 * n) as f64) as usize).clamp(2 * i, 2 * i + 1);
        let made: Vec<Made> =
            (child..child + 4).map(|k| make(averager, n, k, &legs, i)).collect::<Result<_, PathError>>()?;
        let next = [0, 1, 2].map(|k| join(averager, [&made[k], &made[k + 1]], &legs, i));
        let [a, b, c] = next;
        legs = [a?, b?, c?];
        (n, i) = (2 * n, child);
    }
    let polygon = bezier_of_interval(averager, &legs, n, i)?;
    casteljau::direct(averager, &polygon, (t * n as f64 - i as f64).clamp(0.0, 1.0))
}

/// The Bézier polygon of interval `i` of `n` ≥ 4 by its blossom; exact in the plane.
fn bezier_of_interval(averager: &mut Averager<'_>, [l0, l1, l2]: &Legs, n: usize, i: usize) -> Result<Legs, PathError> {
    const THIRD: f64 = 1.0 / 3.0;
    let surface = averager.surface;
    let (first, last) = (i == 0, i + 1 == n);
    // Shares of the middle leg at which the inner control points lie.
    let (from, to) = if first {
        (0.0, 0.5)
    } else if last {
        (0.5, 1.0)
    } else {
        (THIRD, 2.0 * THIRD)
    };
    let middle = l1.piece(surface, from, to);
    let left = if first {
        l0.clone()
    } else {
        let share = if i == 1 { 0.5 } else { 2.0 * THIRD };
        averager.bridge(Span::new(l0, share, 1.0), Span::new(l1, 0.0, from))?.piece(surface, 0.5, 1.0)
    };
    let right = if last {
        l2.clone()
    } else {
        let share = if i + 2 == n { 0.5 } else { THIRD };
        averager.bridge(Span::new(l1, to, 1.0), Span::new(l2, 0.0, share))?.piece(surface, 0.0, 0.5)
    };
    Ok([left, middle, right])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Applies the stencils to numbers on a line.
    fn subdivide(points: &[f64]) -> Vec<f64> {
        let n = points.len() - 3;
        let on = |j: usize, share: f64| points[j] + share * (points[j + 1] - points[j]);
        (0..2 * n + 3)
            .map(|i| match stencil(n, i) {
                Stencil::First => points[0],
                Stencil::Last => points[n + 2],
                Stencil::On(j, share) => on(j, share),
                Stencil::Across(j, a, b) => 0.5 * (on(j, a) + on(j + 1, b)),
            })
            .collect()
    }

    /// Knot insertion at all middles (Oslo/Boehm), one knot at a time.
    fn insert_knots(points: &[f64]) -> Vec<f64> {
        let n = points.len() - 3;
        let mut knots: Vec<f64> = [vec![0.0; 3], (0..=n).map(|k| k as f64).collect(), vec![n as f64; 3]].concat();
        let mut points = points.to_vec();
        for k in 0..n {
            let u = k as f64 + 0.5;
            let span = knots.partition_point(|x| *x <= u) - 1;
            let old = points.clone();
            points.insert(span, 0.0);
            for i in span - 2..=span {
                let a = (u - knots[i]) / (knots[i + 3] - knots[i]);
                points[i] = (1.0 - a) * old[i - 1] + a * old[i];
            }
            points[span + 1..].copy_from_slice(&old[span..]);
            knots.insert(span + 1, u);
        }
        points
    }

    #[test]
    fn stencils_are_knot_insertion() {
        for n in [1, 2, 4, 8, 16] {
            for one in 0..n + 3 {
                let points: Vec<f64> = (0..n + 3).map(|i| f64::from(u8::from(i == one))).collect();
                let (ours, exact) = (subdivide(&points), insert_knots(&points));
                for (i, (a, b)) in ours.iter().zip(&exact).enumerate() {
                    assert!((a - b).abs() < 1e-15, "n {n} point {one} of {i}: {a} for {b}");
                }
            }
        }
    }

    #[test]
    fn stencils_are_symmetric() {
        for n in [1, 2, 4, 8] {
            let points: Vec<f64> = (0..n + 3).map(|i| ((i * i * 7 + 3 * i) % 11) as f64).collect();
            let reversed: Vec<f64> = points.iter().rev().copied().collect();
            let mut mirrored = subdivide(&reversed);
            mirrored.reverse();
            assert_eq!(subdivide(&points), mirrored);
        }
    }

    #[test]
    fn parameters_are_means_of_knots() {
        let of = |n: usize| (0..n + 3).map(|i| parameter(n, i) * n as f64).collect::<Vec<_>>();
        assert_eq!(of(1), [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]);
        assert_eq!(of(4), [0.0, 1.0 / 3.0, 1.0, 2.0, 3.0, 11.0 / 3.0, 4.0]);
    }
}
