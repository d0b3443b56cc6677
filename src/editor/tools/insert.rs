//! The tool that adds anchors to a curve.

use bevy::prelude::*;

use super::{PointerEvent, Target, Tool, ToolPointer};
use crate::curve::SplineEdit;
use crate::editor::notices::Notices;
use crate::editor::selection::Selection;
use crate::plugin::EditSpline;
use crate::surface::SurfacePoint;

/// Where a click would insert an anchor: the spline, and the place.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct InsertPreview(pub(crate) Option<(Entity, SurfacePoint)>);

pub(crate) fn insert(
    tool: Res<Tool>,
    pointer: Res<ToolPointer>,
    mut preview: ResMut<InsertPreview>,
    mut selection: ResMut<Selection>,
    mut notices: ResMut<Notices>,
    mut edits: MessageWriter<EditSpline>,
) {
    if *tool != Tool::Insert {
        preview.set_if_neq(InsertPreview(None));
        return;
    }
    let hovered = pointer.hover.and_then(|moment| match moment.target {
        Target::Curve { spline, hit } => Some((spline, hit.point)),
        _ => None,
    });
    preview.set_if_neq(InsertPreview(hovered));
    for event in &pointer.events {
        let PointerEvent::Click { at, .. } = event else { continue };
        match at.target {
            Target::Curve { spline, hit } => {
                edits.write(EditSpline::new(spline, SplineEdit::Insert { at: hit.t }).undoable());
                selection.select_anchor_next(spline, hit.t.0.max(0.0).floor() as u32 + 1);
            }
            Target::Surface | Target::Nothing => {
                selection.clear();
                notices.info("Click on a curve: the anchor is added where it is clicked.");
            }
            Target::Line { .. } => notices.info("A drawn line has no anchors: make a spline of it first (Properties)."),
            Target::Control { .. } | Target::Gizmo(_) => {}
        }
    }
}
