//! How large a drawing may be.

/// How large a drawing may be: what is larger is refused before it takes time or memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SvgLimits {
    /// Length of the text, in bytes.
    pub bytes: usize,
    /// How deep elements may lie in each other, also by `use`.
    pub depth: u32,
    /// How many elements there may be, those copied by `use` included.
    pub elements: u32,
    /// How many segments may be drawn, those copied by `use` included.
    pub segments: u32,
    /// How many attributes an element may have, and how many namespaces a document.
    pub attributes: usize,
    /// To how many bytes entities may grow.
    pub entity_bytes: usize,
    /// How many elements a style sheet may be compared with, each with each rule and with its ancestors where a rule asks for them.
    pub comparisons: u64,
}

impl Default for SvgLimits {
    fn default() -> Self {
        Self {
            bytes: 64 << 20,
            depth: 1_000,
            elements: 1_000_000,
            segments: 1_000_000,
            attributes: 256,
            entity_bytes: 1 << 20,
            comparisons: 2_000_000,
        }
    }
}
