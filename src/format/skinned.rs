//! Meshes with what moves their vertices.

use std::collections::HashMap;
use std::path::Path;

use glam::DAffine3;

use super::read::file_of_known_format;
use super::{FormatError, MeshFormat, gltf};
use crate::skin::{SkinError, SkinSet, SurfaceWeights, WeightsError};
use crate::surface::{Surface, TriangleMesh};

/// A mesh with the joints that move it, and how much each moves each vertex.
///
/// The mesh is what [`read_mesh`](super::read_mesh) gives: every vertex where its node puts it, before any joint moves it. A handle of a
/// skin made with it is a joint; [`pose`](Self::pose) gives the transforms that skinning takes. A mesh that has no skin hangs on its node, which
/// counts as a joint then.
#[derive(Clone, Debug)]
pub struct SkinnedMesh {
    /// All triangles of the scene.
    pub mesh: TriangleMesh,
    /// What moves vertices: the joints of each skin in its order, once for each place in which meshes with that skin stand.
    pub joints: Vec<SkinJoint>,
    /// As many as the vertex with the most influences needs. All are as long as the mesh has vertices, and weights of a vertex sum to one in all
    /// sets together; they are zero only where a node without a skin flattens its mesh.
    pub sets: Vec<JointSet>,
    /// Vertices whose weights in the file missed a sum of one by more than a thousandth.
    pub uneven: usize,
    /// By how much the sum missed one at most.
    pub worst_miss: f64,
    /// Joints in such an order that each comes after its parent.
    pub(super) order: Vec<usize>,
}

/// Something that moves vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinJoint {
    /// Its node's name. Names need not differ.
    pub name: Option<String>,
    /// Its node's number in the document.
    pub node: usize,
    /// The nearest joint above it.
    pub parent: Option<usize>,
    /// Where the file has it, in the frame of its parent, or of the world if it has none. Nodes in between are part of it.
    pub local: DAffine3,
    /// From the world to its own frame when the mesh was bound to it: the inverse bind matrix, for vertices that stand in the world.
    pub bind: DAffine3,
}

/// Four joints and their weights for each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointSet {
    /// Places in the list of joints.
    pub joints: Vec<[u16; 4]>,
    /// Their weights; a joint with weight zero is joint zero.
    pub weights: Vec<[f32; 4]>,
}

/// What is let pass in a skinned mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinnedMeshOptions {
    /// By how much the weights of a vertex may miss a sum of one; what they miss is made good. Exporters that drop the least of many influences
    /// leave sums of a fifth, so the default is 1. A sum of zero is always refused.
    pub uneven: f64,
}

impl Default for SkinnedMeshOptions {
    fn default() -> Self {
        Self { uneven: 1.0 }
    }
}

/// Reads a glTF or GLB file with its skins.
///
/// # Errors
/// As [`read_mesh`](super::read_mesh), and [`FormatError::NoSkins`] for other formats. [`FormatError::Content`] names the accessor, the skin or the
/// primitive where joints or weights are missing ([`Cause::Missing`](super::Cause::Missing), [`Cause::NoSuchItem`](super::Cause::NoSuchItem)), a
/// vertex names a joint that there is not ([`Cause::NoSuchJoint`](super::Cause::NoSuchJoint)), or its weights make no sense
/// ([`Cause::BadWeights`](super::Cause::BadWeights)).
///
/// ```no_run
/// use bevy_surface_splines::format::{SkinnedMeshOptions, read_skinned_mesh};
/// use bevy_surface_splines::skin::{Chain, JoinRules, BoundSkin};
/// use bevy_surface_splines::surface::{Surface, SurfaceOptions};
/// use bevy_surface_splines::vector::SpatialPath;
/// use glam::{DAffine3, DVec3};
///
/// let fox = read_skinned_mesh("fox.glb", &SkinnedMeshOptions::default())?;
/// let surface = Surface::build(&fox.mesh, &SurfaceOptions::default())?;
/// let collar = SpatialPath::from_points(vec![DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE], false).unwrap_or_default();
/// let chain = Chain::spatial(&collar, &JoinRules::default());
/// let skin = BoundSkin::bind(vec![chain], &fox.weights(&surface)?, &Default::default())?;
/// let mut posed = skin.at_rest();
/// let mut locals = fox.locals();
/// if let Some(neck) = fox.joint_named("b_Neck_04") {
///     locals[neck] *= DAffine3::from_rotation_x(0.3);
/// }
/// skin.pose(&fox.pose(&locals)?, &mut posed)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_skinned_mesh(path: impl AsRef<Path>, options: &SkinnedMeshOptions) -> Result<SkinnedMesh, FormatError> {
    let path = path.as_ref();
    let (bytes, format) = file_of_known_format(path)?;
    parse_skinned_mesh(&bytes, format, path.parent(), options)
}

/// Reads a glTF document with its skins from the bytes of a file; buffers in other files are read from `folder`, if one is given.
///
/// # Errors
/// As [`read_skinned_mesh`].
pub fn parse_skinned_mesh(
    bytes: &[u8],
    format: MeshFormat,
    folder: Option<&Path>,
    options: &SkinnedMeshOptions,
) -> Result<SkinnedMesh, FormatError> {
    match format {
        MeshFormat::Gltf => gltf::parse_skinned_json(bytes, folder, options),
        MeshFormat::Glb => gltf::parse_skinned_glb(bytes, folder, options),
        _ => return Err(FormatError::NoSkins { format }),
    }
    .map_err(|fault| fault.in_format(format))
}

impl SkinnedMesh {
    /// The first joint of a name.
    pub fn joint_named(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name.as_deref() == Some(name))
    }

    /// Where the file has all joints, in the frames of their parents: what to start a pose from.
    pub fn locals(&self) -> Vec<DAffine3> {
        self.joints.iter().map(|joint| joint.local).collect()
    }

    /// What moves places of the mesh in a pose, one transform for each joint: `locals` are the places of joints in the frames of their parents. In
    /// those of the file vertices need not be where [`mesh`](Self::mesh) has them: many files are bound in one pose and stand in another.
    ///
    /// # Errors
    /// [`SkinError::PoseLength`], [`SkinError::PoseNotFinite`].
    pub fn pose(&self, locals: &[DAffine3]) -> Result<Vec<DAffine3>, SkinError> {
        if locals.len() != self.joints.len() {
            return Err(SkinError::PoseLength { handles: self.joints.len(), found: locals.len() });
        }
        let mut worlds = locals.to_vec();
        for joint in &self.order {
            let parent = self.joints.get(*joint).and_then(|joint| joint.parent);
            if let Some(parent) = parent.and_then(|parent| worlds.get(parent)).copied() {
                worlds[*joint] = parent * worlds[*joint];
            }
        }
        let all: Vec<DAffine3> = worlds.iter().zip(&self.joints).map(|(world, joint)| *world * joint.bind).collect();
        match all.iter().position(|transform| !transform.is_finite()) {
            Some(handle) => Err(SkinError::PoseNotFinite { handle }),
            None => Ok(all),
        }
    }

    /// Joints and weights of the vertices, as [`SurfaceWeights::of_skin`] takes them.
    pub fn skin_sets(&self) -> Vec<SkinSet<'_>> {
        self.sets.iter().map(|set| (&set.joints[..], &set.weights[..])).collect()
    }

    /// Weights at all places, carried by the surface that was built of the mesh.
    ///
    /// # Errors
    /// As [`SurfaceWeights::of_skin`].
    pub fn weights<'a>(&'a self, surface: &'a Surface) -> Result<SurfaceWeights<'a>, WeightsError> {
        SurfaceWeights::of_skin(surface, &self.mesh, self.joints.len(), &self.skin_sets())
    }

    /// Parents, and the order that they ask for, once all joints are known. `above` has the nearest node above each joint's node that is a joint,
    /// `depths` how deep nodes lie, and `groups` which joints belong together.
    pub(super) fn link(&mut self, above: &[Option<usize>], depths: &[usize], groups: &[usize]) {
        let mut first: HashMap<usize, usize> = HashMap::new();
        let mut in_group: HashMap<(usize, usize), usize> = HashMap::new();
        for (number, (joint, group)) in self.joints.iter().zip(groups).enumerate() {
            first.entry(joint.node).or_insert(number);
            in_group.entry((joint.node, *group)).or_insert(number);
        }
        for (joint, group) in self.joints.iter_mut().zip(groups) {
            let node = above.get(joint.node).copied().flatten();
            joint.parent = node.and_then(|node| in_group.get(&(node, *group)).or_else(|| first.get(&node)).copied());
        }
        self.order = (0..self.joints.len()).collect();
        self.order.sort_by_key(|joint| depths.get(self.joints[*joint].node).copied().unwrap_or(0));
    }
}
