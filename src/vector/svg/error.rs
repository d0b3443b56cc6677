//! Why a drawing could not be read.

use std::path::PathBuf;

/// Why a drawing could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SvgError {
    /// The file could not be read.
    #[error("{}: {source}: check that the file exists and can be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is no text.
    #[error("SVG, byte {byte}: this is no UTF-8 text: unpack it if it is an SVGZ, else save it as plain SVG")]
    NotText {
        /// The first byte that is none of a text.
        byte: usize,
    },
    /// The XML does not parse.
    #[error("SVG, line {line}: the XML does not parse ({what}): correct or export it again")]
    Xml {
        /// Which line, from one.
        line: u32,
        /// What the parser says.
        what: String,
    },
    /// The root is another element than `svg`.
    #[error("this is no SVG: its root is `{root}` and should be `svg`")]
    NotSvg {
        /// The root's name.
        root: String,
    },
    /// The text is too long.
    #[error("the drawing has {bytes} bytes, and the limit is {limit}: take pictures and what is unused out of it")]
    TooLong {
        /// How long it is.
        bytes: usize,
        /// How long it may be.
        limit: usize,
    },
    /// Elements lie in each other too deeply.
    #[error("SVG, line {line}: elements lie in each other more than {limit} deep: take groups apart")]
    TooDeep {
        /// Which line, from one.
        line: u32,
        /// How deep they may.
        limit: u32,
    },
    /// There are too many elements, copies by `use` included.
    #[error("SVG: with the copies that `use` makes there are more than {limit} elements: use fewer copies")]
    TooManyElements {
        /// How many there may be.
        limit: u32,
    },
    /// There are too many segments, copies by `use` included.
    #[error("SVG: there are more than {limit} segments to draw: simplify the drawing or use fewer copies")]
    TooManySegments {
        /// How many there may be.
        limit: u32,
    },
    /// An element has too many attributes, or the document too many namespaces.
    #[error(
        "SVG, line {line}: there are too many attributes or namespaces (more than {limit}): no drawing needs so many"
    )]
    TooManyAttributes {
        /// Which line, from one.
        line: u32,
        /// How many there may be.
        limit: usize,
    },
    /// Entities of the document type are more than abbreviations.
    #[error("SVG, line {line}: the entity `{name}` {what}: write out what it stands for")]
    Entity {
        /// Which line, from one.
        line: u32,
        /// The entity.
        name: String,
        /// What is wrong with it.
        what: &'static str,
    },
    /// The style sheet asks for too much work.
    #[error("SVG: its style sheet needs more than {limit} comparisons: use fewer or simpler selectors")]
    TooManyRules {
        /// How many comparisons there may be.
        limit: u64,
    },
}
