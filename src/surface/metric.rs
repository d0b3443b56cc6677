//! Lengths, angles and unfolding that keep their accuracy for needles.

use glam::DVec2;

/// Lengths of the sides of a triangle, sorted, give 16 · area² without cancellation (Kahan, "Miscalculating Area and
/// Angles of a Needle-like Triangle"). Zero for lengths that make no triangle.
#[inline]
fn sixteen_area_squared(a: f64, b: f64, c: f64) -> f64 {
    let (mut p, mut q, mut r) = (a, b, c);
    if p < q {
        std::mem::swap(&mut p, &mut q);
    }
    if q < r {
        std::mem::swap(&mut q, &mut r);
    }
    if p < q {
        std::mem::swap(&mut p, &mut q);
    }
    ((p + (q + r)) * (r - (p - q)) * (r + (p - q)) * (p + (q - r))).max(0.0)
}

/// Area of a triangle from the lengths of its sides.
#[inline]
pub(crate) fn area(a: f64, b: f64, c: f64) -> f64 {
    0.25 * sixteen_area_squared(a, b, c).sqrt()
}

/// Angle between the sides of lengths `a` and `b`, opposite the side of length `c`, in radians.
///
/// Kahan's half-angle formula, good for needles; 0 when `a` or `b` is 0.
pub(crate) fn corner_angle(a: f64, b: f64, c: f64) -> f64 {
    if a == 0.0 || b == 0.0 {
        return 0.0;
    }
    let (x, y) = if a >= b { (a, b) } else { (b, a) };
    let mu = if y >= c { c - (x - y) } else { y - (x - c) };
    let numerator = ((x - y) + c) * mu.max(0.0);
    let denominator = (x + (y + c)) * ((x - c) + y);
    if denominator > 0.0 { 2.0 * (numerator / denominator).sqrt().atan() } else { std::f64::consts::PI }
}

/// Places the third corner to the left of `a` → `b`.
///
/// `length` = |ab|, `la` = distance from a, `lb` = distance from b. A side of no length puts the corner above `a`.
#[inline]
pub(crate) fn apex(a: DVec2, b: DVec2, length: f64, la: f64, lb: f64) -> DVec2 {
    apex_over(a, b, [length, 1.0 / length], la, lb)
}

/// [`apex`], given the length of the side and one over it.
#[inline]
pub(crate) fn apex_over(a: DVec2, b: DVec2, [length, per_length]: [f64; 2], la: f64, lb: f64) -> DVec2 {
    if length <= 0.0 {
        return DVec2::new(a.x, a.y + la);
    }
    // (la − lb)(la + lb) instead of la² − lb²: the difference of squares cancels for needles.
    let x = 0.5 * ((la - lb) * (la + lb) * per_length + length);
    // By Pythagoras where that loses no more than two digits.
    let squared = (la - x) * (la + x);
    let y = if squared > 0.01 * la * la {
        squared.sqrt()
    } else {
        0.5 * sixteen_area_squared(la, lb, length).sqrt() * per_length
    };
    let u = (b - a) * per_length;
    DVec2::new(a.x + u.x * x - u.y * y, a.y + u.y * x + u.x * y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn right_triangle() {
        assert!((area(3.0, 4.0, 5.0) - 6.0).abs() < 1e-15);
        assert!((corner_angle(3.0, 4.0, 5.0) - PI / 2.0).abs() < 1e-15);
        let c = apex(DVec2::ZERO, DVec2::X * 3.0, 3.0, 5.0, 4.0);
        assert!((c - DVec2::new(3.0, 4.0)).length() < 1e-14);
    }

    #[test]
    fn needles_keep_relative_accuracy() {
        // Height 1e-9 over a base of 1, apex above the middle.
        let side = (0.25_f64 + 1e-18).sqrt();
        let c = apex(DVec2::ZERO, DVec2::X, 1.0, side, side);
        assert!(c.y >= 0.0 && c.y < 2e-8 && (c.x - 0.5).abs() < 1e-15);
        // A base of 1e-9 under an apex at height 1.
        assert!((corner_angle(1.0, 1.0, 1e-9) / 1e-9 - 1.0).abs() < 1e-12);
        assert!((area(1.0, 1.0, 1e-9) / 0.5e-9 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn degenerate_triangles_give_no_nan() {
        for (a, b, c) in
            [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 0.0, 1.0), (1.0, 2.0, 3.0), (3.0, 1.0, 2.0), (1.0, 1.0, 9.0)]
        {
            assert!(corner_angle(a, b, c).is_finite() && area(a, b, c).is_finite());
            assert!(apex(DVec2::ZERO, DVec2::X * c, c, a, b).is_finite());
        }
        assert_eq!(corner_angle(1.0, 2.0, 3.0), PI);
        assert_eq!(corner_angle(2.0, 3.0, 1.0), 0.0);
    }
}
