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
            JumpPolicy::Allow => {}
            JumpPolicy::Sticky => next.lead_middles(surface, finder, self, &led)?,
            JumpPolicy::AutoSplit => {
                if let Some(segment) = next.first_jump(surface, finder, self, &led)? {
                    // One split a move: where that is not enough, the next move of the drag splits again.
                    let mut split = self.insertion(surface, finder, SplineT(segment as f64 + 0.5))?.spline;
                    next = if let SplineEdit::DragHandle { anchor, side, .. } = edit {
                        // The insertion moved the handle, and yet it is to go where the drag leads it.
                        let dragged = next.anchors[self.index(*anchor)?].handle(*side).clone();
                        let anchor = split.index(after_split(*anchor, segment as u32))?;
                        split.place_handle(surface, anchor, *side, dragged)?;
                        split
                    } else {
                        split.moved(surface, finder, &shifted(edit, segment as u32))?.0
                    };
                }
            }
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

/// The number of an anchor after another was inserted in a segment.
fn after_split(anchor: u32, segment: u32) -> u32 {
    if anchor > segment { anchor + 1 } else { anchor }
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
        *anchor = after_split(*anchor, segment);
    }
    edit
}
