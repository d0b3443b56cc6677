//! The strip of tools at the left.

use bevy::prelude::*;
use bevy_egui::egui;

use super::status::Status;
use super::theme;
use crate::editor::actions::EditorAction;
use crate::editor::tools::Tool;

const WIDTH: f32 = 46.0;

/// Lines in a square from 0 to 1.
type Icon = &'static [&'static [(f32, f32)]];

/// Each tool, the key that takes it, and how it is drawn.
const TOOLS: [(Tool, &str, Icon); 7] = [
    (
        Tool::Select,
        "V",
        &[&[
            (0.25, 0.1),
            (0.25, 0.8),
            (0.42, 0.63),
            (0.55, 0.9),
            (0.66, 0.84),
            (0.54, 0.58),
            (0.78, 0.58),
            (0.25, 0.1),
        ]],
    ),
    (Tool::Pen, "P", &[&[(0.15, 0.85), (0.25, 0.5), (0.6, 0.2), (0.8, 0.4), (0.5, 0.75), (0.15, 0.85), (0.47, 0.53)]]),
    (
        Tool::Freehand,
        "N",
        &[&[(0.1, 0.6), (0.2, 0.35), (0.32, 0.3), (0.42, 0.5), (0.5, 0.72), (0.62, 0.7), (0.72, 0.45), (0.9, 0.3)]],
    ),
    (
        Tool::Insert,
        "I",
        &[&[(0.1, 0.7), (0.4, 0.5), (0.9, 0.4)], &[(0.5, 0.2), (0.5, 0.75)], &[(0.25, 0.47), (0.75, 0.47)]],
    ),
    (Tool::Join, "C", &[&[(0.1, 0.8), (0.5, 0.25), (0.9, 0.8)], &[(0.2, 0.25), (0.8, 0.25)]]),
    (
        Tool::Drawing,
        "D",
        &[
            &[(0.15, 0.15), (0.85, 0.15), (0.85, 0.85), (0.15, 0.85), (0.15, 0.15)],
            &[(0.25, 0.7), (0.45, 0.4), (0.58, 0.58), (0.68, 0.46), (0.78, 0.7), (0.25, 0.7)],
        ],
    ),
    (
        Tool::Brush,
        "B",
        &[
            &[(0.85, 0.12), (0.5, 0.5), (0.6, 0.6), (0.85, 0.12)],
            &[(0.5, 0.5), (0.32, 0.55), (0.28, 0.75), (0.15, 0.85), (0.42, 0.85), (0.6, 0.6)],
        ],
    ),
];

/// Shows the strip; gives its right edge.
pub(crate) fn show(
    ctx: &egui::Context,
    window: egui::Rect,
    status: &Status,
    actions: &mut MessageWriter<EditorAction>,
) -> f32 {
    egui::Area::new("strip".into()).fixed_pos(window.min).show(ctx, |ui| {
        theme::panel().inner_margin(egui::Margin::symmetric(6, 8)).show(ui, |ui| {
            let size = egui::vec2(WIDTH - 14.0, window.height() - 18.0);
            ui.set_min_size(size);
            ui.set_max_size(size);
            ui.vertical_centered(|ui| {
                for (tool, key, icon) in TOOLS {
                    if tool_button(ui, tool, key, icon, status.tool() == tool) {
                        actions.write(EditorAction::Take(tool));
                    }
                }
            });
        });
    });
    window.left() + WIDTH
}

/// A button with an icon; whether it was clicked.
fn tool_button(ui: &mut egui::Ui, tool: Tool, key: &str, icon: Icon, taken: bool) -> bool {
    let (place, response) = ui.allocate_exact_size(egui::Vec2::splat(30.0), egui::Sense::click());
    response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::RadioButton, true, taken, tool.name()));
    let visuals = ui.style().interact_selectable(&response, taken);
    if taken || response.hovered() || response.has_focus() {
        ui.painter().rect(place, 5.0, visuals.weak_bg_fill, visuals.bg_stroke, egui::StrokeKind::Inside);
    }
    let inner = place.shrink(5.0);
    let stroke = egui::Stroke::new(1.6, visuals.text_color());
    for line in icon {
        let points = line.iter().map(|(x, y)| inner.min + egui::vec2(*x, *y) * inner.size()).collect();
        ui.painter().add(egui::Shape::line(points, stroke));
    }
    let response = response.on_hover_text(format!("{}  {key}\n{}", tool.name(), tool.meaning()));
    response.clicked()
}
