//! What the primary pointer does, in the words of tools: presses, drags and clicks, each with what it is on.
//!
//! Written in `PreUpdate`, after picking and before the plugin's own drags. A press on a panel, on another program's things, or one
//! that orbits the camera (with Alt) begins nothing here. Nothing hovers while a camera gesture or the panel has the pointer.

use bevy::ecs::system::SystemParam;
use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::{Location, PointerAction, PointerButton, PointerId, PointerInput};
use bevy::prelude::*;

use super::gizmo::{GizmoPart, SelectionGizmo};
use crate::editor::curves::Curve;
use crate::editor::input::{Modifiers, PanelInput};
use crate::plugin::{BuiltSurface, ControlKind, ControlPoint, CurveHit, LineHit, Picker, SurfaceLine, SurfaceSpline};
use crate::surface::SurfacePoint;

/// A press that moves less than this many pixels is a click, as for the plugin's drags.
pub(crate) const DEAD_ZONE: f32 = 4.0;
/// Clicks as near as this to the last one are on the same place.
const SAME_PLACE: f32 = 3.0;

/// What is under the pointer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Target {
    /// An anchor or handle of an editable spline.
    Control { spline: Entity, kind: ControlKind },
    /// A curve.
    Curve { spline: Entity, hit: CurveHit },
    /// A drawn line.
    Line { line: Entity, place: LineHit },
    /// The gizmo of the selection.
    Gizmo(GizmoPart),
    /// The bare surface.
    Surface,
    /// Nothing: the background.
    #[default]
    Nothing,
}

/// A moment of the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    /// In logical pixels.
    pub(crate) at: Vec2,
    pub(crate) camera: Entity,
    pub(crate) target: Target,
    /// The surface under it, whatever is on top, and where.
    pub(crate) surface: Option<(Entity, SurfacePoint)>,
    pub(crate) modifiers: Modifiers,
}

/// What the pointer did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PointerEvent {
    /// The button went down; again, if that is where the last click was.
    Press {
        at: Moment,
        again: bool,
    },
    /// The pressed pointer left the dead zone.
    DragStart {
        from: Moment,
    },
    /// The pressed pointer moved, outside of the dead zone.
    Drag {
        from: Moment,
        to: Moment,
    },
    DragEnd {
        from: Moment,
        to: Moment,
    },
    /// The button went up where it went down; again at the same place makes the count grow.
    Click {
        at: Moment,
        count: u32,
    },
    /// What was pressed is taken back: Escape, or the system took the pointer away.
    Cancel,
}

/// The primary pointer, as tools see it.
#[derive(Resource, Debug, Default)]
pub(crate) struct ToolPointer {
    /// Where it is, unless a panel or the camera has it.
    pub(crate) hover: Option<Moment>,
    /// What it did in this frame, in order.
    pub(crate) events: Vec<PointerEvent>,
    press: Option<Press>,
    last_click: Option<(Vec2, u32)>,
}

#[derive(Clone, Copy, Debug)]
struct Press {
    pointer: PointerId,
    from: Moment,
    dragging: bool,
}

impl ToolPointer {
    /// What is held; dragged or not.
    pub(crate) fn held(&self) -> Option<Moment> {
        self.press.map(|press| press.from)
    }

    /// The rest of a gesture that was cancelled does nothing.
    fn cancel(&mut self) {
        if self.press.take().is_some() {
            self.events.push(PointerEvent::Cancel);
        }
    }
}

/// What the pointer may be on.
#[derive(SystemParam)]
pub(crate) struct PointerScene<'w, 's> {
    picker: Picker<'w, 's>,
    hover: Option<Res<'w, HoverMap>>,
    panel: Res<'w, PanelInput>,
    controls: Query<'w, 's, &'static ControlPoint>,
    splines: Query<'w, 's, Option<&'static Curve>, With<SurfaceSpline>>,
    lines: Query<'w, 's, Option<&'static Curve>, With<SurfaceLine>>,
    surfaces: Query<'w, 's, (), With<BuiltSurface>>,
    windows: Query<'w, 's, (), With<Window>>,
    gizmo: Res<'w, SelectionGizmo>,
}

impl PointerScene<'_, '_> {
    fn moment(&self, location: &Location, modifiers: Modifiers) -> Option<Moment> {
        let at = location.position;
        let camera = self.picker.cameras_at(location).first().copied()?;
        let surface = self.picker.nearest_surface_under(camera, at).map(|(entity, hit)| (entity, hit.point));
        let control = self.picker.control_under(camera, at).and_then(|control| self.controls.get(control).ok());
        let target = match control {
            Some(control) => Target::Control { spline: control.spline, kind: control.kind },
            None => match self.curves_under(camera, at).first() {
                Some((spline, hit)) => Target::Curve { spline: *spline, hit: *hit },
                None => match (self.lines_under(camera, at).first(), self.gizmo.part_at(at)) {
                    (Some((line, place)), _) => Target::Line { line: *line, place: *place },
                    (None, Some(part)) => Target::Gizmo(part),
                    (None, None) if surface.is_some() => Target::Surface,
                    (None, None) => Target::Nothing,
                },
            },
        };
        Some(Moment { at, camera, target, surface, modifiers })
    }

    fn curves_under(&self, camera: Entity, at: Vec2) -> Vec<(Entity, CurveHit)> {
        let is_free = |spline: Entity| self.splines.get(spline).is_ok_and(|curve| curve.is_none_or(Curve::is_free));
        self.picker.curves_under(camera, at).into_iter().filter(|(spline, _)| is_free(*spline)).collect()
    }

    fn lines_under(&self, camera: Entity, at: Vec2) -> Vec<(Entity, LineHit)> {
        let is_free = |line: Entity| self.lines.get(line).is_ok_and(|curve| curve.is_none_or(Curve::is_free));
        self.picker.lines_under(camera, at).into_iter().filter(|(line, _)| is_free(*line)).collect()
    }

    /// All that a click may mean, the likeliest first.
    pub(crate) fn all_under(&self, moment: &Moment) -> Vec<Target> {
        let controls = self.picker.controls_under(moment.camera, moment.at);
        let controls = controls.into_iter().filter_map(|control| self.controls.get(control).ok());
        let controls = controls.map(|control| Target::Control { spline: control.spline, kind: control.kind });
        let curves = self.curves_under(moment.camera, moment.at);
        let curves = curves.into_iter().map(|(spline, hit)| Target::Curve { spline, hit });
        let lines = self.lines_under(moment.camera, moment.at).into_iter();
        controls.chain(curves).chain(lines.map(|(line, place)| Target::Line { line, place })).collect()
    }

    /// Whether the pointer is over something else first: a panel, a button, another program's model.
    fn is_covered(&self, pointer: PointerId) -> bool {
        if self.panel.pointer {
            return true;
        }
        let Some(hovered) = self.hover.as_ref().and_then(|hover| hover.get(&pointer)) else { return false };
        let drawn = |e: Entity| self.splines.contains(e) || self.lines.contains(e);
        let ours = |e: Entity| self.controls.contains(e) || drawn(e) || self.surfaces.contains(e);
        hovered.keys().any(|e| !ours(*e) && !self.windows.contains(*e)) && !hovered.keys().any(|e| ours(*e))
    }
}

/// Turns pointer input into events.
pub(crate) fn read_pointer(
    mut pointer: ResMut<ToolPointer>,
    mut inputs: MessageReader<PointerInput>,
    scene: PointerScene,
    keys: Res<ButtonInput<KeyCode>>,
) {
    if !pointer.events.is_empty() {
        pointer.events.clear();
    }
    let modifiers = Modifiers::of(&keys);
    let mut newest: Option<&PointerInput> = None;
    for input in inputs.read() {
        if matches!(input.pointer_id, PointerId::Mouse | PointerId::Touch(_)) {
            newest = Some(input);
            pointer.take(input, &scene, modifiers);
        }
    }
    if keys.just_pressed(KeyCode::Escape) {
        pointer.cancel();
    }
    if let Some(input) = newest {
        let covered = scene.is_covered(input.pointer_id) && pointer.press.is_none();
        pointer.hover = if covered { None } else { scene.moment(&input.location, modifiers) };
    } else if scene.panel.pointer && pointer.hover.is_some() && pointer.press.is_none() {
        pointer.hover = None;
    }
}

impl ToolPointer {
    fn take(&mut self, input: &PointerInput, scene: &PointerScene, modifiers: Modifiers) {
        let held = self.press.filter(|press| press.pointer == input.pointer_id);
        match (input.action, held) {
            (PointerAction::Press(PointerButton::Primary), None) if self.press.is_none() => {
                if modifiers.alt || scene.is_covered(input.pointer_id) {
                    return;
                }
                let Some(from) = scene.moment(&input.location, modifiers) else { return };
                self.press = Some(Press { pointer: input.pointer_id, from, dragging: false });
                let again = self.last_click.is_some_and(|(at, _)| at.distance(from.at) < SAME_PLACE);
                self.events.push(PointerEvent::Press { at: from, again });
            }
            (PointerAction::Move { .. }, Some(mut press)) => {
                let Some(to) = scene.moment(&input.location, modifiers) else { return };
                if !press.dragging {
                    if press.from.at.distance(to.at) < DEAD_ZONE {
                        return;
                    }
                    press.dragging = true;
                    self.press = Some(press);
                    self.events.push(PointerEvent::DragStart { from: press.from });
                }
                self.events.push(PointerEvent::Drag { from: press.from, to });
            }
            (PointerAction::Release(PointerButton::Primary), Some(press)) => {
                self.press = None;
                let to = scene.moment(&input.location, modifiers).unwrap_or(press.from);
                if press.dragging {
                    self.last_click = None;
                    self.events.push(PointerEvent::DragEnd { from: press.from, to });
                } else {
                    let again = self.last_click.filter(|(at, _)| at.distance(to.at) < SAME_PLACE);
                    let count = again.map_or(1, |(_, count)| count + 1);
                    self.last_click = Some((to.at, count));
                    self.events.push(PointerEvent::Click { at: press.from, count });
                }
            }
            (PointerAction::Cancel, Some(_)) => self.cancel(),
            _ => {}
        }
    }
}
