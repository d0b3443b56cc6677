//! Why a document cannot be read, written or restored.

use std::path::PathBuf;

use super::Document;
use crate::curve::EditError;
use crate::format::save::SaveError;
use crate::geodesic::PathError;
use crate::smooth::PolylineError;
use crate::surface::PointError;

/// Why a document cannot be read, written or restored.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DocumentError {
    /// The file cannot be read.
    #[error("{}: {source}: check that the file exists and can be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file cannot be written; the old one is as it was.
    #[error(transparent)]
    Save(#[from] SaveError),
    /// The document is too large.
    #[error("the document has more than {limit} bytes: share its splines among several documents")]
    TooLarge {
        /// How many there may be.
        limit: u64,
    },
    /// There is no version number where a document has one.
    #[error("line {line}, column {column}: a document begins with `(version: 1,`: open a file of splines")]
    NoDocument {
        /// Counted from one.
        line: usize,
        /// Counted from one, in characters.
        column: usize,
    },
    /// A newer program wrote it.
    #[error(
        "the document has version {found}, and this program knows versions up to {}: open it with a newer program",
        Document::VERSION
    )]
    NewerVersion {
        /// The version of the document.
        found: u64,
    },
    /// The text breaks the format, or a value is out of its range.
    #[error("line {line}, column {column}, in {field}: {problem}: correct it, or open an earlier copy")]
    Content {
        /// Counted from one.
        line: usize,
        /// Counted from one, in characters.
        column: usize,
        /// The field, such as `splines[2].anchors[0].point`.
        field: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A spline does not lie on the surface as it says.
    #[error(
        "spline {index} (`{name}`), {part}: {fault}: correct it, or place the document anew by the positions that it holds"
    )]
    Spline {
        /// Which one, counted from zero.
        index: usize,
        /// Its name.
        name: String,
        /// The part of it.
        part: String,
        /// What is wrong with it.
        fault: Box<SplineFault>,
    },
    /// A line does not lie on the surface as it says.
    #[error("line {index} (`{name}`): {fault}: correct it, or place the document anew by the positions that it holds")]
    Line {
        /// Which one, counted from zero.
        index: usize,
        /// Its name.
        name: String,
        /// What is wrong with it.
        fault: Box<PolylineError>,
    },
}

/// What is wrong with a spline that is to be restored.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SplineFault {
    /// A point or a leg does not fit the surface.
    #[error(transparent)]
    Point(#[from] PointError),
    /// The leg's length is another.
    #[error("the leg is {measured} long, and not {stored}")]
    Length {
        /// As the document says.
        stored: f64,
        /// As measured on the surface.
        measured: f64,
    },
    /// The leg does not join what it is to join.
    #[error("the leg does not join its handles")]
    Ends,
    /// The parts do not make a spline.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// What the document leaves out cannot be searched.
    #[error(transparent)]
    Path(#[from] PathError),
}
