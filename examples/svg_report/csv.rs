//! Results as a table.

use std::fs::File;
use std::io::{BufWriter, Result, Write};
use std::path::Path;

use bevy_surface_splines::vector::{SegmentCounts, SegmentKind, SvgReport};

use crate::report::Outcome;

pub(crate) struct CsvWriter(BufWriter<File>);

impl CsvWriter {
    pub(crate) fn new(path: &Path) -> Result<Self> {
        let mut out = BufWriter::new(File::create(path)?);
        write!(out, "drawing,passed,import_ms,in_paths,in_shapes,in_copies")?;
        for group in ["found", "drawn", "left_out"] {
            for kind in SegmentKind::ALL {
                write!(out, ",{group}_{}", kind.name())?;
            }
        }
        writeln!(out, ",splines,segments,paths_dropped,place_ms,trace_ms,error")?;
        Ok(Self(out))
    }

    pub(crate) fn write(&mut self, outcome: &Outcome) -> Result<()> {
        let empty = SvgReport::default();
        let report = outcome.report.as_ref().unwrap_or(&empty);
        let out = &mut self.0;
        write!(out, "{},{},{:.3}", quoted(&outcome.name), outcome.passed(), outcome.import_ms)?;
        let sources = [&report.in_paths, &report.in_shapes, &report.in_copies].map(SegmentCounts::total);
        write!(out, ",{},{},{}", sources[0], sources[1], sources[2])?;
        for counts in [report.found(), report.drawn, report.segments_left_out()] {
            for kind in SegmentKind::ALL {
                write!(out, ",{}", counts[kind])?;
            }
        }
        match &outcome.on_mesh {
            Some(Ok(on)) => {
                let (place, trace) = (on.place_ms, on.trace_ms);
                write!(out, ",{},{},{},{place:.3},{trace:.3}", on.splines, on.segments, on.dropped)?;
            }
            _ => write!(out, ",,,,,")?,
        }
        let placing = outcome.on_mesh.as_ref().and_then(|on| match on {
            Ok(on) => on.first_error.as_ref(),
            Err(error) => Some(error),
        });
        let error = outcome.report.as_ref().err().or(placing);
        writeln!(out, ",{}", quoted(error.map_or("", String::as_str)))?;
        out.flush()
    }
}

/// A field that may hold commas and quotes.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
