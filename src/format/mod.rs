//! Files: meshes in, documents in and out, traces out.
//!
//! With the feature `formats`, `read_mesh` reads a mesh file, `parse_mesh` bytes that are in memory already. Both give a
//! [`TriangleMesh`](crate::surface::TriangleMesh) as the file has it: nothing is welded, oriented or dropped. Coordinates that
//! are infinite or not numbers pass through; whatever builds a surface drops their faces.
//!
//! | format | what is read |
//! |---|---|
//! | OBJ | `v` and `f` lines: polygons, negative indices, UTF-16 too |
//! | STL | text and binary, several solids |
//! | PLY | text and binary of both byte orders: polygons and `tristrips` |
//! | OFF | text: polygons |
//! | glTF, GLB | triangles, strips and fans of the default scene, with the nodes' transforms |
//!
//! A polygon of n corners gives n − 2 consecutive triangles, a fan from its first corner. Nothing in a file makes a reader
//! panic, hang, or reserve memory out of proportion to the file; errors name the line or byte, see `FormatError`.
//!
//! `read_skinned_mesh` reads a glTF file with its joints and weights, so that curves follow them (see [`crate::skin`]).
//!
//! With the feature `document`, `document` holds splines and their surface in RON. [`export`] writes traces as lines, and
//! [`save`] is how all files are written.

#[cfg(feature = "document")]
pub mod document;
#[cfg(feature = "formats")]
mod error;
pub mod export;
#[cfg(feature = "formats")]
mod gltf;
#[cfg(feature = "formats")]
mod gltf_data;
#[cfg(feature = "formats")]
mod gltf_root;
#[cfg(feature = "formats")]
mod gltf_skin;
#[cfg(feature = "formats")]
mod obj;
#[cfg(feature = "formats")]
mod off;
#[cfg(feature = "formats")]
mod ply;
#[cfg(feature = "formats")]
mod ply_values;
#[cfg(feature = "formats")]
mod read;
#[cfg(any(feature = "formats", feature = "document"))]
pub(crate) mod regular;
pub mod save;
#[cfg(feature = "formats")]
mod skinned;
#[cfg(feature = "formats")]
mod stl;
#[cfg(feature = "formats")]
mod strip;
#[cfg(feature = "formats")]
mod text;

#[cfg(feature = "formats")]
pub use error::{Cause, FormatError, Place};
#[cfg(feature = "formats")]
pub use read::{LoadError, MeshFormat, parse_mesh, parse_mesh_beside, read_mesh};
#[cfg(feature = "formats")]
pub use skinned::{JointSet, SkinJoint, SkinnedMesh, SkinnedMeshOptions, parse_skinned_mesh, read_skinned_mesh};
