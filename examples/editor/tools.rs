//! Tools: what a press and a click on the model mean. Dragging control points is the plugin's.

use bevy::picking::events::{Click, Pointer, Press};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use bevy_surface_splines::geodesic::PathFinder;
use bevy_surface_splines::plugin::{DragSettings, Picker};
use bevy_surface_splines::prelude::*;

use crate::actions::Spawned;
use crate::curves::{self, NextNumber};
use crate::model::Model;
use crate::notices::Notices;
use crate::selection::Selection;

/// A press that moves less than this many pixels is a click, as for the plugin's drags.
const DEAD_ZONE: f32 = 4.0;

#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tool {
    #[default]
    Select,
    Pen,
}

/// Where the pen began: a spline needs two points.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PenStart(pub(crate) Option<(Entity, SurfacePoint)>);

/// Where the primary button went down.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
struct Pressed(Option<(Entity, Vec2)>);

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Tool>()
        .init_resource::<PenStart>()
        .init_resource::<Pressed>()
        .add_systems(PreUpdate, leave_alt_to_camera.before(SurfaceSplineSystems::Drag))
        .add_systems(Update, (press, click).chain());
}

/// Alt and left drag orbits: it must not take hold of control points.
fn leave_alt_to_camera(keys: Res<ButtonInput<KeyCode>>, drag: Res<DragState>, mut settings: ResMut<DragSettings>) {
    if *drag == DragState::Idle {
        let enabled = !keys.any_pressed([KeyCode::AltLeft, KeyCode::AltRight]);
        settings.set_if_neq(DragSettings { enabled, ..*settings });
    }
}

/// Selects what is pressed, at once, so that it can be dragged in one go.
fn press(
    mut presses: MessageReader<Pointer<Press>>,
    controls: Query<&ControlPoint>,
    splines: Query<(), With<SurfaceSpline>>,
    settings: Res<DragSettings>,
    tool: Res<Tool>,
    mut pressed: ResMut<Pressed>,
    mut selection: ResMut<Selection>,
) {
    for press in presses.read().filter(|press| press.button == PointerButton::Primary && settings.enabled) {
        pressed.0 = Some((press.entity, press.pointer_location.position));
        if let Ok(control) = controls.get(press.entity) {
            let (ControlKind::Anchor(anchor) | ControlKind::Handle(anchor, _)) = control.kind;
            selection.select_anchor(control.spline, anchor);
        } else if splines.contains(press.entity) && *tool == Tool::Select {
            selection.select(press.entity);
        }
    }
}

/// What a click may do.
#[derive(bevy::ecs::system::SystemParam)]
struct Desk<'w, 's> {
    commands: Commands<'w, 's>,
    finder: Local<'s, PathFinder>,
    next: ResMut<'w, NextNumber>,
    selection: ResMut<'w, Selection>,
    pen: ResMut<'w, PenStart>,
    notices: ResMut<'w, Notices>,
    edits: MessageWriter<'w, EditSpline>,
    spawned: MessageWriter<'w, Spawned>,
}

/// What may be clicked.
#[derive(bevy::ecs::system::SystemParam)]
struct Scene<'w, 's> {
    picker: Picker<'w, 's>,
    controls: Query<'w, 's, (), With<ControlPoint>>,
    windows: Query<'w, 's, (), With<Window>>,
    models: Query<'w, 's, (Entity, &'static BuiltSurface), With<Model>>,
    splines: Query<'w, 's, &'static SurfaceSpline>,
}

fn click(
    mut clicks: MessageReader<Pointer<Click>>,
    mut pressed: ResMut<Pressed>,
    tool: Res<Tool>,
    scene: Scene,
    mut desk: Desk,
) {
    for click in clicks.read().filter(|click| click.button == PointerButton::Primary) {
        let (at, entity) = (click.pointer_location.position, click.entity);
        let begun = pressed.0.take().filter(|(begun, from)| *begun == entity && from.distance(at) < DEAD_ZONE);
        if begun.is_none() || scene.controls.contains(entity) {
            continue;
        }
        let on_model = scene.models.contains(entity);
        match *tool {
            Tool::Select if on_model || scene.windows.contains(entity) => desk.selection.clear(),
            Tool::Pen if on_model || scene.splines.contains(entity) => {
                for (model, surface) in &scene.models {
                    if let Some(hit) = scene.picker.surface_under(click.hit.camera, at, model) {
                        desk.add_anchor(model, surface, hit.point, &scene.splines);
                    }
                }
            }
            _ => {}
        }
    }
}

impl Desk<'_, '_> {
    /// The pen touches the surface: a new anchor, or the beginning of a new spline.
    fn add_anchor(&mut self, model: Entity, surface: &BuiltSurface, at: SurfacePoint, splines: &Query<&SurfaceSpline>) {
        let active = self.selection.spline.and_then(|entity| Some((entity, splines.get(entity).ok()?)));
        if let Some((entity, spline)) = active.filter(|(_, spline)| !spline.is_closed()) {
            let edit = SplineEdit::Append { end: SplineEnd::End, at };
            self.edits.write(EditSpline::new(entity, edit).undoable());
            self.selection.select_anchor(entity, spline.anchors().len() as u32);
            return;
        }
        let start = self.pen.0.take().filter(|(on, _)| *on == model);
        let Some((_, first)) = start else {
            self.selection.clear();
            self.pen.0 = Some((model, at));
            return;
        };
        match curves::corners(surface, &mut self.finder, &[first, at]) {
            Ok(spline) => {
                let entity = curves::spawn(&mut self.commands, &mut self.next, model, None, spline);
                self.spawned.write(Spawned(entity));
                self.selection.select_anchor(entity, 1);
            }
            Err(error) => {
                self.pen.0 = Some((model, first));
                self.notices.warn(error.to_string());
            }
        }
    }
}
