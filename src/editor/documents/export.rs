//! Traces and drawings for other programs.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::*;
use glam::{DMat4, DVec2};

use super::save::Scene;
use super::{FileTasks, fetch};
use crate::curve::{Spline, Trace};
use crate::editor::curves::Curve;
use crate::editor::notices::Notices;
use crate::format::export::TraceExport;
use crate::format::save::replace_file;
use crate::geodesic::PathFinder;
use crate::placement::{Placement, drawing_about, drawing_in_view};
use crate::surface::Surface;
use crate::vector::{self, Drawing, Paint, ViewBox, export_svg};

/// The width of an ordinary line, as a share of the page.
const LINE: f64 = 0.004;

/// Where to, and how many curves; or why not.
pub(crate) type ExportResult = Result<(PathBuf, usize), String>;

/// How curves become a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExportKind {
    /// Unrolled from the first anchor: lengths and angles near it are true.
    #[default]
    Unrolled,
    /// As the camera sees them, those behind the model too.
    AsSeen,
}

/// What a curve is for an export.
struct Source {
    name: String,
    color: Color,
    /// Of its line, in logical pixels.
    width: f32,
    spline: Spline,
    trace: Option<Arc<Trace>>,
}

impl Scene<'_, '_> {
    /// The work of exporting all curves that are shown.
    pub(crate) fn export(
        &self,
        path: &Path,
        kind: ExportKind,
    ) -> Result<impl FnOnce() -> ExportResult + Send + 'static, String> {
        let Some((entity, _, surface)) = self.models.iter().next() else {
            return Err("there is no model yet".into());
        };
        let mut shown: Vec<_> =
            self.curves.iter().filter(|(curve, _, on, _)| on.0 == entity && !curve.hidden).collect();
        shown.sort_by_key(|(curve, ..)| curve.number);
        if shown.is_empty() {
            return Err("there is no curve that is shown".into());
        }
        let sources: Vec<Source> = shown
            .into_iter()
            .map(|(curve, spline, _, trace)| Source {
                name: curve.name.clone(),
                color: curve.color,
                width: curve.width,
                spline: (**spline).clone(),
                trace: trace.map(|trace| trace.trace().clone()),
            })
            .collect();
        let (surface, path) = (surface.0.clone(), path.to_owned());
        let view = match kind {
            ExportKind::Unrolled => None,
            ExportKind::AsSeen => Some(self.view(entity).ok_or("there is no camera that sees the model")?),
        };
        Ok(move || export(&surface, &sources, path, view))
    }
}

/// A view, if the curves are to be drawn as a camera sees them, maps the model's space to the page.
fn export(surface: &Surface, sources: &[Source], path: PathBuf, view: Option<DMat4>) -> ExportResult {
    let is_drawing = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg"));
    if is_drawing {
        let mut drawing = match view {
            None => unrolled(surface, sources)?,
            Some(view) => drawing_in_view(traces(sources)?, &view).map_err(|error| error.to_string())?,
        };
        dress(&mut drawing, sources);
        let text = export_svg(&drawing);
        replace_file(&path, |file| file.write_all(text.as_bytes())).map_err(|error| error.to_string())?;
    } else {
        let mut export = TraceExport::default();
        for (source, trace) in sources.iter().zip(traces(sources)?) {
            export.add(surface, source.name.clone(), trace).map_err(|error| error.to_string())?;
        }
        export.save(&path).map_err(|error| error.to_string())?;
    }
    Ok((path, sources.len()))
}

/// Gives each curve its name and colour, and the page its size: without one, other programs show a corner.
fn dress(drawing: &mut Drawing, sources: &[Source]) {
    let Some((min, max)) = drawing.bounds() else { return };
    let size = (max - min).max_element();
    let hair = LINE * size / f64::from(Curve::WIDTH);
    let mut widest = 0.0_f64;
    for (shape, source) in drawing.shapes.iter_mut().zip(sources) {
        shape.id = Some(source.name.split_whitespace().collect::<Vec<_>>().join("_"));
        let [red, green, blue, alpha] = source.color.to_srgba().to_f32_array();
        if let Some(stroke) = &mut shape.style.stroke {
            stroke.paint = Paint::Color(vector::Color { red, green, blue, alpha });
            stroke.width = hair * f64::from(source.width);
            widest = widest.max(stroke.width);
        }
    }
    let margin = DVec2::splat(widest.max(0.02 * size));
    drawing.view_box = Some(ViewBox { min: min - margin, size: max - min + 2.0 * margin });
}

fn traces(sources: &[Source]) -> Result<Vec<&Trace>, String> {
    let trace = |source: &'_ Source| match &source.trace {
        Some(_) => Ok(()),
        None => Err(format!("{} has no trace yet: wait a moment", source.name)),
    };
    sources.iter().try_for_each(trace)?;
    Ok(sources.iter().filter_map(|source| source.trace.as_deref()).collect())
}

/// All curves as seen from the first anchor, by the logarithmic map.
fn unrolled(surface: &Surface, sources: &[Source]) -> Result<Drawing, String> {
    let first = sources.first().and_then(|source| source.spline.anchors().first());
    let at = first.ok_or("there is no anchor")?.point();
    // Upwards in the model, unless that stands upright on the surface.
    let up = [glam::DVec3::Y, glam::DVec3::Z];
    let leans = |up: &glam::DVec3| surface.tangent(&at, *up).is_ok_and(|tangent| tangent.length() > 0.1);
    let up = up.into_iter().find(leans).unwrap_or(glam::DVec3::X);
    let placement = Placement { at, up, scale: 0.01 * surface.diagonal() };
    let splines = sources.iter().map(|source| &source.spline);
    let drawing = drawing_about(surface, &mut PathFinder::new(), splines, &placement, glam::DVec2::ZERO);
    drawing.map_err(|error| error.to_string())
}

/// Tells how exporting ended.
pub(crate) fn collect(mut tasks: ResMut<FileTasks>, mut notices: ResMut<Notices>) {
    match fetch(&mut tasks.exporting) {
        Some(Ok((path, count))) => notices.info(format!("Exported {count} curves to {}", path.display())),
        Some(Err(reason)) => notices.error(format!("Nothing was exported: {reason}")),
        None => {}
    }
}
