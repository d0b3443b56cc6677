//! Schemes on developable surfaces and at their limits: cylinder, cone, corner of a cube, degenerate polygons.

use glam::DVec3;

use super::*;
use crate::curve::*;

/// Whether the curve of a polygon is an expected one, under both schemes.
fn follows(surface: &Surface, points: &[SurfacePoint], expected: impl Fn(f64) -> DVec3, within: f64) {
    let mut tracer = Tracer::new(surface);
    for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld()] {
        for k in 0..=20 {
            let t = f64::from(k) / 20.0;
            let found = surface.position(&tracer.evaluate(points, &scheme, t).unwrap());
            assert!(found.distance(expected(t)) < within, "{scheme:?} {t}");
        }
    }
}

#[test]
fn cylinder_is_the_rolled_up_plane() {
    let segments = 48;
    let surface = built(&shapes::cylinder(segments, 12, 3.0));
    // Distance along the polygonal prism.
    let side = 2.0 * (std::f64::consts::PI / f64::from(segments)).sin();
    let roll = |p: DVec3| {
        let (k, share) = ((p.x / side).floor(), (p.x / side).fract());
        let corner = |k: f64| {
            let a = k / f64::from(segments) * std::f64::consts::TAU;
            DVec3::new(a.cos(), a.sin(), p.y)
        };
        corner(k) + share * (corner(k + 1.0) - corner(k))
    };
    let polygon = [(0.3, 0.4), (1.1, 2.6), (2.2, 0.2), (2.7, 2.4)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let points = polygon.map(|p| at(&surface, roll(p)));
    follows(&surface, &points, |t| roll(bezier(polygon, t)), 1e-11);
}

#[test]
fn cone_is_the_rolled_up_sector() {
    let (segments, half_angle) = (64_u32, 0.5_f64);
    let surface = built(&shapes::cone(segments, 6, half_angle));
    // One side of the pyramid is a triangle with two edges of length 1 a row and this angle between them.
    let edge = DVec3::new(half_angle.sin(), 0.0, half_angle.cos());
    let next = glam::DQuat::from_rotation_z(std::f64::consts::TAU / f64::from(segments)) * edge;
    let wedge = edge.angle_between(next);
    let roll = |p: DVec3| {
        let (radius, angle) = (p.length(), p.y.atan2(p.x));
        let k = (angle / wedge).floor();
        let inside = angle - k * wedge;
        // In the side's plane: x along its first edge.
        let y = (next - edge * wedge.cos()) / wedge.sin();
        let flat = radius * (inside.cos() * edge + inside.sin() * y);
        glam::DQuat::from_rotation_z(std::f64::consts::TAU / f64::from(segments) * k) * flat
    };
    let polygon = [(2.0, 0.1), (4.6, 0.5), (3.0, 1.2), (4.8, 1.6)]
        .map(|(r, a): (f64, f64)| DVec3::new(r * a.cos(), r * a.sin(), 0.0));
    let points = polygon.map(|p| at(&surface, roll(p)));
    follows(&surface, &points, |t| roll(bezier(polygon, t)), 1e-10);
}

#[test]
fn over_a_corner_of_the_cube_pieces_meet_smoothly() {
    let surface = built(&shapes::cube());
    let polygon = [(0.5, 0.2, 1.0), (0.9, 0.3, 1.0), (1.0, 0.8, 0.9), (0.6, 1.0, 0.5)]
        .map(|(x, y, z)| at(&surface, DVec3::new(x, y, z)));
    let trace = Tracer::new(&surface).trace(&polygon, &Scheme::de_casteljau().with_levels(7)).unwrap();
    let segment = &trace.segments()[0];
    // Where two pieces meet, the legs on both sides are halves of one geodesic: no turn in any unfolding.
    let mut finder = PathFinder::new();
    let averager = average::Averager { surface: &surface, finder: &mut finder, quality: PathQuality::Default };
    let legs: Vec<_> =
        segment.paths().iter().map(|p| crate::geodesic::inner::InnerPath::from_outer(&surface, p).unwrap()).collect();
    for pair in legs.windows(2).skip(2).step_by(3) {
        let turn = averager.turn(average::Span::whole(&pair[0]), average::Span::whole(&pair[1]));
        assert!(turn.abs() < 1e-6, "{turn}");
    }
}

#[test]
fn reversed_polygons_give_reversed_traces() {
    let surface = built(&shapes::torus(2.0, 0.8, 40, 20));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(5);
    for _ in 0..10 {
        let polygon = [(); 6].map(|()| at(&surface, random.on_sphere() * 2.5));
        let mut check = |polygon: &[SurfacePoint], scheme: Scheme| {
            let mut positions = |polygon: &[SurfacePoint]| -> Vec<DVec3> {
                let trace = tracer.trace(polygon, &scheme).unwrap();
                let points = trace.segments().iter().flat_map(|s| s.points());
                points.map(|p| surface.position(p)).collect()
            };
            let there = positions(polygon);
            let reversed: Vec<_> = polygon.iter().rev().copied().collect();
            let back = positions(&reversed);
            assert_eq!(there.len(), back.len(), "{scheme:?}");
            for (p, q) in there.iter().zip(back.iter().rev()) {
                assert!(p.distance(*q) < 1e-12 * surface.diagonal(), "{scheme:?}: {}", p.distance(*q));
            }
        };
        for base in [Scheme::de_casteljau(), Scheme::lane_riesenfeld()] {
            for scheme in [base, base.on_curve(), base.adaptive(), base.adaptive().on_curve(), base.with_length(0.1)] {
                check(&polygon[..4], scheme);
                check(&polygon[..3], scheme);
            }
        }
        check(&polygon, Scheme::b_spline());
        check(&polygon, Scheme::quadratic_b_spline());
        check(&polygon[..4], Scheme::direct());
    }
}

#[test]
fn degenerate_polygons_are_traced() {
    let surface = built(&shapes::icosphere(3));
    let mut tracer = Tracer::new(&surface);
    let [a, b, c] = [DVec3::X, DVec3::new(1.0, 0.5, 0.2), DVec3::new(0.7, 0.3, 0.6)].map(|p| at(&surface, p));
    let vertex = at(&surface, surface.positions[7]);
    for polygon in
        [[a; 4], [a, a, b, b], [a, b, c, a], [a, c, a, c], [a, b, b, a], [vertex, vertex, b, vertex], [vertex; 4]]
    {
        for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld(), Scheme::de_casteljau().with_levels(0)] {
            let trace = tracer.trace(&polygon, &scheme).unwrap();
            assert!(trace.length().is_finite());
            assert!(trace.positions().iter().all(|p| p.is_finite()));
            assert!(surface.position(&tracer.evaluate(&polygon, &scheme, 0.4).unwrap()).is_finite());
        }
    }
}

#[test]
fn legs_shrink() {
    let surface = built(&shapes::torus(2.0, 0.8, 60, 30));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(9);
    for _ in 0..5 {
        let polygon = [(); 4].map(|()| at(&surface, random.on_sphere() * 2.5));
        let mut longest = |scheme: Scheme, levels: u8| {
            let trace = tracer.trace(&polygon, &scheme.with_levels(levels)).unwrap();
            trace.segments()[0].paths().iter().map(|p| p.length()).fold(0.0, f64::max)
        };
        let lengths: Vec<f64> = (0..7).map(|levels| longest(Scheme::de_casteljau(), levels)).collect();
        assert!(lengths.windows(2).all(|w| w[1] <= 0.5 * w[0] * (1.0 + 1e-9)), "{lengths:?}");
        // Lane–Riesenfeld: never longer from the second level on, and halves in the end.
        let lengths: Vec<f64> = (2..9).map(|levels| longest(Scheme::lane_riesenfeld(), levels)).collect();
        assert!(lengths.windows(2).all(|w| w[1] <= w[0] * (1.0 + 1e-9)), "{lengths:?}");
        assert!(lengths[6] < 0.55 * lengths[5], "{lengths:?}");
    }
}
