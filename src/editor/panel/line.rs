//! The properties of a drawn line: how it is smoothed, and what came of it.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;

use super::properties::significant;
use crate::editor::actions::EditorAction;
use crate::editor::convert::Conversions;
use crate::editor::model::Model;
use crate::editor::selection::Selection;
use crate::plugin::{LineSmoothing, LineState, OnSurface, SmoothedLine};
use crate::smooth::{LineMetrics, SmoothingMode};

/// The ways of smoothing, and what one should know of them.
const MODES: [(SmoothingMode, &str, &str); 6] = [
    (SmoothingMode::Tether { closeness: 10.0 }, "Tether", "Short and smooth, tied to where it was drawn"),
    (SmoothingMode::Geodesic, "Geodesic", "As short as it can be between its ends"),
    (
        SmoothingMode::Stencil { scale: 1.0, passes: 5 },
        "Even out",
        "Its own curvature, evened out along it; it may drift",
    ),
    (SmoothingMode::Budget { share: 0.25 }, "Budget", "Shortened until it turns by a quarter of what it did"),
    (SmoothingMode::Lift { weight: 1.0 }, "Lift", "For comparison: rough where it holds"),
    (SmoothingMode::Conformal { weight: 1.0 }, "Conformal", "For comparison: half as rough as the lift"),
];

/// What the section shows.
#[derive(SystemParam)]
pub(crate) struct LineProperties<'w, 's> {
    selection: Res<'w, Selection>,
    lines:
        Query<'w, 's, (&'static SmoothedLine, Option<&'static LineSmoothing>, &'static LineState, &'static OnSurface)>,
    models: Query<'w, 's, &'static Model>,
    conversions: Res<'w, Conversions>,
}

/// Shows the section, if a line is active; says whether that is so.
pub(crate) fn show(ui: &mut egui::Ui, properties: &LineProperties, actions: &mut MessageWriter<EditorAction>) -> bool {
    let active = properties.selection.spline().and_then(|line| properties.lines.get(line).ok());
    let Some((line, smoothing, state, on)) = active else { return false };
    let kind = if line.line.is_closed() { "closed" } else { "open" };
    ui.label(format!("Drawn line, {kind}, {} crossings", line.line.crossings().len()));
    show_smoothing(ui, smoothing, actions);
    match state {
        LineState::Smoothing { rounds, .. } => {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label(format!("Smoothing, round {rounds} …"));
            });
        }
        LineState::Failed { reason } => drop(ui.label(egui::RichText::new(reason).color(super::theme::WARNING))),
        LineState::Pending | LineState::Ready => {}
    }
    let unit = properties.models.get(on.0).map_or(1.0, |model| model.unit);
    show_metrics(ui, &line.before, &line.after, unit);
    super::curvature::show_line(ui, line, unit);
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        let fits = ui.add_enabled(!properties.conversions.is_busy(), egui::Button::new("Make a spline"));
        if fits.on_hover_text("Fits a spline within the tolerance of the freehand tool").clicked() {
            actions.write(EditorAction::ToSplines);
        }
        if ui.button("Delete").on_hover_text("X").clicked() {
            actions.write(EditorAction::Delete);
        }
    });
    true
}

fn show_smoothing(ui: &mut egui::Ui, smoothing: Option<&LineSmoothing>, actions: &mut MessageWriter<EditorAction>) {
    let mut smooths = smoothing.is_some_and(|smoothing| smoothing.enabled);
    if ui.checkbox(&mut smooths, "Smooth").on_hover_text("What was drawn stays, and can be had again").changed() {
        actions.write(EditorAction::SetSmoothing(smooths.then(LineSmoothing::default)));
    }
    let Some(smoothing) = smoothing.filter(|smoothing| smoothing.enabled) else { return };
    let name = MODES.iter().find(|(mode, ..)| mode.name() == smoothing.options.mode.name()).map_or("", |mode| mode.1);
    egui::ComboBox::from_id_salt("smoothing").selected_text(name).width(150.0).show_ui(ui, |ui| {
        for (mode, name, meaning) in MODES {
            let taken = mode.name() == smoothing.options.mode.name();
            if ui.selectable_label(taken, name).on_hover_text(meaning).clicked() && !taken {
                actions.write(EditorAction::SetSmoothing(Some(LineSmoothing::by(mode))));
            }
        }
    });
    let [least, most] = LineSmoothing::SLIDER;
    let mut mode = smoothing.options.mode;
    let slider = match &mut mode {
        SmoothingMode::Tether { closeness } => {
            Some(egui::Slider::new(closeness, least..=most).logarithmic(true).text("Closeness"))
        }
        SmoothingMode::Lift { weight } | SmoothingMode::Conformal { weight } => {
            Some(egui::Slider::new(weight, 0.01..=100.0).logarithmic(true).text("Weight"))
        }
        SmoothingMode::Stencil { scale, .. } => Some(egui::Slider::new(scale, 0.0..=2.0).text("Scale")),
        SmoothingMode::Budget { share } => Some(egui::Slider::new(share, 0.0..=1.0).text("Share")),
        SmoothingMode::Geodesic => None,
    };
    let Some(slider) = slider.map(|slider| ui.add(slider)) else { return };
    if slider.changed() {
        let options = crate::smooth::Smoothing { mode, ..smoothing.options };
        actions.write(EditorAction::SlideSmoothing(LineSmoothing { options, ..*smoothing }));
    }
    if slider.drag_stopped() || (slider.changed() && !slider.dragged()) {
        actions.write(EditorAction::EndSlide);
    }
}

/// How smooth the line was, and is; lengths in the units of the model's file.
fn show_metrics(ui: &mut egui::Ui, before: &LineMetrics, after: &LineMetrics, unit: f64) {
    ui.add_space(4.0);
    egui::Grid::new("metrics").num_columns(3).spacing([12.0, 2.0]).striped(true).show(ui, |ui| {
        let mut row = |name: &str, was: String, is: String| {
            ui.label(name);
            ui.monospace(was);
            ui.monospace(is);
            ui.end_row();
        };
        row("", "drawn".into(), "now".into());
        let mut number = |name: &str, of: &dyn Fn(&LineMetrics) -> f64| {
            row(name, significant(of(before), 3), significant(of(after), 3));
        };
        number("Length", &|metrics| metrics.length * unit);
        number("Turns, in all (°)", &|metrics| metrics.total_turn.to_degrees());
        number("Curvature, most", &|metrics| metrics.max_curvature / unit);
        number("Curvature², mean", &|metrics| metrics.mean_square_curvature() / (unit * unit));
        number("Trembling (°)", &|metrics| metrics.variation.to_degrees());
        row("Inflections", before.inflections.to_string(), after.inflections.to_string());
        row("Distance, most", String::new(), significant(after.max_distance * unit, 3));
        row("Distance, mean", String::new(), significant(after.mean_distance * unit, 3));
    });
}
