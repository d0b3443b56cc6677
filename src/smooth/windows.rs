//! Which part of a line is solved for: after the first solve only what is about new crossings has changed.

use std::ops::Range;

use super::{
    engine::Engine,
    solve::Solver,
    strip::Strip,
    task::{Task, Watch},
};

/// Crossings on either side of new ones that are solved for with them.
pub(super) const MARGIN: usize = 6;
/// Steps for all crossings of a window together, before those that are not where they should be are solved for alone.
const TOGETHER: usize = 2;
/// Steps of such a part, and how often parts are looked for.
const APART: usize = 12;
const SEARCHES: usize = 16;
/// How often in a row what is left may be more than half of what it was.
const IDLE: u32 = 4;
/// Crossings on either side of a part that are solved for with it, at first.
const BESIDE: usize = 3;
/// From this search on crossings keep their nearest stretches.
const SETTLED: usize = 1;

impl Engine {
    /// What is to be solved for: all, or what is about the crossings that are new.
    pub(crate) fn choose_windows(&mut self, strip: &Strip, all: bool) {
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
}

/// Puts ranges in order, and joins those that overlap or touch.
pub(super) fn merge(ranges: &mut Vec<Range<usize>>) {
    ranges.sort_unstable_by_key(|range| range.start);
    ranges.dedup_by(|next, kept| {
        let touches = next.start <= kept.end;
        if touches {
            kept.end = kept.end.max(next.end);
        }
        touches
    });
}

/// Solves for the crossings of a window, and for more of them as long as those beside it would move.
pub(crate) fn solve_window(
    solver: &mut Solver,
    task: &mut Task<'_>,
    window: &mut Range<usize>,
    parts: &mut Vec<Range<usize>>,
    at: &mut [f64],
    closed: bool,
    mut watch: Option<Watch<'_>>,
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
        steps += settle(solver, task, start..end, parts, at, closed, watch.as_mut().map(|w| &mut **w as Watch<'_>));
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

/// Goes through the stages: some steps for the whole range, then for what is not yet where it should be. Most crossings are after a few
/// steps; waiting for the last ones with all the others would be most of the work.
fn settle(
    solver: &mut Solver,
    task: &mut Task<'_>,
    range: Range<usize>,
    parts: &mut Vec<Range<usize>>,
    at: &mut [f64],
    closed: bool,
    mut watch: Option<Watch<'_>>,
) -> u32 {
    let (stages, tolerance, n) = (task.stages, task.tolerance, at.len());
    let mut steps = 0;
    for (k, stage) in stages.iter().enumerate() {
        (task.stages, task.tolerance) = (std::slice::from_ref(stage), task.tolerance_of(k + 1 == stages.len()));
        let mut run = |solver: &mut Solver, task: &mut Task<'_>, part: Range<usize>, at: &mut [f64]| {
            steps += solver.run(task, part, at, watch.as_mut().map(|w| &mut **w as Watch<'_>)).0 as u32;
        };
        task.most_steps = TOGETHER;
        run(solver, task, range.clone(), at);
        let mut left = solver.left(task, range.clone(), at);
        let (mut beside, mut before, mut idle) = (BESIDE, f64::INFINITY, 0);
        for search in 0..SEARCHES {
            idle = if left > 0.5 * before { idle + 1 } else { 0 };
            if left < task.tolerance || idle >= IDLE {
                break;
            }
            before = left;
            task.settled = search >= SETTLED;
            // Parts of a closed line stop before its last crossing.
            let whole = closed && range == (0..n);
            let end = if whole { n - 1 } else { range.end };
            find_parts(&solver.residual, task.tolerance, range.start..end, beside, parts);
            let count = parts.iter().map(ExactSizeIterator::len).sum::<usize>();
            if whole && solver.residual[n - 1] >= task.tolerance || 4 * count > 3 * range.len() {
                run(solver, task, range.clone(), at);
                left = solver.left(task, range.clone(), at);
            } else {
                task.most_steps = APART;
                left = 0.0;
                for part in parts.iter() {
                    run(solver, task, part.clone(), at);
                }
                for part in parts.iter() {
                    let around = part.start.saturating_sub(1).max(range.start)..(part.end + 1).min(range.end);
                    left = left.max(solver.left(task, around, at));
                }
                task.most_steps = TOGETHER;
            }
            beside += beside / 2;
        }
        task.settled = false;
        (task.stages, task.tolerance) = (stages, tolerance);
    }
    steps
}

/// What is about the crossings of a range that are not where they should be.
fn find_parts(residual: &[f64], tolerance: f64, range: Range<usize>, beside: usize, parts: &mut Vec<Range<usize>>) {
    parts.clear();
    for i in range.clone().filter(|i| residual[*i] >= tolerance) {
        let (start, end) = (i.saturating_sub(beside).max(range.start), (i + beside + 1).min(range.end));
        match parts.last_mut() {
            Some(last) if start <= last.end => last.end = end,
            _ => parts.push(start..end),
        }
    }
}
