//! Splines copied from a surface, to be put down elsewhere on it or on another one.

use glam::{DMat2, DVec2};

use super::{
    JumpPolicy, Scheme, Spline,
    edit::EditError,
    normal::{Coordinates, Frame, NormalAnchor, normalised, placed, settle_automatic},
};
use crate::geodesic::{PathFinder, Tangent};
use crate::surface::{Surface, SurfacePoint};

/// Splines by directions and lengths about a point: plain data that belongs to no surface.
///
/// ```
/// use bevy_surface_splines::{curve::*, surface::{Surface, SurfaceOptions, shapes}};
/// use glam::DVec3;
///
/// let ball = Surface::build(&shapes::icosphere(4), &SurfaceOptions::default())?;
/// let ring = Surface::build(&shapes::torus(2.0, 0.8, 60, 30), &SurfaceOptions::default())?;
/// let points = [(0.1, 0.0), (0.0, 0.1), (-0.1, -0.1)]
///     .map(|(x, y)| ball.closest_point(DVec3::new(x, y, 1.0)).unwrap().point);
/// let mut workspace = TraceWorkspace::default();
/// let spline = Spline::smooth_through(&ball, &mut workspace.finder, &points, true)?;
/// let centre = ball.closest_point(DVec3::Z).unwrap().point;
/// let copied = SplineClip::copy(&ball, &mut workspace.finder, &[&spline], &centre, None, Coordinates::Normal)?;
///
/// let at = ring.closest_point(DVec3::new(2.8, 0.0, 0.0)).unwrap().point;
/// let scale = copied.clip.ratio(&ring); // as large on the ring as it was on the ball
/// let pasted = copied.clip.paste(&ring, &mut workspace.finder, &Paste { scale, ..Paste::at(at) })?;
/// assert_eq!(pasted.splines[0].anchors().len(), 3);
/// assert!(pasted.clipped.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct SplineClip {
    splines: Vec<ClippedSpline>,
    diagonal: f64,
}

#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
struct ClippedSpline {
    anchors: Vec<NormalAnchor>,
    closed: bool,
    scheme: Scheme,
    jumps: JumpPolicy,
}

/// What was copied.
#[derive(Clone, Debug, PartialEq)]
pub struct Copied {
    /// The splines.
    pub clip: SplineClip,
    /// Which of the splines lie on other pieces of the surface than the centre, and were left out.
    pub left_out: Vec<u32>,
}

/// Where and how splines are put down.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct Paste {
    /// Where the centre of the copy comes to lie.
    pub at: SurfacePoint,
    /// Where the axis of the copy comes to point; none: along the first side of the point's face.
    pub axis: Option<Tangent>,
    /// By how much everything is turned, counter-clockwise as seen against the normal, in radians.
    pub turn: f64,
    /// By how much everything is scaled; see [`SplineClip::ratio`].
    pub scale: f64,
}

impl Paste {
    /// At a point, neither turned nor scaled.
    pub fn at(at: SurfacePoint) -> Self {
        Self { at, axis: None, turn: 0.0, scale: 1.0 }
    }
}

/// What was put down.
#[derive(Clone, Debug, PartialEq)]
pub struct Pasted {
    /// The splines, in the order in which they were copied.
    pub splines: Vec<Spline>,
    /// Spline and anchor of what would have fallen off the surface and was clipped at the boundary.
    pub clipped: Vec<[u32; 2]>,
}

impl SplineClip {
    /// Copies splines, seen from a point. `axis` is the direction that [`Paste::axis`] will lie in; none: along the first side of
    /// the point's face.
    ///
    /// Joins, schemes and what happens at jumps come along; legs that stay on their side of a hole do not.
    ///
    /// Cost: a shortest path for each anchor.
    ///
    /// # Errors
    /// [`EditError`] if points do not belong to the surface.
    pub fn copy(
        surface: &Surface,
        finder: &mut PathFinder,
        splines: &[&Spline],
        centre: &SurfacePoint,
        axis: Option<&Tangent>,
        coordinates: Coordinates,
    ) -> Result<Copied, EditError> {
        let frame = Frame::new(surface, centre, axis)?;
        let sheet = surface.sheet(centre.face)?;
        let mut clip = Self { splines: Vec::with_capacity(splines.len()), diagonal: surface.diagonal() };
        let mut left_out = Vec::new();
        for (i, spline) in splines.iter().enumerate() {
            let mut elsewhere = false;
            for anchor in &spline.anchors {
                surface.inner_point(&anchor.point)?;
                elsewhere |= surface.sheet(anchor.point.face)? != sheet;
            }
            if elsewhere {
                left_out.push(i as u32);
                continue;
            }
            let anchors: Vec<_> = spline.anchors.iter().collect();
            let anchors = normalised(surface, finder, &frame, &anchors, coordinates)?;
            let Spline { closed, scheme, jumps, .. } = **spline;
            clip.splines.push(ClippedSpline { anchors, closed, scheme, jumps });
        }
        Ok(Copied { clip, left_out })
    }

    /// Number of splines.
    pub fn len(&self) -> usize {
        self.splines.len()
    }

    /// Whether nothing was copied.
    pub fn is_empty(&self) -> bool {
        self.splines.is_empty()
    }

    /// How large a surface is against the one that was copied from: the ratio of the diagonals of their bounds.
    pub fn ratio(&self, surface: &Surface) -> f64 {
        if self.diagonal > 0.0 { surface.diagonal() / self.diagonal } else { 1.0 }
    }

    /// Puts the splines down about a point of a surface. On the surface that they were copied from, at the centre and along the
    /// axis of the copy, they are the same curves again, within 1e-9 of the diagonal, but for anchors that lie behind a hole.
    ///
    /// Smooth joins stay smooth. What would fall off the surface is clipped: anchors at the boundary, and handles, which get
    /// their length back where there is room.
    ///
    /// Cost: three straight walks for each anchor; searches for automatic joins and legs that belong to the document.
    ///
    /// # Errors
    /// [`EditError::BadTransform`] if turn or scale are no numbers, or the scale is zero; [`EditError::Point`] if the point does not
    /// belong to the surface.
    pub fn paste(&self, surface: &Surface, finder: &mut PathFinder, paste: &Paste) -> Result<Pasted, EditError> {
        let frame = Frame::new(surface, &paste.at, paste.axis.as_ref())?;
        let matrix = DMat2::from_scale_angle(DVec2::splat(paste.scale), paste.turn);
        super::edit::check_matrix(matrix)?;
        let mut out = Pasted { splines: Vec::with_capacity(self.splines.len()), clipped: Vec::new() };
        for (s, clipped) in self.splines.iter().enumerate() {
            let mut spline =
                Spline { anchors: Vec::new(), closed: clipped.closed, scheme: clipped.scheme, jumps: clipped.jumps };
            for (a, placed) in placed(surface, &frame, &clipped.anchors, matrix)?.into_iter().enumerate() {
                spline.anchors.push(placed.anchor);
                if placed.clipped {
                    out.clipped.push([s as u32, a as u32]);
                }
            }
            let all: Vec<_> = (0..spline.anchors.len()).collect();
            settle_automatic(surface, finder, &mut spline, &all)?;
            spline.settle_middles(surface, finder)?;
            out.splines.push(spline);
        }
        Ok(out)
    }
}
