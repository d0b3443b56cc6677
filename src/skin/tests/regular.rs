//! What a regular solve reproduces, and that it is the least.

use glam::{DAffine2, DAffine3, DMat3, DVec2, DVec3};

use super::dense::{Dense, Metric, joined, segments};
use super::*;

#[test]
fn handles_at_rest_leave_all_as_it_is() {
    for seed in 0..200 {
        let mut random = Random(seed);
        let spatial = seed % 2 == 1;
        let kinds = if seed % 3 == 0 { vec![JoinKind::ALL[seed as usize % 4]] } else { JoinKind::ALL.to_vec() };
        let (count, closed) = (1 + random.below(20), random.below(2) == 0);
        let mut chain = random_chain(&mut random, count, closed, spatial, &kinds);
        let anchor = random.below(chain.anchor_count());
        if seed % 5 == 0 {
            chain.pin(anchor, Some(chain.points()[3 * anchor])).unwrap();
        }
        let weights = random_handles(&mut random, 4, spatial);
        let still = [DAffine3::IDENTITY; 4];
        for measure in [Measure::Parameter, Measure::ArcLength] {
            let options = BindOptions { quadrature: Some(Quadrature { nodes: 6, pieces: 1 }), measure };
            for options in [options, BindOptions::default()] {
                let bound = BoundChain::new(&chain, 0, &weights, &options).unwrap();
                let off = apart(&solve(&bound, &still), chain.points()) / chain.extent();
                assert!(off < 1e-13, "seed {seed} {options:?}: {off:e}");
                let mut out = Vec::new();
                bound.solve_flexible(&still, &Default::default(), &mut Default::default(), &mut out).unwrap();
                let off = apart(&out, chain.points()) / chain.extent();
                assert!(off < 1e-13, "flexible, seed {seed} {options:?}: {off:e}");
            }
        }
    }
}

#[test]
fn one_transform_of_all_handles_is_that_of_the_chain() {
    for seed in 0..200 {
        let mut random = Random(seed);
        let spatial = seed % 2 == 1;
        let (count, closed) = (1 + random.below(12), random.below(2) == 0);
        let turned = seed % 4 > 1;
        let kinds = if turned { &JoinKind::ALL[..] } else { &JoinKind::ALL[..3] };
        let chain = random_chain(&mut random, count, closed, spatial, kinds);
        let weights = random_handles(&mut random, 3, spatial);
        let affine = random_pose(&mut random, 1, spatial)[0];
        let shift = affine.translation;
        let turn = if spatial {
            DMat3::from_axis_angle(random.vector(true).normalize(), random.between(-3.0, 3.0))
        } else {
            DMat3::from_axis_angle(DVec3::Z, random.between(-3.0, 3.0))
        };
        // Angles are kept by similarities; in space also by mirroring ones.
        let mirror = if spatial && seed % 8 == 3 { -1.0 } else { 1.0 };
        let similar = DAffine3 { matrix3: turn * (1.7 * mirror), translation: shift };
        let transform = if turned { similar } else { affine };
        let bound = bind(&chain, &weights);
        let wished: Vec<DVec3> = chain.points().iter().map(|p| transform.transform_point3(*p)).collect();
        let off = apart(&solve(&bound, &[transform; 3]), &wished) / chain.extent();
        assert!(off < 1e-12, "seed {seed}: {off:e}");
    }
}

#[test]
fn the_reference_pose_comes_out() {
    let points = [(0.0, 0.0), (1.0, 2.0), (3.0, 2.0), (4.0, 0.0)].map(DVec2::from);
    let places = [(-0.5, 0.3), (2.0, 2.2), (4.5, 0.2)].map(DVec2::from);
    let path = VectorPath::from_points(points.to_vec(), false).unwrap();
    let chain = Chain::planar(&path, &JoinRules::default());
    let weights = Shepard::new(&places.map(HandleShape::planar)).unwrap();
    let about = |place: DVec2, angle: f64| {
        DAffine2::from_translation(place) * DAffine2::from_angle(angle) * DAffine2::from_translation(-place)
    };
    let pose = [about(places[0], 0.6), DAffine2::from_translation(DVec2::new(0.3, 0.8)), about(places[2], -0.9)]
        .map(|t| in_space(&t));
    let wished = [
        (5.369_745_17e-4, 0.388_125_517),
        (0.543_517_143, 3.169_048_23),
        (4.291_297_92, 3.014_550_09),
        (4.177_997_67, 0.504_357_139),
    ];
    let fine = BindOptions { quadrature: Some(Quadrature { nodes: 64, pieces: 4 }), ..Default::default() };
    for (options, within) in [(fine, 1e-8), (BindOptions::default(), 1e-6)] {
        let bound = BoundChain::new(&chain, 0, &weights, &options).unwrap();
        for (p, (x, y)) in solve(&bound, &pose).iter().zip(wished) {
            assert!(p.distance(DVec3::new(x, y, 0.0)) < within, "{p} {x} {y}");
        }
    }
}

#[test]
fn the_band_gives_what_multipliers_give() {
    let mut worst: f64 = 0.0;
    for seed in 0..120 {
        let mut random = Random(seed + 1000);
        let spatial = seed % 3 == 2;
        let count = if seed % 10 == 0 { 40 } else { 1 + random.below(12) };
        let closed = random.below(2) == 0;
        let mut chain = random_chain(&mut random, count, closed, spatial, &JoinKind::ALL);
        let handles = 1 + random.below(5);
        let weights = random_handles(&mut random, handles, spatial);
        let pose = random_pose(&mut random, handles, spatial);
        if seed % 4 == 0 {
            let anchor = random.below(chain.anchor_count());
            chain.pin(anchor, Some(chain.points()[3 * anchor] + random.vector(spatial))).unwrap();
        }
        let bound = bind(&chain, &weights);
        let solved = solve(&bound, &pose);
        let dense = Dense::new(&bound, &weights, &pose, Metric::Energy);
        let by_multipliers = dense.nearest(&bound, Metric::Energy, &bound.solve_loose(&pose).unwrap(), false);
        let off = apart(&joined(&chain, &by_multipliers), &solved) / chain.extent();
        let missed = dense.missed(&segments(&chain, &solved)).max(bound.violation(&pose, &solved, false));
        assert!(off < 1e-10, "seed {seed}: {off:e}");
        assert!(missed < 1e-9 * chain.extent(), "seed {seed}: {missed:e}");
        worst = worst.max(off);
    }
    println!("largest difference to multipliers: {worst:e} of the extent");
}

#[test]
fn chains_without_extent_or_length_are_solved() {
    let weights = Shepard::new(&[DVec2::ZERO, DVec2::X].map(HandleShape::planar)).unwrap();
    let pose = [DAffine3::IDENTITY, in_space(&DAffine2::from_angle(1.0))];
    let at = DVec2::new(0.3, 2.0);
    let same = vec![at; 7];
    let mut one_flat = vec![DVec2::ZERO, DVec2::Y, DVec2::ONE, at, at, at, at];
    one_flat.extend([DVec2::X, DVec2::Y, DVec2::ONE]);
    let no_handles = vec![at, at, DVec2::X, DVec2::X, DVec2::X, DVec2::ZERO, DVec2::ZERO];
    let single = vec![at, DVec2::X, DVec2::Y];
    for (points, closed) in
        [(same.clone(), false), (same[..6].to_vec(), true), (one_flat, false), (no_handles, false), (single, true)]
    {
        let path = VectorPath::from_points(points, closed).unwrap();
        let chain = Chain::planar(&path, &JoinRules::default());
        let bound = bind(&chain, &weights);
        assert!(apart(&solve(&bound, &[DAffine3::IDENTITY; 2]), chain.points()) < 1e-12);
        let mut flexible = Vec::new();
        bound.solve_flexible(&pose, &Default::default(), &mut Default::default(), &mut flexible).unwrap();
        for points in [solve(&bound, &pose), flexible] {
            assert!(points.iter().all(|p| p.is_finite()), "{points:?}");
            assert!(bound.violation(&pose, &points, false) < 1e-9);
        }
    }
    let empty = Chain::planar(&VectorPath::default(), &JoinRules::default());
    assert!(solve(&bind(&empty, &weights), &pose).is_empty());
}

#[test]
fn sixteen_nodes_are_as_accurate_as_said() {
    // A handle close by a curve, and weights that fall fast there.
    let path =
        VectorPath::from_points([(0.0, 0.0), (1.0, 2.0), (3.0, 2.0), (4.0, 0.0)].map(DVec2::from).to_vec(), false);
    let chain = Chain::planar(&path.unwrap(), &JoinRules::default());
    let weights = Shepard::new(&[DVec2::new(2.0, 1.9), DVec2::new(-0.5, 0.3)].map(HandleShape::planar)).unwrap();
    let pose = [in_space(&DAffine2::from_translation(DVec2::Y)), DAffine3::IDENTITY];
    let with = |nodes, pieces| {
        let options = BindOptions { quadrature: Some(Quadrature { nodes, pieces }), ..Default::default() };
        solve(&BoundChain::new(&chain, 0, &weights, &options).unwrap(), &pose)
    };
    let exact = with(64, 8);
    let errors = [(6, 1), (8, 1), (16, 1), (8, 4)].map(|(nodes, pieces)| apart(&with(nodes, pieces), &exact));
    println!("errors with 6, 8, 16 and 4 times 8 nodes: {errors:?}");
    assert!(errors[2] < 1e-5 && errors[2] < errors[1] && errors[1] < errors[0] && errors[3] < errors[1]);
}

#[test]
fn what_cannot_be_bound_is_refused() {
    struct Nothing;
    impl WeightField for Nothing {
        fn handle_count(&self) -> usize {
            2
        }
        fn weights_at(&self, place: DVec3, out: &mut [f64]) {
            out.fill(if place.x > 1.0 { 0.0 } else { 1.0 });
        }
    }
    let points = (0..7).map(|i| DVec2::new(f64::from(i) / 3.0, 0.0)).collect();
    let chain = Chain::planar(&VectorPath::from_points(points, false).unwrap(), &JoinRules::default());
    let bound = BoundChain::new(&chain, 5, &Nothing, &BindOptions::default());
    assert_eq!(bound.unwrap_err(), SkinError::NoWeights { chain: 5, segment: 1 });
}
