//! Surfaces as components: the request, the built surface, its state, and the building in the background.

use std::sync::Arc;

use bevy::asset::AssetEventSystems;
use bevy::log::warn;
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::build::{BuildStatus, Builds};
use crate::surface::{Surface, SurfaceOptions};

/// Asks for the entity's `Mesh3d` to be built as a surface; the result is a [`BuiltSurface`] on the same entity.
///
/// Building runs in the background; [`SurfaceState`] tells how far it is, [`SurfaceReady`] and [`SurfaceFailed`] how it ended.
/// Entities with one mesh asset and the same options share one surface.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[require(SurfaceState, Transform)]
pub struct SplineSurface {
    /// What to do about defects of the mesh.
    pub options: SurfaceOptions,
}

/// How far the surface of an entity is.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub enum SurfaceState {
    /// The mesh is not loaded yet, or the surface is being built.
    Pending {
        /// How far building is, from 0 to 1.
        progress: f32,
    },
    /// [`BuiltSurface`] can be used.
    Ready,
    /// There is no surface.
    Failed {
        /// Why, and what to do about it.
        reason: String,
    },
}

impl Default for SurfaceState {
    fn default() -> Self {
        Self::Pending { progress: 0.0 }
    }
}

/// The surface of an entity, shared with everything that lies on it.
///
/// Written by the system of [`SurfacePlugin`]; an entity without [`SplineSurface`] may be given one by hand (read from a
/// file, say), and behaves the same. Derived: it is never saved.
#[derive(Component, Clone, Debug, Deref)]
#[component(immutable)]
#[require(Transform)]
pub struct BuiltSurface(pub Arc<Surface>);

/// Puts an entity (a spline, a drawing) on a surface; despawned with it.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, FromWorld, Clone, Debug, PartialEq)]
#[relationship(relationship_target = SurfaceItems)]
pub struct OnSurface(#[entities] pub Entity);

impl FromWorld for OnSurface {
    fn from_world(_: &mut World) -> Self {
        Self(Entity::PLACEHOLDER)
    }
}

/// What lies on a surface, in the order in which it came; kept by [`OnSurface`].
#[derive(Component, Reflect, Debug, Default, PartialEq, Eq)]
#[reflect(Component, FromWorld, Default)]
#[relationship_target(relationship = OnSurface, linked_spawn)]
pub struct SurfaceItems(Vec<Entity>);

/// Happens once when the surface of an entity can be used for the first time.
#[derive(EntityEvent, Clone, Debug)]
pub struct SurfaceReady {
    /// The entity with the surface.
    pub entity: Entity,
}

/// Happens when the mesh of an entity cannot be made a surface.
#[derive(EntityEvent, Clone, Debug)]
pub struct SurfaceFailed {
    /// The entity with the mesh.
    pub entity: Entity,
    /// Why, and what to do about it.
    pub reason: String,
}

/// Happens when a usable surface was replaced by another, because its mesh or its options changed; the splines on it are
/// mapped by closest points.
#[derive(EntityEvent, Clone, Debug)]
pub struct SurfaceChanged {
    /// The entity with the surface.
    pub entity: Entity,
    /// The surface before.
    pub previous: Arc<Surface>,
}

/// The mesh and options that were last asked for; marks entities whose request is known.
#[derive(Component, Clone, Debug, PartialEq)]
#[component(clone_behavior = Ignore)]
struct Requested {
    mesh: AssetId<Mesh>,
    options: SurfaceOptions,
    waiting: bool,
}

/// The surface that was last announced, to tell a first one from a change.
#[derive(Component, Clone, Debug)]
#[component(clone_behavior = Ignore)]
struct Announced(Arc<Surface>);

/// The systems by which surfaces come, before those that say more of them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SurfaceBuildSystems;

/// Builds surfaces from meshes, off the main thread.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Build`], after `AssetEventSystems`. Needs Bevy's `AssetPlugin` and `Mesh` assets.
#[derive(Debug, Default)]
pub struct SurfacePlugin;

impl Plugin for SurfacePlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_type::<SplineSurface>()
            .register_type::<SurfaceState>()
            .register_type::<OnSurface>()
            .register_type::<SurfaceItems>()
            .init_resource::<Builds>()
            .add_observer(forget_removed)
            .add_systems(
                PostUpdate,
                (request_surfaces, build_surfaces, announce_surfaces)
                    .chain()
                    .in_set(SurfaceBuildSystems)
                    .in_set(SurfaceSplineSystems::Build)
                    .after(AssetEventSystems)
                    .run_if(resource_exists::<Assets<Mesh>>),
            );
    }
}

/// Notes new and changed requests, and meshes that were modified.
fn request_surfaces(
    mut commands: Commands,
    mut builds: ResMut<Builds>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    mut surfaces: Query<(Entity, Ref<SplineSurface>, Ref<Mesh3d>, Option<&mut Requested>)>,
) {
    let mut modified = Vec::new();
    for event in events.read() {
        match event {
            AssetEvent::Modified { id } => {
                builds.modified(*id);
                modified.push(*id);
            }
            AssetEvent::Removed { id } => builds.forget(*id),
            _ => {}
        }
    }
    for (entity, surface, mesh, requested) in &mut surfaces {
        let wanted = Requested { mesh: mesh.id(), options: surface.options, waiting: true };
        match requested {
            None => drop(commands.entity(entity).try_insert(wanted)),
            Some(mut known) => {
                let other = known.mesh != wanted.mesh || known.options != wanted.options;
                if other || modified.contains(&wanted.mesh) {
                    *known = wanted;
                }
            }
        }
    }
}

/// Starts and polls builds, and hands results to the entities that wait for them.
fn build_surfaces(
    mut commands: Commands,
    mut builds: ResMut<Builds>,
    meshes: Res<Assets<Mesh>>,
    mut surfaces: Query<(Entity, &mut Requested, &mut SurfaceState, Option<&BuiltSurface>), With<SplineSurface>>,
) {
    for (entity, mut requested, mut state, built) in &mut surfaces {
        if !requested.waiting {
            continue;
        }
        let status = builds.request(requested.mesh, &requested.options, &meshes);
        let next = match status {
            BuildStatus::Pending(progress) => SurfaceState::Pending { progress },
            BuildStatus::Ready(surface) => {
                requested.waiting = false;
                if built.is_none_or(|b| !Arc::ptr_eq(&b.0, &surface)) {
                    commands.entity(entity).try_insert(BuiltSurface(surface));
                }
                SurfaceState::Ready
            }
            BuildStatus::Failed { reason, first } => {
                requested.waiting = false;
                if first {
                    warn!("the mesh of {entity} cannot be used as a surface: {reason}");
                }
                commands.entity(entity).try_remove::<BuiltSurface>();
                commands.trigger(SurfaceFailed { entity, reason: reason.clone() });
                SurfaceState::Failed { reason }
            }
        };
        state.set_if_neq(next);
    }
    builds.drop_unwanted();
}

/// Fires [`SurfaceReady`] for first surfaces and [`SurfaceChanged`] for later ones.
fn announce_surfaces(
    mut commands: Commands,
    surfaces: Query<(Entity, &BuiltSurface, Option<&Announced>), Or<(Changed<BuiltSurface>, Without<Announced>)>>,
) {
    for (entity, built, announced) in &surfaces {
        match announced {
            None => commands.trigger(SurfaceReady { entity }),
            Some(before) if Arc::ptr_eq(&before.0, &built.0) => continue,
            Some(before) => commands.trigger(SurfaceChanged { entity, previous: before.0.clone() }),
        }
        commands.entity(entity).try_insert(Announced(built.0.clone()));
    }
}

/// Lets go of the surface when its component goes.
fn forget_removed(removed: On<Remove, BuiltSurface>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<Announced>();
    }
}
