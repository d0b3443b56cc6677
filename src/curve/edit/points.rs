//! Edits that move control points and leave their number as it is.

use super::{EditError, HandleSide, JumpPolicy, SplineEdit, jumps::Led};
use crate::curve::{Anchor, Handle, Join, Spline, SplineT, handles};
use crate::geodesic::{GeodesicPath, PathFinder, inner::InnerPath};
use crate::surface::{Surface, SurfacePoint};

impl Spline {
    /// The spline after an edit that moves control points, with what the policy asks for where a middle leg jumps.
    pub(super) fn after_move(
        &self,
        surface: &Surface,
        finder: &mut PathFinder,
        edit: &SplineEdit,
    ) -> Result<Self, EditError> {
        let (mut next, led) = self.moved(surface, finder, edit)?;
        if self.scheme.method.is_b_spline() {
            next.settle_middles(surface, finder)?;
            return Ok(next);
        }
        match self.jumps {
            JumpPolicy::Allow => Ok(next),
            JumpPolicy::Sticky => {
                next.lead_middles(surface, finder, self, &led)?;
                Ok(next)
            }
            JumpPolicy::AutoSplit => self.after_splits(surface, finder, edit, next, led),
        }
    }

    /// The spline after a move, with anchors inserted in the middle of segments that would jump, as often as that helps.
    fn after_splits(
        &self,
        surface: &Surface,
        finder: &mut PathFinder,
        edit: &SplineEdit,
        moved: Self,
        led: Led,
    ) -> Result<Self, EditError> {
        /// Each split halves what is left of the segment on the side that jumps.
        const MAX_SPLITS: u32 = 6;
        // An insertion shortens the handles around, and yet a handle is to go where its drag leads it.
        let dragged = match edit {
            SplineEdit::DragHandle { anchor, side, .. } => {
                Some(moved.anchors[self.index(*anchor)?].handle(*side).clone())
            }
            _ => None,
        };
        let (mut base, mut next, mut led, mut edit) = (self.clone(), moved, led, edit.clone());
        for _ in 0..MAX_SPLITS {
            let Some(segment) = next.first_jump(surface, finder, &base, &led)? else { break };
            base = base.insertion(surface, finder, SplineT(segment as f64 + 0.5))?.spline;
            edit = shifted(&edit, segment as u32);
            (next, led) = match (&edit, &dragged) {
                (SplineEdit::DragHandle { anchor, side, .. }, Some(handle)) => {
                    let mut next = base.clone();
                    let anchor = next.index(*anchor)?;
                    next.place_handle(surface, anchor, *side, handle.clone())?;
                    (next, Led::Nothing)
                }
                _ => base.moved(surface, finder, &edit)?,
            };
        }
        Ok(next)
    }

    /// Moves what the edit says, and all that depends on it but middle legs.
    fn moved(&self, surface: &Surface, finder: &mut PathFinder, edit: &SplineEdit) -> Result<(Self, Led), EditError> {
        let mut next = self.clone();
        let led = match edit {
            SplineEdit::MoveAnchor { anchor, to } => {
                let from = self.anchors[self.index(*anchor)?].point;
                if from.same_bits(&handles::without_negative_zeros(*to)) {
                    return Ok((next, Led::Nothing));
                }
                let path = finder.shortest(surface, &from, to)?;
                next.lead_anchor(surface, finder, *anchor, &path, *to)?
            }
            SplineEdit::DragAnchor { anchor, along } => {
                let i = self.index(*anchor)?;
                if !surface.same_place(&along.start(), &self.anchors[i].point) {
                    return Err(EditError::BadDrag { anchor: *anchor });
                }
                next.lead_anchor(surface, finder, *anchor, along, along.end())?
            }
            SplineEdit::MoveHandle { anchor, side, to } => {
                let i = self.index(*anchor)?;
                let moved = handles::towards(surface, finder, &self.anchors[i].point, to)?;
                next.place_handle(surface, i, *side, moved)?;
                Led::Nothing
            }
            SplineEdit::DragHandle { anchor, side, along } => {
                let i = self.index(*anchor)?;
                let old = self.anchors[i].handle(*side);
                if !surface.same_place(&along.start(), &old.point()) {
                    return Err(EditError::BadDrag { anchor: *anchor });
                }
                let (leg, along) = (InnerPath::from_outer(surface, &old.leg)?, InnerPath::from_outer(surface, along)?);
                let leg = finder.chained(surface, &[&leg, &along])?;
                next.place_handle(surface, i, *side, handles::along(surface, &leg))?;
                Led::Handle { anchor: i, side: *side, along }
            }
            SplineEdit::SetJoin { anchor, join } => {
                next.set_join(surface, finder, *anchor, *join)?;
                Led::Nothing
            }
            _ => Led::Nothing,
        };
        Ok((next, led))
    }

    fn lead_anchor(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        anchor: u32,
        path: &GeodesicPath,
        to: SurfacePoint,
    ) -> Result<Led, EditError> {
        let i = self.index(anchor)?;
        let to = handles::without_negative_zeros(to);
        self.anchors[i] = handles::carry(surface, &self.anchors[i], path, to)?;
        self.place_automatic_around(surface, finder, i)?;
        Ok(Led::Anchor { anchor: i, along: InnerPath::from_outer(surface, path)? })
    }

    /// Places the handles of an anchor and of its neighbours where these are automatic.
    pub(super) fn place_automatic_around(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        anchor: usize,
    ) -> Result<(), EditError> {
        let (before, after) = self.neighbours(anchor);
        for i in [before, Some(anchor), after].into_iter().flatten() {
            if self.anchors[i].join == Join::Automatic {
                handles::place_automatic(surface, finder, self, i)?;
            }
        }
        Ok(())
    }

    /// Puts a handle in its place, and its partner where their join asks for it.
    fn place_handle(
        &mut self,
        surface: &Surface,
        anchor: usize,
        side: HandleSide,
        mut moved: Handle,
    ) -> Result<(), EditError> {
        let anchor = &mut self.anchors[anchor];
        let point = anchor.point;
        if anchor.join == Join::Automatic {
            anchor.join = Join::Smooth;
        }
        let join = anchor.join;
        let (own, partner) = match side {
            HandleSide::Incoming => (&mut anchor.incoming, &mut anchor.outgoing),
            HandleSide::Outgoing => (&mut anchor.outgoing, &mut anchor.incoming),
        };
        if handles::has_say(surface, &moved) {
            match join {
                Join::Corner | Join::Automatic => {}
                Join::Smooth => *partner = handles::opposite(surface, &point, &moved, partner.wished_length)?,
                Join::Mirrored => *partner = handles::opposite(surface, &point, &moved, moved.wished_length)?,
            }
        } else {
            moved.heading = own.heading;
        }
        *own = moved;
        Ok(())
    }

    fn set_join(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        anchor: u32,
        join: Join,
    ) -> Result<(), EditError> {
        let i = self.index(anchor)?;
        self.anchors[i].join = join;
        match join {
            Join::Corner => {}
            Join::Smooth => handles::align(surface, &mut self.anchors[i], false)?,
            Join::Mirrored => handles::align(surface, &mut self.anchors[i], true)?,
            Join::Automatic => handles::place_automatic(surface, finder, self, i)?,
        }
        Ok(())
    }
}

impl Anchor {
    /// One of its handles.
    pub fn handle(&self, side: HandleSide) -> &Handle {
        match side {
            HandleSide::Incoming => &self.incoming,
            HandleSide::Outgoing => &self.outgoing,
        }
    }
}

/// The same edit after an anchor was inserted in a segment.
fn shifted(edit: &SplineEdit, segment: u32) -> SplineEdit {
    let mut edit = edit.clone();
    if let SplineEdit::MoveAnchor { anchor, .. }
    | SplineEdit::DragAnchor { anchor, .. }
    | SplineEdit::MoveHandle { anchor, .. }
    | SplineEdit::DragHandle { anchor, .. }
    | SplineEdit::SetJoin { anchor, .. } = &mut edit
    {
        *anchor += u32::from(*anchor > segment);
    }
    edit
}
