//! Smoothing by solving: the best crossings for the strip, then past the vertices that press, until none does.

use std::ops::Range;

use super::{
    envelope,
    fan::Fan,
    flip::{Flipper, Rule, touching},
    layout::Layout,
    metric::Metric,
    nodes::{self, Node},
    plain::Sweeper,
    profile::Profile,
    solve::{STAGES, Solver, Task, Tether, UNKNOWN},
    strip::Strip,
    tree::LineTree,
};
use crate::surface::{InnerPoint, Surface};

/// Crossings this near to a vertex, in mean edges, may pass it.
pub(crate) const NEAR: f64 = 1e-2;
/// How corners are rounded off while vertices are passed, in mean edges: less when nothing more is to pass.
const LEVELS: [&[f64]; 3] = [&[1e-2], &[1e-2, 1e-3], &[1e-4]];
/// What is as stiff as that is fixed.
const SMOOTH: f64 = 1e3;
/// Turns on either side of a place by which it is judged to be rough or smooth.
const BESIDE: isize = 8;
/// Turns below this are none.
const TURN: f64 = 0.02;
/// Rounds in which a line may get no shorter.
const IDLE: u32 = 24;
/// By how much a line may grow when it passes vertices.
const GROWTH: f64 = 1e-3;
/// Crossings on either side of new ones that are solved for with them.
const MARGIN: usize = 12;
/// Steps of one solve.
const MOST_STEPS: usize = 60;
/// Turns that may remain while most vertices are passed.
const COARSELY: f64 = 1e-2;
/// Turns that may remain before vertices are passed, and at the end.
const ROUGHLY: f64 = 1e-3;
const EXACTLY: f64 = 1e-7;
/// Crossings begin this far inside their sides, so that none is stuck at a vertex.
const INSIDE: f64 = 1e-3;
/// How stiff a tether gets at most where the line is smooth already.
const STIFFEST: f64 = 1e4;

/// What is asked of the engine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    /// Whether crossings have wished turns: those of the profile.
    pub(crate) profile: bool,
    /// Whether it is not to grow by that.
    pub(crate) shrinks: bool,
    /// Closeness of the tether, if there is one.
    pub(crate) tether: Option<f64>,
    /// Length scale of the tether.
    pub(crate) reach: f64,
    /// No crossing leaves what is within this of the drawn line.
    pub(crate) envelope: Option<f64>,
    /// Reach of the barrier at the boundary.
    pub(crate) barrier: Option<f64>,
    /// Mean length of a side.
    pub(crate) mean: f64,
    pub(crate) max_rounds: u32,
}

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Done {
    pub(crate) rounds: u32,
    pub(crate) steps: u32,
    pub(crate) flips: u32,
    /// Whether vertices were left to pass when the bound was met.
    pub(crate) met_bound: bool,
    /// Whether a closed line shrank to a point.
    pub(crate) collapsed: bool,
}

impl Done {
    pub(crate) fn add(&mut self, other: Self) {
        self.rounds += other.rounds;
        self.steps += other.steps;
        self.flips += other.flips;
        self.met_bound |= other.met_bound;
        self.collapsed |= other.collapsed;
    }
}

/// Scratch memory of smoothing, and what is known of the drawn line.
#[derive(Debug, Default)]
pub(crate) struct Engine {
    pub(crate) metric: Metric,
    pub(crate) layout: Layout,
    pub(crate) solver: Solver,
    pub(crate) flipper: Flipper,
    pub(crate) fan: Fan,
    pub(crate) nodes: Vec<Node>,
    pub(crate) profile: Profile,
    pub(crate) sweeper: Sweeper,
    /// The drawn line.
    pub(crate) line: LineTree,
    /// What the tether's stiffness is multiplied by, for each stretch of the drawn line.
    pub(crate) factors: Vec<f64>,
    pub(crate) wished: Vec<f64>,
    pub(crate) bounds: Vec<[f64; 2]>,
    stiffness: Vec<f64>,
    nearest: Vec<u32>,
    ends: Vec<[bool; 2]>,
    pieces: Vec<[f64; 2]>,
    turns: Vec<(usize, f64)>,
    kept: Strip,
    /// Which crossings are solved for.
    windows: Vec<Range<usize>>,
    /// Whether somebody looks at every step.
    pub(crate) watched: bool,
}

impl Engine {
    /// Fills in how much a line turns, its density spread to neighbours.
    pub(crate) fn measure_profile(&mut self, surface: &Surface, strip: &Strip, passes: u32, scale: f64) {
        self.layout.build(surface, &mut self.metric, strip);
        nodes::find(surface, &mut self.metric, strip, &self.layout, &mut self.fan, &mut self.nodes);
        self.profile.measure(strip, &self.layout, &self.nodes, passes, scale);
    }

    /// Fills in by how much stiffer the tether is where the drawn line is smooth.
    ///
    /// A line is rough where it turns to and fro: where of its nearest turns more than two pairs of neighbours point to different sides, by
    /// more than `roughness` in all. Where it is smoother the tether is stiffer by the eighth power of the ratio. Turns are
    /// counted, not lengths: so neither the mesh nor the speed of a hand decides.
    pub(crate) fn measure_roughness(&mut self, surface: &Surface, strip: &Strip, roughness: f64) {
        let stretches = self.line.points().len().saturating_sub(1);
        self.factors.clear();
        self.factors.resize(stretches, 1.0);
        if roughness <= 0.0 {
            return;
        }
        self.layout.build(surface, &mut self.metric, strip);
        nodes::find(surface, &mut self.metric, strip, &self.layout, &mut self.fan, &mut self.nodes);
        let Self { nodes, turns, factors, .. } = self;
        turns.clear();
        turns.extend(nodes.iter().filter(|node| node.bend.abs() > TURN).map(|node| (node.first, node.bend)));
        let count = turns.len();
        if count == 0 {
            factors.fill(STIFFEST);
            return;
        }
        // The stretch that begins at a crossing.
        let stretch = |crossing: usize| if strip.closed { crossing } else { crossing + 1 };
        let turn = |j: isize| match usize::try_from(j) {
            _ if strip.closed => turns[j.rem_euclid(count as isize) as usize].1,
            Ok(j) if j < count => turns[j].1,
            _ => 0.0,
        };
        let mut next = 0;
        for (k, factor) in factors.iter_mut().enumerate() {
            while next < count && stretch(turns[next].0) <= k {
                next += 1;
            }
            let (mut sum, mut largest) = (0.0, [0.0_f64; 2]);
            for j in next as isize - BESIDE..next as isize + BESIDE - 1 {
                let [a, b] = [turn(j), turn(j + 1)];
                let fro = if a * b < 0.0 { a.abs().min(b.abs()) } else { 0.0 };
                sum += fro;
                largest = if fro > largest[0] { [fro, largest[0]] } else { [largest[0], largest[1].max(fro)] };
            }
            // Smooth lines turn to the other side once in a while.
            let rough = sum - largest[0] - largest[1];
            if rough < roughness {
                *factor = (roughness / rough.max(1e-9)).powi(8).min(STIFFEST);
            }
        }
    }

    /// Tethers all of the drawn line alike.
    pub(crate) fn hold_alike(&mut self) {
        self.factors.clear();
        self.factors.resize(self.line.points().len().saturating_sub(1), 1.0);
    }

    /// Fixes the crossings of the drawn line where it is as smooth as can be.
    pub(crate) fn fix_smooth(&self, strip: &mut Strip) {
        for i in 0..strip.len() {
            let stretches = if strip.closed { [i, (i + strip.len() - 1) % strip.len()] } else { [i, i + 1] };
            let smooth = |k: &usize| self.factors.get(*k).is_some_and(|factor| *factor >= SMOOTH);
            strip.fixed[i] |= stretches.iter().all(smooth);
        }
    }

    /// Smooths a strip, of which the drawn line, the profile and the metric are known.
    pub(crate) fn relax(
        &mut self,
        surface: &Surface,
        strip: &mut Strip,
        plan: &Plan,
        watch: &mut dyn FnMut(&Strip),
    ) -> Done {
        let mut done = Done::default();
        self.flipper.counts.clear();
        self.stiffness.clear();
        if let Some(closeness) = plan.tether {
            let per = closeness / (plan.reach * plan.reach);
            self.stiffness.extend(self.factors.iter().map(|factor| factor * per));
        }
        let near = NEAR * plan.mean;
        let (mut seams, mut level, mut kept) = (0, 0, f64::INFINITY);
        let mut raised = true;
        let (mut shortest, mut since) = (f64::INFINITY, 0);
        loop {
            if strip.closed {
                self.layout.build(surface, &mut self.metric, strip);
                let layout = &self.layout;
                let lengths =
                    |s: &Strip, i: usize| near / layout.lengths[i].max(f64::MIN_POSITIVE) >= s.at[i].min(1.0 - s.at[i]);
                let _ = strip.seam_off_vertices(lengths);
            }
            if strip.closed && (strip.len() < 3 || self.is_point(surface, strip, plan)) {
                done.collapsed = true;
                return done;
            }
            let first = done.rounds == 0;
            self.choose_windows(strip, raised || seams > 0);
            let stages: &[f64] = if first { &STAGES[..2] } else { LEVELS[level] };
            raised = false;
            self.solve(
                surface,
                strip,
                plan,
                [stages, &[]],
                if first { INSIDE } else { 0.0 },
                if level == 0 { COARSELY } else { ROUGHLY },
                &mut done,
                watch,
            );
            if plan.profile {
                // A line that is to turn much may wind itself up beyond a vertex: what was before is better then.
                let length = strip.length(surface);
                if first || length <= kept * (1.0 + GROWTH) {
                    kept = length;
                    self.kept.copy_from(strip);
                } else if plan.shrinks {
                    strip.copy_from(&self.kept);
                    break;
                }
            }
            if done.rounds >= plan.max_rounds {
                done.met_bound = true;
                break;
            }
            // Where vertices are passed to and fro, nothing is gained any more.
            let length = strip.length(surface);
            if length < shortest * (1.0 - 1e-7) {
                (shortest, since) = (length, done.rounds);
            } else if done.rounds > since + IDLE {
                break;
            }
            done.rounds += 1;
            let flipped = self.pass(surface, strip, plan, near);
            done.flips += flipped.count as u32;
            if flipped.count > 0 {
                watch(strip);
                (seams, level) = (0, level.min(1));
            } else if flipped.at_seam && seams < 2 {
                seams += 1;
            } else if level + 1 == LEVELS.len() {
                break;
            } else {
                // What presses little shows only when corners are hardly rounded.
                (level, raised) = (level + 1, true);
            }
        }
        self.finish(surface, strip, plan, near, &mut done, watch);
        done
    }

    /// What is to be solved for: all, or what is about the crossings that are new.
    fn choose_windows(&mut self, strip: &Strip, all: bool) {
        let n = strip.len();
        let Self { windows, flipper, .. } = self;
        windows.clear();
        if all || n < 4 * MARGIN {
            windows.push(0..n);
            return;
        }
        for changed in &flipper.changed {
            let (start, end) = (changed.start.saturating_sub(MARGIN), (changed.end + MARGIN).min(n));
            if strip.closed && (start == 0 || end == n) {
                windows.clear();
                windows.push(0..n);
                return;
            }
            match windows.last_mut() {
                Some(last) if start <= last.end => last.end = last.end.max(end),
                _ if start < end => windows.push(start..end),
                _ => {}
            }
        }
        if 2 * windows.iter().map(ExactSizeIterator::len).sum::<usize>() > n {
            windows.clear();
            windows.push(0..n);
        }
    }

    /// Passes the vertices that press.
    fn pass(&mut self, surface: &Surface, strip: &mut Strip, plan: &Plan, near: f64) -> super::flip::Flipped {
        let Self { metric, layout, solver, flipper, line, wished, windows, .. } = self;
        let wish = |k: usize| wish(plan, wished, solver, layout, k);
        let mut allowed = |vertex: u32| match plan.envelope {
            Some(reach) => {
                line.nearest(surface.positions[vertex as usize], None).is_some_and(|near| near.distance <= reach)
            }
            None => true,
        };
        let mut rule = Rule { near, wished: &wish, allowed: &mut allowed, straight: false, windows };
        flipper.flip(surface, metric, strip, layout, &mut rule)
    }

    /// One solve on the strip as it is.
    #[expect(clippy::too_many_arguments, reason = "the stages of one driver, called from three places in it")]
    fn solve(
        &mut self,
        surface: &Surface,
        strip: &mut Strip,
        plan: &Plan,
        stages: [&[f64]; 2],
        inside: f64,
        tolerance: f64,
        done: &mut Done,
        watch: &mut dyn FnMut(&Strip),
    ) {
        self.layout.build(surface, &mut self.metric, strip);
        self.fill_bounds(surface, strip, plan);
        if inside > 0.0 {
            for (at, [low, high]) in strip.at.iter_mut().zip(&self.bounds) {
                let room = inside.min(0.5 * (high - low));
                *at = at.clamp(low + room, high - room);
            }
        }
        if plan.profile {
            self.profile.wished(strip, &mut self.wished);
        }
        self.run_solver(strip, plan, stages, tolerance, done, watch);
    }

    fn run_solver(
        &mut self,
        strip: &mut Strip,
        plan: &Plan,
        [stages, more]: [&[f64]; 2],
        tolerance: f64,
        done: &mut Done,
        watch: &mut dyn FnMut(&Strip),
    ) {
        let Self { layout, solver, line, wished, bounds, stiffness, nearest, ends, windows, watched, .. } = self;
        if plan.tether.is_some() {
            nearest.clear();
            nearest.resize(strip.len(), UNKNOWN);
        }
        for stages in [stages, more] {
            if stages.is_empty() {
                continue;
            }
            let mut task = Task {
                layout,
                turns: if plan.profile { wished } else { &[] },
                tether: plan.tether.map(|_| Tether { line, stiffness, nearest, steady: false }),
                bounds,
                barrier: plan.barrier.map(|reach| (reach, ends.as_slice())),
                mean: plan.mean,
                stages,
                tolerance,
                most_steps: MOST_STEPS,
            };
            let mut at = std::mem::take(&mut strip.at);
            if *watched {
                let (steps, _) = solver.run(
                    &mut task,
                    0..at.len(),
                    &mut at,
                    Some(&mut |at| {
                        strip.at.clear();
                        strip.at.extend_from_slice(at);
                        watch(strip);
                    }),
                );
                done.steps += steps as u32;
            } else {
                for window in windows.iter_mut() {
                    done.steps += solve_window(solver, &mut task, window, &mut at, strip.closed);
                }
            }
            strip.at = at;
        }
    }

    /// What each crossing may be.
    pub(crate) fn fill_bounds(&mut self, surface: &Surface, strip: &Strip, plan: &Plan) {
        self.bounds.clear();
        self.ends.clear();
        for i in 0..strip.len() {
            let at = strip.at[i];
            let mut bound = if strip.fixed[i] { [at, at] } else { [0.0, 1.0] };
            if let (Some(reach), false) = (plan.envelope, strip.fixed[i]) {
                let (a, way) = (self.layout.rights[i], self.layout.extents[i]);
                bound = envelope::interval(&self.line, a, way, at, reach, &mut self.pieces).unwrap_or([at, at]);
            }
            if plan.barrier.is_some() {
                let h = strip.sides[i];
                self.ends.push([surface.origin(h), surface.target(h)].map(|v| surface.boundary[v as usize]));
            }
            self.bounds.push(bound);
        }
    }

    /// Puts crossings that are pressed against vertices exactly there, and solves for the others once more.
    fn finish(
        &mut self,
        surface: &Surface,
        strip: &mut Strip,
        plan: &Plan,
        near: f64,
        done: &mut Done,
        watch: &mut dyn FnMut(&Strip),
    ) {
        if strip.closed && strip.len() < 3 {
            done.collapsed = true;
            return;
        }
        self.layout.build(surface, &mut self.metric, strip);
        self.fill_bounds(surface, strip, plan);
        if plan.profile {
            self.profile.wished(strip, &mut self.wished);
        }
        let Self { metric, layout, solver, flipper, bounds, wished, .. } = self;
        let wish = |k: usize| wish(plan, wished, solver, layout, k);
        let mut i = 0;
        while i < strip.len() {
            let Some(run) = touching(surface, strip, layout, i, near) else {
                i += 1;
                continue;
            };
            i = run.last + 1;
            let range = run.first..=run.last;
            let end = if run.left { 1.0 } else { 0.0 };
            let fits = |k: usize| !strip.fixed[k] && (bounds[k][0]..=bounds[k][1]).contains(&end);
            if range.clone().all(fits) && flipper.presses(surface, metric, strip, layout, &wish, &run).is_some() {
                for k in range {
                    (strip.at[k], bounds[k]) = (end, [end, end]);
                }
            }
        }
        self.choose_windows(strip, true);
        self.run_solver(strip, plan, [&STAGES[2..], &[1e-6]], EXACTLY, done, watch);
        watch(strip);
    }

    /// Whether a closed line has shrunk to a point.
    fn is_point(&self, surface: &Surface, strip: &Strip, plan: &Plan) -> bool {
        let Some(first) = (!strip.sides.is_empty()).then(|| strip.crossing(surface, 0)) else { return true };
        (0..strip.len()).all(|i| strip.crossing(surface, i).distance(first) < 2.0 * NEAR * plan.mean)
    }
}

/// Solves for the crossings of a window, and for more of them as long as those beside it would move.
fn solve_window(
    solver: &mut Solver,
    task: &mut Task<'_>,
    window: &mut Range<usize>,
    at: &mut [f64],
    closed: bool,
) -> u32 {
    let n = at.len();
    let Range { mut start, mut end } = window.clone();
    let mut steps = 0;
    loop {
        if 2 * (end - start) > n {
            (start, end) = (0, n);
        }
        let around = start.saturating_sub(1)..(end + 1).min(n);
        if let Some(tether) = &mut task.tether {
            tether.look_up(task.layout, around, at);
        }
        steps += solver.run(task, start..end, at, None).0 as u32;
        let [before, after] = [start.saturating_sub(1)..start, end..(end + 1).min(n - usize::from(closed))];
        let mut more = false;
        if (start, end) != (0, n) {
            let wider = end - start;
            if !before.is_empty() && solver.left(task, before, at) > 2.0 * task.tolerance {
                (start, more) = (start.saturating_sub(wider), true);
            }
            if !after.is_empty() && solver.left(task, after, at) > 2.0 * task.tolerance {
                (end, more) = ((end + wider).min(n), true);
            }
            if closed && (start == 0 || end == n) {
                (start, end) = (0, n);
            }
        }
        if !more {
            *window = start..end;
            return steps;
        }
    }
}

/// By how much a line is to turn at a crossing: as its profile says, and as tether and barrier pull.
fn wish(plan: &Plan, wished: &[f64], solver: &Solver, layout: &Layout, i: usize) -> f64 {
    let own = if plan.profile { wished.get(i).copied().unwrap_or(0.0) } else { 0.0 };
    if plan.tether.is_none() && plan.barrier.is_none() {
        return own;
    }
    own + 2.0 * (0.5 * solver.pull_over_length(layout, i)).clamp(-1.0, 1.0).asin()
}

/// A place inside a face, for messages.
pub(crate) fn somewhere(strip: &Strip) -> InnerPoint {
    match strip.sides.first() {
        Some(h) => InnerPoint::on_side(*h, strip.at.first().copied().unwrap_or(0.5).clamp(0.0, 1.0)),
        None => strip.start,
    }
}
