//! A chain of cubic Bézier segments in space.

use glam::DVec3;

use super::VectorPath;

/// A chain of cubic Bézier segments in space, open or closed.
///
/// The control points lie as in a [`VectorPath`]: anchor, handle, handle, anchor, …; an open path of n segments has 3n + 1 of them, a closed
/// one 3n. All are finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpatialPath {
    points: Vec<DVec3>,
    closed: bool,
}

impl SpatialPath {
    /// Makes a path of its control points; none if their number fits no path, or one is not finite.
    pub fn from_points(points: Vec<DVec3>, closed: bool) -> Option<Self> {
        let fits = points.len() % 3 == usize::from(!closed);
        (fits && points.len() > 1 && points.iter().all(|p| p.is_finite())).then_some(Self { points, closed })
    }

    /// The control points: anchor, handle, handle, anchor, …
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Whether the last segment ends at the first anchor.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Number of segments.
    pub fn segment_count(&self) -> usize {
        self.points.len() / 3
    }
}

impl From<&VectorPath> for SpatialPath {
    /// The path in the plane z = 0.
    fn from(path: &VectorPath) -> Self {
        Self { points: path.points().iter().map(|p| p.extend(0.0)).collect(), closed: path.is_closed() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_numbers_of_points_that_fit_make_a_path() {
        for n in 0..12 {
            let points = vec![DVec3::ONE; n];
            assert_eq!(SpatialPath::from_points(points.clone(), false).is_some(), n > 1 && n % 3 == 1, "{n}");
            assert_eq!(SpatialPath::from_points(points, true).is_some(), n > 0 && n % 3 == 0, "{n}");
        }
        assert!(SpatialPath::from_points(vec![DVec3::NAN; 4], false).is_none());
    }
}
