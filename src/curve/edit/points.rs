//! Edits that move control points and leave their number as it is.

use super::{EditError, HandleSide, JumpPolicy, SplineEdit, jumps::Led};
use crate::curve::{Anchor, Handle, Join, Spline, SplineT, handles};
use crate::geodesic::{GeodesicPath, PathFinder, Tangent, inner::InnerPath};
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
                    next.place_handle(surface, finder, anchor, *side, handle.clone())?;
                    (next, Led::Nothing)
                }
                _ => base.moved(surface, finder, &edit)?,
            };
        }
        Ok(next)
    }

    /// The spline with what the edit says moved, and all that depends on it but middle legs.
    fn moved(&self, surface: &Surface, finder: &mut PathFinder, edit: &SplineEdit) -> Result<(Self, Led), EditError> {
        let mut next = self.clone();
        let led = match edit {
            // What led there counts where middle legs are to follow.
            _ if self.jumps == JumpPolicy::Allow => Led::Nothing,
            SplineEdit::DragAnchor { anchor, along } => {
                Led::Anchor { anchor: self.index(*anchor)?, along: InnerPath::from_outer(surface, along)? }
            }
            SplineEdit::DragHandle { anchor, side, along } => {
                let along = InnerPath::from_outer(surface, along)?;
                Led::Handle { anchor: self.index(*anchor)?, side: *side, along }
            }
            SplineEdit::MoveAnchor { anchor, to } => {
                let i = self.index(*anchor)?;
                let along = finder.shortest(surface, &self.anchors[i].point, to)?;
                Led::Anchor { anchor: i, along: InnerPath::from_outer(surface, &along)? }
            }
            _ => Led::Nothing,
        };
        next.move_points(surface, finder, edit)?;
        Ok((next, led))
    }

    /// Moves what the edit says, and all that depends on it but middle legs.
    ///
    /// # Errors
    /// [`EditError`]; the spline is then neither as it was nor as it should be.
    fn move_points(&mut self, surface: &Surface, finder: &mut PathFinder, edit: &SplineEdit) -> Result<(), EditError> {
        match edit {
            SplineEdit::MoveAnchor { anchor, to } => {
                let from = self.anchors[self.index(*anchor)?].point;
                if from.same_bits(&handles::without_negative_zeros(*to)) {
                    return Ok(());
                }
                let path = finder.shortest(surface, &from, to)?;
                self.lead_anchor(surface, finder, *anchor, &path, *to)
            }
            SplineEdit::DragAnchor { anchor, along } => {
                let i = self.index(*anchor)?;
                if !surface.same_place(&along.start(), &self.anchors[i].point) {
                    return Err(EditError::BadDrag { anchor: *anchor });
                }
                self.lead_anchor(surface, finder, *anchor, along, along.end())
            }
            SplineEdit::MoveHandle { anchor, side, to } => {
                let i = self.index(*anchor)?;
                let moved = handles::towards(surface, finder, &self.anchors[i].point, to)?;
                self.place_handle(surface, finder, i, *side, moved)
            }
            SplineEdit::FreeHandle { anchor, side, to } => {
                let i = self.index(*anchor)?;
                let moved = handles::towards(surface, finder, &self.anchors[i].point, to)?;
                self.anchors[i].join = Join::Corner;
                self.place_handle(surface, finder, i, *side, moved)
            }
            SplineEdit::DragHandle { anchor, side, along } => {
                let i = self.index(*anchor)?;
                if !surface.same_place(&along.start(), &self.anchors[i].handle(*side).point()) {
                    return Err(EditError::BadDrag { anchor: *anchor });
                }
                self.lead_handle(surface, finder, i, *side, along)
            }
            SplineEdit::SetJoin { anchor, join } => self.set_join(surface, finder, *anchor, *join),
            _ => Ok(()),
        }
    }

    /// Becomes what another spline is after an edit, keeping memory: for the steps of a drag, which all start from the spline as
    /// it was before.
    ///
    /// The result is that of [`apply`](Self::apply), bit for bit. Once warm, nothing is allocated for
    /// [`DragAnchor`](SplineEdit::DragAnchor) and [`DragHandle`](SplineEdit::DragHandle) where the policy is
    /// [`Allow`](JumpPolicy::Allow) and no handle around is automatic.
    ///
    /// # Errors
    /// As [`apply`](Self::apply); the spline is then a copy of `before`.
    pub fn assign_after(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        before: &Self,
        edit: &SplineEdit,
    ) -> Result<(), EditError> {
        self.clone_from(before);
        let moves = matches!(edit, SplineEdit::DragAnchor { .. } | SplineEdit::DragHandle { .. });
        if !moves || self.jumps != JumpPolicy::Allow || self.scheme.method.is_b_spline() {
            *self = before.after(surface, finder, edit)?;
            return Ok(());
        }
        let moved = self.move_points(surface, finder, edit);
        if moved.is_err() {
            self.clone_from(before);
        }
        moved
    }

    fn lead_anchor(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        anchor: u32,
        path: &GeodesicPath,
        to: SurfacePoint,
    ) -> Result<(), EditError> {
        let i = self.index(anchor)?;
        handles::carry(surface, finder, &mut self.anchors[i], path, handles::without_negative_zeros(to))?;
        self.place_automatic_around(surface, finder, i)
    }

    /// Leads a handle along a path that begins at it.
    fn lead_handle(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        anchor: usize,
        side: HandleSide,
        along: &GeodesicPath,
    ) -> Result<(), EditError> {
        let [mut old, mut way, mut leg] = [(); 3].map(|()| finder.lend_path());
        let own = self.anchors[anchor].handle_mut(side);
        old.set_outer(surface, &own.leg)?;
        way.set_outer(surface, along)?;
        finder.chained_into(surface, &[&old, &way], &mut leg)?;
        let heading = own.heading;
        handles::set_along(surface, &leg, own);
        [old, way, leg].into_iter().for_each(|path| finder.take_path_back(path));
        self.place_partner(surface, finder, anchor, side, heading)
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
        finder: &mut PathFinder,
        anchor: usize,
        side: HandleSide,
        moved: Handle,
    ) -> Result<(), EditError> {
        let before = std::mem::replace(self.anchors[anchor].handle_mut(side), moved);
        self.place_partner(surface, finder, anchor, side, before.heading)
    }

    /// Places the partner of a handle that was moved, where their join asks for it; a handle that lost its length keeps the
    /// heading it had.
    fn place_partner(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        anchor: usize,
        side: HandleSide,
        heading: Tangent,
    ) -> Result<(), EditError> {
        let Anchor { point, join, incoming, outgoing, .. } = &mut self.anchors[anchor];
        if *join == Join::Automatic {
            *join = Join::Smooth;
        }
        let (own, partner) = match side {
            HandleSide::Incoming => (incoming, outgoing),
            HandleSide::Outgoing => (outgoing, incoming),
        };
        if !handles::has_say(surface, own) {
            own.heading = heading;
            return Ok(());
        }
        let length = match join {
            Join::Corner | Join::Automatic => return Ok(()),
            Join::Smooth => partner.wished_length,
            Join::Mirrored => own.wished_length,
        };
        let mut spare = finder.lend_path();
        handles::set_opposite(surface, &mut spare, point, own, length, partner)?;
        finder.take_path_back(spare);
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

    fn handle_mut(&mut self, side: HandleSide) -> &mut Handle {
        match side {
            HandleSide::Incoming => &mut self.incoming,
            HandleSide::Outgoing => &mut self.outgoing,
        }
    }
}

/// The same edit after an anchor was inserted in a segment.
fn shifted(edit: &SplineEdit, segment: u32) -> SplineEdit {
    let mut edit = edit.clone();
    if let SplineEdit::MoveAnchor { anchor, .. }
    | SplineEdit::DragAnchor { anchor, .. }
    | SplineEdit::MoveHandle { anchor, .. }
    | SplineEdit::FreeHandle { anchor, .. }
    | SplineEdit::DragHandle { anchor, .. }
    | SplineEdit::SetJoin { anchor, .. } = &mut edit
    {
        *anchor += u32::from(*anchor > segment);
    }
    edit
}
