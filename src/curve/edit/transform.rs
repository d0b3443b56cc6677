//! Moving, turning and scaling many anchors at once, about a point of the surface.

use glam::DMat2;

use super::{EditError, JumpPolicy, jumps::Led};
use crate::curve::{
    Anchor, Spline,
    normal::{Coordinates, Frame, normalised, placed, settle_automatic},
};
use crate::geodesic::{PathFinder, PathQuality, Tangent, inner::InnerPath};
use crate::surface::{Surface, SurfacePoint};

/// A move, turn, scale or shear of anchors with their handles, as plain data.
///
/// Anchors are taken by direction and length from the centre, these are mapped, the centre moves on the shortest path to
/// its new place and takes directions along by parallel transport, and from there the anchors are put down again by
/// walking. Handles go with their anchors in the same way, so smooth joins stay smooth. In the plane that is the affine map;
/// on a sphere it is exact for turns and for moves of everything.
///
/// A gesture sends the whole transform since its beginning, always of the splines as they were then. For a selection of several
/// splines it is the same for each, but for the anchors.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct SelectionTransform {
    /// Which anchors, in any order; none: all.
    pub anchors: Option<Vec<u32>>,
    /// The point that directions and lengths are counted from.
    pub centre: SurfacePoint,
    /// Where that point goes.
    pub to: SurfacePoint,
    /// What becomes of directions and lengths.
    pub matrix: DMat2,
    /// The matrix' x axis, a direction at the centre; none: along the first side of the centre's face. Turns and even scalings
    /// are the same in all axes.
    pub axis: Option<Tangent>,
    /// What the coordinates are counted from.
    pub coordinates: Coordinates,
}

impl SelectionTransform {
    /// All anchors, with a matrix, about a point.
    pub fn new(centre: SurfacePoint, matrix: DMat2) -> Self {
        Self { anchors: None, centre, to: centre, matrix, axis: None, coordinates: Coordinates::Normal }
    }

    /// All anchors, moved as a point moves.
    pub fn translation(from: SurfacePoint, to: SurfacePoint) -> Self {
        Self { to, ..Self::new(from, DMat2::IDENTITY) }
    }

    /// All anchors, turned about a point counter-clockwise as seen against the normal, by an angle in radians.
    pub fn rotation(centre: SurfacePoint, angle: f64) -> Self {
        Self::new(centre, DMat2::from_angle(angle))
    }

    /// All anchors, scaled about a point.
    pub fn scaling(centre: SurfacePoint, factor: f64) -> Self {
        Self::new(centre, DMat2::from_diagonal(glam::DVec2::splat(factor)))
    }

    /// The same of some anchors.
    pub fn of(mut self, anchors: impl IntoIterator<Item = u32>) -> Self {
        self.anchors = Some(anchors.into_iter().collect());
        self
    }

    /// The same with coordinates from neighbour to neighbour.
    pub fn chained(mut self) -> Self {
        self.coordinates = Coordinates::Chained;
        self
    }

    fn is_identity(&self) -> bool {
        self.matrix == DMat2::IDENTITY && self.centre.same_bits(&self.to)
    }
}

/// What a transform makes of a spline.
#[derive(Clone, Debug, PartialEq)]
pub struct Transformed {
    /// The spline.
    pub spline: Spline,
    /// Anchors that would have left the surface and stay at its boundary.
    pub clipped: Vec<u32>,
    /// Anchors that stay where they were, because they lie on another piece of the surface than the centre.
    pub left: Vec<u32>,
}

/// Whether a matrix keeps things apart that are.
pub(crate) fn check_matrix(matrix: DMat2) -> Result<(), EditError> {
    let largest = matrix.to_cols_array().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let is_sound =
        matrix.is_finite() && largest < 1e12 && matrix.determinant().abs() > 1e-18 * largest * largest.max(1e-9);
    if is_sound && largest > 1e-12 { Ok(()) } else { Err(EditError::BadTransform) }
}

impl Spline {
    /// The spline after a transform, with what became of anchors that could not follow it:
    /// [`SplineEdit::Transform`](super::SplineEdit::Transform) does the same and says nothing.
    ///
    /// The identity gives the spline bit for bit. Turned back by the same angle, anchors are within 1e-9 of the diagonal of where
    /// they were, unless the shortest path to them bends at a vertex. Small changes of the transform move anchors a little, unless
    /// the centre, or with [`Chained`](Coordinates::Chained) an anchor, lies exactly on a vertex: there is no tangent plane there.
    /// Legs that belong to the document are led along; none is split where it would jump.
    ///
    /// Cost: a shortest path and three straight walks for each anchor.
    ///
    /// # Errors
    /// [`EditError::BadTransform`] for a matrix that is not finite or flattens everything, [`EditError::NoSuchAnchor`],
    /// [`EditError::Path`] where the centre cannot go to its new place.
    pub fn transformed(
        &self,
        surface: &Surface,
        finder: &mut PathFinder,
        transform: &SelectionTransform,
    ) -> Result<Transformed, EditError> {
        check_matrix(transform.matrix)?;
        let chosen = self.chosen(transform)?;
        let mut out = Transformed { spline: self.clone(), clipped: Vec::new(), left: Vec::new() };
        let centre = Frame::new(surface, &transform.centre, transform.axis.as_ref())?;
        let mut way = InnerPath::default();
        let ends = [surface.inner_point(&transform.centre)?, surface.inner_point(&transform.to)?];
        finder.shortest_inner(surface, &ends[0], &ends[1], PathQuality::Default, &mut way)?;
        if transform.is_identity() || chosen.is_empty() {
            return Ok(out);
        }
        let sheet = surface.sheet(transform.centre.face)?;
        for i in &chosen {
            if surface.sheet(self.anchors[*i].point.face)? != sheet {
                out.left.push(*i as u32);
            }
        }
        if !out.left.is_empty() {
            // A spline lies on one piece of the surface.
            out.left = chosen.iter().map(|i| *i as u32).collect();
            return Ok(out);
        }
        let anchors: Vec<&Anchor> = chosen.iter().map(|i| &self.anchors[*i]).collect();
        let normal = normalised(surface, finder, &centre, &anchors, transform.coordinates)?;
        let there = centre.carried(surface, &way);
        for (i, placed) in chosen.iter().zip(placed(surface, &there, &normal, transform.matrix)?) {
            let middle = out.spline.anchors[*i].middle.take();
            out.spline.anchors[*i] = Anchor { middle, ..placed.anchor };
            if placed.clipped {
                out.clipped.push(*i as u32);
            }
        }
        settle_automatic(surface, finder, &mut out.spline, &chosen)?;
        if self.jumps == JumpPolicy::Sticky && !self.scheme.method.is_b_spline() {
            let mut ways = vec![None; self.anchors.len()];
            for i in chosen {
                let path = finder.shortest(surface, &self.anchors[i].point, &out.spline.anchors[i].point)?;
                ways[i] = Some(InnerPath::from_outer(surface, &path)?);
            }
            out.spline.lead_middles(surface, finder, self, &Led::Anchors(ways))?;
        }
        out.spline.settle_middles(surface, finder)?;
        Ok(out)
    }

    /// The anchors of a transform, in order and each once.
    fn chosen(&self, transform: &SelectionTransform) -> Result<Vec<usize>, EditError> {
        let Some(anchors) = &transform.anchors else { return Ok((0..self.anchors.len()).collect()) };
        let mut chosen = anchors.iter().map(|i| self.index(*i)).collect::<Result<Vec<_>, _>>()?;
        chosen.sort_unstable();
        chosen.dedup();
        Ok(chosen)
    }
}
