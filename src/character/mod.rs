//! Characters: a drawing, the joints that move it, and how they move.
//!
//! A [`Character`] is read from a text that people can write, `*.character.ron`. The text names a drawing (SVG) and says which joints there are,
//! which of them each part of the drawing follows, and which clips there are. `docs/characters.md` has every field.
//!
//! Here **y goes up**, as in engines: the drawing is turned over about its origin when it is read. Lengths are in the drawing's units, angles in
//! radians, counter-clockwise. The text speaks of places as the drawing does, with y down, and of angles in degrees.
//!
//! [`Character::bind`] makes one [`BoundSkin`](crate::skin::BoundSkin) of all paths, whose handle `i` is joint `i`. A pose is then:
//! [`sample`](Character::sample) a clip, [`worlds`](Character::worlds) of the joints, [`BoundCharacter::pose`].
//!
//! Nothing in a file is trusted: numbers are checked against their ranges, names against one another and the drawing, and how much there may be of
//! everything is bounded, so that what loads is bound and posed within a second.

mod assign;
mod bind;
mod cache;
mod check;
mod clip;
mod error;
#[cfg(feature = "formats")]
mod follow;
mod joint;
mod locate;
mod model;
mod part;
mod read;
mod stored;
#[cfg(test)]
mod tests;
mod weights;
mod write;

pub use bind::{BindProgress, BoundCharacter, CharacterPath};
pub use cache::CacheUse;
pub use clip::{Clip, Easing, Keys, Track};
pub use error::{CharacterError, CharacterFault, DrawingFault, Place};
#[cfg(feature = "formats")]
pub use follow::{DrawingPlane, SkeletonMap};
pub use joint::{Joint, JointPose};
pub use model::Character;
pub use part::{CageCorner, JoinChange, Part, WeightSource};
pub use read::CharacterFile;
