//! Lines of a document: as they were drawn, and how they are smoothed.

use serde::{Deserialize, Deserializer, Serialize};

use super::stored::{StoredCrossing, StoredPoint};
use super::{Document, DocumentError, Frame, MappedSpline, SplineStyle, ranges};
use crate::geodesic::PathFinder;
use crate::smooth::{Envelope, PolylineError, Smoothing, SurfacePolyline};
use crate::surface::{PointError, Surface};
use glam::DVec3;

/// A line of a [`Document`], with what is not geometry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DocumentLine {
    /// Its name for people, of 1,000 bytes at most.
    #[serde(deserialize_with = "ranges::text::<_, 1_000>")]
    pub name: String,
    /// How it is drawn.
    pub style: SplineStyle,
    /// Whether it is not drawn at all.
    #[serde(default)]
    pub hidden: bool,
    /// Whether it is not to be edited.
    #[serde(default)]
    pub locked: bool,
    /// How it is smoothed, with lengths in the document's unit; none: it stays as it was drawn.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "smoothing")]
    pub smoothing: Option<Smoothing>,
    geometry: StoredLine,
}

/// The geometry of a line as a document holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredLine {
    /// Where it begins and ends; none if it is closed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ends: Option<(StoredPoint, StoredPoint)>,
    #[serde(deserialize_with = "ranges::list::<_, _, 1_000_000>")]
    crossings: Vec<StoredCrossing>,
    /// The crossings that are fixed.
    #[serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "ranges::list::<_, _, 1_000_000>")]
    fixed: Vec<u32>,
    /// Where its points are, ends included, in the coordinates of the mesh file.
    #[serde(deserialize_with = "ranges::list::<_, _, 1_000_002>")]
    positions: Vec<StoredPosition>,
}

/// A position whose numbers are checked while it is read.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct StoredPosition(#[serde(deserialize_with = "ranges::position")] [f64; 3]);

fn smoothing<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Smoothing>, D::Error> {
    let smoothing = Option::<Smoothing>::deserialize(d)?;
    let check = smoothing.map_or(Ok(()), |smoothing| smoothing.check());
    check.map_err(serde::de::Error::custom)?;
    Ok(smoothing)
}

/// A line that was restored, and how it is smoothed.
#[derive(Clone, Debug, PartialEq)]
pub struct RestoredLine {
    /// The line as it was drawn.
    pub line: SurfacePolyline,
    /// How it is smoothed, with lengths in the surface's local unit.
    pub smoothing: Option<Smoothing>,
}

impl Document {
    /// Adds a line that lies on the surface, and gives its place in the document to fill in what is not geometry.
    ///
    /// # Errors
    /// [`DocumentError::Line`] if it lies on another surface.
    pub fn add_line(
        &mut self,
        surface: &Surface,
        name: impl Into<String>,
        line: &SurfacePolyline,
        smoothing: Option<Smoothing>,
    ) -> Result<&mut DocumentLine, DocumentError> {
        let (name, index) = (name.into(), self.lines.len());
        let geometry = match StoredLine::of(surface, &self.surface.frame, line) {
            Ok(geometry) => geometry,
            Err(error) => return Err(DocumentError::Line { index, name, fault: Box::new(error.into()) }),
        };
        let style = SplineStyle::default();
        self.lines.push(DocumentLine { name, style, hidden: false, locked: false, smoothing, geometry });
        Ok(&mut self.lines[index])
    }
}

impl DocumentLine {
    /// The line bit for bit as it was; `scale` is the document's unit of length in the surface's.
    pub(super) fn restore(&self, surface: &Surface, scale: f64) -> Result<RestoredLine, PolylineError> {
        let crossings = self.geometry.crossings.iter().map(|crossing| crossing.0).collect();
        let mut line = match self.geometry.ends {
            Some((start, end)) => SurfacePolyline::open(surface, start.0, crossings, end.0)?,
            None => SurfacePolyline::closed(surface, crossings)?,
        };
        for crossing in &self.geometry.fixed {
            line.set_fixed(*crossing as usize, true)?;
        }
        Ok(RestoredLine { line, smoothing: self.smoothing.map(|smoothing| scaled(smoothing, scale)) })
    }

    /// The line anew, through the places nearest to where its points were. What was fixed is not any more.
    pub(super) fn map(
        &self,
        surface: &Surface,
        frame: &Frame,
        scale: f64,
        finder: &mut PathFinder,
    ) -> (Option<RestoredLine>, MappedSpline) {
        let mut report = MappedSpline::default();
        let mut points = Vec::with_capacity(self.geometry.positions.len());
        for StoredPosition(position) in &self.geometry.positions {
            let Some(found) = surface.closest_point(frame.of_file(DVec3::from_array(*position))) else {
                let reason = "a position is too far from the surface: open the mesh that the document names";
                report.refused = Some(reason.to_owned());
                return (None, report);
            };
            report.points += 1;
            report.largest_distance = report.largest_distance.max(found.distance);
            points.push(found.point);
        }
        match SurfacePolyline::through(surface, finder, &points, self.geometry.ends.is_none()) {
            Ok(line) => {
                let smoothing = self.smoothing.map(|smoothing| scaled(smoothing, scale));
                (Some(RestoredLine { line, smoothing }), report)
            }
            Err(error) => {
                report.refused = Some(error.to_string());
                (None, report)
            }
        }
    }
}

/// The same with its lengths in another unit.
fn scaled(smoothing: Smoothing, scale: f64) -> Smoothing {
    let length = |length: Option<f64>| length.map(|length| length * scale);
    let envelope = smoothing.envelope.map(|envelope| match envelope {
        Envelope::Hard(far) => Envelope::Hard(far * scale),
        Envelope::Soft(far) => Envelope::Soft(far * scale),
    });
    Smoothing { reach: length(smoothing.reach), barrier: length(smoothing.barrier), envelope, ..smoothing }
}

impl StoredLine {
    fn of(surface: &Surface, frame: &Frame, line: &SurfacePolyline) -> Result<Self, PointError> {
        let points = line.points();
        points.iter().try_for_each(|point| surface.inner_point(point).map(drop))?;
        let [start, end] = line.ends();
        let fixed = (0..line.crossings().len()).filter(|crossing| line.is_fixed(*crossing));
        Ok(Self {
            ends: (!line.is_closed()).then_some((StoredPoint(start), StoredPoint(end))),
            crossings: line.crossings().iter().map(|crossing| StoredCrossing(*crossing)).collect(),
            fixed: fixed.map(|crossing| crossing as u32).collect(),
            positions: points.iter().map(|point| StoredPosition(frame.hint(surface, point))).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::document::SurfaceReference;
    use crate::surface::{SurfaceOptions, shapes};

    /// A sphere with a jagged line around it, open or closed.
    fn jagged(closed: bool) -> (Surface, SurfacePolyline) {
        let surface = Surface::build(&shapes::icosphere(3), &SurfaceOptions::default()).unwrap();
        let at = |k: u32| {
            let angle = f64::from(k) * std::f64::consts::TAU / 40.0;
            let tremor = if k.is_multiple_of(2) { 0.1 } else { -0.1 };
            surface.closest_point(DVec3::new(angle.cos(), angle.sin(), tremor)).unwrap().point
        };
        let points: Vec<_> = (0..if closed { 40 } else { 30 }).map(at).collect();
        let mut line = SurfacePolyline::through(&surface, &mut PathFinder::new(), &points, closed).unwrap();
        line.set_fixed(5, true).unwrap();
        (surface, line)
    }

    #[test]
    fn lines_come_back_bit_for_bit() {
        for closed in [false, true] {
            let (surface, line) = jagged(closed);
            let smoothing = Smoothing { reach: Some(0.3), ..Smoothing::tether(20.0) };
            let mut document = Document::new(SurfaceReference::of(&surface));
            document.add_line(&surface, "edge", &line, Some(smoothing)).unwrap().locked = true;
            let text = document.to_ron().unwrap();
            let read = Document::from_ron(&text).unwrap();
            assert_eq!((&read, read.to_ron().unwrap()), (&document, text));
            let restored = read.restore(&surface, &mut PathFinder::new()).unwrap();
            assert_eq!(restored.lines, [Some(RestoredLine { line, smoothing: Some(smoothing) })]);
        }
    }

    #[test]
    fn on_another_mesh_lines_go_to_the_nearest_places() {
        for closed in [false, true] {
            let (surface, line) = jagged(closed);
            let mut document = Document::new(SurfaceReference::of(&surface));
            document.add_line(&surface, "edge", &line, None).unwrap();
            let finer = Surface::build(&shapes::icosphere(4), &SurfaceOptions::default()).unwrap();
            let restored = document.restore(&finer, &mut PathFinder::new()).unwrap();
            let mapping = restored.mapping.unwrap();
            assert_eq!((mapping.lines.len(), mapping.refused()), (1, 0));
            assert!(mapping.to_string().contains("and 1 lines"), "{mapping}");
            let mapped = restored.lines[0].as_ref().unwrap().line.clone();
            assert_eq!(mapped.is_closed(), closed);
            assert!((mapped.length(&finer) / line.length(&surface) - 1.0).abs() < 0.05);
        }
    }

    #[test]
    fn what_is_no_line_is_refused_in_words() {
        let (surface, line) = jagged(false);
        let mut document = Document::new(SurfaceReference::of(&surface));
        document.add_line(&surface, "edge", &line, Some(Smoothing::default())).unwrap();
        let text = document.to_ron().unwrap();
        let broken = text.replacen("closeness: 10.0", "closeness: -1.0", 1);
        assert_ne!(broken, text);
        let error = Document::from_ron(&broken).unwrap_err().to_string();
        assert!(error.contains("closeness"), "{error}");
        // A crossing that does not follow on the one before.
        document.lines[0].geometry.crossings.swap(3, 9);
        let error = document.restore(&surface, &mut PathFinder::new()).unwrap_err().to_string();
        assert!(error.contains("line 0 (`edge`)"), "{error}");
        let other = Surface::build(&shapes::cube(), &SurfaceOptions::default()).unwrap();
        assert!(Document::new(SurfaceReference::of(&other)).add_line(&other, "edge", &line, None).is_err());
    }
}
