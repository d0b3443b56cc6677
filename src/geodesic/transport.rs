//! Logarithmic map and parallel transport along a path.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::{
    GeodesicPath, PathError,
    inner::InnerPath,
    tangent::{
        InnerTangent, Tangent, angle_before, angle_between, lay, over_hinge, settle, side_direction, spell_in, turn_at,
        unit,
    },
};
use crate::surface::{HalfEdge, InnerPoint, PointError, Surface, SurfacePoint, Zeros};

impl Surface {
    /// Logarithmic map: initial direction of the shortest path, with its length.
    ///
    /// Walking along it leads back to `to`, unless the path bends at a vertex: keep the path where that matters.
    ///
    /// # Errors
    /// As [`PathFinder::shortest`](super::PathFinder::shortest).
    pub fn log(&self, from: &SurfacePoint, to: &SurfacePoint) -> Result<Tangent, PathError> {
        let path = self.shortest_path(from, to)?;
        Ok(path.initial_tangent(self)?)
    }

    /// Carries a tangent vector from the start of a path to its end by parallel transport.
    ///
    /// Between vertices the angle to the path is kept. At a vertex with angles β on either side, summing to θ, the path
    /// turns left by (2π/θ)(β_right − θ/2) and the vector keeps its direction (at the boundary: in the unfolded strip).
    ///
    /// # Errors
    /// [`PointError`] if path or tangent do not belong to the surface.
    pub fn transport(&self, path: &GeodesicPath, tangent: &Tangent) -> Result<Tangent, PointError> {
        let (_, tangent) = self.inner_tangent_at(&path.start, tangent)?;
        let path = InnerPath::from_outer(self, path)?;
        Ok(self.outer_tangent(&transport(self, &path, &tangent)))
    }
}

impl GeodesicPath {
    /// Direction at the start, with the path's length; zero for a path of no length.
    ///
    /// # Errors
    /// [`PointError`] if the path does not belong to the surface.
    pub fn initial_tangent(&self, surface: &Surface) -> Result<Tangent, PointError> {
        let inner = InnerPath::from_outer(surface, self)?;
        let mut tangent = initial_direction(surface, &inner);
        tangent.vector *= inner.length;
        Ok(surface.outer_tangent(&tangent))
    }
}

/// Unit direction at the start of a path, in the frame of its first face; zero if it has no length.
pub(crate) fn initial_direction(surface: &Surface, path: &InnerPath) -> InnerTangent {
    InnerTangent { face: path.start.face, vector: direction_from(surface, path, 0) }
}

/// Unit direction at the end of a path, in the frame of its last face; zero if it has no length.
pub(crate) fn final_direction(surface: &Surface, path: &InnerPath) -> InnerTangent {
    InnerTangent { face: path.end.face, vector: direction_to(surface, path, path.stretches() - 1) }
}

/// Stretches shorter than this share of their face's longest side have no direction to trust; the line is followed further.
const FAR_ENOUGH: f64 = 1e-3;

/// The same where the path bends at a vertex: a bend nearer than this may be on the wrong side of it, which costs less than
/// rounding.
const FAR_TO_BEND: f64 = 1e-6;

/// Unit direction in which a path leaves the beginning of a stretch, in the frame of that stretch's face.
///
/// The faces ahead are unfolded until the line is long enough or bends at a vertex.
pub(crate) fn direction_from(surface: &Surface, path: &InnerPath, stretch: usize) -> DVec2 {
    let begin = lay(&surface.flat(path.face(stretch)), &path.entry(surface, stretch));
    let mut unfolding = Unfolding::default();
    let mut along = DVec2::ZERO;
    for i in stretch..path.stretches() {
        let end = unfolding.place(lay(&surface.flat(path.face(i)), &path.exit(i)));
        along = end - begin;
        let bends = i < path.strip.len() && vertex_of(surface, path, i).is_some();
        if is_far(surface, path, i, along, bends) || i >= path.strip.len() {
            break;
        }
        unfolding.step(surface, path.strip[i]);
    }
    unit(along)
}

/// Unit direction in which a path arrives at the end of a stretch, in the frame of that stretch's face.
pub(crate) fn direction_to(surface: &Surface, path: &InnerPath, stretch: usize) -> DVec2 {
    let end = lay(&surface.flat(path.face(stretch)), &path.exit(stretch));
    let mut unfolding = Unfolding::default();
    let mut along = DVec2::ZERO;
    for i in (0..=stretch).rev() {
        let begin = unfolding.place(lay(&surface.flat(path.face(i)), &path.entry(surface, i)));
        along = end - begin;
        let Some(before) = i.checked_sub(1) else { break };
        let bends = vertex_of(surface, path, before).is_some();
        if is_far(surface, path, i, along, bends) {
            break;
        }
        unfolding.step(surface, surface.twin(path.strip[before]));
    }
    unit(along)
}

fn is_far(surface: &Surface, path: &InnerPath, i: usize, along: DVec2, bends: bool) -> bool {
    let longest = surface.lengths[path.face(i) as usize].iter().fold(0.0_f64, |m, l| m.max(*l));
    along.length() > longest * if bends { FAR_TO_BEND } else { FAR_ENOUGH }
}

/// Lays the frames of consecutive faces into the frame of the first.
struct Unfolding {
    turn: DVec2,
    shift: DVec2,
}

impl Default for Unfolding {
    fn default() -> Self {
        Self { turn: DVec2::X, shift: DVec2::ZERO }
    }
}

impl Unfolding {
    fn place(&self, p: DVec2) -> DVec2 {
        self.turn.rotate(p) + self.shift
    }

    /// Goes over side `h` to the face behind.
    fn step(&mut self, surface: &Surface, h: HalfEdge) {
        let (here, there) = (surface.flat(h.face()), surface.flat(surface.twin(h).face()));
        let twin = surface.twin(h);
        let (from, to) = (-side_direction(&there, twin), side_direction(&here, h));
        let hinge = DVec2::new(from.dot(to), from.perp_dot(to));
        let turn = self.turn.rotate(hinge);
        let origin = self.place(here[h.side()]);
        self.turn = turn;
        self.shift = origin - turn.rotate(there[twin.next().side()]);
    }
}

/// Parallel transport in inner spelling.
pub(crate) fn transport(surface: &Surface, path: &InnerPath, tangent: &InnerTangent) -> InnerTangent {
    let first = initial_direction(surface, path);
    if first.vector == DVec2::ZERO {
        return spelled_at(surface, &path.end, tangent);
    }
    // The angle from the path to the vector, counter-clockwise, as seen at the start.
    let mut angle = angle_at(surface, &path.start, &first, tangent);
    let mut i = 0;
    while i < path.strip.len() {
        match vertex_of(surface, path, i) {
            Some(vertex) => {
                let last = run_end(surface, path, i, vertex);
                angle -= turn_at_vertex(surface, path, i, last, vertex);
                i = last + 1;
            }
            None => i += 1,
        }
    }
    let last = final_direction(surface, path);
    let length = tangent.vector.length();
    let end = spell_in(surface, &path.end, last.face).unwrap_or(path.end);
    let ahead = InnerTangent { face: last.face, vector: last.vector * length };
    if end.zeros() != Zeros::None && matches!(end.zeros(), Zeros::Corner(_)) {
        // At a vertex angles count from the way back, which lies in the last face.
        let back = InnerTangent { face: last.face, vector: -ahead.vector };
        return turn_at(surface, &end, &back, angle + PI);
    }
    InnerTangent { face: last.face, vector: DVec2::from_angle(angle).rotate(ahead.vector) }
}

/// The vector spelled in a face around the point, unchanged if its own face is one.
fn spelled_at(surface: &Surface, at: &InnerPoint, tangent: &InnerTangent) -> InnerTangent {
    settle(surface, at, tangent).map_or(*tangent, |(_, settled)| settled)
}

/// Angle from one vector at a point counter-clockwise to another; at a vertex scaled so that a full turn is 2π.
pub(crate) fn angle_at(surface: &Surface, at: &InnerPoint, from: &InnerTangent, to: &InnerTangent) -> f64 {
    match at.zeros() {
        Zeros::Corner(k) => {
            let vertex = surface.triangles[at.face as usize][k as usize] as usize;
            match (star_angle(surface, at, from), star_angle(surface, at, to)) {
                (Some(a), Some(b)) if surface.boundary[vertex] => b - a,
                (Some(a), Some(b)) => (b - a) * TAU / surface.angle[vertex].max(f64::MIN_POSITIVE),
                // A vector that points over the boundary has no place among the faces, but it has in its frame.
                _ if from.face == to.face => angle_between(from.vector, to.vector),
                _ => 0.0,
            }
        }
        _ if from.face == to.face => angle_between(from.vector, to.vector),
        Zeros::Side(k) => {
            // The vectors lie in the two faces at this hinge.
            let h = HalfEdge::new(at.face, k);
            let back = if to.face == h.face() { h } else { surface.twin(h) };
            if !back.is_some() || !surface.twin(back).is_some() {
                return 0.0;
            }
            angle_between(from.vector, over_hinge(surface, back, to.vector))
        }
        Zeros::None => 0.0,
    }
}

/// Angle of a vector at a vertex from the vertex' first outgoing side, counter-clockwise along the faces.
fn star_angle(surface: &Surface, at: &InnerPoint, tangent: &InnerTangent) -> Option<f64> {
    let (p, settled) = settle(surface, at, tangent)?;
    let Zeros::Corner(k) = p.zeros() else { return None };
    let goal = HalfEdge::new(p.face, k);
    let corner = surface.corner_angle(goal);
    let inside = angle_between(side_direction(&surface.flat(p.face), goal), settled.vector);
    let inside = if inside > corner { if inside > 0.5 * (TAU + corner) { 0.0 } else { corner } } else { inside };
    Some(angle_before(surface, goal)? + inside)
}

/// The vertex at which crossing `i` lies, if it lies at one.
fn vertex_of(surface: &Surface, path: &InnerPath, i: usize) -> Option<u32> {
    let h = path.strip[i];
    match path.at[i] {
        0.0 => Some(surface.origin(h)),
        1.0 => Some(surface.target(h)),
        _ => None,
    }
}

/// Last crossing of the run at a vertex that begins with crossing `first`.
fn run_end(surface: &Surface, path: &InnerPath, first: usize, vertex: u32) -> usize {
    let mut last = first;
    while last + 1 < path.strip.len() && vertex_of(surface, path, last + 1) == Some(vertex) {
        last += 1;
    }
    last
}

/// By how much a path turns left at a vertex it passes.
fn turn_at_vertex(surface: &Surface, path: &InnerPath, first: usize, last: usize, vertex: u32) -> f64 {
    let on_left = path.at[first] == 1.0;
    // Angle on the side where the strip runs: a part of the first face, whole corners between, a part of the last face.
    let part = |h: HalfEdge, other: &InnerPoint| {
        let flat = surface.flat(h.face());
        let k = if surface.origin(h) == vertex { h.side() } else { h.next().side() };
        let far = if surface.origin(h) == vertex { h.next().side() } else { h.side() };
        let (a, b) = (flat[far] - flat[k], lay(&flat, other) - flat[k]);
        a.perp_dot(b).abs().atan2(a.dot(b))
    };
    let mut strip_side = part(path.strip[first], &path.entry(surface, first));
    for h in &path.strip[first + 1..=last] {
        let corner = if surface.origin(*h) == vertex { *h } else { h.next() };
        strip_side += surface.corner_angle(corner);
    }
    strip_side += part(surface.twin(path.strip[last]), &path.exit(last + 1));
    let total = surface.angle[vertex as usize];
    let right = if on_left { strip_side } else { total - strip_side };
    if surface.boundary[vertex as usize] {
        if on_left { strip_side - PI } else { PI - strip_side }
    } else {
        TAU / total.max(f64::MIN_POSITIVE) * (right - 0.5 * total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesic::PathFinder;
    use crate::surface::{SurfaceOptions, TriangleMesh, shapes};
    use glam::DVec3;
    use std::f64::consts::FRAC_PI_2;

    fn built(mesh: &TriangleMesh) -> Surface {
        Surface::build(mesh, &SurfaceOptions::default()).unwrap()
    }

    /// Carries a vector around a closed chain of shortest paths and gives the angle it turned by, in (−π, π].
    fn holonomy(surface: &Surface, stops: &[DVec3]) -> f64 {
        let points: Vec<_> = stops.iter().map(|p| surface.closest_point(*p).unwrap().point).collect();
        let mut finder = PathFinder::new();
        let start = Tangent { face: points[0].face, vector: DVec2::new(0.6, 0.8) };
        let mut vector = start;
        for (i, p) in points.iter().enumerate() {
            let path = finder.shortest(surface, p, &points[(i + 1) % points.len()]).unwrap();
            vector = surface.transport(&path, &vector).unwrap();
            assert!((vector.length() - 1.0).abs() < 1e-12);
        }
        let at = surface.inner_point(&points[0]).unwrap();
        let [a, b] = [start, vector].map(|t| surface.inner_tangent(&t).unwrap());
        let angle = angle_at(surface, &at, &a, &b).rem_euclid(TAU);
        if angle > PI { angle - TAU } else { angle }
    }

    #[test]
    fn around_a_corner_of_the_cube() {
        let surface = built(&shapes::cube());
        // Counter-clockwise as seen from outside, around (1, 1, 1).
        let turn =
            holonomy(&surface, &[DVec3::new(1.0, 0.6, 0.7), DVec3::new(0.55, 1.0, 0.6), DVec3::new(0.7, 0.6, 1.0)]);
        assert!((turn - FRAC_PI_2).abs() < 1e-10, "{turn}");
    }

    #[test]
    fn around_an_octant_of_the_sphere() {
        let surface = built(&shapes::icosphere(5));
        // Away from vertices: the exact octant's corners are edge midpoints of the icosahedron.
        let tilt = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.1, 0.2, 0.3);
        let turn = holonomy(&surface, &[tilt * DVec3::X, tilt * DVec3::Y, tilt * DVec3::Z]);
        assert!((turn - FRAC_PI_2).abs() < 5e-3, "{turn}");
    }

    #[test]
    fn around_a_circle_of_colatitude() {
        let surface = built(&shapes::icosphere(5));
        let circle = |k: i32| {
            let a = f64::from(k) / 60.0 * TAU;
            DVec3::new(0.5_f64.sin() * a.cos(), 0.5_f64.sin() * a.sin(), 0.5_f64.cos())
        };
        let stops: Vec<_> = (0..60).map(circle).collect();
        // Inside a polygon of great circles there is a little less than inside the circle: 2π(1 − cos ½) = 0.76917.
        let turn = holonomy(&surface, &stops);
        assert!((turn - 0.769_171_448_5).abs() < 1e-2, "{turn}");
    }

    #[test]
    fn flat_loops_turn_nothing() {
        let surface = built(&shapes::grid(8, 8, 1.0, 1.0));
        for stops in [
            vec![DVec3::new(0.1, 0.1, 0.0), DVec3::new(0.9, 0.2, 0.0), DVec3::new(0.4, 0.95, 0.0)],
            // Over vertices: corners of cells.
            vec![DVec3::new(0.25, 0.25, 0.0), DVec3::new(0.75, 0.25, 0.0), DVec3::new(0.75, 0.75, 0.0)],
        ] {
            let turn = holonomy(&surface, &stops);
            assert!(turn.abs() < 1e-10, "{turn}");
        }
    }

    #[test]
    fn there_and_back_changes_nothing() {
        let surface = built(&shapes::torus(2.0, 0.8, 30, 14));
        let turn = holonomy(&surface, &[DVec3::new(2.5, 0.3, 0.4), DVec3::new(-1.2, 1.5, 0.1)]);
        assert!(turn.abs() < 1e-10, "{turn}");
        // From vertex to vertex.
        let turn = holonomy(&surface, &[surface.positions[5], surface.positions[170]]);
        assert!(turn.abs() < 1e-10, "{turn}");
    }

    #[test]
    fn log_then_exp_comes_home() {
        let surface = built(&shapes::torus(2.0, 0.8, 40, 20));
        let at = |p: DVec3| surface.closest_point(p).unwrap().point;
        let from = at(DVec3::new(2.6, 0.1, 0.3));
        for to in [DVec3::new(2.0, 1.5, 0.7), DVec3::new(1.0, 2.0, 0.5), DVec3::new(2.7, 0.3, -0.3)] {
            let to = at(to);
            let log = surface.log(&from, &to).unwrap();
            let end = surface.exp(&from, &log).unwrap().path.end();
            assert!(surface.position(&end).distance(surface.position(&to)) < 1e-9);
        }
    }
}
