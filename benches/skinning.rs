//! How long do poses of splines that follow handles take? Drawings made with as many curves, handles and smooth joins as the examples of
//! the skinning paper (Liu, Jacobson and Gingold 2014, Table 1), with Shepard weights, on one thread.
//!
//! `precompute` binds: weights, integrals, factors, and what a pose needs of each handle; the paper's figure is without weights. `pose` is
//! the median of many, `flexible` frees the ratios of handle lengths. Allocations are counted over poses after the first.

mod common;

use std::{alloc::System, f64::consts::TAU};

use bevy_surface_splines::{
    skin::{BindOptions, BoundChain, BoundSkin, Chain, FlexibleOptions, HandleShape, JoinKind, JoinRules, Shepard},
    vector::{SpatialPath, VectorPath},
};
use common::{
    arguments::Arguments,
    clock,
    random::SplitMix64,
    stats::Times,
    table::{self, Table},
    threads,
};
use glam::{DAffine2, DVec2};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static MEMORY: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// A line of the paper's table: curves, handles, smooth joins and angles; seconds of precomputation, a regular pose and a flexible one.
struct Example {
    name: &'static str,
    curves: usize,
    handles: usize,
    joins: usize,
    /// None of what the paper does not have: chains in space, whose angles turn along with the pose.
    seconds: Option<[f64; 3]>,
}

const EXAMPLES: [Example; 12] = [
    Example { name: "Boxes", curves: 4, handles: 2, joins: 4, seconds: Some([0.03, 2e-4, 0.008]) },
    Example { name: "Spoon", curves: 7, handles: 2, joins: 7, seconds: Some([0.08, 2e-4, 0.02]) },
    Example { name: "Clam", curves: 56, handles: 3, joins: 50, seconds: Some([0.1, 8e-4, 0.1]) },
    Example { name: "Boy", curves: 226, handles: 5, joins: 118, seconds: Some([0.7, 5e-3, 0.4]) },
    Example { name: "Zapfino", curves: 379, handles: 3, joins: 316, seconds: Some([1.4, 4e-3, 0.65]) },
    Example { name: "Worm", curves: 395, handles: 2, joins: 261, seconds: Some([8.1, 3e-2, 2.75]) },
    Example { name: "Penguin on Lion", curves: 400, handles: 9, joins: 168, seconds: Some([2.5, 1e-2, 0.64]) },
    Example { name: "Man", curves: 516, handles: 4, joins: 240, seconds: Some([1.3, 1e-2, 0.78]) },
    Example { name: "Seven Turtles", curves: 1_324, handles: 5, joins: 914, seconds: Some([3.2, 3e-2, 2.5]) },
    Example { name: "Octopus", curves: 1_706, handles: 8, joins: 1_181, seconds: Some([11.0, 2e-2, 4.2]) },
    Example { name: "Coat of Arms", curves: 9_496, handles: 4, joins: 8_159, seconds: Some([42.0, 0.1, 16.1]) },
    Example { name: "in space, with angles", curves: 1_324, handles: 5, joins: 914, seconds: None },
];

/// Width and height of drawings.
const SIZE: f64 = 1000.0;
const SEED: u64 = 7;

fn main() {
    let arguments = Arguments::read();
    let (repeats, poses, flexible) = if arguments.quick { (1, 5, 1) } else { (9, 500, 15) };
    println!("Made drawings, seed {SEED}; ours on one thread, in medians.");
    let table = Table::new(&[
        "example",
        "curves",
        "handles",
        "smooth and angles",
        "precompute ms",
        "paper",
        "pose ms",
        "paper",
        "flexible ms",
        "paper",
        "allocations in poses",
        "flexible energy of regular",
    ]);
    // In one pool: the threads of one that ends would allocate while the next poses.
    threads::on(1, || EXAMPLES.iter().for_each(|example| row(&table, example, repeats, poses, flexible)));
}

fn row(table: &Table, example: &Example, repeats: usize, poses: usize, flexible: usize) {
    let mut random = SplitMix64::new(SEED);
    let chains = drawing(&mut random, example);
    let places: Vec<DVec2> = (0..example.handles).map(|_| place(&mut random)).collect();
    let shapes: Vec<HandleShape> = places.iter().map(|place| HandleShape::planar(*place)).collect();
    let weights = Shepard::new(&shapes).unwrap_or_else(|error| panic!("{error}"));
    let bind = || BoundSkin::bind(chains.clone(), &weights, &BindOptions::default());
    let binding = Times::new((0..repeats).map(|_| clock::wall_ms(bind).0).collect::<Vec<_>>());
    let skin = bind().unwrap_or_else(|error| panic!("{error}"));
    let moves: Vec<Vec<DAffine2>> =
        (0..poses).map(|_| places.iter().map(|p| moved(&mut random, *p)).collect()).collect();
    let mut posed = skin.at_rest();
    let mut pose = |transforms: &Vec<DAffine2>| {
        skin.pose_plane(transforms, &mut posed).unwrap_or_else(|error| panic!("{error}"));
    };
    moves.first().iter().for_each(|transforms| pose(transforms));
    let mut times = Vec::with_capacity(poses);
    let region = Region::new(MEMORY);
    moves.iter().for_each(|transforms| times.push(clock::wall_ms(|| pose(transforms)).0));
    let change = region.change();
    let (mut freeing, mut share) = (Vec::new(), 0.0);
    for transforms in moves.iter().take(flexible) {
        let wide: Vec<_> = transforms.iter().map(bevy_surface_splines::skin::in_space).collect();
        let options = FlexibleOptions::default();
        let (ms, report) = clock::wall_ms(|| skin.pose_flexible(&wide, &options, &mut posed));
        let report = report.unwrap_or_else(|error| panic!("{error}"));
        freeing.push(ms);
        share += report.flexible / report.regular;
    }
    let taken = freeing.len() as f64;
    let [precompute, regular, free] = [0, 1, 2].map(|k| table::number(example.seconds.map(|of| of[k] * 1e3)));
    table.row([
        example.name.to_owned(),
        example.curves.to_string(),
        example.handles.to_string(),
        kept(skin.chains().iter().map(BoundChain::chain)).to_string(),
        table::number(binding.median()),
        precompute,
        Times::new(times).median().map_or("–".into(), |ms| format!("{ms:.4}")),
        regular,
        table::number(Times::new(freeing).median()),
        free,
        (change.allocations + change.reallocations).to_string(),
        table::number(Some(share / taken)),
    ]);
}

/// Closed chains of up to ten curves, each about a place of its own, with as many smooth joins and angles as the example has.
fn drawing(random: &mut SplitMix64, example: &Example) -> Vec<Chain> {
    let mut chains = Vec::new();
    let (mut left, mut joins) = (example.curves, example.joins);
    while left > 0 {
        let count = left.min(10);
        left -= count;
        let (centre, radius) = (place(random), SIZE * (0.01 + 0.04 * random.unit()));
        let mut points = Vec::new();
        for i in 0..count {
            let direction = DVec2::from_angle(TAU * (i as f64 + 0.5 * random.unit()) / count as f64);
            let anchor = centre + direction * radius * (0.7 + 0.6 * random.unit());
            let handle = direction.perp() * radius / count as f64 * 2.0;
            let spread = joins as f64 > random.unit() * (left + count - i) as f64;
            joins -= usize::from(spread);
            let out = if spread { handle } else { handle.rotate(DVec2::from_angle(0.5 + random.unit())) };
            let (before, behind) = (anchor - handle * (0.5 + random.unit()), anchor + out * (0.5 + random.unit()));
            points.extend([before, anchor, behind]);
        }
        points.rotate_left(1);
        let path = VectorPath::from_points(points, true).unwrap_or_default();
        let mut chain = Chain::planar(&path, &JoinRules::default());
        if example.seconds.is_none() {
            chain = Chain::spatial(&SpatialPath::from(&path), &JoinRules::default());
            // Every other join becomes an angle.
            for anchor in (0..chain.anchor_count()).step_by(2).filter(|_| count > 1) {
                chain.set_join(anchor, JoinKind::Angle).unwrap_or_else(|error| panic!("{error}"));
            }
        }
        chains.push(chain);
    }
    let kept = kept(chains.iter());
    let is_like = kept.abs_diff(example.joins) <= example.joins / 20 + 2;
    assert!(is_like || example.seconds.is_none(), "{kept} {}", example.joins);
    chains
}

/// Joins of which more is kept than that they meet.
fn kept<'a>(chains: impl Iterator<Item = &'a Chain>) -> usize {
    chains.flat_map(|chain| chain.joins()).filter(|join| join.kind != JoinKind::Corner).count()
}

fn place(random: &mut SplitMix64) -> DVec2 {
    DVec2::new(random.unit(), random.unit()) * SIZE
}

/// A handle turned, stretched and moved.
fn moved(random: &mut SplitMix64, place: DVec2) -> DAffine2 {
    let mut between = |low: f64, high: f64| low + (high - low) * random.unit();
    let scale = DVec2::new(between(0.8, 1.25), between(0.8, 1.25));
    let turn = between(-1.0, 1.0);
    let shift = DVec2::new(between(-0.1, 0.1), between(-0.1, 0.1)) * SIZE;
    let about = DAffine2::from_scale_angle_translation(scale, turn, shift);
    DAffine2::from_translation(place) * about * DAffine2::from_translation(-place)
}
