//! A triangle mesh as a surface one can walk on.

mod ids;
mod options;
mod point;
mod report;
mod triangle_mesh;
mod weld;

pub(crate) use ids::HalfEdge;
pub use ids::{FaceId, VertexId};
pub use options::{BuildProgress, NonManifoldEdges, NonManifoldVertices, NonOrientable, SurfaceOptions};
pub use point::{PointElement, PointError, SurfacePoint};
pub use report::{DropReason, SurfaceError, SurfaceReport};
pub use triangle_mesh::TriangleMesh;
