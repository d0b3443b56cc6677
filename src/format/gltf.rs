//! glTF 2.0: the triangles of a scene.

use std::collections::HashMap;
use std::path::Path;

use glam::{DMat4, DQuat, DVec3};
use gltf::json::accessor::{Accessor, Type};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Node};

use super::error::{Cause, Fault};
use super::gltf_data::{Buffer, Container, Data, load_buffers};
use super::gltf_root::Root;
use super::gltf_skin::{Rig, VERTEX_BYTES, check_skins, each_set, skin_of};
use super::skinned::{SkinnedMesh, SkinnedMeshOptions};
use super::strip::push_strip;
use crate::surface::TriangleMesh;

/// A document may unpack to this many times its own size …
const GROWTH: u64 = 64;
/// … and this many bytes on top, before it counts as hostile.
const ALLOWANCE: u64 = 32 << 20;
/// What visiting a primitive costs of that, however little it holds: bounds the time that instances take.
const VISIT: usize = 64;

/// Extensions that may be required and change nothing about positions and faces.
const HARMLESS_EXTENSIONS: [&str; 10] = [
    "KHR_mesh_quantization",
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_animation_",
    "KHR_xmp",
    "KHR_audio",
];

/// Reads a document in JSON; one in a GLB container as well.
pub(super) fn parse_json(bytes: &[u8], folder: Option<&Path>) -> Result<TriangleMesh, Fault> {
    parse(&json_container(bytes)?, folder)
}

/// Reads a document in a GLB container.
pub(super) fn parse_glb(bytes: &[u8], folder: Option<&Path>) -> Result<TriangleMesh, Fault> {
    parse(&Container::split(bytes)?, folder)
}

/// Reads a document in JSON with its skins; one in a GLB container as well.
pub(super) fn parse_skinned_json(
    bytes: &[u8],
    folder: Option<&Path>,
    options: &SkinnedMeshOptions,
) -> Result<SkinnedMesh, Fault> {
    parse_skinned(&json_container(bytes)?, folder, options)
}

/// Reads a document in a GLB container with its skins.
pub(super) fn parse_skinned_glb(
    bytes: &[u8],
    folder: Option<&Path>,
    options: &SkinnedMeshOptions,
) -> Result<SkinnedMesh, Fault> {
    parse_skinned(&Container::split(bytes)?, folder, options)
}

fn json_container(bytes: &[u8]) -> Result<Container<'_>, Fault> {
    if bytes.starts_with(b"glTF") {
        return Container::split(bytes);
    }
    let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    Ok(Container { json, json_start: None, binary: None })
}

fn parse(container: &Container<'_>, folder: Option<&Path>) -> Result<TriangleMesh, Fault> {
    let root = root_of(container)?;
    Ok(walked(&root, container, folder, None)?.mesh)
}

fn parse_skinned(
    container: &Container<'_>,
    folder: Option<&Path>,
    options: &SkinnedMeshOptions,
) -> Result<SkinnedMesh, Fault> {
    let root = root_of(container)?;
    let walked = walked(&root, container, folder, Some(Rig::new(*options)))?;
    let rig = walked.rig.unwrap_or_else(|| Rig::new(*options));
    Ok(rig.finish(walked.mesh, &root, &walked.parents))
}

/// The document, if all that it requires is known and its skins have joints that exist.
fn root_of(container: &Container<'_>) -> Result<Root, Fault> {
    let root: Root = gltf::json::deserialize::from_slice(container.json)
        .map_err(|error| container.json_fault(error.line(), error.column(), error.to_string()))?;
    if let Some(name) = root.extensions_required.iter().find(|name| !is_harmless(name)) {
        let what = format!("the required extension `{name}`");
        return Err(Fault::item("the document", Cause::Unsupported { what, remedy: "export it without" }));
    }
    check_skins(&root)?;
    Ok(root)
}

/// What a walk gathered.
struct Walked {
    mesh: TriangleMesh,
    rig: Option<Rig>,
    /// Of all nodes.
    parents: Vec<Option<usize>>,
}

/// Reads the triangles, strips and fans of the default scene (else the first, else of all root nodes) in document order,
/// in world space. Skins and morph targets are checked where they are used, but move nothing; a node that mirrors does not
/// turn its faces over.
fn walked(root: &Root, container: &Container<'_>, folder: Option<&Path>, rig: Option<Rig>) -> Result<Walked, Fault> {
    let buffers = load_buffers(root, container.binary, folder)?;
    let budget = budget(container, &buffers);
    let data = Data { root, buffers: &buffers, budget };
    let parents = parents(root)?;
    let mut walk = Walk { data, budget, mesh: TriangleMesh::default(), rig };
    walk.all(first_nodes(root, &parents)?)?;
    Ok(Walked { mesh: walk.mesh, rig: walk.rig, parents })
}

fn is_harmless(extension: &str) -> bool {
    HARMLESS_EXTENSIONS.iter().any(|harmless| extension.starts_with(harmless))
}

/// Bytes that the mesh may come to.
fn budget(container: &Container<'_>, buffers: &[Buffer<'_>]) -> u64 {
    let data: usize = buffers.iter().map(|buffer| buffer.bytes().len()).sum();
    (container.json.len() + data) as u64 * GROWTH + ALLOWANCE
}

/// The parents of all nodes, used or not, which are made sure to form trees.
fn parents(root: &Root) -> Result<Vec<Option<usize>>, Fault> {
    let not_a_tree = |node: usize| Fault::item(format!("node {node}"), Cause::NotATree);
    let mut parents = vec![None; root.nodes.len()];
    for (number, node) in root.nodes.iter().enumerate() {
        for child in node.children.iter().flatten().map(Index::value) {
            let missing = || Fault::item(format!("node {number}"), Cause::NoSuchItem(format!("node {child}")));
            if parents.get_mut(child).ok_or_else(missing)?.replace(number).is_some() {
                return Err(not_a_tree(child));
            }
        }
    }
    // With one parent each, the nodes that no root leads to are those on cycles and below.
    let mut reached = vec![false; parents.len()];
    let mut open: Vec<usize> = root_numbers(&parents).collect();
    while let Some(node) = open.pop() {
        reached[node] = true;
        open.extend(root.nodes[node].children.iter().flatten().map(Index::value));
    }
    match reached.iter().position(|reached| !reached) {
        Some(node) => Err(not_a_tree(node)),
        None => Ok(parents),
    }
}

/// The nodes without a parent.
fn root_numbers(parents: &[Option<usize>]) -> impl Iterator<Item = usize> + '_ {
    (0..parents.len()).filter(|node| parents[*node].is_none())
}

/// The nodes that the walk starts from.
fn first_nodes(root: &Root, parents: &[Option<usize>]) -> Result<Vec<Index<Node>>, Fault> {
    let Some(scene) = root.scene else {
        let all = || root_numbers(parents).map(|node| Index::new(node as u32)).collect();
        return Ok(root.scenes.first().map_or_else(all, |scene| scene.nodes.clone()));
    };
    let missing = || Fault::item("the document", Cause::NoSuchItem(format!("scene {}", scene.value())));
    Ok(root.scenes.get(scene.value()).ok_or_else(missing)?.nodes.clone())
}

/// A walk over the nodes that gathers their triangles.
struct Walk<'a> {
    data: Data<'a>,
    /// Bytes that the mesh may still grow by.
    budget: u64,
    mesh: TriangleMesh,
    /// What moves the mesh, if that is asked for.
    rig: Option<Rig>,
}

impl Walk<'_> {
    /// Visits nodes and their children, depth first, in document order; no node twice.
    fn all(&mut self, first: Vec<Index<Node>>) -> Result<(), Fault> {
        let root = self.data.root;
        let mut visited = vec![false; root.nodes.len()];
        let mut open: Vec<(Index<Node>, DMat4)> = first.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
        while let Some((index, parent)) = open.pop() {
            let name = format!("node {}", index.value());
            let Some(node) = root.nodes.get(index.value()) else {
                return Err(Fault::item("the scene", Cause::NoSuchItem(name)));
            };
            if std::mem::replace(&mut visited[index.value()], true) {
                return Err(Fault::item(name, Cause::NotATree));
            }
            let transform = parent * local_transform(node);
            self.node((index.value(), node), &name, transform)?;
            open.extend(node.children.iter().flatten().rev().map(|child| (*child, transform)));
        }
        Ok(())
    }

    fn node(&mut self, (index, node): (usize, &Node), name: &str, transform: DMat4) -> Result<(), Fault> {
        let skin = node.skin.map(|skin| skin_of(self.data.root, skin, name)).transpose()?;
        let joints = skin.map(|skin| skin.joints.len());
        let Some(mesh) = node.mesh else {
            return Ok(());
        };
        let missing = || Fault::item(name, Cause::NoSuchItem(format!("mesh {}", mesh.value())));
        let primitives = &self.data.root.meshes.get(mesh.value()).ok_or_else(missing)?.primitives;
        // Primitives often share their vertices: where each accessor's positions begin in the mesh, and how many there are.
        let mut placed: HashMap<usize, (u32, usize)> = HashMap::new();
        // The first joint that moves them, once that is known.
        let mut first = None;
        for (number, primitive) in primitives.iter().enumerate() {
            let node_name = name;
            let name = format!("mesh {}, primitive {number}", mesh.value());
            let fault = |cause| Fault::item(name.clone(), cause);
            self.spend(1, VISIT, &name)?;
            let Checked::Valid(mode) = primitive.mode else {
                return Err(fault(Cause::Invalid("its mode is unknown".into())));
            };
            if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
                continue;
            }
            let Some(positions) = attribute(primitive, Semantic::Positions) else {
                return Err(fault(Cause::Missing("the attribute `POSITION`")));
            };
            let (base, vertices) = match placed.get(&positions.value()) {
                Some(known) => *known,
                None => {
                    let new = self.vertices(positions, transform, &name)?;
                    if let Some(rig) = &mut self.rig {
                        let first = match first {
                            Some(known) => known,
                            None => *first.insert(rig.enter(&self.data, (index, node), node_name, transform)?),
                        };
                        self.spend(new.1, VERTEX_BYTES, &name)?;
                        if let (Some(rig), Some(first)) = (&mut self.rig, first) {
                            rig.add(&self.data, primitive, (first, joints), (new.0 as usize, new.1), &name)?;
                        }
                    } else if let Some(joints) = joints {
                        each_set(&self.data, primitive, joints, new.1, &name, |_, _, _| {})?;
                    }
                    *placed.entry(positions.value()).or_insert(new)
                }
            };
            self.faces(primitive, mode, base, vertices, &name)?;
        }
        Ok(())
    }

    /// Appends the positions of an accessor; gives the first one's index and how many there are.
    fn vertices(&mut self, accessor: Index<Accessor>, transform: DMat4, name: &str) -> Result<(u32, usize), Fault> {
        let positions = self.data.elements::<3>(accessor, Type::Vec3)?;
        self.spend(positions.len(), size_of::<DVec3>(), name)?;
        let base = self.mesh.positions.len();
        if base + positions.len() > u32::MAX as usize {
            return Err(Fault::item(name, Cause::TooManyVertices));
        }
        let world = positions.iter().map(|position| transform.transform_point3(DVec3::from_array(*position)));
        self.mesh.positions.extend(world);
        Ok((base as u32, positions.len()))
    }

    fn faces(
        &mut self,
        primitive: &Primitive,
        mode: Mode,
        base: u32,
        vertices: usize,
        name: &str,
    ) -> Result<(), Fault> {
        let corners: Vec<u32> = match primitive.indices {
            None => (0..vertices as u32).map(|corner| base + corner).collect(),
            Some(indices) => {
                let indices = self.data.elements::<1>(indices, Type::Scalar)?;
                let checked = indices.into_iter().map(|[index]| {
                    // Also refuses fractions below zero and NaN.
                    let ok = index >= 0.0 && index < vertices as f64 && index.fract() == 0.0;
                    let vertices = vertices as u64;
                    let out_of_range = || Cause::IndexOutOfRange { index: index.to_string(), vertices };
                    if ok { Ok(base + index as u32) } else { Err(Fault::item(name, out_of_range())) }
                });
                checked.collect::<Result<_, _>>()?
            }
        };
        self.spend(corners.len(), size_of::<u32>() * if mode == Mode::Triangles { 1 } else { 3 }, name)?;
        match mode {
            Mode::TriangleStrip => push_strip(&mut self.mesh.faces, &corners),
            Mode::TriangleFan => self.mesh.push_polygon(&corners),
            _ => self.mesh.faces.extend_from_slice(corners.as_chunks::<3>().0),
        }
        Ok(())
    }

    /// Takes `count` items of `size` bytes out of the budget.
    fn spend(&mut self, count: usize, size: usize, name: &str) -> Result<(), Fault> {
        let bytes = (count as u64).saturating_mul(size as u64);
        let left = self.budget.checked_sub(bytes);
        self.budget = left.ok_or_else(|| {
            let bytes = (self.data.budget - self.budget).saturating_add(bytes);
            Fault::item(name, Cause::TooLarge { bytes })
        })?;
        Ok(())
    }
}

pub(super) fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

pub(super) fn local_transform(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector =
        |values: Option<[f32; 3]>, otherwise| values.map_or(otherwise, |v| DVec3::from_array(v.map(f64::from)));
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)));
    // Single precision leaves a quaternion's length off by 1e-8, which would scale the mesh.
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    let scale = vector(node.scale, DVec3::ONE);
    DMat4::from_scale_rotation_translation(scale, rotation, vector(node.translation, DVec3::ZERO))
}

#[cfg(test)]
mod tests {
    use base64::Engine as _;
    use base64::engine::general_purpose::STANDARD;

    use super::super::error::Place;
    use super::*;

    /// Four corners of a unit square as floats, then the indices 0 1 2 3 as bytes.
    fn square() -> Vec<u8> {
        let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()).chain([0, 1, 2, 3]).collect()
    }

    /// A document around the square, with these nodes and this primitive.
    fn document(nodes: &str, primitive: &str) -> String {
        let data = STANDARD.encode(square());
        format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}],"meshes":[{{"primitives":[{primitive}]}}],
            "buffers":[{{"byteLength":52,"uri":"data:application/octet-stream;base64,{data}"}}],
            "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":4}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
            {{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"}}]}}"#
        )
    }

    const STRIP: &str = r#"{"attributes":{"POSITION":0},"indices":1,"mode":5}"#;
    const NODE: &str = r#"{"mesh":0}"#;

    fn fails(document: &str) -> Fault {
        parse_json(document.as_bytes(), None).unwrap_err()
    }

    #[test]
    fn strips_fans_and_shared_vertices() {
        let fan = r#"{"attributes":{"POSITION":0},"mode":6},{"attributes":{"POSITION":0},"mode":1}"#;
        let mesh = parse_json(document(NODE, &format!("{STRIP},{fan}")).as_bytes(), None).unwrap();
        assert_eq!(mesh.positions.len(), 4);
        assert_eq!(mesh.faces, [[0, 1, 2], [1, 3, 2], [0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn transforms_are_chained_in_document_order() {
        let nodes = r#"{"translation":[0,0,5],"children":[1,2]},{"mesh":0,"scale":[2,2,2]},{"mesh":0}"#;
        let mesh = parse_json(document(nodes, STRIP).as_bytes(), None).unwrap();
        assert_eq!(mesh.positions[3], DVec3::new(2.0, 2.0, 5.0));
        assert_eq!(mesh.positions[7], DVec3::new(1.0, 1.0, 5.0));
        assert_eq!(mesh.faces[2], [4, 5, 6]);
    }

    #[test]
    fn cycles_and_second_parents_are_refused() {
        assert_eq!(fails(&document(r#"{"mesh":0},{"children":[2]},{"children":[1]}"#, STRIP)).cause, Cause::NotATree);
        let twice = document(NODE, STRIP).replace("\"nodes\"", "\"scenes\":[{\"nodes\":[0,0]}],\"nodes\"");
        assert_eq!(fails(&twice).cause, Cause::NotATree);
        let shared = document(r#"{"children":[2]},{"children":[2]},{"mesh":0}"#, STRIP);
        assert_eq!(fails(&shared).place, Place::Item("node 2".into()));
        assert_eq!(fails(&document(r#"{"children":[7]}"#, STRIP)).cause, Cause::NoSuchItem("node 7".into()));
    }

    #[test]
    fn errors_name_the_item() {
        let good = document(NODE, STRIP);
        let past = fails(&good.replace(r#"5121,"count":4"#, r#"5121,"count":5"#));
        assert_eq!(past.place, Place::Item("accessor 1".into()));
        assert_eq!(past.cause, Cause::PastEnd { needed: 5, holder: "buffer view 1".into(), present: 4 });
        let short = fails(&good.replace(r#""byteLength":52"#, r#""byteLength":53"#));
        assert_eq!(short.place, Place::Item("buffer 0".into()));
        let huge =
            fails(&good.replace(
                r#""bufferView":0,"componentType":5126,"count":4"#,
                r#""componentType":5126,"count":4000000000"#,
            ));
        assert!(matches!(huge.cause, Cause::TooLarge { .. }));
        let wide = fails(&good.replace(
            r#""bufferView":1,"componentType":5121,"count":4"#,
            r#""bufferView":0,"componentType":5121,"count":24"#,
        ));
        assert!(matches!(wide.cause, Cause::IndexOutOfRange { vertices: 4, .. }));
        assert_eq!(fails(&good.replace("\"nodes\"", "\n\"nodes\":7,\"x\"")).place, Place::Line(2));
        let draco = good.replace("\"nodes\"", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"nodes\"");
        assert!(matches!(fails(&draco).cause, Cause::Unsupported { .. }));
        let external = fails(&good.replace("data:application/octet-stream;base64,", "a/"));
        assert!(matches!(external.cause, Cause::Unsupported { .. }));
    }

    #[test]
    fn what_is_no_geometry_may_be_anything() {
        let good = document(NODE, &STRIP.replace("\"mode\"", "\"material\":0,\"mode\""));
        // A texture without an image, one that an extension has, and what nobody could read.
        let painted = r#""materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"images":[],"samplers":7,
            "textures":[{},{"extensions":{"KHR_texture_basisu":{"source":0}}}],"animations":[{"channels":false}],"cameras":{},"nodes""#;
        let mesh = parse_json(good.replace("\"nodes\"", painted).as_bytes(), None).unwrap();
        assert_eq!(mesh, parse_json(good.as_bytes(), None).unwrap());
        assert_eq!(mesh.faces.len(), 2);
        assert!(matches!(fails(&good.replace("asset", "other")).cause, Cause::Json(_)));
    }

    #[test]
    fn sparse_values_replace_others() {
        let sparse = r#""count":4,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":1,"byteOffset":2,
            "componentType":5121},"values":{"bufferView":0,"byteOffset":36}}}"#;
        let good = document(NODE, STRIP).replace(r#""count":4,"type":"VEC3"}"#, sparse);
        let mesh = parse_json(good.as_bytes(), None).unwrap();
        assert_eq!(mesh.positions[2], DVec3::new(1.0, 1.0, 0.0));
        assert!(matches!(
            fails(&good.replace(r#""byteOffset":36"#, r#""byteOffset":37"#)).cause,
            Cause::PastEnd { .. }
        ));
    }
}
