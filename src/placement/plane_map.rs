//! The plane of a drawing laid onto a surface, place by place.

use glam::{DVec2, DVec3};

use super::frame::Frame;
use super::{PlaceError, Placement};
use crate::geodesic::inner::InnerPath;
use crate::surface::{Surface, SurfacePoint};

/// The plane of a drawing laid onto a surface by polar coordinates: a place goes to where the straightest path from the placement's point
/// leads, in its direction and for its distance (exponential map). For what has many places and changes in every frame; splines are made by
/// [`place_drawing`](super::place_drawing).
///
/// ```
/// use bevy_surface_splines::{placement::{Placement, PlaneMap, PlaneWalk}, surface::{Surface, SurfaceOptions, shapes}};
/// use glam::{DVec2, DVec3};
///
/// let surface = Surface::build(&shapes::icosphere(4), &SurfaceOptions::default())?;
/// let at = surface.closest_point(DVec3::X).unwrap().point;
/// let map = PlaneMap::new(&surface, &Placement { at, up: DVec3::Z, scale: 0.1 }, DVec2::ZERO)?;
/// let there = map.place(DVec2::new(0.0, 10.0), &mut PlaneWalk::default()); // ten units up: one radian
/// assert!((there.position.z - 1.0_f64.sin()).abs() < 1e-2 && !there.is_off);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PlaneMap<'s>(Frame<'s>);

/// Memory of a walk, to be used again.
#[derive(Debug, Default)]
pub struct PlaneWalk(InnerPath);

/// Where a place of the plane came to lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanePoint {
    /// The point of the surface; where the way to it ended, if it is off the surface.
    pub point: SurfacePoint,
    /// Its position, in the surface's local space.
    pub position: DVec3,
    /// The normal of its face.
    pub normal: DVec3,
    /// Whether the way to it left the surface, or was too long.
    pub is_off: bool,
}

impl<'s> PlaneMap<'s> {
    /// The plane whose `origin` lies at the placement's point, with y up.
    ///
    /// # Errors
    /// [`PlaceError`] if the placement makes no sense.
    pub fn new(surface: &'s Surface, placement: &Placement, origin: DVec2) -> Result<Self, PlaceError> {
        // A frame has y down, as drawings have.
        Frame::new(surface, placement, DVec2::new(origin.x, -origin.y)).map(Self)
    }

    /// Where a place of the plane lies. Cost: 50 ns for each face that the way from the placement's point crosses. Takes no memory once `walk` is warm.
    pub fn place(&self, place: DVec2, walk: &mut PlaneWalk) -> PlanePoint {
        let surface = self.0.surface;
        let landing = self.0.land(DVec2::new(place.x, -place.y), &mut walk.0);
        let at = match &landing {
            Ok(landing) => landing.at,
            // A way that was never begun ends at the centre.
            Err(super::frame::Miss::TooFar) => self.0.centre().0,
            Err(super::frame::Miss::Stopped(_)) => walk.0.end,
        };
        let point = surface.outer_point(&at);
        let (position, normal) = (surface.position(&point), surface.normal(&point));
        PlanePoint { point, position, normal, is_off: landing.is_err() }
    }
}
