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
    /// Of which surface, and measured how.
    of: Option<(u64, u64)>,
    sides: Vec<HalfEdge>,
    ends: [InnerPoint; 2],
    anew: Anew,
}

/// What is laid flat anew.
#[derive(Debug, Default)]
struct Anew {
    legs: Vec<Leg>,
    lengths: Vec<f64>,
    rights: Vec<DVec3>,
    extents: Vec<DVec3>,
}

/// How far apart, in sides of both strips together, two strips may meet again where they differ.
const APART: usize = 40;

impl Layout {
    /// Lays the faces of a strip flat: those that were not laid flat for the strip before. Cost: linear, and little where nothing changed.
    pub(crate) fn build(&mut self, surface: &Surface, metric: &mut Metric, strip: &Strip) {
        let of = Some((surface.identity(), metric.version()));
        let ends = [strip.start, strip.end];
        let is_known = self.of == of && self.closed == strip.closed;
        if is_known && self.sides == strip.sides && (strip.closed || self.ends == ends) {
            return;
        }
        (self.of, self.closed, self.ends) = (of, strip.closed, ends);
        if !is_known {
            self.legs.clear();
            self.lengths.clear();
            self.rights.clear();
            self.extents.clear();
            self.sides.clear();
        }
        let (new, old) = (strip.sides.as_slice(), self.sides.as_slice());
        let alike = |(a, b): &(&HalfEdge, &HalfEdge)| a == b;
        let head = new.iter().zip(old).take_while(alike).count();
        let tail = new[head..].iter().rev().zip(old[head..].iter().rev()).take_while(alike).count();
        self.splice(surface, metric, strip, [head, tail]);
    }

    /// Lays the sides anew that are neither of the first nor of the last ones, which are as they were.
    fn splice(&mut self, surface: &Surface, metric: &mut Metric, strip: &Strip, [head, tail]: [usize; 2]) {
        let Self { legs, lengths, rights, extents, anew, sides, .. } = self;
        let (n, m) = (strip.len(), sides.len());
        let (new, old) = (&strip.sides[head..n - tail], &sides[head..m - tail]);
        anew.legs.clear();
        anew.lengths.clear();
        anew.rights.clear();
        anew.extents.clear();
        let (mut i, mut j) = (0, 0);
        while i < new.len() {
            let alike = new[i..].iter().zip(&old[j..]).take_while(|(a, b)| a == b).count();
            if alike > 0 {
                let known = head + j..head + j + alike;
                anew.legs.push(leg(surface, metric, strip, head + i));
                anew.legs.extend_from_slice(&legs[known.start + 1..known.end]);
                anew.lengths.extend_from_slice(&lengths[known.clone()]);
                anew.rights.extend_from_slice(&rights[known.clone()]);
                anew.extents.extend_from_slice(&extents[known]);
                (i, j) = (i + alike, j + alike);
                continue;
            }
            let [skip, drop] = meet(&new[i..], &old[j..]);
            for (k, h) in new.iter().enumerate().skip(i).take(skip) {
                let [a, b] = [surface.origin(*h), surface.target(*h)].map(|v| surface.positions[v as usize]);
                anew.rights.push(a);
                anew.extents.push(b - a);
                anew.lengths.push(metric.length(surface, *h));
                anew.legs.push(leg(surface, metric, strip, head + k));
            }
            (i, j) = (i + skip, j + drop);
        }
        let gone = head..m - tail;
        lengths.splice(gone.clone(), anew.lengths.drain(..));
        rights.splice(gone.clone(), anew.rights.drain(..));
        extents.splice(gone.clone(), anew.extents.drain(..));
        legs.truncate(m);
        legs.splice(gone.clone(), anew.legs.drain(..));
        sides.splice(gone, new.iter().copied());
        if n == 0 {
            return;
        }
        // Legs lie between two sides: the one behind the new ones, the first, and the last of an open line.
        if tail > 0 {
            legs[n - tail] = leg(surface, metric, strip, n - tail);
        }
        legs[0] = leg(surface, metric, strip, 0);
        if !strip.closed {
            legs.push(into(surface, metric, strip.sides[n - 1], &strip.end));
        }
    }

    /// Lets a closed line begin with crossing `first`, as its strip does.
    pub(crate) fn rotate(&mut self, first: usize) {
        self.legs.rotate_left(first);
        self.lengths.rotate_left(first);
        self.rights.rotate_left(first);
        self.extents.rotate_left(first);
        self.sides.rotate_left(first);
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

/// The leg to crossing `i`.
fn leg(surface: &Surface, metric: &mut Metric, strip: &Strip, i: usize) -> Leg {
    match (i.checked_sub(1), strip.closed) {
        (Some(before), _) => through(surface, metric, strip.sides[before], strip.sides[i]),
        (None, true) => through(surface, metric, strip.sides[strip.len() - 1], strip.sides[i]),
        (None, false) => out_of(surface, metric, &strip.start, strip.sides[i]),
    }
}

/// How many sides of two strips that differ are to be left until they are alike again; what is left of the strips where that is far.
fn meet(new: &[HalfEdge], old: &[HalfEdge]) -> [usize; 2] {
    for both in 1..=APART {
        for skip in 0..=both {
            if let (Some(a), Some(b)) = (new.get(skip), old.get(both - skip))
                && a == b
            {
                return [skip, both - skip];
            }
        }
    }
    if old.is_empty() { [new.len(), 0] } else { [APART.min(new.len()), APART.min(old.len())] }
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
