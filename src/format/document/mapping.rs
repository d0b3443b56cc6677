//! Splines of a document on another surface: every point goes to the closest place.

use std::fmt;

use glam::DVec3;

use super::Frame;
use super::stored::{StoredHandle, StoredSpline};
use crate::curve::{Anchor, Handle, Join, Spline, handles};
use crate::geodesic::{PathError, PathFinder};
use crate::surface::{Surface, SurfacePoint};

/// How splines were placed on a surface that is not the document's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MappingReport {
    /// Of each spline, in the order of the document.
    pub splines: Vec<MappedSpline>,
    /// Of each line, likewise.
    pub lines: Vec<MappedSpline>,
}

/// How a spline was placed on a surface that is not the document's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MappedSpline {
    /// Number of points that were placed, anchors and handles.
    pub points: usize,
    /// How far the position of a point lay from the surface at most, in the surface's local unit.
    pub largest_distance: f64,
    /// Why the spline could not be placed, if it could not.
    pub refused: Option<String>,
}

impl MappingReport {
    /// How far the position of any point lay from the surface at most, in the surface's local unit.
    pub fn largest_distance(&self) -> f64 {
        self.all().map(|s| s.largest_distance).fold(0.0, f64::max)
    }

    /// How many splines and lines could not be placed.
    pub fn refused(&self) -> usize {
        self.all().filter(|s| s.refused.is_some()).count()
    }

    fn all(&self) -> impl Iterator<Item = &MappedSpline> {
        self.splines.iter().chain(&self.lines)
    }
}

impl fmt::Display for MappingReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let points: usize = self.all().map(|s| s.points).sum();
        let placed = |all: &[MappedSpline]| all.iter().filter(|s| s.refused.is_none()).count();
        let (splines, lines, largest) = (placed(&self.splines), placed(&self.lines), self.largest_distance());
        let lines = if self.lines.is_empty() { String::new() } else { format!(" and {lines} lines") };
        write!(
            f,
            "the mesh is not the document's: {points} points of {splines} splines{lines} were moved to the closest places"
        )?;
        write!(f, ", by {largest:.3e} at most")?;
        let refused = |(i, s): (usize, &MappedSpline)| Some((i, s.refused.clone()?));
        for (i, reason) in self.splines.iter().enumerate().filter_map(refused) {
            write!(f, "; spline {i} was left out: {reason}")?;
        }
        for (i, reason) in self.lines.iter().enumerate().filter_map(refused) {
            write!(f, "; line {i} was left out: {reason}")?;
        }
        Ok(())
    }
}

/// Places a spline; `scale` is the document's unit of length in the surface's.
pub(super) fn map_spline(
    surface: &Surface,
    frame: &Frame,
    scale: f64,
    stored: &StoredSpline,
    finder: &mut PathFinder,
) -> (Option<Spline>, MappedSpline) {
    let mut mapping = Mapping { surface, frame, scale, report: MappedSpline::default() };
    let spline = mapping.spline(stored, finder);
    let mut report = mapping.report;
    match spline {
        Ok(spline) => (Some(spline), report),
        Err(reason) => {
            report.refused = Some(reason);
            (None, report)
        }
    }
}

struct Mapping<'a> {
    surface: &'a Surface,
    frame: &'a Frame,
    scale: f64,
    report: MappedSpline,
}

impl Mapping<'_> {
    fn spline(&mut self, stored: &StoredSpline, finder: &mut PathFinder) -> Result<Spline, String> {
        let StoredSpline { closed, jumps, scheme, anchors } = stored;
        let mut made = Vec::with_capacity(anchors.len());
        for anchor in anchors {
            let point = self.closest(DVec3::from_array(anchor.position))?;
            let bare = handles::bare_anchor(self.surface, point).map_err(|error| error.to_string())?;
            made.push(Anchor { join: anchor.join, ..bare });
        }
        let mut spline = Spline { anchors: made, closed: *closed, scheme: *scheme, jumps: *jumps };
        for (i, anchor) in anchors.iter().enumerate() {
            let at = spline.anchors[i].point;
            spline.anchors[i].incoming = self.handle(&at, &anchor.incoming, finder)?;
            spline.anchors[i].outgoing = self.handle(&at, &anchor.outgoing, finder)?;
            let aligned = match anchor.join {
                Join::Corner => Ok(()),
                Join::Smooth | Join::Mirrored => {
                    let equal = anchor.join == Join::Mirrored;
                    handles::align(self.surface, &mut spline.anchors[i], equal).map_err(PathError::from)
                }
                Join::Automatic => handles::place_automatic(self.surface, finder, &mut spline, i),
            };
            aligned.map_err(|error| error.to_string())?;
        }
        spline.check(self.surface).map_err(|error| error.to_string())?;
        spline.settle_middles(self.surface, finder).map_err(|error| error.to_string())?;
        Ok(spline)
    }

    fn closest(&mut self, in_file: DVec3) -> Result<SurfacePoint, String> {
        let found = self.surface.closest_point(self.frame.of_file(in_file));
        let found = found.ok_or("a position is too far from the surface: open the mesh that the document names")?;
        self.report.points += 1;
        self.report.largest_distance = self.report.largest_distance.max(found.distance);
        Ok(found.point)
    }

    fn handle(
        &mut self,
        anchor: &SurfacePoint,
        stored: &StoredHandle,
        finder: &mut PathFinder,
    ) -> Result<Handle, String> {
        let to = stored.hint().map_or(Ok(*anchor), |hint| self.closest(hint))?;
        let mut handle = handles::towards(self.surface, finder, anchor, &to).map_err(|error| error.to_string())?;
        // What was cut short at a boundary goes on wishing.
        if let (Some(wished), Some(leg)) = (stored.wished, &stored.leg)
            && wished > leg.length
        {
            handle.wished_length = (wished * self.scale).clamp(handle.leg.length, f64::MAX);
        }
        Ok(handle)
    }
}
