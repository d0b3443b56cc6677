//! What the modes promise.

use super::*;
use crate::geodesic::{PathFinder, inner::InnerPath};
use crate::surface::shapes;

fn meshes() -> Vec<(&'static str, Surface)> {
    let mut bumpy = shapes::icosphere(4);
    for p in &mut bumpy.positions {
        *p *= 1.0 + 0.2 * (5.0 * p.x).sin() * (4.0 * p.y + 1.0).sin() * (6.0 * p.z + 2.0).sin();
    }
    vec![
        ("grid", built(&shapes::grid(40, 40, 1.0, 1.0))),
        ("bumpy", built(&bumpy)),
        ("torus", built(&shapes::torus(2.0, 0.7, 60, 30))),
        ("cylinder", built(&shapes::cylinder(30, 20, 3.0))),
    ]
}

#[test]
fn geodesic_is_what_the_path_engine_makes_of_the_strip() {
    for (name, surface) in meshes() {
        let (mut random, mut workspace) = (Random(11), SmoothWorkspace::default());
        let mut alike = 0;
        for _ in 0..20 {
            let line = jagged(&surface, &mut random, 150);
            let mut strip = Strip::default();
            line.strip_into(&surface, &mut strip).unwrap();
            let mut path = InnerPath::default();
            PathFinder::new().continue_inner(&surface, &strip.start, &strip.end, &mut strip.sides, &mut path);
            let by = Smoothing::by(SmoothingMode::Geodesic);
            let straight = smooth(&surface, &mut workspace, &line, &by).unwrap();
            assert!((straight.after.length - path.length).abs() < 1e-12 * path.length.max(1e-3), "{name}");
            // The solves lead to a locally shortest line too, mostly the same one.
            let solved = Smoothing { roughness: 0.0, ..Smoothing::tether(0.0) };
            let solved = smooth(&surface, &mut workspace, &line, &solved).unwrap();
            alike += usize::from((solved.after.length / path.length - 1.0).abs() < 1e-5);
            assert!(solved.after.length <= solved.before.length * (1.0 + 1e-9), "{name}");
            // So do sweeps, if slowly.
            let swept = Smoothing { iteration: Iteration::Sequential, max_sweeps: 2000, ..by };
            let swept = smooth(&surface, &mut workspace, &line, &swept).unwrap();
            assert!(
                swept.after.length <= swept.before.length && swept.after.length < 0.7 * swept.before.length,
                "{name}"
            );
        }
        println!("{name}: {alike} of 20 the same by solving");
        assert!(alike >= 14, "{name}: {alike}");
    }
}

#[test]
fn without_a_tether_lines_on_a_plane_are_straight() {
    let surface = built(&shapes::grid(30, 30, 1.0, 1.0));
    let (mut random, mut workspace) = (Random(12), SmoothWorkspace::default());
    for _ in 0..20 {
        let line = jagged(&surface, &mut random, 200);
        let [a, b] = line.ends().map(|p| surface.position(&p));
        let straight = smooth(&surface, &mut workspace, &line, &Smoothing::by(SmoothingMode::Geodesic)).unwrap();
        assert!((straight.after.length - a.distance(b)).abs() < 1e-10, "{}", straight.after.length - a.distance(b));
        let loose =
            smooth(&surface, &mut workspace, &line, &Smoothing { roughness: 0.0, ..Smoothing::tether(0.0) }).unwrap();
        assert!((loose.after.length - a.distance(b)).abs() < 1e-5 * (1e-3 + a.distance(b)), "{}", loose.after.length);
    }
}

#[test]
fn a_polygonal_circle_keeps_its_radius_and_its_turn() {
    let surface = built(&shapes::grid(60, 60, 1.0, 1.0));
    let middle = DVec3::new(0.503, 0.497, 0.0);
    let around = |k: u32| {
        let a = f64::from(k) * std::f64::consts::TAU / 40.0;
        middle + 0.3 * DVec3::new(a.cos(), a.sin(), 0.0)
    };
    let circle = ring(&surface, (0..40).map(around));
    let mut workspace = SmoothWorkspace::default();
    for iteration in [Iteration::Solve, Iteration::Symmetric] {
        let smoothing = Smoothing { iteration, ..Smoothing::by(SmoothingMode::Stencil { scale: 1.0, passes: 20 }) };
        let kept = smooth(&surface, &mut workspace, &circle, &smoothing).unwrap();
        println!("{:?} {:?}", kept.before, kept.after);
        assert!((kept.after.total_turn - std::f64::consts::TAU).abs() < 0.06, "{}", kept.after.total_turn);
        for p in kept.line.positions(&surface) {
            assert!((p.distance(middle) - 0.3).abs() < 0.003, "{iteration:?}: {}", p.distance(middle));
        }
    }
    let shrunk = Smoothing::by(SmoothingMode::Geodesic);
    assert!(matches!(smooth(&surface, &mut workspace, &circle, &shrunk), Err(SmoothError::Collapsed { .. })));
}

#[test]
fn closer_tethers_make_longer_lines_that_are_nearer() {
    for (name, surface) in meshes() {
        let (mut random, mut workspace) = (Random(13), SmoothWorkspace::default());
        for round in 0..6 {
            let line = jagged(&surface, &mut random, 150);
            let mut last: Option<Smoothed> = None;
            for closeness in [0.0, 0.1, 1.0, 10.0, 100.0, 1e3, 1e5] {
                let smoothing = Smoothing { roughness: 0.0, ..Smoothing::tether(closeness) };
                let here = smooth(&surface, &mut workspace, &line, &smoothing).unwrap();
                assert!(here.after.total_turn <= here.before.total_turn * (1.0 + 1e-9), "{name} {round} {closeness}");
                if let Some(last) = &last {
                    // Up to jumps between local minima.
                    assert!(here.after.length >= 0.995 * last.after.length, "{name} {round} {closeness}");
                }
                last = Some(here);
            }
            let close = last.unwrap();
            assert!(
                close.after.max_distance < 0.6 * surface.mean_edge[0],
                "{name} {round}: {}",
                close.after.max_distance
            );
        }
    }
}

/// The mean of (d / reach)² along a line, d the distance from the line given.
fn mean_square_distance(surface: &Surface, smoothed: &Smoothed, given: &SurfacePolyline) -> f64 {
    let reach = 10.0 * surface.mean_edge[0];
    let (line, given) = (smoothed.line.positions(surface), given.positions(surface));
    let (mut sum, mut length) = (0.0, 0.0);
    for pair in line.windows(2) {
        let long = pair[0].distance(pair[1]);
        let square = |p: DVec3| (distance(p, &given) / reach).powi(2);
        sum += long * (square(pair[0]) + 4.0 * square(pair[0].midpoint(pair[1])) + square(pair[1])) / 6.0;
        length += long;
    }
    sum / length
}

/// Lines drawn by a hand that trembles: from closeness to closeness no shorter by more than half a per cent, no farther by more than half a
/// per cent of the reach, and never rougher than drawn.
#[test]
fn closeness_is_monotone() {
    for (name, surface) in meshes() {
        let (mut random, mut workspace) = (Random(18), SmoothWorkspace::default());
        let (edge, size) = (surface.mean_edge[0], surface.diagonal());
        let (mut shorter, mut farther) = (0.0_f64, 0.0_f64);
        for round in 0..6 {
            // A walk over the surface, in the direction in which it sets out, and off it by up to an edge to either side.
            let mut points = Vec::new();
            let start = surface.positions[(random.word() % surface.positions.len() as u64) as usize] + surface.origin;
            let axis = DVec3::new(random.next() - 0.5, random.next() - 0.5, random.next() - 0.5).normalize();
            for k in 0..60 {
                let tremor = DVec3::new(random.next() - 0.5, random.next() - 0.5, random.next() - 0.5) * 2.0 * edge;
                points.push(at(&surface, start + axis * 0.4 * size * f64::from(k) / 60.0 + tremor));
            }
            points.dedup();
            let line = SurfacePolyline::through(&surface, &mut workspace.finder, &points, false).unwrap();
            let mut last: Option<(f64, f64)> = None;
            for closeness in [0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4] {
                let smoothing = Smoothing { roughness: 0.0, ..Smoothing::tether(closeness) };
                let here = smooth(&surface, &mut workspace, &line, &smoothing).unwrap();
                assert!(here.after.total_turn <= here.before.total_turn * (1.0 + 1e-9), "{name} {round} {closeness}");
                let square = mean_square_distance(&surface, &here, &line);
                if let Some((length, before)) = last {
                    shorter = shorter.max(1.0 - here.after.length / length);
                    farther = farther.max(square.sqrt() - before.sqrt());
                }
                last = Some((here.after.length, square));
            }
        }
        println!("{name}: shorter by {shorter:.1e}, farther by {farther:.1e} reaches (seed 18)");
        assert!(shorter <= 0.005 && farther <= 0.005, "{name}: {shorter} {farther}");
    }
}

#[test]
fn nothing_leaves_the_envelope() {
    for (name, surface) in meshes() {
        let (mut random, mut workspace) = (Random(14), SmoothWorkspace::default());
        let edge = surface.mean_edge[0];
        for _ in 0..5 {
            let line = jagged(&surface, &mut random, 120);
            for far in [0.3 * edge, edge, 4.0 * edge] {
                for mode in [
                    SmoothingMode::Geodesic,
                    SmoothingMode::Stencil { scale: 0.5, passes: 5 },
                    SmoothingMode::Tether { closeness: 1.0 },
                    SmoothingMode::Budget { share: 0.1 },
                ] {
                    for envelope in [Envelope::Hard(far), Envelope::Soft(far)] {
                        let smoothing = Smoothing { max_sweeps: 500, ..Smoothing::by(mode) }.within(envelope);
                        let held = smooth(&surface, &mut workspace, &line, &smoothing).unwrap();
                        // Every vertex and a dozen places between, against the whole line given.
                        let (given, made) = (line.positions(&surface), held.line.positions(&surface));
                        let mut off = 0.0_f64;
                        for pair in made.windows(2) {
                            for k in 0..12 {
                                off = off.max(distance(pair[0].lerp(pair[1], f64::from(k) / 12.0), &given));
                            }
                        }
                        assert!(off <= far * 1.001 + 1e-3 * edge, "{name} {mode:?} {envelope:?}: {}", off / far);
                        assert!(held.after.length <= held.before.length * 1.000_001, "{name} {mode:?} {envelope:?}");
                    }
                }
            }
        }
    }
}

fn distance(p: DVec3, line: &[DVec3]) -> f64 {
    line.windows(2).fold(f64::INFINITY, |least, pair| {
        let way = pair[1] - pair[0];
        let share = ((p - pair[0]).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        least.min(p.distance(pair[0] + share * way))
    })
}

#[test]
fn fixed_crossings_stay() {
    for (name, surface) in meshes() {
        let (mut random, mut workspace) = (Random(15), SmoothWorkspace::default());
        for _ in 0..8 {
            let mut line = jagged(&surface, &mut random, 120);
            let count = line.crossings().len();
            let pins = [count / 5, count / 2, count / 2 + 1, 4 * count / 5];
            pins.iter().for_each(|i| line.set_fixed(*i, true).unwrap());
            let fixed = pins.map(|i| line.crossings()[i]);
            for mode in [
                SmoothingMode::Geodesic,
                SmoothingMode::Stencil { scale: 1.0, passes: 5 },
                SmoothingMode::Tether { closeness: 1.0 },
                SmoothingMode::Lift { weight: 1.0 },
                SmoothingMode::Conformal { weight: 1.0 },
                SmoothingMode::Budget { share: 0.3 },
            ] {
                let smoothing = Smoothing { max_sweeps: 1000, ..Smoothing::by(mode) };
                let done = smooth(&surface, &mut workspace, &line, &smoothing).unwrap();
                let kept: Vec<_> = (0..done.line.crossings().len())
                    .filter(|i| done.line.is_fixed(*i))
                    .map(|i| done.line.crossings()[i])
                    .collect();
                assert_eq!(kept, fixed, "{name} {mode:?}");
            }
        }
    }
}

#[test]
fn what_is_smooth_stays_and_twice_moves_less_than_once() {
    for (name, surface) in meshes() {
        let (mut random, mut workspace) = (Random(16), SmoothWorkspace::default());
        let mut moved = [0.0; 2];
        for round in 0..10 {
            let line = jagged(&surface, &mut random, 200);
            let once = smooth(&surface, &mut workspace, &line, &Smoothing::default()).unwrap();
            let twice = smooth(&surface, &mut workspace, &once.line, &Smoothing::default()).unwrap();
            moved = [moved[0] + once.after.max_distance, moved[1] + twice.after.max_distance];
            let straight = smooth(&surface, &mut workspace, &line, &Smoothing::by(SmoothingMode::Geodesic)).unwrap();
            let again = smooth(&surface, &mut workspace, &straight.line, &Smoothing::default()).unwrap();
            assert!((again.after.length / straight.after.length - 1.0).abs() < 1e-6, "{name} {round}");
            assert!(again.after.max_distance < 0.1 * surface.mean_edge[0], "{name} {round}");
        }
        println!("{name}: the second time {:.3} of the first", moved[1] / moved[0]);
        assert!(moved[1] < 0.5 * moved[0], "{name}: {moved:?}");
    }
}

#[test]
fn the_same_line_whatever_was_smoothed_before() {
    let surface = built(&shapes::icosphere(4));
    let mut random = Random(17);
    let mut used = SmoothWorkspace::default();
    let mut out = Smoothed::blank();
    for round in 0..12 {
        let line = jagged(&surface, &mut random, 100 + 10 * round);
        for mode in [SmoothingMode::default(), SmoothingMode::Lift { weight: 3.0 }, SmoothingMode::Geodesic] {
            let smoothing = Smoothing::by(mode);
            let fresh = smooth(&surface, &mut SmoothWorkspace::default(), &line, &smoothing).unwrap();
            smooth_into(&surface, &mut used, &line, &smoothing, &mut out).unwrap();
            assert_eq!(fresh, out);
        }
    }
}

#[test]
fn a_barrier_keeps_off_the_boundary() {
    // A line along a side of a square, drawn so near that it would run along the boundary.
    let mut mesh = shapes::grid(30, 30, 1.0, 1.0);
    for p in &mut mesh.positions {
        p.y += 0.25 * (std::f64::consts::PI * p.x).sin(); // the lower side bends inwards
    }
    let surface = built(&mesh);
    let mut workspace = SmoothWorkspace::default();
    let curve = |x: f64| DVec3::new(x, 0.02 + 0.25 * (std::f64::consts::PI * x).sin(), 0.0);
    let points: Vec<_> = (1..30).map(|k| at(&surface, curve(f64::from(k) / 30.0))).collect();
    let line = SurfacePolyline::through(&surface, &mut workspace.finder, &points, false).unwrap();
    let bare = |smoothed: &Smoothed| {
        let inner = smoothed.line.positions(&surface);
        inner[2..inner.len() - 2]
            .iter()
            .map(|p| p.y - 0.25 * (std::f64::consts::PI * p.x).sin())
            .fold(f64::INFINITY, f64::min)
    };
    let free = smooth(&surface, &mut workspace, &line, &Smoothing::by(SmoothingMode::Geodesic)).unwrap();
    let by = Smoothing { barrier: Some(0.03), ..Smoothing::by(SmoothingMode::Geodesic) };
    let kept = smooth(&surface, &mut workspace, &line, &by).unwrap();
    println!("nearest to the boundary: {:.4} free, {:.4} with a barrier", bare(&free), bare(&kept));
    assert!(bare(&free) < 1e-3 && bare(&kept) > 0.005, "{} {}", bare(&free), bare(&kept));
}
