//! The panel's section about what is selected.

use crate::curve::Anchor;
use crate::prelude::*;
use crate::surface::Surface;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;
use glam::DVec3;

use super::scheme;
use crate::editor::actions::EditorAction;
use crate::editor::colors;
use crate::editor::model::Model;
use crate::editor::selection::Selection;
use crate::editor::view::sticky::Excess;

use super::theme;

const JOINS: [(Join, &str, &str); 4] = [
    (Join::Corner, "Corner", "The handles are independent"),
    (Join::Smooth, "Smooth", "The handles point in opposite directions"),
    (Join::Mirrored, "Mirrored", "Opposite directions and equal lengths"),
    (Join::Automatic, "Automatic", "The handles are placed from the neighbouring anchors"),
];

const JUMPS: [(JumpPolicy, &str, &str); 3] = [
    (JumpPolicy::Allow, "Allow", "The curve goes the shortest way, and jumps where another one becomes the shortest"),
    (
        JumpPolicy::Sticky,
        "Stick",
        "The curve stays on its side while handles are dragged; no longer always the shortest way",
    ),
    (JumpPolicy::AutoSplit, "Split", "An anchor is inserted where a segment would jump"),
];

/// What the section shows.
#[derive(SystemParam)]
pub(crate) struct Properties<'w, 's> {
    selection: Res<'w, Selection>,
    splines: Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>,
    excess: Query<'w, 's, &'static Excess>,
    models: Query<'w, 's, (&'static Model, &'static BuiltSurface)>,
}

pub(crate) fn show(ui: &mut egui::Ui, properties: &Properties, actions: &mut MessageWriter<EditorAction>) {
    let selected = properties.selection.spline().and_then(|entity| properties.splines.get(entity).ok());
    let Some((spline, on)) = selected else {
        ui.label(egui::RichText::new("Nothing is selected").weak());
        return;
    };
    let anchor = properties.selection.anchor().and_then(|i| Some((i, spline.anchors().get(i as usize)?)));
    egui::Grid::new("properties").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
        ui.label("Shape");
        let kind = if spline.is_closed() { "closed" } else { "open" };
        ui.label(format!("{kind}, {} anchors", spline.anchors().len()));
        ui.end_row();
        if let Some((index, anchor)) = anchor {
            ui.label("Anchor");
            ui.label(format!("{} of {}", index + 1, spline.anchors().len()));
            ui.end_row();
            if !spline.scheme().method.is_b_spline() {
                show_join(ui, anchor.join(), actions);
            }
        }
    });
    let longer = properties.selection.spline().and_then(|entity| properties.excess.get(entity).ok());
    for (segment, share) in longer.into_iter().flat_map(Excess::segments) {
        let text =
            format!("⚠ Segment {}: {} % longer than the shortest way", segment + 1, significant(100.0 * share, 3));
        let color = theme::egui_color(colors::STICKY, 1.0);
        let meaning = "Its middle leg stays on its side; Jumps: Allow, and back to Stick, lets it go the shortest way";
        ui.label(egui::RichText::new(text).color(color)).on_hover_text(meaning);
    }
    show_buttons(ui, spline.is_closed(), anchor.is_some(), actions);
    let model = properties.models.get(on.0);
    if let (Some((_, anchor)), Ok((model, surface))) = (anchor, model) {
        show_position(ui, model, surface, anchor, actions);
    }
    ui.add_space(6.0);
    ui.label(egui::RichText::new("How it is traced").strong());
    egui::Grid::new("scheme").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
        scheme::show(ui, spline.scheme(), actions);
        if !spline.scheme().method.is_b_spline() {
            show_jumps(ui, spline.jumps(), actions);
        }
    });
}

fn show_jumps(ui: &mut egui::Ui, jumps: JumpPolicy, actions: &mut MessageWriter<EditorAction>) {
    let name = JUMPS.iter().find(|(policy, ..)| *policy == jumps).map_or("", |(_, name, _)| name);
    ui.label("Jumps");
    egui::ComboBox::from_id_salt("jumps").selected_text(name).width(150.0).show_ui(ui, |ui| {
        for (policy, name, meaning) in JUMPS {
            if ui.selectable_label(policy == jumps, name).on_hover_text(meaning).clicked() {
                actions.write(EditorAction::SetJumps(policy));
            }
        }
    });
    ui.end_row();
}

/// What can be done with the selection, with the keys that do it.
fn show_buttons(ui: &mut egui::Ui, closed: bool, anchor: bool, actions: &mut MessageWriter<EditorAction>) {
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        let toggle = if closed { "Open" } else { "Close" };
        let buttons = [
            (toggle, "O", true, EditorAction::ToggleClosed),
            ("Reverse", "Shift+R", true, EditorAction::Reverse),
            ("Duplicate", "Ctrl+D", true, EditorAction::Duplicate),
            ("Split", "K, at the active anchor", anchor, EditorAction::Split),
            ("Straighten", "L, the segment behind the active anchor", anchor, EditorAction::Straighten),
            ("Join", "J, the last two selected curves", true, EditorAction::JoinSplines),
            ("Make a line", "A drawn line along it, which can be smoothed and brushed", true, EditorAction::ToLines),
            ("Delete", "X", true, EditorAction::Delete),
        ];
        for (name, key, enabled, action) in buttons {
            if ui.add_enabled(enabled, egui::Button::new(name)).on_hover_text(key).clicked() {
                actions.write(action);
            }
        }
    });
}

/// The anchor's position, which may be typed: the nearest surface point is taken.
fn show_position(
    ui: &mut egui::Ui,
    model: &Model,
    surface: &Surface,
    anchor: &Anchor,
    actions: &mut MessageWriter<EditorAction>,
) {
    let position = model.in_file(surface.position(&anchor.point()));
    let mut typed = position.to_array();
    let speed = 0.002 * model.unit;
    ui.add_space(4.0);
    ui.label("Position").on_hover_text(
        "In the model's own units. The anchor goes to the nearest place on the surface, so that other numbers may come of it",
    );
    let (mut moved, mut slides, mut ended) = (false, false, false);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for (axis, value) in ["x", "y", "z"].into_iter().zip(&mut typed) {
            let before = *value;
            let field = egui::DragValue::new(value).speed(speed).update_while_editing(false);
            let field = field.custom_formatter(|value, _| significant(value, 4)).prefix(format!("{axis} "));
            let response = ui.add(field.max_decimals(9));
            // A field that is left as it was gives back what it shows, which is rounded.
            moved |= response.changed() && significant(*value, 4) != significant(before, 4);
            slides |= response.dragged();
            ended |= response.drag_stopped();
        }
    });
    let wanted = model.of_file(DVec3::from_array(typed));
    if moved
        && wanted.is_finite()
        && let Some(nearest) = surface.closest_point(wanted)
    {
        // A way of the pointer over the field is one entry of the history, as is a number that is typed.
        let to = nearest.point;
        actions.write(if slides { EditorAction::SlideAnchorTo(to) } else { EditorAction::MoveAnchorTo(to) });
    }
    if ended {
        actions.write(EditorAction::EndSlide);
    }
}

fn show_join(ui: &mut egui::Ui, join: Join, actions: &mut MessageWriter<EditorAction>) {
    let name = JOINS.iter().find(|(kind, ..)| *kind == join).map_or("", |(_, name, _)| name);
    ui.label("Join  C");
    egui::ComboBox::from_id_salt("join").selected_text(name).width(140.0).show_ui(ui, |ui| {
        for (other, name, meaning) in JOINS {
            if ui.selectable_label(other == join, name).on_hover_text(meaning).clicked() {
                actions.write(EditorAction::SetJoin(other));
            }
        }
    });
    ui.end_row();
}

/// A number with so many significant digits, in as few characters as that needs.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    let magnitude = if value == 0.0 || !value.is_finite() { 0.0 } else { value.abs().log10().floor() };
    if (-4.0..6.0).contains(&magnitude) {
        let decimals = (digits as f64 - 1.0 - magnitude).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.0$e}", digits.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn numbers_are_short() {
        assert_eq!(significant(0.0, 4), "0.000");
        assert_eq!(significant(-1.06271, 4), "-1.063");
        assert_eq!(significant(12345.6, 4), "12346");
        assert_eq!(significant(0.00123456, 4), "0.001235");
        assert_eq!(significant(1.5e9, 4), "1.500e9");
        assert_eq!(significant(f64::NAN, 4), "NaN");
    }
}
