//! Paths bound to joints, in the background.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use bevy::log::warn;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on, futures_lite::future};
use glam::{DMat4, DVec3};

use super::paths::BezierPaths;
use super::spline_skin::SplineSkin;
use crate::skin::{BindOptions, BoundChain, BoundSkin, Chain, HandleShape, JoinRules, Posed, Shepard, SkinError};
use crate::vector::{Picture, SpatialPath, VectorPath};

/// How much joints move places.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub enum JointWeights {
    /// By a power of the distance to each joint, from 1 to 8.
    Joints(f64),
    /// By a power of the distance to the bone from each joint to the first joint in the list that it carries, or to the joint if it carries none.
    Bones(f64),
}

impl Default for JointWeights {
    fn default() -> Self {
        Self::Bones(4.0)
    }
}

/// How far a [`SplineSkin`] is.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub enum SkinState {
    /// It has no paths, or no joints.
    #[default]
    Pending,
    /// Its paths are being bound in the background.
    Binding {
        /// How far that is, from 0 to 1.
        progress: f32,
    },
    /// Its paths follow its joints.
    Ready,
    /// Its paths cannot be bound.
    Failed {
        /// Why, and what to do about it.
        reason: String,
    },
}

/// Paths of a picture bound to joints. Written by a system for each [`SplineSkin`] that has none of its own; cheap to clone, and shared by all that
/// show the picture.
#[derive(Component, Clone, Debug)]
pub struct SkinBinding {
    skin: Arc<BoundSkin>,
    picture: Arc<Picture>,
    /// Of each chain, its path.
    paths: Arc<[u32]>,
    /// What it was made by, if a system made it: where joints are at rest, and weights.
    made_by: Option<Arc<(Vec<Mat4>, JointWeights)>>,
}

impl SkinBinding {
    /// Chains that were bound already, of which each is a path of a picture; none if there are not as many paths as chains, or
    /// a path has other control points than its chain.
    pub fn new(skin: impl Into<Arc<BoundSkin>>, picture: impl Into<Arc<Picture>>, paths: &[usize]) -> Option<Self> {
        let (skin, picture) = (skin.into(), picture.into());
        let fits = |(chain, path): (&BoundChain, &usize)| {
            (0..=3).contains(&picture.rest_of(*path).len().wrapping_sub(chain.chain().points().len()))
        };
        let all = skin.chains().len() == paths.len() && skin.chains().iter().zip(paths).all(fits);
        let paths = paths.iter().map(|path| *path as u32).collect();
        all.then_some(Self { skin, picture, paths, made_by: None })
    }

    /// The chains.
    pub fn skin(&self) -> &Arc<BoundSkin> {
        &self.skin
    }

    /// The picture whose paths are bound.
    pub fn picture(&self) -> &Arc<Picture> {
        &self.picture
    }

    /// Of each chain, its path.
    pub fn paths(&self) -> &[u32] {
        &self.paths
    }

    /// Whether a joint has an influence on a path.
    pub fn is_influenced(&self, path: usize, joint: usize) -> bool {
        let of = |(chain, own): (&BoundChain, &u32)| *own as usize == path && chain.handles.contains(&(joint as u32));
        self.skin.chains().iter().zip(&*self.paths).any(of)
    }

    pub(super) fn is_of(&self, paths: &BezierPaths) -> bool {
        Arc::ptr_eq(&self.picture, paths.picture())
    }

    pub(super) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.skin, &other.skin) && Arc::ptr_eq(&self.picture, &other.picture)
    }

    /// Whether one of the joints that move a chain has moved.
    pub(super) fn is_moved(&self, chain: usize, moved: &[bool]) -> bool {
        let handles = self.skin.chains().get(chain).map_or(&[][..], |chain| &chain.handles);
        handles.iter().any(|handle| moved.get(*handle as usize).copied().unwrap_or(false))
    }

    /// Writes the control points of a chain into its path; whether one moved.
    pub(super) fn write(&self, chain: usize, path: usize, posed: &Posed, paths: &mut BezierPaths) -> bool {
        // A path that ends where it begins has its first point once more, or a segment without length.
        let first = self.skin.points(posed, chain).next();
        paths.set_points(path, self.skin.points(posed, chain).chain(std::iter::repeat_n(first, 3).flatten()))
    }
}

/// A binding that is under way.
#[derive(Component)]
#[component(clone_behavior = Ignore)]
pub(super) struct BindTask {
    task: Task<Result<BoundSkin, SkinError>>,
    done: Arc<AtomicUsize>,
    picture: Arc<Picture>,
    wanted: SplineSkin,
}

type Skins<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        Ref<'static, SplineSkin>,
        Ref<'static, BezierPaths>,
        Option<&'static SkinBinding>,
        Option<&'static mut BindTask>,
        &'static mut SkinState,
    ),
>;

/// Binds the paths of skins that are not bound.
pub(super) fn bind_skins(mut commands: Commands, mut skins: Skins, joints: Query<&ChildOf>) {
    for (entity, skin, paths, binding, task, mut state) in &mut skins {
        let is_bound = |binding: &SkinBinding| {
            let same = |made_by: &Arc<(Vec<Mat4>, JointWeights)>| {
                made_by.0 == skin.inverse_bind_poses && made_by.1 == skin.weights
            };
            binding.is_of(&paths)
                && binding.skin.handle_count() == skin.joints.len()
                && binding.made_by.as_ref().is_none_or(same)
        };
        if binding.is_some_and(is_bound) {
            state.set_if_neq(SkinState::Ready);
            continue;
        }
        if let Some(mut running) = task {
            let is_wanted = Arc::ptr_eq(&running.picture, paths.picture()) && running.wanted == *skin;
            if is_wanted {
                match block_on(future::poll_once(&mut running.task)) {
                    None => {
                        let all = running.picture.path_count().max(1) as f32;
                        let progress = running.done.load(Ordering::Relaxed) as f32 / all;
                        state.set_if_neq(SkinState::Binding { progress });
                        continue;
                    }
                    Some(result) => {
                        commands.entity(entity).try_remove::<BindTask>();
                        let every: Vec<usize> = (0..running.picture.path_count()).collect();
                        let made_by = Some(Arc::new((skin.inverse_bind_poses.clone(), skin.weights)));
                        let binding = result.map(|bound| SkinBinding::new(bound, running.picture.clone(), &every));
                        match binding {
                            Ok(Some(binding)) => {
                                commands.entity(entity).try_insert(SkinBinding { made_by, ..binding });
                                state.set_if_neq(SkinState::Ready);
                            }
                            other => {
                                let reason =
                                    other.err().map_or("it has paths without segments".into(), |e| e.to_string());
                                warn!("the paths of {entity} cannot be bound to joints: {reason}");
                                state.set_if_neq(SkinState::Failed { reason });
                            }
                        }
                        continue;
                    }
                }
            }
        }
        let is_new = skin.is_changed() || paths.is_added();
        let has_failed = matches!(*state, SkinState::Failed { .. });
        if skin.joints.is_empty() || has_failed && !is_new {
            continue;
        }
        let done = Arc::new(AtomicUsize::new(0));
        let picture = paths.picture().clone();
        let (count, shown) = (done.clone(), picture.clone());
        let (shapes, power) = handles(&skin, &joints);
        let work = async move { bind(&shown, &shapes, power, &count) };
        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(work);
        commands.entity(entity).try_insert(BindTask { task, done, picture, wanted: (*skin).clone() });
        state.set_if_neq(SkinState::Binding { progress: 0.0 });
    }
}

/// What joints are held by, and the power of the distance.
fn handles(skin: &SplineSkin, parents: &Query<&ChildOf>) -> (Vec<HandleShape>, f64) {
    let place = |number: usize| -> DVec3 {
        let inverse = skin.inverse_bind_poses.get(number).copied().unwrap_or(Mat4::IDENTITY);
        let matrix: DMat4 = inverse.as_dmat4();
        matrix.inverse().w_axis.truncate()
    };
    let first_child =
        |joint: &Entity| skin.joints.iter().position(|other| parents.get(*other).is_ok_and(|of| of.parent() == *joint));
    let shape = |(number, joint): (usize, &Entity)| match (skin.weights, first_child(joint)) {
        (JointWeights::Bones(_), Some(child)) => HandleShape::Bone(place(number), place(child)),
        _ => HandleShape::Point(place(number)),
    };
    let (JointWeights::Joints(power) | JointWeights::Bones(power)) = skin.weights;
    (skin.joints.iter().enumerate().map(shape).collect(), power)
}

/// Binds all paths of a picture.
fn bind(picture: &Picture, handles: &[HandleShape], power: f64, done: &AtomicUsize) -> Result<BoundSkin, SkinError> {
    let weights = Shepard::with_power(handles, power)?;
    let mut chains = Vec::with_capacity(picture.path_count());
    for path in 0..picture.path_count() {
        let chain = chain_of(picture, path);
        chains.push(BoundChain::new(&chain, path, &weights, &BindOptions::default())?);
        done.fetch_add(1, Ordering::Relaxed);
    }
    BoundSkin::of_bound(chains, handles.len())
}

/// A path of a picture as a chain: of the plane if it lies in z = 0.
fn chain_of(picture: &Picture, path: usize) -> Chain {
    let (points, closed) = (picture.rest_of(path), picture.is_closed(path));
    let rules = JoinRules::default();
    if points.iter().all(|p| p.z == 0.0) {
        let flat = points.iter().map(|p| p.truncate().as_dvec2()).collect();
        let path = VectorPath::from_points(flat, closed).unwrap_or_default();
        return Chain::planar(&path, &rules);
    }
    let path = SpatialPath::from_points(points.iter().map(|p| p.as_dvec3()).collect(), closed).unwrap_or_default();
    Chain::spatial(&path, &rules)
}
