//! Tracing: from control polygons to polylines of geodesics.

use std::sync::Arc;

use super::{
    Method, Scheme, SegmentTrace, Spline, SplineT, Trace,
    average::Averager,
    piece::Control,
    segment::{self, ChainLegs, Scratch},
};
use crate::geodesic::{PathError, PathFinder, Tangent};
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
    /// There is no curve to be on.
    #[error(
        "the spline has no segments: give it more anchors (a B-spline has none below four control points, closed three)"
    )]
    NoSegments,
    /// The spline cannot be converted.
    #[error("the spline cannot be converted: {0}")]
    Conversion(&'static str),
    /// The polygon has too few or too many points for the method.
    #[error("a polygon of {count} points is none of a {}: give 3 or 4 for a Bézier segment, at least 4 for a B-spline (3 for a quadratic one)", method.name())]
    Polygon {
        /// How many points there are.
        count: usize,
        /// The method.
        method: Method,
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
    pub(crate) scratch: Scratch,
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

    /// Traces a control polygon: three or four control points of a Bézier segment, or those of an open B-spline.
    ///
    /// Cost: searches across the polygon, then mostly short paths that continue known ones.
    ///
    /// # Errors
    /// [`TraceError`] if control points cannot be joined or do not belong to the surface, or are too few or too many.
    pub fn trace(&mut self, polygon: &[SurfacePoint], scheme: &Scheme) -> Result<Trace, TraceError> {
        let mut averager =
            Averager { surface: self.surface, finder: &mut self.workspace.finder, quality: scheme.quality };
        let controls = segment::polygon_controls(&mut averager, polygon, *scheme)?;
        let scratch = &mut self.workspace.scratch;
        let mut segments = Vec::with_capacity(controls.len());
        for control in controls {
            let mut segment = SegmentTrace::default();
            segment::trace(&mut averager, scratch, control, *scheme, &mut segment)?;
            segments.push(Arc::new(segment));
        }
        let retraced = (0..segments.len() as u32).collect();
        Ok(Trace::new(segments, retraced))
    }

    /// Computes the scheme's points alone, into `out`; of Lane–Riesenfeld subdivision without the geodesics that join them,
    /// and, once warm, without an allocation.
    ///
    /// # Errors
    /// As [`trace`](Self::trace).
    pub fn trace_points(
        &mut self,
        polygon: &[SurfacePoint],
        scheme: &Scheme,
        out: &mut Vec<SurfacePoint>,
    ) -> Result<(), TraceError> {
        let mut averager =
            Averager { surface: self.surface, finder: &mut self.workspace.finder, quality: scheme.quality };
        let scratch = &mut self.workspace.scratch;
        out.clear();
        if matches!(polygon.len(), 3 | 4) && segment::subdivides_whole(*scheme) {
            return segment::subdivided_points(&mut averager, scratch, polygon, scheme.sampling, out);
        }
        let mut segment = SegmentTrace::default();
        for control in segment::polygon_controls(&mut averager, polygon, *scheme)? {
            out.truncate(out.len().saturating_sub(1)); // the next segment begins with the last one's end
            segment::trace(&mut averager, scratch, control, *scheme, &mut segment)?;
            out.extend(segment.points());
        }
        Ok(())
    }

    /// The curve's own point at a parameter, counted in segments, to about 1e-6 of the diagonal.
    ///
    /// # Errors
    /// As [`trace`](Self::trace), and if the polygon's curve has no such parameter.
    pub fn evaluate(&mut self, polygon: &[SurfacePoint], scheme: &Scheme, t: f64) -> Result<SurfacePoint, TraceError> {
        Ok(self.curve_point(polygon, scheme, t)?.point)
    }

    /// The curve's own point at a parameter, with derivative and geodesic curvature.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn curve_point(&mut self, polygon: &[SurfacePoint], scheme: &Scheme, t: f64) -> Result<CurvePoint, TraceError> {
        let mut averager =
            Averager { surface: self.surface, finder: &mut self.workspace.finder, quality: scheme.quality };
        let controls = segment::polygon_controls(&mut averager, polygon, *scheme)?;
        let (segment, local) = SplineT(t).locate(controls.len())?;
        segment::curve_point(&mut averager, &controls[segment], *scheme, local)
    }
}

/// A point of a curve, with the curve's first two orders there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// The point.
    pub point: SurfacePoint,
    /// Derivative by the parameter, in local units a segment; zero at a cusp and where control points coincide.
    pub derivative: Tangent,
    /// Geodesic curvature, one over a length: positive where the curve turns left as seen against the normal, zero where
    /// the derivative is.
    pub curvature: f64,
}

impl Spline {
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
        Ok(self.curve_point(surface, workspace, t)?.point)
    }

    /// The curve's own point at a parameter, with derivative and geodesic curvature. Where segments meet, those of the
    /// segment that begins there are given.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn curve_point(
        &self,
        surface: &Surface,
        workspace: &mut TraceWorkspace,
        t: SplineT,
    ) -> Result<CurvePoint, TraceError> {
        let (segment, local) = t.locate(self.segment_count())?;
        let mut averager = Averager { surface, finder: &mut workspace.finder, quality: self.scheme.quality };
        let control = self.control(&mut averager, segment)?;
        segment::curve_point(&mut averager, &control, self.scheme, local)
    }

    /// The piece of curve that a segment is.
    pub(crate) fn control(&self, averager: &mut Averager<'_>, segment: usize) -> Result<Control, TraceError> {
        self.key(averager.surface, segment, None).control.control(averager, 0, &mut ChainLegs::default())
    }
}

impl SplineT {
    /// Segment and local parameter of a spline of `segments` segments.
    pub(crate) fn locate(self, segments: usize) -> Result<(usize, f64), TraceError> {
        if segments == 0 {
            return Err(TraceError::NoSegments);
        }
        let inside = (0.0..=segments as f64).contains(&self.0);
        let place = if inside { self.split(segments) } else { None };
        place.ok_or(TraceError::Parameter { t: self.0, segments })
    }
}
