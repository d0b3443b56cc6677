//! The rows about a spline's scheme: method, sampling, and how fine.

use crate::prelude::*;
use bevy::prelude::*;
use bevy_egui::egui;

use super::properties::significant;
use crate::editor::actions::EditorAction;

/// The method's name, and what one should know of it.
const METHODS: [(Method, &str); 6] = [
    (Method::DeCasteljau, "C¹ inside a segment, touches the first and last leg"),
    (Method::LaneRiesenfeld, "C² inside a segment, touches the first and last leg"),
    (Method::BSpline, "C² across all segments, passes near its control points"),
    (Method::QuadraticBSpline, "C¹ across all segments, nearer to its control points"),
    (Method::Direct, "For comparison: breaks on large control polygons"),
    (Method::CentreOfMass, "For comparison: breaks on large control polygons, slow"),
];

pub(crate) fn show(ui: &mut egui::Ui, scheme: Scheme, actions: &mut MessageWriter<EditorAction>) {
    ui.label("Scheme");
    egui::ComboBox::from_id_salt("scheme").selected_text(scheme.method.name()).width(150.0).show_ui(ui, |ui| {
        for (method, meaning) in METHODS {
            let label = ui.selectable_label(method == scheme.method, method.name()).on_hover_text(meaning);
            if label.clicked() && method != scheme.method {
                actions.write(EditorAction::SetScheme(with_method(scheme, method)));
            }
        }
    });
    ui.end_row();
    if scheme.method.is_b_spline() {
        ui.label("");
        ui.label(egui::RichText::new("Handles do not count").weak()).on_hover_text(
            "Anchors are control points of one long curve; their handles and joins wait for another scheme",
        );
        ui.end_row();
    }
    show_sampling(ui, scheme, actions);
    if !scheme.method.is_for_comparison() {
        ui.label("");
        let mut on_curve = scheme.on_curve;
        let meaning =
            "Else the trace is a refined control polygon: more points for the work, but further from the curve";
        if ui.checkbox(&mut on_curve, "Points on the curve").on_hover_text(meaning).changed() {
            actions.write(EditorAction::SetScheme(Scheme { on_curve, ..scheme }));
        }
        ui.end_row();
    }
}

fn show_sampling(ui: &mut egui::Ui, scheme: Scheme, actions: &mut MessageWriter<EditorAction>) {
    ui.label("Sampling");
    ui.horizontal(|ui| {
        let adaptive = matches!(scheme.sampling, Sampling::Adaptive { .. });
        let levels = ui.selectable_label(matches!(scheme.sampling, Sampling::Levels(_)), "Levels");
        if levels.on_hover_text("Every segment is halved as often").clicked() {
            actions.write(EditorAction::SetScheme(Scheme { sampling: Scheme::of(scheme.method).sampling, ..scheme }));
        }
        // Schemes for comparison have no pieces that could be halved.
        let button = egui::Button::selectable(adaptive, "Adaptive");
        let button = ui.add_enabled(!scheme.method.is_for_comparison(), button);
        if button.on_hover_text("Halved where the curve turns").clicked() && !adaptive {
            actions.write(EditorAction::SetScheme(scheme.adaptive()));
        }
    });
    ui.end_row();
    ui.spacing_mut().slider_width = 96.0;
    match scheme.sampling {
        Sampling::Levels(mut levels) => {
            ui.label("Level");
            // One more level doubles the work; beyond eight nobody sees a difference.
            let slider = ui.add(egui::Slider::new(&mut levels, 1..=8));
            slide(&slider, scheme.with_levels(levels), actions);
        }
        Sampling::Adaptive { turn, length } => {
            ui.label("Largest turn");
            let mut degrees = turn.to_degrees();
            let slider = ui.add(egui::Slider::new(&mut degrees, 0.5..=30.0).logarithmic(true).suffix("°"));
            let sampling = Sampling::Adaptive { turn: degrees.to_radians(), length };
            slide(&slider, Scheme { sampling, ..scheme }, actions);
        }
        Sampling::Length(length) => {
            ui.label("Length of legs");
            ui.label(significant(length, 4));
        }
    }
    ui.end_row();
}

/// A slider's whole way is one step of the history.
fn slide(slider: &egui::Response, scheme: Scheme, actions: &mut MessageWriter<EditorAction>) {
    if slider.changed() {
        actions.write(EditorAction::SlideScheme(scheme));
    }
    if slider.drag_stopped() || (slider.changed() && !slider.dragged()) {
        actions.write(EditorAction::EndSlide);
    }
}

/// The same sampling by another method, as far as it has it.
fn with_method(scheme: Scheme, method: Method) -> Scheme {
    let default = Scheme::of(method);
    let adaptive = matches!(scheme.sampling, Sampling::Adaptive { .. });
    let sampling = if adaptive && !method.is_for_comparison() { scheme.sampling } else { default.sampling };
    Scheme { sampling, on_curve: scheme.on_curve && !method.is_for_comparison(), ..default }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_methods_are_offered() {
        assert_eq!(METHODS.map(|(method, _)| method), Method::ALL);
    }

    #[test]
    fn another_method_keeps_what_it_can() {
        let fine = Scheme::de_casteljau().adaptive().on_curve();
        assert_eq!(with_method(fine, Method::BSpline), Scheme::b_spline().adaptive().on_curve());
        assert_eq!(with_method(fine, Method::Direct), Scheme::direct());
        // Levels mean something else with every method.
        assert_eq!(
            with_method(Scheme::de_casteljau().with_levels(7), Method::LaneRiesenfeld),
            Scheme::lane_riesenfeld()
        );
    }
}
