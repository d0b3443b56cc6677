//! Actions on the shape of curves: how they go on at anchors, where they end, cut in two and joined.

use bevy::prelude::*;

use super::Desk;
use crate::curve::{Join, Spline, SplineEdit, SplineEnd};
use crate::editor::tools::Tool;

impl Desk<'_, '_> {
    pub(super) fn cycle_join(&mut self) {
        let active = self.selection.anchors().last().copied();
        if active.is_none() {
            *self.tool = Tool::Join;
        }
        let join = active.and_then(|(spline, anchor)| join_of(self.spline(spline)?, anchor));
        if let Some(join) = join {
            self.set_joins(next_join(join));
        }
    }

    pub(super) fn set_joins(&mut self, join: Join) {
        let anchors = self.selection.anchors().to_vec();
        let name = format!("Make {} anchors {}", anchors.len(), name_of_join(join));
        if anchors.len() > 1 {
            self.history.begin(name);
        }
        for (entity, anchor) in &anchors {
            let Some(spline) = self.spline(*entity).filter(|spline| !spline.scheme().method.is_b_spline()) else {
                continue;
            };
            edits_for_join(spline, *anchor, join).into_iter().for_each(|edit| self.send(*entity, edit));
        }
        if anchors.len() > 1 {
            self.history.end();
        }
    }

    pub(super) fn toggle_closed(&mut self) {
        let active = self.selection.anchors().last().copied();
        let splines = self.selection.splines().to_vec();
        let many = splines.len() > 1;
        if many {
            self.history.begin("Close or open curves");
        }
        for entity in splines {
            let Some(spline) = self.spline(entity) else { continue };
            let at = active.filter(|(of, _)| *of == entity).map_or(0, |(_, anchor)| anchor);
            let edit = if spline.is_closed() { SplineEdit::Open { anchor: at } } else { SplineEdit::Close };
            self.send(entity, edit);
        }
        if many {
            self.history.end();
        }
    }

    pub(super) fn split(&mut self) {
        let Some((entity, anchor)) = self.selection.anchors().last().copied() else {
            self.notices.info("Select the anchor at which the curve is to be cut.");
            return;
        };
        let Ok((spline, on)) = self.splines.get(entity) else { return };
        let (spline, on): (Spline, Entity) = ((**spline).clone(), on.0);
        if spline.is_closed() {
            self.send(entity, SplineEdit::Open { anchor });
            return;
        }
        if anchor == 0 || anchor as usize + 1 == spline.anchors().len() {
            self.notices.info("The curve ends here: select an anchor between its ends to cut it there.");
            return;
        }
        match spline.split(anchor) {
            Ok([_, behind]) => {
                self.history.begin("Split spline");
                self.send(entity, SplineEdit::Cut { anchor, keep: SplineEnd::Start });
                self.spawn(on, behind, entity);
                self.history.end();
            }
            Err(error) => self.notices.warn(error.to_string()),
        }
    }

    pub(super) fn join(&mut self) {
        let [.., other, active] = self.selection.splines() else {
            self.notices.info("Select the two curves that are to be joined.");
            return;
        };
        let (other, active) = (*other, *active);
        let (Ok((kept, on)), Ok((added, on_too))) = (self.splines.get(other), self.splines.get(active)) else { return };
        if on.0 != on_too.0 || kept.is_closed() || added.is_closed() {
            self.notices.warn("Only open curves of one model can be joined: open them first.");
            return;
        }
        let Ok(surface) = self.surfaces.get(on.0) else { return };
        let place = |spline: &Spline, end: SplineEnd| {
            let anchor = if end == SplineEnd::Start { spline.anchors().first() } else { spline.anchors().last() };
            anchor.map(|anchor| surface.position(&anchor.point()))
        };
        // A selected end is meant; of two that are not, the nearer.
        let meant = |entity: Entity, spline: &Spline, end: SplineEnd| {
            let number = if end == SplineEnd::Start { 0 } else { spline.anchors().len().saturating_sub(1) as u32 };
            self.selection.has_anchor(entity, number)
        };
        let ends = [SplineEnd::Start, SplineEnd::End];
        let pairs = ends.into_iter().flat_map(|a| ends.map(|b| (a, b)));
        let cost = |(a, b): &(SplineEnd, SplineEnd)| {
            let apart = place(kept, *a).zip(place(added, *b)).map_or(f64::INFINITY, |(a, b)| a.distance(b));
            let unmeant = u8::from(!meant(other, kept, *a)) + u8::from(!meant(active, added, *b));
            (unmeant, apart)
        };
        let best = pairs.min_by(|x, y| {
            let ((u, d), (v, e)) = (cost(x), cost(y));
            u.cmp(&v).then(d.total_cmp(&e))
        });
        let Some((end, at)) = best else { return };
        let edit = SplineEdit::Join { end, other: (**added).clone(), at };
        self.history.begin("Join splines");
        self.remove("Remove spline", active);
        self.send(other, edit);
        self.history.end();
        self.selection.select(other);
        self.selection.clear_anchors();
    }

    pub(super) fn straighten(&mut self) {
        let Some((entity, anchor)) = self.selection.anchors().last().copied() else { return };
        let segments = self.spline(entity).map_or(0, Spline::segment_count);
        let segment = (anchor as usize).min(segments.saturating_sub(1)) as u32;
        self.send(entity, SplineEdit::Straighten { segment });
    }
}

fn join_of(spline: &Spline, anchor: u32) -> Option<Join> {
    spline.anchors().get(anchor as usize).map(|anchor| anchor.join())
}

fn next_join(join: Join) -> Join {
    match join {
        Join::Corner => Join::Smooth,
        Join::Smooth => Join::Mirrored,
        Join::Mirrored => Join::Automatic,
        Join::Automatic => Join::Corner,
    }
}

fn name_of_join(join: Join) -> &'static str {
    match join {
        Join::Corner => "corners",
        Join::Smooth => "smooth",
        Join::Mirrored => "mirrored",
        Join::Automatic => "automatic",
    }
}

/// Sets a join. Handles of no length have no direction that could be smooth: they are placed first.
fn edits_for_join(spline: &Spline, anchor: u32, join: Join) -> Vec<SplineEdit> {
    let Some(at) = spline.anchors().get(anchor as usize) else { return Vec::new() };
    let bare = at.incoming().leg().length() == 0.0 && at.outgoing().leg().length() == 0.0;
    let mut edits = Vec::new();
    if bare && matches!(join, Join::Smooth | Join::Mirrored) {
        edits.push(SplineEdit::SetJoin { anchor, join: Join::Automatic });
    }
    edits.push(SplineEdit::SetJoin { anchor, join });
    edits
}
