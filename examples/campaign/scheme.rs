//! The schemes by their names on the command line.

use bevy_surface_splines::curve::Scheme;

/// A scheme with its name here and in the recorded results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NamedScheme {
    /// Name on the command line and in results.
    pub(crate) name: &'static str,
    /// Name in the recorded results to compare with.
    pub(crate) recorded: &'static str,
    pub(crate) scheme: Scheme,
}

/// All schemes there are.
pub(crate) const ALL: [NamedScheme; 2] = [
    NamedScheme { name: "rdc", recorded: "rdc_uniform4", scheme: Scheme::de_casteljau() },
    NamedScheme { name: "olr", recorded: "olr_uniform6", scheme: Scheme::lane_riesenfeld() },
];

/// Their names, for messages.
pub(crate) fn known() -> String {
    ALL.map(|s| s.name).join(", ")
}
