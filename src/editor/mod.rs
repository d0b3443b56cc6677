//! The editor: tools, selection, history and documents that work without a window, and a panel of egui on top.
//!
//! [`EditorToolsPlugin`] lets players draw on every surface of a game: it brings the tools, their keys, the selection, and undo and
//! redo. [`ModelPlugin`] and [`CameraPlugin`] are for programs whose only scene is a model: they open mesh files and look around. The
//! panel (feature `editor`) stands on these, and the program in `examples/editor` adds them all.
//!
//! Everything that changes a spline leaves here as an [`EditSpline`](crate::plugin::EditSpline), and everything that the panel or a key
//! asks for is an [`EditorAction`], which any system may write as well.

use bevy::prelude::*;

mod actions;
mod camera;
mod clipboard;
pub mod colors;
mod convert;
mod curves;
mod documents;
mod history;
mod input;
mod keys;
mod model;
mod notices;
#[cfg(feature = "editor")]
mod panel;
mod selection;
mod shading;
mod tools;
#[cfg(feature = "editor")]
mod view;

pub use actions::EditorAction;
pub use camera::{Orbit, sphere_around};
pub use clipboard::Clipboard;
pub use convert::Conversions;
pub use curves::{Curve, CurveSpawner};
pub use documents::{AutosaveSettings, DocumentFile, ExportKind, FileRequest, Question, RecentDocuments};
pub use history::{History, HistorySystems, PlayHistory};
pub use input::{FreeView, PanelInput};
pub use keys::{BINDINGS, Binding, HINTS, Hint};
pub use model::{FirstModel, Model, ModelOpened, ModelRefused, OpenModel};
pub use notices::{Notice, Notices, Severity};
pub use selection::Selection;
pub use tools::brush::BrushSettings;
pub use tools::drawing::{DrawingInHand, TakeDrawing};
pub use tools::freehand::{Freehand, FreehandSettings};
pub use tools::transform::{BeginTransform, TransformMode};
pub use tools::{Tool, ToolSystems};
#[cfg(feature = "editor")]
pub use view::stage::StageSettings;

/// Tools, keys, selection, history and notices, for the surfaces of any app. Needs
/// [`SurfaceSplinePlugins`](crate::plugin::SurfaceSplinePlugins) and Bevy's picking.
///
/// Schedules: `PreUpdate` (the pointer, after picking; [`HistorySystems`]), `Update` ([`ToolSystems`], keys) and `PostUpdate` (actions before
/// [`SurfaceSplineSystems::Edit`](crate::plugin::SurfaceSplineSystems), the selection after it).
#[derive(Debug, Default)]
pub struct EditorToolsPlugin;

impl Plugin for EditorToolsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Curve>().init_resource::<PanelInput>().init_resource::<FreeView>().add_plugins((
            notices::plugin,
            selection::plugin,
            history::plugin,
            actions::plugin,
            convert::plugin,
            tools::plugin,
            keys::plugin,
        ));
    }
}

/// Opens meshes, drawings and documents, saves and exports, one model at a time: [`FileRequest`] asks for it, [`OpenModel`] for a
/// model alone. Needs [`EditorToolsPlugin`].
///
/// Asks before a window is closed while there are edits that are not saved, where `WindowPlugin::close_when_requested` is off; where it is on,
/// they are kept for the next start.
///
/// Schedule: `Update`.
#[derive(Debug, Default)]
pub struct ModelPlugin;

impl Plugin for ModelPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((model::plugin, documents::plugin));
    }
}

/// Lets the pointer and keys move cameras that have an [`Orbit`] around the model of a [`ModelPlugin`].
///
/// Schedule: `Update`; framing in `PostUpdate`, before transforms are propagated.
#[derive(Debug, Default)]
pub struct CameraPlugin;

impl Plugin for CameraPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(camera::plugin);
    }
}

/// The panel, on top of [`EditorToolsPlugin`], which it adds: splines of a game can be drawn and edited in it, and the game stays a
/// game. Needs `EguiPlugin` and [`SurfaceSplinePlugins`](crate::plugin::SurfaceSplinePlugins); curves are drawn as the editor draws
/// them, so its [`DebugDrawPlugin`](crate::plugin::DebugDrawPlugin) is best left out.
///
/// Schedules: `PreUpdate`, `Update`, `EguiPrimaryContextPass`, and `PostUpdate` for lines.
#[cfg(feature = "editor")]
#[derive(Debug, Default)]
pub struct SurfaceSplineEditorPlugin;

#[cfg(feature = "editor")]
impl Plugin for SurfaceSplineEditorPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<EditorToolsPlugin>() {
            app.add_plugins(EditorToolsPlugin);
        }
        app.add_plugins((
            panel::plugin,
            view::draw::plugin,
            view::lines::plugin,
            view::drawn::plugin,
            view::sticky::plugin,
        ));
    }
}

/// Lights, a backdrop and a camera for a program whose only scene is a model. Needs [`CameraPlugin`] and [`ModelPlugin`].
///
/// Schedules: `Startup`, `PostUpdate`.
#[cfg(feature = "editor")]
#[derive(Debug, Default)]
pub struct StagePlugin;

#[cfg(feature = "editor")]
impl Plugin for StagePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(view::stage::plugin);
    }
}

/// What a program that takes pictures of the editor looks at.
#[cfg(feature = "editor")]
pub mod marks {
    pub use super::panel::marks::{Mark, MarkKind, Marks};
}
