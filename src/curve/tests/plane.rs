//! In the plane every scheme is its Euclidean counterpart.

use glam::DVec3;

use super::*;
use crate::curve::*;
use crate::surface::TriangleMesh;

/// A random Delaunay triangulation of the unit square with positions of single precision.
pub(super) fn delaunay_square(cells: u32, seed: u64) -> TriangleMesh {
    let mut mesh = shapes::grid(cells, cells, 1.0, 1.0);
    let mut random = Random(seed);
    let step = 1.0 / f64::from(cells);
    for p in &mut mesh.positions {
        let inside = |x: f64| x > 0.0 && x < 1.0;
        let mut jitter = |free: bool| if free { 0.9 * step * (random.next() - 0.5) } else { 0.0 };
        let (x, y) = (p.x + jitter(inside(p.x)), p.y + jitter(inside(p.y)));
        // Three quarters of the plane's exactness would be lost on a tilted one: z stays 0.
        *p = DVec3::new(f64::from(x as f32), f64::from(y as f32), 0.0);
    }
    flip_to_delaunay(&mut mesh);
    mesh
}

/// Flips edges until every triangle's circumcircle is empty (Lawson 1977).
fn flip_to_delaunay(mesh: &mut TriangleMesh) {
    loop {
        let mut sides = std::collections::HashMap::new();
        for (f, t) in mesh.faces.iter().enumerate() {
            for k in 0..3 {
                sides.insert((t[k], t[(k + 1) % 3]), (f, k));
            }
        }
        let mut touched = vec![false; mesh.faces.len()];
        let mut keys: Vec<_> = sides.keys().copied().filter(|(a, b)| a < b).collect();
        keys.sort_unstable();
        let mut flipped = false;
        for (a, b) in keys {
            let (Some(&(f, k)), Some(&(g, l))) = (sides.get(&(a, b)), sides.get(&(b, a))) else { continue };
            let (c, d) = (mesh.faces[f][(k + 2) % 3], mesh.faces[g][(l + 2) % 3]);
            let p = |v: u32| mesh.positions[v as usize];
            let angle = |at: u32| (p(a) - p(at)).angle_between(p(b) - p(at));
            if touched[f] || touched[g] || angle(c) + angle(d) <= std::f64::consts::PI + 1e-9 {
                continue;
            }
            (mesh.faces[f], mesh.faces[g]) = ([c, a, d], [c, d, b]);
            (touched[f], touched[g], flipped) = (true, true, true);
        }
        if !flipped {
            return;
        }
    }
}

/// What is worth a thousand polygons, and what is not without optimisation.
fn rounds(full: usize) -> usize {
    if cfg!(debug_assertions) { full / 10 } else { full }
}

fn quadratic([a, b, c]: [DVec3; 3], t: f64) -> DVec3 {
    (1.0 - t) * (1.0 - t) * a + 2.0 * t * (1.0 - t) * b + t * t * c
}

/// A uniform B-spline by de Boor's recurrence, knots in whole numbers.
fn de_boor(degree: usize, points: &[DVec3], periodic: bool, t: f64) -> DVec3 {
    let m = points.len();
    let n = if periodic { m } else { m - degree };
    let i = (t as usize).min(n - 1);
    let knot = |k: isize| if periodic { k as f64 } else { k.clamp(0, n as isize) as f64 };
    let mut d: Vec<DVec3> = (0..=degree).map(|k| points[(i + k) % m]).collect();
    for round in 1..=degree {
        for k in (round..=degree).rev() {
            let [from, to] = [i + k, i + k + degree + 1 - round].map(|x| knot(x as isize - degree as isize));
            let a = (t - from) / (to - from);
            d[k] = d[k - 1] * (1.0 - a) + d[k] * a;
        }
    }
    d[degree]
}

pub(super) const EXACT: f64 = 1e-12 * std::f64::consts::SQRT_2;

#[test]
pub(super) fn delaunay_squares_are_what_they_say() {
    let mesh = delaunay_square(9, 3);
    let p = |v: u32| mesh.positions[v as usize];
    let doubled = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).z;
    let areas: Vec<f64> = mesh.faces.iter().map(|t| doubled(t.map(p))).collect();
    assert!(areas.iter().all(|a| *a > 0.0) && (areas.iter().sum::<f64>() - 2.0).abs() < 1e-12);
    for t in &mesh.faces {
        let [a, b, c] = t.map(p);
        for v in (0..mesh.positions.len() as u32).filter(|v| !t.contains(v)) {
            // The lifted incircle determinant.
            let row = |x: DVec3| (x - p(v)).with_z((x - p(v)).length_squared());
            assert!(row(a).dot(row(b).cross(row(c))) < 1e-9);
        }
    }
}

#[test]
fn every_scheme_is_its_euclidean_counterpart() {
    let surface = built(&delaunay_square(13, 1));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(1);
    for round in 0..rounds(1000) {
        let polygon = [(); 4].map(|()| random.in_square());
        let [a, b, c, _] = polygon;
        let points = polygon.map(|p| at(&surface, p));
        for _ in 0..50 {
            let t = random.next();
            let mut check = |points: &[SurfacePoint], scheme: Scheme, t: f64, expected: DVec3| {
                let found = surface.position(&tracer.evaluate(points, &scheme, t).unwrap());
                assert!(found.distance(expected) < EXACT, "{round} {scheme:?} {t}: {}", found.distance(expected));
            };
            for method in [Method::DeCasteljau, Method::LaneRiesenfeld, Method::Direct, Method::CentreOfMass] {
                check(&points, Scheme::of(method), t, bezier(polygon, t));
                check(&points[..3], Scheme::of(method), t, quadratic([a, b, c], t));
            }
        }
    }
}

#[test]
fn b_splines_are_de_boors() {
    let surface = built(&delaunay_square(13, 2));
    let mut workspace = TraceWorkspace::default();
    let mut random = Random(2);
    for round in 0..rounds(1000) {
        let m = 4 + round % 7;
        let polygon: Vec<DVec3> = (0..m).map(|_| random.in_square()).collect();
        let points: Vec<_> = polygon.iter().map(|p| at(&surface, *p)).collect();
        for (closed, scheme) in [
            (false, Scheme::b_spline()),
            (true, Scheme::b_spline()),
            (false, Scheme::quadratic_b_spline()),
            (true, Scheme::quadratic_b_spline()),
        ] {
            let degree = scheme.method.b_spline_degree().unwrap();
            let spline = Spline::b_spline(&surface, &points, closed).unwrap().with_scheme(scheme);
            for _ in 0..13 {
                let t = random.next() * spline.segment_count() as f64;
                let found = surface.position(&spline.evaluate(&surface, &mut workspace, SplineT(t)).unwrap());
                let expected = de_boor(degree, &polygon, closed, t);
                assert!(found.distance(expected) < EXACT, "{round} {scheme:?} {closed} {t}");
            }
        }
    }
}

#[test]
fn points_of_uniform_traces_are_the_schemes_own() {
    let surface = built(&delaunay_square(13, 4));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(3);
    for _ in 0..rounds(1000) / 5 {
        let polygon = [(); 4].map(|()| random.in_square());
        let points = polygon.map(|p| at(&surface, p));
        let mut trace = |scheme: Scheme| {
            let trace = tracer.trace(&points, &scheme).unwrap();
            trace.segments()[0].points().iter().map(|p| surface.position(p)).collect::<Vec<_>>()
        };
        // De Casteljau: the control points of all pieces, by the blossom of the whole.
        let blossom = |u: [f64; 3]| {
            let on = |p: DVec3, q: DVec3, t: f64| p + t * (q - p);
            let first = [0, 1, 2].map(|i| on(polygon[i], polygon[i + 1], u[0]));
            let second = [0, 1].map(|i| on(first[i], first[i + 1], u[1]));
            on(second[0], second[1], u[2])
        };
        let mut expected = vec![polygon[0]];
        for i in 0..16 {
            let [s, t] = [i, i + 1].map(|k| f64::from(k) / 16.0);
            expected.extend([blossom([s, s, t]), blossom([s, t, t]), blossom([t, t, t])]);
        }
        for (found, expected) in trace(Scheme::de_casteljau()).iter().zip(&expected) {
            assert!(found.distance(*expected) < EXACT);
        }
        // Lane–Riesenfeld: the blossom at three consecutive knots.
        let knot = |k: usize| k.saturating_sub(2).min(64) as f64 / 64.0;
        let found = trace(Scheme::lane_riesenfeld());
        assert_eq!(found.len(), 67);
        for (i, found) in found.iter().enumerate() {
            assert!(found.distance(blossom([knot(i), knot(i + 1), knot(i + 2)])) < EXACT);
        }
        // On the curve: the curve's own points.
        for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld().with_levels(4)] {
            let found = trace(scheme.on_curve());
            assert_eq!(found.len(), 17);
            for (i, found) in found.iter().enumerate() {
                assert!(found.distance(bezier(polygon, i as f64 / 16.0)) < EXACT);
            }
        }
    }
}

#[test]
fn derivatives_and_curvatures_are_euclidean() {
    let surface = built(&delaunay_square(13, 5));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(4);
    for _ in 0..rounds(1000) / 5 {
        let polygon = [(); 4].map(|()| random.in_square());
        let [a, b, c, d] = polygon;
        let points = polygon.map(|p| at(&surface, p));
        for _ in 0..5 {
            let t = random.next();
            let velocity = 3.0 * quadratic([b - a, c - b, d - c], t);
            let acceleration = 6.0 * ((1.0 - t) * (a - 2.0 * b + c) + t * (b - 2.0 * c + d));
            let curvature = velocity.cross(acceleration).z / velocity.length().powi(3);
            for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld(), Scheme::direct()] {
                let found = tracer.curve_point(&points, &scheme, t).unwrap();
                let derivative = surface.tangent_in_space(&found.derivative).unwrap();
                // Legs of a hundredth and shorter divide rounding by their length, curvature twice.
                assert!(derivative.distance(velocity) < 1e-9, "{scheme:?} {}", derivative.distance(velocity));
                let off = (found.curvature - curvature).abs();
                assert!(off < 1e-7 * (1.0 + curvature.abs().powi(2)), "{scheme:?} {off} of {curvature}");
            }
        }
    }
}

#[test]
fn smooth_splines_are_chordal_catmull_rom() {
    let surface = built(&delaunay_square(13, 6));
    let mut random = Random(5);
    for _ in 0..rounds(1000) {
        // Away from the sides, where handles would be cut short.
        let stops: Vec<DVec3> = (0..4).map(|_| 0.4 * random.in_square() + DVec3::new(0.3, 0.3, 0.0)).collect();
        let spline = spline_on(&surface, &stops, true);
        for i in 0..4 {
            let [x, p, n] = [stops[i], stops[(i + 3) % 4], stops[(i + 1) % 4]];
            let (d0, d1) = (x.distance(p), x.distance(n));
            let m = ((n - x) * (d0 / d1) - (p - x) * (d1 / d0)) / (d0 + d1);
            let anchor = &spline.anchors()[i];
            let [incoming, outgoing] = [anchor.incoming(), anchor.outgoing()].map(|h| surface.position(&h.point()));
            assert!(outgoing.distance(x + m * d1 / 3.0) < EXACT);
            assert!(incoming.distance(x - m * d0 / 3.0) < EXACT);
        }
    }
}

#[test]
fn adaptive_traces_turn_gently_and_follow_the_curve() {
    let surface = built(&delaunay_square(13, 7));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(6);
    for _ in 0..rounds(1000) / 5 {
        let polygon = [(); 4].map(|()| random.in_square());
        let points = polygon.map(|p| at(&surface, p));
        for base in [Scheme::de_casteljau(), Scheme::lane_riesenfeld()] {
            for scheme in [base.adaptive(), base.adaptive().on_curve()] {
                let trace = tracer.trace(&points, &scheme).unwrap();
                let segment = &trace.segments()[0];
                let found: Vec<DVec3> = segment.points().iter().map(|p| surface.position(p)).collect();
                for w in found.windows(3) {
                    let (u, v) = (w[1] - w[0], w[2] - w[1]);
                    let turn = u.cross(v).length().atan2(u.dot(v));
                    let tiny = u.length().min(v.length()) < 1e-11;
                    assert!(turn < Scheme::TURN + 1e-9 || tiny || segment.bound().is_some(), "{scheme:?} {turn}");
                }
                // Every piece begins and ends on the curve; its other control points lie near it.
                let step = if scheme.on_curve { 1 } else { 3 };
                assert_eq!((found.len() - 1) % step, 0);
                for (p, t) in found.iter().zip(segment.parameters()).step_by(step) {
                    assert!(p.distance(bezier(polygon, *t)) < EXACT, "{scheme:?} {t}");
                }
                assert!(found.len() < 400, "{}", found.len());
            }
        }
    }
}
