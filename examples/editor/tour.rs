//! The tour: every tool is used on the bundled model by a simulated mouse and keyboard, and a picture is taken of each.
//!
//! Mouse and keys are simulated where the window system would speak, so that all parts of the editor take part.

use std::collections::VecDeque;
use std::path::PathBuf;

use bevy::ecs::system::SystemParam;
use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput, NativeKey};
use bevy::input::mouse::{MouseButtonInput, MouseScrollUnit, MouseWheel};
use bevy::input::touch::TouchPhase;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::window::{CursorMoved, PrimaryWindow, WindowEvent};
use bevy_surface_splines::editor::{DrawingInHand, EditorAction, FileRequest, FreeView, Selection};
use bevy_surface_splines::prelude::*;

use crate::arguments::Arguments;

/// Frames that follow everything that is done, so that background work and panels come to rest.
const SETTLE: u32 = 4;
/// After this many seconds without an end something is wrong.
const TIME_LIMIT: f32 = 1200.0;

#[derive(Resource, Default)]
struct Tour {
    steps: Option<VecDeque<Step>>,
    /// Frames to wait.
    wait: u32,
    is_taken: bool,
    pictures: u32,
}

#[derive(Clone, Debug)]
enum Step {
    Wait(u32),
    Move(Vec2),
    Button(ButtonState),
    Key(KeyCode, ButtonState),
    Type(&'static str),
    Wheel(f32),
    Act(EditorAction),
    /// Selects the spline of a number.
    Take(usize),
    Open(PathBuf),
    AwaitDrawing,
    Photograph(&'static str),
    AwaitPicture,
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Tour>().add_systems(Last, play);
}

#[derive(SystemParam)]
struct Hands<'w, 's> {
    commands: Commands<'w, 's>,
    windows: Query<'w, 's, (Entity, &'static mut Window), With<PrimaryWindow>>,
    events: MessageWriter<'w, WindowEvent>,
    moves: MessageWriter<'w, CursorMoved>,
    buttons: MessageWriter<'w, MouseButtonInput>,
    keys: MessageWriter<'w, KeyboardInput>,
    wheels: MessageWriter<'w, MouseWheel>,
    actions: MessageWriter<'w, EditorAction>,
    files: MessageWriter<'w, FileRequest>,
    traces: Query<'w, 's, (Entity, &'static bevy_surface_splines::editor::Curve), With<SplineTrace>>,
    selection: ResMut<'w, Selection>,
    hand: Res<'w, DrawingInHand>,
    free: Res<'w, FreeView>,
}

fn play(
    arguments: Res<Arguments>,
    time: Res<Time<Real>>,
    mut tour: ResMut<Tour>,
    mut hands: Hands,
    mut exits: MessageWriter<AppExit>,
) {
    let Some(folder) = &arguments.tour else { return };
    if time.elapsed_secs() > TIME_LIMIT {
        eprintln!("editor: the tour was not done after {TIME_LIMIT} s");
        exits.write(AppExit::error());
        return;
    }
    if tour.steps.is_none() {
        if hands.traces.iter().count() < 3 || hands.free.0.is_none() {
            return;
        }
        if let Err(error) = std::fs::create_dir_all(folder) {
            eprintln!("editor: {}: {error}", folder.display());
            exits.write(AppExit::error());
        }
        tour.steps = Some(all_steps());
    }
    if tour.wait > 0 {
        tour.wait -= 1;
        return;
    }
    let Some(step) = tour.steps.as_mut().and_then(VecDeque::pop_front) else {
        println!("{} pictures in {}", tour.pictures, folder.display());
        exits.write(AppExit::Success);
        return;
    };
    match step {
        Step::Photograph(name) => {
            hands.photograph(folder.join(name).with_extension("png"));
            tour.pictures += 1;
        }
        Step::AwaitPicture if !std::mem::take(&mut tour.is_taken) => put_back(&mut tour, Step::AwaitPicture),
        Step::AwaitDrawing if hands.hand.name().is_none() => put_back(&mut tour, Step::AwaitDrawing),
        Step::AwaitPicture | Step::AwaitDrawing => {}
        Step::Wait(frames) => tour.wait = frames,
        step => hands.perform(step),
    }
}

fn put_back(tour: &mut Tour, step: Step) {
    if let Some(steps) = &mut tour.steps {
        steps.push_front(step);
    }
}

impl Hands<'_, '_> {
    fn photograph(&mut self, path: PathBuf) {
        self.commands
            .spawn(Screenshot::primary_window())
            .observe(save_to_disk(path))
            .observe(|_: On<ScreenshotCaptured>, mut tour: ResMut<Tour>| tour.is_taken = true);
    }

    fn perform(&mut self, step: Step) {
        let Ok((window, mut state)) = self.windows.single_mut() else { return };
        match step {
            Step::Move(position) => {
                let delta = state.cursor_position().map(|before| position - before);
                state.set_cursor_position(Some(position));
                let moved = CursorMoved { window, position, delta };
                self.moves.write(moved.clone());
                self.events.write(WindowEvent::CursorMoved(moved));
            }
            Step::Button(state) => {
                let pressed = MouseButtonInput { button: MouseButton::Left, state, window };
                self.buttons.write(pressed);
                self.events.write(WindowEvent::MouseButtonInput(pressed));
            }
            Step::Wheel(y) => {
                let (unit, phase) = (MouseScrollUnit::Line, TouchPhase::Moved);
                let turned = MouseWheel { unit, x: 0.0, y, window, phase };
                self.wheels.write(turned);
                self.events.write(WindowEvent::MouseWheel(turned));
            }
            Step::Key(key_code, state) => {
                let logical_key = Key::Unidentified(NativeKey::Unidentified);
                self.strike(KeyboardInput { key_code, logical_key, state, text: None, repeat: false, window });
            }
            Step::Type(text) => {
                for state in [ButtonState::Pressed, ButtonState::Released] {
                    let (logical_key, written) = (Key::Character(text.into()), Some(text.into()));
                    let key_code = KeyCode::F24;
                    self.strike(KeyboardInput { key_code, logical_key, state, text: written, repeat: false, window });
                }
            }
            Step::Act(action) => drop(self.actions.write(action)),
            Step::Open(path) => drop(self.files.write(FileRequest::Open(path))),
            Step::Take(number) => {
                let mut curves: Vec<_> = self.traces.iter().collect();
                curves.sort_by_key(|(_, curve)| curve.number);
                if let Some((entity, _)) = curves.get(number) {
                    self.selection.select(*entity);
                }
            }
            _ => {}
        }
    }

    fn strike(&mut self, input: KeyboardInput) {
        self.keys.write(input.clone());
        self.events.write(WindowEvent::KeyboardInput(input));
    }
}

fn at(x: f32, y: f32) -> Vec2 {
    Vec2::new(x, y)
}

fn strike(key: KeyCode) -> Vec<Step> {
    vec![Step::Key(key, ButtonState::Pressed), Step::Key(key, ButtonState::Released), Step::Wait(1)]
}

/// Comes from a pixel aside, so that the pointer has moved to the place before the button goes down.
fn press(from: Vec2) -> Vec<Step> {
    vec![Step::Move(from - Vec2::X), Step::Wait(2), Step::Move(from), Step::Wait(2), Step::Button(ButtonState::Pressed)]
}

fn way(places: &[Vec2]) -> Vec<Step> {
    places.iter().map(|place| Step::Move(*place)).collect()
}

fn release() -> Vec<Step> {
    vec![Step::Button(ButtonState::Released), Step::Wait(SETTLE)]
}

fn click(place: Vec2) -> Vec<Step> {
    [press(place), release()].concat()
}

fn picture(name: &'static str) -> Vec<Step> {
    vec![Step::Wait(SETTLE), Step::Photograph(name), Step::AwaitPicture]
}

/// What is done, in pixels of the tour's window, which is 960 × 600.
fn all_steps() -> VecDeque<Step> {
    let away = at(330.0, 560.0);
    let wave: Vec<Vec2> =
        (0..=24u8).map(|i| at(190.0 + 12.0 * f32::from(i), 410.0 + 22.0 * (f32::from(i) * 0.5).sin())).collect();
    let leaf = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/leaf.svg"));
    let steps = [
        vec![Step::Wait(SETTLE), Step::Move(away)],
        // Select: a box over the wave.
        press(at(130.0, 290.0)),
        way(&[at(200.0, 320.0), at(320.0, 400.0), at(415.0, 405.0)]),
        picture("select"),
        release(),
        // Move, turn, scale: the selected anchors by what is typed.
        vec![Step::Move(at(300.0, 330.0)), Step::Wait(2)],
        strike(KeyCode::KeyR),
        vec![Step::Wait(2)],
        strike(KeyCode::Digit2),
        strike(KeyCode::Digit0),
        picture("turn"),
        strike(KeyCode::Escape),
        vec![Step::Wait(SETTLE)],
        strike(KeyCode::KeyS),
        vec![Step::Wait(2)],
        strike(KeyCode::Digit2),
        picture("scale"),
        strike(KeyCode::Escape),
        vec![Step::Wait(SETTLE)],
        strike(KeyCode::KeyG),
        vec![Step::Move(at(310.0, 325.0)), Step::Move(at(330.0, 310.0)), Step::Move(at(350.0, 290.0))],
        picture("move"),
        strike(KeyCode::Escape),
        vec![Step::Wait(SETTLE), Step::Act(EditorAction::Take(bevy_surface_splines::editor::Tool::Select))],
        // Pen: three anchors, the last with its handles pulled out.
        vec![Step::Act(EditorAction::BeginSpline), Step::Wait(2)],
        click(at(230.0, 240.0)),
        click(at(200.0, 290.0)),
        press(at(290.0, 400.0)),
        way(&[at(300.0, 405.0), at(330.0, 415.0), at(350.0, 425.0)]),
        picture("pen"),
        release(),
        strike(KeyCode::Enter),
        // Freehand.
        strike(KeyCode::KeyN),
        press(wave[0]),
        way(&wave[1..]),
        picture("freehand"),
        release(),
        vec![Step::Wait(20)],
        // Insert: where a click would add an anchor to the wave.
        vec![Step::Take(0)],
        strike(KeyCode::KeyI),
        vec![Step::Wait(SETTLE), Step::Move(at(300.0, 400.0)), Step::Move(at(301.0, 400.0))],
        picture("insert"),
        strike(KeyCode::Escape),
        // Join kinds.
        vec![Step::Take(2), Step::Wait(SETTLE)],
        strike(KeyCode::KeyC),
        click(at(254.0, 197.0)),
        vec![Step::Move(away)],
        picture("join"),
        strike(KeyCode::Escape),
        // A drawing under the pointer, and placed.
        vec![
            Step::Open(leaf),
            Step::AwaitDrawing,
            Step::Move(at(270.0, 250.0)),
            Step::Move(at(220.0, 215.0)),
            Step::Wait(2),
        ],
        vec![Step::Wheel(-3.0), Step::Wait(2)],
        picture("drawing"),
        click(at(220.0, 215.0)),
        vec![Step::Wait(30), Step::Act(EditorAction::Take(bevy_surface_splines::editor::Tool::Select))],
        vec![Step::Move(away)],
        picture("placed"),
        // Brush: the wave by hand, as a line, is smoothed in its middle.
        vec![Step::Take(4), Step::Wait(2), Step::Act(EditorAction::ToLines), Step::Wait(30)],
        strike(KeyCode::KeyB),
        press(wave[6]),
        way(&wave[6..16]),
        way(&wave[6..16]),
        picture("brush"),
        release(),
        vec![Step::Act(EditorAction::Take(bevy_surface_splines::editor::Tool::Select))],
        // The tabs: properties, numbers, history.
        vec![Step::Take(0), Step::Wait(2)],
        click(at(793.0, 21.0)),
        picture("properties"),
        click(at(869.0, 21.0)),
        vec![Step::Wait(30)],
        picture("numbers"),
        click(at(731.0, 47.0)),
        picture("history"),
        click(at(728.0, 21.0)),
        vec![Step::Move(away)],
        // Help, searched.
        strike(KeyCode::F1),
        vec![Step::Wait(2), Step::Type("undo"), Step::Wait(2)],
        picture("help"),
        strike(KeyCode::Escape),
    ];
    steps.into_iter().flatten().collect()
}
