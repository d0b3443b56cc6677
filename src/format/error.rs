//! Why a mesh file could not be read.

use std::fmt;
use std::path::PathBuf;

use super::MeshFormat;

/// Why a mesh file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The file could not be opened or read.
    #[error("{}: {source}: check that the file exists and can be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Neither the file's extension nor its first bytes tell a format.
    #[error("{}: not a known mesh format: give an OBJ, STL, PLY, OFF, glTF or GLB file", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// Files of this format hold no skins.
    #[error("{format} files hold no skins: give a glTF or GLB file")]
    NoSkins {
        /// The format.
        format: MeshFormat,
    },
    /// The content is broken, or uses something that is not supported.
    #[error("{format}, {place}: {cause}")]
    Content {
        /// The format it was read as.
        format: MeshFormat,
        /// Where.
        place: Place,
        /// What is wrong, and what to do.
        cause: Cause,
    },
}

impl FormatError {
    /// Where in the file, if the content is at fault.
    pub fn place(&self) -> Option<&Place> {
        if let Self::Content { place, .. } = self { Some(place) } else { None }
    }

    /// What is wrong with the content, if that is at fault.
    pub fn cause(&self) -> Option<&Cause> {
        if let Self::Content { cause, .. } = self { Some(cause) } else { None }
    }
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file, counted from one.
    Line(u64),
    /// A byte, counted from zero.
    Byte(u64),
    /// An item of a glTF document, such as `accessor 3`.
    Item(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Item(item) => f.write_str(item),
        }
    }
}

/// What is wrong at a [`Place`], and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Cause {
    /// Nothing that belongs to the format was found.
    #[error("found nothing of this format ({0}): check that the file is what its name says")]
    NothingFound(&'static str),
    /// Something else stands there.
    #[error("expected {expected}, found `{found}`: correct it")]
    Unexpected {
        /// What should stand there.
        expected: &'static str,
        /// What does, shortened.
        found: String,
    },
    /// Something is left out.
    #[error("{0} is missing: add it")]
    Missing(&'static str),
    /// The file stops too early.
    #[error("the file ends inside {0}: it was cut off, copy or export it again")]
    EndsEarly(&'static str),
    /// More items are announced than the rest of the file can hold.
    #[error("{count} {what} are announced, but only {room} bytes follow: the file was cut off or its header is wrong")]
    CountTooLarge {
        /// Of what.
        what: &'static str,
        /// How many are announced.
        count: u64,
        /// Bytes that are left.
        room: u64,
    },
    /// A face names a vertex that does not exist.
    #[error("a face uses vertex {index}, but there are {vertices} vertices: correct the index")]
    IndexOutOfRange {
        /// The index as written in the file.
        index: String,
        /// How many vertices there are.
        vertices: u64,
    },
    /// More vertices than 32-bit indices can count.
    #[error("there are more than 2^32 vertices: split the mesh")]
    TooManyVertices,
    /// Legal, but not read.
    #[error("{what} is not supported: {remedy}")]
    Unsupported {
        /// What it is.
        what: String,
        /// What to do instead.
        remedy: &'static str,
    },
    /// The JSON of a glTF file does not parse.
    #[error("the JSON does not parse as glTF 2.0 ({0}): correct or export it again")]
    Json(String),
    /// A glTF item refers to one that does not exist.
    #[error("it refers to {0}, which does not exist: correct the reference")]
    NoSuchItem(String),
    /// A glTF node has two parents, lies on a cycle, or is listed twice in a scene.
    #[error("the node lies on a cycle or hangs in two places: let the nodes form trees")]
    NotATree,
    /// A part of a glTF buffer lies outside of what holds it.
    #[error("it needs {needed} bytes of {holder}, which has {present}: the file was cut off or the lengths are wrong")]
    PastEnd {
        /// Bytes needed, from the start of the holder.
        needed: u64,
        /// The buffer or view that should hold them.
        holder: String,
        /// Bytes it has.
        present: u64,
    },
    /// A glTF item has a value that makes no sense.
    #[error("{0}: correct it")]
    Invalid(String),
    /// A vertex gives weight to a joint that its skin does not have.
    #[error("vertex {vertex} is weighted to joint {joint}, but the skin has {joints} joints: correct the index")]
    NoSuchJoint {
        /// The vertex, counted in its primitive.
        vertex: usize,
        /// The joint as written in the file.
        joint: String,
        /// How many joints the skin has.
        joints: usize,
    },
    /// A vertex has weights that make no sense.
    #[error(
        "the weights of vertex {vertex} sum to {sum}, or one is negative: bring them to a sum of 1 in the exporter"
    )]
    BadWeights {
        /// The vertex, counted in its primitive.
        vertex: usize,
        /// Their sum.
        sum: String,
    },
    /// A glTF buffer that lies in another file cannot be read.
    #[error("the file `{uri}` cannot be read ({reason}): put it beside the document")]
    ExternalFile {
        /// As written in the document.
        uri: String,
        /// What the system says.
        reason: String,
    },
    /// A glTF document describes far more than its own size.
    #[error("the scene comes to {bytes} bytes, far more than the file holds: bake fewer instances into it")]
    TooLarge {
        /// Bytes needed.
        bytes: u64,
    },
}

/// A [`Cause`] at a [`Place`]: an error whose format the caller knows.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) place: Place,
    pub(super) cause: Cause,
}

impl Fault {
    pub(super) fn line(line: u64, cause: Cause) -> Self {
        Self { place: Place::Line(line), cause }
    }

    pub(super) fn byte(byte: usize, cause: Cause) -> Self {
        Self { place: Place::Byte(byte as u64), cause }
    }

    pub(super) fn item(item: impl Into<String>, cause: Cause) -> Self {
        Self { place: Place::Item(item.into()), cause }
    }

    pub(super) fn in_format(self, format: MeshFormat) -> FormatError {
        FormatError::Content { format, place: self.place, cause: self.cause }
    }
}

/// A piece of a file as a message may show it: printable and short.
pub(super) fn shown(bytes: &[u8]) -> String {
    const LONGEST: usize = 32;
    let mut text: String =
        String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST)]).chars().flat_map(char::escape_debug).collect();
    if bytes.len() > LONGEST {
        text.push('…');
    }
    text
}
