//! Placing a drawing: it follows the pointer over the model until a click leaves it there.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::ecs::system::SystemParam;
use bevy::input::mouse::{AccumulatedMouseScroll, MouseScrollUnit};
use bevy::prelude::*;
use bevy::tasks::{Task, block_on, futures_lite::future};
use glam::DVec3;

use super::{PointerEvent, TakesWheel, Tool, ToolPointer};
use crate::editor::curves::{self, NextNumber};
use crate::editor::documents::spawn;
use crate::editor::history::History;
use crate::editor::input::{Modifiers, PanelInput};
use crate::editor::notices::Notices;
use crate::editor::selection::Selection;
use crate::geodesic::PathFinder;
use crate::placement::{DrawingOutline, PlaceOptions, PlacedDrawing, Placement, PlacementPreview, place_drawing};
use crate::plugin::BuiltSurface;
use crate::surface::{Surface, SurfacePoint};
use crate::vector::{Drawing, Paint};
use crate::vector::{SvgImport, read_svg};

/// So many points of a drawing follow the pointer; the rest appears when it is placed.
const PREVIEW_POINTS: usize = 4_000;
/// A new drawing is as large as this share of the model's diagonal.
const FIRST_SIZE: f64 = 0.25;
/// How much larger one notch of the wheel makes it, and by how much it turns, in radians.
const NOTCH: f64 = 1.1;
const TURN: f64 = std::f64::consts::PI / 24.0;

/// Asks for a drawing to be taken in hand.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct TakeDrawing(pub PathBuf);

/// The drawing in hand.
#[derive(Resource, Default)]
pub struct DrawingInHand {
    reading: Option<Task<Result<Taken, String>>>,
    taken: Option<Taken>,
    /// How long one of its units is, and by how much it is turned.
    scale: f64,
    turn: f64,
    placement: Option<(Entity, Placement)>,
    /// Where it lay when it was pressed: a drag from there turns and scales it.
    pull: Option<(Entity, Placement)>,
    preview: PlacementPreview,
    placing: Option<Placing>,
}

#[derive(Clone, Debug)]
struct Taken {
    name: String,
    drawing: Arc<Drawing>,
    outline: Arc<DrawingOutline>,
    /// The longer side of what is drawn, in its units.
    size: f64,
}

struct Placing {
    task: Task<Result<PlacedDrawing, String>>,
    on: Entity,
    drawing: Arc<Drawing>,
    name: String,
}

impl DrawingInHand {
    /// Its name; none if there is none.
    pub fn name(&self) -> Option<&str> {
        self.taken.as_ref().map(|taken| taken.name.as_str())
    }

    /// Stops what is being read or placed.
    pub(crate) fn cancel(&mut self) {
        (self.reading, self.placing) = (None, None);
    }

    /// Whether a drawing is being read or placed.
    pub fn is_busy(&self) -> bool {
        self.reading.is_some() || self.placing.is_some()
    }

    /// Where it lies, in local space of the model's surface; none off the model.
    pub fn preview(&self) -> Option<(Entity, impl Iterator<Item = &[DVec3]>)> {
        let (on, _) = self.placement?;
        self.taken.is_some().then(|| (on, self.preview.polylines()))
    }
}

/// What placing works with.
#[derive(SystemParam)]
pub(crate) struct Desk<'w, 's> {
    commands: Commands<'w, 's>,
    finder: Local<'s, PathFinder>,
    hand: ResMut<'w, DrawingInHand>,
    tool: ResMut<'w, Tool>,
    takes_wheel: ResMut<'w, TakesWheel>,
    next: ResMut<'w, NextNumber>,
    selection: ResMut<'w, Selection>,
    notices: ResMut<'w, Notices>,
    history: ResMut<'w, History>,
    surfaces: Query<'w, 's, (&'static BuiltSurface, &'static GlobalTransform)>,
    cameras: Query<'w, 's, &'static GlobalTransform, With<Camera>>,
}

pub(crate) fn place(
    mut asked: MessageReader<TakeDrawing>,
    pointer: Res<ToolPointer>,
    scroll: Res<AccumulatedMouseScroll>,
    (keys, panel): (Res<ButtonInput<KeyCode>>, Res<PanelInput>),
    mut desk: Desk,
) {
    // Of several the last.
    if let Some(TakeDrawing(path)) = asked.read().last().cloned() {
        desk.hand.reading = Some(spawn(move || read(&path)));
    }
    desk.collect_read();
    desk.collect_placed();
    let takes_wheel = *desk.tool == Tool::Drawing && desk.hand.taken.is_some();
    desk.takes_wheel.set_if_neq(TakesWheel(takes_wheel));
    if !takes_wheel {
        if desk.hand.placement.is_some() {
            (desk.hand.placement, desk.hand.pull) = (None, None);
        }
        return;
    }
    let lines = if scroll.unit == MouseScrollUnit::Line { 1.0 } else { 0.02 };
    // Shift makes some systems scroll sideways.
    let notches = f64::from((scroll.delta.x + scroll.delta.y) * lines);
    if notches != 0.0 && !panel.pointer {
        if Modifiers::of(&keys).shift {
            desk.hand.turn += TURN * notches;
        } else {
            desk.hand.scale *= NOTCH.powf(notches.clamp(-20.0, 20.0));
        }
    }
    let hover = pointer.hover.and_then(|hover| Some((hover.camera, hover.surface?)));
    match hover {
        _ if desk.hand.pull.is_some() => {}
        Some((camera, (on, at))) => desk.follow(camera, on, at),
        None => desk.hand.placement = None,
    }
    for event in &pointer.events {
        match event {
            PointerEvent::DragStart { from } => {
                // From where it was pressed: the pointer has left the dead zone since.
                if let Some((on, at)) = from.surface {
                    desk.follow(from.camera, on, at);
                }
                desk.hand.pull = desk.hand.placement;
            }
            PointerEvent::Drag { to, .. } => desk.pull(to.surface),
            PointerEvent::DragEnd { .. } if desk.hand.pull.take().is_some() => desk.leave(),
            PointerEvent::Click { .. } => desk.leave(),
            PointerEvent::Cancel => desk.hand.pull = None,
            _ => {}
        }
    }
}

fn read(path: &Path) -> Result<Taken, String> {
    let SvgImport { drawing, report } = read_svg(path).map_err(|error| error.to_string())?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let bounds = drawing.bounds().filter(|_| report.drawn.total() > 0);
    let Some((min, max)) = bounds else {
        return Err(format!("{name} has no path that could be drawn: open one with paths or shapes"));
    };
    let outline = Arc::new(DrawingOutline::new(&drawing, PREVIEW_POINTS));
    Ok(Taken { name, drawing: Arc::new(drawing), outline, size: (max - min).max_element().max(1e-12) })
}

impl Desk<'_, '_> {
    fn collect_read(&mut self) {
        let Some(result) = self.hand.reading.as_mut().and_then(|task| block_on(future::poll_once(task))) else {
            return;
        };
        self.hand.reading = None;
        match result {
            Ok(taken) => {
                (self.hand.scale, self.hand.turn) = (0.0, 0.0);
                self.notices.info(format!("{}: click on the model where it is to lie", taken.name));
                self.hand.taken = Some(taken);
                *self.tool = Tool::Drawing;
            }
            Err(reason) => self.notices.error(reason),
        }
    }

    /// The drawing lies under the pointer, upright on the screen.
    fn follow(&mut self, camera: Entity, on: Entity, at: SurfacePoint) {
        let Ok((surface, place)) = self.surfaces.get(on) else { return };
        let Ok(camera) = self.cameras.get(camera) else { return };
        let Some(taken) = self.hand.taken.clone() else { return };
        let to_local = place.affine().inverse();
        let local = |way: Dir3| to_local.transform_vector3(way.as_vec3()).as_dvec3();
        let leans = |up: &DVec3| surface.tangent(&at, *up).is_ok_and(|tangent| tangent.length() > 1e-2);
        // Where the model faces upwards, away from the eye is up.
        let Some(up) = [local(camera.up()), local(camera.forward())].into_iter().find(leans) else { return };
        if self.hand.scale <= 0.0 || !self.hand.scale.is_finite() {
            self.hand.scale = FIRST_SIZE * surface.diagonal() / taken.size;
        }
        let placement = Placement { at, up, scale: self.hand.scale }.turned(surface, self.hand.turn);
        let Ok(placement) = placement else { return };
        let hand = &mut *self.hand;
        if hand.placement != Some((on, placement)) {
            let shown = hand.preview.update(surface, &taken.outline, &placement);
            hand.placement = shown.is_ok().then_some((on, placement));
        }
    }

    /// A drag from its middle turns and scales the drawing: the middle of its upper edge follows the pointer.
    fn pull(&mut self, to: Option<(Entity, SurfacePoint)>) {
        let (Some((on, from)), Some(taken)) = (self.hand.pull, self.hand.taken.clone()) else { return };
        let Some((_, to)) = to.filter(|(under, _)| *under == on) else { return };
        let Ok((surface, _)) = self.surfaces.get(on) else { return };
        let pulled = from.pulled(surface, &mut self.finder, &to, 0.5 * taken.size);
        let Ok(placement) = pulled else { return };
        let hand = &mut *self.hand;
        if hand.preview.update(surface, &taken.outline, &placement).is_ok() {
            hand.placement = Some((on, placement));
        }
    }

    /// Leaves the drawing where it is.
    fn leave(&mut self) {
        let Some((on, placement)) = self.hand.placement else {
            self.notices.info("Click on the model: the drawing lies where the pointer is.");
            return;
        };
        let (Some(taken), Ok((surface, _))) = (self.hand.taken.clone(), self.surfaces.get(on)) else { return };
        if self.hand.placing.is_some() {
            return;
        }
        let (surface, drawing) = (surface.0.clone(), taken.drawing.clone());
        let task = spawn(move || place_on(&surface, &drawing, &placement));
        self.hand.placing = Some(Placing { task, on, drawing: taken.drawing, name: taken.name });
    }

    fn collect_placed(&mut self) {
        let Some(placing) = &mut self.hand.placing else { return };
        let Some(result) = block_on(future::poll_once(&mut placing.task)) else { return };
        let Some(Placing { on, drawing, name, .. }) = self.hand.placing.take() else { return };
        if !self.surfaces.contains(on) {
            return;
        }
        match result {
            Ok(placed) => self.add(on, &drawing, &name, placed),
            Err(reason) => self.notices.error(format!("{name} cannot be placed here: {reason}")),
        }
    }

    fn add(&mut self, on: Entity, drawing: &Drawing, name: &str, placed: PlacedDrawing) {
        let dropped = placed.dropped();
        let count = placed.splines.len();
        self.history.begin(format!("Place {name}"));
        self.selection.clear();
        for (index, one) in (1..).zip(placed.splines) {
            let shape = drawing.shapes.get(one.shape as usize);
            let called = shape.and_then(|shape| shape.id.clone()).unwrap_or_else(|| format!("{name} {index}"));
            let mut curve = self.next.curve(Some(&called));
            if let Some(color) = shape.and_then(|shape| color_of(&shape.style)) {
                curve.color = color;
            }
            let entity = curves::spawn(&mut self.commands, on, curve, one.spline);
            self.history.note_added("Add spline", entity);
            self.selection.add(entity);
        }
        self.history.end();
        if dropped > 0 {
            self.notices.warn(format!("{name}: {count} curves are placed, {dropped} paths are not: they fall off the model, or nothing of them is seen."));
        } else {
            self.notices.info(format!("{name}: {count} curves are placed"));
        }
    }
}

fn place_on(surface: &Surface, drawing: &Drawing, placement: &Placement) -> Result<PlacedDrawing, String> {
    place_drawing(surface, drawing, placement, &PlaceOptions::default()).map_err(|error| error.to_string())
}

/// What a curve of a shape looks like: its stroke, or else its fill.
fn color_of(style: &crate::vector::Style) -> Option<Color> {
    let paints = [style.stroke.as_ref().map(|stroke| &stroke.paint), style.fill.as_ref()];
    paints.into_iter().flatten().find_map(|paint| match paint {
        Paint::Color(color) => Some(Color::srgb(color.red, color.green, color.blue)),
        _ => None,
    })
}
