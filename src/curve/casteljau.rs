//! Recursive de Casteljau (Mancinelli et al. 2022, sec. 3.4; Noakes 1998).

use super::average::{Averager, Span};
use crate::geodesic::{PathError, inner::InnerPath};
use crate::surface::InnerPoint;

/// The three legs of a cubic control polygon.
pub(crate) type Legs = [InnerPath; 3];

/// Halves a control polygon: the polygons of the curve's two halves.
///
/// Only three paths are new; all other legs are pieces of known ones.
pub(crate) fn halve(averager: &mut Averager<'_>, [l01, l12, l23]: &Legs) -> Result<[Legs; 2], PathError> {
    let a = averager.bridge(Span::new(l01, 0.5, 1.0), Span::new(l12, 0.0, 0.5))?;
    let b = averager.bridge(Span::new(l12, 0.5, 1.0), Span::new(l23, 0.0, 0.5))?;
    let c = averager.bridge(Span::new(&a, 0.5, 1.0), Span::new(&b, 0.0, 0.5))?;
    let s = averager.surface;
    Ok([
        [l01.piece(s, 0.0, 0.5), a.piece(s, 0.0, 0.5), c.piece(s, 0.0, 0.5)],
        [c.piece(s, 0.5, 1.0), b.piece(s, 0.5, 1.0), l23.piece(s, 0.5, 1.0)],
    ])
}

/// Halves `levels` times and appends the legs of all pieces in order.
pub(crate) fn trace(
    averager: &mut Averager<'_>,
    legs: Legs,
    levels: u8,
    out: &mut Vec<InnerPath>,
) -> Result<(), PathError> {
    if levels == 0 {
        out.extend(legs);
        return Ok(());
    }
    let [left, right] = halve(averager, &legs)?;
    trace(averager, left, levels - 1, out)?;
    trace(averager, right, levels - 1, out)
}

/// The curve's point at `t`: halves towards `t` until the polygon is short and nearly straight, then averages directly.
pub(crate) fn evaluate(averager: &mut Averager<'_>, legs: Legs, t: f64) -> Result<InnerPoint, PathError> {
    const MAX_LEVELS: u32 = 20;
    let (mut legs, mut t) = (legs, t.clamp(0.0, 1.0));
    for _ in 0..MAX_LEVELS {
        if t == 0.0 {
            return Ok(legs[0].start);
        }
        if t == 1.0 {
            return Ok(legs[2].end);
        }
        if is_flat(averager, &legs) {
            break;
        }
        let [left, right] = halve(averager, &legs)?;
        (legs, t) = if t < 0.5 { (left, 2.0 * t) } else { (right, 2.0 * t - 1.0) };
    }
    direct(averager, &legs, t)
}

/// Whether the polygon turns by less than 5° at both joints and no leg is longer than 1 % of the diagonal.
pub(crate) fn is_flat(averager: &Averager<'_>, legs: &Legs) -> bool {
    const STRAIGHT: f64 = 5.0 * std::f64::consts::PI / 180.0;
    let limit = 0.01 * averager.surface.diagonal();
    let [a, b, c] = legs.each_ref().map(|leg| Span::new(leg, 0.0, 1.0));
    legs.iter().all(|leg| leg.length <= limit)
        && averager.turn(a, b).abs() < STRAIGHT
        && averager.turn(b, c).abs() < STRAIGHT
}

/// De Casteljau's construction at `t` itself. Right for short polygons only: on long ones its intermediate legs jump.
pub(crate) fn direct(averager: &mut Averager<'_>, [l01, l12, l23]: &Legs, t: f64) -> Result<InnerPoint, PathError> {
    let a = averager.bridge(Span::new(l01, t, 1.0), Span::new(l12, 0.0, t))?;
    let b = averager.bridge(Span::new(l12, t, 1.0), Span::new(l23, 0.0, t))?;
    let c = averager.bridge(Span::new(&a, t, 1.0), Span::new(&b, 0.0, t))?;
    Ok(averager.point(&c, t))
}
