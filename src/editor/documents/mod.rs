//! Documents: opening, saving, exporting, in the background, so that no file makes a frame wait.
//!
//! What fails leaves everything as it was: a document takes the place of the one before when its model is built and all its
//! splines are restored, and a file is replaced as a whole or not at all.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on, futures_lite::future};

use super::model::{Candidate, OpenModel, Reading};
use super::tools::drawing::DrawingInHand;
use crate::format::document::Recent;

mod autosave;
mod close;
mod export;
mod open;
mod save;

pub use autosave::AutosaveSettings;
pub use export::ExportKind;
pub(crate) use open::{Opened, Restoring, begin_on_candidate};

/// Asks for something to be done with files.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub enum FileRequest {
    /// Opens a document (`.ron`), a drawing (`.svg`) or a mesh, told apart by how the name ends.
    Open(PathBuf),
    /// Saves the document where it came from; asks for a place if it came from nowhere.
    Save,
    /// Saves the document under another name.
    SaveAs(PathBuf),
    /// Writes all traces as OBJ, CSV or GLB lines, or as a drawing (`.svg`), told apart by how the name ends.
    Export(PathBuf, ExportKind),
    /// Stops what is done in the background: nothing comes of it. A file that is being written is whole or as it was.
    Cancel,
    /// Answers the question that is open: goes on, or leaves everything as it is.
    Answer(bool),
}

/// The document that is edited.
#[derive(Resource, Debug, Default)]
pub struct DocumentFile {
    path: Option<PathBuf>,
    question: Option<Question>,
    /// How often a place to save to was asked for.
    places_wanted: u32,
    working: Option<&'static str>,
    /// The user closes the editor and does not want what is not saved.
    leaves_edits: bool,
}

/// Something to be decided before anything is done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Question {
    /// What is asked.
    pub text: String,
    /// What the answer yes does.
    pub yes: &'static str,
    /// What the answer no does.
    pub no: &'static str,
    then: Then,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Then {
    /// Opens something else, and unsaved edits are lost.
    Open(PathBuf),
    /// Opens the autosave, or throws it away.
    Recover(autosave::Found),
    /// Writes over a file.
    Save(PathBuf),
    Export(PathBuf, ExportKind),
    /// Closes a window, and unsaved edits are lost.
    Close(Entity),
}

impl Question {
    /// Whether no answer may be taken for no: something would be lost.
    pub fn decides_for_good(&self) -> bool {
        matches!(self.then, Then::Recover(_))
    }

    /// Whether saving first would lose nothing: once that is done ([`FileRequest::Save`]), the question has answered itself.
    pub fn offers_saving(&self) -> bool {
        matches!(self.then, Then::Open(_) | Then::Close(_))
    }
}

impl DocumentFile {
    /// Where it was opened from or saved to.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The question that is open.
    pub fn question(&self) -> Option<&Question> {
        self.question.as_ref()
    }

    /// What is done in the background with files, in words.
    pub fn working(&self) -> Option<&'static str> {
        self.working
    }

    /// How often a place to save to was asked for: whoever sees the count grow should ask the user.
    pub fn places_wanted(&self) -> u32 {
        self.places_wanted
    }
}

/// The documents that were opened or saved last, and the file that remembers them; none is kept without.
#[derive(Resource, Debug, Default)]
pub struct RecentDocuments {
    /// The list.
    pub list: Recent,
    /// Where it is kept.
    pub file: Option<PathBuf>,
}

impl RecentDocuments {
    /// The list that a file remembers.
    pub fn from_file(file: PathBuf) -> Self {
        Self { list: Recent::load(&file), file: Some(file) }
    }

    fn note(&mut self, path: &Path) {
        self.list.note(path);
        if let Some(file) = &self.file
            && let Err(error) = self.list.save(file)
        {
            warn!("the list of recent documents is not kept: {error}");
        }
    }
}

/// Work with files that is under way: what is written, read or made, one thing at a time each.
#[derive(Resource, Default)]
pub(crate) struct FileTasks {
    reading: Option<Task<open::ReadResult>>,
    saving: Option<Task<save::SaveResult>>,
    exporting: Option<Task<export::ExportResult>>,
}

pub(crate) fn spawn<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Task<T> {
    AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(async move { work() })
}

/// Fetches what a task made, if it is done.
fn fetch<T>(task: &mut Option<Task<T>>) -> Option<T> {
    let done = block_on(future::poll_once(task.as_mut()?))?;
    *task = None;
    Some(done)
}

pub(crate) fn plugin(app: &mut App) {
    app.add_message::<FileRequest>()
        .init_resource::<DocumentFile>()
        .init_resource::<RecentDocuments>()
        .init_resource::<FileTasks>()
        .init_resource::<AutosaveSettings>()
        .add_observer(open::forget_path)
        .add_systems(
            Update,
            (
                open::open_dropped,
                take_requests,
                (open::collect, open::collect_restored, save::collect, export::collect, autosave::keep, tell_work),
                close::ask,
            )
                .chain(),
        )
        .add_systems(Startup, autosave::look_for_untitled)
        .add_systems(Last, close::keep_edits);
}

/// Models on which a document is restored, or that are to take the place of the one before.
type UnderWay = Or<(With<Restoring>, With<Candidate>)>;

/// What requests need.
#[derive(bevy::ecs::system::SystemParam)]
struct Desk<'w, 's> {
    commands: Commands<'w, 's>,
    restoring: Query<'w, 's, (Entity, Has<Candidate>), UnderWay>,
    hand: ResMut<'w, DrawingInHand>,
    reading: ResMut<'w, Reading>,
    files: ResMut<'w, DocumentFile>,
    tasks: ResMut<'w, FileTasks>,
    scene: save::Scene<'w, 's>,
    opens: MessageWriter<'w, OpenModel>,
    drawings: MessageWriter<'w, super::tools::drawing::TakeDrawing>,
    notices: ResMut<'w, super::notices::Notices>,
    settings: Res<'w, AutosaveSettings>,
}

fn take_requests(mut requests: MessageReader<FileRequest>, mut desk: Desk) {
    for request in requests.read() {
        match request {
            FileRequest::Open(path) => desk.open(path),
            FileRequest::Save => match desk.files.path.clone() {
                Some(path) => desk.save(path),
                None => desk.files.places_wanted += 1,
            },
            FileRequest::SaveAs(path) => desk.save_as(with_extension(path)),
            FileRequest::Export(path, kind) => desk.export_to(path, *kind),
            FileRequest::Cancel => desk.cancel(),
            FileRequest::Answer(yes) => desk.answer(*yes),
        }
    }
}

/// A document's name ends as documents do.
fn with_extension(path: &Path) -> PathBuf {
    let ends = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ron"));
    if ends { path.to_owned() } else { PathBuf::from(format!("{}.splines.ron", path.display())) }
}

impl Desk<'_, '_> {
    fn open(&mut self, path: &Path) {
        let kind = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        if kind.as_deref() == Some("svg") {
            self.drawings.write(super::tools::drawing::TakeDrawing(path.to_owned()));
            return;
        }
        if self.scene.history.is_dirty() {
            let text = "There are edits that are not saved. Opening another file takes its place.".into();
            let then = Then::Open(path.to_owned());
            self.ask(Question { text, yes: "Open, lose the edits", no: "Stay here", then });
            return;
        }
        self.open_at_once(path);
    }

    fn open_at_once(&mut self, path: &Path) {
        let is_document = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ron"));
        if !is_document {
            self.opens.write(OpenModel::File(path.to_owned()));
            return;
        }
        if let Some(found) = autosave::beside(path, &self.settings) {
            let text = format!("{} was not saved when it was edited last.", path.display());
            let then = Then::Recover(found);
            self.ask(Question { text, yes: "Take the newer one", no: "Open what was saved", then });
            return;
        }
        self.read(path.to_owned(), path.to_owned());
    }

    /// Reads a document from one place that belongs to another: an autosave belongs to its document.
    fn read(&mut self, from: PathBuf, path: PathBuf) {
        self.tasks.reading = Some(spawn(move || open::read(&from, path)));
    }

    fn answer(&mut self, yes: bool) {
        let Some(question) = self.files.question.take() else { return };
        match (question.then, yes) {
            (Then::Open(path), true) => self.open_at_once(&path),
            (Then::Save(path), true) => self.save(path),
            (Then::Export(path, kind), true) => self.export(&path, kind),
            (Then::Close(window), true) => self.close(window),
            (Then::Open(_) | Then::Save(_) | Then::Export(..) | Then::Close(_), false) => {}
            (Then::Recover(found), true) => self.read(found.autosave, found.document.unwrap_or_default()),
            (Then::Recover(found), false) => {
                found.discard();
                if let Some(path) = found.document {
                    self.read(path.clone(), path);
                }
            }
        }
    }

    /// A file that is not the document's own is not written over without a question.
    fn save_as(&mut self, path: PathBuf) {
        if path.exists() && self.files.path.as_ref() != Some(&path) {
            self.ask_to_replace(path.clone(), Then::Save(path));
        } else {
            self.save(path);
        }
    }

    fn export_to(&mut self, path: &Path, kind: ExportKind) {
        let whole = |path: &Path| std::fs::canonicalize(path).ok();
        let is_mesh = |mesh: &PathBuf| whole(mesh).is_some_and(|mesh| whole(path) == Some(mesh));
        if self.scene.models.iter().any(|(_, model, _)| model.path.as_ref().is_some_and(is_mesh)) {
            self.notices
                .error(format!("Nothing was exported: {} is the model itself; choose another name.", path.display()));
        } else if path.exists() {
            self.ask_to_replace(path.to_owned(), Then::Export(path.to_owned(), kind));
        } else {
            self.export(path, kind);
        }
    }

    fn ask_to_replace(&mut self, path: PathBuf, then: Then) {
        let text = format!("{} is there already.", path.display());
        self.ask(Question { text, yes: "Replace it", no: "Leave it", then });
    }

    /// One question at a time; one that decides for good waits for its answer.
    fn ask(&mut self, question: Question) {
        if self.files.question.as_ref().is_some_and(Question::decides_for_good) {
            self.notices.warn("Answer the question that is open first.");
        } else {
            self.files.question = Some(question);
        }
    }

    /// What was not saved is not wanted any more.
    fn close(&mut self, window: Entity) {
        self.files.leaves_edits = true;
        autosave::discard(self.files.path(), &self.settings);
        self.commands.entity(window).try_despawn();
    }

    fn cancel(&mut self) {
        *self.tasks = FileTasks::default();
        self.hand.cancel();
        // Without a model there is nothing to stay with.
        if !self.scene.models.is_empty() {
            self.reading.cancel();
        }
        for (entity, is_candidate) in &self.restoring {
            self.commands.entity(entity).remove::<Restoring>();
            if is_candidate && !self.scene.models.is_empty() {
                self.commands.entity(entity).despawn();
            }
        }
    }

    fn save(&mut self, path: PathBuf) {
        if self.tasks.saving.is_some() {
            self.notices.warn("The document is being saved: wait until it is done.");
            return;
        }
        match self.scene.document(Some(&path)) {
            Ok(document) => {
                let revision = self.scene.history.revision();
                self.tasks.saving = Some(spawn(move || save::write(&document, path, revision)));
            }
            Err(reason) => self.notices.error(format!("The document cannot be saved: {reason}")),
        }
    }

    fn export(&mut self, path: &Path, kind: ExportKind) {
        if self.tasks.exporting.is_some() {
            self.notices.warn("Another file is being exported: wait until it is done.");
            return;
        }
        match self.scene.export(path, kind) {
            Ok(work) => self.tasks.exporting = Some(spawn(work)),
            Err(reason) => self.notices.error(format!("Nothing was exported: {reason}")),
        }
    }
}

fn tell_work(
    mut files: ResMut<DocumentFile>,
    (tasks, hand, model): (Res<FileTasks>, Res<DrawingInHand>, Res<Reading>),
    (restoring, candidates): (Query<(), With<Restoring>>, Query<(), With<Candidate>>),
) {
    let working = if tasks.reading.is_some() {
        Some("Reading the document …")
    } else if !restoring.is_empty() {
        Some("Restoring the curves …")
    } else if model.is_busy() {
        Some("Reading the model …")
    } else if !candidates.is_empty() {
        Some("Building the surface …")
    } else if hand.is_busy() {
        Some("Reading and placing the drawing …")
    } else if tasks.saving.is_some() {
        Some("Saving …")
    } else if tasks.exporting.is_some() {
        Some("Exporting …")
    } else {
        None
    };
    if files.working != working {
        files.working = working;
    }
}
