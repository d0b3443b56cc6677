//! Tests that use several parts at once, in one binary.

#[cfg(feature = "formats")]
mod corpus;
#[cfg(feature = "tools")]
mod editor;
#[cfg(feature = "formats")]
mod formats;
#[cfg(feature = "bevy")]
mod plugin;
