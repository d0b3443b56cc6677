//! Anchors and handles as entities, for as long as their spline is [`Editable`].

use std::collections::HashMap;

use bevy::ecs::entity::{EntityHashMap, EntityHashSet};
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::spline::SurfaceSpline;
use super::surface::{BuiltSurface, OnSurface};
use crate::curve::{HandleSide, Spline, SplineEdit};
use crate::geodesic::GeodesicPath;
use crate::surface::SurfacePoint;

/// Lets the user grab the anchors and handles of a spline: while it is there, each has an entity.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct Editable;

/// Which control point of a spline.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Clone, Debug, PartialEq, Hash)]
pub enum ControlKind {
    /// An anchor, by its number.
    Anchor(u32),
    /// A handle of an anchor.
    Handle(u32, HandleSide),
}

/// An anchor or handle of a spline, as an entity: a child of the surface, at the control point's place in local space.
///
/// Derived: spawned, moved and despawned by a system. Moving its `Transform` does nothing; send an
/// [`EditSpline`](super::EditSpline). Worlds are smaller when saved without the entities that have this component, but
/// loading them with it does no harm.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform)]
pub struct ControlPoint {
    /// The spline.
    #[entities]
    pub spline: Entity,
    /// Which of its control points.
    pub kind: ControlKind,
}

/// Names the spline that a control point belongs to; despawned with it.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, FromWorld, Clone, Debug, PartialEq)]
#[relationship(relationship_target = Controls)]
pub struct ControlOf(#[entities] pub Entity);

impl FromWorld for ControlOf {
    fn from_world(_: &mut World) -> Self {
        Self(Entity::PLACEHOLDER)
    }
}

/// The control points of an [`Editable`] spline; kept by [`ControlOf`].
#[derive(Component, Reflect, Debug, Default, PartialEq, Eq)]
#[reflect(Component, FromWorld, Default)]
#[relationship_target(relationship = ControlOf, linked_spawn)]
pub struct Controls(Vec<Entity>);

impl ControlKind {
    /// The control points that shape a spline: anchors, each followed by its handles that belong to a segment. A B-spline
    /// has anchors alone.
    pub fn all(spline: &Spline) -> Vec<Self> {
        let count = spline.anchors().len() as u32;
        if spline.scheme().method.is_b_spline() {
            return (0..count).map(Self::Anchor).collect();
        }
        let mut all = Vec::with_capacity(3 * count as usize);
        for i in 0..count {
            all.push(Self::Anchor(i));
            if i > 0 || spline.is_closed() {
                all.push(Self::Handle(i, HandleSide::Incoming));
            }
            if i + 1 < count || spline.is_closed() {
                all.push(Self::Handle(i, HandleSide::Outgoing));
            }
        }
        all
    }

    /// Where it is; none if the spline has no such anchor, or if it is a handle and the spline a B-spline, whose handles do
    /// not count.
    pub fn point(self, spline: &Spline) -> Option<SurfacePoint> {
        let (Self::Anchor(i) | Self::Handle(i, _)) = self;
        let anchor = spline.anchors().get(i as usize)?;
        match self {
            Self::Anchor(_) => Some(anchor.point()),
            Self::Handle(..) if spline.scheme().method.is_b_spline() => None,
            Self::Handle(_, HandleSide::Incoming) => Some(anchor.incoming().point()),
            Self::Handle(_, HandleSide::Outgoing) => Some(anchor.outgoing().point()),
        }
    }

    /// The edit that moves it.
    pub fn moved(self, to: SurfacePoint) -> SplineEdit {
        match self {
            Self::Anchor(anchor) => SplineEdit::MoveAnchor { anchor, to },
            Self::Handle(anchor, side) => SplineEdit::MoveHandle { anchor, side, to },
        }
    }

    /// The edit that moves it along a path.
    pub fn dragged(self, along: GeodesicPath) -> SplineEdit {
        match self {
            Self::Anchor(anchor) => SplineEdit::DragAnchor { anchor, along },
            Self::Handle(anchor, side) => SplineEdit::DragHandle { anchor, side, along },
        }
    }
}

/// Keeps an entity for each control point of editable splines.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Controls`].
#[derive(Debug, Default)]
pub struct ControlsPlugin;

impl Plugin for ControlsPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_type::<Editable>()
            .register_type::<ControlPoint>()
            .register_type::<ControlOf>()
            .register_type::<Controls>()
            .add_observer(remove_controls::<Editable>)
            .add_observer(remove_controls::<SurfaceSpline>)
            .add_systems(PostUpdate, update_controls.in_set(SurfaceSplineSystems::Controls));
    }
}

type EditableSplines<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        Ref<'static, SurfaceSpline>,
        Ref<'static, OnSurface>,
        Ref<'static, Editable>,
        Option<Ref<'static, Controls>>,
    ),
>;

fn update_controls(
    mut commands: Commands,
    splines: EditableSplines,
    surfaces: Query<Ref<BuiltSurface>>,
    mut controls: Query<(Entity, Ref<ControlPoint>, &mut Transform, Option<&ChildOf>)>,
) {
    let is_due = |entity: Entity| -> bool {
        splines.get(entity).is_ok_and(|(_, spline, on, editable, listed)| {
            let surface_changed = surfaces.get(on.0).is_ok_and(|surface| surface.is_changed());
            let listed_changed = listed.is_none_or(|listed| listed.is_changed());
            spline.is_changed() || on.is_changed() || editable.is_changed() || surface_changed || listed_changed
        })
    };
    // All control points that name the spline, listed in its `Controls` or not: loading and cloning bring some that are not.
    let mut due: EntityHashMap<Vec<(Entity, ControlKind)>> =
        splines.iter().filter(|s| is_due(s.0)).map(|s| (s.0, Vec::new())).collect();
    for (_, control, ..) in controls.iter().filter(|c| c.1.is_added() && splines.contains(c.1.spline)) {
        due.entry(control.spline).or_default();
    }
    if due.is_empty() {
        return;
    }
    for (entity, control, ..) in &controls {
        if let Some(known) = due.get_mut(&control.spline) {
            known.push((entity, control.kind));
        }
    }
    for (entity, existing) in due {
        let Ok((_, spline, on, _, listed)) = splines.get(entity) else { continue };
        let Ok(surface) = surfaces.get(on.0) else { continue };
        let listed: EntityHashSet = listed.iter().flat_map(|listed| listed.iter()).collect();
        let mut known = HashMap::new();
        for (control, kind) in existing {
            if let Some(double) = known.insert(kind, control) {
                despawn(&mut commands, double);
            }
        }
        for kind in ControlKind::all(&spline) {
            let Some(point) = kind.point(&spline) else { continue };
            let position = surface.position(&point).as_vec3();
            if !position.is_finite() {
                continue; // a spline that was made for another surface; its state says so
            }
            let place = Transform::from_translation(position);
            let Some(control) = known.remove(&kind) else {
                commands.spawn((ControlPoint { spline: entity, kind }, ControlOf(entity), ChildOf(on.0), place));
                continue;
            };
            if let Ok((_, _, mut transform, parent)) = controls.get_mut(control) {
                transform.set_if_neq(place);
                if parent.is_none_or(|p| p.parent() != on.0) {
                    commands.entity(control).try_insert(ChildOf(on.0));
                }
            }
            if !listed.contains(&control) {
                commands.entity(control).try_insert(ControlOf(entity));
            }
        }
        for (_, surplus) in known {
            despawn(&mut commands, surplus);
        }
    }
}

fn despawn(commands: &mut Commands, entity: Entity) {
    if let Ok(mut entity) = commands.get_entity(entity) {
        entity.try_despawn();
    }
}

/// Control points go when their spline is no longer edited.
fn remove_controls<C: Component>(removed: On<Remove, C>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.queue_silenced(|mut entity: EntityWorldMut| {
            entity.despawn_related::<Controls>();
        });
    }
}
