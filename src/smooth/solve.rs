//! The best crossings for a strip of faces that stays as it is.
//!
//! With crossings wᵢ along sides eᵢ (from right to left), unit directions uᵢ of the stretches and nᵢ the left normal of
//! uᵢ₋₁ + uᵢ, the line turns by κᵢ everywhere where ⟨eᵢ, uᵢ₋₁ − uᵢ⟩ + 2 sin(κᵢ/2) ⟨nᵢ, eᵢ⟩ vanishes. With the normals held fast that is the
//! gradient of a convex function, a length and a linear form; a tether adds a parabola for each crossing. Its
//! minimum is found by Newton steps on a tridiagonal matrix (cyclic for closed lines), where turns are large by steps
//! that majorise, inside the bounds of every crossing.

use std::ops::Range;

use glam::DVec2;

use super::{
    layout::Layout,
    task::{Part, Task, Watch, barrier, tangent},
};

/// Stages of rounding off, in mean edges: crossings that gather at a vertex would stall without.
pub(crate) const STAGES: [f64; 3] = [0.1, 0.01, 0.001];
/// Below this a stretch is as good as straight and Newton's matrix is taken.
const NEARLY: f64 = 0.3;
/// Good enough before the next stage.
const COARSE: f64 = 1e-2;
/// Rounds in which crossings are held at their bounds.
const BOUND_ROUNDS: usize = 4;
/// A crossing this near to its bound is at it.
const AT_BOUND: f64 = 1e-9;
/// Share of its stiffness that a tether has at least along the drawn line.
const ALONG: f64 = 0.05;
/// Steps in which crossings look for the nearest stretch of the drawn line.
const UNSTEADY: usize = 6;
/// Tries of ever shorter steps.
const HALVINGS: usize = 20;

/// Scratch memory of the solves.
#[derive(Debug, Default)]
pub(crate) struct Solver {
    units: Vec<DVec2>,
    lengths: Vec<f64>,
    /// ⟨nᵢ, eᵢ⟩ times twice the sine of half the wished turn.
    bending: Vec<f64>,
    gradient: Vec<f64>,
    pull: Vec<f64>,
    stiff: Vec<f64>,
    diagonal: Vec<f64>,
    beside: Vec<f64>,
    step: Vec<f64>,
    held: Vec<bool>,
    moved: Vec<f64>,
    factor: Vec<f64>,
    column: Vec<f64>,
}

impl Solver {
    /// What tether and barrier pull a crossing by, to the right, after a solve.
    pub(crate) fn pull_over_length(&self, layout: &Layout, i: usize) -> f64 {
        match (self.pull.get(i), layout.lengths.get(i)) {
            (Some(pull), Some(length)) if *length > 0.0 => pull / length,
            _ => 0.0,
        }
    }

    /// Moves the crossings of a range to where they are best, the others held; gives the steps taken and the largest turn
    /// that remained.
    pub(crate) fn run(
        &mut self,
        task: &mut Task<'_>,
        range: Range<usize>,
        at: &mut [f64],
        watch: Option<Watch<'_>>,
    ) -> (usize, f64) {
        if range.is_empty() {
            return (0, 0.0);
        }
        let mut watch = watch;
        self.make_room(at.len());
        let part = Part::new(task.layout, range, at.len());
        let (mut stage, mut damping, mut left) = (0, 0.0, f64::INFINITY);
        for step in 0..task.most_steps {
            let Some(&rounding) = task.stages.get(stage) else { break };
            let rounding = rounding * task.mean;
            if let Some(tether) = &mut task.tether {
                tether.steady = step >= UNSTEADY;
            }
            left = self.look(task, &part, at, rounding);
            let last = stage + 1 == task.stages.len();
            if left < if last { task.tolerance } else { COARSE.max(task.tolerance) } {
                if last {
                    return (step, left);
                }
                stage += 1;
                continue;
            }
            self.matrix(task, &part);
            self.solve_in_bounds(task, &part, at, damping);
            let accepted = self.descend(task, &part, at, rounding);
            if let Some(watch) = &mut watch {
                watch(at);
            }
            if accepted {
                damping = if damping < 1e-6 { 0.0 } else { damping * 0.1 };
            } else if damping < 1e6 {
                damping = if damping == 0.0 { 1e-3 } else { damping * 10.0 };
            } else if last {
                return (step, left);
            } else {
                (stage, damping) = (stage + 1, 0.0);
            }
        }
        (task.most_steps, left)
    }

    /// The largest turn that is left at some crossings, the rounding off being that of the last stage.
    pub(crate) fn left(&mut self, task: &mut Task<'_>, range: Range<usize>, at: &[f64]) -> f64 {
        let rounding = task.stages.last().copied().unwrap_or(0.0) * task.mean;
        let part = Part::new(task.layout, range, at.len());
        self.make_room(at.len());
        self.look(task, &part, at, rounding)
    }

    fn make_room(&mut self, n: usize) {
        let lists = [
            &mut self.bending,
            &mut self.gradient,
            &mut self.pull,
            &mut self.stiff,
            &mut self.diagonal,
            &mut self.beside,
            &mut self.step,
            &mut self.moved,
            &mut self.factor,
            &mut self.column,
        ];
        lists.into_iter().for_each(|list| list.resize(n, 0.0));
        self.held.resize(n, false);
        self.units.resize(n + 1, DVec2::ZERO);
        self.lengths.resize(n + 1, 0.0);
    }

    /// Directions and forces; holds what is pressed against its bound, and gives the largest turn that is left elsewhere.
    fn look(&mut self, task: &mut Task<'_>, part: &Part, at: &[f64], rounding: f64) -> f64 {
        for j in part.legs.clone() {
            let d = task.layout.stretch(j, at);
            let length = (d.length_squared() + rounding * rounding).sqrt();
            self.lengths[j] = length;
            self.units[j] = d / length;
        }
        self.forces(task, part, at);
        let mut left = 0.0_f64;
        for i in part.range.clone() {
            let ([low, high], length) = (task.bounds[i], task.layout.lengths[i]);
            let still = high - low <= 0.0 || length <= 1e-12 * task.mean;
            let (g, t) = (self.gradient[i], at[i]);
            self.held[i] = still || (t <= low + AT_BOUND && g > 0.0) || (t >= high - AT_BOUND && g < 0.0);
            if !self.held[i] {
                // A turn, or what is left of the way to where a stiff tether leads, in mean edges.
                left = left.max(g.abs() * length / (length * length + self.stiff[i] * task.mean));
            }
        }
        left
    }

    /// The gradient.
    fn forces(&mut self, task: &mut Task<'_>, part: &Part, at: &[f64]) {
        let layout = task.layout;
        for i in part.range.clone() {
            let (after, leg) = (layout.after(i), &layout.legs[i]);
            let length = layout.lengths[i];
            let (before, next) = (self.units[i], self.units[after]);
            let turn = task.turns.get(i).copied().unwrap_or(0.0);
            let mut bending = 0.0;
            if turn != 0.0 && length > 0.0 {
                let up = leg.leave / length;
                // Both directions in the frame of the side.
                let along = DVec2::new(before.perp_dot(up), before.dot(up)) + next;
                let size = along.length();
                if size > 1e-9 {
                    bending = 2.0 * (0.5 * turn).sin() * length * along.x / size;
                }
            }
            (self.bending[i], self.pull[i], self.stiff[i]) = (bending, 0.0, 0.0);
            self.gradient[i] = leg.leave.dot(before) - length * next.y + bending;
        }
        if let Some(tether) = &mut task.tether {
            for i in part.range.clone() {
                let place = layout.place(i, at[i]);
                let stretch = tether.nearest[i] as usize;
                let near =
                    if tether.steady { tether.line.of(place, stretch) } else { tether.line.near(place, stretch) };
                let Some(near) = near else { continue };
                tether.nearest[i] = near.stretch as u32;
                let share = 0.5 * (self.lengths[i] + self.lengths[layout.after(i)]) * tether.stiffness[near.stretch];
                let side = layout.extents[i];
                let (squared, along) = (side.length_squared(), side.dot(tangent(tether.line, near.stretch)));
                self.pull[i] = share * (place - near.place).dot(side);
                let across = if near.at_end { squared } else { (squared - along * along).max(ALONG * squared) };
                self.stiff[i] = share * across;
                self.gradient[i] += self.pull[i];
            }
        }
        if let Some((reach, ends)) = task.barrier {
            for i in part.range.clone() {
                let (force, stiff) = barrier(ends[i], at[i], layout.lengths[i], reach);
                self.pull[i] += force;
                self.stiff[i] += stiff;
                self.gradient[i] += force;
            }
        }
    }

    /// The matrix, for each stretch Newton's or one that majorises.
    fn matrix(&mut self, task: &Task<'_>, part: &Part) {
        let layout = task.layout;
        for i in part.range.clone() {
            (self.diagonal[i], self.beside[i]) = (self.stiff[i], 0.0);
        }
        let rough = |i: usize| !self.held[i] && self.gradient[i].abs() > NEARLY * layout.lengths[i];
        for j in part.legs.clone() {
            let leg = &layout.legs[j];
            let [from, to] = part.ends(j);
            let (u, inverse) = (self.units[j], 1.0 / self.lengths[j]);
            let newton = if from.is_some_and(rough) || to.is_some_and(rough) { 0.0 } else { 1.0 };
            let product = |a: DVec2, b: DVec2| (a.dot(b) - newton * a.dot(u) * b.dot(u)) * inverse;
            let enter = DVec2::new(0.0, leg.enter);
            if let Some(from) = from {
                self.diagonal[from] += product(enter, enter);
                if to.is_some() {
                    self.beside[from] -= product(enter, leg.leave);
                }
            }
            if let Some(to) = to {
                self.diagonal[to] += product(leg.leave, leg.leave);
            }
        }
    }

    /// The step to the minimum of the parabola inside the bounds: which crossings stop at theirs is guessed, and the guess mended
    /// by what presses and what leaves, until it holds (a primal–dual active set).
    fn solve_in_bounds(&mut self, task: &Task<'_>, part: &Part, at: &[f64], damping: f64) {
        self.step[part.range.clone()].fill(0.0);
        for round in 0..BOUND_ROUNDS {
            self.solve(task, part, damping);
            let mut changed = false;
            for i in part.range.clone() {
                let ([low, high], t) = (task.bounds[i], at[i]);
                if self.held[i] {
                    if high - low <= 0.0 || task.layout.lengths[i] <= 1e-12 * task.mean || 2 * round > BOUND_ROUNDS {
                        continue;
                    }
                    let mut force = self.gradient[i] + self.diagonal[i] * self.step[i];
                    if let Some(next) = part.next(i) {
                        force += self.beside[i] * self.step[next];
                    }
                    if let Some(before) = part.before(i) {
                        force += self.beside[before] * self.step[before];
                    }
                    let at_low = t + self.step[i] <= low + AT_BOUND;
                    if if at_low { force < 0.0 } else { force > 0.0 } {
                        self.held[i] = false;
                        changed = true;
                    }
                    continue;
                }
                let to = t + self.step[i];
                if to < low - 1e-12 || to > high + 1e-12 {
                    (self.held[i], self.step[i]) = (true, to.clamp(low, high) - t);
                    changed = true;
                }
            }
            if !changed {
                return;
            }
        }
    }

    /// Solves the tridiagonal system, or of a closed line the cyclic one, for all crossings that are not held; those that
    /// are keep their step.
    fn solve(&mut self, task: &Task<'_>, part: &Part, damping: f64) {
        let Range { start: first, end } = part.range;
        let last = end - 1;
        let Self { diagonal, beside, gradient, step, held, moved: right, factor: pivot, column, .. } = self;
        let free_pair = |i: usize, j: usize| if held[i] || held[j] { 0.0 } else { beside[i] };
        let soft = (damping + 1e-10) / task.mean;
        for i in part.range.clone() {
            column[i] = 0.0;
            (pivot[i], right[i]) = if held[i] {
                (1.0, step[i])
            } else {
                let mut known = 0.0;
                if let Some(next) = part.next(i).filter(|k| held[*k]) {
                    known += beside[i] * step[next];
                }
                if let Some(before) = part.before(i).filter(|k| held[*k]) {
                    known += beside[before] * step[before];
                }
                let length = task.layout.lengths[i];
                (diagonal[i] + soft * length * length, -gradient[i] - known)
            };
        }
        // The last unknown is coupled to its neighbour and, of a closed line, to the first one: a column of its own.
        if last > first {
            if part.cyclic {
                column[first] = free_pair(last, first);
            }
            column[last - 1] += free_pair(last - 1, last);
        }
        for i in first..last {
            let inverse = 1.0 / pivot[i];
            if i + 1 < last {
                let by = free_pair(i, i + 1);
                let f = by * inverse;
                pivot[i + 1] -= f * by;
                right[i + 1] -= f * right[i];
                column[i + 1] -= f * column[i];
            }
            let f = column[i] * inverse;
            pivot[last] -= f * column[i];
            right[last] -= f * right[i];
            pivot[i] = inverse;
        }
        step[last] = right[last] / pivot[last].max(1e-300);
        for i in (first..last).rev() {
            let by = if i + 1 < last { free_pair(i, i + 1) * step[i + 1] } else { 0.0 };
            step[i] = (right[i] - by - column[i] * step[last]) * pivot[i];
        }
    }

    /// Takes the step, or as much of it as leads downhill; says whether there was any.
    fn descend(&mut self, task: &Task<'_>, part: &Part, at: &mut [f64], rounding: f64) -> bool {
        let layout = task.layout;
        let noise = 1e-15 * task.mean * part.range.len() as f64;
        self.moved[part.range.clone()].copy_from_slice(&at[part.range.clone()]);
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let (mut change, mut largest) = (0.0, 0.0_f64);
            for i in part.range.clone() {
                let [low, high] = task.bounds[i];
                let to = (self.moved[i] + share * self.step[i]).clamp(low, high);
                let by = to - self.moved[i];
                at[i] = to;
                change += by * (self.bending[i] + self.pull[i] + 0.5 * by * self.stiff[i]);
                largest = largest.max(by.abs());
            }
            for j in part.legs.clone() {
                let d = layout.stretch(j, at);
                change += (d.length_squared() + rounding * rounding).sqrt() - self.lengths[j];
            }
            if change <= noise {
                return largest > 1e-14;
            }
            share *= 0.5;
        }
        at[part.range.clone()].copy_from_slice(&self.moved[part.range.clone()]);
        false
    }
}
