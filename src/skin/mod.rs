//! Splines that follow handles and stay splines.
//!
//! Handles move places by a blend of their transforms (linear blend skinning), and what becomes of a cubic Bézier curve is not one. A [`BoundSkin`] finds
//! the control points whose curves are nearest to it in the least squares sense, among all that keep their joins: corners that meet, smooth and
//! mirrored joins, angles, pinned anchors (Liu, Jacobson and Gingold 2014, *Skinning cubic Bézier splines and Catmull–Clark subdivision
//! surfaces*). What comes out can be edited like what went in.
//!
//! A [`Chain`] is a path with its joins. A [`WeightField`] says how much each handle moves each place. Binding does all that does not depend on
//! the pose, so that a pose is a few multiplications a control point; a flexible pose also chooses the ratios of handle lengths.
//! [`NaiveWay`] has what one would do otherwise, to compare with, and [`SplitChain`] splits segments that are too long to follow.
//!
//! Solving is in double precision, poses are in single precision: within 2e-6 of the drawing's size.

mod band;
mod block;
mod bound;
mod bound_skin;
mod chain;
mod energy;
mod error;
mod flexible;
mod joins;
mod naive;
mod quadrature;
mod solve;
mod split;
mod spread;
mod system;
#[cfg(test)]
mod tests;
mod turn;
mod weights;

pub use bound::{BindOptions, BoundChain, Measure};
pub use bound_skin::{BoundSkin, FlexibleReport, Posed, in_space};
pub use chain::Chain;
pub use energy::skinned;
pub use error::SkinError;
pub use flexible::{FlexibleOptions, FlexibleOutcome};
pub use joins::{ChainJoin, JoinKind, JoinRules};
pub use naive::NaiveWay;
pub use quadrature::Quadrature;
pub use solve::SolveWorkspace;
pub use split::{SplitChain, SplitOptions};
pub use weights::{Cage, HandleShape, Shepard, SkinSet, SurfaceWeights, WeightField, WeightsError};
#[cfg(feature = "weights")]
pub use weights::{MeshedReport, MeshedWeights};
