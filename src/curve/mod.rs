//! Bézier curves on a surface: schemes, tracing, splines and their edits.
//!
//! All schemes are made of one operation, the geodesic average: the point at some share of the length of the shortest path
//! between two points. A *leg* is such a path, computed once and asked for several shares.

mod average;
mod batch;
mod casteljau;
mod edit;
mod handles;
mod lane_riesenfeld;
mod scheme;
mod spline;
#[cfg(test)]
mod tests;
mod trace;
mod tracer;

pub use edit::{EditError, HandleSide, SplineEdit, SplineEnd, SplinePatch};
pub use scheme::Scheme;
pub use spline::{Anchor, Handle, Join, Spline, SplineError, SplineT};
pub use trace::{NearestOnTrace, SegmentTrace, Trace};
pub use tracer::{TraceError, TraceWorkspace, Tracer};
