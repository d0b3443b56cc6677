//! Splines of a document on the surface that they were made on.

use super::mapping::{MappingReport, map_spline};
use super::stored::{StoredAnchor, StoredHandle, StoredLeg, StoredSpline};
use super::{Document, DocumentError, RestoredLine, SplineFault, SurfaceReference};
use crate::curve::{Anchor, Handle, HandleSide, Spline};
use crate::geodesic::{GeodesicPath, PathFinder, inner::InnerPath};
use crate::surface::{Surface, SurfacePoint};

/// Lengths within this share of the diagonal are the same but for rounding of the last bits.
const SAME: f64 = 1e-9;
/// Lengths within this share of the diagonal differ by the rounding of positions to `f32`, which a fingerprint does not see.
const ROUNDED: f64 = 1e-4;

/// The splines of a document, on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Restored {
    /// In the order of the document; none for one that could not be placed anew, of which the report says why.
    pub splines: Vec<Option<Spline>>,
    /// Likewise the lines.
    pub lines: Vec<Option<RestoredLine>>,
    /// Present if the surface is not the one of the document, so that all points were placed anew.
    pub mapping: Option<MappingReport>,
}

impl Document {
    /// The splines on a surface that is as it is in its file: bit for bit as they were if it is the document's own, else placed
    /// anew by the positions that the document holds, with a report.
    ///
    /// Every leg is checked: consecutive faces share the side, crossings lie on it, ends and length are right.
    ///
    /// # Errors
    /// [`DocumentError::Spline`] if the surface is the same and a spline does not lie on it as the document says;
    /// [`map`](Self::map) places the splines of such a document.
    pub fn restore(&self, surface: &Surface, finder: &mut PathFinder) -> Result<Restored, DocumentError> {
        self.restore_as(surface, &SurfaceReference::of(surface), finder)
    }

    /// As [`restore`](Self::restore), for a surface whose reference is known: in a [`Frame`](super::Frame) of its own.
    ///
    /// In another frame than the document's, lengths are scaled.
    ///
    /// # Errors
    /// As [`restore`](Self::restore).
    pub fn restore_as(
        &self,
        surface: &Surface,
        known: &SurfaceReference,
        finder: &mut PathFinder,
    ) -> Result<Restored, DocumentError> {
        if !self.surface.is_same_mesh(known) {
            return Ok(self.map(surface, known, finder));
        }
        let mut splines = Vec::with_capacity(self.splines.len());
        let scale = self.surface.frame.unit / known.frame.unit;
        for (index, spline) in self.splines.iter().enumerate() {
            let restored = Restoring { surface, scale }.spline(&spline.geometry, finder);
            splines.push(Some(restored.map_err(|(part, fault)| DocumentError::Spline {
                index,
                name: spline.name.clone(),
                part,
                fault: Box::new(fault),
            })?));
        }
        let mut lines = Vec::with_capacity(self.lines.len());
        for (index, line) in self.lines.iter().enumerate() {
            let restored = line.restore(surface, scale);
            let name = || line.name.clone();
            let refused = |fault| DocumentError::Line { index, name: name(), fault: Box::new(fault) };
            lines.push(Some(restored.map_err(refused)?));
        }
        Ok(Restored { splines, lines, mapping: None })
    }

    /// Places the splines anew, every point at the place nearest to the position that the document holds for it.
    ///
    /// Handles are joined to their anchors by shortest paths, and middle legs are searched: what way they took around the model
    /// is not kept.
    pub fn map(&self, surface: &Surface, known: &SurfaceReference, finder: &mut PathFinder) -> Restored {
        let scale = self.surface.frame.unit / known.frame.unit;
        let mapped = self.splines.iter().map(|s| map_spline(surface, &known.frame, scale, &s.geometry, finder));
        let (splines, reports) = mapped.unzip();
        let placed = self.lines.iter().map(|line| line.map(surface, &known.frame, scale, finder));
        let (lines, line_reports) = placed.unzip();
        Restored { splines, lines, mapping: Some(MappingReport { splines: reports, lines: line_reports }) }
    }
}

/// A fault, and the part that has it.
type Failed = (String, SplineFault);

/// What splines are restored on.
struct Restoring<'a> {
    surface: &'a Surface,
    /// The document's unit of length, in the surface's.
    scale: f64,
}

impl Restoring<'_> {
    fn spline(&self, stored: &StoredSpline, finder: &mut PathFinder) -> Result<Spline, Failed> {
        let StoredSpline { closed, jumps, scheme, anchors } = stored;
        let mut made = Vec::with_capacity(anchors.len());
        for (i, anchor) in anchors.iter().enumerate() {
            made.push(self.anchor(anchor).map_err(|(side, fault)| (format!("anchor {i}{side}"), fault))?);
        }
        let mut spline = Spline { anchors: made, closed: *closed, scheme: *scheme, jumps: *jumps };
        for (i, leg) in anchors.iter().enumerate().filter_map(|(i, anchor)| Some((i, anchor.middle.as_ref()?))) {
            let middle = self.middle(&spline, i, leg);
            spline.anchors[i].middle = Some(middle.map_err(|fault| (format!("middle leg {i}"), fault))?);
        }
        let whole = |fault| ("the whole".to_owned(), fault);
        spline.check(self.surface).map_err(|error| whole(error.into()))?;
        spline.settle_middles(self.surface, finder).map_err(|error| whole(error.into()))?;
        Ok(spline)
    }

    fn anchor(&self, stored: &StoredAnchor) -> Result<Anchor, (&'static str, SplineFault)> {
        let point = stored.point.0;
        self.surface.inner_point(&point).map_err(|error| ("", error.into()))?;
        Ok(Anchor {
            point,
            join: stored.join,
            incoming: self.handle(&stored.incoming, &point).map_err(|fault| (", incoming handle", fault))?,
            outgoing: self.handle(&stored.outgoing, &point).map_err(|fault| (", outgoing handle", fault))?,
            middle: None,
        })
    }

    fn handle(&self, stored: &StoredHandle, anchor: &SurfacePoint) -> Result<Handle, SplineFault> {
        let mut handle = stored.to_handle(anchor);
        let same = self.check_leg(&mut handle.leg)?;
        if !self.surface.same_place(&handle.leg.start, anchor) {
            return Err(SplineFault::Ends);
        }
        if !same {
            handle.wished_length = stored.wished.map_or(handle.leg.length, |wished| wished * self.scale);
        }
        Ok(handle)
    }

    fn middle(&self, spline: &Spline, segment: usize, stored: &StoredLeg) -> Result<GeodesicPath, SplineFault> {
        let next = &spline.anchors[(segment + 1) % spline.anchors.len()];
        let [from, to] =
            [spline.anchors[segment].handle(HandleSide::Outgoing).point(), next.handle(HandleSide::Incoming).point()];
        let mut leg = stored.to_path(&from, &to);
        self.check_leg(&mut leg)?;
        if self.surface.same_place(&leg.start, &from) && self.surface.same_place(&leg.end, &to) {
            Ok(leg)
        } else {
            Err(SplineFault::Ends)
        }
    }

    /// Checks that a leg runs over the surface and is as long as it says; tells whether it is just so. One that differs by the
    /// rounding of the mesh, or in scale, gets the length that is measured.
    fn check_leg(&self, leg: &mut GeodesicPath) -> Result<bool, SplineFault> {
        let measured = InnerPath::from_outer(self.surface, leg)?.length;
        let stored = leg.length;
        let missing = (measured - stored * self.scale).abs() / self.surface.diagonal();
        if missing <= SAME && self.scale == 1.0 {
            return Ok(true);
        }
        if missing <= ROUNDED {
            leg.length = measured;
            return Ok(false);
        }
        Err(SplineFault::Length { stored, measured })
    }
}
