//! Counts and times of a group of cases.

use std::fmt;

use bevy_surface_splines::curve::TraceBound;

use crate::{
    outcome::{Outcome, Status, Verdict},
    scheme::NamedScheme,
    stats::Times,
};

/// What a group of cases came to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    times: Vec<f64>,
    pub(crate) passed: usize,
    pub(crate) failed: usize,
    pub(crate) without_path: usize,
    pub(crate) undecided: usize,
    adaptive: Bounds,
    compared: Breaks,
}

/// Adaptive traces that met a bound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Bounds {
    depth: usize,
    pieces: usize,
    length: usize,
    /// Of so many traces.
    of: usize,
}

/// What became of curves by schemes for comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Breaks {
    broken: usize,
    timed_out: usize,
    /// Of so many curves.
    of: usize,
}

impl Tally {
    /// Counts the outcomes of a scheme, or of pairs.
    pub(crate) fn of<'a>(scheme: Option<&NamedScheme>, outcomes: impl IntoIterator<Item = &'a Outcome>) -> Self {
        let mut tally = Self::default();
        for outcome in outcomes {
            tally.count(outcome);
            if outcome.status == Status::NoPath {
                continue;
            }
            tally.adaptive.of += usize::from(scheme.is_some_and(|s| s.most_turn_deg().is_some()));
            tally.compared.of += usize::from(scheme.is_some_and(NamedScheme::is_for_comparison));
        }
        tally
    }

    fn count(&mut self, outcome: &Outcome) {
        match outcome.status.verdict() {
            Verdict::Passed => self.passed += 1,
            Verdict::Failed => self.failed += 1,
            Verdict::Neither => {}
        }
        match outcome.status {
            Status::NoPath => self.without_path += 1,
            Status::Bound(TraceBound::Depth) => self.adaptive.depth += 1,
            Status::Bound(TraceBound::Pieces) => self.adaptive.pieces += 1,
            Status::Bound(TraceBound::Length) => self.adaptive.length += 1,
            Status::Broken => self.compared.broken += 1,
            Status::Slow => self.compared.timed_out += 1,
            _ => {}
        }
        self.undecided += outcome.undecided;
        if outcome.is_timed() {
            self.times.push(outcome.ms);
        }
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.times.extend_from_slice(&other.times);
        self.passed += other.passed;
        self.failed += other.failed;
        self.without_path += other.without_path;
        self.undecided += other.undecided;
        let (bounds, breaks) = (&mut self.adaptive, &mut self.compared);
        bounds.depth += other.adaptive.depth;
        bounds.pieces += other.adaptive.pieces;
        bounds.length += other.adaptive.length;
        bounds.of += other.adaptive.of;
        breaks.broken += other.compared.broken;
        breaks.timed_out += other.compared.timed_out;
        breaks.of += other.compared.of;
    }

    pub(crate) fn total(&self) -> usize {
        self.passed + self.failed + self.without_path + self.compared.timed_out
    }

    /// What there is to say of adaptive traces and of schemes for comparison, in whole lines.
    pub(crate) fn remarks(&self) -> Vec<String> {
        let adaptive = (self.adaptive.of > 0).then(|| format!("of the adaptive traces {}", self.adaptive));
        let compared = (self.compared.of > 0).then(|| format!("of the curves for comparison {}", self.compared));
        [adaptive, compared].into_iter().flatten().collect()
    }
}

fn percent(count: usize, of: usize) -> f64 {
    100.0 * count as f64 / of.max(1) as f64
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let met = self.depth + self.pieces + self.length;
        write!(f, "{met} of {} met a bound ({:.3} %", self.of, percent(met, self.of))?;
        for (count, what) in [(self.depth, "depth"), (self.pieces, "pieces"), (self.length, "length")] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        f.write_str(")")
    }
}

impl fmt::Display for Breaks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { broken, timed_out, of } = *self;
        let shares = [broken, timed_out].map(|count| percent(count, of));
        write!(f, "broken: {broken} of {of} ({:.1} %), timed out: {timed_out} of {of} ({:.1} %)", shares[0], shares[1])
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
        for (count, what) in [(self.without_path, "without a path"), (self.undecided, "places undecided")] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        if self.adaptive.of > 0 {
            write!(f, ", {}", self.adaptive)?;
        }
        if self.compared.of > 0 {
            write!(f, ", {}", self.compared)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{outcome::Job, scheme};

    fn tally(scheme: &str, statuses: &[Status]) -> Tally {
        let ended = |status: &Status| Outcome::new(Job::Curve { case: 0, scheme: 0 }).ended(*status, "");
        let outcomes: Vec<Outcome> = statuses.iter().map(ended).collect();
        Tally::of(scheme::find(scheme).as_ref(), &outcomes)
    }

    #[test]
    fn bounds_and_breaks_are_shares_of_what_could_be_traced() {
        let bound = Status::Bound(TraceBound::Depth);
        let adaptive = tally("olr-adaptive", &[Status::Ok, bound, Status::NoPath, Status::Timeout, Status::Ok]);
        assert_eq!(
            adaptive.to_string(),
            "3 passed, 1 failed, 1 without a path, 1 of 4 met a bound (25.000 %, 1 depth)"
        );
        let compared = tally("rcm", &[Status::Broken, Status::Slow, Status::Ok, Status::Ok]);
        let broken = "broken: 1 of 4 (25.0 %), timed out: 1 of 4 (25.0 %)";
        assert_eq!(compared.to_string(), format!("3 passed, 0 failed, {broken}"));
        let mut all = adaptive;
        all.add(&compared);
        all.add(&tally("rdc", &[Status::Ok]));
        assert_eq!((all.total(), all.passed, all.failed, all.without_path), (10, 7, 1, 1));
        let adaptive = "of the adaptive traces 1 of 4 met a bound (25.000 %, 1 depth)".to_owned();
        assert_eq!(all.remarks(), [adaptive, format!("of the curves for comparison {broken}")]);
    }
}
