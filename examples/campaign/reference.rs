//! Recorded results to compare with.

use std::{
    collections::HashMap,
    fs, io,
    path::{Path, PathBuf},
};

use crate::{
    args::Args,
    outcome::{Job, Outcome, Status},
    scheme::NamedScheme,
};

/// An exact distance may be undercut by this share: recorded positions are 32-bit floats.
const UNDERCUT: f64 = 1e-5;

/// A recorded curve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CurveRecord {
    /// Random or local.
    pub(crate) kind: String,
    /// Milliseconds for the points alone.
    pub(crate) ms: f64,
    pub(crate) length: f64,
}

/// A recorded path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PairRecord {
    pub(crate) kind: String,
    pub(crate) us: f64,
    /// The exact distance, where it is known.
    pub(crate) exact: Option<f64>,
}

/// What was recorded, by mesh, case and scheme.
#[derive(Debug, Default)]
pub(crate) struct Reference {
    curves: HashMap<(String, usize, String), CurveRecord>,
    pairs: HashMap<(String, usize), PairRecord>,
}

impl Reference {
    /// Finds and reads what there is: the folder given, or the one that holds the folder of cases or pairs. A folder without
    /// records gives none.
    ///
    /// # Errors
    /// Whatever keeps a folder that was asked for from being read.
    pub(crate) fn find(args: &Args) -> io::Result<Self> {
        if let Some(folder) = &args.reference {
            let found = Self::read(folder)?;
            if found.is_empty() {
                let message = format!("{}: neither curves.csv nor pairs.csv has any records", folder.display());
                return Err(io::Error::new(io::ErrorKind::NotFound, message));
            }
            return Ok(found);
        }
        let beside = |cases: &PathBuf| cases.is_dir().then(|| cases.join("..")).filter(|f| f.is_dir());
        match [&args.cases, &args.pairs].into_iter().flatten().find_map(beside) {
            Some(folder) => Self::read(&folder),
            None => Ok(Self::default()),
        }
    }

    fn read(folder: &Path) -> io::Result<Self> {
        let text = |name: &str| match fs::read_to_string(folder.join(name)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(String::new()),
            read => read,
        };
        Ok(Self::parse(&text("curves.csv")?, &text("pairs.csv")?))
    }

    fn parse(curves: &str, pairs: &str) -> Self {
        let mut found = Self::default();
        for row in rows(curves) {
            let record = || {
                let key = (row.get("mesh")?.clone(), row.get("case")?.parse().ok()?, row.get("scheme")?.clone());
                let kind = row.get("kind").cloned().unwrap_or_default();
                let (ms, length) = (row.get("ms")?.parse().ok()?, row.get("length")?.parse().ok()?);
                Some((key, CurveRecord { kind, ms, length }))
            };
            found.curves.extend(record());
        }
        for row in rows(pairs) {
            let record = || {
                let key = (row.get("mesh")?.clone(), row.get("pair")?.parse().ok()?);
                let kind = row.get("kind").cloned().unwrap_or_default();
                let exact = row.get("exact").and_then(|e| e.parse().ok());
                Some((key, PairRecord { kind, us: row.get("us")?.parse().ok()?, exact }))
            };
            found.pairs.extend(record());
        }
        found
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.curves.is_empty() && self.pairs.is_empty()
    }

    /// What was recorded for a curve.
    pub(crate) fn curve(&self, mesh: &str, case: usize, scheme: &NamedScheme) -> Option<&CurveRecord> {
        self.curves.get(&(mesh.to_owned(), case, scheme.recorded?.to_owned()))
    }

    /// What was recorded for a pair.
    pub(crate) fn pair(&self, mesh: &str, case: usize) -> Option<&PairRecord> {
        self.pairs.get(&(mesh.to_owned(), case))
    }

    /// Fails the paths that are shorter than the exact distance.
    pub(crate) fn fail_undercuts(&self, mesh: &str, outcomes: &mut [Outcome]) {
        for outcome in outcomes.iter_mut().filter(|o| o.status == Status::Ok) {
            let Job::Pair { case } = outcome.job else { continue };
            let Some(exact) = self.pair(mesh, case).and_then(|p| p.exact) else { continue };
            if outcome.length < exact * (1.0 - UNDERCUT) {
                outcome.status = Status::Undercut;
                outcome.detail = format!("length {} is below the exact distance {exact}", outcome.length);
            }
        }
    }
}

/// The lines of a table, each by the names of its columns.
fn rows(text: &str) -> impl Iterator<Item = HashMap<&str, String>> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').map(str::trim).collect();
    lines.map(move |line| names.iter().copied().zip(line.split(',').map(|f| f.trim().to_owned())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme;

    #[test]
    fn records_are_found_and_gaps_are_skipped() {
        let curves = "mesh,case,kind,scheme,ms,length,status\nspot,0,random,rdc_uniform4,1.5,2.25,ok\n\
                      spot,1,random,rdc_uniform4,,,signal6\n";
        let pairs =
            "mesh,pair,kind,us,length,locally_shortest,exact\nspot,0,local,376,1.7,0,1.69\nspot,1,local,5,1,1,\n";
        let reference = Reference::parse(curves, pairs);
        assert_eq!(reference.curve("spot", 0, &scheme::ALL[0]).map(|c| (c.ms, c.length)), Some((1.5, 2.25)));
        assert_eq!(reference.curve("spot", 1, &scheme::ALL[0]), None);
        assert_eq!(reference.pair("spot", 0).and_then(|p| p.exact), Some(1.69));
        assert_eq!(reference.pair("spot", 1).map(|p| p.exact), Some(None));
    }

    #[test]
    fn only_undercuts_beyond_rounding_fail() {
        let reference = Reference::parse("", "mesh,pair,us,exact\nm,0,1,1.0\nm,1,1,1.0\n");
        let outcome = |case: usize, length: f64| Outcome { length, ..Outcome::new(Job::Pair { case }) };
        let mut outcomes = [outcome(0, 0.999_995), outcome(1, 0.999_98)];
        reference.fail_undercuts("m", &mut outcomes);
        assert_eq!(outcomes.map(|o| o.status), [Status::Ok, Status::Undercut]);
    }
}
