//! What the benches share: arguments, meshes with their cases, clocks, tables. What the campaign has already is taken from it.
#![allow(dead_code, reason = "each bench is a program of its own and uses a part of this")]
#![allow(unused_imports, reason = "the tests in files of the campaign are run there, and left out here")]

pub(crate) mod arguments;
pub(crate) mod clock;
pub(crate) mod drag;
#[cfg(all(feature = "svg", feature = "document"))]
pub(crate) mod figure;
pub(crate) mod made;
pub(crate) mod records;
pub(crate) mod samples;
pub(crate) mod table;
pub(crate) mod threads;

#[path = "../../examples/campaign/cases.rs"]
pub(crate) mod cases;
#[path = "../../examples/campaign/random.rs"]
pub(crate) mod random;
#[path = "../../examples/campaign/stats.rs"]
pub(crate) mod stats;
