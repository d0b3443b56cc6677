//! Traces as lines of other programs: OBJ, CSV and glTF.
//!
//! Every vertex of a line has a position, the surface's normal there and its distance along the trace. A torn trace is
//! several lines.
//!
//! | format | position | normal | distance |
//! |---|---|---|---|
//! | OBJ | `v` | `vn`, one for each `v` | `vt`, which the `l` elements name |
//! | CSV | `x`, `y`, `z` | `normal_x`, `normal_y`, `normal_z` | `distance` |
//! | GLB | `POSITION` | `NORMAL` | `_DISTANCE`, a scalar; a `LINE_STRIP` for each line |
//!
//! OBJ and CSV hold numbers to the last bit, GLB as `f32`.

mod glb;
mod text;

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::save::{SaveError, replace_file};
use crate::curve::Trace;
use crate::geodesic::GeodesicPath;
use crate::surface::{FaceId, Surface, SurfacePoint};

/// A vertex of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineVertex {
    /// Its position, in the surface's local space.
    pub position: DVec3,
    /// Unit normal of the surface: of the face it is in, halfway between both on a side; zero where faces have no area.
    pub normal: DVec3,
    /// Distance along the trace, in local units.
    pub distance: f64,
}

/// A trace on its way out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExportedTrace {
    /// Its name for people.
    pub name: String,
    /// Its unbroken pieces: a single one, unless the curve is torn.
    pub lines: Vec<Vec<LineVertex>>,
}

/// Traces that leave in one file.
///
/// ```
/// use bevy_surface_splines::{curve::*, format::export::TraceExport, surface::*};
///
/// let surface = Surface::build(&shapes::icosphere(3), &SurfaceOptions::default())?;
/// let polygon = [5, 70, 140, 200].map(|face| surface.point(FaceId(face), [0.2, 0.3, 0.5]).unwrap());
/// let trace = Tracer::new(&surface).trace(&polygon, &Scheme::lane_riesenfeld())?;
///
/// let mut export = TraceExport::default();
/// export.add(&surface, "orbit", &trace)?;
/// let path = std::env::temp_dir().join("trace_export_doctest.glb");
/// export.save(&path)?; // or .obj, or .csv
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TraceExport {
    /// The traces, in order.
    pub traces: Vec<ExportedTrace>,
}

/// Why traces cannot be exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The trace was made on another surface.
    #[error("the trace `{name}` was made on another surface: trace the spline on this one")]
    OtherSurface {
        /// Its name.
        name: String,
    },
    /// No format has this extension.
    #[error("{}: not a format of lines: give the file the extension obj, csv or glb", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// GLB holds 32-bit numbers.
    #[error("the lines do not fit into a GLB, which holds positions up to 3e38 and 4 GiB: export OBJ or CSV")]
    TooLarge,
    /// The file cannot be written; the old one is as it was.
    #[error(transparent)]
    Save(#[from] SaveError),
}

impl TraceExport {
    /// Adds a trace. Linear in its polyline.
    ///
    /// # Errors
    /// [`ExportError::OtherSurface`].
    pub fn add(&mut self, surface: &Surface, name: impl Into<String>, trace: &Trace) -> Result<(), ExportError> {
        let name = name.into();
        let Some(vertices) = vertices_of(surface, trace) else { return Err(ExportError::OtherSurface { name }) };
        let lines = trace.pieces().into_iter().filter_map(|piece| Some(vertices.get(piece)?.to_vec())).collect();
        self.traces.push(ExportedTrace { name, lines });
        Ok(())
    }

    /// Writes a file in the format that its extension names, replacing it only when all is written.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), ExportError> {
        let path = path.as_ref();
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let bytes = match extension.as_deref() {
            Some("obj") => self.to_obj().into_bytes(),
            Some("csv") => self.to_csv().into_bytes(),
            Some("glb") => self.to_glb()?,
            _ => return Err(ExportError::UnknownFormat { path: path.to_owned() }),
        };
        Ok(replace_file(path, |file| file.write_all(&bytes))?)
    }
}

impl Trace {
    /// Writes the polyline in the format that the file's extension names: OBJ, CSV or GLB, see [`format::export`](mod@crate::format::export).
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn save_lines(&self, surface: &Surface, path: impl AsRef<Path>) -> Result<(), ExportError> {
        let mut export = TraceExport::default();
        export.add(surface, "curve", self)?;
        export.save(path)
    }

    /// Writes the polyline as OBJ lines with normals and distances, whatever the file is called.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn write_obj(&self, surface: &Surface, path: impl AsRef<Path>) -> Result<(), ExportError> {
        let mut export = TraceExport::default();
        export.add(surface, "curve", self)?;
        Ok(replace_file(path, |file| file.write_all(export.to_obj().as_bytes()))?)
    }
}

/// A vertex for each of the trace's positions; none if it was made on another surface.
fn vertices_of(surface: &Surface, trace: &Trace) -> Option<Vec<LineVertex>> {
    let mut out: Vec<LineVertex> = Vec::new();
    let mut before = 0.0;
    for segment in trace.segments() {
        let mut normals = vec![DVec3::ZERO; segment.polyline().len()];
        for (path, begin) in segment.paths().iter().zip(&segment.begins) {
            let there = normals.get_mut(*begin as usize..)?;
            // A vertex that ends a path begins the next one, in a face that may be another; the first says.
            for (k, normal) in normals_of(surface, path)?.into_iter().enumerate() {
                let slot = there.get_mut(k)?;
                *slot = if k == 0 && *begin > 0 { *slot } else { normal };
            }
        }
        let skip = usize::from(!out.is_empty());
        let all = segment.polyline().iter().zip(&segment.distances).zip(normals);
        out.extend(all.skip(skip).map(|((p, d), normal)| LineVertex { position: *p, normal, distance: before + d }));
        before += segment.length();
    }
    Some(out)
}

/// Normals at the start of a path, at its crossings and at its end.
fn normals_of(surface: &Surface, path: &GeodesicPath) -> Option<Vec<DVec3>> {
    let of = |face: FaceId| {
        let normal = surface.normal(&SurfacePoint { face, weights: [1.0, 0.0, 0.0] });
        (!normal.is_nan()).then_some(normal)
    };
    let faces: Option<Vec<DVec3>> = path.crossings().iter().map(|c| c.face).chain([path.end().face]).map(of).collect();
    let faces = faces?;
    let sides = faces.windows(2).map(|pair| (pair[0] + pair[1]).normalize_or_zero());
    Some(faces.first().copied().into_iter().chain(sides).chain(faces.last().copied()).collect())
}
