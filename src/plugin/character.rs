//! Characters in a world: joints as entities, paths that follow them, clips to be played.

use std::sync::Arc;

use bevy::animation::graph::{AnimationGraphHandle, AnimationNodeIndex};
use bevy::animation::{ActiveAnimation, AnimatedBy, AnimationPlayer};
use bevy::asset::{AssetLoadError, AssetLoadFailedEvent, LoadState};
use bevy::log::warn;
use bevy::prelude::*;

use super::CharacterSystems;
use super::character_asset::{CharacterAsset, CharacterLoadError, CharacterLoader, target_of, transform_of};
use super::character_binding::{Bindings, Prepared};
use super::drawing::Placement;
use super::paths::BezierPaths;
use super::skin_binding::{self, SkinBinding};
use super::spline_skin::SplineSkin;
use crate::character::Character;

/// A character that is made of curves.
///
/// Once its file is loaded and its paths are bound, which happens in the background, its joints are spawned below it: entities with `Name` and `Transform`,
/// listed by [`CharacterJoints`]. It gets [`BezierPaths`] that follow them by a [`SplineSkin`], an `AnimationPlayer` and the graph of its clips, in
/// which [`CharacterAsset::node`] finds each by its name. [`CharacterReady`] says so. Characters of one file share all but pose and mesh.
///
/// If the file or its drawing changes, joints of the same names keep their poses, clips of the same names go on, and the rest is made anew. A file that
/// cannot be used leaves what is there, and [`CharacterFailed`] says why.
///
/// With [`OnSurface`](super::OnSurface) and a [`Placement`], it lies on a surface ([`LaidState`](super::LaidState)), and
/// [`Placement::walk`] lets it go there.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_surface_splines::plugin::{BezierCharacter, CharacterAsset, CharacterReady};
/// fn setup(mut commands: Commands, assets: Res<AssetServer>) {
///     commands.spawn(BezierCharacter(assets.load("hero.character.ron")));
/// }
///
/// // An observer.
/// fn walk(
///     ready: On<CharacterReady>,
///     mut characters: Query<(&BezierCharacter, &mut AnimationPlayer)>,
///     assets: Res<Assets<CharacterAsset>>,
/// ) -> Result {
///     let (character, mut player) = characters.get_mut(ready.entity)?;
///     if let Some(walk) = assets.get(&character.0).and_then(|asset| asset.node("walk")) {
///         player.play(walk).repeat();
///     }
///     Ok(())
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform, Visibility, CharacterState)]
pub struct BezierCharacter(pub Handle<CharacterAsset>);

/// How far a character is.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub enum CharacterState {
    /// Its file is not loaded.
    #[default]
    Pending,
    /// Its paths are being bound in the background. Where it was something else before, that stays meanwhile.
    Binding {
        /// How far that is, from 0 to 1.
        progress: f32,
    },
    /// It is there.
    Ready,
    /// It cannot be used. Where it was something else before, that stays.
    Failed {
        /// Why, and what to do about it.
        reason: String,
    },
}

/// The joints of a character, in the order of its file. They are below it, parents above children.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct CharacterJoints(#[entities] Vec<Entity>);

impl CharacterJoints {
    /// The joints.
    pub fn all(&self) -> &[Entity] {
        &self.0
    }

    /// A joint by its place in the file.
    pub fn get(&self, joint: usize) -> Option<Entity> {
        self.0.get(joint).copied()
    }
}

/// Happens when a character has got its joints and paths, and again when a changed file gave it others.
#[derive(EntityEvent, Clone, Debug)]
pub struct CharacterReady {
    /// The character.
    pub entity: Entity,
}

/// Happens when a character's file cannot be used, at first or any more.
#[derive(EntityEvent, Clone, Debug)]
pub struct CharacterFailed {
    /// The character.
    pub entity: Entity,
    /// Why, and what to do about it.
    pub reason: String,
    /// Whether it goes on as what it was before.
    pub kept: bool,
}

/// What an entity was made of.
#[derive(Component, Debug)]
#[component(clone_behavior = Ignore)]
pub(super) struct Instance {
    pub(super) prepared: Arc<Prepared>,
    /// Names of clips and their nodes in the graph, as the player knows them.
    clips: Vec<(String, AnimationNodeIndex)>,
    is_laid: bool,
}

/// Spawns characters.
///
/// Schedule: `PostUpdate`, set [`CharacterSystems::Spawn`]. Needs Bevy's `AssetPlugin` and `AnimationPlugin`, and poses by
/// [`SkinPlugin`](super::SkinPlugin) and [`PathPlugin`](super::PathPlugin).
#[derive(Debug, Default)]
pub struct CharacterPlugin;

impl Plugin for CharacterPlugin {
    fn build(&self, app: &mut App) {
        super::character_systems::configure(app);
        app.register_type::<BezierCharacter>()
            .register_type::<CharacterState>()
            .register_type::<CharacterJoints>()
            .init_resource::<Bindings>()
            .add_observer(drop_character)
            .add_systems(
                PostUpdate,
                (notice_failures, prepare_characters)
                    .chain()
                    .in_set(CharacterSystems::Spawn)
                    .before(skin_binding::bind_skins)
                    .run_if(resource_exists::<Assets<CharacterAsset>>),
            );
        if app.world().contains_resource::<AssetServer>() {
            app.init_asset::<CharacterAsset>().init_asset_loader::<CharacterLoader>();
        }
    }
}

/// Says of files that cannot be read any more whom that concerns.
fn notice_failures(
    mut commands: Commands,
    mut failures: MessageReader<AssetLoadFailedEvent<CharacterAsset>>,
    mut characters: Query<(Entity, &BezierCharacter, Option<&Instance>, &mut CharacterState)>,
) {
    for failure in failures.read() {
        for (entity, _, instance, mut state) in characters.iter_mut().filter(|(_, of, ..)| of.0.id() == failure.id) {
            fail(entity, reason_of(&failure.error), instance.is_some(), &mut state, &mut commands);
        }
    }
}

/// What is wrong with a file, without the engine's trace of how it came to see it.
fn reason_of(error: &AssetLoadError) -> String {
    match error {
        AssetLoadError::AssetLoaderError(error) => {
            let own = error.error().downcast_ref::<CharacterLoadError>();
            own.map_or_else(|| error.to_string(), |own| own.to_string())
        }
        other => other.to_string(),
    }
}

fn fail(entity: Entity, reason: String, kept: bool, state: &mut Mut<CharacterState>, commands: &mut Commands) {
    let next = CharacterState::Failed { reason: reason.clone() };
    if **state != next {
        let what = if kept { "stays what it was" } else { "cannot be shown" };
        warn!("the character {entity} {what}: {reason}");
        **state = next;
        commands.trigger(CharacterFailed { entity, reason, kept });
    }
}

type Characters<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        Ref<'static, BezierCharacter>,
        &'static mut CharacterState,
        Option<&'static mut Instance>,
        Option<&'static CharacterJoints>,
        Option<&'static mut SplineSkin>,
        Option<&'static mut AnimationPlayer>,
        Has<Placement>,
    ),
>;

type Joints<'w, 's> =
    Query<'w, 's, (&'static mut Transform, Option<&'static Name>, Option<&'static ChildOf>), Without<BezierCharacter>>;

/// Binds what is loaded and gives characters their joints and paths.
fn prepare_characters(
    mut commands: Commands,
    assets: Res<Assets<CharacterAsset>>,
    server: Option<Res<AssetServer>>,
    mut bindings: ResMut<Bindings>,
    mut characters: Characters,
    mut joints: Joints,
    (children, animated): (Query<&Children>, Query<&AnimatedBy>),
) {
    bindings.begin_frame();
    for (entity, character, mut state, mut instance, known, skin, mut player, is_laid) in &mut characters {
        let id = character.0.id();
        let Some(asset) = assets.get(id) else {
            match server.as_ref().map(|server| server.load_state(id)) {
                Some(LoadState::Failed(error)) => {
                    fail(entity, reason_of(&error), instance.is_some(), &mut state, &mut commands);
                }
                _ if instance.is_none() => drop(state.set_if_neq(CharacterState::Pending)),
                _ => {}
            }
            continue;
        };
        // The graph is that of the asset as it is now, also while what became of it is being bound, or cannot be.
        if let (Some(instance), Some(player)) = (&mut instance, &mut player) {
            let is_known = asset.clips().iter().map(|clip| (clip.name.as_str(), clip.node));
            if !is_known.eq(instance.clips.iter().map(|(name, node)| (name.as_str(), *node))) {
                let now = clips_of(asset);
                go_on(player, &instance.clips, &now);
                instance.clips = now;
            }
        }
        let instance = instance.as_deref();
        match bindings.of(id, asset, server.as_deref()) {
            Err(progress) => drop(state.set_if_neq(CharacterState::Binding { progress })),
            Ok(Err(reason)) => fail(entity, reason.to_owned(), instance.is_some(), &mut state, &mut commands),
            Ok(Ok(prepared)) => {
                let same = |known: &Instance| Arc::ptr_eq(&known.prepared, prepared) && known.is_laid == is_laid;
                if instance.is_some_and(same) {
                    // It may have been a file in between that could not be read.
                    if matches!(*state, CharacterState::Binding { .. }) {
                        *state = CharacterState::Ready;
                    }
                    continue;
                }
                let before = instance.map(|instance| &*instance.prepared);
                let mine = |joint: &Entity| animated.get(*joint).is_ok_and(|by| by.0 == entity);
                let below = children.iter_descendants(entity).filter(mine).collect();
                let of = Of { entity, prepared, before, known: known.map_or(&[], |known| &known.0), below };
                let all = of.take_joints(&mut commands, &mut joints);
                if player.is_none() {
                    commands.entity(entity).try_insert(AnimationPlayer::default());
                }
                let mut wanted = skin.map_or_else(SplineSkin::default, |skin| skin.clone());
                (wanted.joints, wanted.inverse_bind_poses) = (all.clone(), prepared.inverse_rest.clone());
                let binding = prepared.bindings[usize::from(is_laid)].clone();
                let paths = BezierPaths::new(binding.picture().clone());
                let instance = Instance { prepared: prepared.clone(), clips: clips_of(asset), is_laid };
                let made = (wanted, binding, paths, CharacterJoints(all), instance);
                commands.entity(entity).try_insert((made, AnimationGraphHandle(asset.graph().clone())));
                *state = CharacterState::Ready;
                commands.trigger(CharacterReady { entity });
            }
        }
    }
    bindings.end_frame();
}

/// A character that is to be made something else.
struct Of<'a> {
    entity: Entity,
    prepared: &'a Prepared,
    before: Option<&'a Prepared>,
    /// The joints that it had.
    known: &'a [Entity],
    /// What is animated along with it, and below it. A clone may list the joints of the other still, but those below it are its own.
    below: Vec<Entity>,
}

impl Of<'_> {
    /// Joints that are there take part in the new character by their names, others are spawned or despawned.
    fn take_joints(&self, commands: &mut Commands, joints: &mut Joints) -> Vec<Entity> {
        let character: &Character = &self.prepared.character;
        let mut spare = self.below.clone();
        let mut all: Vec<Entity> = Vec::with_capacity(character.joints.len());
        for (number, joint) in character.joints.iter().enumerate() {
            let is_it = |entity: &Entity| {
                joints.get(*entity).is_ok_and(|(_, name, _)| name.is_some_and(|name| name.as_str() == joint.name))
            };
            let rest = transform_of(&character.rest_pose(number));
            let place = spare.iter().position(is_it);
            let target = (target_of(character, number), AnimatedBy(self.entity));
            let entity = match place {
                Some(place) => {
                    let entity = spare.swap_remove(place);
                    if let Ok((mut transform, ..)) = joints.get_mut(entity) {
                        self.bring_to_rest(&joint.name, &rest, &mut transform);
                    }
                    commands.entity(entity).try_insert(target);
                    entity
                }
                None => commands.spawn((Name::new(joint.name.clone()), rest, Visibility::default(), target)).id(),
            };
            let parent = joint.parent.and_then(|parent| all.get(parent)).copied().unwrap_or(self.entity);
            if !joints.get(entity).is_ok_and(|(_, _, of)| of.is_some_and(|of| of.parent() == parent)) {
                commands.entity(entity).try_insert(ChildOf(parent));
            }
            all.push(entity);
        }
        let surplus = spare.into_iter().filter(|joint| self.known.contains(joint));
        surplus.for_each(|joint| commands.entity(joint).try_despawn());
        all
    }

    /// What of a joint is where the file had it before goes to where it has it now.
    fn bring_to_rest(&self, name: &str, rest: &Transform, transform: &mut Transform) {
        let Some(before) = self.before.map(|before| &before.character) else { return };
        let Some(old) = before.joint_named(name).map(|joint| transform_of(&before.rest_pose(joint))) else { return };
        if transform.translation == old.translation {
            transform.translation = rest.translation;
        }
        if transform.rotation == old.rotation {
            transform.rotation = rest.rotation;
        }
        if transform.scale == old.scale {
            transform.scale = rest.scale;
        }
    }
}

/// Names of clips and their nodes.
fn clips_of(asset: &CharacterAsset) -> Vec<(String, AnimationNodeIndex)> {
    asset.clips().iter().map(|clip| (clip.name.clone(), clip.node)).collect()
}

/// Clips of the same names go on where the nodes of a graph are others.
fn go_on(player: &mut AnimationPlayer, before: &[(String, AnimationNodeIndex)], now: &[(String, AnimationNodeIndex)]) {
    let name_of = |node| before.iter().find(|(_, known)| *known == node).map(|(name, _)| name);
    let playing: Vec<(Option<&String>, ActiveAnimation)> =
        player.playing_animations().map(|(node, active)| (name_of(*node), *active)).collect();
    player.stop_all();
    for (name, active) in playing {
        if let Some((_, node)) = now.iter().find(|(known, _)| Some(known) == name) {
            *player.play(*node) = active;
        }
    }
}

/// Takes joints and paths from an entity that is no character any more.
fn drop_character(
    removed: On<Remove, BezierCharacter>,
    joints: Query<&CharacterJoints>,
    animated: Query<&AnimatedBy>,
    mut commands: Commands,
) {
    if let Ok(known) = joints.get(removed.entity) {
        // A clone that has none of its own yet lists those of the other.
        let mine = known.0.iter().filter(|joint| animated.get(**joint).is_ok_and(|by| by.0 == removed.entity));
        mine.for_each(|joint| commands.entity(*joint).try_despawn());
    }
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<(Instance, CharacterJoints, SplineSkin, SkinBinding, BezierPaths, AnimationGraphHandle)>();
    }
}
