//! What was measured, in words and as a table.

use std::fmt;
use std::fs::File;
use std::io::{BufWriter, Result, Write};
use std::path::Path;

use bevy_surface_splines::skin::JoinKind;

use crate::measure::{ENERGIES, Measured};

/// A drawing, and what was measured or why it could not be.
pub(crate) struct Outcome {
    name: String,
    measured: std::result::Result<Measured, String>,
}

impl Outcome {
    pub(crate) fn of(file: &Path, handles: usize, poses: usize) -> Self {
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        Self { name, measured: Measured::of(file, handles, poses) }
    }

    pub(crate) fn passed(&self) -> bool {
        self.measured.as_ref().is_ok_and(|measured| measured.failures.is_empty())
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let m = match &self.measured {
            Ok(measured) => measured,
            Err(error) => return writeln!(f, "{}: {error}", self.name),
        };
        write!(f, "{}: {} curves in {} chains; joins:", self.name, m.curves, m.chains)?;
        for (kind, count) in JoinKind::ALL.iter().zip(m.joins).filter(|(_, count)| *count > 0) {
            write!(f, " {count} {}", kind.name())?;
        }
        write!(f, "\n  bound in {:.1} ms, a pose {:.1} µs, flexible {:.2} ms", m.bind_ms, m.pose_us, m.flexible_ms)?;
        writeln!(f, "; joins missed by {:.1e}, single precision by {:.1e}", m.violation, m.single)?;
        write!(f, "  energy:")?;
        for (name, energy) in ENERGIES.iter().zip(m.energies) {
            write!(f, " {name} {energy:.3e};")?;
        }
        writeln!(f)?;
        m.failures.iter().take(5).try_for_each(|failure| writeln!(f, "  FAILED: {failure}"))
    }
}

/// Writes outcomes as lines of a table.
pub(crate) struct CsvWriter(BufWriter<File>);

impl CsvWriter {
    pub(crate) fn new(path: &Path) -> Result<Self> {
        let mut out = BufWriter::new(File::create(path)?);
        write!(out, "drawing,passed,curves,chains")?;
        JoinKind::ALL.iter().try_for_each(|kind| write!(out, ",{}", kind.name()))?;
        write!(out, ",bind_ms,pose_us,flexible_ms,violation,single")?;
        ENERGIES.iter().try_for_each(|name| write!(out, ",energy_{}", name.replace(' ', "_")))?;
        writeln!(out, ",error")?;
        Ok(Self(out))
    }

    pub(crate) fn write(&mut self, outcome: &Outcome) -> Result<()> {
        let nothing = Measured::default();
        let m = outcome.measured.as_ref().unwrap_or(&nothing);
        let out = &mut self.0;
        write!(out, "{},{},{},{}", quoted(&outcome.name), outcome.passed(), m.curves, m.chains)?;
        m.joins.iter().try_for_each(|count| write!(out, ",{count}"))?;
        write!(out, ",{:.3},{:.2},{:.3},{:e},{:e}", m.bind_ms, m.pose_us, m.flexible_ms, m.violation, m.single)?;
        m.energies.iter().try_for_each(|energy| write!(out, ",{energy:e}"))?;
        let error = outcome.measured.as_ref().err().or(m.failures.first());
        writeln!(out, ",{}", quoted(error.map_or("", String::as_str)))?;
        out.flush()
    }
}

/// A field that may hold commas and quotes.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
