//! A mesh as the baseline sees it: single-precision positions, and a node a face.

use bevy_surface_splines::surface::TriangleMesh;
use glam::{DVec3, Vec3};

/// Where a side has no other face.
pub(crate) const NONE: u32 = u32::MAX;

/// All that the search reads of a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// Its centre: the middles of its sides, weighted by their lengths.
    pub(crate) centre: Vec3,
    /// The faces across its sides; side k runs from corner k to corner k + 1.
    pub(crate) neighbours: [u32; 3],
}

#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) faces: Vec<[u32; 3]>,
    pub(crate) nodes: Vec<Node>,
}

impl Mesh {
    /// Finds which faces are neighbours. A side of three faces or more counts as boundary.
    pub(crate) fn new(mesh: &TriangleMesh) -> Self {
        let positions: Vec<Vec3> = mesh.positions.iter().map(|p| p.as_vec3()).collect();
        let faces = mesh.faces.clone();
        let mut nodes: Vec<Node> = faces
            .iter()
            .map(|face| Node { centre: centre(face.map(|v| positions[v as usize])), neighbours: [NONE; 3] })
            .collect();

        // Sides by their two vertices, the smaller one first; equal ones come to stand together.
        let mut sides: Vec<(u64, u32, u8)> = Vec::with_capacity(faces.len() * 3);
        for (f, face) in faces.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                sides.push((u64::from(a.min(b)) << 32 | u64::from(a.max(b)), f as u32, k as u8));
            }
        }
        sides.sort_unstable();
        for same in sides.chunk_by(|a, b| a.0 == b.0) {
            if let [(_, f, j), (_, g, k)] = *same {
                nodes[f as usize].neighbours[j as usize] = g;
                nodes[g as usize].neighbours[k as usize] = f;
            }
        }
        Self { positions, faces, nodes }
    }

    pub(crate) fn position(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize].as_dvec3()
    }

    /// The two vertices of the side between a face and its neighbour.
    pub(crate) fn side_between(&self, face: u32, neighbour: u32) -> Option<[u32; 2]> {
        let k = self.nodes[face as usize].neighbours.iter().position(|&n| n == neighbour)?;
        let corners = &self.faces[face as usize];
        Some([corners[k], corners[(k + 1) % 3]])
    }
}

fn centre([a, b, c]: [Vec3; 3]) -> Vec3 {
    let (ab, bc, ca) = (a.distance(b), b.distance(c), c.distance(a));
    let perimeter = ab + bc + ca;
    if perimeter == 0.0 {
        return a;
    }
    ((a + b) * ab + (b + c) * bc + (c + a) * ca) / (2.0 * perimeter)
}
