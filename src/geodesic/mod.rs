//! Moving on a surface: shortest and straightest paths, exponential and logarithmic map, parallel transport.
//!
//! A shortest path is found in two steps: an any-angle search gives a strip of faces, straightening pulls a string taut in
//! it and moves the strip past every vertex where that shortens the string. A straightest path is walked face by face.

pub(crate) mod chain;
mod corridor;
mod finder;
mod funnel;
mod guess;
mod guide;
mod heap;
pub(crate) mod inner;
mod path;
pub(crate) mod path_list;
mod quality;
mod queue;
mod search;
mod seen;
mod stamps;
mod straighten;
pub(crate) mod tangent;
pub(crate) mod transport;
pub(crate) mod walk;

pub use finder::{PathError, PathFinder};
pub use path::{Crossing, GeodesicPath, PathSegment};
pub use quality::PathQuality;
pub use tangent::Tangent;
pub use walk::{Walk, WalkStop};
