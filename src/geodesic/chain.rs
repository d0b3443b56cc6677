//! Paths one after the other, pulled taut: what a path becomes when one of its ends is led along another.

use super::{GeodesicPath, PathError, PathFinder, PathQuality, inner::InnerPath};
use crate::surface::{HalfEdge, InnerPoint, Surface, SurfacePoint, Zeros};

impl PathFinder {
    /// Leads the end of a path along the shortest way to another point: the two one after the other, straightened.
    ///
    /// The result can be reached from the path by moving its end and shortening, so it winds about handles of the surface,
    /// and lies behind hills, as the path did; where it is no longer the shortest, [`shortest`](Self::shortest) finds
    /// another.
    ///
    /// Cost: linear in the two strips, a few sweeps.
    ///
    /// # Errors
    /// [`PathError`] if the point cannot be reached, or path or point do not belong to the surface.
    ///
    /// ```
    /// use bevy_surface_splines::{geodesic::PathFinder, surface::{Surface, SurfaceOptions, shapes}};
    /// use glam::DVec3;
    ///
    /// // Half way around a ring and on: the way that was taken, not the shorter way back.
    /// let surface = Surface::build(&shapes::torus(2.0, 0.5, 48, 16), &SurfaceOptions::default())?;
    /// let at = |angle: f64| surface.closest_point(2.5 * DVec3::new(angle.cos(), angle.sin(), 0.0)).unwrap().point;
    /// let mut finder = PathFinder::new();
    /// let half = finder.shortest(&surface, &at(0.0), &at(3.0))?;
    /// let on = finder.continued(&surface, &half, &at(3.5))?;
    /// assert!(on.length() > 1.1 * finder.shortest(&surface, &at(0.0), &at(3.5))?.length());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn continued(
        &mut self,
        surface: &Surface,
        path: &GeodesicPath,
        to: &SurfacePoint,
    ) -> Result<GeodesicPath, PathError> {
        let first = InnerPath::from_outer(surface, path)?;
        let mut second = InnerPath::default();
        self.shortest_inner(surface, &first.end, &surface.inner_point(to)?, PathQuality::Default, &mut second)?;
        Ok(self.chained(surface, &[&first, &second])?.to_outer(surface))
    }

    /// Some paths, each from where the one before ends, as one straightened path.
    ///
    /// Searched where they cannot be joined, which takes a hole in the surface at the point where two meet.
    pub(crate) fn chained(&mut self, surface: &Surface, pieces: &[&InnerPath]) -> Result<InnerPath, PathError> {
        let mut out = InnerPath::default();
        self.chained_into(surface, pieces, &mut out)?;
        Ok(out)
    }

    /// [`chained`](Self::chained) into reused memory; without pieces `out` stays as it is.
    pub(crate) fn chained_into(
        &mut self,
        surface: &Surface,
        pieces: &[&InnerPath],
        out: &mut InnerPath,
    ) -> Result<(), PathError> {
        let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else { return Ok(()) };
        let mut strip = self.lend_strip();
        strip.extend_from_slice(&first.strip);
        let joined = pieces.windows(2).all(|pair| {
            let joins = turn_into(surface, &pair[0].end, pair[1].start.face, &mut strip);
            strip.extend_from_slice(&pair[1].strip);
            joins
        });
        if joined {
            self.continue_inner(surface, &first.start, &last.end, &mut strip, out);
        }
        self.take_strip_back(strip);
        if joined {
            return Ok(());
        }
        self.shortest_inner(surface, &first.start, &last.end, PathQuality::Default, out)
    }
}

/// Extends a strip from the face a point is spelled in to another face around the point, the shorter way around a vertex;
/// says whether that face was reached.
pub(crate) fn turn_into(surface: &Surface, here: &InnerPoint, face: u32, strip: &mut Vec<HalfEdge>) -> bool {
    if here.face == face {
        return true;
    }
    match here.zeros() {
        Zeros::None => false,
        Zeros::Side(k) => {
            let h = HalfEdge::new(here.face, k);
            strip.push(h);
            surface.twin(h).is_some() && surface.twin(h).face() == face
        }
        Zeros::Corner(k) => {
            let start = HalfEdge::new(here.face, k);
            let around = |left: bool| {
                let mut crossed = Vec::new();
                let mut h = start;
                while h.face() != face {
                    let side = if left { h.prev() } else { h };
                    let twin = surface.twin(side);
                    if !twin.is_some() || (twin.face() == start.face() && !crossed.is_empty()) {
                        return None;
                    }
                    crossed.push(side);
                    h = if left { twin } else { twin.next() };
                }
                Some(crossed)
            };
            let ways = [around(true), around(false)];
            let shorter = ways.into_iter().flatten().min_by_key(Vec::len);
            shorter.map(|way| strip.extend(way)).is_some()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{SurfaceOptions, TriangleMesh, shapes};
    use glam::DVec3;

    #[test]
    fn there_and_back_is_nowhere() {
        let surface = Surface::build(&shapes::torus(2.0, 0.8, 40, 20), &SurfaceOptions::default()).unwrap();
        let mut finder = PathFinder::new();
        let at = |p: DVec3| surface.closest_point(p).unwrap().point;
        for (a, b) in [(DVec3::X, DVec3::Y), (surface.positions[3], surface.positions[400]), (DVec3::X, -DVec3::X)] {
            let path = finder.shortest(&surface, &at(a), &at(b)).unwrap();
            let back = finder.continued(&surface, &path, &at(a)).unwrap();
            assert!(back.length() < 1e-9, "{}", back.length());
        }
    }

    #[test]
    fn small_steps_lead_all_the_way_around() {
        let surface = Surface::build(&shapes::torus(2.0, 0.5, 64, 24), &SurfaceOptions::default()).unwrap();
        let mut finder = PathFinder::new();
        let at = |k: u32| {
            let angle = f64::from(k) / 40.0 * std::f64::consts::TAU + 0.02;
            surface.closest_point(DVec3::new(angle.cos(), angle.sin(), 0.0) * 2.5 + DVec3::Z * 0.1).unwrap().point
        };
        let mut path = finder.shortest(&surface, &at(0), &at(1)).unwrap();
        for k in 2..=80 {
            path = finder.continued(&surface, &path, &at(k)).unwrap();
        }
        // Twice around on the inner side, which is the shortest of its kind and the same way back.
        assert!(path.length() > 1.9 * std::f64::consts::TAU * 1.5, "{}", path.length());
        let home = path.reversed(&surface).unwrap();
        assert!((home.length() - path.length()).abs() < 1e-9);
    }

    /// A vertex with more than four full turns about it: sixteen right angles. What a strip turns by is not known in the
    /// plane, where a full turn looks like none.
    #[test]
    fn led_around_a_saddle_the_other_side_is_found() {
        let ring = |k: u32| {
            let angle = f64::from(k) / 16.0 * std::f64::consts::TAU;
            DVec3::new(angle.cos(), angle.sin(), if k.is_multiple_of(2) { 1.0 } else { -1.0 })
        };
        let mesh = TriangleMesh {
            positions: std::iter::once(DVec3::ZERO).chain((0..16).map(ring)).collect(),
            faces: (0..16).map(|k| [0, 1 + k, 1 + (k + 1) % 16]).collect(),
        };
        let surface = Surface::build(&mesh, &SurfaceOptions::default()).unwrap();
        let at = |face: u32| surface.point(crate::surface::FaceId(face), [0.4, 0.3, 0.3]).unwrap();
        let mut finder = PathFinder::new();
        let mut path = GeodesicPath::at_rest(at(0));
        for face in 1..16 {
            path = finder.continued(&surface, &path, &at(face)).unwrap();
            let shortest = finder.shortest(&surface, &at(0), &at(face)).unwrap();
            assert!(
                (path.length() - shortest.length()).abs() < 1e-12,
                "{face}: {} {}",
                path.length(),
                shortest.length()
            );
        }
    }
}
