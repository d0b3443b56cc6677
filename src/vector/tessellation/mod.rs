//! Triangles of painted paths, kept while control points move.
//!
//! A [`Picture`] is what does not change: shapes with their paint, paths as they were drawn, dashes cut. [`PicturePoints`] are the control
//! points as they are now, and a [`PictureMesh`] has the triangles: all shapes in one list, in the order in which they are painted.
//! Tessellation is by `lyon_tessellation`. Only shapes with paths that moved are made again, in memory that is kept.
//!
//! A fill keeps its triangles and only moves their corners as long as none of them turns over: the sum of triangles that all turn the same way
//! covers each place as often as the outline winds around it, so nothing is painted that is not inside. Fills that cross
//! themselves, and those by the even-odd rule, are tessellated anew whenever they move.
//!
//! Where this differs from SVG: colours of gradients are at vertices (fills are divided in up to 64 parts a triangle for them); opacity counts for
//! fill and stroke each; strokes keep their width and dashes stick to the path when it is bent; a stroke that crosses itself shows so
//! if it is not opaque. Two loops that turn opposite ways, apart at first and later one over the other, are both painted.

mod dash;
mod fill;
mod picture;
mod picture_mesh;
mod points;
mod shade;
mod stroke;
#[cfg(test)]
mod tests;

pub use picture::{Picture, PictureOptions};
pub use picture_mesh::{PictureChange, PictureMesh, Tessellator};
pub use points::PicturePoints;
