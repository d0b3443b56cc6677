//! Dragging control points: a state machine of our own over pointer input.
//!
//! Bevy's `DragStart` has no dead zone and its `Click` follows drags, so neither is used. A press on a control point starts
//! in [`DragState::Pressed`]; leaving the dead zone makes it [`DragState::Dragging`], which sends one
//! [`EditSpline`] a frame in which the pointer moved, all of one gesture. The pixel offset between the press and the control
//! point is kept, so nothing jumps. Off the model the last hit holds; over another piece of the surface too, and that is
//! said. Escape, or a cancelled pointer, restores the spline as it was, bit for bit.
//!
//! In splines whose legs stay on their side, or that are split where they would jump
//! ([`JumpPolicy`]), the way that the pointer took over the surface goes with the edit. Where a frame has no time for it
//! ([`TraceBudget`]), it is found in the background and the edit comes later.

use std::sync::Arc;

use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::{Location, PointerAction, PointerButton, PointerId, PointerInput};
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::budget::{self, FrameTime, TraceBudget};
use super::controls::{ControlKind, ControlPoint};
use super::drag_modifiers::DragModifiers;
use super::drag_ways::{Sent, Way, Ways};
use super::edit::{EditRefusal, EditSpline, EndGesture, GestureId, SplineEditRefused};
use super::pick::Picker;
use super::spline::SurfaceSpline;
use super::surface::{BuiltSurface, OnSurface};
use super::workspaces::Workspaces;
use crate::curve::{JumpPolicy, Spline};
use crate::surface::SurfacePoint;

/// How drags behave.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct DragSettings {
    /// Whether control points can be dragged at all.
    pub enabled: bool,
    /// A press that moves less than this many logical pixels is a click.
    pub dead_zone: f32,
}

impl Default for DragSettings {
    fn default() -> Self {
        Self { enabled: true, dead_zone: 4.0 }
    }
}

/// Whether a control point is being dragged, and which.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub enum DragState {
    /// Nothing is held.
    #[default]
    Idle,
    /// A control point was pressed; the pointer has not left the dead zone.
    Pressed(Grip),
    /// A control point follows the pointer.
    Dragging(Grip),
}

/// What is held, and by whom.
#[derive(Clone, Debug, PartialEq)]
pub struct Grip {
    /// The pointer that holds it; others are ignored until it lets go.
    pub pointer: PointerId,
    /// The camera through which it was grabbed.
    pub camera: Entity,
    /// The spline.
    pub spline: Entity,
    /// Which of its control points.
    pub kind: ControlKind,
    /// The gesture that its edits belong to.
    pub gesture: GestureId,
    /// Where it was pressed, in logical pixels.
    pressed_at: Vec2,
    /// From there to where the control point appeared.
    offset: Vec2,
    /// The surface, and the sheet of it that the spline lies on.
    surface: Entity,
    sheet: u32,
    /// Whether the pointer is over another sheet, and that was said.
    astray: bool,
    /// The spline as it was, where a handle may be bound to the direction that it had.
    start: Option<Arc<Spline>>,
}

impl DragState {
    /// What is being dragged; none inside the dead zone.
    pub fn dragged(&self) -> Option<&Grip> {
        if let Self::Dragging(grip) = self { Some(grip) } else { None }
    }

    /// What is held, dragged or not.
    pub fn held(&self) -> Option<&Grip> {
        match self {
            Self::Idle => None,
            Self::Pressed(grip) | Self::Dragging(grip) => Some(grip),
        }
    }
}

/// Drags control points with pointers.
///
/// Schedule: `PreUpdate`, set [`SurfaceSplineSystems::Drag`]. Needs [`PickPlugin`](super::PickPlugin) and
/// [`EditPlugin`](super::EditPlugin); reads Bevy's pointer input, and its hover map to leave presses on other things alone.
#[derive(Debug, Default)]
pub struct DragPlugin;

impl Plugin for DragPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        budget::configure(app);
        app.register_type::<DragSettings>()
            .register_type::<DragModifiers>()
            .init_resource::<DragModifiers>()
            .init_resource::<DragSettings>()
            .init_resource::<DragState>()
            .init_resource::<Workspaces>()
            .init_resource::<Ways>()
            .init_resource::<super::SplinePickingSettings>()
            .add_message::<PointerInput>()
            .add_message::<EditSpline>()
            .add_message::<EndGesture>()
            .add_systems(PreUpdate, drag_controls.in_set(SurfaceSplineSystems::Drag));
    }
}

/// What a drag looks at.
#[derive(bevy::ecs::system::SystemParam)]
struct Scene<'w, 's> {
    picker: Picker<'w, 's>,
    hover: Option<Res<'w, HoverMap>>,
    controls: Query<'w, 's, &'static ControlPoint>,
    splines: Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>,
    surfaces: Query<'w, 's, &'static BuiltSurface>,
    windows: Query<'w, 's, (), With<Window>>,
}

fn drag_controls(
    mut commands: Commands,
    mut state: ResMut<DragState>,
    (settings, modifiers, keys): (Res<DragSettings>, Res<DragModifiers>, Option<Res<ButtonInput<KeyCode>>>),
    mut inputs: MessageReader<PointerInput>,
    (mut edits, mut ends): (MessageWriter<EditSpline>, MessageWriter<EndGesture>),
    (scene, mut ways): (Scene, ResMut<Ways>),
    (budget, mut frame, workspaces): (Res<TraceBudget>, ResMut<FrameTime>, Res<Workspaces>),
) {
    let begin = Instant::now();
    let mut drag = Drag { state: state.clone(), target: None, end: None, ways: &mut ways, modifiers: *modifiers };
    if drag.state.held().is_some_and(|grip| !scene.still_there(grip)) || !settings.enabled {
        drag.finish(true);
    }
    for input in inputs.read() {
        let held_by = drag.state.held().map(|grip| grip.pointer);
        match input.action {
            PointerAction::Press(PointerButton::Primary) if held_by.is_none() && settings.enabled => {
                drag.press(&scene, input.pointer_id, &input.location);
            }
            _ if held_by != Some(input.pointer_id) => {}
            PointerAction::Move { .. } => drag.follow(&mut commands, &scene, &settings, input.location.position),
            PointerAction::Release(PointerButton::Primary) => drag.finish(false),
            PointerAction::Cancel => drag.finish(true),
            _ => {}
        }
        // What a finished gesture left goes out before the next one may begin.
        drag.flush(&mut edits, &mut ends, false);
    }
    if keys.is_some_and(|keys| keys.just_pressed(KeyCode::Escape)) {
        drag.finish(true);
    }
    drag.flush(&mut edits, &mut ends, true);
    state.set_if_neq(drag.state);
    ways.retain(|way| scene.is_on(way));
    ways.lead(frame.left(&budget), &workspaces, |sent| match sent {
        Sent::Edit(edit) => drop(edits.write(edit)),
        Sent::End(end) => drop(ends.write(end)),
    });
    frame.spend(begin.elapsed());
}

/// The state machine during one frame.
struct Drag<'f> {
    state: DragState,
    /// The newest edit that was not sent yet.
    target: Option<EditSpline>,
    /// The gesture that has ended.
    end: Option<EndGesture>,
    ways: &'f mut Ways,
    modifiers: DragModifiers,
}

impl Drag<'_> {
    /// A pointer takes hold of what is under it.
    fn press(&mut self, scene: &Scene, pointer: PointerId, at: &Location) {
        let Some(grip) = scene.grab(pointer, at) else { return };
        // Where the last drag of the spline leads to is known in a moment, and a new one begins from there.
        if self.ways.has_one_of(grip.spline) {
            return;
        }
        self.ways.begin(scene.way(&grip));
        self.state = DragState::Pressed(grip);
    }

    /// The pointer that holds the grip has moved.
    fn follow(&mut self, commands: &mut Commands, scene: &Scene, settings: &DragSettings, to: Vec2) {
        if let DragState::Pressed(grip) = &self.state
            && grip.pressed_at.distance(to) >= settings.dead_zone
        {
            self.state = DragState::Dragging(grip.clone());
        }
        let DragState::Dragging(grip) = &mut self.state else { return };
        // Off the model the last hit holds.
        let Some(hit) = scene.picker.surface_under(grip.camera, to + grip.offset, grip.surface) else { return };
        let to = scene.bound(grip, &self.modifiers, hit.point);
        let edit = self.modifiers.edit(grip.kind, to);
        if scene.sheet(grip.surface, &to) == Some(grip.sheet) {
            grip.astray = false;
            if self.modifiers.free || !self.ways.follow(grip.gesture, to) {
                self.target = Some(EditSpline::new(grip.spline, edit).undoable().in_gesture(grip.gesture));
            }
        } else if !std::mem::replace(&mut grip.astray, true) {
            commands.trigger(SplineEditRefused { entity: grip.spline, edit, reason: EditRefusal::OtherPiece });
        }
    }

    /// The pointer lets go.
    fn finish(&mut self, cancel: bool) {
        match &self.state {
            DragState::Idle => {}
            DragState::Pressed(grip) => self.ways.forget(grip.gesture),
            DragState::Dragging(grip) => {
                let end = EndGesture { gesture: grip.gesture, cancel };
                self.end = (!self.ways.finish(end)).then_some(end);
            }
        }
        self.state = DragState::Idle;
    }

    /// Sends what has to be sent: of one gesture's moves in a frame the last alone.
    fn flush(&mut self, edits: &mut MessageWriter<EditSpline>, ends: &mut MessageWriter<EndGesture>, frame_ends: bool) {
        if (frame_ends || self.end.is_some())
            && let Some(edit) = self.target.take()
        {
            edits.write(edit);
        }
        if let Some(end) = self.end.take() {
            ends.write(end);
        }
    }
}

impl Scene<'_, '_> {
    /// What a press grabs.
    fn grab(&self, pointer: PointerId, at: &Location) -> Option<Grip> {
        if self.is_covered(pointer) {
            return None;
        }
        let under = |camera| Some((camera, self.picker.control_under(camera, at.position)?));
        let (camera, entity) = self.picker.cameras_at(at).into_iter().find_map(under)?;
        let control = self.controls.get(entity).ok()?;
        let (spline, on) = self.splines.get(control.spline).ok()?;
        let point = control.kind.point(spline)?;
        Some(Grip {
            pointer,
            camera,
            spline: control.spline,
            kind: control.kind,
            gesture: GestureId::next(),
            pressed_at: at.position,
            offset: self.picker.control_on_screen(camera, entity)? - at.position,
            surface: on.0,
            sheet: self.sheet(on.0, &point)?,
            astray: false,
            start: matches!(control.kind, ControlKind::Handle(..)).then(|| Arc::new((**spline).clone())),
        })
    }

    /// Where a grip goes that is dragged to a place.
    fn bound(&self, grip: &Grip, modifiers: &DragModifiers, to: SurfacePoint) -> SurfacePoint {
        let bound = || {
            let spline = grip.start.as_ref()?;
            Some(modifiers.bound(self.surfaces.get(grip.surface).ok()?, spline, grip.kind, to))
        };
        bound().unwrap_or(to)
    }

    /// The way that a grip leads along; none where that is of no consequence.
    fn way(&self, grip: &Grip) -> Option<Way> {
        let (spline, _) = self.splines.get(grip.spline).ok()?;
        let surface = self.surfaces.get(grip.surface).ok()?.0.clone();
        let from = grip.kind.point(spline)?;
        let matters = spline.jumps() != JumpPolicy::Allow;
        matters.then(|| Way::new(grip.spline, grip.kind, grip.gesture, surface, from))
    }

    /// Whether the spline of a way still lies on the surface that it leads over.
    fn is_on(&self, way: &Way) -> bool {
        let on = |(_, on): (&SurfaceSpline, &OnSurface)| {
            self.surfaces.get(on.0).is_ok_and(|surface| Arc::ptr_eq(&surface.0, way.surface()))
        };
        self.splines.get(way.spline).is_ok_and(on)
    }

    /// Whether the pointer is over something else first: a panel, a button, another model.
    fn is_covered(&self, pointer: PointerId) -> bool {
        let Some(hovered) = self.hover.as_ref().and_then(|hover| hover.get(&pointer)) else { return false };
        let ours = |e: Entity| self.controls.contains(e) || self.splines.contains(e) || self.surfaces.contains(e);
        let foreign = |e: Entity| !ours(e) && !self.windows.contains(e);
        hovered.keys().any(|entity| foreign(*entity)) && !hovered.keys().any(|entity| ours(*entity))
    }

    fn sheet(&self, surface: Entity, point: &SurfacePoint) -> Option<u32> {
        self.surfaces.get(surface).ok()?.sheet(point.face).ok()
    }

    fn still_there(&self, grip: &Grip) -> bool {
        let same = |(spline, on): (&SurfaceSpline, &OnSurface)| {
            on.0 == grip.surface && grip.kind.point(spline).is_some() && self.surfaces.contains(on.0)
        };
        self.splines.get(grip.spline).is_ok_and(same)
    }
}
