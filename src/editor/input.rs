//! Whose input it is: a panel's or the viewport's.

use std::time::Duration;

use bevy::ecs::system::SystemParam;
use bevy::input::ButtonState;
use bevy::input::keyboard::KeyboardInput;
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

/// When a transform was asked for by its key last: digits after it are a number, also where there was nothing to transform, and turn no
/// view.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct NumberExpected(Option<Duration>);

impl NumberExpected {
    /// A number is typed within this.
    const WITHIN: Duration = Duration::from_secs(2);

    pub(crate) fn expect(&mut self, now: Duration) {
        self.0 = Some(now);
    }

    pub(crate) fn is_near(&self, now: Duration) -> bool {
        self.0.is_some_and(|asked| now.saturating_sub(asked) < Self::WITHIN)
    }
}

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

/// Keys in the order in which they were struck, each with what was held then: in a slow frame that is more than what is held at its end.
#[derive(SystemParam)]
pub(crate) struct StruckKeys<'w, 's> {
    events: MessageReader<'w, 's, KeyboardInput>,
    held: Local<'s, Vec<KeyCode>>,
}

impl StruckKeys<'_, '_> {
    /// What was struck since this was asked last; repeats of a key that is held do not count.
    pub(crate) fn read(&mut self) -> Vec<(KeyCode, Modifiers)> {
        let mut struck = Vec::new();
        for event in self.events.read() {
            self.held.retain(|key| *key != event.key_code);
            if event.state == ButtonState::Released {
                continue;
            }
            if !event.repeat {
                struck.push((event.key_code, Modifiers::among(|key| self.held.contains(&key))));
            }
            self.held.push(event.key_code);
        }
        struck
    }

    /// What is held is forgotten where keys may have been let go unseen.
    pub(crate) fn keep_held(&mut self, keys: &ButtonInput<KeyCode>) {
        self.held.retain(|key| keys.pressed(*key));
    }
}

impl Modifiers {
    pub(crate) fn of(keys: &ButtonInput<KeyCode>) -> Self {
        Self::among(|key| keys.pressed(key))
    }

    fn among(held: impl Fn(KeyCode) -> bool) -> Self {
        let command = [KeyCode::ControlLeft, KeyCode::ControlRight, KeyCode::SuperLeft, KeyCode::SuperRight];
        Self {
            control: command.into_iter().any(&held),
            shift: [KeyCode::ShiftLeft, KeyCode::ShiftRight].into_iter().any(&held),
            alt: [KeyCode::AltLeft, KeyCode::AltRight].into_iter().any(&held),
        }
    }
}
