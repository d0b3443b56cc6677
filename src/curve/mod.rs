//! Bézier curves on a surface: schemes, tracing, splines and their edits.
//!
//! All schemes are made of one operation, the geodesic average: the point at some share of the length of the shortest path
//! between two points. A *leg* is such a path, computed once and asked for several shares.

pub(crate) mod assemble;
mod average;
mod b_spline;
mod batch;
mod casteljau;
mod comparison;
mod curvature;
mod edit;
pub(crate) mod handles;
mod lane_riesenfeld;
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
pub use edit::{EditError, HandleSide, Insertion, JumpPolicy, SplineEdit, SplineEnd, SplinePatch};
pub use scheme::{Method, Sampling, Scheme};
pub use spline::{Anchor, Handle, Join, Spline, SplineError, SplineT};
pub use trace::{Jump, NearestOnTrace, SegmentTrace, Trace, TraceBound};
pub use tracer::{CurvePoint, TraceError, TraceWorkspace, Tracer};
