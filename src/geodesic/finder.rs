//! Shortest paths: search a strip, straighten it.

use super::{
    GeodesicPath, PathQuality,
    corridor::{Corridor, far_apart},
    guess::Guess,
    inner::{InnerPath, reverse_strip},
    search::{Found, Search},
    straighten::{Straightener, order},
};
use crate::surface::{HalfEdge, InnerPoint, PointError, Surface, SurfacePoint};

/// A path must be shorter than another by this factor to be taken instead; less is rounding.
const SHORTER: f64 = 1.0 - 1e-12;

/// A search of more labels than this is worth a corridor.
const BRIEF: usize = 1 << 15;

/// Why there is no path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PathError {
    /// A point does not belong to the surface.
    #[error(transparent)]
    Point(#[from] PointError),
    /// The points lie on different sheets.
    #[error("no path joins {} and {}: they lie on separate pieces of the surface; pick both on one piece", from.face, to.face)]
    NoPath {
        /// One point.
        from: SurfacePoint,
        /// The other.
        to: SurfacePoint,
    },
}

/// Finds locally shortest paths.
///
/// It owns the scratch memory: keep one a thread and reuse it, for any surface. Once warm, a query allocates nothing but its
/// result.
///
/// ```
/// use bevy_surface_splines::{geodesic::PathFinder, surface::{FaceId, Surface, SurfaceOptions, SurfacePoint, shapes}};
///
/// let surface = Surface::build(&shapes::cube(), &SurfaceOptions::default())?;
/// let corner = |p: glam::DVec3| surface.closest_point(p).unwrap().point;
/// let path = PathFinder::new().shortest(&surface, &corner(glam::DVec3::ZERO), &corner(glam::DVec3::ONE))?;
/// assert!((path.length() - 5.0_f64.sqrt()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct PathFinder {
    search: Search,
    back: Search,
    guess: Guess,
    corridor: Corridor,
    straightener: Straightener,
    strip: Vec<HalfEdge>,
    /// To build strips to continue in.
    spare_strip: Vec<HalfEdge>,
    spare_paths: Vec<InnerPath>,
    path: InnerPath,
    other_path: InnerPath,
}

impl PathFinder {
    /// Makes a finder; memory is taken where queries lead: 64 bytes a face that one query reaches, and 170 a label.
    pub fn new() -> Self {
        Self::default()
    }

    /// Finds a locally shortest path from one point to another.
    ///
    /// The path is straight across sides, and where it bends at a vertex both angles on the surface are at least π. It is
    /// nearly always globally shortest too (see [`PathQuality`]).
    /// Swapping the points gives the same path reversed, bit for bit. Two points in one face are joined by a straight line.
    ///
    /// Cost: about 0.1 µs for each side of an ellipse about the path, then a few sweeps over the strip; around 1 ms across a
    /// model of 100,000 faces, 15 ms across one of 1.4 million.
    ///
    /// # Errors
    /// [`PathError::NoPath`] between sheets, [`PathError::Point`] if a point does not belong to the surface.
    pub fn shortest(
        &mut self,
        surface: &Surface,
        from: &SurfacePoint,
        to: &SurfacePoint,
    ) -> Result<GeodesicPath, PathError> {
        self.shortest_with_quality(surface, from, to, PathQuality::Default)
    }

    /// [`shortest`](Self::shortest) of a quality.
    ///
    /// # Errors
    /// As [`shortest`](Self::shortest).
    pub fn shortest_with_quality(
        &mut self,
        surface: &Surface,
        from: &SurfacePoint,
        to: &SurfacePoint,
        quality: PathQuality,
    ) -> Result<GeodesicPath, PathError> {
        let mut path = GeodesicPath::at_rest(*from);
        self.shortest_into(surface, from, to, quality, &mut path)?;
        Ok(path)
    }

    /// [`shortest_with_quality`](Self::shortest_with_quality) into a path whose memory is reused: once warm, nothing is
    /// allocated.
    ///
    /// # Errors
    /// As [`shortest`](Self::shortest); `out` is then as it was.
    pub fn shortest_into(
        &mut self,
        surface: &Surface,
        from: &SurfacePoint,
        to: &SurfacePoint,
        quality: PathQuality,
        out: &mut GeodesicPath,
    ) -> Result<(), PathError> {
        let (from, to) = (surface.inner_point(from)?, surface.inner_point(to)?);
        let mut path = std::mem::take(&mut self.path);
        let found = self.shortest_inner(surface, &from, &to, quality, &mut path);
        if found.is_ok() {
            path.outer_into(surface, out);
        }
        self.path = path;
        found
    }

    /// [`shortest`](Self::shortest) in inner spelling, into reused memory.
    pub(crate) fn shortest_inner(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        to: &InnerPoint,
        quality: PathQuality,
        out: &mut InnerPath,
    ) -> Result<(), PathError> {
        let sheet = |p: &InnerPoint| surface.sheet[p.face as usize];
        if sheet(from) != sheet(to) {
            return Err(no_path(surface, from, to));
        }
        let backwards = order(to, from).is_lt();
        let (first, second) = if backwards { (to, from) } else { (from, to) };
        if let Some((start, end)) = in_one_face(surface, first, second) {
            out.set_straight(surface, start, end);
        } else {
            let mut strip = std::mem::take(&mut self.strip);
            let result = match self.find_strip(surface, first, second, quality, &mut strip) {
                Some(ends) => {
                    if quality == PathQuality::Fast {
                        self.straightener.run(surface, ends.start, ends.end, &mut strip, out);
                    } else {
                        self.straightener.run_thoroughly(surface, ends.start, ends.end, &mut strip, out);
                    }
                    if quality == PathQuality::Best {
                        self.look_back(surface, first, second, &mut strip, out);
                    }
                    Ok(())
                }
                None => Err(no_path(surface, from, to)),
            };
            self.strip = strip;
            result?;
        }
        if backwards {
            out.reverse(surface);
        }
        Ok(())
    }

    /// A strip between two points of one sheet that share no face.
    fn find_strip(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        to: &InnerPoint,
        quality: PathQuality,
        strip: &mut Vec<HalfEdge>,
    ) -> Option<Found> {
        let near_a_way = match quality {
            PathQuality::Fast => self.guess.run(surface, from, to, &mut self.corridor, strip),
            PathQuality::Default | PathQuality::Best => {
                // Points that are near in space may be far apart on the surface: a search tells.
                let near = !far_apart(surface, from, to);
                let found = if near { self.search.run_briefly(surface, from, to, BRIEF, strip) } else { None };
                found.or_else(|| {
                    self.corridor.along_short_ways(surface, from, to);
                    self.search.run_inside(surface, from, to, &self.corridor, strip)
                })
            }
        };
        near_a_way.or_else(|| self.search.run(surface, from, to, strip))
    }

    /// Searches the other way round, and takes that path where it is shorter than the one found.
    fn look_back(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        to: &InnerPoint,
        strip: &mut Vec<HalfEdge>,
        path: &mut InnerPath,
    ) {
        let found = self.back.run_back(surface, to, from, &self.search, path.length, strip);
        let Some(ends) = found else { return };
        reverse_strip(surface, strip);
        self.straightener.run_thoroughly(surface, ends.end, ends.start, strip, &mut self.other_path);
        if self.other_path.length < path.length * SHORTER && !self.other_path.frozen {
            path.copy_from(&self.other_path);
        }
    }

    /// Some path to be overwritten, and to be given back.
    pub(crate) fn lend_path(&mut self) -> InnerPath {
        self.spare_paths.pop().unwrap_or_default()
    }

    /// Takes a lent path back, for the next who asks.
    pub(crate) fn take_path_back(&mut self, path: InnerPath) {
        self.spare_paths.push(path);
    }

    /// An empty strip, to be given back.
    pub(crate) fn lend_strip(&mut self) -> Vec<HalfEdge> {
        let mut strip = std::mem::take(&mut self.spare_strip);
        strip.clear();
        strip
    }

    /// Takes a lent strip back, for the next who asks.
    pub(crate) fn take_strip_back(&mut self, strip: Vec<HalfEdge>) {
        self.spare_strip = strip;
    }

    /// Straightens a known strip instead of searching one: the result can be reached from it by shortening alone.
    pub(crate) fn continue_inner(
        &mut self,
        surface: &Surface,
        start: &InnerPoint,
        end: &InnerPoint,
        strip: &mut [HalfEdge],
        out: &mut InnerPath,
    ) {
        self.straightener.run(surface, *start, *end, strip, out);
    }
}

fn no_path(surface: &Surface, from: &InnerPoint, to: &InnerPoint) -> PathError {
    PathError::NoPath { from: surface.outer_point(from), to: surface.outer_point(to) }
}

/// Spellings of two points in a face they share, if they do.
fn in_one_face(surface: &Surface, a: &InnerPoint, b: &InnerPoint) -> Option<(InnerPoint, InnerPoint)> {
    if a.face == b.face {
        return Some((*a, *b));
    }
    let mut found: Option<(InnerPoint, InnerPoint)> = None;
    surface.for_each_spelling(a, |p| {
        surface.for_each_spelling(b, |q| {
            if p.face == q.face && found.is_none_or(|f| p.face < f.0.face) {
                found = Some((p, q));
            }
        });
    });
    found
}

impl Surface {
    /// Finds a locally shortest path; for many queries keep a [`PathFinder`].
    ///
    /// # Errors
    /// As [`PathFinder::shortest`].
    pub fn shortest_path(&self, from: &SurfacePoint, to: &SurfacePoint) -> Result<GeodesicPath, PathError> {
        PathFinder::new().shortest(self, from, to)
    }
}

#[cfg(test)]
mod tests;
