//! Tests that use several parts at once, in one binary.

#[cfg(feature = "formats")]
mod corpus;
#[cfg(feature = "svg")]
mod drawings;
#[cfg(feature = "formats")]
mod formats;
#[cfg(feature = "bevy")]
mod plugin;
