//! Walking a text file by lines and words, without copying it.

use std::borrow::Cow;

use super::error::{Cause, Fault, shown};

/// A cursor over text that knows its line.
///
/// Lines end with LF, CR LF or a lone CR. Words are parted by anything up to a blank.
pub(super) struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    /// `#` at the start of a word begins a comment.
    comments: bool,
    /// A backslash at the end of a line joins it with the next.
    continued: bool,
}

impl<'a> Text<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, line: 1, comments: false, continued: false }
    }

    pub(super) fn with_comments(self) -> Self {
        Self { comments: true, ..self }
    }

    pub(super) fn with_continuations(self) -> Self {
        Self { continued: true, ..self }
    }

    /// Calls the first line `line`.
    pub(super) fn starting_at(self, line: u64) -> Self {
        Self { line, ..self }
    }

    /// The current line, counted from one.
    pub(super) fn line(&self) -> u64 {
        self.line
    }

    /// Bytes not yet read.
    pub(super) fn room(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Bytes read.
    pub(super) fn offset(&self) -> usize {
        self.at
    }

    /// Goes to the next word, over empty lines and comments; false at the end of the file.
    pub(super) fn seek_word(&mut self) -> bool {
        while !self.at_word() {
            if !self.next_line() {
                return false;
            }
        }
        true
    }

    /// Whether this line has another word; goes to its start.
    #[inline]
    pub(super) fn at_word(&mut self) -> bool {
        loop {
            match self.bytes.get(self.at) {
                None | Some(b'\n') => return false,
                Some(b'\r') if self.bytes.get(self.at + 1) != Some(&b'\n') => return false,
                Some(b'#') if self.comments => return false,
                Some(b'\\') if self.continued && self.joins_next_line() => self.break_line(self.at + 1),
                Some(0..=b' ') => self.at += 1,
                Some(_) => return true,
            }
        }
    }

    /// The next word on this line, or `None` at its end.
    #[inline]
    pub(super) fn word(&mut self) -> Option<&'a [u8]> {
        if !self.at_word() {
            return None;
        }
        let start = self.at;
        while let Some(byte) = self.bytes.get(self.at) {
            if *byte <= b' ' || (*byte == b'\\' && self.continued && self.joins_next_line()) {
                break;
            }
            self.at += 1;
        }
        Some(&self.bytes[start..self.at])
    }

    /// Goes to the start of the next line; false at the end of the file.
    pub(super) fn next_line(&mut self) -> bool {
        while let Some(byte) = self.bytes.get(self.at) {
            match byte {
                b'\n' | b'\r' => {
                    self.break_line(self.at);
                    return self.at < self.bytes.len();
                }
                b'#' if self.comments => self.skip_comment(),
                b'\\' if self.continued && self.joins_next_line() => self.break_line(self.at + 1),
                _ => self.at += 1,
            }
        }
        false
    }

    /// The next word on this or a later line, or `None` at the end of the file.
    pub(super) fn word_anywhere(&mut self) -> Option<&'a [u8]> {
        if self.seek_word() { self.word() } else { None }
    }

    /// The next word on this line as a number.
    #[inline]
    pub(super) fn number(&mut self, what: &'static str) -> Result<f64, Fault> {
        let word = self.word().ok_or_else(|| Fault::line(self.line, Cause::Missing(what)))?;
        number(word).ok_or_else(|| self.unexpected(what, word))
    }

    /// The next word on this line as a whole number that is not negative.
    pub(super) fn count(&mut self, what: &'static str) -> Result<u64, Fault> {
        let word = self.word().ok_or_else(|| Fault::line(self.line, Cause::Missing(what)))?;
        integer(word).and_then(|n| u64::try_from(n).ok()).ok_or_else(|| self.unexpected(what, word))
    }

    /// The fault that `found` stands here instead of `expected`.
    pub(super) fn unexpected(&self, expected: &'static str, found: &[u8]) -> Fault {
        Fault::line(self.line, Cause::Unexpected { expected, found: shown(found) })
    }

    /// A comment runs to the end of the line; a `#` inside a word is not one, but then the rest of the line is skipped
    /// as well.
    fn skip_comment(&mut self) {
        while self.bytes.get(self.at).is_some_and(|byte| !matches!(byte, b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    /// Whether the backslash here is the last thing on its line.
    fn joins_next_line(&self) -> bool {
        matches!(self.bytes.get(self.at + 1), Some(b'\n' | b'\r'))
    }

    /// Steps over the line end at `end`.
    fn break_line(&mut self, end: usize) {
        let two = self.bytes[end..].starts_with(b"\r\n");
        self.at = end + 1 + usize::from(two);
        self.line += 1;
    }
}

/// A decimal number, `inf` or `nan` in any case, or the texts that Microsoft's library writes for them.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    text.parse().ok().or_else(|| microsoft_number(text))
}

/// `1.#INF`, `-1.#IND00`, `1.#QNAN`, `-nan(ind)` and the like.
fn microsoft_number(text: &str) -> Option<f64> {
    let (sign, rest) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let upper = rest.to_ascii_uppercase();
    if upper.starts_with("1.#INF") {
        return Some(sign * f64::INFINITY);
    }
    ["1.#IND", "1.#QNAN", "1.#SNAN", "1.#NAN", "NAN("].iter().any(|nan| upper.starts_with(nan)).then_some(f64::NAN)
}

/// A whole decimal number; `None` also if it does not fit.
pub(super) fn integer(word: &[u8]) -> Option<i64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The text without its byte-order mark, as UTF-8 where that mark says UTF-16.
pub(super) fn decoded(bytes: &[u8]) -> Cow<'_, [u8]> {
    let utf16 = |rest: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = rest.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        let text: String = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
        Cow::Owned(text.into_bytes())
    };
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(rest),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        _ => Cow::Borrowed(bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_counted_over_all_kinds_of_ends() {
        let mut text = Text::new(b"a b\r\nc\rd \\\n e # f\\\n#g\nh").with_comments().with_continuations();
        let mut seen = Vec::new();
        while let Some(word) = text.word_anywhere() {
            seen.push((std::str::from_utf8(word).unwrap(), text.line()));
        }
        assert_eq!(seen, [("a", 1), ("b", 1), ("c", 2), ("d", 3), ("e", 4), ("h", 6)]);
    }

    #[test]
    fn numbers_of_all_kinds() {
        assert_eq!(number(b"-1.5e3"), Some(-1500.0));
        assert_eq!(number(b"-1.#INF00"), Some(f64::NEG_INFINITY));
        for nan in ["nan", "-NaN", "1.#IND", "-1.#QNAN0", "-nan(ind)"] {
            assert!(number(nan.as_bytes()).is_some_and(f64::is_nan), "{nan}");
        }
        for bad in ["", "1,5", "abc", "1.0.0", "\u{ff11}", "--1"] {
            assert_eq!(number(bad.as_bytes()), None, "{bad}");
        }
        assert_eq!(integer(b"99999999999999999999"), None);
        assert_eq!(integer(b"-7"), Some(-7));
    }

    #[test]
    fn byte_order_marks_are_understood() {
        assert_eq!(&*decoded(b"\xef\xbb\xbfv"), b"v");
        assert_eq!(&*decoded(b"\xfe\xff\0v\0\n"), b"v\n");
        assert_eq!(&*decoded(b"\xff\xfev\0\xff"), b"v");
        assert_eq!(&*decoded(b"v"), b"v");
    }
}
