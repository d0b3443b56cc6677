//! Tracing many splines at once.

use super::{Spline, Trace, TraceError, TraceWorkspace};
use crate::surface::Surface;

impl Spline {
    /// Traces many splines of one surface, each with the result that [`trace`](Self::trace) has; in the order given.
    ///
    /// With the feature `parallel` they are spread over the caller's rayon pool, with a workspace for each thread; the
    /// result does not depend on the number of threads.
    ///
    /// ```
    /// use bevy_surface_splines::{curve::Spline, geodesic::PathFinder, surface::{FaceId, Surface, SurfaceOptions, shapes}};
    ///
    /// let surface = Surface::build(&shapes::icosphere(3), &SurfaceOptions::default())?;
    /// let mut finder = PathFinder::new();
    /// let middle = |face| surface.point(FaceId(face), [0.3, 0.3, 0.4]);
    /// let splines = (0..20)
    ///     .map(|i| Ok(Spline::smooth_through(&surface, &mut finder, &[middle(i)?, middle(600 + i)?], false)?))
    ///     .collect::<Result<Vec<_>, Box<dyn std::error::Error>>>()?;
    /// let traces = Spline::trace_all(&surface, &splines);
    /// assert!(traces.iter().all(|t| t.as_ref().is_ok_and(|t| t.length() > 0.0)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn trace_all(surface: &Surface, splines: &[Self]) -> Vec<Result<Trace, TraceError>> {
        let trace = |workspace: &mut TraceWorkspace, spline: &Self| spline.trace(surface, workspace, None);
        #[cfg(feature = "parallel")]
        {
            use rayon::prelude::*;
            splines.par_iter().map_init(TraceWorkspace::default, trace).collect()
        }
        #[cfg(not(feature = "parallel"))]
        {
            let mut workspace = TraceWorkspace::default();
            splines.iter().map(|spline| trace(&mut workspace, spline)).collect()
        }
    }
}
