//! Free ratios of handle lengths.

use super::*;

fn flex(bound: &BoundChain, pose: &[DAffine3], options: &FlexibleOptions) -> (FlexibleOutcome, Vec<DVec3>) {
    let mut out = Vec::new();
    let outcome = bound.solve_flexible(pose, options, &mut SolveWorkspace::default(), &mut out).unwrap();
    (outcome, out)
}

#[test]
fn free_ratios_are_never_worse_and_keep_joins() {
    let (mut most, mut sum, mut shares, mut settled) = (0, 0, 0.0, 0);
    let runs = 400;
    for seed in 0..runs {
        let mut random = Random(seed + 5000);
        let spatial = seed % 2 == 1;
        let (count, closed) = (2 + random.below(8), random.below(3) == 0);
        let mut chain = random_chain(&mut random, count, closed, spatial, &JoinKind::ALL);
        if seed % 7 == 0 {
            chain.pin(1, Some(chain.points()[3])).unwrap();
        }
        let weights = random_handles(&mut random, 4, spatial);
        let pose = random_pose(&mut random, 4, spatial);
        let bound = bind(&chain, &weights);
        let (outcome, points) = flex(&bound, &pose, &FlexibleOptions::default());
        let regular = bound.energy(&weights, &BindOptions::default(), &pose, &solve(&bound, &pose));
        let flexible = bound.energy(&weights, &BindOptions::default(), &pose, &points);
        assert!(flexible <= regular * (1.0 + 1e-12), "seed {seed}: {flexible} {regular}");
        assert!(((regular - flexible) - (outcome.regular - outcome.flexible)).abs() < 1e-9 * regular, "seed {seed}");
        let missed = bound.violation(&pose, &points, true);
        assert!(missed < 1e-9 * chain.extent(), "seed {seed}: {missed:e}");
        for anchor in 0..chain.anchor_count() {
            assert!(!collapses(&bound, &pose, &points, anchor), "seed {seed} anchor {anchor}");
        }
        most = most.max(outcome.pairs);
        sum += outcome.pairs;
        settled += u32::from(outcome.settled);
        shares += if outcome.regular > 0.0 { outcome.flexible / outcome.regular } else { 1.0 };
    }
    let mean = f64::from(sum) / runs as f64;
    println!(
        "pairs {mean:.1} in the mean, {most} at most, {settled} of {runs} settled, energy {:.3} of the regular one",
        shares / runs as f64
    );
}

/// Whether a handle is shorter than a thousandth of what it was at rest, and that of the loose segment is not.
pub(super) fn collapses(bound: &BoundChain, pose: &[DAffine3], points: &[DVec3], anchor: usize) -> bool {
    let chain = bound.chain();
    let Some(rest) = chain.handles(anchor) else { return false };
    let loose = bound.solve_loose(pose).unwrap();
    let (n, at) = (points.len(), 3 * anchor);
    let before = if anchor > 0 { anchor - 1 } else { loose.len() - 1 };
    let wished = [loose[before][2] - loose[before][3], loose[anchor][1] - loose[anchor][0]];
    let now = [points[if at > 0 { at - 1 } else { n - 1 }] - points[at], points[at + 1] - points[at]];
    (0..2).any(|side| {
        let least = 1e-3 * rest[side].length();
        now[side].length() < least && wished[side].length() >= least
    })
}

#[test]
fn stopping_early_gives_the_best_so_far() {
    for seed in 0..60 {
        let mut random = Random(seed + 9000);
        let spatial = seed % 2 == 1;
        let chain = random_chain(&mut random, 6, false, spatial, &[JoinKind::Smooth, JoinKind::Angle]);
        let weights = random_handles(&mut random, 4, spatial);
        let pose = random_pose(&mut random, 4, spatial);
        let bound = bind(&chain, &weights);
        let mut last = f64::INFINITY;
        for pairs in 0..12 {
            let options = FlexibleOptions { pairs, moved: 0.0, gained: 0.0, ..Default::default() };
            let (outcome, points) = flex(&bound, &pose, &options);
            let energy = bound.energy(&weights, &BindOptions::default(), &pose, &points);
            assert!(energy <= last * (1.0 + 1e-12), "seed {seed} {pairs} pairs: {energy} {last}");
            assert_eq!(pairs == 0, outcome.flexible == outcome.regular && outcome.pairs == 0, "seed {seed}");
            last = energy;
        }
    }
}

#[test]
fn a_ratio_that_only_the_pose_changes_is_found() {
    // Two segments of a straight line, the second of which grows: with free ratios a smooth join follows exactly.
    let points = (0..7).map(|i| DVec3::X * f64::from(i)).collect();
    let chain = Chain::spatial(&SpatialPath::from_points(points, false).unwrap(), &JoinRules::default());
    struct Halves;
    impl WeightField for Halves {
        fn handle_count(&self) -> usize {
            2
        }
        fn weights_at(&self, place: DVec3, out: &mut [f64]) {
            out.copy_from_slice(&[f64::from(place.x <= 3.0), f64::from(place.x > 3.0)]);
        }
    }
    let grown = DAffine3::from_translation(DVec3::X * 3.0)
        * DAffine3::from_scale(DVec3::splat(2.0))
        * DAffine3::from_translation(-DVec3::X * 3.0);
    let pose = [DAffine3::IDENTITY, grown];
    let bound = BoundChain::new(&chain, 0, &Halves, &BindOptions::default()).unwrap();
    let (outcome, points) = flex(&bound, &pose, &FlexibleOptions::default());
    assert!(outcome.regular > 1e-3 && outcome.flexible < 1e-12, "{outcome:?}");
    assert!(points[2].distance(DVec3::X * 2.0) < 1e-6 && points[4].distance(DVec3::X * 5.0) < 1e-6);
}
