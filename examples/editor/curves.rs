//! Splines as the editor knows them: with a name and a colour of their own.

use bevy::prelude::*;
use bevy_surface_splines::curve::{EditError, Spline, SplineError};
use bevy_surface_splines::geodesic::PathFinder;
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::Surface;

use crate::theme;

/// A spline in the list of the panel.
#[derive(Component, Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    /// Counts up; the list is in this order.
    pub(crate) number: u32,
    pub(crate) name: String,
    pub(crate) color: Color,
}

/// A spline that was removed and may be brought back by undo: it keeps its entity, so that the history stays true.
#[derive(Component, Clone, Debug)]
pub(crate) struct Shelved {
    spline: Spline,
    on: Entity,
}

/// The number of the next curve.
#[derive(Resource, Debug, Default)]
pub(crate) struct NextNumber(u32);

/// Why a chain of corners cannot be made.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CornersError {
    #[error(transparent)]
    Spline(#[from] SplineError),
    #[error(transparent)]
    Edit(#[from] EditError),
}

/// Spawns a spline on a model.
pub(crate) fn spawn(
    commands: &mut Commands,
    next: &mut NextNumber,
    on: Entity,
    name: Option<&str>,
    spline: Spline,
) -> Entity {
    let number = next.0;
    next.0 += 1;
    let name = name.map_or_else(|| format!("Curve {}", number + 1), str::to_string);
    let color = theme::CURVES[number as usize % theme::CURVES.len()];
    commands.spawn((OnSurface(on), SurfaceSpline::new(spline), Curve { number, name, color }, Pickable::default())).id()
}

/// A spline whose segments are geodesics between consecutive points.
pub(crate) fn corners(
    surface: &Surface,
    finder: &mut PathFinder,
    points: &[SurfacePoint],
) -> Result<Spline, CornersError> {
    let [first, second, rest @ ..] = points else {
        return Err(SplineError::TooFewPoints { distinct: points.len() }.into());
    };
    let mut spline = Spline::bezier(surface, finder, [*first, *first, *second, *second])?;
    for at in rest {
        spline.apply(surface, finder, &SplineEdit::Append { end: SplineEnd::End, at: *at })?;
    }
    Ok(spline)
}

/// Takes a spline off its surface.
pub(crate) fn shelve(commands: &mut Commands, entity: Entity, spline: &Spline, on: Entity) {
    commands
        .entity(entity)
        .try_remove::<(SurfaceSpline, SplineTrace, OnSurface, Editable)>()
        .try_insert(Shelved { spline: spline.clone(), on });
}

/// Puts it back.
pub(crate) fn unshelve(commands: &mut Commands, entity: Entity, shelved: &Shelved) {
    commands
        .entity(entity)
        .try_remove::<Shelved>()
        .try_insert((SurfaceSpline::new(shelved.spline.clone()), OnSurface(shelved.on)));
}
