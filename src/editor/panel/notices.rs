//! Shows the notices at the top right.

use bevy::prelude::*;
use bevy_egui::egui;

use super::theme;
use crate::editor::actions::EditorAction;
use crate::editor::notices::{Notice, Notices, Severity};

/// Width of a notice where there is room.
const WIDTH: f32 = 300.0;

/// Shows the notices at the right of a part of the window.
pub(crate) fn show(
    ctx: &egui::Context,
    part: std::ops::RangeInclusive<f32>,
    notices: &mut Notices,
    actions: &mut MessageWriter<EditorAction>,
) {
    let mut dismissed = None;
    let width = WIDTH.min(part.end() - part.start() - 60.0).max(120.0);
    egui::Area::new("notices".into())
        .order(egui::Order::Foreground)
        .pivot(egui::Align2::RIGHT_TOP)
        .fixed_pos(egui::pos2(part.end() - 12.0, 12.0))
        .show(ctx, |ui| {
            for (index, notice) in notices.all().iter().enumerate() {
                if show_one(ui, width, notice, actions) {
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
fn show_one(ui: &mut egui::Ui, width: f32, notice: &Notice, actions: &mut MessageWriter<EditorAction>) -> bool {
    let (sign, color) = match notice.severity {
        Severity::Info => ("i", theme::INFO),
        Severity::Warning => ("!", theme::WARNING),
        Severity::Error => ("×", theme::ERROR),
    };
    let mut dismissed = false;
    theme::card().stroke(egui::Stroke::new(1.0, color)).show(ui, |ui| {
        ui.set_width(width);
        ui.horizontal_top(|ui| {
            ui.label(egui::RichText::new(sign).strong().color(color));
            ui.vertical(|ui| {
                ui.set_width(width - 50.0);
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
