//! Between Bevy's `Mesh` and the ground floor's [`TriangleMesh`].
//!
//! Triangles keep their order, so a [`FaceId`](crate::surface::FaceId) is the place of a triangle in the Bevy mesh.
//! Vertices that a render mesh splits at seams (for texture coordinates or normals) stay split there; here their positions are made
//! equal, so that they become one vertex of the surface.

use std::collections::HashMap;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, Mesh, MeshAccessError, PrimitiveTopology, VertexAttributeValues};
use glam::{DVec3, IVec3, Vec3};

use crate::surface::TriangleMesh;

/// Positions of a seam's two sides differ by the rounding of `f32`; closer than this share of the largest coordinate they
/// are one place.
const SEAM: f64 = 4.0 * f32::EPSILON as f64;

/// Why a Bevy mesh cannot be read as triangles.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshReadError {
    /// The arrays were moved to the render world.
    #[error(
        "its vertices live in the render world only: create or load it with RenderAssetUsages::default() (main world and \
         render world)"
    )]
    RenderWorldOnly,
    /// There are no positions.
    #[error("it has no vertex positions: insert Mesh::ATTRIBUTE_POSITION")]
    NoPositions,
    /// Positions are not three `f32`s.
    #[error("its positions are not stored as Float32x3: convert them")]
    PositionFormat,
    /// Points or lines.
    #[error("it is made of {0:?}: only TriangleList and TriangleStrip have a surface")]
    Topology(PrimitiveTopology),
    /// No triangle at all.
    #[error("it has no triangles: give at least three vertices or three indices")]
    NoTriangles,
}

impl From<MeshAccessError> for MeshReadError {
    fn from(error: MeshAccessError) -> Self {
        match error {
            MeshAccessError::ExtractedToRenderWorld => Self::RenderWorldOnly,
            MeshAccessError::NotFound => Self::NoPositions,
        }
    }
}

/// Reads the triangles of a Bevy mesh: lists and strips, with 16-bit, 32-bit or no indices.
///
/// Vertices keep their places. Positions that differ by rounding alone (4 · `f32::EPSILON` of the largest coordinate, as
/// at the seam of a generated sphere) are made equal. O(vertices + indices).
///
/// # Errors
/// [`MeshReadError`], whose text names the remedy.
pub fn triangle_mesh_from(mesh: &Mesh) -> Result<TriangleMesh, MeshReadError> {
    let mut triangles = read_triangles(mesh)?;
    close_seams(&mut triangles.positions);
    Ok(triangles)
}

/// Makes a Bevy mesh for drawing: positions, 32-bit indices and area-weighted normals, kept in both worlds.
///
/// Faces that name a vertex that does not exist are left out.
pub fn mesh_from(triangles: &TriangleMesh) -> Mesh {
    let positions: Vec<[f32; 3]> = triangles.positions.iter().map(|p| p.as_vec3().to_array()).collect();
    let count = positions.len();
    let faces = || triangles.faces.iter().filter(move |f| f.iter().all(|v| (*v as usize) < count));
    let mut normals = vec![DVec3::ZERO; count];
    for face in faces() {
        let [a, b, c] = face.map(|v| triangles.positions[v as usize]);
        let twice_area = (b - a).cross(c - a);
        for v in face {
            normals[*v as usize] += twice_area;
        }
    }
    let normals: Vec<[f32; 3]> = normals.iter().map(|n| n.normalize_or(DVec3::Y).as_vec3().to_array()).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(faces().flatten().copied().collect()))
}

/// Reads positions and triangles as they are.
pub(crate) fn read_triangles(mesh: &Mesh) -> Result<TriangleMesh, MeshReadError> {
    let strip = match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => false,
        PrimitiveTopology::TriangleStrip => true,
        other => return Err(MeshReadError::Topology(other)),
    };
    let VertexAttributeValues::Float32x3(positions) = mesh.try_attribute(Mesh::ATTRIBUTE_POSITION)? else {
        return Err(MeshReadError::PositionFormat);
    };
    let positions: Vec<DVec3> = positions.iter().map(|p| Vec3::from_array(*p).as_dvec3()).collect();
    let faces = match mesh.try_indices_option()? {
        None => corners((0..positions.len() as u32).collect(), strip, None),
        Some(Indices::U16(list)) => corners(list.iter().map(|i| u32::from(*i)).collect(), strip, Some(0xffff)),
        Some(Indices::U32(list)) => corners(list.clone(), strip, Some(u32::MAX)),
    };
    if faces.is_empty() {
        return Err(MeshReadError::NoTriangles);
    }
    Ok(TriangleMesh { positions, faces })
}

/// Groups indices into triangles; in a strip every second one is turned, and `restart` begins a new strip.
fn corners(list: Vec<u32>, strip: bool, restart: Option<u32>) -> Vec<[u32; 3]> {
    if !strip {
        return list.as_chunks::<3>().0.to_vec();
    }
    let mut faces = Vec::with_capacity(list.len());
    for run in list.split(|i| Some(*i) == restart) {
        for (i, w) in run.windows(3).enumerate() {
            faces.push(if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
        }
    }
    faces
}

/// Gives positions that differ by rounding alone the position of the first of them.
pub(crate) fn close_seams(positions: &mut [DVec3]) {
    let largest = positions.iter().filter(|p| p.is_finite()).fold(0.0_f64, |m, p| m.max(p.abs().max_element()));
    let tolerance = SEAM * largest;
    if tolerance == 0.0 {
        return;
    }
    // Cells are wide enough that a ball of the tolerance touches two of them an axis at most, mostly one, and coordinates
    // over cells stay within 2²⁰.
    let cell = 8.0 * tolerance;
    let of = |p: DVec3| (p / cell).floor().as_ivec3();
    let mut cells: HashMap<IVec3, Vec<DVec3>> = HashMap::new();
    for p in positions.iter_mut().filter(|p| p.is_finite()) {
        let (low, high) = (of(*p - tolerance), of(*p + tolerance));
        let mut near = None;
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    let there = cells.get(&IVec3::new(x, y, z)).into_iter().flatten();
                    near = near.or_else(|| there.copied().find(|q| q.distance(*p) <= tolerance));
                }
            }
        }
        match near {
            Some(first) => *p = first,
            None => cells.entry(of(*p)).or_default().push(*p),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Surface, SurfaceOptions, shapes};
    use bevy::prelude::{Meshable, Sphere};

    fn triangle(topology: PrimitiveTopology, usages: RenderAssetUsages) -> Mesh {
        Mesh::new(topology, usages).with_inserted_attribute(
            Mesh::ATTRIBUTE_POSITION,
            vec![[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
        )
    }

    #[test]
    fn lists_strips_and_all_kinds_of_indices() {
        let all = RenderAssetUsages::default();
        let bare = triangle(PrimitiveTopology::TriangleList, all);
        assert_eq!(triangle_mesh_from(&bare).unwrap().faces, [[0, 1, 2]]);
        let strip = triangle(PrimitiveTopology::TriangleStrip, all);
        assert_eq!(triangle_mesh_from(&strip).unwrap().faces, [[0, 1, 2], [2, 1, 3]]);
        let small = strip.clone().with_inserted_indices(Indices::U16(vec![0, 1, 2, 0xffff, 1, 3, 2]));
        assert_eq!(triangle_mesh_from(&small).unwrap().faces, [[0, 1, 2], [1, 3, 2]]);
        let large = bare.with_inserted_indices(Indices::U32(vec![0, 1, 3, 0, 3, 2]));
        assert_eq!(triangle_mesh_from(&large).unwrap().faces, [[0, 1, 3], [0, 3, 2]]);
    }

    #[test]
    fn what_cannot_be_read_says_why() {
        let lines = triangle(PrimitiveTopology::LineList, RenderAssetUsages::default());
        assert_eq!(triangle_mesh_from(&lines), Err(MeshReadError::Topology(PrimitiveTopology::LineList)));
        let mut gone = triangle(PrimitiveTopology::TriangleList, RenderAssetUsages::RENDER_WORLD);
        gone.take_gpu_data().unwrap();
        assert_eq!(triangle_mesh_from(&gone), Err(MeshReadError::RenderWorldOnly));
        let empty = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        assert_eq!(triangle_mesh_from(&empty), Err(MeshReadError::NoPositions));
        let none = empty.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, Vec::<[f32; 3]>::new());
        assert_eq!(triangle_mesh_from(&none), Err(MeshReadError::NoTriangles));
    }

    #[test]
    fn the_seam_of_a_uv_sphere_closes() {
        let mesh = Sphere::new(2.0).mesh().uv(32, 18);
        let read = triangle_mesh_from(&mesh).unwrap();
        assert_eq!(read.positions.len(), mesh.count_vertices());
        let surface = Surface::build(&read, &SurfaceOptions::default()).unwrap();
        assert!(surface.report().is_closed(), "{}", surface.report());
        assert_eq!(surface.vertex_count(), 32 * 17 + 2);
        assert_eq!(surface.report().sheets, 1);
    }

    #[test]
    fn there_and_back() {
        let torus = shapes::torus(2.0, 0.5, 12, 8);
        let back = triangle_mesh_from(&mesh_from(&torus)).unwrap();
        assert_eq!(back.faces, torus.faces);
        assert!(back.positions.iter().zip(&torus.positions).all(|(a, b)| a.distance(*b) < 1e-6));
    }
}
