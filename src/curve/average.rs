//! Legs and geodesic averages: what all schemes are made of.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI, TAU};

use glam::DVec2;

use crate::geodesic::{
    PathError, PathFinder, PathQuality,
    chain::turn_into,
    inner::{InnerPath, Place},
    tangent::InnerTangent,
    transport::{angle_at, direction_from, direction_to},
};
use crate::surface::{InnerPoint, Surface, Zeros};

/// Legs longer than this share of the diagonal are searched rather than continued (spec: beyond it, continuation winds
/// around bumps).
const SHORT_LEG: f64 = 0.1;
/// A joint that turns more than this is searched.
const GENTLE_TURN: f64 = FRAC_PI_4;

/// Finds legs, and bridges between legs that meet.
pub(crate) struct Averager<'a> {
    pub(crate) surface: &'a Surface,
    pub(crate) finder: &'a mut PathFinder,
    /// Of the legs that are searched.
    pub(crate) quality: PathQuality,
}

/// A part of a leg.
#[derive(Clone, Copy)]
pub(crate) struct Span<'l> {
    pub(crate) leg: &'l InnerPath,
    pub(crate) from: Place,
    pub(crate) to: Place,
}

impl<'l> Span<'l> {
    /// The part between two shares of the length.
    pub(crate) fn new(surface: &Surface, leg: &'l InnerPath, from: f64, to: f64) -> Self {
        Self { leg, from: leg.at_share(surface, from), to: leg.at_share(surface, to) }
    }

    /// All of it.
    pub(crate) fn whole(leg: &'l InnerPath) -> Self {
        Self { leg, from: leg.first(), to: leg.last() }
    }
}

impl Averager<'_> {
    /// The shortest path between two points.
    pub(crate) fn leg(&mut self, from: &InnerPoint, to: &InnerPoint) -> Result<InnerPath, PathError> {
        let mut leg = InnerPath::default();
        self.leg_into(from, to, &mut leg)?;
        Ok(leg)
    }

    /// [`leg`](Self::leg) into reused memory.
    pub(crate) fn leg_into(
        &mut self,
        from: &InnerPoint,
        to: &InnerPoint,
        out: &mut InnerPath,
    ) -> Result<(), PathError> {
        self.finder.shortest_inner(self.surface, from, to, self.quality, out)
    }

    /// The point at a share of a leg's length.
    pub(crate) fn point(&self, leg: &InnerPath, share: f64) -> InnerPoint {
        leg.at_share(self.surface, share).1
    }

    /// The path from where one span begins to where the next ends; the spans meet in a point.
    ///
    /// Where they are short and meet at a gentle angle, the two strips one after the other are straightened: much cheaper
    /// than a search, and as good. Otherwise the path is searched.
    pub(crate) fn bridge(&mut self, first: Span<'_>, second: Span<'_>) -> Result<InnerPath, PathError> {
        let mut path = InnerPath::default();
        self.bridge_into(first, second, &mut path)?;
        Ok(path)
    }

    /// [`bridge`](Self::bridge) into reused memory.
    pub(crate) fn bridge_into(
        &mut self,
        first: Span<'_>,
        second: Span<'_>,
        out: &mut InnerPath,
    ) -> Result<(), PathError> {
        let surface = self.surface;
        let [(i, start), (meets, here)] = [first.from, first.to];
        let [(continues, there), (j, end)] = [second.from, second.to];
        if start.face == end.face {
            out.set_straight(surface, start, end);
            return Ok(());
        }
        if self.are_short(first, second) && self.is_gentle(first, second) {
            let mut strip = self.finder.lend_strip();
            strip.extend_from_slice(first.leg.strip.get(i..meets).unwrap_or_default());
            let is_joined = turn_into(surface, &here, there.face, &mut strip);
            if is_joined {
                strip.extend_from_slice(second.leg.strip.get(continues..j).unwrap_or_default());
                self.finder.continue_inner(surface, &start, &end, &mut strip, out);
            }
            self.finder.take_strip_back(strip);
            if is_joined {
                return Ok(());
            }
        }
        self.leg_into(&start, &end, out)
    }

    fn are_short(&self, first: Span<'_>, second: Span<'_>) -> bool {
        let limit = SHORT_LEG * self.surface.diagonal();
        first.leg.length < limit && second.leg.length < limit
    }

    /// Whether the way turns little where two spans meet.
    fn is_gentle(&self, first: Span<'_>, second: Span<'_>) -> bool {
        /// Stretches shorter than this share of their face's longest side have no direction to trust.
        const FAR_ENOUGH: f64 = 1e-3;
        let surface = self.surface;
        let [(i, here), (j, there)] = [first.to, second.from];
        if here.face == there.face && here.zeros() == Zeros::None {
            // Inside a face directions are what they are in space.
            let at = |p: &InnerPoint| surface.inner_position(p);
            let arriving = at(&here) - at(&first.leg.entry(surface, i));
            let leaving = at(&second.leg.exit(j)) - at(&there);
            let longest = surface.lengths[here.face as usize].iter().fold(0.0_f64, |m, l| m.max(*l));
            let (a, b) = (arriving.length(), leaving.length());
            if a.min(b) > FAR_ENOUGH * longest {
                return arriving.dot(leaving) > FRAC_1_SQRT_2 * a * b;
            }
        }
        self.turn(first, second).abs() < GENTLE_TURN
    }

    /// By how much the way turns left where two spans meet, in (−π, π]; zero where one has no length.
    pub(crate) fn turn(&self, first: Span<'_>, second: Span<'_>) -> f64 {
        let [(i, here), (j, _)] = [first.to, second.from];
        let arriving = InnerTangent { face: first.leg.face(i), vector: direction_to(self.surface, first.leg, i) };
        let leaving = InnerTangent { face: second.leg.face(j), vector: direction_from(self.surface, second.leg, j) };
        if arriving.vector == DVec2::ZERO || leaving.vector == DVec2::ZERO {
            return 0.0;
        }
        let angle = angle_at(self.surface, &here, &arriving, &leaving).rem_euclid(TAU);
        if angle > PI { angle - TAU } else { angle }
    }
}
