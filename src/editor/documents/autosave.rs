//! Keeping what is not saved, now and then, and finding it again.

use std::path::{Path, PathBuf};
use std::time::Duration;

use bevy::prelude::*;
use bevy::tasks::{Task, block_on, futures_lite::future};

use super::save::Scene;
use super::{DocumentFile, Question, Then, spawn};
use crate::editor::history::Revision;
use crate::editor::notices::Notices;
use crate::format::document::{Autosave, DocumentError};

/// How unsaved edits are kept.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct AutosaveSettings {
    /// How long edits may go unsaved.
    pub every: Duration,
    /// Where documents are kept that have no file yet; without it they are not kept.
    pub folder: Option<PathBuf>,
    /// Whether anything is kept at all.
    pub enabled: bool,
}

impl Default for AutosaveSettings {
    fn default() -> Self {
        Self { every: Duration::from_secs(30), folder: None, enabled: true }
    }
}

/// An autosave that was found, and the document it belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) autosave: PathBuf,
    pub(crate) document: Option<PathBuf>,
}

impl Found {
    /// Throws it away.
    pub(crate) fn discard(&self) {
        if let Err(error) = std::fs::remove_file(&self.autosave) {
            warn!("{} stays: {error}", self.autosave.display());
        }
    }
}

fn place_of(document: Option<&Path>, settings: &AutosaveSettings) -> Option<Autosave> {
    match (document, &settings.folder) {
        (Some(document), _) => Some(Autosave::beside(document)),
        (None, Some(folder)) => Some(Autosave::in_folder(folder, None)),
        (None, None) => None,
    }
}

/// The autosave of a document that is newer than it.
pub(crate) fn beside(document: &Path, settings: &AutosaveSettings) -> Option<Found> {
    let found = place_of(Some(document), settings)?.recovery()?;
    Some(Found { autosave: found.path, document: Some(document.to_owned()) })
}

/// What is saved needs no autosave.
pub(crate) fn discard(document: Option<&Path>, settings: &AutosaveSettings) {
    if let Some(Err(error)) = place_of(document, settings).map(|autosave| autosave.discard()) {
        warn!("the autosave stays: {error}");
    }
}

/// A document that was never saved may have been kept when the program ended.
pub(crate) fn look_for_untitled(settings: Res<AutosaveSettings>, mut files: ResMut<DocumentFile>) {
    let found = settings.folder.as_ref().and_then(|folder| Autosave::in_folder(folder, None).recovery());
    if let Some(found) = found.filter(|_| settings.enabled) {
        let then = Then::Recover(Found { autosave: found.path, document: None });
        let text = format!(
            "Curves that were drawn {}were not saved when the editor ended. Opening them shows the model that they are on.",
            age_of(&then)
        );
        files.question = Some(Question { text, yes: "Open them", no: "Throw them away for good", then });
    }
}

/// How long ago something was kept, in words.
fn age_of(then: &Then) -> String {
    let Then::Recover(found) = then else { return String::new() };
    let kept = std::fs::metadata(&found.autosave).and_then(|file| file.modified());
    let Some(age) = kept.ok().and_then(|kept| kept.elapsed().ok()) else { return String::new() };
    match age.as_secs() / 60 {
        0 | 1 => "a minute ago ".into(),
        minutes @ ..60 => format!("{minutes} minutes ago "),
        minutes @ ..2880 => format!("{} hours ago ", minutes / 60),
        minutes => format!("{} days ago ", minutes / 1440),
    }
}

/// What is kept, and when it was last.
#[derive(Default)]
pub(crate) struct Keeping {
    since: Duration,
    revision: Option<Revision>,
    task: Option<Task<Result<(), DocumentError>>>,
}

/// Keeps unsaved edits, in the background.
pub(crate) fn keep(
    mut keeping: Local<Keeping>,
    time: Res<Time<Real>>,
    settings: Res<AutosaveSettings>,
    files: Res<DocumentFile>,
    scene: Scene,
    mut notices: ResMut<Notices>,
) {
    if let Some(result) = keeping.task.as_mut().and_then(|task| block_on(future::poll_once(task))) {
        keeping.task = None;
        if let Err(error) = result {
            notices.warn(format!("Unsaved edits cannot be kept: {error}"));
        }
    }
    let revision = scene.history.revision();
    if !settings.enabled || !scene.history.is_dirty() || keeping.revision == Some(revision) {
        keeping.since = Duration::ZERO;
        return;
    }
    keeping.since += time.delta();
    // An open question is about the autosave that is there.
    if keeping.since < settings.every || keeping.task.is_some() || files.question.is_some() || scene.history.is_busy() {
        return;
    }
    if let Some(work) = work(&scene, &files, &settings) {
        (keeping.revision, keeping.since) = (Some(revision), Duration::ZERO);
        keeping.task = Some(spawn(work));
    }
}

/// The work of keeping the document as it is now; none where there is no place for it.
pub(crate) fn work(
    scene: &Scene,
    files: &DocumentFile,
    settings: &AutosaveSettings,
) -> Option<impl FnOnce() -> Result<(), DocumentError> + Send + 'static> {
    let place = place_of(files.path(), settings)?;
    let document = scene.document(files.path()).ok()?;
    Some(move || {
        if let Some(folder) = place.path().parent() {
            std::fs::create_dir_all(folder).map_err(|source| DocumentError::Io { path: folder.to_owned(), source })?;
        }
        place.save(&document)
    })
}
