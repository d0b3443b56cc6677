//! Shortcuts: stretches of a drawn line that are straightened before anything is solved for.
//!
//! A jag costs a vertex passed for every edge that it is high, each with a solve around it. Straightening a stretch between two
//! of its crossings passes all of them at a fraction of that cost, and is a step of the same descent where what it saves in length is more
//! than what the tether asks for it (Birkhoff's curve shortening with a price). Stretches begin short and get longer as long as that pays.

use super::{
    engine::{Done, Engine, Plan},
    progress::Watch,
    strip::{Strip, UNKNOWN},
    tree::LineTree,
};
use crate::geodesic::{
    PathFinder,
    inner::{InnerPath, side_position},
};
use crate::surface::{HalfEdge, InnerPoint, Surface};
use glam::DVec3;
use std::ops::Range;

/// Length of the first stretches, in mean edges; each time they are longer by a factor.
const SHORTEST: f64 = 8.0;
const LONGER: f64 = 2.0;
/// Longest stretches, in lengths over which a disturbance of the tethered line dies away.
const LONGEST: f64 = 5.0;
/// Passes by stretches of one length, at least and at most: as long as so large a share of them is worth it.
const PASSES: [u32; 2] = [2, 6];
const WORTH: f64 = 0.4;
/// From stretches of this length on, in mean edges: where a smaller share of them is worth it in the first pass, no more and no longer ones are
/// tried.
const LONG: f64 = 32.0;
const FEW: f64 = 0.15;
/// Stretches that a closed line has at least.
const FEWEST: f64 = 6.0;
/// Stretches end at crossings this far from the ends of their sides, as a share of these.
const OFF_VERTICES: f64 = 0.05;
/// What saves less than this, in mean edges, is left as it is.
const LITTLE: f64 = 0.02;
/// How far apart places are at which the tether is asked, in mean edges.
const APART: f64 = 1.0;

/// Scratch memory.
#[derive(Debug, Default)]
pub(crate) struct Shortcuts {
    next: Strip,
    piece: Vec<HalfEdge>,
    path: InnerPath,
    near: Vec<u32>,
    others: Vec<u32>,
    positions: Vec<DVec3>,
    straight: Vec<DVec3>,
}

/// Between two pieces: a crossing of the line before.
#[derive(Clone, Copy, Debug)]
struct Joint {
    crossing: usize,
    /// The face in which the piece before ends.
    face: u32,
}

/// Which stretches are tried.
#[derive(Clone, Copy, Debug)]
struct Stretches {
    long: f64,
    /// Whether the first of them is half as long.
    half: bool,
    mean: f64,
}

/// What was tried, and what was worth it.
#[derive(Clone, Copy, Debug, Default)]
struct Taken {
    tried: usize,
    taken: usize,
}

impl Engine {
    /// Straightens stretches of a tethered line where that costs less than it saves; of the line as it was given, so that nothing is known of it
    /// but the tether's stiffness.
    pub(crate) fn take_shortcuts(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        strip: &mut Strip,
        plan: &Plan,
        watch: &mut Watch<'_>,
    ) {
        self.fill_stiffness(plan);
        let longest = LONGEST * plan.reach / plan.tether.unwrap_or(0.0).sqrt();
        let mut long = SHORTEST * plan.mean;
        loop {
            for pass in 0..PASSES[1] {
                let length = strip.length(surface);
                if strip.closed && length < FEWEST * long {
                    return;
                }
                let how = Stretches { long, half: pass % 2 == 1, mean: plan.mean };
                let Some(taken) = self.shortcuts_of(surface, finder, strip, how) else { return };
                watch.see(strip);
                if watch.stops(&Done::default(), || length) {
                    return;
                }
                let share = taken.taken as f64 / taken.tried.max(1) as f64;
                if pass == 0 && long >= LONG * plan.mean && taken.tried > 0 && share < FEW {
                    return;
                }
                let is_worth_it = share >= WORTH;
                if pass + 1 >= PASSES[0] && !is_worth_it {
                    break;
                }
            }
            long *= LONGER;
            if long > longest || long > LONGER * strip.length(surface) {
                return;
            }
        }
    }

    /// One pass over a line; none if it cannot be done, and the line is as it was.
    fn shortcuts_of(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        strip: &mut Strip,
        Stretches { long, half, mean }: Stretches,
    ) -> Option<Taken> {
        let Self { line, stiffness, shortcuts, .. } = self;
        let ends = |strip: &Strip, i: usize| {
            let h = strip.sides[i];
            let inside = strip.at[i].min(1.0 - strip.at[i]) >= OFF_VERTICES;
            inside && surface.twin(h).face() != h.face()
        };
        let n = strip.len();
        if n < 3 {
            return None;
        }
        if strip.closed {
            // The seam is an end of stretches; half a stretch on in every other pass.
            let mut way = if half { 0.5 * long } else { 0.0 };
            let mut first = None;
            for i in 0..n {
                way -= strip.crossing(surface, i).distance(strip.crossing(surface, (i + 1) % n));
                if way < 0.0 && ends(strip, i) {
                    first = Some(i);
                    break;
                }
            }
            strip.rotate(first?);
        }
        let start = if strip.closed { strip.crossing(surface, 0) } else { surface.inner_position(&strip.start) };
        let work = std::mem::take(shortcuts);
        let mut pass =
            Pass { surface, finder, line, stiffness, strip, mean, work, taken: Taken::default(), first: None };
        pass.begin();
        let (mut before, mut begin, mut way) = (None, 0, 0.0);
        if strip.closed {
            (before, begin) = (Some(Joint { crossing: 0, face: strip.sides[0].face() }), 1);
        } else if half {
            way = 0.5 * long;
        }
        let mut here = start;
        let mut fits = true;
        let first = begin;
        for i in first..n {
            let there = strip.crossing(surface, i);
            way += here.distance(there);
            here = there;
            if strip.fixed[i] || (way >= long && ends(strip, i)) {
                let face = pass.piece(before, begin..i, Some(i));
                fits &= face.is_some();
                before = face.map(|face| Joint { crossing: i, face });
                (begin, way) = (i + 1, 0.0);
            }
        }
        let last = pass.piece(before, begin..n, strip.closed.then_some(0));
        fits &= last.is_some() && (!strip.closed || last.is_some_and(|face| pass.close(face)));
        let taken = pass.taken;
        *shortcuts = pass.work;
        let next = &mut shortcuts.next;
        next.close_seam_if_closed(surface);
        // A fixed crossing at the seam may be led back over.
        let seam = next.sides.last().map(|last| surface.twin(*last));
        if !fits || (next.closed && (next.len() < 3 || seam == next.sides.first().copied())) {
            return None;
        }
        std::mem::swap(strip, next);
        strip.trim_ends(surface);
        Some(taken)
    }
}

/// One pass: pieces are straightened, or copied, one after the other.
struct Pass<'a> {
    surface: &'a Surface,
    finder: &'a mut PathFinder,
    line: &'a LineTree,
    stiffness: &'a [f64],
    strip: &'a Strip,
    mean: f64,
    work: Shortcuts,
    taken: Taken,
    /// Of a closed line: in which face its first piece begins.
    first: Option<u32>,
}

impl Pass<'_> {
    fn begin(&mut self) {
        let (next, strip) = (&mut self.work.next, self.strip);
        next.clear();
        (next.closed, next.start, next.end) = (strip.closed, strip.start, strip.end);
    }

    /// The crossings of a range between two joints, or the ends of the line; gives the face in which it ends, or none if that does not fit
    /// what was before.
    fn piece(&mut self, from: Option<Joint>, range: Range<usize>, to: Option<usize>) -> Option<u32> {
        let (surface, strip) = (self.surface, self.strip);
        let start = from.map_or(strip.start, |joint| behind(surface, strip, joint.crossing));
        let end = to.map_or(strip.end, |i| InnerPoint::on_side(strip.sides[i], strip.at[i]));
        let mut ends = [start.face, end.face];
        let is_taken = !range.is_empty() && self.is_worth_it([start, end], range.clone(), from.map(|j| j.crossing), to);
        if is_taken {
            ends = [self.work.path.start.face, self.work.path.end.face];
        }
        match from {
            None if is_taken => self.work.next.start = self.work.path.start,
            None => {}
            Some(joint) if strip.closed && joint.crossing == 0 => self.first = Some(ends[0]),
            Some(joint) => self.join(joint, ends[0]).then_some(())?,
        }
        let Shortcuts { next, path, near, .. } = &mut self.work;
        let mut held = false;
        if is_taken {
            if to.is_none() {
                next.end = path.end;
            }
            let [low, mut high] = [from.map(|joint| joint.crossing), to].map(|i| i.map(|i| strip.along[i]));
            if strip.closed && high <= low {
                high = high.map(|high| high + 1.0);
            }
            let (low, high) = (low.unwrap_or(0.0), high.unwrap_or(1.0));
            for (k, (h, at)) in path.strip.iter().zip(&path.at).enumerate() {
                let along = low + (high - low) * path.travelled[k] / path.length;
                let along = if strip.closed { along - along.floor() } else { along };
                let count = next.len();
                held |= next.push(surface, *h, *at, along, false);
                if let (true, Some(nearest)) = (next.len() > count, next.near.last_mut()) {
                    *nearest = near[k];
                }
            }
        } else {
            for i in range {
                held |= next.push_from(surface, strip, i);
            }
        }
        (!held).then_some(ends[1])
    }

    /// Joins the piece before a joint to one that begins in a face behind it or before it.
    fn join(&mut self, joint: Joint, face: u32) -> bool {
        let (surface, strip, i) = (self.surface, self.strip, joint.crossing);
        let h = strip.sides[i];
        let twin = surface.twin(h);
        let next = &mut self.work.next;
        if joint.face == face {
            !strip.fixed[i]
        } else if (joint.face, face) == (h.face(), twin.face()) {
            !next.push_from(surface, strip, i)
        } else if (joint.face, face) == (twin.face(), h.face()) {
            !strip.fixed[i] && !next.push(surface, twin, 1.0 - strip.at[i], strip.along[i], false)
        } else {
            false
        }
    }

    /// Joins the last piece of a closed line to its first.
    fn close(&mut self, face: u32) -> bool {
        self.first.is_some_and(|first| self.join(Joint { crossing: 0, face }, first))
    }

    /// Straightens a piece, into the path; whether the tether asks less for it than it saves.
    fn is_worth_it(
        &mut self,
        [start, end]: [InnerPoint; 2],
        range: Range<usize>,
        from: Option<usize>,
        to: Option<usize>,
    ) -> bool {
        let (surface, strip) = (self.surface, self.strip);
        let Shortcuts { piece, path, near, others, positions, straight, .. } = &mut self.work;
        positions.clear();
        positions.push(surface.inner_position(&start));
        positions.extend(range.clone().map(|i| strip.crossing(surface, i)));
        positions.push(surface.inner_position(&end));
        let price = Price { line: self.line, stiffness: self.stiffness, apart: APART * self.mean };
        let long = length(positions);
        let enough = long - LITTLE * self.mean;
        if positions[0].distance(positions[positions.len() - 1]) >= enough {
            return false;
        }
        self.taken.tried += 1;
        piece.clear();
        piece.extend_from_slice(&strip.sides[range.clone()]);
        self.finder.continue_inner(surface, &start, &end, piece, path);
        let is_at = |face: u32, i: Option<usize>, own: u32| match i {
            None => true,
            Some(i) if strip.fixed[i] => face == own,
            Some(i) => face == strip.sides[i].face() || face == surface.twin(strip.sides[i]).face(),
        };
        if path.length >= enough
            || path.frozen
            || !is_at(path.start.face, from, start.face)
            || !is_at(path.end.face, to, end.face)
        {
            return false;
        }
        straight.clear();
        straight.push(surface.inner_position(&path.start));
        straight.extend(path.strip.iter().zip(&path.at).map(|(h, at)| side_position(surface, *h, *at)));
        straight.push(surface.inner_position(&path.end));
        // Crossings of the drawn line are on it.
        let hint = range.clone().map(|i| strip.near[i]).find(|near| *near != UNKNOWN);
        let then = price.of(straight, hint, near);
        let worth = then < long || hint.is_some() && then < price.of(positions, hint, others);
        self.taken.taken += usize::from(worth);
        worth
    }
}

/// What the tether asks for.
struct Price<'a> {
    line: &'a LineTree,
    stiffness: &'a [f64],
    /// Places are this far apart at least.
    apart: f64,
}

impl Price<'_> {
    /// Length and tether of some positions in a row; fills in the nearest stretches of those between the ends, about.
    fn of(&self, positions: &[DVec3], hint: Option<u32>, near: &mut Vec<u32>) -> f64 {
        near.clear();
        let mut hint = hint.map(|hint| hint as usize);
        let mut pull = |p: DVec3| {
            let Some(found) = self.line.nearest(p, hint) else { return (0.0, UNKNOWN) };
            hint = Some(found.stretch);
            let stiff = self.stiffness.get(found.stretch).copied().unwrap_or(0.0);
            (0.25 * stiff * found.distance * found.distance, found.stretch as u32)
        };
        let mut before = positions.first().map_or((0.0, UNKNOWN), |p| pull(*p));
        let (mut sum, mut way) = (0.0, 0.0);
        for (k, pair) in positions.windows(2).enumerate() {
            way += pair[0].distance(pair[1]);
            let is_last = k + 2 == positions.len();
            if way >= self.apart || is_last {
                let here = pull(pair[1]);
                sum += way * (1.0 + before.0 + here.0);
                (before, way) = (here, 0.0);
            }
            if !is_last {
                near.push(before.1);
            }
        }
        sum
    }
}

fn length(positions: &[DVec3]) -> f64 {
    positions.windows(2).fold(0.0, |sum, pair| sum + pair[0].distance(pair[1]))
}

/// A crossing as a point of the face that is entered.
fn behind(surface: &Surface, strip: &Strip, i: usize) -> InnerPoint {
    InnerPoint::on_side(surface.twin(strip.sides[i]), 1.0 - strip.at[i])
}
