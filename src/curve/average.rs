//! Legs and geodesic averages: what all schemes are made of.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI, TAU};

use glam::DVec2;

use crate::geodesic::{
    PathError, PathFinder, PathQuality,
    chain::turn_into,
    inner::InnerPath,
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

/// A stretch of a leg, between two shares of its length.
#[derive(Clone, Copy)]
pub(crate) struct Span<'l> {
    pub(crate) leg: &'l InnerPath,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

impl<'l> Span<'l> {
    pub(crate) fn new(leg: &'l InnerPath, from: f64, to: f64) -> Self {
        Self { leg, from, to }
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
        let (i, start) = first.leg.at_share(surface, first.from);
        let (j, end) = second.leg.at_share(surface, second.to);
        if start.face != end.face && self.are_short(first, second) {
            let meet = Meeting::of(surface, first, second);
            if meet.is_gentle(self, first, second) {
                let mut strip = self.finder.lend_strip();
                strip.extend_from_slice(first.leg.strip.get(i..meet.first).unwrap_or_default());
                let meets = turn_into(surface, &meet.here, meet.there.face, &mut strip);
                if meets {
                    strip.extend_from_slice(second.leg.strip.get(meet.second..j).unwrap_or_default());
                    self.finder.continue_inner(surface, &start, &end, &mut strip, out);
                }
                self.finder.take_strip_back(strip);
                if meets {
                    return Ok(());
                }
            }
        }
        self.leg_into(&start, &end, out)
    }

    fn are_short(&self, first: Span<'_>, second: Span<'_>) -> bool {
        let limit = SHORT_LEG * self.surface.diagonal();
        first.leg.length < limit && second.leg.length < limit
    }

    /// By how much the way turns left where two spans meet, in (−π, π]; zero where one has no length.
    pub(crate) fn turn(&self, first: Span<'_>, second: Span<'_>) -> f64 {
        let (meet, here) = first.leg.at_share(self.surface, first.to);
        let (from, _) = second.leg.at_share(self.surface, second.from);
        let arriving = InnerTangent { face: first.leg.face(meet), vector: direction_to(self.surface, first.leg, meet) };
        let leaving =
            InnerTangent { face: second.leg.face(from), vector: direction_from(self.surface, second.leg, from) };
        if arriving.vector == DVec2::ZERO || leaving.vector == DVec2::ZERO {
            return 0.0;
        }
        let angle = angle_at(self.surface, &here, &arriving, &leaving).rem_euclid(TAU);
        if angle > PI { angle - TAU } else { angle }
    }
}

/// Where two spans meet: the stretches of their legs, and the place as either spells it.
struct Meeting {
    first: usize,
    here: InnerPoint,
    second: usize,
    there: InnerPoint,
}

impl Meeting {
    fn of(surface: &Surface, first: Span<'_>, second: Span<'_>) -> Self {
        let (i, here) = first.leg.at_share(surface, first.to);
        let (j, there) = second.leg.at_share(surface, second.from);
        Self { first: i, here, second: j, there }
    }

    /// Whether the way turns little there.
    fn is_gentle(&self, averager: &Averager<'_>, first: Span<'_>, second: Span<'_>) -> bool {
        /// Stretches shorter than this share of their face's longest side have no direction to trust.
        const FAR_ENOUGH: f64 = 1e-3;
        let surface = averager.surface;
        if self.here.face == self.there.face && self.here.zeros() == Zeros::None {
            // Inside a face directions are what they are in space.
            let at = |p: &InnerPoint| surface.inner_position(p);
            let arriving = at(&self.here) - at(&first.leg.entry(surface, self.first));
            let leaving = at(&second.leg.exit(self.second)) - at(&self.there);
            let longest = surface.lengths[self.here.face as usize].iter().fold(0.0_f64, |m, l| m.max(*l));
            let (a, b) = (arriving.length(), leaving.length());
            if a.min(b) > FAR_ENOUGH * longest {
                return arriving.dot(leaving) > FRAC_1_SQRT_2 * a * b;
            }
        }
        averager.turn(first, second).abs() < GENTLE_TURN
    }
}
