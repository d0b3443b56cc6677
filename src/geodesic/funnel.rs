//! The shortest path inside a strip: unfold its faces into the plane and pull a string taut.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::search::turn;
use crate::surface::{HalfEdge, InnerPoint, Surface, metric};

/// A vertex at which the taut string bends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend {
    pub(crate) vertex: u32,
    /// First and last side of the strip that have the vertex at this end.
    pub(crate) first: usize,
    pub(crate) last: usize,
    /// By how much the string turns there, in the plane; never negative.
    pub(crate) turn: f64,
    /// Whether the vertex is at the left end of those sides (their target).
    pub(crate) left: bool,
}

#[derive(Clone, Copy, Debug)]
struct Knot {
    at: DVec2,
    vertex: u32,
    side: usize,
    left: bool,
}

const NO_VERTEX: u32 = u32::MAX;
/// A crossing this close to an end of its side (as a share of it) is at the vertex.
const TOUCHING: f64 = 1e-12;

/// Scratch memory of the funnel; linear in the longest strip seen.
#[derive(Debug, Default)]
pub(crate) struct Funnel {
    /// The taut string: start, bends, end.
    string: Vec<Knot>,
    /// Left and right end of each side in the plane.
    lefts: Vec<DVec2>,
    rights: Vec<DVec2>,
    left_chain: Chain,
    right_chain: Chain,
}

/// One wall of the funnel; knots before `head` have moved onto the string.
#[derive(Debug, Default)]
struct Chain {
    knots: Vec<Knot>,
    head: usize,
}

impl Funnel {
    /// Pulls the string taut from `start` through `strip` to `end`, fills in where it bends and gives its length.
    ///
    /// Cost: linear in the strip (two-chain funnel, Lee & Preparata 1984).
    pub(crate) fn pull(
        &mut self,
        surface: &Surface,
        start: &InnerPoint,
        end: &InnerPoint,
        strip: &[HalfEdge],
        bends: &mut Vec<Bend>,
    ) -> f64 {
        bends.clear();
        self.string.clear();
        self.lefts.clear();
        self.rights.clear();
        for chain in [&mut self.left_chain, &mut self.right_chain] {
            chain.knots.clear();
            chain.head = 0;
        }
        let Some(&first) = strip.first() else {
            return surface.inner_position(start).distance(surface.inner_position(end));
        };
        let ends = self.unfold(surface, start, end, strip, first);
        if self.is_straight(ends) {
            let knot = |at: DVec2| Knot { at, vertex: NO_VERTEX, side: 0, left: false };
            self.string.extend(ends.map(knot));
            return ends[0].distance(ends[1]);
        }
        self.tighten(surface, strip, ends);
        self.string.extend_from_slice(&self.left_chain.knots[self.left_chain.head..]);
        self.collect_bends(surface, strip, bends);
        self.string.windows(2).map(|w| w[0].at.distance(w[1].at)).sum()
    }

    /// Lays the faces side by side into the plane; gives start and end there.
    fn unfold(
        &mut self,
        surface: &Surface,
        start: &InnerPoint,
        end: &InnerPoint,
        strip: &[HalfEdge],
        first: HalfEdge,
    ) -> [DVec2; 2] {
        let width = surface.length(first);
        let (mut right, mut left) = (DVec2::ZERO, DVec2::new(width, 0.0));
        let corner = metric::apex(right, left, width, surface.length(first.prev()), surface.length(first.next()));
        let from = spell(start, first, [right, left, corner]);
        let mut to = from;
        for (side, &h) in strip.iter().enumerate() {
            self.lefts.push(left);
            self.rights.push(right);
            let twin = surface.twin(h);
            let lengths = surface.lengths[twin.face() as usize];
            let length = |h: HalfEdge| lengths[h.side()];
            let corner = metric::apex(left, right, length(twin), length(twin.prev()), length(twin.next()));
            match strip.get(side + 1) {
                None => to = spell(end, twin, [left, right, corner]),
                Some(next) if *next == twin.next() => left = corner,
                Some(_) => right = corner,
            }
        }
        [from, to]
    }

    /// Whether the straight line from start to end stays inside the strip, away from all vertices.
    fn is_straight(&self, [start, end]: [DVec2; 2]) -> bool {
        let along = end - start;
        let beside = |p: &DVec2| along.perp_dot(*p - start);
        self.lefts.iter().zip(&self.rights).all(|(left, right)| beside(left) > 0.0 && beside(right) < 0.0)
    }

    /// Hands each new end of a side to the funnel, and the end of the string.
    fn tighten(&mut self, surface: &Surface, strip: &[HalfEdge], [start, end]: [DVec2; 2]) {
        self.string.push(Knot { at: start, vertex: NO_VERTEX, side: 0, left: false });
        let (mut last_left, mut last_right) = (NO_VERTEX, NO_VERTEX);
        for (side, &h) in strip.iter().enumerate() {
            let (left, right) = (surface.target(h), surface.origin(h));
            if left != last_left {
                self.add(Knot { at: self.lefts[side], vertex: left, side, left: true });
            }
            if right != last_right {
                self.add(Knot { at: self.rights[side], vertex: right, side, left: false });
            }
            (last_left, last_right) = (left, right);
        }
        self.add(Knot { at: end, vertex: NO_VERTEX, side: strip.len(), left: true });
    }

    /// Narrows the funnel by a knot on one of its walls; where that wall passes the other, the other's knots become bends.
    /// Collinear knots are dropped: the string merely touches them.
    fn add(&mut self, knot: Knot) {
        let (own, other, sign) = if knot.left {
            (&mut self.left_chain, &mut self.right_chain, 1.0)
        } else {
            (&mut self.right_chain, &mut self.left_chain, -1.0)
        };
        let mut apex = self.string.last().map_or(DVec2::ZERO, |k| k.at);
        while let Some(last) = own.knots.get(own.head..).and_then(|k| k.last()) {
            let n = own.knots.len();
            let before = if n - own.head >= 2 { own.knots[n - 2].at } else { apex };
            if sign * turn(before, last.at, knot.at) > 0.0 {
                break;
            }
            own.knots.pop();
        }
        if own.knots.len() == own.head {
            while let Some(&first) = other.knots.get(other.head)
                && sign * turn(apex, first.at, knot.at) < 0.0
            {
                self.string.push(first);
                apex = first.at;
                other.head += 1;
            }
        }
        own.knots.push(knot);
    }

    fn collect_bends(&self, surface: &Surface, strip: &[HalfEdge], bends: &mut Vec<Bend>) {
        for (i, knot) in self.string.iter().enumerate().skip(1) {
            if knot.vertex == NO_VERTEX {
                continue;
            }
            // Neighbours at the same place have no direction: look past them.
            let away = |k: &&Knot| k.at.distance_squared(knot.at) > 0.0;
            let before = self.string[..i].iter().rev().find(away).unwrap_or(knot);
            let after = self.string[i + 1..].iter().find(away).unwrap_or(knot);
            let (a, b) = (knot.at - before.at, after.at - knot.at);
            let touches = |k: usize| {
                let h = strip[k];
                knot.vertex == if knot.left { surface.target(h) } else { surface.origin(h) }
            };
            let (mut first, mut last) = (knot.side, knot.side);
            while first > 0 && touches(first - 1) {
                first -= 1;
            }
            while last + 1 < strip.len() && touches(last + 1) {
                last += 1;
            }
            let turn = full_turn(surface, &strip[first..=last], knot.left, a, b);
            bends.push(Bend { vertex: knot.vertex, first, last, turn, left: knot.left });
        }
    }

    /// Where the string pulled last crosses the sides of its strip: exactly 0 or 1 at the vertices where it bends.
    pub(crate) fn crossings(&self, strip: &[HalfEdge], bends: &[Bend], at: &mut Vec<f64>) {
        at.clear();
        let mut knots = self.string.windows(2);
        let mut next_bend = bends.iter().peekable();
        let Some(mut stretch) = knots.next() else { return };
        for i in 0..strip.len() {
            while let Some(bend) = next_bend.peek()
                && i > bend.last
            {
                next_bend.next();
                stretch = knots.next().unwrap_or(stretch);
            }
            if let Some(bend) = next_bend.peek()
                && (bend.first..=bend.last).contains(&i)
            {
                at.push(if bend.left { 1.0 } else { 0.0 });
                continue;
            }
            let (a, b) = (stretch[0].at, stretch[1].at);
            let (right, left) = (self.rights[i], self.lefts[i]);
            // Signed distances of the side's ends from the string's line.
            let (from, to) = (turn(a, b, right), turn(a, b, left));
            let t = if from == to {
                // The string has no length here, or runs along the side: the nearest place on the side.
                let along = left - right;
                (a - right).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)
            } else {
                from / (from - to)
            };
            // A string that merely touches a vertex passes exactly through it on all its sides.
            at.push(if t < TOUCHING {
                0.0
            } else if t > 1.0 - TOUCHING {
                1.0
            } else {
                t
            });
        }
    }
}

/// By how much the string turns towards a vertex at the end of some sides, from direction `a` to `b`.
///
/// In the plane a turn is known but for full turns, and about a saddle the strip may lead round by more than one: the angles
/// of the faces between the sides tell, which leave out less than a half turn at either end.
fn full_turn(surface: &Surface, sides: &[HalfEdge], left: bool, a: DVec2, b: DVec2) -> f64 {
    let side = if left { 1.0 } else { -1.0 };
    let turn = side * a.perp_dot(b).atan2(a.dot(b));
    // The corner of the face that side `h` leads out of, and of the face behind it.
    let corner = |h: HalfEdge| surface.corner_angle(if left { h.next() } else { h });
    let behind = |h: HalfEdge| surface.corner_angle(if left { surface.twin(h) } else { surface.twin(h).next() });
    let [first, .., last] = sides else { return turn.abs() };
    let between: f64 = sides[1..].iter().map(|h| corner(*h)).sum();
    let about = between + 0.5 * (corner(*first) + behind(*last)) - PI;
    let turns = ((about - turn) / TAU).round();
    if turns > 0.0 { turn + turns * TAU } else { turn.abs() }
}

/// Vertices that the string runs straight through: found where crossings lie at a vertex and the string does not bend.
pub(crate) fn straight_through(surface: &Surface, strip: &[HalfEdge], at: &[f64], bends: &mut Vec<Bend>) {
    bends.clear();
    let vertex = |i: usize| match at[i] {
        0.0 => Some((surface.origin(strip[i]), false)),
        1.0 => Some((surface.target(strip[i]), true)),
        _ => None,
    };
    let mut i = 0;
    while i < strip.len() {
        let first = i;
        i += 1;
        let Some((vertex_here, left)) = vertex(first) else { continue };
        while i < strip.len() && vertex(i) == Some((vertex_here, left)) {
            i += 1;
        }
        bends.push(Bend { vertex: vertex_here, first, last: i - 1, turn: 0.0, left });
    }
}

/// A point of the face of `h` in the plane, given where origin and target of `h` and the third corner lie.
fn spell(p: &InnerPoint, h: HalfEdge, corners: [DVec2; 3]) -> DVec2 {
    p.weights[h.side()] * corners[0] + p.weights[h.next().side()] * corners[1] + p.weights[h.prev().side()] * corners[2]
}
