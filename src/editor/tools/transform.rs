//! Moving, turning and scaling what is selected: by a key and the pointer, by a number that is typed, or by dragging the gizmo, a curve
//! or one of several selected anchors.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::gizmo::SelectionGizmo;
use super::{Moment, PointerEvent, Target, Tool, ToolPointer, select};
use crate::curve::{SelectionTransform, SplineEdit};
use crate::editor::history::History;
use crate::editor::input::{Modifiers, PanelInput, StruckKeys};
use crate::editor::model::Model;
use crate::editor::notices::Notices;
use crate::editor::selection::Selection;
use crate::geodesic::Tangent;
use crate::plugin::{
    BuiltSurface, EditSpline, EndGesture, GestureId, OnSurface, Picker, SurfaceQueries, SurfaceSpline,
};
use crate::surface::{Surface, SurfacePoint};

/// Nearer to the centre than this, in pixels, the pointer has no direction from it: then its way to the right counts.
const NEAR: f32 = 24.0;
/// Radians, and doublings, for each pixel to the right.
const BY_PIXEL: f64 = 0.01;
/// With Ctrl, in steps of these: a share of the surface's diagonal, radians, a factor.
const STEPS: [f64; 3] = [0.01, std::f64::consts::PI / 12.0, 0.1];
/// With Shift the pointer's way counts for this much.
const FINE: f32 = 0.1;

/// What is done to the selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransformMode {
    /// It is moved over the surface.
    Move,
    /// It is turned about a point.
    Turn,
    /// It is scaled about a point.
    Scale,
}

impl TransformMode {
    /// What the history calls it.
    fn name(self) -> &'static str {
        match self {
            Self::Move => "Move",
            Self::Turn => "Turn",
            Self::Scale => "Scale",
        }
    }

    /// The key that asks for it.
    fn key(self) -> KeyCode {
        match self {
            Self::Move => KeyCode::KeyG,
            Self::Turn => KeyCode::KeyR,
            Self::Scale => KeyCode::KeyS,
        }
    }
}

/// Keys in the order in which they were struck: a number that is typed in one slow frame is that number.
#[derive(SystemParam)]
pub(crate) struct NumberKeys<'w, 's> {
    keys: StruckKeys<'w, 's>,
    /// Those of the frame before, in which the key was struck that asked for a transform.
    before: Local<'s, Vec<KeyCode>>,
    panel: Res<'w, PanelInput>,
}

impl NumberKeys<'_, '_> {
    fn struck(&mut self) -> Vec<KeyCode> {
        let is_typed_elsewhere = self.panel.keyboard;
        let struck = self.keys.read().into_iter().map(|(key, _)| key);
        if is_typed_elsewhere { Vec::new() } else { struck.collect() }
    }

    /// What came after a key in the frame before.
    fn after(&self, key: KeyCode) -> Vec<KeyCode> {
        let asked = self.before.iter().rposition(|struck| *struck == key);
        asked.map_or_else(Vec::new, |at| self.before[at + 1..].to_vec())
    }

    fn remember(&mut self, struck: &[KeyCode]) {
        self.before.clear();
        self.before.extend(struck);
    }
}

/// Asks for a transform that follows the pointer until it is clicked.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub struct BeginTransform(pub TransformMode);

/// The transform that is under way.
#[derive(Resource, Debug, Default)]
pub(crate) struct Transforming(pub(crate) Option<Active>);

#[derive(Clone, Debug)]
pub(crate) struct Active {
    pub(crate) mode: TransformMode,
    pub(crate) model: Entity,
    pub(crate) centre: SurfacePoint,
    /// Where a move leads.
    pub(crate) to: Option<SurfacePoint>,
    parts: Vec<Part>,
    /// Where the pointer was at the beginning, and where the centre was seen then.
    from: Vec2,
    centre_at: Vec2,
    camera: Entity,
    /// The number that is typed.
    pub(crate) typed: String,
    /// Whether the button is held, and lets go of it.
    by_drag: bool,
    /// Where the pointer is.
    at: Vec2,
    /// What is shown to the user: length, degrees or factor.
    pub(crate) amount: f64,
}

/// What of one spline is moved.
#[derive(Clone, Debug)]
struct Part {
    spline: Entity,
    gesture: GestureId,
    /// None: all.
    anchors: Option<Vec<u32>>,
}

/// What a transform works with.
#[derive(SystemParam)]
pub(crate) struct Desk<'w, 's> {
    active: ResMut<'w, Transforming>,
    selection: Res<'w, Selection>,
    history: ResMut<'w, History>,
    notices: ResMut<'w, Notices>,
    edits: MessageWriter<'w, EditSpline>,
    ends: MessageWriter<'w, EndGesture>,
    splines: Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>,
    surfaces: Query<'w, 's, &'static BuiltSurface>,
    views: SurfaceQueries<'w, 's>,
    picker: Picker<'w, 's>,
    cameras: Query<'w, 's, (Entity, &'static Camera, &'static GlobalTransform)>,
    models: Query<'w, 's, &'static Model>,
    gizmo: Res<'w, SelectionGizmo>,
}

pub(crate) fn transform(
    tool: Res<Tool>,
    mut pointer: ResMut<ToolPointer>,
    mut asked: MessageReader<BeginTransform>,
    (keys, mouse): (Res<ButtonInput<KeyCode>>, Res<ButtonInput<MouseButton>>),
    mut numbers: NumberKeys,
    mut desk: Desk,
) {
    let mut struck = numbers.struck();
    for BeginTransform(mode) in asked.read() {
        if desk.active.0.is_none() {
            desk.begin(*mode, pointer.hover.as_ref());
            // What was typed in the frame of the key itself, too.
            struck.splice(0..0, numbers.after(mode.key()));
        }
    }
    numbers.remember(&struck);
    if *tool == Tool::Select && desk.active.0.is_none() {
        desk.begin_drag(&pointer.events);
    }
    let Some(active) = &mut desk.active.0 else { return };
    let (by_drag, mut changed) = (active.by_drag, active.type_keys(&struck));
    if let Some(hover) = pointer.hover.filter(|hover| hover.at != active.at && !by_drag) {
        (active.at, changed) = (hover.at, true);
    }
    let (mut done, mut cancelled) = (false, false);
    for event in &pointer.events {
        match event {
            PointerEvent::Drag { to, .. } if by_drag => (active.at, changed) = (to.at, true),
            PointerEvent::DragEnd { .. } if by_drag => done = true,
            PointerEvent::Press { .. } if !by_drag => done = true,
            PointerEvent::Cancel => cancelled = true,
            _ => {}
        }
    }
    done |= struck.iter().any(|key| matches!(key, KeyCode::Enter | KeyCode::NumpadEnter));
    cancelled |= struck.contains(&KeyCode::Escape) || mouse.just_pressed(MouseButton::Right);
    let modifiers = Modifiers::of(&keys);
    let switched = keys.get_just_pressed().any(is_modifier) || keys.get_just_released().any(is_modifier);
    if (changed || switched) && !cancelled {
        desk.follow(modifiers);
    }
    // What the pointer did was meant for the transform.
    if !pointer.events.is_empty() {
        pointer.events.clear();
    }
    if done || cancelled {
        desk.end(cancelled);
    }
}

impl Active {
    /// Digits, a point and a sign make a number; whether it changed.
    fn type_keys(&mut self, keys: &[KeyCode]) -> bool {
        let before = self.typed.clone();
        for key in keys {
            match key {
                KeyCode::Backspace => drop(self.typed.pop()),
                KeyCode::Minus | KeyCode::NumpadSubtract if self.typed.is_empty() => self.typed.push('-'),
                KeyCode::Period | KeyCode::NumpadDecimal if !self.typed.contains('.') => self.typed.push('.'),
                _ => self.typed.extend(digit(*key).filter(|_| self.typed.len() < 12)),
            }
        }
        self.typed != before
    }

    fn number(&self) -> Option<f64> {
        self.typed.parse().ok()
    }

    /// The direction of a place from the centre, where it has one.
    fn direction(&self, at: Vec2) -> Option<Vec2> {
        Some(at - self.centre_at).filter(|way| way.length() > NEAR)
    }

    /// How far the pointer has turned about the centre, counter-clockwise on the screen.
    fn pointer_angle(&self, at: Vec2) -> f64 {
        match (self.direction(self.from), self.direction(at)) {
            (Some(a), Some(b)) => f64::from(-a.angle_to(b)),
            _ => -BY_PIXEL * f64::from(at.x - self.from.x),
        }
    }

    fn pointer_factor(&self, at: Vec2) -> f64 {
        match self.direction(self.from) {
            Some(way) => f64::from((at - self.centre_at).length() / way.length()),
            None => (BY_PIXEL * f64::from(at.x - self.from.x)).exp2(),
        }
    }
}

/// The surface point nearest to the mean of some.
pub(crate) fn middle(surface: &Surface, points: impl Iterator<Item = SurfacePoint>) -> Option<SurfacePoint> {
    let (sum, count) =
        points.fold((glam::DVec3::ZERO, 0.0), |(sum, count), p| (sum + surface.position(&p), count + 1.0));
    Some(surface.closest_point(sum / count)?.point)
}

fn is_modifier(key: &KeyCode) -> bool {
    matches!(key, KeyCode::ShiftLeft | KeyCode::ShiftRight | KeyCode::ControlLeft | KeyCode::ControlRight)
}

fn digit(key: KeyCode) -> Option<char> {
    let digits = [
        (KeyCode::Digit0, KeyCode::Numpad0),
        (KeyCode::Digit1, KeyCode::Numpad1),
        (KeyCode::Digit2, KeyCode::Numpad2),
        (KeyCode::Digit3, KeyCode::Numpad3),
        (KeyCode::Digit4, KeyCode::Numpad4),
        (KeyCode::Digit5, KeyCode::Numpad5),
        (KeyCode::Digit6, KeyCode::Numpad6),
        (KeyCode::Digit7, KeyCode::Numpad7),
        (KeyCode::Digit8, KeyCode::Numpad8),
        (KeyCode::Digit9, KeyCode::Numpad9),
    ];
    let value = digits.iter().position(|(row, pad)| *row == key || *pad == key)?;
    char::from_digit(value as u32, 10)
}

impl Desk<'_, '_> {
    /// A key was struck: about the active anchor, or else the place under the pointer, or the middle of what is selected.
    fn begin(&mut self, mode: TransformMode, hover: Option<&Moment>) {
        let Some((model, parts)) = self.parts() else {
            self.notices.info(format!("Select what is to be changed first: {} works on the selection.", mode.name()));
            return;
        };
        // By the keyboard alone it is about the middle of what is selected.
        let Some(hover) = hover.copied().or_else(|| self.seen_middle(model, &parts)) else {
            self.notices.info("Move the pointer over the model first: the transform follows it.");
            return;
        };
        let anchor = self.selection.anchors().last().and_then(|(spline, anchor)| {
            let (spline, on) = self.splines.get(*spline).ok()?;
            (on.0 == model).then_some(spline.anchors().get(*anchor as usize)?.point())
        });
        let under = hover.surface.filter(|(on, _)| *on == model).map(|(_, point)| point);
        let under = under.filter(|_| mode != TransformMode::Move);
        let Some(centre) = anchor.or(under).or_else(|| self.middle(model, &parts)) else { return };
        self.start(mode, model, centre, parts, &hover, false);
    }

    /// Where the middle of what is selected is seen, as if the pointer were there.
    fn seen_middle(&self, model: Entity, parts: &[Part]) -> Option<Moment> {
        let middle = self.middle(model, parts)?;
        let position = self.views.get(model)?.position(middle);
        self.cameras.iter().find_map(|(entity, camera, transform)| {
            let at = camera.world_to_viewport(transform, position).ok().filter(|_| camera.is_active)?;
            let (target, modifiers) = (Target::Nothing, Modifiers::default());
            Some(Moment { at, camera: entity, target, surface: None, modifiers })
        })
    }

    /// A curve, or one of several selected anchors, is dragged.
    fn begin_drag(&mut self, events: &[PointerEvent]) {
        let from = events.iter().find_map(|event| match event {
            PointerEvent::DragStart { from } if select::moves_selection(from, &self.selection) => Some(*from),
            _ => None,
        });
        let Some(from) = from else { return };
        let Some((model, parts)) = self.parts() else { return };
        if let (Target::Gizmo(part), Some(gizmo)) = (from.target, &self.gizmo.0) {
            return self.start(part.mode(), model, gizmo.centre, parts, &from, true);
        }
        let grabbed = match from.target {
            Target::Curve { hit, .. } => Some(hit.point),
            Target::Control { spline, kind } => self.splines.get(spline).ok().and_then(|(s, _)| kind.point(s)),
            _ => None,
        };
        if let Some(centre) = grabbed {
            self.start(TransformMode::Move, model, centre, parts, &from, true);
        }
    }

    /// The selection as parts of splines, all of one model.
    fn parts(&self) -> Option<(Entity, Vec<Part>)> {
        let active = self.selection.spline()?;
        let model = self.splines.get(active).ok()?.1.0;
        let on_model = |spline: &&Entity| self.splines.get(**spline).is_ok_and(|(_, on)| on.0 == model);
        let whole = self.selection.anchors().is_empty();
        let part = |spline: &Entity| {
            let anchors: Vec<u32> = self.selection.anchors_of(*spline).collect();
            let part = Part { spline: *spline, gesture: GestureId::next(), anchors: (!whole).then_some(anchors) };
            part.anchors.as_ref().is_none_or(|anchors| !anchors.is_empty()).then_some(part)
        };
        let parts: Vec<_> = self.selection.splines().iter().filter(on_model).filter_map(part).collect();
        (!parts.is_empty()).then_some((model, parts))
    }

    /// The surface point nearest to the mean of all anchors.
    fn middle(&self, model: Entity, parts: &[Part]) -> Option<SurfacePoint> {
        let anchors = parts.iter().filter_map(|part| Some((part, self.splines.get(part.spline).ok()?.0)));
        let points = anchors.flat_map(|(part, spline)| {
            let taken = |index: &u32| part.anchors.as_ref().is_none_or(|anchors| anchors.contains(index));
            (0..).zip(spline.anchors()).filter(move |(index, _)| taken(index)).map(|(_, anchor)| anchor.point())
        });
        middle(self.surfaces.get(model).ok()?, points)
    }

    fn start(
        &mut self,
        mode: TransformMode,
        model: Entity,
        centre: SurfacePoint,
        parts: Vec<Part>,
        pointer: &Moment,
        by_drag: bool,
    ) {
        let seen = self.views.get(model).and_then(|view| {
            let (_, camera, transform) = self.cameras.get(pointer.camera).ok()?;
            camera.world_to_viewport(transform, view.position(centre)).ok()
        });
        self.history.begin(format!("{} selection", mode.name()));
        let amount = if mode == TransformMode::Scale { 1.0 } else { 0.0 };
        let (from, at, camera, typed) = (pointer.at, pointer.at, pointer.camera, String::new());
        let centre_at = seen.unwrap_or(from);
        self.active.0 =
            Some(Active { mode, model, centre, to: None, parts, from, centre_at, camera, typed, by_drag, at, amount });
    }

    /// Sends the transform since the beginning, of the splines as they were then.
    fn follow(&mut self, modifiers: Modifiers) {
        let Some(mut active) = self.active.0.take() else { return };
        if let Some(transform) = self.transform_of(&mut active, modifiers) {
            for part in &active.parts {
                let anchors = part.anchors.clone();
                let edit = SplineEdit::Transform(SelectionTransform { anchors, ..transform.clone() });
                self.edits.write(EditSpline::new(part.spline, edit).undoable().in_gesture(part.gesture));
            }
        }
        self.active.0 = Some(active);
    }

    fn transform_of(&self, active: &mut Active, modifiers: Modifiers) -> Option<SelectionTransform> {
        let at = if modifiers.shift { active.from + FINE * (active.at - active.from) } else { active.at };
        let stepped = |value: f64, step: f64| if modifiers.control { (value / step).round() * step } else { value };
        let centre = active.centre;
        match active.mode {
            TransformMode::Move => {
                let surface: &Surface = self.surfaces.get(active.model).ok()?;
                // Off the model the last place holds.
                let pixel = active.centre_at + (at - active.from);
                let mut to = self.picker.surface_under(active.camera, pixel, active.model)?.point;
                let way = surface.log(&centre, &to).ok()?;
                // Longer ways than around the model mean nothing, and take long to walk.
                let most = 4.0 * surface.diagonal();
                // Lengths are shown and typed in the units of the model's file, where it has one.
                let unit = self.models.get(active.model).map_or(1.0, |model| model.unit);
                let typed = active.number().map(|length| (length / unit).clamp(-most, most));
                let length = typed.unwrap_or(stepped(way.length(), STEPS[0] * surface.diagonal()));
                if length != way.length() {
                    // Without a direction by the pointer: to the right.
                    let way = if way.length() > 0.0 { way } else { self.rightwards(active)? };
                    let heading = if length < 0.0 { surface.opposite(&centre, &way).ok()? } else { way };
                    to = surface.walk(&centre, &heading, length.abs()).ok()?.path.end();
                }
                (active.amount, active.to) = (length * unit, Some(to));
                Some(SelectionTransform::translation(centre, to))
            }
            TransformMode::Turn => {
                let typed = active.number().map(f64::to_radians);
                // Counter-clockwise on the screen is so on the surface where that faces the eye.
                let seen = if self.faces_away(active) { -1.0 } else { 1.0 };
                let angle = typed.unwrap_or_else(|| stepped(seen * active.pointer_angle(at), STEPS[1]));
                active.amount = angle.to_degrees();
                Some(SelectionTransform::rotation(centre, angle))
            }
            TransformMode::Scale => {
                let factor = active.number().unwrap_or_else(|| stepped(active.pointer_factor(at), STEPS[2]));
                // At nothing all would be lost.
                let factor = if factor.abs() < 1e-3 { 1e-3 } else { factor };
                active.amount = factor;
                Some(SelectionTransform::scaling(centre, factor))
            }
        }
    }

    /// The direction at the centre that the eye sees as to the right.
    fn rightwards(&self, active: &Active) -> Option<Tangent> {
        let (.., camera) = self.cameras.get(active.camera).ok()?;
        let view = self.views.get(active.model)?;
        let right = view.to_world().inverse().transform_vector3(*camera.right()).as_dvec3();
        view.surface().tangent(&active.centre, right).ok().filter(|tangent| tangent.length() > 0.0)
    }

    fn faces_away(&self, active: &Active) -> bool {
        let facing = || {
            let (.., camera) = self.cameras.get(active.camera).ok()?;
            let view = self.views.get(active.model)?;
            let to_eye = camera.translation() - view.position(active.centre);
            Some(view.normal(active.centre).dot(to_eye))
        };
        facing().is_some_and(|facing| facing < 0.0)
    }

    fn end(&mut self, cancel: bool) {
        let Some(active) = self.active.0.take() else { return };
        let ends = active.parts.iter().map(|part| EndGesture { gesture: part.gesture, cancel });
        self.ends.write_batch(ends);
        if cancel { self.history.take_back() } else { self.history.end() }
    }
}
