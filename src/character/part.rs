//! Parts: which joints shapes follow, and how.

use glam::DVec2;

use crate::skin::JoinKind;

/// Shapes of the drawing that follow the same joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Its name; no two parts have the same.
    pub name: String,
    /// Ids of shapes and groups of the drawing. A group stands for all in it that no part names more closely.
    pub shapes: Vec<String>,
    /// The joints that it follows. What follows one joint is rigid.
    pub follows: Vec<usize>,
    /// Parts are painted in this order, those alike in the drawing's.
    pub z: f64,
    /// How much each joint moves each place, where that is not as for all parts.
    pub weights: Option<WeightSource>,
    /// Joins that are something else than they look like.
    pub joins: Vec<JoinChange>,
}

/// A join of a path that is something else than it looks like.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JoinChange {
    /// The id of a shape of the part.
    pub shape: String,
    /// The path of the shape, in the order in which they are drawn.
    pub path: usize,
    /// The anchor of the path, its first one being zero.
    pub anchor: usize,
    /// What is kept there.
    pub kind: JoinKind,
}

/// Where weights come from: how much each joint moves each place of a part.
#[derive(Clone, Debug, PartialEq)]
pub enum WeightSource {
    /// By a power of the distance to each joint or its bone (see [`Shepard`](crate::skin::Shepard)).
    Shepard {
        /// From 1 to 8; the larger, the shorter the way over which one joint takes over from the next.
        power: f64,
    },
    /// Bounded biharmonic weights of joints and bones (see `MeshedWeights`); asks for the feature `weights`. A bone counts without a tenth of its
    /// length at either end, so that bones that meet do not claim one place.
    Bounded {
        /// About how many triangles they are solved on.
        triangles: u32,
        /// A polygon about the part; a rectangle about what it moves and follows if it has no corners.
        outline: Vec<DVec2>,
    },
    /// Harmonic coordinates of a cage, each of whose corners goes with a joint (see `MeshedWeights`); asks for the feature `weights`.
    Cage {
        /// About how many triangles they are solved on.
        triangles: u32,
        /// A polygon about the part.
        corners: Vec<CageCorner>,
    },
}

impl Default for WeightSource {
    fn default() -> Self {
        Self::Shepard { power: 4.0 }
    }
}

/// A corner of a cage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CageCorner {
    /// The joint that it goes with, one that the part follows.
    pub joint: usize,
    /// Where it is at rest.
    pub at: DVec2,
}
