//! A place on a surface.

use super::FaceId;

/// Weights more negative than this are an error; milder ones are rounding and become zero.
const NEGATIVE_WEIGHT: f64 = -1e-9;

/// A place on a surface: an input face and barycentric weights of its three corners.
///
/// The weights are not negative and sum to one (within rounding). A weight of exactly zero puts the point on a side, two
/// zeros on a corner; such a point has one spelling a face around it, of which
/// [`Surface::canonical`](super::Surface::canonical) picks one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfacePoint {
    /// The input face.
    pub face: FaceId,
    /// Weights of the face's corners, in input order.
    pub weights: [f64; 3],
}

/// What a [`SurfacePoint`] lies on, as seen from its face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointElement {
    /// Inside the face.
    Face,
    /// On side `k`, which runs from corner k to corner k + 1.
    Edge(u8),
    /// On corner `k`.
    Vertex(u8),
}

/// Why weights do not name a place.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PointError {
    /// A weight is NaN, infinite or clearly negative, or the weights do not sum to one.
    #[error("weights {1:?} on {0} are not barycentric: give three numbers ≥ 0 that sum to 1")]
    BadWeights(FaceId, [f64; 3]),
    /// The surface has no such face.
    #[error("{0} does not exist: the input mesh has {1} faces")]
    NoSuchFace(FaceId, usize),
    /// A vector, a distance, a share or an angle is NaN or infinite.
    #[error("{0} at {1} is not finite: give finite numbers")]
    NotFinite(&'static str, FaceId),
    /// A tangent vector is spelled in a face that does not touch its point.
    #[error(
        "the tangent vector is spelled in {tangent}, which does not touch the point on {point}: spell it in a face around"
    )]
    ForeignTangent {
        /// The point's face.
        point: FaceId,
        /// The tangent's face.
        tangent: FaceId,
    },
    /// A path does not run through neighbouring faces, so it was made for another surface.
    #[error("the path breaks off at {0}: it was made for another surface; search it again")]
    BadCrossing(FaceId),
    /// The face was dropped when the surface was built, so it has no points.
    #[error("{0} was dropped when the surface was built: {1}")]
    FaceDropped(FaceId, super::DropReason),
}

impl SurfacePoint {
    /// Makes a point from the weights of the face's three corners.
    ///
    /// Weights between −1e-9 and 0 count as rounding and become 0; the rest is scaled to sum to one.
    ///
    /// # Errors
    /// [`PointError::BadWeights`] if a weight is not finite, or below −1e-9, or if the sum is off by more than 1e-6.
    pub fn new(face: FaceId, weights: [f64; 3]) -> Result<Self, PointError> {
        let bad = PointError::BadWeights(face, weights);
        if weights.iter().any(|w| !w.is_finite() || *w < NEGATIVE_WEIGHT) {
            return Err(bad);
        }
        let sum: f64 = weights.iter().sum();
        if (sum - 1.0).abs() > 1e-6 {
            return Err(bad);
        }
        if weights.iter().all(|w| *w >= 0.0) && (sum - 1.0).abs() <= 4.0 * f64::EPSILON {
            return Ok(Self { face, weights: weights.map(|w| w + 0.0) });
        }
        let clamped = weights.map(|w| w.max(0.0));
        let sum: f64 = clamped.iter().sum();
        Ok(Self { face, weights: clamped.map(|w| w / sum) })
    }

    /// Makes a point from the weights of the face's second and third corner.
    ///
    /// # Errors
    /// As [`SurfacePoint::new`].
    pub fn from_uv(face: FaceId, u: f64, v: f64) -> Result<Self, PointError> {
        Self::new(face, [1.0 - u - v, u, v])
    }

    /// What the point lies on, calling a weight at most `tolerance` (of one) zero. The point itself is not changed.
    pub fn element(&self, tolerance: f64) -> PointElement {
        let zero = self.weights.map(|w| w <= tolerance);
        match zero {
            [false, true, true] => PointElement::Vertex(0),
            [true, false, true] => PointElement::Vertex(1),
            [true, true, false] => PointElement::Vertex(2),
            [false, false, true] => PointElement::Edge(0),
            [true, false, false] => PointElement::Edge(1),
            [false, true, false] => PointElement::Edge(2),
            _ => PointElement::Face,
        }
    }

    /// The same bits: face and weights.
    pub(crate) fn same_bits(&self, other: &Self) -> bool {
        self.face == other.face && self.weights.map(f64::to_bits) == other.weights.map(f64::to_bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_checked_and_cleaned() {
        let p = SurfacePoint::new(FaceId(3), [0.5, 0.5 + 1e-10, -1e-10]).unwrap();
        assert_eq!(p.weights[2], 0.0);
        assert!((p.weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        for bad in [[f64::NAN, 0.0, 1.0], [1.1, -0.1, 0.0], [0.5, 0.5, 0.5], [f64::INFINITY, 0.0, 0.0]] {
            assert!(SurfacePoint::new(FaceId(0), bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn elements_are_named_without_moving_the_point() {
        let p = SurfacePoint::new(FaceId(0), [1.0 - 1e-12, 1e-12, 0.0]).unwrap();
        assert_eq!(p.element(1e-10), PointElement::Vertex(0));
        assert_eq!(p.element(0.0), PointElement::Edge(0));
        assert_eq!(p.weights[1], 1e-12);
        assert_eq!(SurfacePoint::from_uv(FaceId(0), 0.0, 0.5).unwrap().element(0.0), PointElement::Edge(2));
    }
}
