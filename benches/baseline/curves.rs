//! Curves of the baseline, of nothing but shortest paths and points at shares of them.

use bevy_surface_splines::surface::SurfacePoint;

use super::{Baseline, Path};

/// The two uniform schemes that were recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Uniform {
    /// Open-uniform Lane–Riesenfeld subdivision, six levels: 67 points.
    LaneRiesenfeld,
    /// Recursive de Casteljau bisection, four levels: 16 polygons of four points.
    DeCasteljau,
}

impl Baseline {
    /// The points of a curve; none if a path is missing.
    pub(crate) fn curve(&mut self, polygon: &[SurfacePoint; 4], scheme: Uniform) -> Option<Vec<SurfacePoint>> {
        match scheme {
            Uniform::LaneRiesenfeld => {
                let mut points = polygon.to_vec();
                for _ in 0..6 {
                    points = self.subdivided(&points)?;
                }
                Some(points)
            }
            Uniform::DeCasteljau => {
                let mut polygons = vec![*polygon];
                for _ in 0..4 {
                    let halves = polygons.iter().map(|polygon| self.halved(polygon));
                    polygons = halves.collect::<Option<Vec<_>>>()?.into_iter().flatten().collect();
                }
                Some(polygons.into_iter().flatten().collect())
            }
        }
    }

    /// Length of the paths that join points in order.
    pub(crate) fn joined_length(&mut self, points: &[SurfacePoint]) -> Option<f64> {
        points.windows(2).map(|pair| self.path(&pair[0], &pair[1]).map(|path| path.length())).sum()
    }

    fn middle(&mut self, a: &SurfacePoint, b: &SurfacePoint) -> Option<SurfacePoint> {
        let path = self.path(a, b)?;
        Some(self.at(&path, 0.5))
    }

    /// Both halves of a cubic polygon by de Casteljau's construction.
    fn halved(&mut self, [p0, p1, p2, p3]: &[SurfacePoint; 4]) -> Option<[[SurfacePoint; 4]; 2]> {
        let (q0, q1, q2) = (self.middle(p0, p1)?, self.middle(p1, p2)?, self.middle(p2, p3)?);
        let (r0, r1) = (self.middle(&q0, &q1)?, self.middle(&q1, &q2)?);
        let s = self.middle(&r0, &r1)?;
        Some([[*p0, q0, r0, s], [s, r1, q2, *p3]])
    }

    /// The next level of open-uniform cubic subdivision, which depends on the number of intervals there are.
    fn subdivided(&mut self, points: &[SurfacePoint]) -> Option<Vec<SurfacePoint>> {
        let intervals = points.len() - 3;
        let legs: Vec<Path> = points.windows(2).map(|pair| self.path(&pair[0], &pair[1])).collect::<Option<_>>()?;
        let on = |this: &Self, leg: usize, share: f64| this.at(&legs[leg], share);
        let between = |this: &mut Self, leg: usize, from: f64, to: f64| {
            let (a, b) = (this.at(&legs[leg], from), this.at(&legs[leg + 1], to));
            this.middle(&a, &b)
        };
        let (first, last) = (points[0], *points.last()?);
        let mut out = vec![first];
        match intervals {
            1 => out.extend([0, 1, 2].map(|leg| on(self, leg, 0.5))),
            2 => {
                out.extend([on(self, 0, 0.5), on(self, 1, 0.25)]);
                out.push(between(self, 1, 0.625, 0.375)?);
                out.extend([on(self, 2, 0.75), on(self, 3, 0.5)]);
            }
            n => {
                out.extend([on(self, 0, 0.5), on(self, 1, 0.25)]);
                out.push(between(self, 1, 0.625, 0.25)?);
                for j in 2..n {
                    out.push(on(self, j, 0.5));
                    if j < n - 1 {
                        out.push(between(self, j, 0.75, 0.25)?);
                    }
                }
                out.push(between(self, n - 1, 0.75, 0.375)?);
                out.extend([on(self, n, 0.75), on(self, n + 1, 0.5)]);
            }
        }
        out.push(last);
        Some(out)
    }
}
