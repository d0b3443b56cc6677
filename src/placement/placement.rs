//! Where and how a drawing lies on a surface.

use glam::DVec3;

use crate::geodesic::{PathError, PathFinder, WalkStop};
use crate::surface::{PointError, Surface, SurfacePoint};

/// Where and how a drawing lies on a surface: by its centre, its upward direction and its scale.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct Placement {
    /// Where the drawing's centre lies: that of its view box, unless the options name another point.
    pub at: SurfacePoint,
    /// Which way is up, in the surface's local space; projected onto the tangent plane, its length does not matter.
    pub up: DVec3,
    /// Length on the surface, in local units, of one unit of the drawing.
    pub scale: f64,
}

/// Where a placement came to by walking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WalkedPlacement {
    /// Where it is now.
    pub placement: Placement,
    /// How far it went, in local units.
    pub length: f64,
    /// What ended the walk early, if anything did.
    pub stopped: Option<WalkStop>,
}

/// Why a drawing cannot be placed at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlaceError {
    /// The centre does not belong to the surface.
    #[error(transparent)]
    Point(#[from] PointError),
    /// Two points cannot be joined.
    #[error(transparent)]
    Path(#[from] PathError),
    /// The upward direction has no part along the surface.
    #[error("the upward direction {up} stands upright on the surface: give one that leans to a side")]
    NoUp {
        /// The direction.
        up: DVec3,
    },
    /// The scale makes no sense.
    #[error("the scale is {scale}: give a positive number")]
    BadScale {
        /// The scale.
        scale: f64,
    },
    /// The point to be held is not finite.
    #[error("the drawing's origin is not a finite point: give finite coordinates")]
    BadOrigin,
}

impl Placement {
    /// The placement turned counter-clockwise about its centre, as seen against the normal, by an angle in radians.
    ///
    /// # Errors
    /// [`PlaceError`] if the centre does not belong to the surface, or nothing is up.
    pub fn turned(&self, surface: &Surface, angle: f64) -> Result<Self, PlaceError> {
        let up = surface.tangent_in_space(&surface.tangent(&self.at, self.up)?.rotated(angle))?;
        if !up.is_finite() || up == DVec3::ZERO {
            return Err(PlaceError::NoUp { up: self.up });
        }
        Ok(Self { up, ..*self })
    }

    /// The placement whose centre is somewhere else: what is up is carried along the shortest path, so that a drawing that is moved does not
    /// turn on the spot.
    ///
    /// # Errors
    /// [`PlaceError`] if the points do not belong to the surface or cannot be joined.
    pub fn moved(&self, surface: &Surface, finder: &mut PathFinder, to: &SurfacePoint) -> Result<Self, PlaceError> {
        let path = finder.shortest(surface, &self.at, to)?;
        let mut up = surface.tangent(&self.at, self.up)?;
        if up.vector == glam::DVec2::ZERO {
            return Err(PlaceError::NoUp { up: self.up });
        }
        up.vector = up.vector.normalize_or_zero();
        Ok(Self { at: path.end(), up: surface.tangent_in_space(&surface.transport(&path, &up)?)?, ..*self })
    }

    /// The placement moved straight ahead, as what walks on the surface moves: in the direction that lies `angle` radians counter-clockwise from upward,
    /// as seen against the normal. What is up is carried along, so that it keeps its angle to the way.
    ///
    /// # Errors
    /// [`PlaceError`] if the centre does not belong to the surface, nothing is up, or a number is not finite.
    pub fn walked(&self, surface: &Surface, angle: f64, distance: f64) -> Result<WalkedPlacement, PlaceError> {
        let up = surface.tangent(&self.at, self.up)?;
        if up.vector == glam::DVec2::ZERO {
            return Err(PlaceError::NoUp { up: self.up });
        }
        let heading = surface.turned(&self.at, &up.with_length(1.0), angle)?;
        let walk = surface.walk(&self.at, &heading, distance)?;
        let end = walk.path.end();
        let up = surface.tangent_in_space(&surface.turned(&end, &walk.heading, -angle)?)?;
        Ok(WalkedPlacement {
            placement: Self { at: end, up, ..*self },
            length: walk.path.length(),
            stopped: walk.stopped,
        })
    }

    /// The placement pulled by a point of the drawing's upward axis, `reach` of its units above the centre: it turns and scales so that the
    /// point comes to lie there. What a drag does that began at the centre.
    ///
    /// # Errors
    /// [`PlaceError`] if the points do not belong to the surface or cannot be joined, or the point is the centre.
    pub fn pulled(
        &self,
        surface: &Surface,
        finder: &mut PathFinder,
        to: &SurfacePoint,
        reach: f64,
    ) -> Result<Self, PlaceError> {
        let path = finder.shortest(surface, &self.at, to)?;
        let scale = path.length() / reach;
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(PlaceError::BadScale { scale });
        }
        let up = surface.tangent_in_space(&path.initial_tangent(surface)?)?;
        Ok(Self { at: path.start(), up, scale })
    }
}
