//! Faces and vertices in the order in which a surface keeps them in memory.

use glam::DVec3;

use super::{
    BuildProgress, SurfaceError, TriangleMesh, morton, parallel,
    sift::Sifted,
    surface::DROPPED,
    weld::{Welded, without_negative_zero},
};

/// Faces in the order in which they are kept in memory, and vertices by their first use there: what meets in the mesh is
/// near in memory while it is linked.
pub(crate) struct Arranged {
    /// Corners, in the input's order of corners; vertices that were welded are one.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The input face of each.
    pub(crate) outer_of: Vec<u32>,
    /// For every vertex the first input vertex at its position.
    pub(crate) input_vertex: Vec<u32>,
}

impl Arranged {
    /// Arranges the faces that were kept.
    ///
    /// # Errors
    /// [`SurfaceError::Cancelled`].
    pub(crate) fn new(
        mesh: &TriangleMesh,
        welded: Welded,
        sifted: &Sifted,
        progress: &BuildProgress,
    ) -> Result<Self, SurfaceError> {
        let Welded { of_input, first } = welded;
        let outer_of = morton::order(mesh, sifted, progress)?;
        let corners = |face: usize| mesh.faces[outer_of[face] as usize].map(|v| of_input[v as usize]);
        let mut triangles = parallel::table(outer_of.len(), [0; 3], progress, corners)?;
        drop(of_input);
        let order = first_uses(&mut triangles, first.len());
        let input_vertex = order.into_iter().map(|v| first[v as usize]).collect();
        Ok(Self { triangles, outer_of, input_vertex })
    }

    pub(crate) fn position(&self, mesh: &TriangleMesh, vertex: u32) -> DVec3 {
        without_negative_zero(mesh.positions[self.input_vertex[vertex as usize] as usize])
    }

    /// For each input face its place in memory, or [`DROPPED`].
    pub(crate) fn inner_of(&self, input_faces: usize) -> Vec<u32> {
        let mut inner_of = vec![DROPPED; input_faces];
        for (inner, &outer) in self.outer_of.iter().enumerate() {
            inner_of[outer as usize] = inner as u32;
        }
        inner_of
    }

    /// Keeps the faces for which `stays` is true. All vertices must stay in use.
    pub(crate) fn retain(&mut self, stays: impl Fn(u32) -> bool) {
        let mut face = 0..;
        self.triangles.retain(|_| face.next().is_some_and(&stays));
        let mut face = 0..;
        self.outer_of.retain(|_| face.next().is_some_and(&stays));
    }
}

/// Numbers vertices by their first use, and returns their former numbers in that order.
fn first_uses(triangles: &mut [[u32; 3]], vertices: usize) -> Vec<u32> {
    const UNSEEN: u32 = u32::MAX;
    let mut number = vec![UNSEEN; vertices];
    let mut order = Vec::with_capacity(vertices);
    for v in triangles.as_flattened_mut() {
        let number = &mut number[*v as usize];
        if *number == UNSEEN {
            *number = order.len() as u32;
            order.push(*v);
        }
        *v = *number;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_are_numbered_by_first_use() {
        let mut triangles = [[5, 2, 7], [7, 2, 0], [4, 0, 5]];
        assert_eq!(first_uses(&mut triangles, 8), [5, 2, 7, 0, 4]);
        assert_eq!(triangles, [[0, 1, 2], [2, 1, 3], [4, 3, 0]]);
    }
}
