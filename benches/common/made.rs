//! Meshes that the benches make themselves, and finer versions of others.

use std::collections::HashMap;
use std::f64::consts::TAU;

use bevy_surface_splines::surface::{TriangleMesh, shapes};
use glam::DVec3;

/// A sphere with hills of a quarter of its radius, of 20 · 4^level faces.
pub(crate) fn bumpy_sphere(level: u32) -> TriangleMesh {
    let mut mesh = shapes::icosphere(level);
    for p in &mut mesh.positions {
        let hills = (5.0 * p.x).sin() * (4.0 * p.y + 1.0).sin() * (6.0 * p.z + 2.0).sin();
        *p *= 1.0 + 0.25 * hills;
    }
    mesh
}

/// A torus with ripples, of about as many faces as asked for.
pub(crate) fn rippled_torus(faces: u32) -> TriangleMesh {
    let across = (f64::from(faces) / 4.0).sqrt() as u32;
    let mut mesh = shapes::torus(2.0, 1.0, 2 * across, across);
    for p in &mut mesh.positions {
        let around = p.y.atan2(p.x);
        p.z += 0.05 * (9.0 * around).sin() * (3.0 * p.length() * TAU / 2.0).cos();
    }
    mesh
}

/// The same surface with every face cut in four at the middles of its sides.
pub(crate) fn refined(mesh: &TriangleMesh) -> TriangleMesh {
    let mut positions = mesh.positions.clone();
    positions.reserve(mesh.faces.len() * 3 / 2);
    let mut faces = Vec::with_capacity(mesh.faces.len() * 4);
    let mut middles: HashMap<(u32, u32), u32> = HashMap::with_capacity(mesh.faces.len() * 3 / 2);
    for &[a, b, c] in &mesh.faces {
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let middle: DVec3 = (positions[a as usize] + positions[b as usize]) / 2.0;
                positions.push(middle);
                positions.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        faces.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    TriangleMesh { positions, faces }
}
