//! Elements of an XML text and what they would draw, by nothing of the crate.

use std::collections::HashMap;

use super::tokens::{Counts, count, numbers};

/// Elements whose contents are only definitions.
const DEFINITIONS: [&str; 8] =
    ["defs", "symbol", "clipPath", "mask", "pattern", "marker", "linearGradient", "radialGradient"];

pub(super) struct Element {
    pub(super) name: String,
    pub(super) attributes: HashMap<String, String>,
    children: Vec<usize>,
}

/// Segments as they should be found.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Expected {
    pub(super) in_paths: Counts,
    pub(super) in_shapes: Counts,
    pub(super) in_copies: Counts,
}

/// The elements of a text that is known to be sound; the first is the root.
pub(super) fn parse(text: &str) -> Vec<Element> {
    let mut elements: Vec<Element> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    let mut rest = text;
    while let Some(begin) = rest.find('<') {
        rest = &rest[begin..];
        let behind = |end: &str| rest.find(end).map_or("", |at| &rest[at + end.len()..]);
        if rest.starts_with("<!--") {
            rest = behind("-->");
        } else if rest.starts_with("<![CDATA[") {
            rest = behind("]]>");
        } else if rest.starts_with("<?") {
            rest = behind("?>");
        } else if rest.starts_with("<!DOCTYPE") {
            let bracket = rest.find('[').filter(|at| *at < rest.find('>').unwrap());
            rest = if bracket.is_some() { behind("]") } else { rest };
            rest = &rest[rest.find('>').unwrap() + 1..];
        } else if rest.starts_with("</") {
            open.pop();
            rest = behind(">");
        } else {
            let (element, empty, length) = tag(rest);
            let place = elements.len();
            if let Some(parent) = open.last() {
                let parent: &mut Element = &mut elements[*parent];
                parent.children.push(place);
            }
            elements.push(element);
            if !empty {
                open.push(place);
            }
            rest = &rest[length..];
        }
    }
    elements
}

/// An opening tag: what it says, whether it is empty, and its length.
fn tag(text: &str) -> (Element, bool, usize) {
    let name_end = text.find(|c: char| c.is_whitespace() || c == '>' || c == '/').unwrap();
    let name = text[1..name_end].to_owned();
    let mut attributes = HashMap::new();
    let mut at = name_end;
    loop {
        at += text[at..].find(|c: char| !c.is_whitespace()).unwrap();
        if text[at..].starts_with("/>") {
            return (Element { name, attributes, children: Vec::new() }, true, at + 2);
        }
        if text[at..].starts_with('>') {
            return (Element { name, attributes, children: Vec::new() }, false, at + 1);
        }
        let equals = at + text[at..].find('=').unwrap();
        let quote_at = equals + text[equals..].find(['"', '\'']).unwrap();
        let quote = text[quote_at..].chars().next().unwrap();
        let end = quote_at + 1 + text[quote_at + 1..].find(quote).unwrap();
        attributes.insert(text[at..equals].trim().to_owned(), text[quote_at + 1..end].to_owned());
        at = end + 1;
    }
}

impl Element {
    fn number(&self, name: &str) -> f64 {
        self.attributes.get(name).and_then(|text| numbers(text).first().copied()).unwrap_or(0.0)
    }

    /// The segments of a path or shape, and whether it is a path.
    fn segments(&self) -> Option<(Counts, bool)> {
        let points = || numbers(self.attributes.get("points").map_or("", String::as_str)).len() as u64 / 2;
        let shape = match self.name.as_str() {
            "path" => return Some((count(self.attributes.get("d").map_or("", String::as_str)), true)),
            "rect" if self.number("rx") > 0.0 || self.number("ry") > 0.0 => [4, 0, 0, 4, 0],
            "rect" => [4, 0, 0, 0, 0],
            "circle" | "ellipse" => [0, 0, 0, 4, 0],
            "line" => [1, 0, 0, 0, 0],
            "polyline" => [points().saturating_sub(1), 0, 0, 0, 0],
            "polygon" => [points(), 0, 0, 0, 0],
            _ => return None,
        };
        Some((shape, false))
    }

    fn is_displayed(&self) -> bool {
        let style = self.attributes.get("style").map(|s| s.replace(' ', ""));
        self.attributes.get("display").is_none_or(|d| d.trim() != "none")
            && style.is_none_or(|s| !s.contains("display:none"))
    }
}

/// What should be found in a document.
pub(super) fn expected(elements: &[Element]) -> Expected {
    let mut expected = Expected::default();
    for element in elements {
        if let Some((counts, is_path)) = element.segments() {
            add(if is_path { &mut expected.in_paths } else { &mut expected.in_shapes }, &counts);
        }
    }
    let ids: HashMap<&str, usize> = elements
        .iter()
        .enumerate()
        .rev()
        .filter_map(|(place, e)| e.attributes.get("id").map(|id| (id.as_str(), place)))
        .collect();
    copies(elements, &ids, 0, &mut expected.in_copies, false, true);
    expected
}

/// Adds up what the `use` elements in a subtree copy; `copied` adds the subtree itself.
fn copies(elements: &[Element], ids: &HashMap<&str, usize>, at: usize, sum: &mut Counts, copied: bool, mut live: bool) {
    let element = &elements[at];
    live &= element.is_displayed();
    if copied && let Some((counts, _)) = element.segments() {
        add(sum, &counts);
    }
    if element.name == "use" && live {
        let target = element.attributes.get("xlink:href").or_else(|| element.attributes.get("href")).unwrap();
        // Also a symbol is drawn when it is referred to.
        if let Some(place) = ids.get(target.trim().trim_start_matches('#')) {
            copies_of(elements, ids, *place, sum);
        }
    }
    let below = live && !DEFINITIONS.contains(&element.name.as_str());
    for child in &element.children {
        copies(elements, ids, *child, sum, copied, below);
    }
}

fn copies_of(elements: &[Element], ids: &HashMap<&str, usize>, at: usize, sum: &mut Counts) {
    if elements[at].name == "symbol" {
        elements[at].children.iter().for_each(|child| copies(elements, ids, *child, sum, true, true));
    } else {
        copies(elements, ids, at, sum, true, true);
    }
}

fn add(sum: &mut Counts, more: &Counts) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}
