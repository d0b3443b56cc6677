//! Which declarations hold for an element: attributes, style sheets, its own style.

use std::cell::Cell;

use roxmltree::{Document, Node};
use simplecss::{AttributeOperator, Declaration, DeclarationTokenizer, PseudoClass, StyleSheet};

use super::{SvgError, SvgLimits};

/// The style sheets of a document.
pub(super) struct Cascade<'a> {
    sheet: StyleSheet<'a>,
    /// How many more elements may be compared with rules.
    left: Cell<u64>,
    limit: u64,
}

impl<'a> Cascade<'a> {
    pub(super) fn new(document: &'a Document<'_>, limits: &SvgLimits) -> Self {
        let mut sheet = StyleSheet::new();
        for node in document.descendants().filter(|node| node.tag_name().name() == "style") {
            let is_css = node.attribute("type").is_none_or(|kind| kind.is_empty() || kind == "text/css");
            for text in node.children().filter_map(|child| child.text()).filter(|_| is_css) {
                sheet.parse_more(text);
            }
        }
        Self { sheet, left: Cell::new(limits.comparisons), limit: limits.comparisons }
    }

    /// Calls `apply` with every declaration that holds for an element, the weakest first.
    pub(super) fn declarations(
        &self,
        node: &Node<'a, '_>,
        mut apply: impl FnMut(&'a str, &'a str),
    ) -> Result<(), SvgError> {
        for attribute in node.attributes().filter(|a| a.namespace().is_none()) {
            apply(attribute.name(), attribute.value());
        }
        let style = node.attribute("style").unwrap_or("");
        if self.sheet.rules.is_empty() {
            DeclarationTokenizer::from(style).for_each(|declaration| apply(declaration.name, declaration.value));
            return Ok(());
        }
        let mut important: Vec<Declaration<'a>> = Vec::new();
        let element = Compared { node: *node, left: &self.left };
        // The rules are in the order of their specificity.
        for rule in &self.sheet.rules {
            element.spend();
            if rule.selector.matches(&element) {
                for declaration in &rule.declarations {
                    if declaration.important {
                        important.push(*declaration);
                    } else {
                        apply(declaration.name, declaration.value);
                    }
                }
            }
        }
        if self.left.get() == 0 {
            return Err(SvgError::TooManyRules { limit: self.limit });
        }
        for declaration in DeclarationTokenizer::from(style) {
            if declaration.important {
                important.push(declaration);
            } else {
                apply(declaration.name, declaration.value);
            }
        }
        important.iter().for_each(|declaration| apply(declaration.name, declaration.value));
        Ok(())
    }
}

/// An element as rules are compared with it. When the allowance is spent it has no relatives, so that comparing ends.
struct Compared<'c, 'a, 'input> {
    node: Node<'a, 'input>,
    left: &'c Cell<u64>,
}

impl Compared<'_, '_, '_> {
    fn spend(&self) -> bool {
        self.left.set(self.left.get().saturating_sub(1));
        self.left.get() > 0
    }
}

impl simplecss::Element for Compared<'_, '_, '_> {
    fn parent_element(&self) -> Option<Self> {
        let node = self.node.parent_element().filter(|_| self.spend())?;
        Some(Self { node, left: self.left })
    }

    fn prev_sibling_element(&self) -> Option<Self> {
        let node = self.node.prev_sibling_element().filter(|_| self.spend())?;
        Some(Self { node, left: self.left })
    }

    fn has_local_name(&self, name: &str) -> bool {
        self.node.tag_name().name() == name
    }

    fn attribute_matches(&self, local_name: &str, operator: AttributeOperator<'_>) -> bool {
        self.node.attribute(local_name).is_some_and(|value| operator.matches(value))
    }

    fn pseudo_class_matches(&self, class: PseudoClass<'_>) -> bool {
        matches!(class, PseudoClass::FirstChild) && self.node.prev_sibling_element().is_none()
    }
}
