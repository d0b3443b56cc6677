//! What is printed.

use std::collections::BTreeMap;

use crate::{
    args::Args,
    clock,
    compare::{self, Comparisons},
    hash::Fnv,
    outcome::{Job, Outcome, Verdict},
    prepare::Prepared,
    reference::Reference,
    scheme::NamedScheme,
    tally::Tally,
};

/// Failed cases named for each mesh.
const NAMED_FAILURES: usize = 10;

/// Prints each mesh as it is done, and sums up.
#[derive(Debug, Default)]
pub(crate) struct Report {
    groups: BTreeMap<String, Tally>,
    comparisons: Comparisons,
    meshes: usize,
    refused: usize,
    /// Meshes named on the command line that were refused.
    pub(crate) refused_by_name: usize,
    slowest_preparation_ms: f64,
    peak_mb: Option<f64>,
    hash: Fnv,
}

impl Report {
    /// A mesh that cannot be used.
    pub(crate) fn refused(&mut self, path: &std::path::Path, reason: &str, named: bool) {
        println!("{}: refused: {reason}", path.display());
        self.refused += 1;
        self.refused_by_name += usize::from(named);
    }

    /// The results of a mesh.
    pub(crate) fn mesh(&mut self, mesh: &Prepared, outcomes: &[Outcome], reference: &Reference, args: &Args) {
        self.meshes += 1;
        self.heading(mesh);
        let mut groups: BTreeMap<String, Vec<&Outcome>> = BTreeMap::new();
        for outcome in outcomes {
            self.hash.word(outcome.hash);
            groups.entry(group_name(outcome.job, &args.schemes).to_owned()).or_default().push(outcome);
        }
        let width = width(groups.keys());
        for (name, outcomes) in groups {
            let scheme = args.schemes.iter().find(|s| s.name == name);
            let tally = Tally::of(scheme, outcomes.iter().copied());
            println!("  {name:<width$} {tally}");
            self.groups.entry(name).or_default().add(&tally);
        }
        for (name, comparison) in compare::compare(reference, &mesh.name, mesh.cases.len(), &args.schemes, outcomes) {
            println!("  {name}: {comparison}");
            self.comparisons.entry(name).or_default().add(&comparison);
        }
        name_failures(outcomes, &args.schemes);
    }

    fn heading(&mut self, mesh: &Prepared) {
        let peak = clock::peak_mb();
        let mb = |mb: Option<f64>| mb.map_or("?".to_owned(), |mb| format!("{mb:.1}"));
        println!("{}: {}", mesh.name, mesh.surface.report());
        println!(
            "  prepared in {:.1} ms, peak memory {} MB until then, {} MB in all (the checker's included)",
            mesh.prepare_ms,
            mb(mesh.prepare_mb),
            mb(peak)
        );
        if mesh.undrawn > 0 {
            println!("  {} random polygons could not be drawn: no four rays hit one sheet from any side", mesh.undrawn);
        }
        self.slowest_preparation_ms = self.slowest_preparation_ms.max(mesh.prepare_ms);
        self.peak_mb = [self.peak_mb, peak].into_iter().flatten().reduce(f64::max);
    }

    /// Sums up; the last line is `N passed, M failed`. Returns all cases' counts.
    pub(crate) fn finish(&self, args: &Args) -> Tally {
        println!("\noverall: {} meshes, {} refused, seed {}", self.meshes, self.refused, args.seed);
        println!(
            "  slowest preparation {:.1} ms, peak memory {} MB",
            self.slowest_preparation_ms,
            self.peak_mb.map_or("?".to_owned(), |mb| format!("{mb:.1}"))
        );
        let mut all = Tally::default();
        let width = width(self.groups.keys());
        for (name, tally) in &self.groups {
            println!("  {name:<width$} {tally}");
            all.add(tally);
        }
        for (name, comparison) in &self.comparisons {
            println!("  {name}: {comparison}");
        }
        if args.hash {
            println!("hash {:016x}", self.hash.0);
        }
        all.remarks().iter().for_each(|remark| println!("{remark}"));
        if all.without_path > 0 {
            println!("{} cases without a path count neither way", all.without_path);
        }
        if all.undecided > 0 {
            println!("{} places on paths could not be decided (one-sided sheets, faces without area)", all.undecided);
        }
        println!("{} passed, {} failed", all.passed, all.failed);
        all
    }
}

/// Room for the longest name.
fn width<'a>(names: impl Iterator<Item = &'a String>) -> usize {
    names.map(String::len).max().unwrap_or(0).max(6)
}

fn group_name(job: Job, schemes: &[NamedScheme]) -> &'static str {
    match job {
        Job::Curve { scheme, .. } => schemes[scheme].name,
        Job::Pair { .. } => "pairs",
    }
}

fn name_failures(outcomes: &[Outcome], schemes: &[NamedScheme]) {
    let failed = || outcomes.iter().filter(|o| o.status.verdict() == Verdict::Failed);
    for outcome in failed().take(NAMED_FAILURES) {
        let (Job::Curve { case, .. } | Job::Pair { case }) = outcome.job;
        let group = group_name(outcome.job, schemes);
        println!("  FAILED {group} {case}: {}: {}", outcome.status, outcome.detail);
    }
    let more = failed().count().saturating_sub(NAMED_FAILURES);
    if more > 0 {
        println!("  … and {more} more");
    }
}
