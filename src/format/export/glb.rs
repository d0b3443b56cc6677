//! Lines as glTF 2.0 in one binary file.

use std::fmt::Write as _;

use super::{ExportError, LineVertex, TraceExport};

/// Numbers of the glTF specification.
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const LINE_STRIP: u32 = 3;

impl TraceExport {
    /// The lines as GLB: a node with a mesh for each trace, a `LINE_STRIP` for each line.
    ///
    /// # Errors
    /// [`ExportError::TooLarge`] if a position is too large for `f32`, or the file for its 32-bit lengths.
    pub fn to_glb(&self) -> Result<Vec<u8>, ExportError> {
        let mut parts = Parts::default();
        for trace in self.traces.iter().filter(|trace| !trace.lines.is_empty()) {
            let mut primitives = Vec::with_capacity(trace.lines.len());
            for line in &trace.lines {
                primitives.push(parts.add(line)?);
            }
            let name = json_text(&trace.name);
            parts.nodes.push(format!(r#"{{"name":{name},"mesh":{}}}"#, parts.meshes.len()));
            parts.meshes.push(format!(r#"{{"name":{name},"primitives":[{}]}}"#, primitives.join(",")));
        }
        parts.into_glb()
    }
}

/// What a glTF document is made of.
#[derive(Default)]
struct Parts {
    nodes: Vec<String>,
    meshes: Vec<String>,
    accessors: Vec<String>,
    views: Vec<String>,
    buffer: Vec<u8>,
}

impl Parts {
    /// Adds a line, and gives the primitive.
    fn add(&mut self, line: &[LineVertex]) -> Result<String, ExportError> {
        let positions: Vec<[f32; 3]> = line.iter().map(|v| v.position.as_vec3().to_array()).collect();
        if positions.iter().flatten().any(|x| !x.is_finite()) {
            return Err(ExportError::TooLarge);
        }
        let bound = |pick: fn(f32, f32) -> f32| {
            let corner = positions.iter().copied().reduce(|a, b| [0, 1, 2].map(|k| pick(a[k], b[k])));
            let [x, y, z] = corner.unwrap_or_default();
            format!("[{x:?},{y:?},{z:?}]")
        };
        let bounds = format!(r#","min":{},"max":{}"#, bound(f32::min), bound(f32::max));
        // A face without area has no normal; glTF wants unit vectors.
        let normals = line.iter().map(|v| v.normal.normalize_or(glam::DVec3::Y).as_vec3().to_array());
        let normals: Vec<[f32; 3]> = normals.collect();
        let distances: Vec<f32> = line.iter().map(|v| v.distance as f32).collect();
        if distances.iter().any(|d| !d.is_finite()) {
            return Err(ExportError::TooLarge);
        }
        let position = self.accessor(positions.as_flattened(), "VEC3", line.len(), &bounds);
        let normal = self.accessor(normals.as_flattened(), "VEC3", line.len(), "");
        let distance = self.accessor(&distances, "SCALAR", line.len(), "");
        Ok(format!(
            r#"{{"mode":{LINE_STRIP},"attributes":{{"POSITION":{position},"NORMAL":{normal},"_DISTANCE":{distance}}}}}"#
        ))
    }

    fn accessor(&mut self, numbers: &[f32], kind: &str, count: usize, bounds: &str) -> usize {
        let (offset, length) = (self.buffer.len(), size_of_val(numbers));
        self.buffer.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
        let view = self.views.len();
        self.views
            .push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length},"target":{ARRAY_BUFFER}}}"#));
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{FLOAT},"count":{count},"type":"{kind}"{bounds}}}"#
        ));
        self.accessors.len() - 1
    }

    fn into_glb(self) -> Result<Vec<u8>, ExportError> {
        let version = env!("CARGO_PKG_VERSION");
        let mut json = format!(r#"{{"asset":{{"version":"2.0","generator":"bevy_surface_splines {version}"}}"#);
        // Lists of a glTF document are not empty.
        if !self.nodes.is_empty() {
            let scene: Vec<String> = (0..self.nodes.len()).map(|i| i.to_string()).collect();
            let _ = write!(json, r#","scene":0,"scenes":[{{"nodes":[{}]}}]"#, scene.join(","));
        }
        for (name, list) in [
            ("nodes", &self.nodes),
            ("meshes", &self.meshes),
            ("accessors", &self.accessors),
            ("bufferViews", &self.views),
        ] {
            if !list.is_empty() {
                let _ = write!(json, r#","{name}":[{}]"#, list.join(","));
            }
        }
        if !self.buffer.is_empty() {
            let _ = write!(json, r#","buffers":[{{"byteLength":{}}}]"#, self.buffer.len());
        }
        json.push('}');
        while !json.len().is_multiple_of(4) {
            json.push(' ');
        }
        let length = |bytes: usize| u32::try_from(bytes).map_err(|_| ExportError::TooLarge);
        let binary = if self.buffer.is_empty() { 0 } else { 8 + self.buffer.len() };
        let mut out = Vec::with_capacity(20 + json.len() + binary);
        out.extend(b"glTF");
        out.extend(2_u32.to_le_bytes());
        out.extend(length(20 + json.len() + binary)?.to_le_bytes());
        out.extend(length(json.len())?.to_le_bytes());
        out.extend(b"JSON");
        out.extend(json.as_bytes());
        if !self.buffer.is_empty() {
            out.extend(length(self.buffer.len())?.to_le_bytes());
            out.extend(b"BIN\0");
            out.extend(self.buffer);
        }
        Ok(out)
    }
}

/// A text as JSON has it.
fn json_text(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c < ' ' => {
                let _ = write!(out, "\\u{:04x}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
