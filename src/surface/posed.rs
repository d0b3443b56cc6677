//! A surface in another shape: its vertices elsewhere, its faces and what lies on them the same.

use std::sync::Arc;

use glam::{DMat2, DVec2, DVec3};

use super::surface::FLIPPED;
use super::{Bvh, ClosestPoint, FaceId, PointError, RayHit, Surface, SurfacePoint, TriangleMesh};

/// A surface whose mesh joints, morph targets or a simulation have moved: where its points are now, what a ray hits and what is
/// closest to a place.
///
/// Faces, points, paths and curves stay those of the [`Surface`], and lengths along it those of the mesh from which it was built. Positions are
/// those of the input's vertices, so that two vertices in one place, which the surface welds, may part here as they do on the screen.
/// Beside the surface, 24 bytes a vertex, 12 a face and the tree of boxes.
#[derive(Clone, Debug)]
pub struct PosedSurface {
    surface: Arc<Surface>,
    /// Corners of each inner face, as vertices of the input.
    triangles: Vec<[u32; 3]>,
    positions: Vec<DVec3>,
    bvh: Bvh,
}

/// Why a surface cannot be posed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PoseError {
    /// The mesh is another one.
    #[error(
        "the mesh has {found} faces, and the one that the surface was built from has {built}: pose it by that mesh"
    )]
    OtherFaces {
        /// Faces of the mesh.
        found: usize,
        /// Faces of the surface's input.
        built: usize,
    },
    /// A face has a vertex that does not exist.
    #[error("face {0} names a vertex that does not exist, so that it cannot be placed: pass the mesh as it was built")]
    NoSuchVertex(FaceId),
    /// There are more or fewer positions than vertices.
    #[error("{found} positions for {vertices} vertices: give one for each vertex of the mesh")]
    OtherVertices {
        /// Positions given.
        found: usize,
        /// Vertices of the mesh.
        vertices: usize,
    },
}

impl PosedSurface {
    /// The surface in the shape of a mesh, which must be the one it was built from but for its positions.
    ///
    /// O(F).
    ///
    /// # Errors
    /// [`PoseError`] for another mesh.
    pub fn new(surface: Arc<Surface>, mesh: &TriangleMesh) -> Result<Self, PoseError> {
        let (found, built) = (mesh.faces.len(), surface.inner_of.len());
        if found != built {
            return Err(PoseError::OtherFaces { found, built });
        }
        let corners = |outer: &u32| {
            let face = outer & !FLIPPED;
            let [a, b, c] = mesh.faces[face as usize];
            let exists = [a, b, c].iter().all(|v| (*v as usize) < mesh.positions.len());
            let inner = if outer & FLIPPED != 0 { [a, c, b] } else { [a, b, c] };
            if exists { Ok(inner) } else { Err(PoseError::NoSuchVertex(FaceId(face))) }
        };
        let triangles = surface.outer_of.iter().map(corners).collect::<Result<Vec<_>, _>>()?;
        let (positions, mut bvh) = (mesh.positions.clone(), surface.bvh.clone());
        bvh.refit(&positions, &triangles);
        Ok(Self { surface, triangles, positions, bvh })
    }

    /// The surface that is posed.
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    /// Where the vertices of the input are.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Moves all vertices, in the order of the input. O(V + F), nothing is allocated.
    ///
    /// # Errors
    /// [`PoseError::OtherVertices`]; the pose is then as it was.
    pub fn pose(&mut self, positions: impl ExactSizeIterator<Item = DVec3>) -> Result<(), PoseError> {
        let (found, vertices) = (positions.len(), self.positions.len());
        if found != vertices {
            return Err(PoseError::OtherVertices { found, vertices });
        }
        self.positions.iter_mut().zip(positions).for_each(|(old, new)| *old = new);
        self.bvh.refit(&self.positions, &self.triangles);
        Ok(())
    }

    /// The first place where a ray meets the posed surface, from either side.
    pub fn ray(&self, origin: DVec3, direction: DVec3) -> Option<RayHit> {
        let hit = self.bvh.ray(&self.positions, &self.triangles, origin, direction, f64::INFINITY)?;
        let (point, position) = self.place(hit.face, hit.weights);
        Some(RayHit { point, position, normal: self.face_normal(hit.face), distance: hit.distance })
    }

    /// The place of the posed surface that is nearest to a position; none for one that is not finite.
    pub fn closest_point(&self, position: DVec3) -> Option<ClosestPoint> {
        let found = self.bvh.closest(&self.positions, &self.triangles, position, f64::INFINITY)?;
        let (point, position) = self.place(found.face, found.weights);
        Some(ClosestPoint { point, position, distance: found.distance })
    }

    /// Where a point is now; NaN if it does not belong to the surface.
    pub fn position(&self, point: &SurfacePoint) -> DVec3 {
        let Ok(inner) = self.surface.inner_point(point) else { return DVec3::NAN };
        self.place(inner.face, inner.weights).1
    }

    /// Unit normal of a point's face as it is now; zero for a face that has no area now, NaN if the point does not belong to the surface.
    pub fn normal(&self, point: &SurfacePoint) -> DVec3 {
        self.surface.inner_face(point.face).map_or(DVec3::NAN, |face| self.face_normal(face))
    }

    /// A direction in space, projected to a face as it is now, as the direction in the surface's own shape that becomes it.
    ///
    /// Zero where the face has no area now.
    ///
    /// # Errors
    /// [`PointError`] if the face does not belong to the surface.
    pub fn direction_at_rest(&self, face: FaceId, direction: DVec3) -> Result<DVec3, PointError> {
        let inner = self.surface.inner_face(face)?;
        Ok(carry(self.sides(inner), self.sides_at_rest(inner), direction))
    }

    /// A direction along a face in the surface's own shape, as it is now.
    ///
    /// # Errors
    /// [`PointError`] if the face does not belong to the surface.
    pub fn direction_now(&self, face: FaceId, direction: DVec3) -> Result<DVec3, PointError> {
        let inner = self.surface.inner_face(face)?;
        Ok(carry(self.sides_at_rest(inner), self.sides(inner), direction))
    }

    fn corners(&self, face: u32) -> [DVec3; 3] {
        self.triangles[face as usize].map(|v| self.positions[v as usize])
    }

    fn sides(&self, face: u32) -> [DVec3; 2] {
        let [a, b, c] = self.corners(face);
        [b - a, c - a]
    }

    fn sides_at_rest(&self, face: u32) -> [DVec3; 2] {
        let [a, b, c] = self.surface.triangles[face as usize].map(|v| self.surface.positions[v as usize]);
        [b - a, c - a]
    }

    fn face_normal(&self, face: u32) -> DVec3 {
        let [u, v] = self.sides(face);
        u.cross(v).normalize_or_zero()
    }

    fn place(&self, face: u32, weights: [f64; 3]) -> (SurfacePoint, DVec3) {
        let [a, b, c] = self.corners(face);
        let position = weights[0] * a + weights[1] * b + weights[2] * c;
        (self.surface.outer_point(&super::InnerPoint { face, weights }), position)
    }
}

/// A direction by its shares of two sides of a face, and the same shares of two others.
fn carry(from: [DVec3; 2], to: [DVec3; 2], direction: DVec3) -> DVec3 {
    let [u, v] = from;
    let products = DMat2::from_cols(DVec2::new(u.dot(u), u.dot(v)), DVec2::new(u.dot(v), v.dot(v)));
    let size = u.dot(u) * v.dot(v);
    let area = products.determinant();
    if area.is_nan() || area <= 1e-24 * size {
        return DVec3::ZERO;
    }
    let shares = products.inverse() * DVec2::new(u.dot(direction), v.dot(direction));
    shares.x * to[0] + shares.y * to[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{SurfaceOptions, shapes};

    /// A torus, every second face turned over, so that the surface has to turn it back.
    fn turned_torus() -> TriangleMesh {
        let mut mesh = shapes::torus(2.0, 0.7, 30, 15);
        mesh.faces.iter_mut().step_by(2).for_each(|face| face.swap(1, 2));
        mesh
    }

    fn bent(p: DVec3) -> DVec3 {
        let (sin, cos) = (0.4 * p.x).sin_cos();
        DVec3::new((3.0 + p.z) * sin, 1.5 * p.y, (3.0 + p.z) * cos)
    }

    #[test]
    fn a_posed_surface_is_one_built_from_the_pose() {
        let mesh = turned_torus();
        let rest = Arc::new(Surface::build(&mesh, &SurfaceOptions::default()).unwrap());
        let mut posed = PosedSurface::new(rest.clone(), &mesh).unwrap();
        posed.pose(mesh.positions.iter().map(|p| bent(*p))).unwrap();
        let other = TriangleMesh { positions: mesh.positions.iter().map(|p| bent(*p)).collect(), faces: mesh.faces };
        let built = Surface::build(&other, &SurfaceOptions::default()).unwrap();
        for i in 0..300_u32 {
            let point = SurfacePoint { face: FaceId(i * 7 % 900), weights: [0.1, 0.6, 0.3] };
            assert!(posed.position(&point).distance(built.position(&point)) < 1e-12);
            assert!(posed.normal(&point).dot(built.normal(&point)).abs() > 1.0 - 1e-12);
            let from = 6.0 * DVec3::new(f64::from(i).sin(), f64::from(i * 3).cos(), f64::from(i * 7).sin());
            let (a, b) = (posed.ray(from, -from), built.ray(from, -from));
            assert_eq!(a.is_some(), b.is_some());
            if let (Some(a), Some(b)) = (a, b) {
                assert!((a.distance - b.distance).abs() < 1e-9 && a.position.distance(b.position) < 1e-9);
            }
            let (a, b) = (posed.closest_point(from).unwrap(), built.closest_point(from).unwrap());
            assert!((a.distance - b.distance).abs() < 1e-9 && a.position.distance(posed.position(&a.point)) < 1e-12);
        }
    }

    #[test]
    fn directions_go_with_their_faces() {
        let mesh = turned_torus();
        let rest = Arc::new(Surface::build(&mesh, &SurfaceOptions::default()).unwrap());
        let mut posed = PosedSurface::new(rest.clone(), &mesh).unwrap();
        posed.pose(mesh.positions.iter().map(|p| bent(*p))).unwrap();
        for face in (0..900).step_by(11).map(FaceId) {
            let at = |w| SurfacePoint { face, weights: w };
            let (a, b) = (at([0.5, 0.2, 0.3]), at([0.1, 0.3, 0.6]));
            let still = rest.position(&b) - rest.position(&a);
            let moved = posed.position(&b) - posed.position(&a);
            assert!(posed.direction_now(face, still).unwrap().distance(moved) < 1e-12);
            let out = 0.7 * posed.normal(&a);
            assert!(posed.direction_at_rest(face, moved + out).unwrap().distance(still) < 1e-12);
        }
    }

    #[test]
    fn another_mesh_is_refused() {
        let mesh = turned_torus();
        let rest = Arc::new(Surface::build(&mesh, &SurfaceOptions::default()).unwrap());
        let fewer = TriangleMesh { faces: mesh.faces[1..].to_vec(), ..mesh.clone() };
        assert_eq!(
            PosedSurface::new(rest.clone(), &fewer).unwrap_err(),
            PoseError::OtherFaces { found: 899, built: 900 }
        );
        let short = TriangleMesh { positions: mesh.positions[..5].to_vec(), ..mesh.clone() };
        assert!(matches!(PosedSurface::new(rest.clone(), &short), Err(PoseError::NoSuchVertex(_))));
        let mut posed = PosedSurface::new(rest, &mesh).unwrap();
        let error = posed.pose([DVec3::ZERO; 3].into_iter()).unwrap_err();
        assert_eq!(error, PoseError::OtherVertices { found: 3, vertices: 450 });
    }
}
