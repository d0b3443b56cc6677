//! Traces and drawings for other programs.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::*;

use super::save::Scene;
use super::{FileTasks, fetch};
use crate::curve::{Spline, Trace};
use crate::editor::notices::Notices;
use crate::format::export::TraceExport;
use crate::format::save::replace_file;
use crate::geodesic::PathFinder;
use crate::placement::{Placement, drawing_about};
use crate::surface::Surface;
use crate::vector::export_svg;

/// Where to, and how many curves; or why not.
pub(crate) type ExportResult = Result<(PathBuf, usize), String>;

/// What a curve is for an export.
struct Source {
    name: String,
    spline: Spline,
    trace: Option<Arc<Trace>>,
}

impl Scene<'_, '_> {
    /// The work of exporting all curves that are shown.
    pub(crate) fn export(&self, path: &Path) -> Result<impl FnOnce() -> ExportResult + Send + 'static, String> {
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
                spline: (**spline).clone(),
                trace: trace.map(|trace| trace.trace().clone()),
            })
            .collect();
        let (surface, path) = (surface.0.clone(), path.to_owned());
        Ok(move || export(&surface, &sources, path))
    }
}

fn export(surface: &Surface, sources: &[Source], path: PathBuf) -> ExportResult {
    let is_drawing = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg"));
    if is_drawing {
        export_drawing(surface, sources, &path)?;
    } else {
        let mut export = TraceExport::default();
        for source in sources {
            let trace =
                source.trace.as_ref().ok_or_else(|| format!("{} has no trace yet: wait a moment", source.name))?;
            export.add(surface, source.name.clone(), trace).map_err(|error| error.to_string())?;
        }
        export.save(&path).map_err(|error| error.to_string())?;
    }
    Ok((path, sources.len()))
}

/// All curves as seen from the first anchor, by the logarithmic map.
fn export_drawing(surface: &Surface, sources: &[Source], path: &Path) -> Result<(), String> {
    let first = sources.first().and_then(|source| source.spline.anchors().first());
    let at = first.ok_or("there is no anchor")?.point();
    // Upwards in the model, unless that stands upright on the surface.
    let up = [glam::DVec3::Y, glam::DVec3::Z];
    let leans = |up: &glam::DVec3| surface.tangent(&at, *up).is_ok_and(|tangent| tangent.length() > 0.1);
    let up = up.into_iter().find(leans).unwrap_or(glam::DVec3::X);
    let placement = Placement { at, up, scale: 0.01 * surface.diagonal() };
    let splines = sources.iter().map(|source| &source.spline);
    let drawing = drawing_about(surface, &mut PathFinder::new(), splines, &placement, glam::DVec2::ZERO);
    let text = export_svg(&drawing.map_err(|error| error.to_string())?);
    replace_file(path, |file| file.write_all(text.as_bytes())).map_err(|error| error.to_string())
}

/// Tells how exporting ended.
pub(crate) fn collect(mut tasks: ResMut<FileTasks>, mut notices: ResMut<Notices>) {
    match fetch(&mut tasks.exporting) {
        Some(Ok((path, count))) => notices.info(format!("Exported {count} curves to {}", path.display())),
        Some(Err(reason)) => notices.error(format!("Nothing was exported: {reason}")),
        None => {}
    }
}
