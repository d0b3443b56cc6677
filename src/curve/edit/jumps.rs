//! What happens to middle legs, handle to handle, where another way becomes the shortest: at the cut locus.
//!
//! While a handle is dragged around a model, the shortest path to the next handle changes sides at some place, and the curve
//! jumps with it.

use super::{EditError, HandleSide};
use crate::curve::Spline;
use crate::geodesic::{PathError, PathFinder, PathQuality, inner::InnerPath};
use crate::surface::{PointError, Surface};

/// What happens where moving a control point makes another way the shortest between two handles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum JumpPolicy {
    /// The curve jumps to the shortest way: the trace depends on the control points alone.
    #[default]
    Allow,
    /// The leg stays on its side and belongs to the document; [`Spline::excess`] says how much longer it is.
    Sticky,
    /// An anchor is inserted in the middle of the segment before it jumps, and in the middle of what is left of it, up to six
    /// times a move.
    AutoSplit,
}

/// What was led along a path by a drag.
pub(super) enum Led {
    /// Nothing was: what moved did so by itself.
    Nothing,
    Anchor {
        anchor: usize,
        along: InnerPath,
    },
    Handle {
        anchor: usize,
        side: HandleSide,
        along: InnerPath,
    },
}

/// Ways whose points at the same shares are nearer than this share of their length are one way.
const APART: f64 = 0.05;

impl Spline {
    /// By what share the middle leg of a segment is longer than the shortest way; zero where it is the shortest, and for
    /// splines that are not sticky.
    ///
    /// # Errors
    /// [`PathError`] if the spline does not belong to the surface.
    pub fn excess(&self, surface: &Surface, finder: &mut PathFinder, segment: u32) -> Result<f64, PathError> {
        let middle = self.anchors.get(segment as usize).and_then(|anchor| anchor.middle.as_ref());
        let Some(middle) = middle else { return Ok(0.0) };
        let shortest = finder.shortest(surface, &middle.start(), &middle.end())?.length();
        Ok(if shortest > 0.0 { (middle.length() / shortest - 1.0).max(0.0) } else { 0.0 })
    }

    /// Sees to it that exactly those segments have a middle leg that are to have one, and that it joins their handles; what
    /// is missing is searched.
    pub(crate) fn settle_middles(&mut self, surface: &Surface, finder: &mut PathFinder) -> Result<(), PathError> {
        let sticky = self.jumps == JumpPolicy::Sticky;
        let n = self.anchors.len();
        for i in 0..n {
            if !sticky || (i + 1 == n && !self.closed) {
                self.anchors[i].middle = None;
                continue;
            }
            let [from, to] = [self.anchors[i].outgoing.point(), self.anchors[(i + 1) % n].incoming.point()];
            let fits = |middle: &crate::geodesic::GeodesicPath| {
                surface.same_place(&middle.start(), &from) && surface.same_place(&middle.end(), &to)
            };
            if !self.anchors[i].middle.as_ref().is_some_and(fits) {
                self.anchors[i].middle = Some(finder.shortest(surface, &from, &to)?);
            }
        }
        Ok(())
    }

    /// Leads the middle legs along with the handles they join; `before` has the same anchors elsewhere.
    pub(super) fn lead_middles(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        before: &Self,
        led: &Led,
    ) -> Result<(), EditError> {
        for i in 0..self.anchors.len() {
            let Some(middle) = before.anchors[i].middle.as_ref().filter(|_| !self.is_still(before, i)) else {
                continue;
            };
            let middle = InnerPath::from_outer(surface, middle)?;
            let led = self.led_middle(surface, finder, before, led, i, &middle)?;
            self.anchors[i].middle = Some(led.to_outer(surface));
        }
        self.settle_middles(surface, finder)?;
        Ok(())
    }

    /// The middle leg of a segment after its handles moved.
    fn led_middle(
        &self,
        surface: &Surface,
        finder: &mut PathFinder,
        before: &Self,
        led: &Led,
        segment: usize,
        middle: &InnerPath,
    ) -> Result<InnerPath, EditError> {
        let [from, to] = self.ends(segment);
        let mut start = self.way(surface, before, led, from)?;
        start.reverse();
        start.iter_mut().for_each(|path| path.reverse(surface));
        let end = self.way(surface, before, led, to)?;
        let pieces: Vec<&InnerPath> = start.iter().chain([middle]).chain(&end).collect();
        Ok(finder.chained(surface, &pieces)?)
    }

    /// The handles that a segment's middle leg joins.
    fn ends(&self, segment: usize) -> [(usize, HandleSide); 2] {
        [(segment, HandleSide::Outgoing), ((segment + 1) % self.anchors.len(), HandleSide::Incoming)]
    }

    /// Whether the handles of a segment are where they were.
    fn is_still(&self, before: &Self, segment: usize) -> bool {
        self.ends(segment)
            .into_iter()
            .all(|(i, side)| self.anchors[i].handle(side).leg == before.anchors[i].handle(side).leg)
    }

    /// The way a handle took: along the path it was led, or back to its anchor, with that, and out again.
    fn way(
        &self,
        surface: &Surface,
        before: &Self,
        led: &Led,
        (anchor, side): (usize, HandleSide),
    ) -> Result<Vec<InnerPath>, PointError> {
        let [old, new] = [before, self].map(|spline| &spline.anchors[anchor].handle(side).leg);
        if old == new {
            return Ok(Vec::new());
        }
        if let Led::Handle { anchor: a, side: s, along } = led
            && (*a, *s) == (anchor, side)
        {
            return Ok(vec![along.clone()]);
        }
        let mut back = InnerPath::from_outer(surface, old)?;
        back.reverse(surface);
        let mut way = vec![back];
        if let Led::Anchor { anchor: a, along } = led
            && *a == anchor
        {
            way.push(along.clone());
        }
        way.push(InnerPath::from_outer(surface, new)?);
        Ok(way)
    }

    /// The first segment whose shortest middle leg is not where the one before leads to.
    pub(super) fn first_jump(
        &self,
        surface: &Surface,
        finder: &mut PathFinder,
        before: &Self,
        led: &Led,
    ) -> Result<Option<usize>, EditError> {
        for i in (0..self.segment_count()).filter(|i| !self.is_still(before, *i)) {
            let search = |finder: &mut PathFinder, spline: &Self| -> Result<InnerPath, EditError> {
                let next = (i + 1) % spline.anchors.len();
                let [from, to] = [spline.anchors[i].outgoing.point(), spline.anchors[next].incoming.point()];
                let mut path = InnerPath::default();
                finder.shortest_inner(
                    surface,
                    &surface.inner_point(&from)?,
                    &surface.inner_point(&to)?,
                    PathQuality::Default,
                    &mut path,
                )?;
                Ok(path)
            };
            let old = search(finder, before)?;
            let led = self.led_middle(surface, finder, before, led, i, &old)?;
            let found = search(finder, self)?;
            if found.length < led.length * (1.0 - 1e-9) && are_apart(surface, &found, &led) {
                return Ok(Some(i));
            }
        }
        Ok(None)
    }
}

/// Whether two paths between the same points take different ways.
fn are_apart(surface: &Surface, a: &InnerPath, b: &InnerPath) -> bool {
    let limit = APART * a.length;
    [0.25, 0.5, 0.75].into_iter().any(|share| {
        let [p, q] = [a, b].map(|path| surface.inner_position(&path.at_share(surface, share).1));
        p.distance(q) > limit
    })
}
