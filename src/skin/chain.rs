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
    ending: Ending,
    joins: Vec<ChainJoin>,
    turned_by: f64,
}

/// How the end of a path differs from that of its chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    Same,
    /// The path has its first point again at its end without being closed.
    Open,
    /// The path closes with a segment that has no length.
    Point,
}

impl Chain {
    /// The chain of a planar path. An open path whose ends meet is a closed chain, and a last segment that only closes a gap of rounding is left
    /// out, so that a smooth join there is seen.
    pub fn planar(path: &VectorPath, rules: &JoinRules) -> Self {
        Self::new(path.points().iter().map(|p| p.extend(0.0)).collect(), path.is_closed(), false, rules)
    }

    /// The chain of a path in space, with ends as in [`planar`](Self::planar).
    pub fn spatial(path: &SpatialPath, rules: &JoinRules) -> Self {
        Self::new(path.points().to_vec(), path.is_closed(), true, rules)
    }

    fn new(mut points: Vec<DVec3>, mut closed: bool, spatial: bool, rules: &JoinRules) -> Self {
        let extent = extent(&points);
        let mut ending = Ending::Same;
        // What is too large to be measured stays as it is.
        let near = if extent.is_finite() { rules.degenerate * extent } else { -1.0 };
        match (closed, &points[..]) {
            (false, [first, .., last]) if first.distance(*last) <= near => {
                points.pop();
                (closed, ending) = (true, Ending::Open);
            }
            (true, [first, .., a, b, c])
                if points.len() > 3 && [a, b, c].iter().all(|p| first.distance(**p) <= near) =>
            {
                points.truncate(points.len() - 3);
                ending = Ending::Point;
            }
            _ => {}
        }
        let anchors = points.len().div_ceil(3);
        let mut chain =
            Self { points, closed, spatial, ending, joins: vec![ChainJoin::default(); anchors], turned_by: 0.0 };
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
    /// [`SkinError::NoJoin`] where there is no anchor, [`SkinError::PinNotFinite`].
    pub fn pin(&mut self, anchor: usize, place: Option<DVec3>) -> Result<(), SkinError> {
        let join = self.joins.get_mut(anchor).ok_or(SkinError::NoJoin { anchor })?;
        if place.is_some_and(|place| !place.is_finite()) {
            return Err(SkinError::PinNotFinite { anchor });
        }
        join.pinned = place;
        Ok(())
    }

    /// The chain with other control points, as many as it has, as a path of the plane in the layout of the path that it was made of; none if
    /// their number differs, one is not finite, or the chain is in space.
    pub fn path_of(&self, points: impl ExactSizeIterator<Item = DVec2>) -> Option<VectorPath> {
        if self.spatial || points.len() != self.points.len() {
            return None;
        }
        VectorPath::from_points(self.ended(points.collect())?, self.closed && self.ending != Ending::Open)
    }

    /// The same as a path in space, of any chain.
    pub fn spatial_path_of(&self, points: impl ExactSizeIterator<Item = DVec3>) -> Option<SpatialPath> {
        if points.len() != self.points.len() {
            return None;
        }
        SpatialPath::from_points(self.ended(points.collect())?, self.closed && self.ending != Ending::Open)
    }

    /// Control points with the end that the path had.
    fn ended<P: Copy>(&self, mut points: Vec<P>) -> Option<Vec<P>> {
        let more = match self.ending {
            Ending::Same => 0,
            Ending::Open => 1,
            Ending::Point => 3,
        };
        if more > 0 {
            let first = *points.first()?;
            points.extend(std::iter::repeat_n(first, more));
        }
        Some(points)
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
    fn a_smooth_join_is_seen_behind_a_gap_of_rounding() {
        let points = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (1.0, -1.0), (0.0, -1.0)].map(DVec2::from);
        let (whole, mut points) = (points.to_vec(), points.to_vec());
        points.extend([DVec2::splat(5e-7); 3]);
        let path = VectorPath::from_points(points.clone(), true).unwrap();
        let chain = Chain::planar(&path, &JoinRules::default());
        assert_eq!((chain.segment_count(), chain.join(0).kind), (2, JoinKind::Smooth));
        let back = chain.path_of(chain.points().iter().map(|p| p.truncate())).unwrap();
        assert_eq!((back.segment_count(), back.is_closed()), (3, true));
        assert!(back.points().iter().zip(path.points()).all(|(a, b)| a.distance(*b) < 1e-6));
        // A gap that can be seen is a segment.
        points[6..].fill(DVec2::splat(5e-5));
        let path = VectorPath::from_points(points, true).unwrap();
        assert_eq!(Chain::planar(&path, &JoinRules::default()).segment_count(), 3);
        let path = SpatialPath::from(&VectorPath::from_points(whole, true).unwrap());
        let chain = Chain::spatial(&path, &JoinRules::default());
        assert_eq!(chain.spatial_path_of(chain.points().iter().copied()), Some(path));
        assert_eq!(chain.spatial_path_of([DVec3::ZERO].into_iter()), None);
        assert_eq!(chain.path_of(chain.points().iter().map(|p| p.truncate())), None);
    }

    #[test]
    fn paths_too_large_to_be_measured_stay_as_they_are() {
        for scale in [1e160, 1e308] {
            let points = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.5)].map(|p| DVec2::from(p) * scale);
            let chain = Chain::planar(&VectorPath::from_points(points.to_vec(), false).unwrap(), &JoinRules::default());
            assert!(!chain.is_closed() && chain.points()[3].truncate() == points[3]);
        }
    }

    #[test]
    fn joins_that_cannot_be_are_refused() {
        let mut chain = Chain::planar(&corner(DVec2::ZERO, DVec2::X), &JoinRules::default());
        assert_eq!(chain.set_join(1, JoinKind::Smooth), Err(SkinError::NoDirection { anchor: 1 }));
        assert_eq!(chain.set_join(0, JoinKind::Smooth), Err(SkinError::NoJoin { anchor: 0 }));
        assert_eq!(chain.pin(3, None), Err(SkinError::NoJoin { anchor: 3 }));
        assert_eq!(chain.pin(1, Some(DVec3::NAN)), Err(SkinError::PinNotFinite { anchor: 1 }));
        let mut chain = Chain::planar(&corner(DVec2::Y, 3.0 * DVec2::X), &JoinRules::default());
        assert_eq!(chain.join(1).kind, JoinKind::Angle);
        chain.set_join(1, JoinKind::Mirrored).unwrap();
        assert_eq!(chain.handles(1), Some([DVec3::NEG_X * 2.0, DVec3::X * 2.0]));
    }
}
