//! A triangle mesh as a surface one can walk on: welding, adjacency, checks, points, queries in space.
//!
//! [`TriangleMesh`] (raw) → [`Surface::build`] → [`Surface`], which answers about [`SurfacePoint`]s. Faces are named by
//! their place in the input throughout; the order and orientation used inside are private.

mod adjacency;
mod arranged;
mod buckets;
mod build;
mod bvh;
mod clusters;
mod fans;
pub(crate) mod fingerprint;
mod ids;
mod measure;
mod memory;
pub(crate) mod metric;
mod morton;
mod options;
mod orientation;
mod parallel;
mod point;
mod posed;
mod report;
pub mod shapes;
mod sift;
#[expect(clippy::module_inception, reason = "the file of `Surface` is called surface, like every type's file")]
mod surface;
mod survey;
#[cfg(test)]
mod tests;
mod triangle_mesh;
mod weld;

pub(crate) use bvh::Bvh;
pub(crate) use clusters::Clusters;
pub(crate) use ids::HalfEdge;
pub use ids::{FaceId, VertexId};
pub use memory::{ArrayMemory, SurfaceMemory};
pub use options::{BuildProgress, NonManifoldEdges, NonManifoldVertices, NonOrientable, SurfaceOptions};
pub use point::{PointElement, PointError, SurfacePoint};
pub use posed::{PoseError, PosedSurface};
pub use report::{DropReason, Repair, SurfaceError, SurfaceReport};
pub use surface::{ClosestPoint, RayHit, Surface};
pub(crate) use surface::{InnerPoint, Zeros};
pub use triangle_mesh::TriangleMesh;
