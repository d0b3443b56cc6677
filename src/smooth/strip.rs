//! A line on a surface as a strip of faces and the places where it crosses the sides between them.

use std::ops::Range;

use glam::DVec3;

use crate::geodesic::inner::side_position;
use crate::surface::{HalfEdge, InnerPoint, Surface, Zeros};

/// A crossing this close to an end of its side, as a share of it, is at the vertex.
pub(crate) const AT_VERTEX: f64 = 1e-9;

/// A face-strip curve: straight inside each face, bending where it crosses sides.
///
/// Crossing `i` leaves its face through `sides[i]`, at the share `at[i]` from the right end (seen in the direction of
/// travel: the origin of the half-edge) to the left one. Regular: no side is crossed back at once. An open line has its
/// ends in its first and its last face; a closed one, of at least three crossings, comes back to its first face.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Strip {
    pub(crate) closed: bool,
    pub(crate) start: InnerPoint,
    pub(crate) end: InnerPoint,
    pub(crate) sides: Vec<HalfEdge>,
    pub(crate) at: Vec<f64>,
    /// Share of the first line's length up to there: carried along, so that what is known there can be found.
    pub(crate) along: Vec<f64>,
    /// Crossings that stay where they are.
    pub(crate) fixed: Vec<bool>,
    /// The stretch of a drawn line that is nearest, if it was looked up; [`UNKNOWN`] of new crossings.
    pub(crate) near: Vec<u32>,
}

/// In place of the nearest stretch: not looked up yet.
pub(crate) const UNKNOWN: u32 = u32::MAX;

/// Some crossings in a row that a vertex has in common, at the same end: a fan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) first: usize,
    pub(crate) last: usize,
    pub(crate) vertex: u32,
    /// Whether the vertex is to the left.
    pub(crate) left: bool,
}

impl Strip {
    pub(crate) fn len(&self) -> usize {
        self.sides.len()
    }

    pub(crate) fn clear(&mut self) {
        self.sides.clear();
        self.at.clear();
        self.along.clear();
        self.fixed.clear();
        self.near.clear();
    }

    pub(crate) fn copy_from(&mut self, other: &Self) {
        let Self { closed, start, end, sides, at, along, fixed, near } = other;
        (self.closed, self.start, self.end) = (*closed, *start, *end);
        self.sides.clone_from(sides);
        self.at.clone_from(at);
        self.along.clone_from(along);
        self.fixed.clone_from(fixed);
        self.near.clone_from(near);
    }

    /// Adds a crossing; one that leads back to the face just left takes that one away instead.
    ///
    /// Says whether that leads back over a fixed crossing, which stays: the strip is not regular then.
    pub(crate) fn push(&mut self, surface: &Surface, side: HalfEdge, at: f64, along: f64, fixed: bool) -> bool {
        let back = self.sides.last().is_some_and(|last| surface.twin(*last) == side);
        let held = back && (fixed || self.fixed.last() == Some(&true));
        if back && !held {
            self.sides.pop();
            self.at.pop();
            self.along.pop();
            self.fixed.pop();
            self.near.pop();
            return false;
        }
        self.sides.push(side);
        self.at.push(at);
        self.along.push(along);
        self.fixed.push(fixed);
        self.near.push(UNKNOWN);
        held
    }

    /// Adds crossing `i` of another strip.
    pub(crate) fn push_from(&mut self, surface: &Surface, other: &Self, i: usize) -> bool {
        let count = self.len();
        let held = self.push(surface, other.sides[i], other.at[i], other.along[i], other.fixed[i]);
        if let (true, Some(near)) = (self.len() > count, self.near.last_mut()) {
            *near = other.near[i];
        }
        held
    }

    /// Adds some crossings of another strip, which is regular, so that only the first of them can lead back; says whether they lead back over a
    /// fixed one, and adds no more then.
    pub(crate) fn append(&mut self, surface: &Surface, other: &Self, range: Range<usize>) -> bool {
        let Range { mut start, end } = range;
        while start < end && self.sides.last().is_some_and(|last| surface.twin(*last) == other.sides[start]) {
            if self.push_from(surface, other, start) {
                return true;
            }
            start += 1;
        }
        self.sides.extend_from_slice(&other.sides[start..end]);
        self.at.extend_from_slice(&other.at[start..end]);
        self.along.extend_from_slice(&other.along[start..end]);
        self.fixed.extend_from_slice(&other.fixed[start..end]);
        self.near.extend_from_slice(&other.near[start..end]);
        false
    }

    /// Takes away what leads there and back at the seam of a closed line.
    pub(crate) fn close_seam(&mut self, surface: &Surface) {
        let mut cut = 0;
        let n = self.len();
        while n - 2 * cut >= 2
            && surface.twin(self.sides[n - 1 - cut]) == self.sides[cut]
            && !self.fixed[cut]
            && !self.fixed[n - 1 - cut]
        {
            cut += 1;
        }
        if cut > 0 {
            self.sides.truncate(n - cut);
            self.at.truncate(n - cut);
            self.along.truncate(n - cut);
            self.fixed.truncate(n - cut);
            self.near.truncate(n - cut);
            self.sides.drain(..cut);
            self.at.drain(..cut);
            self.along.drain(..cut);
            self.fixed.drain(..cut);
            self.near.drain(..cut);
        }
    }

    pub(crate) fn close_seam_if_closed(&mut self, surface: &Surface) {
        if self.closed {
            self.close_seam(surface);
        }
    }

    /// Drops faces at the ends of an open line that it does not enter: while an end lies on the side to its neighbour, it moves
    /// there.
    pub(crate) fn trim_ends(&mut self, surface: &Surface) {
        if self.closed {
            return;
        }
        let on_side = |p: &InnerPoint, h: HalfEdge| p.zeros() != Zeros::None && p.weights[h.prev().side()] == 0.0;
        let mut skip = 0;
        while let Some(&h) = self.sides.get(skip)
            && on_side(&self.start, h)
            && !self.fixed[skip]
            && let Some(there) = surface.across(&self.start, h)
        {
            self.start = there;
            skip += 1;
        }
        self.sides.drain(..skip);
        self.at.drain(..skip);
        self.along.drain(..skip);
        self.fixed.drain(..skip);
        self.near.drain(..skip);
        while let Some(&h) = self.sides.last()
            && on_side(&self.end, surface.twin(h))
            && self.fixed.last() == Some(&false)
            && let Some(there) = surface.across(&self.end, surface.twin(h))
        {
            self.end = there;
            self.sides.pop();
            self.at.pop();
            self.along.pop();
            self.fixed.pop();
            self.near.pop();
        }
    }

    /// Lets a closed line begin with crossing `first`.
    pub(crate) fn rotate(&mut self, first: usize) {
        self.sides.rotate_left(first);
        self.at.rotate_left(first);
        self.along.rotate_left(first);
        self.fixed.rotate_left(first);
        self.near.rotate_left(first);
    }

    /// The vertex at one end of a crossed side.
    pub(crate) fn end_vertex(&self, surface: &Surface, i: usize, left: bool) -> u32 {
        let h = self.sides[i];
        if left { surface.target(h) } else { surface.origin(h) }
    }

    /// Position of a crossing, relative to the surface's origin.
    pub(crate) fn crossing(&self, surface: &Surface, i: usize) -> DVec3 {
        side_position(surface, self.sides[i], self.at[i])
    }

    /// All positions in order: of an open line its ends too, of a closed one its first crossing again.
    pub(crate) fn positions_into(&self, surface: &Surface, out: &mut Vec<DVec3>) {
        out.clear();
        if !self.closed {
            out.push(surface.inner_position(&self.start));
        }
        out.extend((0..self.len()).map(|i| self.crossing(surface, i)));
        if self.closed {
            out.extend(out.first().copied());
        } else {
            out.push(surface.inner_position(&self.end));
        }
    }

    /// Length, by positions.
    pub(crate) fn length(&self, surface: &Surface) -> f64 {
        let ends = (!self.closed).then(|| [&self.start, &self.end].map(|p| surface.inner_position(p)));
        let crossings = (0..self.len()).map(|i| self.crossing(surface, i));
        let first = if self.closed { self.len().checked_sub(1).map(|i| self.crossing(surface, i)) } else { None };
        let points = ends.map(|e| e[0]).into_iter().chain(first).chain(crossings).chain(ends.map(|e| e[1]));
        let mut sum = 0.0;
        let mut before: Option<DVec3> = None;
        for p in points {
            sum += before.map_or(0.0, |b| b.distance(p));
            before = Some(p);
        }
        sum
    }

    /// Fills in shares of the length.
    pub(crate) fn measure(&mut self, surface: &Surface) {
        let whole = self.length(surface).max(f64::MIN_POSITIVE);
        let mut before = (!self.closed).then(|| surface.inner_position(&self.start));
        let mut sum = 0.0;
        self.along.clear();
        for i in 0..self.len() {
            let here = self.crossing(surface, i);
            sum += before.map_or(0.0, |b| b.distance(here));
            self.along.push(sum / whole);
            before = Some(here);
        }
    }

    /// The largest run about one end of crossing `i`; of a closed line it does not reach over the seam.
    pub(crate) fn run_at(&self, surface: &Surface, i: usize, left: bool) -> Run {
        let vertex = self.end_vertex(surface, i, left);
        let (mut first, mut last) = (i, i);
        while first > 0 && self.end_vertex(surface, first - 1, left) == vertex {
            first -= 1;
        }
        while last + 1 < self.len() && self.end_vertex(surface, last + 1, left) == vertex {
            last += 1;
        }
        Run { first, last, vertex, left }
    }

    /// Of a closed line: moves the seam where no run reaches over it that lies about a vertex which the line touches, if there is
    /// such a place; says which crossing is the first one now.
    pub(crate) fn seam_off_vertices(&mut self, surface: &Surface, touches: impl Fn(usize, f64) -> bool) -> usize {
        if !self.closed {
            return 0;
        }
        let touches_none = |i: &usize| !touches(*i, self.at[*i]) && !touches(*i, 1.0 - self.at[*i]);
        let free = (0..self.len()).find(|i| self.is_seam_free(surface, *i, &touches));
        let first = free.or_else(|| (0..self.len()).find(touches_none)).unwrap_or(0);
        if first > 0 {
            self.rotate(first);
        }
        first
    }

    /// Of a closed line: whether a seam before crossing `i` is neither in nor beside a run about a vertex that the line touches. `touches` is told a
    /// crossing, and how far it is off the vertex, as a share of its side.
    pub(crate) fn is_seam_free(&self, surface: &Surface, i: usize, touches: impl Fn(usize, f64) -> bool) -> bool {
        let n = self.len();
        let before = (i + n - 1) % n;
        [(i, false), (i, true), (before, false), (before, true)].into_iter().all(|(of, left)| {
            let vertex = self.end_vertex(surface, of, left);
            let off = |k: usize| if left { 1.0 - self.at[k] } else { self.at[k] };
            let is_about = |k: &usize| self.end_vertex(surface, *k, left) == vertex;
            let forwards = (0..n).map(|k| (of + k) % n).take_while(is_about);
            let backwards = (1..n).map(|k| (of + n - k) % n).take_while(is_about);
            !forwards.chain(backwards).any(|k| touches(k, off(k)))
        })
    }

    /// Of a closed line: moves the seam to where the line is at no vertex, if there is such a place, so that what bends at a
    /// vertex is in one piece.
    pub(crate) fn seam_off_crossings_at_vertices(&mut self, surface: &Surface) -> usize {
        self.seam_off_vertices(surface, |_, off| off <= AT_VERTEX)
    }

    /// Whether each side leads to the face that the next one leaves, and no side is crossed back at once.
    pub(crate) fn is_regular(&self, surface: &Surface) -> bool {
        let n = self.len();
        let pairs = if self.closed { n } else { n.saturating_sub(1) };
        let joined = (0..pairs).all(|i| {
            let (twin, next) = (surface.twin(self.sides[i]), self.sides[(i + 1) % n]);
            twin.is_some() && twin.face() == next.face() && twin != next
        });
        let ends = self.closed
            || match (self.sides.first(), self.sides.last()) {
                (Some(first), Some(last)) => {
                    let twin = surface.twin(*last);
                    first.face() == self.start.face && twin.is_some() && twin.face() == self.end.face
                }
                _ => self.start.face == self.end.face,
            };
        let lengths = [self.at.len(), self.along.len(), self.fixed.len(), self.near.len()] == [n; 4];
        joined && ends && lengths && (!self.closed || n >= 3) && self.at.iter().all(|t| (0.0..=1.0).contains(t))
    }
}

/// The sides to cross when a run's vertex is passed on its other side: none if the strip then stays in one face, `false` where
/// the boundary is in the way.
pub(crate) fn other_side(surface: &Surface, strip: &Strip, run: &Run, fan: &mut Vec<HalfEdge>) -> bool {
    fan.clear();
    let goal = surface.twin(strip.sides[run.last]).face();
    let mut h = strip.sides[run.first];
    let first = h.face();
    while h.face() != goal {
        let side = if run.left { h.next() } else { h.prev() };
        h = surface.twin(side);
        if !h.is_some() || h.face() == first {
            return false;
        }
        fan.push(side);
    }
    true
}

/// Extends a strip from the face that a point is spelled in to another face around the point; every side is crossed at the
/// point. Says whether that face was reached.
pub(crate) fn turn_into(surface: &Surface, here: &InnerPoint, face: u32, sides: &mut Vec<HalfEdge>) -> bool {
    if here.face == face {
        return true;
    }
    matches!(here.zeros(), Zeros::Side(_) | Zeros::Corner(_))
        && crate::geodesic::chain::turn_into(surface, here, face, sides)
}

/// Where on side `h` a point is that lies on it.
pub(crate) fn share_on(surface: &Surface, here: &InnerPoint, h: HalfEdge) -> f64 {
    match here.zeros() {
        Zeros::Corner(k) => {
            let vertex = surface.triangles[here.face as usize][k as usize];
            if surface.origin(h) == vertex { 0.0 } else { 1.0 }
        }
        Zeros::Side(k) => {
            let own = HalfEdge::new(here.face, k);
            let t = here.weights[own.next().side()];
            if own == h { t } else { 1.0 - t }
        }
        Zeros::None => 0.5,
    }
}
