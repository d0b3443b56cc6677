//! Documents: splines and drawn lines, and the surface they lie on, as a text that people can read.
//!
//! The format is [RON](https://github.com/ron-rs/ron) with a version number in front. The mesh is not in the document; a
//! [`SurfaceReference`] says where it lies and by what it is known again. On that mesh splines come back bit for bit. On
//! another, or another version of it, they are placed anew: every point goes to the place nearest to the position that the
//! document holds for it, and a [`MappingReport`] says how far that was.
//!
//! Nothing in a file is trusted: numbers are checked against their ranges while they are read, and legs against the surface
//! before they become paths.

mod error;
mod lines;
mod mapping;
mod ranges;
mod recent;
mod recovery;
mod reference;
mod restore;
mod stored;
mod text;

#[cfg(feature = "svg")]
pub(crate) use text::{place, version_of};

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use error::{DocumentError, SplineFault};
pub use lines::{DocumentLine, RestoredLine};
pub use mapping::{MappedSpline, MappingReport};
pub use recent::Recent;
pub use recovery::{Autosave, Recovery};
pub use reference::{Fingerprint, Frame, SurfaceReference};
pub use restore::Restored;
use stored::StoredSpline;

use super::{regular, save};
use crate::curve::Spline;
use crate::surface::Surface;

/// Splines, the surface they lie on, and how they were looked at.
///
/// ```
/// use bevy_surface_splines::{curve::Spline, format::document::*, geodesic::PathFinder, surface::*};
///
/// let surface = Surface::build(&shapes::icosphere(3), &SurfaceOptions::default())?;
/// let points = [3, 70, 140].map(|face| surface.point(FaceId(face), [0.2, 0.3, 0.5]).unwrap());
/// let mut finder = PathFinder::new();
/// let spline = Spline::smooth_through(&surface, &mut finder, &points, true)?;
///
/// let mut document = Document::new(SurfaceReference::of(&surface).at("planet.obj"));
/// document.add(&surface, "orbit", &spline)?;
/// let path = std::env::temp_dir().join("document_doctest.splines.ron");
/// document.save(&path)?;
///
/// let restored = Document::open(&path)?.restore(&surface, &mut finder)?;
/// assert_eq!(restored.splines, [Some(spline)]);
/// assert!(restored.mapping.is_none()); // it is the same surface
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Document {
    version: u32,
    /// The surface.
    pub surface: SurfaceReference,
    /// How it was looked at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<View>,
    /// The splines, in order.
    #[serde(deserialize_with = "ranges::list::<_, _, 10_000>")]
    pub splines: Vec<DocumentSpline>,
    /// Lines that are no splines, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "ranges::list::<_, _, 10_000>")]
    pub lines: Vec<DocumentLine>,
}

/// A spline of a [`Document`], with what is not geometry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DocumentSpline {
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
    geometry: StoredSpline,
}

/// How a spline is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SplineStyle {
    /// Red, green, blue (sRGB) and opacity, from 0 to 1.
    #[serde(deserialize_with = "ranges::colour")]
    pub colour: [f32; 4],
    /// Width of the line in logical pixels, at most 1,000.
    #[serde(deserialize_with = "ranges::width")]
    pub width: f32,
}

impl Default for SplineStyle {
    fn default() -> Self {
        Self { colour: [1.0, 0.6, 0.1, 1.0], width: 3.0 }
    }
}

/// Where a camera that circles about a target stands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// What it looks at, in the coordinates of the program that wrote it.
    #[serde(deserialize_with = "ranges::target")]
    pub target: [f64; 3],
    /// Angle about the vertical, in radians.
    #[serde(deserialize_with = "ranges::yaw")]
    pub yaw: f64,
    /// Angle above the horizon, in radians, between −2 and 2.
    #[serde(deserialize_with = "ranges::pitch")]
    pub pitch: f64,
    /// Distance from the target.
    #[serde(deserialize_with = "ranges::distance")]
    pub distance: f64,
    /// Whether what is far is not drawn smaller.
    #[serde(default)]
    pub orthographic: bool,
}

impl Document {
    /// The version of the format that is written, and the newest that is read.
    pub const VERSION: u32 = 1;
    /// How files of documents end.
    pub const EXTENSION: &str = "splines.ron";

    /// A document without splines.
    pub fn new(surface: SurfaceReference) -> Self {
        Self { version: Self::VERSION, surface, view: None, splines: Vec::new(), lines: Vec::new() }
    }

    /// Adds a spline that lies on the surface, and gives its place in the document to fill in what is not geometry.
    ///
    /// # Errors
    /// [`DocumentError::Spline`] if it lies on another surface.
    pub fn add(
        &mut self,
        surface: &Surface,
        name: impl Into<String>,
        spline: &Spline,
    ) -> Result<&mut DocumentSpline, DocumentError> {
        let (name, index) = (name.into(), self.splines.len());
        let geometry = match StoredSpline::of(surface, &self.surface.frame, spline) {
            Ok(geometry) => geometry,
            Err((anchor, error)) => {
                return Err(DocumentError::Spline {
                    index,
                    name,
                    part: format!("anchor {anchor}"),
                    fault: Box::new(error.into()),
                });
            }
        };
        let style = SplineStyle::default();
        self.splines.push(DocumentSpline { name, style, hidden: false, locked: false, geometry });
        Ok(&mut self.splines[index])
    }

    /// Opens a file, and removes what processes that died while saving it have left beside it.
    ///
    /// # Errors
    /// [`DocumentError`]: the file cannot be read, or not as a document.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, DocumentError> {
        let path = path.as_ref();
        save::remove_leftovers(path);
        let bytes = regular::read_file(path, text::MAX_BYTES.saturating_add(1));
        Self::from_bytes(&bytes.map_err(|source| DocumentError::Io { path: path.to_owned(), source })?)
    }

    /// Writes a file, all or nothing: see [`replace_file`](save::replace_file).
    ///
    /// # Errors
    /// [`DocumentError`]: a value is out of its range, or the file cannot be written. The old file is then as it was.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), DocumentError> {
        let text = self.to_ron()?;
        Ok(save::replace_file(path, |file| file.write_all(text.as_bytes()))?)
    }
}
