//! Autosaves: a copy of what is not saved yet, and finding it again after a crash.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::{Document, DocumentError};
use crate::format::save;

/// Where the unsaved state of a document is kept.
///
/// A program writes it now and then while there are unsaved edits, [`discard`](Self::discard)s it when the document is saved or
/// closed on purpose, and asks for [`recovery`](Self::recovery) when it opens the document. After a crash there is one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Autosave {
    path: PathBuf,
    document: Option<PathBuf>,
}

/// An autosave that is newer than its document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recovery {
    /// The file, a whole document.
    pub path: PathBuf,
    /// When it was written, if the system tells.
    pub saved: Option<SystemTime>,
}

impl Autosave {
    /// Beside a document, in a hidden file.
    pub fn beside(document: impl AsRef<Path>) -> Self {
        let document = document.as_ref();
        Self { path: save::renamed(document, ".", ".autosave"), document: Some(document.to_owned()) }
    }

    /// In a folder of the caller's choice, for a document at some place, or for one that has no file yet.
    pub fn in_folder(folder: impl AsRef<Path>, document: Option<&Path>) -> Self {
        let Some(document) = document else {
            return Self { path: folder.as_ref().join("untitled.autosave"), document: None };
        };
        // Documents of one name may lie in several folders.
        let whole = fs::canonicalize(document).or_else(|_| std::path::absolute(document));
        let hash = save::fnv(whole.as_deref().unwrap_or(document).as_os_str().as_encoded_bytes());
        let name = save::renamed(document, "", &format!(".{hash:016x}.autosave"));
        let path = folder.as_ref().join(name.file_name().unwrap_or_default());
        Self { path, document: Some(document.to_owned()) }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Keeps the state of a document.
    ///
    /// The path of its mesh stays as seen from the document's own place.
    ///
    /// # Errors
    /// As [`Document::save`].
    pub fn save(&self, document: &Document) -> Result<(), DocumentError> {
        document.save(&self.path)
    }

    /// Removes what was kept; nothing if nothing was.
    ///
    /// # Errors
    /// What the file system says.
    pub fn discard(&self) -> io::Result<()> {
        save::remove_leftovers(&self.path);
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    /// What there is to recover: an autosave that is not older than its document, and says something else.
    pub fn recovery(&self) -> Option<Recovery> {
        let kept = fs::metadata(&self.path).ok().filter(fs::Metadata::is_file)?;
        let saved = kept.modified().ok();
        let found = Recovery { path: self.path.clone(), saved };
        let Some((document, state)) = self.document.as_ref().and_then(|path| Some((path, fs::metadata(path).ok()?)))
        else {
            return Some(found);
        };
        let is_older = saved.zip(state.modified().ok()).is_some_and(|(kept, document)| kept < document);
        let is_same = kept.len() == state.len() && fs::read(&self.path).ok() == fs::read(document).ok();
        (!is_older && !is_same).then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::document::SurfaceReference;
    use crate::surface::{Surface, SurfaceOptions, shapes};
    use std::time::Duration;

    #[test]
    fn what_is_newer_is_recovered() {
        let folder = std::env::temp_dir().join(format!("surface_splines_recovery_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.splines.ron");
        let surface = Surface::build(&shapes::icosphere(0), &SurfaceOptions::default()).unwrap();
        let old = Document::new(SurfaceReference::of(&surface));
        let new = Document::new(SurfaceReference::of(&surface).at("mesh.obj"));
        for autosave in [Autosave::beside(&path), Autosave::in_folder(&folder, Some(&path))] {
            old.save(&path).unwrap();
            assert_eq!(autosave.recovery(), None);
            autosave.save(&old).unwrap();
            assert_eq!(autosave.recovery(), None, "the same state");
            autosave.save(&new).unwrap();
            let found = autosave.recovery().expect("a recovery");
            assert_eq!(Document::open(&found.path).unwrap(), new);
            // A document that was saved later, by a program without autosaves.
            let later = SystemTime::now() + Duration::from_secs(60);
            fs::File::options().write(true).open(&path).unwrap().set_modified(later).unwrap();
            assert_eq!(autosave.recovery(), None);
            fs::remove_file(&path).unwrap();
            assert!(autosave.recovery().is_some(), "the document is gone");
            autosave.discard().unwrap();
            autosave.discard().unwrap();
            assert_eq!((autosave.recovery(), fs::read_dir(&folder).unwrap().count()), (None, 0));
        }
        let untitled = Autosave::in_folder(&folder, None);
        assert_eq!(untitled.recovery(), None);
        untitled.save(&new).unwrap();
        assert_eq!(untitled.recovery().map(|r| r.path), Some(untitled.path().to_owned()));
        let others = ["a.splines.ron", "b/a.splines.ron"].map(|p| Autosave::in_folder(&folder, Some(Path::new(p))));
        assert_ne!(others[0], others[1]);
        fs::remove_dir_all(folder).unwrap();
    }
}
