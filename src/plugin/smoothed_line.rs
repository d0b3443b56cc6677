//! What a line is now: smoothed, measured, and ready to be drawn.

use std::sync::{Arc, Weak};

use bevy::prelude::*;
use glam::DVec3;

use super::surface::BuiltSurface;
use super::trace::Polyline;
use crate::smooth::{LineBend, Smoothed, Smoothing, SurfacePolyline};
use crate::surface::{FaceId, Surface, SurfacePoint};

/// Over so many mean stretches to either side curvature is evened out to be shown.
const WITHIN: f64 = 3.0;

/// A [`SurfaceLine`](super::SurfaceLine) as it is to be shown: smoothed by its [`LineSmoothing`](super::LineSmoothing), or as it was drawn. Derived: a
/// system writes it, and it is never saved.
///
/// It is always what [`smooth`](crate::smooth::smooth) gives, bit for bit; but it may lag behind the `LineSmoothing` while that takes
/// longer than a frame has ([`LineState::Smoothing`](super::LineState::Smoothing)). [`by`](Self::by) says what it was made by.
#[derive(Component, Clone, Debug, Deref)]
#[component(immutable)]
pub struct SmoothedLine {
    #[deref]
    smoothed: Arc<Smoothed>,
    by: Option<Smoothing>,
    drawn: Arc<SurfacePolyline>,
    drawn_polyline: Polyline,
    polyline: Polyline,
    /// Length of the line up to each position.
    lengths: Arc<[f64]>,
    bends: Arc<[LineBend]>,
    /// Geodesic curvature at each position.
    curvatures: Arc<[f32]>,
    surface: Weak<Surface>,
}

/// A place on a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinePlace {
    /// Length along the line from its start (of a closed one, its first crossing), in local units.
    pub distance: f64,
    /// The place on the surface.
    pub point: SurfacePoint,
}

impl SmoothedLine {
    pub(crate) fn new(
        smoothed: Smoothed,
        by: Option<Smoothing>,
        (drawn, drawn_polyline): (Arc<SurfacePolyline>, Polyline),
        mut bends: Vec<LineBend>,
        surface: &Arc<Surface>,
    ) -> Self {
        let positions = positions(surface, &smoothed.line);
        let mut length = 0.0;
        let mut lengths = vec![0.0; positions.len()];
        for (pair, here) in positions.windows(2).zip(lengths.iter_mut().skip(1)) {
            length += pair[0].distance(pair[1]);
            *here = length;
        }
        if smoothed.line.is_closed() {
            begin_with_the_line(surface, &positions, &lengths, &mut bends);
        }
        let curvatures = curvatures(&bends, &lengths, smoothed.line.is_closed());
        let polyline = Polyline::unbroken(positions.iter().map(|p| p.as_vec3()));
        Self {
            smoothed: Arc::new(smoothed),
            by,
            drawn,
            drawn_polyline,
            polyline,
            lengths: lengths.into(),
            bends: bends.into(),
            curvatures,
            surface: Arc::downgrade(surface),
        }
    }

    /// The line with its metrics before and after.
    pub fn smoothed(&self) -> &Arc<Smoothed> {
        &self.smoothed
    }

    /// By what it was smoothed; none if it is as it was drawn.
    pub fn by(&self) -> Option<&Smoothing> {
        self.by.as_ref()
    }

    /// The line that was drawn.
    pub fn drawn(&self) -> &Arc<SurfacePolyline> {
        &self.drawn
    }

    /// Positions of the line that was drawn, in the surface's local space.
    pub fn drawn_polyline(&self) -> &[Vec3] {
        self.drawn_polyline.positions()
    }

    /// Positions along the line in the surface's local space: ends and crossings. Of a closed line the first one comes last again.
    pub fn polyline(&self) -> &[Vec3] {
        self.polyline.positions()
    }

    /// Length of the line up to each place of the [`polyline`](Self::polyline), in local units.
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// Where the line bends and by how much, in order: for a plot of the curvature along it.
    pub fn bends(&self) -> &[LineBend] {
        &self.bends
    }

    /// Geodesic curvature at each place of the [`polyline`](Self::polyline), one over local units, positive to the left: to colour
    /// the line by. Crossing by crossing it jumps about, so it is evened out over some stretches to either side; [`bends`](Self::bends)
    /// has it as it is.
    pub fn curvatures(&self) -> &[f32] {
        &self.curvatures
    }

    /// The polyline with a colour for each place, by its curvature: the middle one where the line is straight, the others where it turns to the right or left
    /// by `most` (one over local units) or more.
    pub fn colored(&self, [right, flat, left]: [Color; 3], most: f32) -> impl Iterator<Item = (Vec3, Color)> {
        self.polyline().iter().zip(self.curvatures()).map(move |(position, curvature)| {
            let share = (curvature / most).clamp(-1.0, 1.0);
            (*position, flat.mix(if share < 0.0 { &right } else { &left }, share.abs()))
        })
    }

    /// The place at a length along the line (local units); on a closed one that may be any number, on an open one it is kept
    /// between its ends. None for a number that is not finite, or if the surface is another one.
    pub fn at_distance(&self, surface: &BuiltSurface, distance: f64) -> Option<LinePlace> {
        let whole = *self.lengths.last().filter(|_| self.is_on(surface) && distance.is_finite())?;
        let round = self.smoothed.line.is_closed() && whole > 0.0;
        let distance = if round { distance.rem_euclid(whole) } else { distance.clamp(0.0, whole) };
        let after = self.lengths.partition_point(|length| *length < distance).max(1);
        let (from, to) = (*self.lengths.get(after - 1)?, *self.lengths.get(after)?);
        let share = if to > from { (distance - from) / (to - from) } else { 0.0 };
        self.place(surface, after - 1, share)
    }

    /// The place nearest to a position in the surface's local space. None if the surface is another one.
    ///
    /// Cost: linear in the crossings.
    pub fn nearest(&self, surface: &BuiltSurface, position: Vec3) -> Option<LinePlace> {
        let mut best = (f32::INFINITY, 0, 0.0);
        for (stretch, pair) in self.polyline().windows(2).enumerate() {
            let way = pair[1] - pair[0];
            let share = ((position - pair[0]).dot(way) / way.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            let distance = position.distance_squared(pair[0] + share * way);
            if distance < best.0 {
                best = (distance, stretch, f64::from(share));
            }
        }
        (best.0.is_finite() && self.is_on(surface)).then(|| self.place(surface, best.1, best.2))?
    }

    /// A place on a stretch between two places of the polyline.
    fn place(&self, surface: &Surface, stretch: usize, share: f64) -> Option<LinePlace> {
        let line = &self.smoothed.line;
        let (from, to) = (*self.lengths.get(stretch)?, *self.lengths.get(stretch + 1)?);
        // A crossing names the face that is left there: the one before it.
        let crossings = line.crossings();
        let before = if line.is_closed() { (stretch + 1) % crossings.len().max(1) } else { stretch };
        let face = crossings.get(before).map_or(line.ends()[1].face, |crossing| crossing.face);
        let points = [stretch, stretch + 1].map(|i| point_at(line, i));
        let position = surface.position(&points[0]).lerp(surface.position(&points[1]), share);
        let point = point_in(surface, face, position)?;
        Some(LinePlace { distance: from + share * (to - from), point })
    }

    /// Whether it is of this very surface.
    pub fn is_on(&self, surface: &BuiltSurface) -> bool {
        self.is_of(&surface.0)
    }

    pub(crate) fn is_of(&self, surface: &Arc<Surface>) -> bool {
        std::ptr::eq(self.surface.as_ptr(), Arc::as_ptr(surface))
    }

    /// The centre and radius of a sphere that holds the polyline, in local space.
    pub(crate) fn bounds(&self) -> (Vec3, f32) {
        self.polyline.bounds()
    }
}

/// Positions of ends and crossings; of a closed line the first one comes last again.
pub(crate) fn positions(surface: &Surface, line: &SurfacePolyline) -> Vec<DVec3> {
    let mut points = line.points();
    if line.is_closed() {
        points.extend(points.first().copied());
    }
    points.iter().map(|point| surface.position(point)).collect()
}

/// An end or a crossing, counted as in the polyline.
fn point_at(line: &SurfacePolyline, i: usize) -> SurfacePoint {
    let crossings = line.crossings();
    let crossing = if line.is_closed() { Some(i % crossings.len().max(1)) } else { i.checked_sub(1) };
    match crossing.map(|i| crossings.get(i)) {
        Some(Some(crossing)) => {
            let mut weights = [0.0; 3];
            let side = usize::from(crossing.side) % 3;
            (weights[side], weights[(side + 1) % 3]) = (1.0 - crossing.at, crossing.at);
            SurfacePoint { face: crossing.face, weights }
        }
        Some(None) => line.ends()[1],
        None => line.ends()[0],
    }
}

/// The point of a face at a position in its plane.
fn point_in(surface: &Surface, face: FaceId, position: DVec3) -> Option<SurfacePoint> {
    let [a, b, c] = surface.corners(face).ok()?;
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared();
    let weight = |from: DVec3, to: DVec3| ((to - from).cross(position - from).dot(normal) / area).max(0.0);
    let weights = [weight(b, c), weight(c, a), weight(a, b)];
    let sum: f64 = weights.iter().sum();
    surface.point(face, weights.map(|w| w / sum)).ok()
}

/// Bends of a closed line are measured from a crossing that is at no vertex; here from the first.
fn begin_with_the_line(surface: &Surface, positions: &[DVec3], lengths: &[f64], bends: &mut [LineBend]) {
    let (Some(first), Some(whole)) = (bends.first().copied(), lengths.last().copied()) else { return };
    let at = surface.position(&first.point);
    let near = positions.iter().zip(lengths).min_by(|a, b| a.0.distance(at).total_cmp(&b.0.distance(at)));
    let Some((_, there)) = near.filter(|_| whole > 0.0) else { return };
    let shift = there - first.distance;
    if shift.abs() > 1e-9 * whole {
        bends.iter_mut().for_each(|bend| bend.distance = (bend.distance + shift).rem_euclid(whole));
        bends.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    }
}

/// Curvature at each of some lengths along a line: the turns within some stretches of it, the nearer the more.
fn curvatures(bends: &[LineBend], lengths: &[f64], closed: bool) -> Arc<[f32]> {
    let whole = lengths.last().copied().unwrap_or(0.0);
    let reach = WITHIN * whole / lengths.len().saturating_sub(1).max(1) as f64;
    let again = |turns: f64| bends.iter().map(move |bend| (bend.distance + turns * whole, bend.turn));
    let around = |turns: f64| again(turns).filter(|_| closed);
    let turns: Vec<(f64, f64)> = around(-1.0).chain(again(0.0)).chain(around(1.0)).collect();
    let mut first = 0;
    let at = |length: &f64| {
        first += turns[first..].iter().take_while(|(there, _)| *there <= length - reach).count();
        let near = turns[first..].iter().take_while(|(there, _)| *there < length + reach);
        let weigh = |(there, turn): &(f64, f64)| turn * (1.0 - (there - length).abs() / reach) / reach;
        near.map(weigh).sum::<f64>() as f32
    };
    lengths.iter().map(at).collect()
}
