//! A path on a surface: from a point through a strip of faces to a point.

use glam::DVec3;

use super::inner::InnerPath;
use crate::surface::{FaceId, PointError, Surface, SurfacePoint};

/// Where a path leaves a face through a side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct Crossing {
    /// The face that is left.
    pub face: FaceId,
    /// Its side `k`, from corner k to corner k + 1 in input order.
    pub side: u8,
    /// Where on that side: 0 at corner k, 1 at corner k + 1. Exactly 0 or 1 where the path bends at the vertex.
    pub at: f64,
}

/// A stretch of a path inside one face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSegment {
    /// The face.
    pub face: FaceId,
    /// Weights of the face's corners where the stretch begins.
    pub from: [f64; 3],
    /// Weights where it ends.
    pub to: [f64; 3],
}

/// A path on a surface: a start, the sides it crosses in order, an end.
///
/// It holds no reference to its surface; whoever asks hands the same surface over again.
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct GeodesicPath {
    pub(crate) start: SurfacePoint,
    pub(crate) end: SurfacePoint,
    pub(crate) crossings: Vec<Crossing>,
    pub(crate) length: f64,
    pub(crate) frozen: bool,
}

/// By hand, because derived `clone_from` does not keep memory.
impl Clone for GeodesicPath {
    fn clone(&self) -> Self {
        Self { crossings: self.crossings.clone(), ..*self }
    }

    fn clone_from(&mut self, other: &Self) {
        let Self { start, end, crossings, length, frozen } = other;
        (self.start, self.end, self.length, self.frozen) = (*start, *end, *length, *frozen);
        self.crossings.clone_from(crossings);
    }
}

impl GeodesicPath {
    /// The path of no length at a point: where a drag begins, to be [`continued`](super::PathFinder::continued).
    pub fn at_rest(point: SurfacePoint) -> Self {
        Self { start: point, end: point, crossings: Vec::new(), length: 0.0, frozen: false }
    }

    /// Where the path starts, in the spelling of the first face it runs in.
    pub fn start(&self) -> SurfacePoint {
        self.start
    }

    /// Where the path ends, in the spelling of the last face.
    pub fn end(&self) -> SurfacePoint {
        self.end
    }

    /// The sides crossed, in order.
    pub fn crossings(&self) -> &[Crossing] {
        &self.crossings
    }

    /// Length in the surface's local unit.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Whether straightening met its bound before the path was locally shortest; it is short all the same.
    pub fn is_frozen(&self) -> bool {
        self.frozen
    }

    /// The stretches inside the faces, in order; none if the path belongs to another surface.
    pub fn segments<'a>(&'a self, surface: &'a Surface) -> impl Iterator<Item = PathSegment> + 'a {
        let inner = InnerPath::from_outer(surface, self).ok();
        let count = inner.as_ref().map_or(0, InnerPath::stretches);
        (0..count).filter_map(move |i| {
            let inner = inner.as_ref()?;
            let from = surface.outer_point(&inner.entry(surface, i));
            let to = surface.outer_point(&inner.exit(i));
            Some(PathSegment { face: from.face, from: from.weights, to: to.weights })
        })
    }

    /// Start, crossings and end as positions; empty if the path belongs to another surface.
    pub fn positions(&self, surface: &Surface) -> Vec<DVec3> {
        let Ok(inner) = InnerPath::from_outer(surface, self) else { return Vec::new() };
        let crossings = (0..inner.strip.len()).map(|i| inner.crossing_position(surface, i));
        let ends = [&inner.start, &inner.end].map(|p| surface.inner_position(p));
        std::iter::once(ends[0]).chain(crossings).chain([ends[1]]).map(|p| surface.origin + p).collect()
    }

    /// The point at a share of the length, 0 at the start and 1 at the end.
    ///
    /// # Errors
    /// [`PointError`] if the path belongs to another surface, or the share is NaN.
    pub fn at(&self, surface: &Surface, share: f64) -> Result<SurfacePoint, PointError> {
        if share.is_nan() {
            return Err(PointError::NotFinite("the share", self.start.face));
        }
        let inner = InnerPath::from_outer(surface, self)?;
        Ok(surface.outer_point(&inner.at_share(surface, share).1))
    }

    /// The same path from its end to its start.
    ///
    /// # Errors
    /// [`PointError`] if the path belongs to another surface.
    pub fn reversed(&self, surface: &Surface) -> Result<Self, PointError> {
        let mut inner = InnerPath::from_outer(surface, self)?;
        inner.reverse(surface);
        Ok(inner.to_outer(surface))
    }
}
