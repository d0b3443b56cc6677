//! What is printed and written of smoothed lines.

use std::{
    collections::BTreeMap,
    io::{self, Write},
};

use bevy_surface_splines::smooth::{LineMetrics, Smoothed};

use super::{
    lines::{Kind, Line},
    settings::Setting,
};
use crate::stats::Times;

/// One line and what became of it.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    number: usize,
    kind: Kind,
    boundary: bool,
    mode: &'static str,
    setting: f64,
    ms: f64,
    mean: f64,
    crossings: [usize; 2],
    before: LineMetrics,
    after: LineMetrics,
    counts: [u32; 3],
    /// Whether the line given was kept.
    kept: bool,
    /// Whether the line shrank to a point by some setting: settings are compared by the same lines.
    left_out: bool,
    pub(crate) status: String,
}

impl Case {
    pub(crate) fn new(line: &Line, setting: &Setting, ms: f64, mean: f64) -> Self {
        Self {
            number: line.number,
            kind: line.kind,
            boundary: line.boundary,
            mode: setting.name(),
            setting: setting.number,
            ms,
            mean,
            crossings: [line.line.crossings().len(), 0],
            before: LineMetrics::default(),
            after: LineMetrics::default(),
            counts: [0; 3],
            kept: false,
            left_out: false,
            status: String::new(),
        }
    }

    pub(crate) fn set(&mut self, smoothed: &Smoothed) {
        (self.before, self.after) = (smoothed.before, smoothed.after);
        self.crossings[1] = smoothed.line.crossings().len();
        self.kept = smoothed.kept;
        self.counts = [smoothed.rounds, smoothed.steps, smoothed.flips];
    }

    pub(crate) fn failed(&self) -> bool {
        self.status != "ok" && self.status != "collapsed"
    }

    /// Writes a line of the table; distances in mean edges.
    pub(crate) fn write(&self, out: &mut impl Write, mesh: &str) -> io::Result<()> {
        let Self {
            number,
            kind,
            boundary,
            mode,
            setting,
            ms,
            mean,
            crossings,
            before,
            after,
            counts,
            kept,
            status,
            ..
        } = self;
        let [rounds, steps, flips] = counts;
        writeln!(
            out,
            "\"{mesh}\",{number},{kind:?},{boundary},{mode},{setting},{ms:.4},{},{},{:.9},{:.9},{:.6},{:.6},{:.6},{:.6},\
             {:.6},{:.6},{:.6},{rounds},{steps},{flips},{kept},\"{}\"",
            crossings[0],
            crossings[1],
            before.length,
            after.length,
            before.total_turn,
            after.total_turn,
            before.square_curvature,
            after.square_curvature,
            after.max_distance / mean,
            after.mean_distance / mean,
            after.max_missed / mean,
            status.replace('"', "'")
        )
    }
}

/// Cases by what they are.
#[derive(Debug, Default)]
pub(crate) struct Table {
    cases: Vec<Case>,
}

impl Table {
    pub(crate) fn add(&mut self, case: Case) {
        self.cases.push(case);
    }

    /// Leaves lines out of the comparison that some setting made a point of; for the cases of one mesh.
    pub(crate) fn leave_out(&mut self) {
        let lost: Vec<(Kind, usize)> =
            self.cases.iter().filter(|case| case.status != "ok").map(|case| (case.kind, case.number)).collect();
        self.cases.iter_mut().for_each(|case| case.left_out = lost.contains(&(case.kind, case.number)));
    }

    pub(crate) fn merge(&mut self, other: Self) {
        self.cases.extend(other.cases);
    }

    pub(crate) fn passed(&self) -> usize {
        self.cases.iter().filter(|case| !case.failed()).count()
    }

    pub(crate) fn failed(&self) -> usize {
        self.cases.iter().filter(|case| case.failed()).count()
    }

    pub(crate) fn summary(&self) -> String {
        let ms = Times::new(self.cases.iter().map(|case| case.ms));
        let collapsed = self.cases.iter().filter(|case| case.status == "collapsed").count();
        format!(
            "{} passed, {} failed, {collapsed} of them collapsed; median {:.2}, max {:.2} ms",
            self.passed(),
            self.failed(),
            ms.median().unwrap_or(0.0),
            ms.quantile(1.0).unwrap_or(0.0)
        )
    }

    /// Counts by kind, and for every setting what was gained for what distance.
    pub(crate) fn print(&self) {
        let mut kinds: BTreeMap<(Kind, bool), [usize; 4]> = BTreeMap::new();
        for case in &self.cases {
            let counts = kinds.entry((case.kind, case.boundary)).or_default();
            counts[3] += usize::from(case.kept && !case.failed());
            counts[if case.failed() {
                1
            } else if case.status == "collapsed" {
                2
            } else {
                0
            }] += 1;
        }
        for ((kind, boundary), [passed, failed, collapsed, kept]) in kinds {
            let place = if boundary { "at a boundary" } else { "inside" };
            println!(
                "  {kind:?} lines {place}: {passed} passed ({kept} of them left as they were), {failed} failed, {collapsed} collapsed to a point"
            );
        }
        let mut modes: Vec<(&str, f64)> = self.cases.iter().map(|case| (case.mode, case.setting)).collect();
        modes.dedup();
        let mut seen: Vec<(&str, f64)> = Vec::new();
        modes.retain(|mode| {
            let new = !seen.contains(mode);
            seen.extend(new.then_some(*mode));
            new
        });
        println!(
            "  {:<10} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>8}",
            "jagged", "setting", "square", "turn", "length", "max d", "max d 90%", "mean d", "ms"
        );
        for (mode, setting) in modes {
            let of = |value: &dyn Fn(&Case) -> f64, share: f64| {
                let jagged = |case: &&Case| {
                    (case.mode, case.setting) == (mode, setting) && case.kind != Kind::Trace && !case.left_out
                };
                Times::new(self.cases.iter().filter(jagged).map(value)).quantile(share).unwrap_or(f64::NAN)
            };
            println!(
                "  {mode:<10} {setting:>8} {:>9.5} {:>9.4} {:>9.4} {:>9.3} {:>9.3} {:>9.3} {:>8.3}",
                of(&|c| c.after.square_curvature / c.before.square_curvature, 0.5),
                of(&|c| c.after.total_turn / c.before.total_turn, 0.5),
                of(&|c| c.after.length / c.before.length, 0.5),
                of(&|c| c.after.max_distance / c.mean, 0.5),
                of(&|c| c.after.max_distance / c.mean, 0.9),
                of(&|c| c.after.mean_distance / c.mean, 0.5),
                of(&|c| c.ms, 0.5),
            );
        }
    }
}
