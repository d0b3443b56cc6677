//! Lines drawn on a surface, and how they become smooth.
//!
//! A [`SurfacePolyline`] is the strip of faces that a drawn line runs through, with the places where it crosses the sides between. Smoothing
//! moves these places, and the strip past vertices that the line presses against, so that the line stays a curve of the surface
//! all the while. What it becomes is for the [`SmoothingMode`] to say; by default it is short and smooth and tethered to
//! where it was drawn.
//!
//! ```
//! use bevy_surface_splines::{geodesic::PathFinder, smooth::*, surface::{Surface, SurfaceOptions, shapes}};
//! use glam::DVec3;
//!
//! let surface = Surface::build(&shapes::icosphere(4), &SurfaceOptions::default())?;
//! let at = |k: u32| {
//!     let (a, tremor) = (0.05 * f64::from(k), if k % 2 == 0 { 0.08 } else { -0.08 });
//!     surface.closest_point(DVec3::new(a.cos(), a.sin(), tremor)).unwrap().point
//! };
//! let points: Vec<_> = (0..60).map(at).collect();
//! let mut workspace = SmoothWorkspace::default();
//! let drawn = SurfacePolyline::through(&surface, &mut workspace.finder, &points, false)?;
//! let smoothed = smooth(&surface, &mut workspace, &drawn, &Smoothing::default())?;
//! assert!(smoothed.after.total_turn < 0.1 * smoothed.before.total_turn);
//! assert!(smoothed.after.max_distance < 0.15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Sources: Pawellek, *Smoothing Curves on Surface Meshes*; Lawonn, Gasteiger, Rössl and Preim 2014, *Adaptive and robust curve smoothing on surface
//! meshes*; Martínez, Velho and Carvalho 2005, *Computing geodesics on triangular meshes*. The tether, the solves on a strip and the order of flips
//! are this project's own.

mod driver;
mod engine;
mod envelope;
mod fan;
mod flip;
mod gathered;
mod hinge;
mod layout;
mod live;
mod metric;
mod metrics;
mod nodes;
mod options;
mod plain;
mod polyline;
mod profile;
mod progress;
mod range;
mod region;
mod roughness;
mod seam;
mod shortcuts;
mod smoothing;
mod solve;
mod strip;
mod task;
mod taut;
#[cfg(test)]
mod tests;
mod tree;
mod windows;
mod wish;

pub use live::LiveSmoothing;
pub use metrics::{LineBend, LineMetrics};
pub use options::{Envelope, Iteration, SmoothError, Smoothing, SmoothingMode};
pub use polyline::{PolylineError, SurfacePolyline};
pub use progress::SmoothProgress;
pub use range::SmoothRange;
pub use smoothing::{SmoothWorkspace, Smoothed, bends_into, measure, smooth, smooth_into, smooth_while};
