//! Paths of cubic Bézier segments, drawings made of planar ones with their styles, SVG in and out.
//!
//! This folder knows nothing of surfaces. A [`Drawing`] is a list of [`Shape`]s, each of one or more [`VectorPath`]s that are filled
//! together (so that a path inside another is a hole) and one [`Style`]. Coordinates are those of SVG: x to the right, **y down**.
//!
//! With the feature `svg`, `import_svg` reads a drawing and says what became of every segment, and `export_svg` writes one. With the feature
//! `tessellation`, a `Picture` becomes triangles that follow its control points.

mod builder;
mod drawing;
mod joins;
mod path;
mod spatial;
mod style;
#[cfg(feature = "svg")]
mod svg;
#[cfg(feature = "tessellation")]
mod tessellation;

pub use builder::{Added, PathBuilder};
pub use drawing::{Drawing, Group, Shape, ViewBox};
pub use joins::{JoinTolerance, PathJoin};
pub use path::VectorPath;
pub use spatial::SpatialPath;
pub use style::{
    Color, FillRule, Gradient, GradientKind, GradientStop, LineCap, LineJoin, Paint, SpreadMethod, Stroke, Style,
};
#[cfg(feature = "svg")]
pub use svg::{
    LeftOut, LeftOutReason, Note, SegmentCounts, SegmentKind, SvgError, SvgImport, SvgLimits, SvgReport, export_svg,
    import_svg, import_svg_within, read_svg,
};
#[cfg(feature = "tessellation")]
pub use tessellation::{Picture, PictureChange, PictureMesh, PictureOptions, PicturePoints, Tessellator};
