//! Traces as curves of Bevy's mathematics.

use std::sync::Arc;

use bevy::math::curve::{Curve, Interval};
use bevy::prelude::*;

use super::trace::SplineTrace;
use crate::curve::{SplineT, Trace};

/// The trace of a spline as a [`Curve`] through the surface's local space, with all that Bevy does with curves.
///
/// Parametrization: the domain is 0 to the number of segments, and a parameter is a [`SplineT`]. Interpolation: positions are
/// on the trace's polyline, and at parameters of the scheme's points they are those points. Continuity: C⁰.
///
/// It is a copy of the trace as it was, cheap to make and to clone: later edits of the spline do not change it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_surface_splines::prelude::*;
/// fn place_posts(mut gizmos: Gizmos, spline: Single<(&SplineTrace, &OnSurface)>, places: Query<&GlobalTransform>) -> Result {
///     let (trace, on) = *spline;
///     let Some(curve) = trace.curve() else { return Ok(()) }; // it has no segment
///     let place = places.get(on.0)?;
///     for position in curve.samples(20)? {
///         gizmos.cross(Isometry3d::from_translation(place.transform_point(position)), 0.1, Color::WHITE);
///     }
///     Ok(())
/// }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TraceCurve {
    trace: Arc<Trace>,
    domain: Interval,
}

impl TraceCurve {
    /// A trace as a curve; none if it is empty, because a curve has a position at least somewhere.
    pub fn new(trace: Arc<Trace>) -> Option<Self> {
        trace.position_at(SplineT(0.0))?;
        let domain = Interval::new(0.0, trace.segments().len() as f32).ok()?;
        Some(Self { trace, domain })
    }

    /// The trace.
    pub fn trace(&self) -> &Arc<Trace> {
        &self.trace
    }
}

impl Curve<Vec3> for TraceCurve {
    fn domain(&self) -> Interval {
        self.domain
    }

    /// The position at the nearest parameter of the domain; NaN for NaN.
    fn sample_unchecked(&self, t: f32) -> Vec3 {
        self.trace.position_at(SplineT(f64::from(t))).map_or(Vec3::NAN, |position| position.as_vec3())
    }
}

impl SplineTrace {
    /// The trace as a curve of Bevy's; none if the spline has no segment, as a B-spline of too few anchors.
    pub fn curve(&self) -> Option<TraceCurve> {
        TraceCurve::new(Arc::clone(self.trace()))
    }
}
