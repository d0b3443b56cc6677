//! Moving a strip past vertices that the line presses against.
//!
//! With the angle β on the strip's side of a vertex of total angle θ, a line that is to turn by K towards the vertex has
//! nothing to gain beyond it unless the angle θ − β there is less than π − K.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::ops::Range;

use super::{
    fan::Fan,
    layout::Layout,
    metric::Metric,
    strip::{Run, Strip, other_side},
    windows::merge,
};
use crate::surface::{HalfEdge, Surface};

/// A vertex is not passed more often than this.
const MOST_FLIPS: u8 = 4;
/// A line that bends less than this more than it is to, in radians, may be about to leave the vertex.
const PRESSING: f64 = 1e-3;
/// Crossings beside one that is at a vertex are at it too if they are so many times farther at most.
const BESIDE: f64 = 4.0;
/// Angles this near to the limit stay.
const LIMIT: f64 = 1e-9;

/// What decides about runs.
pub(crate) struct Rule<'a> {
    /// Crossings this near to a vertex, in local units, are at it.
    pub(crate) near: f64,
    /// By how much the line is to turn at a crossing, to the left.
    pub(crate) wished: &'a dyn Fn(&Strip, usize) -> f64,
    /// Whether a vertex may be passed; the distance envelope may forbid it.
    pub(crate) allowed: &'a mut dyn FnMut(u32) -> bool,
    /// Whether new crossings are placed straight where that is possible, or at the vertex.
    pub(crate) straight: bool,
    /// Where to look, in order; what lies elsewhere has not moved.
    pub(crate) windows: &'a [Range<usize>],
}

/// What became of a strip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Flipped {
    /// How many vertices were passed.
    pub(crate) count: usize,
    /// Whether a run reaches over the seam of a closed line and was left for that.
    pub(crate) at_seam: bool,
}

/// Scratch memory, and which vertices were passed how often.
#[derive(Debug, Default)]
pub(crate) struct Flipper {
    pub(crate) counts: HashMap<u32, u8>,
    pub(crate) fan: Fan,
    sides: Vec<HalfEdge>,
    next: Strip,
    /// Which crossings are new after the last flips; in order, and apart.
    pub(crate) changed: Vec<Range<usize>>,
}

impl Flipper {
    /// Passes every vertex that it is worth to pass and whose run was not touched before.
    pub(crate) fn flip(
        &mut self,
        surface: &Surface,
        metric: &mut Metric,
        strip: &mut Strip,
        layout: &Layout,
        rule: &mut Rule<'_>,
    ) -> Flipped {
        match self.flip_apart(surface, metric, strip, layout, rule, 0) {
            Some(flipped) => flipped,
            // Runs side by side lead back over a fixed crossing: those that are apart do not.
            None => self.flip_apart(surface, metric, strip, layout, rule, 8).unwrap_or_default(),
        }
    }

    /// Passes vertices whose runs are so many crossings apart, and from fixed ones too; none if the strip would lead back over a
    /// fixed crossing, and it stays as it was then.
    fn flip_apart(
        &mut self,
        surface: &Surface,
        metric: &mut Metric,
        strip: &mut Strip,
        layout: &Layout,
        rule: &mut Rule<'_>,
        apart: usize,
    ) -> Option<Flipped> {
        let n = strip.len();
        let mut held = false;
        let mut flipped = Flipped::default();
        self.next.clear();
        (self.next.closed, self.next.start, self.next.end) = (strip.closed, strip.start, strip.end);
        self.changed.clear();
        let mut copied = 0;
        let (mut i, mut window) = (0, 0);
        while i < n {
            while rule.windows.get(window).is_some_and(|w| w.end <= i) {
                window += 1;
            }
            match rule.windows.get(window) {
                None => break,
                Some(range) if i < range.start => i = range.start,
                Some(_) => {}
            }
            let Some(touch) = touching(surface, strip, layout, i, rule.near) else {
                i += 1;
                continue;
            };
            let run = strip.run_at(surface, i, touch.left);
            i = touch.last + 1;
            if (run.first < copied + apart && copied > 0)
                || !self.is_worth_it(surface, metric, strip, layout, rule, &touch)
            {
                continue;
            }
            if strip.closed && (run.first == 0 || run.last + 1 == n) {
                flipped.at_seam = true;
                continue;
            }
            if strip.fixed[run.first..=run.last].contains(&true) || !other_side(surface, strip, &run, &mut self.sides) {
                continue;
            }
            *self.counts.entry(run.vertex).or_insert(0) += 1;
            held |= self.next.append(surface, strip, copied..run.first);
            let begin = self.next.len();
            held |= self.splice(surface, metric, strip, layout, &run, rule.straight);
            self.changed.push(begin.min(self.next.len())..self.next.len());
            copied = run.last + 1;
            i = i.max(copied);
            flipped.count += 1;
        }
        if flipped.count > 0 {
            held |= self.next.append(surface, strip, copied..n);
            let first = self.next.sides.first().copied();
            self.next.close_seam_if_closed(surface);
            let seam = self.next.sides.last().map(|last| surface.twin(*last));
            if held || (self.next.closed && self.next.len() > 1 && seam == self.next.sides.first().copied()) {
                return None;
            }
            std::mem::swap(strip, &mut self.next);
            strip.trim_ends(surface);
            if strip.sides.first().copied() != first {
                self.changed.clear();
                self.changed.push(0..strip.len());
            }
            // What led there and back took others along.
            let n = strip.len();
            self.changed.iter_mut().for_each(|range| *range = range.start.min(n)..range.end.min(n));
            merge(&mut self.changed);
        }
        Some(flipped)
    }

    /// Places crossings that were clamped to a vertex straight again where the line can leave it on its own side.
    pub(crate) fn release(
        &mut self,
        surface: &Surface,
        metric: &mut Metric,
        strip: &mut Strip,
        layout: &Layout,
        clamped: &[bool],
    ) {
        let mut i = 0;
        while i < strip.len() {
            let here = i;
            i += 1;
            if !clamped[here] {
                continue;
            }
            let run = strip.run_at(surface, here, strip.at[here] > 0.5);
            i = run.last + 1;
            self.fan.unfold(surface, metric, strip, layout, &run);
            if self.fan.angle >= PI || run.first == run.last || strip.fixed[run.first..=run.last].contains(&true) {
                continue;
            }
            for k in run.first..=run.last {
                let share = (self.fan.chord(k - run.first) / layout.lengths[k].max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                strip.at[k] = if run.left { 1.0 - share } else { share };
            }
        }
    }

    fn is_worth_it(
        &mut self,
        surface: &Surface,
        metric: &mut Metric,
        strip: &Strip,
        layout: &Layout,
        rule: &mut Rule<'_>,
        touch: &Run,
    ) -> bool {
        let vertex = touch.vertex;
        if surface.boundary[vertex as usize] || self.counts.get(&vertex).is_some_and(|count| *count >= MOST_FLIPS) {
            return false;
        }
        let Some(towards) = self.presses(surface, metric, strip, layout, rule.wished, touch) else { return false };
        let beyond = metric.angle(surface, vertex) - self.fan.angle;
        beyond < PI - towards - LIMIT && (rule.allowed)(vertex)
    }

    /// Whether the line presses against a vertex: it would leave it on its own side if it bent less than it has to. Gives the turn
    /// towards the vertex that is wished there.
    pub(crate) fn presses(
        &mut self,
        surface: &Surface,
        metric: &mut Metric,
        strip: &Strip,
        layout: &Layout,
        wished: &dyn Fn(&Strip, usize) -> f64,
        touch: &Run,
    ) -> Option<f64> {
        self.fan.unfold(surface, metric, strip, layout, touch);
        let wished: f64 = (touch.first..=touch.last).map(|k| wished(strip, k)).sum();
        let towards = if touch.left { wished } else { -wished };
        let presses = !self.fan.radii.contains(&0.0) && self.fan.angle > PI + towards + PRESSING;
        presses.then_some(towards)
    }

    /// Adds the sides on the other side of a vertex.
    fn splice(
        &mut self,
        surface: &Surface,
        metric: &mut Metric,
        strip: &Strip,
        layout: &Layout,
        run: &Run,
        straight: bool,
    ) -> bool {
        let n = strip.len();
        let mut held = false;
        let from = match run.first.checked_sub(1) {
            Some(before) => strip.along[before],
            None => 0.0,
        };
        let mut to = if run.last + 1 < n { strip.along[run.last + 1] } else { 1.0 };
        if strip.closed && to < from - 0.5 {
            to += 1.0;
        }
        let count = self.sides.len();
        if straight {
            self.fan.unfold_other(surface, metric, strip, layout, run, &self.sides);
        }
        for (k, h) in self.sides.iter().enumerate() {
            // The vertex is to the right now if it was to the left.
            let vertex_end = if run.left { 0.0 } else { 1.0 };
            let mut at = vertex_end;
            if straight && self.fan.angle < PI {
                let share = (self.fan.chord(k) / metric.length(surface, *h).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                at = if run.left { share } else { 1.0 - share };
            }
            let along = from + (to - from) * (k + 1) as f64 / (count + 1) as f64;
            let along = if strip.closed { along - along.floor() } else { along };
            held |= self.next.push(surface, *h, at, along, false);
        }
        held
    }
}

/// The crossings in a row about `i` that are at one vertex: one of them near it, those beside it not much farther.
pub(crate) fn touching(surface: &Surface, strip: &Strip, layout: &Layout, i: usize, near: f64) -> Option<Run> {
    let left = strip.at[i] > 0.5;
    let off = |k: usize| if left { 1.0 - strip.at[k] } else { strip.at[k] } * layout.lengths[k];
    if off(i) > near {
        return None;
    }
    let vertex = strip.end_vertex(surface, i, left);
    let beside = |k: usize| strip.end_vertex(surface, k, left) == vertex && off(k) <= BESIDE * near;
    let (mut first, mut last) = (i, i);
    while first > 0 && beside(first - 1) {
        first -= 1;
    }
    while last + 1 < strip.len() && beside(last + 1) {
        last += 1;
    }
    Some(Run { first, last, vertex, left })
}
