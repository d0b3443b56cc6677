//! What a search knows of each side: sparse, and empty again at no cost.

use crate::surface::HalfEdge;

/// Places in a block: four a face, of which three are used. Faces whose numbers follow one another lie together.
const BLOCK: usize = 64;

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

/// A cache line a face.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Block([Stamped; BLOCK]);

/// Where the places of some faces are, if the epoch is the table's.
#[derive(Clone, Copy, Debug, Default)]
struct Page {
    epoch: u32,
    block: u32,
}

/// A table over the sides of a surface. Each query hands out the same blocks of memory anew, to faces in the order in which it comes to
/// them: what a query writes to was written to by the one before, wherever that was, so that it is near at hand. Memory grows with what
/// queries reach, not with the surface.
#[derive(Debug, Default)]
pub(crate) struct Stamps {
    pages: Vec<Page>,
    blocks: Vec<Block>,
    /// Blocks handed out in this query.
    used: u32,
    epoch: u32,
}

impl Stamps {
    /// Forgets everything, and makes place for the sides of so many faces.
    pub(crate) fn clear(&mut self, faces: usize) {
        let pages = (4 * faces).div_ceil(BLOCK);
        if self.pages.len() < pages {
            self.pages.resize(pages, Page::default());
        }
        self.used = 0;
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.pages.fill(Page::default());
            self.blocks.fill(Block([Stamped::default(); BLOCK]));
            self.epoch = 1;
        }
    }

    /// What is known of a side.
    #[inline]
    pub(crate) fn get(&self, side: HalfEdge) -> Option<Reached> {
        let at = side.bits();
        let page = self.pages.get(at / BLOCK).filter(|page| page.epoch == self.epoch)?;
        let stamped = &self.blocks[page.block as usize].0[at % BLOCK];
        (stamped.epoch == self.epoch).then_some(Reached { label: stamped.label, to_middle: stamped.to_middle })
    }

    /// The distance to a side's middle; infinite if it was not reached.
    #[inline]
    pub(crate) fn to_middle(&self, side: HalfEdge) -> f64 {
        self.get(side).map_or(f64::INFINITY, |reached| reached.to_middle)
    }

    /// [`to_middle`](Self::to_middle) of two sides of one face.
    #[inline]
    pub(crate) fn to_middles(&self, sides: [HalfEdge; 2]) -> [f64; 2] {
        let page = self.pages.get(sides[0].bits() / BLOCK).filter(|page| page.epoch == self.epoch);
        let Some(page) = page else { return [f64::INFINITY; 2] };
        let block = &self.blocks[page.block as usize].0;
        let to_middle = |side: HalfEdge| {
            let stamped = &block[side.bits() % BLOCK];
            if stamped.epoch == self.epoch { stamped.to_middle } else { f64::INFINITY }
        };
        [to_middle(sides[0]), to_middle(sides[1])]
    }

    /// Notes how a side was reached; it must belong to one of the faces that place was made for.
    #[inline]
    pub(crate) fn set(&mut self, side: HalfEdge, reached: Reached) {
        let at = side.bits();
        let Some(page) = self.pages.get_mut(at / BLOCK) else { return };
        if page.epoch != self.epoch {
            *page = Page { epoch: self.epoch, block: self.used };
            if self.blocks.len() == self.used as usize {
                self.blocks.push(Block([Stamped::default(); BLOCK]));
            }
            self.used += 1;
        }
        let stamped = Stamped { epoch: self.epoch, label: reached.label, to_middle: reached.to_middle };
        self.blocks[page.block as usize].0[at % BLOCK] = stamped;
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

    #[test]
    fn every_query_is_handed_the_same_blocks() {
        let mut stamps = Stamps::default();
        for face in [900, 3, 4000] {
            stamps.clear(5000);
            let [near, far] = [face, face + 17].map(|face| HalfEdge::new(face, 1));
            assert!(stamps.to_middles([near, near.next()]).iter().all(|d| *d == f64::INFINITY));
            for (label, side) in [far, near].into_iter().enumerate() {
                stamps.set(side, Reached { label: label as u32, to_middle: f64::from(face) });
            }
            assert_eq!([near, far].map(|side| stamps.get(side).map(|r| r.label)), [Some(1), Some(0)]);
            assert_eq!(stamps.to_middles([near, near.next()]), [f64::from(face), f64::INFINITY]);
            assert_eq!(stamps.blocks.len(), 2);
        }
    }
}
