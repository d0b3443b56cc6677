//! Tools: what presses, drags and clicks on the model mean. Dragging single control points is the plugin's.

use bevy::picking::PickingSystems;
use bevy::prelude::*;

use super::input::{Modifiers, ToolKeys};
use super::selection::Selection;
use crate::plugin::{ControlKind, DragModifiers, DragSettings, DragState, SplinePickingSettings, SurfaceSplineSystems};

pub(crate) mod brush;
pub(crate) mod drawing;
pub(crate) mod freehand;
pub(crate) mod gizmo;
pub(crate) mod insert;
pub(crate) mod join;
pub(crate) mod pen;
pub(crate) mod pointer;
pub(crate) mod select;
pub(crate) mod transform;

pub(crate) use pointer::{Moment, PointerEvent, Target, ToolPointer};

/// With Ctrl a handle turns in steps of 15°.
const SNAP: f64 = std::f64::consts::PI / 12.0;

/// What the pointer is used for.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Resource, Default, Clone, Debug, PartialEq, Hash)]
pub enum Tool {
    /// Selects what is clicked or in a box, and moves what is dragged.
    #[default]
    Select,
    /// Adds anchors: corners by clicks, smooth ones by dragging their handles out.
    Pen,
    /// Draws a line by hand, which becomes a spline.
    Freehand,
    /// Adds an anchor to a curve, which keeps its shape.
    Insert,
    /// Changes the joins of anchors.
    Join,
    /// Places a drawing.
    Drawing,
    /// Smooths a drawn line where it is dragged.
    Brush,
}

impl Tool {
    /// All tools in the order of the tool strip.
    pub const ALL: [Self; 7] =
        [Self::Select, Self::Pen, Self::Freehand, Self::Insert, Self::Join, Self::Drawing, Self::Brush];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Select => "Select",
            Self::Pen => "Pen",
            Self::Freehand => "Freehand",
            Self::Insert => "Insert",
            Self::Join => "Join kind",
            Self::Drawing => "Drawing",
            Self::Brush => "Brush",
        }
    }

    /// What one does with it.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Select => "Click selects, Shift adds, drag moves, a drag from empty space is a box",
            Self::Pen => "Click adds a corner, press and drag a smooth anchor; click the first anchor to close",
            Self::Freehand => "Drag draws; the line becomes a spline within the tolerance",
            Self::Insert => "Click on a curve adds an anchor there, and the curve stays",
            Self::Join => "Click on an anchor: corner, smooth, mirrored, automatic, in turn",
            Self::Drawing => {
                "Choose an SVG; wheel scales, Shift and wheel turn, or drag from its middle; a click places it"
            }
            Self::Brush => "Drag along a drawn line to smooth it there",
        }
    }
}

/// Whether the wheel belongs to a tool, and not to the camera.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TakesWheel(pub(crate) bool);

/// Where tools look at input, in `PreUpdate`, and where they act, in `Update`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ToolSystems;

pub(crate) fn plugin(app: &mut App) {
    app.register_type::<Tool>()
        .init_resource::<Tool>()
        .init_resource::<ToolPointer>()
        .init_resource::<TakesWheel>()
        .init_resource::<pen::PenStart>()
        .init_resource::<pen::PenPull>()
        .init_resource::<select::BoxSelection>()
        .init_resource::<insert::InsertPreview>()
        .init_resource::<transform::Transforming>()
        .init_resource::<gizmo::SelectionGizmo>()
        .init_resource::<brush::Brushing>()
        .init_resource::<brush::BrushSettings>()
        .register_type::<brush::BrushSettings>()
        .init_resource::<freehand::Freehand>()
        .init_resource::<freehand::FreehandSettings>()
        .register_type::<freehand::FreehandSettings>()
        .init_resource::<ToolKeys>()
        .init_resource::<drawing::DrawingInHand>()
        .add_message::<drawing::TakeDrawing>()
        .add_message::<transform::BeginTransform>()
        .add_systems(
            PreUpdate,
            (pointer::read_pointer, leave_to_tools)
                .chain()
                .after(PickingSystems::Last)
                .after(bevy::input::InputSystems)
                .before(SurfaceSplineSystems::Drag),
        )
        .add_systems(
            Update,
            // What is pressed is selected first; then a transform takes what the pointer does before all others.
            (
                select::select,
                transform::transform,
                pen::draw,
                freehand::draw,
                insert::insert,
                join::click,
                drawing::place,
                brush::brush,
            )
                .chain()
                .in_set(ToolSystems),
        )
        .add_systems(PostUpdate, gizmo::place.in_set(SurfaceSplineSystems::Draw));
}

/// The plugin drags single control points, but not those that a tool wants for itself: with Alt a drag orbits, and of several
/// selected anchors all are moved.
fn leave_to_tools(
    keys: Res<ButtonInput<KeyCode>>,
    drag: Res<DragState>,
    pointer: Res<ToolPointer>,
    (tool, selection, transforming): (Res<Tool>, Res<Selection>, Res<transform::Transforming>),
    mut tool_keys: ResMut<ToolKeys>,
    (mut settings, mut bound): (ResMut<DragSettings>, ResMut<DragModifiers>),
    mut picking: ResMut<SplinePickingSettings>,
) {
    let Modifiers { control, shift, alt } = Modifiers::of(&keys);
    let is_dragged = drag.dragged().is_some();
    let snap = (is_dragged && control).then_some(SNAP);
    bound.set_if_neq(DragModifiers { free: is_dragged && alt, snap, keep_direction: is_dragged && shift });
    tool_keys.set_if_neq(ToolKeys(transforming.0.is_some()));
    if *drag == DragState::Idle {
        let pressed = pointer.events.iter().find_map(|event| match event {
            PointerEvent::Press { at, .. } => Some(at),
            _ => None,
        });
        let is_tools = pressed.or(pointer.held().as_ref()).is_some_and(|moment| match *tool {
            Tool::Select => select::moves_selection(moment, &selection),
            Tool::Pen => false,
            _ => true,
        });
        settings.set_if_neq(DragSettings { enabled: !alt && !is_tools && transforming.0.is_none(), ..*settings });
    }
    // Of control points at one place, the one that is selected is meant.
    let active = selection.spline().zip(selection.anchor());
    let preferred = active.map(|(spline, anchor)| (spline, ControlKind::Anchor(anchor)));
    let preferred =
        preferred.filter(|_| picking.preferred.is_none_or(|(_, kind)| matches!(kind, ControlKind::Anchor(_))));
    if picking.preferred != preferred {
        picking.preferred = preferred;
    }
}
