//! A spline: what a user edits.

use super::{JumpPolicy, Scheme, handles};
use crate::geodesic::{GeodesicPath, PathError, PathFinder, Tangent};
use crate::surface::{PointError, Surface, SurfacePoint};

/// A parameter on a spline: segment number plus local parameter, so 2.5 is the middle of the third segment.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct SplineT(pub f64);

impl SplineT {
    /// Segment number and local parameter, clamped to `segments` segments; none if there are none, or for NaN.
    pub fn split(self, segments: usize) -> Option<(usize, f64)> {
        if segments == 0 || self.0.is_nan() {
            return None;
        }
        let t = self.0.clamp(0.0, segments as f64);
        let segment = (t as usize).min(segments - 1);
        Some((segment, t - segment as f64))
    }
}

/// How the two handles of an anchor depend on each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum Join {
    /// Not at all.
    #[default]
    Corner,
    /// Opposite directions (G¹).
    Smooth,
    /// Opposite directions and equal lengths (C¹).
    Mirrored,
    /// Placed from the neighbouring anchors (chordal Catmull–Rom).
    Automatic,
}

/// A tangent control point, with the geodesic leg from its anchor.
///
/// The leg is the authority: its first direction is the curve's tangent. At another point the same place may be reached by
/// other legs.
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct Handle {
    /// From the anchor to the handle; its end is the handle's place.
    pub(crate) leg: GeodesicPath,
    /// Unit direction at the anchor, kept while the leg has no length; zero before it ever had one.
    pub(crate) heading: Tangent,
    /// The length asked for; more than the leg's where the boundary cut it short.
    pub(crate) wished_length: f64,
}

impl Handle {
    /// Where the handle is.
    pub fn point(&self) -> SurfacePoint {
        self.leg.end()
    }

    /// The geodesic from the anchor to the handle.
    pub fn leg(&self) -> &GeodesicPath {
        &self.leg
    }

    /// Unit direction at the anchor; the last one while the handle has no length; zero before it ever had one.
    pub fn heading(&self) -> Tangent {
        self.heading
    }

    /// The length asked for; the leg gets it back when there is room again.
    pub fn wished_length(&self) -> f64 {
        self.wished_length
    }

    /// Whether the boundary made it shorter than asked for.
    pub fn is_clipped(&self) -> bool {
        self.leg.length() < self.wished_length * (1.0 - 1e-9)
    }
}

/// A control point that the curve passes through, with its two handles.
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct Anchor {
    pub(crate) point: SurfacePoint,
    pub(crate) join: Join,
    pub(crate) incoming: Handle,
    pub(crate) outgoing: Handle,
    /// The leg from the outgoing handle to the next anchor's incoming one, where it belongs to the document.
    pub(crate) middle: Option<GeodesicPath>,
}

impl Anchor {
    /// Where the anchor is.
    pub fn point(&self) -> SurfacePoint {
        self.point
    }

    /// How its handles depend on each other.
    pub fn join(&self) -> Join {
        self.join
    }

    /// The handle of the segment that ends here; of no consequence at the start of an open spline.
    pub fn incoming(&self) -> &Handle {
        &self.incoming
    }

    /// The handle of the segment that begins here; of no consequence at the end of an open spline.
    pub fn outgoing(&self) -> &Handle {
        &self.outgoing
    }

    /// The leg from the outgoing handle to the next anchor's incoming one, where it belongs to the document: in splines
    /// that are [`Sticky`](JumpPolicy::Sticky).
    pub fn middle(&self) -> Option<&GeodesicPath> {
        self.middle.as_ref()
    }
}

/// A chain of cubic Bézier segments on a surface: the small truth that everything else is derived from.
///
/// It holds no reference to its surface. It changes by [`apply`](Self::apply) alone.
///
/// ```
/// use bevy_surface_splines::{curve::*, geodesic::PathFinder, surface::{Surface, SurfaceOptions, shapes}};
/// use glam::DVec3;
///
/// let surface = Surface::build(&shapes::icosphere(4), &SurfaceOptions::default())?;
/// let points = [DVec3::X, DVec3::Y, DVec3::Z].map(|p| surface.closest_point(p).unwrap().point);
/// let mut workspace = TraceWorkspace::default();
/// let mut spline = Spline::smooth_through(&surface, &mut workspace.finder, &points, true)?;
/// let before = spline.trace(&surface, &mut workspace, None)?;
/// let to = surface.closest_point(DVec3::new(0.5, 1.0, 0.2)).unwrap().point;
/// let back = spline.apply(&surface, &mut workspace.finder, &SplineEdit::MoveAnchor { anchor: 1, to })?;
/// let after = spline.trace(&surface, &mut workspace, Some(&before))?;
/// assert_eq!(after.retraced(), [0, 1]); // the third segment does not touch the anchor
/// spline.apply(&surface, &mut workspace.finder, &back)?;
/// assert_eq!(spline.trace(&surface, &mut workspace, None)?, before);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct Spline {
    pub(crate) anchors: Vec<Anchor>,
    pub(crate) closed: bool,
    pub(crate) scheme: Scheme,
    pub(crate) jumps: JumpPolicy,
}

// By hand, because derived `clone_from` does not keep memory, and a drag copies the spline for every step.

impl Clone for Handle {
    fn clone(&self) -> Self {
        Self { leg: self.leg.clone(), ..*self }
    }

    fn clone_from(&mut self, other: &Self) {
        let Self { leg, heading, wished_length } = other;
        self.leg.clone_from(leg);
        (self.heading, self.wished_length) = (*heading, *wished_length);
    }
}

impl Clone for Anchor {
    fn clone(&self) -> Self {
        let Self { point, join, incoming, outgoing, middle } = self;
        Self {
            point: *point,
            join: *join,
            incoming: incoming.clone(),
            outgoing: outgoing.clone(),
            middle: middle.clone(),
        }
    }

    fn clone_from(&mut self, other: &Self) {
        let Self { point, join, incoming, outgoing, middle } = other;
        (self.point, self.join) = (*point, *join);
        self.incoming.clone_from(incoming);
        self.outgoing.clone_from(outgoing);
        self.middle.clone_from(middle);
    }
}

impl Clone for Spline {
    fn clone(&self) -> Self {
        Self { anchors: self.anchors.clone(), ..*self }
    }

    fn clone_from(&mut self, other: &Self) {
        let Self { anchors, closed, scheme, jumps } = other;
        self.anchors.clone_from(anchors);
        (self.closed, self.scheme, self.jumps) = (*closed, *scheme, *jumps);
    }
}

/// Why a spline could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SplineError {
    /// Too few distinct points.
    #[error("a spline needs at least two distinct points, and there is {distinct}: give another")]
    TooFewPoints {
        /// How many distinct points there were.
        distinct: usize,
    },
    /// Too few control points for a B-spline.
    #[error("a B-spline like this needs {needed} control points, and there are {count}: give more")]
    TooFewControlPoints {
        /// How many there are.
        count: usize,
        /// How many are needed.
        needed: usize,
    },
    /// A point does not belong to the surface.
    #[error(transparent)]
    Point(#[from] PointError),
    /// Two points cannot be joined.
    #[error(transparent)]
    Path(#[from] PathError),
}

impl Spline {
    /// Makes a spline of one segment from its control points: anchor, handle, handle, anchor.
    ///
    /// # Errors
    /// [`SplineError`] if points do not belong to the surface or cannot be joined.
    pub fn bezier(surface: &Surface, finder: &mut PathFinder, polygon: [SurfacePoint; 4]) -> Result<Self, SplineError> {
        let [start, h0, h1, end] = polygon;
        let mut first = handles::bare_anchor(surface, start)?;
        let mut last = handles::bare_anchor(surface, end)?;
        first.outgoing = handles::towards(surface, finder, &start, &h0)?;
        last.incoming = handles::towards(surface, finder, &end, &h1)?;
        let spline =
            Self { anchors: vec![first, last], closed: false, scheme: Scheme::default(), jumps: JumpPolicy::default() };
        finder.shortest(surface, &h0, &h1)?; // a spline that cannot be traced is no spline
        Ok(spline)
    }

    /// Makes a smooth spline through points: chordal Catmull–Rom, each tangent from the two neighbours.
    ///
    /// Points that repeat their predecessor are left out.
    ///
    /// Interpolation: passes through all points. Continuity: C¹, up to parametrisation. Locality: a point affects the two
    /// segments on either side.
    ///
    /// # Errors
    /// [`SplineError`] with fewer than two distinct points, points that cannot be joined or that do not belong to the
    /// surface.
    pub fn smooth_through(
        surface: &Surface,
        finder: &mut PathFinder,
        points: &[SurfacePoint],
        closed: bool,
    ) -> Result<Self, SplineError> {
        let distinct = distinct_points(surface, points, closed)?;
        let anchors: Result<Vec<_>, _> = distinct.iter().map(|p| handles::bare_anchor(surface, *p)).collect();
        let mut spline = Self { anchors: anchors?, closed, scheme: Scheme::default(), jumps: JumpPolicy::default() };
        for i in 0..spline.anchors.len() {
            handles::place_automatic(surface, finder, &mut spline, i)?;
            spline.anchors[i].join = Join::Smooth;
        }
        Ok(spline)
    }

    /// Makes a spline of corners: its segments are the shortest paths between consecutive points.
    ///
    /// Points that repeat their predecessor are left out.
    ///
    /// Interpolation: passes through all points. Continuity: C⁰. Locality: a point affects the segments on either side.
    ///
    /// # Errors
    /// As [`smooth_through`](Self::smooth_through).
    pub fn corners_through(
        surface: &Surface,
        finder: &mut PathFinder,
        points: &[SurfacePoint],
        closed: bool,
    ) -> Result<Self, SplineError> {
        let distinct = distinct_points(surface, points, closed)?;
        for pair in distinct.windows(2) {
            finder.shortest(surface, &pair[0], &pair[1])?; // a spline that cannot be traced is no spline
        }
        let anchors: Result<Vec<_>, _> = distinct.iter().map(|p| handles::bare_anchor(surface, *p)).collect();
        Ok(Self { anchors: anchors?, closed, scheme: Scheme::default(), jumps: JumpPolicy::default() })
    }

    /// The same spline traced in another way.
    pub fn with_scheme(mut self, scheme: Scheme) -> Self {
        self.scheme = scheme;
        self
    }

    /// The anchors in order.
    pub fn anchors(&self) -> &[Anchor] {
        &self.anchors
    }

    /// Whether the last anchor is joined to the first.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// How the spline is traced.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// What happens where moving a control point makes another way the shortest.
    pub fn jumps(&self) -> JumpPolicy {
        self.jumps
    }

    /// Number of segments: Bézier segments between anchors, or intervals of a B-spline.
    pub fn segment_count(&self) -> usize {
        let n = self.anchors.len();
        match (self.scheme.method.b_spline_degree(), self.closed) {
            (None, true) => n,
            (None, false) => n.saturating_sub(1),
            (Some(_), true) => {
                if n >= 3 {
                    n
                } else {
                    0
                }
            }
            (Some(degree), false) => n.saturating_sub(degree),
        }
    }

    /// The control points of a segment in order, if there is such a segment: four, of a quadratic B-spline three.
    pub fn polygon(&self, segment: usize) -> Option<Vec<SurfacePoint>> {
        if segment >= self.segment_count() {
            return None;
        }
        let anchor = |k: usize| &self.anchors[(segment + k) % self.anchors.len()];
        if let Some(degree) = self.scheme.method.b_spline_degree() {
            return Some((0..=degree).map(|k| anchor(k).point).collect());
        }
        let (from, to) = (anchor(0), anchor(1));
        Some(vec![from.point, from.outgoing.point(), to.incoming.point(), to.point])
    }

    /// The anchors before and after one, where the spline has them.
    pub(crate) fn neighbours(&self, anchor: usize) -> (Option<usize>, Option<usize>) {
        let n = self.anchors.len();
        let before = if anchor > 0 { Some(anchor - 1) } else { (self.closed && n > 1).then(|| n - 1) };
        let after = if anchor + 1 < n { Some(anchor + 1) } else { (self.closed && n > 1).then_some(0) };
        (before, after)
    }
}

/// Points without those that repeat their predecessor.
fn distinct_points(surface: &Surface, points: &[SurfacePoint], closed: bool) -> Result<Vec<SurfacePoint>, SplineError> {
    let mut distinct: Vec<SurfacePoint> = Vec::with_capacity(points.len());
    for p in points {
        surface.inner_point(p)?;
        if distinct.last().is_none_or(|last| !surface.same_place(last, p)) {
            distinct.push(*p);
        }
    }
    while closed && distinct.len() > 1 && surface.same_place(&distinct[0], &distinct[distinct.len() - 1]) {
        distinct.pop();
    }
    if distinct.len() < 2 {
        return Err(SplineError::TooFewPoints { distinct: distinct.len() });
    }
    Ok(distinct)
}
