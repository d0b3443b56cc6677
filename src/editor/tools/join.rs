//! The tool that changes joins.

use bevy::prelude::*;

use super::{PointerEvent, Target, Tool, ToolPointer};
use crate::editor::actions::EditorAction;
use crate::editor::notices::Notices;
use crate::editor::selection::Selection;
use crate::plugin::ControlKind;

pub(crate) fn click(
    tool: Res<Tool>,
    pointer: Res<ToolPointer>,
    mut selection: ResMut<Selection>,
    mut notices: ResMut<Notices>,
    mut actions: MessageWriter<EditorAction>,
) {
    if *tool != Tool::Join {
        return;
    }
    for event in &pointer.events {
        let PointerEvent::Click { at, .. } = event else { continue };
        match at.target {
            Target::Control { spline, kind: ControlKind::Anchor(anchor) | ControlKind::Handle(anchor, _) } => {
                selection.select_anchor(spline, anchor);
                actions.write(EditorAction::CycleJoin);
            }
            Target::Line { .. } => notices.info("A drawn line has no joins: make a spline of it first (Properties)."),
            Target::Gizmo(_) => {}
            // Its anchors appear, and can be clicked then.
            Target::Curve { spline, .. } => selection.select(spline),
            Target::Surface | Target::Nothing => {
                selection.clear();
                notices.info("Click on a curve to see its anchors, then on an anchor to change its join.");
            }
        }
    }
}
