//! Tracing: from control polygons to polylines of geodesics.

use std::sync::Arc;

use super::{
    Scheme, SegmentTrace, Spline, SplineT, Trace,
    average::Averager,
    casteljau::{self, Legs},
    lane_riesenfeld,
    trace::SegmentKey,
};
use crate::geodesic::{PathError, PathFinder, inner::InnerPath};
use crate::surface::{PointError, Surface, SurfacePoint};

/// Why a trace failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TraceError {
    /// Two control points cannot be joined.
    #[error(transparent)]
    Path(#[from] PathError),
    /// The parameter is not on the spline.
    #[error("the spline has {segments} segments, so {t} is not a parameter on it: give 0 to {segments}")]
    Parameter {
        /// The parameter asked for.
        t: f64,
        /// How many segments there are.
        segments: usize,
    },
}

impl From<PointError> for TraceError {
    fn from(error: PointError) -> Self {
        Self::Path(error.into())
    }
}

/// Scratch memory for tracing; keep one a thread and reuse it, for any surface.
#[derive(Debug, Default)]
pub struct TraceWorkspace {
    /// The path finder inside, free for queries of one's own.
    pub finder: PathFinder,
}

/// Traces control polygons on one surface.
///
/// ```
/// use bevy_surface_splines::{curve::{Scheme, SplineT, Tracer}, surface::{Surface, SurfaceOptions, shapes}};
/// use glam::DVec3;
///
/// let surface = Surface::build(&shapes::icosphere(4), &SurfaceOptions::default())?;
/// let polygon = [(1.0, 0.0, 0.0), (1.0, 1.0, 0.5), (0.2, 1.0, 0.6), (0.0, 0.5, 1.0)]
///     .map(|(x, y, z)| surface.closest_point(DVec3::new(x, y, z).normalize()).unwrap().point);
/// let mut tracer = Tracer::new(&surface);
/// let curve = tracer.trace(&polygon, &Scheme::lane_riesenfeld())?;
/// assert_eq!(curve.segments()[0].points().len(), 67);
/// assert!((curve.length() - 1.806).abs() < 1e-2);
/// let middle = curve.point_at(&surface, SplineT(0.5)).unwrap();
/// assert!(surface.position(&middle).distance(DVec3::new(0.5125, 0.7094, 0.4838)) < 1e-2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Tracer<'s> {
    surface: &'s Surface,
    workspace: TraceWorkspace,
}

impl<'s> Tracer<'s> {
    /// Makes a tracer; memory is taken at the first trace.
    pub fn new(surface: &'s Surface) -> Self {
        Self { surface, workspace: TraceWorkspace::default() }
    }

    /// Traces one cubic segment, given its control points: anchor, handle, handle, anchor.
    ///
    /// Cost: three searches across the polygon, then mostly short paths that continue known ones.
    ///
    /// # Errors
    /// [`TraceError`] if control points cannot be joined or do not belong to the surface.
    pub fn trace(&mut self, polygon: &[SurfacePoint; 4], scheme: &Scheme) -> Result<Trace, TraceError> {
        let mut averager = Averager { surface: self.surface, finder: &mut self.workspace.finder };
        let legs = search_legs(&mut averager, polygon)?;
        let segment = trace_segment(&mut averager, legs, *scheme, None)?;
        Ok(Trace::new(vec![Arc::new(segment)], vec![0]))
    }

    /// Computes the scheme's points alone, into `out`, without the geodesics that join them.
    ///
    /// # Errors
    /// As [`trace`](Self::trace).
    pub fn trace_points(
        &mut self,
        polygon: &[SurfacePoint; 4],
        scheme: &Scheme,
        out: &mut Vec<SurfacePoint>,
    ) -> Result<(), TraceError> {
        let surface = self.surface;
        let mut averager = Averager { surface, finder: &mut self.workspace.finder };
        let legs = search_legs(&mut averager, polygon)?;
        out.clear();
        let mut paths = Vec::new();
        match scheme {
            Scheme::DeCasteljau { .. } => {
                casteljau::trace(&mut averager, legs, scheme.levels(), &mut paths)?;
                out.extend(paths.iter().map(|leg| surface.outer_point(&leg.start)));
                out.extend(paths.last().map(|leg| surface.outer_point(&leg.end)));
            }
            Scheme::LaneRiesenfeld { .. } => {
                paths.extend(legs);
                let mut points = Vec::new();
                lane_riesenfeld::trace(&mut averager, &mut paths, scheme.levels(), false, &mut points)?;
                out.extend(points.iter().map(|p| surface.outer_point(p)));
            }
        }
        Ok(())
    }

    /// The curve's own point at a local parameter from 0 to 1, to about 1e-6 of the diagonal.
    ///
    /// # Errors
    /// As [`trace`](Self::trace), and if `t` is not in [0, 1].
    pub fn evaluate(
        &mut self,
        polygon: &[SurfacePoint; 4],
        scheme: &Scheme,
        t: f64,
    ) -> Result<SurfacePoint, TraceError> {
        if !(0.0..=1.0).contains(&t) {
            return Err(TraceError::Parameter { t, segments: 1 });
        }
        let mut averager = Averager { surface: self.surface, finder: &mut self.workspace.finder };
        let legs = search_legs(&mut averager, polygon)?;
        evaluate_segment(&mut averager, legs, *scheme, t)
    }
}

impl Spline {
    /// Traces the spline. Segments whose control points and scheme are as in `previous` are shared with it; the result is
    /// the same, bit for bit, as without.
    ///
    /// # Errors
    /// [`TraceError`] if control points cannot be joined or do not belong to the surface.
    pub fn trace(
        &self,
        surface: &Surface,
        workspace: &mut TraceWorkspace,
        previous: Option<&Trace>,
    ) -> Result<Trace, TraceError> {
        let known = previous.map_or(&[][..], Trace::segments);
        let mut retraced = Vec::new();
        let mut segments = Vec::with_capacity(self.segment_count());
        for i in 0..self.segment_count() {
            let key = self.key(surface, i);
            // An edit may have shifted segments by one: look at the neighbours too.
            let near = [Some(i), i.checked_sub(1), Some(i + 1)];
            let same = near.into_iter().flatten().filter_map(|k| known.get(k)).find(|s| s.key.as_ref() == Some(&key));
            segments.push(match same {
                Some(segment) => Arc::clone(segment),
                None => {
                    retraced.push(i as u32);
                    let mut averager = Averager { surface, finder: &mut workspace.finder };
                    let legs = legs_of_key(&mut averager, &key)?;
                    Arc::new(trace_segment(&mut averager, legs, self.scheme, Some(key))?)
                }
            });
        }
        Ok(Trace::new(segments, retraced))
    }

    /// The curve's own point at a parameter, to about 1e-6 of the diagonal.
    ///
    /// # Errors
    /// As [`trace`](Self::trace), and [`TraceError::Parameter`] outside the spline.
    pub fn evaluate(
        &self,
        surface: &Surface,
        workspace: &mut TraceWorkspace,
        t: SplineT,
    ) -> Result<SurfacePoint, TraceError> {
        let segments = self.segment_count();
        let inside = (0.0..=segments as f64).contains(&t.0);
        let place = if inside { t.split(segments) } else { None };
        let (segment, local) = place.ok_or(TraceError::Parameter { t: t.0, segments })?;
        let mut averager = Averager { surface, finder: &mut workspace.finder };
        let legs = legs_of_key(&mut averager, &self.key(surface, segment))?;
        evaluate_segment(&mut averager, legs, self.scheme, local)
    }

    fn key(&self, surface: &Surface, segment: usize) -> SegmentKey {
        let (from, to) = (&self.anchors[segment], &self.anchors[(segment + 1) % self.anchors.len()]);
        SegmentKey {
            surface: surface.fingerprint(),
            legs: [from.outgoing.leg.clone(), to.incoming.leg.clone()],
            scheme: self.scheme.with_levels(self.scheme.levels()),
        }
    }
}

/// The legs of a segment: the outer two belong to the document, the middle one is searched.
fn legs_of_key(averager: &mut Averager<'_>, key: &SegmentKey) -> Result<Legs, TraceError> {
    let first = InnerPath::from_outer(averager.surface, &key.legs[0])?;
    let mut last = InnerPath::from_outer(averager.surface, &key.legs[1])?;
    last.reverse(averager.surface);
    let middle = averager.leg(&first.end, &last.start)?;
    Ok([first, middle, last])
}

fn search_legs(averager: &mut Averager<'_>, polygon: &[SurfacePoint; 4]) -> Result<Legs, TraceError> {
    let mut p = [averager.surface.inner_point(&polygon[0])?; 4];
    for (inner, outer) in p.iter_mut().zip(polygon) {
        *inner = averager.surface.inner_point(outer)?;
    }
    Ok([averager.leg(&p[0], &p[1])?, averager.leg(&p[1], &p[2])?, averager.leg(&p[2], &p[3])?])
}

fn trace_segment(
    averager: &mut Averager<'_>,
    legs: Legs,
    scheme: Scheme,
    key: Option<SegmentKey>,
) -> Result<SegmentTrace, TraceError> {
    let mut paths = Vec::new();
    let levels = scheme.levels();
    let pieces = 1_usize << levels;
    let parameters = match scheme {
        Scheme::DeCasteljau { .. } => {
            casteljau::trace(averager, legs, levels, &mut paths)?;
            (0..=3 * pieces).map(|i| i as f64 / (3 * pieces) as f64).collect()
        }
        Scheme::LaneRiesenfeld { .. } => {
            paths.extend(legs);
            lane_riesenfeld::trace(averager, &mut paths, levels, true, &mut Vec::new())?;
            (0..pieces + 3).map(|i| lane_riesenfeld::parameter(pieces, i)).collect()
        }
    };
    Ok(SegmentTrace::new(averager.surface, key, &paths, parameters))
}

fn evaluate_segment(
    averager: &mut Averager<'_>,
    legs: Legs,
    scheme: Scheme,
    t: f64,
) -> Result<SurfacePoint, TraceError> {
    let point = match scheme {
        Scheme::DeCasteljau { .. } => casteljau::evaluate(averager, legs, t)?,
        Scheme::LaneRiesenfeld { .. } => lane_riesenfeld::evaluate(averager, legs, t)?,
    };
    Ok(averager.surface.outer_point(&point))
}
