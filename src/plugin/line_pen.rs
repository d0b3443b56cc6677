//! Lines drawn freehand: the pointer is dragged over a surface, and a line follows it.

use std::collections::HashMap;

use bevy::log::warn;
use bevy::picking::events::{Drag, DragEnd, DragStart, Pointer};
use bevy::picking::pointer::{PointerAction, PointerButton, PointerId, PointerInput};
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::line::{LineSmoothing, SurfaceLine};
use super::pick::{Picker, SurfaceHit};
use super::surface::{BuiltSurface, OnSurface};
use crate::curve::DrawnLine;
use crate::geodesic::PathFinder;
use crate::smooth::SurfacePolyline;

/// Makes a surface something to draw on: while it is there, dragging the pointer over the surface draws a [`SurfaceLine`].
///
/// The line is there from the beginning, as it is drawn, and is smoothed when it is finished.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct LinePen {
    /// What finished lines get; none: they stay as drawn.
    pub smoothing: Option<LineSmoothing>,
    /// Points nearer to the one before than this (local units) are left out; none: the larger of half a mean edge and of three
    /// pixels.
    pub step: Option<f64>,
    /// A line that ends within so many logical pixels of its start is closed; 0: none is.
    pub close_within: f32,
    /// The button that draws.
    pub button: PointerButton,
}

impl Default for LinePen {
    fn default() -> Self {
        Self {
            smoothing: Some(LineSmoothing::default()),
            step: None,
            close_within: 12.0,
            button: PointerButton::Primary,
        }
    }
}

/// Happens when a line was drawn to its end.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct LineDrawn {
    /// The line.
    pub entity: Entity,
    /// What it was drawn on.
    pub surface: Entity,
}

/// Draws lines on surfaces with a [`LinePen`].
///
/// Schedule: observers of picking's drags; `PreUpdate`, set [`SurfaceSplineSystems::Drag`]; `PostUpdate`, set [`SurfaceSplineSystems::Resolve`]. Needs
/// [`PickPlugin`](super::PickPlugin) and Bevy's picking plugins; without those nothing is drawn.
#[derive(Debug, Default)]
pub struct LinePenPlugin;

impl Plugin for LinePenPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_type::<LinePen>()
            .init_resource::<super::SplinePickingSettings>()
            .init_resource::<Strokes>()
            .add_observer(begin)
            .add_observer(go_on)
            .add_observer(end)
            .add_message::<PointerInput>()
            .add_systems(PreUpdate, cancel.in_set(SurfaceSplineSystems::Drag))
            .add_systems(PostUpdate, show_strokes.in_set(SurfaceSplineSystems::Resolve));
    }
}

/// Lines that are being drawn.
#[derive(Resource, Default)]
struct Strokes {
    of: HashMap<PointerId, Stroke>,
    finder: PathFinder,
}

struct Stroke {
    surface: Entity,
    camera: Entity,
    button: PointerButton,
    start: Vec2,
    drawn: DrawnLine,
    /// The line, once there are two points.
    line: Option<Entity>,
    /// Points that it has.
    shown: usize,
}

fn begin(
    event: On<Pointer<DragStart>>,
    mut strokes: ResMut<Strokes>,
    pens: Query<(&LinePen, &BuiltSurface)>,
    picker: Picker,
) {
    let surface = event.entity;
    let Ok((pen, built)) = pens.get(surface) else { return };
    let Some(hit) = event.hit.extra_as::<SurfaceHit>() else { return };
    if event.button != pen.button || event.original_event_target() != surface {
        return;
    }
    let camera = event.hit.camera;
    let start = event.pointer_location.position;
    let step = pen.step.unwrap_or_else(|| {
        let half_edge = 0.5 * built.mean_edge_length(hit.point.face).unwrap_or(0.0);
        let beside = picker.surface_under(camera, start + Vec2::new(3.0, 0.0), surface);
        let across = beside.map_or(0.0, |beside| built.position(&beside.point).distance(built.position(&hit.point)));
        half_edge.max(across)
    });
    let mut drawn = DrawnLine::new(step);
    let Strokes { of, finder } = &mut *strokes;
    if drawn.push(built, finder, hit.point).is_ok() {
        let stroke = Stroke { surface, camera, button: pen.button, start, drawn, line: None, shown: 0 };
        of.insert(event.pointer_id, stroke);
    }
}

fn go_on(event: On<Pointer<Drag>>, mut strokes: ResMut<Strokes>, surfaces: Query<&BuiltSurface>, picker: Picker) {
    let Strokes { of, finder } = &mut *strokes;
    let Some(stroke) = of.get_mut(&event.pointer_id).filter(|stroke| stroke.is_of(event.entity, event.button)) else {
        return;
    };
    stroke.push(event.pointer_location.position, &surfaces, finder, &picker);
}

fn end(
    event: On<Pointer<DragEnd>>,
    mut commands: Commands,
    mut strokes: ResMut<Strokes>,
    pens: Query<&LinePen>,
    surfaces: Query<&BuiltSurface>,
    picker: Picker,
) {
    let Strokes { of, finder } = &mut *strokes;
    if !of.get(&event.pointer_id).is_some_and(|stroke| stroke.is_of(event.entity, event.button)) {
        return;
    }
    let Some(mut stroke) = of.remove(&event.pointer_id) else { return };
    let (at, surface) = (event.pointer_location.position, stroke.surface);
    stroke.push(at, &surfaces, finder, &picker);
    let (Ok(built), Ok(pen)) = (surfaces.get(surface), pens.get(surface)) else {
        return stroke.forget(&mut commands);
    };
    let mut ended = stroke.drawn.end(built, finder);
    if at.distance(stroke.start) <= pen.close_within && stroke.drawn.points().len() > 3 {
        ended = ended.and_then(|()| stroke.drawn.close(built, finder));
    }
    let drawn = ended.map_err(Into::into).and_then(|()| SurfacePolyline::drawn(built, &stroke.drawn));
    match drawn {
        Ok(line) => {
            let entity = stroke.line.unwrap_or_else(|| commands.spawn(OnSurface(surface)).id());
            commands.entity(entity).try_insert(SurfaceLine::new(line));
            if let Some(smoothing) = pen.smoothing {
                commands.entity(entity).try_insert(smoothing);
            }
            commands.trigger(LineDrawn { entity, surface });
        }
        Err(error) => {
            warn!("nothing was drawn on {surface}: {error}");
            stroke.forget(&mut commands);
        }
    }
}

/// A pointer that is cancelled draws nothing; picking says so only to what it hovers over.
fn cancel(mut commands: Commands, mut strokes: ResMut<Strokes>, mut inputs: MessageReader<PointerInput>) {
    for input in inputs.read().filter(|input| matches!(input.action, PointerAction::Cancel)) {
        if let Some(stroke) = strokes.of.remove(&input.pointer_id) {
            stroke.forget(&mut commands);
        }
    }
}

/// Shows lines as far as they are drawn.
fn show_strokes(mut commands: Commands, mut strokes: ResMut<Strokes>, surfaces: Query<&BuiltSurface>) {
    if strokes.of.is_empty() {
        return;
    }
    strokes.of.retain(|_, stroke| surfaces.contains(stroke.surface));
    for stroke in strokes.of.values_mut() {
        let count = stroke.drawn.points().len();
        let Ok(built) = surfaces.get(stroke.surface) else { continue };
        if count < 2 || count == stroke.shown {
            continue;
        }
        if let Ok(line) = SurfacePolyline::drawn(built, &stroke.drawn) {
            let entity = *stroke.line.get_or_insert_with(|| commands.spawn(OnSurface(stroke.surface)).id());
            commands.entity(entity).try_insert(SurfaceLine::new(line));
            stroke.shown = count;
        }
    }
}

impl Stroke {
    fn is_of(&self, surface: Entity, button: PointerButton) -> bool {
        self.surface == surface && self.button == button
    }

    /// Goes on to a pixel; beside the surface nothing is drawn.
    fn push(&mut self, pixel: Vec2, surfaces: &Query<&BuiltSurface>, finder: &mut PathFinder, picker: &Picker) {
        let Ok(built) = surfaces.get(self.surface) else { return };
        if let Some(hit) = picker.surface_under(self.camera, pixel, self.surface) {
            // What lies on another piece of the surface cannot be joined, and is left out.
            let _ = self.drawn.push(built, finder, hit.point);
        }
    }

    fn forget(&self, commands: &mut Commands) {
        if let Some(line) = self.line {
            commands.entity(line).try_despawn();
        }
    }
}
