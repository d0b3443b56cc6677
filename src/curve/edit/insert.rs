//! Inserting an anchor on the curve.

use std::f64::consts::PI;

use glam::DVec3;

use super::EditError;
use crate::curve::{Handle, Join, Spline, SplineT, average::Averager, handles, piece::Control, segment};
use crate::geodesic::{PathFinder, inner::InnerPath, tangent::turn_at};
use crate::surface::{PointError, Surface};

/// Places on each half where old and new curve are compared.
const SAMPLES: u32 = 16;

/// What inserting an anchor makes of a spline.
#[derive(Clone, Debug, PartialEq)]
pub struct Insertion {
    /// The spline with the anchor.
    pub spline: Spline,
    /// The new anchor.
    pub anchor: u32,
    /// Largest distance found between the old curve and the new one at equal parameters, in local units: 16 places on each
    /// half are compared. For a B-spline, whose parameters shift: of 17 places on the segment from the new curve, to about
    /// a thousandth of the length.
    pub deviation: f64,
    /// Length of the old segment, roughly, in local units.
    pub length: f64,
}

impl Insertion {
    /// The deviation as a share of the segment's length; zero for a segment of no length.
    pub fn relative(&self) -> f64 {
        if self.length > 0.0 { self.deviation / self.length } else { 0.0 }
    }

    /// Whether the curve moved by less than a hundredth of the segment's length.
    ///
    /// Where it did not, the segment is too long for its surface: inserting two anchors changes less. A B-spline is meant to
    /// change.
    pub fn is_close(&self) -> bool {
        self.relative() < 0.01
    }
}

impl Spline {
    /// Inserts a smooth anchor at a place on the curve: the handles around are shortened as de Casteljau's construction
    /// asks, and the new ones lie along the curve's tangent. Exact in the plane; on a surface the curve moves a little, and
    /// by how much is measured.
    ///
    /// With c the curve and t the local parameter, the new handles lie at −c′(t) t/3 and c′(t) (1 − t)/3 from c(t), and the
    /// outer ones at shares t and 1 − t of what they were. A mirrored or automatic neighbour becomes smooth.
    ///
    /// A B-spline gets a control point on the middle leg of the interval instead.
    ///
    /// Source: Mancinelli et al. 2022, sec. 4.2 (the inner handles straight from the derivative).
    ///
    /// # Errors
    /// [`EditError::AtAnchor`] where there is an anchor, [`EditError::Trace`] outside the spline.
    pub fn insertion(&self, surface: &Surface, finder: &mut PathFinder, at: SplineT) -> Result<Insertion, EditError> {
        let (segment, t) = at.locate(self.segment_count())?;
        let mut averager = Averager { surface, finder, quality: self.scheme.quality };
        let old = self.control(&mut averager, segment)?;
        if self.scheme.method.is_b_spline() {
            return self.with_control_point(&mut averager, &old, segment, t);
        }
        if t <= 0.0 || t >= 1.0 {
            return Err(EditError::AtAnchor { t: at.0 });
        }
        let spot = segment::evaluate(&mut averager, &old, self.scheme, t)?;
        let point = surface.outer_point(&spot.point);
        let reach = spot.derivative.vector.length() / 3.0;
        let mut anchor = handles::bare_anchor(surface, point)?;
        if reach > 0.0 {
            let back = turn_at(surface, &spot.point, &spot.derivative, PI);
            anchor.outgoing = handles::ahead(surface, &anchor.point, &spot.derivative, reach * (1.0 - t))?;
            anchor.incoming = handles::ahead(surface, &anchor.point, &back, reach * t)?;
            anchor.join = Join::Smooth;
        }
        let mut spline = self.clone();
        let next = (segment + 1) % self.anchors.len();
        spline.anchors[segment].outgoing = shortened(surface, &self.anchors[segment].outgoing, t)?;
        spline.anchors[next].incoming = shortened(surface, &self.anchors[next].incoming, 1.0 - t)?;
        for k in [segment, next] {
            if matches!(spline.anchors[k].join, Join::Mirrored | Join::Automatic) {
                spline.anchors[k].join = Join::Smooth;
            }
        }
        spline.anchors[segment].middle = None;
        spline.anchors.insert(segment + 1, anchor);
        spline.settle_middles(surface, averager.finder)?;
        let halves = [spline.control(&mut averager, segment)?, spline.control(&mut averager, segment + 1)?];
        let (deviation, length) = self.compare(&mut averager, &old, &halves, t)?;
        Ok(Insertion { spline, anchor: segment as u32 + 1, deviation, length })
    }

    /// Largest distance between a curve and its two halves, split at `t`, and the curve's length.
    fn compare(
        &self,
        averager: &mut Averager<'_>,
        old: &Control,
        halves: &[Control; 2],
        t: f64,
    ) -> Result<(f64, f64), EditError> {
        let surface = averager.surface;
        let mut place = |control: &Control, t: f64| -> Result<_, EditError> {
            Ok(surface.inner_position(&segment::evaluate(averager, control, self.scheme, t)?.point))
        };
        let (mut deviation, mut length) = (0.0_f64, 0.0);
        let mut before = place(old, 0.0)?;
        for (half, [from, to]) in halves.iter().zip([[0.0, t], [t, 1.0]]) {
            for k in 1..=SAMPLES {
                let share = f64::from(k) / f64::from(SAMPLES);
                let here = place(old, from + share * (to - from))?;
                deviation = deviation.max(place(half, share)?.distance(here));
                length += before.distance(here);
                before = here;
            }
        }
        Ok((deviation, length))
    }

    /// Adds a control point on the middle leg of a B-spline's interval.
    fn with_control_point(
        &self,
        averager: &mut Averager<'_>,
        old: &Control,
        segment: usize,
        t: f64,
    ) -> Result<Insertion, EditError> {
        let surface = averager.surface;
        let legs = old.legs();
        // The leg whose middle is the interval's: of a cubic the second of three, of a quadratic the nearer of two.
        let (leg, share) = match (legs.len(), t < 0.5) {
            (2, true) => (0, 0.5 + t),
            (2, false) => (1, t - 0.5),
            _ => (1, t),
        };
        let point = averager.point(&legs[leg], share);
        let anchor = handles::bare_anchor(surface, surface.outer_point(&point))?;
        let mut spline = self.clone();
        let place = segment + leg + 1;
        let place = if place > self.anchors.len() { place - self.anchors.len() } else { place };
        spline.anchors.insert(place, anchor);
        // A control point that came before the segment's own shifts it by one.
        let segment = if place <= segment { segment + 1 } else { segment };
        let (deviation, length) = self.distance_to(averager, old, &spline, segment)?;
        Ok(Insertion { spline, anchor: place as u32, deviation, length })
    }

    /// Largest distance from a segment of a B-spline to where another one runs around segment `near`, and the segment's length.
    fn distance_to(
        &self,
        averager: &mut Averager<'_>,
        old: &Control,
        new: &Self,
        near: usize,
    ) -> Result<(f64, f64), EditError> {
        let surface = averager.surface;
        let sampled = |averager: &mut Averager<'_>, control: &Control| -> Result<Vec<DVec3>, EditError> {
            let mut place = |k| segment::evaluate(averager, control, self.scheme, f64::from(k) / f64::from(SAMPLES));
            (0..=SAMPLES).map(|k| Ok(surface.inner_position(&place(k)?.point))).collect()
        };
        let before = sampled(averager, old)?;
        let count = new.segment_count();
        let mut line = Vec::new();
        // The segment has become two; what was at its ends may lie in the ones beside.
        for k in near + count - 1..near + count + 3 {
            if new.closed || (count..2 * count).contains(&k) {
                let control = new.control(averager, k % count)?;
                line.push(sampled(averager, &control)?);
            }
        }
        let distance = |p: &DVec3| {
            let pairs = line.iter().flat_map(|piece| piece.windows(2));
            pairs.map(|pair| distance_to_line(*p, [pair[0], pair[1]])).fold(f64::INFINITY, f64::min)
        };
        let deviation = before.iter().map(distance).fold(0.0, f64::max);
        Ok((deviation, before.windows(2).map(|pair| pair[0].distance(pair[1])).sum()))
    }
}

/// Distance of a position from a line between two others.
fn distance_to_line(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let way = b - a;
    let share = ((p - a).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(a + share * way)
}

/// The handle at a share of its leg.
fn shortened(surface: &Surface, handle: &Handle, share: f64) -> Result<Handle, PointError> {
    let leg = InnerPath::from_outer(surface, &handle.leg)?.piece(surface, 0.0, share);
    Ok(Handle { wished_length: leg.length, leg: leg.to_outer(surface), heading: handle.heading })
}
