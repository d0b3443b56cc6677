//! The Bevy plugin: splines on surfaces as components, edited live; works without window and renderer.
//!
//! [`SplineSurface`] beside a `Mesh3d` asks for a [`BuiltSurface`]; a [`SplineSource`] or [`SurfaceSpline`] with
//! [`OnSurface`] lies on it; [`EditSpline`] messages change it, and its [`SplineTrace`] follows. A [`SurfaceLine`] is smoothed by its
//! [`LineSmoothing`] into a [`SmoothedLine`]. [`Editable`] makes anchors and
//! handles appear that can be picked and dragged. What would take longer than a frame has ([`TraceBudget`]) is computed in the
//! background; a [`TracePreview`] is shown meanwhile. With the feature `svg`, a `Drawing` with a `Placement` becomes splines. With the feature
//! `characters`, `BezierPaths` are painted paths as meshes, a `SplineSkin` lets them follow joints, and a `BezierCharacter` is all of that from one file.
//! On a mesh that joints or morph targets deform ([`DeformedSurface`]), curves ride along ([`RidingCurve`]) and picking hits what is seen.
//!
//! Every plugin can be added alone and names its schedule and set; [`SurfaceSplinePlugins`] adds them all. Sets run in
//! `PostUpdate` in the order of [`SurfaceSplineSystems`], before transforms are propagated (drawing after), so an edit
//! sent in `Update` shows in the same frame. Picking and dragging run in `PreUpdate`.

#![expect(clippy::type_complexity, reason = "queries name what they read where they read it")]

mod background;
mod budget;
mod build;
#[cfg(feature = "characters")]
mod character;
#[cfg(feature = "characters")]
mod character_asset;
#[cfg(feature = "characters")]
mod character_binding;
#[cfg(feature = "characters")]
mod character_capture;
#[cfg(feature = "characters")]
mod character_systems;
mod controls;
mod costs;
mod curve;
mod debug_draw;
mod deformed;
mod diagnostics;
#[cfg(feature = "document")]
mod document;
#[cfg(feature = "document")]
mod document_asset;
mod drag;
mod drag_modifiers;
mod drag_ways;
#[cfg(feature = "svg")]
mod drawing;
mod edit;
mod edit_costs;
mod edit_queue;
#[cfg(feature = "characters")]
mod laid_paths;
mod line;
mod line_pen;
mod line_remap;
mod line_source;
mod line_work;
pub mod mesh;
#[cfg(feature = "characters")]
mod paths;
mod pick;
mod polygon;
mod preview;
mod queries;
mod remap;
mod retrace;
mod riding;
#[cfg(feature = "characters")]
mod skin_binding;
mod smooth_lines;
mod smoothed_line;
mod spline;
#[cfg(feature = "characters")]
mod spline_skin;
mod surface;
pub mod testing;
mod trace;
mod workspaces;

use bevy::app::PluginGroupBuilder;
use bevy::prelude::*;

pub use budget::TraceBudget;
#[cfg(feature = "characters")]
pub use character::{
    BezierCharacter, CharacterFailed, CharacterJoints, CharacterPlugin, CharacterReady, CharacterState,
};
#[cfg(feature = "characters")]
pub use character_asset::{CharacterAsset, CharacterClip, CharacterLoadError, CharacterLoader};
#[cfg(feature = "characters")]
pub use character_capture::{CharacterCapture, CharacterCaptureError};
#[cfg(feature = "characters")]
pub use character_systems::CharacterSystems;
pub use controls::{ControlKind, ControlOf, ControlPoint, Controls, ControlsPlugin, Editable};
pub use curve::TraceCurve;
pub use debug_draw::{DebugDrawPlugin, SplineGizmos};
pub use deformed::{DeformPlugin, DeformedSurface};
pub use diagnostics::SplineDiagnosticsPlugin;
#[cfg(feature = "document")]
pub use document::{
    CaptureError, ConflictChoice, DocumentConflict, DocumentFailed, DocumentPlugin, DocumentRestored, DocumentSaved,
    DocumentState, DocumentedSpline, KnownMesh, ResolveConflict, SaveDocument, SplineDocument, SplineDocuments,
};
#[cfg(feature = "document")]
pub use document_asset::{DocumentAsset, DocumentLoader, DocumentSaver};
pub use drag::{DragPlugin, DragSettings, DragState, Grip};
pub use drag_modifiers::DragModifiers;
#[cfg(feature = "svg")]
pub use drawing::{
    Drawing, DrawingOptions, DrawingPlugin, DrawingSplines, DrawingState, DrawnPath, OfDrawing, Placement, SvgDrawing,
    SvgLoadError, SvgLoader,
};
pub use edit::{
    EditPlugin, EditRefusal, EditSpline, EndGesture, GestureEnded, GestureId, SplineEditRefused, SplineEdited,
};
pub use edit_queue::PendingEdit;
#[cfg(feature = "characters")]
pub use laid_paths::LaidState;
pub use line::{LineChanged, LineFailed, LinePlugin, LineSmoothing, LineState, SurfaceLine};
pub use line_pen::{LineDrawn, LinePen, LinePenPlugin};
pub use line_source::{LineCommands, LineFitError, LineSource};
pub use mesh::{MeshReadError, mesh_from, triangle_mesh_from};
#[cfg(feature = "characters")]
pub use paths::{BezierPaths, PathPlugin, PathStatistics};
pub use pick::{CurveHit, LineHit, PickPlugin, Picker, SplinePickingSettings, SurfaceHit};
pub use polygon::{ControlPolygon, PolygonPlugin};
pub use preview::{PreviewKind, TracePreview};
pub use queries::{SurfaceQueries, SurfaceQueryError, SurfaceView, WorldHit, WorldPlace, WorldWalk};
pub use retrace::{RetracePlugin, TraceStatistics};
pub use riding::{RidingCurve, RidingPlugin};
#[cfg(feature = "characters")]
pub use skin_binding::{JointWeights, SkinBinding, SkinState};
pub use smoothed_line::{LinePlace, SmoothedLine};
pub use spline::{SplinePlugin, SplineSource, SplineState, SurfaceSpline};
#[cfg(feature = "characters")]
pub use spline_skin::{FlexibleSolve, SkinPlugin, SkinPose, SplineSkin};
pub use surface::{
    BuiltSurface, OnSurface, SplineSurface, SurfaceChanged, SurfaceFailed, SurfaceItems, SurfacePlugin, SurfaceReady,
    SurfaceState,
};
pub use trace::{SplineTrace, TraceChanged};

/// The steps of a frame: `Build` to `Controls` run in `PostUpdate`, chained in this order, before transforms are
/// propagated; `Ride` and `Draw` after that; `Drag` in `PreUpdate`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SurfaceSplineSystems {
    /// Surfaces are built from meshes.
    Build,
    /// Sources become splines.
    Resolve,
    /// Edits are applied.
    Edit,
    /// Changed segments are traced again, and lines smoothed.
    Trace,
    /// Entities of anchors and handles follow, and control polygons of B-splines.
    Controls,
    /// What lies on deformed meshes follows them, after transforms are propagated.
    Ride,
    /// Gizmos are drawn.
    Draw,
    /// Pointers grab and move control points, after picking.
    Drag,
}

/// Puts the sets in order; every plugin calls it, and calling it again changes nothing.
fn configure_sets(app: &mut App) {
    use SurfaceSplineSystems::{Build, Controls, Drag, Draw, Edit, Resolve, Ride, Trace};
    if app.world().contains_resource::<SetsConfigured>() {
        return;
    }
    app.insert_resource(SetsConfigured)
        .configure_sets(PostUpdate, (Build, Resolve, Edit, Trace, Controls).chain().before(TransformSystems::Propagate))
        .configure_sets(PostUpdate, (Ride, Draw).chain().after(Controls).after(TransformSystems::Propagate))
        .configure_sets(PreUpdate, Drag.after(bevy::picking::PickingSystems::Last).after(bevy::input::InputSystems));
}

#[derive(Resource)]
struct SetsConfigured;

/// Everything that works without a window: surfaces, splines, lines, documents, edits, traces, picking, dragging, diagnostics,
/// gizmos.
///
/// Picking and dragging wait for Bevy's picking plugins, gizmos for its `GizmoPlugin`; where those are missing they do nothing.
#[derive(Debug, Default)]
pub struct SurfaceSplinePlugins;

impl PluginGroup for SurfaceSplinePlugins {
    fn build(self) -> PluginGroupBuilder {
        let group = PluginGroupBuilder::start::<Self>();
        #[cfg(feature = "document")]
        let group = group.add(DocumentPlugin);
        #[cfg(feature = "svg")]
        let group = group.add(DrawingPlugin);
        #[cfg(feature = "characters")]
        let group = group.add(PathPlugin).add(SkinPlugin).add(CharacterPlugin);
        group
            .add(SurfacePlugin)
            .add(SplinePlugin)
            .add(EditPlugin)
            .add(RetracePlugin)
            .add(LinePlugin)
            .add(ControlsPlugin)
            .add(PolygonPlugin)
            .add(PickPlugin)
            .add(LinePenPlugin)
            .add(DragPlugin)
            .add(DeformPlugin)
            .add(RidingPlugin)
            .add(SplineDiagnosticsPlugin)
            .add(DebugDrawPlugin)
    }
}
