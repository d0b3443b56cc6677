//! Which format a file has, and reading it.

use std::fmt;
use std::path::Path;

use super::error::{Fault, FormatError};
use super::regular::read_file;
use super::{gltf, obj, off, ply, stl, text};
use crate::surface::TriangleMesh;

/// A format of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// Stereolithography, text or binary.
    Stl,
    /// Stanford PLY, text or binary.
    Ply,
    /// Object File Format.
    Off,
    /// glTF 2.0 as JSON.
    Gltf,
    /// glTF 2.0 as one binary file.
    Glb,
}

impl MeshFormat {
    /// The format that a file's extension names, in any case.
    pub fn from_extension(path: impl AsRef<Path>) -> Option<Self> {
        let extension = path.as_ref().extension()?.to_str()?.to_ascii_lowercase();
        Some(match extension.as_str() {
            "obj" => Self::Obj,
            "stl" => Self::Stl,
            "ply" => Self::Ply,
            "off" => Self::Off,
            "gltf" => Self::Gltf,
            "glb" => Self::Glb,
            _ => return None,
        })
    }

    /// The format that a file's content looks like.
    pub fn from_content(bytes: &[u8]) -> Option<Self> {
        const ENOUGH: usize = 4096;
        if bytes.starts_with(b"glTF") {
            return Some(Self::Glb);
        }
        let start = text::decoded(&bytes[..bytes.len().min(ENOUGH)]);
        let mut words = text::Text::new(&start).with_comments();
        match words.word_anywhere() {
            Some(b"ply") => Some(Self::Ply),
            Some(word) if word.starts_with(b"{") => Some(Self::Gltf),
            Some(word) if word.len() <= 7 && word.ends_with(b"OFF") => Some(Self::Off),
            _ if stl::is_text(&start) || stl::is_binary_of_exact_size(bytes) => Some(Self::Stl),
            Some(b"v" | b"vn" | b"vt" | b"o" | b"g" | b"s" | b"mtllib" | b"usemtl") => Some(Self::Obj),
            _ => None,
        }
    }
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Obj => "OBJ",
            Self::Stl => "STL",
            Self::Ply => "PLY",
            Self::Off => "OFF",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
        })
    }
}

/// Reads a mesh file.
///
/// The extension tells the format, or the content where the extension tells none. Buffers of a glTF document that lie in
/// other files are read from beside it. Takes the file's size in memory and the mesh on top of it.
///
/// # Errors
/// [`FormatError::Io`] if the file cannot be read or is not a regular file, [`FormatError::UnknownFormat`], and
/// [`FormatError::Content`] as for [`parse_mesh`].
///
/// ```
/// use bevy_surface_splines::format::read_mesh;
///
/// let path = std::env::temp_dir().join("read_mesh_doctest.obj");
/// std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")?;
/// let mesh = read_mesh(&path)?;
/// assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3]]);
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_mesh(path: impl AsRef<Path>) -> Result<TriangleMesh, FormatError> {
    let path = path.as_ref();
    let (bytes, format) = file_of_known_format(path)?;
    parse(&bytes, format, path.parent())
}

/// The bytes of a file and its format.
pub(super) fn file_of_known_format(path: &Path) -> Result<(Vec<u8>, MeshFormat), FormatError> {
    let bytes = read_file(path, u64::MAX).map_err(|source| FormatError::Io { path: path.to_owned(), source })?;
    let format = MeshFormat::from_extension(path).or_else(|| MeshFormat::from_content(&bytes));
    let format = format.ok_or_else(|| FormatError::UnknownFormat { path: path.to_owned() })?;
    Ok((bytes, format))
}

/// Reads a mesh from the bytes of a file.
///
/// Of a glTF document only embedded buffers are read; for others use [`parse_mesh_beside`] or [`read_mesh`].
///
/// # Errors
/// [`FormatError::Content`] naming the line, byte or item where the bytes break the format or use something unsupported.
///
/// ```
/// use bevy_surface_splines::format::{MeshFormat, Place, parse_mesh};
///
/// let mesh = parse_mesh(b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", MeshFormat::Off)?;
/// assert_eq!(mesh.positions.len(), 3);
///
/// let error = parse_mesh(b"v 0 0 0\nf 1 2 3\n", MeshFormat::Obj).unwrap_err();
/// assert_eq!(error.place(), Some(&Place::Line(2)));
/// # Ok::<(), bevy_surface_splines::format::FormatError>(())
/// ```
pub fn parse_mesh(bytes: &[u8], format: MeshFormat) -> Result<TriangleMesh, FormatError> {
    parse(bytes, format, None)
}

/// Reads a mesh from the bytes of a file, and the buffers of a glTF document from files in `folder`.
///
/// # Errors
/// As [`parse_mesh`].
pub fn parse_mesh_beside(
    bytes: &[u8],
    format: MeshFormat,
    folder: impl AsRef<Path>,
) -> Result<TriangleMesh, FormatError> {
    parse(bytes, format, Some(folder.as_ref()))
}

fn parse(bytes: &[u8], format: MeshFormat, folder: Option<&Path>) -> Result<TriangleMesh, FormatError> {
    let mesh = match format {
        MeshFormat::Obj => obj::parse(bytes),
        MeshFormat::Stl => stl::parse(bytes),
        MeshFormat::Ply => ply::parse(bytes),
        MeshFormat::Off => off::parse(bytes),
        MeshFormat::Gltf => gltf::parse_json(bytes, folder),
        MeshFormat::Glb => gltf::parse_glb(bytes, folder),
    };
    mesh.map_err(|fault: Fault| fault.in_format(format))
}

impl crate::surface::Surface {
    /// Reads a mesh file and builds a surface from it with default options; [`report`](Self::report) says what was found
    /// and repaired.
    ///
    /// # Errors
    /// [`LoadError`]: the file cannot be read, or its faces make no surface.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        Ok(Self::build(&read_mesh(path)?, &crate::surface::SurfaceOptions::default())?)
    }
}

/// Why a file did not become a surface.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file cannot be read.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Its faces make no surface.
    #[error(transparent)]
    Surface(#[from] crate::surface::SurfaceError),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_and_contents_tell_the_format() {
        assert_eq!(MeshFormat::from_extension("a/b.OBJ"), Some(MeshFormat::Obj));
        assert_eq!(MeshFormat::from_extension("a.obj/b"), None);
        let content = |bytes: &[u8]| MeshFormat::from_content(bytes);
        assert_eq!(content(b"ply\nformat"), Some(MeshFormat::Ply));
        assert_eq!(content(b"glTF\x02\0\0\0"), Some(MeshFormat::Glb));
        assert_eq!(content(b" {\"asset\""), Some(MeshFormat::Gltf));
        assert_eq!(content(b"# x\nCOFF\n"), Some(MeshFormat::Off));
        assert_eq!(content(b"solid x\n"), Some(MeshFormat::Stl));
        assert_eq!(content(&[0; 84]), Some(MeshFormat::Stl));
        assert_eq!(content(b"# x\nv 0 0 0\n"), Some(MeshFormat::Obj));
        assert_eq!(content(b"prose"), None);
        assert_eq!(content(b""), None);
    }

    #[test]
    fn missing_files_and_folders_are_named() {
        let error = read_mesh("no/such/file.obj").unwrap_err();
        assert!(error.to_string().starts_with("no/such/file.obj: "), "{error}");
        assert!(matches!(read_mesh(std::env::temp_dir()), Err(FormatError::Io { .. })));
    }
}
