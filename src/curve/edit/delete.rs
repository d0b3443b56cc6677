//! Removing an anchor so that the curve stays where it is as well as one segment can.

use super::EditError;
use crate::curve::{Join, Spline, Trace, TraceWorkspace, fit, handles};
use crate::geodesic::PathFinder;
use crate::surface::Surface;

/// What removing an anchor makes of a spline.
#[derive(Clone, Debug, PartialEq)]
pub struct Deletion {
    /// The spline without the anchor.
    pub spline: Spline,
    /// A bound for the distance between the two old segments and the one in their place, in local units; zero where none took
    /// their place.
    pub deviation: f64,
    /// Length of the two old segments, in local units; zero where none took their place.
    pub length: f64,
}

impl Spline {
    /// Removes an anchor. Between two others, one segment takes the place of two: with the same outer tangents, and lengths of
    /// its two handles that bring its trace nearest to the two old ones, found by least squares.
    ///
    /// A mirrored or automatic neighbour becomes smooth. At an end, and of a B-spline, the anchor just goes.
    /// [`SplineEdit::DeleteFitted`](super::SplineEdit::DeleteFitted) does the same.
    ///
    /// Cost: nine traces of a segment.
    ///
    /// # Errors
    /// [`EditError::NoSuchAnchor`], [`EditError::TooFewAnchors`], and what tracing meets.
    pub fn deletion(&self, surface: &Surface, finder: &mut PathFinder, anchor: u32) -> Result<Deletion, EditError> {
        let mut spline = self.clone();
        spline.delete(surface, finder, anchor)?;
        let i = self.index(anchor)?;
        let mut made = Deletion { spline, deviation: 0.0, length: 0.0 };
        if let (Some(before), Some(after)) = self.neighbours(i)
            && !self.scheme.method.is_b_spline()
        {
            let mut workspace = TraceWorkspace { finder: std::mem::take(finder), ..TraceWorkspace::default() };
            let fitted = self.bridged(surface, &mut workspace, [before, i, after], &made.spline);
            *finder = workspace.finder;
            if let Some(fitted) = fitted? {
                made = fitted;
            }
        }
        made.spline.settle_middles(surface, finder)?;
        Ok(made)
    }

    /// The spline with one fitted segment instead of two; none where there is nothing to fit. `plain` is the spline with one that
    /// is not.
    fn bridged(
        &self,
        surface: &Surface,
        workspace: &mut TraceWorkspace,
        [before, gone, after]: [usize; 3],
        plain: &Self,
    ) -> Result<Option<Deletion>, EditError> {
        let old = self.two_segments(surface, workspace, [before, gone, after])?;
        let line = fit::DrawnLine::along(&old, false);
        let headings = [self.anchors[before].outgoing.heading, self.anchors[after].incoming.heading];
        let tangents = [surface.inner_tangent(&headings[0])?, surface.inner_tangent(&headings[1])?];
        if headings.iter().any(|heading| heading.length() <= 0.0) {
            return Ok(None);
        }
        let kept = |k: usize| if k > gone { k - 1 } else { k };
        let (first, last) = (kept(before), kept(after));
        let guess = [plain.anchors[first].outgoing.wished_length, plain.anchors[last].incoming.wished_length];
        let Some((lengths, deviation)) = fit::refit(surface, workspace, &line, self.scheme, tangents, guess)? else {
            return Ok(None);
        };
        let mut spline = self.clone();
        spline.anchors.remove(gone);
        let ends = [first, last].map(|k| spline.anchors[k].point);
        spline.anchors[first].outgoing = handles::ahead(surface, &ends[0], &tangents[0], lengths[0])?;
        spline.anchors[last].incoming = handles::ahead(surface, &ends[1], &tangents[1], lengths[1])?;
        for k in [first, last] {
            if matches!(spline.anchors[k].join, Join::Mirrored | Join::Automatic) {
                spline.anchors[k].join = Join::Smooth;
            }
        }
        Ok(Some(Deletion { spline, deviation, length: old.length() }))
    }

    /// The trace of the two segments about an anchor.
    fn two_segments(
        &self,
        surface: &Surface,
        workspace: &mut TraceWorkspace,
        around: [usize; 3],
    ) -> Result<Trace, EditError> {
        let mut anchors = around.map(|k| self.anchors[k].clone()).to_vec();
        anchors[2].middle = None;
        let part = Self { anchors, closed: false, ..*self };
        Ok(part.trace(surface, workspace, None)?)
    }
}
