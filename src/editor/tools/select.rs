//! The tool that selects and moves.

use bevy::prelude::*;

use super::pointer::PointerScene;
use super::transform::Transforming;
use super::{Moment, PointerEvent, Target, Tool, ToolPointer};
use crate::editor::selection::Selection;
use crate::plugin::{ControlKind, DragState, Picker};

/// A box that is being drawn, in logical pixels.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BoxSelection(pub(crate) Option<Rect>);

/// Whether a drag from here moves all that is selected: an anchor among several selected ones, or a curve.
pub(crate) fn moves_selection(from: &Moment, selection: &Selection) -> bool {
    match from.target {
        Target::Control { spline, kind: ControlKind::Anchor(anchor) } => {
            selection.anchors().len() > 1 && selection.has_anchor(spline, anchor)
        }
        Target::Curve { .. } | Target::Gizmo(_) => true,
        _ => false,
    }
}

pub(crate) fn select(
    tool: Res<Tool>,
    pointer: Res<ToolPointer>,
    scene: PointerScene,
    picker: Picker,
    (mut selection, mut boxed): (ResMut<Selection>, ResMut<BoxSelection>),
    (drag, transforming): (Res<DragState>, Res<Transforming>),
) {
    if transforming.0.is_some() {
        return;
    }
    if !matches!(*tool, Tool::Select | Tool::Pen) {
        boxed.set_if_neq(BoxSelection(None));
        return;
    }
    for event in &pointer.events {
        match *event {
            // A second click may mean what is behind: until it is clear that it is none, nothing changes.
            PointerEvent::Press { at, again: false } | PointerEvent::DragStart { from: at } => {
                press(&mut selection, &at, *tool);
            }
            PointerEvent::Click { at, count } if *tool == Tool::Select => click(&mut selection, &scene, &at, count),
            PointerEvent::Drag { from, to } if *tool == Tool::Select && begins_box(&from) && drag.held().is_none() => {
                boxed.0 = Some(Rect::from_corners(from.at, to.at));
            }
            PointerEvent::DragEnd { from, .. } => {
                if let Some(part) = boxed.0.take() {
                    select_box(&mut selection, &picker, &from, part);
                }
            }
            PointerEvent::Cancel => drop(boxed.0.take()),
            _ => {}
        }
    }
}

fn begins_box(from: &Moment) -> bool {
    matches!(from.target, Target::Surface | Target::Nothing)
}

/// Selects what is pressed at once, so that it can be dragged in one go.
fn press(selection: &mut Selection, at: &Moment, tool: Tool) {
    if at.modifiers.shift {
        return; // the click decides
    }
    match at.target {
        Target::Control { spline, kind: ControlKind::Anchor(anchor) } if !selection.has_anchor(spline, anchor) => {
            selection.select_anchor(spline, anchor);
        }
        Target::Control { spline, kind: ControlKind::Handle(anchor, _) } if !selection.has_anchor(spline, anchor) => {
            selection.select_anchor(spline, anchor);
        }
        Target::Curve { spline, .. } if tool == Tool::Select && !selection.has_spline(spline) => {
            selection.select(spline);
        }
        _ => {}
    }
}

fn click(selection: &mut Selection, scene: &PointerScene, at: &Moment, count: u32) {
    let behind = if count > 1 { next_behind(selection, scene.all_under(at)) } else { None };
    let target = behind.unwrap_or(at.target);
    match (target, at.modifiers.shift) {
        (Target::Control { spline, kind: ControlKind::Anchor(anchor) }, true) => {
            selection.toggle_anchor(spline, anchor)
        }
        (Target::Control { spline, kind: ControlKind::Anchor(anchor) }, false) => {
            selection.select_anchor(spline, anchor)
        }
        (Target::Control { spline, kind: ControlKind::Handle(anchor, _) }, false) => {
            selection.select_anchor(spline, anchor)
        }
        (Target::Curve { spline, .. } | Target::Line { line: spline, .. }, true) => selection.toggle(spline),
        (Target::Curve { spline, .. } | Target::Line { line: spline, .. }, false) => selection.select(spline),
        (Target::Surface | Target::Nothing, false) => selection.clear(),
        _ => {}
    }
}

/// A second click at the same place takes what comes behind what is selected, and after the last the first.
fn next_behind(selection: &Selection, mut all: Vec<Target>) -> Option<Target> {
    // A handle is selected by its anchor.
    all.retain(|target| !matches!(target, Target::Control { kind: ControlKind::Handle(..), .. }));
    let is_selected = |target: &Target| match *target {
        Target::Control { spline, kind: ControlKind::Anchor(anchor) } => selection.anchors() == [(spline, anchor)],
        Target::Curve { spline, .. } | Target::Line { line: spline, .. } => {
            selection.splines() == [spline] && selection.anchors().is_empty()
        }
        _ => false,
    };
    let next = all.iter().position(is_selected).map_or(0, |place| place + 1);
    all.get(next).or(all.first()).copied()
}

/// Selects all anchors in the box, and their splines.
fn select_box(selection: &mut Selection, picker: &Picker, from: &Moment, part: Rect) {
    if !from.modifiers.shift {
        selection.clear();
    }
    for (spline, anchor) in picker.anchors_in(from.camera, part) {
        selection.add_anchor(spline, anchor);
    }
}
