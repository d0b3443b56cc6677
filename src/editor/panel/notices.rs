//! Shows the notices at the top right.

use bevy::prelude::*;
use bevy_egui::egui;

use super::theme;
use crate::editor::actions::EditorAction;
use crate::editor::notices::{Notice, Notices, Severity};

/// Shows the notices with their right edge at `right`.
pub(crate) fn show(ctx: &egui::Context, right: f32, notices: &mut Notices, actions: &mut MessageWriter<EditorAction>) {
    let mut dismissed = None;
    egui::Area::new("notices".into())
        .order(egui::Order::Foreground)
        .pivot(egui::Align2::RIGHT_TOP)
        .fixed_pos(egui::pos2(right - 12.0, 12.0))
        .show(ctx, |ui| {
            for (index, notice) in notices.all().iter().enumerate() {
                if show_one(ui, notice, actions) {
                    dismissed = Some(index);
                }
                ui.add_space(6.0);
            }
        });
    if let Some(index) = dismissed {
        notices.dismiss(index);
    }
}

/// Shows a notice; whether it was dismissed.
fn show_one(ui: &mut egui::Ui, notice: &Notice, actions: &mut MessageWriter<EditorAction>) -> bool {
    let (sign, color) = match notice.severity {
        Severity::Info => ("i", theme::INFO),
        Severity::Warning => ("!", theme::WARNING),
        Severity::Error => ("×", theme::ERROR),
    };
    let mut dismissed = false;
    theme::card().stroke(egui::Stroke::new(1.0, color)).show(ui, |ui| {
        ui.set_width(300.0);
        ui.horizontal_top(|ui| {
            ui.label(egui::RichText::new(sign).strong().color(color));
            ui.vertical(|ui| {
                ui.set_width(250.0);
                ui.add(egui::Label::new(&notice.text).wrap());
                if let Some((name, action)) = &notice.button
                    && ui.button(*name).clicked()
                {
                    actions.write(action.clone());
                }
            });
            dismissed = ui.small_button("×").on_hover_text("Dismiss").clicked();
        });
    });
    dismissed
}
