//! A hand on mouse and keyboard: what it does arrives where the window system would speak, so that every part of an app takes part.

use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::input::mouse::{MouseButtonInput, MouseScrollUnit, MouseWheel};
use bevy::input::touch::TouchPhase;
use bevy::prelude::*;
use bevy::window::{CursorMoved, PrimaryWindow, WindowEvent};

/// Moves the mouse and strikes keys of the primary window; every call updates the app once.
///
/// Unlike [`PointerScript`](super::PointerScript), which speaks to picking alone, it is heard by everything that reads input.
#[derive(Clone, Debug)]
pub struct Hand {
    window: Entity,
    at: Vec2,
}

impl Hand {
    /// A hand on the primary window; none without a window.
    pub fn new(app: &mut App) -> Option<Self> {
        let world = app.world_mut();
        let window = world.query_filtered::<Entity, With<PrimaryWindow>>().single(world).ok()?;
        Some(Self { window, at: Vec2::ZERO })
    }

    /// Where the mouse is, in logical pixels of the window.
    pub fn position(&self) -> Vec2 {
        self.at
    }

    /// Moves the mouse.
    pub fn move_to(&mut self, app: &mut App, to: Vec2) {
        let moved = CursorMoved { window: self.window, position: to, delta: Some(to - self.at) };
        self.at = to;
        let world = app.world_mut();
        if let Some(mut window) = world.get_mut::<Window>(self.window) {
            window.set_cursor_position(Some(to));
        }
        world.write_message(moved.clone());
        world.write_message(WindowEvent::CursorMoved(moved));
        app.update();
    }

    /// Presses a mouse button.
    pub fn press(&self, app: &mut App, button: MouseButton) {
        self.button(app, button, ButtonState::Pressed);
    }

    /// Lets a mouse button go.
    pub fn release(&self, app: &mut App, button: MouseButton) {
        self.button(app, button, ButtonState::Released);
    }

    /// Clicks with the left button.
    pub fn click(&mut self, app: &mut App, at: Vec2) {
        self.move_to(app, at);
        self.press(app, MouseButton::Left);
        self.release(app, MouseButton::Left);
    }

    /// Drags with the left button through several places.
    pub fn drag(&mut self, app: &mut App, places: impl IntoIterator<Item = Vec2>) {
        for (index, place) in places.into_iter().enumerate() {
            self.move_to(app, place);
            if index == 0 {
                self.press(app, MouseButton::Left);
            }
        }
        self.release(app, MouseButton::Left);
    }

    /// Turns the wheel.
    pub fn wheel(&self, app: &mut App, notches: f32) {
        let unit = MouseScrollUnit::Line;
        let turned = MouseWheel { unit, x: 0.0, y: notches, window: self.window, phase: TouchPhase::Moved };
        app.world_mut().write_message(turned);
        app.world_mut().write_message(WindowEvent::MouseWheel(turned));
        app.update();
    }

    /// Holds a key down.
    pub fn hold(&self, app: &mut App, key: KeyCode) {
        self.key(app, key, ButtonState::Pressed);
    }

    /// Lets a key go.
    pub fn let_go(&self, app: &mut App, key: KeyCode) {
        self.key(app, key, ButtonState::Released);
    }

    /// Strikes a key: one update with it down, one with it up.
    pub fn strike(&self, app: &mut App, key: KeyCode) {
        self.hold(app, key);
        self.let_go(app, key);
    }

    /// Strikes a key while others are held.
    pub fn strike_with(&self, app: &mut App, held: &[KeyCode], key: KeyCode) {
        held.iter().for_each(|other| self.hold(app, *other));
        self.strike(app, key);
        held.iter().for_each(|other| self.let_go(app, *other));
    }

    /// Types a character.
    pub fn write(&self, app: &mut App, character: char) {
        let (logical_key, text) = (Key::Character(character.to_string().into()), Some(character.to_string().into()));
        for state in [ButtonState::Pressed, ButtonState::Released] {
            let key_code = code_of(character);
            let (logical_key, text) = (logical_key.clone(), text.clone());
            self.send_key(
                app,
                KeyboardInput { key_code, logical_key, state, text, repeat: false, window: self.window },
            );
        }
    }

    fn button(&self, app: &mut App, button: MouseButton, state: ButtonState) {
        let pressed = MouseButtonInput { button, state, window: self.window };
        app.world_mut().write_message(pressed);
        app.world_mut().write_message(WindowEvent::MouseButtonInput(pressed));
        app.update();
    }

    fn key(&self, app: &mut App, key_code: KeyCode, state: ButtonState) {
        let logical_key = match key_code {
            KeyCode::Escape => Key::Escape,
            KeyCode::Enter => Key::Enter,
            KeyCode::Tab => Key::Tab,
            KeyCode::ControlLeft => Key::Control,
            KeyCode::ShiftLeft => Key::Shift,
            KeyCode::AltLeft => Key::Alt,
            KeyCode::Delete => Key::Delete,
            KeyCode::Backspace => Key::Backspace,
            _ => Key::Unidentified(bevy::input::keyboard::NativeKey::Unidentified),
        };
        self.send_key(
            app,
            KeyboardInput { key_code, logical_key, state, text: None, repeat: false, window: self.window },
        );
    }

    fn send_key(&self, app: &mut App, input: KeyboardInput) {
        app.world_mut().write_message(input.clone());
        app.world_mut().write_message(WindowEvent::KeyboardInput(input));
        app.update();
    }
}

/// The key that a digit, sign or letter is on.
fn code_of(character: char) -> KeyCode {
    match character {
        '0' => KeyCode::Digit0,
        '1' => KeyCode::Digit1,
        '2' => KeyCode::Digit2,
        '3' => KeyCode::Digit3,
        '4' => KeyCode::Digit4,
        '5' => KeyCode::Digit5,
        '6' => KeyCode::Digit6,
        '7' => KeyCode::Digit7,
        '8' => KeyCode::Digit8,
        '9' => KeyCode::Digit9,
        '.' => KeyCode::Period,
        '-' => KeyCode::Minus,
        _ => KeyCode::F24,
    }
}
