//! Chains of segments with their joins.

use glam::{DVec2, DVec3};

use super::{ChainJoin, JoinKind, JoinRules, SkinError};
use crate::vector::{SpatialPath, VectorPath};

/// A chain of cubic Bézier segments in the plane or in space, and what is kept of how they meet.
///
/// Its control points lie as in a [`VectorPath`]; those of the plane have z = 0. Joins fulfil what their kind says to the last digits: where
/// a drawing misses that by its rounding, the shorter handle was turned, which moves its end by no more than [`turned_by`](Self::turned_by).
///
/// ```
/// use bevy_surface_splines::{skin::{Chain, JoinKind, JoinRules}, vector::VectorPath};
/// use glam::DVec2;
///
/// let points = [(0.0, 0.0), (1.0, 1.0), (2.0, 1.0), (3.0, 0.0), (3.5, -0.5), (5.0, 0.0), (5.0, 1.0)];
/// let path = VectorPath::from_points(points.map(DVec2::from).to_vec(), false).unwrap();
/// let chain = Chain::planar(&path, &JoinRules::default());
/// assert_eq!(chain.join(1).kind, JoinKind::Smooth);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    points: Vec<DVec3>,
    closed: bool,
    spatial: bool,
    /// Whether the path had its first point again at its end without being closed.
    was_open: bool,
    joins: Vec<ChainJoin>,
    turned_by: f64,
}

impl Chain {
    /// The chain of a planar path. An open path whose ends meet is a closed chain.
    pub fn planar(path: &VectorPath, rules: &JoinRules) -> Self {
        Self::new(path.points().iter().map(|p| p.extend(0.0)).collect(), path.is_closed(), false, rules)
    }

    /// The chain of a path in space. An open path whose ends meet is a closed chain.
    pub fn spatial(path: &SpatialPath, rules: &JoinRules) -> Self {
        Self::new(path.points().to_vec(), path.is_closed(), true, rules)
    }

    fn new(mut points: Vec<DVec3>, mut closed: bool, spatial: bool, rules: &JoinRules) -> Self {
        let extent = extent(&points);
        let mut was_open = false;
        if let (false, [first, .., last]) = (closed, &points[..])
            && first.distance(*last) <= rules.degenerate * extent
        {
            points.pop();
            (closed, was_open) = (true, true);
        }
        let anchors = points.len().div_ceil(3);
        let mut chain =
            Self { points, closed, spatial, was_open, joins: vec![ChainJoin::default(); anchors], turned_by: 0.0 };
        for anchor in 0..anchors {
            let Some([incoming, outgoing]) = chain.handles(anchor) else { continue };
            let kind = rules.kind(incoming, outgoing, extent);
            // A kind that was recognised has handles with directions.
            let _ = chain.set_join(anchor, kind);
        }
        chain
    }

    /// The control points: anchor, handle, handle, anchor, …
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Whether the last segment ends at the first anchor.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Whether it is a chain in space, and not in the plane.
    pub fn is_spatial(&self) -> bool {
        self.spatial
    }

    /// Number of segments.
    pub fn segment_count(&self) -> usize {
        self.points.len() / 3
    }

    /// Number of anchors.
    pub fn anchor_count(&self) -> usize {
        self.joins.len()
    }

    /// The join at an anchor; ends of open chains and anchors that there are not are corners.
    pub fn join(&self, anchor: usize) -> ChainJoin {
        self.joins.get(anchor).copied().unwrap_or_default()
    }

    /// All joins; those at the ends of an open chain are corners.
    pub fn joins(&self) -> &[ChainJoin] {
        &self.joins
    }

    /// How far the end of a handle was moved at most to make joins what they are.
    pub fn turned_by(&self) -> f64 {
        self.turned_by
    }

    /// The distance between opposite corners of the control points' bounds.
    pub fn extent(&self) -> f64 {
        extent(&self.points)
    }

    /// Makes a join of a kind. For [`JoinKind::Smooth`] and [`JoinKind::Mirrored`] the shorter handle is turned to be opposite to the longer
    /// one, for the latter both become as long as they are in the mean; the others change nothing.
    ///
    /// # Errors
    /// [`SkinError::NoJoin`] at ends and where there is no anchor, [`SkinError::NoDirection`] if a handle has no length and the kind is not
    /// [`JoinKind::Corner`].
    pub fn set_join(&mut self, anchor: usize, kind: JoinKind) -> Result<(), SkinError> {
        let [incoming, outgoing] = self.handles(anchor).ok_or(SkinError::NoJoin { anchor })?;
        let (p, q) = (incoming.length(), outgoing.length());
        let directed = p > 0.0 && q > 0.0 && p.is_finite() && q.is_finite();
        if kind != JoinKind::Corner && !directed {
            return Err(SkinError::NoDirection { anchor });
        }
        let (new_incoming, new_outgoing) = match kind {
            JoinKind::Corner | JoinKind::Angle => (incoming, outgoing),
            JoinKind::Smooth if p < q => (-outgoing * (p / q), outgoing),
            JoinKind::Smooth => (incoming, -incoming * (q / p)),
            JoinKind::Mirrored => {
                let along = if p < q { outgoing / q } else { -incoming / p } * (0.5 * (p + q));
                (-along, along)
            }
        };
        let at = 3 * anchor;
        let before = if at == 0 { self.points.len() - 1 } else { at - 1 };
        let moved = new_incoming.distance(incoming).max(new_outgoing.distance(outgoing));
        if moved > 0.0 {
            let anchor = self.points[at];
            self.points[before] = anchor + new_incoming;
            self.points[at + 1] = anchor + new_outgoing;
            self.turned_by = self.turned_by.max(moved);
        }
        self.joins[anchor].kind = kind;
        Ok(())
    }

    /// Pins an anchor to a place, or frees it.
    ///
    /// # Errors
    /// [`SkinError::NoJoin`] where there is no anchor or the place is not finite.
    pub fn pin(&mut self, anchor: usize, place: Option<DVec3>) -> Result<(), SkinError> {
        let join = self.joins.get_mut(anchor).filter(|_| place.is_none_or(DVec3::is_finite));
        join.ok_or(SkinError::NoJoin { anchor })?.pinned = place;
        Ok(())
    }

    /// The chain with other control points, as many as it has, as a path of the plane in the layout of the path that it was made of; none if
    /// their number differs, one is not finite, or the chain is in space.
    pub fn path_of(&self, points: impl ExactSizeIterator<Item = DVec2>) -> Option<VectorPath> {
        if self.spatial || points.len() != self.points.len() {
            return None;
        }
        let mut points: Vec<DVec2> = points.collect();
        if self.was_open {
            points.push(*points.first()?);
        }
        VectorPath::from_points(points, self.closed && !self.was_open)
    }

    /// Vectors from an anchor to the handles of the two segments that meet there, if two do.
    pub(crate) fn handles(&self, anchor: usize) -> Option<[DVec3; 2]> {
        let at = 3 * anchor;
        let before = if at > 0 { at - 1 } else { self.points.len().checked_sub(1).filter(|_| self.closed)? };
        let anchor = self.points.get(at)?;
        Some([*self.points.get(before)? - *anchor, *self.points.get(at + 1)? - *anchor])
    }

    /// Places of a segment's control points.
    pub(crate) fn places(&self, segment: usize) -> [usize; 4] {
        let first = 3 * segment;
        [first, first + 1, first + 2, if first + 3 < self.points.len() { first + 3 } else { 0 }]
    }

    /// The control points of a segment.
    pub(crate) fn segment(&self, segment: usize) -> [DVec3; 4] {
        self.places(segment).map(|at| self.points[at])
    }

    /// The same joins with other control points and anchors, as splitting makes them.
    pub(crate) fn rebuilt(&self, points: Vec<DVec3>, joins: Vec<ChainJoin>) -> Self {
        Self { points, joins, ..*self }
    }
}

/// The distance between opposite corners of the points' bounds.
fn extent(points: &[DVec3]) -> f64 {
    let low = points.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = points.iter().copied().reduce(DVec3::max).unwrap_or_default();
    low.distance(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(incoming: DVec2, outgoing: DVec2) -> VectorPath {
        let at = DVec2::new(4.0, 1.0);
        let points = vec![DVec2::ZERO, DVec2::X, at + incoming, at, at + outgoing, DVec2::Y, DVec2::ONE];
        VectorPath::from_points(points, false).unwrap()
    }

    #[test]
    fn joins_are_made_what_they_are_recognised_as() {
        let nearly = DVec2::from_angle(5e-4);
        let chain = Chain::planar(&corner(-DVec2::X, 0.5 * nearly), &JoinRules::default());
        let [incoming, outgoing] = chain.handles(1).unwrap();
        assert_eq!(chain.join(1).kind, JoinKind::Smooth);
        assert!(incoming.cross(outgoing).length() < 1e-15 && (outgoing.length() - 0.5).abs() < 1e-15);
        assert!((chain.turned_by() - 2.5e-4).abs() < 1e-8, "{}", chain.turned_by());
        assert_eq!(chain.handles(0), None);
    }

    #[test]
    fn ends_that_meet_are_closed_and_come_back_open() {
        let points = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (1.0, -1.0), (0.0, -1.0), (0.0, 0.0)];
        let path = VectorPath::from_points(points.map(DVec2::from).to_vec(), false).unwrap();
        let chain = Chain::planar(&path, &JoinRules::default());
        assert!(chain.is_closed() && chain.join(0).kind == JoinKind::Smooth);
        assert_eq!(chain.path_of(chain.points().iter().map(|p| p.truncate())), Some(path));
    }

    #[test]
    fn joins_that_cannot_be_are_refused() {
        let mut chain = Chain::planar(&corner(DVec2::ZERO, DVec2::X), &JoinRules::default());
        assert_eq!(chain.set_join(1, JoinKind::Smooth), Err(SkinError::NoDirection { anchor: 1 }));
        assert_eq!(chain.set_join(0, JoinKind::Smooth), Err(SkinError::NoJoin { anchor: 0 }));
        assert_eq!(chain.pin(3, None), Err(SkinError::NoJoin { anchor: 3 }));
        assert_eq!(chain.pin(1, Some(DVec3::NAN)), Err(SkinError::NoJoin { anchor: 1 }));
        let mut chain = Chain::planar(&corner(DVec2::Y, 3.0 * DVec2::X), &JoinRules::default());
        assert_eq!(chain.join(1).kind, JoinKind::Angle);
        chain.set_join(1, JoinKind::Mirrored).unwrap();
        assert_eq!(chain.handles(1), Some([DVec3::NEG_X * 2.0, DVec3::X * 2.0]));
    }
}
