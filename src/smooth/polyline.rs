//! A line drawn on a surface, as the sides it crosses.

use glam::DVec3;

use super::strip::{self, Strip};
use crate::curve::{DrawnLine, Trace};
use crate::geodesic::{Crossing, GeodesicPath, PathError, PathFinder, inner::InnerPath};
use crate::surface::{HalfEdge, InnerPoint, PointError, Surface, SurfacePoint};

/// A line on a surface that is straight inside every face and may bend where it crosses sides: what is smoothed.
///
/// It is open, with its ends anywhere, or closed. What a drawn line does inside a single face is not kept: a closed line needs
/// three faces. It holds no reference to its surface.
///
/// ```
/// use bevy_surface_splines::{geodesic::PathFinder, smooth::SurfacePolyline, surface::{Surface, SurfaceOptions, shapes}};
/// use glam::DVec3;
///
/// let surface = Surface::build(&shapes::grid(10, 10, 1.0, 1.0), &SurfaceOptions::default())?;
/// let at = |x: f64, y: f64| surface.closest_point(DVec3::new(x, y, 0.0)).unwrap().point;
/// let points = [at(0.15, 0.2), at(0.5, 0.6), at(0.85, 0.2)];
/// let line = SurfacePolyline::through(&surface, &mut PathFinder::new(), &points, false)?;
/// assert!(line.crossings().len() > 10 && !line.is_closed());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfacePolyline {
    pub(crate) closed: bool,
    pub(crate) start: SurfacePoint,
    pub(crate) end: SurfacePoint,
    pub(crate) crossings: Vec<Crossing>,
    pub(crate) fixed: Vec<bool>,
}

/// Why there is no such line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PolylineError {
    /// There is no line.
    #[error("a line needs two points, a closed one three: draw further")]
    TooFewPoints,
    /// A closed line does not leave the faces about a side.
    #[error("the closed line at {0} runs in fewer than three faces, so nothing of it could bend: draw a larger one")]
    TooSmall(crate::surface::FaceId),
    /// There is no such crossing.
    #[error("crossing {0} does not exist: the line has {1}")]
    NoSuchCrossing(usize, usize),
    /// A point, or the line, does not belong to the surface.
    #[error(transparent)]
    Point(#[from] PointError),
    /// Points cannot be joined.
    #[error(transparent)]
    Path(#[from] PathError),
}

/// # Making
impl SurfacePolyline {
    /// The line along a drawn one.
    ///
    /// # Errors
    /// [`PolylineError`] if there is too little of it, or it was drawn on another surface.
    pub fn drawn(surface: &Surface, line: &DrawnLine) -> Result<Self, PolylineError> {
        Self::along_paths(surface, line.paths(), line.is_closed())
    }

    /// The line from point to point by shortest paths.
    ///
    /// # Errors
    /// [`PolylineError`] if there are too few points, or they cannot be joined.
    pub fn through(
        surface: &Surface,
        finder: &mut PathFinder,
        points: &[SurfacePoint],
        closed: bool,
    ) -> Result<Self, PolylineError> {
        Self::drawn(surface, &DrawnLine::through(surface, finder, points, closed)?)
    }

    /// The line along a trace, which is closed if its spline is.
    ///
    /// # Errors
    /// As [`drawn`](Self::drawn).
    pub fn along(surface: &Surface, trace: &Trace, closed: bool) -> Result<Self, PolylineError> {
        Self::along_paths(surface, trace.segments().iter().flat_map(|segment| segment.paths()), closed)
    }

    /// The line from a point in a face over the sides it crosses to a point in the last face.
    ///
    /// # Errors
    /// [`PolylineError`] if a crossing does not lead to the face that the next one leaves.
    pub fn open(
        surface: &Surface,
        start: SurfacePoint,
        crossings: Vec<Crossing>,
        end: SurfacePoint,
    ) -> Result<Self, PolylineError> {
        let fixed = vec![false; crossings.len()];
        Self { closed: false, start, end, crossings, fixed }.checked(surface)
    }

    /// The closed line over some sides, at least three of them.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn closed(surface: &Surface, crossings: Vec<Crossing>) -> Result<Self, PolylineError> {
        let start = crossings.first().map(point_of).ok_or(PolylineError::TooFewPoints)?;
        let fixed = vec![false; crossings.len()];
        Self { closed: true, start, end: start, crossings, fixed }.checked(surface)
    }

    fn checked(self, surface: &Surface) -> Result<Self, PolylineError> {
        let mut strip = Strip::default();
        self.strip_into(surface, &mut strip)?;
        Self::of(surface, strip)
    }

    /// An open line, closed by the shortest path from its end to its start.
    ///
    /// # Errors
    /// [`PolylineError`] if there is none, or the line belongs to another surface.
    pub fn closed_home(&self, surface: &Surface, finder: &mut PathFinder) -> Result<Self, PolylineError> {
        let mut strip = Strip::default();
        self.strip_into(surface, &mut strip)?;
        if self.closed {
            return Self::of(surface, strip);
        }
        let home = finder.shortest(surface, &self.end, &self.start)?;
        let path = InnerPath::from_outer(surface, &home)?;
        let (start, end, mut around) = (strip.start, strip.end, Vec::new());
        join(surface, &mut strip, &end, &path.start, &mut around)?;
        for (h, at) in path.strip.iter().zip(&path.at) {
            strip.push(surface, *h, *at, 0.0, false);
        }
        join(surface, &mut strip, &path.end, &start, &mut around)?;
        strip.closed = true;
        Self::of(surface, strip)
    }

    /// The line along some paths, each from where the one before ends; closed, if it is to come back to its start.
    ///
    /// # Errors
    /// [`PolylineError`] if there are none, or they do not meet.
    pub fn along_paths<'a>(
        surface: &Surface,
        paths: impl IntoIterator<Item = &'a GeodesicPath>,
        closed: bool,
    ) -> Result<Self, PolylineError> {
        let mut strip = Strip { closed, ..Strip::default() };
        let (mut path, mut around) = (InnerPath::default(), Vec::new());
        let mut end: Option<InnerPoint> = None;
        for outer in paths {
            path.set_outer(surface, outer)?;
            match &end {
                None => strip.start = path.start,
                Some(end) => join(surface, &mut strip, end, &path.start, &mut around)?,
            }
            for (h, at) in path.strip.iter().zip(&path.at) {
                strip.push(surface, *h, *at, 0.0, false);
            }
            end = Some(path.end);
        }
        let Some(end) = end else { return Err(PolylineError::TooFewPoints) };
        strip.end = end;
        if closed {
            let start = strip.start;
            join(surface, &mut strip, &end, &start, &mut around)?;
        }
        Self::of(surface, strip)
    }

    /// From a strip that may have to be tidied at its ends.
    pub(crate) fn of(surface: &Surface, mut strip: Strip) -> Result<Self, PolylineError> {
        strip.close_seam_if_closed(surface);
        strip.trim_ends(surface);
        if strip.closed && strip.len() < 3 {
            return Err(PolylineError::TooSmall(surface.outer_point(&strip.start).face));
        }
        let mut out = Self::blank();
        out.set(surface, &strip);
        Ok(out)
    }

    pub(crate) fn blank() -> Self {
        let nowhere = SurfacePoint { face: crate::surface::FaceId(0), weights: [1.0, 0.0, 0.0] };
        Self { closed: false, start: nowhere, end: nowhere, crossings: Vec::new(), fixed: Vec::new() }
    }

    /// Becomes a strip, keeping memory.
    pub(crate) fn set(&mut self, surface: &Surface, strip: &Strip) {
        self.closed = strip.closed;
        self.crossings.clear();
        self.crossings.extend(strip.sides.iter().zip(&strip.at).map(|(h, at)| {
            let (face, side, reversed) = surface.outer_side(*h);
            Crossing { face, side, at: if reversed { 1.0 - at } else { *at } }
        }));
        self.fixed.clone_from(&strip.fixed);
        if strip.closed {
            let first = strip.sides.first().zip(strip.at.first());
            let start = first.map_or(strip.start, |(h, at)| InnerPoint::on_side(*h, *at));
            (self.start, self.end) = (surface.outer_point(&start), surface.outer_point(&start));
        } else {
            (self.start, self.end) = (surface.outer_point(&strip.start), surface.outer_point(&strip.end));
        }
    }

    /// The strip, with shares of the length filled in.
    pub(crate) fn strip_into(&self, surface: &Surface, strip: &mut Strip) -> Result<(), PolylineError> {
        self.turned_strip_into(surface, strip).map(|_| ())
    }

    /// The same; says with which crossing the strip of a closed line begins.
    pub(crate) fn turned_strip_into(&self, surface: &Surface, strip: &mut Strip) -> Result<usize, PolylineError> {
        strip.clear();
        strip.closed = self.closed;
        strip.start = surface.inner_point(&self.start)?;
        strip.end = surface.inner_point(&self.end)?;
        for (i, crossing) in self.crossings.iter().enumerate() {
            let (h, reversed) = surface.inner_side(crossing.face, crossing.side)?;
            if !(0.0..=1.0).contains(&crossing.at) {
                return Err(PointError::BadCrossing(crossing.face).into());
            }
            strip.sides.push(h);
            strip.at.push(if reversed { 1.0 - crossing.at } else { crossing.at });
            strip.along.push(0.0);
            strip.fixed.push(self.fixed.get(i).copied().unwrap_or(false));
            strip.near.push(strip::UNKNOWN);
        }
        if !strip.is_regular(surface) {
            let at = self.crossings.first().map_or(self.start.face, |crossing| crossing.face);
            return Err(PointError::BadCrossing(at).into());
        }
        let turned = strip.seam_off_crossings_at_vertices(surface);
        strip.measure(surface);
        Ok(turned)
    }
}

/// # Asking
impl SurfacePolyline {
    /// Whether it comes back to its start.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Where an open line starts and ends; of a closed one, its first crossing twice.
    pub fn ends(&self) -> [SurfacePoint; 2] {
        [self.start, self.end]
    }

    /// The sides it crosses, in order, each named by the face that is left.
    pub fn crossings(&self) -> &[Crossing] {
        &self.crossings
    }

    /// Whether a crossing stays where it is when the line is smoothed.
    pub fn is_fixed(&self, crossing: usize) -> bool {
        self.fixed.get(crossing).copied().unwrap_or(false)
    }

    /// Fixes a crossing, or sets it free: the line crosses that side there, however it is smoothed.
    ///
    /// # Errors
    /// [`PolylineError::NoSuchCrossing`].
    pub fn set_fixed(&mut self, crossing: usize, fixed: bool) -> Result<(), PolylineError> {
        let count = self.crossings.len();
        *self.fixed.get_mut(crossing).ok_or(PolylineError::NoSuchCrossing(crossing, count))? = fixed;
        Ok(())
    }

    /// Ends and crossings as surface points, in order; of a closed line its crossings.
    pub fn points(&self) -> Vec<SurfacePoint> {
        let crossings = self.crossings.iter().map(point_of);
        if self.closed {
            crossings.collect()
        } else {
            std::iter::once(self.start).chain(crossings).chain([self.end]).collect()
        }
    }

    /// The same as positions; of a closed line the first one comes last again. Empty if the line belongs to another surface.
    pub fn positions(&self, surface: &Surface) -> Vec<DVec3> {
        let mut strip = Strip::default();
        let mut out = Vec::new();
        if self.strip_into(surface, &mut strip).is_ok() {
            strip.positions_into(surface, &mut out);
            out.iter_mut().for_each(|p| *p += surface.origin);
        }
        out
    }

    /// Length in local units; zero if the line belongs to another surface.
    pub fn length(&self, surface: &Surface) -> f64 {
        let mut strip = Strip::default();
        if self.strip_into(surface, &mut strip).is_ok() { strip.length(surface) } else { 0.0 }
    }

    /// The same line as one that was drawn, so that [`Spline::fit`](crate::curve::Spline::fit) can follow it.
    ///
    /// # Errors
    /// [`PolylineError`] if it belongs to another surface, or all of it is one place.
    pub fn to_drawn(&self, surface: &Surface) -> Result<DrawnLine, PolylineError> {
        let mut strip = Strip::default();
        self.strip_into(surface, &mut strip)?;
        let mut paths = Vec::with_capacity(strip.len() + 1);
        let mut here = if strip.closed {
            let last = strip.len() - 1;
            behind(surface, strip.sides[last], strip.at[last])
        } else {
            strip.start
        };
        let mut path = InnerPath::default();
        let hair = 1e-9 * surface.mean_edge[surface.sheet[here.face as usize] as usize];
        let mut add = |from: InnerPoint, to: InnerPoint| {
            path.set_straight(surface, from, to);
            let long = path.length > hair;
            if long {
                paths.push(path.to_outer(surface));
            }
            long
        };
        // Where a stretch has no length, the next one begins in another face of the same place.
        for (h, at) in strip.sides.iter().zip(&strip.at) {
            add(here, InnerPoint::on_side(*h, *at));
            here = behind(surface, *h, *at);
        }
        if !strip.closed {
            add(here, strip.end);
        }
        if paths.is_empty() {
            return Err(PolylineError::TooFewPoints);
        }
        Ok(DrawnLine::of_paths(paths, strip.closed))
    }
}

/// A crossing as a point of the face that is left.
fn point_of(crossing: &Crossing) -> SurfacePoint {
    let side = usize::from(crossing.side) % 3;
    let mut weights = [0.0; 3];
    weights[side] = 1.0 - crossing.at;
    weights[(side + 1) % 3] = crossing.at;
    SurfacePoint { face: crossing.face, weights }
}

/// A crossing as a point of the face that is entered.
fn behind(surface: &Surface, h: HalfEdge, at: f64) -> InnerPoint {
    InnerPoint::on_side(surface.twin(h), 1.0 - at)
}

/// Leads a strip from one spelling of a point to another.
fn join(
    surface: &Surface,
    strip: &mut Strip,
    from: &InnerPoint,
    to: &InnerPoint,
    around: &mut Vec<HalfEdge>,
) -> Result<(), PolylineError> {
    around.clear();
    let near = surface.inner_position(from).distance(surface.inner_position(to));
    let hair = 1e-6 * surface.mean_edge[surface.sheet[from.face as usize] as usize];
    if near > hair || !strip::turn_into(surface, from, to.face, around) {
        return Err(PointError::BadCrossing(surface.outer_point(to).face).into());
    }
    for h in around.iter() {
        strip.push(surface, *h, strip::share_on(surface, from, *h), 0.0, false);
    }
    Ok(())
}
