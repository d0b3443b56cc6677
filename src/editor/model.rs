//! The model: reading it in the background, and putting it in the place of the one before once its surface is built.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, block_on, futures_lite::future};
use glam::DVec3;

use super::actions::{EditorAction, ShownRepairs};
use super::curves::Shelved;
use super::documents::{Opened, begin_on_candidate};
use super::history::{self, History};
use super::notices::Notices;
use super::shading::shaded_mesh;
use crate::format::document::{Fingerprint, Frame, SurfaceReference};
use crate::format::{MeshFormat, parse_mesh, read_mesh};
use crate::plugin::{BuiltSurface, SplineSurface, SurfaceFailed, SurfaceReady};
use crate::surface::{Surface, SurfaceOptions, SurfaceReport, TriangleMesh};

const BUNDLED: &[u8] = include_bytes!("../../assets/pebble.obj");

/// The model on the stage: the entity with the surface. It is moved and scaled into the unit sphere before it is rounded
/// to the numbers that graphics cards know, so that neither its size nor its place matter.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Model {
    /// What it is called: its file's name.
    pub name: String,
    /// Whether it is the one that comes with the editor.
    pub bundled: bool,
    /// Its file; none for the one that comes with the editor.
    pub path: Option<PathBuf>,
    /// By what a document knows its mesh, as it is in the file.
    fingerprint: Fingerprint,
    /// In the file's units: what is the origin here, and how long the unit is.
    centre: DVec3,
    pub(crate) unit: f64,
}

impl Model {
    /// A position in the file's coordinates.
    pub fn in_file(&self, position: DVec3) -> DVec3 {
        self.centre + self.unit * position
    }

    /// By what a document knows the model again.
    pub(crate) fn reference(&self, surface: &Surface) -> SurfaceReference {
        let frame = Frame { centre: self.centre.to_array(), unit: self.unit };
        SurfaceReference { fingerprint: self.fingerprint, frame, ..SurfaceReference::of(surface) }
    }

    /// A position of the file where it is here.
    pub fn of_file(&self, position: DVec3) -> DVec3 {
        (position - self.centre) / self.unit
    }
}

/// A model whose surface is being built; the old one stays until it is known to be usable.
#[derive(Component, Clone, Debug)]
pub(crate) struct Candidate {
    pub(crate) model: Model,
    /// The document that is to be restored on it.
    pub(crate) document: Option<Arc<Opened>>,
}

/// Asks for a model.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum OpenModel {
    /// The one that comes with the editor.
    Bundled,
    /// A file.
    File(PathBuf),
    /// The mesh of a document.
    #[doc(hidden)]
    #[allow(private_interfaces, reason = "documents alone make it")]
    Document(PathBuf, Arc<Opened>),
    /// A document about the model that comes with the editor.
    #[doc(hidden)]
    #[allow(private_interfaces, reason = "documents alone make it")]
    BundledDocument(Arc<Opened>),
}

/// Happens when a model has taken its place.
#[derive(EntityEvent, Clone, Debug)]
pub struct ModelOpened {
    /// The model.
    pub entity: Entity,
}

/// Happens when a model could not be used; the old one stays.
#[derive(Event, Clone, Debug)]
pub struct ModelRefused {
    /// Why, and what to do about it.
    pub reason: String,
}

/// The model that is being read.
#[derive(Resource, Default)]
pub(crate) struct Reading(Option<Task<Result<Read, String>>>);

impl Reading {
    /// Whether a model is being read.
    pub(crate) fn is_busy(&self) -> bool {
        self.0.is_some()
    }

    /// Stops reading.
    pub(crate) fn cancel(&mut self) {
        self.0 = None;
    }
}

pub(crate) struct Read {
    model: Model,
    mesh: Mesh,
    document: Option<Arc<Opened>>,
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Reading>()
        .add_message::<OpenModel>()
        .add_observer(take_place)
        .add_observer(refuse_surface)
        .add_observer(tell_refusal)
        .add_observer(forget_history)
        .init_resource::<FirstModel>()
        .add_systems(Startup, open_first)
        .add_systems(Update, (start_reading, finish_reading).chain());
}

/// The model that the program opens first; the bundled one, if none is named.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct FirstModel(pub Option<PathBuf>);

fn open_first(first: Res<FirstModel>, mut opens: MessageWriter<OpenModel>) {
    opens.write(first.0.clone().map_or(OpenModel::Bundled, OpenModel::File));
}

fn start_reading(mut opens: MessageReader<OpenModel>, mut reading: ResMut<Reading>) {
    // Of several the last; a task that is dropped is cancelled.
    if let Some(open) = opens.read().last().cloned() {
        reading.0 = Some(AsyncComputeTaskPool::get().spawn(async move { read(&open) }));
    }
}

fn read(open: &OpenModel) -> Result<Read, String> {
    let (path, document) = match open {
        OpenModel::Bundled => (None, None),
        OpenModel::BundledDocument(document) => (None, Some(document.clone())),
        OpenModel::File(path) => (Some(path.clone()), None),
        OpenModel::Document(path, document) => (Some(path.clone()), Some(document.clone())),
    };
    let (triangles, name) = match &path {
        None => (parse_mesh(BUNDLED, MeshFormat::Obj), "Pebble (bundled)".to_string()),
        Some(path) => (read_mesh(path), file_name(path)),
    };
    let mut triangles = triangles.map_err(|error| {
        let error = error.to_string();
        if error.contains(&name) { error } else { format!("{name}: {error}") }
    })?;
    let (centre, unit) = sphere_around(&triangles);
    let fingerprint = Fingerprint(triangles.fingerprint());
    let model = Model { name, bundled: path.is_none(), path, fingerprint, centre, unit };
    triangles.positions.iter_mut().for_each(|p| *p = model.of_file(*p));
    Ok(Read { model, mesh: shaded_mesh(&triangles), document })
}

/// By what a document knows the model that comes with the editor.
pub(crate) fn bundled_reference() -> Option<SurfaceReference> {
    let triangles = parse_mesh(BUNDLED, MeshFormat::Obj).ok()?;
    let surface = Surface::build(&triangles, &SurfaceOptions::default()).ok()?;
    Some(SurfaceReference::of(&surface))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The centre of the bounding box, and the radius of the sphere about it that holds all that is used and finite.
fn sphere_around(triangles: &TriangleMesh) -> (DVec3, f64) {
    let used = triangles.faces.iter().flatten().filter_map(|v| triangles.positions.get(*v as usize));
    let finite = used.filter(|p| p.is_finite());
    let bounds = finite.clone().fold(None, |bounds, p| {
        let (min, max) = bounds.unwrap_or((*p, *p));
        Some((p.min(min), p.max(max)))
    });
    let Some((min, max)) = bounds else { return (DVec3::ZERO, 1.0) };
    // Halves first: the sum of two large numbers may be infinite.
    let centre = 0.5 * min + 0.5 * max;
    // The square of a large number may be infinite too.
    let extent = (max - min).max_element();
    let radius = extent * finite.map(|p| ((*p - centre) / extent).length()).fold(0.0, f64::max);
    (centre, if radius > 0.0 && radius.is_finite() { radius } else { 1.0 })
}

fn finish_reading(
    mut commands: Commands,
    mut reading: ResMut<Reading>,
    candidates: Query<Entity, With<Candidate>>,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    let Some(result) = reading.0.as_mut().and_then(|task| block_on(future::poll_once(task))) else { return };
    reading.0 = None;
    match result {
        Ok(read) => {
            // Whoever opened another one meanwhile does not want the one before.
            candidates.iter().for_each(|old| commands.entity(old).despawn());
            commands.spawn((
                Candidate { model: read.model, document: read.document },
                Mesh3d(meshes.add(read.mesh)),
                Transform::default(),
                Visibility::Hidden,
                SplineSurface::default(),
            ));
        }
        Err(reason) => commands.trigger(ModelRefused { reason }),
    }
}

fn take_place(
    ready: On<SurfaceReady>,
    mut commands: Commands,
    candidates: Query<(&Candidate, &BuiltSurface)>,
    models: Query<Entity, With<Model>>,
    mut notices: ResMut<Notices>,
) {
    let Ok((candidate, surface)) = candidates.get(ready.entity) else { return };
    if begin_on_candidate(&mut commands, ready.entity, candidate, surface) {
        return;
    }
    models.iter().for_each(|old| commands.entity(old).despawn());
    commands
        .entity(ready.entity)
        .remove::<Candidate>()
        .insert((candidate.model.clone(), Visibility::Visible))
        .trigger(|entity| ModelOpened { entity });
    let report = surface.report();
    if report.repaired() {
        let text = format!("{} was repaired: {}.", candidate.model.name, repairs_in_words(report));
        notices.warn_with(text, "Show where", EditorAction::ToggleRepairs);
    } else if !candidate.model.bundled {
        notices.info(format!("{}: {report}", candidate.model.name));
    }
}

/// What was done to a mesh, and what that means for curves.
fn repairs_in_words(report: &SurfaceReport) -> String {
    let count = |count: usize, one: &str, many: &str| match count {
        0 => None,
        1 => Some(format!("1 {one}")),
        count => Some(format!("{count} {many}")),
    };
    let done = [
        count(report.dropped.len(), "face was left out", "faces were left out"),
        count(report.flipped_faces, "face was turned over", "faces were turned over"),
        count(
            report.nonmanifold_edges,
            "edge has three faces or more and was cut, so curves do not cross it",
            "edges have three faces or more and were cut, so curves do not cross them",
        ),
        count(
            report.orientation_cuts,
            "edge was cut to tell the sides apart, so curves do not cross it",
            "edges were cut to tell the sides apart, so curves do not cross them",
        ),
        // Those beside cut edges go with them.
        count(
            report.nonmanifold_vertices,
            "vertex joined separate parts and was split",
            "vertices joined separate parts and were split",
        ),
    ];
    done.into_iter().flatten().collect::<Vec<_>>().join("; ")
}

fn refuse_surface(failed: On<SurfaceFailed>, mut commands: Commands, candidates: Query<&Candidate>) {
    let Ok(candidate) = candidates.get(failed.entity) else { return };
    commands.entity(failed.entity).despawn();
    commands.trigger(ModelRefused { reason: format!("{}: {}", candidate.model.name, failed.reason) });
}

fn tell_refusal(
    refused: On<ModelRefused>,
    models: Query<(), With<Model>>,
    mut notices: ResMut<Notices>,
    mut opens: MessageWriter<OpenModel>,
) {
    let kept = if models.is_empty() { "The bundled model is shown instead." } else { "The model stays as it was." };
    notices.error(format!("{}. {kept}", refused.reason));
    if models.is_empty() {
        opens.write(OpenModel::Bundled);
    }
}

/// Another model: nothing of before can be taken back.
fn forget_history(
    _: On<ModelOpened>,
    mut commands: Commands,
    (mut history, mut repairs): (ResMut<History>, ResMut<ShownRepairs>),
    shelved: Query<Entity, With<Shelved>>,
) {
    repairs.set_if_neq(ShownRepairs::default());
    history::clear(&mut commands, &mut history, &shelved);
}
