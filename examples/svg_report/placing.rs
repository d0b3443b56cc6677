//! Drawings on a mesh.

use std::path::Path;
use std::time::Instant;

use bevy_surface_splines::curve::Spline;
use bevy_surface_splines::format::LoadError;
use bevy_surface_splines::placement::{DropReason, PathOutcome, PlaceOptions, Placement, place_drawing};
use bevy_surface_splines::surface::{Surface, SurfacePoint};
use bevy_surface_splines::vector::Drawing;
use glam::DVec3;

/// A mesh, and the place on it where drawings go.
pub(crate) struct Stage {
    surface: Surface,
    at: SurfacePoint,
}

/// What became of a drawing on a mesh.
pub(crate) struct OnMesh {
    pub(crate) paths: usize,
    pub(crate) splines: usize,
    pub(crate) segments: usize,
    pub(crate) dropped: usize,
    pub(crate) invisible: usize,
    pub(crate) clipped_handles: u32,
    pub(crate) place_ms: f64,
    pub(crate) trace_ms: f64,
    /// Splines that could not be traced, with the first reason.
    pub(crate) untraced: usize,
    pub(crate) first_error: Option<String>,
}

impl Stage {
    /// Loads a mesh; drawings go to where it faces the viewer, near its middle.
    pub(crate) fn new(mesh: &Path) -> Result<Self, LoadError> {
        let surface = Surface::from_file(mesh)?;
        let (low, high) = surface.bounds();
        let before = 0.5 * (low + high) + DVec3::new(0.02, 0.03, 1.0) * surface.diagonal();
        let hit = surface.ray(before, DVec3::NEG_Z).map(|hit| hit.point);
        let at = hit.or_else(|| surface.closest_point(before).map(|c| c.point));
        let nowhere = SurfacePoint { face: bevy_surface_splines::surface::FaceId(0), weights: [1.0, 0.0, 0.0] };
        Ok(Self { at: at.unwrap_or(nowhere), surface })
    }

    /// Places and traces a drawing.
    pub(crate) fn place(&self, drawing: &Drawing) -> Result<OnMesh, String> {
        let (low, high) = drawing.bounds().unwrap_or((glam::DVec2::ZERO, glam::DVec2::ONE));
        let scale = 0.25 * self.surface.diagonal() / low.distance(high);
        let options = PlaceOptions { origin: Some(0.5 * (low + high)), ..PlaceOptions::default() };
        let placement = Placement { at: self.at, up: DVec3::new(0.0, 1.0, 1e-3), scale };
        let start = Instant::now();
        let placed = place_drawing(&self.surface, drawing, &placement, &options).map_err(|error| error.to_string())?;
        let place_ms = start.elapsed().as_secs_f64() * 1e3;
        let invisible = PathOutcome::Dropped(DropReason::Invisible);
        let invisible = placed.paths.iter().filter(|path| path.outcome == invisible).count();
        let (paths, dropped) = (placed.paths.len(), placed.dropped());
        let clipped_handles = placed.paths.iter().map(|path| path.clipped_handles).sum();
        let splines: Vec<Spline> = placed.splines.into_iter().map(|one| one.spline).collect();
        let start = Instant::now();
        let traces = Spline::trace_all(&self.surface, &splines);
        let trace_ms = start.elapsed().as_secs_f64() * 1e3;
        let errors: Vec<String> = traces.iter().filter_map(|t| t.as_ref().err()).map(ToString::to_string).collect();
        Ok(OnMesh {
            paths,
            splines: splines.len(),
            segments: splines.iter().map(Spline::segment_count).sum(),
            dropped,
            invisible,
            clipped_handles,
            place_ms,
            trace_ms,
            untraced: errors.len(),
            first_error: errors.into_iter().next(),
        })
    }
}
