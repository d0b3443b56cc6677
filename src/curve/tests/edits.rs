//! Edits that change the structure of a spline: what the curve does.

use glam::DVec3;

use super::*;
use crate::curve::*;

/// Polylines of the curve's own points.
fn sampled(surface: &Surface, spline: &Spline) -> Vec<DVec3> {
    let mut workspace = TraceWorkspace::default();
    let count = 16 * spline.segment_count();
    let place = |k: usize| spline.evaluate(surface, &mut workspace, SplineT(k as f64 / 16.0)).unwrap();
    (0..=count).map(place).map(|p| surface.position(&p)).collect()
}

fn apply(surface: &Surface, spline: &mut Spline, edit: &SplineEdit) -> SplineEdit {
    spline.apply(surface, &mut PathFinder::new(), edit).unwrap()
}

fn farthest(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
}

fn four(surface: &Surface, closed: bool) -> Spline {
    let points = [DVec3::X, DVec3::new(0.2, 1.0, 0.3), DVec3::new(-0.4, 0.5, 1.0), DVec3::new(0.6, -0.2, 1.0)];
    spline_on(surface, &points, closed)
}

#[test]
fn opening_and_closing_leave_the_curve() {
    let surface = built(&shapes::icosphere(4));
    let mut spline = four(&surface, true);
    let curve = sampled(&surface, &spline);
    for anchor in [0, 1, 3] {
        let mut opened = spline.clone();
        apply(&surface, &mut opened, &SplineEdit::Open { anchor });
        assert!(!opened.is_closed() && opened.anchors().len() == 5 && opened.segment_count() == 4);
        let mut expected = curve[16 * anchor as usize..].to_vec();
        expected.extend(&curve[1..=16 * anchor as usize]);
        assert!(farthest(&sampled(&surface, &opened), &expected) < 1e-12);
        // The two ends become one anchor again, as smooth as it was.
        apply(&surface, &mut opened, &SplineEdit::Close);
        assert!(opened.is_closed() && opened.anchors().len() == 4);
        assert_eq!(opened.anchors()[0].join(), Join::Smooth);
        assert!(farthest(&sampled(&surface, &opened), &expected) < 1e-12);
    }
    // Ends that are apart are joined by a segment.
    apply(&surface, &mut spline, &SplineEdit::Open { anchor: 0 });
    apply(&surface, &mut spline, &SplineEdit::Delete { anchor: 4 });
    assert_eq!(spline.segment_count(), 3);
    apply(&surface, &mut spline, &SplineEdit::Close);
    assert_eq!(spline.segment_count(), 4);
    assert!(farthest(&sampled(&surface, &spline)[..49], &curve[..49]) < 1e-12);
    let mut finder = PathFinder::new();
    assert_eq!(spline.apply(&surface, &mut finder, &SplineEdit::Close), Err(EditError::Closed));
    apply(&surface, &mut spline, &SplineEdit::Open { anchor: 0 });
    assert_eq!(spline.apply(&surface, &mut finder, &SplineEdit::Open { anchor: 0 }), Err(EditError::Open));
}

#[test]
fn closing_what_was_opened_keeps_the_join() {
    let surface = built(&shapes::icosphere(4));
    for join in [Join::Smooth, Join::Mirrored, Join::Automatic] {
        let mut spline = four(&surface, true);
        apply(&surface, &mut spline, &SplineEdit::SetJoin { anchor: 0, join });
        let before = spline.clone();
        apply(&surface, &mut spline, &SplineEdit::Open { anchor: 0 });
        apply(&surface, &mut spline, &SplineEdit::Close);
        assert_eq!(spline.anchors()[0].join(), join);
        assert!(farthest(&sampled(&surface, &spline), &sampled(&surface, &before)) < 1e-9);
    }
}

/// No constructor makes such a spline, but a document may hold one.
#[test]
fn splines_without_anchors_are_no_reason_to_panic() {
    let surface = built(&shapes::icosphere(2));
    let p = at(&surface, DVec3::X);
    for closed in [false, true] {
        let mut empty = four(&surface, closed);
        empty.anchors.clear();
        for edit in [
            SplineEdit::MoveAnchor { anchor: 0, to: p },
            SplineEdit::Insert { at: SplineT(0.0) },
            SplineEdit::Delete { anchor: 0 },
            SplineEdit::SetJoin { anchor: 0, join: Join::Automatic },
            SplineEdit::Straighten { segment: 0 },
            SplineEdit::Close,
            SplineEdit::Open { anchor: 0 },
            SplineEdit::Reverse,
            SplineEdit::Cut { anchor: 0, keep: SplineEnd::End },
            SplineEdit::Join { end: SplineEnd::End, other: four(&surface, false), at: SplineEnd::Start },
            SplineEdit::Append { end: SplineEnd::End, at: p },
            SplineEdit::SetJumps(JumpPolicy::Sticky),
            SplineEdit::SetScheme(Scheme::b_spline()),
        ] {
            // Whatever is said to it, it is said in words.
            let mut spline = empty.clone();
            if let Err(error) = spline.apply(&surface, &mut PathFinder::new(), &edit) {
                assert!(spline == empty && !error.to_string().is_empty());
            }
            assert!(spline.trace(&surface, &mut TraceWorkspace::default(), None).is_ok());
        }
        let mut finder = PathFinder::new();
        assert!(empty.to_bezier(&surface, &mut finder).is_err() && empty.to_b_spline(&surface, &mut finder).is_err());
    }
}

#[test]
fn schemes_that_are_no_numbers_are_refused() {
    let surface = built(&shapes::icosphere(2));
    let mut finder = PathFinder::new();
    let mut spline = four(&surface, true);
    for scheme in [
        Scheme::b_spline().with_length(f64::NAN),
        Scheme { sampling: Sampling::Adaptive { turn: f64::NAN, length: None }, ..Scheme::default() },
    ] {
        assert_eq!(spline.apply(&surface, &mut finder, &SplineEdit::SetScheme(scheme)), Err(EditError::BadScheme));
    }
    // One that was made with them is traced, and need not be traced again.
    let odd = spline
        .with_scheme(Scheme { sampling: Sampling::Adaptive { turn: f64::NAN, length: None }, ..Scheme::default() });
    let trace = odd.trace(&surface, &mut TraceWorkspace::default(), None).unwrap();
    let again = odd.trace(&surface, &mut TraceWorkspace::default(), Some(&trace)).unwrap();
    assert!(again.retraced().is_empty() && again == trace);
}

#[test]
fn legs_are_no_longer_than_asked_for() {
    let surface = built(&jittered_square(12));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(14);
    for _ in 0..30 {
        let polygon = [(); 5].map(|()| at(&surface, random.in_square()));
        for length in [0.3, 0.05] {
            for base in
                [Scheme::de_casteljau(), Scheme::lane_riesenfeld(), Scheme::b_spline(), Scheme::quadratic_b_spline()]
            {
                let points = if base.method.is_b_spline() { &polygon[..] } else { &polygon[..4] };
                for scheme in [base.with_length(length), base.with_length(length).on_curve()] {
                    let trace = tracer.trace(points, &scheme).unwrap();
                    let legs = trace.segments().iter().flat_map(|s| s.paths()).map(|path| path.length());
                    let longest = legs.fold(0.0, f64::max);
                    assert!(longest <= length * (1.0 + 1e-9), "{scheme:?} {longest}");
                }
            }
        }
    }
}

#[test]
fn reversing_runs_the_curve_backwards() {
    let surface = built(&shapes::icosphere(4));
    for closed in [false, true] {
        let mut spline = four(&surface, closed);
        let mut curve = sampled(&surface, &spline);
        apply(&surface, &mut spline, &SplineEdit::Reverse);
        curve.reverse();
        assert!(farthest(&sampled(&surface, &spline), &curve) < 1e-12);
        let again = {
            let mut twice = spline.clone();
            apply(&surface, &mut twice, &SplineEdit::Reverse);
            twice
        };
        assert_eq!(again, four(&surface, closed));
    }
}

#[test]
fn cutting_and_joining_leave_the_curve() {
    let surface = built(&shapes::icosphere(4));
    let whole = four(&surface, false);
    let curve = sampled(&surface, &whole);
    let [before, after] = whole.split(2).unwrap();
    assert!(farthest(&sampled(&surface, &before), &curve[..33]) < 1e-12);
    assert!(farthest(&sampled(&surface, &after), &curve[32..]) < 1e-12);
    let mut cut = whole.clone();
    apply(&surface, &mut cut, &SplineEdit::Cut { anchor: 2, keep: SplineEnd::Start });
    assert_eq!(cut, before);
    // However the parts lie, they become the whole again.
    for (end, at) in
        [SplineEnd::Start, SplineEnd::End].into_iter().flat_map(|e| [SplineEnd::Start, SplineEnd::End].map(|a| (e, a)))
    {
        let (mut own, mut other) = (before.clone(), after.clone());
        if end == SplineEnd::Start {
            apply(&surface, &mut own, &SplineEdit::Reverse);
        }
        if at == SplineEnd::End {
            apply(&surface, &mut other, &SplineEdit::Reverse);
        }
        apply(&surface, &mut own, &SplineEdit::Join { end, other, at });
        let mut joined = sampled(&surface, &own);
        if end == SplineEnd::Start {
            joined.reverse();
        }
        assert!(farthest(&joined, &curve) < 1e-12, "{end:?} {at:?}");
        assert_eq!(own.anchors().iter().filter(|a| a.join() == Join::Smooth).count(), 4);
    }
    // Ends that are apart get a segment between.
    let far = spline_on(&surface, &[DVec3::NEG_Y, DVec3::NEG_Z], false);
    let mut joined = whole.clone();
    apply(&surface, &mut joined, &SplineEdit::Join { end: SplineEnd::End, other: far, at: SplineEnd::Start });
    assert_eq!(joined.segment_count(), 5);
    let mut finder = PathFinder::new();
    let refused = joined.apply(&surface, &mut finder, &SplineEdit::Cut { anchor: 0, keep: SplineEnd::Start });
    assert_eq!(refused, Err(EditError::TooFewAnchors));
    let closed = four(&surface, true);
    let edit = SplineEdit::Join { end: SplineEnd::End, other: closed, at: SplineEnd::Start };
    assert_eq!(joined.apply(&surface, &mut finder, &edit), Err(EditError::Closed));
}

#[test]
fn one_anchor_is_a_loop() {
    let surface = built(&shapes::icosphere(4));
    let mut spline = four(&surface, true);
    for _ in 0..3 {
        apply(&surface, &mut spline, &SplineEdit::Delete { anchor: 1 });
    }
    assert_eq!((spline.anchors().len(), spline.segment_count()), (1, 1));
    let mut finder = PathFinder::new();
    assert_eq!(spline.apply(&surface, &mut finder, &SplineEdit::Delete { anchor: 0 }), Err(EditError::TooFewAnchors));
    let to = at(&surface, DVec3::new(1.0, 0.5, 0.1));
    apply(&surface, &mut spline, &SplineEdit::SetJoin { anchor: 0, join: Join::Corner });
    apply(&surface, &mut spline, &SplineEdit::MoveHandle { anchor: 0, side: HandleSide::Outgoing, to });
    let to = at(&surface, DVec3::new(1.0, 0.1, 0.5));
    apply(&surface, &mut spline, &SplineEdit::MoveHandle { anchor: 0, side: HandleSide::Incoming, to });
    let curve = sampled(&surface, &spline);
    assert!(curve[0].distance(curve[16]) < 1e-12 && curve[8].distance(curve[0]) > 0.1);
    apply(&surface, &mut spline, &SplineEdit::Insert { at: SplineT(0.5) });
    assert_eq!(spline.segment_count(), 2);
    apply(&surface, &mut spline, &SplineEdit::Open { anchor: 1 });
    assert_eq!((spline.anchors().len(), spline.segment_count()), (3, 2));
    // A loop without handles, placed automatically, is a point; it is traced all the same.
    let mut point = four(&surface, true);
    (0..3).for_each(|_| drop(apply(&surface, &mut point, &SplineEdit::Delete { anchor: 0 })));
    apply(&surface, &mut point, &SplineEdit::SetJoin { anchor: 0, join: Join::Automatic });
    assert_eq!(point.trace(&surface, &mut TraceWorkspace::default(), None).unwrap().length(), 0.0);
}

#[test]
fn straight_segments_are_geodesics_with_even_parameters() {
    let surface = built(&shapes::torus(2.0, 0.8, 60, 30));
    let mut random = Random(12);
    for _ in 0..20 {
        let points = [(); 2].map(|()| 2.5 * random.on_sphere());
        let mut spline = spline_on(&surface, &points, false);
        apply(&surface, &mut spline, &SplineEdit::Straighten { segment: 0 });
        let [a, b] = [0, 1].map(|k| spline.anchors()[k].point());
        let path = surface.shortest_path(&a, &b).unwrap();
        for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld()] {
            let spline = spline.clone().with_scheme(scheme);
            let trace = spline.trace(&surface, &mut TraceWorkspace::default(), None).unwrap();
            assert!((trace.length() - path.length()).abs() < 1e-9 * path.length(), "{scheme:?}");
            for k in 0..=10 {
                let t = f64::from(k) / 10.0;
                let found = spline.evaluate(&surface, &mut TraceWorkspace::default(), SplineT(t)).unwrap();
                let expected = path.at(&surface, t).unwrap();
                let off = surface.position(&found).distance(surface.position(&expected));
                assert!(off < 1e-9 * surface.diagonal(), "{scheme:?} {t}: {off}");
            }
        }
    }
}

/// Local control polygons: four points within a twentieth of the diagonal of one another.
fn local_spline(surface: &Surface, random: &mut Random, scheme: Scheme) -> Spline {
    let faces = surface.face_count();
    let middle =
        surface.position(&surface.point(crate::surface::FaceId(random.below(faces) as u32), [1.0 / 3.0; 3]).unwrap());
    let reach = 0.05 * surface.diagonal();
    let polygon = [(); 4].map(|()| at(surface, middle + reach * random.next().cbrt() * random.on_sphere()));
    Spline::bezier(surface, &mut PathFinder::new(), polygon).unwrap().with_scheme(scheme)
}

pub(super) fn bumpy(level: u32) -> TriangleMesh {
    let mut mesh = shapes::icosphere(level);
    for p in &mut mesh.positions {
        *p *= 1.0 + 0.1 * (4.0 * p.x).sin() * (5.0 * p.y + 1.0).cos() + 0.05 * (7.0 * p.z).sin();
    }
    mesh
}

/// A square of a saddle, with a boundary.
fn saddle(cells: u32) -> TriangleMesh {
    let mut mesh = jittered_square(cells);
    for p in &mut mesh.positions {
        p.z = (2.0 * p.x - 1.0).powi(2) - (2.0 * p.y - 1.0).powi(2);
    }
    mesh
}

#[test]
fn inserting_leaves_the_curve() {
    let meshes = [shapes::icosphere(5), shapes::torus(2.0, 0.8, 120, 60), bumpy(4), bumpy(6), saddle(80)];
    let mut relative = Vec::new();
    for (m, mesh) in meshes.iter().enumerate() {
        let surface = built(mesh);
        let mut random = Random(40 + m as u64);
        let mut workspace = TraceWorkspace::default();
        for round in 0..if cfg!(debug_assertions) { 20 } else { 200 } {
            let scheme = if round % 2 == 0 { Scheme::de_casteljau() } else { Scheme::lane_riesenfeld() };
            let old = local_spline(&surface, &mut random, scheme);
            let t = 0.02 + 0.96 * random.next();
            let made = old.insertion(&surface, &mut workspace.finder, SplineT(t)).unwrap();
            let expected = old.curve_point(&surface, &mut workspace, SplineT(t)).unwrap();
            let anchor = &made.spline.anchors()[1];
            assert_eq!((made.anchor, made.spline.segment_count()), (1, 2));
            assert!(surface.same_place(&anchor.point(), &expected.point));
            // Both halves begin and end along the old curve, at the speed their parameters ask for.
            if anchor.join() == Join::Smooth && !anchor.incoming().is_clipped() && !anchor.outgoing().is_clipped() {
                assert!((handle_angle(&surface, anchor) - std::f64::consts::PI).abs() < 1e-9);
                let speed = expected.derivative.length();
                let [h_in, h_out] = [anchor.incoming(), anchor.outgoing()].map(|h| h.leg().length());
                assert!((h_in - speed * t / 3.0).abs() < 1e-9 && (h_out - speed * (1.0 - t) / 3.0).abs() < 1e-9);
            }
            let [a, b] = [&old.anchors()[0].outgoing, &old.anchors()[1].incoming];
            let [c, d] = [&made.spline.anchors()[0].outgoing, &made.spline.anchors()[2].incoming];
            assert!((c.leg.length() - t * a.leg.length()).abs() < 1e-12);
            assert!((d.leg.length() - (1.0 - t) * b.leg.length()).abs() < 1e-12);
            assert_eq!((a.heading, b.heading), (c.heading, d.heading));
            // What it says about itself is so: measured against a fine trace of the old curve.
            let fine = old.clone().with_scheme(scheme.with_levels(7).on_curve());
            let fine = fine.trace(&surface, &mut workspace, None).unwrap();
            let step = fine.length() / 128.0;
            let mut off = 0.0_f64;
            for k in 0..=20 {
                let p = made.spline.evaluate(&surface, &mut workspace, SplineT(f64::from(k) / 10.0)).unwrap();
                off = off.max(fine.nearest(&surface, surface.position(&p)).unwrap().distance);
            }
            assert!(off <= 1.5 * made.deviation + 0.2 * step, "{off} {}", made.deviation);
            relative.push(made.relative());
        }
    }
    relative.sort_by(f64::total_cmp);
    let at = |share: f64| relative[((relative.len() - 1) as f64 * share) as usize];
    println!("deviation: median {:.2e}, 90 % {:.2e}, 99 % {:.2e}, worst {:.2e}", at(0.5), at(0.9), at(0.99), at(1.0));
    assert!(at(0.5) <= 1e-4 && at(0.99) <= 1e-2);
}

/// A segment as long as its surface is not kept by an insertion, and that is said.
#[test]
fn insertions_that_move_the_curve_say_so() {
    let surface = built(&shapes::torus(2.0, 0.8, 60, 30));
    let mut random = Random(70);
    let mut workspace = TraceWorkspace::default();
    let mut far = 0;
    for _ in 0..40 {
        let polygon = [(); 4].map(|()| at(&surface, 2.5 * random.on_sphere()));
        let old = Spline::bezier(&surface, &mut workspace.finder, polygon).unwrap();
        let made = old.insertion(&surface, &mut workspace.finder, SplineT(0.1 + 0.8 * random.next())).unwrap();
        let fine = old.with_scheme(Scheme::de_casteljau().with_levels(8).on_curve());
        let fine = fine.trace(&surface, &mut workspace, None).unwrap();
        let off = (0..=40)
            .map(|k| made.spline.evaluate(&surface, &mut workspace, SplineT(f64::from(k) / 20.0)).unwrap())
            .map(|p| fine.nearest(&surface, surface.position(&p)).unwrap().distance)
            .fold(0.0, f64::max);
        far += usize::from(off > 0.01 * fine.length());
        assert!(off < 0.01 * fine.length() || !made.is_close(), "{off} of {}: {}", fine.length(), made.deviation);
    }
    assert!(far >= 3, "{far}");
}

#[test]
fn evaluation_is_on_the_deep_trace() {
    for (m, mesh) in [shapes::icosphere(5), shapes::torus(2.0, 0.8, 120, 60), bumpy(5)].iter().enumerate() {
        let surface = built(mesh);
        let mut random = Random(60 + m as u64);
        let mut workspace = TraceWorkspace::default();
        let mut worst = 0.0_f64;
        for round in 0..if cfg!(debug_assertions) { 4 } else { 40 } {
            for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld()] {
                let spline = if round % 2 == 0 {
                    local_spline(&surface, &mut random, scheme)
                } else {
                    spline_on(&surface, &[2.5 * random.on_sphere(), 2.5 * random.on_sphere()], false)
                        .with_scheme(scheme)
                };
                let deep = spline.clone().with_scheme(scheme.with_levels(11).on_curve());
                let deep = deep.trace(&surface, &mut workspace, None).unwrap();
                let length = deep.length();
                for k in 0..=64 {
                    let found = spline.evaluate(&surface, &mut workspace, SplineT(k as f64 / 64.0)).unwrap();
                    let expected = &deep.segments()[0].points()[k * 32];
                    worst = worst.max(surface.position(&found).distance(surface.position(expected)) / length);
                }
            }
        }
        println!("mesh {m}: evaluation off the deep trace by at most {worst:.2e} of the length");
        assert!(worst < 1e-6, "{worst}");
    }
}

/// Automatic ends got a neighbour by closing or joining, and no handles towards it.
#[test]
fn automatic_ends_see_their_new_neighbours() {
    let surface = built(&shapes::icosphere(4));
    let mut automatic = four(&surface, false);
    for anchor in 0..4 {
        apply(&surface, &mut automatic, &SplineEdit::SetJoin { anchor, join: Join::Automatic });
    }
    let mut closed = automatic.clone();
    apply(&surface, &mut closed, &SplineEdit::Close);
    let mut other = spline_on(&surface, &[DVec3::NEG_Y, DVec3::NEG_Z], false);
    apply(&surface, &mut other, &SplineEdit::SetJoin { anchor: 0, join: Join::Automatic });
    let mut joined = automatic;
    apply(&surface, &mut joined, &SplineEdit::Join { end: SplineEnd::End, other, at: SplineEnd::Start });
    for (spline, ends) in [(closed, [0, 3]), (joined, [3, 4])] {
        for i in ends {
            let anchor = &spline.anchors()[i];
            assert!(anchor.incoming().leg().length() > 0.05 && anchor.outgoing().leg().length() > 0.05, "{i}");
            assert!((handle_angle(&surface, anchor) - std::f64::consts::PI).abs() < 1e-9);
        }
    }
}

/// A handle that pointed out of the surface was carried along with nothing to hold on to, and came back elsewhere.
#[test]
fn smooth_anchors_come_back_smooth_from_the_boundary() {
    let surface = built(&jittered_square(8));
    let mut random = Random(14);
    for round in 0..60 {
        let edge = DVec3::new(f64::from(1 + round % 7) / 8.0, 0.0, 0.0);
        let points = [0.5 * random.in_square() + DVec3::new(0.2, 0.3, 0.0), edge, random.in_square()];
        let mut spline = spline_on(&surface, &points, false);
        let to = at(&surface, 0.5 * random.in_square() + DVec3::new(0.25, 0.25, 0.0));
        apply(&surface, &mut spline, &SplineEdit::MoveAnchor { anchor: 1, to });
        let angle = handle_angle(&surface, &spline.anchors()[1]);
        assert!((angle - std::f64::consts::PI).abs() < 1e-9, "{round}: {angle}");
    }
}
