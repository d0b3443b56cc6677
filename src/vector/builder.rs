//! Building paths from lines, quadratic and cubic curves and elliptical arcs.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DAffine2, DVec2};

use super::VectorPath;

/// What adding a segment did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Added {
    /// It was added.
    Drawn,
    /// Its control points are all in one place: it was left out.
    NoLength,
}

/// Builds paths as a pen draws them: lines, curves and arcs become cubic segments.
///
/// A line has its handles at thirds. A quadratic curve is raised by a degree, which is exact. An elliptical arc becomes pieces of at most
/// 90°, which are off by at most 2.8e-4 of the radius.
#[derive(Clone, Debug, Default)]
pub struct PathBuilder {
    paths: Vec<VectorPath>,
    points: Vec<DVec2>,
    start: DVec2,
    pen: DVec2,
    segments: usize,
    overflowed: bool,
    /// Applied to all that is drawn.
    transform: DAffine2,
}

/// A gap to the start that is smaller than this share of the path's extent is rounding and closed without a line.
const CLOSED: f64 = 1e-10;

impl PathBuilder {
    /// A pen whose paths come to lie under an affine map. What has no length, and what is closed, is judged there.
    pub fn under(transform: DAffine2) -> Self {
        Self { transform, ..Self::default() }
    }

    /// Lifts the pen and puts it down elsewhere: what follows is another path.
    pub fn move_to(&mut self, to: DVec2) {
        self.end_open();
        (self.start, self.pen) = (to, to);
    }

    /// Where the pen is, before the map.
    pub fn pen(&self) -> DVec2 {
        self.pen
    }

    /// Adds a line.
    pub fn line_to(&mut self, to: DVec2) -> Added {
        let from = self.pen;
        self.cubic_to(from.lerp(to, 1.0 / 3.0), from.lerp(to, 2.0 / 3.0), to)
    }

    /// Adds a quadratic curve.
    pub fn quadratic_to(&mut self, control: DVec2, to: DVec2) -> Added {
        let from = self.pen;
        self.cubic_to(from.lerp(control, 2.0 / 3.0), to.lerp(control, 2.0 / 3.0), to)
    }

    /// Adds a cubic curve.
    pub fn cubic_to(&mut self, c1: DVec2, c2: DVec2, to: DVec2) -> Added {
        let [from, c1, c2, end] = [self.pen, c1, c2, to].map(|p| self.transform.transform_point2(p));
        self.pen = to;
        if from == end && from == c1 && from == c2 {
            return Added::NoLength;
        }
        if self.points.is_empty() {
            self.points.push(from);
        }
        self.points.extend([c1, c2, end]);
        self.segments += 1;
        Added::Drawn
    }

    /// Adds an elliptical arc as SVG means it (SVG 2, appendix B.2): radii that are too small grow until the arc reaches, an arc
    /// without a radius is a line, one that ends where it begins is left out. `rotation` is in radians.
    pub fn arc_to(&mut self, radii: DVec2, rotation: f64, large: bool, sweep: bool, to: DVec2) -> Added {
        let from = self.pen;
        let mut radii = radii.abs();
        if from == to {
            return Added::NoLength;
        }
        if radii.x == 0.0 || radii.y == 0.0 {
            return self.line_to(to);
        }
        let axis = DVec2::from_angle(rotation);
        let back = DVec2::new(axis.x, -axis.y);
        // In the frame of the ellipse, about the middle of the chord.
        let half = back.rotate(0.5 * (from - to));
        let needed = (half / radii).length_squared();
        if needed > 1.0 {
            radii *= needed.sqrt();
        }
        // On the unit circle: the chord's half, and the centre on its perpendicular.
        let chord = half / radii;
        let squared = chord.length_squared();
        let reach = ((1.0 - squared).max(0.0) / squared).sqrt() * if large == sweep { -1.0 } else { 1.0 };
        let centre = DVec2::new(chord.y, -chord.x) * reach;
        let (first, last) = (chord - centre, -chord - centre);
        let mut turn = first.perp_dot(last).atan2(first.dot(last));
        if sweep && turn < 0.0 {
            turn += TAU;
        } else if !sweep && turn > 0.0 {
            turn -= TAU;
        }
        let middle = 0.5 * (from + to) + axis.rotate(centre * radii);
        let place = |unit: DVec2| middle + axis.rotate(unit * radii);
        let pieces = ((turn.abs() / FRAC_PI_2) - 1e-9).ceil().clamp(1.0, 4.0);
        let step = turn / pieces;
        // Handles of this length make the piece touch the arc at its ends and in its middle.
        let reach = 4.0 / 3.0 * (step / 4.0).tan();
        let begin = first.y.atan2(first.x);
        for piece in 0..pieces as u32 {
            let u0 = DVec2::from_angle(begin + step * f64::from(piece));
            let u1 = DVec2::from_angle(begin + step * f64::from(piece + 1));
            let end = if f64::from(piece + 1) == pieces { to } else { place(u1) };
            self.cubic_to(place(u0 + u0.perp() * reach), place(u1 - u1.perp() * reach), end);
        }
        Added::Drawn
    }

    /// Closes the path, with a line where it does not end where it began; the pen is then at its start. Without a segment
    /// there is nothing to close.
    pub fn close(&mut self) -> Added {
        let added = if self.points.is_empty() { Added::NoLength } else { Added::Drawn };
        if let [first, .., last] = self.points[..] {
            let low = self.points.iter().copied().fold(first, DVec2::min);
            let high = self.points.iter().copied().fold(first, DVec2::max);
            if last.distance(first) > CLOSED * low.distance(high) {
                self.line_to(self.start);
            }
            self.points.pop();
            self.end(true);
        }
        self.pen = self.start;
        added
    }

    /// Number of cubic segments so far.
    pub fn segment_count(&self) -> usize {
        self.segments
    }

    /// The paths, in the order in which they were begun; none of them if a coordinate is not finite.
    pub fn finish_finite(mut self) -> Option<Vec<VectorPath>> {
        self.end_open();
        (!self.overflowed).then_some(self.paths)
    }

    /// The paths, in the order in which they were begun; those with a coordinate that is not finite are left out.
    pub fn finish(mut self) -> Vec<VectorPath> {
        self.end_open();
        self.paths
    }

    fn end_open(&mut self) {
        if !self.points.is_empty() {
            self.end(false);
        }
    }

    fn end(&mut self, closed: bool) {
        let path = VectorPath::from_points(std::mem::take(&mut self.points), closed);
        self.overflowed |= path.is_none();
        self.paths.extend(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> DVec2 {
        DVec2::new(x, y)
    }

    #[test]
    fn arcs_lie_on_their_ellipse() {
        let (radii, rotation): (DVec2, f64) = (at(3.0, 2.0), 0.7);
        for (large, sweep) in [(false, false), (false, true), (true, false), (true, true)] {
            let mut builder = PathBuilder::default();
            builder.move_to(at(1.0, 1.0));
            assert_eq!(builder.arc_to(radii, rotation, large, sweep, at(2.0, 3.0)), Added::Drawn);
            let path = builder.finish().remove(0);
            assert_eq!(path.segment_count() > 2, large);
            // The centre from the first three points of the ellipse is the same from any others: all lie on one ellipse.
            let flat = |p: DVec2| DVec2::from_angle(-rotation).rotate(p) / radii;
            let on: Vec<DVec2> = (0..path.segment_count())
                .flat_map(|i| (0..8).map(move |k| (i, f64::from(k) / 8.0)))
                .map(|(i, t)| flat(path.point_at(i, t)))
                .collect();
            let (a, b, c) = (on[0], on[on.len() / 2], on[on.len() - 1]);
            let (ab, ac) = (b - a, c - a);
            let twice = 2.0 * ab.perp_dot(ac);
            let u = at(
                ac.y * ab.length_squared() - ab.y * ac.length_squared(),
                ab.x * ac.length_squared() - ac.x * ab.length_squared(),
            ) / twice;
            for p in &on {
                assert!((p.distance(a + u) - 1.0).abs() < 2e-3, "{large} {sweep} {}", p.distance(a + u));
            }
            // Sweep runs towards growing angles.
            assert_eq!((b - a).perp_dot(c - b) > 0.0, sweep);
        }
    }

    #[test]
    fn quarter_circle_is_off_by_what_is_said() {
        let mut builder = PathBuilder::default();
        builder.move_to(at(1.0, 0.0));
        builder.arc_to(at(1.0, 1.0), 0.0, false, true, at(0.0, 1.0));
        let path = builder.finish().remove(0);
        assert_eq!(path.segment_count(), 1);
        let worst =
            (0..=100).map(|i| (path.point_at(0, f64::from(i) / 100.0).length() - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 2.8e-4 && worst > 2e-4, "{worst}");
    }

    #[test]
    fn radii_that_are_too_small_grow() {
        let mut builder = PathBuilder::default();
        builder.move_to(DVec2::ZERO);
        builder.arc_to(at(0.1, 0.1), 0.0, false, true, at(2.0, 0.0));
        let path = builder.finish().remove(0);
        assert_eq!(path.segment_count(), 2);
        assert!(path.points()[3].distance(at(1.0, -1.0)) < 1e-12, "{}", path.points()[3]);
    }

    #[test]
    fn closing_adds_a_line_only_where_there_is_a_gap() {
        let mut builder = PathBuilder::default();
        builder.move_to(DVec2::ZERO);
        builder.line_to(at(3.0, 0.0));
        builder.line_to(at(3.0, 3.0));
        assert_eq!(builder.close(), Added::Drawn);
        // The next path begins where the last one did.
        assert_eq!(builder.line_to(at(0.0, 1.0)), Added::Drawn);
        assert_eq!(builder.line_to(DVec2::ZERO), Added::Drawn);
        assert_eq!(builder.line_to(DVec2::ZERO), Added::NoLength);
        assert_eq!(builder.close(), Added::Drawn);
        assert_eq!(builder.close(), Added::NoLength);
        let paths = builder.finish();
        assert_eq!(
            paths.iter().map(|p| (p.segment_count(), p.is_closed())).collect::<Vec<_>>(),
            [(3, true), (2, true)]
        );
    }

    #[test]
    fn quadratics_keep_their_curve() {
        let mut builder = PathBuilder::default();
        builder.move_to(DVec2::ZERO);
        builder.quadratic_to(at(1.0, 2.0), at(3.0, 0.0));
        let path = builder.finish().remove(0);
        for i in 0..=4 {
            let t = f64::from(i) / 4.0;
            let exact = at(1.0, 2.0) * (2.0 * t * (1.0 - t)) + at(3.0, 0.0) * (t * t);
            assert!(path.point_at(0, t).distance(exact) < 1e-14);
        }
    }
}
