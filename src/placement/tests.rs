//! Placements on surfaces where everything is known.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat4, DVec2, DVec3};

use super::*;
use crate::curve::{Join, Spline, TraceWorkspace};
use crate::geodesic::PathFinder;
use crate::surface::{Surface, SurfaceOptions, TriangleMesh, shapes};
use crate::vector::{Color, Drawing, Paint, PathBuilder, Shape, Style, VectorPath};

fn built(mesh: &TriangleMesh) -> Surface {
    Surface::build(mesh, &SurfaceOptions::default()).unwrap()
}

fn at(surface: &Surface, x: f64, y: f64, z: f64) -> crate::surface::SurfacePoint {
    surface.closest_point(DVec3::new(x, y, z)).unwrap().point
}

fn drawing(paths: Vec<VectorPath>) -> Drawing {
    let fill = Some(Paint::Color(Color::BLACK));
    let style = Style { fill, opacity: 1.0, ..Style::default() };
    Drawing { shapes: vec![Shape { paths, style, ..Shape::default() }], ..Drawing::default() }
}

/// A circle of radius 1 about the origin, a flower of corners and smooth anchors, an open wave.
fn sample() -> Drawing {
    let mut pen = PathBuilder::default();
    pen.move_to(DVec2::X);
    pen.arc_to(DVec2::ONE, 0.0, false, true, -DVec2::X);
    pen.arc_to(DVec2::ONE, 0.0, false, true, DVec2::X);
    pen.close();
    pen.move_to(DVec2::new(0.5, 0.1));
    for k in 1..=7 {
        let u = DVec2::from_angle(TAU * f64::from(k) / 7.0);
        pen.cubic_to(u * 0.9, u.perp() * 0.3 + u * 0.5, u * if k % 2 == 0 { 0.5 } else { 0.3 });
    }
    pen.close();
    pen.move_to(DVec2::new(-1.2, 0.3));
    pen.quadratic_to(DVec2::new(-0.6, 1.0), DVec2::new(0.0, 0.3));
    pen.quadratic_to(DVec2::new(0.6, -0.4), DVec2::new(1.2, 0.3));
    drawing(pen.finish())
}

fn place(surface: &Surface, drawing: &Drawing, placement: &Placement, options: &PlaceOptions) -> PlacedDrawing {
    let options = PlaceOptions { origin: Some(DVec2::ZERO), ..*options };
    place_drawing(surface, drawing, placement, &options).unwrap()
}

#[test]
fn on_a_plane_the_drawing_is_itself() {
    let surface = built(&shapes::grid(13, 17, 10.0, 10.0));
    let drawing = sample();
    for (k, handles) in [HandleRule::Relative, HandleRule::Polar].into_iter().cycle().take(12).enumerate() {
        let angle = 0.7 * k as f64;
        // Also from vertices and from the middle of sides.
        let centre = [DVec2::new(5.1, 4.7), DVec2::new(50.0 / 13.0, 50.0 / 17.0), DVec2::new(50.0 / 13.0, 5.0)][k % 3];
        let up = DVec2::from_angle(angle);
        let point = at(&surface, centre.x, centre.y, 0.0);
        let placement = Placement { at: point, up: DVec3::new(up.x, up.y, 3.0), scale: 1.7 };
        let placed = place(&surface, &drawing, &placement, &PlaceOptions { handles, ..PlaceOptions::default() });
        let right = -up.perp();
        let expected = |q: DVec2| centre + 1.7 * (q.x * right - q.y * up);
        assert_eq!(placed.splines.len(), 3);
        for (PlacedSpline { spline, .. }, (_, path)) in placed.splines.iter().zip(drawing.paths()) {
            assert_eq!((spline.is_closed(), spline.segment_count()), (path.is_closed(), path.segment_count()));
            for (i, planar) in path.segments().enumerate() {
                for (point, q) in spline.polygon(i).unwrap().iter().zip(planar) {
                    let off = surface.position(point).truncate().distance(expected(q));
                    assert!(off < 1e-12, "{k} {handles:?}: {off}");
                }
            }
        }
        let joins: Vec<Join> = placed.splines[0].spline.anchors().iter().map(|a| a.join()).collect();
        assert_eq!(joins, [Join::Mirrored; 4]);
        assert_eq!(placed.splines[2].spline.anchors()[1].join(), Join::Mirrored);
    }
}

#[test]
fn on_a_sphere_circles_stay_circles_and_joins_stay_smooth() {
    let surface = built(&shapes::icosphere(6));
    for centre in [DVec3::X, DVec3::new(0.3, 0.5, 0.8), surface.vertex_position(crate::surface::VertexId(17)).unwrap()]
    {
        let centre = centre.normalize();
        let point = surface.closest_point(centre).unwrap().point;
        let placement = Placement { at: point, up: DVec3::new(0.2, 0.9, -0.4), scale: 0.8 };
        for handles in [HandleRule::Relative, HandleRule::Polar] {
            let placed = place(&surface, &sample(), &placement, &PlaceOptions { handles, ..PlaceOptions::default() });
            let circle = &placed.splines[0].spline;
            for anchor in circle.anchors() {
                let angle = surface.position(&anchor.point()).normalize().angle_between(centre);
                assert!((angle - 0.8).abs() < 2e-3, "{angle}");
            }
            for anchor in placed.splines.iter().flat_map(|s| s.spline.anchors()) {
                if matches!(anchor.join(), Join::Smooth | Join::Mirrored) {
                    let back = surface.opposite(&anchor.point(), &anchor.incoming().heading()).unwrap();
                    let [a, b] = [back, anchor.outgoing().heading()].map(|t| surface.tangent_in_space(&t).unwrap());
                    // Faces of an icosphere of this level meet at 2° at most.
                    assert!((a - b).length() < if back.face == anchor.outgoing().heading().face { 1e-9 } else { 0.04 });
                }
            }
        }
    }
}

#[test]
fn paths_that_leave_the_surface_are_dropped_or_cut() {
    let surface = built(&shapes::grid(10, 10, 10.0, 10.0));
    let placement = Placement { at: at(&surface, 9.2, 5.0, 0.0), up: DVec3::Y, scale: 1.0 };
    let placed = place(&surface, &sample(), &placement, &PlaceOptions::default());
    let outcomes: Vec<PathOutcome> = placed.paths.iter().map(|p| p.outcome).collect();
    let off = PathOutcome::Dropped(DropReason::OffSurface);
    assert_eq!(outcomes, [off, PathOutcome::Placed, off]);
    assert_eq!(placed.dropped(), 2);

    let clip = PlaceOptions { boundary: Boundary::Clip, ..PlaceOptions::default() };
    let placed = place(&surface, &sample(), &placement, &clip);
    assert_eq!(placed.paths[0].outcome, PathOutcome::Clipped { gone: 0 });
    assert_eq!(placed.dropped(), 0);
    // The circle x² + y² = 1 is cut at x = 0.8.
    let arc = &placed.splines[0].spline;
    assert!(!arc.is_closed() && arc.segment_count() == 4);
    let ends = [&arc.anchors()[0], &arc.anchors()[4]].map(|a| surface.position(&a.point()));
    for (end, y) in ends.iter().zip([4.4, 5.6]) {
        assert!(end.distance(DVec3::new(10.0, y, 0.0)) < 1e-3, "{end}");
    }
    // Much too large.
    let placed = place(&surface, &sample(), &Placement { scale: 1e6, ..placement }, &clip);
    assert_eq!(placed.paths[0].outcome, PathOutcome::Dropped(DropReason::TooFar));
}

#[test]
fn placements_without_sense_are_refused() {
    let surface = built(&shapes::grid(2, 2, 1.0, 1.0));
    let good = Placement { at: at(&surface, 0.4, 0.4, 0.0), up: DVec3::Y, scale: 1.0 };
    let refused =
        |placement: Placement| place_drawing(&surface, &sample(), &placement, &PlaceOptions::default()).unwrap_err();
    for up in [DVec3::ZERO, DVec3::Z, DVec3::NAN, DVec3::INFINITY] {
        assert!(matches!(refused(Placement { up, ..good }), PlaceError::NoUp { .. }), "{up}");
    }
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(Placement { scale, ..good }), PlaceError::BadScale { .. }));
    }
    let foreign = crate::surface::SurfacePoint::new(crate::surface::FaceId(99), [1.0, 0.0, 0.0]).unwrap();
    assert!(matches!(refused(Placement { at: foreign, ..good }), PlaceError::Point(_)));
    for up in [DVec3::Y * 1e-300, DVec3::Y * 1e300] {
        assert!(place_drawing(&surface, &sample(), &Placement { up, ..good }, &PlaceOptions::default()).is_ok());
    }
}

#[test]
fn placements_are_turned_moved_and_pulled() {
    let surface = built(&shapes::grid(10, 10, 10.0, 10.0));
    let mut finder = PathFinder::new();
    let placement = Placement { at: at(&surface, 3.3, 3.1, 0.0), up: DVec3::Y, scale: 0.5 };
    assert!((placement.turned(&surface, FRAC_PI_2).unwrap().up - DVec3::NEG_X).length() < 1e-12);
    let moved = placement.moved(&surface, &mut finder, &at(&surface, 7.0, 8.0, 0.0)).unwrap();
    assert!((moved.up - DVec3::Y).length() < 1e-12 && moved.scale == 0.5);
    assert!(surface.position(&moved.at).distance(DVec3::new(7.0, 8.0, 0.0)) < 1e-12);
    let pulled = placement.pulled(&surface, &mut finder, &at(&surface, 6.3, 7.1, 0.0), 10.0).unwrap();
    assert!((pulled.up.normalize() - DVec3::new(0.6, 0.8, 0.0)).length() < 1e-12 && (pulled.scale - 0.5).abs() < 1e-12);
    assert!(placement.pulled(&surface, &mut finder, &placement.at, 1.0).is_err());
}

#[test]
fn a_drawing_comes_back_from_where_it_was_placed() {
    let drawing = sample();
    let mut finder = PathFinder::new();
    for (mesh, centre, tolerance) in [
        (shapes::grid(10, 10, 10.0, 10.0), DVec3::new(5.03, 4.88, 0.0), 1e-11),
        // Walks on a sphere are shortest but for a few that pass a vertex on its other side.
        (shapes::icosphere(5), DVec3::new(0.3, 0.5, 0.8), 5e-3),
    ] {
        let surface = built(&mesh);
        let point = surface.closest_point(centre).unwrap().point;
        let placement = Placement { at: point, up: DVec3::new(0.1, 0.8, 0.1), scale: 0.4 };
        let placed = place(&surface, &drawing, &placement, &PlaceOptions::default());
        let splines = placed.splines.iter().map(|s| &s.spline);
        let back = drawing_about(&surface, &mut finder, splines, &placement, DVec2::ZERO).unwrap();
        assert_eq!(back.shapes.len(), 3);
        for ((_, a), (_, b)) in drawing.paths().zip(back.paths()) {
            assert_eq!((a.is_closed(), a.points().len()), (b.is_closed(), b.points().len()));
            for (p, q) in a.points().iter().zip(b.points()) {
                assert!(p.distance(*q) < tolerance, "{p} {q}");
            }
        }
    }
}

#[test]
fn curves_are_drawn_as_a_camera_sees_them() {
    let surface = built(&shapes::grid(10, 10, 10.0, 10.0));
    let placement = Placement { at: at(&surface, 5.0, 5.0, 0.0), up: DVec3::Y, scale: 2.0 };
    let drawing = sample();
    let placed = place(&surface, &drawing, &placement, &PlaceOptions::default());
    let mut workspace = TraceWorkspace::default();
    let scheme = crate::curve::Scheme::de_casteljau().with_levels(6);
    let traces: Vec<_> = placed
        .splines
        .iter()
        .map(|s| s.spline.clone().with_scheme(scheme).trace(&surface, &mut workspace, None).unwrap())
        .collect();
    // A page that undoes the placement.
    let view = DMat4::from_scale(DVec3::splat(0.5)) * DMat4::from_translation(DVec3::new(-5.0, -5.0, 0.0));
    let seen = drawing_in_view(&traces, &view).unwrap();
    for ((_, a), (_, b)) in drawing.paths().zip(seen.paths()) {
        assert_eq!(b.segment_count(), 16 * a.segment_count());
        for i in 0..b.segment_count() {
            for t in [0.0, 0.3, 0.5, 0.8] {
                let exact = a.point_at(i / 16, ((i % 16) as f64 + t) / 16.0);
                assert!(b.point_at(i, t).distance(exact) < 4e-4, "{}", b.point_at(i, t).distance(exact));
            }
        }
    }
    let behind = DMat4::perspective_rh(1.0, 1.0, 0.1, 100.0) * DMat4::look_at_rh(DVec3::Z, 2.0 * DVec3::Z, DVec3::Y);
    assert!(matches!(drawing_in_view(&traces, &behind), Err(ProjectError::NotInView { curve: 0 })));
}

#[test]
fn previews_lie_where_the_drawing_will() {
    let surface = built(&shapes::grid(10, 10, 10.0, 10.0));
    let drawing = sample();
    let outline = DrawingOutline::new(&drawing, 120).with_origin(DVec2::ZERO);
    assert!((100..=125).contains(&outline.len()), "{}", outline.len());
    let mut preview = PlacementPreview::default();
    let placement = Placement { at: at(&surface, 5.0, 5.0, 0.0), up: DVec3::Y, scale: 2.0 };
    preview.update(&surface, &outline, &placement).unwrap();
    assert_eq!((preview.polylines().count(), preview.missing()), (3, 0));
    let circle = preview.polylines().next().unwrap();
    assert!(circle.iter().all(|p| (p.distance(DVec3::new(5.0, 5.0, 0.0)) - 2.0).abs() < 1e-3));
    let at_border = Placement { at: at(&surface, 9.0, 5.0, 0.0), ..placement };
    preview.update(&surface, &outline, &at_border).unwrap();
    assert!(preview.missing() > 0 && preview.polylines().count() >= 3);
    assert!(preview.update(&surface, &outline, &Placement { scale: 0.0, ..placement }).is_err());
    assert_eq!(preview.polylines().count(), 0);
}

#[test]
fn single_segments_that_close_on_themselves_are_placed() {
    let surface = built(&shapes::icosphere(4));
    let points = [(0.0, 0.0), (1.0, -1.0), (-1.0, -1.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
    let drop = drawing(vec![VectorPath::from_points(points, true).unwrap()]);
    let placement = Placement { at: at(&surface, 0.0, 0.1, 1.0), up: DVec3::Y, scale: 0.5 };
    let placed = place(&surface, &drop, &placement, &PlaceOptions::default());
    let spline: &Spline = &placed.splines[0].spline;
    assert_eq!((spline.segment_count(), spline.anchors().len()), (1, 1));
    let trace = spline.trace(&surface, &mut TraceWorkspace::default(), None).unwrap();
    assert!(trace.length() > 0.5 && trace.length() < PI);
}

#[cfg(feature = "parallel")]
#[test]
fn threads_change_nothing() {
    let surface = built(&shapes::icosphere(5));
    let mut many = sample();
    for _ in 0..5 {
        many.shapes.extend(many.shapes.clone());
    }
    let placement = Placement { at: at(&surface, 0.3, 0.1, 1.0), up: DVec3::Y, scale: 0.7 };
    let place = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| place_drawing(&surface, &many, &placement, &PlaceOptions::default()).unwrap())
    };
    assert_eq!(place(1), place(4));
}
