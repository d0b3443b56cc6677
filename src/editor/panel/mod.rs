//! The panel of egui: a tool strip at the left, tabs at the right, the status line, notices, help.
//!
//! It shows what resources and components say, and asks for changes by messages, as any other system could.

use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_egui::input::EguiWantsInput;
use bevy_egui::{EguiContexts, EguiInput, EguiPostUpdateSet, EguiPreUpdateSet, EguiPrimaryContextPass, egui};

use super::actions::EditorAction;
use super::input::{FreeView, PanelInput, keyboard_is_free};
use super::notices::Notices;
use super::tools::pointer::read_pointer;
use crate::plugin::SurfaceSplineSystems;

pub(crate) mod curvature;
pub(crate) mod files;
pub(crate) mod gizmo;
pub(crate) mod help;
pub(crate) mod history;
pub(crate) mod line;
pub(crate) mod marks;
pub(crate) mod notices;
pub(crate) mod properties;
pub(crate) mod scene;
pub(crate) mod scheme;
pub(crate) mod statistics;
pub(crate) mod status;
pub(crate) mod strip;
pub(crate) mod theme;

use marks::Marks;
use status::Status;

/// Width of the panel, and at most which share of the window.
const WIDTH: f32 = 272.0;
const SHARE: f32 = 0.38;

/// What the panel shows.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub(crate) struct Layout {
    pub(crate) panel_hidden: bool,
    pub(crate) help: bool,
    /// Whether it was opened in this frame.
    help_is_new: bool,
    /// Whether the keyboard is to go into the panel.
    pub(crate) focus_panel: bool,
    pub(crate) tab: Tab,
    /// What is searched in the help.
    pub(crate) search: String,
    /// The path in the panel's field.
    pub(crate) path: String,
    /// The spline that is being renamed, and its name so far.
    pub(crate) renaming: Option<(Entity, String)>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tab {
    #[default]
    Scene,
    Properties,
    Statistics,
    History,
}

impl Tab {
    const ALL: [(Self, &str); 4] = [
        (Self::Scene, "Scene"),
        (Self::Properties, "Properties"),
        (Self::Statistics, "Statistics"),
        (Self::History, "History"),
    ];
}

pub(crate) fn plugin(app: &mut App) {
    let before_all = take_tab.after(EguiPreUpdateSet::ProcessInput).before(EguiPreUpdateSet::BeginPass);
    app.init_resource::<Layout>()
        .configure_sets(PostUpdate, EguiPostUpdateSet::EndPass.after(SurfaceSplineSystems::Controls))
        .add_plugins(theme::plugin)
        .add_systems(PreUpdate, (before_all, keep_input.before(read_pointer)))
        .init_resource::<files::FileDialog>()
        .init_resource::<curvature::CurvaturePlot>()
        .add_systems(Update, (strike.run_if(keyboard_is_free), files::strike))
        .add_systems(EguiPrimaryContextPass, show);
}

/// Tells everybody else what the panel keeps for itself.
fn keep_input(
    egui: Res<EguiWantsInput>,
    mut contexts: EguiContexts,
    windows: Query<&Window, With<PrimaryWindow>>,
    mut panel: ResMut<PanelInput>,
) {
    // What egui wants is of the frame before: a press may come with the move that led there.
    let at = windows.iter().next().and_then(Window::cursor_position);
    let over = at.zip(contexts.ctx_mut().ok()).is_some_and(|(at, ctx)| {
        let layer = ctx.layer_id_at(egui::pos2(at.x, at.y));
        layer.is_some_and(|layer| layer.order != egui::Order::Background)
    });
    let pointer = over || egui.wants_any_pointer_input();
    panel.set_if_neq(PanelInput { pointer, keyboard: egui.wants_any_keyboard_input() });
}

/// Tab hides the panel, unless the keyboard is in the panel already, where it goes on to the next field. egui would move
/// there by itself.
fn take_tab(egui: Res<EguiWantsInput>, mut inputs: Query<&mut EguiInput>) {
    if egui.wants_any_keyboard_input() {
        return;
    }
    for mut input in &mut inputs {
        input.events.retain(|event| !matches!(event, egui::Event::Key { key: egui::Key::Tab, .. }));
    }
}

fn strike(keys: Res<ButtonInput<KeyCode>>, mut struck: MessageReader<KeyboardInput>, mut layout: ResMut<Layout>) {
    // Where the question mark is depends on the keyboard's layout. `ButtonInput` would take it for held for ever where Shift is let go
    // of first: then it is another character that ends.
    let asks = struck.read().any(|key| {
        let is_pressed = key.state == ButtonState::Pressed && !key.repeat;
        is_pressed && (key.key_code == KeyCode::F1 || key.logical_key == Key::Character("?".into()))
    });
    // While it is open, help closes itself.
    if !layout.help && asks {
        (layout.help, layout.help_is_new, layout.search) = (true, true, String::new());
    }
    if keys.just_pressed(KeyCode::Tab) {
        layout.panel_hidden = !layout.panel_hidden;
    }
    if keys.just_pressed(KeyCode::F6) {
        (layout.panel_hidden, layout.focus_panel) = (false, true);
    }
}

/// What the tabs show.
type Tabs<'w, 's> = (scene::Scene<'w, 's>, AllProperties<'w, 's>, statistics::Statistics<'w, 's>, history::Entries<'w>);
/// Of a spline, or of a line.
type AllProperties<'w, 's> = (properties::Properties<'w, 's>, line::LineProperties<'w, 's>);

fn show(
    mut contexts: EguiContexts,
    (mut layout, mut free_view): (ResMut<Layout>, ResMut<FreeView>),
    (marks, gizmo): (Marks, gizmo::GizmoLook),
    tabs: Tabs,
    status: Status,
    (mut notices, mut files): (ResMut<Notices>, files::Files),
    mut actions: MessageWriter<EditorAction>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    let window = ctx.viewport_rect();
    gizmo::paint(ctx, &gizmo, &marks);
    marks::paint(ctx, &marks);
    let hidden = layout.panel_hidden;
    let left = if hidden { window.left() } else { strip::show(ctx, window, &status, &mut actions) };
    let right = if hidden { window.right() } else { window.right() - WIDTH.min(SHARE * window.width()) };
    let below = egui::Rect::from_min_max(egui::pos2(left, window.top()), egui::pos2(right, window.bottom()));
    let bottom = status::show(ctx, below, (&status, tabs.0.draws_lines()), files.requests.as_mut());
    if !hidden {
        show_panel(ctx, window, right, &mut layout, (tabs, &mut files), &mut actions);
    }
    notices::show(ctx, left..=right, &mut notices, &mut actions);
    files::show(ctx, &mut files);
    if layout.help {
        let is_new = std::mem::take(&mut layout.help_is_new);
        layout.help = help::show(ctx, &mut layout.search, is_new);
    }
    let free = FreeView(Some(Rect::new(left, window.top(), right, bottom)));
    free_view.set_if_neq(free);
    Ok(())
}

fn show_panel(
    ctx: &egui::Context,
    window: egui::Rect,
    left: f32,
    layout: &mut Layout,
    ((mut scene, properties, mut statistics, entries), files): (Tabs, &mut files::Files),
    actions: &mut MessageWriter<EditorAction>,
) {
    // An area, not a panel: so egui knows when the pointer is on it.
    egui::Area::new("panel".into()).fixed_pos(egui::pos2(left, window.top())).show(ctx, |ui| {
        theme::panel().show(ui, |ui| {
            let size = egui::vec2(window.right() - left - 30.0, window.height() - 22.0);
            ui.set_min_size(size);
            ui.set_max_size(size);
            show_tabs(ui, layout);
            ui.separator();
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match layout.tab {
                Tab::Scene => {
                    files::show_buttons(ui, files);
                    scene::show(ui, layout, &mut scene, actions);
                }
                Tab::Properties => {
                    if !line::show(ui, &properties.1, actions) {
                        properties::show(ui, &properties.0, actions);
                    }
                }
                Tab::Statistics => statistics::show(ui, &mut statistics),
                Tab::History => history::show(ui, &entries, actions),
            });
        });
    });
}

fn show_tabs(ui: &mut egui::Ui, layout: &mut Layout) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 1.0;
        ui.spacing_mut().button_padding.x = 5.0;
        for (tab, name) in Tab::ALL {
            let label = ui.selectable_label(layout.tab == tab, name);
            if layout.tab == tab && std::mem::take(&mut layout.focus_panel) {
                label.request_focus();
            }
            if label.clicked() {
                layout.tab = tab;
            }
        }
    });
}
