//! Smoothing by solving: the best crossings for the strip, then past the vertices that press, until none does.

use std::ops::Range;

use super::{
    SmoothRange, envelope,
    fan::Fan,
    flip::{Flipper, Rule, touching},
    layout::Layout,
    metric::Metric,
    nodes::{self, Node},
    plain::Sweeper,
    profile::Profile,
    progress::Watch,
    roughness::Turn,
    shortcuts::Shortcuts,
    solve::Solver,
    strip::Strip,
    task::{Task, Tether},
    tree::LineTree,
    windows::{merge, solve_window},
    wish::Wish,
};
use glam::DVec3;

use crate::surface::{InnerPoint, Surface};

/// Crossings this near to a vertex, in mean edges, may pass it.
pub(crate) const NEAR: f64 = 1e-2;
/// How corners are rounded off at first, in mean edges: crossings that gather at a vertex would stall without.
const FIRST: [&[f64]; 3] = [&[0.1, 0.01], &[0.03, 1e-3], &[0.03, 1e-3, 1e-4]];
/// How corners are rounded off while vertices are passed, in mean edges, level after level: less when nothing more is to pass. Of the
/// whole line when a level is reached.
const LEVELS: [&[f64]; 3] = [&[1e-2], &[1e-3], &[1e-4]];
/// And about vertices that were passed.
const PASSED: [&[f64]; 3] = [&[1e-2], &[1e-2, 1e-3], &[1e-2, 1e-3, 1e-4]];
/// How corners are rounded off at the end.
const LAST: [f64; 2] = [1e-4, 1e-6];
/// Rounds in which a line may get no shorter.
const IDLE: u32 = 24;
/// The length is looked at in every so many rounds.
const LOOKS: u32 = 4;
/// By how much a line may grow when it passes vertices.
const GROWTH: f64 = 1e-3;
/// Turns that may remain while most vertices are passed.
const COARSELY: f64 = 1e-2;
/// Turns that may remain where a tether holds the line, until the end; and where it holds it loosely, so that they add up.
const HELD: [f64; 2] = [2e-2, 1e-2];
/// Turns that may remain before vertices are passed, and at the end.
const ROUGHLY: f64 = 1e-3;
const EXACTLY: f64 = 1e-7;
/// A tether of this closeness holds a line; below that it holds it loosely.
const HOLDS: f64 = 0.05;
const LOOSE: f64 = 3.0;
/// Crossings begin this far inside their sides, so that none is stuck at a vertex.
const INSIDE: f64 = 1e-3;

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
    /// Whether shortcuts were taken.
    pub(crate) is_short: bool,
}

/// How a strip is solved for.
struct How {
    /// Stages of rounding off corners, in mean edges.
    stages: &'static [f64],
    /// How far inside their sides crossings begin.
    inside: f64,
    /// Turns that may remain.
    tolerance: f64,
    /// Whether all crossings look for the nearest stretch of the drawn line, or new ones alone.
    afresh: bool,
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
    /// Whether the line given was kept.
    pub(crate) kept: bool,
    /// By what tether.
    pub(crate) closeness: Option<f64>,
}

impl Done {
    pub(crate) fn add(&mut self, other: Self) {
        self.rounds += other.rounds;
        self.steps += other.steps;
        self.flips += other.flips;
        self.met_bound |= other.met_bound;
        self.collapsed |= other.collapsed;
        self.kept |= other.kept;
        self.closeness = other.closeness.or(self.closeness);
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
    /// By what they were found.
    pub(crate) judged: Option<(f64, Option<SmoothRange>)>,
    /// Length of the drawn line, and at which share of it the line as it was given begins: a closed one's seam may have moved.
    pub(crate) length: f64,
    pub(crate) begin: f64,
    pub(crate) wished: Vec<f64>,
    pub(crate) bounds: Vec<[f64; 2]>,
    pub(crate) stiffness: Vec<f64>,
    pub(crate) shortcuts: Shortcuts,
    ends: Vec<[bool; 2]>,
    pieces: Vec<[f64; 2]>,
    /// Where crossings were, and where they are to be.
    pub(crate) places: Vec<[f64; 2]>,
    pub(crate) turns: Vec<Turn>,
    pub(crate) fros: Vec<f64>,
    kept: Strip,
    /// Which crossings are solved for.
    pub(crate) windows: Vec<Range<usize>>,
    parts: Vec<Range<usize>>,
}

impl Engine {
    /// Takes up a drawn line.
    pub(crate) fn take_up(&mut self, positions: &[DVec3], begin: f64) {
        self.line.build(positions);
        self.length = positions.windows(2).fold(0.0, |sum, pair| sum + pair[0].distance(pair[1]));
        self.begin = begin;
        self.judged = None;
    }

    /// Fills in how much a line turns, its density spread to neighbours.
    pub(crate) fn measure_profile(&mut self, surface: &Surface, strip: &Strip, passes: u32, scale: f64) {
        self.layout.build(surface, &mut self.metric, strip);
        nodes::find(surface, &mut self.metric, strip, &self.layout, &mut self.fan, &mut self.nodes);
        self.profile.measure(strip, &self.layout, &self.nodes, passes, scale);
    }

    /// Fills in how stiff the tether is.
    pub(crate) fn fill_stiffness(&mut self, plan: &Plan) {
        self.stiffness.clear();
        if let Some(closeness) = plan.tether {
            let per = closeness / (plan.reach * plan.reach);
            self.stiffness.extend(self.factors.iter().map(|factor| factor * per));
        }
    }

    /// Smooths a strip, of which the drawn line, the profile and the metric are known.
    pub(crate) fn relax(&mut self, surface: &Surface, strip: &mut Strip, plan: &Plan, watch: &mut Watch<'_>) -> Done {
        let mut done = Done::default();
        self.flipper.counts.clear();
        self.flipper.changed.clear();
        self.fill_stiffness(plan);
        let near = NEAR * plan.mean;
        // A tether forgives turns that would let a free line drift.
        let is_held = plan.is_short && plan.tether.is_some_and(|closeness| closeness >= HOLDS);
        // What was straightened has few vertices left to pass.
        let (mut seams, mut level, mut kept) = (0, usize::from(plan.is_short), f64::INFINITY);
        let mut raised = true;
        let (mut shortest, mut since) = (f64::INFINITY, 0);
        loop {
            if strip.closed {
                self.layout.build(surface, &mut self.metric, strip);
                self.move_seam(surface, strip, near, raised, seams > 0);
            }
            if strip.closed && (strip.len() < 3 || self.is_point(surface, strip, plan.mean)) {
                done.collapsed = true;
                return done;
            }
            let first = done.rounds == 0;
            self.choose_windows(strip, raised || seams > 0);
            let how = How {
                stages: if first {
                    FIRST[level]
                } else if raised {
                    LEVELS[level]
                } else {
                    PASSED[level]
                },
                inside: if first { INSIDE } else { 0.0 },
                tolerance: match level {
                    _ if is_held => HELD[usize::from(plan.tether < Some(LOOSE))],
                    0 => COARSELY,
                    _ => ROUGHLY,
                },
                afresh: raised,
            };
            raised = false;
            done.steps += self.solve(surface, strip, plan, &how, watch);
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
            if watch.stops(&done, || strip.length(surface)) {
                return done;
            }
            if done.rounds >= plan.max_rounds {
                done.met_bound = true;
                break;
            }
            // Where vertices are passed to and fro, nothing is gained any more.
            let length = if done.rounds.is_multiple_of(LOOKS) { self.layout.length(&strip.at) } else { f64::INFINITY };
            if length < shortest * (1.0 - 1e-7) {
                (shortest, since) = (length, done.rounds);
            } else if done.rounds > since + IDLE {
                break;
            }
            done.rounds += 1;
            let flipped = self.pass(surface, strip, plan, near);
            done.flips += flipped.count as u32;
            if flipped.count > 0 {
                watch.see(strip);
                seams = 0;
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

    /// Passes the vertices that press.
    fn pass(&mut self, surface: &Surface, strip: &mut Strip, plan: &Plan, near: f64) -> super::flip::Flipped {
        let Self { metric, layout, flipper, line, wished, stiffness, ends, windows, .. } = self;
        let wish = wish(plan, layout, wished, line, stiffness, ends);
        let wish = |strip: &Strip, k: usize| wish.turn(strip, k);
        let mut allowed = |vertex: u32| match plan.envelope {
            Some(reach) => {
                line.nearest(surface.positions[vertex as usize], None).is_some_and(|near| near.distance <= reach)
            }
            None => true,
        };
        let mut rule = Rule { near, wished: &wish, allowed: &mut allowed, straight: false, windows };
        flipper.flip(surface, metric, strip, layout, &mut rule)
    }

    /// One solve on the strip as it is; gives the steps taken.
    fn solve(&mut self, surface: &Surface, strip: &mut Strip, plan: &Plan, how: &How, watch: &mut Watch<'_>) -> u32 {
        self.layout.build(surface, &mut self.metric, strip);
        self.fill_bounds(surface, strip, plan);
        if how.inside > 0.0 {
            for (at, [low, high]) in strip.at.iter_mut().zip(&self.bounds) {
                let room = how.inside.min(0.5 * (high - low));
                *at = at.clamp(low + room, high - room);
            }
        }
        if plan.profile {
            self.profile.wished(strip, &mut self.wished);
        }
        self.run_solver(strip, plan, how, watch)
    }

    fn run_solver(&mut self, strip: &mut Strip, plan: &Plan, how: &How, watch: &mut Watch<'_>) -> u32 {
        let Self { layout, solver, line, wished, bounds, stiffness, ends, windows, parts, .. } = self;
        let (sees, mut steps) = (watch.sees(), 0);
        let mut nearest = std::mem::take(&mut strip.near);
        let mut task = Task {
            layout,
            turns: if plan.profile { wished } else { &[] },
            tether: plan.tether.map(|_| Tether {
                line,
                stiffness,
                nearest: &mut nearest,
                afresh: how.afresh,
                steady: false,
            }),
            bounds,
            barrier: plan.barrier.map(|reach| (reach, ends.as_slice())),
            mean: plan.mean,
            stages: how.stages,
            tolerance: how.tolerance,
            most_steps: 0,
            settled: false,
        };
        let mut at = std::mem::take(&mut strip.at);
        let closed = strip.closed;
        let mut show = |at: &[f64], moved: usize| {
            if sees {
                strip.at.clear();
                strip.at.extend_from_slice(at);
                watch.see(strip);
            }
            watch.stops_within(moved)
        };
        for k in 0..windows.len() {
            // A window that grew may hold the next ones.
            if let Some(before) = k.checked_sub(1).map(|k| windows[k].clone())
                && before.start <= windows[k].start
                && windows[k].end <= before.end
            {
                windows[k] = before;
                continue;
            }
            let show = Some(&mut show as &mut dyn FnMut(&[f64], usize) -> bool);
            steps += solve_window(solver, &mut task, &mut windows[k], parts, &mut at, closed, show);
        }
        merge(windows);
        (strip.at, strip.near) = (at, nearest);
        steps
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
        watch: &mut Watch<'_>,
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
        let Self { metric, layout, flipper, bounds, wished, line, stiffness, ends, .. } = self;
        let wish = wish(plan, layout, wished, line, stiffness, ends);
        let wish = |strip: &Strip, k: usize| wish.turn(strip, k);
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
        let how = How { stages: &LAST, inside: 0.0, tolerance: EXACTLY, afresh: true };
        done.steps += self.run_solver(strip, plan, &how, watch);
        if !plan.profile && plan.barrier.is_none() {
            self.straighten_gathered(surface, strip, plan.mean);
        }
        watch.see(strip);
    }

    /// Whether a closed line has shrunk to a point.
    pub(crate) fn is_point(&self, surface: &Surface, strip: &Strip, mean: f64) -> bool {
        let Some(first) = (!strip.sides.is_empty()).then(|| strip.crossing(surface, 0)) else { return true };
        (0..strip.len()).all(|i| strip.crossing(surface, i).distance(first) < 2.0 * NEAR * mean)
    }
}

/// What a plan wishes of a strip that is laid flat.
fn wish<'a>(
    plan: &Plan,
    layout: &'a Layout,
    wished: &'a [f64],
    line: &'a LineTree,
    stiffness: &'a [f64],
    ends: &'a [[bool; 2]],
) -> Wish<'a> {
    Wish {
        layout,
        turns: if plan.profile { wished } else { &[] },
        tether: plan.tether.map(|_| (line, stiffness)),
        barrier: plan.barrier.map(|reach| (reach, ends)),
    }
}

/// A place inside a face, for messages.
pub(crate) fn somewhere(strip: &Strip) -> InnerPoint {
    match strip.sides.first() {
        Some(h) => InnerPoint::on_side(*h, strip.at.first().copied().unwrap_or(0.5).clamp(0.0, 1.0)),
        None => strip.start,
    }
}
