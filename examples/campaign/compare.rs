//! Our results beside the recorded ones.

use std::{collections::BTreeMap, fmt};

use crate::{
    outcome::{Job, Outcome, Status, Verdict},
    reference::Reference,
    scheme::NamedScheme,
    stats::Times,
};

/// Our times and the recorded ones, for the same cases.
#[derive(Clone, Debug, Default)]
pub(crate) struct Comparison {
    ours: Vec<f64>,
    recorded: Vec<f64>,
    /// For paths: length over exact distance; for curves: length over recorded length.
    ratios: Vec<f64>,
    /// Whether the ratios are those of paths.
    exact: bool,
}

/// Comparisons by what is compared, as `rdc random` or `pairs local`.
pub(crate) type Comparisons = BTreeMap<String, Comparison>;

/// Compares the cases that have a record and came to an end. Curves are compared by the time for their points alone, which
/// is what was recorded.
pub(crate) fn compare(
    reference: &Reference,
    mesh: &str,
    recorded_cases: usize,
    schemes: &[NamedScheme],
    outcomes: &[Outcome],
) -> Comparisons {
    let mut found = Comparisons::new();
    let ended = |o: &&Outcome| o.status.verdict() == Verdict::Passed || o.status == Status::Undercut;
    for outcome in outcomes.iter().filter(ended) {
        match outcome.job {
            Job::Curve { case, scheme } if case < recorded_cases => {
                let Some(record) = reference.curve(mesh, case, &schemes[scheme]) else { continue };
                let group = found.entry(format!("{} {}", schemes[scheme].name, record.kind)).or_default();
                group.ours.push(outcome.ms_points);
                group.recorded.push(record.ms);
                group.ratios.push(outcome.length / record.length);
            }
            Job::Curve { .. } => {}
            Job::Pair { case } => {
                let Some(record) = reference.pair(mesh, case) else { continue };
                let group = found.entry(format!("pairs {}", record.kind)).or_default();
                group.exact = true;
                group.ours.push(outcome.ms);
                group.recorded.push(record.us * 1e-3);
                group.ratios.extend(record.exact.map(|exact| outcome.length / exact));
            }
        }
    }
    found
}

impl Comparison {
    pub(crate) fn add(&mut self, other: &Self) {
        self.ours.extend_from_slice(&other.ours);
        self.recorded.extend_from_slice(&other.recorded);
        self.ratios.extend_from_slice(&other.ratios);
        self.exact |= other.exact;
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let median = |times: &[f64]| Times::new(times.iter().copied()).median().unwrap_or(f64::NAN);
        let (ours, recorded) = (median(&self.ours), median(&self.recorded));
        let quotients = Times::new(self.ours.iter().zip(&self.recorded).map(|(a, b)| a / b));
        write!(
            f,
            "{} cases, median {ours:.4} ms, recorded {recorded:.4} ms: {:.3} (case by case {:.3})",
            self.ours.len(),
            ours / recorded,
            quotients.median().unwrap_or(f64::NAN)
        )?;
        let n = self.ratios.len();
        let percent = |count: usize| 100.0 * count as f64 / n.max(1) as f64;
        let above = |bound: f64| percent(self.ratios.iter().filter(|r| **r > 1.0 + bound).count());
        if self.exact && n > 0 {
            let worst = self.ratios.iter().copied().fold(1.0, f64::max);
            write!(
                f,
                "; of {n} with exact distances {:.1} % are above by 0.1 %, {:.1} % by 1 %, the worst by {:.3} %",
                above(1e-3),
                above(1e-2),
                100.0 * (worst - 1.0)
            )?;
        } else if n > 0 {
            let below = percent(self.ratios.iter().filter(|r| **r < 0.99).count());
            write!(f, "; {:.1} % longer and {below:.1} % shorter than recorded by 1 %", above(1e-2))?;
        }
        Ok(())
    }
}
