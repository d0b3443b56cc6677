//! What most programs need: `use bevy_surface_splines::prelude::*`.

pub use crate::curve::{
    HandleSide, Join, JumpPolicy, Method, Sampling, Scheme, SelectionTransform, SplineEdit, SplineEnd, SplineT,
};
pub use crate::plugin::{
    BuiltSurface, ControlKind, ControlPoint, ControlPolygon, DragState, EditSpline, Editable, GestureId, OnSurface,
    PendingEdit, SplineEditRefused, SplineEdited, SplineGizmos, SplineSource, SplineState, SplineSurface, SplineTrace,
    SurfaceChanged, SurfaceFailed, SurfaceItems, SurfaceQueries, SurfaceReady, SurfaceSpline, SurfaceSplinePlugins,
    SurfaceSplineSystems, SurfaceState, SurfaceView, TraceBudget, TraceChanged, TraceCurve, TracePreview,
};
#[cfg(feature = "svg")]
pub use crate::plugin::{
    Drawing, DrawingOptions, DrawingSplines, DrawingState, DrawnPath, OfDrawing, Placement, SvgDrawing,
};
pub use crate::surface::{FaceId, SurfacePoint};
