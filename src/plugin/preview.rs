//! What is shown of a spline while its trace is computed in the background.

use bevy::prelude::*;

use super::spline::SurfaceSpline;
use super::trace::Polyline;
use crate::curve::{Method, Sampling, Scheme, Spline};
use crate::geodesic::PathQuality;

/// A rough or outdated curve, there while a trace is computed in the background; draw it instead of the
/// [`SplineTrace`](super::SplineTrace), which is outdated then. Gone when the trace is there.
///
/// Derived: a system writes it. It is for the eye alone, and depends on how fast things go: never measure, save or follow it.
#[derive(Component, Clone, Debug)]
#[component(immutable, clone_behavior = Ignore)]
pub struct TracePreview {
    kind: PreviewKind,
    polyline: Polyline,
}

/// What a [`TracePreview`] shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PreviewKind {
    /// The spline as it was some edits ago, exactly.
    Previous,
    /// A newer spline than any that was traced, roughly: of quality [`PathQuality::Fast`], with few levels.
    Fast,
}

impl TracePreview {
    pub(crate) fn new(kind: PreviewKind, polyline: Polyline) -> Self {
        Self { kind, polyline }
    }

    /// What it shows.
    pub fn kind(&self) -> PreviewKind {
        self.kind
    }

    /// Positions along the curve in the surface's local space.
    pub fn polyline(&self) -> &[Vec3] {
        self.polyline.positions()
    }

    /// The unbroken pieces of the [`polyline`](Self::polyline).
    pub fn pieces(&self) -> impl Iterator<Item = &[Vec3]> {
        self.polyline.pieces()
    }
}

/// The spline of which the trace is a preview.
pub(crate) fn rough(spline: &Spline) -> Spline {
    spline.clone().with_scheme(rough_scheme(spline.scheme()))
}

/// The same method in a hurry; never finer than it was.
fn rough_scheme(scheme: Scheme) -> Scheme {
    let levels = if scheme.method == Method::LaneRiesenfeld { 4 } else { 3 };
    let levels = if let Sampling::Levels(wanted) = scheme.sampling { levels.min(wanted) } else { levels };
    Scheme { on_curve: false, ..scheme }.with_levels(levels).with_quality(PathQuality::Fast)
}

/// What is no spline any more has no preview.
pub(crate) fn remove_preview(removed: On<Remove, SurfaceSpline>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<TracePreview>();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn previews_are_not_finer_than_what_they_stand_for() {
        let levels = |scheme| rough_scheme(scheme).sampling;
        assert_eq!(levels(Scheme::de_casteljau()), Sampling::Levels(3));
        assert_eq!(levels(Scheme::lane_riesenfeld()), Sampling::Levels(4));
        assert_eq!(levels(Scheme::lane_riesenfeld().with_levels(2)), Sampling::Levels(2));
        assert_eq!(levels(Scheme::b_spline().adaptive().on_curve()), Sampling::Levels(3));
        assert!(Method::ALL.iter().all(|m| rough_scheme(Scheme::of(*m)).quality == PathQuality::Fast));
    }
}
