//! What can be wrong with skinning.

/// Why splines could not be bound to handles, or posed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SkinError {
    /// There is nothing that could move.
    #[error("there are no handles: give at least one")]
    NoHandles,
    /// A handle's place, or a weight, is not a number.
    #[error("handle {handle} has a coordinate that is not finite: give it a place")]
    HandleNotFinite {
        /// Its place in the list.
        handle: usize,
    },
    /// No handle moves a part of a curve, or a weight is not finite.
    #[error(
        "segment {segment} of chain {chain} has no weights: no handle moves it, or one of its weights is not finite"
    )]
    NoWeights {
        /// The chain, by its place in the list.
        chain: usize,
        /// The segment of the chain.
        segment: usize,
    },
    /// There are as many transforms as handles.
    #[error("the pose has {found} transforms, and there are {handles} handles: give one for each")]
    PoseLength {
        /// Handles that there are.
        handles: usize,
        /// Transforms that were given.
        found: usize,
    },
    /// A transform is not finite, or too large for single precision.
    #[error("the transform of handle {handle} is not finite, or too large for single precision: keep it nearer to 1")]
    PoseNotFinite {
        /// Its place in the list.
        handle: usize,
    },
    /// Chains of a skin follow the same handles.
    #[error(
        "chain {chain} is bound to {found} handles, and the skin has {handles}: bind all chains to the same weights"
    )]
    OtherHandles {
        /// The chain, by its place in the list.
        chain: usize,
        /// Handles that it is bound to.
        found: usize,
        /// Handles that the skin has.
        handles: usize,
    },
    /// Poses are in single precision.
    #[error("chain {chain} has coordinates that are too large for single precision: bring them nearer to 1")]
    TooLarge {
        /// The chain, by its place in the list.
        chain: usize,
    },
    /// An anchor is to be pinned to a place that is nowhere.
    #[error("the place to which anchor {anchor} is to be pinned is not finite: give it one that is")]
    PinNotFinite {
        /// The anchor.
        anchor: usize,
    },
    /// The system of a chain cannot be solved: its coordinates are too large or too small for 64 bits.
    #[error("chain {chain} cannot be solved in double precision: bring its coordinates nearer to 1")]
    Singular {
        /// The chain, by its place in the list.
        chain: usize,
    },
    /// There is no such anchor, or it is the end of an open chain.
    #[error("no two segments meet at anchor {anchor}, or there is none: name one inside the chain")]
    NoJoin {
        /// The anchor.
        anchor: usize,
    },
    /// A handle of a join has no length, so it has no direction.
    #[error("a handle at anchor {anchor} has no length: draw it out, or leave the join a corner")]
    NoDirection {
        /// The anchor.
        anchor: usize,
    },
}
