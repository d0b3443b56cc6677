//! What a document knows of its surface.

use std::fmt;
use std::path::{Component, Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::ranges;
use crate::surface::{Surface, SurfaceOptions, SurfacePoint};

/// By what a document knows its surface again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceReference {
    /// Where the mesh lies, seen from the document, with `/` between folders; none for a mesh that is in no file.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "ranges::maybe_path")]
    pub path: Option<String>,
    /// Hash of the mesh in the file's coordinates.
    pub fingerprint: Fingerprint,
    /// How many triangles it has.
    pub faces: u32,
    /// How the surface is built from them.
    #[serde(default, skip_serializing_if = "is_default")]
    pub options: SurfaceOptions,
    /// Where the surface's coordinates lie in the file's.
    #[serde(default, skip_serializing_if = "is_default")]
    pub frame: Frame,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// [`Surface::fingerprint`], as sixteen hexadecimal digits in text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Fingerprint(pub u64);

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl From<Fingerprint> for String {
    fn from(fingerprint: Fingerprint) -> Self {
        fingerprint.to_string()
    }
}

impl TryFrom<String> for Fingerprint {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let is_hex = text.len() == 16 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        let number = if is_hex { u64::from_str_radix(&text, 16).ok() } else { None };
        number.map(Self).ok_or("a fingerprint has sixteen digits from 0 to f")
    }
}

/// Where a surface's coordinates lie in those of its file: a position p of the surface is `centre + unit · p` there.
///
/// Programs that keep models at the origin and of one size say so by it. The default is no difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    /// The surface's origin, in the file's coordinates.
    #[serde(deserialize_with = "ranges::position")]
    pub centre: [f64; 3],
    /// The surface's unit of length, in the file's.
    #[serde(deserialize_with = "ranges::unit")]
    pub unit: f64,
}

impl Default for Frame {
    fn default() -> Self {
        Self { centre: [0.0; 3], unit: 1.0 }
    }
}

impl Frame {
    /// A position in the file's coordinates, as a hint: rounded to a hundred-millionth of the surface's diagonal at least, for
    /// digits make documents long.
    pub(super) fn hint(&self, surface: &Surface, point: &SurfacePoint) -> [f64; 3] {
        let position = DVec3::from_array(self.centre) + self.unit * surface.position(point);
        let digits = 9.0 - (self.unit * surface.diagonal()).log10().ceil();
        let scale = 10_f64.powi(digits as i32);
        position.to_array().map(|x| {
            let rounded = (x * scale).round() / scale + 0.0;
            if rounded.is_finite() { rounded } else { x }
        })
    }

    pub(super) fn of_file(&self, position: DVec3) -> DVec3 {
        (position - DVec3::from_array(self.centre)) / self.unit
    }
}

impl SurfaceReference {
    /// The reference of a surface that is as it is in its file.
    pub fn of(surface: &Surface) -> Self {
        Self {
            path: None,
            fingerprint: Fingerprint(surface.fingerprint()),
            faces: surface.face_count() as u32,
            options: SurfaceOptions::default(),
            frame: Frame::default(),
        }
    }

    /// The same with a path, as seen from the document.
    pub fn at(mut self, path: impl Into<String>) -> Self {
        self.path = Some(path.into());
        self
    }

    /// The same with the path of a mesh as seen from a document; none where that cannot be told in UTF-8.
    ///
    /// A mesh on another drive keeps its whole path.
    pub fn beside(mut self, document: impl AsRef<Path>, mesh: impl AsRef<Path>) -> Self {
        self.path = relative(document.as_ref(), mesh.as_ref());
        self
    }

    /// Where the mesh lies, given where the document does.
    pub fn resolve(&self, document: impl AsRef<Path>) -> Option<PathBuf> {
        Some(document.as_ref().parent().unwrap_or(Path::new("")).join(self.path.as_ref()?))
    }

    /// Whether two references mean the same triangles.
    pub fn is_same_mesh(&self, other: &Self) -> bool {
        (self.fingerprint, self.faces) == (other.fingerprint, other.faces)
    }
}

fn relative(document: &Path, mesh: &Path) -> Option<String> {
    let whole = |path: &Path| std::path::absolute(path).map(|path| std::fs::canonicalize(&path).unwrap_or(path));
    let mesh = whole(mesh).ok()?;
    let document = std::path::absolute(document).ok()?;
    let folder = whole(document.parent()?).ok()?;
    let (mut from, mut to) = (folder.components().peekable(), mesh.components().peekable());
    let mut shared = 0;
    while from.peek().is_some() && from.peek() == to.peek() {
        (shared, _, _) = (shared + 1, from.next(), to.next());
    }
    if shared == 0 {
        return mesh.to_str().map(str::to_owned);
    }
    let up = from.map(|_| Some(".."));
    let down = to.map(|part| match part {
        Component::Normal(name) => name.to_str(),
        _ => None,
    });
    Some(up.chain(down).collect::<Option<Vec<_>>>()?.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::shapes;

    #[test]
    fn paths_are_seen_from_the_document() {
        let reference =
            SurfaceReference::of(&Surface::build(&shapes::icosphere(0), &SurfaceOptions::default()).unwrap());
        for (document, mesh, path) in [
            ("/nowhere/a/x.splines.ron", "/nowhere/a/b/m.obj", "b/m.obj"),
            ("/nowhere/a/x.splines.ron", "/nowhere/m.obj", "../m.obj"),
            ("/nowhere/a/x.splines.ron", "/elsewhere/m.obj", "../../elsewhere/m.obj"),
            ("x.splines.ron", "m.obj", "m.obj"),
        ] {
            let placed = reference.clone().beside(document, mesh);
            assert_eq!(placed.path.as_deref(), Some(path));
            assert_eq!(placed.resolve(document).unwrap(), Path::new(document).parent().unwrap().join(path));
        }
    }

    #[test]
    fn fingerprints_are_sixteen_digits() {
        let text = String::from(Fingerprint(0xabc));
        assert_eq!((text.as_str(), Fingerprint::try_from(text.clone())), ("0000000000000abc", Ok(Fingerprint(0xabc))));
        for bad in ["", "abc", "0000000000000ABC", "+000000000000abc", "00000000000000abc"] {
            assert!(Fingerprint::try_from(bad.to_owned()).is_err(), "{bad}");
        }
    }
}
