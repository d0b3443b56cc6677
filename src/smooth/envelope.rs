//! How far along a side a line may go without leaving what is near to where it was drawn.

use glam::DVec3;

use super::tree::LineTree;

/// The part of a segment, as shares of it, within a distance of a stretch; the set is convex, so that it is one interval.
fn within(a: DVec3, way: DVec3, [p, q]: [DVec3; 2], reach: f64) -> Option<[f64; 2]> {
    let mut found: Option<[f64; 2]> = None;
    let mut add = |from: f64, to: f64| {
        let (from, to) = (from.max(0.0), to.min(1.0));
        if from <= to {
            found = Some(found.map_or([from, to], |[a, b]| [a.min(from), b.max(to)]));
        }
    };
    // Within the balls about both ends.
    for end in [p, q] {
        if let Some([from, to]) =
            below(way.length_squared(), 2.0 * way.dot(a - end), a.distance_squared(end) - reach * reach)
        {
            add(from, to);
        }
    }
    // Within the cylinder between them.
    let axis = q - p;
    let length = axis.length();
    if length > 0.0 {
        let axis = axis / length;
        let (start, along) = ((a - p).dot(axis), way.dot(axis));
        let (off, beside) = ((a - p) - start * axis, way - along * axis);
        let slab = if along.abs() > 0.0 {
            let ends = [-start / along, (length - start) / along];
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        } else if (0.0..=length).contains(&start) {
            [0.0, 1.0]
        } else {
            [1.0, 0.0]
        };
        let inside = below(beside.length_squared(), 2.0 * off.dot(beside), off.length_squared() - reach * reach);
        if let Some([from, to]) = inside {
            add(from.max(slab[0]), to.min(slab[1]));
        }
    }
    found
}

/// Where a t² + b t + c ≤ 0, for a ≥ 0.
fn below(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    if a <= 1e-300 {
        return (c <= 0.0).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let root = b * b - 4.0 * a * c;
    if root < 0.0 {
        return None;
    }
    let q = -0.5 * (b + root.sqrt().copysign(b));
    let (x, y) = (q / a, if q == 0.0 { 0.0 } else { c / q });
    Some([x.min(y), x.max(y)])
}

/// The part of a segment about the share `at` that stays within a distance of a line; the place itself, where that is not.
pub(crate) fn interval(
    line: &LineTree,
    a: DVec3,
    way: DVec3,
    at: f64,
    reach: f64,
    pieces: &mut Vec<[f64; 2]>,
) -> Option<[f64; 2]> {
    pieces.clear();
    line.visit_near(a.min(a + way), a.max(a + way), reach, |p, q| pieces.extend(within(a, way, [p, q], reach)));
    pieces.sort_unstable_by(|x, y| x[0].total_cmp(&y[0]));
    const ROUNDING: f64 = 1e-9;
    let mut whole: Option<[f64; 2]> = None;
    for [from, to] in pieces.iter().copied() {
        match &mut whole {
            Some([_, end]) if from <= *end + ROUNDING => *end = end.max(to),
            Some([begin, end]) if (*begin - ROUNDING..=*end + ROUNDING).contains(&at) => break,
            _ => whole = Some([from, to]),
        }
    }
    whole.filter(|[from, to]| (*from - ROUNDING..=*to + ROUNDING).contains(&at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smooth::tests::Random;

    #[test]
    fn intervals_are_where_the_distance_is_small() {
        let mut random = Random(31);
        let mut point = || DVec3::new(random.next(), random.next(), random.next());
        let (mut tree, mut pieces) = (LineTree::default(), Vec::new());
        let mut inside = 0;
        for _ in 0..300 {
            let points: Vec<DVec3> = (0..6).map(|_| point()).collect();
            tree.build(&points);
            let (a, way, at, reach) = (point(), point() - point(), point().x, 0.3 * point().x);
            let off = |t: f64| tree.nearest(a + t * way, None).unwrap().distance - reach;
            match interval(&tree, a, way, at, reach, &mut pieces) {
                None => assert!(off(at) > -1e-9),
                Some([from, to]) => {
                    inside += 1;
                    for k in 0..=50 {
                        assert!(off(from + (to - from) * f64::from(k) / 50.0) < 1e-9);
                    }
                    assert!(from == 0.0 || off(from - 1e-6) > -1e-9, "{}", off(from - 1e-6));
                    assert!(to == 1.0 || off(to + 1e-6) > -1e-9, "{}", off(to + 1e-6));
                }
            }
        }
        assert!(inside > 30, "{inside}");
    }
}
