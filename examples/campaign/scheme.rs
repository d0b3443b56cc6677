//! The schemes by their names on the command line.

use bevy_surface_splines::curve::{Method, Sampling, Scheme};

/// A scheme with its name here and in the recorded results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NamedScheme {
    /// Name on the command line and in results.
    pub(crate) name: &'static str,
    /// What it is, for the command line's help.
    pub(crate) about: &'static str,
    pub(crate) scheme: Scheme,
    /// How many points of a control polygon it takes, the first ones.
    pub(crate) takes: usize,
    /// Name in the recorded results to compare with.
    pub(crate) recorded: Option<&'static str>,
}

const RDC: Scheme = Scheme::de_casteljau();
const OLR: Scheme = Scheme::lane_riesenfeld();
const SPLINE: Scheme = Scheme::b_spline();

/// All schemes there are.
pub(crate) const ALL: [NamedScheme; 17] = [
    of("rdc", "recursive de Casteljau, 48 segments", RDC).recorded_as("rdc_uniform4"),
    of("olr", "Lane–Riesenfeld, 67 points", OLR).recorded_as("olr_uniform6"),
    of("rdc-adaptive", "until it turns by at most 5°", RDC.adaptive()).recorded_as("rdc_adaptive5deg"),
    of("olr-adaptive", "likewise", OLR.adaptive()).recorded_as("olr_adaptive5deg"),
    of("rdc-curve", "all points on the curve", RDC.on_curve()),
    of("olr-curve", "likewise", OLR.on_curve()),
    of("rdc-adaptive-curve", "both", RDC.on_curve().adaptive()),
    of("olr-adaptive-curve", "both", OLR.on_curve().adaptive()),
    of("rdc2", "quadratic: the first three points", RDC).taking(3),
    of("olr2", "likewise", OLR).taking(3),
    of("rdc2-adaptive", "likewise", RDC.adaptive()).taking(3),
    of("olr2-adaptive", "likewise", OLR.adaptive()).taking(3),
    of("bspline", "cubic B-spline, one segment", SPLINE),
    of("bspline2", "quadratic B-spline, two segments", Scheme::quadratic_b_spline()),
    of("bspline2-adaptive", "likewise", Scheme::quadratic_b_spline().adaptive()),
    of("direct", "for comparison: direct de Casteljau, 33 points", Scheme::direct()),
    of("rcm", "for comparison: centres of mass, 33 points", Scheme::centre_of_mass()),
];

/// The schemes that are run if none are named.
pub(crate) const DEFAULT: [NamedScheme; 2] = [ALL[0], ALL[1]];

const fn of(name: &'static str, about: &'static str, scheme: Scheme) -> NamedScheme {
    NamedScheme { name, about, scheme, takes: 4, recorded: None }
}

impl NamedScheme {
    const fn recorded_as(mut self, name: &'static str) -> Self {
        self.recorded = Some(name);
        self
    }

    const fn taking(mut self, points: usize) -> Self {
        self.takes = points;
        self
    }

    /// How many segments its trace has.
    pub(crate) const fn segments(&self) -> usize {
        match self.scheme.method {
            Method::BSpline => self.takes - 3,
            Method::QuadraticBSpline => self.takes - 2,
            _ => 1,
        }
    }

    /// The turn in degrees that its traces may not exceed unless they say what kept them from it.
    pub(crate) fn most_turn_deg(&self) -> Option<f64> {
        match self.scheme.sampling {
            Sampling::Adaptive { turn, .. } => Some(turn.to_degrees()),
            _ => None,
        }
    }

    /// Whether it is there to be compared with: it may tear curves, and take too long.
    pub(crate) const fn is_for_comparison(&self) -> bool {
        self.scheme.method.is_for_comparison()
    }
}

/// Finds a scheme by its name.
pub(crate) fn find(name: &str) -> Option<NamedScheme> {
    ALL.into_iter().find(|s| s.name == name)
}

/// Their names, for messages.
pub(crate) fn known() -> String {
    ALL.map(|s| s.name).join(", ")
}

/// Names and explanations, a line each.
pub(crate) fn table() -> String {
    ALL.map(|s| format!("  {:<18} {}\n", s.name, s.about)).concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_stands_for_one_scheme() {
        for (i, a) in ALL.iter().enumerate() {
            assert_eq!(find(a.name), Some(*a));
            assert!(ALL[i + 1..].iter().all(|b| (a.scheme, a.takes) != (b.scheme, b.takes)), "{}", a.name);
        }
        assert_eq!(find("rdc3"), None);
        assert_eq!(find("bspline2").map(|s| s.segments()), Some(2));
    }
}
