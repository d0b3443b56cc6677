//! What became of every segment of a drawing.

use std::fmt;
use std::ops::{AddAssign, Index, IndexMut};

/// What a segment is in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SegmentKind {
    /// A line: `l`, `h`, `v`, a side of a shape.
    Line,
    /// A quadratic curve: `q`, `t`.
    Quadratic,
    /// A cubic curve: `c`, `s`.
    Cubic,
    /// An elliptical arc: `a`, a quarter of a circle or an ellipse, a round corner.
    Arc,
    /// A closing: `z`, drawn as a line where the path does not end where it began.
    Closing,
}

impl SegmentKind {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Line, Self::Quadratic, Self::Cubic, Self::Arc, Self::Closing];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Quadratic => "quadratic",
            Self::Cubic => "cubic",
            Self::Arc => "arc",
            Self::Closing => "closing",
        }
    }
}

/// How many segments there are of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SegmentCounts([u64; 5]);

impl SegmentCounts {
    /// Of all kinds together.
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }
}

impl Index<SegmentKind> for SegmentCounts {
    type Output = u64;

    fn index(&self, kind: SegmentKind) -> &u64 {
        &self.0[kind as usize]
    }
}

impl IndexMut<SegmentKind> for SegmentCounts {
    fn index_mut(&mut self, kind: SegmentKind) -> &mut u64 {
        &mut self.0[kind as usize]
    }
}

impl AddAssign for SegmentCounts {
    fn add_assign(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(own, more)| *own += more);
    }
}

impl fmt::Display for SegmentCounts {
    /// `12 (10 line, 2 arc)`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.total())?;
        let kinds = SegmentKind::ALL.into_iter().filter(|kind| self[*kind] > 0);
        for (i, kind) in kinds.enumerate() {
            write!(f, "{}{} {}", if i == 0 { " (" } else { ", " }, self[kind], kind.name())?;
        }
        if self.total() > 0 { f.write_str(")") } else { Ok(()) }
    }
}

/// Why something is not in the drawing.
#[derive(Clone, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum LeftOutReason {
    /// All control points of the segments are in one place.
    #[error("no length, and so no direction")]
    NoLength,
    /// A closing without a segment before it.
    #[error("there is no path here to close")]
    NothingToClose,
    /// A shape without width, height or radius, which SVG does not draw.
    #[error("the shape has no extent, so SVG does not draw it")]
    NoExtent,
    /// It stands in `defs`, a `symbol`, or another element whose contents are drawn only where something refers to them.
    #[error("only defined here, inside `{0}`; drawn where it is used")]
    Defined(&'static str),
    /// `display: none`.
    #[error("hidden: display is none")]
    NotDisplayed,
    /// `visibility: hidden` or `collapse`.
    #[error("hidden: visibility is not visible")]
    NotVisible,
    /// Another child of the same `switch` was chosen.
    #[error("another branch of the `switch` applies")]
    NotChosen,
    /// The transform has no inverse, or is not finite.
    #[error("its transform flattens it to a line or a point")]
    Flattened,
    /// Coordinates leave the range of numbers.
    #[error("its coordinates are not finite: correct them")]
    NotFinite,
    /// An attribute does not parse.
    #[error("its attribute `{0}` is no valid value: correct it")]
    BadAttribute(&'static str),
    /// Path data break off; what stands before is drawn.
    #[error("its path data cannot be read on at character {0}; what stands before is drawn")]
    BrokenPathData(usize),
    /// A `use` refers to nothing.
    #[error("it refers to nothing in this file (`{0}`)")]
    NoTarget(String),
    /// A `use` refers to itself, through others or not.
    #[error("it refers to itself, so there is no end to it")]
    Recursive,
    /// Text.
    #[error("text has no outlines here: convert it to paths")]
    Text,
    /// A picture made of pixels.
    #[error("a picture of pixels has no paths")]
    Image,
    /// Something that moves.
    #[error("animations and scripts are not run")]
    Animation,
    /// An element of another language.
    #[error("an element of another language than SVG")]
    Foreign,
    /// An element of SVG that is not known here.
    #[error("an element that is not supported")]
    Unsupported,
}

/// Something that is not in the drawing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The name of the element.
    pub element: String,
    /// Its id, if it has one.
    pub id: Option<String>,
    /// The line where it begins, from one.
    pub line: u32,
    /// Why.
    pub reason: LeftOutReason,
    /// How many segments, in all copies of the element.
    pub segments: SegmentCounts,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, {}", self.line, self.element)?;
        if let Some(id) = &self.id {
            write!(f, " `{id}`")?;
        }
        if self.segments.total() > 0 {
            write!(f, ", segments: {}", self.segments)?;
        }
        write!(f, ": {}", self.reason)
    }
}

/// Something that is in the drawing, but looks otherwise than the file says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The name of the element.
    pub element: String,
    /// Its id, if it has one.
    pub id: Option<String>,
    /// The line where it begins, from one.
    pub line: u32,
    /// The property that is not followed.
    pub property: &'static str,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, {}", self.line, self.element)?;
        if let Some(id) = &self.id {
            write!(f, " `{id}`")?;
        }
        write!(f, ": `{}` is not applied", self.property)
    }
}

/// What became of every segment of a drawing: `in_paths + in_shapes + in_copies` is `drawn + ` those of `left_out`, for each kind.
///
/// Segments are those of the file: an arc is one segment whatever it becomes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SvgReport {
    /// Segments of `path` elements, each as often as it stands in the file.
    pub in_paths: SegmentCounts,
    /// Segments made from other shapes, each as often as it stands in the file.
    pub in_shapes: SegmentCounts,
    /// Segments of paths and shapes in the copies that `use` makes.
    pub in_copies: SegmentCounts,
    /// Segments that are in the drawing.
    pub drawn: SegmentCounts,
    /// What is not, by element and reason, in the order of the file.
    pub left_out: Vec<LeftOut>,
    /// What is drawn, but looks otherwise.
    pub notes: Vec<Note>,
    /// Elements visited, copies included.
    pub elements: u64,
}

impl SvgReport {
    /// All segments found.
    pub fn found(&self) -> SegmentCounts {
        let mut found = self.in_paths;
        found += self.in_shapes;
        found += self.in_copies;
        found
    }

    /// All segments left out.
    pub fn segments_left_out(&self) -> SegmentCounts {
        let mut left = SegmentCounts::default();
        self.left_out.iter().for_each(|l| left += l.segments);
        left
    }

    /// Whether every segment found was either drawn or left out with a reason.
    pub fn adds_up(&self) -> bool {
        let mut accounted = self.drawn;
        accounted += self.segments_left_out();
        accounted == self.found()
    }
}
