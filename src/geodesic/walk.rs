//! Straightest paths: walking straight ahead (Polthier & Schmies 1998).

use glam::DVec2;

use super::{
    GeodesicPath,
    inner::{InnerPath, between},
    tangent::{InnerTangent, Tangent, angle_between, fan_out, lay, over_hinge, settle, side_direction, unit},
};
use crate::surface::{HalfEdge, InnerPoint, PointError, Surface, SurfacePoint};

/// A crossing this close to an end of its side (as a share of it) counts as the vertex: well above the rounding of a walk
/// over a thousand faces, well below what a person can aim at.
const AT_VERTEX: f64 = 1e-9;
/// … but only if the line passes it by less than this share of its way through the face: who starts a hair beside a vertex
/// does not run into it.
const HEAD_ON: f64 = 1e-6;
/// No walk takes more steps than this.
const MAX_STEPS: f64 = 1e6;

/// What ended a walk early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WalkStop {
    /// It ran into the boundary, or into a vertex on the boundary, where straight ahead is not defined.
    Boundary,
    /// It took as many steps as the mesh lets one expect: eight for each mean edge of its length and four for each face,
    /// and at most a million.
    StepLimit,
}

/// A straightest path and where it led.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// The path walked; its length is the distance travelled.
    pub path: GeodesicPath,
    /// The direction at its end, of unit length.
    pub heading: Tangent,
    /// What ended it early, if anything did.
    pub stopped: Option<WalkStop>,
}

/// A walk in inner spelling.
pub(crate) struct InnerWalk {
    pub(crate) path: InnerPath,
    pub(crate) heading: InnerTangent,
    pub(crate) stopped: Option<WalkStop>,
}

impl Surface {
    /// Walks straight ahead: over sides along the unfolded line, through a vertex so that the angles left and right are
    /// equal.
    ///
    /// `heading` gives the direction (its length does not matter), `distance` is in local units. The result is straightest,
    /// not shortest: past a cone's tip there are shorter ways. A heading of zero length stays where it is.
    ///
    /// Cost: about 50 ns a face crossed.
    ///
    /// # Errors
    /// [`PointError`] if point or heading do not belong to the surface, or the distance is not finite.
    ///
    /// ```
    /// use bevy_surface_splines::surface::{FaceId, Surface, SurfaceOptions, shapes};
    /// use glam::{DVec2, DVec3};
    ///
    /// let surface = Surface::build(&shapes::grid(10, 10, 1.0, 1.0), &SurfaceOptions::default())?;
    /// let start = surface.closest_point(DVec3::new(0.1, 0.1, 0.0)).unwrap().point;
    /// let ahead = surface.tangent(&start, DVec3::new(3.0, 4.0, 0.0))?;
    /// let walk = surface.walk(&start, &ahead, 0.5)?;
    /// assert!(surface.position(&walk.path.end()).distance(DVec3::new(0.4, 0.5, 0.0)) < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn walk(&self, from: &SurfacePoint, heading: &Tangent, distance: f64) -> Result<Walk, PointError> {
        if !distance.is_finite() {
            return Err(PointError::NotFinite("the distance", from.face));
        }
        let (from, heading) = self.inner_tangent_at(from, heading)?;
        let walk = walk(self, &from, &heading, distance);
        Ok(Walk { path: walk.path.to_outer(self), heading: self.outer_tangent(&walk.heading), stopped: walk.stopped })
    }

    /// Exponential map: walks along a tangent vector for its length.
    ///
    /// # Errors
    /// As [`walk`](Self::walk).
    pub fn exp(&self, from: &SurfacePoint, tangent: &Tangent) -> Result<Walk, PointError> {
        self.walk(from, tangent, tangent.length())
    }
}

/// Walks straight ahead, in inner spelling. A negative distance counts as zero.
pub(crate) fn walk(surface: &Surface, from: &InnerPoint, heading: &InnerTangent, distance: f64) -> InnerWalk {
    walk_in(surface, from, heading, distance, InnerPath::default())
}

/// [`walk`] in the memory of some path.
pub(crate) fn walk_in(
    surface: &Surface,
    from: &InnerPoint,
    heading: &InnerTangent,
    distance: f64,
    mut path: InnerPath,
) -> InnerWalk {
    path.set_straight(surface, *from, *from);
    let heading = InnerTangent { face: heading.face, vector: unit(heading.vector) };
    if heading.vector == DVec2::ZERO || distance <= 0.0 {
        return InnerWalk { path, heading, stopped: None };
    }
    let Some((start, heading)) = settle(surface, from, &heading) else {
        return InnerWalk { path, heading, stopped: Some(WalkStop::Boundary) };
    };
    (path.start, path.end) = (start, start);
    let mut walker = Walker { surface, path, at: start, direction: heading.vector, entered: None, rest: distance };
    let mut stopped = Some(WalkStop::StepLimit);
    let mean = surface.mean_edge[surface.sheet[start.face as usize] as usize];
    let steps = 1000.0 + 4.0 * surface.triangles.len() as f64 + 8.0 * distance / mean.max(f64::MIN_POSITIVE);
    for _ in 0..steps.min(MAX_STEPS) as usize {
        match walker.step() {
            Step::Crossed => {}
            Step::Arrived => {
                stopped = None;
                break;
            }
            Step::Blocked => {
                stopped = Some(WalkStop::Boundary);
                break;
            }
        }
    }
    let Walker { mut path, at, direction, .. } = walker;
    path.end = at;
    path.measure(surface);
    InnerWalk { path, heading: InnerTangent { face: at.face, vector: direction }, stopped }
}

enum Step {
    Crossed,
    Arrived,
    Blocked,
}

struct Walker<'s> {
    surface: &'s Surface,
    path: InnerPath,
    at: InnerPoint,
    /// Unit direction in the frame of `at`'s face.
    direction: DVec2,
    /// The side through which the face was entered.
    entered: Option<HalfEdge>,
    rest: f64,
}

impl Walker<'_> {
    /// Goes through one face, to its far side or to the end.
    fn step(&mut self) -> Step {
        let flat = self.surface.flat(self.at.face);
        let here = lay(&flat, &self.at);
        // Positive: the corner lies to the left of the line ahead.
        let left = flat.map(|corner| self.direction.perp_dot(corner - here));
        let side = self.exit_side(&left);
        let (s0, s1) = (left[side.side()], left[side.next().side()]);
        let t = if s1 > s0 { (-s0 / (s1 - s0)).clamp(0.0, 1.0) } else { 0.5 };
        let exit = InnerPoint::on_side(side, t);
        let ahead = (lay(&flat, &exit) - here).dot(self.direction).max(0.0);
        if ahead >= self.rest {
            let share = if ahead > 0.0 { self.rest / ahead } else { 0.0 };
            self.at = between(&self.at, &exit, share);
            self.rest = 0.0;
            return Step::Arrived;
        }
        self.rest -= ahead;
        if t < AT_VERTEX && s0.abs() <= HEAD_ON * ahead {
            return self.through_vertex(side, &flat);
        }
        if t > 1.0 - AT_VERTEX && s1.abs() <= HEAD_ON * ahead {
            return self.through_vertex(side.next(), &flat);
        }
        self.at = exit;
        let Some(there) = self.surface.across(&exit, side) else { return Step::Blocked };
        self.direction = over_hinge(self.surface, side, self.direction).normalize_or(DVec2::X);
        self.path.strip.push(side);
        self.path.at.push(t);
        self.entered = Some(self.surface.twin(side));
        self.at = there;
        Step::Crossed
    }

    /// The side ahead: its origin lies to the right of the line, its target to the left. Signs alone decide, so that a line
    /// through a corner never finds a gap.
    fn exit_side(&self, left: &[f64; 3]) -> HalfEdge {
        if let Some(entered) = self.entered {
            let apex = entered.prev();
            return if left[apex.side()] > 0.0 { entered.next() } else { apex };
        }
        let sides = [0, 1, 2].map(|k| HalfEdge::new(self.at.face, k));
        // From a corner only the opposite side lies ahead; from a side one of the other two.
        let away = |h: &HalfEdge| self.at.weights[h.prev().side()] > 0.0;
        let straddles = |h: &HalfEdge| left[h.side()] <= 0.0 && left[h.next().side()] >= 0.0;
        let widest = |a: &HalfEdge, b: &HalfEdge| {
            let span = |h: &HalfEdge| left[h.next().side()] - left[h.side()];
            span(a).total_cmp(&span(b))
        };
        let ahead = sides.into_iter().filter(|h| away(h) && straddles(h)).max_by(widest);
        ahead.unwrap_or_else(|| sides.into_iter().filter(away).max_by(widest).unwrap_or(sides[0]))
    }

    /// Goes through the vertex at the origin of `h`, halving its angle.
    fn through_vertex(&mut self, h: HalfEdge, flat: &[DVec2; 3]) -> Step {
        let surface = self.surface;
        self.at = InnerPoint::on_side(h, 0.0);
        let vertex = surface.origin(h);
        if surface.boundary[vertex as usize] {
            return Step::Blocked;
        }
        let corner = surface.corner_angle(h);
        // Where the way back lies in this corner; rounding may put it just outside.
        let mut back = angle_between(side_direction(flat, h), -self.direction);
        if back > corner {
            back = if back - corner < std::f64::consts::TAU - back { corner } else { 0.0 };
        }
        let ahead = back + 0.5 * surface.angle[vertex as usize];
        let Some((there, heading)) = fan_out(surface, h, ahead, 1.0) else { return Step::Blocked };
        // The strip turns counter-clockwise about the vertex, through sides that end there: a whole turn if the line comes
        // back into its face, since only a crossing can bend.
        let mut spoke = h;
        loop {
            self.path.strip.push(spoke.prev());
            self.path.at.push(1.0);
            spoke = surface.counter_clockwise(spoke);
            if spoke.face() == there.face || spoke == h {
                break;
            }
        }
        self.at = there;
        self.direction = heading.vector;
        self.entered = None;
        Step::Crossed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{SurfaceOptions, TriangleMesh, shapes};
    use glam::DVec3;
    use std::f64::consts::{FRAC_PI_4, TAU};

    fn built(mesh: &TriangleMesh) -> Surface {
        Surface::build(mesh, &SurfaceOptions::default()).unwrap()
    }

    fn go(surface: &Surface, from: DVec3, direction: DVec3, distance: f64) -> Walk {
        let start = surface.closest_point(from).unwrap().point;
        surface.walk(&start, &surface.tangent(&start, direction).unwrap(), distance).unwrap()
    }

    #[test]
    fn plane_is_exact_also_through_vertices() {
        let surface = built(&shapes::grid(10, 10, 1.0, 1.0));
        for (from, to) in [
            ((0.05, 0.07), (0.93, 0.81)),
            ((0.1, 0.1), (0.9, 0.9)),
            ((0.2, 0.3), (0.2, 0.9)),
            ((0.15, 0.3), (0.85, 0.3)),
        ] {
            let [from, to] = [from, to].map(|(x, y)| DVec3::new(x, y, 0.0));
            let walk = go(&surface, from, to - from, from.distance(to));
            assert!(surface.position(&walk.path.end()).distance(to) < 1e-13, "{from} {to}");
            assert!(walk.stopped.is_none());
            assert!((surface.tangent_in_space(&walk.heading).unwrap() - (to - from).normalize()).length() < 1e-12);
        }
        let walk = go(&surface, DVec3::new(0.5, 0.5, 0.0), DVec3::new(1.0, 0.3, 0.0), 9.0);
        assert_eq!(walk.stopped, Some(WalkStop::Boundary));
        assert!((surface.position(&walk.path.end()) - DVec3::new(1.0, 0.65, 0.0)).length() < 1e-12);
    }

    #[test]
    fn torus_end_points() {
        let surface = built(&shapes::torus(2.0, 1.0, 720, 360));
        for (angle, end) in [
            (0.0, [1.620_906_917_6, 2.524_412_954_4, 0.0]),
            (0.3, [1.540_153_393_3, 2.420_163_649_1, 0.495_392_108_6]),
            (FRAC_PI_4, [1.110_489_986_9, 1.807_472_946_5, 0.992_609_186_3]),
            (1.2, [0.780_366_172_2, 0.958_726_215_1, 0.645_422_775_0]),
        ] {
            let (sin, cos) = f64::sin_cos(angle);
            // The start is a vertex, where a face's plane is not the tangent plane: begin a little inside a face.
            let walk = go(&surface, DVec3::new(3.0, 1e-7, 2e-7), DVec3::new(0.0, cos, sin), 3.0);
            let off = surface.position(&walk.path.end()).distance(DVec3::from(end));
            assert!(off < 1e-3, "{angle}: {off}");
        }
    }

    #[test]
    fn once_around_the_sphere() {
        let surface = built(&shapes::icosphere(6));
        let start = DVec3::new(0.36, 0.48, 0.8);
        let walk = go(&surface, start, DVec3::new(0.8, -0.6, 0.0), TAU);
        let off = surface.position(&walk.path.end()).distance(start);
        assert!(off < 1e-3, "{off}");
    }

    #[test]
    fn there_and_back_through_vertices_too() {
        let surface = built(&shapes::icosphere(4));
        let mut state = 3_u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut left_out = 0;
        for i in 0..200 {
            let walk = if i % 4 == 0 {
                // From a vertex along a side to the next vertex, and on through that.
                let h = surface.outgoing[i];
                let vector = side_direction(&surface.flat(h.face()), h);
                let heading = surface.outer_tangent(&InnerTangent { face: h.face(), vector });
                surface.walk(&surface.outer_point(&InnerPoint::on_side(h, 0.0)), &heading, 2.0).unwrap()
            } else {
                let start = DVec3::new(random(), random(), random()).normalize();
                go(&surface, start, DVec3::new(random(), random(), random()), 2.0)
            };
            let back = surface.opposite(&walk.path.end(), &walk.heading).unwrap();
            let home = surface.walk(&walk.path.end(), &back, 2.0).unwrap();
            let off = surface.position(&home.path.end()).distance(surface.position(&walk.path.start()));
            // Whether a crossing 1e-9 from a vertex counts as the vertex is for rounding to decide, either way.
            let undecided = |c: &crate::geodesic::Crossing| (1e-10..1e-8).contains(&c.at.min(1.0 - c.at));
            if walk.path.crossings().iter().chain(home.path.crossings()).any(undecided) {
                left_out += 1;
                continue;
            }
            assert!(off < 1e-10, "{i}: {off}");
            assert!((walk.path.length() - 2.0).abs() < 1e-12);
        }
        assert!(left_out < 5, "{left_out}");
    }

    #[test]
    fn tip_of_a_cone_halves_the_angle() {
        let surface = built(&shapes::cone(24, 3, 0.6));
        let spoke = |k: f64| {
            DVec3::new((TAU * k / 24.0).cos() * 0.6_f64.sin(), (TAU * k / 24.0).sin() * 0.6_f64.sin(), 0.6_f64.cos())
        };
        let from = spoke(4.0);
        let walk = go(&surface, from, -from, 2.0);
        assert!(surface.position(&walk.path.end()).distance(spoke(16.0)) < 1e-9);
    }

    #[test]
    fn steps_are_refused_where_nothing_is_to_be_walked() {
        let surface = built(&shapes::cube());
        let start = surface.closest_point(DVec3::new(0.3, 0.2, 0.0)).unwrap().point;
        let ahead = Tangent { face: start.face, vector: DVec2::X };
        assert!(surface.walk(&start, &ahead, f64::NAN).is_err());
        assert!(surface.walk(&start, &Tangent { vector: DVec2::NAN, ..ahead }, 1.0).is_err());
        assert_eq!(surface.walk(&start, &Tangent { vector: DVec2::ZERO, ..ahead }, 1.0).unwrap().path.length(), 0.0);
        // Around the cube's waist and home again.
        let walk = surface.walk(&start, &surface.tangent(&start, DVec3::X).unwrap(), 4.0).unwrap();
        assert!(surface.position(&walk.path.end()).distance(surface.position(&start)) < 1e-12);
    }
}
