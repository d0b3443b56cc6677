//! The plane laid onto a surface about a point: polar coordinates, and axes carried along.

use glam::{DVec2, DVec3};

use super::{PlaceError, Placement};
use crate::curve::handles::MAX_LENGTH;
use crate::geodesic::{
    WalkStop,
    inner::InnerPath,
    tangent::{InnerTangent, turn_at},
    walk::walk_in,
};
use crate::surface::{InnerPoint, Surface, Zeros};

/// The plane of a drawing laid onto a surface.
pub(super) struct Frame<'s> {
    pub(super) surface: &'s Surface,
    at: InnerPoint,
    /// Upward at the centre, of unit length.
    up: InnerTangent,
    scale: f64,
    origin: DVec2,
}

/// Where a point of the plane came to lie.
pub(super) struct Landing {
    pub(super) at: InnerPoint,
    /// Direction of the walk at its end, and what it is in the plane; both of unit length.
    heading: InnerTangent,
    planar: DVec2,
}

/// Why a point of the plane has no place on the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Miss {
    /// The walk to it leaves the surface.
    Stopped(WalkStop),
    /// It is too far away.
    TooFar,
}

impl<'s> Frame<'s> {
    pub(super) fn new(surface: &'s Surface, placement: &Placement, origin: DVec2) -> Result<Self, PlaceError> {
        let Placement { at, up, scale } = *placement;
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(PlaceError::BadScale { scale });
        }
        if !origin.is_finite() {
            return Err(PlaceError::BadOrigin);
        }
        // A hair of a direction is rounding.
        let unit = up / up.abs().max_element();
        let unit = if unit.is_finite() { unit.normalize() } else { DVec3::ZERO };
        let (point, tangent) = surface.inner_tangent_at(&at, &surface.tangent(&at, unit)?)?;
        if tangent.vector.length() < 1e-9 {
            return Err(PlaceError::NoUp { up });
        }
        let up = InnerTangent { face: tangent.face, vector: tangent.vector.normalize() };
        Ok(Self { surface, at: point, up, scale, origin })
    }

    /// The point that the plane touches, and what is up there.
    pub(super) fn centre(&self) -> (InnerPoint, InnerTangent) {
        (self.at, self.up)
    }

    /// A vector of the drawing (y down) as one of the plane (y up), in the surface's unit.
    pub(super) fn planar(&self, vector: DVec2) -> DVec2 {
        DVec2::new(vector.x, -vector.y) * self.scale
    }

    /// Walks to a point of the drawing; `spare` is overwritten.
    pub(super) fn land(&self, point: DVec2, spare: &mut InnerPath) -> Result<Landing, Miss> {
        let away = self.planar(point - self.origin);
        let distance = away.length();
        if distance.is_nan() || distance > MAX_LENGTH * self.surface.diagonal() {
            return Err(Miss::TooFar);
        }
        let planar = away.try_normalize().unwrap_or(DVec2::Y);
        let heading = InnerTangent { face: self.up.face, vector: from_up(self.up.vector, planar) };
        let walk = walk_in(self.surface, &self.at, &heading, distance, std::mem::take(spare));
        let landing = Landing { at: walk.path.end, heading: walk.heading, planar };
        *spare = walk.path;
        match walk.stopped {
            None => Ok(landing),
            // Rounding may stop a walk right at its end, on the boundary.
            Some(_) if spare.length >= distance * (1.0 - 1e-12) => Ok(landing),
            Some(stop) => Err(Miss::Stopped(stop)),
        }
    }

    /// A vector of the plane as a tangent vector where something landed: the axes of the plane are carried along the walk.
    pub(super) fn tangent(&self, landing: &Landing, vector: DVec2) -> InnerTangent {
        // The vector as seen by who walks: along the walk, and to its left.
        let seen = DVec2::new(landing.planar.x, -landing.planar.y).rotate(vector);
        if matches!(landing.at.zeros(), Zeros::Corner(_)) {
            // About a vertex, angles are shares of its total angle.
            let ahead = InnerTangent { face: landing.heading.face, vector: landing.heading.vector * vector.length() };
            return turn_at(self.surface, &landing.at, &ahead, seen.y.atan2(seen.x));
        }
        InnerTangent { face: landing.heading.face, vector: landing.heading.vector.rotate(seen) }
    }
}

/// The direction that has some coordinates where y runs along `up`.
fn from_up(up: DVec2, planar: DVec2) -> DVec2 {
    planar.x * -up.perp() + planar.y * up
}
