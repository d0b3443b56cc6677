//! From the scene to a document, and from there to a file.

use std::path::{Path, PathBuf};

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use glam::DMat4;

use super::{DocumentFile, FileRequest, FileTasks, Question, RecentDocuments, autosave, fetch};
use crate::editor::camera::{Orbit, view_of};
use crate::editor::curves::Curve;
use crate::editor::history::{History, Revision};
use crate::editor::model::Model;
use crate::editor::notices::Notices;
use crate::format::document::{Document, DocumentError, SplineStyle};
use crate::plugin::{BuiltSurface, LineSmoothing, OnSurface, SplineTrace, SurfaceLine, SurfaceSpline};

/// What is saved.
#[derive(SystemParam)]
pub(crate) struct Scene<'w, 's> {
    pub(crate) history: ResMut<'w, History>,
    pub(crate) models: Query<'w, 's, (Entity, &'static Model, &'static BuiltSurface)>,
    pub(crate) curves:
        Query<'w, 's, (&'static Curve, &'static SurfaceSpline, &'static OnSurface, Option<&'static SplineTrace>)>,
    lines: Query<'w, 's, (&'static Curve, &'static SurfaceLine, Option<&'static LineSmoothing>, &'static OnSurface)>,
    cameras: Query<'w, 's, (&'static Orbit, &'static Transform, &'static Projection)>,
    eyes: Query<'w, 's, (&'static Camera, &'static GlobalTransform), With<Orbit>>,
    places: Query<'w, 's, &'static GlobalTransform>,
}

/// Where it was saved, in which state of the document.
pub(crate) type SaveResult = Result<(PathBuf, Revision), (PathBuf, DocumentError)>;

impl Scene<'_, '_> {
    /// From a model's space to the page, in logical pixels with the middle at the origin and y up; w is what perspective divides by.
    pub(crate) fn view(&self, model: Entity) -> Option<DMat4> {
        let (camera, eye) = self.eyes.iter().find(|(camera, _)| camera.is_active)?;
        let size = camera.logical_viewport_size()?.as_dvec2();
        let to_world = self.places.get(model).ok()?.to_matrix().as_dmat4();
        let to_clip = camera.clip_from_view().as_dmat4() * eye.to_matrix().as_dmat4().inverse();
        Some(DMat4::from_scale((0.5 * size).extend(1.0)) * to_clip * to_world)
    }

    /// The document as it is now, for a file at some place.
    pub(crate) fn document(&self, at: Option<&Path>) -> Result<Document, String> {
        let Some((entity, model, surface)) = self.models.iter().next() else {
            return Err("there is no model yet: open one first".into());
        };
        let mut reference = model.reference(surface);
        if let (Some(document), Some(mesh)) = (at, &model.path) {
            reference = reference.beside(document, mesh);
        }
        let mut document = Document::new(reference);
        let mut curves: Vec<_> = self.curves.iter().filter(|(_, _, on, _)| on.0 == entity).collect();
        curves.sort_by_key(|(curve, ..)| curve.number);
        for (curve, spline, ..) in curves {
            let added = document.add(surface, curve.name.clone(), spline).map_err(|error| error.to_string())?;
            let colour = curve.color.to_srgba().to_f32_array();
            added.style = SplineStyle { colour, width: curve.width };
            (added.hidden, added.locked) = (curve.hidden, curve.locked);
        }
        let mut lines: Vec<_> = self.lines.iter().filter(|(.., on)| on.0 == entity).collect();
        lines.sort_by_key(|(curve, ..)| curve.number);
        for (curve, line, smoothing, _) in lines {
            // What is drawn but not smoothed now may be so again.
            let smoothing = smoothing.filter(|smoothing| smoothing.enabled).map(|smoothing| smoothing.options);
            let added = document.add_line(surface, curve.name.clone(), line, smoothing);
            let added = added.map_err(|error| error.to_string())?;
            let colour = curve.color.to_srgba().to_f32_array();
            added.style = SplineStyle { colour, width: curve.width };
            (added.hidden, added.locked) = (curve.hidden, curve.locked);
        }
        document.view = self.cameras.iter().next().map(|(orbit, place, lens)| view_of(orbit, place, lens));
        Ok(document)
    }
}

pub(crate) fn write(document: &Document, path: PathBuf, revision: Revision) -> SaveResult {
    match document.save(&path) {
        Ok(()) => Ok((path, revision)),
        Err(error) => Err((path, error)),
    }
}

/// Tells how saving ended.
pub(crate) fn collect(
    mut tasks: ResMut<FileTasks>,
    mut files: ResMut<DocumentFile>,
    mut recent: ResMut<RecentDocuments>,
    mut history: ResMut<History>,
    mut notices: ResMut<Notices>,
    settings: Res<super::AutosaveSettings>,
    mut requests: MessageWriter<FileRequest>,
) {
    match fetch(&mut tasks.saving) {
        Some(Ok((path, revision))) => {
            history.mark_saved(revision);
            if !history.is_dirty() && files.question().is_some_and(Question::offers_saving) {
                requests.write(FileRequest::Answer(true));
            }
            autosave::discard(files.path(), &settings);
            notices.info(format!("Saved {}", path.display()));
            recent.note(&path);
            files.path = Some(path);
        }
        Some(Err((path, error))) => {
            let (name, error) = (path.display().to_string(), error.to_string());
            let what = if error.starts_with(&name) { error } else { format!("{name} was not saved: {error}") };
            notices.error(if path.exists() { format!("{what}. What was there is as it was.") } else { what });
        }
        None => {}
    }
}
