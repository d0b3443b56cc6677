//! Turns between the handles of a join, and how they turn along with a deformation in space.

use glam::{DMat3, DVec3};

/// A transform whose smallest stretch is below this share of its largest says nothing of how it turns.
const FLAT: f64 = 1e-6;

/// What ties the outgoing handle of a join to the incoming one at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tie {
    /// Length of the outgoing handle over that of the incoming one.
    pub(crate) ratio: f64,
    /// Takes the direction of the incoming handle to that of the outgoing one.
    pub(crate) turn: DMat3,
    /// Whether the ratio is free in flexible poses.
    pub(crate) flexible: bool,
    /// Whether the turn is not just a half turn.
    pub(crate) turned: bool,
}

/// The turn about their common normal that takes one direction to another; in the plane z = 0 it is one of that plane. Directions that are
/// opposite give −1, which is a half turn whatever its axis.
pub(crate) fn turn_between(from: DVec3, to: DVec3, spatial: bool) -> DMat3 {
    let (normal, cosine) = (from.cross(to), from.dot(to));
    if !spatial {
        let (cosine, sine) = unit(cosine, normal.z);
        return DMat3::from_cols(DVec3::new(cosine, sine, 0.0), DVec3::new(-sine, cosine, 0.0), DVec3::Z);
    }
    let sine = normal.length();
    if sine < 1e-12 * from.length() * to.length() {
        return if cosine > 0.0 { DMat3::IDENTITY } else { -DMat3::IDENTITY };
    }
    DMat3::from_axis_angle(normal / sine, sine.atan2(cosine))
}

fn unit(cosine: f64, sine: f64) -> (f64, f64) {
    let length = cosine.hypot(sine);
    if length > 0.0 { (cosine / length, sine / length) } else { (1.0, 0.0) }
}

/// The orthogonal factor of a matrix (polar decomposition), by Higham's scaled Newton iteration; none if the matrix is flat.
///
/// It mirrors where the matrix does: forcing it to be a rotation would turn joins the wrong way under mirrored transforms.
pub(crate) fn orthogonal_factor(matrix: DMat3) -> Option<DMat3> {
    let largest = matrix.to_cols_array().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let mut q = matrix * (1.0 / largest);
    for step in 0..30 {
        let inverse = q.inverse();
        if !inverse.is_finite() {
            return None;
        }
        let (size, inverse_size) = (frobenius(q), frobenius(inverse));
        // Between the ratio of stretches and three times that.
        if step == 0 && size * inverse_size > 1.0 / FLAT {
            return None;
        }
        let scale = (inverse_size / size).sqrt();
        let next = 0.5 * (q * scale + inverse.transpose() * (1.0 / scale));
        let moved = frobenius(next - q);
        q = next;
        if moved < 1e-15 {
            break;
        }
    }
    Some(q)
}

fn frobenius(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn off(a: DMat3, b: DMat3) -> f64 {
        frobenius(a - b)
    }

    #[test]
    fn turns_take_one_direction_to_the_other() {
        for (from, to) in [(DVec3::X, DVec3::Y), (DVec3::X, -DVec3::X), (DVec3::ONE, DVec3::ONE)] {
            let turn = turn_between(from, to, true);
            assert!((turn * from.normalize()).distance(to.normalize()) < 1e-15);
            let (from, to) = (from.truncate().extend(0.0), to.truncate().extend(0.0));
            assert!((turn_between(from, to, false) * from.normalize()).distance(to.normalize()) < 1e-15);
        }
        let (from, to) = (DVec3::new(1.0, 2.0, -1.0), DVec3::new(0.3, -1.0, 2.0));
        let turn = turn_between(from, to, true);
        assert!((turn * from.normalize()).distance(to.normalize()) < 1e-15);
        assert!((turn.determinant() - 1.0).abs() < 1e-14 && off(turn * turn.transpose(), DMat3::IDENTITY) < 1e-14);
    }

    #[test]
    fn orthogonal_factors_leave_a_symmetric_positive_rest() {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 2.0);
        for mirror in [1.0, -1.0] {
            for stretch in [DVec3::ONE, DVec3::new(1.0, 0.1, 3.0), DVec3::new(1.0, 1e-5, 1.0)] {
                let side = DMat3::from_axis_angle(DVec3::Y, 0.4);
                let symmetric = side * DMat3::from_diagonal(stretch) * side.transpose();
                let q = orthogonal_factor(turn * (symmetric * mirror)).unwrap();
                assert!(off(q, turn * mirror) < 1e-9, "{mirror} {stretch} {}", off(q, turn * mirror));
            }
        }
        assert_eq!(orthogonal_factor(DMat3::from_diagonal(DVec3::new(1.0, 1e-7, 1.0))), None);
        assert_eq!(orthogonal_factor(DMat3::ZERO), None);
    }
}
