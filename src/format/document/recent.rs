//! The documents that were opened or saved last.

use std::path::{Path, PathBuf};

use super::{DocumentError, ranges};
use crate::format::{regular, save};

/// The documents that were opened or saved last, the last one first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recent {
    paths: Vec<PathBuf>,
}

#[derive(serde::Serialize, serde::Deserialize)]
struct Paths(#[serde(deserialize_with = "ranges::list::<_, _, 1_000>")] Vec<PathBuf>);

impl Recent {
    /// How many are remembered.
    pub const MOST: usize = 12;

    /// Reads the list from a file; empty where there is none that can be read, for nothing depends on it.
    pub fn load(path: impl AsRef<Path>) -> Self {
        const LONGEST: u64 = 1 << 20;
        let path = path.as_ref();
        save::remove_leftovers(path);
        let read = || {
            let bytes = regular::read_file(path, LONGEST).ok()?;
            let Paths(mut paths) = ron::de::from_bytes(&bytes).ok()?;
            paths.truncate(Self::MOST);
            Some(paths)
        };
        Self { paths: read().unwrap_or_default() }
    }

    /// Writes the list to a file. Paths that are not UTF-8 are left out.
    ///
    /// # Errors
    /// [`DocumentError::Save`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), DocumentError> {
        let paths = Paths(self.paths.iter().filter(|path| path.to_str().is_some()).cloned().collect());
        Ok(save::replace_file(path, |file| {
            let text = ron::ser::to_string_pretty(&paths, ron::ser::PrettyConfig::new().new_line("\n"));
            file.write_all(text.map_err(std::io::Error::other)?.as_bytes())
        })?)
    }

    /// The paths, the last one first.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// Puts a document in front.
    pub fn note(&mut self, document: impl AsRef<Path>) {
        let path = document.as_ref();
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.paths.retain(|other| *other != path);
        self.paths.insert(0, path);
        self.paths.truncate(Self::MOST);
    }

    /// Removes a document, because it is not there any more, say.
    pub fn forget(&mut self, document: impl AsRef<Path>) {
        let path = document.as_ref();
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.paths.retain(|other| *other != path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_one_is_first() {
        let file = std::env::temp_dir().join(format!("surface_splines_recent_{}", std::process::id()));
        assert_eq!(Recent::load(&file), Recent::default());
        let mut recent = Recent::default();
        for i in 0..20 {
            recent.note(format!("/a/\"{i}\".splines.ron"));
        }
        recent.note("/a/\"15\".splines.ron");
        recent.note("b");
        recent.forget("/a/\"19\".splines.ron");
        assert_eq!(recent.paths().len(), Recent::MOST - 1);
        assert_eq!(recent.paths()[1], Path::new("/a/\"15\".splines.ron"));
        assert!(recent.paths()[0].is_absolute());
        recent.save(&file).unwrap();
        assert_eq!(Recent::load(&file), recent);
        std::fs::write(&file, "[\"a\", ").unwrap();
        assert_eq!(Recent::load(&file), Recent::default());
        std::fs::remove_file(file).unwrap();
    }
}
