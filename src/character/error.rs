//! Why a character cannot be read, bound or written.

use std::fmt;
use std::path::PathBuf;

use super::Character;
use crate::skin::{SkinError, WeightsError};
use crate::vector::SvgError;

/// Why a character cannot be read, bound or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CharacterError {
    /// The file cannot be read.
    #[error("{}: {source}: check that the file exists and can be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is too large.
    #[error("{file}: a character has at most {limit} bytes: move clips or parts to characters of their own")]
    TooLarge {
        /// The file.
        file: String,
        /// How many there may be.
        limit: usize,
    },
    /// There is no version number where a character has one.
    #[error("{0}: a character begins with `(version: 1,`: open a file of a character")]
    NoCharacter(Place),
    /// A newer program wrote it.
    #[error(
        "{file}: the character has version {found}, and this program knows versions up to {}: open it with a newer program",
        Character::VERSION
    )]
    NewerVersion {
        /// The file.
        file: String,
        /// The version of the character.
        found: u64,
    },
    /// The text breaks the format, or a number is out of its range.
    #[error("{place}, in {field}: {problem}: correct it")]
    Content {
        /// Where.
        place: Place,
        /// The field, such as `joints[2].at`.
        field: String,
        /// What is wrong with it.
        problem: String,
    },
    /// Something does not fit with the rest.
    #[error("{}{element}: {fault}", At(place))]
    Fault {
        /// Where in the file; none of a character that was changed since it was read.
        place: Option<Place>,
        /// The joint, part, clip or track.
        element: String,
        /// What is wrong with it.
        fault: CharacterFault,
    },
    /// The drawing cannot be read.
    #[error("{place}, drawing `{drawing}`: {source}")]
    Drawing {
        /// Where the character names it.
        place: Place,
        /// The drawing.
        drawing: String,
        /// Why it cannot be read.
        source: DrawingFault,
    },
    /// The paths of a part cannot be bound.
    #[error("part `{part}`, path {path} of shape `{shape}`: {source}")]
    Skin {
        /// The part.
        part: String,
        /// The shape of the drawing.
        shape: String,
        /// The path of the shape.
        path: usize,
        /// Why.
        source: SkinError,
    },
    /// The weights of a part cannot be made.
    #[error("part `{part}`: {source}")]
    Weights {
        /// The part.
        part: String,
        /// Why; handles are the joints that it follows, in the order of all joints.
        source: WeightsError,
    },
    /// The program was built without what weights ask for.
    #[error(
        "part `{part}`: {source_name} weights need the feature `weights`: switch it on, or use `Shepard` weights, or hand over a cache of them"
    )]
    FeatureOff {
        /// The part.
        part: String,
        /// The weights, by their name in files.
        source_name: &'static str,
    },
    /// Binding was cancelled.
    #[error("binding was cancelled")]
    Cancelled,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: String,
    /// Counted from one.
    pub line: usize,
    /// Counted from one, in characters.
    pub column: usize,
}

impl fmt::Display for Place {
    /// `hero.character.ron, line 3, column 7`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, line {}, column {}", self.file, self.line, self.column)
    }
}

/// A place that may not be known, in front of something.
struct At<'a>(&'a Option<Place>);

impl fmt::Display for At<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.as_ref().map_or(Ok(()), |place| write!(f, "{place}, "))
    }
}

/// Why a drawing cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum DrawingFault {
    /// Its file cannot be read.
    #[error("{0}: check that the file exists and can be read")]
    Io(std::io::Error),
    /// It is no drawing.
    #[error(transparent)]
    Svg(#[from] SvgError),
}

/// What is wrong with an element of a character.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CharacterFault {
    /// There is nothing that could move.
    #[error("there are no joints: give at least one")]
    NoJoints,
    /// The drawing has no paths.
    #[error("the drawing `{drawing}` is empty: draw something, or name another")]
    EmptyDrawing {
        /// The drawing.
        drawing: String,
    },
    /// The drawing is too large to be posed in single precision.
    #[error("the drawing `{drawing}` has coordinates beyond {limit:e}: scale it down")]
    FarDrawing {
        /// The drawing.
        drawing: String,
        /// How large coordinates may be.
        limit: f64,
    },
    /// There is more than is reasonable.
    #[error("there are {found} {what}, at most {limit} are read: take some away")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A name is empty or very long.
    #[error("its name has {bytes} bytes: give it one of 1 to {limit}")]
    BadName {
        /// How long it is.
        bytes: usize,
        /// How long it may be.
        limit: usize,
    },
    /// Two have the same name.
    #[error("there is another {what} of this name: rename one")]
    SameName {
        /// What they are.
        what: &'static str,
    },
    /// There is no such joint.
    #[error("there is no joint `{name}`: correct the name, or add the joint")]
    NoSuchJoint {
        /// The name.
        name: String,
    },
    /// Joints carry one another in a circle.
    #[error("joints carry one another in a circle ({}): give one of them another parent, or none", names.join(" → "))]
    Cycle {
        /// The joints of the circle, each followed by its parent; the first one stands at the end again.
        names: Vec<String>,
    },
    /// A joint comes before its parent; files may have them in any order.
    #[error("the joint comes before its parent: put parents first")]
    ParentLater,
    /// The same joint twice.
    #[error("the joint `{name}` stands here twice: leave one away")]
    SameJoint {
        /// The joint.
        name: String,
    },
    /// A part without shapes.
    #[error("the part has no shapes: name the ids of some")]
    NoShapes,
    /// A part without joints.
    #[error("the part follows no joint: name at least one")]
    FollowsNothing,
    /// The drawing has no such shape or group.
    #[error(
        "nothing drawn has the id `{id}`: correct it, or give this id to a shape or a group of the drawing `{drawing}`"
    )]
    NoSuchShape {
        /// The id.
        id: String,
        /// The drawing.
        drawing: String,
    },
    /// Two parts want the same shape.
    #[error("the id `{id}` stands in part `{other}` too: leave it to one of them")]
    SameShape {
        /// The id.
        id: String,
        /// The other part.
        other: String,
    },
    /// A shape belongs to no part.
    #[error(
        "{shape} of the drawing belongs to no part: name its id, or that of a group that it lies in, in one of them"
    )]
    NotInAPart {
        /// The shape.
        shape: String,
    },
    /// A join is changed where there is none.
    #[error(
        "shape `{shape}` of this part has no join at anchor {anchor} of path {path}: name one where two segments meet"
    )]
    NoSuchJoin {
        /// The shape.
        shape: String,
        /// The path.
        path: usize,
        /// The anchor.
        anchor: usize,
    },
    /// A join cannot be what it is asked to be.
    #[error(
        "at anchor {anchor} of path {path} of shape `{shape}` a handle has no length: draw it out, or leave the join a corner"
    )]
    NoDirection {
        /// The shape.
        shape: String,
        /// The path.
        path: usize,
        /// The anchor.
        anchor: usize,
    },
    /// A corner of a cage goes with a joint that the part does not follow.
    #[error(
        "a corner of the cage goes with joint `{name}`, which the part does not follow: add it there, or name another"
    )]
    CornerElsewhere {
        /// The joint.
        name: String,
    },
    /// A number is out of its range.
    #[error("{what} is {found:?}, and must be from {least:?} to {most:?}: correct it")]
    OutOfRange {
        /// Which number.
        what: &'static str,
        /// What it is.
        found: f64,
        /// What it may be at least.
        least: f64,
        /// What it may be at most.
        most: f64,
    },
    /// A track without keys.
    #[error("the track has no keys: give it some, or leave it away")]
    NoKeys,
    /// Two tracks move the same.
    #[error("another track of the clip moves the {channel} of joint `{name}`: make them one")]
    SameTrack {
        /// What they move.
        channel: &'static str,
        /// The joint.
        name: String,
    },
    /// Keys go back in time.
    #[error("key {key} is not later than the one before: put keys in the order of their times")]
    KeyOrder {
        /// The key, counted from zero.
        key: usize,
    },
    /// A looping clip repeats its first key.
    #[error("key {key} is at the end of a clip that loops, which is its beginning again: leave it away")]
    KeyAtTheEnd {
        /// The key, counted from zero.
        key: usize,
    },
    /// Binding would take too long.
    #[error(
        "binding would take too long ({found} {what}, at most {limit}): let parts follow fewer joints, use fewer triangles, or simplify the drawing"
    )]
    TooCostly {
        /// What there is too much of.
        what: &'static str,
        /// How much there is.
        found: usize,
        /// How much there may be.
        limit: usize,
    },
}
