//! A piece of a curve with the legs that make it: what is halved, turned into a Bézier polygon and asked for points.

use glam::DVec2;

use super::{
    average::{Averager, Span},
    casteljau::{self, Legs},
    lane_riesenfeld::Interval,
};
use crate::geodesic::{
    PathError,
    inner::InnerPath,
    tangent::{InnerTangent, spell_in},
    transport::{final_direction, initial_direction},
};
use crate::surface::InnerPoint;

/// A piece of a curve, by its control polygon.
#[derive(Clone, Debug)]
pub(crate) enum Control {
    /// The curve that recursive halving of a Bézier polygon leads to.
    Bezier(Legs),
    /// An interval of a B-spline.
    Interval(Interval),
}

/// Legs shorter than this share of the diagonal have no direction.
const NO_LENGTH: f64 = 1e-12;

impl Control {
    /// The legs between its control points.
    pub(crate) fn legs(&self) -> &[InnerPath] {
        match self {
            Self::Bezier(legs) | Self::Interval(Interval { legs, .. }) => legs,
        }
    }

    /// Length of the longest leg.
    pub(crate) fn longest_leg(&self) -> f64 {
        self.legs().iter().map(|leg| leg.length).fold(0.0, f64::max)
    }

    /// The two halves.
    pub(crate) fn halve(&self, averager: &mut Averager<'_>) -> Result<[Self; 2], PathError> {
        match self {
            Self::Bezier(legs) => {
                let halves = casteljau::halve(averager, legs)?;
                Ok([Self::Bezier(halves.left), Self::Bezier(halves.right)])
            }
            Self::Interval(interval) => Ok(interval.halve(averager)?.map(Self::Interval)),
        }
    }

    /// [`bezier`](Self::bezier), at no cost where it is one already.
    pub(crate) fn into_bezier(self, averager: &mut Averager<'_>) -> Result<Legs, PathError> {
        match self {
            Self::Bezier(legs) => Ok(legs),
            Self::Interval(interval) => interval.bezier(averager),
        }
    }

    /// The Bézier polygon; the shorter and straighter a B-spline's interval is, the better it stands for the curve.
    pub(crate) fn bezier(&self, averager: &mut Averager<'_>) -> Result<Legs, PathError> {
        match self {
            Self::Bezier(legs) => Ok(legs.clone()),
            Self::Interval(interval) => interval.bezier(averager),
        }
    }
}

/// Whether a polygon turns by no more than `turn` at each joint and has no leg longer than `length`.
pub(crate) fn is_flat(averager: &Averager<'_>, legs: &[InnerPath], turn: f64, length: f64) -> bool {
    let mut last = None;
    legs.iter().all(|leg| leg.length <= length)
        && with_length(averager, legs).all(|leg| last.replace(leg).is_none_or(|l| leg_turn(averager, l, leg) <= turn))
}

/// The legs that go anywhere: a leg without length has no direction, and what counts is the turn from the leg before it to the
/// one after it.
pub(crate) fn with_length<'l>(
    averager: &Averager<'_>,
    legs: &'l [InnerPath],
) -> impl DoubleEndedIterator<Item = &'l InnerPath> {
    let least = NO_LENGTH * averager.surface.diagonal();
    legs.iter().filter(move |leg| leg.length > least)
}

/// The angle by which the second leg departs from the first.
pub(crate) fn leg_turn(averager: &Averager<'_>, first: &InnerPath, second: &InnerPath) -> f64 {
    averager.turn(Span::whole(first), Span::whole(second)).abs()
}

/// A curve's point, with what de Casteljau's last steps say about it.
#[derive(Clone, Debug)]
pub(crate) struct Spot {
    pub(crate) point: InnerPoint,
    /// Derivative by the parameter.
    pub(crate) derivative: InnerTangent,
    /// Geodesic curvature, positive where the curve turns left; zero where the derivative is.
    pub(crate) curvature: f64,
}

/// What evaluation halves down to: turns of a degree and legs of a hundredth of the diagonal.
const FLAT: (f64, f64) = (1.0 * std::f64::consts::PI / 180.0, 0.01);
/// How often it halves at most.
const MAX_LEVELS: u32 = 20;

/// The Bézier polygon of a short and nearly straight part of the curve around `t`, and which part that is.
pub(crate) struct Leaf {
    pub(crate) legs: Legs,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

/// Descends to the leaf around `t`.
pub(crate) fn leaf_at(averager: &mut Averager<'_>, control: &Control, t: f64) -> Result<Leaf, PathError> {
    let (turn, length) = (FLAT.0, FLAT.1 * averager.surface.diagonal());
    let (mut from, mut to) = (0.0, 1.0);
    let mut here = None;
    for _ in 0..MAX_LEVELS {
        let control = here.as_ref().unwrap_or(control);
        if is_flat(averager, control.legs(), turn, length) {
            break;
        }
        let [left, right] = control.halve(averager)?;
        let middle = 0.5 * (from + to);
        if t < middle {
            (here, to) = (Some(left), middle);
        } else {
            (here, from) = (Some(right), middle);
        }
    }
    let legs = here.as_ref().unwrap_or(control).bezier(averager)?;
    Ok(Leaf { legs, from, to })
}

/// The curve's point at `t`: halves towards `t` until the polygon is short and nearly straight, then averages directly.
pub(crate) fn evaluate(averager: &mut Averager<'_>, control: &Control, t: f64) -> Result<Spot, PathError> {
    let t = t.clamp(0.0, 1.0);
    let leaf = leaf_at(averager, control, t)?;
    let width = leaf.to - leaf.from;
    let local = ((t - leaf.from) / width).clamp(0.0, 1.0);
    let split = casteljau::split(averager, &leaf.legs, local)?;
    let spot = spot(averager, &split, local);
    let derivative = InnerTangent { vector: spot.derivative.vector / width, ..spot.derivative };
    Ok(Spot { derivative, ..spot })
}

/// Reads point, derivative and curvature off a polygon that was split at `t`: from its longer part.
///
/// With X the point, R the next control point and S the one after it, in the part of width w: the derivative is
/// degree · |XR|/w towards R, the curvature (degree − 1)/degree · |RS| sin ∠/|XR|², ∠ the turn at R.
pub(crate) fn spot(averager: &Averager<'_>, split: &casteljau::Split, t: f64) -> Spot {
    let surface = averager.surface;
    let backwards = t > 0.5;
    let legs = if backwards { &split.left } else { &split.right };
    let degree = legs.len() as f64;
    let (first, second) = if backwards { (legs.last(), legs.iter().rev().nth(1)) } else { (legs.first(), legs.get(1)) };
    let Some(arm) = first else {
        // There is no polygon without legs.
        let nowhere = InnerTangent { face: 0, vector: DVec2::ZERO };
        return Spot { point: InnerPoint::default(), derivative: nowhere, curvature: 0.0 };
    };
    let (point, direction) =
        if backwards { (arm.end, final_direction(surface, arm)) } else { (arm.start, initial_direction(surface, arm)) };
    let width = if backwards { t } else { 1.0 - t };
    let derivative = InnerTangent { vector: direction.vector * (degree * arm.length / width), ..direction };
    let point = spell_in(surface, &point, derivative.face).unwrap_or(point);
    let curvature = match second {
        Some(second) if arm.length > NO_LENGTH * surface.diagonal() => {
            let (a, b) = if backwards { (second, arm) } else { (arm, second) };
            let turn = averager.turn(Span::whole(a), Span::whole(b));
            (degree - 1.0) / degree * second.length * turn.sin() / (arm.length * arm.length)
        }
        _ => 0.0,
    };
    Spot { point, derivative, curvature }
}
