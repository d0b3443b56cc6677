//! Surfaces of meshes that joints or morph targets deform.

use std::sync::{Mutex, PoisonError};

use bevy::ecs::system::SystemParam;
use bevy::log::warn;
use bevy::math::Ray3d;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::mesh::{Mesh, VertexAttributeValues};
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::mesh::read_triangles;
use super::surface::BuiltSurface;
use crate::surface::{ClosestPoint, FaceId, PosedSurface, RayHit, SurfacePoint, TriangleMesh};

/// The surface of an entity whose mesh is skinned (`SkinnedMesh`) or morphed (`MeshMorphWeights`, with the feature `morph`), as it is posed: where its
/// points are in the world, and what a ray hits. Derived: a system writes it beside the [`BuiltSurface`], and it is never saved.
///
/// Points, paths and curves are those of the mesh as it was made: lengths do not follow the pose. As in the engine's shaders, the transform
/// of a skinned entity itself counts for nothing.
///
/// Cost: a frame in which joints moved compares their matrices. Vertices are posed, and the tree of boxes is fitted to them, when something
/// asks by a ray for the first time after that (about 40 ns a vertex and a face); curves that ride pose the vertices beside them only.
#[derive(Component, Debug)]
#[component(clone_behavior = Ignore)]
pub struct DeformedSurface {
    rig: Rig,
    pose: Pose,
    /// Counts poses that differ from the one before.
    stamp: u64,
    /// Made on demand; the stamp is that of the pose which it has.
    posed: Mutex<(u64, PosedSurface)>,
}

/// What of a mesh is deformed, as the mesh has it.
#[derive(Debug)]
struct Rig {
    mesh: AssetId<Mesh>,
    positions: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
    /// Four joints of each vertex; empty for a mesh without a skin.
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    /// Displacements of all vertices, target after target.
    targets: Vec<Vec3>,
}

/// What deforms it now.
#[derive(Clone, Debug, Default, PartialEq)]
struct Pose {
    /// What each joint does to the mesh; one for all vertices where there is no skin.
    matrices: Vec<Mat4>,
    morphs: Vec<f32>,
}

impl DeformedSurface {
    /// Counts the poses that it has had: as long as it is the same, nothing has moved.
    pub fn stamp(&self) -> u64 {
        self.stamp
    }

    /// Where a vertex of the mesh is in the world; NaN if there is no such vertex.
    pub fn vertex(&self, vertex: u32) -> Vec3 {
        self.rig.posed(&self.pose, vertex as usize).unwrap_or(Vec3::NAN)
    }

    /// The mesh's vertices at the corners of a face; none if there is no such face.
    pub fn corners(&self, face: FaceId) -> Option<[u32; 3]> {
        self.rig.faces.get(face.0 as usize).copied()
    }

    /// Where a point is in the world; NaN if it does not belong to the surface.
    pub fn position(&self, point: &SurfacePoint) -> Vec3 {
        let Some(corners) = self.corners(point.face) else { return Vec3::NAN };
        let place = |k: usize| point.weights[k] as f32 * self.vertex(corners[k]);
        place(0) + place(1) + place(2)
    }

    /// The unit normal of a point's face in the world, towards the side from which its corners run counter-clockwise as the surface has them, which turns faces over that disagree with their
    /// neighbours.
    pub fn normal(&self, point: &SurfacePoint) -> Vec3 {
        self.with_posed(|posed| posed.normal(point)).as_vec3()
    }

    /// The first place where a ray in the world meets the posed surface, from either side.
    pub fn ray(&self, ray: Ray3d) -> Option<RayHit> {
        self.with_posed(|posed| posed.ray(ray.origin.as_dvec3(), ray.direction.as_dvec3()))
    }

    /// The place of the posed surface that is nearest to a place in the world.
    pub fn closest_point(&self, position: Vec3) -> Option<ClosestPoint> {
        self.with_posed(|posed| posed.closest_point(position.as_dvec3()))
    }

    /// Shows the posed surface, made anew if something has moved since it was shown last. `show` must not ask this same component anything: what it is
    /// given answers all of that.
    pub fn with_posed<T>(&self, show: impl FnOnce(&PosedSurface) -> T) -> T {
        // A panic elsewhere leaves a pose that is fitted anew.
        let mut posed = self.posed.lock().unwrap_or_else(|poisoned| {
            let mut posed = PoisonError::into_inner(poisoned);
            posed.0 = self.stamp.wrapping_sub(1);
            posed
        });
        if posed.0 != self.stamp {
            let vertices = 0..self.rig.positions.len();
            let places = vertices.map(|v| self.rig.posed(&self.pose, v).unwrap_or(Vec3::NAN).as_dvec3());
            if posed.1.pose(places).is_ok() {
                posed.0 = self.stamp;
            }
        }
        show(&posed.1)
    }
}

impl Rig {
    fn read(id: AssetId<Mesh>, mesh: &Mesh) -> Result<Self, super::MeshReadError> {
        let TriangleMesh { positions, faces } = read_triangles(mesh)?;
        let positions: Vec<Vec3> = positions.iter().map(|p| p.as_vec3()).collect();
        let joints = match mesh.try_attribute_option(Mesh::ATTRIBUTE_JOINT_INDEX)? {
            Some(VertexAttributeValues::Uint16x4(joints)) => joints.clone(),
            _ => Vec::new(),
        };
        let weights = match mesh.try_attribute_option(Mesh::ATTRIBUTE_JOINT_WEIGHT)? {
            Some(VertexAttributeValues::Float32x4(weights)) => weights.clone(),
            _ => Vec::new(),
        };
        let targets = displacements(mesh);
        Ok(Self { mesh: id, positions, faces, joints, weights, targets })
    }

    /// A vertex under a pose: first the morph targets, then the joints, as in the engine's shaders.
    fn posed(&self, pose: &Pose, vertex: usize) -> Option<Vec3> {
        let count = self.positions.len();
        let mut place = *self.positions.get(vertex)?;
        for (target, weight) in pose.morphs.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            place += *weight * self.targets.get(target * count + vertex)?;
        }
        match (self.joints.get(vertex), self.weights.get(vertex)) {
            (Some(joints), Some(weights)) => {
                let mut blend = Mat4::ZERO;
                for (joint, weight) in joints.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
                    blend += *weight * pose.matrices.get(usize::from(*joint)).copied().unwrap_or(Mat4::IDENTITY);
                }
                Some((blend * place.extend(1.0)).truncate())
            }
            _ => Some(pose.matrices.first()?.transform_point3(place)),
        }
    }

    fn is_skinned(&self) -> bool {
        self.joints.len() == self.positions.len() && self.weights.len() == self.positions.len()
    }
}

#[cfg(feature = "morph")]
fn displacements(mesh: &Mesh) -> Vec<Vec3> {
    // Asked for positions before, it has not gone to the render world.
    mesh.get_morph_targets().unwrap_or_default().iter().map(|target| target.position).collect()
}

#[cfg(not(feature = "morph"))]
fn displacements(_: &Mesh) -> Vec<Vec3> {
    Vec::new()
}

/// Keeps the [`DeformedSurface`] of skinned and morphed entities with a [`BuiltSurface`].
///
/// Schedule: `PostUpdate`; it is made in [`SurfaceSplineSystems::Build`], and posed in [`SurfaceSplineSystems::Ride`], after transforms are propagated,
/// so that it shows the pose of the same frame.
#[derive(Debug, Default)]
pub struct DeformPlugin;

impl Plugin for DeformPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        let has_assets =
            resource_exists::<Assets<Mesh>>.and_then(resource_exists::<Assets<SkinnedMeshInverseBindposes>>);
        app.add_observer(forget_removed).add_systems(
            PostUpdate,
            (
                // Before anything is put on the surface at a place in the world.
                read_rigs.after(super::surface::SurfaceBuildSystems).in_set(SurfaceSplineSystems::Build),
                pose.in_set(SurfaceSplineSystems::Ride).before(super::riding::RideSystems),
            )
                .run_if(has_assets),
        );
    }
}

#[cfg(feature = "morph")]
type MorphsOf = bevy::mesh::morph::MeshMorphWeights;
#[cfg(not(feature = "morph"))]
type MorphsOf = NoMorphs;
/// Nothing is morphed without the feature.
#[cfg(not(feature = "morph"))]
#[derive(Component)]
struct NoMorphs;

/// What of an entity deforms its mesh.
type Deforming = Or<(With<SkinnedMesh>, With<MorphsOf>)>;
/// What tells that the rig has to be read again.
type Read<'a> = (
    (Entity, &'a Mesh3d, Ref<'a, BuiltSurface>, Option<&'a DeformedSurface>),
    (Option<&'a SkinnedMesh>, Option<&'a MorphsOf>),
);

fn read_rigs(
    mut commands: Commands,
    meshes: Res<Assets<Mesh>>,
    joints: Joints,
    surfaces: Query<Read, Deforming>,
    lost: Query<Entity, (With<DeformedSurface>, Without<SkinnedMesh>, Without<MorphsOf>)>,
    mut refused: Local<Vec<(Entity, AssetId<Mesh>)>>,
) {
    for entity in &lost {
        commands.entity(entity).try_remove::<DeformedSurface>();
    }
    for ((entity, mesh, built, deformed), (skin, morphs)) in &surfaces {
        if built.is_changed() {
            // The mesh may have come before the surface that was built of it.
            refused.retain(|(of, _)| *of != entity);
        }
        let known = deformed.is_some_and(|deformed| deformed.rig.mesh == mesh.id());
        if (known && !built.is_changed()) || refused.contains(&(entity, mesh.id())) {
            continue;
        }
        let Some(asset) = meshes.get(mesh) else { continue };
        match make(mesh.id(), asset, &built) {
            Ok(mut deformed) => {
                joints.matrices(entity, &deformed.rig, skin, &mut deformed.pose.matrices);
                joints.morphs(morphs, &mut deformed.pose.morphs);
                commands.entity(entity).try_insert(deformed);
            }
            Err(reason) => {
                warn!("curves do not ride on the mesh of {entity}: {reason}");
                commands.entity(entity).try_remove::<DeformedSurface>();
                refused.push((entity, mesh.id()));
            }
        }
    }
    refused.retain(|(entity, _)| surfaces.contains(*entity));
}

fn make(id: AssetId<Mesh>, mesh: &Mesh, built: &BuiltSurface) -> Result<DeformedSurface, String> {
    let rig = Rig::read(id, mesh).map_err(|error| error.to_string())?;
    let positions = rig.positions.iter().map(|p| p.as_dvec3()).collect();
    let at_rest = TriangleMesh { positions, faces: rig.faces.clone() };
    let posed = PosedSurface::new(built.0.clone(), &at_rest).map_err(|error| error.to_string())?;
    Ok(DeformedSurface { rig, pose: Pose::default(), stamp: 0, posed: Mutex::new((u64::MAX, posed)) })
}

/// What a pose is read from.
#[derive(SystemParam)]
struct Joints<'w, 's> {
    globals: Query<'w, 's, &'static GlobalTransform>,
    bindposes: Res<'w, Assets<SkinnedMeshInverseBindposes>>,
    #[cfg(feature = "morph")]
    weights: Query<'w, 's, &'static bevy::mesh::morph::MorphWeights>,
}

impl Joints<'_, '_> {
    fn matrices(&self, entity: Entity, rig: &Rig, skin: Option<&SkinnedMesh>, out: &mut Vec<Mat4>) {
        out.clear();
        let of = |entity: Entity| self.globals.get(entity).map_or(Mat4::IDENTITY, GlobalTransform::to_matrix);
        match skin.filter(|_| rig.is_skinned()).map(|skin| (skin, self.bindposes.get(&skin.inverse_bindposes))) {
            Some((skin, Some(inverse))) => {
                out.extend(skin.joints.iter().zip(inverse.iter()).map(|(joint, inverse)| of(*joint) * *inverse));
            }
            _ => out.push(of(entity)),
        }
    }

    #[cfg(feature = "morph")]
    fn morphs(&self, morphs: Option<&MorphsOf>, out: &mut Vec<f32>) {
        use bevy::mesh::morph::MeshMorphWeights::{Reference, Value};
        out.clear();
        match morphs {
            Some(Value { weights }) => out.extend(weights),
            Some(Reference(owner)) => out.extend(self.weights.get(*owner).iter().flat_map(|owned| owned.weights())),
            None => {}
        }
    }

    #[cfg(not(feature = "morph"))]
    fn morphs(&self, _: Option<&MorphsOf>, _: &mut Vec<f32>) {}
}

fn pose(
    mut surfaces: Query<(Entity, &mut DeformedSurface, Option<&SkinnedMesh>, Option<&MorphsOf>)>,
    joints: Joints,
    mut next: Local<Pose>,
) {
    for (entity, mut deformed, skin, morphs) in &mut surfaces {
        joints.matrices(entity, &deformed.rig, skin, &mut next.matrices);
        joints.morphs(morphs, &mut next.morphs);
        if deformed.pose != *next {
            let deformed = deformed.as_mut();
            std::mem::swap(&mut deformed.pose, &mut next);
            deformed.stamp = deformed.stamp.wrapping_add(1);
        }
    }
}

/// What was deformed goes with its surface.
fn forget_removed(removed: On<Remove, BuiltSurface>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<DeformedSurface>();
    }
}
