//! A chain of cubic Bézier segments in the plane.

use glam::{DAffine2, DVec2};

/// A chain of cubic Bézier segments in the plane, open or closed.
///
/// The control points lie in one array, anchor, handle, handle, anchor, …: segment `i` has those from `3i` to `3i + 3`. An open
/// path of n segments has 3n + 1 of them; a closed one 3n, its last segment ends at point 0. All are finite.
///
/// ```
/// use bevy_surface_splines::vector::VectorPath;
/// use glam::DVec2;
///
/// let points = [(0.0, 0.0), (1.0, 0.0), (2.0, 1.0), (2.0, 2.0)].map(|(x, y)| DVec2::new(x, y));
/// let path = VectorPath::from_points(points.to_vec(), false).unwrap();
/// assert_eq!(path.segment_count(), 1);
/// assert_eq!(path.point_at(0, 0.5), DVec2::new(1.375, 0.625));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VectorPath {
    points: Vec<DVec2>,
    closed: bool,
}

impl VectorPath {
    /// Makes a path of its control points; none if their number fits no path, or one is not finite.
    pub fn from_points(points: Vec<DVec2>, closed: bool) -> Option<Self> {
        let fits = points.len() % 3 == usize::from(!closed);
        (fits && points.len() > 1 && points.iter().all(|p| p.is_finite())).then_some(Self { points, closed })
    }

    /// The control points: anchor, handle, handle, anchor, …
    pub fn points(&self) -> &[DVec2] {
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

    /// Number of anchors.
    pub fn anchor_count(&self) -> usize {
        self.points.len().div_ceil(3)
    }

    /// An anchor, if there is such a one.
    pub fn anchor(&self, anchor: usize) -> Option<DVec2> {
        self.points.get(anchor.checked_mul(3)?).copied()
    }

    /// The control points of a segment, if there is such a segment.
    pub fn segment(&self, segment: usize) -> Option<[DVec2; 4]> {
        let first = segment.checked_mul(3)?;
        let [a, b, c] = *self.points.get(first..first.checked_add(3)?)? else { return None };
        let d = self.points.get(first + 3).or(if self.closed { self.points.first() } else { None })?;
        Some([a, b, c, *d])
    }

    /// All segments in order.
    pub fn segments(&self) -> impl ExactSizeIterator<Item = [DVec2; 4]> + '_ {
        (0..self.segment_count()).map(|i| self.segment(i).unwrap_or_default())
    }

    /// Vectors from an anchor to its handles, of the segment before and of the one behind, where there are such.
    pub fn handles(&self, anchor: usize) -> [Option<DVec2>; 2] {
        let Some(at) = self.anchor(anchor) else { return [None; 2] };
        let n = self.points.len();
        let before = if anchor > 0 { Some(3 * anchor - 1) } else { self.closed.then(|| n - 1) };
        let behind = Some(3 * anchor + 1).filter(|i| *i < n);
        [before, behind].map(|i| i.and_then(|i| Some(*self.points.get(i)? - at)))
    }

    /// The point of a segment at a local parameter; zero if there is no such segment.
    pub fn point_at(&self, segment: usize, t: f64) -> DVec2 {
        let [a, b, c, d] = self.segment(segment).unwrap_or_default();
        let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
        ab.lerp(bc, t).lerp(bc.lerp(cd, t), t)
    }

    /// Smallest and largest coordinates of the control points; none of an empty path.
    pub fn bounds(&self) -> Option<(DVec2, DVec2)> {
        let first = *self.points.first()?;
        Some(self.points.iter().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p))))
    }

    /// Smallest and largest coordinates of the curve itself; none of an empty path.
    pub fn curve_bounds(&self) -> Option<(DVec2, DVec2)> {
        let first = *self.points.first()?;
        let (mut low, mut high) = (first, first);
        for segment in self.segments() {
            for axis in 0..2 {
                let [a, b, c, d] = segment.map(|p| p[axis]);
                let mut take = |value: f64| {
                    low[axis] = low[axis].min(value);
                    high[axis] = high[axis].max(value);
                };
                take(d);
                // The derivative is 3 (u t² + v t + w).
                let (u, v, w) = (d - 3.0 * c + 3.0 * b - a, 2.0 * (a - 2.0 * b + c), b - a);
                let root = (v * v - 4.0 * u * w).sqrt();
                let q = -0.5 * (v + root.copysign(v));
                for t in [q / u, w / q].into_iter().filter(|t| (0.0..=1.0).contains(t)) {
                    let s = 1.0 - t;
                    take(s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d);
                }
            }
        }
        Some((low, high))
    }

    /// Distance between opposite corners of the [`bounds`](Self::bounds).
    pub fn extent(&self) -> f64 {
        self.bounds().map_or(0.0, |(low, high)| low.distance(high))
    }

    /// The path under an affine map; none if a point would not be finite.
    pub fn transformed(&self, transform: &DAffine2) -> Option<Self> {
        Self::from_points(self.points.iter().map(|p| transform.transform_point2(*p)).collect(), self.closed)
    }

    /// The part of a segment between two local parameters, as control points; zeros if there is no such segment.
    pub fn part(&self, segment: usize, from: f64, to: f64) -> [DVec2; 4] {
        let [a, b, c, d] = self.segment(segment).unwrap_or_default();
        let blossom = |r: f64, s: f64, t: f64| {
            let (ab, bc, cd) = (a.lerp(b, r), b.lerp(c, r), c.lerp(d, r));
            ab.lerp(bc, s).lerp(bc.lerp(cd, s), t)
        };
        let ends =
            [if from == 0.0 { a } else { blossom(from, from, from) }, if to == 1.0 { d } else { blossom(to, to, to) }];
        [ends[0], blossom(from, from, to), blossom(from, to, to), ends[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(n: usize) -> Vec<DVec2> {
        (0..n).map(|i| DVec2::new(i as f64, (i * i % 5) as f64)).collect()
    }

    #[test]
    fn only_numbers_of_points_that_fit_make_a_path() {
        for n in 0..12 {
            assert_eq!(VectorPath::from_points(points(n), false).is_some(), n > 1 && n % 3 == 1, "{n}");
            assert_eq!(VectorPath::from_points(points(n), true).is_some(), n > 0 && n % 3 == 0, "{n}");
        }
        assert!(VectorPath::from_points(vec![DVec2::NAN; 4], false).is_none());
    }

    #[test]
    fn closed_paths_come_back_to_their_start() {
        let path = VectorPath::from_points(points(6), true).unwrap();
        assert_eq!((path.segment_count(), path.anchor_count()), (2, 2));
        assert_eq!(path.segment(1).unwrap()[3], path.points()[0]);
        assert_eq!(path.segment(2), None);
        assert_eq!(path.handles(0), [Some(path.points()[5]), Some(path.points()[1])]);
        let open = VectorPath::from_points(points(7), false).unwrap();
        assert_eq!((open.segment_count(), open.anchor_count()), (2, 3));
        assert_eq!(open.handles(0), [None, Some(open.points()[1])]);
        assert_eq!(open.handles(2), [Some(open.points()[5] - open.points()[6]), None]);
    }

    #[test]
    fn curve_bounds_are_those_of_the_curve() {
        for n in [4, 7, 10] {
            let path = VectorPath::from_points(points(n), false).unwrap();
            let (low, high) = path.curve_bounds().unwrap();
            let on = (0..path.segment_count()).flat_map(|i| (0..=1000).map(move |k| (i, f64::from(k) / 1000.0)));
            let sampled =
                on.map(|(i, t)| path.point_at(i, t)).fold((DVec2::MAX, DVec2::MIN), |(l, h), p| (l.min(p), h.max(p)));
            assert!(low.distance(sampled.0) < 1e-5 && high.distance(sampled.1) < 1e-5, "{low} {high} {sampled:?}");
        }
    }

    #[test]
    fn parts_are_parts_of_the_curve() {
        let path = VectorPath::from_points(points(4), false).unwrap();
        let part = VectorPath::from_points(path.part(0, 0.2, 0.7).to_vec(), false).unwrap();
        for i in 0..=10 {
            let t = f64::from(i) / 10.0;
            assert!(part.point_at(0, t).distance(path.point_at(0, 0.2 + 0.5 * t)) < 1e-14);
        }
        assert_eq!(path.part(0, 0.0, 1.0), path.segment(0).unwrap());
    }
}
