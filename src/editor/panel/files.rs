//! Asking for a file: a path field everywhere, the platform's dialog where it has one, and the documents used last.

use std::path::PathBuf;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on, futures_lite::future};
use bevy_egui::egui;

use super::theme;
use crate::editor::documents::{DocumentFile, ExportKind, FileRequest, RecentDocuments};
use crate::editor::history::History;
use crate::editor::input::{PanelInput, StruckKeys, ToolKeys, keyboard_is_free};

/// What a file is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    Open,
    SaveAs,
    Export,
    Drawing,
}

impl Purpose {
    fn title(self) -> &'static str {
        match self {
            Self::Open => "Open",
            Self::SaveAs => "Save as",
            Self::Export => "Export",
            Self::Drawing => "Choose a drawing",
        }
    }

    fn hint(self) -> &'static str {
        match self {
            Self::Open => "A document (.ron), a drawing (.svg), or a mesh: OBJ, STL, PLY, OFF, glTF, GLB",
            Self::SaveAs => "A document ends in .splines.ron",
            Self::Export => ".obj, .csv or .glb for the lines of the traces, .svg for a drawing of them",
            Self::Drawing => "An SVG; it follows the pointer then, and a click places it",
        }
    }

    fn filters(self) -> &'static [(&'static str, &'static [&'static str])] {
        const MESHES: &[&str] = &["obj", "stl", "ply", "off", "gltf", "glb"];
        match self {
            Self::Open => &[
                ("All that can be opened", &["ron", "svg", "obj", "stl", "ply", "off", "gltf", "glb"]),
                ("Documents", &["ron"]),
                ("Meshes", MESHES),
                ("Drawings", &["svg"]),
            ],
            Self::SaveAs => &[("Documents", &["ron"])],
            Self::Export => &[("Lines and drawings", &["obj", "csv", "glb", "svg"])],
            Self::Drawing => &[("Drawings", &["svg"])],
        }
    }

    fn saves(self) -> bool {
        matches!(self, Self::SaveAs | Self::Export)
    }

    fn place(self) -> usize {
        match self {
            Self::Open => 0,
            Self::SaveAs => 1,
            Self::Export => 2,
            Self::Drawing => 3,
        }
    }

    fn request(self, path: PathBuf, kind: ExportKind) -> FileRequest {
        match self {
            Self::Open | Self::Drawing => FileRequest::Open(path),
            Self::SaveAs => FileRequest::SaveAs(path),
            Self::Export => FileRequest::Export(path, kind),
        }
    }
}

/// The file that is asked for.
#[derive(Resource, Default)]
pub(crate) struct FileDialog {
    purpose: Option<Purpose>,
    /// What was typed last, for each purpose: what is opened must not be written over by chance.
    paths: [String; 4],
    is_new: bool,
    /// How often a place to save to was wanted when this was asked last.
    places_wanted: u32,
    /// How an SVG is drawn.
    kind: ExportKind,
    browsing: Option<Task<Option<PathBuf>>>,
}

impl FileDialog {
    pub(crate) fn ask(&mut self, purpose: Purpose) {
        (self.purpose, self.is_new) = (Some(purpose), true);
    }

    pub(crate) fn is_open(&self) -> bool {
        self.purpose.is_some()
    }
}

/// What files need.
#[derive(SystemParam)]
pub(crate) struct Files<'w> {
    pub(crate) dialog: ResMut<'w, FileDialog>,
    document: Option<Res<'w, DocumentFile>>,
    recent: Option<Res<'w, RecentDocuments>>,
    pub(crate) requests: Option<MessageWriter<'w, FileRequest>>,
    history: Res<'w, History>,
}

/// The row of buttons at the top of the scene; nothing in a game that opens no files.
pub(crate) fn show_buttons(ui: &mut egui::Ui, files: &mut Files) {
    let (Some(document), Some(requests)) = (&files.document, &mut files.requests) else { return };
    let name = document.path().and_then(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned());
    // A sign that does not rely on colour.
    let dirty = if files.history.is_dirty() { " •" } else { "" };
    let text = egui::RichText::new(format!("{}{dirty}", name.as_deref().unwrap_or("Not saved yet"))).strong();
    ui.add(egui::Label::new(text).truncate()).on_hover_text("The document; • stands for edits that are not saved");
    ui.horizontal_wrapped(|ui| {
        if ui.button("Open …").on_hover_text("Ctrl+O").clicked() {
            files.dialog.ask(Purpose::Open);
        }
        if ui.button("Save").on_hover_text("Ctrl+S").clicked() {
            requests.write(FileRequest::Save);
        }
        if ui.button("Save as …").on_hover_text("Ctrl+Shift+S").clicked() {
            files.dialog.ask(Purpose::SaveAs);
        }
        if ui.button("Export …").on_hover_text("Traces as OBJ, CSV or GLB, or all as an SVG").clicked() {
            files.dialog.ask(Purpose::Export);
        }
        let recent = files.recent.as_ref().map(|recent| recent.list.paths().to_vec()).unwrap_or_default();
        ui.add_enabled_ui(!recent.is_empty(), |ui| {
            ui.menu_button("Recent", |ui| {
                for path in recent {
                    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
                    if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                        requests.write(FileRequest::Open(path));
                        ui.close();
                    }
                }
            });
        });
    });
}

/// Shows the dialog or the question that is open.
pub(crate) fn show(ctx: &egui::Context, files: &mut Files) {
    let wanted = files.document.as_ref().map_or(0, |document| document.places_wanted());
    if wanted != files.dialog.places_wanted {
        files.dialog.places_wanted = wanted;
        files.dialog.ask(Purpose::SaveAs);
    }
    show_question(ctx, files);
    show_dialog(ctx, files);
}

fn show_question(ctx: &egui::Context, files: &mut Files) {
    let Some(question) = files.document.as_ref().and_then(|document| document.question().cloned()) else { return };
    let (mut answer, mut saves) = (None, false);
    let modal = egui::Modal::new("question".into()).frame(theme::card().inner_margin(20)).show(ctx, |ui| {
        ui.set_max_width(360.0);
        ui.label(&question.text);
        ui.add_space(8.0);
        ui.horizontal_wrapped(|ui| {
            saves = question.offers_saving() && ui.button("Save first").clicked();
            answer = ui.button(question.yes).clicked().then_some(true);
            if ui.button(question.no).clicked() {
                answer = Some(false);
            }
        });
    });
    if modal.should_close() && !question.decides_for_good() {
        answer = Some(false);
    }
    let Some(requests) = &mut files.requests else { return };
    if saves {
        requests.write(FileRequest::Save);
    } else if let Some(answer) = answer {
        requests.write(FileRequest::Answer(answer));
    }
}

fn show_dialog(ctx: &egui::Context, files: &mut Files) {
    let Some(purpose) = files.dialog.purpose else { return };
    let document = files.document.as_ref().and_then(|document| document.path().map(|path| path.display().to_string()));
    let dialog = &mut *files.dialog;
    let path = &mut dialog.paths[purpose.place()];
    if let Some(document) = document.filter(|_| purpose == Purpose::SaveAs && path.is_empty()) {
        *path = document;
    }
    let browsed = dialog.browsing.as_mut().and_then(|task| block_on(future::poll_once(task)));
    if let Some(found) = browsed {
        dialog.browsing = None;
        if let (Some(path), Some(requests)) = (found, &mut files.requests) {
            requests.write(purpose.request(path, dialog.kind));
            dialog.purpose = None;
            return;
        }
    }
    let (mut go, mut leave) = (false, false);
    let modal = egui::Modal::new("file".into()).frame(theme::card().inner_margin(20)).show(ctx, |ui| {
        ui.set_max_width(420.0);
        ui.heading(purpose.title());
        ui.label(egui::RichText::new(purpose.hint()).weak());
        let shown = egui::TextEdit::singleline(path).hint_text("Path").desired_width(400.0).show(ui);
        let field = shown.response.response.on_hover_text(format!("A relative path begins at {}", current_folder()));
        if std::mem::take(&mut dialog.is_new) {
            field.request_focus();
            // Whoever types replaces what was there.
            let mut state = shown.state;
            let all = egui::text::CCursorRange::two(
                egui::text::CCursor::new(0),
                egui::text::CCursor::new(path.chars().count()),
            );
            state.cursor.set_char_range(Some(all));
            state.store(ui.ctx(), field.id);
        }
        go |= field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        if purpose == Purpose::Export && path.trim().to_lowercase().ends_with(".svg") {
            ui.horizontal(|ui| {
                let unrolled = "Flat, as if unrolled from the first anchor: lengths and angles near it are true";
                ui.radio_value(&mut dialog.kind, ExportKind::Unrolled, "Unrolled").on_hover_text(unrolled);
                let seen = "As the camera sees them now";
                ui.radio_value(&mut dialog.kind, ExportKind::AsSeen, "As seen").on_hover_text(seen);
            });
        }
        ui.horizontal(|ui| {
            go |= ui.add_enabled(!path.trim().is_empty(), egui::Button::new(purpose.title())).clicked();
            if ui.add_enabled(dialog.browsing.is_none(), egui::Button::new("Browse …")).clicked() {
                dialog.browsing = Some(browse(purpose));
            }
            leave |= ui.button("Cancel").clicked();
        });
    });
    if go && !path.trim().is_empty() {
        let path = PathBuf::from(path.trim());
        if let Some(requests) = &mut files.requests {
            requests.write(purpose.request(path, dialog.kind));
        }
        dialog.purpose = None;
    } else if leave || modal.should_close() {
        (dialog.purpose, dialog.browsing) = (None, None);
    }
}

fn current_folder() -> String {
    std::env::current_dir().map(|folder| folder.display().to_string()).unwrap_or_default()
}

/// The platform's own dialog, while the editor goes on.
fn browse(purpose: Purpose) -> Task<Option<PathBuf>> {
    let mut dialog = rfd::AsyncFileDialog::new().set_title(purpose.title());
    for (name, extensions) in purpose.filters() {
        dialog = dialog.add_filter(*name, extensions);
    }
    AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(async move {
        let picked = if purpose.saves() { dialog.save_file().await } else { dialog.pick_file().await };
        picked.map(|file| file.path().to_owned())
    })
}

/// Ctrl+O, Ctrl+Shift+S and the drawing tool ask for a file.
pub(crate) fn strike(
    mut keys: StruckKeys,
    pressed: Res<ButtonInput<KeyCode>>,
    (panel, tool_keys): (Res<PanelInput>, Option<Res<ToolKeys>>),
    tool: Res<crate::editor::tools::Tool>,
    hand: Res<crate::editor::tools::drawing::DrawingInHand>,
    mut files: Files,
) {
    use crate::editor::tools::Tool;
    let struck = keys.read();
    keys.keep_held(&pressed);
    if files.requests.is_none() || !keyboard_is_free(panel, tool_keys) {
        return;
    }
    let has = |key: KeyCode, control: bool, shift: bool| {
        struck.iter().any(|(struck, held)| *struck == key && held.control == control && held.shift == shift)
    };
    if has(KeyCode::KeyO, true, false) {
        files.dialog.ask(Purpose::Open);
    }
    if has(KeyCode::KeyS, true, true) {
        files.dialog.ask(Purpose::SaveAs);
    }
    // D again asks for another one.
    let taken = tool.is_changed() && *tool == Tool::Drawing && hand.name().is_none() && !hand.is_busy();
    let again = *tool == Tool::Drawing && has(KeyCode::KeyD, false, false);
    let asks = taken || again;
    if asks && !files.dialog.is_open() {
        files.dialog.ask(Purpose::Drawing);
    }
}
