//! Weights beside closed forms and finer triangulations.

use glam::{DVec2, DVec3};

use super::*;
use crate::skin::{BindOptions, BoundChain, Chain, JoinRules, SkinError};
use crate::surface::{Surface, SurfaceOptions, TriangleMesh, shapes};
use crate::vector::VectorPath;

#[cfg(feature = "weights")]
mod meshed {
    use std::f64::consts::{PI, TAU};

    use super::super::meshed::solve_bounded;
    use super::super::plane_mesh::PlaneMesh;
    use super::super::sparse::Symmetric;
    use super::*;
    use crate::skin::tests::{Random, apart, solve};

    fn square() -> Cage {
        Cage::new(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from)).unwrap()
    }

    fn disc(corners: u32) -> Cage {
        let corner = |i| DVec2::from_angle(TAU * f64::from(i) / f64::from(corners));
        Cage::new(&(0..corners).map(corner).collect::<Vec<_>>()).unwrap()
    }

    fn at(field: &MeshedWeights, x: f64, y: f64) -> Vec<f64> {
        let mut out = vec![0.0; field.handle_count()];
        field.weights_at(DVec3::new(x, y, 0.0), &mut out);
        out
    }

    /// All weights within their bounds, and sums of one, at vertices and between them, inside and outside.
    fn check(field: &MeshedWeights, seed: u64) {
        let mut random = Random(seed);
        let between: Vec<Vec<f64>> =
            (0..500).map(|_| at(field, random.between(-1.5, 1.5), random.between(-1.5, 1.5))).collect();
        for weights in field.vertices().map(|(_, w)| w).chain(between.iter().map(Vec::as_slice)) {
            assert!(weights.iter().all(|w| (-1e-6..=1.0 + 1e-6).contains(w)), "{weights:?}");
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn harmonic_coordinates_of_a_square_are_bilinear() {
        let mut last = f64::INFINITY;
        for triangles in [200, 3000, 12_000] {
            let field = MeshedWeights::harmonic(&square(), triangles).unwrap();
            let of_vertex = |(p, w): (DVec2, &[f64])| {
                let exact = [(1.0 - p.x) * (1.0 - p.y), p.x * (1.0 - p.y), p.x * p.y, (1.0 - p.x) * p.y];
                exact.iter().zip(w).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            let worst = field.vertices().map(of_vertex).fold(0.0, f64::max);
            println!("{} triangles: {worst:.1e}, sums {:?}", field.report().triangles, field.report().sums);
            assert!(worst < 0.5 * last && field.report().sums.iter().all(|sum| (sum - 1.0).abs() < 1e-9));
            last = worst;
            check(&field, 1);
        }
        assert!(last < 2e-4, "{last}");
    }

    #[test]
    fn harmonic_coordinates_of_a_disc_are_poissons_integral() {
        let corners = 64;
        let field = MeshedWeights::harmonic(&disc(corners), 12_000).unwrap();
        check(&field, 2);
        for (x, y) in [(0.0, 0.0), (0.3, 0.1), (-0.2, 0.6), (0.7, 0.0)] {
            let place = DVec2::new(x, y);
            let weights = at(&field, x, y);
            for (i, weight) in weights.iter().enumerate() {
                // The hat about a corner against Poisson's kernel.
                let steps = 400;
                let width = TAU / f64::from(corners);
                let hat = |k: i32| {
                    let off = width * (f64::from(k) + 0.5) / f64::from(steps);
                    let angle = width * i as f64 + off;
                    let kernel =
                        (1.0 - place.length_squared()) / (DVec2::from_angle(angle) - place).length_squared() / TAU;
                    kernel * (1.0 - off.abs() / width) * width / f64::from(steps)
                };
                let exact: f64 = (-steps..steps).map(hat).sum();
                assert!((weight - exact).abs() < 1e-3 * exact.max(0.3), "{place} {i}: {weight} {exact}");
            }
        }
    }

    #[test]
    fn biharmonic_weights_between_two_sides_are_a_cubic() {
        let sides = [HandleShape::Bone(DVec3::ZERO, DVec3::Y), HandleShape::Bone(DVec3::X, DVec3::new(1.0, 1.0, 0.0))];
        let mut last = f64::INFINITY;
        for triangles in [400, 1600, 6400] {
            let field = MeshedWeights::biharmonic(&square(), &sides, triangles).unwrap();
            let of_vertex = |(p, w): (DVec2, &[f64])| (w[1] - p.x * p.x * (3.0 - 2.0 * p.x)).abs();
            let worst = field.vertices().map(of_vertex).fold(0.0, f64::max);
            println!("{:?}: {worst:.1e}", field.report());
            assert!(worst < last);
            last = worst;
            check(&field, 3);
        }
        assert!(last < 0.01, "{last}");
    }

    #[test]
    fn biharmonic_weights_of_a_disc_are_radial() {
        // One for the centre, none on the rim, flat there: 1 − r² + 2 r² ln r.
        let cage = disc(96);
        let mut last = f64::INFINITY;
        for triangles in [1000, 8000] {
            let mesh = PlaneMesh::new(&cage, &[DVec2::ZERO], triangles, 8).unwrap();
            let of_vertex = |(p, on_cage): (&DVec2, &bool)| {
                let share = if p.length() < 1e-12 { Some(1.0) } else { on_cage.then_some(0.0) };
                share.map(|share| [(0, share), (1, 1.0 - share)])
            };
            let fixed: Vec<_> = mesh.positions.iter().zip(&mesh.on_cage).map(of_vertex).collect();
            let solved = solve_bounded(&mesh, &fixed, 2).unwrap();
            let worst = mesh.positions.iter().zip(&solved[0].values).map(|(p, w)| {
                let r = p.length().max(1e-300);
                (w - (1.0 - r * r + 2.0 * r * r * r.ln())).abs()
            });
            let worst = worst.fold(0.0, f64::max);
            println!("{} triangles: {worst:.1e}", mesh.triangles.len());
            assert!(worst < last);
            last = worst;
        }
        assert!(last < 0.01, "{last}");
    }

    #[test]
    fn bounded_weights_are_the_minimum() {
        let places = [(0.2, 0.2), (0.8, 0.25), (0.7, 0.8), (0.25, 0.7)].map(DVec2::from);
        let mesh = PlaneMesh::new(&square(), &places, 2500, 8).unwrap();
        let vertices = places.map(|place| mesh.vertex_at(place, 1.0).unwrap());
        let fixed: Vec<_> = (0..mesh.positions.len())
            .map(|v| vertices.iter().position(|of| *of == v).map(|handle| [(handle, 1.0), (handle, 0.0)]))
            .collect();
        let solved = solve_bounded(&mesh, &fixed, 4).unwrap();
        let (laplacian, areas) = Symmetric::laplacian(&mesh);
        let q = laplacian.squared(&areas);
        let scale = (0..q.size()).map(|i| q.diagonal(i)).sum::<f64>() / q.size() as f64;
        for one in &solved {
            assert!(one.settled && one.rounds > 0, "bounds are at work here");
            let pull = q.times(&one.values);
            let mut bounds = [0, 0];
            for (i, w) in one.values.iter().enumerate().filter(|(i, _)| fixed[*i].is_none()) {
                let wrong = match *w {
                    w if w <= 0.0 => (-pull[i]).max(0.0),
                    w if w >= 1.0 => pull[i].max(0.0),
                    _ => pull[i].abs(),
                };
                bounds[0] += usize::from(*w <= 0.0);
                bounds[1] += usize::from(*w >= 1.0);
                assert!((0.0..=1.0).contains(w) && wrong < 1e-6 * scale, "{w} {wrong}");
            }
            println!("{} rounds, {bounds:?} of {} at bounds", one.rounds, one.values.len());
        }
    }

    #[test]
    fn biharmonic_weights_are_near_to_those_of_a_finer_triangulation() {
        let handles = [(0.2, 0.2), (0.8, 0.25), (0.5, 0.8)].map(|p| HandleShape::planar(p.into()));
        let fields = [800, 3200].map(|t| MeshedWeights::biharmonic(&square(), &handles, t).unwrap());
        fields.iter().for_each(|field| check(field, 5));
        let fine = MeshedWeights::biharmonic(&square(), &handles, 12_800).unwrap();
        println!("{:?}", fine.report());
        let mut random = Random(6);
        let mut worst = [0.0_f64; 2];
        for _ in 0..400 {
            let (x, y) = (random.between(0.0, 1.0), random.between(0.0, 1.0));
            for (worst, field) in worst.iter_mut().zip(&fields) {
                for (a, b) in at(field, x, y).iter().zip(at(&fine, x, y)) {
                    *worst = worst.max((a - b).abs());
                }
            }
        }
        println!("beside 12,800 triangles: 800 are off by {:.1e}, 3,200 by {:.1e}", worst[0], worst[1]);
        assert!(worst[1] < worst[0] && worst[1] < 0.02, "{worst:?}");
        let twice = MeshedWeights::biharmonic(&square(), &handles, 800).unwrap();
        assert!(twice.vertices().eq(fields[0].vertices()), "the same every time");
    }

    #[test]
    fn cages_move_what_is_inside() {
        let star: Vec<DVec2> =
            (0..10).map(|i| DVec2::from_angle(PI * f64::from(i) / 5.0) * if i % 2 == 0 { 2.0 } else { 1.0 }).collect();
        let backwards: Vec<DVec2> = star.iter().rev().copied().collect();
        let points = [(-0.5, 0.0), (-0.2, 0.6), (0.2, -0.6), (0.5, 0.0)].map(DVec2::from).to_vec();
        let chain = Chain::planar(&VectorPath::from_points(points, false).unwrap(), &JoinRules::default());
        for corners in [star, backwards] {
            let cage = Cage::new(&corners).unwrap();
            cage.holds(std::slice::from_ref(&chain)).unwrap();
            let fields =
                [MeshedWeights::harmonic(&cage, 3000), MeshedWeights::biharmonic_cage(&cage, 1500)].map(Result::unwrap);
            for field in fields {
                check(&field, 4);
                let bound = BoundChain::new(&chain, 0, &field, &BindOptions::default()).unwrap();
                let moved: Vec<DVec2> = corners.iter().map(|c| *c + DVec2::new(0.5, -0.25)).collect();
                let pose: Vec<_> = cage.pose(&moved).unwrap().iter().map(crate::skin::in_space).collect();
                let wished: Vec<_> = chain.points().iter().map(|p| *p + DVec3::new(0.5, -0.25, 0.0)).collect();
                assert!(apart(&solve(&bound, &pose), &wished) < 1e-9);
                // Corners have their own weights to themselves.
                for (i, corner) in corners.iter().enumerate() {
                    assert!((at(&field, corner.x, corner.y)[i] - 1.0).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn handles_that_cannot_be_are_refused() {
        let at = |x, y| HandleShape::planar(DVec2::new(x, y));
        let field = |handles: &[HandleShape]| MeshedWeights::biharmonic(&square(), handles, 200).map(|_| ());
        assert_eq!(field(&[]), Err(WeightsError::NoHandles));
        assert_eq!(field(&[at(0.5, 0.5), at(f64::NAN, 0.0)]), Err(WeightsError::NotFinite { point: 1 }));
        assert_eq!(field(&[at(0.5, 0.5), at(0.5, 0.5)]), Err(WeightsError::SamePlace { handles: [0, 1] }));
        let outside = field(&[at(0.5, 0.5), at(1.5, 0.5)]);
        assert_eq!(outside, Err(WeightsError::HandleOutside { handle: 1, distance: 0.5 }));
        assert!(field(&[at(0.0, 0.5), at(1.0, 1.0)]).is_ok());
        // Just too near and just far enough, whatever is between them in the list.
        let near = |gap: f64| field(&[at(0.5, 0.5), at(0.2, 0.7), at(0.5 + gap, 0.5)]);
        assert_eq!(near(1.4e-6), Err(WeightsError::SamePlace { handles: [0, 2] }));
        assert_eq!(near(2e-6), Ok(()));
        // A bone that runs over a point.
        let bone = HandleShape::Bone(DVec3::new(0.1, 0.5, 0.0), DVec3::new(0.9, 0.5, 0.0));
        assert_eq!(field(&[at(0.1, 0.5), bone]), Err(WeightsError::SamePlace { handles: [0, 1] }));
    }

    #[test]
    fn more_weights_than_memory_should_hold_are_refused() {
        let many = disc(4096);
        let refused = [MeshedWeights::harmonic(&many, 60_000), MeshedWeights::biharmonic_cage(&many, 60_000)];
        for refused in refused.map(Result::unwrap_err) {
            assert!(matches!(refused, WeightsError::TooMany { handles: 4096, .. }), "{refused}");
        }
    }
}

#[test]
fn drawings_that_leave_their_cage_are_told_and_follow_its_rim() {
    let points = (0..4).map(|i| DVec2::new(f64::from(i) * 0.5, 0.5)).collect();
    let chain = Chain::planar(&VectorPath::from_points(points, false).unwrap(), &JoinRules::default());
    let cage = Cage::around(DVec2::ZERO, DVec2::ONE, 0.0).unwrap();
    assert_eq!(
        cage.holds(std::slice::from_ref(&chain)),
        Err(WeightsError::Leaves { chain: 0, segment: 0, distance: 0.5 })
    );
    assert_eq!(Cage::around(DVec2::ZERO, DVec2::ONE, 1.0).unwrap().holds(&[chain]), Ok(()));
    assert_eq!(cage.pose(&[DVec2::ZERO]), Err(WeightsError::Length { found: 1, expected: 4 }));
}

#[test]
fn painted_weights_are_linear_on_faces() {
    let mesh = shapes::icosphere(3);
    let surface = Surface::build(&mesh, &SurfaceOptions::default()).unwrap();
    let painted: Vec<f64> = mesh.positions.iter().flat_map(|p| [2.0 + p.x, 2.0 - p.x]).collect();
    let field = SurfaceWeights::painted(&surface, &mesh, 2, &painted).unwrap();
    let mut out = [0.0; 2];
    for place in [DVec3::new(0.3, 0.4, 0.8), DVec3::new(-3.0, 0.4, 0.1), DVec3::Z] {
        let on = surface.closest_point(place).unwrap().position;
        field.weights_at(place, &mut out);
        assert!((out[0] - (2.0 + on.x) / 4.0).abs() < 1e-12 && (out[0] + out[1] - 1.0).abs() < 1e-15);
    }
    assert_eq!(field.far_handles(&[DVec3::X, DVec3::X * 10.0], 0.1).len(), 1);
}

#[test]
fn skins_keep_the_largest_weights() {
    let triangle = TriangleMesh { positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y], faces: vec![[2, 0, 1]] };
    let surface = Surface::build(&triangle, &SurfaceOptions::default()).unwrap();
    let joints = [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]];
    let weights = [[0.4, 0.3, 0.2, 0.1]; 3];
    let field = SurfaceWeights::of_skin(&surface, &triangle, 12, &[(&joints, &weights)]).unwrap();
    let mut out = [0.0; 12];
    field.weights_at(DVec3::new(1.0 / 3.0, 1.0 / 3.0, 2.0), &mut out);
    assert_eq!(out.iter().filter(|w| **w > 0.0).count(), 8);
    assert!((out.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    field.weights_at(DVec3::ZERO, &mut out);
    assert!((out[0] - 0.4).abs() < 1e-7 && (out[3] - 0.1).abs() < 1e-7 && out[4] == 0.0);
    let refused = |joints: &[[u16; 4]], weights: &[[f32; 4]]| {
        SurfaceWeights::of_skin(&surface, &triangle, 12, &[(joints, weights)]).map(|_| ()).unwrap_err()
    };
    assert_eq!(refused(&joints[..2], &weights), WeightsError::Length { found: 2, expected: 3 });
    assert_eq!(refused(&joints, &[[f32::NAN; 4]; 3]), WeightsError::BadWeight { vertex: 0 });
    let huge = SurfaceWeights::painted(&surface, &triangle, 2, &[f64::MAX; 6]);
    assert_eq!(huge.map(|_| ()).unwrap_err(), WeightsError::BadWeight { vertex: 0 });
    assert_eq!(
        refused(&[[0; 4], [0; 4], [12; 4]], &weights),
        WeightsError::NoSuchHandle { vertex: 2, handle: 12, handles: 12 }
    );
    // Nothing moves a vertex without weights.
    let none = SurfaceWeights::of_skin(&surface, &triangle, 12, &[(&joints, &[[0.0; 4]; 3])]).unwrap();
    let points = (0..4).map(|i| DVec2::new(f64::from(i), 0.0)).collect();
    let chain = Chain::planar(&VectorPath::from_points(points, false).unwrap(), &JoinRules::default());
    let bound = BoundChain::new(&chain, 0, &none, &BindOptions::default());
    assert_eq!(bound.unwrap_err(), SkinError::NoWeights { chain: 0, segment: 0 });
}
