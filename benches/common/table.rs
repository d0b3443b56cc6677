//! Results as Markdown.

use super::stats::Times;

/// A table that is printed row by row, so that a long run shows what it has.
pub(crate) struct Table {
    columns: usize,
}

impl Table {
    /// Prints the headings.
    pub(crate) fn new(headings: &[&str]) -> Self {
        println!();
        println!("| {} |", headings.join(" | "));
        println!("|{}", "---|".repeat(headings.len()));
        Self { columns: headings.len() }
    }

    pub(crate) fn row(&self, cells: impl IntoIterator<Item = String>) {
        let cells: Vec<String> = cells.into_iter().collect();
        assert_eq!(cells.len(), self.columns, "a row has a cell for each heading");
        println!("| {} |", cells.join(" | "));
    }
}

/// Three digits that count, and a dash for what is not known.
pub(crate) fn number(value: Option<f64>) -> String {
    match value {
        None => "–".into(),
        Some(value) if !value.is_finite() => "–".into(),
        Some(value) if value.abs() >= 100.0 => format!("{value:.0}"),
        Some(value) if value.abs() >= 10.0 => format!("{value:.1}"),
        Some(value) if value.abs() >= 1.0 => format!("{value:.2}"),
        Some(value) => format!("{value:.3}"),
    }
}

/// How many times `ours` goes into `theirs`, by medians.
pub(crate) fn ratio(theirs: &Times, ours: &Times) -> String {
    number(theirs.median().zip(ours.median()).map(|(theirs, ours)| theirs / ours))
}

/// The baseline counts as it ran where its times are so near the recorded ones.
const LIKE_RECORDED: std::ops::RangeInclusive<f64> = 0.7..=1.3;

/// The baseline's time over ours, as it ran. Where it is not like the recorded program on the same cases, also what it
/// comes to when its times are brought to the recorded ones.
pub(crate) fn against_baseline(baseline: &Times, recorded: &Times, ours: &Times) -> String {
    let as_it_ran = ratio(baseline, ours);
    match baseline.median().zip(recorded.median()) {
        Some((baseline, recorded)) if !LIKE_RECORDED.contains(&(baseline / recorded)) => {
            format!("{as_it_ran} (scaled {})", number(ours.median().map(|ours| recorded / ours)))
        }
        _ => as_it_ran,
    }
}

/// A part of a count in per cent.
pub(crate) fn share(part: usize, count: usize) -> String {
    if count == 0 { "–".into() } else { format!("{:.2} %", 100.0 * part as f64 / count as f64) }
}
