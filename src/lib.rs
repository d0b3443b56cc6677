//! Splines on surfaces.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod geodesic;
pub mod surface;
