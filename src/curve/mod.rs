//! Bézier curves on a surface: schemes, tracing, splines and their edits.
//!
//! All schemes are made of one operation, the geodesic average: the point at some share of the length of the shortest path
//! between two points. A *leg* is such a path, computed once and asked for several shares.

pub(crate) mod assemble;
mod average;
mod b_spline;
mod batch;
mod casteljau;
mod clip;
mod comparison;
mod curvature;
mod edit;
mod fit;
pub(crate) mod handles;
mod lane_riesenfeld;
mod normal;
mod piece;
mod retrace;
mod sample;
mod scheme;
mod segment;
mod spline;
#[cfg(test)]
mod tests;
mod trace;
mod tracer;

pub use b_spline::{Conversion, Interpolation};
pub use clip::{Copied, Paste, Pasted, SplineClip};
pub use edit::{
    Deletion, EditError, HandleSide, Insertion, JumpPolicy, SelectionTransform, SplineEdit, SplineEnd, SplinePatch,
    Transformed,
};
pub use fit::{DrawnLine, Fit, FitError, FitOptions};
pub use normal::Coordinates;
pub use scheme::{Method, Sampling, Scheme};
pub use spline::{Anchor, Handle, Join, Spline, SplineError, SplineT};
pub use trace::{Jump, NearestOnTrace, SegmentTrace, Trace, TraceBound};
pub use tracer::{CurvePoint, TraceError, TraceWorkspace, Tracer};
