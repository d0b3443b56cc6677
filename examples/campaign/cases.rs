//! Control polygons and pairs of points, as text.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// A point as written: face, and the weights of its second and third corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CasePoint {
    pub(crate) face: u32,
    pub(crate) u: f64,
    pub(crate) v: f64,
}

impl CasePoint {
    /// Weights of all three corners.
    pub(crate) fn weights(&self) -> [f64; 3] {
        [1.0 - self.u - self.v, self.u, self.v]
    }
}

/// Why a file of cases cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CasesError {
    #[error("{}: cannot be read: {error}", path.display())]
    Io { path: PathBuf, error: io::Error },
    #[error("{}:{line}: {expected} numbers expected (face, u, v a point), and {found} found", path.display())]
    Count { path: PathBuf, line: usize, expected: usize, found: usize },
    #[error("{}:{line}: {word:?} is not {expected}", path.display())]
    Word { path: PathBuf, line: usize, word: String, expected: &'static str },
}

/// The file of cases for a mesh: the file itself, or of a folder the one with the mesh's stem; none if the folder has none.
pub(crate) fn file_for(cases: &Path, mesh: &Path) -> Option<PathBuf> {
    if !cases.is_dir() {
        return Some(cases.to_owned());
    }
    let stem = mesh.file_stem()?;
    let mut files: Vec<PathBuf> = fs::read_dir(cases).ok()?.filter_map(|e| Some(e.ok()?.path())).collect();
    files.sort();
    files.into_iter().find(|f| f.is_file() && f.file_stem() == Some(stem))
}

/// Reads one group of `N` points a line; empty lines and lines that start with `#` are skipped.
///
/// # Errors
/// [`CasesError`] with the line and what is wrong with it.
pub(crate) fn read<const N: usize>(path: &Path) -> Result<Vec<[CasePoint; N]>, CasesError> {
    let text = fs::read_to_string(path).map_err(|error| CasesError::Io { path: path.to_owned(), error })?;
    parse(path, &text)
}

fn parse<const N: usize>(path: &Path, text: &str) -> Result<Vec<[CasePoint; N]>, CasesError> {
    let mut cases = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.is_empty() || words[0].starts_with('#') {
            continue;
        }
        let line = i + 1;
        if words.len() != 3 * N {
            return Err(CasesError::Count { path: path.to_owned(), line, expected: 3 * N, found: words.len() });
        }
        let mut points = [CasePoint { face: 0, u: 0.0, v: 0.0 }; N];
        for (point, words) in points.iter_mut().zip(words.chunks_exact(3)) {
            point.face = word(path, line, words[0], "a face number")?;
            point.u = word(path, line, words[1], "a number")?;
            point.v = word(path, line, words[2], "a number")?;
        }
        cases.push(points);
    }
    Ok(cases)
}

fn word<T: std::str::FromStr>(path: &Path, line: usize, word: &str, expected: &'static str) -> Result<T, CasesError> {
    word.parse().map_err(|_| CasesError::Word { path: path.to_owned(), line, word: word.to_owned(), expected })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_points() {
        let pairs = parse::<2>(Path::new("p.txt"), "# two\n\n7 0.25 0.5  8 0 1\n").unwrap();
        assert_eq!(pairs.len(), 1);
        assert_eq!(pairs[0][0], CasePoint { face: 7, u: 0.25, v: 0.5 });
        assert_eq!(pairs[0][1].weights(), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn mistakes_name_the_line() {
        let message = |text: &str| parse::<2>(Path::new("p.txt"), text).unwrap_err().to_string();
        assert_eq!(message("1 0 0 2 0 0\n1 0 0"), "p.txt:2: 6 numbers expected (face, u, v a point), and 3 found");
        assert_eq!(message("1 0 0 -2 0 0"), "p.txt:1: \"-2\" is not a face number");
        assert_eq!(message("1 x 0 2 0 0"), "p.txt:1: \"x\" is not a number");
    }
}
