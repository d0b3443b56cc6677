//! A look at the text before it is parsed: how deep it is, how much of everything there is, what its entities grow to.
//!
//! It need not be right about documents that are no XML; the parser says what is wrong with those.

use std::collections::HashMap;

use super::{SvgError, SvgLimits};

/// Refuses a text that a parser would need too much time or memory for.
pub(super) fn check(text: &str, limits: &SvgLimits) -> Result<(), SvgError> {
    let mut scan = Scan { text, at: 0, depth: 0, elements: 0, namespaces: 0, entities: HashMap::new(), limits };
    while let Some(next) = text.get(scan.at..).and_then(|rest| rest.find('<')) {
        scan.at += next;
        scan.markup()?;
    }
    scan.check_references()
}

struct Scan<'t> {
    text: &'t str,
    at: usize,
    depth: u32,
    elements: u32,
    namespaces: usize,
    entities: HashMap<&'t str, Entity<'t>>,
    limits: &'t SvgLimits,
}

/// What a name stands for, and to how many bytes that grows, once it was asked for.
#[derive(Clone, Copy)]
struct Entity<'t> {
    value: &'t str,
    grown: Option<usize>,
}

impl<'t> Scan<'t> {
    fn rest(&self) -> &'t str {
        self.text.get(self.at..).unwrap_or("")
    }

    /// Goes behind the next place where some text stands.
    fn skip_past(&mut self, end: &str) {
        self.at = self.rest().find(end).map_or(self.text.len(), |found| self.at + found + end.len());
    }

    fn line(&self) -> u32 {
        let before = self.text.as_bytes().get(..self.at).unwrap_or_default();
        1 + before.iter().filter(|b| **b == b'\n').count() as u32
    }

    /// Goes over what begins with a `<`.
    fn markup(&mut self) -> Result<(), SvgError> {
        let rest = self.rest();
        if rest.starts_with("<!--") {
            self.skip_past("-->");
        } else if rest.starts_with("<![CDATA[") {
            self.skip_past("]]>");
        } else if rest.starts_with("<?") {
            self.skip_past("?>");
        } else if rest.starts_with("<!") {
            self.document_type()?;
        } else if rest.starts_with("</") {
            self.depth = self.depth.saturating_sub(1);
            self.skip_past(">");
        } else {
            self.open_tag()?;
        }
        Ok(())
    }

    fn open_tag(&mut self) -> Result<(), SvgError> {
        self.elements += 1;
        self.depth += 1;
        if self.elements > self.limits.elements {
            return Err(SvgError::TooManyElements { limit: self.limits.elements });
        }
        if self.depth > self.limits.depth {
            return Err(SvgError::TooDeep { line: self.line(), limit: self.limits.depth });
        }
        let (mut quote, mut attributes) = (None, 0);
        let tag = self.rest().as_bytes();
        let mut length = tag.len();
        for (i, byte) in tag.iter().enumerate() {
            match (quote, byte) {
                (Some(open), byte) if open == *byte => quote = None,
                (Some(_), _) => {}
                (None, b'"' | b'\'') => quote = Some(*byte),
                (None, b'=') => {
                    attributes += 1;
                    self.namespaces += usize::from(names_namespace(&tag[..i]));
                }
                (None, b'>') => {
                    length = i + 1;
                    break;
                }
                _ => {}
            }
        }
        if attributes > self.limits.attributes || self.namespaces > self.limits.attributes {
            return Err(SvgError::TooManyAttributes { line: self.line(), limit: self.limits.attributes });
        }
        if tag.get(..length).is_some_and(|tag| tag.ends_with(b"/>")) {
            self.depth -= 1;
        }
        self.at += length;
        Ok(())
    }

    /// Goes over a document type, and notes its entities.
    fn document_type(&mut self) -> Result<(), SvgError> {
        let end = outside_quotes(self.rest(), b"[>");
        let has_subset = self.rest().as_bytes().get(end) == Some(&b'[');
        self.at += (end + 1).min(self.rest().len());
        if has_subset {
            self.declarations()?;
            self.skip_past(">");
        }
        Ok(())
    }

    /// Goes over the declarations of a document type, to the bracket behind them.
    fn declarations(&mut self) -> Result<(), SvgError> {
        loop {
            self.at += outside_quotes(self.rest(), b"<]");
            let rest = self.rest();
            if rest.is_empty() || rest.starts_with(']') {
                return Ok(());
            }
            if rest.starts_with("<!--") {
                self.skip_past("-->");
            } else if rest.starts_with("<?") {
                self.skip_past("?>");
            } else {
                let end = outside_quotes(rest, b">");
                let declaration = rest.get(..end).unwrap_or(rest);
                self.entity(declaration)?;
                self.at += declaration.len();
            }
        }
    }

    /// Notes an entity, where a declaration is one: its name, and between quotes what it stands for.
    fn entity(&mut self, declaration: &'t str) -> Result<(), SvgError> {
        let Some(declared) = declaration.strip_prefix("<!ENTITY") else { return Ok(()) };
        let name = declared.split_whitespace().next().unwrap_or("");
        let Some(open) = declared.find(['"', '\'']) else { return Ok(()) };
        let value = declared.get(open + 1..).unwrap_or("");
        let value = value.trim_end().trim_end_matches(['"', '\'']);
        if value.contains('<') || value.contains("&#") {
            let what = "holds elements or character codes, which is not supported";
            return Err(SvgError::Entity { line: self.line(), name: name.to_owned(), what });
        }
        // Of several with one name, the first counts.
        self.entities.entry(name).or_insert(Entity { value, grown: None });
        Ok(())
    }

    /// To how many bytes an entity grows, which may be declared with others that come later; more than the limit if it has no end.
    fn grown(&mut self, name: &'t str, depth: u32) -> usize {
        /// The parser does not look deeper either.
        const DEEPEST: u32 = 10;
        let beyond = self.limits.entity_bytes + 1;
        let Some(Entity { value, grown }) = self.entities.get(name).copied() else { return 0 };
        if depth > DEEPEST {
            return beyond;
        }
        grown.unwrap_or_else(|| {
            let mut sum = value.len();
            for inner in references(value) {
                sum = (sum + self.grown(inner, depth + 1)).min(beyond);
            }
            if let Some(entity) = self.entities.get_mut(name) {
                entity.grown = Some(sum);
            }
            sum
        })
    }

    /// Adds up what all references of the text grow to.
    fn check_references(&mut self) -> Result<(), SvgError> {
        if self.entities.is_empty() {
            return Ok(());
        }
        let mut total = 0;
        for name in references(self.text) {
            total += self.grown(name, 0);
            if total > self.limits.entity_bytes {
                let what = "grows without measure, or is referred to so often";
                return Err(SvgError::Entity { line: 1, name: name.to_owned(), what });
            }
        }
        Ok(())
    }
}

/// Where one of some characters stands for the first time outside of quotes; the length of the text if it does not.
fn outside_quotes(text: &str, stops: &[u8]) -> usize {
    let mut quote = None;
    let found = text.bytes().position(|byte| match quote {
        Some(open) => {
            if open == byte {
                quote = None;
            }
            false
        }
        None if matches!(byte, b'"' | b'\'') => {
            quote = Some(byte);
            false
        }
        None => stops.contains(&byte),
    });
    found.unwrap_or(text.len())
}

/// Whether the name at the end of a piece of a tag declares a namespace.
fn names_namespace(tag: &[u8]) -> bool {
    let trimmed = tag.trim_ascii_end();
    let begin = trimmed.iter().rposition(|b| b.is_ascii_whitespace() || matches!(b, b'"' | b'\'')).map_or(0, |i| i + 1);
    trimmed.get(begin..).is_some_and(|name| name.starts_with(b"xmlns"))
}

/// The names of the entities that a text refers to.
fn references(text: &str) -> impl Iterator<Item = &str> {
    text.split('&').skip(1).filter_map(|rest| rest.get(..rest.find(';')?)).filter(|name| !name.starts_with('#'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        check(text, &SvgLimits::default()).map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn what_is_deep_long_or_grows_is_refused() {
        let limits = SvgLimits::default();
        let nested = |n: usize| "<g>".repeat(n) + &"</g>".repeat(n);
        assert!(check(&nested(1000), &limits).is_ok());
        assert!(refused(&nested(1001)).contains("1000 deep"));
        assert!(check(&"<g a='>'/>".repeat(1_000_000), &limits).is_ok());
        assert!(refused(&"<g/>".repeat(1_000_001)).contains("1000000 elements"));
        let attributes: String = (0..300).map(|i| format!("a{i}='' ")).collect();
        assert!(refused(&format!("<g {attributes}/>")).contains("attributes"));
        assert!(refused(&"<g xmlns:a='b'/>".repeat(300)).contains("namespaces"));
        let long = format!("<!DOCTYPE svg [<!ENTITY a \"{}\">]><svg>{}</svg>", "x".repeat(1000), "&a;".repeat(2000));
        assert!(refused(&long).contains("grows without"), "{}", refused(&long));
        // Declared before what it refers to; and behind a bracket that is none.
        let later = format!("<!ENTITY a '{}'><!ENTITY b '{}'>", "&b;".repeat(200), "x".repeat(9000));
        assert!(refused(&format!("<!DOCTYPE svg [{later}]><svg>&a;</svg>")).contains("grows without"));
        assert!(refused(&format!("<!DOCTYPE svg PUBLIC '[' ']' [{later}]><svg>&a;</svg>")).contains("grows without"));
        assert!(refused(&format!("<!DOCTYPE svg PUBLIC '[' ''>{}", nested(1001))).contains("1000 deep"));
        assert!(refused("<!DOCTYPE svg [<!ENTITY a '&b;'><!ENTITY b '&a;'>]><svg>&a;</svg>").contains("grows without"));
        assert!(refused("<!DOCTYPE svg [<!ENTITY a '<g/>'>]><svg>&a;</svg>").contains("holds elements"));
    }

    #[test]
    fn what_only_looks_like_markup_is_none() {
        let limits = SvgLimits { depth: 2, elements: 3, ..SvgLimits::default() };
        let text = "<?xml a='<b>'?><!DOCTYPE svg [ <!ENTITY ns \"http://a.b/c\"> <!-- <a> --> ]>\
                    <svg xmlns='&ns;'><!-- <g><g><g> --><![CDATA[<g><g>]]><g a=\"<\" b='/>'/><g></g></svg>";
        assert!(check(text, &limits).is_ok(), "{:?}", check(text, &limits));
        for broken in
            ["<", "<!", "<!DOCTYPE", "<!DOCTYPE [", "<!DOCTYPE [<!ENTITY", "<!DOCTYPE [<!ENTITY a 'ä", "<a b='"]
        {
            let _ = check(broken, &limits);
        }
    }
}
