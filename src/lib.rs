//! Bézier splines on triangle meshes: geodesics, tracing, live editing, and a plugin for Bevy.
//!
//! Two storeys. The ground floor knows no engine: [`surface`] (a mesh one can walk on), [`geodesic`] (shortest and
//! straightest paths), [`curve`] (Bézier curves made of geodesic averages), [`smooth`] (drawn lines made smooth), [`vector`] (planar drawings),
//! [`placement`] (drawings on a surface), [`skin`] (splines that follow handles), `character` (drawings with joints and clips; features `svg` and `document`) and [`mod@format`] (files). The upper floor is a
//! Bevy plugin, thin components and systems that call the ground floor.
//!
//! Faces are always named by their place in the input mesh, lengths are in the mesh's own unit, angles in radians, curve
//! parameters in segments.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(all(feature = "svg", feature = "document"))]
pub mod character;
pub mod curve;
#[cfg(feature = "tools")]
pub mod editor;
pub mod format;
pub mod geodesic;
pub mod placement;
#[cfg(feature = "bevy")]
pub mod plugin;
#[cfg(feature = "bevy")]
pub mod prelude;
pub mod skin;
pub mod smooth;
pub mod surface;
pub mod vector;

/// The README's code, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
