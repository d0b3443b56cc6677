//! Curves of a surface as planar drawings.

use glam::{DMat4, DVec2, DVec3};

use super::{PlaceError, Placement};
use crate::curve::{Anchor, Handle, Spline, Trace};
use crate::geodesic::{
    PathError, PathFinder, PathQuality,
    inner::InnerPath,
    tangent::{InnerTangent, angle_between, settle},
    transport::{final_direction, initial_direction},
};
use crate::surface::{InnerPoint, PointError, Surface};
use crate::vector::{Drawing, Shape, Style, VectorPath};

/// Why curves cannot be drawn in the plane.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProjectError {
    /// The placement makes no sense.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// A point is on another sheet than the placement's.
    #[error(transparent)]
    Path(#[from] PathError),
    /// A point does not come to lie in the view.
    #[error("curve {curve} is not in front of the camera as a whole: move the camera back, or leave the curve out")]
    NotInView {
        /// Which curve.
        curve: usize,
    },
}

impl From<PointError> for ProjectError {
    fn from(error: PointError) -> Self {
        Self::Path(error.into())
    }
}

/// Draws splines in the plane about a point of their surface: the way back from [`place_drawing`](super::place_drawing).
///
/// An anchor goes to its polar coordinates about the placement's point (logarithmic map), a handle relative to it, along axes carried there.
/// `origin` is what lies at the placement's point. A drawing that was placed comes back as it was wherever the walks from the centre were
/// shortest paths: on a flat surface without holes everywhere. Handles that the boundary cut short come back whole. Of a B-spline
/// its control polygon is drawn; convert it first.
///
/// # Errors
/// [`ProjectError`] if the placement makes no sense, or a spline lies on another sheet.
pub fn drawing_about<'s>(
    surface: &Surface,
    finder: &mut PathFinder,
    splines: impl IntoIterator<Item = &'s Spline>,
    placement: &Placement,
    origin: DVec2,
) -> Result<Drawing, ProjectError> {
    let mut plane = Plane::new(surface, placement, origin)?;
    let mut drawing = Drawing::default();
    for spline in splines {
        let mut points = Vec::with_capacity(3 * spline.anchors().len());
        for anchor in spline.anchors() {
            points.extend(plane.anchor(finder, anchor)?);
        }
        // The first point is the first anchor's incoming handle, which closes a path; an open one has none, and no last one.
        let first = points.remove(0);
        if spline.is_closed() {
            points.push(first);
        } else {
            points.pop();
        }
        drawing.shapes.extend(shape_of(VectorPath::from_points(points, spline.is_closed())));
    }
    Ok(drawing)
}

/// The tangent plane at a point, and where points of the surface lie in it.
struct Plane<'s> {
    surface: &'s Surface,
    at: InnerPoint,
    up: InnerTangent,
    scale: f64,
    origin: DVec2,
    path: InnerPath,
}

impl<'s> Plane<'s> {
    fn new(surface: &'s Surface, placement: &Placement, origin: DVec2) -> Result<Self, PlaceError> {
        let (at, up) = super::frame::Frame::new(surface, placement, origin)?.centre();
        Ok(Self { surface, at, up, scale: placement.scale, origin, path: InnerPath::default() })
    }

    /// Where an anchor lies, between its handles.
    fn anchor(&mut self, finder: &mut PathFinder, anchor: &Anchor) -> Result<[DVec2; 3], ProjectError> {
        let to = self.surface.inner_point(&anchor.point())?;
        finder.shortest_inner(self.surface, &self.at, &to, PathQuality::Default, &mut self.path)?;
        let length = self.path.length;
        let (away, ahead) = if length > 0.0 {
            let begin = initial_direction(self.surface, &self.path);
            (self.angle(&self.at, &self.up, &begin), final_direction(self.surface, &self.path))
        } else {
            (0.0, self.up)
        };
        // Counter-clockwise of upward, in a plane where y runs up.
        let planar = DVec2::from_angle(away).rotate(DVec2::Y);
        let end = self.path.end;
        let handle = |handle: &Handle| -> Result<DVec2, PointError> {
            let heading = self.surface.inner_tangent(&handle.heading())?;
            if heading.vector == DVec2::ZERO {
                return Ok(DVec2::ZERO);
            }
            let turn = self.angle(&end, &ahead, &heading);
            Ok(DVec2::from_angle(turn).rotate(planar) * handle.wished_length())
        };
        let (incoming, outgoing) = (handle(anchor.incoming())?, handle(anchor.outgoing())?);
        let drawn = |v: DVec2| self.origin + DVec2::new(v.x, -v.y) / self.scale;
        let place = planar * length;
        Ok([drawn(place + incoming), drawn(place), drawn(place + outgoing)])
    }

    /// The angle counter-clockwise from one direction at a point to another.
    fn angle(&self, at: &InnerPoint, from: &InnerTangent, to: &InnerTangent) -> f64 {
        // Exact in one face; else as about a vertex or over a side.
        let settled =
            [from, to].map(|tangent| settle(self.surface, at, tangent).map_or(*tangent, |(_, tangent)| tangent));
        if settled[0].face == settled[1].face && !matches!(at.zeros(), crate::surface::Zeros::Corner(_)) {
            return angle_between(settled[0].vector, settled[1].vector);
        }
        crate::geodesic::transport::angle_at(self.surface, at, from, to)
    }
}

/// Draws traces as a camera sees them: `view` maps local space to the page, x to the right and y up; perspective is allowed.
///
/// The result has y down, as drawings do. Each segment becomes sixteen cubics that touch the trace, fewer where it has fewer points.
/// What lies behind the surface is drawn too.
///
/// # Errors
/// [`ProjectError::NotInView`] if a curve is not in front of the camera.
pub fn drawing_in_view<'t>(traces: impl IntoIterator<Item = &'t Trace>, view: &DMat4) -> Result<Drawing, ProjectError> {
    let mut drawing = Drawing::default();
    for (curve, trace) in traces.into_iter().enumerate() {
        let page = |p: DVec3| {
            let h = *view * p.extend(1.0);
            let flat = DVec2::new(h.x, -h.y) / h.w;
            if h.w > 0.0 && flat.is_finite() { Ok(flat) } else { Err(ProjectError::NotInView { curve }) }
        };
        let mut points: Vec<DVec2> = Vec::new();
        for segment in trace.segments() {
            let flat = segment.point_positions().map(page).collect::<Result<Vec<_>, _>>()?;
            append_cubics(&flat, segment.parameters(), &mut points);
        }
        drawing.shapes.extend(shape_of(VectorPath::from_points(points, false)));
    }
    Ok(drawing)
}

/// Adds cubics through some points of a curve with their parameters, about sixteen of them.
fn append_cubics(curve: &[DVec2], parameters: &[f64], points: &mut Vec<DVec2>) {
    const PIECES: usize = 16;
    let last = curve.len().min(parameters.len()).saturating_sub(1);
    if last == 0 {
        return;
    }
    // The derivative of the parabola through a point and its neighbours, or at an end of that through the next two.
    let derivative = |i: usize| {
        let middle = i.clamp(1, last.max(2) - 1);
        let (a, b, c) = (middle - 1, middle.min(last), (middle + 1).min(last));
        let slope = |i: usize, k: usize| (curve[k] - curve[i]) / (parameters[k] - parameters[i]);
        if c == b {
            return slope(a, b);
        }
        let (first, second) = (slope(a, b), slope(b, c));
        let bend = (second - first) / (parameters[c] - parameters[a]);
        first + bend * (2.0 * parameters[i] - parameters[a] - parameters[b])
    };
    if points.is_empty() {
        points.push(curve[0]);
    }
    let pieces = last.min(PIECES);
    for k in 0..pieces {
        let (i, j) = (k * last / pieces, (k + 1) * last / pieces);
        let third = (parameters[j] - parameters[i]) / 3.0;
        points.extend([curve[i] + derivative(i) * third, curve[j] - derivative(j) * third, curve[j]]);
    }
}

/// A path as a shape with a black line.
fn shape_of(path: Option<VectorPath>) -> Option<Shape> {
    use crate::vector::{Color, LineCap, LineJoin, Paint, Stroke};
    let path = path?;
    let stroke = Stroke {
        paint: Paint::Color(Color::BLACK),
        width: 0.005 * path.extent(),
        cap: LineCap::Round,
        join: LineJoin::Round,
        miter_limit: 4.0,
        dashes: Vec::new(),
        dash_offset: 0.0,
    };
    let style = Style { stroke: Some(stroke), opacity: 1.0, ..Style::default() };
    Some(Shape { element: "path".to_owned(), paths: vec![path], style, id: None, group: None })
}
