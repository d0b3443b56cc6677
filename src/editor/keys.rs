//! The key map: which key asks for what. The table is what keys do and what the help shows, so that the two agree.

use bevy::prelude::*;

use super::actions::EditorAction;
use super::input::{Modifiers, NumberExpected, PanelInput, StruckKeys, ToolKeys, keyboard_is_free};
use super::tools::transform::TransformMode;
use super::tools::{Tool, ToolPointer};
use crate::plugin::DragState;

/// A key, what must be held with it, and what it asks for.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// The key by its place on the keyboard.
    pub key: KeyCode,
    /// With Ctrl (or the command key), and with Shift.
    pub control: bool,
    /// With Shift.
    pub shift: bool,
    /// How it is written.
    pub label: &'static str,
    /// What it does.
    pub meaning: &'static str,
    /// What it asks for; none where another part of the editor reads the key itself.
    pub(crate) action: Option<fn() -> EditorAction>,
    /// Under which heading the help shows it.
    pub section: &'static str,
}

/// A line of help about something that is no single key.
#[derive(Clone, Copy, Debug)]
pub struct Hint {
    /// What one does.
    pub label: &'static str,
    /// What comes of it.
    pub meaning: &'static str,
    /// Under which heading the help shows it.
    pub section: &'static str,
}

const fn key(key: KeyCode, label: &'static str, meaning: &'static str, section: &'static str) -> Binding {
    Binding { key, control: false, shift: false, label, meaning, action: None, section }
}

impl Binding {
    const fn control(self) -> Self {
        Self { control: true, ..self }
    }

    const fn shift(self) -> Self {
        Self { shift: true, ..self }
    }

    const fn asks(self, action: fn() -> EditorAction) -> Self {
        Self { action: Some(action), ..self }
    }
}

const TOOLS: &str = "Tools";
const EDIT: &str = "Edit";
const VIEW: &str = "View";
const PANEL: &str = "Panel";
const FILES: &str = "Files";

/// All keys.
pub const BINDINGS: &[Binding] = &[
    key(KeyCode::KeyV, "V", "Select and move", TOOLS).asks(|| EditorAction::Take(Tool::Select)),
    key(KeyCode::KeyP, "P", "Pen", TOOLS).asks(|| EditorAction::Take(Tool::Pen)),
    key(KeyCode::KeyN, "N", "Freehand", TOOLS).asks(|| EditorAction::Take(Tool::Freehand)),
    key(KeyCode::KeyI, "I", "Insert anchors", TOOLS).asks(|| EditorAction::Take(Tool::Insert)),
    key(KeyCode::KeyD, "D", "Place a drawing", TOOLS).asks(|| EditorAction::Take(Tool::Drawing)),
    key(KeyCode::KeyB, "B", "Brush: smooths drawn lines", TOOLS).asks(|| EditorAction::Take(Tool::Brush)),
    key(KeyCode::KeyC, "C", "Join of the selected anchors, in turn; without one, the tool that does so", TOOLS)
        .asks(|| EditorAction::CycleJoin),
    key(KeyCode::Enter, "Enter", "End the pen", TOOLS).asks(|| EditorAction::Take(Tool::Select)),
    key(KeyCode::Escape, "Escape", "Take a gesture back; end the pen", TOOLS).asks(|| EditorAction::Take(Tool::Select)),
    key(KeyCode::KeyG, "G", "Move the selection with the pointer; numbers may be typed", EDIT)
        .asks(|| EditorAction::Transform(TransformMode::Move)),
    key(KeyCode::KeyR, "R", "Turn the selection; in degrees", EDIT)
        .asks(|| EditorAction::Transform(TransformMode::Turn)),
    key(KeyCode::KeyS, "S", "Scale the selection; a factor", EDIT)
        .asks(|| EditorAction::Transform(TransformMode::Scale)),
    key(KeyCode::KeyX, "X, Delete", "Delete the selected anchors, or the curves", EDIT).asks(|| EditorAction::Delete),
    key(KeyCode::KeyX, "Shift+X", "Delete the segment behind the active anchor", EDIT)
        .shift()
        .asks(|| EditorAction::DeleteSegment),
    key(KeyCode::KeyO, "O", "Close the curve, or open it at the active anchor", EDIT)
        .asks(|| EditorAction::ToggleClosed),
    key(KeyCode::KeyK, "K", "Cut the curve in two at the active anchor", EDIT).asks(|| EditorAction::Split),
    key(KeyCode::KeyJ, "J", "Join two curves at their nearest ends", EDIT).asks(|| EditorAction::JoinSplines),
    key(KeyCode::KeyR, "Shift+R", "Let the curve run the other way", EDIT).shift().asks(|| EditorAction::Reverse),
    key(KeyCode::KeyL, "L", "Straighten the segment behind the active anchor", EDIT).asks(|| EditorAction::Straighten),
    key(KeyCode::KeyA, "Ctrl+A", "Select all curves", EDIT).control().asks(|| EditorAction::SelectAll),
    key(KeyCode::KeyC, "Ctrl+C", "Copy the selected curves", EDIT).control().asks(|| EditorAction::Copy),
    key(KeyCode::KeyV, "Ctrl+V", "Paste at the pointer", EDIT).control().asks(|| EditorAction::Paste { scaled: false }),
    key(KeyCode::KeyV, "Ctrl+Shift+V", "Paste, scaled by the ratio of the models' sizes", EDIT)
        .control()
        .shift()
        .asks(|| EditorAction::Paste { scaled: true }),
    key(KeyCode::KeyD, "Ctrl+D", "Duplicate the selected curves in place", EDIT)
        .control()
        .asks(|| EditorAction::Duplicate),
    key(KeyCode::KeyZ, "Ctrl+Z", "Undo", EDIT).control().asks(|| EditorAction::Undo),
    key(KeyCode::KeyZ, "Ctrl+Shift+Z", "Redo", EDIT).control().shift().asks(|| EditorAction::Redo),
    key(KeyCode::KeyY, "Ctrl+Y", "Redo", EDIT).control().asks(|| EditorAction::Redo),
    key(KeyCode::KeyO, "Ctrl+O", "Open a document, a mesh or a drawing", FILES).control(),
    key(KeyCode::KeyS, "Ctrl+S", "Save", FILES).control().asks(|| EditorAction::Save),
    key(KeyCode::KeyS, "Ctrl+Shift+S", "Save under another name", FILES).control().shift(),
    key(KeyCode::KeyF, "F, Home", "Frame the selection, or the model", VIEW),
    key(KeyCode::Digit1, "1, 3, 7", "From the front, the right, the top", VIEW),
    key(KeyCode::Digit5, "5", "Orthographic or perspective", VIEW),
    key(KeyCode::KeyZ, "Z", "See through: what is behind the model can be selected, or not", VIEW)
        .asks(|| EditorAction::ToggleSeeThrough),
    key(KeyCode::Tab, "Tab", "Hide or show the panel", PANEL),
    key(KeyCode::F6, "F6", "Take the keyboard to the panel; Escape leaves", PANEL),
    key(KeyCode::F1, "?, F1", "This help", PANEL),
];

/// What one does with the pointer.
pub const HINTS: &[Hint] = &[
    Hint { label: "Shift+click", meaning: "Add to the selection, or take out of it", section: EDIT },
    Hint { label: "Click again", meaning: "Take what is behind, at the same place", section: EDIT },
    Hint { label: "Alt, dragging a handle", meaning: "Free it from its partner", section: EDIT },
    Hint { label: "Ctrl, dragging a handle", meaning: "Turn it in steps of 15°", section: EDIT },
    Hint { label: "Shift, dragging a handle", meaning: "Keep its direction", section: EDIT },
    Hint { label: "Shift, Ctrl in a transform", meaning: "Finer; in steps", section: EDIT },
    Hint { label: "Middle drag, Alt+left drag", meaning: "Orbit about the point under the pointer", section: VIEW },
    Hint { label: "Shift+middle drag", meaning: "Pan", section: VIEW },
    Hint { label: "Wheel, pinch", meaning: "Zoom to the pointer", section: VIEW },
    Hint { label: "Two fingers", meaning: "Orbit; with Shift pan", section: VIEW },
];

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<NumberExpected>().add_systems(Update, strike.before(super::camera::ViewKeys));
}

fn strike(
    mut keys: StruckKeys,
    pressed: Res<ButtonInput<KeyCode>>,
    (drag, pointer): (Res<DragState>, Res<ToolPointer>),
    (panel, tool): (Res<PanelInput>, Option<Res<ToolKeys>>),
    mut was_held: Local<bool>,
    (mut numbers, time): (ResMut<NumberExpected>, Res<Time<Real>>),
    mut actions: MessageWriter<EditorAction>,
) {
    let struck = keys.read();
    keys.keep_held(&pressed);
    // What is held ends first; Escape takes it back, and no more than that.
    let held = drag.held().is_some() || pointer.held().is_some();
    let was_held = std::mem::replace(&mut *was_held, held);
    if held || !keyboard_is_free(panel, tool) {
        return;
    }
    for (struck, Modifiers { control, shift, .. }) in struck {
        let key = match struck {
            KeyCode::Escape | KeyCode::Enter | KeyCode::NumpadEnter if was_held => continue,
            KeyCode::Delete | KeyCode::Backspace => KeyCode::KeyX,
            KeyCode::NumpadEnter => KeyCode::Enter,
            other => other,
        };
        let found = BINDINGS.iter().find(|b| b.key == key && b.control == control && b.shift == shift);
        if let Some(action) = found.and_then(|binding| binding.action) {
            let action = action();
            if matches!(action, EditorAction::Transform(_)) {
                numbers.expect(time.elapsed());
            }
            actions.write(action);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_means_two_things() {
        for (i, a) in BINDINGS.iter().enumerate() {
            for b in &BINDINGS[i + 1..] {
                assert!((a.key, a.control, a.shift) != (b.key, b.control, b.shift), "{} and {}", a.label, b.label);
            }
        }
    }
}
