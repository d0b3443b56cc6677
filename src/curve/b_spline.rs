//! B-splines: splines whose anchors are control points.

use super::{JumpPolicy, Scheme, Spline, SplineError, handles};
use crate::geodesic::PathError;
use crate::surface::{Surface, SurfacePoint};

impl Spline {
    /// Makes a uniform cubic B-spline from its control points: C² from end to end, and it passes near them.
    ///
    /// The points become anchors with handles of no length; [`with_scheme`](Self::with_scheme) makes it a quadratic one, or
    /// joins the same anchors in another way.
    ///
    /// # Errors
    /// [`SplineError`] with fewer than four points (closed: three), points that cannot be joined or that do not belong to
    /// the surface.
    pub fn b_spline(surface: &Surface, points: &[SurfacePoint], closed: bool) -> Result<Self, SplineError> {
        let needed = if closed { 3 } else { 4 };
        if points.len() < needed {
            return Err(SplineError::TooFewControlPoints { count: points.len(), needed });
        }
        let anchors = points.iter().map(|p| handles::bare_anchor(surface, *p)).collect::<Result<Vec<_>, _>>()?;
        for pair in points.windows(2) {
            if surface.sheet(pair[0].face)? != surface.sheet(pair[1].face)? {
                return Err(PathError::NoPath { from: pair[0], to: pair[1] }.into());
            }
        }
        Ok(Self { anchors, closed, scheme: Scheme::b_spline(), jumps: JumpPolicy::default() })
    }
}
