//! The overlay with all keys, which can be searched.

use bevy_egui::egui;

use super::theme;
use crate::editor::keys::{BINDINGS, HINTS};

const SECTIONS: [&str; 5] = ["Tools", "Edit", "Files", "View", "Panel"];

/// Width of the column of keys.
const LABELS: f32 = 190.0;

/// Shows the overlay; whether it is to stay. The key that opened it, which the first frame still sees, does not close it.
pub(crate) fn show(ctx: &egui::Context, search: &mut String, is_new: bool) -> bool {
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
            let size = ctx.viewport_rect().size() - egui::vec2(80.0, 140.0);
            ui.set_width(size.x.min(640.0));
            // As high as with all keys: what is searched must not make the window jump.
            let keys = egui::ScrollArea::vertical().min_scrolled_height(size.y).max_height(size.y).auto_shrink(false);
            keys.show(ui, |ui| show_keys(ui, &search.to_lowercase()));
        });
    // Also while the search has the keyboard; a question mark looks for nothing.
    let closes = ctx.input(|input| input.key_pressed(egui::Key::F1) || input.key_pressed(egui::Key::Escape));
    is_new || (stays && !modal.should_close() && !closes && search != "?")
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
        for (label, meaning) in rows {
            ui.horizontal_top(|ui| {
                let label = egui::Label::new(egui::RichText::new(label).monospace());
                ui.add_sized([LABELS, 0.0], label.halign(egui::Align::LEFT));
                ui.add(egui::Label::new(meaning).wrap());
            });
        }
    }
    if !found {
        ui.label("Nothing has this in its name.");
    }
}
