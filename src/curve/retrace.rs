//! Traces of splines: only segments that changed are traced, in memory that is kept.

use std::sync::Arc;

use super::{
    SegmentTrace, Spline, Trace, TraceError, TraceWorkspace,
    average::Averager,
    lane_riesenfeld::Knots,
    segment::{ChainLegs, KeyControl, SegmentKey},
};
use crate::surface::Surface;

impl Spline {
    /// Traces the spline. Segments whose control points and scheme are as in `previous` are shared with it; the result is
    /// the same, bit for bit, as without.
    ///
    /// # Errors
    /// [`TraceError`] if control points cannot be joined or do not belong to the surface.
    pub fn trace(
        &self,
        surface: &Surface,
        workspace: &mut TraceWorkspace,
        previous: Option<&Trace>,
    ) -> Result<Trace, TraceError> {
        let mut trace = previous.cloned().unwrap_or_default();
        self.trace_into(surface, workspace, &mut trace)?;
        Ok(trace)
    }

    /// [`trace`](Self::trace) in place of an earlier trace, of which unchanged segments stay as they are.
    ///
    /// Changed segments that nobody else holds are overwritten: once warm, a segment under Lane–Riesenfeld subdivision
    /// is traced anew without an allocation.
    ///
    /// # Errors
    /// As [`trace`](Self::trace); `trace` is then empty.
    pub fn trace_into(
        &self,
        surface: &Surface,
        workspace: &mut TraceWorkspace,
        trace: &mut Trace,
    ) -> Result<(), TraceError> {
        self.line_up(surface, trace);
        let mut chain = ChainLegs::default();
        for i in 0..self.segment_count() {
            if self.is_traced_by(surface, i, &trace.segments[i]) {
                continue;
            }
            trace.retraced.push(i as u32);
            let segment = writable(&mut trace.segments[i]);
            if let Err(error) = self.trace_segment(surface, workspace, (i, &mut chain), segment) {
                *trace = Trace::default();
                return Err(error);
            }
        }
        Ok(())
    }

    fn trace_segment(
        &self,
        surface: &Surface,
        workspace: &mut TraceWorkspace,
        (i, chain): (usize, &mut ChainLegs),
        out: &mut SegmentTrace,
    ) -> Result<(), TraceError> {
        let key = self.key(surface, i, out.key.take());
        let TraceWorkspace { finder, scratch } = workspace;
        let mut averager = Averager { surface, finder, quality: self.scheme.quality };
        key.trace(&mut averager, scratch, (i, chain), out)
    }

    /// Makes room for as many segments as there are. Where their number changed, an edit may have shifted them by one.
    fn line_up(&self, surface: &Surface, trace: &mut Trace) {
        trace.retraced.clear();
        let count = self.segment_count();
        if trace.segments.len() == count {
            return;
        }
        let known = std::mem::take(&mut trace.segments);
        trace.segments.extend((0..count).map(|i| {
            let near = [Some(i), i.checked_sub(1), Some(i + 1)];
            let same =
                near.into_iter().flatten().filter_map(|k| known.get(k)).find(|s| self.is_traced_by(surface, i, s));
            same.map(Arc::clone).unwrap_or_default()
        }));
    }

    /// Whether a trace is that of a segment as it is now.
    fn is_traced_by(&self, surface: &Surface, segment: usize, trace: &SegmentTrace) -> bool {
        let Some(key) = &trace.key else { return false };
        let n = self.anchors.len();
        let anchor = |k: usize| &self.anchors[(segment + k) % n];
        key.surface == surface.identity()
            && key.scheme == self.scheme.settled()
            && match (&key.control, self.knots(segment)) {
                (KeyControl::Bezier { legs, middle }, None) => {
                    legs[0] == anchor(0).outgoing.leg
                        && legs[1] == anchor(1).incoming.leg
                        && *middle == anchor(0).middle
                }
                (KeyControl::BSpline { points, knots, index }, Some(own)) => {
                    (*knots, *index) == own && points.iter().enumerate().all(|(k, p)| *p == anchor(k).point)
                }
                _ => false,
            }
    }

    /// The knots around an interval and its place among them, of a B-spline.
    fn knots(&self, segment: usize) -> Option<(Knots, usize)> {
        let degree = self.scheme.method.b_spline_degree()?;
        Some(Knots { degree, intervals: self.segment_count(), periodic: self.closed }.around(segment))
    }

    /// What a segment's trace depends on; `old` lends its memory.
    pub(crate) fn key(&self, surface: &Surface, segment: usize, old: Option<SegmentKey>) -> SegmentKey {
        let n = self.anchors.len();
        let anchor = |k: usize| &self.anchors[(segment + k) % n];
        let control = match (self.knots(segment), old.map(|key| key.control)) {
            (Some((knots, index)), _) => {
                let points = (0..=knots.degree).map(|k| anchor(k).point).collect();
                KeyControl::BSpline { points, knots, index }
            }
            (None, Some(KeyControl::Bezier { mut legs, mut middle })) => {
                legs[0].clone_from(&anchor(0).outgoing.leg);
                legs[1].clone_from(&anchor(1).incoming.leg);
                middle.clone_from(&anchor(0).middle);
                KeyControl::Bezier { legs, middle }
            }
            (None, _) => KeyControl::Bezier {
                legs: Box::new([anchor(0).outgoing.leg.clone(), anchor(1).incoming.leg.clone()]),
                middle: anchor(0).middle.clone(),
            },
        };
        SegmentKey { surface: surface.identity(), control, scheme: self.scheme.settled() }
    }
}

/// The trace itself if nobody else holds it, else a new one in its place.
fn writable(segment: &mut Arc<SegmentTrace>) -> &mut SegmentTrace {
    if Arc::get_mut(segment).is_none() {
        *segment = Arc::default();
    }
    Arc::make_mut(segment)
}
