//! Beside the naive ways, and beside whatever else keeps the joins.

use super::dense::{Dense, Metric, joined, segments};
use super::flexible::collapses;
use super::*;

#[test]
fn no_naive_way_is_nearer_and_no_other_way_to_keep_joins() {
    let options = BindOptions::default();
    let names: Vec<&str> =
        ["ours, loose", "ours", "flexible"].into_iter().chain(NaiveWay::ALL.map(NaiveWay::name)).collect();
    let mut sums = vec![0.0; names.len()];
    let mut below = [0; 4];
    let poses = 1000;
    println!("seeds 20000 to {}", 20000 + poses - 1);
    for seed in 0..poses {
        let mut random = Random(seed + 20000);
        let spatial = seed % 2 == 1;
        let (count, closed) = (1 + random.below(5), random.below(3) == 0);
        let chain = random_chain(&mut random, count, closed, spatial, &JoinKind::ALL);
        let weights = random_handles(&mut random, 4, spatial);
        let pose = random_pose(&mut random, 4, spatial);
        let bound = bind(&chain, &weights);
        let energy = |points: &[DVec3]| bound.energy(&weights, &options, &pose, points);
        let loose = bound.energy_of_segments(&weights, &options, &pose, &bound.solve_loose(&pose).unwrap());
        let points = solve(&bound, &pose);
        let ours = energy(&points);
        let mut flexible = Vec::new();
        bound.solve_flexible(&pose, &Default::default(), &mut Default::default(), &mut flexible).unwrap();
        let mut energies = vec![loose, ours, energy(&flexible)];
        let dense = Dense::new(&bound, &weights, &pose, Metric::Points);
        let within = 1.0 + 1e-9;
        for (k, way) in NaiveWay::ALL.into_iter().enumerate() {
            let naive = way.pose(&chain, &weights, &pose);
            let raw = energy(&naive);
            assert!(loose <= raw * within, "seed {seed} {way:?}: {loose} {raw}");
            // With the least change to keep the joins.
            let kept = dense.nearest(&bound, Metric::Points, &segments(&chain, &naive), false);
            assert!(dense.missed(&kept) < 1e-9 * chain.extent(), "seed {seed} {way:?}");
            let feasible = energy(&joined(&chain, &kept));
            assert!(ours <= feasible * within, "seed {seed} {way:?}: {ours} {feasible}");
            below[k] += u32::from(raw < ours);
            energies.push(raw);
        }
        for i in 0..100 {
            let size = chain.extent() * 10_f64.powf(random.between(-6.0, 0.0));
            let change: Vec<[DVec3; 4]> =
                segments(&chain, &points).iter().map(|s| s.map(|_| random.vector(spatial) * size)).collect();
            let change = dense.nearest(&bound, Metric::Points, &change, true);
            let other: Vec<DVec3> = joined(&chain, &change).iter().zip(&points).map(|(c, p)| *p + *c).collect();
            let other = energy(&other);
            assert!(ours <= other * within, "seed {seed}, perturbation {i}: {ours} {other}");
        }
        if seed % 20 == 0 {
            let system = Dense::new(&bound, &weights, &pose, Metric::Energy);
            let exact = system.nearest(&bound, Metric::Energy, &bound.solve_loose(&pose).unwrap(), false);
            let exact = energy(&joined(&chain, &exact));
            assert!(ours <= 1.01 * exact && exact <= ours * within, "seed {seed}: {ours} {exact}");
        }
        for (points, what) in [(&points, "regular"), (&flexible, "flexible")] {
            for anchor in 0..chain.anchor_count() {
                assert!(!collapses(&bound, &pose, points, anchor), "seed {seed} {what} anchor {anchor}");
            }
        }
        sums.iter_mut().zip(energies).for_each(|(sum, energy)| *sum += energy);
    }
    for (name, sum) in names.iter().zip(&sums) {
        println!("{name}: mean energy {:.5e}", sum / poses as f64);
    }
    for (way, below) in NaiveWay::ALL.iter().zip(below) {
        println!("{}: less energy than ours, by breaking joins, in {below} of {poses}", way.name());
    }
}
