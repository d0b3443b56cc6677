//! The panel's section of numbers: the mesh report, tracing, the frame rate.

use bevy::diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;
use bevy_surface_splines::plugin::TraceStatistics;
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::{Surface, SurfaceReport};

use crate::model::Model;
use crate::properties::significant;
use crate::selection::Selection;

/// What the section shows.
#[derive(SystemParam)]
pub(crate) struct Statistics<'w, 's> {
    models: Query<'w, 's, (&'static Model, &'static BuiltSurface)>,
    traces: Query<'w, 's, (&'static SplineTrace, &'static OnSurface)>,
    selection: Res<'w, Selection>,
    tracing: Res<'w, TraceStatistics>,
    diagnostics: Res<'w, DiagnosticsStore>,
}

impl Statistics<'_, '_> {
    /// In the file's units.
    fn selected_length(&self) -> Option<f64> {
        let (trace, on) = self.traces.get(self.selection.spline?).ok()?;
        let (model, _) = self.models.get(on.0).ok()?;
        Some(model.unit * trace.length())
    }
}

pub(crate) fn show(ui: &mut egui::Ui, statistics: &Statistics) {
    egui::Grid::new("statistics").num_columns(2).spacing([14.0, 2.0]).striped(true).show(ui, |ui| {
        for (_, surface) in &statistics.models {
            for (name, value) in mesh_rows(surface) {
                row(ui, &name, &value);
            }
        }
        if let Some(length) = statistics.selected_length() {
            row(ui, "Length of the selected", &significant(length, 6));
        }
        row(ui, "Segments retraced", &statistics.tracing.segments.to_string());
        row(ui, "Trace time", &format!("{:.2} ms", statistics.tracing.milliseconds));
        let rate = statistics.diagnostics.get(&FrameTimeDiagnosticsPlugin::FPS).and_then(|fps| fps.smoothed());
        row(
            ui,
            "Frames per second",
            &rate.map_or("–".into(), |rate| if rate < 10.0 { format!("{rate:.1}") } else { format!("{rate:.0}") }),
        );
    });
}

fn row(ui: &mut egui::Ui, name: &str, value: &str) {
    ui.label(name);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| ui.monospace(value));
    ui.end_row();
}

/// Sizes, and of what was found and repaired all that is not zero.
fn mesh_rows(surface: &Surface) -> Vec<(String, String)> {
    let report: &SurfaceReport = surface.report();
    let counted = |name: &str, count: usize| (name.to_string(), grouped(count));
    let mut rows = vec![
        counted("Faces", report.input_faces),
        counted("Vertices", surface.vertex_count()),
        counted("Sheets", report.sheets),
        counted("Boundary loops", report.boundary_loops),
        ("Euler characteristic".into(), report.euler_characteristic.to_string()),
    ];
    let found = [
        ("Faces dropped", report.dropped.len()),
        ("Degenerate faces", report.degenerate_faces),
        ("Duplicate faces", report.duplicate_faces),
        ("Non-manifold edges, cut", report.nonmanifold_edges),
        ("Non-manifold vertices, split", report.nonmanifold_vertices),
        ("Faces turned over", report.flipped_faces),
        ("Edges cut to orient", report.orientation_cuts),
    ];
    rows.extend(found.into_iter().filter(|(_, count)| *count > 0).map(|(name, count)| counted(name, count)));
    rows
}

/// Digits in groups of three.
fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}
