//! The shape of a drawn line: where it runs in space, and rolled out into the plane.

use glam::{DVec2, DVec3};

use super::{DrawnLine, distance::Line};
use crate::curve::average::{Averager, Span};
use crate::geodesic::{
    PathFinder, PathQuality,
    inner::InnerPath,
    tangent::{InnerTangent, turn_at},
    transport::{angle_at, final_direction, initial_direction, transport},
};
use crate::surface::{PointError, Surface, SurfacePoint};

/// A drawn line in space and in the plane.
///
/// The surface is rolled along the line, so that lengths and turns are in the plane what they are on it. Seen from a place of
/// the line, what is near lies in the plane as the logarithmic map there shows it; ends of long stretches are off by what
/// the surface curves in between.
#[derive(Debug, Default)]
pub(super) struct Shape {
    closed: bool,
    /// Points and crossings.
    positions: Vec<DVec3>,
    /// Length up to each position.
    along: Vec<f64>,
    flat: Vec<DVec2>,
    /// One for each stretch between positions.
    frames: Vec<Frame>,
    /// Which positions are the line's points; of a closed line the first comes last again.
    vertices: Vec<usize>,
    points: Vec<SurfacePoint>,
    legs: Vec<Leg>,
    /// By how much the plane is turned after once round a closed line.
    closing: f64,
}

/// How a stretch of the line lies in space and in the plane.
#[derive(Clone, Copy, Debug)]
struct Frame {
    ahead: DVec3,
    left: DVec3,
    /// Direction in the plane.
    angle: f64,
}

/// A path from point to point.
#[derive(Debug)]
struct Leg {
    path: InnerPath,
    leaving: (InnerTangent, f64),
    arriving: (InnerTangent, f64),
}

/// Samples on either side that a tangent is made of.
const SAMPLES: i32 = 6;

impl Shape {
    /// The shape of a line, which has a path; a closed one begins at point `first`.
    pub(super) fn of(
        surface: &Surface,
        finder: &mut PathFinder,
        line: &DrawnLine,
        first: usize,
    ) -> Result<Self, PointError> {
        let count = line.paths().len();
        let mut shape = Self { closed: line.is_closed(), ..Self::default() };
        let mut angle = 0.0;
        for k in 0..count {
            let path = InnerPath::from_outer(surface, &line.paths()[(first + k) % count])?;
            let averager = Averager { surface, finder, quality: PathQuality::Default };
            angle += shape.legs.last().map_or(0.0, |last| averager.turn(Span::whole(&last.path), Span::whole(&path)));
            angle = shape.add(surface, path, angle);
        }
        if let (true, Some(start), Some(end)) = (shape.closed, shape.legs.first(), shape.legs.last()) {
            let averager = Averager { surface, finder, quality: PathQuality::Default };
            let turn = averager.turn(Span::whole(&end.path), Span::whole(&start.path));
            shape.closing = end.arriving.1 + turn - start.leaving.1;
        }
        let points = line.points();
        shape.points.extend((0..=count).map(|k| points[(first + k) % points.len()]));
        Ok(shape)
    }

    /// Adds a leg that leaves at some angle and gives the angle at which it arrives.
    fn add(&mut self, surface: &Surface, path: InnerPath, angle: f64) -> f64 {
        let (leaving, arriving) = (initial_direction(surface, &path), final_direction(surface, &path));
        if self.positions.is_empty() {
            self.push(surface, surface.inner_position(&path.start), path.face(0), angle);
            self.vertices.push(0);
        }
        let bend = path.at.iter().position(|at| *at == 0.0 || *at == 1.0);
        let arriving_angle = bend.map_or(angle, |_| {
            let carried = transport(surface, &path, &leaving);
            angle + within_half_turn(angle_at(surface, &path.end, &carried, &arriving))
        });
        for k in 0..path.strip.len() {
            let angle = if bend.is_some_and(|bend| k > bend) { arriving_angle } else { angle };
            self.push(surface, path.crossing_position(surface, k), path.face(k), angle);
        }
        self.push(surface, surface.inner_position(&path.end), path.end.face, arriving_angle);
        self.vertices.push(self.positions.len() - 1);
        self.legs.push(Leg { path, leaving: (leaving, angle), arriving: (arriving, arriving_angle) });
        arriving_angle
    }

    /// Adds a position, reached through a face at an angle, unless it is the last one again.
    fn push(&mut self, surface: &Surface, position: DVec3, face: u32, angle: f64) {
        let position = surface.origin + position;
        if let (Some(last), Some(along), Some(flat)) = (self.positions.last(), self.along.last(), self.flat.last()) {
            let (way, length) = (position - *last, position.distance(*last));
            if length <= 0.0 {
                return;
            }
            let (along, flat) = (along + length, *flat + DVec2::from_angle(angle) * length);
            let ahead = way / length;
            self.frames.push(Frame { ahead, left: surface.face_normal(face).cross(ahead), angle });
            self.along.push(along);
            self.flat.push(flat);
        } else {
            self.along.push(0.0);
            self.flat.push(DVec2::ZERO);
        }
        self.positions.push(position);
    }

    /// Number of legs; points are counted from 0 to this.
    pub(super) fn leg_count(&self) -> usize {
        self.legs.len()
    }

    pub(super) fn leg(&self, k: usize) -> &InnerPath {
        &self.legs[k].path
    }

    pub(super) fn point(&self, k: usize) -> SurfacePoint {
        self.points[k]
    }

    pub(super) fn length(&self) -> f64 {
        self.along.last().copied().unwrap_or(0.0)
    }

    /// Length up to a point.
    pub(super) fn at(&self, point: usize) -> f64 {
        self.along[self.vertices[point]]
    }

    /// The point nearest to a place, by length.
    pub(super) fn point_near(&self, along: f64) -> usize {
        let after = self.vertices.partition_point(|v| self.along[*v] < along).min(self.leg_count());
        let before = after.saturating_sub(1);
        if along - self.at(before) < self.at(after) - along { before } else { after }
    }

    /// The line from point to point, in space.
    pub(super) fn stretch(&self, from: usize, to: usize) -> Line<'_> {
        let range = self.vertices[from]..=self.vertices[to];
        Line { positions: &self.positions[range.clone()], along: &self.along[range] }
    }

    /// The stretch between positions at a length, and the share of it before.
    fn locate(&self, along: f64) -> (usize, f64) {
        let last = self.frames.len().saturating_sub(1);
        let k = self.along.partition_point(|d| *d <= along).saturating_sub(1).min(last);
        (k, ((along - self.along[k]) / (self.along[k + 1] - self.along[k])).clamp(0.0, 1.0))
    }

    /// The place at a length, in space.
    pub(super) fn position(&self, along: f64) -> DVec3 {
        let (k, share) = self.locate(along);
        self.positions[k].lerp(self.positions[k + 1], share)
    }

    /// The place at a length, in the plane; of a closed line also before its start and after its end.
    pub(super) fn flat(&self, along: f64) -> DVec2 {
        let end = self.flat.last().copied().unwrap_or(DVec2::ZERO);
        let turn = DVec2::from_angle(self.closing);
        if self.closed && along < 0.0 {
            let before = self.flat_inside(along + self.length()) - end;
            return DVec2::new(turn.x, -turn.y).rotate(before);
        }
        if self.closed && along > self.length() {
            return end + turn.rotate(self.flat_inside(along - self.length()));
        }
        self.flat_inside(along)
    }

    fn flat_inside(&self, along: f64) -> DVec2 {
        let (k, share) = self.locate(along);
        self.flat[k].lerp(self.flat[k + 1], share)
    }

    /// A vector in space at a length, in the plane.
    pub(super) fn flattened(&self, along: f64, vector: DVec3) -> DVec2 {
        let Frame { ahead, left, angle } = self.frames[self.locate(along).0];
        DVec2::from_angle(angle).rotate(DVec2::new(vector.dot(ahead), vector.dot(left)))
    }

    /// By how much the line turns at a point, seen from `reach` on either side.
    pub(super) fn turn(&self, point: usize, reach: f64) -> f64 {
        let along = self.at(point);
        let reach = if self.closed { reach } else { reach.min(along).min(self.length() - along) };
        let [before, here, after] = [-reach, 0.0, reach].map(|d| self.flat(along + d));
        (here - before).angle_to(after - here)
    }

    /// Direction of the line at a point, in the plane: from a parabola through it that fits what lies within `before` and
    /// `after` of it.
    pub(super) fn direction(&self, point: usize, before: f64, after: f64) -> f64 {
        let along = self.at(point);
        let here = self.flat(along);
        // With x the place and u the length from here: x = a u + b u².
        let [mut uu, mut uuu, mut uuuu] = [0.0; 3];
        let [mut xu, mut xuu] = [DVec2::ZERO; 2];
        for k in -SAMPLES..=SAMPLES {
            let u = if k < 0 { before } else { after } * f64::from(k) / f64::from(SAMPLES);
            let x = self.flat(along + u) - here;
            (uu, uuu, uuuu) = (uu + u * u, uuu + u * u * u, uuuu + u * u * u * u);
            (xu, xuu) = (xu + u * x, xuu + u * u * x);
        }
        let a = uuuu * xu - uuu * xuu;
        a.y.atan2(a.x)
    }

    /// The tangent of a direction in the plane at a point, seen along the leg that begins there, or, at the end of an open
    /// line, that ends there. The two ends of a closed line have directions of their own in the plane.
    pub(super) fn tangent(&self, surface: &Surface, point: usize, direction: f64) -> InnerTangent {
        match self.legs.get(point) {
            Some(leg) => turn_at(surface, &leg.path.start, &leg.leaving.0, direction - leg.leaving.1),
            None => self.arriving(surface, point, direction),
        }
    }

    /// [`tangent`](Self::tangent) seen along the leg that ends at the point.
    pub(super) fn arriving(&self, surface: &Surface, point: usize, direction: f64) -> InnerTangent {
        let leg = &self.legs[point - 1];
        turn_at(surface, &leg.path.end, &leg.arriving.0, direction - leg.arriving.1)
    }

    /// Angles in the plane of tangents at the two ends of the line.
    pub(super) fn headings(&self, surface: &Surface, [first, last]: [InnerTangent; 2]) -> [f64; 2] {
        let (Some(start), Some(end)) = (self.legs.first(), self.legs.last()) else { return [0.0; 2] };
        [
            start.leaving.1 + angle_at(surface, &start.path.start, &start.leaving.0, &first),
            end.arriving.1 + angle_at(surface, &end.path.end, &end.arriving.0, &last),
        ]
    }

    /// By how much the plane is turned at the end of a closed line.
    pub(super) fn closing(&self) -> f64 {
        self.closing
    }
}

/// The angle in (−π, π].
fn within_half_turn(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let angle = angle.rem_euclid(TAU);
    if angle > PI { angle - TAU } else { angle }
}
