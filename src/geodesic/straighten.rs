//! From a strip to a locally shortest path: batch sweeps over the vertices at which the taut string bends.
//!
//! A string that bends at an interior vertex with turn τ has the angle π + τ on the strip's side and θ − π − τ on the
//! other, so the vertex can be passed on its other side with gain iff τ + K > 0, K = 2π − θ (Xin & Wang 2007 by another
//! route). One sweep moves the strip past all such vertices whose runs of sides do not overlap; no trial flips, no walk
//! about a star for the test.

use super::{
    funnel::{Bend, Beside, Funnel, straight_through},
    inner::{InnerPath, reverse_strip},
};
use crate::surface::{HalfEdge, InnerPoint, Surface, Zeros};

/// Turns below this are straight.
const STRAIGHT: f64 = 1e-9;
/// A strip counts as shorter only if it is shorter by this share of its length, and by this share of its longest side: below
/// that rounding decides, and flips would undo each other for ever.
const GAIN: f64 = 1e-13;
const NOISE: f64 = 64.0 * f64::EPSILON;

/// Sweeps in a row that may leave the length as it is.
const MAX_STALLED: usize = 8;
/// How often a straightened path may be moved off vertices it runs straight through; each time it gets shorter.
const MAX_ROUNDS: usize = 1000;

/// How many vertices beside a path are passed on their other side for a try.
const MAX_TRIALS: usize = 8;
/// How often a path may be replaced by one beside it.
const MAX_DETOURS: usize = 16;
/// Vertices are tried even where the path would seem to become longer by this share of its length.
const HOPE: f64 = 1e-3;
/// A path beside another is shorter only if it is by this factor.
const SHORTER: f64 = 1.0 - 1e-9;

/// Scratch memory of straightening; linear in the longest strip seen.
#[derive(Debug, Default)]
pub(crate) struct Straightener {
    funnel: Funnel,
    bends: Vec<Bend>,
    strip: Vec<HalfEdge>,
    next: Vec<HalfEdge>,
    before: Vec<HalfEdge>,
    fan: Vec<HalfEdge>,
    refused: Vec<u32>,
    straight_through: Vec<Bend>,
    beside: Vec<Beside>,
    kept: Vec<HalfEdge>,
    tried_at: Vec<f64>,
    /// Differences of length below this are rounding; found when lengths are first compared.
    noise: Option<f64>,
    /// Length of the taut string, if the string is up to date with strip and ends.
    taut: Option<f64>,
}

impl Straightener {
    /// Straightens a path inside `strip` and beyond; both ends must lie in the strip's first and last face.
    ///
    /// Works from the smaller spelling to the larger, so that a path and its reverse are the same path.
    pub(crate) fn run(
        &mut self,
        surface: &Surface,
        start: InnerPoint,
        end: InnerPoint,
        strip: &mut [HalfEdge],
        out: &mut InnerPath,
    ) {
        self.run_with(surface, [start, end], strip, false, out);
    }

    /// [`run`](Self::run), and then looks beside the path for shorter ones.
    ///
    /// Two paths on either side of a vertex of positive curvature may both be locally shortest: a search, which judges
    /// distances coarsely, may take the longer one.
    pub(crate) fn run_thoroughly(
        &mut self,
        surface: &Surface,
        start: InnerPoint,
        end: InnerPoint,
        strip: &mut [HalfEdge],
        out: &mut InnerPath,
    ) {
        self.run_with(surface, [start, end], strip, true, out);
    }

    fn run_with(
        &mut self,
        surface: &Surface,
        [start, end]: [InnerPoint; 2],
        strip: &mut [HalfEdge],
        thoroughly: bool,
        out: &mut InnerPath,
    ) {
        let backwards = order(&end, &start).is_lt();
        if backwards {
            reverse_strip(surface, strip);
        }
        let (mut start, mut end) = if backwards { (end, start) } else { (start, end) };
        self.make_room();
        self.strip.clear();
        for &h in strip.iter() {
            push(surface, &mut self.strip, h);
        }
        self.noise = None;
        self.taut = None;
        out.frozen = self.settle(surface, &mut start, &mut end, &mut out.at);
        if thoroughly && !out.frozen {
            let mut rounds = 0..MAX_DETOURS;
            while rounds.next().is_some() && self.look_beside(surface, &mut start, &mut end, &mut out.at) {}
        }
        (out.start, out.end) = (start, end);
        out.strip.clear();
        out.strip.extend_from_slice(&self.strip);
        out.measure(surface);
        if backwards {
            out.reverse(surface);
        }
    }

    /// Strips change places: all of them get the room that one of them once needed, so that it is found once for all.
    fn make_room(&mut self) {
        let strips = [&mut self.strip, &mut self.next, &mut self.before, &mut self.kept];
        let room = strips.iter().map(|strip| strip.capacity()).max().unwrap_or(0);
        strips.into_iter().for_each(|strip| {
            strip.clear();
            strip.reserve_exact(room);
        });
    }

    /// Straightens until the path is locally shortest, and fills in where it crosses sides; says whether a bound was met
    /// instead.
    fn settle(&mut self, surface: &Surface, start: &mut InnerPoint, end: &mut InnerPoint, at: &mut Vec<f64>) -> bool {
        for round in 0..=MAX_ROUNDS {
            let met_bound = round == MAX_ROUNDS || self.sweep(surface, start, end) || !self.finish(surface, start, end);
            self.pull(surface, start, end);
            self.funnel.crossings(&self.strip, &self.bends, at);
            if met_bound || !self.leave_straight_through(surface, start, end, at) {
                return met_bound;
            }
        }
        true
    }

    /// Tries to pass vertices of positive curvature beside the path on their other side, the most promising ones first, and
    /// straightens what comes of it; says whether that led to a shorter path, and leaves the path as it was where it did not.
    fn look_beside(
        &mut self,
        surface: &Surface,
        start: &mut InnerPoint,
        end: &mut InnerPoint,
        at: &mut Vec<f64>,
    ) -> bool {
        let length = self.pull(surface, start, end);
        let mut beside = std::mem::take(&mut self.beside);
        self.funnel.beside(surface, &self.strip, &self.bends, &mut beside);
        // What is gained there alone is but a hint: vertices near it have their say too.
        beside.retain(|b| b.gain > -HOPE * length);
        beside.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.bend.first.cmp(&b.bend.first)));
        let (mut kept, ends) = (std::mem::take(&mut self.kept), (*start, *end));
        let mut tried_at = std::mem::take(&mut self.tried_at);
        kept.clone_from(&self.strip);
        let mut found = false;
        for Beside { bend, .. } in beside.iter().take(MAX_TRIALS) {
            if !other_side(surface, &self.strip, bend, &mut self.fan) {
                continue;
            }
            self.splice(surface, bend);
            let frozen = self.settle(surface, start, end, &mut tried_at);
            let shorter = self.pull(surface, start, end);
            if !frozen && shorter < length * SHORTER {
                found = true;
                // Copied: swapped, what grew in one path would be missing in the next.
                at.clone_from(&tried_at);
                break;
            }
            self.strip.clone_from(&kept);
            (*start, *end) = ends;
            self.taut = None;
        }
        (self.beside, self.kept, self.tried_at) = (beside, kept, tried_at);
        found
    }

    /// Pulls the string taut, unless it is, and gives its length.
    fn pull(&mut self, surface: &Surface, start: &InnerPoint, end: &InnerPoint) -> f64 {
        *self.taut.get_or_insert_with(|| self.funnel.pull(surface, start, end, &self.strip, &mut self.bends))
    }

    /// A string that runs straight through a vertex of positive curvature does not bend there, and yet there is a shorter
    /// way on the other side. Passes the first such vertex where that holds; says whether there was one.
    fn leave_straight_through(&mut self, surface: &Surface, start: &InnerPoint, end: &InnerPoint, at: &[f64]) -> bool {
        let length = self.pull(surface, start, end);
        let mut candidates = std::mem::take(&mut self.straight_through);
        straight_through(surface, &self.strip, at, &mut candidates);
        let mut found = false;
        for bend in &candidates {
            let bent = |b: &Bend| b.vertex == bend.vertex && b.first <= bend.last && bend.first <= b.last;
            if surface.curvature(bend.vertex) <= STRAIGHT
                || self.bends.iter().any(bent)
                || !other_side(surface, &self.strip, bend, &mut self.fan)
            {
                continue;
            }
            self.splice(surface, bend);
            let shorter = self.pull(surface, start, end);
            if self.gains(surface, length, shorter) {
                found = true;
                break;
            }
            std::mem::swap(&mut self.strip, &mut self.next);
            self.taut = None;
            self.pull(surface, start, end);
        }
        self.straight_through = candidates;
        found
    }

    /// Whether the second length is less than the first by more than rounding.
    fn gains(&mut self, surface: &Surface, before: f64, after: f64) -> bool {
        let noise = *self.noise.get_or_insert_with(|| NOISE * longest_side(surface, &self.strip));
        before - after > (GAIN * before).max(noise)
    }

    /// Replaces the bend's run of sides by those in `fan`; the strip as it was is then in `next`.
    fn splice(&mut self, surface: &Surface, bend: &Bend) {
        self.next.clear();
        for &h in self.strip[..bend.first].iter().chain(&self.fan).chain(&self.strip[bend.last + 1..]) {
            push(surface, &mut self.next, h);
        }
        std::mem::swap(&mut self.strip, &mut self.next);
        self.taut = None;
    }

    /// Sweeps until no vertex can be passed with gain; says whether the bound was met instead.
    fn sweep(&mut self, surface: &Surface, start: &mut InnerPoint, end: &mut InnerPoint) -> bool {
        self.clean_ends(surface, start, end);
        let mut length = self.pull(surface, start, end);
        let mut stalled = 0;
        // A sweep moves the path by at most one ring of vertices, so sweeps grow with the displacement in rings.
        let bound = 4 * self.strip.len() + 1000;
        let mut met_bound = true;
        for _ in 0..bound {
            let before = (length, *start, *end);
            if !self.flip_all(surface) {
                met_bound = false;
                break;
            }
            std::mem::swap(&mut self.before, &mut self.next); // where flipping left the strip as it was
            self.clean_ends(surface, start, end);
            length = self.pull(surface, start, end);
            if self.gains(surface, length, before.0) {
                (*start, *end) = (before.1, before.2);
                std::mem::swap(&mut self.strip, &mut self.before);
                self.taut = None;
                met_bound = false;
                break;
            }
            // Equal but for rounding: angles know better than lengths then, but not for ever.
            stalled = if self.gains(surface, before.0, length) { 0 } else { stalled + 1 };
            if stalled >= MAX_STALLED {
                met_bound = false;
                break;
            }
        }
        met_bound
    }

    fn clean_ends(&mut self, surface: &Surface, start: &mut InnerPoint, end: &mut InnerPoint) {
        let faces = self.strip.len();
        clean_ends(surface, start, end, &mut self.strip);
        if self.strip.len() != faces {
            self.taut = None;
        }
    }

    /// Passes every vertex that can be passed with gain and whose run of sides is still as it was; says whether there was one.
    fn flip_all(&mut self, surface: &Surface) -> bool {
        self.next.clear();
        let (mut copied, mut flipped) = (0, false);
        for bend in &self.bends {
            if bend.first < copied || !improves(surface, bend) || !other_side(surface, &self.strip, bend, &mut self.fan)
            {
                continue;
            }
            for &h in self.strip[copied..bend.first].iter().chain(&self.fan) {
                push(surface, &mut self.next, h);
            }
            copied = bend.last + 1;
            flipped = true;
        }
        if flipped {
            for &h in &self.strip[copied..] {
                push(surface, &mut self.next, h);
            }
            std::mem::swap(&mut self.strip, &mut self.next);
            self.taut = None;
        }
        flipped
    }

    /// The guard behind the sweeps: passes the sharpest vertex alone, keeps the result if it is shorter, else leaves that
    /// vertex until the path has changed. Ends with no vertex left to try, which it confirms with `true`.
    fn finish(&mut self, surface: &Surface, start: &InnerPoint, end: &InnerPoint) -> bool {
        let mut refused = std::mem::take(&mut self.refused);
        refused.clear();
        let finished = self.pass_sharpest(surface, start, end, &mut refused);
        self.refused = refused;
        finished
    }

    /// The loop of [`finish`](Self::finish), with the vertices that were tried in vain.
    fn pass_sharpest(
        &mut self,
        surface: &Surface,
        start: &InnerPoint,
        end: &InnerPoint,
        refused: &mut Vec<u32>,
    ) -> bool {
        let mut length = self.pull(surface, start, end);
        for _ in 0..4 * self.strip.len() + 1000 {
            let sharpness = |b: &Bend| b.turn + surface.curvature(b.vertex);
            let candidate = self
                .bends
                .iter()
                .filter(|b| improves(surface, b) && !refused.contains(&b.vertex))
                .max_by(|a, b| sharpness(a).total_cmp(&sharpness(b)));
            let Some(&bend) = candidate else { return true };
            if !other_side(surface, &self.strip, &bend, &mut self.fan) {
                refused.push(bend.vertex);
                continue;
            }
            self.splice(surface, &bend);
            let shorter = self.pull(surface, start, end);
            if self.gains(surface, length, shorter) {
                length = shorter;
                refused.clear();
            } else {
                std::mem::swap(&mut self.strip, &mut self.next);
                self.taut = None;
                self.pull(surface, start, end);
                refused.push(bend.vertex);
            }
        }
        false
    }
}

/// The longest side of the faces in a strip.
fn longest_side(surface: &Surface, strip: &[HalfEdge]) -> f64 {
    let of_face = |face: u32| surface.lengths[face as usize].iter().fold(0.0_f64, |m, l| m.max(*l));
    strip.iter().fold(0.0, |m, h| m.max(of_face(h.face())).max(of_face(surface.twin(*h).face())))
}

/// Whether passing the bend's vertex on its other side makes the path shorter, if there is another side.
fn improves(surface: &Surface, bend: &Bend) -> bool {
    bend.turn > STRAIGHT && bend.turn + surface.curvature(bend.vertex) > STRAIGHT
}

/// The sides to cross when the bend's vertex is passed on its other side; `false` where the boundary is in the way.
fn other_side(surface: &Surface, strip: &[HalfEdge], bend: &Bend, fan: &mut Vec<HalfEdge>) -> bool {
    fan.clear();
    let goal = surface.twin(strip[bend.last]).face();
    let mut h = strip[bend.first];
    let around = |h: HalfEdge| if bend.left { h.next() } else { h.prev() };
    // Turning about a vertex comes back to where it began, so this ends after one round.
    while h.face() != goal {
        let side = around(h);
        h = surface.twin(side);
        if !h.is_some() {
            return false;
        }
        fan.push(side);
    }
    true
}

/// Appends a side to a strip; a step back to the face just left cancels.
fn push(surface: &Surface, strip: &mut Vec<HalfEdge>, h: HalfEdge) {
    if strip.last().is_some_and(|last| surface.twin(*last) == h) {
        strip.pop();
    } else {
        strip.push(h);
    }
}

/// Drops faces at the ends that the path does not enter: while an end lies on the side to its neighbour, it moves there.
pub(crate) fn clean_ends(surface: &Surface, start: &mut InnerPoint, end: &mut InnerPoint, strip: &mut Vec<HalfEdge>) {
    let on_side = |p: &InnerPoint, h: HalfEdge| p.weights[h.prev().side()] == 0.0;
    let mut skip = 0;
    while let Some(&h) = strip.get(skip)
        && start.zeros() != Zeros::None
        && on_side(start, h)
        && let Some(there) = surface.across(start, h)
    {
        *start = there;
        skip += 1;
    }
    strip.drain(..skip);
    while let Some(&h) = strip.last()
        && end.zeros() != Zeros::None
        && on_side(end, surface.twin(h))
        && let Some(there) = surface.across(end, surface.twin(h))
    {
        *end = there;
        strip.pop();
    }
}

/// A total order on spellings.
pub(crate) fn order(a: &InnerPoint, b: &InnerPoint) -> std::cmp::Ordering {
    let by = |i: usize| a.weights[i].total_cmp(&b.weights[i]);
    a.face.cmp(&b.face).then_with(|| by(1)).then_with(|| by(2)).then_with(|| by(0))
}
