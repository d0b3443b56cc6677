//! The line along the paths of a shape as triangles.

use glam::{Vec2, Vec3};
use lyon_tessellation::geometry_builder::{GeometryBuilder, GeometryBuilderError, StrokeGeometryBuilder};
use lyon_tessellation::math::{Point, point};
use lyon_tessellation::path::{ControlPointId, EndpointId, IdEvent, PositionStore};
use lyon_tessellation::{StrokeOptions, StrokeTessellator, StrokeVertex, VertexId, VertexSource};

use super::Picture;
use super::dash::Part;
use super::picture::{Pen, PictureShape, point as cubic_point};
use super::shade::Shade;
use crate::vector::{LineCap, LineJoin};

/// A stroke is as wide as this at most, magnified: far wider than the picture, and not so wide that its corners take vertices without end.
const WIDEST: f32 = 1e4;

/// The triangles of a stroke.
#[derive(Clone, Debug, Default)]
pub(super) struct Line {
    pub(super) positions: Vec<Vec3>,
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Memory for tessellating.
#[derive(Default)]
pub(super) struct LineScratch {
    tessellator: StrokeTessellator,
    events: Vec<IdEvent>,
    /// In the plane, magnified.
    endpoints: Vec<Point>,
    controls: Vec<Point>,
    /// What begins at each endpoint: segments, as they are and as they were drawn.
    segments: Vec<[[Vec3; 4]; 2]>,
}

impl std::fmt::Debug for LineScratch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LineScratch").finish_non_exhaustive()
    }
}

impl Line {
    /// Memory that it has taken, in items.
    pub(super) fn capacity(&self) -> usize {
        self.positions.capacity() + self.colors.capacity() + self.triangles.capacity()
    }

    /// Follows the control points of a shape.
    pub(super) fn update(
        &mut self,
        picture: &Picture,
        shape: &PictureShape,
        points: &[Vec3],
        scratch: &mut LineScratch,
    ) {
        self.positions.clear();
        self.colors.clear();
        self.triangles.clear();
        let Some(pen) = &shape.stroke else { return };
        scratch.feed(picture, shape, pen, points);
        let cap = match pen.cap {
            LineCap::Butt => lyon_tessellation::LineCap::Butt,
            LineCap::Round => lyon_tessellation::LineCap::Round,
            LineCap::Square => lyon_tessellation::LineCap::Square,
        };
        let join = match pen.join {
            LineJoin::Miter => lyon_tessellation::LineJoin::Miter,
            LineJoin::Round => lyon_tessellation::LineJoin::Round,
            LineJoin::Bevel => lyon_tessellation::LineJoin::Bevel,
        };
        let options = StrokeOptions::default()
            .with_line_width((pen.width * picture.magnified).min(WIDEST))
            .with_tolerance(picture.tolerance * picture.magnified)
            .with_line_cap(cap)
            .with_line_join(join)
            // Smaller ones mean nothing, and the tessellator refuses them.
            .with_miter_limit(pen.miter_limit.max(StrokeOptions::MINIMUM_MITER_LIMIT));
        let LineScratch { tessellator, events, endpoints, controls, segments } = scratch;
        let store = Ends { endpoints, controls };
        let mut sink = Sink { picture, pen, segments, line: self };
        let done = tessellator.tessellate_with_ids(events.iter().copied(), &store, None, &options, &mut sink);
        if done.is_err() {
            self.positions.clear();
            self.colors.clear();
            self.triangles.clear();
        }
    }
}

impl LineScratch {
    /// Makes ready what is to be drawn.
    fn feed(&mut self, picture: &Picture, shape: &PictureShape, pen: &Pen, points: &[Vec3]) {
        self.events.clear();
        self.endpoints.clear();
        self.controls.clear();
        self.segments.clear();
        for (path, dashes) in picture.paths[shape.paths.clone()].iter().zip(&pen.dashes) {
            let both = |i| [points, picture.rest()].map(|all| path.segment(all, i));
            match dashes {
                None => self.run(
                    picture,
                    (0..path.segment_count()).flat_map(|i| spaced(both(i), picture.spacing)),
                    path.closed,
                ),
                Some(dashes) => {
                    for dash in dashes {
                        let part = |part: &Part| both(part.segment as usize).map(|whole| cut(whole, part));
                        let parts = dash.iter().flat_map(|dash| spaced(part(dash), picture.spacing));
                        self.run(picture, parts, false);
                    }
                }
            }
        }
    }

    fn run(&mut self, picture: &Picture, segments: impl Iterator<Item = [[Vec3; 4]; 2]>, closed: bool) {
        let first = self.endpoints.len() as u32;
        let flat = |place: Vec3| {
            let at: Vec2 = picture.flat(place) * picture.magnified;
            point(at.x, at.y)
        };
        for both in segments {
            let [now, _] = both;
            let (from, control) = (self.endpoints.len() as u32, self.controls.len() as u32);
            if from == first {
                self.endpoints.push(flat(now[0]));
                self.segments.push(both);
                self.events.push(IdEvent::Begin { at: EndpointId(first) });
            }
            let to = self.endpoints.len() as u32;
            if let Some(at) = self.segments.last_mut() {
                *at = both;
            }
            self.endpoints.push(flat(now[3]));
            // Where nothing begins, the last segment ends.
            self.segments.push([now[3], both[1][3]].map(|end| [end; 4]));
            self.controls.extend([flat(now[1]), flat(now[2])]);
            let (ctrl1, ctrl2) = (ControlPointId(control), ControlPointId(control + 1));
            self.events.push(IdEvent::Cubic { from: EndpointId(to - 1), ctrl1, ctrl2, to: EndpointId(to) });
        }
        let last = self.endpoints.len() as u32;
        if last > first {
            self.events.push(IdEvent::End { last: EndpointId(last - 1), first: EndpointId(first), close: closed });
        }
    }
}

/// A segment in pieces that are not longer than they may be.
fn spaced(both: [[Vec3; 4]; 2], spacing: f32) -> impl Iterator<Item = [[Vec3; 4]; 2]> {
    let [a, b, c, d] = both[0];
    let length = a.distance(b) + b.distance(c) + c.distance(d);
    let pieces = (length / spacing).ceil().clamp(1.0, 64.0);
    (0..pieces as u32).map(move |i| {
        let part = Part { segment: 0, from: i as f32 / pieces, to: (i + 1) as f32 / pieces };
        if pieces == 1.0 { both } else { both.map(|whole| cut(whole, &part)) }
    })
}

/// A part of a segment.
fn cut([a, b, c, d]: [Vec3; 4], part: &Part) -> [Vec3; 4] {
    let blossom = |r: f32, s: f32, t: f32| {
        let (ab, bc, cd) = (a.lerp(b, r), b.lerp(c, r), c.lerp(d, r));
        ab.lerp(bc, s).lerp(bc.lerp(cd, s), t)
    };
    let Part { from, to, .. } = *part;
    [blossom(from, from, from), blossom(from, from, to), blossom(from, to, to), blossom(to, to, to)]
}

struct Ends<'a> {
    endpoints: &'a [Point],
    controls: &'a [Point],
}

impl PositionStore for Ends<'_> {
    fn get_endpoint(&self, id: EndpointId) -> Point {
        self.endpoints.get(id.0 as usize).copied().unwrap_or_default()
    }

    fn get_control_point(&self, id: ControlPointId) -> Point {
        self.controls.get(id.0 as usize).copied().unwrap_or_default()
    }
}

/// Takes triangles in.
struct Sink<'a> {
    picture: &'a Picture,
    pen: &'a Pen,
    segments: &'a [[[Vec3; 4]; 2]],
    line: &'a mut Line,
}

impl Sink<'_> {
    /// The place on the path that a vertex belongs to, and its colour, which goes by where it was drawn.
    fn place(&self, source: VertexSource) -> (Vec3, [f32; 4]) {
        let (id, t) = match source {
            VertexSource::Endpoint { id } => (id, 0.0),
            VertexSource::Edge { from, t, .. } => (from, t),
        };
        let [now, drawn] = self.segments.get(id.0 as usize).copied().unwrap_or_default();
        let color = match &self.pen.shade {
            Shade::Plain(color) => *color,
            shade => shade.at(self.picture.drawn(cubic_point(drawn, t))),
        };
        (cubic_point(now, t), color)
    }
}

impl GeometryBuilder for Sink<'_> {
    fn add_triangle(&mut self, a: VertexId, b: VertexId, c: VertexId) {
        self.line.triangles.push([a.0, b.0, c.0]);
    }
}

impl StrokeGeometryBuilder for Sink<'_> {
    fn add_stroke_vertex(&mut self, vertex: StrokeVertex<'_, '_>) -> Result<VertexId, GeometryBuilderError> {
        let id = VertexId(self.line.positions.len() as u32);
        let (on, at) = (vertex.position_on_path(), vertex.position());
        let off = Vec2::new(at.x - on.x, at.y - on.y) / self.picture.magnified;
        let (now, color) = self.place(vertex.source());
        let offset = self.picture.lifted(off);
        self.line.positions.push(now + offset);
        self.line.colors.push(color);
        Ok(id)
    }
}
