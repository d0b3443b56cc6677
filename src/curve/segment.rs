//! What the trace of a segment depends on, and how it is made from that.

use super::{
    CurvePoint, Method, Sampling, Scheme, SegmentTrace, TraceError,
    average::Averager,
    casteljau::Legs,
    comparison,
    lane_riesenfeld::{self, Interval, Knots, Levels},
    piece::{self, Control, Spot},
    sample,
};
use crate::geodesic::{GeodesicPath, inner::InnerPath, path_list::PathList};
use crate::surface::{InnerPoint, SurfacePoint};

/// What a segment's trace depends on: two equal keys have one trace, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SegmentKey {
    /// Fingerprint of the surface.
    pub(crate) surface: u64,
    pub(crate) control: KeyControl,
    pub(crate) scheme: Scheme,
}

/// The control polygon of a segment as the document has it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum KeyControl {
    /// First and last leg, both pointing away from their anchors; the middle one, where it belongs to the document too.
    Bezier { legs: Box<[GeodesicPath; 2]>, middle: Option<GeodesicPath> },
    /// The control points of an interval of a B-spline.
    BSpline { points: Vec<SurfacePoint>, knots: Knots, index: usize },
}

/// Legs of a chain of control points, each searched once.
#[derive(Debug, Default)]
pub(crate) struct ChainLegs(Vec<Option<InnerPath>>);

impl ChainLegs {
    /// Those of interval `first`, as many as the degree; `points` are its control points.
    fn of_interval(
        &mut self,
        averager: &mut Averager<'_>,
        first: usize,
        points: &[SurfacePoint],
    ) -> Result<Legs, TraceError> {
        let mut legs = Legs::with_capacity(points.len());
        for (k, pair) in points.windows(2).enumerate() {
            if self.0.len() <= first + k {
                self.0.resize(first + k + 1, None);
            }
            let leg = match self.0[first + k].take() {
                Some(leg) => leg,
                None => {
                    let surface = averager.surface;
                    averager.leg(&surface.inner_point(&pair[0])?, &surface.inner_point(&pair[1])?)?
                }
            };
            legs.push(self.0[first + k].insert(leg).clone());
        }
        Ok(legs)
    }
}

impl KeyControl {
    /// The piece of curve it stands for; `interval` is its place in the whole spline, which `chain` has the legs of.
    pub(crate) fn control(
        &self,
        averager: &mut Averager<'_>,
        interval: usize,
        chain: &mut ChainLegs,
    ) -> Result<Control, TraceError> {
        match self {
            Self::Bezier { .. } => {
                let mut legs = PathList::default();
                self.polygon(averager, &mut legs)?;
                Ok(Control::Bezier(legs.to_vec()))
            }
            Self::BSpline { points, knots, index } => {
                let legs = chain.of_interval(averager, interval, points)?;
                Ok(Control::Interval(Interval { knots: *knots, index: *index, legs }))
            }
        }
    }
}

impl KeyControl {
    /// The legs of a Bézier polygon, into memory that is kept; none for an interval of a B-spline.
    fn polygon(&self, averager: &mut Averager<'_>, out: &mut PathList) -> Result<(), TraceError> {
        let surface = averager.surface;
        out.clear();
        let Self::Bezier { legs, middle } = self else { return Ok(()) };
        out.place().set_outer(surface, &legs[0])?;
        let [start, end] = [&legs[0].end, &legs[1].end];
        // A document may say anything: a leg that does not join the handles is searched.
        let joins =
            |middle: &&GeodesicPath| surface.same_place(&middle.start, start) && surface.same_place(&middle.end, end);
        match middle.as_ref().filter(joins) {
            Some(middle) => out.place().set_outer(surface, middle)?,
            None => averager.leg_into(&surface.inner_point(start)?, &surface.inner_point(end)?, out.place())?,
        }
        let last = out.place();
        last.set_outer(surface, &legs[1])?;
        last.reverse(surface);
        Ok(())
    }
}

impl SegmentKey {
    /// Traces the segment that this is the key of; `interval` is its place in the whole spline, which `chain` has the legs of.
    pub(crate) fn trace(
        self,
        averager: &mut Averager<'_>,
        scratch: &mut Scratch,
        (interval, chain): (usize, &mut ChainLegs),
        out: &mut SegmentTrace,
    ) -> Result<(), TraceError> {
        let is_bezier = matches!(self.control, KeyControl::Bezier { .. });
        if is_bezier && subdivides_whole(self.scheme) {
            self.control.polygon(averager, &mut scratch.levels.legs)?;
            out.jumps.clear();
            trace_subdivided(averager, scratch, self.scheme.sampling, out)?;
        } else {
            let control = self.control.control(averager, interval, chain)?;
            trace(averager, scratch, control, self.scheme, out)?;
        }
        out.key = Some(self);
        Ok(())
    }
}

/// Scratch memory of tracing a segment.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    levels: Levels,
    points: Vec<InnerPoint>,
}

/// Searches the legs of a Bézier polygon.
pub(crate) fn search_legs(averager: &mut Averager<'_>, polygon: &[SurfacePoint]) -> Result<Legs, TraceError> {
    let points = polygon.iter().map(|p| averager.surface.inner_point(p)).collect::<Result<Vec<_>, _>>()?;
    points.windows(2).map(|pair| Ok(averager.leg(&pair[0], &pair[1])?)).collect()
}

/// The piece of curve that a method makes of a polygon.
fn understood(control: Control, method: Method) -> Control {
    match (control, method) {
        (Control::Bezier(legs), Method::LaneRiesenfeld) => {
            Control::Interval(Interval { knots: Knots::bezier(legs.len()), index: 0, legs })
        }
        (control, _) => control,
    }
}

/// Traces a segment, into a trace whose memory is kept; its key is the caller's to set.
pub(crate) fn trace(
    averager: &mut Averager<'_>,
    scratch: &mut Scratch,
    control: Control,
    scheme: Scheme,
    out: &mut SegmentTrace,
) -> Result<(), TraceError> {
    out.jumps.clear();
    let sampled = match control {
        Control::Bezier(legs) if scheme.method.is_for_comparison() => {
            let (sampled, jumps) = comparison::sample(averager, &legs, scheme.method, scheme.sampling)?;
            out.jumps = jumps;
            sampled
        }
        Control::Bezier(legs) if subdivides_whole(scheme) => {
            scratch.levels.legs.clear();
            scratch.levels.legs.extend_from(&legs);
            return trace_subdivided(averager, scratch, scheme.sampling, out);
        }
        control => {
            let control = understood(control, scheme.method);
            sample::sample(averager, control, scheme.sampling, scheme.on_curve)?
        }
    };
    out.fill(averager.surface, &sampled.paths, sampled.bound);
    out.parameters = sampled.parameters;
    Ok(())
}

/// Traces the polygon whose legs `scratch` holds by subdividing it.
fn trace_subdivided(
    averager: &mut Averager<'_>,
    scratch: &mut Scratch,
    sampling: Sampling,
    out: &mut SegmentTrace,
) -> Result<(), TraceError> {
    let knots = subdivide(averager, scratch, sampling, true)?;
    out.fill(averager.surface, &scratch.levels.legs, None);
    out.parameters.clear();
    let intervals = knots.intervals as f64;
    out.parameters.extend((0..scratch.points.len()).map(|i| knots.greville(i) / intervals));
    Ok(())
}

/// The points of a subdivided Bézier polygon.
pub(crate) fn subdivided_points(
    averager: &mut Averager<'_>,
    scratch: &mut Scratch,
    polygon: &[SurfacePoint],
    sampling: Sampling,
    out: &mut Vec<SurfacePoint>,
) -> Result<(), TraceError> {
    let surface = averager.surface;
    scratch.levels.legs.clear();
    for pair in polygon.windows(2) {
        let (from, to) = (surface.inner_point(&pair[0])?, surface.inner_point(&pair[1])?);
        averager.leg_into(&from, &to, scratch.levels.legs.place())?;
    }
    subdivide(averager, scratch, sampling, false)?;
    out.extend(scratch.points.iter().map(|p| surface.outer_point(p)));
    Ok(())
}

/// Whether the trace is the subdivided control polygon of the whole segment, which shares points between intervals.
pub(crate) fn subdivides_whole(scheme: Scheme) -> bool {
    let even = !matches!(scheme.sampling, Sampling::Adaptive { .. });
    scheme.method == Method::LaneRiesenfeld && even && !scheme.on_curve
}

/// Subdivides the polygon whose legs `scratch` holds; it then holds the points, and the legs between them if `joined`.
fn subdivide(
    averager: &mut Averager<'_>,
    scratch: &mut Scratch,
    sampling: Sampling,
    joined: bool,
) -> Result<Knots, TraceError> {
    let degree = scratch.levels.legs.len();
    let longest = scratch.levels.legs.iter().map(|leg| leg.length).fold(0.0, f64::max);
    // The legs of a level with N intervals are up to degree / N times as long as those of the polygon.
    let levels = sampling.levels(degree as f64 * longest).unwrap_or(0);
    let knots = Knots::bezier(degree);
    lane_riesenfeld::trace(averager, &mut scratch.levels, knots, levels, joined, &mut scratch.points)?;
    Ok(Knots { intervals: 1 << levels, ..knots })
}

/// The curve's point at a local parameter.
pub(crate) fn evaluate(
    averager: &mut Averager<'_>,
    control: &Control,
    scheme: Scheme,
    t: f64,
) -> Result<Spot, TraceError> {
    match (control, scheme.method) {
        (Control::Bezier(legs), method) if method.is_for_comparison() => {
            Ok(comparison::evaluate(averager, legs, method, t)?)
        }
        _ => Ok(piece::evaluate(averager, &understood(control.clone(), scheme.method), t)?),
    }
}

/// [`evaluate`] in outer spelling.
pub(crate) fn curve_point(
    averager: &mut Averager<'_>,
    control: &Control,
    scheme: Scheme,
    t: f64,
) -> Result<CurvePoint, TraceError> {
    let spot = evaluate(averager, control, scheme, t)?;
    let surface = averager.surface;
    Ok(CurvePoint {
        point: surface.outer_point(&spot.point),
        derivative: surface.outer_tangent(&spot.derivative),
        curvature: spot.curvature,
    })
}

/// The pieces of curve that a polygon's segments are.
pub(crate) fn polygon_controls(
    averager: &mut Averager<'_>,
    polygon: &[SurfacePoint],
    scheme: Scheme,
) -> Result<Vec<Control>, TraceError> {
    let count = polygon.len();
    let wrong = TraceError::Polygon { count, method: scheme.method };
    let Some(degree) = scheme.method.b_spline_degree() else {
        return match count {
            3 | 4 => Ok(vec![Control::Bezier(search_legs(averager, polygon)?)]),
            _ => Err(wrong),
        };
    };
    if count <= degree {
        return Err(wrong);
    }
    let legs = search_legs(averager, polygon)?;
    let knots = Knots { degree, intervals: count - degree, periodic: false };
    let control = |i: usize| {
        let (knots, index) = knots.around(i);
        Control::Interval(Interval { knots, index, legs: legs[i..i + degree].to_vec() })
    };
    Ok((0..knots.intervals).map(control).collect())
}
