//! The panel's section of numbers: the mesh report, tracing, the frame rate.

use crate::curve::{Trace, TraceBound};
use crate::plugin::TraceStatistics;
use crate::prelude::*;
use crate::surface::{Surface, SurfaceReport};
use bevy::diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;

use super::curvature::{self, CurvaturePlot};
use super::properties::significant;
use crate::editor::model::Model;
use crate::editor::selection::Selection;

/// What the section shows.
#[derive(SystemParam)]
pub(crate) struct Statistics<'w, 's> {
    models: Query<'w, 's, (&'static Model, &'static BuiltSurface)>,
    traces: Query<'w, 's, (&'static SplineTrace, &'static OnSurface)>,
    selection: Res<'w, Selection>,
    tracing: Res<'w, TraceStatistics>,
    diagnostics: Res<'w, DiagnosticsStore>,
    plot: ResMut<'w, CurvaturePlot>,
}

impl Statistics<'_, '_> {
    /// The trace of what is selected, and its length in the file's units.
    fn selected(&self) -> Option<(f64, &Trace)> {
        let (trace, on) = self.traces.get(self.selection.spline()?).ok()?;
        let (model, _) = self.models.get(on.0).ok()?;
        Some((model.unit * trace.length(), trace))
    }
}

pub(crate) fn show(ui: &mut egui::Ui, statistics: &mut Statistics) {
    egui::Grid::new("statistics").num_columns(2).spacing([14.0, 2.0]).striped(true).show(ui, |ui| {
        for (_, surface) in &statistics.models {
            for (name, value) in mesh_rows(surface) {
                row(ui, &name, &value);
            }
        }
        if let Some((length, trace)) = statistics.selected() {
            row(ui, "Length of the selected", &significant(length, 6));
            for (name, value) in trace_rows(trace) {
                row(ui, name, &value);
            }
        }
        row(ui, "Segments retraced", &statistics.tracing.segments.to_string());
        row(ui, "Trace time", &format!("{:.2} ms", statistics.tracing.milliseconds));
        row(ui, "In the background", &format!("{:.2} ms", statistics.tracing.background_milliseconds));
        let rate = statistics.diagnostics.get(&FrameTimeDiagnosticsPlugin::FPS).and_then(|fps| fps.smoothed());
        row(
            ui,
            "Frames per second",
            &rate.map_or("–".into(), |rate| if rate < 10.0 { format!("{rate:.1}") } else { format!("{rate:.0}") }),
        );
    });
    show_plot(ui, statistics);
}

/// The plot of the active curve.
fn show_plot(ui: &mut egui::Ui, statistics: &mut Statistics) {
    let Statistics { models, traces, selection, plot, .. } = statistics;
    let selected = selection.spline().and_then(|spline| traces.get(spline).ok());
    let Some((trace, on)) = selected.filter(|(trace, _)| trace.length() > 0.0) else { return };
    let Ok((model, surface)) = models.get(on.0) else { return };
    curvature::show(ui, plot, &surface.0, trace.trace(), model.unit);
}

fn row(ui: &mut egui::Ui, name: &str, value: &str) {
    ui.label(name);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| ui.monospace(value));
    ui.end_row();
}

/// How many points a trace has, and what is amiss with it.
fn trace_rows(trace: &Trace) -> Vec<(&'static str, String)> {
    let segments = trace.segments();
    // Where segments meet, they share a point.
    let points: usize = segments.iter().map(|segment| segment.points().len().saturating_sub(1)).sum();
    let mut rows = vec![("Its points", grouped(points + usize::from(!segments.is_empty())))];
    let bounds = [
        (TraceBound::Depth, "20 halvings"),
        (TraceBound::Pieces, "4\u{202f}096 pieces a segment"),
        (TraceBound::Length, "shortest pieces (cusp)"),
    ];
    let met = bounds.into_iter().filter(|(bound, _)| segments.iter().any(|segment| segment.bound() == Some(*bound)));
    rows.extend(met.map(|(_, name)| ("Bound met", name.into())));
    let torn: usize = segments.iter().map(|segment| segment.jumps().len()).sum();
    if torn > 0 {
        rows.push(("Torn places", grouped(torn)));
    }
    rows
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Tracer;
    use crate::surface::{SurfaceOptions, shapes};
    use glam::DVec3;

    fn rows(scheme: Scheme) -> Vec<(&'static str, String)> {
        let surface = Surface::build(&shapes::torus(1.0, 0.45, 48, 24), &SurfaceOptions::default()).expect("a surface");
        // Angles around and across the torus; a polygon large enough to break the schemes for comparison.
        let polygon = [(-1.83_f64, 0.57_f64), (1.34, 1.73), (-0.22, 1.71), (2.11, 0.4)].map(|(u, v)| {
            let out = 1.0 + 0.45 * v.cos();
            surface.closest_point(DVec3::new(out * u.sin(), -out * u.cos(), 0.45 * v.sin())).expect("a place").point
        });
        trace_rows(&Tracer::new(&surface).trace(&polygon, &scheme).expect("a trace"))
    }

    #[test]
    fn traces_are_counted_and_what_is_amiss_is_said() {
        assert_eq!(rows(Scheme::de_casteljau()), [("Its points", "49".to_string())]);
        assert_eq!(rows(Scheme::quadratic_b_spline()), [("Its points", "65".to_string())]);
        let torn = rows(Scheme::centre_of_mass());
        assert_eq!(torn.iter().map(|row| row.0).collect::<Vec<_>>(), ["Its points", "Torn places"], "{torn:?}");
        let mut endless = Scheme::de_casteljau();
        endless.sampling = Sampling::Adaptive { turn: 0.0, length: None };
        assert!(rows(endless).iter().any(|row| row.0 == "Bound met"));
        assert_eq!(trace_rows(&Trace::default()), [("Its points", "0".to_string())]);
    }
}
