//! A path in inner spelling, with cumulative lengths.

use glam::DVec3;

use super::{Crossing, GeodesicPath};
use crate::surface::{HalfEdge, InnerPoint, PointError, Surface};

/// A place on a path: the stretch, and the point there.
pub(crate) type Place = (usize, InnerPoint);

/// A path in inner spelling: what the engine works on.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct InnerPath {
    pub(crate) start: InnerPoint,
    pub(crate) end: InnerPoint,
    /// The sides through which faces are left, in order.
    pub(crate) strip: Vec<HalfEdge>,
    /// Where each side is crossed: 0 at its origin, 1 at its target.
    pub(crate) at: Vec<f64>,
    /// Distance along the path from the start to each crossing.
    pub(crate) travelled: Vec<f64>,
    pub(crate) length: f64,
    /// Whether straightening met its bound.
    pub(crate) frozen: bool,
}

impl Default for InnerPoint {
    fn default() -> Self {
        Self { face: 0, weights: [1.0, 0.0, 0.0] }
    }
}

impl InnerPath {
    /// The face of stretch `i`.
    pub(crate) fn face(&self, i: usize) -> u32 {
        self.strip.get(i).map_or(self.end.face, |h| h.face())
    }

    /// Where stretch `i` begins, in its face.
    pub(crate) fn entry(&self, surface: &Surface, i: usize) -> InnerPoint {
        match i.checked_sub(1) {
            None => self.start,
            Some(before) => InnerPoint::on_side(surface.twin(self.strip[before]), 1.0 - self.at[before]),
        }
    }

    /// Where stretch `i` ends, in its face.
    pub(crate) fn exit(&self, i: usize) -> InnerPoint {
        self.strip.get(i).map_or(self.end, |h| InnerPoint::on_side(*h, self.at[i]))
    }

    /// Number of stretches.
    pub(crate) fn stretches(&self) -> usize {
        self.strip.len() + 1
    }

    /// Position of crossing `i`.
    pub(crate) fn crossing_position(&self, surface: &Surface, i: usize) -> DVec3 {
        let (h, t) = (self.strip[i], self.at[i]);
        side_position(surface, h, t)
    }

    /// Becomes a copy of another path, keeping its memory.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        let Self { start, end, strip, at, travelled, length, frozen } = other;
        (self.start, self.end, self.length, self.frozen) = (*start, *end, *length, *frozen);
        self.strip.clone_from(strip);
        self.at.clone_from(at);
        self.travelled.clone_from(travelled);
    }

    /// Makes this a path of one stretch, keeping its memory.
    pub(crate) fn set_straight(&mut self, surface: &Surface, start: InnerPoint, end: InnerPoint) {
        (self.start, self.end, self.frozen) = (start, end, false);
        self.strip.clear();
        self.at.clear();
        self.measure(surface);
    }

    /// Fills in distances from the crossings' positions.
    pub(crate) fn measure(&mut self, surface: &Surface) {
        self.travelled.clear();
        let mut here = surface.inner_position(&self.start);
        let mut sum = 0.0;
        for i in 0..self.strip.len() {
            let next = self.crossing_position(surface, i);
            sum += here.distance(next);
            self.travelled.push(sum);
            here = next;
        }
        self.length = sum + here.distance(surface.inner_position(&self.end));
    }

    /// Turns the path round.
    pub(crate) fn reverse(&mut self, surface: &Surface) {
        std::mem::swap(&mut self.start, &mut self.end);
        reverse_strip(surface, &mut self.strip);
        self.at.reverse();
        self.at.iter_mut().for_each(|t| *t = 1.0 - *t);
        let length = self.length;
        self.travelled.reverse();
        self.travelled.iter_mut().for_each(|d| *d = length - *d);
    }

    /// The stretch that a distance from the start falls into, and the point there.
    pub(crate) fn at_distance(&self, surface: &Surface, distance: f64) -> Place {
        let distance = distance.clamp(0.0, self.length);
        let stretch = self.travelled.partition_point(|d| *d < distance);
        let before = stretch.checked_sub(1).map_or(0.0, |i| self.travelled[i]);
        let after = self.travelled.get(stretch).copied().unwrap_or(self.length);
        let (a, b) = (self.entry(surface, stretch), self.exit(stretch));
        let share = if after > before { ((distance - before) / (after - before)).clamp(0.0, 1.0) } else { 0.0 };
        (stretch, between(&a, &b, share))
    }

    /// The point at a share of the length, with its stretch.
    pub(crate) fn at_share(&self, surface: &Surface, share: f64) -> Place {
        if share <= 0.0 {
            return self.first();
        }
        if share >= 1.0 {
            return self.last();
        }
        if self.strip.is_empty() {
            return (0, if self.length > 0.0 { between(&self.start, &self.end, share) } else { self.start });
        }
        self.at_distance(surface, share * self.length)
    }

    /// Where it starts.
    pub(crate) fn first(&self) -> Place {
        (0, self.start)
    }

    /// Where it ends.
    pub(crate) fn last(&self) -> Place {
        (self.strip.len(), self.end)
    }

    /// The piece between two shares of the length, `from` ≤ `to`.
    pub(crate) fn piece(&self, surface: &Surface, from: f64, to: f64) -> Self {
        let mut out = Self::default();
        self.piece_into(surface, self.at_share(surface, from), self.at_share(surface, to), &mut out);
        out
    }

    /// The piece between two places, into reused memory.
    pub(crate) fn piece_into(&self, surface: &Surface, from: Place, to: Place, out: &mut Self) {
        let [(first, start), (last, end)] = [from, to];
        let last = last.max(first);
        (out.start, out.end, out.frozen) = (start, end, self.frozen);
        out.strip.clear();
        out.strip.extend_from_slice(&self.strip[first..last]);
        out.at.clear();
        out.at.extend_from_slice(&self.at[first..last]);
        out.measure(surface);
    }

    /// The public form, in input faces.
    pub(crate) fn to_outer(&self, surface: &Surface) -> GeodesicPath {
        let mut out = GeodesicPath::at_rest(surface.outer_point(&self.start));
        self.outer_into(surface, &mut out);
        out
    }

    /// [`to_outer`](Self::to_outer) into reused memory.
    pub(crate) fn outer_into(&self, surface: &Surface, out: &mut GeodesicPath) {
        out.start = surface.outer_point(&self.start);
        out.end = surface.outer_point(&self.end);
        (out.length, out.frozen) = (self.length, self.frozen);
        out.crossings.clear();
        out.crossings.extend(self.strip.iter().zip(&self.at).map(|(h, t)| {
            let (face, side, reversed) = surface.outer_side(*h);
            Crossing { face, side, at: if reversed { 1.0 - t } else { *t } }
        }));
    }

    /// From the public form.
    ///
    /// # Errors
    /// [`PointError`] if the path does not belong to the surface.
    pub(crate) fn from_outer(surface: &Surface, path: &GeodesicPath) -> Result<Self, PointError> {
        let mut out = Self::default();
        out.set_outer(surface, path)?;
        Ok(out)
    }

    /// [`from_outer`](Self::from_outer) into reused memory.
    ///
    /// # Errors
    /// As there; what the path then is, is not defined.
    pub(crate) fn set_outer(&mut self, surface: &Surface, path: &GeodesicPath) -> Result<(), PointError> {
        let out = self;
        out.start = surface.inner_point(&path.start)?;
        out.end = surface.inner_point(&path.end)?;
        out.frozen = path.frozen;
        out.strip.clear();
        out.at.clear();
        let mut face = out.start.face;
        for c in &path.crossings {
            let (h, reversed) = surface.inner_side(c.face, c.side)?;
            let twin = surface.twin(h);
            if h.face() != face || !twin.is_some() || !(0.0..=1.0).contains(&c.at) {
                return Err(PointError::BadCrossing(c.face));
            }
            face = twin.face();
            out.strip.push(h);
            out.at.push(if reversed { 1.0 - c.at } else { c.at });
        }
        if face != out.end.face {
            return Err(PointError::BadCrossing(path.end.face));
        }
        out.measure(surface);
        Ok(())
    }
}

/// Position on a side, `t` of the way from its origin; the same bits from both faces.
pub(crate) fn side_position(surface: &Surface, h: HalfEdge, t: f64) -> DVec3 {
    let (a, b) = (surface.origin(h), surface.target(h));
    (1.0 - t) * surface.positions[a as usize] + t * surface.positions[b as usize]
}

/// Turns a strip round: the same faces, left through the other sides.
pub(crate) fn reverse_strip(surface: &Surface, strip: &mut [HalfEdge]) {
    strip.reverse();
    strip.iter_mut().for_each(|h| *h = surface.twin(*h));
}

/// The point between two points of one face.
pub(crate) fn between(a: &InnerPoint, b: &InnerPoint, share: f64) -> InnerPoint {
    if share <= 0.0 {
        return *a;
    }
    if share >= 1.0 {
        return *b;
    }
    let mut weights = [0.0; 3];
    for (k, w) in weights.iter_mut().enumerate() {
        *w = (a.weights[k] + share * (b.weights[k] - a.weights[k])).max(0.0) + 0.0;
    }
    let sum: f64 = weights.iter().sum();
    InnerPoint { face: a.face, weights: weights.map(|w| w / sum) }.snapped()
}
