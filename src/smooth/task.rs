//! What is to be solved: a strip laid flat, wished turns, a tether, bounds; and which part of it.

use std::ops::Range;

use super::{layout::Layout, strip::UNKNOWN, tree::LineTree};

/// Good enough before the next stage.
const COARSE: f64 = 0.1;

/// A tether to a drawn line.
#[derive(Debug)]
pub(crate) struct Tether<'a> {
    pub(crate) line: &'a LineTree,
    /// For each stretch of the line: closeness over squared reach.
    pub(crate) stiffness: &'a [f64],
    /// For each crossing the stretch of the line that is nearest.
    pub(crate) nearest: &'a mut [u32],
    /// Whether all of them are to be looked up again, once.
    pub(crate) afresh: bool,
    /// Whether stretches stay: set after some steps, so that a crossing does not go to and fro between two of them.
    pub(crate) steady: bool,
}

impl Tether<'_> {
    /// Finds the nearest stretches of some crossings of which they are not known, or of all of them.
    pub(crate) fn look_up(&mut self, layout: &Layout, range: Range<usize>, at: &[f64]) {
        let afresh = std::mem::take(&mut self.afresh);
        let mut hint = None;
        for i in range {
            let known = (self.nearest[i] != UNKNOWN).then(|| self.nearest[i] as usize);
            if known.is_none() || afresh {
                let near = self.line.nearest(layout.place(i, at[i]), known.or(hint));
                self.nearest[i] = near.map_or(0, |near| near.stretch as u32);
            }
            hint = Some(self.nearest[i] as usize);
        }
    }
}

/// What is to be solved.
pub(crate) struct Task<'a> {
    pub(crate) layout: &'a Layout,
    /// Wished turns; empty: none.
    pub(crate) turns: &'a [f64],
    pub(crate) tether: Option<Tether<'a>>,
    /// Bounds of the crossings.
    pub(crate) bounds: &'a [[f64; 2]],
    /// Reach and strength of the barrier at ends of sides that lie on the boundary, and which ends do (right, left).
    pub(crate) barrier: Option<(f64, &'a [[bool; 2]])>,
    /// Mean length of a side.
    pub(crate) mean: f64,
    /// Which stages to go through, in mean edges.
    pub(crate) stages: &'a [f64],
    /// The largest remaining turn.
    pub(crate) tolerance: f64,
    pub(crate) most_steps: usize,
    /// Whether crossings keep their nearest stretches from the first step on.
    pub(crate) settled: bool,
}

impl Task<'_> {
    /// The largest turn that may remain after a stage.
    pub(crate) fn tolerance_of(&self, last: bool) -> f64 {
        if last { self.tolerance } else { COARSE.max(self.tolerance) }
    }
}

/// Sees the crossings after every step, of which so many were moved; says whether to stop.
pub(crate) type Watch<'a> = &'a mut dyn FnMut(&[f64], usize) -> bool;

/// The crossings that are solved for, and the legs between and beside them.
pub(crate) struct Part {
    pub(crate) range: Range<usize>,
    pub(crate) legs: Range<usize>,
    /// Whether that is a whole closed line.
    pub(crate) cyclic: bool,
}

impl Part {
    pub(crate) fn new(layout: &Layout, range: Range<usize>, n: usize) -> Self {
        let cyclic = layout.legs.len() == n && range == (0..n);
        // Of a part of a closed line that ends with its last crossing, the leg after that is the first one: parts stop before.
        let end = if cyclic { range.end } else { (range.end + 1).min(layout.legs.len()) };
        Self { legs: range.start..end, range, cyclic }
    }

    /// The crossings before and after a leg, if they are solved for.
    #[inline]
    pub(crate) fn ends(&self, leg: usize) -> [Option<usize>; 2] {
        let Range { start, end } = self.range;
        let from = if leg > start { Some(leg - 1) } else { self.cyclic.then(|| end - 1) };
        [from, (leg < end).then_some(leg)]
    }

    #[inline]
    pub(crate) fn next(&self, i: usize) -> Option<usize> {
        if i + 1 < self.range.end { Some(i + 1) } else { self.cyclic.then_some(self.range.start) }
    }

    #[inline]
    pub(crate) fn before(&self, i: usize) -> Option<usize> {
        if i > self.range.start { Some(i - 1) } else { self.cyclic.then(|| self.range.end - 1) }
    }
}

/// Slope and curvature of the barrier −reach · ln(x / reach), x the length to an end on the boundary, where that is less than the
/// reach.
pub(crate) fn barrier([right, left]: [bool; 2], t: f64, length: f64, reach: f64) -> (f64, f64) {
    let (mut force, mut stiff) = (0.0, 0.0);
    for (ends, share, sign) in [(right, t, -1.0), (left, 1.0 - t, 1.0)] {
        let x = (share * length).max(1e-9 * length);
        if ends && x < reach {
            // (reach − x)² / x has no jump in its slope at the reach.
            let slope = 1.0 - reach * reach / (x * x);
            force += sign * -slope * length;
            stiff += 2.0 * reach * reach / (x * x * x) * length * length;
        }
    }
    (force, stiff)
}
