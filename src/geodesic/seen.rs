//! The faces that a search has seen: a hash table, for they are few however large the surface.

use crate::surface::HalfEdge;

/// How a face was reached.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Visit {
    /// The side of the face before; none at the start.
    pub(crate) came_by: HalfEdge,
    /// Length of the way so far.
    pub(crate) so_far: f64,
    closed: bool,
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    /// A slot of another epoch is free.
    epoch: u32,
    face: u32,
    visit: Visit,
}

const FREE: Slot = Slot { epoch: 0, face: 0, visit: Visit { came_by: HalfEdge::NONE, so_far: 0.0, closed: false } };
const FEWEST_SLOTS: usize = 256;

/// Faces seen by one query; forgets them at no cost.
#[derive(Debug, Default)]
pub(crate) struct Seen {
    /// A power of two of slots, at most half of them taken.
    slots: Vec<Slot>,
    taken: usize,
    epoch: u32,
}

impl Seen {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.taken = 0;
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 || self.slots.is_empty() {
            let slots = self.slots.len().max(FEWEST_SLOTS);
            self.slots.clear();
            self.slots.resize(slots, FREE);
            self.epoch = 1;
        }
    }

    /// Notes how a face was reached, unless it is closed or a way no longer is known; says whether it did.
    #[inline]
    pub(crate) fn reach(&mut self, face: u32, came_by: HalfEdge, so_far: f64) -> bool {
        let i = self.place(face);
        let slot = &mut self.slots[i];
        let new = slot.epoch != self.epoch;
        if !new && (slot.visit.closed || slot.visit.so_far <= so_far) {
            return false;
        }
        *slot = Slot { epoch: self.epoch, face, visit: Visit { came_by, so_far, closed: false } };
        self.taken += usize::from(new);
        if 2 * self.taken > self.slots.len() {
            self.grow();
        }
        true
    }

    /// How a face was reached, the first time that this is asked: ways to it found later do not count.
    #[inline]
    pub(crate) fn close(&mut self, face: u32) -> Option<Visit> {
        let i = self.place(face);
        let slot = &mut self.slots[i];
        if slot.epoch != self.epoch || slot.visit.closed {
            return None;
        }
        slot.visit.closed = true;
        Some(slot.visit)
    }

    /// The side that a face was come by; none if it was not seen, and at the start.
    pub(crate) fn came_by(&self, face: u32) -> Option<HalfEdge> {
        let slot = &self.slots[self.place(face)];
        (slot.epoch == self.epoch && slot.visit.came_by.is_some()).then_some(slot.visit.came_by)
    }

    /// The slot of a face, or the free one where it belongs; half of the slots are free, so there is one.
    #[inline]
    fn place(&self, face: u32) -> usize {
        let mask = self.slots.len() - 1;
        // Multiplicative hashing (Knuth): of the product the high bits are well mixed.
        let mut i = (face.wrapping_mul(0x9e37_79b9) >> 8) as usize & mask;
        while self.slots[i].epoch == self.epoch && self.slots[i].face != face {
            i = (i + 1) & mask;
        }
        i
    }

    fn grow(&mut self) {
        let slots = 2 * self.slots.len();
        let old = std::mem::replace(&mut self.slots, vec![FREE; slots]);
        for slot in old.into_iter().filter(|s| s.epoch == self.epoch) {
            let i = self.place(slot.face);
            self.slots[i] = slot;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shorter_ways_replace_longer_ones_until_a_face_is_closed() {
        let mut seen = Seen::default();
        seen.clear();
        let [a, b] = [HalfEdge::new(1, 0), HalfEdge::new(2, 1)];
        assert!(seen.reach(7, a, 2.0));
        assert!(!seen.reach(7, b, 3.0));
        assert!(seen.reach(7, b, 1.0));
        assert_eq!(seen.close(7).map(|v| (v.came_by, v.so_far)), Some((b, 1.0)));
        assert!(!seen.reach(7, a, 0.5) && seen.close(7).is_none());
        assert_eq!(seen.came_by(7), Some(b));
    }

    #[test]
    fn the_table_grows_and_forgets() {
        let mut seen = Seen::default();
        for round in 0..3_u32 {
            seen.clear();
            assert_eq!(seen.came_by(5 * round), None);
            for face in 0..5000_u32 {
                assert!(seen.reach(face * 977, HalfEdge::new(face, 1), f64::from(face)));
            }
            assert!((0..5000).all(|face| seen.came_by(face * 977) == Some(HalfEdge::new(face, 1))));
            assert_eq!(seen.came_by(1), None);
        }
        seen.epoch = u32::MAX;
        seen.clear();
        assert!(seen.epoch == 1 && seen.came_by(977).is_none());
    }
}
