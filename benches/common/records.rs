//! What was recorded of the paper's own program: times and lengths of paths and curves, exact distances.

use std::{collections::HashMap, fs, path::Path};

/// A recorded curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurveRecord {
    /// For the points alone.
    pub(crate) ms: f64,
    pub(crate) length: f64,
}

/// A recorded path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairRecord {
    pub(crate) us: f64,
    pub(crate) length: f64,
    pub(crate) exact: Option<f64>,
}

/// Preparation as recorded: adjacency and search graph alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparationRecord {
    pub(crate) ms: f64,
    pub(crate) peak_mb: f64,
}

/// All records of a folder; empty where it has none.
#[derive(Debug, Default)]
pub(crate) struct Records {
    curves: HashMap<(String, usize, String), CurveRecord>,
    pairs: HashMap<(String, usize), PairRecord>,
    preparations: HashMap<String, PreparationRecord>,
}

impl Records {
    pub(crate) fn read(folder: &Path) -> Self {
        let text = |name: &str| fs::read_to_string(folder.join(name)).unwrap_or_default();
        let mut found = Self::default();
        for row in rows(&text("curves.csv")) {
            if let [mesh, case, _, scheme, ms, length, "ok", ..] = row[..]
                && let (Ok(case), Ok(ms), Ok(length)) = (case.parse(), ms.parse(), length.parse())
            {
                found.curves.insert((mesh.into(), case, scheme.into()), CurveRecord { ms, length });
            }
        }
        for row in rows(&text("pairs.csv")) {
            if let [mesh, pair, _, us, length, _, exact, ..] = row[..]
                && let (Ok(pair), Ok(us), Ok(length)) = (pair.parse(), us.parse(), length.parse())
            {
                found.pairs.insert((mesh.into(), pair), PairRecord { us, length, exact: exact.parse().ok() });
            }
        }
        for row in rows(&text("meshes.csv")) {
            if let [mesh, _, _, ms, peak, ..] = row[..]
                && let (Ok(ms), Ok(peak_mb)) = (ms.parse(), peak.parse())
            {
                found.preparations.insert(mesh.into(), PreparationRecord { ms, peak_mb });
            }
        }
        found
    }

    /// A curve by its scheme's recorded name: `rdc_uniform4`, `olr_uniform6`.
    pub(crate) fn curve(&self, mesh: &str, case: usize, scheme: &str) -> Option<CurveRecord> {
        self.curves.get(&(mesh.to_owned(), case, scheme.to_owned())).copied()
    }

    pub(crate) fn pair(&self, mesh: &str, pair: usize) -> Option<PairRecord> {
        self.pairs.get(&(mesh.to_owned(), pair)).copied()
    }

    pub(crate) fn preparation(&self, mesh: &str) -> Option<PreparationRecord> {
        self.preparations.get(mesh).copied()
    }
}

fn rows(text: &str) -> impl Iterator<Item = Vec<&str>> {
    text.lines().skip(1).map(|line| line.split(',').map(str::trim).collect())
}
