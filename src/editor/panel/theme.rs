//! Colours and the look of the panels.

use bevy::prelude::*;
use bevy_egui::egui::{self, Color32, CornerRadius, Frame, Margin, Stroke, Visuals};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use crate::editor::colors::ACCENT;

pub(crate) const INFO: Color32 = Color32::from_rgb(120, 170, 230);
pub(crate) const WARNING: Color32 = Color32::from_rgb(240, 185, 70);
pub(crate) const ERROR: Color32 = Color32::from_rgb(240, 100, 90);
const PANEL: Color32 = Color32::from_rgb(31, 34, 40);
const EDGE: Color32 = Color32::from_rgb(58, 63, 73);

pub(crate) fn plugin(app: &mut App) {
    app.add_systems(EguiPrimaryContextPass, (set_style.run_if(run_once), draw_glyphs).chain());
}

/// Has all usual letters drawn before they are needed: one that is new to the texture is missing for a frame.
fn draw_glyphs(mut contexts: EguiContexts, mut drawn_at: Local<f32>) -> Result {
    let ctx = contexts.ctx_mut()?;
    let scale = ctx.pixels_per_point();
    if std::mem::replace(&mut *drawn_at, scale) != scale {
        let letters: String = (' '..='~').chain("·–…°²³×⚠κ".chars()).collect();
        let fonts: Vec<egui::FontId> = ctx.global_style().text_styles.values().cloned().collect();
        for font in fonts {
            let _ = ctx.fonts_mut(|drawn| drawn.layout_no_wrap(letters.clone(), font, Color32::WHITE));
        }
    }
    Ok(())
}

pub(crate) fn egui_color(color: Color, opacity: f32) -> Color32 {
    let [red, green, blue, alpha] = color.to_srgba().to_u8_array();
    Color32::from_rgba_unmultiplied(red, green, blue, (f32::from(alpha) * opacity) as u8)
}

/// The frame of panels that touch an edge of the window.
pub(crate) fn panel() -> Frame {
    Frame::new().fill(PANEL).inner_margin(Margin::symmetric(14, 10)).stroke(Stroke::new(1.0, EDGE))
}

/// The frame of what floats above the model.
pub(crate) fn card() -> Frame {
    let shadow = egui::Shadow { offset: [0, 3], blur: 10, spread: 0, color: Color32::from_black_alpha(70) };
    panel().corner_radius(CornerRadius::same(8)).inner_margin(Margin::same(10)).shadow(shadow)
}

fn set_style(mut contexts: EguiContexts) -> Result {
    let mut visuals = Visuals::dark();
    visuals.panel_fill = PANEL;
    visuals.window_fill = PANEL;
    visuals.override_text_color = Some(Color32::from_rgb(222, 226, 232));
    visuals.selection.bg_fill = egui_color(ACCENT, 0.35);
    visuals.selection.stroke = Stroke::new(1.0, Color32::WHITE);
    visuals.slider_trailing_fill = true;
    for widget in [&mut visuals.widgets.inactive, &mut visuals.widgets.hovered, &mut visuals.widgets.active] {
        widget.corner_radius = CornerRadius::same(5);
    }
    contexts.ctx_mut()?.all_styles_mut(|style| {
        style.visuals = visuals.clone();
        style.spacing.item_spacing = egui::vec2(8.0, 5.0);
        style.spacing.button_padding = egui::vec2(8.0, 3.0);
        style.interaction.selectable_labels = false;
    });
    Ok(())
}
