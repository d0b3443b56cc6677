//! Copying splines and pasting them at the pointer, on the same surface or another.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::curves::{self, Curve, NextNumber};
use super::history::History;
use super::notices::Notices;
use super::selection::Selection;
use super::tools::ToolPointer;
use crate::curve::{Coordinates, Paste, Spline, SplineClip};
use crate::geodesic::{PathFinder, Tangent};
use crate::plugin::{BuiltSurface, OnSurface, SurfaceSpline};
use crate::surface::{Surface, SurfacePoint};

/// What was copied: splines as seen from a point, and how they look.
#[derive(Resource, Clone, Debug, Default)]
pub struct Clipboard {
    clip: SplineClip,
    looks: Vec<Curve>,
}

impl Clipboard {
    /// How many splines it holds.
    pub fn len(&self) -> usize {
        self.clip.len()
    }

    /// Whether nothing was copied.
    pub fn is_empty(&self) -> bool {
        self.clip.is_empty()
    }
}

/// What copying and pasting work with.
#[derive(SystemParam)]
pub(crate) struct CopyDesk<'w, 's> {
    clipboard: ResMut<'w, Clipboard>,
    finder: Local<'s, PathFinder>,
    pointer: Res<'w, ToolPointer>,
    cameras: Query<'w, 's, &'static GlobalTransform, With<Camera>>,
    places: Query<'w, 's, &'static GlobalTransform, With<BuiltSurface>>,
}

/// What of the editor they change.
pub(crate) struct Changes<'a, 'w, 's> {
    pub(crate) commands: &'a mut Commands<'w, 's>,
    pub(crate) history: &'a mut History,
    pub(crate) notices: &'a mut Notices,
    pub(crate) selection: &'a mut Selection,
    pub(crate) next: &'a mut NextNumber,
}

type Splines<'w, 's> = Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>;
type Surfaces<'w, 's> = Query<'w, 's, &'static BuiltSurface>;

impl CopyDesk<'_, '_> {
    /// Copies the selected splines, seen from the active anchor or the first one of all.
    pub(crate) fn copy(
        &mut self,
        splines: &Splines,
        surfaces: &Surfaces,
        curves: &Query<(Entity, &Curve)>,
        changes: &mut Changes,
    ) {
        let Some(active) = changes.selection.spline() else {
            changes.notices.info("Select the curves that are to be copied.");
            return;
        };
        let Ok((spline, on)) = splines.get(active) else { return };
        let Ok(surface) = surfaces.get(on.0) else { return };
        let index = changes.selection.anchor().unwrap_or(0);
        let Some(centre) = spline.anchors().get(index as usize).map(|anchor| anchor.point()) else { return };
        let chosen: Vec<(Entity, &Spline)> = changes
            .selection
            .splines()
            .iter()
            .filter_map(|entity| Some((*entity, splines.get(*entity).ok()?)))
            .filter(|(_, (_, other))| other.0 == on.0)
            .map(|(entity, (spline, _))| (entity, &**spline))
            .collect();
        let axis = self.upwards(on.0, surface, &centre);
        let list: Vec<&Spline> = chosen.iter().map(|(_, spline)| *spline).collect();
        let copied = SplineClip::copy(surface, &mut self.finder, &list, &centre, axis.as_ref(), Coordinates::Normal);
        match copied {
            Ok(copied) => {
                let kept = (0u32..).zip(&chosen).filter(|(i, _)| !copied.left_out.contains(i));
                let look = |entity: Entity| curves.get(entity).ok().map(|(_, curve)| curve.clone());
                self.clipboard.looks = kept.filter_map(|(_, (entity, _))| look(*entity)).collect();
                self.clipboard.clip = copied.clip;
                if !copied.left_out.is_empty() {
                    let count = copied.left_out.len();
                    changes
                        .notices
                        .warn(format!("{count} curves lie on another piece of the model and were left out."));
                }
            }
            Err(error) => changes.notices.warn(error.to_string()),
        }
    }

    /// Pastes at the pointer; scaled, if asked, by how much larger the surface is than the one that was copied from.
    pub(crate) fn paste(&mut self, surfaces: &Surfaces, scaled: bool, changes: &mut Changes) {
        if self.clipboard.is_empty() {
            changes.notices.info("Nothing was copied yet: select curves, and copy them with Ctrl+C.");
            return;
        }
        let Some((on, at)) = self.pointer.hover.and_then(|hover| hover.surface) else {
            changes.notices.info("Move the pointer to the place on the model where the copy is to lie.");
            return;
        };
        let Ok(surface) = surfaces.get(on) else { return };
        let axis = self.upwards(on, surface, &at);
        let scale = if scaled { self.clipboard.clip.ratio(surface) } else { 1.0 };
        let pasted = self.clipboard.clip.paste(surface, &mut self.finder, &Paste { axis, scale, ..Paste::at(at) });
        match pasted {
            Ok(pasted) => {
                changes.history.begin("Paste");
                changes.selection.clear();
                for (spline, look) in pasted.splines.into_iter().zip(&self.clipboard.looks) {
                    changes.add(on, spline, Some(look));
                }
                changes.history.end();
                if !pasted.clipped.is_empty() {
                    let count = pasted.clipped.len();
                    changes.notices.warn(format!("{count} anchors would lie beyond the boundary, and stay at it."));
                }
            }
            Err(error) => changes.notices.warn(error.to_string()),
        }
    }

    /// Upwards on the screen, along the surface; none where the surface faces that way.
    fn upwards(&self, on: Entity, surface: &Surface, at: &SurfacePoint) -> Option<Tangent> {
        let up = self.cameras.iter().next()?.up().as_vec3();
        let local = self.places.get(on).ok()?.affine().inverse().transform_vector3(up);
        let axis = surface.tangent(at, local.as_dvec3()).ok()?;
        (axis.length() > 1e-3).then_some(axis)
    }
}

impl Changes<'_, '_, '_> {
    /// Adds a spline that looks like another, and selects it too.
    pub(crate) fn add(&mut self, on: Entity, spline: Spline, like: Option<&Curve>) -> Entity {
        let new = self.next.curve(None);
        let curve = match like {
            Some(like) => Curve { number: new.number, name: new.name, hidden: false, locked: false, ..like.clone() },
            None => new,
        };
        let entity = curves::spawn(self.commands, on, curve, spline);
        self.history.note_added("Add spline", entity);
        self.selection.add(entity);
        entity
    }
}

/// Copies the selected splines in place, and selects the copies.
pub(crate) fn duplicate(splines: &Splines, curves: &Query<(Entity, &Curve)>, changes: &mut Changes) {
    let selected = changes.selection.splines().to_vec();
    if selected.is_empty() {
        changes.notices.info("Select the curves that are to be duplicated.");
        return;
    }
    changes.history.begin("Duplicate");
    changes.selection.clear();
    for entity in selected {
        let Ok((spline, on)) = splines.get(entity) else { continue };
        let look = curves.get(entity).ok().map(|(_, curve)| curve.clone());
        changes.add(on.0, (**spline).clone(), look.as_ref());
    }
    changes.history.end();
    changes.notices.info("The copies lie on the originals: G moves them.");
}
