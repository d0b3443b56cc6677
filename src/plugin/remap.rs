//! Splines follow when their surface is replaced: every control point goes to the closest point.

use bevy::log::warn;
use bevy::prelude::*;

use super::spline::SurfaceSpline;
use super::surface::{BuiltSurface, OnSurface, SurfaceChanged};
use crate::curve::{HandleSide, Join, Spline, SplineEdit};
use crate::geodesic::PathFinder;
use crate::surface::{Surface, SurfacePoint};

/// Maps the splines of a changed surface. One that cannot be mapped stays as it is, and its trace says what is wrong.
pub(crate) fn remap_splines(
    changed: On<SurfaceChanged>,
    mut commands: Commands,
    surfaces: Query<&BuiltSurface>,
    splines: Query<(Entity, &SurfaceSpline, &OnSurface)>,
) {
    let Ok(built) = surfaces.get(changed.entity) else { return };
    let mut finder = PathFinder::new();
    for (entity, spline, _) in splines.iter().filter(|(_, _, on)| on.0 == changed.entity) {
        match remap(spline, &changed.previous, built, &mut finder) {
            Ok(mapped) => drop(commands.entity(entity).try_insert(SurfaceSpline::new(mapped))),
            Err(reason) => warn!("the spline {entity} could not follow its changed surface: {reason}"),
        }
    }
}

/// The same spline on another surface.
fn remap(spline: &Spline, from: &Surface, to: &Surface, finder: &mut PathFinder) -> Result<Spline, String> {
    let map = |point: SurfacePoint| -> Result<SurfacePoint, String> {
        let found = to.closest_point(from.position(&point)).ok_or("a control point lost its place; place it anew")?;
        Ok(found.point)
    };
    let anchors = spline.anchors();
    let points = anchors.iter().map(|a| map(a.point())).collect::<Result<Vec<_>, _>>()?;
    let mapped = Spline::smooth_through(to, finder, &points, spline.is_closed()).map_err(|error| error.to_string())?;
    let mut mapped = mapped.with_scheme(spline.scheme());
    let mut apply = |edit: SplineEdit| mapped.apply(to, finder, &edit).map(drop).map_err(|error| error.to_string());
    for (i, anchor) in anchors.iter().enumerate().filter(|(_, a)| a.join() != Join::Automatic) {
        let i = i as u32;
        apply(SplineEdit::SetJoin { anchor: i, join: Join::Corner })?;
        for (side, handle) in [(HandleSide::Incoming, anchor.incoming()), (HandleSide::Outgoing, anchor.outgoing())] {
            apply(SplineEdit::MoveHandle { anchor: i, side, to: map(handle.point())? })?;
        }
        apply(SplineEdit::SetJoin { anchor: i, join: anchor.join() })?;
    }
    for (i, _) in anchors.iter().enumerate().filter(|(_, a)| a.join() == Join::Automatic) {
        apply(SplineEdit::SetJoin { anchor: i as u32, join: Join::Automatic })?;
    }
    Ok(mapped)
}
