//! A spline as a document holds it: every bit that it is made of, and positions to find it again by.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::{Frame, ranges};
use crate::curve::{Anchor, Handle, Join, JumpPolicy, Scheme, Spline};
use crate::geodesic::{Crossing, GeodesicPath, Tangent};
use crate::surface::{FaceId, PointError, Surface, SurfacePoint};

/// The geometry of a spline as a document holds it.
///
/// What follows from the rest is left out: a handle of no length, a leg that begins at its anchor, a wished length that was
/// got.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredSpline {
    pub(super) closed: bool,
    pub(super) jumps: JumpPolicy,
    #[serde(deserialize_with = "ranges::scheme")]
    pub(super) scheme: Scheme,
    #[serde(deserialize_with = "ranges::list::<_, _, 100_000>")]
    pub(super) anchors: Vec<StoredAnchor>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredAnchor {
    pub(super) point: StoredPoint,
    /// Where it is, in the coordinates of the mesh file.
    #[serde(deserialize_with = "ranges::position")]
    pub(super) position: [f64; 3],
    pub(super) join: Join,
    #[serde(default, skip_serializing_if = "StoredHandle::is_bare")]
    pub(super) incoming: StoredHandle,
    #[serde(default, skip_serializing_if = "StoredHandle::is_bare")]
    pub(super) outgoing: StoredHandle,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) middle: Option<StoredLeg>,
}

/// A handle; what is left out is as in a handle that was never pulled out of its anchor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredHandle {
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "ranges::maybe_position")]
    pub(super) position: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "ranges::heading")]
    pub(super) heading: Option<(u32, f64, f64)>,
    /// The length wished for, where it is not the leg's.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "ranges::maybe_length")]
    pub(super) wished: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) leg: Option<StoredLeg>,
}

/// A leg; ends that are left out are those that it is to have.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredLeg {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) start: Option<StoredPoint>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) end: Option<StoredPoint>,
    #[serde(deserialize_with = "ranges::length")]
    pub(super) length: f64,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(super) frozen: bool,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) crossings: Vec<StoredCrossing>,
}

/// Face and weights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "(u32, f64, f64, f64)", try_from = "(u32, f64, f64, f64)")]
pub(super) struct StoredPoint(pub(super) SurfacePoint);

impl From<StoredPoint> for (u32, f64, f64, f64) {
    fn from(StoredPoint(SurfacePoint { face, weights: [a, b, c] }): StoredPoint) -> Self {
        (face.0, a, b, c)
    }
}

impl TryFrom<(u32, f64, f64, f64)> for StoredPoint {
    type Error = PointError;

    fn try_from((face, a, b, c): (u32, f64, f64, f64)) -> Result<Self, PointError> {
        let (face, weights) = (FaceId(face), [a, b, c]);
        SurfacePoint::new(face, weights)?;
        if weights.iter().any(|w| *w < 0.0) {
            return Err(PointError::BadWeights(face, weights)); // such would have to be changed
        }
        Ok(Self(SurfacePoint { face, weights }))
    }
}

/// Face, side and where on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "(u32, u8, f64)", try_from = "(u32, u8, f64)")]
pub(super) struct StoredCrossing(pub(super) Crossing);

impl From<StoredCrossing> for (u32, u8, f64) {
    fn from(StoredCrossing(Crossing { face, side, at }): StoredCrossing) -> Self {
        (face.0, side, at)
    }
}

impl TryFrom<(u32, u8, f64)> for StoredCrossing {
    type Error = String;

    fn try_from((face, side, at): (u32, u8, f64)) -> Result<Self, String> {
        if side > 2 || !(0.0..=1.0).contains(&at) {
            return Err(format!("side {side} at {at:?} is no place on a side: sides are 0 to 2, places 0.0 to 1.0"));
        }
        Ok(Self(Crossing { face: FaceId(face), side, at }))
    }
}

/// Whether a path is [`GeodesicPath::at_rest`] at a point, bit for bit.
fn is_at_rest(path: &GeodesicPath, point: &SurfacePoint) -> bool {
    let GeodesicPath { start, end, crossings, length, frozen } = path;
    start.same_bits(point) && end.same_bits(point) && crossings.is_empty() && length.to_bits() == 0 && !frozen
}

impl StoredSpline {
    /// Takes down a spline that lies on a surface.
    pub(super) fn of(surface: &Surface, frame: &Frame, spline: &Spline) -> Result<Self, (usize, PointError)> {
        let Spline { anchors, closed, scheme, jumps } = spline;
        let count = anchors.len();
        let stored = (0..count).map(|i| {
            let next = &anchors[(i + 1) % count];
            StoredAnchor::of(surface, frame, &anchors[i], next).map_err(|error| (i, error))
        });
        Ok(Self { closed: *closed, jumps: *jumps, scheme: *scheme, anchors: stored.collect::<Result<_, _>>()? })
    }
}

impl StoredAnchor {
    fn of(surface: &Surface, frame: &Frame, anchor: &Anchor, next: &Anchor) -> Result<Self, PointError> {
        let Anchor { point, join, incoming, outgoing, middle } = anchor;
        surface.inner_point(point)?;
        let middle = middle.as_ref().map(|leg| StoredLeg::of(leg, &outgoing.leg.end, &next.incoming.leg.end));
        Ok(Self {
            point: StoredPoint(*point),
            position: frame.hint(surface, point),
            join: *join,
            incoming: StoredHandle::of(surface, frame, incoming, point)?,
            outgoing: StoredHandle::of(surface, frame, outgoing, point)?,
            middle,
        })
    }
}

impl StoredHandle {
    fn is_bare(&self) -> bool {
        *self == Self::default()
    }

    fn of(surface: &Surface, frame: &Frame, handle: &Handle, anchor: &SurfacePoint) -> Result<Self, PointError> {
        let Handle { leg, heading, wished_length } = handle;
        surface.inner_point(&leg.end)?;
        let at_rest = is_at_rest(leg, anchor);
        let no_heading = heading.face == anchor.face && heading.vector.to_array().map(f64::to_bits) == [0; 2];
        Ok(Self {
            position: (!at_rest).then(|| frame.hint(surface, &leg.end)),
            heading: (!no_heading).then_some((heading.face.0, heading.vector.x, heading.vector.y)),
            wished: (wished_length.to_bits() != leg.length.to_bits()).then_some(*wished_length),
            leg: (!at_rest).then(|| StoredLeg::of(leg, anchor, anchor)),
        })
    }

    /// The handle as it was, nothing checked.
    pub(super) fn to_handle(&self, anchor: &SurfacePoint) -> Handle {
        let leg = self.leg.as_ref().map_or(GeodesicPath::at_rest(*anchor), |leg| leg.to_path(anchor, anchor));
        let (face, x, y) = self.heading.unwrap_or((anchor.face.0, 0.0, 0.0));
        let wished_length = self.wished.unwrap_or(leg.length);
        Handle { leg, heading: Tangent { face: FaceId(face), vector: DVec2::new(x, y) }, wished_length }
    }

    /// Where it is, if that is not where its anchor is.
    pub(super) fn hint(&self) -> Option<DVec3> {
        self.position.map(DVec3::from_array)
    }
}

impl StoredLeg {
    /// Takes down a leg that is to join two points.
    fn of(leg: &GeodesicPath, from: &SurfacePoint, to: &SurfacePoint) -> Self {
        let GeodesicPath { start, end, crossings, length, frozen } = leg;
        Self {
            start: (!start.same_bits(from)).then_some(StoredPoint(*start)),
            end: (!end.same_bits(to)).then_some(StoredPoint(*end)),
            length: *length,
            frozen: *frozen,
            crossings: crossings.iter().map(|c| StoredCrossing(*c)).collect(),
        }
    }

    /// The leg as it was, nothing checked.
    pub(super) fn to_path(&self, from: &SurfacePoint, to: &SurfacePoint) -> GeodesicPath {
        GeodesicPath {
            start: self.start.map_or(*from, |p| p.0),
            end: self.end.map_or(*to, |p| p.0),
            crossings: self.crossings.iter().map(|c| c.0).collect(),
            length: self.length,
            frozen: self.frozen,
        }
    }
}
