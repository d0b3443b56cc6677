//! Tangent vectors: frames of faces, hinges between them, directions about a vertex.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::surface::{FaceId, HalfEdge, InnerPoint, PointError, Surface, SurfacePoint, Zeros};

/// A tangent vector at a surface point, in the frame of a face.
///
/// x runs along the face's corner 0 → corner 1 in input order, y to the left of it as seen against the surface's oriented
/// normal. At a point on a side or corner any face around it will do; a vector that points out of its face is carried into
/// the face it points into: exactly over a side, and at a vertex so that a full turn of the frame is a full turn about the
/// vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct Tangent {
    /// The face whose frame is meant.
    pub face: FaceId,
    /// The vector, in local units.
    pub vector: DVec2,
}

impl Tangent {
    /// Length of the vector.
    pub fn length(&self) -> f64 {
        self.vector.length()
    }

    /// The vector turned counter-clockwise, as seen against the normal, by an angle in radians.
    pub fn rotated(&self, angle: f64) -> Self {
        Self { face: self.face, vector: DVec2::from_angle(angle).rotate(self.vector) }
    }

    /// The same direction with another length; the zero vector stays as it is.
    pub fn with_length(&self, length: f64) -> Self {
        Self { face: self.face, vector: self.vector.normalize_or_zero() * length }
    }
}

/// A tangent vector in the frame of an inner face: x along its inner corner 0 → corner 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InnerTangent {
    pub(crate) face: u32,
    pub(crate) vector: DVec2,
}

impl Surface {
    /// Projects a vector in local space onto the plane of the point's face; its length shrinks with the projection.
    ///
    /// # Errors
    /// [`PointError`] if the point does not belong to the surface.
    pub fn tangent(&self, at: &SurfacePoint, direction: DVec3) -> Result<Tangent, PointError> {
        let face = self.inner_face(at.face)?;
        if !direction.is_finite() {
            return Err(PointError::NotFinite("the direction", at.face));
        }
        let (x, y) = self.frame(face);
        let vector = DVec2::new(direction.dot(x), direction.dot(y));
        Ok(self.outer_tangent(&InnerTangent { face, vector }))
    }

    /// A tangent vector as a vector in local space.
    ///
    /// # Errors
    /// [`PointError`] if its face does not belong to the surface.
    pub fn tangent_in_space(&self, tangent: &Tangent) -> Result<DVec3, PointError> {
        let inner = self.inner_tangent(tangent)?;
        let (x, y) = self.frame(inner.face);
        Ok(inner.vector.x * x + inner.vector.y * y)
    }

    /// The opposite direction at a point: the way back, half the angle about a vertex away; same length.
    ///
    /// # Errors
    /// [`PointError`] if point or tangent do not belong to the surface.
    pub fn opposite(&self, at: &SurfacePoint, tangent: &Tangent) -> Result<Tangent, PointError> {
        self.turned(at, tangent, TAU / 2.0)
    }

    /// The direction at a point turned counter-clockwise; a full turn is 2π also about a vertex, whatever its angle.
    ///
    /// # Errors
    /// [`PointError`] if point or tangent do not belong to the surface.
    pub fn turned(&self, at: &SurfacePoint, tangent: &Tangent, angle: f64) -> Result<Tangent, PointError> {
        let (point, tangent) = self.inner_tangent_at(at, tangent)?;
        if !angle.is_finite() {
            return Err(PointError::NotFinite("the angle", at.face));
        }
        Ok(self.outer_tangent(&turn_at(self, &point, &tangent, angle)))
    }

    /// Unit vectors of a face's inner frame in space.
    fn frame(&self, face: u32) -> (DVec3, DVec3) {
        let [a, b, _] = self.triangles[face as usize].map(|v| self.positions[v as usize]);
        let x = (b - a).normalize_or_zero();
        (x, self.face_normal(face).cross(x))
    }

    /// Direction of the input frame's x axis in the inner frame.
    fn input_axis(&self, face: u32) -> DVec2 {
        if self.outer_side(HalfEdge::new(face, 0)).2 {
            self.flat(face)[2].try_normalize().unwrap_or(DVec2::X)
        } else {
            DVec2::X
        }
    }

    pub(crate) fn inner_tangent(&self, tangent: &Tangent) -> Result<InnerTangent, PointError> {
        let face = self.inner_face(tangent.face)?;
        if !tangent.vector.is_finite() {
            return Err(PointError::NotFinite("the tangent vector", tangent.face));
        }
        Ok(InnerTangent { face, vector: self.input_axis(face).rotate(tangent.vector) })
    }

    /// A point and a tangent vector there, which must be spelled in a face around the point.
    pub(crate) fn inner_tangent_at(
        &self,
        at: &SurfacePoint,
        tangent: &Tangent,
    ) -> Result<(InnerPoint, InnerTangent), PointError> {
        let (point, inner) = (self.inner_point(at)?, self.inner_tangent(tangent)?);
        match spell_in(self, &point, inner.face) {
            Some(_) => Ok((point, inner)),
            None => Err(PointError::ForeignTangent { point: at.face, tangent: tangent.face }),
        }
    }

    pub(crate) fn outer_tangent(&self, inner: &InnerTangent) -> Tangent {
        let axis = self.input_axis(inner.face);
        let vector = DVec2::new(axis.x, -axis.y).rotate(inner.vector);
        Tangent { face: self.outer_side(HalfEdge::new(inner.face, 0)).0, vector }
    }
}

/// The spelling of a point in some face, if that face is around it.
pub(crate) fn spell_in(surface: &Surface, at: &InnerPoint, face: u32) -> Option<InnerPoint> {
    let mut found = None;
    surface.for_each_spelling(at, |p| {
        if p.face == face {
            found = Some(p);
        }
    });
    found
}

/// The vector with length one; zero only for the zero vector, however short or long it is.
pub(crate) fn unit(vector: DVec2) -> DVec2 {
    let largest = vector.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (vector / largest).normalize_or_zero() } else { DVec2::ZERO }
}

/// A point of a face in the plane.
pub(crate) fn lay(flat: &[DVec2; 3], p: &InnerPoint) -> DVec2 {
    p.weights[0] * flat[0] + p.weights[1] * flat[1] + p.weights[2] * flat[2]
}

/// Direction of a side in its face's frame.
pub(crate) fn side_direction(flat: &[DVec2; 3], h: HalfEdge) -> DVec2 {
    (flat[h.next().side()] - flat[h.side()]).try_normalize().unwrap_or(DVec2::X)
}

/// Carries a vector over side `h` of its face into the frame of the face behind (a hinge: no angle is lost).
pub(crate) fn over_hinge(surface: &Surface, h: HalfEdge, vector: DVec2) -> DVec2 {
    let twin = surface.twin(h);
    let from = side_direction(&surface.flat(h.face()), h);
    let to = -side_direction(&surface.flat(twin.face()), twin);
    to.rotate(DVec2::new(from.dot(vector), from.perp_dot(vector)))
}

/// Angle from one direction counter-clockwise to another, in [0, 2π).
pub(crate) fn angle_between(from: DVec2, to: DVec2) -> f64 {
    let angle = from.perp_dot(to).atan2(from.dot(to));
    if angle < 0.0 { angle + TAU } else { angle }
}

/// Carries a tangent vector at a point into the face it points into, so that a walk can begin there; `None` where it points
/// over the boundary.
pub(crate) fn settle(surface: &Surface, at: &InnerPoint, tangent: &InnerTangent) -> Option<(InnerPoint, InnerTangent)> {
    /// Angles below this are rounding.
    const ALONG: f64 = 1e-12;
    let at = spell_in(surface, at, tangent.face)?;
    match at.zeros() {
        Zeros::None => Some((at, *tangent)),
        Zeros::Side(k) => {
            let h = HalfEdge::new(at.face, k);
            let along = side_direction(&surface.flat(at.face), h);
            let inwards = along.perp_dot(tangent.vector);
            if inwards >= 0.0 {
                return Some((at, *tangent));
            }
            if inwards > -ALONG * tangent.vector.length() {
                let vector = along * along.dot(tangent.vector).signum() * tangent.vector.length();
                return Some((at, InnerTangent { face: at.face, vector }));
            }
            let there = surface.across(&at, h)?;
            Some((there, InnerTangent { face: there.face, vector: over_hinge(surface, h, tangent.vector) }))
        }
        Zeros::Corner(k) => {
            let h = HalfEdge::new(at.face, k);
            let angle = angle_between(side_direction(&surface.flat(at.face), h), tangent.vector);
            let corner = surface.corner_angle(h);
            if angle <= corner {
                return Some((at, *tangent));
            }
            let length = tangent.vector.length();
            if TAU - angle < ALONG {
                return Some(in_corner(surface, h, 0.0, length));
            }
            let vertex = surface.origin(h);
            let total = surface.angle[vertex as usize];
            if surface.boundary[vertex as usize] {
                // The fan is open and angles are as they are: the vector lies in it counter-clockwise of its face, or
                // clockwise, or not at all.
                let before = angle_before(surface, h)?;
                let first = surface.outgoing[vertex as usize];
                let ways = [before + angle, before + angle - TAU];
                let inside = ways.into_iter().find(|a| (-ALONG..=total + ALONG).contains(a))?;
                return fan_out(surface, first, inside.clamp(0.0, total), length);
            }
            let rest = (angle - corner) * (total - corner).max(0.0) / (TAU - corner).max(f64::MIN_POSITIVE);
            fan_out(surface, h, corner + rest, length)
        }
    }
}

/// Angle from the first outgoing side of the vertex at the origin of `h` counter-clockwise to `h`.
pub(crate) fn angle_before(surface: &Surface, goal: HalfEdge) -> Option<f64> {
    let first = surface.outgoing[surface.origin(goal) as usize];
    let (mut h, mut sum) = (first, 0.0);
    while h != goal {
        sum += surface.corner_angle(h);
        h = surface.counter_clockwise(h);
        if !h.is_some() || h == first {
            return None;
        }
    }
    Some(sum)
}

/// The vector of some length at the origin of `h` that lies `angle` counter-clockwise of it, or `None` over the boundary.
pub(crate) fn fan_out(surface: &Surface, h: HalfEdge, angle: f64, length: f64) -> Option<(InnerPoint, InnerTangent)> {
    let (mut h, mut rest) = (h, angle);
    let first = h;
    loop {
        let corner = surface.corner_angle(h);
        if rest <= corner {
            return Some(in_corner(surface, h, rest, length));
        }
        rest -= corner;
        let next = surface.counter_clockwise(h);
        if next == first {
            // Once around and rounding left a rest: the first side again.
            return Some(in_corner(surface, first, 0.0, length));
        }
        if !next.is_some() {
            return (rest < 1e-9).then(|| in_corner(surface, h, corner, length));
        }
        h = next;
    }
}

/// The vector in the corner at the origin of `h`, `angle` counter-clockwise of it.
fn in_corner(surface: &Surface, h: HalfEdge, angle: f64, length: f64) -> (InnerPoint, InnerTangent) {
    let along = side_direction(&surface.flat(h.face()), h);
    let vector = DVec2::from_angle(angle).rotate(along) * length;
    (InnerPoint::on_side(h, 0.0), InnerTangent { face: h.face(), vector })
}

/// Turns a tangent vector at a point; about a vertex a full turn is its total angle.
pub(crate) fn turn_at(surface: &Surface, at: &InnerPoint, tangent: &InnerTangent, angle: f64) -> InnerTangent {
    let turned = |t: &InnerTangent| InnerTangent { face: t.face, vector: DVec2::from_angle(angle).rotate(t.vector) };
    let Some((at, settled)) = settle(surface, at, tangent) else { return turned(tangent) };
    let Zeros::Corner(k) = at.zeros() else { return turned(&settled) };
    let h = HalfEdge::new(at.face, k);
    let vertex = surface.origin(h);
    if surface.boundary[vertex as usize] {
        return turned(&settled);
    }
    let inside = angle_between(side_direction(&surface.flat(at.face), h), settled.vector).min(surface.corner_angle(h));
    let total = surface.angle[vertex as usize];
    let sum = (inside + angle.rem_euclid(TAU) / TAU * total).rem_euclid(total.max(f64::MIN_POSITIVE));
    fan_out(surface, h, sum, settled.vector.length()).map_or_else(|| turned(&settled), |found| found.1)
}
