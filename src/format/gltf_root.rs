//! glTF 2.0: the parts of a document that say where its triangles are.

use gltf::json::accessor::Accessor;
use gltf::json::{Buffer, Index, Mesh, Node, Scene, Skin, buffer};
use serde::Deserialize;
use serde::de::IgnoredAny;

/// A document without materials, textures, cameras and animations.
///
/// What is not named here is not looked at, so that a texture without an image, or one that only an extension has, is no reason to refuse
/// a mesh.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Root {
    /// Tells a document from any other object.
    #[serde(rename = "asset")]
    _asset: IgnoredAny,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) buffers: Vec<Buffer>,
    #[serde(default)]
    pub(super) buffer_views: Vec<buffer::View>,
    #[serde(default)]
    pub(super) extensions_required: Vec<String>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh>,
    #[serde(default)]
    pub(super) nodes: Vec<Node>,
    pub(super) scene: Option<Index<Scene>>,
    #[serde(default)]
    pub(super) scenes: Vec<Scene>,
    #[serde(default)]
    pub(super) skins: Vec<Skin>,
}
