//! Which part of a line is solved for: after the first solve only what is about new crossings has changed.

use std::ops::Range;

use super::{engine::Engine, solve::Solver, strip::Strip, task::Task};

/// Crossings on either side of new ones that are solved for with them.
const MARGIN: usize = 12;

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

/// Solves for the crossings of a window, and for more of them as long as those beside it would move.
pub(crate) fn solve_window(
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
