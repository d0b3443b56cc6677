//! The method of the b/Surf paper (Mancinelli, Nazzaro, Pellacini and Puppo 2022), to compare with.
//!
//! Written from the paper's description (sec. 5.1): a search over the faces by a label-correcting queue, a funnel through the
//! strip of faces found, and straightening at one vertex after another, the sharpest first, each time with a new funnel
//! through the whole strip. Curves are made of nothing but such paths and of points on them.
//!
//! It is as fast as an honest implementation would be: all that a search reads of a face lies together, memory is kept from
//! query to query and cleaned only where it was used. It stops straightening as the published program does: when the same
//! vertex comes up twice in a row, or after twice as many steps as the strip has faces. That is early, so it is in its favour
//! where times are compared; paths are then not always locally shortest.
#![allow(dead_code, reason = "each bench is a program of its own and uses a part of this")]

pub(crate) mod curves;
mod funnel;
pub(crate) mod mesh;
mod path;
mod search;
mod straighten;
mod unfold;

use bevy_surface_splines::surface::SurfacePoint;
use mesh::Mesh;

pub(crate) use path::Path;

/// Finds paths by the paper's method; keeps its memory from query to query.
pub(crate) struct Baseline {
    mesh: Mesh,
    search: search::Search,
    straightener: straighten::Straightener,
}

impl Baseline {
    pub(crate) fn new(mesh: Mesh) -> Self {
        Self { search: search::Search::new(mesh.nodes.len()), straightener: straighten::Straightener::default(), mesh }
    }

    /// A short path; none between faces that are not connected.
    pub(crate) fn path(&mut self, from: &SurfacePoint, to: &SurfacePoint) -> Option<Path> {
        let mut strip = Vec::new();
        if !self.search.strip(&self.mesh, from.face.0, to.face.0, &mut strip) {
            return None;
        }
        let crossings = self.straightener.straighten(&self.mesh, &mut strip, from, to);
        Some(Path::new(&self.mesh, *from, *to, strip, crossings))
    }

    /// The point at a share of a path's length.
    pub(crate) fn at(&self, path: &Path, share: f64) -> SurfacePoint {
        path.at(&self.mesh, share)
    }
}
