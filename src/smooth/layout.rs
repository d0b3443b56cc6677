//! The faces of a strip, each laid flat by itself.
//!
//! Nothing is unfolded over more than two faces: a stretch of the line needs its own face, a turn the two at a side. So closed
//! lines need no care for what comes back turned after once round, and long ones lose no digits.

use glam::{DVec2, DVec3};

use super::{hinge, metric::Metric, strip::Strip};
use crate::surface::{HalfEdge, InnerPoint, Surface, metric};

/// A face that the line passes, in its own frame: the side it comes in by lies on the y axis with its right end at 0, and the
/// line runs towards +x.
///
/// The stretch from the place `t` on that side to the place `u` on the next is `offset + u · leave − (0, t · enter)`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Leg {
    /// Length of the side it comes in by; 0 at the start of an open line.
    pub(crate) enter: f64,
    /// The side it goes out by, from its right to its left end; 0 at the end.
    pub(crate) leave: DVec2,
    /// From the right end of the first side to that of the next.
    pub(crate) offset: DVec2,
}

/// The legs of a strip, one more than crossings (of a closed line as many: leg `i` leads to crossing `i`).
#[derive(Debug, Default)]
pub(crate) struct Layout {
    pub(crate) legs: Vec<Leg>,
    /// Length of each crossed side.
    pub(crate) lengths: Vec<f64>,
    /// Right end and extent of each crossed side in space.
    pub(crate) rights: Vec<DVec3>,
    pub(crate) extents: Vec<DVec3>,
    closed: bool,
}

impl Layout {
    /// Lays the faces of a strip flat. Cost: linear.
    pub(crate) fn build(&mut self, surface: &Surface, metric: &mut Metric, strip: &Strip) {
        self.legs.clear();
        self.lengths.clear();
        self.rights.clear();
        self.extents.clear();
        self.closed = strip.closed;
        let n = strip.len();
        for h in &strip.sides {
            let [a, b] = [surface.origin(*h), surface.target(*h)].map(|v| surface.positions[v as usize]);
            self.rights.push(a);
            self.extents.push(b - a);
            self.lengths.push(metric.length(surface, *h));
        }
        let Some(first) = strip.sides.first() else { return };
        if strip.closed {
            self.legs.push(through(surface, metric, strip.sides[n - 1], strip.sides[0]));
        } else {
            self.legs.push(out_of(surface, metric, &strip.start, *first));
        }
        for pair in strip.sides.windows(2) {
            self.legs.push(through(surface, metric, pair[0], pair[1]));
        }
        if !strip.closed {
            self.legs.push(into(surface, metric, strip.sides[n - 1], &strip.end));
        }
    }

    /// The leg after crossing `i`.
    #[inline]
    pub(crate) fn after(&self, i: usize) -> usize {
        if self.closed && i + 1 == self.legs.len() { 0 } else { i + 1 }
    }

    /// The stretch of leg `j`, in its frame.
    #[inline]
    pub(crate) fn stretch(&self, j: usize, at: &[f64]) -> DVec2 {
        let leg = &self.legs[j];
        let from = if j > 0 {
            at[j - 1]
        } else if self.closed {
            at[at.len() - 1]
        } else {
            0.0
        };
        let to = at.get(j).copied().unwrap_or(0.0);
        leg.offset + to * leg.leave - DVec2::new(0.0, from * leg.enter)
    }

    /// Length of the line, as sides are measured.
    pub(crate) fn length(&self, at: &[f64]) -> f64 {
        (0..self.legs.len()).fold(0.0, |sum, j| sum + self.stretch(j, at).length())
    }

    /// The points before and after crossing `i`, in the frame of its side.
    pub(crate) fn around(&self, i: usize, at: &[f64]) -> [DVec2; 2] {
        let (before, after) = (&self.legs[i], self.after(i));
        let from = if i > 0 {
            at[i - 1]
        } else if self.closed {
            at[at.len() - 1]
        } else {
            0.0
        };
        // From the right end of the side back to the point before, turned so that the side points up.
        let back = DVec2::new(0.0, from * before.enter) - before.offset;
        let up = before.leave / self.lengths[i].max(f64::MIN_POSITIVE);
        let next = &self.legs[after];
        let to = at.get(after).copied().unwrap_or(0.0);
        [DVec2::new(back.perp_dot(up), back.dot(up)), next.offset + to * next.leave]
    }

    /// The turn at crossing `i`, positive to the left; none where the points before or after coincide with it.
    pub(crate) fn turn(&self, i: usize, at: &[f64]) -> f64 {
        let [p, q] = self.around(i, at);
        let here = DVec2::new(0.0, at[i] * self.lengths[i]);
        let short = 1e-12 * self.lengths[i];
        if p.distance(here) <= short || q.distance(here) <= short {
            return 0.0;
        }
        hinge::turn(p, here.y, q)
    }

    /// The place of crossing `i` in space.
    #[inline]
    pub(crate) fn place(&self, i: usize, at: f64) -> DVec3 {
        self.rights[i] + at * self.extents[i]
    }
}

/// The face entered across `before` and left through `next`.
fn through(surface: &Surface, metric: &mut Metric, before: HalfEdge, next: HalfEdge) -> Leg {
    let twin = surface.twin(before);
    let (enter, apex) = entered(surface, metric, twin);
    if next == twin.next() {
        Leg { enter, leave: apex, offset: DVec2::ZERO }
    } else {
        Leg { enter, leave: DVec2::new(0.0, enter) - apex, offset: apex }
    }
}

/// Length of a face's side on the y axis, and its third corner beyond.
fn entered(surface: &Surface, metric: &mut Metric, twin: HalfEdge) -> (f64, DVec2) {
    let length = metric.length(surface, twin);
    let (left, right) = (DVec2::new(0.0, length), DVec2::ZERO);
    let from_left = metric.length(surface, twin.prev());
    let from_right = metric.length(surface, twin.next());
    (length, metric::apex(left, right, length, from_left, from_right))
}

/// The first face, from a point in it.
fn out_of(surface: &Surface, metric: &mut Metric, start: &InnerPoint, h: HalfEdge) -> Leg {
    let length = metric.length(surface, h);
    let up = DVec2::new(0.0, length);
    let apex =
        metric::apex(DVec2::ZERO, up, length, metric.length(surface, h.prev()), metric.length(surface, h.next()));
    let s = start.weights[h.next().side()] * up + start.weights[h.prev().side()] * apex;
    Leg { enter: 0.0, leave: up, offset: -s }
}

/// The last face, to a point in it.
fn into(surface: &Surface, metric: &mut Metric, before: HalfEdge, end: &InnerPoint) -> Leg {
    let twin = surface.twin(before);
    let (enter, apex) = entered(surface, metric, twin);
    let e = end.weights[twin.side()] * DVec2::new(0.0, enter) + end.weights[twin.prev().side()] * apex;
    Leg { enter, leave: DVec2::ZERO, offset: e }
}
