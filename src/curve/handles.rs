//! Placing handles: by a leg to a point, by direction and length, opposite a partner, from the neighbours.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::{Anchor, Handle, Join, Spline};
use crate::geodesic::{
    GeodesicPath, PathError, PathFinder, PathQuality, Tangent,
    inner::InnerPath,
    tangent::{InnerTangent, turn_at, unit},
    transport::{angle_at, initial_direction, transport},
    walk::walk_in,
};
use crate::surface::{PointError, Surface, SurfacePoint};

/// Handles shorter than this share of the diagonal have no say in their join.
const NO_LENGTH: f64 = 1e-9;

/// A handle of no length and no direction yet.
pub(crate) fn bare_handle(anchor: SurfacePoint) -> Handle {
    Handle {
        leg: GeodesicPath::at_rest(anchor),
        heading: Tangent { face: anchor.face, vector: DVec2::ZERO },
        wished_length: 0.0,
    }
}

/// −0 equals 0 but has other bits, and a spline is to come back from an edit bit for bit.
pub(crate) fn without_negative_zeros(point: SurfacePoint) -> SurfacePoint {
    SurfacePoint { face: point.face, weights: point.weights.map(|w| w + 0.0) }
}

/// An anchor whose handles have no length.
pub(crate) fn bare_anchor(surface: &Surface, point: SurfacePoint) -> Result<Anchor, PointError> {
    surface.inner_point(&point)?;
    let point = without_negative_zeros(point);
    Ok(Anchor { point, join: Join::Corner, incoming: bare_handle(point), outgoing: bare_handle(point), middle: None })
}

/// The handle at a point, reached by the shortest path.
pub(crate) fn towards(
    surface: &Surface,
    finder: &mut PathFinder,
    anchor: &SurfacePoint,
    to: &SurfacePoint,
) -> Result<Handle, PathError> {
    let mut leg = InnerPath::default();
    finder.shortest_inner(
        surface,
        &surface.inner_point(anchor)?,
        &surface.inner_point(to)?,
        PathQuality::Default,
        &mut leg,
    )?;
    Ok(along(surface, &leg))
}

/// The handle at the end of a leg.
pub(crate) fn along(surface: &Surface, leg: &InnerPath) -> Handle {
    let mut handle = bare_handle(surface.outer_point(&leg.start));
    set_along(surface, leg, &mut handle);
    handle
}

/// [`along`] into reused memory.
pub(crate) fn set_along(surface: &Surface, leg: &InnerPath, out: &mut Handle) {
    out.heading = surface.outer_tangent(&initial_direction(surface, leg));
    out.wished_length = leg.length;
    leg.outer_into(surface, &mut out.leg);
}

/// Handles longer than this many diagonals are cut short: they would wind around the model for ever.
pub(crate) const MAX_LENGTH: f64 = 16.0;

/// The handle in a direction at some distance, reached by walking straight ahead; cut short at the boundary.
pub(crate) fn ahead(
    surface: &Surface,
    anchor: &SurfacePoint,
    heading: &InnerTangent,
    length: f64,
) -> Result<Handle, PointError> {
    let mut handle = bare_handle(*anchor);
    set_ahead(surface, &mut InnerPath::default(), anchor, heading, length, &mut handle)?;
    Ok(handle)
}

/// [`ahead`] into reused memory; `spare` is overwritten.
pub(crate) fn set_ahead(
    surface: &Surface,
    spare: &mut InnerPath,
    anchor: &SurfacePoint,
    heading: &InnerTangent,
    length: f64,
    out: &mut Handle,
) -> Result<(), PointError> {
    let unit = InnerTangent { face: heading.face, vector: unit(heading.vector) };
    let reach = length.min(MAX_LENGTH * surface.diagonal());
    *spare = walk_in(surface, &surface.inner_point(anchor)?, &unit, reach, std::mem::take(spare)).path;
    spare.outer_into(surface, &mut out.leg);
    (out.heading, out.wished_length) = (surface.outer_tangent(&unit), length);
    Ok(())
}

/// Whether a handle has a direction that counts in its join.
pub(crate) fn has_say(surface: &Surface, handle: &Handle) -> bool {
    handle.leg.length() > NO_LENGTH * surface.diagonal()
}

/// Places the handle opposite to `leader`, with a length of its own; `spare` is overwritten.
pub(crate) fn set_opposite(
    surface: &Surface,
    spare: &mut InnerPath,
    anchor: &SurfacePoint,
    leader: &Handle,
    length: f64,
    out: &mut Handle,
) -> Result<(), PointError> {
    let (at, heading) = (surface.inner_point(anchor)?, surface.inner_tangent(&leader.heading)?);
    set_ahead(surface, spare, anchor, &turn_at(surface, &at, &heading, PI), length, out)
}

/// Moves an anchor along a path and carries its handles with it by parallel transport.
pub(crate) fn carry(
    surface: &Surface,
    finder: &mut PathFinder,
    anchor: &mut Anchor,
    path: &GeodesicPath,
    to: SurfacePoint,
) -> Result<(), PointError> {
    let (mut inner, mut spare) = (finder.lend_path(), finder.lend_path());
    inner.set_outer(surface, path)?;
    let incoming_leads = anchor.incoming.leg.length() > anchor.outgoing.leg.length();
    for handle in [&mut anchor.incoming, &mut anchor.outgoing] {
        let heading = transport(surface, &inner, &surface.inner_tangent(&handle.heading)?);
        set_ahead(surface, &mut spare, &to, &heading, handle.wished_length, handle)?;
    }
    anchor.point = to;
    let Anchor { join, incoming, outgoing, .. } = anchor;
    let (incoming_wish, outgoing_wish) = (incoming.wished_length, outgoing.wished_length);
    if matches!(join, Join::Smooth | Join::Mirrored)
        && incoming_wish.min(outgoing_wish) > NO_LENGTH * surface.diagonal()
    {
        // On the boundary one of them may point outwards, where there is nothing to be carried along with: the other leads.
        if incoming_leads {
            set_opposite(surface, &mut spare, &to, incoming, outgoing_wish, outgoing)?;
        } else {
            set_opposite(surface, &mut spare, &to, outgoing, incoming_wish, incoming)?;
        }
    }
    finder.take_path_back(inner);
    finder.take_path_back(spare);
    Ok(())
}

/// Places both handles of an anchor from its neighbours: chordal Catmull–Rom.
///
/// With u, v the normal coordinates of the anchors before and after, and d₀ = |u|, d₁ = |v|, the tangent is
/// m = (d₀ v/d₁ − d₁ u/d₀)/(d₀ + d₁); the handles lie at m d₁/3 and −m d₀/3.
pub(crate) fn place_automatic(
    surface: &Surface,
    finder: &mut PathFinder,
    spline: &mut Spline,
    anchor: usize,
) -> Result<(), PathError> {
    let point = spline.anchors[anchor].point;
    let at = surface.inner_point(&point)?;
    let (before, after) = spline.neighbours(anchor);
    let mut reach = |neighbour: Option<usize>| -> Result<Option<(InnerTangent, f64)>, PathError> {
        let Some(neighbour) = neighbour else { return Ok(None) };
        let mut leg = InnerPath::default();
        let goal = surface.inner_point(&spline.anchors[neighbour].point)?;
        finder.shortest_inner(surface, &at, &goal, PathQuality::Default, &mut leg)?;
        let length = leg.length;
        Ok((length > 0.0).then(|| (initial_direction(surface, &leg), length)))
    };
    let (before, after) = (reach(before)?, reach(after)?);
    let third = 1.0 / 3.0;
    let (incoming, outgoing) = match (before, after) {
        (None, None) => (bare_handle(point), bare_handle(point)),
        (Some((u, d0)), None) => (ahead(surface, &point, &u, d0 * third)?, bare_handle(point)),
        (None, Some((v, d1))) => (bare_handle(point), ahead(surface, &point, &v, d1 * third)?),
        (Some((u, d0)), Some((v, d1))) => {
            // In coordinates whose x axis is v's direction.
            let (v_flat, u_flat) = (DVec2::X * d1, DVec2::from_angle(angle_at(surface, &at, &v, &u)) * d0);
            let m = (v_flat * (d0 / d1) - u_flat * (d1 / d0)) / (d0 + d1);
            let angle = if m == DVec2::ZERO { 0.0 } else { m.y.atan2(m.x) };
            let forward = turn_at(surface, &at, &v, angle);
            let backward = turn_at(surface, &at, &v, (angle + PI).rem_euclid(TAU));
            let scale = m.length() * third;
            (ahead(surface, &point, &backward, scale * d0)?, ahead(surface, &point, &forward, scale * d1)?)
        }
    };
    let anchor = &mut spline.anchors[anchor];
    (anchor.incoming, anchor.outgoing) = (incoming, outgoing);
    Ok(())
}

/// Turns both handles so that they are opposite: each by half of what is missing; `equal` makes their lengths equal too.
pub(crate) fn align(surface: &Surface, anchor: &mut Anchor, equal: bool) -> Result<(), PointError> {
    let (says_in, says_out) = (has_say(surface, &anchor.incoming), has_say(surface, &anchor.outgoing));
    let (wish_in, wish_out) = (anchor.incoming.wished_length, anchor.outgoing.wished_length);
    let mean = 0.5 * (wish_in + wish_out);
    let (length_in, length_out) = if equal { (mean, mean) } else { (wish_in, wish_out) };
    let at = surface.inner_point(&anchor.point)?;
    let out = surface.inner_tangent(&anchor.outgoing.heading)?;
    let into = surface.inner_tangent(&anchor.incoming.heading)?;
    let forward = match (says_in, says_out) {
        (false, false) => return Ok(()),
        (false, true) => out,
        (true, false) => turn_at(surface, &at, &into, PI),
        (true, true) => {
            let back = turn_at(surface, &at, &into, PI);
            let missing = angle_at(surface, &at, &out, &back).rem_euclid(TAU);
            let missing = if missing > PI { missing - TAU } else { missing };
            turn_at(surface, &at, &out, 0.5 * missing)
        }
    };
    anchor.outgoing = ahead(surface, &anchor.point, &forward, length_out)?;
    anchor.incoming = ahead(surface, &anchor.point, &turn_at(surface, &at, &forward, PI), length_in)?;
    Ok(())
}
