//! Files that are replaced as a whole: whoever looks sees the old file or the new one, complete.
//!
//! What is to be written goes to a new file in the same folder, is flushed to the disk, and takes the old file's name. The new
//! file is locked while it is written. A process that dies loses its locks, so the next one that saves or opens under the
//! same name knows what is left over, and removes it.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// How names of files end that are being written.
const ENDING: &str = ".being-saved";
/// How often a name, or a file that somebody removed, is tried anew.
const TRIES: u32 = 16;

/// Why a file could not be saved; the old one is as it was.
#[derive(Debug, thiserror::Error)]
#[error("{} was not saved, {step}: {source}: {}", path.display(), remedy(source))]
pub struct SaveError {
    /// The file.
    pub path: PathBuf,
    /// What could not be done.
    pub step: SaveStep,
    /// What the system says.
    pub source: io::Error,
}

/// A step of saving a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum SaveStep {
    /// Making a new file in the folder.
    #[error("a new file cannot be made in its folder")]
    Create,
    /// Filling it.
    #[error("the new file cannot be written")]
    Write,
    /// Giving it the name of the old one.
    #[error("the new file cannot take its place")]
    Replace,
}

fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
            "make room, or save elsewhere"
        }
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => "save where you may write",
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => "make the folder, or save elsewhere",
        io::ErrorKind::IsADirectory => "a folder has this name, choose another",
        _ => "save elsewhere",
    }
}

/// Replaces a file by what `write` writes, or makes it; all or nothing.
///
/// A link is followed, and permissions are kept. `write` may be called anew if another process removes the file that is being
/// written. Files that dead processes left behind under the same name are removed first, see [`remove_leftovers`].
///
/// # Errors
/// [`SaveError`]; the old file is then as it was, and no other is left.
///
/// ```
/// use bevy_surface_splines::format::save::replace_file;
///
/// let path = std::env::temp_dir().join("replace_file_doctest.txt");
/// replace_file(&path, |file| file.write_all(b"old"))?;
/// let error = replace_file(&path, |file| {
///     file.write_all(b"ne")?;
///     Err(std::io::ErrorKind::StorageFull.into())
/// });
/// assert!(error.is_err());
/// assert_eq!(std::fs::read(&path)?, b"old");
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn replace_file(
    path: impl AsRef<Path>,
    mut write: impl FnMut(&mut dyn Write) -> io::Result<()>,
) -> Result<(), SaveError> {
    let asked = path.as_ref();
    // The file that a link leads to is to be replaced, not the link.
    let path = fs::canonicalize(asked).unwrap_or_else(|_| asked.to_owned());
    let fail = |step| move |source| SaveError { path: asked.to_owned(), step, source };
    let names = Names::of(&path).map_err(fail(SaveStep::Create))?;
    let old = fs::metadata(&path).ok();
    if old.as_ref().is_some_and(fs::Metadata::is_dir) {
        return Err(fail(SaveStep::Replace)(io::ErrorKind::IsADirectory.into()));
    }
    names.remove_leftovers();
    let mut tries = 0;
    loop {
        tries += 1;
        let mut new = names.create().map_err(fail(SaveStep::Create))?;
        if let Some(old) = &old {
            // Permissions that cannot be kept are no reason not to save.
            let _ = new.file.set_permissions(old.permissions());
        }
        new.fill(&mut write).map_err(fail(SaveStep::Write))?;
        match fs::rename(&new.path, &path) {
            Ok(()) => {
                new.done = true;
                sync_folder(&names.folder);
                return Ok(());
            }
            // Another process took it for left over, in the moment before it was locked.
            Err(error) if error.kind() == io::ErrorKind::NotFound && tries < TRIES && names.folder.is_dir() => {}
            Err(error) => return Err(fail(SaveStep::Replace)(error)),
        }
    }
}

/// Removes what processes that died while saving this file have left beside it; tells how many files that were.
///
/// Only files are touched that have the name which [`replace_file`] gives, and that no process has locked.
pub fn remove_leftovers(path: impl AsRef<Path>) -> usize {
    let path = path.as_ref();
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    Names::of(&path).map_or(0, |names| names.remove_leftovers())
}

/// Names of files that are to become a certain file.
struct Names {
    folder: PathBuf,
    begin: String,
}

impl Names {
    fn of(path: &Path) -> io::Result<Self> {
        let name = path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "it names no file"))?;
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder.to_owned(),
            _ => PathBuf::from("."),
        };
        Ok(Self { folder, begin: beginning(name) })
    }

    /// Makes a new file that is locked, if the file system knows locks.
    fn create(&self) -> io::Result<NewFile> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let mut last = io::ErrorKind::AlreadyExists.into();
        for _ in 0..TRIES {
            let number = NEXT.fetch_add(1, Ordering::Relaxed);
            let name = format!("{}{}-{number}{ENDING}", self.begin, std::process::id());
            let path = self.folder.join(name);
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => {
                    let taken = matches!(file.try_lock(), Err(TryLockError::WouldBlock));
                    let new = NewFile { file, path, done: false };
                    if !taken {
                        return Ok(new);
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
                Err(error) => return Err(error),
            }
        }
        Err(last)
    }

    fn remove_leftovers(&self) -> usize {
        let Ok(entries) = fs::read_dir(&self.folder) else { return 0 };
        let ours = entries.flatten().filter(|entry| self.is_ours(&entry.file_name()));
        ours.filter(|entry| entry.file_type().is_ok_and(|t| t.is_file()) && remove_unlocked(&entry.path())).count()
    }

    /// Whether a name is one that [`create`](Self::create) gives: beginning, process, number, ending.
    fn is_ours(&self, name: &OsStr) -> bool {
        let numbers = name.to_str().and_then(|name| name.strip_prefix(&self.begin)?.strip_suffix(ENDING));
        let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        numbers.and_then(|text| text.split_once('-')).is_some_and(|(a, b)| is_number(a) && is_number(b))
    }
}

/// A dot, the name (shortened, for names must not become too long) and a hash of it.
fn beginning(name: &OsStr) -> String {
    const LONGEST: usize = 100;
    let text = name.to_string_lossy();
    let mut end = text.len().min(LONGEST);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let hash = fnv(name.as_encoded_bytes());
    format!(".{}.{hash:016x}.", &text[..end])
}

/// The hash of Fowler, Noll and Vo, variant 1a: the same in every process.
pub(super) fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, b| (hash ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}

/// Removes a file that no process has locked.
fn remove_unlocked(path: &Path) -> bool {
    let Ok(file) = OpenOptions::new().write(true).open(path) else { return false };
    file.try_lock().is_ok() && fs::remove_file(path).is_ok()
}

/// A file that is being written; removed unless it is done.
struct NewFile {
    file: File,
    path: PathBuf,
    done: bool,
}

impl NewFile {
    fn fill(&mut self, write: &mut impl FnMut(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
        let mut buffered = io::BufWriter::new(&self.file);
        write(&mut buffered)?;
        buffered.flush()?;
        drop(buffered);
        self.file.sync_all()
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        if !self.done {
            let _ = fs::remove_file(&self.path); // a dead process would leave it too; the next one removes it
        }
    }
}

/// Lets the new name reach the disk, where folders can be flushed.
fn sync_folder(folder: &Path) {
    #[cfg(unix)]
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all(); // not every file system can; the file itself is safe
    }
    #[cfg(not(unix))]
    let _ = folder;
}

/// A path with something put before and behind the file's name.
#[cfg(feature = "document")]
pub(super) fn renamed(path: &Path, before: &str, behind: &str) -> PathBuf {
    let mut name = std::ffi::OsString::from(before);
    name.push(path.file_name().unwrap_or_default());
    name.push(behind);
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("surface_splines_save_{name}_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn listed(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn leftovers_go_and_foreign_files_stay() {
        let folder = folder("leftovers");
        let path = folder.join("a.ron");
        let begin = beginning(OsStr::new("a.ron"));
        let other = beginning(OsStr::new("b.ron"));
        let kept = [
            format!("{begin}12-{ENDING}"),
            format!("{begin}12-3x{ENDING}"),
            format!("{begin}12-3{ENDING}~"),
            format!("{other}12-3{ENDING}"),
            "a.ron.being-saved".to_owned(),
        ];
        kept.iter().for_each(|name| fs::write(folder.join(name), "kept").unwrap());
        let litter = format!("{begin}12-3{ENDING}");
        fs::write(folder.join(&litter), "litter").unwrap();
        let held = folder.join(format!("{begin}12-4{ENDING}"));
        let holder = File::create(&held).unwrap();
        holder.lock().unwrap();
        assert_eq!(remove_leftovers(&path), 1);
        assert!(!folder.join(litter).exists() && held.exists());
        drop(holder);
        replace_file(&path, |file| file.write_all(b"new")).unwrap();
        let mut expected = kept.to_vec();
        expected.push("a.ron".to_owned());
        expected.sort();
        assert_eq!(listed(&folder), expected);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn nothing_is_left_of_what_fails() {
        let folder = folder("failures");
        let path = folder.join("a.ron");
        replace_file(&path, |file| file.write_all(b"old")).unwrap();
        let error = replace_file(&path, |file| {
            file.write_all(&[0; 100_000])?;
            Err(io::ErrorKind::StorageFull.into())
        })
        .unwrap_err();
        assert_eq!(error.step, SaveStep::Write);
        assert!(error.to_string().contains("make room"), "{error}");
        assert_eq!((fs::read(&path).unwrap(), listed(&folder)), (b"old".to_vec(), vec!["a.ron".to_owned()]));
        // A file in the place of the folder, a folder in the place of the file, no folder, no name.
        for (path, step) in [
            (path.join("b.ron"), SaveStep::Create),
            (folder.clone(), SaveStep::Replace),
            (folder.join("missing/b.ron"), SaveStep::Create),
            (PathBuf::from("/"), SaveStep::Create),
            (PathBuf::new(), SaveStep::Create),
        ] {
            let error = replace_file(&path, |file| file.write_all(b"new")).unwrap_err();
            assert_eq!(error.step, step, "{error}");
        }
        assert_eq!(listed(&folder), ["a.ron"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn long_names_and_odd_ones() {
        let folder = folder("names");
        for name in ["ä".repeat(110), "x".repeat(200), " .a b\n".to_owned()] {
            let path = folder.join(name);
            replace_file(&path, |file| file.write_all(b"1")).unwrap();
            assert_eq!(fs::read(path).unwrap(), b"1");
        }
        assert_eq!(listed(&folder).len(), 3);
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_are_kept() {
        use std::os::unix::fs::PermissionsExt;
        let folder = folder("links");
        let (path, link) = (folder.join("a.ron"), folder.join("link.ron"));
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        replace_file(&link, |file| file.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
        fs::remove_dir_all(folder).unwrap();
    }
}
