//! The inside of a shape as triangles that are kept while they can be.

use std::collections::HashMap;

use glam::{Vec2, Vec3};
use lyon_tessellation::geometry_builder::{FillGeometryBuilder, GeometryBuilder, GeometryBuilderError};
use lyon_tessellation::math::{Point, point};
use lyon_tessellation::path::{ControlPointId, EndpointId, IdEvent, PositionStore};
use lyon_tessellation::{FillOptions, FillTessellator, FillVertex, VertexId, VertexSource};

use super::Picture;
use super::picture::{PictureShape, point as cubic_point};
use super::shade::Shade;
use crate::vector::FillRule;

/// Pieces that a segment is flattened into at most.
const MOST_PIECES: f32 = 64.0;
/// How often a triangle is halved at most.
const DEEPEST: u32 = 24;

/// The outline of a shape, flattened, and the triangles inside.
#[derive(Clone, Debug, Default)]
pub(super) struct Fill {
    /// Of each segment of the shape's paths.
    pieces: Vec<u8>,
    /// Of each path, and one past the last.
    firsts: Vec<u32>,
    samples: Vec<Vec3>,
    /// The same in the plane.
    flat: Vec<Vec2>,
    /// Corners by their numbers: samples, then what is between them.
    triangles: Vec<[u32; 3]>,
    between: Vec<Between>,
    /// Those triangles, divided where the paint asks for it.
    divided: Vec<[u32; 3]>,
    /// Whether the triangles may be kept.
    keepable: bool,
    pub(super) colors: Vec<[f32; 4]>,
}

/// A place between three samples.
#[derive(Clone, Copy, Debug)]
struct Between {
    of: [u32; 3],
    shares: Vec3,
}

/// Memory for tessellating.
#[derive(Default)]
pub(super) struct FillScratch {
    tessellator: FillTessellator,
    events: Vec<IdEvent>,
    numbers: Vec<u32>,
    rest: Vec<Vec3>,
    /// The vertex in the middle of an edge that was divided.
    middles: HashMap<[u32; 2], u32>,
    /// Triangles that may have to be divided, and how often they were.
    open: Vec<([u32; 3], u32)>,
}

impl std::fmt::Debug for FillScratch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FillScratch").finish_non_exhaustive()
    }
}

/// What became of a fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filled {
    /// Corners moved.
    Moved,
    /// It has other triangles.
    Anew,
}

impl Fill {
    /// Follows the control points of a shape.
    pub(super) fn update(
        &mut self,
        picture: &Picture,
        shape: &PictureShape,
        points: &[Vec3],
        scratch: &mut FillScratch,
    ) -> Filled {
        let Some((shade, rule)) = &shape.fill else { return Filled::Moved };
        let refined = self.refine(picture, shape, points);
        flatten(picture, shape, points, &self.pieces, &mut self.samples, &mut self.firsts);
        self.flat.clear();
        self.flat.extend(self.samples.iter().map(|p| picture.flat(*p)));
        if !refined && self.keepable && *rule == FillRule::NonZero && self.still_fits(picture.tolerance) {
            return Filled::Moved;
        }
        self.tessellate(picture, shape, *rule, scratch);
        if picture.spacing.is_finite() {
            self.space_out(picture.spacing, scratch);
        }
        self.paint(picture, shape, shade, scratch);
        Filled::Anew
    }

    /// Number of vertices.
    fn len(&self) -> usize {
        self.samples.len() + self.between.len()
    }

    /// Memory that it has taken, in items.
    pub(super) fn capacity(&self) -> usize {
        self.samples.capacity() + self.triangles.capacity() + self.between.capacity() + self.divided.capacity()
    }

    /// Positions of all vertices.
    pub(super) fn positions(&self) -> impl Iterator<Item = Vec3> {
        let place = |between: &Between| {
            let [a, b, c] = between.of.map(|i| self.samples[i as usize]);
            a * between.shares.x + b * between.shares.y + c * between.shares.z
        };
        self.samples.iter().copied().chain(self.between.iter().map(place))
    }

    /// The triangles to be drawn.
    pub(super) fn triangles(&self) -> &[[u32; 3]] {
        if self.divided.is_empty() { &self.triangles } else { &self.divided }
    }

    /// Sees to it that segments have pieces enough; whether some got more.
    fn refine(&mut self, picture: &Picture, shape: &PictureShape, points: &[Vec3]) -> bool {
        let paths = &picture.paths[shape.paths.clone()];
        let count = paths.iter().map(|path| path.segment_count()).sum();
        let mut refined = self.pieces.len() != count;
        self.pieces.resize(count, 0);
        let segments = paths.iter().flat_map(|path| (0..path.segment_count()).map(move |i| path.segment(points, i)));
        for (pieces, segment) in self.pieces.iter_mut().zip(segments) {
            let wanted = wanted_pieces(segment, picture);
            if wanted > f32::from(*pieces) {
                // Some more at once, so that a curve that bends by and by is not divided again and again.
                *pieces = (1.25 * wanted).ceil().clamp(1.0, MOST_PIECES) as u8;
                refined = true;
            }
        }
        refined
    }

    /// Whether no triangle turns over by more than the tolerance.
    fn still_fits(&self, tolerance: f32) -> bool {
        self.triangles.iter().all(|triangle| {
            let [a, b, c] = triangle.map(|i| self.flat[i as usize]);
            let (ab, ac) = (b - a, c - a);
            let doubled = ab.perp_dot(ac);
            // Twice the area over the longest side is how far the corner opposite to it is on the wrong side.
            doubled >= 0.0
                || doubled * doubled
                    <= tolerance * tolerance * ab.length_squared().max(ac.length_squared()).max(b.distance_squared(c))
        })
    }

    fn tessellate(&mut self, picture: &Picture, shape: &PictureShape, rule: FillRule, scratch: &mut FillScratch) {
        self.triangles.clear();
        self.between.clear();
        self.divided.clear();
        let FillScratch { tessellator, events, numbers, .. } = scratch;
        events.clear();
        numbers.clear();
        let mut distinct = 0;
        for (range, _) in self.firsts.windows(2).zip(&picture.paths[shape.paths.clone()]) {
            let (first, last) = (range[0], range[1].saturating_sub(1));
            if first >= last {
                continue;
            }
            let id = EndpointId;
            events.push(IdEvent::Begin { at: id(first) });
            events.extend((first..last).map(|i| IdEvent::Line { from: id(i), to: id(i + 1) }));
            events.push(IdEvent::End { last: id(last), first: id(first), close: true });
            let around = (first..=last).zip((first + 1..=last).chain([first]));
            distinct += around.filter(|(a, b)| self.flat[*a as usize] != self.flat[*b as usize]).count();
        }
        let store = Samples { flat: &self.flat, magnified: picture.magnified };
        let mut sink = Sink {
            samples: self.samples.len() as u32,
            numbers,
            between: &mut self.between,
            triangles: &mut self.triangles,
        };
        let rule = match rule {
            FillRule::NonZero => lyon_tessellation::FillRule::NonZero,
            FillRule::EvenOdd => lyon_tessellation::FillRule::EvenOdd,
        };
        let options = FillOptions::default().with_fill_rule(rule);
        let done = tessellator.tessellate_with_ids(events.iter().copied(), &store, None, &options, &mut sink);
        if done.is_err() {
            // What it does not know how to fill is not filled; it may be again in the next pose.
            self.triangles.clear();
            self.between.clear();
        }
        // Vertices that are one place now may be two later.
        let vertices = numbers.len();
        self.keepable = done.is_ok() && self.between.is_empty() && vertices == distinct;
        for triangle in &mut self.triangles {
            let [a, b, c] = *triangle;
            let places = [a, b, c].map(|i| place_of(i, &self.flat, &self.between));
            if (places[1] - places[0]).perp_dot(places[2] - places[0]) < 0.0 {
                *triangle = [a, c, b];
            }
        }
    }

    /// Divides triangles until no edge is longer than it may be. Whether an edge is divided depends on its ends alone, so neighbours meet.
    fn space_out(&mut self, spacing: f32, scratch: &mut FillScratch) {
        let FillScratch { middles, open, .. } = scratch;
        middles.clear();
        open.clear();
        // Whether they may be kept is decided by the triangles as they were.
        self.divided.clear();
        open.extend(self.triangles.iter().map(|triangle| (*triangle, 0)));
        while let Some(([a, b, c], depth)) = open.pop() {
            let at = |i: u32| place_of(i, &self.flat, &self.between);
            let long = |a: u32, b: u32| at(a).distance_squared(at(b));
            let sides = [(long(a, b), [a, b, c]), (long(b, c), [b, c, a]), (long(c, a), [c, a, b])];
            let longest = sides.into_iter().max_by(|x, y| x.0.total_cmp(&y.0));
            let Some((length, [a, b, c])) = longest else { continue };
            let is_crossing = [a, b, c].iter().any(|i| *i as usize >= self.samples.len() && depth == 0);
            if length <= spacing * spacing || depth >= DEEPEST || is_crossing {
                self.divided.push([a, b, c]);
                continue;
            }
            let (samples, between) = (self.samples.len() as u32, &mut self.between);
            let middle = *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let middle = middle_of(a.min(b), a.max(b), samples, between);
                between.push(middle);
                samples + between.len() as u32 - 1
            });
            open.extend([([a, middle, c], depth + 1), ([middle, b, c], depth + 1)]);
        }
    }

    /// Colours of all vertices; triangles of a gradient are divided for it.
    fn paint(&mut self, picture: &Picture, shape: &PictureShape, shade: &Shade, scratch: &mut FillScratch) {
        self.colors.clear();
        if let Shade::Plain(color) = shade {
            self.colors.resize(self.len(), *color);
            return;
        }
        let (rest, firsts) = (&mut scratch.rest, &mut scratch.numbers);
        flatten(picture, shape, picture.rest(), &self.pieces, rest, firsts);
        let sample = |i: u32| rest.get(i as usize).copied().unwrap_or_default();
        let place = |between: &Between| {
            let [a, b, c] = between.of.map(sample);
            picture.drawn(a * between.shares.x + b * between.shares.y + c * between.shares.z)
        };
        let samples = rest.len() as u32;
        let rest_of = |i: u32, all: &[Between]| {
            all.get(i.wrapping_sub(samples) as usize)
                .filter(|_| i >= samples)
                .map_or_else(|| picture.drawn(sample(i)), place)
        };
        let parts = |[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [*a, *b, *c].map(|i| rest_of(i, &self.between));
            [b - a, c - b, a - c].map(|edge| shade.parts(edge)).into_iter().max()
        };
        // The same number everywhere, so that neighbours meet.
        let parts = self.triangles.iter().filter_map(parts).max().unwrap_or(1);
        if parts > 1 && self.divided.is_empty() {
            divide(&self.triangles, parts, samples, &mut self.between, &mut self.divided);
        }
        self.colors.extend(rest.iter().map(|p| shade.at(picture.drawn(*p))));
        self.colors.extend(self.between.iter().map(|between| shade.at(place(between))));
    }
}

/// How many pieces of equal parameters keep a chord within a tolerance of its curve (Wang 1984), and not longer than it may be.
fn wanted_pieces([a, b, c, d]: [Vec3; 4], picture: &Picture) -> f32 {
    let bend = (a - b - b + c).length_squared().max((b - c - c + d).length_squared()).sqrt();
    let length = a.distance(b).max(b.distance(c)).max(c.distance(d)) * 3.0;
    let pieces = (0.75 * bend / picture.tolerance).sqrt().max(length / picture.spacing);
    pieces.ceil().clamp(1.0, MOST_PIECES)
}

/// Points along the paths of a shape.
fn flatten(
    picture: &Picture,
    shape: &PictureShape,
    points: &[Vec3],
    pieces: &[u8],
    samples: &mut Vec<Vec3>,
    firsts: &mut Vec<u32>,
) {
    samples.clear();
    firsts.clear();
    let mut pieces = pieces.iter();
    for path in &picture.paths[shape.paths.clone()] {
        firsts.push(samples.len() as u32);
        for (i, pieces) in (0..path.segment_count()).zip(&mut pieces) {
            let segment = path.segment(points, i);
            let step = 1.0 / f32::from(*pieces);
            samples.push(segment[0]);
            samples.extend((1..*pieces).map(|k| cubic_point(segment, f32::from(k) * step)));
        }
        if !path.closed {
            samples.extend(points[path.points.clone()].last());
        }
    }
    firsts.push(samples.len() as u32);
}

fn place_of(i: u32, flat: &[Vec2], between: &[Between]) -> Vec2 {
    let sample = |i: u32| flat.get(i as usize).copied().unwrap_or_default();
    let Some(Between { of, shares }) = (i as usize).checked_sub(flat.len()).and_then(|at| between.get(at)) else {
        return sample(i);
    };
    let [a, b, c] = of.map(sample);
    a * shares.x + b * shares.y + c * shares.z
}

/// The place between two others, of which all lie between the samples of one triangle.
fn middle_of(a: u32, b: u32, samples: u32, all: &[Between]) -> Between {
    let mut middle = Between { of: [0; 3], shares: Vec3::ZERO };
    let mut count = 0;
    let mut add = |sample: u32, share: f32| {
        let known = (0..count).find(|i| middle.of[*i] == sample);
        // There are no more than three.
        let place = known.unwrap_or(count).min(2);
        middle.of[place] = sample;
        middle.shares[place] += share;
        count = count.max(place + 1);
    };
    for end in [a, b] {
        match end.checked_sub(samples).and_then(|i| all.get(i as usize)) {
            None => add(end, 0.5),
            Some(Between { of, shares }) => {
                for (sample, share) in of.iter().zip(shares.to_array()).filter(|(_, share)| *share != 0.0) {
                    add(*sample, 0.5 * share);
                }
            }
        }
    }
    let first = middle.of[0];
    middle.of[count.max(1)..].fill(first);
    middle
}

/// Divides each triangle in the square of so many parts. Corners that are no samples are themselves between such.
fn divide(triangles: &[[u32; 3]], parts: u32, samples: u32, between: &mut Vec<Between>, divided: &mut Vec<[u32; 3]>) {
    for triangle in triangles {
        // Triangles with a corner that is a crossing stay whole: what is between the samples of two outlines has no three of them.
        if triangle.iter().any(|i| *i >= samples) {
            divided.push(*triangle);
            continue;
        }
        let first = samples + between.len() as u32;
        let share = |k: u32| k as f32 / parts as f32;
        for i in 0..=parts {
            between.extend(
                (0..=i).map(|k| Between { of: *triangle, shares: Vec3::new(share(parts - i), share(i - k), share(k)) }),
            );
        }
        let at = |i: u32, k: u32| first + i * (i + 1) / 2 + k;
        for i in 0..parts {
            for k in 0..=i {
                divided.push([at(i, k), at(i + 1, k), at(i + 1, k + 1)]);
                if k < i {
                    divided.push([at(i, k), at(i + 1, k + 1), at(i, k + 1)]);
                }
            }
        }
    }
}

/// Samples, for the tessellator.
struct Samples<'a> {
    flat: &'a [Vec2],
    magnified: f32,
}

impl PositionStore for Samples<'_> {
    fn get_endpoint(&self, id: EndpointId) -> Point {
        let at = self.flat.get(id.0 as usize).copied().unwrap_or_default() * self.magnified;
        point(at.x, at.y)
    }

    fn get_control_point(&self, _: ControlPointId) -> Point {
        point(0.0, 0.0)
    }
}

/// Takes triangles in.
struct Sink<'a> {
    samples: u32,
    /// Of each vertex of the tessellator, ours.
    numbers: &'a mut Vec<u32>,
    between: &'a mut Vec<Between>,
    triangles: &'a mut Vec<[u32; 3]>,
}

impl GeometryBuilder for Sink<'_> {
    fn add_triangle(&mut self, a: VertexId, b: VertexId, c: VertexId) {
        let of = |id: VertexId| self.numbers.get(id.0 as usize).copied();
        if let (Some(a), Some(b), Some(c)) = (of(a), of(b), of(c)) {
            self.triangles.push([a, b, c]);
        }
    }
}

impl FillGeometryBuilder for Sink<'_> {
    fn add_fill_vertex(&mut self, vertex: FillVertex<'_>) -> Result<VertexId, GeometryBuilderError> {
        let id = VertexId(self.numbers.len() as u32);
        let mut sources = vertex.sources();
        let number = match vertex.as_endpoint_id() {
            Some(EndpointId(sample)) => sample,
            None => match sources.next() {
                Some(VertexSource::Edge { from, to, t }) => {
                    self.between.push(Between { of: [from.0, to.0, to.0], shares: Vec3::new(1.0 - t, t, 0.0) });
                    self.samples + self.between.len() as u32 - 1
                }
                Some(VertexSource::Endpoint { id }) => id.0,
                None => return Err(GeometryBuilderError::InvalidVertex),
            },
        };
        self.numbers.push(number);
        Ok(id)
    }
}
