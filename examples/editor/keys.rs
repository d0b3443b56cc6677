//! Keys of the tools and edits. Those of the camera are in its file; [`crate::help`] lists them all.

use bevy::input::keyboard::Key;
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;
use bevy_egui::{EguiInput, EguiPreUpdateSet, egui};
use bevy_surface_splines::prelude::*;

use crate::actions::Action;
use crate::panel::Layout;
use crate::tools::{PenStart, Tool};

pub(crate) fn plugin(app: &mut App) {
    let take = take_tab.after(EguiPreUpdateSet::ProcessInput).before(EguiPreUpdateSet::BeginPass);
    app.add_systems(PreUpdate, take).add_systems(Update, (strike, show_panels).run_if(keyboard_is_free));
}

/// Whether keys are not typed into a field of the panel.
pub(crate) fn keyboard_is_free(egui: Res<EguiWantsInput>) -> bool {
    !egui.wants_any_keyboard_input()
}

fn strike(
    keys: Res<ButtonInput<KeyCode>>,
    drag: Res<DragState>,
    tool: Res<Tool>,
    mut pen: ResMut<PenStart>,
    mut actions: MessageWriter<Action>,
) {
    if *tool != Tool::Pen && pen.0.is_some() {
        pen.0 = None;
    }
    // A drag ends first; Escape cancels it.
    if drag.held().is_some() {
        return;
    }
    let control = keys.any_pressed([KeyCode::ControlLeft, KeyCode::ControlRight]);
    let shift = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    actions.write_batch(keys.get_just_pressed().filter_map(|key| match key {
        KeyCode::KeyZ if control && shift => Some(Action::Redo),
        KeyCode::KeyY if control => Some(Action::Redo),
        KeyCode::KeyZ if control => Some(Action::Undo),
        _ if control => None,
        KeyCode::KeyV => Some(Action::Take(Tool::Select)),
        KeyCode::KeyP => Some(Action::Take(Tool::Pen)),
        KeyCode::KeyX | KeyCode::Delete | KeyCode::Backspace => Some(Action::Delete),
        KeyCode::KeyC => Some(Action::CycleJoin),
        KeyCode::Enter | KeyCode::NumpadEnter | KeyCode::Escape => Some(Action::Take(Tool::Select)),
        _ => None,
    }));
}

fn show_panels(keys: Res<ButtonInput<KeyCode>>, typed: Res<ButtonInput<Key>>, mut layout: ResMut<Layout>) {
    // Where the question mark is depends on the keyboard's layout.
    if keys.just_pressed(KeyCode::F1) || typed.just_pressed(Key::Character("?".into())) {
        layout.help = !layout.help;
    } else if keys.just_pressed(KeyCode::Escape) && layout.help {
        layout.help = false;
    }
    if keys.just_pressed(KeyCode::Tab) {
        layout.panel_hidden = !layout.panel_hidden;
    }
    if keys.just_pressed(KeyCode::F6) {
        (layout.panel_hidden, layout.focus_panel) = (false, true);
    }
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
