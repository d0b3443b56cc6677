//! Ground truths of curves. Here: what the tests share.

mod adaptive;
mod b_splines;
mod comparison;
mod edits;
mod fitting;
mod jumps;
mod nasty;
mod plane;
mod schemes;
mod sphere;
mod splines;
mod transforms;

use glam::DVec3;

use super::Spline;
use crate::geodesic::{PathFinder, PathQuality};
use crate::surface::{Surface, SurfaceOptions, SurfacePoint, TriangleMesh, shapes};

pub(super) fn built(mesh: &TriangleMesh) -> Surface {
    Surface::build(mesh, &SurfaceOptions::default()).unwrap()
}

pub(super) fn at(surface: &Surface, p: DVec3) -> SurfacePoint {
    surface.closest_point(p).unwrap().point
}

pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }

    pub(super) fn in_square(&mut self) -> DVec3 {
        DVec3::new(0.02 + 0.96 * self.next(), 0.02 + 0.96 * self.next(), 0.0)
    }

    pub(super) fn on_sphere(&mut self) -> DVec3 {
        loop {
            let p = DVec3::new(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5);
            if (1e-3..0.25).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }
}

pub(super) fn bezier([a, b, c, d]: [DVec3; 4], t: f64) -> DVec3 {
    let s = 1.0 - t;
    s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d
}

/// A flat triangulation with jittered vertices.
pub(super) fn jittered_square(cells: u32) -> TriangleMesh {
    let mut mesh = shapes::grid(cells, cells, 1.0, 1.0);
    let mut random = Random(11);
    let step = 1.0 / f64::from(cells);
    for p in &mut mesh.positions {
        if p.x > 0.0 && p.x < 1.0 && p.y > 0.0 && p.y < 1.0 {
            *p += DVec3::new(random.next() - 0.5, random.next() - 0.5, 0.0) * 0.5 * step;
        }
    }
    mesh
}

pub(super) const S1: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 1.0, 1.0]];
pub(super) const S2: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.2, 1.0, 0.6], [0.0, 0.5, 1.0]];

/// Turns the figures away from the icosphere's mirror planes, in which rows of vertices push paths aside by a part of an
/// edge.
pub(super) fn tilted(p: [f64; 3]) -> DVec3 {
    glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.7, 0.4, 1.1) * DVec3::from(p).normalize()
}

pub(super) fn spline_on(surface: &Surface, points: &[DVec3], closed: bool) -> Spline {
    let points: Vec<_> = points.iter().map(|p| at(surface, *p)).collect();
    Spline::smooth_through(surface, &mut PathFinder::new(), &points, closed).unwrap()
}

/// Angle between the two handles' directions at an anchor, as the surface sees it.
pub(super) fn handle_angle(surface: &Surface, anchor: &super::Anchor) -> f64 {
    use crate::geodesic::transport::angle_at;
    let at = surface.inner_point(&anchor.point()).unwrap();
    let [a, b] = [anchor.outgoing(), anchor.incoming()].map(|h| surface.inner_tangent(&h.heading()).unwrap());
    angle_at(surface, &at, &a, &b).rem_euclid(std::f64::consts::TAU)
}
