//! Painted paths that follow joints, and stay splines.

use bevy::log::warn;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;
use glam::{DAffine3, DVec3};

use super::CharacterSystems;
use super::paths::BezierPaths;
use super::skin_binding::{self, JointWeights, SkinBinding, SkinState};
use crate::skin::{FlexibleOptions, Posed};

/// When the ratios of handle lengths are free: poses are then nearer to what the joints ask for, and take longer.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum FlexibleSolve {
    /// Never.
    #[default]
    Never,
    /// In the first frame in which no joint moves any more, as when somebody lets go of one.
    OnRelease,
    /// In every frame in which a joint moves. Takes memory each time.
    Always,
}

/// Lets the [`BezierPaths`] beside it follow joints, as the engine's `SkinnedMesh` lets a mesh: control points become those of the curves that are
/// nearest to the skinned ones and keep their joins.
///
/// Joints are entities with a `Transform`, posed by hand, by code or by an `AnimationPlayer`. The place of a joint is taken relative to the skin's own
/// entity, along parents up to it, or up to a common root: moving an entity with all its joints changes nothing. Paths are
/// bound to the joints in the background ([`SkinState`]), or were bound before ([`SkinBinding`]). Only paths that a moved joint has an influence
/// on are touched. A joint that is gone leaves what it moved where it was.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[require(SkinState, SkinPose)]
pub struct SplineSkin {
    /// The joints.
    #[entities]
    pub joints: Vec<Entity>,
    /// For each joint, what brings the paths as they were drawn into its space: the inverse of where it is at rest, as seen from this entity.
    pub inverse_bind_poses: Vec<Mat4>,
    /// How much each joint moves each place, if paths are not bound yet.
    pub weights: JointWeights,
    /// When ratios of handle lengths are free.
    pub flexible: FlexibleSolve,
}

impl SplineSkin {
    /// A skin of joints with the inverses of where they are at rest.
    pub fn new(joints: impl Into<Vec<Entity>>, inverse_bind_poses: impl Into<Vec<Mat4>>) -> Self {
        Self { joints: joints.into(), inverse_bind_poses: inverse_bind_poses.into(), ..Self::default() }
    }

    /// The joints of a skinned mesh, as a glTF scene has them: paths lie where the mesh does in its bind pose.
    pub fn of_mesh(mesh: &SkinnedMesh, inverse_bind_poses: &SkinnedMeshInverseBindposes) -> Self {
        Self::new(mesh.joints.clone(), inverse_bind_poses.to_vec())
    }
}

/// The pose of a [`SplineSkin`], written by a system.
#[derive(Component, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct SkinPose {
    posed: Posed,
    /// What joints do to the drawing, now and when it was last posed.
    now: Vec<DAffine3>,
    transforms: Vec<DAffine3>,
    moved: Vec<bool>,
    /// Places of joints in the skin's space.
    places: Vec<Option<DAffine3>>,
    /// Where the parent of each joint was last found among the joints.
    parents: Vec<u32>,
    /// Whether joints moved since the last flexible pose.
    is_loose: bool,
    /// What it was posed with.
    binding: Option<SkinBinding>,
    has_failed: bool,
}

impl SkinPose {
    /// What each joint does to the drawing in this pose: what [`NaiveWay`](crate::skin::NaiveWay)s and other solves want.
    pub fn transforms(&self) -> &[DAffine3] {
        &self.transforms
    }
}

/// Moves the control points of skins.
///
/// Schedule: `PostUpdate`, sets [`CharacterSystems::Spawn`] (binding) and [`CharacterSystems::Pose`].
#[derive(Debug, Default)]
pub struct SkinPlugin;

impl Plugin for SkinPlugin {
    fn build(&self, app: &mut App) {
        super::character_systems::configure(app);
        app.register_type::<SplineSkin>()
            .register_type::<SkinState>()
            .add_observer(drop_skin)
            .add_systems(PostUpdate, skin_binding::bind_skins.in_set(CharacterSystems::Spawn))
            .add_systems(PostUpdate, pose_skins.in_set(CharacterSystems::Pose));
    }
}

/// Takes what was known of a skin from an entity that has none any more.
fn drop_skin(removed: On<Remove, SplineSkin>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<(SkinPose, SkinState, skin_binding::BindTask)>();
    }
}

type Joints<'w, 's> = Query<'w, 's, (&'static Transform, Option<&'static ChildOf>)>;

fn pose_skins(mut skins: Query<(Entity, &SplineSkin, &SkinBinding, &mut SkinPose, &mut BezierPaths)>, joints: Joints) {
    for (entity, skin, binding, mut pose, mut paths) in &mut skins {
        if !binding.is_of(&paths) || binding.skin().handle_count() != skin.joints.len() {
            continue;
        }
        let pose = &mut *pose;
        if paths.is_added() || pose.binding.as_ref().is_none_or(|known| !known.is_same(binding)) {
            pose.binding = Some(binding.clone());
            pose.transforms.clear();
        }
        pose.find(entity, skin, &joints);
        let is_first = pose.transforms.len() != pose.now.len();
        pose.moved.clear();
        pose.moved.extend(pose.now.iter().enumerate().map(|(i, now)| pose.transforms.get(i) != Some(now)));
        let has_moved = is_first || pose.moved.contains(&true);
        let flexible = match skin.flexible {
            FlexibleSolve::Never => false,
            FlexibleSolve::OnRelease => !has_moved && pose.is_loose,
            FlexibleSolve::Always => has_moved,
        };
        if !has_moved && !flexible {
            continue;
        }
        pose.is_loose = has_moved && !flexible;
        let done = if flexible {
            let options = FlexibleOptions::default();
            binding.skin().pose_flexible(&pose.now, &options, &mut pose.posed).map(drop)
        } else {
            binding.skin().pose(&pose.now, &mut pose.posed)
        };
        if let Err(error) = &done
            && !pose.has_failed
        {
            warn!("the skin {entity} keeps the pose that it has: {error}");
        }
        pose.has_failed = done.is_err();
        pose.transforms.clone_from(&pose.now);
        if done.is_err() {
            continue;
        }
        // Nobody is told of a change where nothing moves.
        let changed = paths.bypass_change_detection();
        let mut any = false;
        for (chain, path) in binding.paths().iter().enumerate() {
            let is_influenced = flexible || is_first || binding.is_moved(chain, &pose.moved);
            if is_influenced {
                any |= binding.write(chain, *path as usize, &pose.posed, changed);
            }
        }
        if any {
            paths.set_changed();
        }
    }
}

/// Parents that are looked up before giving up: more than that is no hierarchy.
const MOST_PARENTS: usize = 4096;

impl SkinPose {
    /// Finds what joints do to the drawing.
    fn find(&mut self, skin: Entity, wanted: &SplineSkin, joints: &Joints) {
        let Self { now, places, parents, transforms, .. } = self;
        places.clear();
        parents.resize(wanted.joints.len(), u32::MAX);
        let mut own_place = None;
        for (number, joint) in wanted.joints.iter().enumerate() {
            let place = match joints.get(*joint) {
                Ok((local, child_of)) => {
                    let local = affine(local);
                    let parent = child_of.map(ChildOf::parent);
                    match parent {
                        Some(parent) if parent == skin => Some(local),
                        Some(parent) => {
                            let hint = parents[number] as usize;
                            let known = |i: usize| i < number && wanted.joints.get(i) == Some(&parent);
                            let found = Some(hint).filter(|i| known(*i));
                            let found = found.or_else(|| (0..number).rev().find(|i| known(*i)));
                            parents[number] = found.map_or(u32::MAX, |i| i as u32);
                            match found {
                                Some(carrier) => places[carrier].map(|carrier| carrier * local),
                                None => Some(elsewhere(skin, parent, joints, &mut own_place) * local),
                            }
                        }
                        None => Some(own_inverse(skin, joints, &mut own_place) * local),
                    }
                }
                Err(_) => None,
            };
            places.push(place);
        }
        now.clear();
        let inverses = wanted.inverse_bind_poses.iter().map(bind_affine).chain(std::iter::repeat(DAffine3::IDENTITY));
        for ((number, place), inverse) in places.iter().enumerate().zip(inverses) {
            let stays = || transforms.get(number).copied().unwrap_or(DAffine3::IDENTITY);
            now.push(place.map_or_else(stays, |place| place * inverse));
        }
    }
}

/// Where an entity that is no joint is in the space of the skin.
fn elsewhere(skin: Entity, from: Entity, joints: &Joints, own: &mut Option<DAffine3>) -> DAffine3 {
    let mut place = DAffine3::IDENTITY;
    let mut next = Some(from);
    for _ in 0..MOST_PARENTS {
        match next {
            Some(entity) if entity == skin => return place,
            Some(entity) => {
                let Ok((local, child_of)) = joints.get(entity) else { break };
                place = affine(local) * place;
                next = child_of.map(ChildOf::parent);
            }
            None => break,
        }
    }
    own_inverse(skin, joints, own) * place
}

/// From the world into the space of the skin.
fn own_inverse(skin: Entity, joints: &Joints, own: &mut Option<DAffine3>) -> DAffine3 {
    *own.get_or_insert_with(|| {
        let mut place = DAffine3::IDENTITY;
        let mut next = Some(skin);
        for _ in 0..MOST_PARENTS {
            let Some((local, child_of)) = next.and_then(|entity| joints.get(entity).ok()) else { break };
            place = affine(local) * place;
            next = child_of.map(ChildOf::parent);
        }
        place.inverse()
    })
}

fn affine(transform: &Transform) -> DAffine3 {
    let Transform { translation, rotation, scale } = transform;
    DAffine3::from_scale_rotation_translation(scale.as_dvec3(), rotation.as_dquat().normalize(), translation.as_dvec3())
}

fn bind_affine(matrix: &Mat4) -> DAffine3 {
    let column = |i: usize| -> DVec3 { matrix.col(i).truncate().as_dvec3() };
    DAffine3::from_cols(column(0), column(1), column(2), column(3))
}
