//! Ground truths of building: known meshes, broken meshes, random meshes.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use super::*;

fn built(mesh: &TriangleMesh) -> Surface {
    Surface::build(mesh, &SurfaceOptions::default()).unwrap()
}

/// Gives every corner a vertex of its own, as an STL file does.
fn soup(mesh: &TriangleMesh) -> TriangleMesh {
    let positions = mesh.faces.iter().flatten().map(|v| mesh.positions[*v as usize]).collect();
    TriangleMesh { positions, faces: (0..mesh.faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect() }
}

/// Links are mutual, corners turn in cycles, every star is one fan that starts most clockwise.
fn assert_sound(surface: &Surface) {
    let mut corners = 0;
    for face in 0..surface.triangles.len() as u32 {
        for k in 0..3 {
            let h = HalfEdge::new(face, k);
            let twin = surface.twin(h);
            if twin.is_some() {
                assert_eq!(surface.twin(twin), h);
                assert_eq!((surface.origin(twin), surface.target(twin)), (surface.target(h), surface.origin(h)));
            }
        }
    }
    for v in 0..surface.vertex_count() as u32 {
        let first = surface.outgoing[v as usize];
        let mut h = first;
        loop {
            assert_eq!(surface.origin(h), v);
            corners += 1;
            h = surface.counter_clockwise(h);
            if !h.is_some() || h == first {
                break;
            }
        }
        assert_eq!(!surface.twin(first).is_some(), surface.boundary[v as usize]);
    }
    assert_eq!(corners, 3 * surface.triangles.len());
}

/// Gauss–Bonnet: curvature inside plus turning along the boundary is 2π · Euler characteristic.
fn assert_gauss_bonnet(surface: &Surface, euler: i64) {
    let total: f64 =
        (0..surface.vertex_count()).map(|v| if surface.boundary[v] { PI } else { TAU } - surface.angle[v]).sum();
    let tolerance = 1e-9 * surface.vertex_count() as f64;
    assert!((total - TAU * euler as f64).abs() < tolerance, "{total}");
}

#[test]
fn cube_with_a_vertex_a_corner() {
    let surface = built(&soup(&shapes::cube()));
    assert_eq!((surface.vertex_count(), surface.face_count()), (8, 12));
    assert!((0..8).all(|v| (surface.curvature(v) - FRAC_PI_2).abs() < 1e-12));
    assert_gauss_bonnet(&surface, 2);
    assert_eq!(surface.report().euler_characteristic, 2);
    assert!(!surface.report().repaired());
}

#[test]
fn gauss_bonnet_on_known_shapes() {
    for (mesh, euler) in [
        (shapes::torus(2.0, 1.0, 24, 12), 0),
        (shapes::icosphere(3), 2),
        (shapes::grid(9, 5, 2.0, 1.0), 1),
        (shapes::cylinder(16, 4, 2.0), 0),
        (shapes::cone(12, 3, 0.5), 1),
    ] {
        let surface = built(&soup(&mesh));
        assert_sound(&surface);
        assert_gauss_bonnet(&surface, euler);
        assert_eq!(surface.report().euler_characteristic, euler);
    }
}

#[test]
fn half_the_faces_flipped_are_turned_back() {
    let mut mesh = shapes::icosphere(2);
    mesh.faces.iter_mut().step_by(3).for_each(|t| t.swap(1, 2));
    let surface = built(&mesh);
    assert_sound(&surface);
    let report = surface.report();
    assert!(report.orientable && !report.consistently_oriented);
    assert_eq!(report.flipped_faces, mesh.faces.len().div_ceil(3));
    let turned =
        mesh.faces.iter().step_by(3).map(|t| t.map(|v| mesh.positions[v as usize]).into_iter().sum::<DVec3>() / 3.0);
    let mut turned: Vec<DVec3> = turned.collect();
    assert_eq!(report.places.len(), turned.len());
    for (repair, place) in &report.places {
        let found =
            turned.iter().position(|at| at.distance(*place) < 1e-12).expect("the middle of a face that was turned");
        turned.swap_remove(found);
        assert_eq!(*repair, Repair::Flipped);
    }
    // Points keep the corners of the input.
    for (i, t) in mesh.faces.iter().enumerate() {
        let corners = surface.corners(FaceId(i as u32)).unwrap();
        assert_eq!(corners, t.map(|v| mesh.positions[v as usize]));
        let p = surface.point(FaceId(i as u32), [0.1, 0.2, 0.7]).unwrap();
        let expected = 0.1 * corners[0] + 0.2 * corners[1] + 0.7 * corners[2];
        assert!(surface.position(&p).distance(expected) < 1e-15);
        assert!(surface.normal(&p).dot(expected) > 0.9);
    }
}

#[test]
fn three_faces_on_one_edge_are_cut() {
    let positions = vec![DVec3::ZERO, DVec3::Z, DVec3::X, DVec3::Y, -DVec3::X];
    let mesh = TriangleMesh { positions, faces: vec![[0, 1, 2], [0, 1, 3], [1, 0, 4]] };
    let surface = built(&mesh);
    assert_sound(&surface);
    let report = surface.report();
    assert_eq!((report.nonmanifold_edges, report.sheets, report.components, report.boundary_loops), (1, 3, 1, 3));
    assert_eq!(report.places[0], (Repair::NonManifoldEdge, 0.5 * DVec3::Z));
    // Both ends of the edge are three vertices now; two of each are new.
    let split = |at: DVec3| report.places.iter().filter(|place| **place == (Repair::Split, at)).count();
    assert_eq!((split(DVec3::ZERO), split(DVec3::Z), report.places.len()), (2, 2, 5));
    let refuse = SurfaceOptions { nonmanifold_edges: NonManifoldEdges::Refuse, ..Default::default() };
    assert!(matches!(Surface::build(&mesh, &refuse), Err(SurfaceError::NonManifoldEdge { count: 3, .. })));
}

#[test]
fn two_tetrahedra_touching_in_a_vertex_are_parted() {
    let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let mut positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    positions.extend([-DVec3::X, -DVec3::Y, -DVec3::Z]);
    let mut faces = tetrahedron.to_vec();
    faces.extend(tetrahedron.map(|t| t.map(|v| if v == 0 { 0 } else { v + 3 })));
    let mesh = TriangleMesh { positions, faces };
    let surface = built(&mesh);
    assert_sound(&surface);
    assert_eq!((surface.vertex_count(), surface.report().nonmanifold_vertices, surface.report().sheets), (8, 1, 2));
    assert_eq!(surface.report().places, [(Repair::Split, DVec3::ZERO)]);
    let refuse = SurfaceOptions { nonmanifold_vertices: NonManifoldVertices::Refuse, ..Default::default() };
    assert!(matches!(Surface::build(&mesh, &refuse), Err(SurfaceError::NonManifoldVertex { .. })));
}

#[test]
fn moebius_band_is_cut_once() {
    let n = 12_u32;
    let mut mesh = TriangleMesh::default();
    for i in 0..n {
        let a = f64::from(i) / f64::from(n) * TAU;
        for side in [-0.3, 0.3] {
            let r = 1.0 + side * (a / 2.0).cos();
            mesh.positions.push(DVec3::new(r * a.cos(), r * a.sin(), side * (a / 2.0).sin()));
        }
    }
    for i in 0..n {
        let (a, b) = (2 * i, 2 * i + 1);
        let (c, d) = if i + 1 < n { (a + 2, b + 2) } else { (1, 0) };
        mesh.faces.extend([[a, c, b], [b, c, d]]);
    }
    let surface = built(&mesh);
    assert_sound(&surface);
    assert!(!surface.report().orientable);
    assert_eq!((surface.report().orientation_cuts, surface.report().boundary_loops), (1, 1));
    let side = |place: DVec3| {
        mesh.faces
            .iter()
            .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
            .any(|(a, b)| place.distance(0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize])) < 1e-12)
    };
    let cut = surface.report().places.iter().find(|(repair, _)| *repair == Repair::Cut).expect("a cut");
    assert!(side(cut.1));
    let refuse = SurfaceOptions { non_orientable: NonOrientable::Refuse, ..Default::default() };
    assert!(matches!(Surface::build(&mesh, &refuse), Err(SurfaceError::NonOrientable { .. })));
}

#[test]
fn a_pillow_is_linked_on_all_three_sides() {
    let mesh = TriangleMesh { positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y], faces: vec![[0, 1, 2], [0, 2, 1]] };
    let surface = built(&mesh);
    assert_sound(&surface);
    assert!(surface.report().is_closed());
    assert_gauss_bonnet(&surface, 2);
}

#[test]
fn what_cannot_be_built_says_why() {
    let triangle = |faces| TriangleMesh { positions: vec![DVec3::ZERO, DVec3::X, DVec3::NAN], faces };
    let build = |mesh: &TriangleMesh| Surface::build(mesh, &SurfaceOptions::default()).unwrap_err();
    assert_eq!(build(&TriangleMesh::default()), SurfaceError::NoFaces);
    assert!(matches!(build(&triangle(vec![[0, 1, 7]])), SurfaceError::IndexOutOfRange { index: 7, .. }));
    let not_finite = build(&triangle(vec![[0, 1, 2]]));
    assert!(matches!(not_finite, SurfaceError::NoUsableFaces { reason: DropReason::NotFinite, .. }));
    for scale in [1e200, 1e-200] {
        let mut mesh = shapes::cube();
        mesh.positions.iter_mut().for_each(|p| *p *= scale);
        assert!(matches!(build(&mesh), SurfaceError::Scale { .. }));
    }
    let progress = BuildProgress::default();
    progress.cancel();
    let cancelled = Surface::build_observed(&shapes::cube(), &SurfaceOptions::default(), &progress);
    assert_eq!(cancelled.unwrap_err(), SurfaceError::Cancelled);
}

#[test]
fn dropped_faces_have_no_points() {
    let mut mesh = shapes::cube();
    mesh.faces.insert(3, [1, 1, 2]);
    mesh.faces.push(mesh.faces[0]);
    let surface = built(&mesh);
    assert_eq!(
        surface.point(FaceId(3), [1.0, 0.0, 0.0]),
        Err(PointError::FaceDropped(FaceId(3), DropReason::RepeatedCorner))
    );
    assert_eq!(
        surface.point(FaceId(13), [1.0, 0.0, 0.0]),
        Err(PointError::FaceDropped(FaceId(13), DropReason::Duplicate))
    );
    assert_eq!(surface.point(FaceId(99), [1.0, 0.0, 0.0]), Err(PointError::NoSuchFace(FaceId(99), 14)));
    assert!(surface.point(FaceId(13 - 1), [1.0, 0.0, 0.0]).is_ok());
    assert_eq!(surface.report().duplicate_faces, 1);
    let middle = |face: usize| mesh.faces[face].map(|v| mesh.positions[v as usize]).into_iter().sum::<DVec3>() / 3.0;
    assert_eq!(surface.report().places, [3, 13].map(|face| (Repair::Dropped, middle(face))));
    let foreign = SurfacePoint { face: FaceId(99), weights: [1.0, 0.0, 0.0] };
    assert!(surface.position(&foreign).is_nan());
}

#[test]
fn spellings_of_one_place_are_recognised() {
    let surface = built(&shapes::icosphere(1));
    let p = surface.point(FaceId(17), [0.0, 1.0, 0.0]).unwrap();
    let inner = surface.inner_point(&p).unwrap();
    let mut spellings = Vec::new();
    surface.for_each_spelling(&inner, |s| spellings.push(surface.outer_point(&s)));
    assert!(spellings.len() == 5 || spellings.len() == 6);
    let canonical = surface.canonical(&p).unwrap();
    for s in &spellings {
        assert!(surface.same_place(&p, s));
        assert_eq!(surface.canonical(s).unwrap(), canonical);
    }
    let side = surface.point(FaceId(17), [0.25, 0.0, 0.75]).unwrap();
    let across = surface.canonical(&side).unwrap();
    assert!(surface.position(&side).distance(surface.position(&across)) < 1e-15);
    assert!(!surface.same_place(&p, &side));
}

#[test]
fn order_of_faces_does_not_matter() {
    let mesh = shapes::torus(2.0, 0.7, 20, 10);
    let mut shuffled = mesh.clone();
    let n = shuffled.faces.len();
    for i in 0..n {
        shuffled.faces.swap(i, (i * 7919 + 13) % n);
    }
    let (a, b) = (built(&mesh), built(&shuffled));
    let sorted = |s: &Surface| {
        let mut angles = s.angle.clone();
        angles.sort_by(f64::total_cmp);
        angles
    };
    for (x, y) in sorted(&a).iter().zip(sorted(&b)) {
        assert!((x - y).abs() < 1e-12);
    }
    assert_eq!(SurfaceReport { ..a.report().clone() }.to_string(), b.report().to_string());
}

#[test]
fn rays_and_nearest_points_speak_input_faces() {
    let mut mesh = shapes::icosphere(3);
    mesh.faces.iter_mut().step_by(2).for_each(|t| t.swap(1, 2));
    let surface = built(&mesh);
    let hit = surface.ray(DVec3::new(0.1, 0.2, 5.0), DVec3::NEG_Z).unwrap();
    assert!((surface.position(&hit.point) - DVec3::new(0.1, 0.2, hit.position.z)).length() < 1e-12);
    assert!(hit.position.distance(surface.position(&hit.point)) < 1e-12);
    assert!((hit.distance - (5.0 - hit.position.z)).abs() < 1e-12);
    let near = surface.closest_point(hit.position * 1.5).unwrap();
    assert!(near.position.distance(hit.position) < 0.1);
    assert!(surface.closest_point(DVec3::NAN).is_none());
}

#[test]
fn far_away_nothing_is_lost() {
    let near = shapes::icosphere(3);
    let far = DVec3::new(1e6, -2e6, 3e6);
    let mut mesh = near.clone();
    // Rounded to what is left of the digits out there, so that both meshes have the same shape.
    mesh.positions.iter_mut().for_each(|p| *p = (*p + far) - far);
    let here = built(&mesh);
    mesh.positions.iter_mut().for_each(|p| *p += far);
    let there = built(&mesh);
    for i in 0..20 {
        let [p, q] = [i * 31 % 1280, i * 57 % 1280].map(|f| there.point(FaceId(f), [0.2, 0.3, 0.5]).unwrap());
        let lengths = [&here, &there].map(|s| s.shortest_path(&p, &q).unwrap().length());
        assert!((lengths[0] - lengths[1]).abs() < 1e-12, "{lengths:?}");
        let position = there.position(&p);
        assert!(there.closest_point(position).unwrap().distance < 1e-9);
        assert!((position - far - here.position(&p)).length() < 1e-9);
    }
    assert_eq!(there.corners(FaceId(5)).unwrap(), mesh.faces[5].map(|v| mesh.positions[v as usize]));
    assert!(there.ray(far + DVec3::X * 5.0, -DVec3::X).is_some());
}

#[test]
fn refusals_name_input_faces() {
    // Faces without use in front, and the one that is named last in memory.
    let positions = vec![DVec3::ONE, DVec3::splat(0.9), DVec3::X, DVec3::Y, DVec3::ZERO, DVec3::Z];
    let faces = vec![[1, 1, 2], [0, 0, 2], [0, 1, 2], [1, 0, 3], [0, 1, 4], [4, 2, 5], [5, 2, 4]];
    let mesh = TriangleMesh { positions, faces };
    let refuse = SurfaceOptions { nonmanifold_edges: NonManifoldEdges::Refuse, ..Default::default() };
    let error = Surface::build(&mesh, &refuse).unwrap_err();
    assert_eq!(error, SurfaceError::NonManifoldEdge { face: FaceId(2), count: 3 });
    let refuse = SurfaceOptions { nonmanifold_vertices: NonManifoldVertices::Refuse, ..Default::default() };
    let error = Surface::build(&mesh, &refuse).unwrap_err();
    assert!(matches!(error, SurfaceError::NonManifoldVertex { face, .. } if face >= FaceId(2)), "{error}");
}

/// A torus large enough to be cut into pieces, with some of everything that is repaired.
fn large_and_broken() -> TriangleMesh {
    let mut mesh = shapes::torus(2.0, 0.7, 220, 110);
    let n = mesh.faces.len();
    for i in 0..n {
        mesh.faces.swap(i, (i * 7919 + 13) % n);
    }
    mesh.faces.iter_mut().step_by(7).for_each(|t| t.swap(1, 2));
    mesh.faces.push(mesh.faces[5]);
    let [a, b, c] = mesh.faces[9];
    let new = mesh.positions.len() as u32;
    mesh.positions.extend([DVec3::ONE, -DVec3::ONE]);
    mesh.faces.extend([[a, b, new], [c, new, new + 1], [a, a, b]]);
    mesh
}

#[cfg(feature = "parallel")]
#[test]
fn threads_leave_no_trace() {
    let mesh = large_and_broken();
    let [one, five] = [1, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| format!("{:?}", built(&mesh)))
    });
    assert!(one == five);
}

#[test]
fn a_build_can_be_watched_and_stopped() {
    let mesh = large_and_broken();
    for wait in 0..20 {
        let progress = BuildProgress::default();
        let (mut last, mut grew) = (0.0, true);
        let result = std::thread::scope(|scope| {
            let build = scope.spawn(|| Surface::build_observed(&mesh, &SurfaceOptions::default(), &progress));
            for _ in 0..wait * 20 {
                let now = progress.fraction();
                (last, grew) = (now, grew && now >= last);
                std::thread::sleep(std::time::Duration::from_micros(10));
            }
            progress.cancel();
            build.join().unwrap()
        });
        assert!(grew && (0.0..=1.0).contains(&last));
        assert!(result.is_ok() || result.is_err_and(|e| e == SurfaceError::Cancelled));
    }
}

#[test]
fn memory_is_counted() {
    let surface = built(&shapes::torus(2.0, 0.7, 100, 50));
    let memory = surface.memory();
    let of = |name| memory.arrays.iter().find(|array| array.name == name).unwrap().bytes;
    assert_eq!(of("corners of faces"), 12 * surface.face_count());
    assert_eq!(of("positions of vertices"), 24 * surface.vertex_count());
    assert!(memory.bytes() < 110 * surface.face_count());
    assert!(memory.arrays.is_sorted_by(|a, b| a.bytes >= b.bytes));
    assert_eq!(memory.to_string().lines().count(), memory.arrays.len() + 1);
}
