//! Raw triangles, as a file or an engine hands them over.

use glam::DVec3;

/// Raw triangles: positions and corner indices, nothing checked yet.
///
/// Every triangle is one input face; its place in `faces` is its [`FaceId`](super::FaceId). A polygon of n corners gives
/// n − 2 consecutive triangles, a fan from its first corner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions, in the unit that all lengths on the surface will have.
    pub positions: Vec<DVec3>,
    /// Corners of each face, as places in `positions`.
    pub faces: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// Appends a polygon as a fan from its first corner; fewer than three corners append nothing.
    pub fn push_polygon(&mut self, corners: &[u32]) {
        for pair in corners.get(1..).unwrap_or_default().windows(2) {
            self.faces.push([corners[0], pair[0], pair[1]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_become_fans() {
        let mut mesh = TriangleMesh::default();
        mesh.push_polygon(&[4, 5, 6, 7, 8]);
        mesh.push_polygon(&[1, 2]);
        mesh.push_polygon(&[]);
        assert_eq!(mesh.faces, [[4, 5, 6], [4, 6, 7], [4, 7, 8]]);
    }
}
