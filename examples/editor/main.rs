//! The editor: one should see a pebble with three curves on it, whose anchors and handles can be dragged over its surface.
//!
//! `cargo run --features editor --example editor -- [MESH]`; `--help` says the rest, and `?` in the window shows the keys.

mod arguments;
mod idle;
mod proof;
mod samples;
mod script;
mod tour;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use bevy::app::PluginGroupBuilder;
use bevy::diagnostic::FrameTimeDiagnosticsPlugin;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::window::{PresentMode, WindowResolution};
use bevy_egui::EguiPlugin;
use bevy_surface_splines::editor::{
    AutosaveSettings, CameraPlugin, FileRequest, FirstModel, ModelOpened, ModelPlugin, RecentDocuments, StagePlugin,
    StageSettings, SurfaceSplineEditorPlugin,
};
use bevy_surface_splines::plugin::DebugDrawPlugin;
use bevy_surface_splines::prelude::*;

use arguments::{Arguments, Request};

fn main() -> ExitCode {
    let arguments = match arguments::read(std::env::args_os().skip(1)) {
        Ok(Request::Run(arguments)) => arguments,
        Ok(Request::Help) => {
            print!("{}", arguments::HELP);
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            eprintln!("editor: {error}\n\n{}", arguments::HELP);
            return ExitCode::from(2);
        }
    };
    if let Err(error) = require_display() {
        eprintln!("editor: {error}");
        return ExitCode::FAILURE;
    }
    match run(arguments) {
        AppExit::Success => ExitCode::SUCCESS,
        AppExit::Error(code) => ExitCode::from(code.get()),
    }
}

/// Opening a window panics where there is none to open it on, so this asks first.
fn require_display() -> Result<(), &'static str> {
    let needed = cfg!(all(unix, not(target_os = "macos")));
    let there = std::env::var_os("DISPLAY").is_some_and(|name| !name.is_empty());
    if needed && !there { Err("there is no display: set DISPLAY, or start it by scripts/demo") } else { Ok(()) }
}

fn run(arguments: Arguments) -> AppExit {
    let scripted = arguments.is_scripted();
    // A script looks at what it did, not at previews.
    let budget = if scripted { TraceBudget::UNLIMITED } else { TraceBudget::default() };
    App::new()
        .insert_resource(FirstModel(arguments.mesh.clone().filter(|path| !is_document(path))))
        // A software driver draws several times faster without.
        .insert_resource(StageSettings { smooth_edges: !scripted })
        .insert_resource(arguments)
        .insert_resource(budget)
        .insert_resource(recent_documents(scripted))
        .insert_resource(AutosaveSettings { folder: own_folder(), enabled: !scripted, ..default() })
        .add_plugins((
            engine(scripted),
            EguiPlugin::default(),
            FrameTimeDiagnosticsPlugin::default(),
            // The editor draws splines itself.
            SurfaceSplinePlugins.build().disable::<DebugDrawPlugin>(),
        ))
        .add_plugins((SurfaceSplineEditorPlugin, ModelPlugin, CameraPlugin, StagePlugin))
        .add_observer(open_document)
        .add_plugins((idle::plugin, samples::plugin, script::plugin, tour::plugin))
        .run()
}

fn is_document(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ron"))
}

/// A document that was named on the command line is opened when the bundled model is there, so that there is always a model.
fn open_document(_: On<ModelOpened>, mut arguments: ResMut<Arguments>, mut requests: MessageWriter<FileRequest>) {
    if let Some(path) = arguments.mesh.take_if(|path| is_document(path)) {
        requests.write(FileRequest::Open(path));
    }
}

/// Where the editor keeps what is its own; none where the system does not say.
fn own_folder() -> Option<PathBuf> {
    let variable = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let state = variable("XDG_STATE_HOME").or_else(|| variable("LOCALAPPDATA"));
    let state = state.or_else(|| Some(variable("HOME")?.join(".local/state")))?;
    Some(state.join("bevy_surface_splines"))
}

/// The documents that were opened last; a script leaves no traces.
fn recent_documents(scripted: bool) -> RecentDocuments {
    let folder = own_folder().filter(|folder| !scripted && std::fs::create_dir_all(folder).is_ok());
    folder.map(|folder| RecentDocuments::from_file(folder.join("recent.ron"))).unwrap_or_default()
}

fn engine(scripted: bool) -> PluginGroupBuilder {
    let (width, height) = if scripted { (960, 600) } else { (1280, 720) };
    let mut resolution = WindowResolution::new(width, height);
    if scripted {
        resolution.set_scale_factor_override(Some(1.0));
    }
    let title = "Curves on surfaces".to_string();
    let window = Window { title, resolution, present_mode: PresentMode::AutoVsync, ..default() };
    DefaultPlugins
        // The editor asks first where edits are not saved.
        .set(WindowPlugin { primary_window: Some(window), close_when_requested: false, ..default() })
        // A picture of a half-compiled scene would prove nothing.
        .set(RenderPlugin { synchronous_pipeline_compilation: scripted, ..default() })
}
