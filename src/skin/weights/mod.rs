//! How much each handle moves each place.

mod shepard;

pub use shepard::{HandleShape, Shepard};

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
