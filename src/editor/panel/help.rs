//! The overlay with all keys, which can be searched.

use bevy_egui::egui;

use super::theme;
use crate::editor::keys::{BINDINGS, HINTS};

const SECTIONS: [&str; 5] = ["Tools", "Edit", "Files", "View", "Panel"];

/// Shows the overlay; whether it is to stay.
pub(crate) fn show(ctx: &egui::Context, search: &mut String) -> bool {
    let mut stays = true;
    let shade = egui::Color32::from_black_alpha(120);
    let modal =
        egui::Modal::new("help".into()).backdrop_color(shade).frame(theme::card().inner_margin(20)).show(ctx, |ui| {
            ui.horizontal(|ui| {
                ui.heading("Keys");
                let field = egui::TextEdit::singleline(search).hint_text("Search").desired_width(180.0);
                let field = ui.add(field);
                // Whoever asks for help types what they look for.
                if ui.memory(|memory| memory.focused().is_none()) {
                    field.request_focus();
                }
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    stays &= !ui.button("×").on_hover_text("Close").clicked();
                });
            });
            let height = ctx.viewport_rect().height() - 140.0;
            egui::ScrollArea::vertical().max_height(height).show(ui, |ui| show_keys(ui, &search.to_lowercase()));
        });
    stays && !modal.should_close()
}

fn show_keys(ui: &mut egui::Ui, search: &str) {
    let matches = |label: &str, meaning: &str| {
        let text = format!("{label} {meaning}").to_lowercase();
        search.split_whitespace().all(|word| text.contains(word))
    };
    let mut found = false;
    for section in SECTIONS {
        let keys = BINDINGS.iter().filter(|key| key.section == section).map(|key| (key.label, key.meaning));
        let hints = HINTS.iter().filter(|hint| hint.section == section).map(|hint| (hint.label, hint.meaning));
        let rows: Vec<_> = keys.chain(hints).filter(|(label, meaning)| matches(label, meaning)).collect();
        if rows.is_empty() {
            continue;
        }
        found = true;
        ui.add_space(8.0);
        ui.strong(section);
        egui::Grid::new(section).num_columns(2).min_col_width(190.0).spacing([16.0, 4.0]).show(ui, |ui| {
            for (label, meaning) in rows {
                ui.monospace(label);
                ui.label(meaning);
                ui.end_row();
            }
        });
    }
    if !found {
        ui.label("Nothing has this in its name.");
    }
}
