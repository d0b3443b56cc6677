//! What nobody should ask for.

use super::*;

fn two_handles() -> Shepard {
    Shepard::new(&[DVec2::ZERO, DVec2::X].map(HandleShape::planar)).unwrap()
}

fn some_chain(scale: f64) -> Chain {
    let points = [(0.0, 0.0), (1.0, 2.0), (3.0, 2.0), (4.0, 0.0), (5.0, -2.0), (6.0, 1.0), (7.0, 0.0)];
    let path = VectorPath::from_points(points.map(|p| DVec2::from(p) * scale).to_vec(), false).unwrap();
    Chain::planar(&path, &JoinRules::default())
}

#[test]
fn poses_that_do_not_fit_are_refused_everywhere() {
    let (chain, weights) = (some_chain(1.0), two_handles());
    let bound = bind(&chain, &weights);
    let mut broken = [DAffine3::IDENTITY; 2];
    broken[1].matrix3.x_axis.y = f64::INFINITY;
    let long = [DAffine3::IDENTITY; 3];
    let cases: [(&[DAffine3], SkinError); 4] = [
        (&[], SkinError::PoseLength { handles: 2, found: 0 }),
        (&long[..1], SkinError::PoseLength { handles: 2, found: 1 }),
        (&long, SkinError::PoseLength { handles: 2, found: 3 }),
        (&broken, SkinError::PoseNotFinite { handle: 1 }),
    ];
    for (pose, wished) in cases {
        let (mut workspace, mut out) = (SolveWorkspace::default(), Vec::new());
        let wished = Err(wished);
        assert_eq!(bound.solve(pose, &mut workspace, &mut out), wished);
        assert_eq!(bound.solve_flexible(pose, &Default::default(), &mut workspace, &mut out).map(|_| ()), wished);
        assert_eq!(bound.solve_loose(pose).map(|_| ()), wished);
        let split = SplitChain::new(&chain, &weights, &Default::default(), &[pose.to_vec()], &Default::default());
        assert_eq!(split.map(|_| ()), wished);
        let skin = BoundSkin::of_bound(vec![bound.clone()], 2).unwrap();
        let mut posed = skin.at_rest();
        assert_eq!(skin.pose(pose, &mut posed), wished);
        assert_eq!(skin.pose_flexible(pose, &Default::default(), &mut posed).map(|_| ()), wished);
        assert_eq!(bound.violation(pose, chain.points(), false), f64::INFINITY);
        for way in NaiveWay::ALL {
            assert_eq!(way.pose(&chain, &weights, pose).len(), chain.points().len());
        }
    }
}

#[test]
fn what_is_measured_of_nonsense_is_infinite() {
    let (chain, weights, still) = (some_chain(1.0), two_handles(), [DAffine3::IDENTITY; 2]);
    let bound = bind(&chain, &weights);
    assert!(bound.violation(&still, chain.points(), false) < 1e-15);
    for place in [2, 3, 4] {
        let mut points = chain.points().to_vec();
        points[place].x = f64::NAN;
        assert_eq!(bound.violation(&still, &points, false), f64::INFINITY, "{place}");
        assert_eq!(bound.violation(&still, &points, true), f64::INFINITY, "{place}");
    }
    assert_eq!(bound.violation(&still, &chain.points()[..6], false), f64::INFINITY);
    assert_eq!(bound.energy(&weights, &Default::default(), &still, &chain.points()[..6]), f64::INFINITY);
}

#[test]
fn chains_of_a_skin_have_the_same_handles() {
    let (chain, weights) = (some_chain(1.0), two_handles());
    let three = Shepard::new(&[DVec2::ZERO, DVec2::X, DVec2::Y].map(HandleShape::planar)).unwrap();
    let chains = vec![bind(&chain, &weights), bind(&chain, &three)];
    let skin = BoundSkin::of_bound(chains, 2);
    assert_eq!(skin.unwrap_err(), SkinError::OtherHandles { chain: 1, found: 3, handles: 2 });
    let none = BoundSkin::bind(Vec::new(), &weights, &BindOptions::default()).unwrap();
    let mut posed = none.at_rest();
    none.pose(&[DAffine3::IDENTITY; 2], &mut posed).unwrap();
    assert_eq!((none.point_count(), none.place_of(3), none.points(&posed, 3).len()), (0, 0..0, 0));
}

#[test]
fn coordinates_of_any_size_are_posed_or_refused() {
    let mut refused = Vec::new();
    for power in (-320..=304).step_by(4) {
        let scale = 10_f64.powi(power);
        let chain = some_chain(scale);
        let shapes = [DVec2::ZERO, DVec2::X * scale, DVec2::Y * scale].map(HandleShape::planar);
        let weights = Shepard::new(&shapes).unwrap();
        let turn = in_space(&DAffine2::from_angle(0.5));
        let pose = [DAffine3::IDENTITY, turn, DAffine3::IDENTITY];
        let skin = BoundSkin::bind(vec![chain], &weights, &BindOptions::default());
        let Ok(skin) = skin else {
            refused.push(power);
            continue;
        };
        let mut posed = skin.at_rest();
        skin.pose(&pose, &mut posed).unwrap();
        assert!([posed.x(), posed.y()].into_iter().flatten().all(|x| x.is_finite()), "{power}");
        let mut out = Vec::new();
        let bound = &skin.chains()[0];
        let outcome = bound.solve_flexible(&pose, &Default::default(), &mut SolveWorkspace::default(), &mut out);
        assert!(outcome.is_ok() && out.iter().all(|p| p.is_finite()), "{power}: {outcome:?}");
        if (-70..=30).contains(&power) {
            // As it is at scale one.
            let unit = bind(
                &some_chain(1.0),
                &Shepard::new(&[DVec2::ZERO, DVec2::X, DVec2::Y].map(HandleShape::planar)).unwrap(),
            );
            let mut wished = Vec::new();
            unit.solve_flexible(&pose, &Default::default(), &mut SolveWorkspace::default(), &mut wished).unwrap();
            let back: Vec<DVec3> = out.iter().map(|p| *p / scale).collect();
            assert!(apart(&back, &wished) < 1e-9, "{power}: {:e}", apart(&back, &wished));
        }
    }
    assert!(refused.iter().all(|power| !(-280..=36).contains(power)), "{refused:?}");
    assert!(refused.contains(&40), "single precision ends at 3e38: {refused:?}");
}

#[test]
fn transforms_too_large_for_single_precision_are_refused() {
    let skin = BoundSkin::bind(vec![some_chain(1.0)], &two_handles(), &BindOptions::default()).unwrap();
    let mut posed = skin.at_rest();
    let huge = DAffine3::from_translation(DVec3::X * 1e39);
    let pose = [DAffine3::IDENTITY, huge];
    assert_eq!(skin.pose(&pose, &mut posed), Err(SkinError::PoseNotFinite { handle: 1 }));
    assert_eq!(posed.x(), skin.at_rest().x(), "nothing was moved");
}

#[test]
fn no_wish_makes_a_solve_go_on_for_ever() {
    let (chain, weights) = (some_chain(1.0), two_handles());
    let bound = bind(&chain, &weights);
    let pose = [DAffine3::IDENTITY, in_space(&DAffine2::from_angle(1.0))];
    for (moved, shortest) in [(0.0, 2e-3), (f64::NAN, f64::NAN), (-1.0, -1.0), (0.0, f64::INFINITY)] {
        let options = FlexibleOptions { pairs: u32::MAX, moved, gained: moved, shortest };
        let mut out = Vec::new();
        let outcome = bound.solve_flexible(&pose, &options, &mut SolveWorkspace::default(), &mut out).unwrap();
        assert!(outcome.pairs <= 1000 && outcome.flexible <= outcome.regular, "{outcome:?}");
        assert!(bound.violation(&pose, &out, true) < 1e-9);
    }
    let empty = Chain::planar(&VectorPath::default(), &JoinRules::default());
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = SplitOptions { tolerance, levels: u32::MAX };
        let split =
            |chain: &Chain| SplitChain::new(chain, &weights, &Default::default(), &[pose.to_vec()], &options).unwrap();
        assert_eq!(split(&empty).chain.segment_count(), 0);
        let wished = if tolerance <= 0.0 { 2 << 8 } else { 2 };
        assert_eq!(split(&chain).chain.segment_count(), wished, "{tolerance}");
    }
}

#[test]
fn handles_in_one_place_and_fields_of_nonsense_do_no_harm() {
    let chain = some_chain(1.0);
    let same = Shepard::new(&[HandleShape::planar(DVec2::new(4.0, 0.0)); 3]).unwrap();
    let bound = bind(&chain, &same);
    let pose = [1.0, 2.0, 3.0].map(|x| DAffine3::from_translation(DVec3::X * x));
    assert!(solve(&bound, &pose).iter().all(|p| p.is_finite()));
    /// Weights that are one number.
    struct Flat(f64);
    impl WeightField for Flat {
        fn handle_count(&self) -> usize {
            2
        }
        fn weights_at(&self, _: DVec3, out: &mut [f64]) {
            out[0] = self.0;
        }
    }
    for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
        let refused = BoundChain::new(&chain, 3, &Flat(bad), &BindOptions::default());
        assert_eq!(refused.unwrap_err(), SkinError::NoWeights { chain: 3, segment: 0 }, "{bad}");
    }
    // Brought to one where their sum is a number.
    let bound = BoundChain::new(&chain, 0, &Flat(1e300), &BindOptions::default()).unwrap();
    assert!(apart(&solve(&bound, &[DAffine3::IDENTITY; 2]), chain.points()) < 1e-13);
}
