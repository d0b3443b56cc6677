//! A plot of geodesic curvature along the selected curve, computed in the background when the curve has changed.

use std::sync::Arc;

use bevy::prelude::*;
use bevy::tasks::{Task, block_on, futures_lite::future};
use bevy_egui::egui;

use super::properties::significant;
use super::theme;
use crate::curve::Trace;
use crate::editor::colors;
use crate::editor::documents::spawn;
use crate::geodesic::PathFinder;
use crate::plugin::SmoothedLine;
use crate::surface::Surface;

/// So many places along the curve are measured.
const PLACES: u32 = 160;
/// Curvature is measured over so many mean edges to either side: a mesh is flat in its faces.
const EDGES: f64 = 2.0;

/// The newest plot.
#[derive(Resource, Default)]
pub(crate) struct CurvaturePlot {
    of: Option<Arc<Trace>>,
    values: Vec<f64>,
    task: Option<(Arc<Trace>, Task<Vec<f64>>)>,
}

impl CurvaturePlot {
    /// Asks for the plot of a trace, and fetches what was computed.
    fn follow(&mut self, surface: &Arc<Surface>, trace: &Arc<Trace>) {
        if let Some((of, task)) = &mut self.task
            && let Some(values) = block_on(future::poll_once(task))
        {
            (self.of, self.values) = (Some(of.clone()), values);
            self.task = None;
        }
        let is_known = self.of.as_ref().is_some_and(|of| Arc::ptr_eq(of, trace));
        if !is_known && self.task.is_none() {
            let (surface, of) = (surface.clone(), trace.clone());
            self.task = Some((trace.clone(), spawn(move || measure(&surface, &of))));
        }
    }
}

fn measure(surface: &Surface, trace: &Trace) -> Vec<f64> {
    let mut finder = PathFinder::new();
    let edge = trace.segments().iter().find_map(|s| surface.mean_edge_length(s.points().first()?.face).ok());
    let step = (EDGES * edge.unwrap_or(0.0)).clamp(trace.length() / 200.0, (trace.length() / 4.0).max(1e-300));
    let segments = trace.segments().len() as f64;
    let at = |i: u32| crate::curve::SplineT(segments * f64::from(i) / f64::from(PLACES));
    (0..=PLACES).filter_map(|i| trace.curvature_at(surface, &mut finder, at(i), step)).collect()
}

/// Shows the plot of a trace, whose unit of length is so many of the file's.
pub(crate) fn show(ui: &mut egui::Ui, plot: &mut CurvaturePlot, surface: &Arc<Surface>, trace: &Arc<Trace>, unit: f64) {
    plot.follow(surface, trace);
    paint(ui, &plot.values, unit);
}

/// Shows the plot of a drawn line as it is now, whose unit of length is so many of the file's.
pub(crate) fn show_line(ui: &mut egui::Ui, line: &SmoothedLine, unit: f64) {
    let whole = line.lengths().last().copied().unwrap_or(0.0);
    let at = |i: u32| {
        let length = whole * f64::from(i) / f64::from(PLACES);
        let after = line.lengths().partition_point(|l| *l < length);
        line.curvatures().get(after).map(|curvature| f64::from(*curvature))
    };
    let values: Vec<f64> = (0..=PLACES).filter_map(at).collect();
    paint(ui, &values, unit);
}

/// Paints curvatures at places that are equally far apart.
fn paint(ui: &mut egui::Ui, values: &[f64], unit: f64) {
    ui.add_space(6.0);
    ui.label("Geodesic curvature along the curve").on_hover_text(
        "Left turns are up, right turns down, as seen from outside; one over the radius of the turn, in the model's units",
    );
    let size = egui::vec2(ui.available_width(), 96.0);
    let (place, response) = ui.allocate_exact_size(size, egui::Sense::hover());
    ui.painter().rect_filled(place, 4.0, egui::Color32::from_black_alpha(70));
    let largest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    if values.len() < 2 || largest <= 0.0 {
        return;
    }
    let x = |index: usize| place.left() + place.width() * index as f32 / (values.len() - 1) as f32;
    let y = |value: f64| place.center().y - 0.46 * place.height() * (value / largest) as f32;
    let axis = egui::Stroke::new(1.0, egui::Color32::from_white_alpha(50));
    ui.painter().hline(place.x_range(), place.center().y, axis);
    let points = values.iter().enumerate().map(|(index, value)| egui::pos2(x(index), y(*value))).collect();
    ui.painter().add(egui::Shape::line(points, egui::Stroke::new(1.5, theme::egui_color(colors::ACCENT, 1.0))));
    let text = |value: f64| format!("{} ", significant(value / unit, 3));
    ui.painter().text(
        place.right_top(),
        egui::Align2::RIGHT_TOP,
        text(largest),
        egui::FontId::monospace(10.0),
        egui::Color32::from_white_alpha(150),
    );
    if let Some(at) = response.hover_pos() {
        let share = ((at.x - place.left()) / place.width()).clamp(0.0, 1.0);
        let index = (share * (values.len() - 1) as f32).round() as usize;
        response.on_hover_text(format!("{:.0} % along: {}", 100.0 * share, text(values[index])));
    }
}
