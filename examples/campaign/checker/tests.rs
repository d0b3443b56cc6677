//! The checker passes true paths and fails spoilt ones.

use std::f64::consts::TAU;

use bevy_surface_splines::{
    geodesic::PathFinder,
    surface::{FaceId, Surface, SurfaceOptions, TriangleMesh, shapes},
};
use glam::{DVec2, DVec3};

use super::{Claim, Fault, Stretch, Topology, check, length, mutation, walker};
use crate::{judge, random::SplitMix64};

fn bumpy_grid() -> TriangleMesh {
    let mut mesh = shapes::grid(20, 20, 1.0, 1.0);
    for p in &mut mesh.positions {
        p.z = 0.08 * (TAU * p.x).sin() * (TAU * 1.5 * p.y).cos();
    }
    mesh
}

/// Judges a path by its own ends and length.
fn judge(topology: &Topology, path: &[Stretch]) -> Result<usize, Fault> {
    let (first, last) = (path[0], path[path.len() - 1]);
    let (start, end) = ((first.face, first.from), (last.face, last.to));
    check(topology, &Claim { start, end, length: length(topology, path), stretches: path })
}

/// A straight walk from a random place in a random direction.
fn random_walk(topology: &Topology, random: &mut SplitMix64, distance: f64) -> Vec<Stretch> {
    let face = (random.next() % topology.corners.len() as u64) as u32;
    let (a, b) = (random.unit(), random.unit());
    let (u, v) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
    walker::walk(topology, face, [1.0 - u - v, u, v], random.unit() * TAU, distance)
}

/// Every mutant of a path must fail; returns how many there were of each kind.
fn assert_mutants_fail(topology: &Topology, path: &[Stretch]) -> [usize; 4] {
    let mut tried = [0; 4];
    let whole = length(topology, path);
    for i in 0..path.len() - 1 {
        if let Some(mutant) = mutation::moved_crossing(topology, path, i, 0.02) {
            // A move in a very thin stretch of path may stay below what counts: it must lengthen the path to be one.
            if length(topology, &mutant) > whole * (1.0 + 1e-8) {
                tried[0] += 1;
                assert!(matches!(judge(topology, &mutant), Err(Fault::Bent { .. })), "moved after {i}: {path:?}");
            }
        }
        // A stretch without length about a vertex may go: the path is the same line.
        if let Some(mutant) = mutation::without_face(path, i)
            && path[i].length(topology) > 1e-6 * whole
        {
            tried[1] += 1;
            assert!(matches!(judge(topology, &mutant), Err(Fault::Torn { .. })), "without {i}");
        }
        if let Some(mutant) = mutation::undone_flip(topology, path, i)
            && length(topology, &mutant) > whole * (1.0 + 1e-8)
        {
            tried[2] += 1;
            assert!(matches!(judge(topology, &mutant), Err(Fault::Bent { .. })), "undone flip after {i}: {mutant:?}");
        }
        if let Some(mutant) = mutation::wrapped(topology, path, i, 1e-8)
            && length(topology, &mutant) > whole * (1.0 + 1e-6)
        {
            tried[3] += 1;
            assert!(matches!(judge(topology, &mutant), Err(Fault::Bent { .. })), "wrapped after {i}: {mutant:?}");
        }
    }
    tried
}

fn assert_lengths_and_numbers_count(topology: &Topology, path: &[Stretch]) {
    let (first, last) = (path[0], path[path.len() - 1]);
    let whole = length(topology, path);
    let claim = Claim { start: (first.face, first.from), end: (last.face, last.to), length: whole, stretches: path };
    for wrong in [whole * (1.0 + 1e-8), whole * (1.0 - 1e-8), 0.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(check(topology, &Claim { length: wrong, ..claim }), Err(Fault::Length { .. })), "{wrong}");
    }
    let elsewhere = (first.face, [0.2, 0.3, 0.5]);
    assert_eq!(check(topology, &Claim { start: elsewhere, ..claim }), Err(Fault::Start));
    assert_eq!(check(topology, &Claim { end: elsewhere, ..claim }), Err(Fault::End));
    for i in 0..path.len() {
        let mut mutant = path.to_vec();
        mutant[i].to[1] = f64::NAN;
        assert_eq!(judge(topology, &mutant), Err(Fault::NotFinite { stretch: i }));
        mutant[i].to = [1.5, -0.5, 0.0];
        assert_eq!(judge(topology, &mutant), Err(Fault::Weights { stretch: i }));
        mutant[i].face = u32::MAX;
        assert!(matches!(check(topology, &Claim { stretches: &mutant, ..claim }), Err(Fault::NoFace { .. })));
    }
}

#[test]
fn straight_walks_pass_and_their_mutants_fail() {
    let meshes = [
        ("grid", shapes::grid(9, 7, 1.3, 1.0), 0.9),
        ("cube", shapes::cube(), 1.2),
        ("icosphere", shapes::icosphere(3), 2.0),
        ("torus", shapes::torus(2.0, 0.8, 40, 20), 3.0),
        ("bumpy grid", bumpy_grid(), 0.8),
    ];
    for (name, mesh, distance) in meshes {
        let topology = Topology::new(&mesh);
        let mut random = SplitMix64::new(11);
        let mut tried = [0; 4];
        for _ in 0..60 {
            let path = random_walk(&topology, &mut random, distance);
            assert_eq!(judge(&topology, &path), Ok(0), "{name}: {path:?}");
            let mutants = assert_mutants_fail(&topology, &path);
            tried = std::array::from_fn(|k| tried[k] + mutants[k]);
            assert_lengths_and_numbers_count(&topology, &path);
        }
        assert!(tried.iter().all(|n| *n >= 40), "{name}: {tried:?}");
    }
}

#[test]
fn a_line_on_a_flat_grid_passes_through_vertices_and_along_sides() {
    let topology = Topology::new(&shapes::grid(4, 4, 4.0, 4.0));
    for end in [[3.0, 3.0], [3.0, 1.0], [1.0, 3.0], [3.0, 2.0], [2.5, 3.25]] {
        let path = walker::draw(&topology, &[DVec2::new(1.0, 1.0), DVec2::from(end)]);
        assert_eq!(judge(&topology, &path), Ok(0), "{end:?}: {path:?}");
    }
    for bend in [[2.0, 1.0], [2.0, 2.0], [2.25, 1.5]] {
        let path = walker::draw(&topology, &[DVec2::new(0.5, 1.5), DVec2::from(bend), DVec2::new(3.5, 1.25)]);
        assert!(matches!(judge(&topology, &path), Err(Fault::Bent { .. })), "{bend:?}");
    }
}

#[test]
fn at_a_hole_only_the_inner_side_counts() {
    let mut mesh = shapes::grid(4, 4, 4.0, 4.0);
    let inside = |p: DVec3| (1.0..=3.0).contains(&p.x) && (1.0..=3.0).contains(&p.y);
    mesh.faces.retain(|t| !t.iter().all(|v| inside(mesh.positions[*v as usize])));
    let topology = Topology::new(&mesh);
    let path =
        |corners: &[[f64; 2]]| walker::draw(&topology, &corners.iter().map(|p| DVec2::from(*p)).collect::<Vec<_>>());
    let around = path(&[[0.0, 2.0], [1.0, 3.0], [3.0, 3.0], [4.0, 2.0]]);
    assert!((length(&topology, &around) - (2.0 * 2.0_f64.sqrt() + 2.0)).abs() < 1e-14);
    assert_eq!(judge(&topology, &around), Ok(0));
    let detour = path(&[[0.0, 2.0], [1.0, 3.0], [2.0, 3.5], [3.0, 3.0], [4.0, 2.0]]);
    assert!(matches!(judge(&topology, &detour), Err(Fault::Bent { .. })));
    let out_of_the_way = path(&[[0.0, 2.0], [1.0, 4.0], [3.0, 3.0], [4.0, 2.0]]);
    assert!(matches!(judge(&topology, &out_of_the_way), Err(Fault::Bent { .. })));
}

/// Eight triangles of 60° about a vertex: 480° in all.
fn saddle() -> TriangleMesh {
    // Points at distance 1 whose heights alternate; the height makes neighbours one apart.
    let chord = 2.0 * (TAU / 16.0).sin();
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for _ in 0..200 {
        let h = (low + high) / 2.0;
        if (1.0 - h * h) * chord * chord + 4.0 * h * h < 1.0 { low = h } else { high = h }
    }
    let mut mesh = TriangleMesh { positions: vec![DVec3::ZERO], faces: Vec::new() };
    for i in 0..8 {
        let (sin, cos) = (TAU * f64::from(i) / 8.0).sin_cos();
        let (flat, z) = ((1.0 - low * low).sqrt(), if i % 2 == 0 { low } else { -low });
        mesh.positions.push(DVec3::new(cos * flat, sin * flat, z));
    }
    mesh.faces = (0..8).map(|i| [0, 1 + i, 1 + (i + 1) % 8]).collect();
    mesh
}

#[test]
fn a_path_may_bend_at_a_saddle_but_not_too_far() {
    let topology = Topology::new(&saddle());
    // From the middle of face 0's rim through the hub to the rim of face k: 60° · k on one side.
    let through = |k: u32| {
        let spoke = |face: u32| Stretch { face, from: [1.0, 0.0, 0.0], to: [0.0, 0.5, 0.5] };
        let first = Stretch { face: 0, from: [0.0, 0.5, 0.5], to: [1.0, 0.0, 0.0] };
        let between = (1..k).map(|face| Stretch { face, from: [1.0, 0.0, 0.0], to: [1.0, 0.0, 0.0] });
        [first].into_iter().chain(between).chain([spoke(k)]).collect::<Vec<_>>()
    };
    for k in 1..8 {
        let verdict = judge(&topology, &through(k));
        if (3..=5).contains(&k) {
            assert_eq!(verdict, Ok(0), "{k}");
        } else {
            assert!(matches!(verdict, Err(Fault::Bent { .. })), "{k}: {verdict:?}");
        }
    }
}

#[test]
fn paths_do_not_leap_between_fans_or_across_crowded_edges() {
    // Two triangles that touch in vertex 0 only.
    let mut mesh = TriangleMesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::NEG_X, DVec3::new(-1.0, -1.0, 0.0)],
        faces: vec![[0, 1, 2], [0, 3, 4]],
    };
    let leap = [
        Stretch { face: 0, from: [0.0, 0.5, 0.5], to: [1.0, 0.0, 0.0] },
        Stretch { face: 1, from: [1.0, 0.0, 0.0], to: [0.0, 0.5, 0.5] },
    ];
    assert_eq!(judge(&Topology::new(&mesh), &leap), Err(Fault::Torn { joint: 0 }));
    // Three triangles on the edge 0–1.
    mesh.faces = vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    mesh.positions[3] = DVec3::new(0.5, -1.0, 0.5);
    let across = [
        Stretch { face: 0, from: [0.25, 0.25, 0.5], to: [0.5, 0.5, 0.0] },
        Stretch { face: 1, from: [0.5, 0.5, 0.0], to: [0.25, 0.25, 0.5] },
    ];
    assert_eq!(judge(&Topology::new(&mesh), &across), Err(Fault::Torn { joint: 0 }));
    mesh.faces.pop();
    assert!(!matches!(judge(&Topology::new(&mesh), &across), Err(Fault::Torn { .. })));
}

#[test]
fn turns_are_those_of_the_unfolded_faces() {
    let topology = Topology::new(&shapes::icosphere(3));
    let mut random = SplitMix64::new(4);
    for _ in 0..50 {
        let path = random_walk(&topology, &mut random, 1.5);
        if path.len() < 4 {
            continue;
        }
        for cut in 1..path.len() {
            let halves = [path[..cut].to_vec(), path[cut..].to_vec()];
            assert!(super::largest_turn(&super::turns(&topology, &halves)) < 1e-5, "{cut}: {path:?}");
        }
    }
    let flat = Topology::new(&shapes::grid(4, 4, 4.0, 4.0));
    for bend in [[2.0, 2.0], [2.0, 1.5], [2.2, 1.6]] {
        let bend = DVec2::from(bend);
        let (a, c) = (DVec2::new(0.5, 1.5), DVec2::new(3.1, 3.6));
        let legs = [[a, bend], [bend, c]].map(|leg| walker::draw(&flat, &leg));
        let expected = (bend - a).angle_to(c - bend).abs().to_degrees();
        assert!((super::largest_turn(&super::turns(&flat, &legs)) - expected).abs() < 1e-9, "{bend}");
    }
}

#[test]
fn the_library_s_own_paths_pass_and_their_mutants_fail() {
    for (name, mesh) in [("icosphere", shapes::icosphere(3)), ("bumpy grid", bumpy_grid())] {
        let surface = Surface::build(&mesh, &SurfaceOptions::default()).unwrap();
        let topology = Topology::new(&mesh);
        let mut finder = PathFinder::new();
        let mut random = SplitMix64::new(21);
        let mut tried = [0; 4];
        for _ in 0..60 {
            let mut point = || {
                let face = FaceId((random.next() % mesh.faces.len() as u64) as u32);
                let (a, b) = (random.unit(), random.unit());
                let (u, v) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
                surface.point(face, [1.0 - u - v, u, v]).unwrap()
            };
            let (from, to) = (point(), point());
            let path = finder.shortest(&surface, &from, &to).unwrap();
            assert_eq!(judge::path(&surface, &topology, &path, &from, &to).ok(), Some(0), "{name}: {path:?}");
            let stretches = judge::stretches(&surface, &path);
            let mutants = assert_mutants_fail(&topology, &stretches);
            tried = std::array::from_fn(|k| tried[k] + mutants[k]);
            assert_lengths_and_numbers_count(&topology, &stretches);
        }
        assert!(tried.iter().all(|n| *n >= 40), "{name}: {tried:?}");
    }
}
