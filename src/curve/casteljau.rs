//! Recursive de Casteljau (Mancinelli et al. 2022, sec. 3.4; Noakes 1998), for polygons of any degree.

use super::average::{Averager, Span};
use crate::geodesic::{PathError, inner::InnerPath};

/// The legs of a Bézier polygon: three of a cubic one, two of a quadratic one.
pub(crate) type Legs = Vec<InnerPath>;

/// A Bézier polygon split in two, each the polygon of its part of the curve.
pub(crate) struct Split {
    pub(crate) left: Legs,
    pub(crate) right: Legs,
}

/// De Casteljau's construction at `t`: the legs of each round join points at share `t` of consecutive legs of the round
/// before.
///
/// Only the legs between are new paths (three for a cubic, one for a quadratic); all others are pieces of known ones. Away
/// from the middle it is right for short polygons only: on long ones the new legs may jump.
pub(crate) fn split(averager: &mut Averager<'_>, legs: &[InnerPath], t: f64) -> Result<Split, PathError> {
    let surface = averager.surface;
    let piece = |leg: Option<&InnerPath>, from: f64, to: f64| leg.map(|leg| leg.piece(surface, from, to));
    let mut left = Vec::with_capacity(legs.len());
    let mut right = Vec::with_capacity(legs.len());
    left.extend(piece(legs.first(), 0.0, t));
    right.extend(piece(legs.last(), t, 1.0));
    let mut round: Legs = Vec::new();
    for k in 1..legs.len() {
        let before = if k == 1 { legs } else { &round };
        let next = before
            .windows(2)
            .map(|pair| averager.bridge(Span::new(surface, &pair[0], t, 1.0), Span::new(surface, &pair[1], 0.0, t)));
        round = next.collect::<Result<_, _>>()?;
        left.extend(piece(round.first(), 0.0, t));
        right.extend(piece(round.last(), t, 1.0));
    }
    right.reverse();
    Ok(Split { left, right })
}

/// The polygons of the curve's two halves.
pub(crate) fn halve(averager: &mut Averager<'_>, legs: &[InnerPath]) -> Result<Split, PathError> {
    split(averager, legs, 0.5)
}
