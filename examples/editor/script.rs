//! The scripted drag: takes a picture, drags an anchor with a simulated mouse, takes another, and checks both.
//!
//! The mouse is simulated where the window system would speak, so that picking, dragging, editing and tracing all take part.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use bevy::ecs::system::SystemParam;
use bevy::input::ButtonState;
use bevy::input::mouse::MouseButtonInput;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::window::{CursorMoved, PrimaryWindow, WindowEvent};
use bevy_surface_splines::editor::marks::{MarkKind, Marks};
use bevy_surface_splines::editor::{Curve, FreeView, Model, ModelRefused, Orbit, Selection, sphere_around};
use bevy_surface_splines::plugin::Picker;
use bevy_surface_splines::prelude::*;

use crate::arguments::Arguments;
use crate::proof::{self, Picture};

/// Frames that panels and camera get to come to rest.
const SETTLE: u32 = 4;
/// Moves from the press to the release.
const MOVES: u8 = 5;
/// How far the anchor is dragged, in pixels: the first of these that stays on the model.
const LENGTHS: [f32; 4] = [80.0, 60.0, 45.0, 34.0];
const DIRECTIONS: u8 = 16;
/// Curves that are smaller than this, of the model's radius, are looked at from nearer.
const SMALL: f32 = 0.45;
/// After this many seconds without an end something is wrong.
const TIME_LIMIT: f32 = 480.0;

/// What is still to be done, and what was seen.
#[derive(Resource, Debug, Default)]
struct Script {
    steps: VecDeque<Step>,
    planned: bool,
    pictures: Vec<Picture>,
    captured: Option<Image>,
    /// Frames that a model has been there without a curve.
    waited: u32,
}

#[derive(Clone, Debug)]
enum Step {
    Wait(u32),
    MoveTo(Vec2),
    Button(ButtonState),
    Photograph(&'static str),
    AwaitPicture(&'static str),
    Judge { from: Vec2, to: Vec2 },
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Script>().add_observer(fail_on_refusal).add_systems(Last, play);
}

/// A model that the caller asked for and that cannot be shown is no success.
fn fail_on_refusal(refused: On<ModelRefused>, arguments: Res<Arguments>, mut exits: MessageWriter<AppExit>) {
    if arguments.script.is_some() {
        eprintln!("editor: {}", refused.reason);
        exits.write(AppExit::error());
    }
}

/// What the script looks at and what it may do.
#[derive(SystemParam)]
struct Stage<'w, 's> {
    commands: Commands<'w, 's>,
    marks: Marks<'w, 's>,
    picker: Picker<'w, 's>,
    surfaces: SurfaceQueries<'w, 's>,
    traces: Query<'w, 's, (&'static SplineTrace, &'static OnSurface)>,
    controls: Query<'w, 's, &'static ControlPoint>,
    models: Query<'w, 's, (), With<Model>>,
    curves: Query<'w, 's, (), With<Curve>>,
    cameras: Query<'w, 's, (Entity, &'static mut Orbit)>,
    windows: Query<'w, 's, Entity, With<PrimaryWindow>>,
    selection: Res<'w, Selection>,
    free: Res<'w, FreeView>,
    events: MessageWriter<'w, WindowEvent>,
}

fn play(
    arguments: Res<Arguments>,
    time: Res<Time<Real>>,
    mut script: ResMut<Script>,
    mut stage: Stage,
    mut exits: MessageWriter<AppExit>,
) {
    let Some(folder) = &arguments.script else { return };
    let result = if time.elapsed_secs() > TIME_LIMIT {
        Err(format!("the scripted drag was not done after {TIME_LIMIT} s"))
    } else {
        script.play(&mut stage, folder)
    };
    match result {
        Ok(Some(outcome)) => {
            println!("{outcome}");
            println!("{}\n{}", picture_path(folder, BEFORE).display(), picture_path(folder, AFTER).display());
            exits.write(AppExit::Success);
        }
        Ok(None) => {}
        Err(reason) => {
            eprintln!("editor: {reason}");
            exits.write(AppExit::error());
        }
    }
}

const BEFORE: &str = "before";
const AFTER: &str = "after";

fn picture_path(folder: &Path, name: &str) -> PathBuf {
    folder.join(name).with_extension("png")
}

impl Script {
    /// Does one step a frame; gives the outcome at the end.
    fn play(&mut self, stage: &mut Stage, folder: &Path) -> Result<Option<String>, String> {
        if !self.planned {
            if stage.is_ready() {
                stage.come_near()?;
                std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
                self.steps.extend([Step::Wait(SETTLE), Step::MoveTo(Vec2::splat(4.0)), Step::Wait(SETTLE)]);
                self.steps.extend([Step::Photograph(BEFORE), Step::AwaitPicture(BEFORE)]);
                self.planned = true;
            } else if !stage.models.is_empty() && stage.curves.is_empty() {
                self.waited += 1;
                if self.waited > SETTLE {
                    return Err("no place on this model faces the first view with room for a curve: try another".into());
                }
            }
            return Ok(None);
        }
        match self.steps.pop_front() {
            Some(Step::Wait(frames)) => {
                if frames > 1 {
                    self.steps.push_front(Step::Wait(frames - 1));
                }
            }
            Some(Step::MoveTo(to)) => stage.move_to(to)?,
            Some(Step::Button(state)) => stage.button(state)?,
            Some(Step::Photograph(name)) => {
                self.pictures.push(Picture { image: None, line: stage.line()? });
                photograph(&mut stage.commands, picture_path(folder, name));
            }
            Some(Step::AwaitPicture(name)) => match self.captured.take() {
                None => self.steps.push_front(Step::AwaitPicture(name)),
                Some(image) => {
                    proof::require_whole_png(&picture_path(folder, name))?;
                    if let Some(picture) = self.pictures.last_mut() {
                        picture.image = Some(image);
                    }
                    if name == BEFORE {
                        let (from, to) = stage.find_drag()?;
                        self.steps.extend(drag_steps(from, to));
                    }
                }
            },
            Some(Step::Judge { from, to }) => return self.judge(from, to).map(Some),
            None => return Err("the script has lost its thread".into()),
        }
        Ok(None)
    }

    fn judge(&self, from: Vec2, to: Vec2) -> Result<String, String> {
        let [before, after] = &self.pictures[..] else { return Err("a picture is missing".into()) };
        let changed = proof::farthest_apart(&before.line, &after.line);
        if changed < 0.3 * from.distance(to) {
            return Err(format!("the curve moved {changed:.0} px only, dragged by {:.0} px", from.distance(to)));
        }
        let [share_before, share_after] = [(before, BEFORE), (after, AFTER)].map(|(picture, name)| {
            proof::share_of_line_found(picture).map_err(|reason| format!("{name}.png: {reason}"))
        });
        Ok(format!(
            "Dragged an anchor by {:.0} px; the curve moved by up to {changed:.0} px and is where its trace is projected: \
             {:.1} % of {} places before, {:.1} % of {} after.",
            from.distance(to),
            100.0 * share_before?,
            before.line.len(),
            100.0 * share_after?,
            after.line.len(),
        ))
    }
}

fn photograph(commands: &mut Commands, path: PathBuf) {
    // The observers of one entity run one after another: when the picture is here, the file is written.
    commands.spawn(Screenshot::primary_window()).observe(save_to_disk(path)).observe(
        |captured: On<ScreenshotCaptured>, mut script: ResMut<Script>| {
            script.captured = Some(captured.image.clone());
        },
    );
}

fn drag_steps(from: Vec2, to: Vec2) -> Vec<Step> {
    let mut steps = vec![Step::MoveTo(from), Step::Wait(1), Step::Button(ButtonState::Pressed)];
    steps.extend((1..=MOVES).map(|i| Step::MoveTo(from.lerp(to, f32::from(i) / f32::from(MOVES)))));
    steps.extend([Step::Wait(1), Step::Button(ButtonState::Released), Step::MoveTo(Vec2::splat(4.0))]);
    steps.extend([Step::Wait(SETTLE), Step::Photograph(AFTER), Step::AwaitPicture(AFTER), Step::Judge { from, to }]);
    steps
}

impl Stage<'_, '_> {
    fn is_ready(&self) -> bool {
        let traced = self.selection.spline().is_some_and(|spline| self.traces.contains(spline));
        traced && self.free.0.is_some() && !self.controls.is_empty()
    }

    fn move_to(&mut self, position: Vec2) -> Result<(), String> {
        let window = self.windows.single().map_err(|error| error.to_string())?;
        self.events.write(WindowEvent::CursorMoved(CursorMoved { window, position, delta: None }));
        Ok(())
    }

    fn button(&mut self, state: ButtonState) -> Result<(), String> {
        let window = self.windows.single().map_err(|error| error.to_string())?;
        let button = MouseButton::Left;
        self.events.write(WindowEvent::MouseButtonInput(MouseButtonInput { button, state, window }));
        Ok(())
    }

    /// Where the curve of the selected spline must be seen now.
    fn line(&self) -> Result<Vec<Vec2>, String> {
        let (model, positions) = self.curve()?;
        Ok(proof::visible_line(&self.marks, model, positions.into_iter(), self.free.0.unwrap_or_default()))
    }

    /// The curve of the selected spline in the world, and the model it lies on.
    fn curve(&self) -> Result<(Entity, Vec<Vec3>), String> {
        let selected = self.selection.spline().and_then(|spline| self.traces.get(spline).ok());
        let (trace, on) = selected.ok_or("there is no curve to look at")?;
        let view = self.surfaces.get(on.0).ok_or("the curve's surface is gone")?;
        Ok((on.0, trace.polyline().iter().map(|p| view.to_world().transform_point3(*p)).collect()))
    }

    /// Goes nearer to a small curve.
    fn come_near(&mut self) -> Result<(), String> {
        let (_, positions) = self.curve()?;
        let Some((centre, radius)) = sphere_around(positions.into_iter()).filter(|(_, radius)| *radius < SMALL) else {
            return Ok(());
        };
        self.cameras.iter_mut().for_each(|(_, mut orbit)| orbit.frame(centre, 2.0 * radius));
        Ok(())
    }

    /// An anchor that can be grabbed where it is seen, and somewhere else on its sheet to drag it to.
    fn find_drag(&self) -> Result<(Vec2, Vec2), String> {
        let free = self.free.0.unwrap_or_default().inflate(-20.0);
        let (camera, _) = self.cameras.single().map_err(|error| error.to_string())?;
        let selected = self.selection.spline().and_then(|spline| Some((spline, self.traces.get(spline).ok()?.1.0)));
        let (spline, model) = selected.ok_or("there is no curve to drag")?;
        let surface = self.surfaces.get(model).ok_or("the curve's surface is gone")?;
        let sheet = |pixel| {
            let hit = self.picker.surface_under(camera, pixel, model)?;
            surface.surface().sheet(hit.point.face).ok()
        };
        let grabs = |mark: &Vec2, anchor: u32| {
            let control = self.picker.control_under(camera, *mark).and_then(|control| self.controls.get(control).ok());
            control.is_some_and(|c| c.spline == spline && c.kind == ControlKind::Anchor(anchor))
        };
        let mut anchors: Vec<(Vec2, f32)> = Vec::new();
        for mark in self.marks.all() {
            if let (true, MarkKind::Corner(anchor) | MarkKind::Smooth(anchor)) = (mark.visible, mark.kind)
                && free.contains(mark.at)
                && grabs(&mark.at, anchor)
            {
                // The second one is liked best: both sides of it change.
                anchors.push((mark.at, if anchor == 1 { 2.0 } else { 1.0 }));
            }
        }
        let line = self.line()?;
        for length in LENGTHS {
            let mut best: Option<(f32, Vec2, Vec2)> = None;
            for (from, liked) in &anchors {
                for direction in 0..DIRECTIONS {
                    let angle = f32::from(direction) / f32::from(DIRECTIONS) * std::f32::consts::TAU;
                    let to = from + length * Vec2::from_angle(angle);
                    let way = [0.0, 0.5, 1.0, 1.3].map(|share| sheet(from.lerp(to, share)));
                    let open = free.contains(to) && way[0].is_some() && way.iter().all(|sheet| *sheet == way[0]);
                    // Away from the curve, where it is seen best.
                    let away = liked * proof::distance_to(to, &line);
                    if open && best.is_none_or(|(other, ..)| away > other) {
                        best = Some((away, *from, to));
                    }
                }
            }
            if let Some((_, from, to)) = best {
                return Ok((from, to));
            }
        }
        Err("no anchor can be seen that has room to be dragged: try another mesh".into())
    }
}
