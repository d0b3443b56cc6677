//! Fitting one segment to a stretch of a drawn line, or finding where to split it.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec2;

use super::{
    FitError, FitOptions,
    distance::{Line, farthest},
    planar::{Equations, Planar},
    shape::Shape,
};
use crate::curve::{Handle, SegmentTrace, Spline, Trace, TraceError, TraceWorkspace, handles};
use crate::geodesic::tangent::{InnerTangent, turn_at};
use crate::surface::{PointError, Surface, SurfacePoint};

/// Places of a stretch that its segment's lengths are found from.
const SAMPLES: usize = 40;
/// How often the lengths are improved on the surface.
const ROUNDS: u32 = 4;
/// How often the lengths of a refitted segment are improved.
const STEPS: u32 = 5;
/// A stretch that is farther from its segment in the plane than this many tolerances is not tried on the surface.
const HOPELESS: f64 = 4.0;

/// A segment and the stretch it stands for.
pub(super) struct Piece {
    /// The line's point where it begins.
    pub(super) from: usize,
    pub(super) start: SurfacePoint,
    pub(super) end: SurfacePoint,
    pub(super) outgoing: Handle,
    pub(super) incoming: Handle,
    pub(super) trace: Arc<SegmentTrace>,
    pub(super) distance: f64,
    pub(super) straight: bool,
}

/// What fits the stretches of one line.
pub(super) struct Fitter<'a> {
    surface: &'a Surface,
    workspace: &'a mut TraceWorkspace,
    shape: Shape,
    tolerance: f64,
    /// Points that are corners, in order.
    corners: Vec<usize>,
    /// Where tangents at points look for the line.
    window: f64,
    closed: bool,
    /// A spline of one segment, to be tried.
    candidate: Spline,
    trace: Trace,
    points: Vec<DVec2>,
    shares: Vec<f64>,
}

/// How near a candidate came.
#[derive(Clone, Copy)]
struct Tried {
    distance: f64,
    /// Where on the line it is farthest, by length.
    at: f64,
}

impl<'a> Fitter<'a> {
    pub(super) fn new(
        surface: &'a Surface,
        workspace: &'a mut TraceWorkspace,
        shape: Shape,
        options: &FitOptions,
        tolerance: f64,
        corners: Vec<usize>,
        closed: bool,
    ) -> Result<Self, PointError> {
        let ends = [0, shape.leg_count()].map(|k| handles::bare_anchor(surface, shape.point(k)));
        let [first, last] = ends;
        let candidate =
            Spline { anchors: vec![first?, last?], closed: false, scheme: options.scheme, jumps: Default::default() };
        let step = shape.length() / shape.leg_count() as f64;
        let window = (2.0 * tolerance).max(2.0 * step).min(0.125 * shape.length());
        Ok(Self {
            surface,
            workspace,
            shape,
            tolerance,
            corners,
            window,
            closed,
            candidate,
            trace: Trace::default(),
            points: Vec::new(),
            shares: Vec::new(),
        })
    }

    pub(super) fn corners(&self) -> &[usize] {
        &self.corners
    }

    /// The pieces of the whole line, in order.
    pub(super) fn all(&mut self) -> Result<Vec<Piece>, FitError> {
        let count = self.shape.leg_count();
        let mut ends = vec![0];
        ends.extend(self.corners.iter().copied().filter(|corner| (1..count).contains(corner)));
        ends.push(count);
        // What is still to be fitted, the next last. Each split takes a point of its own, so there is an end.
        let mut left: Vec<[usize; 2]> = ends.windows(2).rev().map(|pair| [pair[0], pair[1]]).collect();
        let mut pieces = Vec::new();
        while let Some([from, to]) = left.pop() {
            match self.piece(from, to)? {
                Ok(piece) => pieces.push(piece),
                Err(middle) => left.extend([[middle, to], [from, middle]]),
            }
        }
        Ok(pieces)
    }

    /// The segment for a stretch, or the point to split it at.
    fn piece(&mut self, from: usize, to: usize) -> Result<Result<Piece, usize>, FitError> {
        let directions = [self.direction(from, false), self.direction(to, true)];
        let tangents = self.tangents([from, to], directions);
        let (start, end) = (self.shape.at(from), self.shape.at(to));
        let length = end - start;
        self.sample(from, to);
        let headings = [DVec2::from_angle(directions[0]), DVec2::from_angle(super::reversed(directions[1]))];
        let ends = [start, end].map(|along| self.shape.flat(along));
        let planar = Planar { points: &self.points, ends, headings, length };
        let flat = planar.fit(&mut self.shares, 0.1 * self.tolerance);
        let is_leg = to - from == 1;
        if flat.error > HOPELESS * self.tolerance {
            let worst = start + length * (flat.worst + 1) as f64 / (SAMPLES + 1) as f64;
            return if is_leg { self.straight(from).map(Ok) } else { Ok(Err(self.split(from, to, worst))) };
        }
        self.place([from, to]);
        let mut lengths = flat.lengths;
        let mut best: Option<Tried> = None;
        for _ in 0..ROUNDS {
            self.reach_out(tangents, lengths)?;
            let tried = self.try_candidate(from, to)?;
            if tried.distance <= self.tolerance {
                return Ok(Ok(self.take(from, to, tried.distance, false)));
            }
            let is_better = best.is_none_or(|best| tried.distance < 0.8 * best.distance);
            if best.is_none_or(|best| tried.distance < best.distance) {
                best = Some(tried);
            }
            if !is_better {
                break;
            }
            let change = self.equations(from, to, headings).step(1e-4);
            let planar = Planar { points: &self.points, ends, headings, length };
            lengths = planar.within_bounds([0, 1].map(|k| lengths[k] + change[k]));
        }
        if is_leg {
            return self.straight(from).map(Ok);
        }
        Ok(Err(self.split(from, to, best.map_or(0.5 * (start + end), |best| best.at))))
    }

    /// Takes samples of a stretch in the plane.
    fn sample(&mut self, from: usize, to: usize) {
        let (start, end) = (self.shape.at(from), self.shape.at(to));
        self.points.clear();
        self.shares.clear();
        for k in 1..=SAMPLES {
            let share = k as f64 / (SAMPLES + 1) as f64;
            self.points.push(self.shape.flat(start + share * (end - start)));
            self.shares.push(share);
        }
    }

    /// Lengths of the two handles with which one segment follows the whole line, whose tangents at the ends are given, both away
    /// from there; and how far they are apart. The guess is taken where nothing better is found.
    pub(super) fn refit(
        &mut self,
        tangents: [InnerTangent; 2],
        guess: [f64; 2],
    ) -> Result<([f64; 2], f64), TraceError> {
        let (from, to) = (0, self.shape.leg_count());
        let headings = self.shape.headings(self.surface, tangents).map(DVec2::from_angle);
        let length = self.shape.length();
        self.sample(from, to);
        self.place([from, to]);
        let ends = [0.0, length].map(|along| self.shape.flat(along));
        let planar = Planar { points: &self.points, ends, headings, length };
        let flat = planar.fit(&mut self.shares, 0.0).lengths;
        let mut best = (guess, f64::INFINITY);
        for lengths in [guess, flat] {
            self.reach_out(tangents, lengths)?;
            let tried = self.try_candidate(from, to)?;
            if tried.distance < best.1 {
                best = (lengths, tried.distance);
            }
        }
        // The equations speak of what was traced last.
        let mut lengths = flat;
        for _ in 0..STEPS {
            let change = self.equations(from, to, headings).step(1e-6);
            let planar = Planar { points: &self.points, ends, headings, length };
            lengths = planar.within_bounds([0, 1].map(|k| lengths[k] + change[k]));
            self.reach_out(tangents, lengths)?;
            let tried = self.try_candidate(from, to)?;
            if tried.distance < best.1 {
                best = (lengths, tried.distance);
            }
        }
        Ok(best)
    }

    /// Gives the candidate's handles their lengths.
    fn reach_out(&mut self, tangents: [InnerTangent; 2], lengths: [f64; 2]) -> Result<(), PointError> {
        let [first, last] = [0, 1].map(|k| self.candidate.anchors[k].point);
        self.candidate.anchors[0].outgoing = handles::ahead(self.surface, &first, &tangents[0], lengths[0])?;
        self.candidate.anchors[1].incoming = handles::ahead(self.surface, &last, &tangents[1], lengths[1])?;
        Ok(())
    }

    /// The line's direction in the plane where a stretch begins or ends.
    fn direction(&self, point: usize, ends: bool) -> f64 {
        let (count, length) = (self.shape.leg_count(), self.shape.length());
        let loops = self.closed && !self.corners.contains(&0);
        if loops && point == count {
            return self.direction(0, ends) + self.shape.closing();
        }
        let is_end = |k: usize| self.corners.contains(&k) || (!loops && (k == 0 || k == count));
        let along = self.shape.at(point);
        let mut room = [self.window; 2];
        if !loops {
            room = [room[0].min(along), room[1].min(length - along)];
        }
        for corner in &self.corners {
            let way = self.shape.at(*corner) - along;
            if way < 0.0 {
                room[0] = room[0].min(-way);
            }
            if way > 0.0 {
                room[1] = room[1].min(way);
            }
        }
        if is_end(point) {
            room[usize::from(ends)] = 0.0;
        }
        self.shape.direction(point, room[0], room[1])
    }

    /// Tangents of the two handles, both away from their anchors; opposite to one another where stretches join smoothly.
    fn tangents(&self, [from, to]: [usize; 2], [out, into]: [f64; 2]) -> [InnerTangent; 2] {
        let (surface, shape) = (self.surface, &self.shape);
        let count = shape.leg_count();
        let loops = self.closed && !self.corners.contains(&0);
        let forward = if loops && to == count {
            shape.tangent(surface, 0, into - shape.closing())
        } else if self.corners.contains(&to) || to == count {
            shape.arriving(surface, to, into)
        } else {
            shape.tangent(surface, to, into)
        };
        let at = surface.inner_point(&shape.point(to)).unwrap_or_default();
        [shape.tangent(surface, from, out), turn_at(surface, &at, &forward, PI)]
    }

    /// Puts the candidate's ends where a stretch begins and ends.
    fn place(&mut self, ends: [usize; 2]) {
        for (anchor, end) in self.candidate.anchors.iter_mut().zip(ends) {
            anchor.point = handles::without_negative_zeros(self.shape.point(end));
        }
    }

    /// Traces the candidate and compares it with its stretch.
    fn try_candidate(&mut self, from: usize, to: usize) -> Result<Tried, TraceError> {
        self.candidate.trace_into(self.surface, self.workspace, &mut self.trace)?;
        let line = self.shape.stretch(from, to);
        let Some(trace) = self.trace.segments().first() else { return Ok(Tried { distance: f64::INFINITY, at: 0.0 }) };
        let curve = Line { positions: trace.polyline(), along: trace.distances() };
        let (there, at) = farthest(line, curve, self.tolerance);
        let (back, at_curve) = farthest(curve, line, self.tolerance);
        if there >= back {
            return Ok(Tried { distance: there, at });
        }
        let (start, end) = (self.shape.at(from), self.shape.at(to));
        let share = at_curve / trace.length().max(f64::MIN_POSITIVE);
        Ok(Tried { distance: back, at: start + share * (end - start) })
    }

    /// The equations for a change of the lengths, from what the trace misses on the surface.
    fn equations(&self, from: usize, to: usize, headings: [DVec2; 2]) -> Equations {
        let mut equations = Equations::default();
        let Some(trace) = self.trace.segments().first() else { return equations };
        let curve = Line { positions: trace.polyline(), along: trace.distances() };
        let (start, end) = (self.shape.at(from), self.shape.at(to));
        for k in 1..=SAMPLES {
            let share = k as f64 / (SAMPLES + 1) as f64;
            let along = start + share * (end - start);
            let position = self.shape.position(along);
            let Some(near) = curve.nearest(position, share, self.tolerance) else { continue };
            let missing = self.shape.flattened(along, position - near.position);
            // The curve runs as the line does, nearly.
            let step = 0.5 / (SAMPLES + 1) as f64 * (end - start);
            let tangent = self.shape.flat(along + step) - self.shape.flat(along - step);
            equations.add(trace.parameter_along(near.along), headings, tangent, missing);
        }
        equations
    }

    /// The candidate as a piece.
    fn take(&mut self, from: usize, to: usize, distance: f64, straight: bool) -> Piece {
        let trace = self.trace.segments().first().map(Arc::clone).unwrap_or_default();
        let [first, last] = [0, 1].map(|k| &self.candidate.anchors[k]);
        Piece {
            from,
            start: self.shape.point(from),
            end: self.shape.point(to),
            outgoing: first.outgoing.clone(),
            incoming: last.incoming.clone(),
            trace,
            distance,
            straight,
        }
    }

    /// The straight segment along a leg.
    fn straight(&mut self, from: usize) -> Result<Piece, FitError> {
        self.place([from, from + 1]);
        let (surface, leg) = (self.surface, self.shape.leg(from));
        let third = 1.0 / 3.0;
        let mut last = leg.piece(surface, 2.0 * third, 1.0);
        last.reverse(surface);
        self.candidate.anchors[0].outgoing = handles::along(surface, &leg.piece(surface, 0.0, third));
        self.candidate.anchors[1].incoming = handles::along(surface, &last);
        let tried = self.try_candidate(from, from + 1)?;
        if tried.distance > self.tolerance {
            let at = self.shape.point(from);
            return Err(FitError::NotReached { at, distance: tried.distance, tolerance: self.tolerance });
        }
        Ok(self.take(from, from + 1, tried.distance, true))
    }

    /// The point inside a stretch to split it at: the one nearest to a place, and not right at an end.
    fn split(&self, from: usize, to: usize, along: f64) -> usize {
        const MARGIN: f64 = 0.1;
        let (start, end) = (self.shape.at(from), self.shape.at(to));
        let margin = MARGIN * (end - start);
        self.shape.point_near(along.clamp(start + margin, end - margin)).clamp(from + 1, to - 1)
    }
}
