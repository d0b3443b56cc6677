//! The bytes behind a glTF document: container, buffers and accessors, every length checked before it is trusted.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use base64::{alphabet, engine::DecodePaddingMode};
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer};

use super::error::{Cause, Fault};
use super::gltf_root::Root;
use super::regular::read_file;

/// Standard base64, with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The two parts of a document.
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// Where the JSON begins in a GLB file.
    pub(super) json_start: Option<usize>,
    pub(super) binary: Option<&'a [u8]>,
}

impl<'a> Container<'a> {
    /// Splits a GLB file into its chunks.
    pub(super) fn split(bytes: &'a [u8]) -> Result<Self, Fault> {
        if !bytes.starts_with(b"glTF") {
            return Err(Fault::byte(0, Cause::NothingFound("it does not begin with `glTF`")));
        }
        let header_end = || Fault::byte(bytes.len(), Cause::EndsEarly("the header"));
        let version = word(bytes, 4).ok_or_else(header_end)?;
        if version != 2 {
            let what = format!("glTF version {version}");
            return Err(Fault::byte(4, Cause::Unsupported { what, remedy: "export it as glTF 2.0" }));
        }
        let length = word(bytes, 8).ok_or_else(header_end)? as usize;
        if length > bytes.len() {
            let present = bytes.len() as u64;
            return Err(Fault::byte(8, Cause::PastEnd { needed: length as u64, holder: "the file".into(), present }));
        }
        let bytes = &bytes[..length.max(12)];
        let (json, kind, next) = chunk(bytes, 12)?;
        let json_start = Some(20);
        if kind != *b"JSON" {
            return Err(Fault::byte(16, Cause::Missing("the JSON chunk")));
        }
        let mut at = next;
        while at < bytes.len() {
            let (data, kind, next) = chunk(bytes, at)?;
            if kind == *b"BIN\0" {
                return Ok(Self { json, json_start, binary: Some(data) });
            }
            at = next;
        }
        Ok(Self { json, json_start, binary: None })
    }
}

impl Container<'_> {
    /// A fault in the JSON: at its line, or in a GLB file at its byte.
    pub(super) fn json_fault(&self, line: usize, column: usize, message: String) -> Fault {
        let cause = Cause::Json(message);
        let Some(start) = self.json_start else {
            return Fault::line(line as u64, cause);
        };
        let lines_before = self.json.split_inclusive(|byte| *byte == b'\n').take(line.saturating_sub(1));
        let bytes_before: usize = lines_before.map(<[u8]>::len).sum();
        Fault::byte(start + bytes_before + column.saturating_sub(1), cause)
    }
}

/// The four bytes at `at` as a number.
fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

/// The chunk that starts at `at`: its data, its kind, and where the next one starts.
fn chunk(bytes: &[u8], at: usize) -> Result<(&[u8], [u8; 4], usize), Fault> {
    let cut = || Fault::byte(at, Cause::EndsEarly("a chunk's header"));
    let length = word(bytes, at).ok_or_else(cut)? as usize;
    let kind = word(bytes, at + 4).ok_or_else(cut)?.to_le_bytes();
    let start = at + 8;
    let data = bytes.get(start..).and_then(|rest| rest.get(..length)).ok_or_else(|| {
        let present = (bytes.len() - start) as u64;
        Fault::byte(at, Cause::PastEnd { needed: length as u64, holder: "the file".into(), present })
    })?;
    Ok((data, kind, start + length))
}

/// The bytes of one buffer.
pub(super) enum Buffer<'a> {
    Borrowed(&'a [u8]),
    Owned(Vec<u8>),
}

impl Buffer<'_> {
    pub(super) fn bytes(&self) -> &[u8] {
        match self {
            Self::Borrowed(bytes) => bytes,
            Self::Owned(bytes) => bytes,
        }
    }
}

/// Loads all buffers and checks their lengths.
pub(super) fn load_buffers<'a>(
    root: &Root,
    binary: Option<&'a [u8]>,
    folder: Option<&Path>,
) -> Result<Vec<Buffer<'a>>, Fault> {
    let load = |(number, declared): (usize, &buffer::Buffer)| {
        let fault = |cause| Fault::item(format!("buffer {number}"), cause);
        let length = declared.byte_length.0;
        let loaded = match &declared.uri {
            Some(uri) => Buffer::Owned(fetch(uri, length, folder).map_err(fault)?),
            None if number == 0 => match binary {
                Some(bytes) => Buffer::Borrowed(bytes),
                None => return Err(fault(Cause::Missing("the binary chunk"))),
            },
            None => return Err(fault(Cause::Missing("the buffer's `uri`"))),
        };
        let present = loaded.bytes().len() as u64;
        if present < length {
            return Err(fault(Cause::PastEnd { needed: length, holder: "its data".into(), present }));
        }
        Ok(loaded)
    };
    root.buffers.iter().enumerate().map(load).collect()
}

/// Reads a `data:` URI, or at most `length` bytes of a file beside the document.
fn fetch(uri: &str, length: u64, folder: Option<&Path>) -> Result<Vec<u8>, Cause> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, encoded)) = data.split_once(";base64,") else {
            let what = "a data URI that is not base64".to_owned();
            return Err(Cause::Unsupported { what, remedy: "export it with base64 buffers, or as GLB" });
        };
        return BASE64.decode(encoded).map_err(|error| Cause::Invalid(format!("its data URI is broken ({error})")));
    }
    if uri.contains("://") {
        let remedy = "download the buffer and refer to the file";
        return Err(Cause::Unsupported { what: format!("the address `{uri}`"), remedy });
    }
    let Some(folder) = folder else {
        let remedy = "read the document from its file, or say which folder it lies in";
        return Err(Cause::Unsupported { what: format!("the external buffer `{uri}`"), remedy });
    };
    let refused = |reason: String| Cause::ExternalFile { uri: uri.to_owned(), reason };
    let relative = percent_decoded(uri).ok_or_else(|| refused("its name does not decode".into()))?;
    if Path::new(&relative).is_absolute() {
        return Err(refused("its path is absolute".into()));
    }
    read_file(&folder.join(relative), length).map_err(|error| refused(error.to_string()))
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = uri.bytes();
    let mut decoded = Vec::with_capacity(uri.len());
    while let Some(byte) = bytes.next() {
        if byte == b'%' {
            let digits = [bytes.next()?, bytes.next()?];
            decoded.push(u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?);
        } else {
            decoded.push(byte);
        }
    }
    String::from_utf8(decoded).ok()
}

/// A document with its buffers.
pub(super) struct Data<'a> {
    pub(super) root: &'a Root,
    pub(super) buffers: &'a [Buffer<'a>],
    /// Bytes that unpacked values may take: what a reasonable document comes to.
    pub(super) budget: u64,
}

/// Evenly spaced elements in a buffer.
struct Span<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Data<'a> {
    /// Unpacks an accessor whose elements have `N` components each; normalised integers become fractions.
    pub(super) fn elements<const N: usize>(&self, index: Index<Accessor>, shape: Type) -> Result<Vec<[f64; N]>, Fault> {
        let name = format!("accessor {}", index.value());
        let missing = || Fault::item("the document", Cause::NoSuchItem(name.clone()));
        let accessor = self.root.accessors.get(index.value()).ok_or_else(missing)?;
        let fault = |cause| Fault::item(name.clone(), cause);
        if accessor.type_ != Checked::Valid(shape) {
            return Err(fault(Cause::Invalid(format!("its type should be {shape:?}"))));
        }
        let Checked::Valid(component) = &accessor.component_type else {
            return Err(fault(Cause::Invalid("its component type is unknown".into())));
        };
        let component = component.0;
        let count = accessor.count.0;
        let bytes = count.saturating_mul(8 * N as u64);
        if bytes > self.budget {
            return Err(fault(Cause::TooLarge { bytes }));
        }
        let count = count as usize;
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let unpack = |element: &[u8]| unpacked::<N>(element, component, accessor.normalized);
        let size = N * component.size();
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let span = self.span(view, offset, count, size).map_err(fault)?;
                (0..count).map(|k| unpack(&span.bytes[k * span.stride..])).collect()
            }
            None => vec![[0.0; N]; count],
        };
        if let Some(sparse) = &accessor.sparse {
            let replaced = sparse.count.0;
            if replaced > count as u64 {
                return Err(fault(Cause::Invalid("it replaces more values than it has".into())));
            }
            let replaced = replaced as usize;
            let Checked::Valid(kind) = &sparse.indices.component_type else {
                return Err(fault(Cause::Invalid("its sparse index type is unknown".into())));
            };
            let (at, new) = (&sparse.indices, &sparse.values);
            let at = self.span(at.buffer_view, at.byte_offset.0, replaced, kind.0.size()).map_err(fault)?;
            let new = self.span(new.buffer_view, new.byte_offset.0, replaced, size).map_err(fault)?;
            for k in 0..replaced {
                let [place] = unpacked::<1>(&at.bytes[k * at.stride..], kind.0, false);
                let value = values.get_mut(place as usize);
                let value = value.ok_or_else(|| fault(Cause::Invalid(format!("it replaces value {place}"))))?;
                *value = unpack(&new.bytes[k * new.stride..]);
            }
        }
        Ok(values)
    }

    /// The part of a buffer view that holds `count` elements of `size` bytes from `offset` on.
    fn span(&self, view: Index<buffer::View>, offset: u64, count: usize, size: usize) -> Result<Span<'a>, Cause> {
        let missing = || Cause::NoSuchItem(format!("buffer view {}", view.value()));
        let described = self.root.buffer_views.get(view.value()).ok_or_else(missing)?;
        let holder = described.buffer.value();
        let missing = || Cause::NoSuchItem(format!("buffer {holder}"));
        let bytes = self.buffers.get(holder).ok_or_else(missing)?.bytes();
        let start = described.byte_offset.map_or(0, |offset| offset.0);
        let bytes = part(bytes, start, described.byte_length.0, || format!("buffer {holder}"))?;
        let stride = described.byte_stride.as_ref().map_or(size, |stride| stride.0);
        if stride < size {
            return Err(Cause::Invalid(format!("its elements have {size} bytes but stand {stride} bytes apart")));
        }
        let needed = match count.checked_sub(1) {
            Some(steps) => (steps as u64).saturating_mul(stride as u64).saturating_add(size as u64),
            None => 0,
        };
        let bytes = part(bytes, offset, needed, || format!("buffer view {}", view.value()))?;
        Ok(Span { bytes, stride })
    }
}

/// `length` bytes from `start` on.
fn part(bytes: &[u8], start: u64, length: u64, holder: impl Fn() -> String) -> Result<&[u8], Cause> {
    let end = start.saturating_add(length);
    if end > bytes.len() as u64 {
        return Err(Cause::PastEnd { needed: end, holder: holder(), present: bytes.len() as u64 });
    }
    Ok(&bytes[start as usize..end as usize])
}

/// The `N` components at the start of `bytes`, of which there are enough.
fn unpacked<const N: usize>(bytes: &[u8], kind: ComponentType, normalized: bool) -> [f64; N] {
    let size = kind.size();
    std::array::from_fn(|k| {
        let mut raw = [0; 4];
        raw[..size].copy_from_slice(&bytes[k * size..(k + 1) * size]);
        let unsigned = u32::from_le_bytes(raw);
        let (value, largest) = match kind {
            ComponentType::I8 => (f64::from(raw[0] as i8), f64::from(i8::MAX)),
            ComponentType::U8 => (f64::from(raw[0]), f64::from(u8::MAX)),
            ComponentType::I16 => (f64::from(unsigned as u16 as i16), f64::from(i16::MAX)),
            ComponentType::U16 => (f64::from(unsigned as u16), f64::from(u16::MAX)),
            ComponentType::U32 => (f64::from(unsigned), f64::from(u32::MAX)),
            ComponentType::F32 => return f64::from(f32::from_bits(unsigned)),
        };
        if normalized { (value / largest).max(-1.0) } else { value }
    })
}

#[cfg(test)]
mod tests {
    use super::super::error::Place;
    use super::*;

    #[test]
    fn chunks_are_checked() {
        let glb = |length: u32, chunk: u32, json: &[u8]| {
            let mut bytes = b"glTF\x02\0\0\0".to_vec();
            bytes.extend(length.to_le_bytes());
            bytes.extend(chunk.to_le_bytes());
            bytes.extend(b"JSON");
            bytes.extend(json);
            bytes
        };
        assert_eq!(Container::split(&glb(22, 2, b"{}")).unwrap().json, b"{}");
        let place = |bytes: &[u8]| Container::split(bytes).err().map(|fault| fault.place);
        assert_eq!(place(&glb(23, 2, b"{}")), Some(Place::Byte(8)));
        assert_eq!(place(&glb(22, 3, b"{}")), Some(Place::Byte(12)));
        assert_eq!(place(&glb(0, 3, b"{}")), Some(Place::Byte(12)));
        assert_eq!(place(b""), Some(Place::Byte(0)));
        assert_eq!(place(b"glTF\x02\0\0\0"), Some(Place::Byte(8)));
        assert_eq!(place(b"glTF\x01\0\0\0"), Some(Place::Byte(4)));
    }

    #[test]
    fn names_are_decoded() {
        assert_eq!(percent_decoded("a%20b.bin").as_deref(), Some("a b.bin"));
        assert_eq!(percent_decoded("a%2"), None);
        assert_eq!(percent_decoded("%zz"), None);
    }

    #[test]
    fn integers_may_be_fractions() {
        assert_eq!(unpacked::<2>(&[255, 51], ComponentType::U8, true), [1.0, 0.2]);
        assert_eq!(unpacked::<2>(&[0x80, 0x7f], ComponentType::I8, true), [-1.0, 1.0]);
        assert_eq!(unpacked::<1>(&[0xff, 0xff], ComponentType::I16, false), [-1.0]);
        assert_eq!(unpacked::<1>(&[0, 0, 0x80, 0x3f], ComponentType::F32, false), [1.0]);
    }
}
