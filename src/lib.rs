//! Splines on surfaces.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod curve;
#[cfg(feature = "formats")]
pub mod format;
pub mod geodesic;
pub mod surface;
