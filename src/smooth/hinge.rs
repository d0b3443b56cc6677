//! Where a line crosses the side between two triangles laid flat.
//!
//! The side lies on the y axis, its right end (seen in the direction of travel) at 0, and the line runs towards +x: the point
//! before is p with p.x ≤ 0, the point after is q with q.x ≥ 0. A turn is positive to the left, and smaller than π.

use std::f64::consts::PI;

use glam::DVec2;

/// Points nearer to the side's line than this share of their distance are on it.
const ON_LINE: f64 = 1e-14;

/// The turn of the line from `p` over the place `t` on the side to `q`: the angle to its right, less π.
pub(crate) fn turn(p: DVec2, t: f64, q: DVec2) -> f64 {
    let (before, after) = (p - DVec2::new(0.0, t), q - DVec2::new(0.0, t));
    // Angles from straight down, on either side of the axis; both lie between 0 and π.
    let right = (-before.x).max(0.0).atan2(-before.y) + after.x.max(0.0).atan2(-after.y);
    right - PI
}

/// Where the line from `p` to `q` crosses the side's line when it is straight; none where both lie on it.
pub(crate) fn straight(p: DVec2, q: DVec2) -> Option<f64> {
    let across = q.x - p.x;
    let scale = p.abs().max_element().max(q.abs().max_element());
    (across > ON_LINE * scale).then(|| (p.y * q.x - q.y * p.x) / across)
}

/// Where the line from `p` to `q` crosses the side's line when it turns there by `turn` to the left; none where both lie
/// on it. There is one such place for every turn between −π and π.
///
/// With Δ = q − p, Σ = p.x + q.x, s and c sine and cosine of the turn, the place lies Δt beyond the straight crossing, where
/// s Δt² − A Δt + p.x q.x s |Δ|² / Δ.x² = 0 and A = Σ s Δ.y / Δ.x + Δ.x c. The root is taken in the form that
/// does not cancel, so that small turns are as exact as large ones.
///
/// Source: Lawonn et al. 2014; Pawellek, code 4.9, whose form loses all digits near zero and returns a length as a weight.
pub(crate) fn turning(p: DVec2, q: DVec2, turn: f64) -> Option<f64> {
    let middle = straight(p, q)?;
    if turn == 0.0 {
        return Some(middle);
    }
    let (d, sum) = (q - p, p.x + q.x);
    let (s, c) = turn.sin_cos();
    let a = sum * (d.y / d.x) * s + d.x * c;
    let root = ((sum * c + d.y * s).powi(2) - 4.0 * p.x * q.x).max(0.0).sqrt();
    let beyond = if a >= 0.0 {
        2.0 * p.x * q.x * s * d.length_squared() / (d.x * d.x * (a + root))
    } else {
        (a - root) / (2.0 * s)
    };
    let place = middle + beyond;
    place.is_finite().then_some(place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smooth::tests::Random;

    #[test]
    fn places_known_in_closed_form() {
        let at = |p: [f64; 2], q: [f64; 2], turn: f64| turning(p.into(), q.into(), turn).unwrap();
        let level = |turn: f64| at([-1.0, 0.0], [1.0, 0.0], turn);
        for (turn, place) in [(PI / 2.0, -1.0), (-PI / 2.0, 1.0), (0.1, -0.050_041_708_4), (0.0, 0.0)] {
            assert!((level(turn) - place).abs() < 1e-10, "{turn}: {}", level(turn));
        }
        let slanted = |turn: f64| at([-1.0, 0.3], [0.7, -0.4], turn);
        for (turn, place) in [(0.0, -0.111_764_705_9), (0.5, -0.347_614_864_3), (-2.5, 2.590_436_262_6)] {
            assert!((slanted(turn) - place).abs() < 1e-10, "{turn}: {}", slanted(turn));
        }
        assert_eq!(turning(DVec2::new(0.0, 1.0), DVec2::new(0.0, 3.0), 0.3), None);
    }

    #[test]
    fn the_turn_asked_for_is_the_turn_got() {
        let mut random = Random(11);
        let mut worst = 0.0_f64;
        for _ in 0..200_000 {
            let p = DVec2::new(-0.01 - random.next(), 4.0 * random.next() - 2.0);
            let q = DVec2::new(0.01 + random.next(), 4.0 * random.next() - 2.0);
            let wanted = 6.0 * random.next() - 3.0;
            let place = turning(p, q, wanted).unwrap();
            worst = worst.max((turn(p, place, q) - wanted).abs());
        }
        println!("worst error of 200,000 turns (seed 11): {worst:e}");
        assert!(worst < 1e-12, "{worst:e}");
    }

    /// The form in print gives +0.06 instead of −4.8e-7 here, when computed with 32 bits.
    #[test]
    fn small_turns_keep_their_digits() {
        let mut random = Random(12);
        for _ in 0..10_000 {
            // As 32-bit positions give it.
            let single = |x: f64| f64::from(x as f32);
            let p = DVec2::new(single(-0.1 - random.next()), single(random.next()));
            let q = DVec2::new(single(0.1 + random.next()), single(random.next()));
            for small in [1e-6, -1e-8, 1e-12] {
                let moved = turning(p, q, small).unwrap() - straight(p, q).unwrap();
                let d = q - p;
                let expected = p.x * q.x * small * d.length_squared() / d.x.powi(3);
                let room = 1e-15 + 10.0 * (small * expected).abs();
                assert!((moved - expected).abs() <= room.max(2e-15), "{p} {q} {small}: {moved:e} {expected:e}");
            }
        }
    }

    #[test]
    fn left_is_positive_in_every_pose() {
        // A line that turns left, over sides of either slope, and its mirror image.
        for y in [-0.7, 0.0, 0.4] {
            let (p, q) = (DVec2::new(-1.0, y), DVec2::new(1.0, y));
            assert!(turn(p, y - 0.5, q) > 0.5 && turn(p, y + 0.5, q) < -0.5);
            assert!((turn(p, y - 0.5, q) + turn(p, y + 0.5, q)).abs() < 1e-15);
            assert!(turn(p, y, q).abs() < 1e-15);
        }
    }
}
