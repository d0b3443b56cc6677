//! Counting what `use` makes of a document, before anything is made.

use std::collections::HashMap;
use std::rc::Rc;

use roxmltree::{Document, Node, NodeId};

use super::{SvgError, SvgLimits};

/// The `use` elements that led to an element: by what they refer to.
pub(super) struct UseChain {
    pub(super) target: NodeId,
    pub(super) before: Option<Rc<UseChain>>,
}

impl UseChain {
    /// Whether an element is being copied already, so that copying it again would never end.
    pub(super) fn holds(chain: &Option<Rc<Self>>, target: NodeId) -> bool {
        let mut link = chain.as_ref();
        while let Some(here) = link {
            if here.target == target {
                return true;
            }
            link = here.before.as_ref();
        }
        false
    }
}

/// Elements by their id; the first of several.
pub(super) fn ids<'a, 'input>(document: &'a Document<'input>) -> HashMap<&'a str, Node<'a, 'input>> {
    let mut ids = HashMap::new();
    for node in document.descendants() {
        if let Some(id) = node.attribute("id") {
            ids.entry(id).or_insert(node);
        }
    }
    ids
}

/// The place that an element refers to, as written.
pub(super) fn reference<'a>(node: &Node<'a, '_>) -> Option<&'a str> {
    const XLINK: &str = "http://www.w3.org/1999/xlink";
    node.attribute("href").or_else(|| node.attribute((XLINK, "href"))).map(str::trim)
}

/// Refuses a document that is too deep or too large when all copies are made.
pub(super) fn check(document: &Document<'_>, limits: &SvgLimits) -> Result<(), SvgError> {
    let ids = ids(document);
    let mut elements = 0;
    let mut waiting = vec![(document.root_element(), 1, None)];
    while let Some((node, depth, chain)) = waiting.pop() {
        elements += 1;
        if elements > limits.elements {
            return Err(SvgError::TooManyElements { limit: limits.elements });
        }
        if depth > limits.depth {
            let line = document.text_pos_at(node.range().start).row;
            return Err(SvgError::TooDeep { line, limit: limits.depth });
        }
        if node.tag_name().name() == "use" {
            let target = reference(&node).and_then(|r| r.strip_prefix('#')).and_then(|id| ids.get(id));
            if let Some(target) = target.filter(|target| !UseChain::holds(&chain, target.id())) {
                let link = Rc::new(UseChain { target: target.id(), before: chain.clone() });
                waiting.push((*target, depth + 1, Some(link)));
            }
        }
        waiting.extend(node.children().filter(Node::is_element).map(|child| (child, depth + 1, chain.clone())));
    }
    Ok(())
}
