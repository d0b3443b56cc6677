//! How much each handle moves each place.

#[cfg(feature = "weights")]
mod bounded;
mod cage;
mod error;
#[cfg(feature = "weights")]
mod meshed;
#[cfg(feature = "weights")]
mod plane_mesh;
mod shepard;
#[cfg(feature = "weights")]
mod sparse;
mod surface_weights;
#[cfg(test)]
mod tests;

pub use cage::Cage;
pub use error::WeightsError;
#[cfg(feature = "weights")]
pub use meshed::{MeshedReport, MeshedWeights};
pub use shepard::{HandleShape, Shepard};
pub use surface_weights::{SkinSet, SurfaceWeights};

use glam::DVec3;

use super::Quadrature;

/// How much each handle moves each place.
pub trait WeightField: Sync {
    /// Number of handles.
    fn handle_count(&self) -> usize;

    /// Writes the weight of each handle at a place: none is negative, and some is positive. They are brought to a sum of one by those who ask.
    fn weights_at(&self, place: DVec3, out: &mut [f64]);

    /// How integrals of these weights along curves are best taken.
    fn quadrature(&self) -> Quadrature {
        Quadrature::SMOOTH
    }
}
