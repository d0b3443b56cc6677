//! What the trace of a segment depends on, and how it is made from that.

use super::{
    CurvePoint, Method, Sampling, Scheme, SegmentTrace, TraceError,
    average::Averager,
    casteljau::Legs,
    comparison,
    lane_riesenfeld::{self, Interval, Knots, Levels},
    piece::{self, Control, Spot},
    sample::{self, Sampled},
};
use crate::geodesic::{GeodesicPath, inner::InnerPath};
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
        let surface = averager.surface;
        match self {
            Self::Bezier { legs, middle } => {
                let first = InnerPath::from_outer(surface, &legs[0])?;
                let mut last = InnerPath::from_outer(surface, &legs[1])?;
                last.reverse(surface);
                // A document may say anything: a leg that does not join the handles is searched.
                let joins = |middle: &&GeodesicPath| {
                    surface.same_place(&middle.start, &legs[0].end) && surface.same_place(&middle.end, &legs[1].end)
                };
                let middle = match middle.as_ref().filter(joins) {
                    Some(middle) => InnerPath::from_outer(surface, middle)?,
                    None => averager.leg(&first.end, &last.start)?,
                };
                Ok(Control::Bezier(vec![first, middle, last]))
            }
            Self::BSpline { points, knots, index } => {
                let legs = chain.of_interval(averager, interval, points)?;
                Ok(Control::Interval(Interval { knots: *knots, index: *index, legs }))
            }
        }
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

/// Traces a segment.
pub(crate) fn trace(
    averager: &mut Averager<'_>,
    scratch: &mut Scratch,
    control: Control,
    scheme: Scheme,
    key: Option<SegmentKey>,
) -> Result<SegmentTrace, TraceError> {
    let (sampled, jumps) = match control {
        Control::Bezier(legs) if scheme.method.is_for_comparison() => {
            comparison::sample(averager, &legs, scheme.method, scheme.sampling)?
        }
        Control::Bezier(legs) if subdivides_whole(scheme) => {
            let knots = subdivide(averager, scratch, &legs, scheme.sampling, true)?;
            let parameters = (0..scratch.points.len()).map(|i| knots.greville(i) / knots.intervals as f64).collect();
            (Sampled { paths: scratch.levels.legs.to_vec(), parameters, bound: None }, Vec::new())
        }
        control => {
            let control = understood(control, scheme.method);
            (sample::sample(averager, control, scheme.sampling, scheme.on_curve)?, Vec::new())
        }
    };
    Ok(SegmentTrace::new(averager.surface, key, sampled, jumps))
}

/// The points of a segment's trace alone.
pub(crate) fn trace_points(
    averager: &mut Averager<'_>,
    scratch: &mut Scratch,
    control: Control,
    scheme: Scheme,
    out: &mut Vec<SurfacePoint>,
) -> Result<(), TraceError> {
    let surface = averager.surface;
    match control {
        Control::Bezier(legs) if subdivides_whole(scheme) => {
            subdivide(averager, scratch, &legs, scheme.sampling, false)?;
            out.extend(scratch.points.iter().map(|p| surface.outer_point(p)));
        }
        control => {
            let segment = trace(averager, scratch, control, scheme, None)?;
            out.extend(segment.points());
        }
    }
    Ok(())
}

/// Whether the trace is the subdivided control polygon of the whole segment, which shares points between intervals.
fn subdivides_whole(scheme: Scheme) -> bool {
    let even = !matches!(scheme.sampling, Sampling::Adaptive { .. });
    scheme.method == Method::LaneRiesenfeld && even && !scheme.on_curve
}

/// Subdivides a polygon; `scratch` then holds the points, and the legs between them if `joined`.
fn subdivide(
    averager: &mut Averager<'_>,
    scratch: &mut Scratch,
    polygon: &[InnerPath],
    sampling: Sampling,
    joined: bool,
) -> Result<Knots, TraceError> {
    let degree = polygon.len();
    let longest = polygon.iter().map(|leg| leg.length).fold(0.0, f64::max);
    // The legs of a level with N intervals are up to degree / N times as long as those of the polygon.
    let levels = sampling.levels(degree as f64 * longest).unwrap_or(0);
    scratch.levels.legs.clear();
    scratch.levels.legs.extend_from(polygon);
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
