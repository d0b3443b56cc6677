//! Poses in single precision, and splitting.

use super::*;

fn mixed_chains(random: &mut Random, count: usize) -> Vec<Chain> {
    (0..count)
        .map(|i| {
            let kinds = if i % 2 == 0 { &JoinKind::ALL[..3] } else { &JoinKind::ALL[..] };
            let (segments, closed) = (1 + random.below(30), random.below(2) == 0);
            let mut chain = random_chain(random, segments, closed, i % 3 == 2, kinds);
            if i % 5 == 0 {
                chain.pin(0, Some(chain.points()[0] + DVec3::X * 0.1)).unwrap();
            }
            chain
        })
        .collect()
}

#[test]
fn single_precision_is_near_to_double() {
    let mut random = Random(77);
    let chains = mixed_chains(&mut random, 40);
    let weights = random_handles(&mut random, 6, true);
    let skin = BoundSkin::bind(chains, &weights, &BindOptions::default()).unwrap();
    let mut posed = skin.at_rest();
    let mut worst: f64 = 0.0;
    for _ in 0..20 {
        let pose = random_pose(&mut random, 6, true);
        skin.pose(&pose, &mut posed).unwrap();
        for (number, bound) in skin.chains().iter().enumerate() {
            let exact = solve(bound, &pose);
            let size = bound.chain().extent();
            assert_eq!(skin.points(&posed, number).len(), exact.len());
            for (single, exact) in skin.points(&posed, number).zip(&exact) {
                worst = worse(worst, single.as_dvec3().distance(*exact) / size);
            }
        }
    }
    println!("largest error of poses: {worst:e} of a chain's extent");
    assert!(worst < 2e-6, "{worst:e}");
}

#[test]
fn rest_is_exact_and_poses_do_not_depend_on_what_was_before() {
    let mut random = Random(78);
    let chains = mixed_chains(&mut random, 20);
    let weights = random_handles(&mut random, 3, true);
    let skin = BoundSkin::bind(chains.clone(), &weights, &BindOptions::default()).unwrap();
    let mut posed = Posed::default();
    skin.pose(&[DAffine3::IDENTITY; 3], &mut posed).unwrap();
    for (number, chain) in
        chains.iter().enumerate().filter(|(_, chain)| chain.joins().iter().all(|j| j.pinned.is_none()))
    {
        let is_solved = chain.is_spatial() && chain.joins().iter().any(|join| join.kind == JoinKind::Angle);
        for (a, b) in skin.points(&posed, number).zip(chain.points()) {
            let off = a.as_dvec3().distance(*b);
            assert!(if is_solved { off < 1e-6 } else { a == b.as_vec3() }, "{a} {b}");
        }
    }
    let pose = random_pose(&mut random, 3, true);
    skin.pose(&random_pose(&mut random, 3, true), &mut posed).unwrap();
    skin.pose(&pose, &mut posed).unwrap();
    let mut fresh = skin.at_rest();
    skin.pose(&pose, &mut fresh).unwrap();
    assert_eq!((posed.x(), posed.y(), posed.z()), (fresh.x(), fresh.y(), fresh.z()));
    assert_eq!(skin.pose(&pose[..2], &mut posed), Err(SkinError::PoseLength { handles: 3, found: 2 }));
    let mut broken = pose.clone();
    broken[1].translation.x = f64::NAN;
    assert_eq!(skin.pose(&broken, &mut posed), Err(SkinError::PoseNotFinite { handle: 1 }));
}

#[test]
#[cfg(feature = "parallel")]
fn threads_do_not_change_a_bit() {
    let make = || {
        let mut random = Random(79);
        let chains = mixed_chains(&mut random, 200);
        let weights = random_handles(&mut random, 5, true);
        let skin = BoundSkin::bind(chains, &weights, &BindOptions::default()).unwrap();
        let pose = random_pose(&mut random, 5, true);
        let (mut regular, mut flexible) = (skin.at_rest(), skin.at_rest());
        skin.pose(&pose, &mut regular).unwrap();
        let report = skin.pose_flexible(&pose, &FlexibleOptions::default(), &mut flexible).unwrap();
        assert!(report.flexible < report.regular && report.chains > 50, "{report:?}");
        [regular, flexible].map(|posed| [posed.x().to_vec(), posed.y().to_vec(), posed.z().to_vec()])
    };
    let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(make);
    assert_eq!(on(1), on(4));
}

#[test]
fn far_from_the_origin_poses_keep_their_digits() {
    let mut random = Random(80);
    let near = random_chain(&mut random, 12, true, false, &JoinKind::ALL);
    let far = DVec2::new(3e5, -2e5);
    let points = near.points().iter().map(|p| p.truncate() + far).collect();
    let mut chain = Chain::planar(&VectorPath::from_points(points, true).unwrap(), &JoinRules::default());
    for (anchor, join) in near.joins().iter().enumerate() {
        chain.set_join(anchor, join.kind).unwrap();
    }
    let weights = Shepard::new(&[DVec2::ZERO, DVec2::X].map(|h| HandleShape::planar(h + far))).unwrap();
    let skin = BoundSkin::bind(vec![chain], &weights, &BindOptions::default()).unwrap();
    let mut posed = skin.at_rest();
    let about = DAffine2::from_translation(far) * DAffine2::from_angle(0.5) * DAffine2::from_translation(-far);
    skin.pose_plane(&[DAffine2::IDENTITY, about], &mut posed).unwrap();
    let exact = solve(&skin.chains()[0], &[DAffine3::IDENTITY, in_space(&about)]);
    for (p, exact) in skin.points(&posed, 0).zip(exact) {
        // No more than rounding of the place itself.
        assert!(p.as_dvec3().distance(exact) < 0.08, "{p} {exact}");
    }
}

#[test]
fn splitting_reaches_the_tolerance_and_keeps_the_curve() {
    for spatial in [false, true] {
        let mut random = Random(81);
        let chain = random_chain(&mut random, 5, spatial, spatial, &JoinKind::ALL);
        let weights = random_handles(&mut random, 4, spatial);
        let poses: Vec<_> = (0..5).map(|_| random_pose(&mut random, 4, spatial)).collect();
        let with = |levels, tolerance| {
            let options = SplitOptions { tolerance, levels };
            SplitChain::new(&chain, &weights, &BindOptions::default(), &poses, &options).unwrap()
        };
        let unsplit = with(0, 0.0);
        assert_eq!(unsplit.chain, chain);
        let mut last = unsplit.left;
        for levels in 1..=4 {
            let split = with(levels, 0.0);
            assert_eq!(split.chain.segment_count(), 5 << levels);
            println!("{levels} levels: {:.3e}", split.left);
            assert!(split.left < last, "{levels}: {} {last}", split.left);
            last = split.left;
            for (segment, (of, [from, to])) in split.parts.iter().enumerate() {
                let (part, whole) = (split.chain.segment(segment), chain.segment(*of));
                for i in 0..=4 {
                    let t = f64::from(i) / 4.0;
                    let at = |control, t| crate::skin::bound::point(control, &crate::skin::quadrature::bernstein(t));
                    assert!(at(&part, t).distance(at(&whole, from + (to - from) * t)) < 1e-13);
                }
            }
            let bound = bind(&split.chain, &weights);
            assert!(apart(&solve(&bound, &[DAffine3::IDENTITY; 4]), split.chain.points()) < 1e-12);
        }
        let tolerance = 2.0 * last;
        let split = with(8, tolerance);
        assert!(split.left <= tolerance && split.chain.segment_count() <= 5 << 5, "{}", split.chain.segment_count());
    }
}
