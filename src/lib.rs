//! Bézier splines on triangle meshes: geodesics, tracing, live editing, and a plugin for Bevy.
//!
//! Two storeys. The ground floor knows no engine: [`surface`] (a mesh one can walk on), [`geodesic`] (shortest and
//! straightest paths), [`curve`] (Bézier curves made of geodesic averages) and [`mod@format`] (files). The upper floor is a
//! Bevy plugin, thin components and systems that call the ground floor.
//!
//! Faces are always named by their place in the input mesh, lengths are in the mesh's own unit, angles in radians, curve
//! parameters in segments.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod curve;
pub mod format;
pub mod geodesic;
#[cfg(feature = "bevy")]
pub mod plugin;
#[cfg(feature = "bevy")]
pub mod prelude;
pub mod surface;

/// The README's code, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
