//! A line drawn on a surface: points joined by shortest paths.

use crate::curve::Trace;
use crate::geodesic::{GeodesicPath, PathError, PathFinder, PathQuality};
use crate::surface::{Surface, SurfacePoint};

/// A line drawn on a surface, point by point: what a pointer hits, thinned, each joined to the one before by the shortest path.
///
/// It grows by [`push`](Self::push) and keeps its memory when it is [`cleared`](Self::clear). It holds no reference to its
/// surface.
///
/// ```
/// use bevy_surface_splines::{curve::*, surface::{Surface, SurfaceOptions, shapes}};
/// use glam::DVec3;
///
/// let surface = Surface::build(&shapes::icosphere(4), &SurfaceOptions::default())?;
/// let mut workspace = TraceWorkspace::default();
/// let mut line = DrawnLine::new(0.02);
/// for k in 0..200 {
///     let a = f64::from(k) * 0.01;
///     let hit = surface.closest_point(DVec3::new(a.cos(), a.sin(), 0.3 * (3.0 * a).sin())).unwrap().point;
///     line.push(&surface, &mut workspace.finder, hit)?;
/// }
/// line.end(&surface, &mut workspace.finder)?;
/// let fit = Spline::fit(&surface, &mut workspace, &line, &FitOptions::within(0.01))?;
/// assert!(fit.max_distance <= 0.01 && fit.spline.segment_count() <= 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnLine {
    step: f64,
    points: Vec<SurfacePoint>,
    /// From each point to the next; of a closed line one from the last to the first too.
    paths: Vec<GeodesicPath>,
    /// Paths that were used before, for their memory.
    spare: Vec<GeodesicPath>,
    /// The last point that was given, if it was too near to the one before.
    left_out: Option<SurfacePoint>,
    closed: bool,
}

impl DrawnLine {
    /// Makes an empty line; points nearer than `step` (local units) to the one before are left out. A good step is the larger
    /// of half an edge and of what three pixels are on the surface.
    pub fn new(step: f64) -> Self {
        Self { step: if step.is_nan() { 0.0 } else { step }, ..Self::default() }
    }

    /// Joins points to a line; those that repeat their predecessor are left out.
    ///
    /// # Errors
    /// [`PathError`] if points do not belong to the surface or lie on different pieces of it.
    pub fn through(
        surface: &Surface,
        finder: &mut PathFinder,
        points: &[SurfacePoint],
        closed: bool,
    ) -> Result<Self, PathError> {
        let mut line = Self::new(0.0);
        for point in points {
            line.push(surface, finder, *point)?;
        }
        if closed {
            line.close(surface, finder)?;
        }
        Ok(line)
    }

    /// The line along a trace, which is closed if its spline is: to be followed anew by fewer segments, say.
    pub fn along(trace: &Trace, closed: bool) -> Self {
        let mut line = Self::default();
        for path in trace.segments().iter().flat_map(|segment| segment.paths()).filter(|path| path.length() > 0.0) {
            line.points.push(path.start());
            line.paths.push(path.clone());
        }
        if !closed {
            line.points.extend(line.paths.last().map(GeodesicPath::end));
        }
        line.closed = closed && !line.paths.is_empty();
        line
    }

    /// The line along paths of some length, each from where the one before ends.
    pub(crate) fn of_paths(paths: Vec<GeodesicPath>, closed: bool) -> Self {
        let mut points: Vec<SurfacePoint> = paths.iter().map(GeodesicPath::start).collect();
        if !closed {
            points.extend(paths.last().map(GeodesicPath::end));
        }
        Self { points, paths, closed, ..Self::default() }
    }

    /// Forgets all points and keeps the memory.
    pub fn clear(&mut self) {
        self.points.clear();
        self.spare.append(&mut self.paths);
        (self.left_out, self.closed) = (None, false);
    }

    /// Adds a point and says whether it was kept; a closed line keeps none.
    ///
    /// Cost: one short path.
    ///
    /// # Errors
    /// [`PathError`] if the point does not belong to the surface or lies on another piece of it; the line is then as it was.
    pub fn push(&mut self, surface: &Surface, finder: &mut PathFinder, point: SurfacePoint) -> Result<bool, PathError> {
        surface.inner_point(&point)?;
        if self.closed {
            return Ok(false);
        }
        let near = self.points.last().is_some_and(|last| {
            surface.same_place(last, &point) || surface.position(last).distance(surface.position(&point)) < self.step
        });
        if near {
            self.left_out = Some(point);
            return Ok(false);
        }
        self.add(surface, finder, point)?;
        self.left_out = None;
        Ok(true)
    }

    /// Ends the line where the last point was given, even if that was left out.
    ///
    /// # Errors
    /// As [`push`](Self::push).
    pub fn end(&mut self, surface: &Surface, finder: &mut PathFinder) -> Result<(), PathError> {
        if let Some(point) = self.left_out.take()
            && self.points.last().is_some_and(|last| !surface.same_place(last, &point))
        {
            self.add(surface, finder, point)?;
        }
        Ok(())
    }

    /// Joins the last point to the first; of fewer than three points nothing is closed.
    ///
    /// # Errors
    /// As [`push`](Self::push).
    pub fn close(&mut self, surface: &Surface, finder: &mut PathFinder) -> Result<(), PathError> {
        let Some(first) = self.points.first().copied() else { return Ok(()) };
        let near = |last: &SurfacePoint| {
            surface.same_place(last, &first) || surface.position(last).distance(surface.position(&first)) < self.step
        };
        while self.points.len() > 3 && self.points.last().is_some_and(near) {
            self.points.pop();
            self.spare.extend(self.paths.pop());
        }
        if self.points.len() < 3 || self.closed {
            return Ok(());
        }
        let last = self.points[self.points.len() - 1];
        let path = self.path(surface, finder, &last, &first)?;
        self.paths.push(path);
        (self.closed, self.left_out) = (true, None);
        Ok(())
    }

    fn add(&mut self, surface: &Surface, finder: &mut PathFinder, point: SurfacePoint) -> Result<(), PathError> {
        if let Some(last) = self.points.last().copied() {
            let path = self.path(surface, finder, &last, &point)?;
            self.paths.push(path);
        }
        self.points.push(point);
        Ok(())
    }

    fn path(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        from: &SurfacePoint,
        to: &SurfacePoint,
    ) -> Result<GeodesicPath, PathError> {
        let mut path = self.spare.pop().unwrap_or_else(|| GeodesicPath::at_rest(*from));
        finder.shortest_into(surface, from, to, PathQuality::Default, &mut path)?;
        Ok(path)
    }

    /// The points that were kept.
    pub fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    /// The paths from point to point, of a closed line one more.
    pub fn paths(&self) -> &[GeodesicPath] {
        &self.paths
    }

    /// Whether the last point is joined to the first.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Length in local units.
    pub fn length(&self) -> f64 {
        self.paths.iter().fold(0.0, |sum, path| sum + path.length())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{SurfaceOptions, shapes};
    use glam::DVec3;

    #[test]
    fn hits_are_thinned_and_the_last_one_stays() {
        let surface = Surface::build(&shapes::grid(10, 10, 1.0, 1.0), &SurfaceOptions::default()).unwrap();
        let mut finder = PathFinder::new();
        let at = |x: f64, y: f64| surface.closest_point(DVec3::new(x, y, 0.0)).unwrap().point;
        let mut line = DrawnLine::new(0.095);
        for round in 0..2 {
            for k in 0..=87 {
                line.push(&surface, &mut finder, at(0.05 + 0.01 * f64::from(k), 0.5)).unwrap();
            }
            assert_eq!(line.points().len(), 9, "{round}");
            line.end(&surface, &mut finder).unwrap();
            assert_eq!((line.points().len(), line.paths().len()), (10, 9));
            assert!((line.length() - 0.87).abs() < 1e-12);
            line.push(&surface, &mut finder, at(0.5, 0.9)).unwrap();
            line.close(&surface, &mut finder).unwrap();
            assert!(line.is_closed() && line.paths().len() == line.points().len());
            assert!(!line.push(&surface, &mut finder, at(0.1, 0.1)).unwrap());
            line.clear();
            assert!(line.points().is_empty() && !line.is_closed());
        }
    }
}
