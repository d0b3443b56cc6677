//! Normals for looking at a mesh: smooth across flat edges, sharp across steep ones.

use std::collections::HashMap;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use glam::DVec3;

use crate::surface::TriangleMesh;

/// Faces that meet at less than 40° look like one.
const SMOOTH: f64 = 0.766;
/// At a vertex of more faces than this, each looks flat: comparing all with all would take long.
const MOST_FACES: usize = 64;

/// A mesh for drawing, whose triangles are in the order of the given ones. A vertex is there once for each normal it has.
/// Faces that name a vertex that does not exist are left out.
pub(crate) fn shaded_mesh(triangles: &TriangleMesh) -> Mesh {
    let positions = &triangles.positions;
    let faces: Vec<[u32; 3]> =
        triangles.faces.iter().filter(|f| f.iter().all(|v| (*v as usize) < positions.len())).copied().collect();
    let twice_areas: Vec<DVec3> = faces.iter().map(|f| twice_area(f.map(|v| positions[v as usize]))).collect();
    let places = places(positions);
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); positions.len()];
    for (face, corners) in (0..).zip(&faces) {
        corners.iter().for_each(|v| around[places[*v as usize] as usize].push(face));
    }
    let (mut drawn, mut normals) = (Vec::new(), Vec::new());
    let mut of_vertex: Vec<Vec<u32>> = vec![Vec::new(); positions.len()];
    let mut indices = Vec::with_capacity(3 * faces.len());
    for (own, corners) in twice_areas.iter().zip(&faces) {
        for vertex in corners.map(|v| v as usize) {
            let normal = normal_of(*own, &around[places[vertex] as usize], &twice_areas);
            let known = of_vertex[vertex].iter().find(|i| normals[**i as usize] == normal).copied();
            indices.push(known.unwrap_or_else(|| {
                let new = drawn.len() as u32;
                drawn.push(positions[vertex].as_vec3().to_array());
                normals.push(normal);
                of_vertex[vertex].push(new);
                new
            }));
        }
    }
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, drawn)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(indices))
}

fn twice_area([a, b, c]: [DVec3; 3]) -> DVec3 {
    let normal = (b - a).cross(c - a);
    if normal.is_finite() { normal } else { DVec3::ZERO }
}

/// For each vertex the first one at the same position: formats without shared vertices look smooth as well.
fn places(positions: &[DVec3]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len());
    let key = |p: &DVec3| (*p + 0.0).to_array().map(f64::to_bits);
    (0..).zip(positions).map(|(i, p)| *first.entry(key(p)).or_insert(i)).collect()
}

/// The area-weighted normal of the faces around a vertex that look like one with the own face.
fn normal_of(own: DVec3, around: &[u32], twice_areas: &[DVec3]) -> [f32; 3] {
    let direction = own.normalize_or_zero();
    let others = if around.len() > MOST_FACES { &[] } else { around };
    let alike = others.iter().map(|face| twice_areas[*face as usize]);
    let sum: DVec3 = alike.filter(|other| other.normalize_or_zero().dot(direction) > SMOOTH).sum();
    sum.normalize_or(own.normalize_or(DVec3::Y)).as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::shapes;

    #[test]
    fn a_sphere_keeps_its_vertices_and_a_cube_gets_corners() {
        let sphere = shapes::icosphere(3);
        assert_eq!(shaded_mesh(&sphere).count_vertices(), sphere.positions.len());
        let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from((i >> 1) & 1), f64::from(i >> 2));
        let mut cube = TriangleMesh { positions: (0..8).map(corner).collect(), faces: Vec::new() };
        for side in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            cube.push_polygon(&side);
        }
        let mesh = shaded_mesh(&cube);
        assert_eq!(mesh.count_vertices(), 24);
    }

    #[test]
    fn triangles_keep_their_order() {
        let torus = shapes::torus(2.0, 0.5, 12, 8);
        let back = crate::plugin::triangle_mesh_from(&shaded_mesh(&torus)).expect("triangles");
        let corners = |mesh: &TriangleMesh, f: usize| mesh.faces[f].map(|v| mesh.positions[v as usize]);
        assert_eq!(back.faces.len(), torus.faces.len());
        for face in 0..torus.faces.len() {
            let pairs = corners(&back, face).into_iter().zip(corners(&torus, face));
            assert!(pairs.into_iter().all(|(a, b)| a.distance(b) < 1e-6));
        }
    }
}
