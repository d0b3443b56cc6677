//! Results as tables.

use std::{
    fs::File,
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

use crate::{
    outcome::{Job, Outcome},
    scheme::NamedScheme,
};

const CURVES: &str = "mesh,case,scheme,ms,ms_points,points,length,max_turn_deg,status";
const PAIRS: &str = "mesh,case,us,length,status";

/// Writes one line a case; curves and pairs to separate files where there are both.
pub(crate) struct CsvWriter {
    curves: Option<BufWriter<File>>,
    pairs: Option<BufWriter<File>>,
}

impl CsvWriter {
    /// Makes the files and writes their headings. With curves and pairs, `results.csv` has the curves and
    /// `results.pairs.csv` the pairs.
    pub(crate) fn new(path: &Path, curves: bool, pairs: bool) -> io::Result<Self> {
        let make = |path: &Path, heading: &str| {
            let mut file = BufWriter::new(File::create(path)?);
            writeln!(file, "{heading}")?;
            Ok::<_, io::Error>(file)
        };
        let beside = if curves { with_pairs(path) } else { path.to_owned() };
        Ok(Self {
            curves: curves.then(|| make(path, CURVES)).transpose()?,
            pairs: pairs.then(|| make(&beside, PAIRS)).transpose()?,
        })
    }

    /// Writes the results of a mesh, and sees that they are on disk.
    pub(crate) fn write(&mut self, mesh: &str, schemes: &[NamedScheme], outcomes: &[Outcome]) -> io::Result<()> {
        let mesh = field(mesh);
        for o in outcomes {
            match (o.job, &mut self.curves, &mut self.pairs) {
                (Job::Curve { case, scheme }, Some(file), _) => {
                    let Outcome { ms, ms_points, points, length, max_turn_deg, status, .. } = o;
                    let scheme = schemes[scheme].name;
                    writeln!(
                        file,
                        "{mesh},{case},{scheme},{ms:.5},{ms_points:.5},{points},{length},{max_turn_deg:.4},{status}"
                    )?;
                }
                (Job::Pair { case }, _, Some(file)) => {
                    writeln!(file, "{mesh},{case},{:.3},{},{}", o.ms * 1e3, o.length, o.status)?;
                }
                _ => {}
            }
        }
        [&mut self.curves, &mut self.pairs].into_iter().flatten().try_for_each(Write::flush)
    }
}

fn with_pairs(path: &Path) -> PathBuf {
    match path.extension() {
        Some(ending) => path.with_extension(format!("pairs.{}", ending.to_string_lossy())),
        None => path.with_extension("pairs"),
    }
}

/// Quotes a name where a comma, a quote or a line end asks for it.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_quoted_where_needed() {
        assert_eq!(field("a b"), "a b");
        assert_eq!(field("a,\"b\""), "\"a,\"\"b\"\"\"");
        assert_eq!(with_pairs(Path::new("x/r.csv")), Path::new("x/r.pairs.csv"));
    }
}
