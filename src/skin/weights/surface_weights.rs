//! Weights at the vertices of a mesh: painted, or those of a skinned one.

use glam::DVec3;

use super::{WeightField, WeightsError};
use crate::skin::Quadrature;
use crate::surface::{Surface, SurfacePoint, TriangleMesh};

/// Weights at the vertices of a mesh, linear on its faces, and carried to all places by the surface that was built of it.
///
/// A place off the surface has the weights of the closest point. A handle is a joint of a skeleton, or a colour that was painted; the transform of
/// a joint in a pose is its place in the world times the inverse of that at rest.
#[derive(Clone, Debug)]
pub struct SurfaceWeights<'a> {
    surface: &'a Surface,
    /// Vertices of the input at the corners of each input face.
    faces: &'a [[u32; 3]],
    handles: usize,
    /// Influences of each vertex; they sum to one, or there are none.
    influences: Vec<Vec<(u32, f64)>>,
}

/// Joints and their weights, four for each vertex.
pub type SkinSet<'a> = (&'a [[u16; 4]], &'a [[f32; 4]]);

/// Handles that move one place at most: of more, those with the largest weights are kept.
const MOST: usize = 8;

impl<'a> SurfaceWeights<'a> {
    /// Painted weights: those of all handles for the first vertex of the mesh, then for the second, … `mesh` is what the surface was built of.
    ///
    /// # Errors
    /// [`WeightsError::NoHandles`], [`WeightsError::Length`], [`WeightsError::BadWeight`].
    pub fn painted(
        surface: &'a Surface,
        mesh: &'a TriangleMesh,
        handles: usize,
        weights: &[f64],
    ) -> Result<Self, WeightsError> {
        if handles == 0 {
            return Err(WeightsError::NoHandles);
        }
        let expected = mesh.positions.len().saturating_mul(handles);
        if weights.len() != expected {
            return Err(WeightsError::Length { found: weights.len(), expected });
        }
        let of_vertex = |weights: &[f64]| weights.iter().enumerate().map(|(h, w)| (h, *w)).collect::<Vec<_>>();
        Self::new(surface, mesh, handles, weights.chunks_exact(handles).map(of_vertex))
    }

    /// The weights of a skinned mesh as glTF has them: sets of four joints and four weights for each vertex of the mesh, which is what the
    /// surface was built of. Most files have one set.
    ///
    /// # Errors
    /// [`WeightsError::NoHandles`], [`WeightsError::Length`], [`WeightsError::BadWeight`], [`WeightsError::NoSuchHandle`].
    pub fn of_skin(
        surface: &'a Surface,
        mesh: &'a TriangleMesh,
        joint_count: usize,
        sets: &[SkinSet<'_>],
    ) -> Result<Self, WeightsError> {
        if joint_count == 0 {
            return Err(WeightsError::NoHandles);
        }
        let expected = mesh.positions.len();
        if let Some(found) = sets.iter().flat_map(|(j, w)| [j.len(), w.len()]).find(|found| *found != expected) {
            return Err(WeightsError::Length { found, expected });
        }
        let of_vertex = |vertex: usize| {
            let pairs = sets.iter().flat_map(|(joints, weights)| joints[vertex].into_iter().zip(weights[vertex]));
            pairs.map(|(joint, w)| (usize::from(joint), f64::from(w))).collect()
        };
        Self::new(surface, mesh, joint_count, (0..expected).map(of_vertex))
    }

    fn new(
        surface: &'a Surface,
        mesh: &'a TriangleMesh,
        handles: usize,
        of_vertices: impl Iterator<Item = Vec<(usize, f64)>>,
    ) -> Result<Self, WeightsError> {
        let mut influences = Vec::with_capacity(mesh.positions.len());
        for (vertex, pairs) in of_vertices.enumerate() {
            let mut kept: Vec<(u32, f64)> = Vec::new();
            for (handle, weight) in pairs {
                if !(weight.is_finite() && weight >= 0.0) {
                    return Err(WeightsError::BadWeight { vertex });
                }
                if weight == 0.0 {
                    continue;
                }
                if handle >= handles {
                    return Err(WeightsError::NoSuchHandle { vertex, handle, handles });
                }
                match kept.iter_mut().find(|(of, _)| *of as usize == handle) {
                    Some((_, sum)) => *sum += weight,
                    None => kept.push((handle as u32, weight)),
                }
            }
            let sum: f64 = kept.iter().map(|(_, w)| w).sum();
            if !sum.is_finite() {
                return Err(WeightsError::BadWeight { vertex });
            }
            kept.iter_mut().for_each(|(_, w)| *w /= sum);
            influences.push(kept);
        }
        Ok(Self { surface, faces: &mesh.faces, handles, influences })
    }

    /// Weights at a point of the surface: those of its face's corners, the largest eight of them; all zero where no corner has any, or for
    /// a point that is not on the surface.
    pub fn weights_on(&self, point: &SurfacePoint, out: &mut [f64]) {
        out.fill(0.0);
        let Some(vertices) = self.faces.get(point.face.0 as usize) else { return };
        for (vertex, share) in vertices.iter().zip(point.weights) {
            for (handle, weight) in self.influences.get(*vertex as usize).into_iter().flatten() {
                if let Some(out) = out.get_mut(*handle as usize) {
                    *out += share.max(0.0) * weight;
                }
            }
        }
        if out.iter().filter(|w| **w > 0.0).count() > MOST {
            // At most twelve are there; the least of those that are too many goes first.
            for _ in 0..12 {
                let count = out.iter().filter(|w| **w > 0.0).count();
                let least = out.iter_mut().filter(|w| **w > 0.0).min_by(|a, b| a.total_cmp(b));
                match least {
                    Some(least) if count > MOST => *least = 0.0,
                    _ => break,
                }
            }
        }
        let sum: f64 = out.iter().sum();
        if sum > 0.0 {
            out.iter_mut().for_each(|w| *w /= sum);
        }
    }

    /// How far places of handles are from the surface that they move, as a share of its diagonal: those farther than `share` of it.
    pub fn far_handles(&self, places: &[DVec3], share: f64) -> Vec<(usize, f64)> {
        let far = |(handle, place): (usize, &DVec3)| {
            let distance = self.surface.closest_point(*place)?.distance / self.surface.diagonal();
            (distance > share).then_some((handle, distance))
        };
        places.iter().enumerate().filter_map(far).collect()
    }
}

impl WeightField for SurfaceWeights<'_> {
    fn handle_count(&self) -> usize {
        self.handles
    }

    fn weights_at(&self, place: DVec3, out: &mut [f64]) {
        match self.surface.closest_point(place) {
            Some(closest) => self.weights_on(&closest.point, out),
            None => out.fill(0.0),
        }
    }

    fn quadrature(&self) -> Quadrature {
        Quadrature::PIECEWISE
    }
}
