//! glTF 2.0: joints and weights of a scene's vertices.

use std::collections::HashMap;

use glam::{DAffine3, DMat4};
use gltf::json::accessor::{Accessor, Type};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::{Index, Node, Skin};

use super::error::{Cause, Fault};
use super::gltf::{attribute, local_transform};
use super::gltf_data::Data;
use super::gltf_root::Root;
use super::skinned::{JointSet, SkinJoint, SkinnedMesh, SkinnedMeshOptions};
use crate::surface::TriangleMesh;

/// Sets of four joints a vertex that are looked at.
const JOINT_SETS: u32 = 8;
/// What a vertex may take in all sets.
pub(super) const VERTEX_BYTES: usize = JOINT_SETS as usize * (size_of::<[u16; 4]>() + size_of::<[f32; 4]>());
/// Joints that sets can name.
const MOST_JOINTS: usize = 1 << 16;
/// By how much a sum of weights may miss one before it is counted: what rounding to bytes leaves is less.
const EVEN: f64 = 1e-3;

/// The skin of a node.
pub(super) fn skin_of<'a>(root: &'a Root, skin: Index<Skin>, node: &str) -> Result<&'a Skin, Fault> {
    let missing = || Fault::item(node, Cause::NoSuchItem(format!("skin {}", skin.value())));
    root.skins.get(skin.value()).ok_or_else(missing)
}

/// Refuses skins with joints that do not exist.
pub(super) fn check_skins(root: &Root) -> Result<(), Fault> {
    for (number, skin) in root.skins.iter().enumerate() {
        if let Some(joint) = skin.joints.iter().find(|joint| joint.value() >= root.nodes.len()) {
            let cause = Cause::NoSuchItem(format!("node {}", joint.value()));
            return Err(Fault::item(format!("skin {number}"), cause));
        }
    }
    Ok(())
}

/// Hands over set after set of a primitive's joints and weights, those of all vertices at once. Vertices that give weight to a joint that the skin
/// does not have are refused.
pub(super) fn each_set(
    data: &Data<'_>,
    primitive: &Primitive,
    joints: usize,
    vertices: usize,
    name: &str,
    mut take: impl FnMut(usize, &[[f64; 4]], &[[f64; 4]]),
) -> Result<(), Fault> {
    for set in 0..JOINT_SETS {
        let indices = attribute(primitive, Semantic::Joints(set));
        let (Some(indices), Some(weights)) = (indices, attribute(primitive, Semantic::Weights(set))) else {
            break;
        };
        for accessor in [indices, weights] {
            let described = data.root.accessors.get(accessor.value());
            if described.is_some_and(|described| described.count.0 != vertices as u64) {
                let cause = format!("accessor {} should have {vertices} values", accessor.value());
                return Err(Fault::item(name, Cause::Invalid(cause)));
            }
        }
        let indices = data.elements::<4>(indices, Type::Vec4)?;
        let weights = data.elements::<4>(weights, Type::Vec4)?;
        for (vertex, (indices, weights)) in indices.iter().zip(&weights).enumerate() {
            // Also refuses fractions below zero and NaN.
            let is_joint = |joint: f64| joint >= 0.0 && joint < joints as f64 && joint.fract() == 0.0;
            let bad = indices.iter().zip(weights).find(|(joint, weight)| **weight != 0.0 && !is_joint(**joint));
            if let Some((joint, _)) = bad {
                let cause = Cause::NoSuchJoint { vertex, joint: joint.to_string(), joints };
                return Err(Fault::item(name, cause));
            }
        }
        take(set as usize, &indices, &weights);
    }
    Ok(())
}

/// Gathers joints and weights while the meshes of a scene are visited.
pub(super) struct Rig {
    options: SkinnedMeshOptions,
    joints: Vec<SkinJoint>,
    /// Which joints belong together: those of a skin in a place, or one of a node.
    groups: Vec<usize>,
    group_count: usize,
    /// The first joint of a skin in a place; places are the same to the bit.
    known: HashMap<(usize, [u64; 16]), usize>,
    /// Inverse bind matrices of skins that were met.
    binds: HashMap<usize, Vec<DAffine3>>,
    sets: Vec<JointSet>,
    uneven: usize,
    worst_miss: f64,
}

impl Rig {
    pub(super) fn new(options: SkinnedMeshOptions) -> Self {
        Self {
            options,
            joints: Vec::new(),
            groups: Vec::new(),
            group_count: 0,
            known: HashMap::new(),
            binds: HashMap::new(),
            sets: Vec::new(),
            uneven: 0,
            worst_miss: 0.0,
        }
    }

    /// The first of the joints that move the mesh of a node that stands in a place; none if that is flat and there is no skin.
    pub(super) fn enter(
        &mut self,
        data: &Data<'_>,
        node: (usize, &Node),
        name: &str,
        transform: DMat4,
    ) -> Result<Option<usize>, Fault> {
        let (number, node) = node;
        let first = self.joints.len();
        let back = DAffine3::from_mat4(transform).inverse();
        let Some(skin) = node.skin else {
            if !back.is_finite() {
                return Ok(None);
            }
            self.push(data.root, number, back, name)?;
            self.group_count += 1;
            return Ok(Some(first));
        };
        let key = (skin.value(), transform.to_cols_array().map(f64::to_bits));
        if let Some(known) = self.known.get(&key) {
            return Ok(Some(*known));
        }
        if !back.is_finite() {
            let what = "a skinned mesh that its node flattens".into();
            return Err(Fault::item(name, Cause::Unsupported { what, remedy: "scale the node by more than zero" }));
        }
        let described = skin_of(data.root, skin, name)?;
        let binds = match self.binds.remove(&skin.value()) {
            Some(known) => known,
            None => inverse_binds(data, described, skin.value())?,
        };
        for (joint, bind) in described.joints.iter().zip(&binds) {
            self.push(data.root, joint.value(), *bind * back, name)?;
        }
        self.binds.insert(skin.value(), binds);
        self.group_count += 1;
        self.known.insert(key, first);
        Ok(Some(first))
    }

    fn push(&mut self, root: &Root, node: usize, bind: DAffine3, name: &str) -> Result<(), Fault> {
        if self.joints.len() >= MOST_JOINTS {
            let what = format!("a scene with more than {MOST_JOINTS} joints");
            return Err(Fault::item(name, Cause::Unsupported { what, remedy: "bake fewer instances into it" }));
        }
        let name = root.nodes.get(node).and_then(|node| node.name.clone());
        self.joints.push(SkinJoint { name, node, parent: None, local: DAffine3::IDENTITY, bind });
        self.groups.push(self.group_count);
        Ok(())
    }

    /// Takes in the vertices of a primitive, so many from `base` on. `first` is its first joint, `joints` how many its skin has, if it has one.
    pub(super) fn add(
        &mut self,
        data: &Data<'_>,
        primitive: &Primitive,
        (first, joints): (usize, Option<usize>),
        (base, count): (usize, usize),
        name: &str,
    ) -> Result<(), Fault> {
        let Some(joints) = joints else {
            let set = self.set(0, base);
            set.joints.resize(base + count, [first as u16, 0, 0, 0]);
            set.weights.resize(base + count, [1.0, 0.0, 0.0, 0.0]);
            return Ok(());
        };
        for set in 0..JOINT_SETS {
            let fault = |what| Err(Fault::item(name, Cause::Missing(what)));
            match [Semantic::Joints(set), Semantic::Weights(set)].map(|semantic| attribute(primitive, semantic)) {
                [None, None] if set > 0 => break,
                [None, _] => return fault("an attribute `JOINTS_n` of the skinned mesh"),
                [_, None] => return fault("an attribute `WEIGHTS_n` of the skinned mesh"),
                _ => {}
            }
        }
        let mut sums = vec![0.0; count];
        let mut negative = None;
        each_set(data, primitive, joints, count, name, |_, _, weights| {
            for (vertex, (sum, weights)) in sums.iter_mut().zip(weights).enumerate() {
                *sum += weights.iter().sum::<f64>();
                negative = negative.or_else(|| weights.iter().any(|w| *w < 0.0).then_some(vertex));
            }
        })?;
        let within = |sum: f64| sum > 0.0 && (sum - 1.0).abs() <= self.options.uneven && sum.is_finite();
        if let Some(vertex) = negative.or_else(|| sums.iter().position(|sum| !within(*sum))) {
            return Err(Fault::item(name, Cause::BadWeights { vertex, sum: sums[vertex].to_string() }));
        }
        for miss in sums.iter().map(|sum| (sum - 1.0).abs()) {
            self.uneven += usize::from(miss > EVEN);
            self.worst_miss = self.worst_miss.max(miss);
        }
        each_set(data, primitive, joints, count, name, |number, indices, weights| {
            let set = self.set(number, base);
            for ((indices, weights), sum) in indices.iter().zip(weights).zip(&sums) {
                let place = |k: usize| if weights[k] > 0.0 { (first + indices[k] as usize) as u16 } else { 0 };
                set.joints.push(std::array::from_fn(place));
                set.weights.push(weights.map(|w| (w / sum) as f32));
            }
        })
    }

    /// A set that is filled up to a vertex.
    fn set(&mut self, number: usize, base: usize) -> &mut JointSet {
        if self.sets.len() <= number {
            self.sets.resize_with(number + 1, JointSet::default);
        }
        let set = &mut self.sets[number];
        set.joints.resize(base, [0; 4]);
        set.weights.resize(base, [0.0; 4]);
        set
    }

    /// The mesh with what was gathered. `parents` are those of all nodes, which form trees.
    pub(super) fn finish(mut self, mesh: TriangleMesh, root: &Root, parents: &[Option<usize>]) -> SkinnedMesh {
        for number in 0..self.sets.len() {
            self.set(number, mesh.positions.len());
        }
        let mut is_joint = vec![false; parents.len()];
        self.joints.iter().for_each(|joint| is_joint[joint.node] = true);
        let depths = depths(parents);
        let mut order: Vec<usize> = (0..parents.len()).collect();
        order.sort_by_key(|node| depths[*node]);
        // The nearest joint above each node, and its place in that joint's frame.
        let mut above: Vec<Option<usize>> = vec![None; parents.len()];
        let mut places = vec![DMat4::IDENTITY; parents.len()];
        for node in order {
            places[node] = local_transform(&root.nodes[node]);
            match parents[node] {
                Some(parent) if is_joint[parent] => above[node] = Some(parent),
                Some(parent) => {
                    above[node] = above[parent];
                    places[node] = places[parent] * places[node];
                }
                None => {}
            }
        }
        self.joints.iter_mut().for_each(|joint| joint.local = DAffine3::from_mat4(places[joint.node]));
        let Self { joints, groups, sets, uneven, worst_miss, .. } = self;
        let mut skinned = SkinnedMesh { mesh, joints, sets, uneven, worst_miss, order: Vec::new() };
        skinned.link(&above, &depths, &groups);
        skinned
    }
}

/// How many nodes are above each node.
fn depths(parents: &[Option<usize>]) -> Vec<usize> {
    let mut depths: Vec<Option<usize>> = vec![None; parents.len()];
    let mut path = Vec::new();
    for node in 0..parents.len() {
        let mut at = node;
        // Every node is on such a path once, since its depth is known then.
        while let (None, Some(parent)) = (depths[at], parents[at]) {
            path.push(at);
            at = parent;
        }
        let mut depth = depths[at].unwrap_or(0);
        depths[at] = Some(depth);
        while let Some(below) = path.pop() {
            depth += 1;
            depths[below] = Some(depth);
        }
    }
    depths.into_iter().map(Option::unwrap_or_default).collect()
}

/// The inverse bind matrices of a skin; it stands where it was bound if it has none.
fn inverse_binds(data: &Data<'_>, skin: &Skin, number: usize) -> Result<Vec<DAffine3>, Fault> {
    let count = skin.joints.len();
    let fault = |cause| Fault::item(format!("skin {number}"), cause);
    if count == 0 {
        return Err(fault(Cause::Missing("a joint of the skin")));
    }
    let Some(accessor): Option<Index<Accessor>> = skin.inverse_bind_matrices else {
        return Ok(vec![DAffine3::IDENTITY; count]);
    };
    let matrices = data.elements::<16>(accessor, Type::Mat4)?;
    if matrices.len() < count {
        let what = format!("it has {count} joints, but accessor {} has {} matrices", accessor.value(), matrices.len());
        return Err(fault(Cause::Invalid(what)));
    }
    let affine = |(joint, matrix): (usize, &[f64; 16])| {
        let last = [matrix[3], matrix[7], matrix[11], matrix[15] - 1.0];
        let fine = matrix.iter().all(|x| x.is_finite()) && last.iter().all(|x| x.abs() < 1e-3);
        let bad = || fault(Cause::Invalid(format!("the inverse bind matrix of its joint {joint} is not affine")));
        if fine { Ok(DAffine3::from_mat4(DMat4::from_cols_array(matrix))) } else { Err(bad()) }
    };
    matrices.iter().take(count).enumerate().map(affine).collect()
}

#[cfg(test)]
mod tests;
