//! Simple ways to move splines along with handles, to compare with.
//!
//! None keeps joins: they are what one would do without a solve.

use glam::{DAffine3, DMat3, DVec3};

use super::bound::point;
use super::energy::skinned;
use super::quadrature::bernstein;
use super::{Chain, WeightField};

/// A simple way to move control points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub enum NaiveWay {
    /// Every control point is skinned like a place of the curve.
    ControlPoints,
    /// Anchors are skinned, and handles move with the blended transform of their anchor.
    Anchors,
    /// Anchors are skinned, and handles are mapped by the derivative of the deformation there.
    Jacobian,
    /// Each segment is sampled, and a cubic fitted to what becomes of the samples; its ends stay on the first and the last.
    Refit,
}

impl NaiveWay {
    /// All ways.
    pub const ALL: [Self; 4] = [Self::ControlPoints, Self::Anchors, Self::Jacobian, Self::Refit];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::ControlPoints => "control points",
            Self::Anchors => "anchors",
            Self::Jacobian => "jacobian",
            Self::Refit => "refit",
        }
    }

    /// The control points of a chain in a pose, with one transform for each handle.
    pub fn pose(self, chain: &Chain, weights: &dyn WeightField, transforms: &[DAffine3]) -> Vec<DVec3> {
        let mut scratch = Vec::new();
        let mut moved = |place: DVec3| skinned(weights, transforms, place, &mut scratch);
        let mut out: Vec<DVec3> = chain.points().to_vec();
        let n = out.len();
        match self {
            Self::ControlPoints => out.iter_mut().for_each(|p| *p = moved(*p)),
            Self::Anchors | Self::Jacobian => {
                // A step at which differences lose as much by rounding as by the field's third derivatives.
                let step = 1e-5 * chain.extent();
                for at in (0..n).step_by(3) {
                    let anchor = chain.points()[at];
                    let place = moved(anchor);
                    let linear = if self == Self::Anchors {
                        blended(weights, transforms, anchor)
                    } else {
                        let mut slope = |axis: DVec3| {
                            (moved(anchor + axis * step) - moved(anchor - axis * step)) / (2.0 * step).max(1e-300)
                        };
                        DMat3::from_cols(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
                    };
                    let before = if at > 0 { Some(at - 1) } else { chain.is_closed().then(|| n - 1) };
                    for handle in before.into_iter().chain(Some(at + 1).filter(|h| *h < n)) {
                        out[handle] = place + linear * (chain.points()[handle] - anchor);
                    }
                    out[at] = place;
                }
            }
            Self::Refit => {
                for segment in 0..chain.segment_count() {
                    let fitted = refit(&chain.segment(segment), &mut moved);
                    for (place, p) in chain.places(segment).into_iter().zip(fitted) {
                        out[place] = p;
                    }
                }
            }
        }
        if !chain.is_spatial() {
            out.iter_mut().for_each(|p| p.z = 0.0);
        }
        out
    }
}

fn blended(weights: &dyn WeightField, transforms: &[DAffine3], place: DVec3) -> DMat3 {
    let mut of_handles = vec![0.0; weights.handle_count()];
    weights.weights_at(place, &mut of_handles);
    let sum: f64 = of_handles.iter().sum();
    of_handles.iter().zip(transforms).fold(DMat3::ZERO, |all, (w, transform)| all + transform.matrix3 * (w / sum))
}

/// A cubic through the first and the last sample whose inner control points are nearest to the others, by least squares (after Schneider
/// 1990, with handles free in direction).
fn refit(rest: &[DVec3; 4], moved: &mut impl FnMut(DVec3) -> DVec3) -> [DVec3; 4] {
    const SAMPLES: u32 = 100;
    let (first, last) = (moved(rest[0]), moved(rest[3]));
    let (mut a, mut b, mut c) = (0.0, 0.0, 0.0);
    let (mut u, mut v) = (DVec3::ZERO, DVec3::ZERO);
    for i in 1..SAMPLES {
        let m = bernstein(f64::from(i) / f64::from(SAMPLES));
        let left = moved(point(rest, &m)) - first * m[0] - last * m[3];
        a += m[1] * m[1];
        b += m[1] * m[2];
        c += m[2] * m[2];
        u += left * m[1];
        v += left * m[2];
    }
    let determinant = a * c - b * b;
    [first, (u * c - v * b) / determinant, (v * a - u * b) / determinant, last]
}
