//! B-splines: splines whose anchors are control points; to and from Bézier segments, and through given points.

use super::{
    Join, JumpPolicy, Method, Scheme, Spline, SplineError, TraceError, average::Averager, handles,
    lane_riesenfeld::Knots, piece::Control, segment,
};
use crate::geodesic::{
    PathError, PathFinder,
    inner::InnerPath,
    transport::{final_direction, initial_direction, transport},
    walk::walk,
};
use crate::surface::{InnerPoint, Surface, SurfacePoint};

/// Places on each segment where two curves are compared.
const SAMPLES: u32 = 16;

/// A curve this near to its points (as a share of the diagonal) passes through them.
const REACHED: f64 = 1e-9;
/// One that stays nearer than this share of the mean edge passes as near as a mesh allows.
const NEAR: f64 = 0.1;
/// How often control points are moved to get there; in the plane each round halves what is missing.
const MAX_ROUNDS: u32 = 64;
/// How many rounds in a row may bring it no nearer.
const PATIENCE: u32 = 8;
/// How far they are moved, in what is missing: the limit has two thirds of its weight in one control point.
const STEP: f64 = 1.5;

/// A spline made of another, and how far its curve lies from the other's.
#[derive(Clone, Debug, PartialEq)]
pub struct Conversion {
    /// The spline.
    pub spline: Spline,
    /// Largest distance found between the two curves at equal parameters, 16 places on each segment, in local units.
    pub deviation: f64,
}

/// A C² spline through points.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpolation {
    /// The spline: a B-spline, or one of smooth anchors where that was not found.
    pub spline: Spline,
    /// Largest distance from a point to the curve, in local units.
    pub residual: f64,
    /// Whether control points were not found and the points were joined by [`Spline::smooth_through`] instead.
    pub fell_back: bool,
}

impl Spline {
    /// Makes a uniform cubic B-spline from its control points: C² from end to end, and it passes near them.
    ///
    /// The points become anchors with handles of no length; [`with_scheme`](Self::with_scheme) joins the same anchors in
    /// another way.
    ///
    /// # Errors
    /// [`SplineError`] with fewer than four points (closed: three), points that cannot be joined or that do not belong to
    /// the surface.
    ///
    /// ```
    /// use bevy_surface_splines::{curve::*, surface::{Surface, SurfaceOptions, shapes}};
    /// use glam::DVec3;
    ///
    /// let surface = Surface::build(&shapes::icosphere(4), &SurfaceOptions::default())?;
    /// let points = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X].map(|p| surface.closest_point(p).unwrap().point);
    /// let spline = Spline::b_spline(&surface, &points, true)?;
    /// let trace = spline.trace(&surface, &mut TraceWorkspace::default(), None)?;
    /// assert_eq!((spline.segment_count(), trace.segments().len()), (4, 4));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn b_spline(surface: &Surface, points: &[SurfacePoint], closed: bool) -> Result<Self, SplineError> {
        Self::from_control_points(surface, points, closed, Scheme::b_spline())
    }

    /// Makes a uniform quadratic B-spline from its control points: C¹, and nearer to its control polygon.
    ///
    /// # Errors
    /// As [`b_spline`](Self::b_spline), with fewer than three points.
    pub fn quadratic_b_spline(surface: &Surface, points: &[SurfacePoint], closed: bool) -> Result<Self, SplineError> {
        Self::from_control_points(surface, points, closed, Scheme::quadratic_b_spline())
    }

    fn from_control_points(
        surface: &Surface,
        points: &[SurfacePoint],
        closed: bool,
        scheme: Scheme,
    ) -> Result<Self, SplineError> {
        let needed = if closed || scheme.method == Method::QuadraticBSpline { 3 } else { 4 };
        if points.len() < needed {
            return Err(SplineError::TooFewControlPoints { count: points.len(), needed });
        }
        let anchors = points.iter().map(|p| handles::bare_anchor(surface, *p)).collect::<Result<Vec<_>, _>>()?;
        for pair in points.windows(2) {
            if surface.sheet(pair[0].face)? != surface.sheet(pair[1].face)? {
                return Err(PathError::NoPath { from: pair[0], to: pair[1] }.into());
            }
        }
        Ok(Self { anchors, closed, scheme, jumps: JumpPolicy::default() })
    }

    /// Turns a B-spline into Bézier segments with smooth anchors at its knots; exact in the plane. A quadratic one is
    /// raised to cubic segments.
    ///
    /// What happens at jumps is allowed again.
    ///
    /// # Errors
    /// [`TraceError`] if control points cannot be joined; [`TraceError::Conversion`] for a spline that is no B-spline,
    /// [`TraceError::NoSegments`] for one without segments.
    pub fn to_bezier(&self, surface: &Surface, finder: &mut PathFinder) -> Result<Conversion, TraceError> {
        let count = self.segment_count();
        if !self.scheme.method.is_b_spline() {
            return Err(TraceError::Conversion("it has Bézier segments already; convert B-splines"));
        }
        if count == 0 {
            return Err(TraceError::NoSegments);
        }
        let mut averager = Averager { surface, finder, quality: self.scheme.quality };
        let mut anchors = Vec::with_capacity(count + 1);
        let mut incoming: Option<InnerPath> = None;
        for i in 0..count {
            let legs = self.control(&mut averager, i)?.into_bezier(&mut averager)?;
            // Of a quadratic segment two thirds of both legs.
            let share = if legs.len() == 2 { 2.0 / 3.0 } else { 1.0 };
            let (Some(first), Some(last)) = (legs.first(), legs.last()) else { continue };
            let mut anchor = handles::bare_anchor(surface, surface.outer_point(&first.start))?;
            anchor.outgoing = handles::along(surface, &first.piece(surface, 0.0, share));
            if let Some(leg) = incoming.take() {
                anchor.incoming = handles::along(surface, &leg);
                anchor.join = Join::Smooth;
            }
            anchors.push(anchor);
            let mut leg = last.piece(surface, 1.0 - share, 1.0);
            leg.reverse(surface);
            incoming = Some(leg);
        }
        if let Some(leg) = incoming {
            if self.closed {
                anchors[0].incoming = handles::along(surface, &leg);
                anchors[0].join = Join::Smooth;
            } else {
                let mut end = handles::bare_anchor(surface, surface.outer_point(&leg.start))?;
                end.incoming = handles::along(surface, &leg);
                anchors.push(end);
            }
        }
        let scheme = Scheme { method: Method::DeCasteljau, ..self.scheme };
        let spline = Self { anchors, closed: self.closed, scheme, jumps: JumpPolicy::default() };
        let deviation = self.distance_from(&mut averager, &spline)?;
        Ok(Conversion { spline, deviation })
    }

    /// Turns Bézier segments into a cubic B-spline, whose control points lie on the lines through the handles of each
    /// segment. Exact in the plane for a spline that is C² with even parameters; otherwise, and on a surface, the curve
    /// changes, and by how much is measured.
    ///
    /// What happens at jumps is allowed again.
    ///
    /// # Errors
    /// [`TraceError`] if control points cannot be joined; [`TraceError::Conversion`] for a spline that is a B-spline already,
    /// or a closed one of less than three segments.
    pub fn to_b_spline(&self, surface: &Surface, finder: &mut PathFinder) -> Result<Conversion, TraceError> {
        let count = self.segment_count();
        if self.scheme.method.is_b_spline() {
            return Err(TraceError::Conversion("it is a B-spline already; convert Bézier splines"));
        }
        if self.closed && count < 3 {
            return Err(TraceError::Conversion("a closed B-spline needs three segments; insert an anchor first"));
        }
        if count == 0 {
            return Err(TraceError::NoSegments);
        }
        let mut averager = Averager { surface, finder, quality: self.scheme.quality };
        let knots = Knots { degree: 3, intervals: count, periodic: self.closed };
        // Control point k as seen from the interval that ends behind it, and from the next.
        let m = if self.closed { count } else { count + 3 };
        let mut seen: Vec<[Option<InnerPoint>; 2]> = vec![[None; 2]; m];
        for i in 0..count {
            let Control::Bezier(legs) = self.control(&mut averager, i)? else { continue };
            let (from, to) = knots.middle_shares(i);
            let reach = legs[1].length / (to - from);
            seen[(i + 1) % m][1] = Some(beyond(surface, &legs[1], true, reach * from));
            seen[(i + 2) % m][0] = Some(beyond(surface, &legs[1], false, reach * (1.0 - to)));
        }
        let mut points = Vec::with_capacity(m);
        for (k, seen) in seen.iter().enumerate() {
            let point = match seen {
                [Some(a), Some(b)] => {
                    let path = averager.leg(a, b)?;
                    averager.point(&path, 0.5)
                }
                [Some(point), None] | [None, Some(point)] => *point,
                [None, None] => {
                    let end = &self.anchors[if k == 0 { 0 } else { self.anchors.len() - 1 }];
                    surface.inner_point(&end.point)?
                }
            };
            points.push(surface.outer_point(&point));
        }
        let anchors = points.iter().map(|p| handles::bare_anchor(surface, *p)).collect::<Result<Vec<_>, _>>()?;
        let scheme = Scheme { method: Method::BSpline, ..self.scheme };
        let spline = Self { anchors, closed: self.closed, scheme, jumps: JumpPolicy::default() };
        let deviation = self.distance_from(&mut averager, &spline)?;
        Ok(Conversion { spline, deviation })
    }

    /// Makes a C² spline through points: a cubic B-spline whose control points are moved, again and again, by what the
    /// curve misses the points by. Where that does not lead there, on surfaces too curved for the distances, the points are
    /// joined by [`smooth_through`](Self::smooth_through).
    ///
    /// Interpolation: passes through all points, to 1e-9 of the diagonal in the plane. On a curved mesh a leg that comes to
    /// pass a vertex on its other side moves the curve by some hundredths of an edge at once, and what lies in between
    /// cannot be met: the curve passes within a tenth of the mean edge of all points, and the residual says how near.
    /// Continuity: C². Locality: none, but influence falls to a quarter from point to point. Parametrization: one segment
    /// between two points, however far apart.
    ///
    /// With S the curve's point that belongs to X, a control point D moves along 3/2 log_S(X), carried from S to D by
    /// parallel transport; in the plane what is missing halves each time. The ends of an open spline are not curved.
    ///
    /// # Errors
    /// As [`smooth_through`](Self::smooth_through).
    pub fn c2_through(
        surface: &Surface,
        finder: &mut PathFinder,
        points: &[SurfacePoint],
        closed: bool,
    ) -> Result<Interpolation, SplineError> {
        let smooth = Self::smooth_through(surface, finder, points, closed)?;
        let points: Vec<SurfacePoint> = smooth.anchors.iter().map(|anchor| anchor.point).collect();
        let fallen_back = || Interpolation { spline: smooth.clone(), residual: 0.0, fell_back: true };
        if closed && points.len() < 3 {
            return Ok(fallen_back());
        }
        let mut controls = points.clone();
        if closed {
            controls.rotate_right(1); // the segment that begins at a point leans on the control point after its own number
        } else {
            controls.insert(1, smooth.anchors[0].outgoing.point());
            controls.insert(points.len(), smooth.anchors[points.len() - 1].incoming.point());
        }
        let mut spline = Self::b_spline(surface, &controls, closed)?;
        let mut averager = Averager { surface, finder, quality: spline.scheme.quality };
        let good = REACHED * surface.diagonal();
        let mut best: Option<Interpolation> = None;
        let mut since = 0;
        for _ in 0..MAX_ROUNDS {
            let Ok(misses) = spline.misses(&mut averager, &points) else { break };
            let residual = misses.iter().map(|miss| miss.path.length).fold(0.0, f64::max);
            since += 1;
            if best.as_ref().is_none_or(|best| residual < 0.9 * best.residual) {
                best = Some(Interpolation { spline: spline.clone(), residual, fell_back: false });
                since = 0;
            }
            if residual <= good || since > PATIENCE || spline.approach(&mut averager, &misses).is_err() {
                break;
            }
        }
        let sheet = surface.sheet(points[0].face)? as usize;
        let near = good.max(NEAR * surface.mean_edge.get(sheet).copied().unwrap_or(0.0));
        Ok(best.filter(|best| best.residual <= near).unwrap_or_else(fallen_back))
    }

    /// By what the curve misses points, at its knots.
    fn misses(&self, averager: &mut Averager<'_>, points: &[SurfacePoint]) -> Result<Vec<Miss>, TraceError> {
        // Of an open spline the ends are where they belong.
        let inner = if self.closed { 0..points.len() } else { 1..points.len() - 1 };
        let miss = |i: usize| {
            let curve = self.control(averager, i)?;
            let place = segment::evaluate(averager, &curve, self.scheme, 0.0)?.point;
            let path = averager.leg(&place, &averager.surface.inner_point(&points[i])?)?;
            Ok(Miss { control: (i + 1) % self.anchors.len(), place, path })
        };
        inner.map(miss).collect()
    }

    /// Moves control points so that the curve comes nearer to what it misses.
    fn approach(&mut self, averager: &mut Averager<'_>, misses: &[Miss]) -> Result<(), TraceError> {
        let surface = averager.surface;
        let mut moved = Vec::with_capacity(misses.len());
        for Miss { control, place, path } in misses {
            let way = averager.leg(place, &surface.inner_point(&self.anchors[*control].point)?)?;
            let shift = transport(surface, &way, &initial_direction(surface, path));
            let to = walk(surface, &way.end, &shift, STEP * path.length).path.end;
            moved.push((*control, surface.outer_point(&to)));
        }
        for (control, to) in moved {
            self.anchors[control] = handles::bare_anchor(surface, to)?;
        }
        if self.closed { Ok(()) } else { self.uncurl_ends(averager) }
    }

    /// Places the second control point from each end so that the curve is not curved at the end: a third of the way to the
    /// third control point.
    fn uncurl_ends(&mut self, averager: &mut Averager<'_>) -> Result<(), TraceError> {
        let surface = averager.surface;
        let m = self.anchors.len();
        if m < 5 {
            return Ok(()); // a straight line's handles are where they belong
        }
        for [end, second, third] in [[0, 1, 2], [m - 1, m - 2, m - 3]] {
            let [a, b] = [end, third].map(|k| surface.inner_point(&self.anchors[k].point));
            let path = averager.leg(&a?, &b?)?;
            let point = surface.outer_point(&averager.point(&path, 1.0 / 3.0));
            self.anchors[second] = handles::bare_anchor(surface, point)?;
        }
        Ok(())
    }

    /// Largest distance between this curve and another of as many segments, at equal parameters.
    fn distance_from(&self, averager: &mut Averager<'_>, other: &Self) -> Result<f64, TraceError> {
        let mut largest = 0.0_f64;
        for i in 0..self.segment_count() {
            let controls = [self.control(averager, i)?, other.control(averager, i)?];
            for k in 0..=SAMPLES {
                let t = f64::from(k) / f64::from(SAMPLES);
                let a = segment::evaluate(averager, &controls[0], self.scheme, t)?.point;
                let b = segment::evaluate(averager, &controls[1], other.scheme, t)?.point;
                let [a, b] = [a, b].map(|p| averager.surface.inner_position(&p));
                largest = largest.max(a.distance(b));
            }
        }
        Ok(largest)
    }
}

/// The point straight beyond the start or the end of a leg.
fn beyond(surface: &Surface, leg: &InnerPath, start: bool, distance: f64) -> InnerPoint {
    let mut leg = leg.clone();
    if start {
        leg.reverse(surface);
    }
    walk(surface, &leg.end, &final_direction(surface, &leg), distance).path.end
}

/// By what a curve misses a point.
struct Miss {
    /// The control point to move.
    control: usize,
    /// Where the curve is.
    place: InnerPoint,
    /// From there to the point.
    path: InnerPath,
}
