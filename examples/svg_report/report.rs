//! What became of a drawing, in words.

use std::fmt;
use std::path::Path;
use std::time::Instant;

use bevy_surface_splines::vector::{SegmentCounts, SvgReport, read_svg};

use crate::placing::{OnMesh, Stage};

/// What became of a drawing.
pub(crate) struct Outcome {
    pub(crate) name: String,
    pub(crate) import_ms: f64,
    pub(crate) report: Result<SvgReport, String>,
    pub(crate) on_mesh: Option<Result<OnMesh, String>>,
}

impl Outcome {
    /// Reads a drawing, and places it where there is a mesh.
    pub(crate) fn of(file: &Path, stage: Option<&Stage>) -> Self {
        let start = Instant::now();
        let read = read_svg(file);
        let import_ms = start.elapsed().as_secs_f64() * 1e3;
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        match read {
            Ok(import) => {
                let on_mesh = stage.map(|stage| stage.place(&import.drawing));
                Self { name, import_ms, report: Ok(import.report), on_mesh }
            }
            Err(error) => Self { name, import_ms, report: Err(error.to_string()), on_mesh: None },
        }
    }

    /// Whether it was read, every segment is accounted for, and every spline was traced.
    pub(crate) fn passed(&self) -> bool {
        let read = self.report.as_ref().is_ok_and(SvgReport::adds_up);
        let placed = self.on_mesh.as_ref().is_none_or(|on| on.as_ref().is_ok_and(|on| on.untraced == 0));
        read && placed
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {:.1} ms", self.name, self.import_ms)?;
        match &self.report {
            Ok(report) => write_report(f, report)?,
            Err(error) => writeln!(f, "  refused: {error}")?,
        }
        match &self.on_mesh {
            None => Ok(()),
            Some(Err(error)) => writeln!(f, "  not placed: {error}"),
            Some(Ok(on)) => {
                write!(f, "  on the mesh: {} of {} paths, {} segments", on.splines, on.paths, on.segments)?;
                write!(f, ", placed in {:.1} ms, traced in {:.1} ms", on.place_ms, on.trace_ms)?;
                for (count, what) in [
                    (on.dropped, "paths off the surface"),
                    (on.invisible, "paths invisible"),
                    (on.clipped_handles as usize, "handles cut short"),
                    (on.untraced, "splines not traced"),
                ] {
                    if count > 0 {
                        write!(f, ", {count} {what}")?;
                    }
                }
                writeln!(f)?;
                on.first_error.iter().try_for_each(|error| writeln!(f, "    {error}"))
            }
        }
    }
}

fn write_report(f: &mut fmt::Formatter<'_>, report: &SvgReport) -> fmt::Result {
    writeln!(f, "  found    {}", report.found())?;
    let sources =
        [("in paths", report.in_paths), ("made from shapes", report.in_shapes), ("in copies by use", report.in_copies)];
    for (what, counts) in sources.iter().filter(|(_, counts)| counts.total() > 0) {
        writeln!(f, "    {what}: {counts}")?;
    }
    writeln!(f, "  drawn    {}", report.drawn)?;
    writeln!(f, "  left out {}", report.segments_left_out())?;
    // One line for each reason and kind of element, with the place of the first.
    let mut groups: Vec<(String, usize, SegmentCounts, u32)> = Vec::new();
    for left in &report.left_out {
        let what = format!("{}: {}", left.element, left.reason);
        match groups.iter_mut().find(|group| group.0 == what) {
            Some(group) => {
                group.1 += 1;
                group.2 += left.segments;
            }
            None => groups.push((what, 1, left.segments, left.line)),
        }
    }
    for (what, elements, segments, line) in groups {
        writeln!(f, "    {segments} in {elements} {what} (first in line {line})")?;
    }
    if !report.adds_up() {
        writeln!(f, "  THE NUMBERS DO NOT ADD UP")?;
    }
    let mut notes: Vec<(&str, usize)> = Vec::new();
    for note in &report.notes {
        match notes.iter_mut().find(|known| known.0 == note.property) {
            Some(known) => known.1 += 1,
            None => notes.push((note.property, 1)),
        }
    }
    notes.iter().try_for_each(|(property, count)| writeln!(f, "  not applied: {property} of {count} elements"))
}
