//! Ground truths of smoothing. Here: what the tests share.

mod balance;
mod lines;
mod live;
mod modes;
mod shapes;

use glam::DVec3;

use super::{strip::Strip, *};
use crate::surface::{HalfEdge, InnerPoint, Surface, SurfaceOptions, SurfacePoint, TriangleMesh};

pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }
}

pub(super) fn built(mesh: &TriangleMesh) -> Surface {
    Surface::build(mesh, &SurfaceOptions::default()).unwrap()
}

pub(super) fn at(surface: &Surface, p: DVec3) -> SurfacePoint {
    surface.closest_point(p).unwrap().point
}

/// A random jagged line: a walk over faces that does not turn back at once.
pub(super) fn jagged(surface: &Surface, random: &mut Random, steps: usize) -> SurfacePolyline {
    let mut strip = Strip::default();
    let face = (random.word() % surface.triangles.len() as u64) as u32;
    let middle = |face| InnerPoint { face, weights: [1.0 / 3.0; 3] };
    strip.start = middle(face);
    let mut here = HalfEdge::new(face, 0);
    for step in 0..steps {
        let mut ways = vec![here.next(), here.prev()];
        ways.extend((step == 0).then_some(here));
        ways.retain(|h| surface.twin(*h).is_some());
        if ways.is_empty() {
            break;
        }
        let h = ways[(random.word() % ways.len() as u64) as usize];
        strip.push(surface, h, 0.1 + 0.8 * random.next(), 0.0, false);
        here = surface.twin(h);
    }
    strip.end = middle(here.face());
    SurfacePolyline::of(surface, strip).unwrap()
}

/// A closed line through positions in space, of shortest paths between the places nearest to them.
pub(super) fn ring(surface: &Surface, positions: impl IntoIterator<Item = DVec3>) -> SurfacePolyline {
    let points: Vec<_> = positions.into_iter().map(|p| at(surface, p)).collect();
    SurfacePolyline::through(surface, &mut crate::geodesic::PathFinder::new(), &points, true).unwrap()
}

/// Shifts crossings at random, so that the line trembles and no crossing is at a vertex.
pub(super) fn shaken(surface: &Surface, line: &SurfacePolyline, random: &mut Random, by: f64) -> SurfacePolyline {
    let mut strip = Strip::default();
    line.strip_into(surface, &mut strip).unwrap();
    for t in &mut strip.at {
        *t = (*t + by * (random.next() - 0.5)).clamp(0.02, 0.98);
    }
    SurfacePolyline::of(surface, strip).unwrap()
}
