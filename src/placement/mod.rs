//! Drawings on surfaces, and curves of surfaces as drawings.
//!
//! A [`Placement`] holds a planar drawing at a point of a surface. [`place_drawing`] makes splines of its paths: an anchor goes to where the
//! straightest path from the centre leads, in its direction and for its distance (polar coordinates; Mancinelli, Nazzaro, Pellacini and
//! Puppo 2022, sec. 4.4). Handles are taken relative to their anchor: the plane's axes are carried along the anchor's path, and the handle is
//! walked from the anchor. So two handles that are opposite in the drawing are opposite on the surface, and smooth joins stay smooth.
//!
//! [`PlacementPreview`] shows a drawing at the pointer, many times a second; [`drawing_about`] and [`drawing_in_view`] go the other way.

mod clip;
mod frame;
mod place;
#[expect(clippy::module_inception, reason = "the file of `Placement` is called placement, like every type's file")]
mod placement;
mod plane_map;
mod preview;
mod project;
#[cfg(test)]
mod tests;

pub use place::{
    Boundary, DropReason, HandleRule, PathOutcome, PlaceOptions, PlacedDrawing, PlacedPath, PlacedSpline, place_drawing,
};
pub use placement::{PlaceError, Placement, WalkedPlacement};
pub use plane_map::{PlaneMap, PlanePoint, PlaneWalk};
pub use preview::{DrawingOutline, PlacementPreview};
pub use project::{ProjectError, drawing_about, drawing_in_view};
