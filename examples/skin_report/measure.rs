//! A drawing bound, posed and measured.

use std::path::Path;
use std::time::Instant;

use bevy_surface_splines::skin::{
    BindOptions, BoundSkin, Chain, FlexibleOptions, JoinKind, JoinRules, NaiveWay, Shepard, SolveWorkspace,
};
use bevy_surface_splines::vector::read_svg;
use glam::{DAffine3, DVec3};

use crate::rig::{Random, Rig};

/// Poses in which energies are measured and ratios freed.
const CLOSELY: usize = 10;
/// By how much joins may be missed, as a share of the drawing's extent.
const KEPT: f64 = 1e-9;
/// How far single precision may be from double, as a share of the drawing's extent.
const SINGLE: f64 = 2e-6;

/// What was measured of a drawing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measured {
    pub(crate) curves: usize,
    pub(crate) chains: usize,
    /// Joins by kind, in the order of [`JoinKind::ALL`].
    pub(crate) joins: [usize; 4],
    pub(crate) bind_ms: f64,
    /// Of the median pose.
    pub(crate) pose_us: f64,
    pub(crate) flexible_ms: f64,
    /// How far joins are missed at most, as a share of the extent.
    pub(crate) violation: f64,
    /// How far single precision is from double at most, as a share of the extent.
    pub(crate) single: f64,
    /// Mean energies in units of the extent cubed: loose segments, ours, with free ratios, and the naive ways.
    pub(crate) energies: [f64; 7],
    /// What did not hold.
    pub(crate) failures: Vec<String>,
}

/// Names of the energies.
pub(crate) const ENERGIES: [&str; 7] = ["loose", "ours", "flexible", "control points", "anchors", "jacobian", "refit"];

impl Measured {
    /// Binds a drawing to so many handles, and takes so many poses.
    pub(crate) fn of(file: &Path, handles: usize, poses: usize) -> Result<Self, String> {
        let drawing = read_svg(file).map_err(|error| error.to_string())?.drawing;
        let chains: Vec<Chain> = drawing.paths().map(|(_, path)| Chain::planar(path, &JoinRules::default())).collect();
        let rig = Rig::spread(&chains, handles).ok_or("there is nothing to bind")?;
        let weights = Shepard::new(&rig.shapes()).map_err(|error| error.to_string())?;
        let mut found = Self { chains: chains.len(), ..Self::default() };
        found.curves = chains.iter().map(Chain::segment_count).sum();
        for chain in &chains {
            let inner = chain.joins().iter().enumerate();
            let meets = |anchor: usize| chain.is_closed() || (anchor > 0 && anchor + 1 < chain.anchor_count());
            for (_, join) in inner.filter(|(anchor, _)| meets(*anchor)) {
                let kind = JoinKind::ALL.iter().position(|kind| *kind == join.kind);
                found.joins[kind.unwrap_or(0)] += 1;
            }
        }
        let start = Instant::now();
        let skin = BoundSkin::bind(chains, &weights, &BindOptions::default()).map_err(|error| error.to_string())?;
        found.bind_ms = start.elapsed().as_secs_f64() * 1e3;
        let mut random = Random(1);
        let all: Vec<Vec<DAffine3>> = (0..poses).map(|_| rig.pose(&mut random)).collect();
        found.take_poses(&skin, &all, rig.extent)?;
        for pose in all.iter().take(CLOSELY) {
            found.compare(&skin, &weights, pose, rig.extent)?;
        }
        let count = all.len().min(CLOSELY) as f64;
        found.flexible_ms /= count;
        found.energies.iter_mut().for_each(|energy| *energy /= count);
        found.judge();
        Ok(found)
    }

    /// Takes all poses in single and double precision.
    fn take_poses(&mut self, skin: &BoundSkin, all: &[Vec<DAffine3>], extent: f64) -> Result<(), String> {
        let mut posed = skin.at_rest();
        let (mut workspace, mut points) = (SolveWorkspace::default(), Vec::new());
        let mut times = Vec::new();
        for pose in all {
            let start = Instant::now();
            skin.pose(pose, &mut posed).map_err(|error| error.to_string())?;
            times.push(start.elapsed().as_secs_f64() * 1e6);
            for (number, bound) in skin.chains().iter().enumerate() {
                bound.solve(pose, &mut workspace, &mut points).map_err(|error| error.to_string())?;
                self.violation = worse(self.violation, bound.violation(pose, &points, false) / extent);
                for (single, double) in skin.points(&posed, number).zip(&points) {
                    self.single = worse(self.single, single.as_dvec3().distance(*double) / extent);
                }
            }
        }
        times.sort_by(f64::total_cmp);
        self.pose_us = times[times.len() / 2];
        Ok(())
    }

    /// Frees ratios, and takes energies of all ways.
    fn compare(&mut self, skin: &BoundSkin, weights: &Shepard, pose: &[DAffine3], extent: f64) -> Result<(), String> {
        let options = BindOptions::default();
        let mut posed = skin.at_rest();
        let start = Instant::now();
        skin.pose_flexible(pose, &FlexibleOptions::default(), &mut posed).map_err(|error| error.to_string())?;
        self.flexible_ms += start.elapsed().as_secs_f64() * 1e3;
        let (mut workspace, mut points) = (SolveWorkspace::default(), Vec::new());
        for bound in skin.chains() {
            let energy = |points: &[DVec3]| bound.energy(weights, &options, pose, points);
            let mut energies = [0.0; 7];
            let loose = bound.solve_loose(pose).map_err(|error| error.to_string())?;
            energies[0] = bound.energy_of_segments(weights, &options, pose, &loose);
            bound.solve(pose, &mut workspace, &mut points).map_err(|error| error.to_string())?;
            energies[1] = energy(&points);
            let outcome = bound.solve_flexible(pose, &FlexibleOptions::default(), &mut workspace, &mut points);
            outcome.map_err(|error| error.to_string())?;
            energies[2] = energy(&points);
            self.violation = worse(self.violation, bound.violation(pose, &points, true) / extent);
            for (way, energy_of_way) in NaiveWay::ALL.into_iter().zip(&mut energies[3..]) {
                *energy_of_way = energy(&way.pose(bound.chain(), weights, pose));
            }
            // What rounding does to squares of distances: those of points to some last digits of the extent, and those of
            // solutions to a thousand.
            let length = bound.lengths().iter().sum::<f64>();
            let (of_points, of_solutions) = (2e-15 * extent, 1e-13 * extent);
            let rounding = |b: f64| of_points * (b * length).sqrt() + of_solutions * of_solutions * length;
            let within = |a: f64, b: f64| a <= b * (1.0 + 1e-9) + rounding(b);
            if !within(energies[2], energies[1]) {
                self.failures.push(format!("flexible {} above regular {}", energies[2], energies[1]));
            }
            if !energies.iter().all(|other| within(energies[0], *other)) {
                self.failures.push(format!("loose segments are not the least: {energies:?}"));
            }
            self.energies.iter_mut().zip(energies).for_each(|(sum, energy)| *sum += energy / extent.powi(3));
        }
        Ok(())
    }

    fn judge(&mut self) {
        if self.violation > KEPT {
            self.failures.push(format!("joins are missed by {:.1e} of the drawing", self.violation));
        }
        if self.single > SINGLE {
            self.failures.push(format!("single precision is off by {:.1e} of the drawing", self.single));
        }
    }
}

/// The larger of two numbers; infinity if one is none.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}
