//! Counts and times of a group of cases.

use std::fmt;

use crate::{
    outcome::{Outcome, Verdict},
    stats::Times,
};

/// What a group of cases came to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    times: Vec<f64>,
    pub(crate) passed: usize,
    pub(crate) failed: usize,
    pub(crate) neither: usize,
    pub(crate) undecided: usize,
}

impl Tally {
    pub(crate) fn of<'a>(outcomes: impl IntoIterator<Item = &'a Outcome>) -> Self {
        let mut tally = Self::default();
        for outcome in outcomes {
            match outcome.status.verdict() {
                Verdict::Passed => tally.passed += 1,
                Verdict::Failed => tally.failed += 1,
                Verdict::Neither => tally.neither += 1,
            }
            tally.undecided += outcome.undecided;
            if outcome.is_timed() {
                tally.times.push(outcome.ms);
            }
        }
        tally
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.times.extend_from_slice(&other.times);
        self.passed += other.passed;
        self.failed += other.failed;
        self.neither += other.neither;
        self.undecided += other.undecided;
    }

    pub(crate) fn total(&self) -> usize {
        self.passed + self.failed + self.neither
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let times = Times::new(self.times.iter().copied());
        if !times.is_empty() {
            write!(f, "< 1 ms {:5.1} %   < 100 ms {:5.1} %   ", times.percent_below(1.0), times.percent_below(100.0))?;
            let ms = |time: Option<f64>| time.unwrap_or(0.0);
            write!(
                f,
                "median {:.3}   90 % {:.3}   99 % {:.3}   max {:.3} ms   ",
                ms(times.median()),
                ms(times.quantile(0.9)),
                ms(times.quantile(0.99)),
                ms(times.quantile(1.0))
            )?;
        }
        write!(f, "{} passed, {} failed", self.passed, self.failed)?;
        for (count, what) in [(self.neither, "without a path"), (self.undecided, "places undecided")] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        Ok(())
    }
}
