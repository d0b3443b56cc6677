//! Changes to a spline, as plain data with inverses.

mod delete;
mod insert;
mod jumps;
mod patch;
mod points;
mod structure;
mod transform;

pub use delete::Deletion;
pub use insert::Insertion;
pub use jumps::JumpPolicy;
pub use patch::SplinePatch;
pub(crate) use transform::check_matrix;
pub use transform::{SelectionTransform, Transformed};

use super::{Join, Scheme, Spline, SplineT, TraceError};
use crate::geodesic::{GeodesicPath, PathError, PathFinder};
use crate::surface::{PointError, Surface, SurfacePoint};

/// One of the two handles of an anchor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum HandleSide {
    /// The handle of the segment that ends at the anchor.
    Incoming,
    /// The handle of the segment that begins at the anchor.
    Outgoing,
}

/// One of the two ends of an open spline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum SplineEnd {
    /// The first anchor.
    Start,
    /// The last anchor.
    End,
}

/// A change to a spline.
///
/// Editor, undo, tests and game code all send these; [`Spline::apply`] gives the inverse.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum SplineEdit {
    /// Moves an anchor; its handles are carried along by parallel transport on the shortest path, and keep their lengths.
    MoveAnchor {
        /// Which anchor.
        anchor: u32,
        /// Where to.
        to: SurfacePoint,
    },
    /// Moves an anchor along a path, which begins at it: [`MoveAnchor`](Self::MoveAnchor) with a way of one's own.
    DragAnchor {
        /// Which anchor.
        anchor: u32,
        /// The way it takes; see [`PathFinder::continued`].
        along: GeodesicPath,
    },
    /// Moves a handle; its leg is the shortest path. At a smooth join the partner turns with it and keeps its length, at a
    /// mirrored one it takes the length too. An automatic join becomes smooth.
    MoveHandle {
        /// Which anchor.
        anchor: u32,
        /// Which of its handles.
        side: HandleSide,
        /// Where to.
        to: SurfacePoint,
    },
    /// Moves a handle by itself: the join becomes a corner, and the partner stays where it is.
    FreeHandle {
        /// Which anchor.
        anchor: u32,
        /// Which of its handles.
        side: HandleSide,
        /// Where to.
        to: SurfacePoint,
    },
    /// Moves a handle along a path, which begins at it; its leg is led along and stays on the side of hills and holes that
    /// it is on. Partners as with [`MoveHandle`](Self::MoveHandle).
    DragHandle {
        /// Which anchor.
        anchor: u32,
        /// Which of its handles.
        side: HandleSide,
        /// The way it takes; see [`PathFinder::continued`].
        along: GeodesicPath,
    },
    /// Moves, turns, scales or shears anchors with their handles about a point: see [`Spline::transformed`].
    Transform(SelectionTransform),
    /// Adds an anchor, a corner with handles of no length, beyond an end of an open spline.
    Append {
        /// Which end.
        end: SplineEnd,
        /// Where.
        at: SurfacePoint,
    },
    /// Adds a smooth anchor on the curve, which stays where it is as well as it can: see [`Spline::insertion`]. Of a
    /// B-spline, adds a control point, which changes the curve near it.
    Insert {
        /// Where on the curve, not at an anchor.
        at: SplineT,
    },
    /// Removes an anchor. Between two others, their segments become one with the outer tangents, its handles longer by
    /// the share that went; a mirrored neighbour becomes smooth, since one of its handles alone grew.
    Delete {
        /// Which anchor.
        anchor: u32,
    },
    /// Removes an anchor as [`Delete`](Self::Delete) does, and lets the new segment follow the two old ones as well as it can:
    /// see [`Spline::deletion`].
    DeleteFitted {
        /// Which anchor.
        anchor: u32,
    },
    /// Changes how the handles of an anchor depend on each other, and moves them as that asks.
    SetJoin {
        /// Which anchor.
        anchor: u32,
        /// How.
        join: Join,
    },
    /// Makes a segment the shortest path between its anchors, with handles at its thirds; both anchors become corners.
    Straighten {
        /// Which segment.
        segment: u32,
    },
    /// Joins the last anchor of an open spline to the first: by a segment, or, where they are in one place, as one anchor.
    Close,
    /// Cuts a closed spline at an anchor, where it then begins and ends.
    Open {
        /// Which anchor.
        anchor: u32,
    },
    /// Lets the spline run the other way; a closed one begins at the same anchor.
    Reverse,
    /// Keeps the part of an open spline before or behind an anchor, the anchor included.
    Cut {
        /// Which anchor.
        anchor: u32,
        /// Which end's part is kept.
        keep: SplineEnd,
    },
    /// Adds another open spline at an end: by a segment, or, where the two ends are in one place, by one anchor.
    Join {
        /// Which end of this spline.
        end: SplineEnd,
        /// The other spline.
        other: Spline,
        /// Which of its ends.
        at: SplineEnd,
    },
    /// Changes how the spline is traced.
    SetScheme(Scheme),
    /// Changes what happens where a leg could go another, shorter way.
    SetJumps(JumpPolicy),
    /// Replaces everything.
    Replace(Spline),
    /// Puts back what another edit changed, bit for bit: the inverses are of this kind.
    Restore(SplinePatch),
}

/// Why an edit was refused; the spline is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    /// No such anchor.
    #[error("there is no anchor {anchor}: the spline has {count}, counted from 0")]
    NoSuchAnchor {
        /// The anchor asked for.
        anchor: u32,
        /// How many there are.
        count: usize,
    },
    /// No such segment.
    #[error("there is no segment {segment}: the spline has {count}, counted from 0")]
    NoSuchSegment {
        /// The segment asked for.
        segment: u32,
        /// How many there are.
        count: usize,
    },
    /// A closed spline has no ends.
    #[error("a closed spline has no end to add to or to cut at: open it first")]
    Closed,
    /// An open spline cannot be opened.
    #[error("the spline is open already: cut it instead")]
    Open,
    /// Too few anchors would be left.
    #[error("a spline keeps at least two anchors, a closed one at least one: remove the spline instead")]
    TooFewAnchors,
    /// There is an anchor at the place of the new one.
    #[error("there is an anchor at parameter {t} already: insert between two")]
    AtAnchor {
        /// The parameter.
        t: f64,
    },
    /// A length or an angle of the scheme is not a number.
    #[error("a length or an angle of the scheme is not a number: give numbers")]
    BadScheme,
    /// A transform is not finite, flattens everything to a line or a point, or its axis has no length.
    #[error(
        "the transform is not finite, flattens everything or has an axis of no length: give numbers, a scale that is not \
         zero and a direction"
    )]
    BadTransform,
    /// The patch was made for another version of the spline.
    #[error("this restores another version of the spline: undo what came after it first")]
    OtherVersion,
    /// A handle of a whole spline does not begin at its anchor, or its length is not a length.
    #[error("a handle of anchor {anchor} does not belong to it: make the spline anew on this surface")]
    BadHandle {
        /// Which anchor.
        anchor: u32,
    },
    /// The path of a drag does not begin at what it drags.
    #[error("the path to drag anchor {anchor} along does not begin at it, or at its handle: begin it there")]
    BadDrag {
        /// Which anchor.
        anchor: u32,
    },
    /// A point does not belong to the surface.
    #[error(transparent)]
    Point(#[from] PointError),
    /// The place cannot be reached.
    #[error(transparent)]
    Path(#[from] PathError),
    /// The curve cannot be evaluated where that is needed.
    #[error(transparent)]
    Trace(#[from] TraceError),
}

impl Spline {
    /// Applies an edit and gives its inverse, which holds what was touched exactly as it was.
    ///
    /// Cost: a few shortest paths and walks; nothing is traced. An insertion evaluates old and new curve at 33 places.
    ///
    /// # Errors
    /// [`EditError`] if the edit names an anchor or a place that is not there; the spline is then as it was.
    pub fn apply(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        edit: &SplineEdit,
    ) -> Result<SplineEdit, EditError> {
        let next = self.after(surface, finder, edit)?;
        let inverse = SplinePatch::between(&next, self);
        *self = next;
        Ok(SplineEdit::Restore(inverse))
    }

    /// The spline as it is after an edit.
    fn after(&self, surface: &Surface, finder: &mut PathFinder, edit: &SplineEdit) -> Result<Self, EditError> {
        let mut next = self.clone();
        match edit {
            SplineEdit::MoveAnchor { .. }
            | SplineEdit::DragAnchor { .. }
            | SplineEdit::MoveHandle { .. }
            | SplineEdit::FreeHandle { .. }
            | SplineEdit::DragHandle { .. }
            | SplineEdit::SetJoin { .. } => return self.after_move(surface, finder, edit),
            SplineEdit::Transform(transform) => return Ok(self.transformed(surface, finder, transform)?.spline),
            SplineEdit::Append { end, at } => next.append(surface, finder, *end, *at)?,
            SplineEdit::Insert { at } => next = self.insertion(surface, finder, *at)?.spline,
            SplineEdit::Delete { anchor } => next.delete(surface, finder, *anchor)?,
            SplineEdit::DeleteFitted { anchor } => return Ok(self.deletion(surface, finder, *anchor)?.spline),
            SplineEdit::Straighten { segment } => next.straighten(surface, finder, *segment)?,
            SplineEdit::Close => next.close(surface, finder)?,
            SplineEdit::Open { anchor } => next.open(*anchor)?,
            SplineEdit::Reverse => next.reverse(surface)?,
            SplineEdit::Cut { anchor, keep } => next.cut(*anchor, *keep)?,
            SplineEdit::Join { end, other, at } => next.join(surface, finder, *end, other, *at)?,
            SplineEdit::SetScheme(scheme) if !scheme.is_sound() => return Err(EditError::BadScheme),
            SplineEdit::SetScheme(scheme) => next.scheme = *scheme,
            SplineEdit::SetJumps(jumps) => next.jumps = *jumps,
            SplineEdit::Replace(spline) => {
                spline.check(surface)?;
                next = spline.clone();
            }
            SplineEdit::Restore(patch) => {
                next.restore(patch)?;
                return Ok(next);
            }
        }
        next.settle_middles(surface, finder)?;
        Ok(next)
    }

    pub(super) fn index(&self, anchor: u32) -> Result<usize, EditError> {
        let count = self.anchors.len();
        if (anchor as usize) < count { Ok(anchor as usize) } else { Err(EditError::NoSuchAnchor { anchor, count }) }
    }

    /// The anchors that a Bézier segment joins.
    pub(super) fn segment_anchors(&self, segment: u32) -> Result<[usize; 2], EditError> {
        let n = self.anchors.len();
        let count = if self.closed { n } else { n.saturating_sub(1) };
        let i = segment as usize;
        if i < count { Ok([i, (i + 1) % n]) } else { Err(EditError::NoSuchSegment { segment, count }) }
    }
}
