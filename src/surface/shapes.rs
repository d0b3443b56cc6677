//! Sample meshes made by formulas: for tests, examples and documentation.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;

use super::TriangleMesh;

/// A flat rectangle [0, width] × [0, height] in the plane z = 0, of `columns` × `rows` cells, two triangles each.
pub fn grid(columns: u32, rows: u32, width: f64, height: f64) -> TriangleMesh {
    let (columns, rows) = (columns.max(1), rows.max(1));
    let mut mesh = TriangleMesh::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let at = |n: u32, of: u32, size: f64| f64::from(n) / f64::from(of) * size;
            mesh.positions.push(DVec3::new(at(i, columns, width), at(j, rows, height), 0.0));
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let a = j * (columns + 1) + i;
            let (b, c, d) = (a + 1, a + columns + 2, a + columns + 1);
            mesh.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// The cube [0, 1]³, two triangles a side.
pub fn cube() -> TriangleMesh {
    let positions =
        (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))).collect();
    let mut mesh = TriangleMesh { positions, faces: Vec::new() };
    for side in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        mesh.push_polygon(&side);
    }
    mesh
}

/// The unit sphere: an icosahedron whose triangles were cut in four `level` times (20 · 4^level faces).
pub fn icosphere(level: u32) -> TriangleMesh {
    let phi = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut mesh = TriangleMesh::default();
    for (x, y) in [(-1.0, phi), (1.0, phi), (-1.0, -phi), (1.0, -phi)] {
        mesh.positions.push(DVec3::new(x, y, 0.0).normalize());
    }
    for (y, z) in [(-1.0, phi), (1.0, phi), (-1.0, -phi), (1.0, -phi)] {
        mesh.positions.push(DVec3::new(0.0, y, z).normalize());
    }
    for (z, x) in [(-1.0, phi), (1.0, phi), (-1.0, -phi), (1.0, -phi)] {
        mesh.positions.push(DVec3::new(x, 0.0, z).normalize());
    }
    mesh.faces = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..level.min(10) {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let m = (mesh.positions[a as usize] + mesh.positions[b as usize]).normalize();
                mesh.positions.push(m);
                mesh.positions.len() as u32 - 1
            })
        };
        let mut faces = Vec::with_capacity(mesh.faces.len() * 4);
        for &[a, b, c] in &mesh.faces {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            faces.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        mesh.faces = faces;
    }
    mesh
}

/// A surface of revolution about the z axis through rings of `segments` points; `profile` gives radius and height of each
/// ring. A radius of zero makes one point.
pub fn revolution(profile: &[(f64, f64)], segments: u32) -> TriangleMesh {
    let segments = segments.max(3);
    let mut mesh = TriangleMesh::default();
    let mut rings: Vec<Vec<u32>> = Vec::new();
    for &(radius, height) in profile {
        let points = if radius == 0.0 { 1 } else { segments };
        let first = mesh.positions.len() as u32;
        for i in 0..points {
            let (sin, cos) = (f64::from(i) / f64::from(segments) * TAU).sin_cos();
            mesh.positions.push(DVec3::new(radius * cos, radius * sin, height));
        }
        rings.push((0..=segments).map(|i| first + i % points).collect());
    }
    for pair in rings.windows(2) {
        for i in 0..segments as usize {
            let quad = [pair[0][i], pair[0][i + 1], pair[1][i + 1], pair[1][i]];
            if quad[0] == quad[1] {
                mesh.faces.push([quad[0], quad[2], quad[3]]);
            } else if quad[2] == quad[3] {
                mesh.faces.push([quad[0], quad[1], quad[2]]);
            } else {
                mesh.push_polygon(&quad);
            }
        }
    }
    mesh
}

/// An open prism about the z axis: `segments` sides of circumradius 1, heights 0 to `height` in `rows` rows.
pub fn cylinder(segments: u32, rows: u32, height: f64) -> TriangleMesh {
    let rows = rows.max(1);
    let profile: Vec<_> = (0..=rows).map(|j| (1.0, height * f64::from(j) / f64::from(rows))).collect();
    revolution(&profile, segments)
}

/// An open pyramid with its apex at the origin, widening along z: slant length 1 a row, `half_angle` between axis and edge.
pub fn cone(segments: u32, rows: u32, half_angle: f64) -> TriangleMesh {
    let (sin, cos) = half_angle.sin_cos();
    let profile: Vec<_> = (0..=rows.max(1)).map(|j| (sin * f64::from(j), cos * f64::from(j))).collect();
    revolution(&profile, segments)
}

/// A torus about the z axis with the given radii, `around` × `across` quads cut in two.
pub fn torus(major: f64, minor: f64, around: u32, across: u32) -> TriangleMesh {
    let (n, m) = (around.max(3), across.max(3));
    let mut mesh = TriangleMesh::default();
    for i in 0..n {
        for j in 0..m {
            let (su, cu) = (f64::from(i) / f64::from(n) * TAU).sin_cos();
            let (sv, cv) = (f64::from(j) / f64::from(m) * TAU).sin_cos();
            mesh.positions.push(DVec3::new((major + minor * cv) * cu, (major + minor * cv) * su, minor * sv));
        }
    }
    for i in 0..n {
        for j in 0..m {
            let at = |i: u32, j: u32| (i % n) * m + j % m;
            mesh.push_polygon(&[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh
}
