//! Random queries on small closed, open and degenerate meshes, at points on, beside and a hair beside sides and corners.

use glam::{DVec2, DVec3};

use super::*;
use crate::curve::*;
use crate::geodesic::Tangent;
use crate::surface::FaceId;

fn meshes() -> Vec<(&'static str, TriangleMesh)> {
    let mesh = |positions: &[[f64; 3]], faces: &[[u32; 3]]| TriangleMesh {
        positions: positions.iter().map(|p| DVec3::from(*p)).collect(),
        faces: faces.to_vec(),
    };
    let pillow = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.75_f64.sqrt(), 0.0]];
    let four = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let thin = [[1e-170, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let fan: Vec<[f64; 3]> = (0..7)
        .map(|k| if k == 0 { [0.0; 3] } else { [f64::from(k).cos(), f64::from(k).sin(), 0.2 * f64::from(k)] })
        .collect();
    vec![
        ("pillow", mesh(&pillow, &[[0, 1, 2], [0, 2, 1]])),
        ("thin pillow", mesh(&thin, &[[0, 1, 2], [0, 2, 1]])),
        ("tetrahedron", mesh(&four, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])),
        ("fan", mesh(&fan, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6]])),
        ("cube", shapes::cube()),
        ("grid", shapes::grid(4, 4, 1.0, 1.0)),
        ("sphere", shapes::icosphere(2)),
        ("torus", shapes::torus(2.0, 0.7, 9, 6)),
        ("cylinder", shapes::cylinder(7, 2, 2.0)),
    ]
}

fn weights(random: &mut Random) -> [f64; 3] {
    const HAIRS: [f64; 10] = [0.0, -0.0, 1e-300, 1e-20, 1e-17, 1e-16, 1e-12, 1e-10, 1e-8, 1e-5];
    let mut pick = || if random.next() < 0.5 { HAIRS[random.below(HAIRS.len())] } else { random.next() };
    let (a, b) = (pick(), pick());
    let (a, b) = if a + b > 1.0 { (0.5 * a, 0.5 * b) } else { (a, b) };
    let mut weights = [1.0 - a - b, a, b];
    weights.rotate_left(random.below(3));
    weights
}

fn point(surface: &Surface, random: &mut Random) -> SurfacePoint {
    loop {
        let face = FaceId(random.below(surface.face_count()) as u32);
        if let Ok(p) = surface.point(face, weights(random)) {
            return p;
        }
    }
}

#[test]
fn paths_and_walks_hold_what_they_promise() {
    for (name, mesh) in meshes() {
        let surface = built(&mesh);
        let mut finder = PathFinder::new();
        let mut random = Random(name.len() as u64);
        let size = surface.diagonal();
        for i in 0..400 {
            let (p, q) = (point(&surface, &mut random), point(&surface, &mut random));
            let path = finder.shortest(&surface, &p, &q).unwrap();
            assert!(!path.is_frozen(), "{name} {i}: {p:?} {q:?}");
            let ends =
                [(path.start(), p), (path.end(), q)].map(|(a, b)| surface.position(&a).distance(surface.position(&b)));
            assert!(ends.iter().all(|d| *d < 1e-9 * size), "{name} {i}: {ends:?}");
            assert!(path.length() >= surface.position(&p).distance(surface.position(&q)) - 1e-9 * size);
            let heading = Tangent { face: p.face, vector: DVec2::from_angle(7.0 * random.next()) };
            let distance = 2.0 * size * random.next();
            let walk = surface.walk(&p, &heading, distance).unwrap();
            let length = walk.path.length();
            if name == "thin pillow" {
                // Faces without area have no directions to keep: it is enough to come to an end.
                assert!(length.is_finite());
                continue;
            }
            let whole = walk.stopped.is_some() || (length - distance).abs() < 1e-9 * size;
            assert!(
                length <= distance + 1e-9 * size && whole,
                "{name} {i}: {length} of {distance}, {:?}",
                walk.stopped
            );
            assert!(!surface.report().is_closed() || walk.stopped.is_none(), "{name} {i}");
            let carried = surface.transport(&path, &path.initial_tangent(&surface).unwrap()).unwrap();
            assert!((carried.length() - path.length()).abs() < 1e-9 * size, "{name} {i}");
        }
    }
}

#[test]
fn walking_along_the_logarithm_arrives_in_the_plane() {
    let surface = built(&shapes::grid(4, 4, 1.0, 1.0));
    let mut random = Random(8);
    for i in 0..3000 {
        let (p, q) = (point(&surface, &mut random), point(&surface, &mut random));
        let log = surface.log(&p, &q).unwrap();
        let walk = surface.exp(&p, &log).unwrap();
        let off = surface.position(&walk.path.end()).distance(surface.position(&q));
        // Vertices on the boundary stop a walk that a path may run along.
        // A path may pass a vertex on the wrong side where that costs less than rounding: 1e-8 off its line.
        assert!(off < 1e-7 || walk.stopped.is_some(), "{i}: {off} {p:?} {q:?}");
        let inside =
            |p: &SurfacePoint| surface.position(p).truncate().to_array().iter().all(|x| (0.01..0.99).contains(x));
        assert!(off < 1e-7 || !inside(&p) || !inside(&q), "{i}: {off} {p:?} {q:?}");
    }
}

#[test]
fn boundary_vertices_take_headings_from_any_face() {
    let surface = built(&shapes::grid(4, 4, 1.0, 1.0));
    let vertex = at(&surface, DVec3::new(0.5, 0.0, 0.0));
    let inner = surface.inner_point(&vertex).unwrap();
    let mut spellings = Vec::new();
    surface.for_each_spelling(&inner, |p| spellings.push(surface.outer_point(&p)));
    assert_eq!(spellings.len(), 3);
    for p in &spellings {
        for direction in [(1.0, 0.1), (0.1, 1.0), (-1.0, 0.1), (-1.0, 0.0), (1.0, 0.0)] {
            let direction = DVec3::new(direction.0, direction.1, 0.0);
            let heading = surface.tangent(p, direction).unwrap();
            let end = surface.position(&surface.walk(p, &heading, 0.2).unwrap().path.end());
            assert!(end.distance(DVec3::new(0.5, 0.0, 0.0) + 0.2 * direction.normalize()) < 1e-12, "{p:?} {direction}");
            let back = surface.opposite(p, &surface.tangent(p, DVec3::X).unwrap()).unwrap();
            let end = surface.position(&surface.walk(p, &back, 0.2).unwrap().path.end());
            assert!(end.distance(DVec3::new(0.3, 0.0, 0.0)) < 1e-12);
        }
    }
}

#[test]
fn who_starts_beside_a_vertex_does_not_run_into_it() {
    let surface = built(&shapes::grid(4, 4, 1.0, 1.0));
    for hair in [5e-13, 1e-10, 1e-8, 1e-6] {
        let p = surface.point(FaceId(0), [hair, hair, 1.0 - 2.0 * hair]).unwrap();
        let heading = surface.tangent(&p, DVec3::new(0.009, -1.0, 0.0)).unwrap();
        let end = surface.walk(&p, &heading, 0.2).unwrap().path.end();
        let expected = surface.position(&p) + 0.2 * DVec3::new(0.009, -1.0, 0.0).normalize();
        assert!(surface.position(&end).distance(expected) < 1e-9 + 2.0 * hair, "{hair}");
    }
}

#[test]
fn traces_and_edits_survive() {
    for (name, mesh) in meshes() {
        let surface = built(&mesh);
        let mut workspace = TraceWorkspace::default();
        let mut random = Random(77 + name.len() as u64);
        for i in 0..25 {
            let polygon = [(); 4].map(|()| point(&surface, &mut random));
            let mut spline = Spline::bezier(&surface, &mut workspace.finder, polygon).unwrap();
            let original = format!("{spline:?}");
            let mut trace = spline.trace(&surface, &mut workspace, None).unwrap();
            let mut inverses = Vec::new();
            for _ in 0..6 {
                let (anchor, to) = (random.below(3) as u32, point(&surface, &mut random));
                let edit = match random.below(5) {
                    0 => SplineEdit::MoveAnchor { anchor, to },
                    1 => SplineEdit::MoveHandle { anchor, side: HandleSide::Outgoing, to },
                    2 => SplineEdit::Append { end: SplineEnd::End, at: to },
                    3 => SplineEdit::SetJoin { anchor, join: Join::Smooth },
                    _ => SplineEdit::SetScheme(Scheme::lane_riesenfeld().with_levels(3)),
                };
                if let Ok(inverse) = spline.apply(&surface, &mut workspace.finder, &edit) {
                    inverses.push(inverse);
                }
                trace = spline.trace(&surface, &mut workspace, Some(&trace)).unwrap();
                let scratch = spline.trace(&surface, &mut TraceWorkspace::default(), None).unwrap();
                assert_eq!(trace, scratch, "{name} {i}");
                assert!(trace.positions().iter().all(|p| p.is_finite()), "{name} {i}");
            }
            for inverse in inverses.iter().rev() {
                spline.apply(&surface, &mut workspace.finder, inverse).unwrap();
            }
            assert_eq!(format!("{spline:?}"), original, "{name} {i}");
            if let Some(last) = inverses.last() {
                let again = spline.apply(&surface, &mut workspace.finder, last);
                assert!(inverses.len() > 1 || again.is_ok() || again == Err(EditError::OtherVersion));
            }
        }
    }
}

#[test]
fn traces_are_not_taken_for_those_of_another_surface() {
    let small = built(&shapes::icosphere(3));
    let mut mesh = shapes::icosphere(3);
    mesh.positions.iter_mut().for_each(|p| *p *= 2.0);
    let large = built(&mesh);
    let mut workspace = TraceWorkspace::default();
    let spline = spline_on(&small, &[DVec3::X, DVec3::Y, DVec3::Z], true);
    let first = spline.trace(&small, &mut workspace, None).unwrap();
    let second = spline.trace(&large, &mut workspace, Some(&first)).unwrap();
    assert_eq!(second.retraced().len(), 3);
    assert!((second.length() / first.length() - 2.0).abs() < 1e-9);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let surface = built(&shapes::icosphere(1));
    let p = surface.point(FaceId(0), [0.2, 0.3, 0.5]).unwrap();
    for weights in [[0.0; 3], [1.0; 3], [1e-300, 0.0, 0.0], [f64::NAN, 0.5, 0.5]] {
        assert!(surface.shortest_path(&p, &SurfacePoint { face: FaceId(3), weights }).is_err(), "{weights:?}");
    }
    let path = surface.shortest_path(&p, &surface.point(FaceId(40), [0.2, 0.3, 0.5]).unwrap()).unwrap();
    assert!(path.at(&surface, f64::NAN).is_err());
    let ahead = Tangent { face: p.face, vector: DVec2::X };
    assert!(surface.turned(&p, &ahead, f64::NAN).is_err() && surface.tangent(&p, DVec3::NAN).is_err());
    let foreign = Tangent { face: FaceId(70), vector: DVec2::X };
    assert!(surface.walk(&p, &foreign, 1.0).is_err() && surface.transport(&path, &foreign).is_err());
    for length in [1e200, 1e-200] {
        let walk = surface.walk(&p, &Tangent { vector: ahead.vector * length, ..ahead }, 0.5).unwrap();
        assert!((walk.path.length() - 0.5).abs() < 1e-12);
    }
    // A whole spline whose handle hangs on another anchor.
    let mut spline = spline_on(&surface, &[DVec3::X, DVec3::Y, DVec3::Z], false);
    let mut broken = spline.clone();
    broken.anchors[0].outgoing = broken.anchors[1].outgoing.clone();
    let refused = spline.apply(&surface, &mut PathFinder::new(), &SplineEdit::Replace(broken));
    assert_eq!(refused, Err(EditError::BadHandle { anchor: 0 }));
}
