//! Weights by distance.

use glam::{DVec2, DVec3};

use super::WeightField;
use crate::skin::SkinError;

/// What a handle is held by.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub enum HandleShape {
    /// A point.
    Point(DVec3),
    /// A bone between two points.
    Bone(DVec3, DVec3),
}

impl HandleShape {
    /// A point of the plane.
    pub fn planar(place: DVec2) -> Self {
        Self::Point(place.extend(0.0))
    }

    /// The ends: twice the same of a point.
    pub(crate) fn ends(&self) -> [DVec3; 2] {
        match *self {
            Self::Point(place) => [place; 2],
            Self::Bone(from, to) => [from, to],
        }
    }

    /// From the nearest place of the handle to a place.
    pub(crate) fn away(&self, place: DVec3) -> DVec3 {
        let [from, to] = self.ends();
        let along = to - from;
        let squared = along.length_squared();
        let t = if squared > 0.0 { ((place - from).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
        place - (from + along * t)
    }
}

/// Weights by a power of the distance to each handle (Shepard 1968).
///
/// A place at a handle moves with that handle alone. Weights are smooth everywhere, reach everywhere, and cost a few operations for each handle.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct Shepard {
    handles: Vec<HandleShape>,
    power: f64,
    /// Squared distance below which a place is at a handle.
    at_handle: f64,
}

impl Shepard {
    /// Weights that fall with the square of the distance.
    ///
    /// # Errors
    /// [`SkinError::NoHandles`], [`SkinError::HandleNotFinite`].
    pub fn new(handles: &[HandleShape]) -> Result<Self, SkinError> {
        Self::with_power(handles, 2.0)
    }

    /// Weights that fall with a power of the distance, from 1 to 8.
    ///
    /// # Errors
    /// [`SkinError::NoHandles`], [`SkinError::HandleNotFinite`].
    pub fn with_power(handles: &[HandleShape], power: f64) -> Result<Self, SkinError> {
        if handles.is_empty() {
            return Err(SkinError::NoHandles);
        }
        let ends = || handles.iter().flat_map(HandleShape::ends);
        if let Some(end) = ends().position(|end| !end.is_finite()) {
            return Err(SkinError::HandleNotFinite { handle: end / 2 });
        }
        let low = ends().fold(DVec3::MAX, DVec3::min);
        let high = ends().fold(DVec3::MIN, DVec3::max);
        let size = low.distance(high).max(low.length().max(high.length()) * 1e-6);
        let power = if power.is_finite() { power.clamp(1.0, 8.0) } else { 2.0 };
        Ok(Self { handles: handles.to_vec(), power, at_handle: 1e-12 * size * size })
    }
}

impl WeightField for Shepard {
    fn handle_count(&self) -> usize {
        self.handles.len()
    }

    fn weights_at(&self, place: DVec3, out: &mut [f64]) {
        // Relative to the smallest distance, so that no power overflows.
        let mut least = f64::INFINITY;
        for (out, handle) in out.iter_mut().zip(&self.handles) {
            *out = handle.away(place).length_squared();
            least = least.min(*out);
        }
        if least <= self.at_handle {
            // The first, if there are several.
            let mut is_taken = false;
            for out in out {
                let is_it = *out <= least && !is_taken;
                is_taken |= is_it;
                *out = f64::from(is_it);
            }
        } else if self.power == 2.0 {
            out.iter_mut().for_each(|out| *out = least / *out);
        } else {
            out.iter_mut().for_each(|out| *out = (least / *out).powf(0.5 * self.power));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_fall_with_the_square_of_the_distance() {
        let handles = [HandleShape::Point(DVec3::ZERO), HandleShape::Bone(DVec3::new(4.0, -1.0, 0.0), DVec3::X * 4.0)];
        let field = Shepard::new(&handles).unwrap();
        let mut out = [0.0; 2];
        field.weights_at(DVec3::new(1.0, 0.0, 0.0), &mut out);
        assert!((out[0] / out[1] - 9.0).abs() < 1e-12);
        field.weights_at(DVec3::new(4.0, -0.5, 3.0), &mut out);
        assert!((out[1] / out[0] - (16.0 + 0.25 + 9.0) / 9.0).abs() < 1e-12);
        field.weights_at(DVec3::ZERO, &mut out);
        assert_eq!(out, [1.0, 0.0]);
        field.weights_at(DVec3::splat(1e100), &mut out);
        assert!((out[0] / out[1] - 1.0).abs() < 1e-12, "{out:?}");
    }

    #[test]
    fn handles_that_are_nowhere_are_refused() {
        assert_eq!(Shepard::new(&[]), Err(SkinError::NoHandles));
        let handles = [HandleShape::Point(DVec3::ZERO), HandleShape::Bone(DVec3::ZERO, DVec3::NAN)];
        assert_eq!(Shepard::new(&handles), Err(SkinError::HandleNotFinite { handle: 1 }));
        let same = Shepard::new(&[HandleShape::Point(DVec3::ONE); 2]).unwrap();
        let mut out = [0.0; 2];
        same.weights_at(DVec3::ONE, &mut out);
        assert_eq!(out, [1.0, 0.0]);
    }
}
