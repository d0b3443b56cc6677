//! Geodesic curvature along a trace.

use super::{
    SplineT, Trace,
    average::{Averager, Span},
};
use crate::geodesic::{PathFinder, PathQuality, inner::InnerPath};
use crate::surface::Surface;

impl Trace {
    /// Distance along the trace at a parameter, clamped to it; none for an empty trace, or NaN.
    pub fn distance_at(&self, t: SplineT) -> Option<f64> {
        let (segment, local) = t.split(self.segments().len())?;
        let before: f64 = self.segments()[..segment].iter().map(|s| s.length()).sum();
        let here = &self.segments()[segment];
        let last = here.paths().len().checked_sub(1)?;
        let i = here.parameters().partition_point(|p| *p <= local).saturating_sub(1).min(last);
        let [from, to] = [here.parameters()[i], here.parameters()[i + 1]];
        let share = if to > from { ((local - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        let paths: f64 = here.paths()[..i].iter().map(|path| path.length()).sum();
        Some(before + paths + share * here.paths()[i].length())
    }

    /// Geodesic curvature near a parameter, as three places of the trace a step apart show it: positive where it turns left
    /// as seen against the normal. None for an empty trace, another surface, or a step that is not positive.
    ///
    /// A mesh is flat in its faces and curved at its vertices, so a step should span a few edges
    /// ([`Surface::mean_edge_length`]); the error is of the order of the step, and the trace's geodesics should be shorter
    /// than it. Near the ends of an open trace the nearest place that has a step to either side counts; a trace that ends
    /// where it begins goes on there. The curve's own second derivative is [`Spline::curve_point`](super::Spline::curve_point).
    ///
    /// With a and b the lengths of the two ways and φ the turn between them: 2 φ/(a + b).
    ///
    /// Cost: two short paths.
    pub fn curvature_at(&self, surface: &Surface, finder: &mut PathFinder, t: SplineT, step: f64) -> Option<f64> {
        let along = self.distance_at(t)?;
        let length = self.length();
        if step <= 0.0 || !step.is_finite() || length <= 0.0 {
            return None;
        }
        let [first, last] = [self.at_distance(surface, 0.0)?, self.at_distance(surface, length)?];
        let returns = surface.same_place(&first, &last);
        let step = step.min(0.5 * length);
        let middle = if returns { along } else { along.clamp(step, length - step) };
        let place = |d: f64| {
            let d = if returns { d.rem_euclid(length) } else { d };
            surface.inner_point(&self.at_distance(surface, d)?).ok()
        };
        let [a, b, c] = [place(middle - step)?, place(middle)?, place(middle + step)?];
        let mut averager = Averager { surface, finder, quality: PathQuality::Default };
        let [into, out]: [InnerPath; 2] = [averager.leg(&a, &b).ok()?, averager.leg(&b, &c).ok()?];
        let turn = averager.turn(Span::whole(&into), Span::whole(&out));
        let ways = into.length + out.length;
        (ways > 0.0).then(|| 2.0 * turn / ways)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{Scheme, Spline, TraceWorkspace};
    use crate::surface::{SurfaceOptions, TriangleMesh, shapes};
    use glam::DVec3;

    fn circle(mesh: &TriangleMesh, at: impl Fn(f64) -> DVec3) -> (Surface, Trace) {
        let surface = Surface::build(mesh, &SurfaceOptions::default()).unwrap();
        let points: Vec<_> = (0..12)
            .map(|k| surface.closest_point(at(f64::from(k) / 12.0 * std::f64::consts::TAU)).unwrap().point)
            .collect();
        let mut workspace = TraceWorkspace::default();
        let spline = Spline::smooth_through(&surface, &mut workspace.finder, &points, true).unwrap();
        let trace = spline.with_scheme(Scheme::de_casteljau().with_levels(6)).trace(&surface, &mut workspace, None);
        (surface, trace.unwrap())
    }

    #[test]
    fn circles_in_the_plane_and_on_the_sphere() {
        let mut finder = PathFinder::new();
        let (plane, flat) =
            circle(&shapes::grid(30, 30, 2.0, 2.0), |a| DVec3::new(1.0 + 0.5 * a.cos(), 1.0 + 0.5 * a.sin(), 0.0));
        // A circle of latitude, 40° from the pole: 1/tan.
        let polar = 40_f64.to_radians();
        let (sphere, round) =
            circle(&shapes::icosphere(6), |a| DVec3::new(polar.sin() * a.cos(), polar.sin() * a.sin(), polar.cos()));
        for (surface, trace, expected) in [(&plane, &flat, 2.0), (&sphere, &round, 1.0 / polar.tan())] {
            for k in 0..24 {
                let t = SplineT(f64::from(k) / 2.0);
                let found = trace.curvature_at(surface, &mut finder, t, 0.15).unwrap();
                assert!((found - expected).abs() < 0.1 * expected, "{t:?} {found} for {expected}");
            }
        }
        assert!(flat.curvature_at(&plane, &mut finder, SplineT(1.0), 0.0).is_none());
        assert!(flat.curvature_at(&plane, &mut finder, SplineT(f64::NAN), 0.1).is_none());
        assert!(Trace::default().curvature_at(&plane, &mut finder, SplineT(0.0), 0.1).is_none());
    }

    #[test]
    fn distances_belong_to_parameters() {
        let (surface, trace) = circle(&shapes::icosphere(5), |a| DVec3::new(a.cos(), a.sin(), 0.3 * (2.0 * a).sin()));
        for k in 0..=60 {
            let t = SplineT(f64::from(k) / 5.0);
            let [by_parameter, by_distance] =
                [trace.point_at(&surface, t), trace.at_distance(&surface, trace.distance_at(t).unwrap())]
                    .map(|p| surface.position(&p.unwrap()));
            assert!(by_parameter.distance(by_distance) < 1e-12, "{t:?}");
        }
    }
}
