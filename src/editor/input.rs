//! Whose input it is: a panel's or the viewport's.

use bevy::prelude::*;

/// What a panel keeps for itself; written by the panel before anybody else looks at the input of the frame.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct PanelInput {
    /// The pointer is over a panel, or holds something of it.
    pub pointer: bool,
    /// Keys are typed into a field.
    pub keyboard: bool,
}

/// The part of the window that no panel covers, in logical pixels; none before the first frame, and without a panel.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct FreeView(pub Option<Rect>);

/// Whether keys belong to what a tool is doing: digits are a number then.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ToolKeys(pub(crate) bool);

/// Whether keys are neither typed into a field of a panel nor into a transform.
pub(crate) fn keyboard_is_free(panel: Res<PanelInput>, tool: Option<Res<ToolKeys>>) -> bool {
    !panel.keyboard && !tool.is_some_and(|tool| tool.0)
}

/// Keys that change what others and the pointer mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Modifiers {
    pub(crate) control: bool,
    pub(crate) shift: bool,
    pub(crate) alt: bool,
}

impl Modifiers {
    pub(crate) fn of(keys: &ButtonInput<KeyCode>) -> Self {
        let command = [KeyCode::ControlLeft, KeyCode::ControlRight, KeyCode::SuperLeft, KeyCode::SuperRight];
        Self {
            control: keys.any_pressed(command),
            shift: keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]),
            alt: keys.any_pressed([KeyCode::AltLeft, KeyCode::AltRight]),
        }
    }
}
