//! A rough strip at once: from centre of face to centre of face, along one way on the graph of clusters.

use glam::DVec3;

use super::{
    corridor::Corridor,
    heap::Heap,
    search::Found,
    seen::{Seen, Visit},
};
use crate::surface::{HalfEdge, InnerPoint, Surface};

/// How much the way so far counts beside the way to go. Ways from centre to centre are too long by a tenth or more; counted in
/// full, that would make the search look at most of the corridor, for strips that are hardly better.
const SO_FAR: f64 = 0.5;

/// Scratch memory of guessing; linear in the faces looked at.
#[derive(Debug, Default)]
pub(crate) struct Guess {
    seen: Seen,
    heap: Heap,
}

impl Guess {
    /// Guesses a strip from `from` to `to`, which must lie on one sheet in different faces; `strip` receives the sides
    /// through which its faces are left, and `corridor` the clusters near it.
    ///
    /// Cost: 0.1 µs a face of the strip, and a few hundredths for each cluster that is nearer than the goal.
    pub(crate) fn run(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        to: &InnerPoint,
        corridor: &mut Corridor,
        strip: &mut Vec<HalfEdge>,
    ) -> Option<Found> {
        corridor.along_one_way(surface, from, to);
        self.heap.clear();
        self.seen.clear();
        self.seen.reach(from.face, HalfEdge::NONE, 0.0);
        self.heap.push(0.0, from.face);
        while let Some((_, face)) = self.heap.pop() {
            if face == to.face {
                self.trace_back(face, strip);
                return Some(Found { start: *from, end: *to });
            }
            if let Some(visit) = self.seen.close(face) {
                self.expand(surface, corridor, face, &visit);
            }
        }
        None
    }

    /// Reaches the neighbours of a face.
    fn expand(&mut self, surface: &Surface, corridor: &Corridor, face: u32, visit: &Visit) {
        let here = center(surface, face);
        for side in [0, 1, 2].map(|k| HalfEdge::new(face, k)) {
            let twin = surface.twin(side);
            if !twin.is_some() || twin == visit.came_by {
                continue;
            }
            let Some(aim) = corridor.aim(surface, twin.face()) else { continue };
            let there = center(surface, twin.face());
            let so_far = visit.so_far + here.distance(there);
            if self.seen.reach(twin.face(), side, so_far) {
                self.heap.push(SO_FAR * so_far + aim.from(there), twin.face());
            }
        }
    }

    /// The sides by which a face was come by from the start.
    fn trace_back(&self, goal: u32, strip: &mut Vec<HalfEdge>) {
        strip.clear();
        let mut face = goal;
        while let Some(side) = self.seen.came_by(face) {
            strip.push(side);
            face = side.face();
        }
        strip.reverse();
    }
}

fn center(surface: &Surface, face: u32) -> DVec3 {
    let [a, b, c] = surface.triangles[face as usize].map(|v| surface.positions[v as usize]);
    (a + b + c) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geodesic::{PathFinder, PathQuality},
        surface::{FaceId, SurfaceOptions, TriangleMesh, shapes},
    };

    fn built(mesh: &TriangleMesh) -> Surface {
        Surface::build(mesh, &SurfaceOptions::default()).unwrap()
    }

    /// A square with a slit from one side nearly to the other, so that the way leads away from the goal at first.
    fn slit() -> TriangleMesh {
        let mut mesh = shapes::grid(60, 60, 6.0, 6.0);
        let positions = mesh.positions.clone();
        mesh.faces.retain(|t| {
            let middle = t.iter().map(|v| positions[*v as usize]).sum::<DVec3>() / 3.0;
            !(middle.y > 2.9 && middle.y < 3.1 && middle.x < 5.5)
        });
        mesh
    }

    #[test]
    fn strips_lead_from_end_to_end() {
        for mesh in [shapes::torus(2.0, 0.7, 90, 40), shapes::icosphere(4), slit(), shapes::cube()] {
            let surface = built(&mesh);
            let faces = surface.triangles.len() as u32;
            let (mut guess, mut corridor, mut strip) = (Guess::default(), Corridor::default(), Vec::new());
            for i in 0..200_u32 {
                let [from, to] = [i * 389 % faces, (i * 1021 + 7) % faces];
                if from == to {
                    continue;
                }
                let [p, q] = [from, to].map(|face| InnerPoint { face, weights: [0.2, 0.3, 0.5] });
                let found = guess.run(&surface, &p, &q, &mut corridor, &mut strip).unwrap();
                assert_eq!((found.start, found.end, strip[0].face()), (p, q, from));
                assert!(strip.windows(2).all(|w| surface.twin(w[0]).face() == w[1].face()));
                assert_eq!(surface.twin(strip[strip.len() - 1]).face(), to);
                let mut again = Vec::new();
                Guess::default().run(&surface, &p, &q, &mut Corridor::default(), &mut again);
                assert_eq!(strip, again);
            }
        }
    }

    #[test]
    fn fast_paths_are_straight_on_a_plane_and_lead_around_slits() {
        let surface = built(&slit());
        let at = |x: f64, y: f64| surface.closest_point(DVec3::new(x, y, 0.0)).unwrap().point;
        let mut finder = PathFinder::new();
        let mut length = |a: (f64, f64), b: (f64, f64)| {
            let [a, b] = [a, b].map(|p| at(p.0, p.1));
            let path = finder.shortest_with_quality(&surface, &a, &b, PathQuality::Fast).unwrap();
            let back = finder.shortest_with_quality(&surface, &b, &a, PathQuality::Fast).unwrap();
            assert_eq!(path.length().to_bits(), back.length().to_bits());
            assert!(!path.is_frozen());
            path.length()
        };
        assert!((length((0.31, 0.22), (5.2, 2.83)) - 4.89_f64.hypot(2.61)).abs() < 1e-12);
        let corner = 5.5_f64.hypot(2.9);
        assert!((length((0.0, 0.0), (0.0, 6.0)) - (2.0 * corner + 0.2)).abs() < 1e-9);
    }

    #[test]
    fn fast_paths_on_a_sphere_are_nearly_shortest() {
        let surface = built(&shapes::icosphere(5));
        let faces = surface.face_count() as u32;
        let mut finder = PathFinder::new();
        for i in 1..100_u32 {
            let [p, q] = [i * 97, i * 3891].map(|f| surface.point(FaceId(f % faces), [0.2, 0.5, 0.3]).unwrap());
            let [a, b] = [&p, &q].map(|x| surface.position(x));
            let path = finder.shortest_with_quality(&surface, &p, &q, PathQuality::Fast).unwrap();
            assert!(path.length() < a.angle_between(b) * 1.01, "{} {}", path.length(), a.angle_between(b));
        }
    }
}
