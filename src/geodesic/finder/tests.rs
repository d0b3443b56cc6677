//! Shortest paths against closed forms, and the properties that all of them have.

use super::*;
use crate::surface::{SurfaceOptions, TriangleMesh, shapes};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

fn built(mesh: &TriangleMesh) -> Surface {
    Surface::build(mesh, &SurfaceOptions::default()).unwrap()
}

fn length(surface: &Surface, a: DVec3, b: DVec3) -> f64 {
    let [a, b] = [a, b].map(|p| surface.closest_point(p).unwrap().point);
    let there = surface.shortest_path(&a, &b).unwrap();
    let back = surface.shortest_path(&b, &a).unwrap();
    assert_eq!(there.length().to_bits(), back.length().to_bits());
    assert!(!there.is_frozen());
    there.length()
}

#[test]
fn plane() {
    let surface = built(&shapes::grid(17, 11, 3.0, 2.0));
    let mut finder = PathFinder::new();
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..1000 {
        let [a, b] = [(); 2].map(|()| DVec3::new(3.0 * random(), 2.0 * random(), 0.0));
        let [p, q] = [a, b].map(|x| surface.closest_point(x).unwrap().point);
        let path = finder.shortest(&surface, &p, &q).unwrap();
        assert!((path.length() - a.distance(b)).abs() < 1e-12);
        for x in path.positions(&surface) {
            let off = (b - a).cross(x - a).length() / a.distance(b).max(1e-9);
            assert!(off < 1e-12, "{off}");
        }
    }
    // Through vertices, along edges.
    assert!((length(&surface, DVec3::ZERO, DVec3::new(3.0, 2.0, 0.0)) - 13.0_f64.sqrt()).abs() < 1e-12);
    assert!((length(&surface, DVec3::ZERO, DVec3::new(3.0, 0.0, 0.0)) - 3.0).abs() < 1e-12);
}

#[test]
fn opposite_corners_of_a_cube() {
    let surface = built(&shapes::cube());
    assert!((length(&surface, DVec3::ZERO, DVec3::ONE) - 5.0_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn spider_and_fly() {
    let mut room = shapes::cube();
    room.positions.iter_mut().for_each(|p| *p *= DVec3::new(12.0, 12.0, 30.0));
    let surface = built(&room);
    let found = length(&surface, DVec3::new(6.0, 1.0, 0.0), DVec3::new(6.0, 11.0, 30.0));
    // Local optima over three, four and five walls.
    let optima = [42.0, (37.0_f64 * 37.0 + 17.0 * 17.0).sqrt(), 40.0];
    assert!(optima.iter().any(|o| (found - o).abs() < 1e-9), "{found}");
}

#[test]
fn prism_approaches_the_cylinder() {
    let mut errors = Vec::new();
    for n in [64_u32, 128, 256] {
        let surface = built(&shapes::cylinder(n, 40, 4.0));
        let at = |turn: f64, z: f64| DVec3::new(turn.cos(), turn.sin(), z);
        errors.push(3.905_124_837_8 - length(&surface, at(0.3, 0.5), at(2.8, 3.5)));
    }
    assert!(errors.iter().all(|e| *e > 0.0 && *e < 5e-3), "{errors:?}");
    assert!((errors[0] / errors[1]).log2() > 1.7 && (errors[1] / errors[2]).log2() > 1.7, "{errors:?}");
}

#[test]
fn cones() {
    for (half_angle, expected) in [
        (PI / 6.0, [1.220_520_279_4, 1.684_871_145_4, 2.236_067_977_5]),
        (PI / 4.0, [1.399_650_532_0, 2.091_942_929_7, 2.724_481_504_5]),
    ] {
        let surface = built(&shapes::cone(720, 4, half_angle));
        let at = |phi: f64, s: f64| {
            DVec3::new(s * half_angle.sin() * phi.cos(), s * half_angle.sin() * phi.sin(), s * half_angle.cos())
        };
        for (turn, expected) in [1.0, 2.0, PI].into_iter().zip(expected) {
            let found = length(&surface, at(0.01, 1.0), at(0.01 + turn, 2.0));
            assert!((found - expected).abs() < 3e-5, "{half_angle} {turn}: {found} for {expected}");
        }
    }
}

#[test]
fn sphere_error_falls_with_the_square_of_the_edges() {
    let ends = [DVec3::new(1.0, 0.2, 0.1).normalize(), DVec3::new(-0.3, 0.9, 0.4).normalize()];
    let exact = ends[0].angle_between(ends[1]);
    let errors: Vec<f64> =
        (2..6).map(|level| (length(&built(&shapes::icosphere(level)), ends[0], ends[1]) - exact).abs()).collect();
    let slope = (errors[0] / errors[3]).log2() / 3.0;
    assert!((1.7..2.3).contains(&slope), "{errors:?}");
}

#[test]
fn torus() {
    let surface = built(&shapes::torus(2.0, 1.0, 360, 180));
    let at = |u: f64, v: f64| DVec3::new((2.0 + v.cos()) * u.cos(), (2.0 + v.cos()) * u.sin(), v.sin());
    for (u, v, expected) in [(PI / 3.0, FRAC_PI_2, 3.055_501_69), (1.0, 2.0, 3.005_309_21)] {
        let found = length(&surface, at(0.0, 0.0), at(u, v));
        assert!((found - expected).abs() < 1e-3, "{found} for {expected}");
    }
}

#[test]
fn around_a_hole() {
    let mut mesh = shapes::grid(16, 16, 4.0, 4.0);
    let inside = |p: DVec3| p.x > 1.0 && p.x < 3.0 && p.y > 1.0 && p.y < 3.0;
    let positions = mesh.positions.clone();
    mesh.faces.retain(|t| !inside(t.iter().map(|v| positions[*v as usize]).sum::<DVec3>() / 3.0));
    let surface = built(&mesh);
    assert_eq!(surface.report().boundary_loops, 2);
    let found = length(&surface, DVec3::new(0.0, 2.0, 0.0), DVec3::new(4.0, 2.0, 0.0));
    assert!((found - 4.828_427_124_7).abs() < 1e-9, "{found}");
}

#[test]
fn saddle() {
    let n = 160;
    let mut mesh = shapes::grid(n, n, 2.4, 2.4);
    for p in &mut mesh.positions {
        *p -= DVec3::new(1.2, 1.2, 0.0);
        p.z = p.x * p.x - p.y * p.y;
    }
    let surface = built(&mesh);
    let on = |x: f64, y: f64| DVec3::new(x, y, x * x - y * y);
    let [a, b] = [on(-1.0, -0.5), on(0.8, 0.9)].map(|p| surface.closest_point(p).unwrap().point);
    let path = surface.shortest_path(&a, &b).unwrap();
    assert!((path.length() - 2.542_313_9).abs() < 2e-4, "{}", path.length());
    let middle = surface.position(&path.at(&surface, 0.5).unwrap());
    assert!(middle.distance(on(-0.175_48, 0.119_92)) < 2e-2, "{middle}");
}

#[test]
fn half_way_around_a_cylinder_both_ways_are_one_length() {
    let surface = built(&shapes::cylinder(256, 40, 4.0));
    let at = |turn: f64, z: f64| DVec3::new(turn.cos(), turn.sin(), z);
    let found = length(&surface, at(0.0, 0.5), at(PI, 3.5));
    assert!((found - 4.343_915_791_3).abs() < 1e-3, "{found}");
}

#[test]
fn long_faces_do_not_lead_the_wrong_way_around() {
    // Eight quads as high as the prism: centres and middles of sides say nothing about its ends.
    let surface = built(&shapes::cylinder(8, 1, 100.0));
    let at = |side: f64, z: f64| {
        let corner = |k: f64| DVec3::new((k * PI / 4.0).cos(), (k * PI / 4.0).sin(), z);
        corner(side.floor()).lerp(corner(side.floor() + 1.0), side.fract())
    };
    let width = 2.0 * (PI / 8.0).sin();
    for (from, to) in [((0.3, 99.0), (3.6, 99.5)), ((0.3, 1.0), (7.6, 2.0)), ((2.5, 50.0), (5.9, 97.0))] {
        let found = length(&surface, at(from.0, from.1), at(to.0, to.1));
        let sides: f64 = to.0 - from.0;
        let expected = (sides.min(8.0 - sides) * width).hypot(to.1 - from.1);
        assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
    }
}

/// A closed surface with bumps and saddles at random.
fn potato(seed: f64) -> TriangleMesh {
    let mut mesh = shapes::icosphere(4);
    for p in &mut mesh.positions {
        let waves = (3.1 * p.x + seed).sin() * (2.7 * p.y).cos() + (4.3 * p.z - 2.0 * seed).sin();
        *p *= 1.0 + 0.2 * waves;
    }
    mesh
}

#[test]
fn paths_on_potatoes_have_the_properties_of_paths() {
    for seed in [0.3, 1.7] {
        let mesh = potato(seed);
        let surface = built(&mesh);
        let mut shuffled = mesh.clone();
        let n = shuffled.faces.len();
        (0..n).for_each(|i| shuffled.faces.swap(i, (i * 7919 + 5) % n));
        let other = built(&shuffled);
        let mut finder = PathFinder::new();
        let faces = |i: usize| [i * 97 % n, i * 389 % n].map(|f| crate::surface::FaceId(f as u32));
        for i in 1..60 {
            let [p, q] = faces(i).map(|f| surface.point(f, [0.2, 0.5, 0.3]).unwrap());
            let path = finder.shortest(&surface, &p, &q).unwrap();
            let [a, b] = [&p, &q].map(|x| surface.position(x));
            assert!(path.length() >= a.distance(b) * (1.0 - 1e-12));
            // Consecutive stretches meet, each inside one face.
            let positions = path.positions(&surface);
            let mut here = a;
            for (k, stretch) in path.segments(&surface).enumerate() {
                let ends =
                    [stretch.from, stretch.to].map(|w| surface.position(&surface.point(stretch.face, w).unwrap()));
                assert!(ends[0].distance(here) < 1e-12 && ends[1].distance(positions[k + 1]) < 1e-12);
                here = ends[1];
            }
            assert!(here.distance(b) < 1e-12);
            // Straightening again moves nothing.
            let inner = InnerPath::from_outer(&surface, &path).unwrap();
            let mut again = InnerPath::default();
            finder.continue_inner(&surface, &inner.start, &inner.end, &mut inner.strip.clone(), &mut again);
            assert_eq!(again.strip, inner.strip);
            // Another order of faces, the same places: the same length, if the same way is taken.
            let [p, q] = [a, b].map(|x| other.closest_point(x).unwrap().point);
            let relative = finder.shortest(&other, &p, &q).unwrap().length() / path.length() - 1.0;
            assert!(relative.abs() < 1e-10 || relative.abs() > 1e-7, "{relative}");
            assert!(relative.abs() < 5e-3, "{relative}");
        }
    }
}

/// Two points on either side of a blunt tip: both ways around are straight, and one is longer.
#[test]
fn the_shorter_of_two_ways_around_a_tip_is_found_beside_the_longer() {
    let half_angle = 75_f64.to_radians();
    let surface = built(&shapes::cone(60, 1, half_angle));
    let at = |phi: f64| {
        let place = 0.5 * DVec3::new(half_angle.sin() * phi.cos(), half_angle.sin() * phi.sin(), half_angle.cos());
        surface.closest_point(place).unwrap().point
    };
    let mut finder = PathFinder::new();
    let mut long = GeodesicPath::at_rest(at(0.01));
    for k in 1..=8 {
        long = finder.continued(&surface, &long, &at(0.01 + 3.2 * f64::from(k) / 8.0)).unwrap();
    }
    let inner = InnerPath::from_outer(&surface, &long).unwrap();
    let mut beside = InnerPath::default();
    let mut strip = inner.strip.clone();
    finder.straightener.run_thoroughly(&surface, inner.start, inner.end, &mut strip, &mut beside);
    let developed = (std::f64::consts::TAU - 3.2) * half_angle.sin();
    assert!(long.length() > beside.length * 1.0005 && !beside.frozen);
    assert!((beside.length - (0.5 * developed).sin()).abs() < 1e-3, "{} {}", beside.length, long.length());
}

#[test]
fn separate_pieces_have_no_path() {
    let mut mesh = shapes::cube();
    let n = mesh.positions.len() as u32;
    mesh.positions.extend(shapes::cube().positions.iter().map(|p| *p + DVec3::X * 5.0));
    mesh.faces.extend(shapes::cube().faces.iter().map(|t| t.map(|v| v + n)));
    let surface = built(&mesh);
    let [a, b] = [DVec3::ZERO, DVec3::X * 5.0].map(|p| surface.closest_point(p).unwrap().point);
    assert!(matches!(surface.shortest_path(&a, &b), Err(PathError::NoPath { .. })));
}

#[test]
fn the_same_point_is_no_way_away() {
    let surface = built(&shapes::icosphere(2));
    for weights in [[0.2, 0.3, 0.5], [0.0, 0.5, 0.5], [0.0, 1.0, 0.0]] {
        let p = surface.point(crate::surface::FaceId(5), weights).unwrap();
        let q = surface.canonical(&p).unwrap();
        assert_eq!(surface.shortest_path(&p, &q).unwrap().length(), 0.0);
    }
}
