//! What a search knows of each side: sparse, and empty again at no cost.

use crate::surface::HalfEdge;

/// Places in a page.
const PAGE: usize = 256;

/// How a side was reached.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reached {
    /// The best label on the side.
    pub(crate) label: u32,
    /// Its distance from the start to the side's middle.
    pub(crate) to_middle: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Stamped {
    epoch: u32,
    label: u32,
    to_middle: f64,
}

/// Four places a face, of which three are used: a cache line a face.
#[derive(Debug)]
#[repr(align(64))]
struct Page([Stamped; PAGE]);

/// A table over the sides of a surface, in pages that are made when they are first written: memory grows with where searches
/// have been, not with the surface.
#[derive(Debug, Default)]
pub(crate) struct Stamps {
    pages: Vec<Option<Box<Page>>>,
    epoch: u32,
}

impl Stamps {
    /// Forgets everything, and makes place for the sides of so many faces.
    pub(crate) fn clear(&mut self, faces: usize) {
        let pages = (4 * faces).div_ceil(PAGE);
        if self.pages.len() < pages {
            self.pages.resize_with(pages, || None);
        }
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.pages.iter_mut().flatten().for_each(|page| page.0.fill(Stamped::default()));
            self.epoch = 1;
        }
    }

    /// What is known of a side.
    #[inline]
    pub(crate) fn get(&self, side: HalfEdge) -> Option<Reached> {
        let at = side.bits();
        let stamped = self.pages.get(at / PAGE)?.as_ref()?.0[at % PAGE];
        (stamped.epoch == self.epoch).then_some(Reached { label: stamped.label, to_middle: stamped.to_middle })
    }

    /// Notes how a side was reached; it must belong to one of the faces that place was made for.
    #[inline]
    pub(crate) fn set(&mut self, side: HalfEdge, reached: Reached) {
        let at = side.bits();
        if let Some(page) = self.pages.get_mut(at / PAGE) {
            let page = page.get_or_insert_with(|| Box::new(Page([Stamped::default(); PAGE])));
            page.0[at % PAGE] = Stamped { epoch: self.epoch, label: reached.label, to_middle: reached.to_middle };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cleared_is_gone_even_when_epochs_come_round() {
        let mut stamps = Stamps::default();
        let (a, b) = (HalfEdge::new(3, 2), HalfEdge::new(4000, 0));
        stamps.clear(5000);
        stamps.set(a, Reached { label: 7, to_middle: 0.5 });
        assert_eq!(stamps.get(a).map(|r| (r.label, r.to_middle)), Some((7, 0.5)));
        assert!(stamps.get(b).is_none());
        stamps.epoch = u32::MAX;
        stamps.clear(5000);
        assert!(stamps.get(a).is_none() && stamps.epoch == 1);
        stamps.set(b, Reached::default());
        assert!(stamps.get(b).is_some() && stamps.get(a).is_none());
    }
}
