//! What can be wrong with cages and weights.

/// Why weights could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WeightsError {
    /// A cage is a polygon.
    #[error("the cage has {found} corners: give it from 3 to {most}")]
    Corners {
        /// Corners that were given.
        found: usize,
        /// Corners that there may be.
        most: usize,
    },
    /// A corner or a handle is nowhere.
    #[error("point {point} has a coordinate that is not finite: give it a place")]
    NotFinite {
        /// Its place in the list.
        point: usize,
    },
    /// The cage has no inside that could be told.
    #[error("edges {} and {} of the cage cross or touch: move their corners apart", edges[0], edges[1])]
    CrossesItself {
        /// Two edges, each by its first corner.
        edges: [usize; 2],
    },
    /// Something lies outside.
    #[error("segment {segment} of chain {chain} leaves the cage by {distance}: make the cage larger")]
    Leaves {
        /// The chain.
        chain: usize,
        /// Its segment.
        segment: usize,
        /// How far it is from the cage, in units of length.
        distance: f64,
    },
    /// A handle lies outside what it should move.
    #[error(
        "handle {handle} lies outside of what it should move, by {distance}: move it inside, or make the outline larger"
    )]
    HandleOutside {
        /// The handle.
        handle: usize,
        /// How far it is from the outline, in units of length.
        distance: f64,
    },
    /// Two handles want one place.
    #[error("handles {} and {} hold the same place: move them apart", handles[0], handles[1])]
    SamePlace {
        /// The handles.
        handles: [usize; 2],
    },
    /// There is nothing that could move.
    #[error("there are no handles: give at least one")]
    NoHandles,
    /// Weights would take more memory than is reasonable.
    #[error(
        "weights of {handles} handles at {vertices} vertices are too many: ask for fewer triangles, or give fewer handles"
    )]
    TooMany {
        /// Handles.
        handles: usize,
        /// Vertices that they would have weights at.
        vertices: usize,
    },
    /// The outline is too thin to be triangulated.
    #[error(
        "the outline could not be triangulated, it is too thin or has corners too near to each other: make it wider"
    )]
    Triangulation,
    /// The system could not be solved.
    #[error("the system of weights could not be solved, the outline has parts that are too thin: make them wider")]
    Singular,
    /// Tables do not fit together.
    #[error("there are {found} entries, and {expected} are needed: give one for each vertex")]
    Length {
        /// Entries that were given.
        found: usize,
        /// Entries that are needed.
        expected: usize,
    },
    /// A weight is negative or no number.
    #[error("vertex {vertex} has a weight that is negative or not finite: correct it")]
    BadWeight {
        /// The vertex.
        vertex: usize,
    },
    /// A vertex names a handle that there is not.
    #[error("vertex {vertex} names handle {handle}, and there are {handles}: correct the index")]
    NoSuchHandle {
        /// The vertex.
        vertex: usize,
        /// What it names.
        handle: usize,
        /// Handles that there are.
        handles: usize,
    },
}
