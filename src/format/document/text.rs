//! Between documents and RON.

use ron::extensions::Extensions;
use ron::ser::PrettyConfig;

use super::{Document, DocumentError};

/// Longer documents are neither read nor written: their splines would take gigabytes.
pub(super) const MAX_BYTES: u64 = 1 << 28;
/// Types of a document are nested less deeply.
const DEEPEST: usize = 32;
/// Down to the fields of an anchor everything has a line of its own.
const INDENTED: usize = 5;

impl Document {
    /// The document as RON: the same text for the same document.
    ///
    /// # Errors
    /// [`DocumentError`] if a value is out of its range, so that the text could not be read again.
    pub fn to_ron(&self) -> Result<String, DocumentError> {
        let style = PrettyConfig::new().depth_limit(INDENTED).new_line("\n").indentor("  ");
        let text = ron::Options::default().to_string_pretty(self, style);
        let mut text = text.map_err(|error| DocumentError::Content {
            line: 1,
            column: 1,
            field: "the document".to_owned(),
            problem: error.to_string(),
        })?;
        text.push('\n');
        // What cannot be read again must not take the place of what can.
        Self::from_bytes(text.as_bytes())?;
        Ok(text)
    }

    /// Reads a document from RON.
    ///
    /// # Errors
    /// [`DocumentError`] naming line, column and field where the text breaks the format or a value is out of its range, or
    /// the version where that is newer than [`VERSION`](Self::VERSION).
    pub fn from_ron(text: &str) -> Result<Self, DocumentError> {
        if text.len() as u64 > MAX_BYTES {
            return Err(DocumentError::TooLarge { limit: MAX_BYTES });
        }
        match version_of(text) {
            Ok(version) if version > u64::from(Self::VERSION) => {
                return Err(DocumentError::NewerVersion { found: version });
            }
            Ok(version) if version > 0 => {}
            Ok(_) | Err(0) => return Err(no_document(text, 0)),
            Err(at) => return Err(no_document(text, at)),
        }
        let options =
            ron::Options::default().with_recursion_limit(DEEPEST).without_default_extension(Extensions::all());
        let failed = |error: ron::error::SpannedError, field: String| DocumentError::Content {
            line: error.span.end.line,
            column: error.span.end.col,
            field: if field == "." { "the document".to_owned() } else { field },
            problem: error.code.to_string(),
        };
        let mut ron =
            ron::Deserializer::from_str_with_options(text, &options).map_err(|error| failed(error, ".".to_owned()))?;
        let read = serde_path_to_error::deserialize(&mut ron);
        let document: Self = read.map_err(|error| {
            let field = error.path().to_string();
            failed(ron.span_error(error.into_inner()), field)
        })?;
        ron.end().map_err(|error| failed(ron.span_error(error), ".".to_owned()))?;
        Ok(document)
    }

    /// Reads a document from the bytes of a file.
    ///
    /// # Errors
    /// As [`from_ron`](Self::from_ron), and where the bytes are not UTF-8.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, DocumentError> {
        if bytes.len() as u64 > MAX_BYTES {
            return Err(DocumentError::TooLarge { limit: MAX_BYTES });
        }
        match std::str::from_utf8(bytes) {
            Ok(text) => Self::from_ron(text.strip_prefix('\u{feff}').unwrap_or(text)),
            Err(error) => {
                let sound = String::from_utf8_lossy(bytes.get(..error.valid_up_to()).unwrap_or_default());
                let (line, column) = place(&sound, sound.len());
                let (field, problem) = ("the document".to_owned(), "a byte here is not UTF-8".to_owned());
                Err(DocumentError::Content { line, column, field, problem })
            }
        }
    }
}

fn no_document(text: &str, at: usize) -> DocumentError {
    let (line, column) = place(text, at);
    DocumentError::NoDocument { line, column }
}

/// Line and column of a byte.
pub(crate) fn place(text: &str, at: usize) -> (usize, usize) {
    let before = text.get(..at).unwrap_or_default();
    let line = before.lines().count() - usize::from(!before.is_empty() && !before.ends_with('\n'));
    (line + 1, before.rsplit('\n').next().unwrap_or_default().chars().count() + 1)
}

/// The version number in front of a document, whatever comes after it; else the byte where it should stand.
///
/// Read by hand, for nobody knows what a newer version looks like.
pub(crate) fn version_of(text: &str) -> Result<u64, usize> {
    let mut rest = text;
    for word in ["(", "version", ":"] {
        rest = without_space(rest);
        rest = rest.strip_prefix(word).ok_or(text.len() - rest.len())?;
    }
    rest = without_space(rest);
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let number = rest.get(..digits).filter(|digits| !digits.is_empty()).ok_or(text.len() - rest.len())?;
    Ok(number.parse().unwrap_or(u64::MAX))
}

/// Without the blanks and comments in front.
fn without_space(text: &str) -> &str {
    let mut rest = text;
    loop {
        rest = rest.trim_start();
        let end = if rest.starts_with("//") {
            rest.find('\n')
        } else if rest.starts_with("/*") {
            rest.find("*/").map(|at| at + 2)
        } else {
            None
        };
        match end.and_then(|end| rest.get(end..)) {
            Some(after) => rest = after,
            None => return rest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_found_in_front() {
        assert_eq!(version_of("(version:1,"), Ok(1));
        assert_eq!(version_of("// hi\n /* ( */ ( // x\n version /**/ : 12)"), Ok(12));
        assert_eq!(version_of("(version: 99999999999999999999999, future: <>)"), Ok(u64::MAX));
        assert_eq!(version_of("(vers"), Err(1));
        assert_eq!(version_of(""), Err(0));
        assert_eq!(version_of("(version: x"), Err(10));
        assert_eq!(version_of("/*"), Err(0));
    }

    #[test]
    fn places_are_counted_from_one() {
        assert_eq!(place("", 0), (1, 1));
        assert_eq!(place("ab\ncä", 2), (1, 3));
        assert_eq!(place("ab\ncä", 3), (2, 1));
        assert_eq!(place("ab\ncä", 6), (2, 3));
    }
}
