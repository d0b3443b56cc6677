//! Splines, their edits and their traces.

use glam::DVec3;

use super::*;
use crate::curve::*;

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
    let count = spline.anchors().len();
    let anchor = random.below(count + 1) as u32;
    let to = at(surface, random.on_sphere());
    let join = [Join::Corner, Join::Smooth, Join::Mirrored, Join::Automatic][random.below(4)];
    let side = if random.next() < 0.5 { HandleSide::Incoming } else { HandleSide::Outgoing };
    let end = if random.next() < 0.5 { SplineEnd::Start } else { SplineEnd::End };
    let known = &spline.anchors()[random.below(count)];
    match random.below(22) {
        0 | 1 => SplineEdit::MoveAnchor { anchor, to },
        2 => SplineEdit::MoveHandle { anchor, side, to },
        3 => SplineEdit::FreeHandle { anchor, side, to },
        4 | 5 => SplineEdit::Append { end, at: to },
        6 if random.next() < 0.5 => SplineEdit::DeleteFitted { anchor },
        6 => SplineEdit::Delete { anchor },
        7 => SplineEdit::SetJoin { anchor, join },
        8 => SplineEdit::SetScheme(Scheme::lane_riesenfeld().with_levels(random.below(6) as u8)),
        9 => SplineEdit::SetScheme(Scheme::of(Method::ALL[random.below(4)])),
        10 | 11 => SplineEdit::Insert { at: SplineT(random.next() * (count + 1) as f64) },
        12 => SplineEdit::Straighten { segment: anchor },
        13 => SplineEdit::Close,
        14 => SplineEdit::Open { anchor },
        15 => SplineEdit::Reverse,
        16 => SplineEdit::Cut { anchor, keep: end },
        17 => {
            let mut other = spline_on(surface, &[random.on_sphere(), random.on_sphere()], false);
            if random.next() < 0.5 {
                // One that begins where this ends.
                let begin = SplineEdit::MoveAnchor { anchor: 0, to: spline.anchors()[count - 1].point() };
                other.apply(surface, &mut PathFinder::new(), &begin).unwrap();
            }
            SplineEdit::Join { end, other, at: if random.next() < 0.5 { SplineEnd::Start } else { SplineEnd::End } }
        }
        18 => SplineEdit::SetJumps([JumpPolicy::Allow, JumpPolicy::Sticky, JumpPolicy::AutoSplit][random.below(3)]),
        19 | 20 => {
            let size = 0.5 + random.next();
            let matrix = glam::DMat2::from_scale_angle(glam::DVec2::new(size, 1.0), 7.0 * random.next());
            let transform = SelectionTransform { to, ..SelectionTransform::new(known.point(), matrix) };
            let transform = if random.next() < 0.5 { transform.chained() } else { transform };
            SplineEdit::Transform(if random.next() < 0.5 { transform.of([anchor, 0]) } else { transform })
        }
        _ => {
            let (from, handle) = (known.point(), known.handle(side).point());
            let path = |from: &SurfacePoint| surface.shortest_path(from, &to).unwrap();
            if random.next() < 0.5 {
                SplineEdit::DragAnchor { anchor, along: path(&from) }
            } else {
                SplineEdit::DragHandle { anchor, side, along: path(&handle) }
            }
        }
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
    assert!(applied > 20_000 && refused > 5_000, "{applied} {refused}");
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

/// A step of a drag in memory that is kept is the edit.
#[test]
fn splines_after_an_edit_are_the_same_in_kept_memory() {
    let surface = built(&shapes::torus(1.0, 0.4, 32, 16));
    let mut workspace = TraceWorkspace::default();
    let at = |u: f64, v: f64| {
        let out = 1.0 + 0.4 * v.cos();
        surface.closest_point(DVec3::new(out * u.cos(), out * u.sin(), 0.4 * v.sin())).unwrap().point
    };
    let points: Vec<_> = (0..4).map(|k| at(f64::from(k), 0.3 * f64::from(k))).collect();
    let smooth = Spline::smooth_through(&surface, &mut workspace.finder, &points, true).unwrap();
    let (mut kept, mut trace) = (smooth.clone(), Trace::default());
    for join in [Join::Corner, Join::Smooth, Join::Mirrored, Join::Automatic] {
        let mut base = smooth.clone().with_scheme(Scheme::lane_riesenfeld());
        base.apply(&surface, &mut workspace.finder, &SplineEdit::SetJoin { anchor: 1, join }).unwrap();
        for k in 0..12 {
            let heading = surface.tangent(&base.anchors()[1].point(), DVec3::new(0.3, f64::from(k), 1.0)).unwrap();
            let side = HandleSide::Incoming;
            let drag = |from: SurfacePoint| {
                let heading = surface.tangent(&from, heading_in_space(&surface, &heading)).unwrap();
                surface.walk(&from, &heading, 0.02 * f64::from(k)).unwrap().path
            };
            let anchor = &base.anchors()[1];
            for edit in [
                SplineEdit::DragAnchor { anchor: 1, along: drag(anchor.point()) },
                SplineEdit::DragHandle { anchor: 1, side, along: drag(anchor.handle(side).point()) },
                SplineEdit::MoveAnchor { anchor: 1, to: at(2.0, 0.1 * f64::from(k)) },
                SplineEdit::Delete { anchor: 1 },
            ] {
                let mut applied = base.clone();
                applied.apply(&surface, &mut workspace.finder, &edit).unwrap();
                kept.assign_after(&surface, &mut workspace.finder, &base, &edit).unwrap();
                assert_eq!(kept, applied);
                kept.trace_into(&surface, &mut workspace, &mut trace).unwrap();
                assert_eq!(trace, applied.trace(&surface, &mut TraceWorkspace::default(), None).unwrap());
            }
            let refused = SplineEdit::DragAnchor { anchor: 0, along: drag(base.anchors()[1].point()) };
            assert!(kept.assign_after(&surface, &mut workspace.finder, &base, &refused).is_err());
            assert_eq!(kept, base);
        }
    }
}

fn heading_in_space(surface: &Surface, heading: &crate::geodesic::Tangent) -> DVec3 {
    let [a, b, _] = surface.corners(heading.face).unwrap();
    (b - a) * heading.vector.x + DVec3::Z * heading.vector.y
}

#[test]
fn a_freed_handle_leaves_its_partner_alone() {
    let surface = Surface::build(&shapes::icosphere(3), &SurfaceOptions::default()).unwrap();
    let points = [DVec3::X, DVec3::Y, DVec3::Z].map(|p| at(&surface, p));
    let mut finder = PathFinder::default();
    let mut spline = Spline::smooth_through(&surface, &mut finder, &points, false).unwrap();
    let before = spline.clone();
    let to = at(&surface, DVec3::new(0.3, 1.0, -0.4));
    let edit = SplineEdit::FreeHandle { anchor: 1, side: HandleSide::Outgoing, to };
    let inverse = spline.apply(&surface, &mut finder, &edit).unwrap();
    assert_eq!(spline.anchors()[1].join(), Join::Corner);
    assert_eq!(spline.anchors()[1].incoming(), before.anchors()[1].incoming());
    assert!(surface.same_place(&spline.anchors()[1].outgoing().point(), &to));
    spline.apply(&surface, &mut finder, &inverse).unwrap();
    assert_eq!(spline, before);
}
