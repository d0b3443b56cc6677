//! The panel at the right, and the layout of everything that egui shows.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPostUpdateSet, EguiPrimaryContextPass, egui};
use bevy_surface_splines::prelude::*;

use crate::actions::Action;
use crate::curves::Curve;
use crate::history::History;
use crate::marks::{self, Marks};
use crate::model::{Model, OpenModel};
use crate::notices::{self, Notices};
use crate::properties::{self, Properties};
use crate::selection::Selection;
use crate::statistics::{self, Statistics};
use crate::status::{self, Status};
use crate::tools::Tool;
use crate::{help, theme};

const WIDTH: f32 = 272.0;

/// What is shown where.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub(crate) struct Layout {
    /// The part of the window that nothing covers; none before the first frame.
    pub(crate) free: Option<Rect>,
    pub(crate) panel_hidden: bool,
    pub(crate) help: bool,
    /// Whether the keyboard is to go into the panel.
    pub(crate) focus_panel: bool,
    /// The path in the panel's field.
    path: String,
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Layout>()
        .configure_sets(PostUpdate, EguiPostUpdateSet::EndPass.after(SurfaceSplineSystems::Controls))
        .add_systems(EguiPrimaryContextPass, show);
}

/// The list of splines and the tools.
#[derive(bevy::ecs::system::SystemParam)]
struct Scene<'w, 's> {
    models: Query<'w, 's, &'static Model>,
    curves: Query<'w, 's, (Entity, &'static Curve, &'static SplineState), With<SurfaceSpline>>,
    selection: Res<'w, Selection>,
    tool: Res<'w, Tool>,
    opens: MessageWriter<'w, OpenModel>,
    history: Res<'w, History>,
}

fn show(
    mut contexts: EguiContexts,
    mut layout: ResMut<Layout>,
    marks: Marks,
    scene: (Scene, Properties, Statistics),
    status: Status,
    mut notices: ResMut<Notices>,
    mut actions: MessageWriter<Action>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    let window = ctx.viewport_rect();
    marks::paint(ctx, &marks);
    let right = if layout.panel_hidden { window.right() } else { window.right() - WIDTH };
    let bottom = status::show(ctx, egui::Rect::from_min_max(window.min, egui::pos2(right, window.max.y)), &status);
    if !layout.panel_hidden {
        show_panel(ctx, window, &mut layout, scene, &mut actions);
    }
    notices::show(ctx, right, &mut notices);
    if layout.help {
        layout.help = help::show(ctx);
    }
    let free = Rect::new(window.left(), window.top(), right, bottom);
    if layout.free != Some(free) {
        layout.free = Some(free);
    }
    Ok(())
}

fn show_panel(
    ctx: &egui::Context,
    window: egui::Rect,
    layout: &mut Layout,
    (mut scene, properties, statistics): (Scene, Properties, Statistics),
    actions: &mut MessageWriter<Action>,
) {
    // An area, not a panel: so egui knows when the pointer is on it.
    egui::Area::new("panel".into()).fixed_pos(egui::pos2(window.right() - WIDTH, window.top())).show(ctx, |ui| {
        theme::panel().show(ui, |ui| {
            let size = egui::vec2(WIDTH - 30.0, window.height() - 22.0);
            ui.set_min_size(size);
            ui.set_max_size(size);
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                section(ui, "Scene", |ui| show_scene(ui, layout, &mut scene, actions));
                section(ui, "Properties", |ui| properties::show(ui, &properties, actions));
                section(ui, "Statistics", |ui| statistics::show(ui, &statistics));
            });
        });
    });
}

fn section(ui: &mut egui::Ui, title: &str, contents: impl FnOnce(&mut egui::Ui)) {
    let heading = egui::RichText::new(title).strong().size(14.0);
    egui::CollapsingHeader::new(heading).default_open(true).show_unindented(ui, contents);
    ui.add_space(4.0);
}

fn show_scene(ui: &mut egui::Ui, layout: &mut Layout, scene: &mut Scene, actions: &mut MessageWriter<Action>) {
    for model in &scene.models {
        ui.add(egui::Label::new(egui::RichText::new(&model.name).weak()).truncate());
    }
    ui.horizontal(|ui| {
        let select = ui.selectable_label(*scene.tool == Tool::Select, "Select  V");
        if std::mem::take(&mut layout.focus_panel) {
            select.request_focus();
        }
        if select.on_hover_text("Click selects, drag moves anchors and handles").clicked() {
            actions.write(Action::Take(Tool::Select));
        }
        let pen = ui.selectable_label(*scene.tool == Tool::Pen, "Pen  P");
        if pen.on_hover_text("Every click on the model adds an anchor").clicked() {
            actions.write(Action::Take(Tool::Pen));
        }
        let [undo, redo] = scene.history.names();
        for (sign, name, action) in [("⟲", undo, Action::Undo), ("⟳", redo, Action::Redo)] {
            let button = ui.add_enabled(name.is_some(), egui::Button::new(sign));
            if button.on_hover_text(format!("{action:?}: {}", name.unwrap_or_default())).clicked() {
                actions.write(action);
            }
        }
    });
    show_list(ui, scene, actions);
    ui.horizontal(|ui| {
        if ui.button("+ New spline").on_hover_text("Takes the pen; click on the model").clicked() {
            actions.write(Action::BeginSpline);
        }
        ui.menu_button("Open …", |ui| {
            ui.set_min_width(260.0);
            ui.label("Path of an OBJ, STL, PLY, OFF, glTF or GLB file:");
            let field = ui.add(egui::TextEdit::singleline(&mut layout.path).desired_width(250.0));
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            if (ui.button("Open").clicked() || entered) && !layout.path.trim().is_empty() {
                scene.opens.write(OpenModel::File(layout.path.trim().into()));
                ui.close();
            }
            ui.label(egui::RichText::new("or drop a file on the window").weak());
        });
    });
}

fn show_list(ui: &mut egui::Ui, scene: &mut Scene, actions: &mut MessageWriter<Action>) {
    let mut curves: Vec<_> = scene.curves.iter().collect();
    curves.sort_by_key(|(_, curve, _)| curve.number);
    if curves.is_empty() {
        ui.label(egui::RichText::new("No splines yet").weak());
    }
    for (entity, curve, state) in curves {
        let selected = scene.selection.spline == Some(entity);
        ui.horizontal(|ui| {
            let color = if selected { theme::ACCENT } else { curve.color };
            let (dot, _) = ui.allocate_exact_size(egui::vec2(12.0, 12.0), egui::Sense::hover());
            ui.painter().circle_filled(dot.center(), 5.0, theme::egui_color(color, 1.0));
            if let SplineState::Failed { reason } = state {
                ui.label(egui::RichText::new("⚠").color(theme::ERROR)).on_hover_text(reason);
            }
            if ui.selectable_label(selected, &curve.name).clicked() {
                actions.write(Action::Select(entity));
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.small_button("×").on_hover_text("Remove this spline").clicked() {
                    actions.write(Action::Remove(entity));
                }
            });
        });
    }
}
