//! Where in a text of RON a value stands.
//!
//! Readers of RON know lines of what they cannot read, and forget those of what they can. Errors that come to light later find their line again by
//! walking through the text, which is known to be sound by then.

/// A step from a value to one inside of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// A field of a structure.
    Field(&'static str),
    /// An entry of a list or of a tuple.
    Item(usize),
}

/// The byte where a value begins; that of the innermost value about it that is there, if it is left out.
pub(super) fn find(text: &str, steps: &[Step]) -> usize {
    let mut cursor = Cursor { bytes: text.as_bytes(), at: 0 };
    cursor.skip_space();
    for step in steps {
        let outer = cursor.at;
        if !cursor.enter(*step) {
            return outer;
        }
    }
    cursor.at
}

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Cursor<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// Goes from the beginning of a value to that of one inside; false if there is none.
    fn enter(&mut self, step: Step) -> bool {
        self.word();
        self.skip_space();
        if !matches!(self.peek(), Some(b'(' | b'[' | b'{')) {
            return false;
        }
        self.at += 1;
        let mut number = 0;
        loop {
            self.skip_space();
            match (step, self.peek()) {
                (_, None | Some(b')' | b']' | b'}')) => return false,
                (Step::Item(wished), _) if wished == number => return true,
                (Step::Item(_), _) => {}
                (Step::Field(wished), _) => {
                    let from = self.at;
                    self.word();
                    let found = self.bytes.get(from..self.at) == Some(wished.as_bytes());
                    self.skip_space();
                    if self.peek() == Some(b':') {
                        self.at += 1;
                        self.skip_space();
                    }
                    if found {
                        return true;
                    }
                }
            }
            self.skip_value();
            if self.peek() != Some(b',') {
                return false;
            }
            (self.at, number) = (self.at + 1, number + 1);
        }
    }

    /// Past a name, if there is one.
    fn word(&mut self) {
        while self.peek().is_some_and(|b| b.is_ascii_alphanumeric() || b == b'_') {
            self.at += 1;
        }
    }

    fn skip_space(&mut self) {
        loop {
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            if rest.starts_with(b"//") {
                self.at += rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
            } else if rest.starts_with(b"/*") {
                self.skip_comment();
            } else if rest.first().is_some_and(u8::is_ascii_whitespace) {
                self.at += 1;
            } else {
                return;
            }
        }
    }

    /// Past a comment in which there may be others.
    fn skip_comment(&mut self) {
        let mut depth = 0_usize;
        while let Some(two) = self.bytes.get(self.at..self.at + 2) {
            let (step, deeper) = match two {
                b"/*" => (2, depth + 1),
                b"*/" => (2, depth.saturating_sub(1)),
                _ => (1, depth),
            };
            (self.at, depth) = (self.at + step, deeper);
            if depth == 0 {
                return;
            }
        }
        self.at = self.bytes.len();
    }

    /// To the comma or the bracket behind a value.
    fn skip_value(&mut self) {
        let mut depth = 0_usize;
        while let Some(byte) = self.peek() {
            match byte {
                b'(' | b'[' | b'{' => depth += 1,
                b')' | b']' | b'}' if depth == 0 => return,
                b')' | b']' | b'}' => depth -= 1,
                b',' if depth == 0 => return,
                b'"' => self.skip_string(),
                b'r' if self.is_raw() => self.skip_raw(),
                b'/' => {
                    let from = self.at;
                    self.skip_space();
                    if self.at > from {
                        continue;
                    }
                }
                _ => {}
            }
            self.at += 1;
        }
    }

    /// From the quote in front to the one behind.
    fn skip_string(&mut self) {
        self.at += 1;
        while let Some(byte) = self.peek() {
            match byte {
                b'"' => return,
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
    }

    /// Whether this is the beginning of `r"…"` or `r#"…"#`, and not of a name.
    fn is_raw(&self) -> bool {
        let before = self.at.checked_sub(1).and_then(|at| self.bytes.get(at));
        let rest = self.bytes.get(self.at + 1..).unwrap_or_default();
        let hashes = rest.iter().take_while(|b| **b == b'#').count();
        !before.is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_') && rest.get(hashes) == Some(&b'"')
    }

    /// From the `r` to the last hash, or to the quote where there are none.
    fn skip_raw(&mut self) {
        let rest = self.bytes.get(self.at + 1..).unwrap_or_default();
        let hashes = rest.iter().take_while(|b| **b == b'#').count();
        let inside = self.at + hashes + 2;
        let ends = |at: &usize| {
            self.bytes.get(*at) == Some(&b'"')
                && self.bytes.get(at + 1..at + 1 + hashes).is_some_and(|end| end.iter().all(|b| *b == b'#'))
        };
        let end = (inside..self.bytes.len()).find(ends);
        self.at = end.map_or(self.bytes.len(), |at| at + hashes);
    }
}

#[cfg(test)]
mod tests {
    use super::Step::{Field, Item};
    use super::*;

    #[test]
    fn values_are_found_behind_all_that_may_stand_before_them() {
        let text = r##"// (a: 0
 ( b: "(,\"", /* x: ( /* , */ */ x: r#"a",("#, rx : 'r', list: [(1, 2), Some((k: [7, 8])), Name(k: 9)], a: (z: 1))"##;
        let at = |steps: &[Step]| &text[find(text, steps)..];
        assert!(at(&[Field("a")]).starts_with("(z"));
        assert!(at(&[Field("a"), Field("z")]).starts_with("1)"));
        assert!(at(&[Field("rx")]).starts_with("'r'"));
        assert!(at(&[Field("list"), Item(0), Item(1)]).starts_with("2)"));
        assert!(at(&[Field("list"), Item(1), Item(0), Field("k"), Item(1)]).starts_with("8]"));
        assert!(at(&[Field("list"), Item(2), Field("k")]).starts_with("9)"));
        // What is not there: the value about it.
        assert!(at(&[Field("list"), Item(3)]).starts_with("[(1"));
        assert!(at(&[Field("list"), Item(2), Field("q"), Item(4)]).starts_with("Name"));
        assert!(at(&[Field("q")]).starts_with("( b"));
        for end in 0..text.len() {
            for steps in [&[Field("list"), Item(2)][..], &[Field("a"), Field("z"), Item(1)]] {
                assert!(find(&text[..end], steps) <= end);
            }
        }
    }
}
