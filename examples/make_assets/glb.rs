//! A binary glTF document that is written part by part.

use std::fmt::Write as _;

/// What the numbers of an accessor are, as glTF counts it.
#[derive(Clone, Copy)]
pub(crate) enum Numbers {
    /// Fractions from 0 to 1 of 255, or whole numbers.
    Bytes { normalized: bool },
    /// Whole numbers of two bytes.
    Shorts,
    /// Single precision.
    Floats,
}

/// The binary part and its accessors.
#[derive(Default)]
pub(crate) struct Data {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Data {
    /// Adds values of a kind (`VEC3`, ...), and gives the number of their accessor. `rest` is put into its description.
    pub(crate) fn add(&mut self, numbers: Numbers, kind: &str, count: usize, bytes: &[u8], rest: &str) -> usize {
        let (component, normalized) = match numbers {
            Numbers::Bytes { normalized } => (5121, normalized),
            Numbers::Shorts => (5123, false),
            Numbers::Floats => (5126, false),
        };
        let (offset, length, view) = (self.bytes.len(), bytes.len(), self.views.len());
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#));
        let normalized = if normalized { r#","normalized":true"# } else { "" };
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"count":{count},"type":"{kind}"{normalized}{rest}}}"#
        ));
        view
    }

    /// Adds numbers of single precision.
    pub(crate) fn floats<const N: usize>(&mut self, kind: &str, values: &[[f32; N]], rest: &str) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add(Numbers::Floats, kind, values.len(), &bytes, rest)
    }

    /// The whole file. `items` are the other members of the document.
    pub(crate) fn into_file(self, items: &str) -> Vec<u8> {
        let mut json = String::from(r#"{"asset":{"version":"2.0","generator":"bevy_surface_splines, make_assets"},"#);
        let (views, accessors) = (self.views.join(","), self.accessors.join(","));
        let length = self.bytes.len();
        let _ = write!(
            json,
            r#"{items},"accessors":[{accessors}],"bufferViews":[{views}],"buffers":[{{"byteLength":{length}}}]}}"#
        );
        while !json.len().is_multiple_of(4) {
            json.push(' ');
        }
        let mut file = b"glTF\x02\0\0\0".to_vec();
        let chunks = [(b"JSON", json.as_bytes()), (b"BIN\0", &self.bytes)];
        let total: usize = 12 + chunks.iter().map(|(_, bytes)| 8 + bytes.len()).sum::<usize>();
        file.extend((total as u32).to_le_bytes());
        for (kind, bytes) in chunks {
            file.extend((bytes.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(bytes);
        }
        file
    }
}
