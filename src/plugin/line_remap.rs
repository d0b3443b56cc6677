//! Lines follow when their surface is replaced: ends and crossings go to the closest points, joined by shortest paths.

use bevy::log::warn;
use bevy::prelude::*;

use super::line::SurfaceLine;
use super::surface::{BuiltSurface, OnSurface, SurfaceChanged};
use crate::geodesic::PathFinder;
use crate::smooth::SurfacePolyline;
use crate::surface::{Surface, SurfacePoint};

/// Maps the lines of a changed surface. One that cannot be mapped stays as it is, and its state says what is wrong.
pub(crate) fn remap_lines(
    changed: On<SurfaceChanged>,
    mut commands: Commands,
    surfaces: Query<&BuiltSurface>,
    lines: Query<(Entity, &SurfaceLine, &OnSurface)>,
) {
    let Ok(built) = surfaces.get(changed.entity) else { return };
    let mut finder = PathFinder::new();
    for (entity, line, _) in lines.iter().filter(|(_, _, on)| on.0 == changed.entity) {
        match remap(line, &changed.previous, built, &mut finder) {
            Ok(mapped) => drop(commands.entity(entity).try_insert(SurfaceLine::new(mapped))),
            Err(reason) => warn!("the line {entity} could not follow its changed surface: {reason}"),
        }
    }
}

/// The same line on another surface. Of crossings that were fixed, the nearest is fixed there.
fn remap(
    line: &SurfacePolyline,
    from: &Surface,
    to: &Surface,
    finder: &mut PathFinder,
) -> Result<SurfacePolyline, String> {
    let map = |point: &SurfacePoint| -> Result<SurfacePoint, String> {
        let found = to.closest_point(from.position(point)).ok_or("a point of it lost its place; draw it anew")?;
        Ok(found.point)
    };
    let points = line.points().iter().map(map).collect::<Result<Vec<_>, _>>()?;
    let mut mapped =
        SurfacePolyline::through(to, finder, &points, line.is_closed()).map_err(|error| error.to_string())?;
    let offset = usize::from(!line.is_closed());
    let fixed = (0..line.crossings().len()).filter(|i| line.is_fixed(*i)).filter_map(|i| points.get(i + offset));
    let places: Vec<_> = mapped.points().iter().map(|point| to.position(point)).collect();
    for point in fixed {
        let at = to.position(point);
        let inside = places.iter().enumerate().skip(offset).take(mapped.crossings().len());
        let nearest = inside.min_by(|a, b| a.1.distance(at).total_cmp(&b.1.distance(at)));
        if let Some((i, _)) = nearest {
            mapped.set_fixed(i - offset, true).map_err(|error| error.to_string())?;
        }
    }
    Ok(mapped)
}
