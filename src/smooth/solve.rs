//! The best crossings for a strip of faces that stays as it is.
//!
//! With crossings wᵢ along sides eᵢ (from right to left), unit directions uᵢ of the stretches and nᵢ the left normal of
//! uᵢ₋₁ + uᵢ, the line turns by κᵢ everywhere where ⟨eᵢ, uᵢ₋₁ − uᵢ⟩ + 2 sin(κᵢ/2) ⟨nᵢ, eᵢ⟩ vanishes. With the normals held fast that is the
//! gradient of a convex function, a length and a linear form; a tether adds a parabola for each crossing. Its
//! minimum is found by Newton steps on a tridiagonal matrix (cyclic for closed lines), where turns are large by steps
//! that majorise, inside the bounds of every crossing.

use std::ops::Range;

use glam::DVec2;

use super::task::{Part, Task, Watch, barrier};

/// Below this a stretch is as good as straight and Newton's matrix is taken.
const NEARLY: f64 = 0.3;
/// Rounds in which crossings are held at their bounds.
const BOUND_ROUNDS: usize = 4;
/// A crossing this near to its bound is at it.
const AT_BOUND: f64 = 1e-9;
/// Share of its stiffness that a tether has at least along the drawn line.
const ALONG: f64 = 0.05;
/// Steps in which crossings look for the nearest stretch of the drawn line.
const UNSTEADY: usize = 2;
/// Tries of ever shorter steps.
const HALVINGS: usize = 20;

/// Scratch memory of the solves.
#[derive(Debug, Default)]
pub(crate) struct Solver {
    units: Vec<DVec2>,
    lengths: Vec<f64>,
    inverses: Vec<f64>,
    /// ⟨nᵢ, eᵢ⟩ times twice the sine of half the wished turn.
    bending: Vec<f64>,
    gradient: Vec<f64>,
    pull: Vec<f64>,
    stiff: Vec<f64>,
    diagonal: Vec<f64>,
    beside: Vec<f64>,
    step: Vec<f64>,
    held: Vec<bool>,
    /// What is left of a crossing's turn, or of its way; nothing where it is held.
    pub(crate) residual: Vec<f64>,
    moved: Vec<f64>,
    factor: Vec<f64>,
    column: Vec<f64>,
}

impl Solver {
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
                tether.steady = task.settled || step >= UNSTEADY;
            }
            left = self.look(task, &part, at, rounding);
            let last = stage + 1 == task.stages.len();
            if left < task.tolerance_of(last) {
                if last {
                    return (step, left);
                }
                stage += 1;
                continue;
            }
            self.matrix(task, &part);
            self.solve_in_bounds(task, &part, at, damping);
            let accepted = self.descend(task, &part, at, rounding);
            if let Some(watch) = &mut watch
                && watch(at, part.range.len())
            {
                return (step, left);
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
            &mut self.residual,
            &mut self.moved,
            &mut self.factor,
            &mut self.column,
        ];
        lists.into_iter().for_each(|list| list.resize(n, 0.0));
        self.held.resize(n, false);
        self.units.resize(n + 1, DVec2::ZERO);
        self.lengths.resize(n + 1, 0.0);
        self.inverses.resize(n + 1, 0.0);
    }

    /// Directions and forces; holds what is pressed against its bound, and gives the largest turn that is left elsewhere.
    fn look(&mut self, task: &mut Task<'_>, part: &Part, at: &[f64], rounding: f64) -> f64 {
        for j in part.legs.clone() {
            let d = task.layout.stretch(j, at);
            let length = (d.length_squared() + rounding * rounding).sqrt();
            let inverse = 1.0 / length;
            (self.lengths[j], self.inverses[j], self.units[j]) = (length, inverse, d * inverse);
        }
        self.forces(task, part, at);
        let mut left = 0.0_f64;
        for i in part.range.clone() {
            let ([low, high], length) = (task.bounds[i], task.layout.lengths[i]);
            let still = high - low <= 0.0 || length <= 1e-12 * task.mean;
            let (g, t) = (self.gradient[i], at[i]);
            self.held[i] = still || (t <= low + AT_BOUND && g > 0.0) || (t >= high - AT_BOUND && g < 0.0);
            // A turn, or what is left of the way to where a stiff tether leads, in mean edges.
            let off = g.abs() * length / (length * length + self.stiff[i] * task.mean);
            self.residual[i] = if self.held[i] { 0.0 } else { off };
            left = left.max(self.residual[i]);
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
                let (squared, along) = (side.length_squared(), tether.line.squared_along(near.stretch, side));
                self.pull[i] = share * (place - near.place).dot(side);
                let across = if near.at_end { squared } else { (squared - along).max(ALONG * squared) };
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
            let (u, inverse) = (self.units[j], self.inverses[j]);
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
        (first..last).zip(&mut column[first..]).for_each(|(i, couple)| *couple = free_pair(i, i + 1));
        if part.cyclic && last > first {
            let seam = free_pair(last, first);
            cyclic(pivot, right, column, step, seam, first..end);
        } else {
            from_both_ends(pivot, right, column, step, first..end);
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

/// Solves a tridiagonal system from both ends towards the middle: two chains of divisions that do not wait for each other.
fn from_both_ends(pivot: &mut [f64], right: &mut [f64], couple: &[f64], step: &mut [f64], range: Range<usize>) {
    let Range { start: first, end } = range;
    let half = (end - first - 1) / 2;
    let middle = first + half;
    for k in 0..end - 1 - middle {
        let (i, j) = (first + k, end - 1 - k);
        let (a, b) = (1.0 / pivot[i], 1.0 / pivot[j]);
        if k < half {
            let f = couple[i] * a;
            pivot[i + 1] -= f * couple[i];
            right[i + 1] -= f * right[i];
            pivot[i] = a;
        }
        let f = couple[j - 1] * b;
        pivot[j - 1] -= f * couple[j - 1];
        right[j - 1] -= f * right[j];
        pivot[j] = b;
    }
    step[middle] = right[middle] / pivot[middle];
    for k in 1..end - middle {
        let j = middle + k;
        step[j] = (right[j] - couple[j - 1] * step[j - 1]) * pivot[j];
        if k <= half {
            let i = middle - k;
            step[i] = (right[i] - couple[i] * step[i + 1]) * pivot[i];
        }
    }
}

/// Solves a tridiagonal system whose last unknown is coupled to the first one too: with a column of its own.
fn cyclic(pivot: &mut [f64], right: &mut [f64], couple: &[f64], step: &mut [f64], seam: f64, range: Range<usize>) {
    let (first, last) = (range.start, range.end - 1);
    // What couples a crossing to the last one.
    let mut to_last = seam;
    for i in first..last {
        let inverse = 1.0 / pivot[i];
        let by = couple[i];
        let own = if i + 1 == last { to_last + by } else { to_last };
        if i + 1 < last {
            let f = by * inverse;
            pivot[i + 1] -= f * by;
            right[i + 1] -= f * right[i];
            to_last = -f * own;
        }
        let f = own * inverse;
        pivot[last] -= f * own;
        right[last] -= f * right[i];
        (pivot[i], step[i]) = (inverse, own);
    }
    step[last] = right[last] / pivot[last];
    let end = step[last];
    for i in (first..last).rev() {
        let by = if i + 1 < last { couple[i] * step[i + 1] } else { 0.0 };
        step[i] = (right[i] - by - step[i] * end) * pivot[i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smooth::tests::Random;

    /// Solutions put back into their systems give the right sides.
    #[test]
    fn systems_are_solved() {
        let mut random = Random(41);
        for n in 1..40 {
            for seam in [false, true] {
                if seam && n < 3 {
                    continue;
                }
                let couple: Vec<f64> = (0..n).map(|_| random.next() - 0.5).collect();
                let diagonal: Vec<f64> = (0..n).map(|_| 1.1 + random.next()).collect();
                let right: Vec<f64> = (0..n).map(|_| random.next() - 0.5).collect();
                let (mut pivot, mut worked, mut step) = (diagonal.clone(), right.clone(), vec![0.0; n]);
                let at_seam = if seam { couple[n - 1] } else { 0.0 };
                if seam {
                    cyclic(&mut pivot, &mut worked, &couple, &mut step, at_seam, 0..n);
                } else {
                    from_both_ends(&mut pivot, &mut worked, &couple, &mut step, 0..n);
                }
                for i in 0..n {
                    let mut sum = diagonal[i] * step[i] - right[i];
                    sum += if i + 1 < n { couple[i] * step[i + 1] } else { at_seam * step[0] };
                    sum += if i > 0 { couple[i - 1] * step[i - 1] } else { at_seam * step[n - 1] };
                    assert!(sum.abs() < 1e-13, "{n} {seam} {i}: {sum:e}");
                }
            }
        }
    }
}
