//! What most programs need: `use bevy_surface_splines::prelude::*`.

pub use crate::curve::{
    HandleSide, Join, JumpPolicy, Method, Sampling, Scheme, SelectionTransform, SplineEdit, SplineEnd, SplineT,
};
#[cfg(feature = "characters")]
pub use crate::plugin::{
    BezierCharacter, BezierPaths, CharacterAsset, CharacterFailed, CharacterJoints, CharacterReady, CharacterState,
    CharacterSystems, FlexibleSolve, LaidState, SplineSkin,
};
pub use crate::plugin::{
    BuiltSurface, ControlKind, ControlPoint, ControlPolygon, DragState, EditSpline, Editable, GestureId, LineChanged,
    LineCommands, LineDrawn, LineFailed, LinePen, LineSmoothing, LineSource, LineState, OnSurface, PendingEdit,
    SmoothedLine, SplineEditRefused, SplineEdited, SplineGizmos, SplineSource, SplineState, SplineSurface, SplineTrace,
    SurfaceChanged, SurfaceFailed, SurfaceItems, SurfaceLine, SurfaceQueries, SurfaceReady, SurfaceSpline,
    SurfaceSplinePlugins, SurfaceSplineSystems, SurfaceState, SurfaceView, TraceBudget, TraceChanged, TraceCurve,
    TracePreview,
};
#[cfg(feature = "svg")]
pub use crate::plugin::{
    Drawing, DrawingOptions, DrawingSplines, DrawingState, DrawnPath, OfDrawing, Placement, SvgDrawing,
};
pub use crate::smooth::{Smoothing, SmoothingMode, SurfacePolyline};
pub use crate::surface::{FaceId, SurfacePoint};
