//! Going round a vertex: how short the way past it can be on one side.

use glam::{DVec2, DVec3};
use std::f64::consts::PI;

use super::{plane::angle, topology::Topology};

/// The wedge of faces between a point before a vertex and a point after it, on one side of the vertex.
#[derive(Debug)]
pub(crate) struct Wedge {
    /// Its angle at the vertex.
    pub(crate) angle: f64,
    /// Polar coordinates about the vertex of the point before, the ends of the spokes, the point after.
    polar: Vec<(f64, f64)>,
}

/// A point by its face and the weights of the face's corners.
pub(crate) type Spelled = (u32, [f64; 3]);

impl Wedge {
    /// Turns about `vertex` from the point `before`, leaving its face through `side`, to the point `after`; none where the
    /// boundary bars the way. If both lie in one face this goes all the way round.
    pub(crate) fn around(
        topology: &Topology,
        vertex: u32,
        before: Spelled,
        side: usize,
        after: Spelled,
    ) -> Option<Self> {
        let center = topology.positions[vertex as usize];
        let spoke = |face: u32, side: usize| topology.positions[topology.far_end(face, side, vertex) as usize] - center;
        let (start, end) = (offset(topology, vertex, before)?, offset(topology, vertex, after)?);
        let mut polar = vec![(start.length(), 0.0)];
        let mut at = spoke(before.0, side);
        let mut turned = angle(start, at);
        for (face, entered) in topology.fan(vertex, before.0, side) {
            polar.push((at.length(), turned));
            if face == after.0 {
                turned += angle(at, end);
                polar.push((end.length(), turned));
                return Some(Self { angle: turned, polar });
            }
            let leave = topology.other_side(face, vertex, entered)?;
            let next = spoke(face, leave);
            turned += angle(at, next);
            at = next;
        }
        None
    }

    /// The wedge between two points of one face, inside that face.
    pub(crate) fn within(topology: &Topology, vertex: u32, before: Spelled, after: Spelled) -> Option<Self> {
        let (start, end) = (offset(topology, vertex, before)?, offset(topology, vertex, after)?);
        let angle = angle(start, end);
        Some(Self { angle, polar: vec![(start.length(), 0.0), (end.length(), angle)] })
    }

    /// Length of the shortest way through the wedge. From an angle of π on that leads through the vertex; below, the
    /// line is a convex chain held off by those spokes that end before the chord.
    pub(crate) fn shortest(&self) -> f64 {
        let ends = self.polar[0].0 + self.polar[self.polar.len() - 1].0;
        if self.angle >= PI {
            return ends;
        }
        let mut chain: Vec<DVec2> = Vec::with_capacity(self.polar.len());
        for &(radius, angle) in &self.polar {
            let (sin, cos) = angle.sin_cos();
            let point = DVec2::new(cos, sin) * radius;
            while let [.., p, q] = chain[..]
                && (q - p).perp_dot(point - q) >= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        let length: f64 = chain.windows(2).map(|w| w[0].distance(w[1])).sum();
        length.min(ends)
    }
}

/// From a vertex to a point in a face at it.
fn offset(topology: &Topology, vertex: u32, (face, weights): Spelled) -> Option<DVec3> {
    let corner = topology.corner_of(face, vertex)?;
    let p = topology.places(face);
    let (a, b) = ((corner + 1) % 3, (corner + 2) % 3);
    Some((p[a] - p[corner]) * weights[a] + (p[b] - p[corner]) * weights[b])
}

/// Total angle of the faces about a vertex, starting from a face at it, and whether they close up.
pub(crate) fn total_angle(topology: &Topology, vertex: u32, face: u32) -> Option<(f64, bool)> {
    let corner_angle = |face: u32| {
        let corner = topology.corner_of(face, vertex)?;
        let p = topology.places(face);
        Some(angle(p[(corner + 1) % 3] - p[corner], p[(corner + 2) % 3] - p[corner]))
    };
    let mut sum = corner_angle(face)?;
    let corner = topology.corner_of(face, vertex)?;
    for side in [corner, (corner + 2) % 3] {
        for (next, _) in topology.fan(vertex, face, side) {
            if next == face {
                return Some((sum, true));
            }
            sum += corner_angle(next)?;
        }
    }
    Some((sum, false))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_surface_splines::surface::{TriangleMesh, shapes};

    /// `n` flat triangles about vertex 0, spoke `i` of length `radii[i]`; open or closed.
    fn wheel(radii: &[f64], sweep: f64) -> TriangleMesh {
        let mut mesh = TriangleMesh { positions: vec![DVec3::ZERO], faces: Vec::new() };
        let steps = radii.len() - 1;
        for (i, r) in radii.iter().enumerate() {
            let (sin, cos) = (sweep * i as f64 / steps as f64).sin_cos();
            mesh.positions.push(DVec3::new(cos, sin, 0.0) * *r);
        }
        mesh.faces = (1..=steps as u32).map(|i| [0, i, i + 1]).collect();
        mesh
    }

    #[test]
    fn the_chord_where_it_fits_and_a_bend_where_a_spoke_is_short() {
        let sweep = 2.0;
        for (short, expected) in [(1.0, 2.0 * 1.0_f64.sin()), (0.2, 2.0 * (1.04 - 0.4 * 1.0_f64.cos()).sqrt())] {
            let topology = Topology::new(&wheel(&[1.0, short, 1.0], sweep));
            let wedge = Wedge::around(&topology, 0, (0, [0.0, 1.0, 0.0]), 2, (1, [0.0, 0.0, 1.0])).unwrap();
            assert!((wedge.angle - sweep).abs() < 1e-14);
            assert!((wedge.shortest() - expected).abs() < 1e-14, "{wedge:?}");
            assert!(Wedge::around(&topology, 0, (0, [0.0, 1.0, 0.0]), 0, (1, [0.0, 0.0, 1.0])).is_none());
        }
    }

    #[test]
    fn a_cube_corner_has_three_right_angles() {
        let topology = Topology::new(&shapes::cube());
        for face in 0..12 {
            for vertex in topology.corners[face as usize] {
                let (sum, closed) = total_angle(&topology, vertex, face).unwrap();
                assert!(closed && (sum - 1.5 * PI).abs() < 1e-14);
            }
        }
    }
}
