//! From a file to the scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::*;
use bevy::tasks::{Task, block_on, futures_lite::future};
use bevy::window::FileDragAndDrop;

use super::{DocumentFile, FileRequest, FileTasks, RecentDocuments, spawn};
use crate::editor::camera::{Orbit, set_view};
use crate::editor::curves::{self, Curve, NextNumber, Shelved};
use crate::editor::history::{self, History};
use crate::editor::model::{Candidate, Model, ModelOpened, OpenModel, bundled_reference};
use crate::editor::notices::Notices;
use crate::editor::selection::Selection;
use crate::format::document::{Document, DocumentError, Restored, SplineStyle, SurfaceReference};
use crate::geodesic::PathFinder;
use crate::plugin::{BuiltSurface, LineSmoothing, SurfaceLine};
use crate::surface::Surface;

/// A document that was read, and where it belongs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Opened {
    pub(crate) document: Document,
    /// Empty for one that was never saved.
    pub(crate) path: PathBuf,
    /// Whether it comes from an autosave, and is not saved as it is.
    pub(crate) recovered: bool,
}

pub(crate) type ReadResult = Result<Opened, (PathBuf, DocumentError)>;

/// The splines of a document are restored on this model, or candidate for one.
#[derive(Component)]
pub(crate) struct Restoring {
    opened: Arc<Opened>,
    task: Task<Result<Restored, DocumentError>>,
}

pub(crate) fn open_dropped(mut drops: MessageReader<FileDragAndDrop>, mut requests: MessageWriter<FileRequest>) {
    for event in drops.read() {
        if let FileDragAndDrop::DroppedFile { path_buf, .. } = event {
            requests.write(FileRequest::Open(path_buf.clone()));
        }
    }
}

pub(crate) fn read(from: &Path, path: PathBuf) -> ReadResult {
    match Document::open(from) {
        Ok(document) => Ok(Opened { document, recovered: from != path, path }),
        Err(error) => Err((from.to_owned(), error)),
    }
}

/// A document was read: its splines go onto the model that is there, if it is the document's, or onto its own, which is read first.
pub(crate) fn collect(
    mut commands: Commands,
    mut tasks: ResMut<FileTasks>,
    models: Query<(Entity, &Model, &BuiltSurface)>,
    mut opens: MessageWriter<OpenModel>,
    mut notices: ResMut<Notices>,
) {
    let opened = match super::fetch(&mut tasks.reading) {
        Some(Ok(opened)) => Arc::new(opened),
        Some(Err((path, error))) => {
            notices.error(format!("{} was not opened, and all stays as it was: {error}", path.display()));
            return;
        }
        None => return,
    };
    let wanted = &opened.document.surface;
    let current = models.iter().next();
    if let Some((entity, model, surface)) =
        current.filter(|(_, model, surface)| model.reference(surface).is_same_mesh(wanted))
    {
        begin(&mut commands, entity, surface, model.reference(surface), opened);
    } else if let Some(mesh) = wanted.resolve(&opened.path).filter(|mesh| mesh.is_file()) {
        opens.write(OpenModel::Document(mesh, opened));
    } else if bundled_reference().is_some_and(|bundled| bundled.fingerprint == wanted.fingerprint) {
        opens.write(OpenModel::BundledDocument(opened));
    } else if let Some((entity, model, surface)) = current {
        let name = wanted.path.as_deref().unwrap_or("The document's model");
        notices.warn(format!("{name} is not there: its curves go to the nearest places of the model that is open."));
        begin(&mut commands, entity, surface, model.reference(surface), opened);
    } else {
        notices.error("The document's model is not there: open a model first, then the document.");
    }
}

/// Restores the splines in the background.
pub(crate) fn begin(
    commands: &mut Commands,
    on: Entity,
    surface: &BuiltSurface,
    known: SurfaceReference,
    opened: Arc<Opened>,
) {
    let (surface, work) = (surface.0.clone(), opened.clone());
    let task = spawn(move || restore(&surface, &known, &work.document));
    commands.entity(on).insert(Restoring { opened, task });
}

fn restore(surface: &Surface, known: &SurfaceReference, document: &Document) -> Result<Restored, DocumentError> {
    document.restore_as(surface, known, &mut PathFinder::new())
}

/// What a document takes the place of.
#[derive(bevy::ecs::system::SystemParam)]
pub(crate) struct Stage<'w, 's> {
    commands: Commands<'w, 's>,
    candidates: Query<'w, 's, &'static Candidate>,
    models: Query<'w, 's, Entity, With<Model>>,
    curves: Query<'w, 's, Entity, With<Curve>>,
    shelved: Query<'w, 's, Entity, With<Shelved>>,
    cameras: Query<'w, 's, (&'static mut Orbit, &'static mut Transform, &'static mut Projection)>,
    next: ResMut<'w, NextNumber>,
    files: ResMut<'w, DocumentFile>,
    recent: ResMut<'w, RecentDocuments>,
    history: ResMut<'w, History>,
    selection: ResMut<'w, Selection>,
    notices: ResMut<'w, Notices>,
}

pub(crate) fn collect_restored(mut restoring: Query<(Entity, &mut Restoring)>, mut stage: Stage) {
    for (entity, mut restoring) in &mut restoring {
        let Some(result) = block_on(future::poll_once(&mut restoring.task)) else { continue };
        stage.commands.entity(entity).remove::<Restoring>();
        match result {
            Ok(restored) => stage.take_over(entity, &restoring.opened, restored),
            Err(error) => {
                if stage.candidates.contains(entity) {
                    stage.commands.entity(entity).despawn();
                }
                let path = restoring.opened.path.display();
                stage.notices.error(format!("{path} was not opened, and all stays as it was: {error}"));
            }
        }
    }
}

impl Stage<'_, '_> {
    fn take_over(&mut self, entity: Entity, opened: &Opened, restored: Restored) {
        if let Ok(candidate) = self.candidates.get(entity) {
            self.models.iter().for_each(|old| self.commands.entity(old).despawn());
            let model = (candidate.model.clone(), Visibility::Visible);
            self.commands.entity(entity).remove::<Candidate>().insert(model);
        }
        self.curves.iter().for_each(|old| self.commands.entity(old).try_despawn());
        history::clear(&mut self.commands, &mut self.history, &self.shelved);
        self.selection.clear();
        *self.next = NextNumber::default();
        let mut left_out = 0;
        for (stored, spline) in opened.document.splines.iter().zip(&restored.splines) {
            match spline {
                Some(spline) => {
                    let curve =
                        look_of(self.next.curve(Some(&stored.name)), &stored.style, stored.hidden, stored.locked);
                    curves::spawn(&mut self.commands, entity, curve, spline.clone());
                }
                None => left_out += 1,
            }
        }
        for (stored, line) in opened.document.lines.iter().zip(&restored.lines) {
            match line {
                Some(restored) => {
                    let curve =
                        look_of(self.next.curve(Some(&stored.name)), &stored.style, stored.hidden, stored.locked);
                    let smoothing = restored.smoothing.map(LineSmoothing::from);
                    let line = SurfaceLine::new(restored.line.clone());
                    curves::spawn_line(&mut self.commands, entity, curve, line, smoothing);
                }
                None => left_out += 1,
            }
        }
        if let Some(view) = &opened.document.view {
            for (mut orbit, mut place, mut lens) in &mut self.cameras {
                set_view(view, &mut orbit, &mut place, &mut lens);
            }
        }
        let is_mapped = restored.mapping.is_some();
        if let Some(report) = restored.mapping {
            self.notices.warn(format!(
                "The model is not the document's own: points went to the nearest places, {:.3} away at most; {left_out} curves could \
                 not be placed. Save to keep them so.",
                report.largest_distance()
            ));
        }
        if is_mapped || opened.recovered {
            self.history.mark_touched();
        }
        let never_saved = opened.path.as_os_str().is_empty();
        if !never_saved {
            self.recent.note(&opened.path);
        }
        self.files.path = (!never_saved).then(|| opened.path.clone());
        let name = opened.path.file_name().map_or("what was not saved".into(), |name| name.to_string_lossy());
        let all = restored.splines.len() + restored.lines.len();
        self.notices.info(format!("Opened {name}: {} curves", all - left_out));
    }
}

fn look_of(curve: Curve, style: &SplineStyle, hidden: bool, locked: bool) -> Curve {
    let [red, green, blue, alpha] = style.colour;
    Curve { color: Color::srgba(red, green, blue, alpha), width: style.width, hidden, locked, ..curve }
}

/// A model that was opened by itself is no document yet.
pub(crate) fn forget_path(_: On<ModelOpened>, mut files: ResMut<DocumentFile>) {
    files.path = None;
}

/// What a candidate does when its surface is built, where it belongs to a document.
pub(crate) fn begin_on_candidate(
    commands: &mut Commands,
    entity: Entity,
    candidate: &Candidate,
    surface: &BuiltSurface,
) -> bool {
    let Some(opened) = &candidate.document else { return false };
    begin(commands, entity, surface, candidate.model.reference(surface), opened.clone());
    true
}
