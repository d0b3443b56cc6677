//! Ground truths of curves: plane, sphere, cylinder; edits and their inverses.

use glam::DVec3;

use super::*;
use crate::geodesic::PathFinder;
use crate::surface::{Surface, SurfaceOptions, SurfacePoint, TriangleMesh, shapes};

fn built(mesh: &TriangleMesh) -> Surface {
    Surface::build(mesh, &SurfaceOptions::default()).unwrap()
}

fn at(surface: &Surface, p: DVec3) -> SurfacePoint {
    surface.closest_point(p).unwrap().point
}

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }

    fn in_square(&mut self) -> DVec3 {
        DVec3::new(0.02 + 0.96 * self.next(), 0.02 + 0.96 * self.next(), 0.0)
    }

    fn on_sphere(&mut self) -> DVec3 {
        loop {
            let p = DVec3::new(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5);
            if (1e-3..0.25).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }
}

fn bezier([a, b, c, d]: [DVec3; 4], t: f64) -> DVec3 {
    let s = 1.0 - t;
    s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d
}

/// A flat triangulation with jittered vertices.
fn jittered_square(cells: u32) -> TriangleMesh {
    let mut mesh = shapes::grid(cells, cells, 1.0, 1.0);
    let mut random = Random(11);
    let step = 1.0 / f64::from(cells);
    for p in &mut mesh.positions {
        if p.x > 0.0 && p.x < 1.0 && p.y > 0.0 && p.y < 1.0 {
            *p += DVec3::new(random.next() - 0.5, random.next() - 0.5, 0.0) * 0.5 * step;
        }
    }
    mesh
}

#[test]
fn plane_equals_the_euclidean_curve() {
    let surface = built(&jittered_square(13));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(1);
    for _ in 0..60 {
        let polygon = [(); 4].map(|()| random.in_square());
        let points = polygon.map(|p| at(&surface, p));
        for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld()] {
            for _ in 0..10 {
                let t = random.next();
                let found = surface.position(&tracer.evaluate(&points, &scheme, t).unwrap());
                assert!(found.distance(bezier(polygon, t)) < 1e-12 * 1.5, "{scheme:?} {t}");
            }
        }
        // De Casteljau's pieces begin and end on the curve.
        let trace = tracer.trace(&points, &Scheme::de_casteljau()).unwrap();
        let segment = &trace.segments()[0];
        assert_eq!((segment.points().len(), segment.paths().len()), (49, 48));
        for (p, t) in segment.points().iter().zip(segment.parameters()).step_by(3) {
            assert!(surface.position(p).distance(bezier(polygon, *t)) < 1e-12 * 1.5);
        }
        // Lane–Riesenfeld's polygon converges to the curve with the square of its steps.
        let trace = tracer.trace(&points, &Scheme::lane_riesenfeld()).unwrap();
        let segment = &trace.segments()[0];
        assert_eq!(segment.points().len(), 67);
        for (p, t) in segment.points().iter().zip(segment.parameters()) {
            assert!(surface.position(p).distance(bezier(polygon, *t)) < 2e-3);
        }
    }
}

const S1: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 1.0, 1.0]];
const S2: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.2, 1.0, 0.6], [0.0, 0.5, 1.0]];

/// Turns the figures away from the icosphere's mirror planes, in which rows of vertices push paths aside by a part of an
/// edge.
fn tilted(p: [f64; 3]) -> DVec3 {
    glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.7, 0.4, 1.1) * DVec3::from(p).normalize()
}

/// Distances of evaluated points from the values of the smooth sphere, for icospheres of two levels.
fn sphere_errors(polygon: [[f64; 3]; 4], scheme: Scheme, t: f64, expected: [f64; 3]) -> [f64; 2] {
    [4, 6].map(|level| {
        let surface = built(&shapes::icosphere(level));
        let points = polygon.map(|p| at(&surface, tilted(p)));
        let found = Tracer::new(&surface).evaluate(&points, &scheme, t).unwrap();
        surface.position(&found).normalize().distance(tilted(expected))
    })
}

#[test]
fn sphere_approaches_the_smooth_figures() {
    let (rdc, olr) = (Scheme::de_casteljau(), Scheme::lane_riesenfeld());
    for (polygon, scheme, t, expected) in [
        (S2, rdc, 0.25, [0.839_041_457_2, 0.475_811_904_8, 0.263_841_741_0]),
        (S2, rdc, 0.5, [0.512_551_755_5, 0.709_258_079_3, 0.483_987_267_3]),
        (S2, rdc, 0.3, [0.779_815_084_9, 0.543_318_542_1, 0.310_955_616_0]),
        (S2, olr, 0.5, [0.512_487_417_7, 0.709_438_082_7, 0.483_791_539_3]),
        (S1, rdc, 0.25, [0.629_412_873_1, 0.732_928_908_9, 0.258_175_617_9]),
        (S1, rdc, 0.5, [0.129_712_649_0, 0.731_870_126_8, 0.668_984_862_5]),
        (S1, olr, 0.5, [0.129_523_255_9, 0.732_037_212_0, 0.668_838_729_8]),
    ] {
        let [coarse, fine] = sphere_errors(polygon, scheme, t, expected);
        assert!(coarse < 3e-3 && fine < 2e-4, "{scheme:?} {t}: {coarse} {fine}");
    }
}

#[test]
fn sphere_lengths() {
    let surface = built(&shapes::icosphere(6));
    for (polygon, expected) in [(S2, 1.806_006_906), (S1, 2.507_708_565)] {
        let points = polygon.map(|p| at(&surface, tilted(p)));
        let length = Tracer::new(&surface).trace(&points, &Scheme::lane_riesenfeld()).unwrap().length();
        assert!((length - expected).abs() < 1e-3, "{length} for {expected}");
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
    let mut tracer = Tracer::new(&surface);
    for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld()] {
        for k in 0..=20 {
            let t = f64::from(k) / 20.0;
            let found = surface.position(&tracer.evaluate(&points, &scheme, t).unwrap());
            assert!(found.distance(roll(bezier(polygon, t))) < 1e-11, "{scheme:?} {t}");
        }
    }
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
    let mut tracer = Tracer::new(&surface);
    for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld()] {
        for k in 0..=20 {
            let t = f64::from(k) / 20.0;
            let found = surface.position(&tracer.evaluate(&points, &scheme, t).unwrap());
            assert!(found.distance(roll(bezier(polygon, t))) < 1e-10, "{scheme:?} {t}");
        }
    }
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
    let averager = average::Averager { surface: &surface, finder: &mut finder };
    let legs: Vec<_> =
        segment.paths().iter().map(|p| crate::geodesic::inner::InnerPath::from_outer(&surface, p).unwrap()).collect();
    for pair in legs.windows(2).skip(2).step_by(3) {
        let turn = averager.turn(average::Span::new(&pair[0], 0.0, 1.0), average::Span::new(&pair[1], 0.0, 1.0));
        assert!(turn.abs() < 1e-6, "{turn}");
    }
}

#[test]
fn moving_nowhere_changes_nothing() {
    let surface = built(&shapes::icosphere(3));
    let mut finder = PathFinder::new();
    let mut spline = spline_on(&surface, &S2.map(tilted), true);
    let before = spline.clone();
    let to = spline.anchors()[1].point();
    spline.apply(&surface, &mut finder, &SplineEdit::MoveAnchor { anchor: 1, to }).unwrap();
    assert_eq!(spline, before);
    // Nearly nowhere changes nearly nothing (away from vertices, whose curvature sits in one place).
    let to = at(&surface, surface.position(&to) + DVec3::new(1e-9, 0.0, 0.0));
    spline.apply(&surface, &mut finder, &SplineEdit::MoveAnchor { anchor: 1, to }).unwrap();
    for (a, b) in spline.anchors().iter().zip(before.anchors()) {
        for (h, k) in [(a.incoming(), b.incoming()), (a.outgoing(), b.outgoing())] {
            assert!(surface.position(&h.point()).distance(surface.position(&k.point())) < 1e-7);
        }
    }
}

#[test]
fn reversed_polygons_give_reversed_traces() {
    let surface = built(&shapes::torus(2.0, 0.8, 40, 20));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(5);
    for _ in 0..10 {
        let mut polygon = [(); 4].map(|()| at(&surface, random.on_sphere() * 2.5));
        for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld()] {
            let mut positions = |polygon: &[SurfacePoint; 4]| -> Vec<DVec3> {
                let trace = tracer.trace(polygon, &scheme).unwrap();
                trace.segments()[0].points().iter().map(|p| surface.position(p)).collect()
            };
            let there = positions(&polygon);
            polygon.reverse();
            let back = positions(&polygon);
            for (p, q) in there.iter().zip(back.iter().rev()) {
                assert!(p.distance(*q) < 1e-12 * surface.diagonal(), "{scheme:?}: {}", p.distance(*q));
            }
        }
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
fn legs_shrink_by_half() {
    let surface = built(&shapes::torus(2.0, 0.8, 60, 30));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(9);
    for _ in 0..5 {
        let polygon = [(); 4].map(|()| at(&surface, random.on_sphere() * 2.5));
        let mut longest = |levels: u8| {
            let trace = tracer.trace(&polygon, &Scheme::de_casteljau().with_levels(levels)).unwrap();
            trace.segments()[0].paths().iter().map(|p| p.length()).fold(0.0, f64::max)
        };
        let lengths: Vec<f64> = (0..6).map(&mut longest).collect();
        assert!(lengths.windows(2).all(|w| w[1] <= 0.5 * w[0] * (1.0 + 1e-9)), "{lengths:?}");
    }
}

fn spline_on(surface: &Surface, points: &[DVec3], closed: bool) -> Spline {
    let points: Vec<_> = points.iter().map(|p| at(surface, *p)).collect();
    Spline::smooth_through(surface, &mut PathFinder::new(), &points, closed).unwrap()
}

#[test]
fn smooth_through_is_catmull_rom_in_the_plane() {
    let surface = built(&jittered_square(9));
    let points = [(0.1, 0.2), (0.4, 0.7), (0.6, 0.3), (0.9, 0.8)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let spline = spline_on(&surface, &points, false);
    for (i, anchor) in spline.anchors().iter().enumerate() {
        assert!(surface.position(&anchor.point()).distance(points[i]) < 1e-15);
        let (out, into) = (surface.position(&anchor.outgoing().point()), surface.position(&anchor.incoming().point()));
        if i > 0 && i < 3 {
            let (u, v) = (points[i - 1] - points[i], points[i + 1] - points[i]);
            let (d0, d1) = (u.length(), v.length());
            let m = (v * (d0 / d1) - u * (d1 / d0)) / (d0 + d1);
            assert!(out.distance(points[i] + m * d1 / 3.0) < 1e-12);
            assert!(into.distance(points[i] - m * d0 / 3.0) < 1e-12);
        }
    }
    assert!(
        surface.position(&spline.anchors()[0].outgoing().point()).distance(points[0].lerp(points[1], 1.0 / 3.0))
            < 1e-12
    );
}

#[test]
fn too_few_points_are_refused() {
    let surface = built(&shapes::icosphere(1));
    let p = at(&surface, DVec3::X);
    let make = |points: &[SurfacePoint]| Spline::smooth_through(&surface, &mut PathFinder::new(), points, true);
    assert_eq!(make(&[]).unwrap_err(), SplineError::TooFewPoints { distinct: 0 });
    assert_eq!(make(&[p, p, p]).unwrap_err(), SplineError::TooFewPoints { distinct: 1 });
    assert!(make(&[p, at(&surface, DVec3::Y), p]).is_ok());
}

/// Angle between the two handles' directions at an anchor, as the surface sees it.
fn handle_angle(surface: &Surface, anchor: &Anchor) -> f64 {
    use crate::geodesic::transport::angle_at;
    let at = surface.inner_point(&anchor.point()).unwrap();
    let [a, b] = [anchor.outgoing(), anchor.incoming()].map(|h| surface.inner_tangent(&h.heading()).unwrap());
    angle_at(surface, &at, &a, &b).rem_euclid(std::f64::consts::TAU)
}

#[test]
fn smooth_joins_stay_smooth_under_edits() {
    let surface = built(&shapes::icosphere(4));
    let mut finder = PathFinder::new();
    let mut spline = spline_on(&surface, &[DVec3::X, DVec3::Y, DVec3::Z], true);
    let mut random = Random(21);
    for i in 0..60 {
        let anchor = random.below(3) as u32;
        let near = surface.position(&spline.anchors()[anchor as usize].point());
        let mut to = at(&surface, near + 0.3 * random.on_sphere());
        if i % 7 == 0 {
            to = at(&surface, surface.positions[random.below(100)]); // exactly on a vertex
        }
        let edit = match i % 3 {
            0 => SplineEdit::MoveAnchor { anchor, to },
            1 => SplineEdit::MoveHandle { anchor, side: HandleSide::Incoming, to },
            _ => SplineEdit::MoveHandle { anchor, side: HandleSide::Outgoing, to },
        };
        let lengths = |s: &Spline| {
            s.anchors().iter().map(|a| [a.incoming().wished_length(), a.outgoing().wished_length()]).collect::<Vec<_>>()
        };
        let before = lengths(&spline);
        spline.apply(&surface, &mut finder, &edit).unwrap();
        let after = lengths(&spline);
        let moved = &spline.anchors()[anchor as usize];
        assert!((handle_angle(&surface, moved) - std::f64::consts::PI).abs() < 1e-9, "{i}: {edit:?}");
        match edit {
            SplineEdit::MoveAnchor { .. } => assert_eq!(before, after),
            SplineEdit::MoveHandle { side: HandleSide::Incoming, .. } => {
                assert_eq!(before[anchor as usize][1], after[anchor as usize][1]);
            }
            _ => assert_eq!(before[anchor as usize][0], after[anchor as usize][0]),
        }
    }
}

#[test]
fn joins_move_handles_as_they_ask() {
    let surface = built(&shapes::icosphere(4));
    let mut finder = PathFinder::new();
    let mut spline = spline_on(&surface, &[DVec3::X, DVec3::Y, DVec3::Z], true);
    let corner = SplineEdit::SetJoin { anchor: 1, join: Join::Corner };
    spline.apply(&surface, &mut finder, &corner).unwrap();
    let to = at(&surface, DVec3::new(0.3, 1.0, 0.4));
    spline.apply(&surface, &mut finder, &SplineEdit::MoveHandle { anchor: 1, side: HandleSide::Outgoing, to }).unwrap();
    assert!((handle_angle(&surface, &spline.anchors()[1]) - std::f64::consts::PI).abs() > 0.1);
    assert!(surface.same_place(&spline.anchors()[1].outgoing().point(), &to));
    spline.apply(&surface, &mut finder, &SplineEdit::SetJoin { anchor: 1, join: Join::Mirrored }).unwrap();
    let anchor = &spline.anchors()[1];
    assert!((handle_angle(&surface, anchor) - std::f64::consts::PI).abs() < 1e-9);
    assert!((anchor.incoming().leg().length() - anchor.outgoing().leg().length()).abs() < 1e-12);
    // Mirrored partners follow in length too.
    let to = at(&surface, DVec3::new(-0.2, 1.0, 0.1));
    spline.apply(&surface, &mut finder, &SplineEdit::MoveHandle { anchor: 1, side: HandleSide::Incoming, to }).unwrap();
    let anchor = &spline.anchors()[1];
    assert!((anchor.incoming().leg().length() - anchor.outgoing().leg().length()).abs() < 1e-12);
}

#[test]
fn clipped_handles_get_their_length_back() {
    let surface = built(&jittered_square(9));
    let mut finder = PathFinder::new();
    let mut spline =
        spline_on(&surface, &[(0.2, 0.5), (0.5, 0.5), (0.8, 0.6)].map(|(x, y)| DVec3::new(x, y, 0.0)), false);
    let length = spline.anchors()[1].outgoing().wished_length();
    let move_to = |spline: &mut Spline, finder: &mut PathFinder, x: f64| {
        let to = at(&surface, DVec3::new(x, 0.5, 0.0));
        spline.apply(&surface, finder, &SplineEdit::MoveAnchor { anchor: 1, to }).unwrap();
    };
    move_to(&mut spline, &mut finder, 0.98);
    assert!(spline.anchors()[1].outgoing().is_clipped());
    assert_eq!(spline.anchors()[1].outgoing().wished_length(), length);
    move_to(&mut spline, &mut finder, 0.5);
    assert!(!spline.anchors()[1].outgoing().is_clipped());
    assert!((spline.anchors()[1].outgoing().leg().length() - length).abs() < 1e-12);
}

fn random_edit(surface: &Surface, spline: &Spline, random: &mut Random) -> SplineEdit {
    let anchor = random.below(spline.anchors().len() + 1) as u32;
    let to = at(surface, random.on_sphere());
    let join = [Join::Corner, Join::Smooth, Join::Mirrored, Join::Automatic][random.below(4)];
    match random.below(8) {
        0 | 1 => SplineEdit::MoveAnchor { anchor, to },
        2 => SplineEdit::MoveHandle { anchor, side: HandleSide::Incoming, to },
        3 => SplineEdit::MoveHandle { anchor, side: HandleSide::Outgoing, to },
        4 => SplineEdit::Append { end: if random.next() < 0.5 { SplineEnd::Start } else { SplineEnd::End }, at: to },
        5 => SplineEdit::Delete { anchor },
        6 => SplineEdit::SetJoin { anchor, join },
        _ => SplineEdit::SetScheme(Scheme::lane_riesenfeld().with_levels(random.below(6) as u8)),
    }
}

#[test]
fn inverses_restore_every_bit() {
    let surface = built(&shapes::icosphere(2));
    let mut finder = PathFinder::new();
    let mut random = Random(77);
    let (mut applied, mut refused) = (0, 0);
    for sequence in 0..10_000 {
        let closed = sequence % 2 == 0;
        let count = 2 + random.below(3);
        let points: Vec<_> = (0..count).map(|_| random.on_sphere()).collect();
        let mut spline = spline_on(&surface, &points, closed);
        let original = spline.clone();
        let mut inverses = Vec::new();
        for _ in 0..1 + random.below(6) {
            let edit = random_edit(&surface, &spline, &mut random);
            let before = spline.clone();
            match spline.apply(&surface, &mut finder, &edit) {
                Ok(inverse) => inverses.push(inverse),
                Err(_) => {
                    refused += 1;
                    assert_eq!(spline, before);
                }
            }
        }
        applied += inverses.len();
        for inverse in inverses.iter().rev() {
            spline.apply(&surface, &mut finder, inverse).unwrap();
        }
        // Debug text shows every bit of every number, the sign of zero included.
        assert!(spline == original && format!("{spline:?}") == format!("{original:?}"), "sequence {sequence}");
    }
    assert!(applied > 20_000 && refused > 1_000, "{applied} {refused}");
}

#[test]
fn only_what_changed_is_traced_again() {
    let surface = built(&shapes::icosphere(4));
    let mut workspace = TraceWorkspace::default();
    let mut random = Random(4);
    let points: Vec<_> = (0..8)
        .map(|i| {
            let a = f64::from(i) / 8.0 * std::f64::consts::TAU;
            DVec3::new(a.cos(), a.sin(), 0.4 * (3.0 * a).sin())
        })
        .collect();
    let mut spline = spline_on(&surface, &points, true);
    let mut trace = spline.trace(&surface, &mut workspace, None).unwrap();
    assert_eq!(trace.retraced().len(), 8);
    for _ in 0..30 {
        let anchor = random.below(8) as u32;
        let near = surface.position(&spline.anchors()[anchor as usize].point());
        let to = at(&surface, near + 0.1 * random.on_sphere());
        spline.apply(&surface, &mut workspace.finder, &SplineEdit::MoveAnchor { anchor, to }).unwrap();
        trace = spline.trace(&surface, &mut workspace, Some(&trace)).unwrap();
        let mut touched = [(anchor + 7) % 8, anchor];
        touched.sort_unstable();
        assert_eq!(trace.retraced(), touched);
        assert_eq!(trace, spline.trace(&surface, &mut TraceWorkspace::default(), None).unwrap());
    }
}

#[test]
fn traces_answer_by_parameter_distance_and_nearness() {
    let surface = built(&shapes::icosphere(5));
    let mut workspace = TraceWorkspace::default();
    let spline = spline_on(&surface, &[DVec3::X, DVec3::Y, DVec3::Z], true);
    let trace = spline.trace(&surface, &mut workspace, None).unwrap();
    let by_distance = |d: f64| surface.position(&trace.at_distance(&surface, d).unwrap());
    assert!(by_distance(0.0).distance(DVec3::X) < 1e-9);
    assert!(by_distance(trace.length()).distance(DVec3::X) < 1e-9);
    for k in 0..30 {
        let t = SplineT(f64::from(k) / 10.0);
        let on_line = surface.position(&trace.point_at(&surface, t).unwrap());
        let on_curve = surface.position(&spline.evaluate(&surface, &mut workspace, t).unwrap());
        assert!(on_line.distance(on_curve) < 2e-3, "{t:?} {}", on_line.distance(on_curve));
        let nearest = trace.nearest(&surface, on_line).unwrap();
        assert!(nearest.distance < 1e-12);
        let wrapped = (nearest.t.0 - t.0).abs();
        assert!(wrapped < 1e-6 || (wrapped - 3.0).abs() < 1e-6, "{t:?} {nearest:?}");
        assert!(by_distance(nearest.along).distance(on_line) < 1e-9);
    }
    assert!(trace.point_at(&surface, SplineT(f64::NAN)).is_none());
    assert!(trace.nearest(&surface, DVec3::NAN).is_none());
    assert!(spline.evaluate(&surface, &mut workspace, SplineT(3.5)).is_err());
    assert!(Trace::default().at_distance(&surface, 1.0).is_none());
}

#[test]
fn threads_and_workspaces_do_not_show() {
    let surface = built(&shapes::torus(2.0, 0.8, 40, 20));
    let mut random = Random(31);
    let splines: Vec<Spline> = (0..40)
        .map(|_| {
            let points: Vec<_> = (0..3).map(|_| random.on_sphere() * 2.5).collect();
            spline_on(&surface, &points, random.next() < 0.5)
        })
        .collect();
    let together = Spline::trace_all(&surface, &splines);
    let mut used = TraceWorkspace::default();
    for (i, spline) in splines.iter().enumerate().rev() {
        let fresh = spline.trace(&surface, &mut TraceWorkspace::default(), None).unwrap();
        let again = spline.trace(&surface, &mut used, None).unwrap();
        assert_eq!(format!("{fresh:?}"), format!("{again:?}"));
        assert_eq!(together[i].as_ref().unwrap(), &fresh);
    }
}
