//! The overlay with all keys.

use bevy_egui::egui;

use crate::theme;

const KEYS: [(&str, &[(&str, &str)]); 4] = [
    (
        "Tools",
        &[
            ("V", "Select: click selects, drag moves what is under the pointer"),
            ("P", "Pen: every click on the model adds an anchor"),
            ("Enter, Escape", "End the pen; Escape takes a drag back"),
        ],
    ),
    (
        "Edit",
        &[
            ("C", "Join of the selected anchor: corner, smooth, mirrored, automatic"),
            ("X, Delete", "Delete the selected anchor, or the spline"),
            ("Ctrl+Z", "Undo"),
            ("Ctrl+Shift+Z, Ctrl+Y", "Redo"),
        ],
    ),
    (
        "View",
        &[
            ("Middle drag, Alt+left drag", "Orbit about the point under the pointer"),
            ("Shift+middle drag", "Pan"),
            ("Wheel", "Zoom to the pointer"),
            ("F", "Frame the selection, or the model"),
            ("1, 3, 7", "From the front, the right, the top"),
        ],
    ),
    ("Panel", &[("Tab", "Hide or show it"), ("F6", "Take the keyboard there; Escape leaves"), ("?, F1", "This help")]),
];

/// Shows the overlay; whether it is to stay.
pub(crate) fn show(ctx: &egui::Context) -> bool {
    let mut stays = true;
    let shade = egui::Color32::from_black_alpha(120);
    let modal =
        egui::Modal::new("help".into()).backdrop_color(shade).frame(theme::card().inner_margin(20)).show(ctx, |ui| {
            ui.horizontal(|ui| {
                ui.heading("Keys");
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    stays &= !ui.button("×").on_hover_text("Close").clicked();
                });
            });
            for (title, keys) in KEYS {
                ui.add_space(8.0);
                ui.strong(title);
                egui::Grid::new(title).num_columns(2).min_col_width(215.0).spacing([16.0, 4.0]).show(ui, |ui| {
                    for (key, meaning) in keys {
                        ui.monospace(*key);
                        ui.label(*meaning);
                        ui.end_row();
                    }
                });
            }
        });
    stays && !modal.should_close()
}
