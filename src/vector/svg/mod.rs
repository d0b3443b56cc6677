//! SVG in and out.
//!
//! [`import_svg`] takes what is geometry: paths and shapes, under all transforms, with groups, nested documents, symbols and `use`, and
//! styles from attributes and style sheets. Its [`SvgReport`] accounts for every segment: those found in paths, made from shapes and
//! copied by `use` are as many as those drawn and those left out, and each of the latter has its element and its reason.
//!
//! The XML is read by `roxmltree`, values (path data, transforms, lengths, colours) by `svgtypes`, style sheets by `simplecss`. The tree
//! is walked here, and not by `usvg` of the same family, because that one drops what it does not draw without a word, turns
//! styles into what a renderer needs, and moves coordinates into 32 bits on the way.
//!
//! | what | what becomes of it |
//! |---|---|
//! | `path`, `rect`, `circle`, `ellipse`, `line`, `polyline`, `polygon` | paths |
//! | lines; quadratic curves; arcs | cubics with handles at thirds; the same curves; pieces of at most 90° |
//! | `g`, `a`, `svg`, `switch`, `use`, `symbol` | their contents, transformed; of a `switch` its first child that applies |
//! | segments whose control points are all in one place | left out: they have no direction |
//! | closings (`z`) | closed paths, with a line where one does not end where it began |
//! | what is defined, hidden, or flattened by its transform | left out |
//! | text, images, foreign objects, animations | left out |
//! | paths without fill and stroke | drawn: they are geometry; see [`Style::is_visible`](super::Style::is_visible) |
//! | linear and radial gradients | paints of their own |
//! | patterns | the fall-back colour of the paint, or none; a note says so |
//! | clip paths, masks, filters, markers, blending | not applied; a note says so |

mod cascade;
mod error;
mod expansion;
mod export;
mod gradients;
mod limits;
mod nesting;
mod path_data;
mod properties;
mod report;
mod shapes;
#[cfg(test)]
mod tests;
mod values;
mod walk;

use std::path::Path;

pub use error::SvgError;
pub use export::export_svg;
pub use limits::SvgLimits;
pub use report::{LeftOut, LeftOutReason, Note, SegmentCounts, SegmentKind, SvgReport};

use super::Drawing;

/// A drawing that was read, with the account of what became of its segments.
#[derive(Clone, Debug, PartialEq)]
pub struct SvgImport {
    /// The drawing, in the units of its view box.
    pub drawing: Drawing,
    /// What was found, drawn and left out.
    pub report: SvgReport,
}

/// Reads an SVG file.
///
/// # Errors
/// As [`import_svg`], and if the file cannot be read.
pub fn read_svg(path: impl AsRef<Path>) -> Result<SvgImport, SvgError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| SvgError::Io { path: path.to_owned(), source })?;
    import_svg(&bytes)
}

/// Reads the text of an SVG drawing, UTF-8, plain.
///
/// Cost: about 10 ms a megabyte.
///
/// # Errors
/// [`SvgError`] if it is no XML or no SVG, or passes one of the [`SvgLimits`].
///
/// ```
/// use bevy_surface_splines::vector::import_svg;
///
/// let text = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"><path d="M 1 1 H 9 V 9 z"/><text>!</text></svg>"#;
/// let import = import_svg(text.as_bytes())?;
/// assert_eq!(import.drawing.segment_count(), 3);
/// assert_eq!(import.report.left_out[0].to_string(), "line 1, text: text has no outlines here: convert it to paths");
/// # Ok::<(), bevy_surface_splines::vector::SvgError>(())
/// ```
pub fn import_svg(bytes: &[u8]) -> Result<SvgImport, SvgError> {
    import_svg_within(bytes, &SvgLimits::default())
}

/// [`import_svg`] with limits of one's own.
///
/// # Errors
/// As [`import_svg`].
pub fn import_svg_within(bytes: &[u8], limits: &SvgLimits) -> Result<SvgImport, SvgError> {
    if bytes.len() > limits.bytes {
        return Err(SvgError::TooLong { bytes: bytes.len(), limit: limits.bytes });
    }
    let text = std::str::from_utf8(bytes).map_err(|error| SvgError::NotText { byte: error.valid_up_to() })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    nesting::check(text, limits)?;
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options)
        .map_err(|error| SvgError::Xml { line: error.pos().row, what: error.to_string() })?;
    expansion::check(&document, limits)?;
    walk::import(&document, limits)
}
