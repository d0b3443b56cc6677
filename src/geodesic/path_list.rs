//! Paths in a row, in memory that is kept.

use std::ops::Deref;

use super::inner::InnerPath;

/// A list of paths; what was in it lends its memory to what comes into it.
#[derive(Debug, Default)]
pub(crate) struct PathList {
    paths: Vec<InnerPath>,
    used: usize,
}

impl PathList {
    /// Makes the list empty.
    pub(crate) fn clear(&mut self) {
        self.used = 0;
    }

    /// Adds a place, in which some path stands that is to be overwritten.
    pub(crate) fn place(&mut self) -> &mut InnerPath {
        let at = self.used;
        if at == self.paths.len() {
            self.paths.push(InnerPath::default());
        }
        self.used += 1;
        &mut self.paths[at]
    }

    /// Adds copies of paths.
    pub(crate) fn extend_from(&mut self, paths: &[InnerPath]) {
        paths.iter().for_each(|path| self.place().copy_from(path));
    }
}

impl Deref for PathList {
    type Target = [InnerPath];

    fn deref(&self) -> &[InnerPath] {
        &self.paths[..self.used]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_used_again() {
        let mut list = PathList::default();
        list.place().length = 1.0;
        list.place().length = 2.0;
        assert_eq!(list.iter().map(|p| p.length).collect::<Vec<_>>(), [1.0, 2.0]);
        let copies = list.to_vec();
        list.clear();
        assert!(list.is_empty());
        list.extend_from(&copies[1..]);
        assert_eq!((list.len(), list[0].length), (1, 2.0));
    }
}
