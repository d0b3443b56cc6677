//! Where lines come from, and what they become.

use super::*;
use crate::curve::{DrawnLine, FitOptions, Scheme, Spline, TraceWorkspace, Tracer};
use crate::geodesic::PathFinder;
use crate::surface::{FaceId, shapes};

#[test]
fn points_drawings_and_traces_become_lines_of_their_length() {
    for mesh in [shapes::grid(30, 30, 1.0, 1.0), shapes::icosphere(4), shapes::torus(2.0, 0.7, 60, 30)] {
        let surface = built(&mesh);
        let mut random = Random(3);
        let mut finder = PathFinder::new();
        let mut point = || {
            surface.outer_point(&InnerPoint {
                face: (random.word() % surface.triangles.len() as u64) as u32,
                weights: [0.2, 0.3, 0.5],
            })
        };
        for _ in 0..10 {
            let points = [point(), point(), point(), point()];
            for closed in [false, true] {
                let drawn = DrawnLine::through(&surface, &mut finder, &points, closed).unwrap();
                let line = SurfacePolyline::drawn(&surface, &drawn).unwrap();
                assert_eq!(line.is_closed(), closed);
                // Corners inside faces are cut, and what leads there and back.
                assert!(line.length(&surface) <= drawn.length() * (1.0 + 1e-12));
                assert!(line.length(&surface) > 0.4 * drawn.length());
                let back = line.to_drawn(&surface).unwrap();
                assert!((back.length() - line.length(&surface)).abs() < 1e-9 * back.length());
                let again = SurfacePolyline::drawn(&surface, &back).unwrap();
                assert!((again.length(&surface) - line.length(&surface)).abs() < 1e-9 * back.length());
            }
            let trace = Tracer::new(&surface).trace(&points, &Scheme::lane_riesenfeld()).unwrap();
            let line = SurfacePolyline::along(&surface, &trace, false).unwrap();
            let share = line.length(&surface) / trace.length();
            assert!(share > 0.6 && share < 1.0 + 1e-9, "{share}");
        }
    }
}

#[test]
fn the_boundary_of_a_selection_runs_around_it() {
    let surface = built(&shapes::grid(20, 20, 1.0, 1.0));
    let chosen = |low: DVec3, high: DVec3| -> Vec<FaceId> {
        (0..surface.face_count() as u32)
            .map(FaceId)
            .filter(|f| {
                let [a, b, c] = surface.corners(*f).unwrap();
                let middle = (a + b + c) / 3.0;
                middle.cmpge(low).all() && middle.cmple(high).all()
            })
            .collect()
    };
    let inner = SurfacePolyline::around_faces(&surface, &chosen(DVec3::new(0.2, 0.2, -1.0), DVec3::new(0.8, 0.6, 1.0)))
        .unwrap();
    assert_eq!(inner.len(), 1);
    assert!(inner[0].is_closed());
    // The two corners that are a single face's own are cut.
    let length = inner[0].length(&surface);
    assert!((length - 2.0).abs() < 0.08 && length <= 2.0 + 1e-12, "{length}");
    let smoothed = smooth(
        &surface,
        &mut SmoothWorkspace::default(),
        &inner[0],
        &Smoothing { roughness: 0.0, ..Smoothing::tether(300.0) },
    )
    .unwrap();
    assert!(smoothed.after.length < length && smoothed.after.max_distance < 0.2);
    // At the boundary of the surface the line ends.
    let outer =
        SurfacePolyline::around_faces(&surface, &chosen(DVec3::new(-1.0, -1.0, -1.0), DVec3::new(0.5, 2.0, 1.0)))
            .unwrap();
    assert_eq!(outer.len(), 1);
    assert!(!outer[0].is_closed());
    assert!((outer[0].length(&surface) - 1.0).abs() < 1e-9, "{}", outer[0].length(&surface));
    assert!(SurfacePolyline::around_faces(&surface, &[FaceId(1 << 20)]).is_err());
    assert!(SurfacePolyline::around_faces(&surface, &[FaceId(400)]).unwrap().is_empty());
}

#[test]
fn a_smoothed_line_becomes_a_spline() {
    let surface = built(&shapes::icosphere(5));
    let mut random = Random(4);
    let mut workspace = SmoothWorkspace::default();
    let mut points = Vec::new();
    for k in 0..80 {
        let a = 0.03 * f64::from(k);
        let tremor = 0.05 * DVec3::new(random.next(), random.next(), random.next());
        points.push(at(&surface, DVec3::new(a.cos(), a.sin(), 0.4 * (2.0 * a).sin()) + tremor));
    }
    let line = SurfacePolyline::through(&surface, &mut workspace.finder, &points, false).unwrap();
    let smoothed = smooth(&surface, &mut workspace, &line, &Smoothing::default()).unwrap();
    let mut traces = TraceWorkspace::default();
    let segments = |line: &SurfacePolyline, traces: &mut TraceWorkspace| {
        let drawn = line.to_drawn(&surface).unwrap();
        Spline::fit(&surface, traces, &drawn, &FitOptions::within(0.01)).unwrap().spline.segment_count()
    };
    let (rough, smooth) = (segments(&line, &mut traces), segments(&smoothed.line, &mut traces));
    println!("{rough} segments for what was drawn, {smooth} for what was smoothed");
    assert!(smooth * 2 < rough && smooth <= 12, "{rough} {smooth}");
}

#[test]
fn what_makes_no_line_is_refused() {
    let surface = built(&shapes::grid(4, 4, 1.0, 1.0));
    let other = built(&shapes::icosphere(3));
    let mut workspace = SmoothWorkspace::default();
    let points = [DVec3::new(0.1, 0.2, 0.0), DVec3::new(0.9, 0.8, 0.0)].map(|p| at(&surface, p));
    let line = SurfacePolyline::through(&surface, &mut workspace.finder, &points, false).unwrap();
    assert!(smooth(&other, &mut workspace, &line, &Smoothing::default()).is_err());
    assert!(SurfacePolyline::through(&surface, &mut workspace.finder, &points[..1], false).is_err());
    let tiny = [(0.30, 0.26), (0.45, 0.26), (0.45, 0.3)].map(|(x, y)| at(&surface, DVec3::new(x, y, 0.0)));
    assert!(matches!(
        SurfacePolyline::through(&surface, &mut workspace.finder, &tiny, true),
        Err(PolylineError::TooSmall(_))
    ));
    assert!(SurfacePolyline::closed(&surface, Vec::new()).is_err());
    for mode in [
        SmoothingMode::Stencil { scale: f64::NAN, passes: 5 },
        SmoothingMode::Budget { share: 2.0 },
        SmoothingMode::Tether { closeness: -1.0 },
        SmoothingMode::Lift { weight: f64::INFINITY },
    ] {
        assert!(matches!(smooth(&surface, &mut workspace, &line, &Smoothing::by(mode)), Err(SmoothError::Options(_))));
    }
    let sweeps = Smoothing { iteration: Iteration::Symmetric, ..Smoothing::default() };
    assert!(smooth(&surface, &mut workspace, &line, &sweeps).is_err());
    let bad = Smoothing::default().within(Envelope::Hard(0.0));
    assert!(smooth(&surface, &mut workspace, &line, &bad).is_err());
    let mut line = line;
    assert!(line.set_fixed(1000, true).is_err());
}
