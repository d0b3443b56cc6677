//! A seeded drag of an anchor or a handle: short straightest walks, one after another, in rough circles.

use std::f64::consts::TAU;

use bevy_surface_splines::{
    curve::{HandleSide, Spline, SplineEdit},
    geodesic::Tangent,
    surface::{Surface, SurfacePoint},
};

use super::random::SplitMix64;

/// Length of a step, as a share of the diagonal.
const STEP: f64 = 0.002;
/// Steps in a full circle.
const CIRCLE: f64 = 60.0;

/// What is dragged.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Grip {
    Anchor(u32),
    Handle(u32, HandleSide),
}

impl Grip {
    fn place(self, spline: &Spline) -> SurfacePoint {
        match self {
            Self::Anchor(i) => spline.anchors()[i as usize].point(),
            Self::Handle(i, HandleSide::Incoming) => spline.anchors()[i as usize].incoming().point(),
            Self::Handle(i, HandleSide::Outgoing) => spline.anchors()[i as usize].outgoing().point(),
        }
    }
}

/// A drag under way.
pub(crate) struct Drag {
    grip: Grip,
    heading: Option<Tangent>,
    random: SplitMix64,
}

impl Drag {
    pub(crate) fn new(grip: Grip, seed: u64) -> Self {
        Self { grip, heading: None, random: SplitMix64::new(seed) }
    }

    /// The edit of the next step. After a step that ends at the boundary the next one sets out anew.
    pub(crate) fn step(&mut self, surface: &Surface, spline: &Spline) -> SplineEdit {
        let place = self.grip.place(spline);
        let ahead = self.heading.map(|heading| heading.rotated(TAU / CIRCLE * (0.5 + self.random.unit())));
        let heading = ahead.unwrap_or_else(|| {
            let along = surface.corners(place.face).map_or(glam::DVec3::X, |[a, b, _]| b - a);
            let tangent = surface.tangent(&place, along).unwrap_or_else(|error| panic!("{error}"));
            tangent.rotated(self.random.unit() * TAU)
        });
        let walk = surface.walk(&place, &heading, STEP * surface.diagonal());
        let walk = walk.unwrap_or_else(|error| panic!("{error}"));
        self.heading = walk.stopped.is_none().then_some(walk.heading);
        match self.grip {
            Grip::Anchor(anchor) => SplineEdit::DragAnchor { anchor, along: walk.path },
            Grip::Handle(anchor, side) => SplineEdit::DragHandle { anchor, side, along: walk.path },
        }
    }
}
