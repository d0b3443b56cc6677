//! The tab of the scene: the model, its splines, files.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;

use super::{Layout, theme};
use crate::editor::actions::{EditorAction, ShownRepairs};
use crate::editor::curves::Curve;
use crate::editor::model::Model;
use crate::editor::selection::Selection;
use crate::editor::tools::Tool;
use crate::editor::tools::brush::BrushSettings;
use crate::editor::tools::drawing::DrawingInHand;
use crate::editor::tools::freehand::{Freehand, FreehandSettings};
use crate::plugin::{BuiltSurface, LineState, SplinePickingSettings, SplineState, SurfaceLine, SurfaceSpline};

/// What lies on a model, and not on the shelf of the history.
type OnModel = Or<(With<SurfaceSpline>, With<SurfaceLine>)>;

/// How far it is.
type State = AnyOf<(&'static SplineState, &'static LineState)>;

/// What the tab shows.
#[derive(SystemParam)]
pub(crate) struct Scene<'w, 's> {
    models: Query<'w, 's, (&'static Model, &'static BuiltSurface)>,
    picking: Res<'w, SplinePickingSettings>,
    repairs: Res<'w, ShownRepairs>,
    curves: Query<'w, 's, (Entity, &'static Curve, State), OnModel>,
    brush: ResMut<'w, BrushSettings>,
    selection: Res<'w, Selection>,
    freehand: ResMut<'w, FreehandSettings>,
    drawn: Res<'w, Freehand>,
    tool: Res<'w, Tool>,
    hand: Res<'w, DrawingInHand>,
}

impl Scene<'_, '_> {
    /// Whether what is drawn by hand stays a line.
    pub(crate) fn draws_lines(&self) -> bool {
        self.freehand.as_line
    }
}

pub(crate) fn show(
    ui: &mut egui::Ui,
    layout: &mut Layout,
    scene: &mut Scene,
    actions: &mut MessageWriter<EditorAction>,
) {
    for (model, _) in &scene.models {
        ui.add(egui::Label::new(egui::RichText::new(&model.name).weak()).truncate());
    }
    show_tool(ui, scene);
    show_list(ui, layout, scene, actions);
    ui.horizontal(|ui| {
        if ui.button("+ New curve").on_hover_text("Takes the pen; click on the model").clicked() {
            actions.write(EditorAction::BeginSpline);
        }
    });
    let mut through = scene.picking.see_through;
    let meaning = "Z: what is behind the model can be selected too";
    if ui.checkbox(&mut through, "See through").on_hover_text(meaning).changed() {
        actions.write(EditorAction::ToggleSeeThrough);
    }
    if scene.models.iter().any(|(_, surface)| surface.report().repaired()) {
        let mut shown = scene.repairs.0;
        let meaning = "Marks the places where the model was repaired when it was opened";
        if ui.checkbox(&mut shown, "Repairs").on_hover_text(meaning).changed() {
            actions.write(EditorAction::ToggleRepairs);
        }
    }
}

/// What the tool in hand can be told.
fn show_tool(ui: &mut egui::Ui, scene: &mut Scene) {
    match *scene.tool {
        Tool::Freehand => {
            let meaning = "What is drawn is smoothed live, by the slider in Properties, and can be brushed; else it becomes a spline";
            let mut as_line = scene.freehand.as_line;
            if ui.checkbox(&mut as_line, "Keep as a line to smooth").on_hover_text(meaning).changed() {
                scene.freehand.as_line = as_line;
            }
            if as_line {
                return;
            }
            ui.label("Tolerance, of the model's size");
            let mut percent = 100.0 * scene.freehand.tolerance;
            let slider = egui::Slider::new(&mut percent, 0.02..=5.0).logarithmic(true).suffix(" %");
            let meaning =
                "How far the spline may be from the line that is drawn; the last line follows until the next is drawn";
            if ui.add(slider).on_hover_text(meaning).changed() {
                scene.freehand.tolerance = 0.01 * percent;
            }
            if scene.drawn.is_fresh() {
                ui.label(egui::RichText::new("The last line follows").weak());
            }
        }
        Tool::Brush => {
            let BrushSettings { mut radius, mut strength, mut closeness } = *scene.brush;
            ui.add(egui::Slider::new(&mut radius, 10.0..=200.0).text("Radius"));
            ui.add(egui::Slider::new(&mut strength, 0.01..=1.0).logarithmic(true).text("Strength"));
            let slider = egui::Slider::new(&mut closeness, 0.1..=100.0).logarithmic(true).text("Closeness");
            ui.add(slider).on_hover_text("How close the line stays to where it was at every touch");
            let settings = BrushSettings { radius, strength, closeness };
            scene.brush.set_if_neq(settings);
        }
        Tool::Drawing => {
            let text = match scene.hand.name() {
                Some(name) => format!("In hand: {name}"),
                None => "No drawing in hand: D asks for one".into(),
            };
            ui.label(text);
        }
        _ => {}
    }
}

fn show_list(ui: &mut egui::Ui, layout: &mut Layout, scene: &Scene, actions: &mut MessageWriter<EditorAction>) {
    let mut curves: Vec<_> = scene.curves.iter().collect();
    curves.sort_by_key(|(_, curve, _)| curve.number);
    if curves.is_empty() {
        ui.label(egui::RichText::new("No splines yet").weak());
    }
    // Thousands of rows would take longer to lay out than a frame has.
    let height = ui.text_style_height(&egui::TextStyle::Button) + 8.0;
    // As much as the window has; what is around it keeps its place.
    let rows = (ui.ctx().viewport_rect().bottom() - ui.cursor().top() - 110.0).max(160.0);
    let rows = egui::ScrollArea::vertical().max_height(rows).auto_shrink([false, true]);
    rows.show_rows(ui, height, curves.len(), |ui, shown| {
        for (entity, curve, state) in &curves[shown] {
            let reason = match state {
                (Some(SplineState::Failed { reason }), _) | (_, Some(LineState::Failed { reason })) => {
                    Some(reason.as_str())
                }
                _ => None,
            };
            show_row(ui, layout, scene, (*entity, curve, reason), actions);
        }
    });
}

fn show_row(
    ui: &mut egui::Ui,
    layout: &mut Layout,
    scene: &Scene,
    (entity, curve, failed): (Entity, &Curve, Option<&str>),
    actions: &mut MessageWriter<EditorAction>,
) {
    let selected = scene.selection.has_spline(entity);
    let mut changed = curve.clone();
    ui.horizontal(|ui| {
        let mut rgb = curve.color.to_srgba().to_u8_array_no_alpha();
        ui.spacing_mut().interact_size = egui::vec2(16.0, 16.0);
        if ui.color_edit_button_srgb(&mut rgb).on_hover_text("Its colour where it is not selected").changed() {
            let [red, green, blue] = rgb;
            changed.color = Color::srgb_u8(red, green, blue);
        }
        if let Some(reason) = failed {
            ui.label(egui::RichText::new("⚠").color(theme::ERROR)).on_hover_text(reason);
        }
        if layout.renaming.as_ref().is_some_and(|(renamed, _)| *renamed == entity) {
            rename(ui, layout, &mut changed);
        } else {
            let text = if curve.is_free() {
                egui::RichText::new(&curve.name)
            } else {
                egui::RichText::new(&curve.name).weak()
            };
            let label =
                ui.selectable_label(selected, text).on_hover_text("Shift adds to the selection; double-click renames");
            if label.double_clicked() {
                layout.renaming = Some((entity, curve.name.clone()));
            } else if label.clicked() {
                let shift = ui.input(|input| input.modifiers.shift);
                actions.write(if shift { EditorAction::Toggle(entity) } else { EditorAction::Select(entity) });
            }
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.small_button("×").on_hover_text("Remove this spline").clicked() {
                actions.write(EditorAction::Remove(entity));
            }
            let hide = ui.selectable_label(curve.hidden, if curve.hidden { "–" } else { "👁" });
            if hide.on_hover_text("Hide or show").clicked() {
                changed.hidden = !changed.hidden;
            }
            let lock = ui.selectable_label(curve.locked, if curve.locked { "🔒" } else { "🔓" });
            if lock.on_hover_text("Locked, no tool touches it").clicked() {
                changed.locked = !changed.locked;
            }
        });
    });
    if changed != *curve {
        actions.write(EditorAction::Restyle(entity, changed));
    }
}

/// The field in which a name is changed; Enter or a click elsewhere keeps it, Escape does not.
fn rename(ui: &mut egui::Ui, layout: &mut Layout, curve: &mut Curve) {
    let Some((_, name)) = &mut layout.renaming else { return };
    let id = egui::Id::new("rename");
    if !ui.memory(|memory| memory.has_focus(id)) {
        // All of it is selected: mostly another name is wanted.
        let mut state = egui::text_edit::TextEditState::default();
        let end = egui::text::CCursor::new(name.chars().count());
        state.cursor.set_char_range(Some(egui::text::CCursorRange::two(egui::text::CCursor::default(), end)));
        state.store(ui.ctx(), id);
    }
    let field = ui.add(egui::TextEdit::singleline(name).id(id).desired_width(90.0));
    if field.lost_focus() {
        let keeps = !ui.input(|input| input.key_pressed(egui::Key::Escape)) && !name.trim().is_empty();
        if keeps {
            curve.name = name.trim().chars().take(200).collect();
        }
        layout.renaming = None;
    } else {
        field.request_focus();
    }
}
