//! The pebble: a torus whose two radii and height swell and sink in smooth waves. It is closed, of genus 1, and nowhere flat, so that
//! shortest paths can go round it more than one way.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use bevy_surface_splines::surface::{TriangleMesh, shapes};
use glam::DVec3;

/// Quads around the hole, and across the ring.
const AROUND: u32 = 104;
const ACROSS: u32 = 42;

/// The file.
pub(crate) fn file() -> String {
    obj_text(&pebble())
}

/// The connectivity of a torus, with every vertex put where [`pebble_position`] says.
fn pebble() -> TriangleMesh {
    let mut mesh = shapes::torus(1.0, 0.4, AROUND, ACROSS);
    for (index, position) in (0..).zip(&mut mesh.positions) {
        let around = f64::from(index / ACROSS) / f64::from(AROUND) * TAU;
        let across = f64::from(index % ACROSS) / f64::from(ACROSS) * TAU;
        *position = pebble_position(around, across);
    }
    mesh
}

/// The place of the angles `around` the hole and `across` the ring, y pointing up.
fn pebble_position(around: f64, across: f64) -> DVec3 {
    let ring_radius = 1.0 + 0.07 * (2.0 * around + 0.6).cos() + 0.05 * (3.0 * around).sin();
    let thickness = 0.42 + 0.07 * (2.0 * around - 0.9).sin() + 0.05 * (3.0 * around + 1.0).cos();
    let ripple = 1.0 + 0.06 * (5.0 * around + 2.0 * across).sin() + 0.04 * (3.0 * around - 3.0 * across).cos();
    let outwards = ring_radius + thickness * ripple * across.cos();
    let up = thickness * ripple * across.sin() + 0.12 * (2.0 * around + 0.4).sin();
    // The ring runs from z to x, which keeps the triangles of the torus facing outwards with y up.
    DVec3::new(outwards * around.sin(), up, outwards * around.cos())
}

/// OBJ text with five significant digits, enough for a model of this size.
fn obj_text(mesh: &TriangleMesh) -> String {
    let mut text = String::from("# A pebble with a hole, written by the example make_assets\n");
    for p in &mesh.positions {
        let _ = writeln!(text, "v {} {} {}", significant(p.x), significant(p.y), significant(p.z));
    }
    for [a, b, c] in &mesh.faces {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

/// The number rounded to five significant digits, as the shortest decimal that reads back the same.
fn significant(value: f64) -> f64 {
    let rounded: f64 = format!("{value:.4e}").parse().unwrap_or(value);
    // Tiny values are rounding of zero, and would print as a long row of digits.
    if rounded.abs() < 1e-9 { 0.0 } else { rounded }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_surface_splines::surface::{Surface, SurfaceOptions};

    #[test]
    fn the_pebble_is_clean_closed_and_has_one_hole() {
        let surface = Surface::build(&pebble(), &SurfaceOptions::default()).expect("a mesh without errors");
        let report = surface.report();
        assert!(report.is_closed() && !report.repaired() && report.consistently_oriented);
        assert_eq!((report.sheets, report.euler_characteristic), (1, 0));
        assert!(report.smallest_angle > 0.15, "smallest angle {}", report.smallest_angle);
        assert!(report.longest_edge < 0.15, "longest edge {}", report.longest_edge);
    }

    #[test]
    fn the_pebble_faces_outwards() {
        let mesh = pebble();
        let corner = |i: u32| mesh.positions[i as usize];
        let six_volumes: f64 = mesh.faces.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum();
        // A round torus of these radii holds 2π² · 1 · 0.42².
        assert!((2.5..5.0).contains(&(six_volumes / 6.0)), "volume {}", six_volumes / 6.0);
    }
}
