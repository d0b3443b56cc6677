//! B-splines: curvature without jumps, conversions, interpolation.

use glam::DVec3;

use super::plane::{EXACT, delaunay_square};
use super::*;
use crate::curve::*;

fn plane_spline(surface: &Surface, random: &mut Random, count: usize, closed: bool) -> Spline {
    let points: Vec<_> =
        (0..count).map(|_| at(surface, 0.6 * random.in_square() + DVec3::new(0.2, 0.2, 0.0))).collect();
    Spline::b_spline(surface, &points, closed).unwrap()
}

/// Curvature just before and just behind a knot, by the curve's own second derivative.
fn curvatures_at_knot(surface: &Surface, spline: &Spline, knot: usize) -> [f64; 2] {
    let mut finder = PathFinder::new();
    let mut averager = average::Averager { surface, finder: &mut finder, quality: PathQuality::Default };
    let n = spline.segment_count();
    [(knot + n - 1) % n, knot % n].map(|segment| {
        let control = spline.control(&mut averager, segment).unwrap();
        let t = if segment == knot % n { 0.0 } else { 1.0 };
        segment::evaluate(&mut averager, &control, spline.scheme(), t).unwrap().curvature
    })
}

#[test]
fn curvature_has_no_jumps_in_the_plane() {
    let surface = built(&delaunay_square(13, 8));
    let mut random = Random(9);
    let (mut splines, mut joined) = (0.0_f64, f64::INFINITY);
    for round in 0..40 {
        let closed = round % 2 == 0;
        let spline = plane_spline(&surface, &mut random, 5 + round % 5, closed);
        let knots = if closed { 0..spline.segment_count() } else { 1..spline.segment_count() };
        for knot in knots.clone() {
            let [a, b] = curvatures_at_knot(&surface, &spline, knot);
            splines = splines.max((a - b).abs() / (1.0 + a * a));
        }
        // Automatic joins through the same places are only C¹.
        let stops: Vec<_> = spline.anchors().iter().map(|a| surface.position(&a.point())).collect();
        let bezier = spline_on(&surface, &stops, closed);
        let jump = |knot| {
            let [a, b] = curvatures_at_knot(&surface, &bezier, knot);
            (a - b).abs()
        };
        joined = joined.min(knots.map(jump).fold(0.0, f64::max));
    }
    println!("largest jump of B-splines {splines:.2e}, smallest of joined segments {joined:.2e}");
    assert!(splines < 1e-9 && joined > 0.1, "{splines} {joined}");
}

/// Local parameter at a distance along a segment.
fn parameter(segment: &SegmentTrace, distance: f64) -> f64 {
    let mut sum = 0.0;
    for (path, t) in segment.paths().iter().zip(segment.parameters().windows(2)) {
        if sum + path.length() >= distance {
            return t[0] + (t[1] - t[0]) * (distance - sum) / path.length();
        }
        sum += path.length();
    }
    1.0
}

/// Root mean square jump of curvature at all knots of closed curves on an icosphere, seen with steps of four mean edges.
fn jump_on_sphere(level: u32, make: impl Fn(&Surface, &[SurfacePoint]) -> Spline) -> f64 {
    let surface = built(&shapes::icosphere(level));
    let step = 4.0 * surface.mean_edge[0];
    let mut random = Random(19);
    let (mut sum, mut count) = (0.0, 0);
    for _ in 0..6 {
        let turn = glam::DQuat::from_axis_angle(random.on_sphere(), 6.0 * random.next());
        let points: Vec<_> = (0..6)
            .map(|k| {
                let angle = f64::from(k) / 6.0 * std::f64::consts::TAU;
                let height = [0.5, -0.4, 0.3, 0.2, -0.6, 0.1][k as usize];
                at(&surface, turn * DVec3::new(angle.cos(), angle.sin(), height).normalize())
            })
            .collect();
        let spline = make(&surface, &points);
        let scheme = Scheme { on_curve: true, ..spline.scheme().with_levels(9) };
        let trace = spline.with_scheme(scheme).trace(&surface, &mut TraceWorkspace::default(), None).unwrap();
        let mut finder = PathFinder::new();
        for (i, segment) in trace.segments().iter().enumerate() {
            // Places a step before and behind the knot: what lies in between is seen by neither.
            let before = &trace.segments()[(i + 5) % 6];
            let ends = [before.length() - step, step];
            let t = [parameter(before, ends[0]) + ((i + 5) % 6) as f64, parameter(segment, ends[1]) + i as f64];
            let [a, b] = t.map(|t| trace.curvature_at(&surface, &mut finder, SplineT(t), step).unwrap());
            sum += (a - b).powi(2);
            count += 1;
        }
    }
    (sum / f64::from(count)).sqrt()
}

#[test]
fn curvature_has_no_jumps_on_finer_and_finer_spheres() {
    let finest = if cfg!(debug_assertions) { 6 } else { 7 };
    let levels = 5..=finest;
    let splines: Vec<f64> =
        levels.clone().map(|level| jump_on_sphere(level, |s, p| Spline::b_spline(s, p, true).unwrap())).collect();
    let joined: Vec<f64> = levels
        .map(|level| jump_on_sphere(level, |s, p| Spline::smooth_through(s, &mut PathFinder::new(), p, true).unwrap()))
        .collect();
    println!("jumps of curvature: B-splines {splines:?}, joined segments {joined:?}");
    assert!(splines.windows(2).all(|w| w[0] >= 1.8 * w[1]), "{splines:?}");
    assert!(joined.windows(2).all(|w| w[0] < 1.3 * w[1]), "{joined:?}");
}

#[test]
fn conversions_are_exact_in_the_plane() {
    let surface = built(&delaunay_square(13, 9));
    let mut finder = PathFinder::new();
    let mut random = Random(10);
    for round in 0..60 {
        let closed = round % 2 == 0;
        let count = 4 + round % 6;
        let cubic = plane_spline(&surface, &mut random, count, closed);
        let bezier = cubic.to_bezier(&surface, &mut finder).unwrap();
        assert!(bezier.deviation < EXACT, "{}", bezier.deviation);
        assert_eq!(bezier.spline.segment_count(), cubic.segment_count());
        let back = bezier.spline.to_b_spline(&surface, &mut finder).unwrap();
        assert!(back.deviation < 1e-10, "{}", back.deviation);
        for (a, b) in cubic.anchors().iter().zip(back.spline.anchors()) {
            // A closed chain comes back begun at another of its points.
            let found = |x: &Anchor| surface.position(&x.point());
            let nearest =
                back.spline.anchors().iter().map(|x| found(x).distance(found(a))).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-10 && (closed || found(a).distance(found(b)) < 1e-10));
        }
        let quadratic = cubic.with_scheme(Scheme::quadratic_b_spline());
        let bezier = quadratic.to_bezier(&surface, &mut finder).unwrap();
        assert!(bezier.deviation < EXACT, "{}", bezier.deviation);
    }
    let spline = plane_spline(&surface, &mut random, 5, false);
    assert!(spline.to_b_spline(&surface, &mut finder).is_err());
    assert!(spline.with_scheme(Scheme::de_casteljau()).to_bezier(&surface, &mut finder).is_err());
}

#[test]
fn deviation_of_conversions_falls_with_the_square_of_the_legs() {
    let surface = built(&shapes::icosphere(7));
    let mut finder = PathFinder::new();
    let turns: Vec<_> = {
        let mut random = Random(29);
        (0..6).map(|_| glam::DQuat::from_axis_angle(random.on_sphere(), 6.0 * random.next())).collect()
    };
    let mut relative = Vec::new();
    for halvings in 0..3 {
        let reach = 0.5_f64.powi(halvings);
        let mut sum = 0.0;
        for turn in &turns {
            // The same wavy line in the tangent plane, smaller and smaller.
            let points: Vec<_> = [(-1.0, 0.1), (-0.5, 0.6), (0.0, -0.3), (0.4, 0.5), (0.9, -0.1)]
                .map(|(x, y)| at(&surface, *turn * DVec3::new(reach * x, reach * y, 1.0).normalize()))
                .to_vec();
            let spline = Spline::b_spline(&surface, &points, false).unwrap();
            let made = spline.to_bezier(&surface, &mut finder).unwrap();
            sum += (made.deviation / reach).powi(2);
        }
        relative.push((sum / turns.len() as f64).sqrt());
    }
    println!("relative deviation of conversions, legs halved: {relative:?}");
    assert!(relative.windows(2).all(|w| w[0] > 3.0 * w[1]), "{relative:?}");
}

#[test]
fn c2_splines_pass_through_their_points() {
    let flat = built(&delaunay_square(13, 10));
    let round = built(&shapes::icosphere(5));
    let mut finder = PathFinder::new();
    let mut random = Random(33);
    let mut worst = 0.0_f64;
    for attempt in 0..20 {
        let closed = attempt % 2 == 0;
        let count = if closed { 3 } else { 2 } + attempt % 6;
        for surface in [&flat, &round] {
            let points: Vec<_> = (0..count)
                .map(|k| {
                    let angle = k as f64 / count as f64 * if closed { std::f64::consts::TAU } else { 3.0 };
                    let off = 0.1 * random.on_sphere();
                    let p = DVec3::new(angle.cos(), angle.sin(), 2.0) + off;
                    at(
                        surface,
                        if surface.diagonal() < 1.5 { 0.15 * p.with_z(0.0) + DVec3::new(0.5, 0.5, 0.0) } else { p },
                    )
                })
                .collect();
            let made = Spline::c2_through(surface, &mut finder, &points, closed).unwrap();
            assert!(!made.fell_back, "{attempt} {closed} {count}");
            let flat = surface.diagonal() < 1.5;
            assert!(made.residual <= if flat { 1e-9 * surface.diagonal() } else { 0.1 * surface.mean_edge[0] });
            worst = worst.max(made.residual / surface.mean_edge[0]);

            let n = if closed { count } else { count - 1 };
            assert_eq!(made.spline.segment_count(), n);
            for (k, p) in points.iter().enumerate() {
                let found = made.spline.evaluate(surface, &mut TraceWorkspace::default(), SplineT(k as f64)).unwrap();
                let off = surface.position(&found).distance(surface.position(p));
                assert!(off <= made.residual + 1e-12, "{k} of {count} {closed}: {off}");
            }
        }
    }
    // Where it is no good, the points are joined all the same.
    let torus = built(&shapes::torus(2.0, 0.8, 40, 20));
    let mut fell_back = 0;
    for _ in 0..20 {
        let points: Vec<_> = (0..6).map(|_| at(&torus, 2.5 * random.on_sphere())).collect();
        let made = Spline::c2_through(&torus, &mut finder, &points, true).unwrap();
        fell_back += usize::from(made.fell_back);
        for (k, p) in points.iter().enumerate() {
            let found = made.spline.evaluate(&torus, &mut TraceWorkspace::default(), SplineT(k as f64)).unwrap();
            assert!(torus.position(&found).distance(torus.position(p)) <= made.residual + 1e-7);
        }
    }
    assert!(fell_back > 0, "points all over a torus are too far apart");
    println!("missed by up to {worst:.2e} mean edges; fell back {fell_back} of 20 times");
    let p = at(&flat, DVec3::new(0.5, 0.5, 0.0));
    assert!(Spline::c2_through(&flat, &mut finder, &[p, p], false).is_err());
}

#[test]
fn moving_a_control_point_traces_four_intervals_again() {
    let surface = built(&shapes::icosphere(4));
    let mut workspace = TraceWorkspace::default();
    let mut random = Random(35);
    let points: Vec<_> = (0..20)
        .map(|k| {
            let angle = f64::from(k) / 20.0 * std::f64::consts::TAU;
            at(&surface, DVec3::new(angle.cos(), angle.sin(), 0.3 * (4.0 * angle).sin()))
        })
        .collect();
    for closed in [false, true] {
        let mut spline = Spline::b_spline(&surface, &points, closed).unwrap();
        let mut trace = spline.trace(&surface, &mut workspace, None).unwrap();
        for _ in 0..10 {
            let anchor = 6 + random.below(8) as u32;
            let near = surface.position(&spline.anchors()[anchor as usize].point());
            let to = at(&surface, near + 0.1 * random.on_sphere());
            spline.apply(&surface, &mut workspace.finder, &SplineEdit::MoveAnchor { anchor, to }).unwrap();
            trace = spline.trace(&surface, &mut workspace, Some(&trace)).unwrap();
            assert_eq!(trace.retraced(), [anchor - 3, anchor - 2, anchor - 1, anchor]);
            assert_eq!(trace, spline.trace(&surface, &mut TraceWorkspace::default(), None).unwrap());
        }
        // A control point more, far away, leaves the rest alone.
        let edit = SplineEdit::Insert { at: SplineT(9.5) };
        spline.apply(&surface, &mut workspace.finder, &edit).unwrap();
        trace = spline.trace(&surface, &mut workspace, Some(&trace)).unwrap();
        assert!(trace.retraced().len() <= 5, "{:?}", trace.retraced());
    }
}

#[test]
fn too_few_control_points_make_no_segment() {
    let surface = built(&shapes::icosphere(2));
    let p = [DVec3::X, DVec3::Y, DVec3::Z].map(|p| at(&surface, p));
    assert_eq!(
        Spline::b_spline(&surface, &p, false).unwrap_err(),
        SplineError::TooFewControlPoints { count: 3, needed: 4 }
    );
    let mut spline = Spline::b_spline(&surface, &p, true).unwrap();
    let mut workspace = TraceWorkspace::default();
    spline.apply(&surface, &mut workspace.finder, &SplineEdit::Delete { anchor: 0 }).unwrap();
    assert_eq!(spline.segment_count(), 0);
    let trace = spline.trace(&surface, &mut workspace, None).unwrap();
    assert!(trace.segments().is_empty() && trace.positions().is_empty());
    assert!(spline.evaluate(&surface, &mut workspace, SplineT(0.0)).is_err());
    assert!(spline.insertion(&surface, &mut workspace.finder, SplineT(0.0)).is_err());
}

/// Old and new parameters do not belong together, and behind the end of a closed spline all segments are counted one on:
/// what was measured was as long as the segment.
#[test]
fn insertions_say_how_far_the_curve_moved() {
    let surface = built(&shapes::icosphere(5));
    let mut workspace = TraceWorkspace::default();
    for closed in [false, true] {
        for scheme in [Scheme::b_spline(), Scheme::quadratic_b_spline()] {
            let points = [DVec3::X, DVec3::new(0.2, 1.0, 0.3), DVec3::NEG_X, DVec3::new(0.1, -1.0, 0.5), DVec3::Z];
            let points = points.map(|p| at(&surface, p));
            let spline = Spline::b_spline(&surface, &points, closed).unwrap().with_scheme(scheme);
            for segment in 0..spline.segment_count() {
                for share in [0.1, 0.4, 0.8] {
                    let t = SplineT(segment as f64 + share);
                    let made = spline.insertion(&surface, &mut workspace.finder, t).unwrap();
                    let scheme = Scheme { on_curve: true, ..scheme.with_levels(6) };
                    let new = made.spline.clone().with_scheme(scheme).trace(&surface, &mut workspace, None).unwrap();
                    let mut off = 0.0_f64;
                    for k in 0..=40 {
                        let t = SplineT(segment as f64 + f64::from(k) / 40.0);
                        let p = spline.evaluate(&surface, &mut workspace, t).unwrap();
                        off = off.max(new.nearest(&surface, surface.position(&p)).unwrap().distance);
                    }
                    assert!(
                        (made.deviation - off).abs() < 0.1 * off + 0.005 * made.length,
                        "{t:?} {closed} {off} {made:?}"
                    );
                }
            }
        }
    }
}
