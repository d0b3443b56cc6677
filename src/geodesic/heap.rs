//! Numbers in the order of their priorities, exactly: a heap.

/// A four-ary heap of numbers by priority; ties go to the smaller number, so that the order is defined.
#[derive(Debug, Default)]
pub(crate) struct Heap(Vec<(f64, u32)>);

impl Heap {
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    fn before(a: (f64, u32), b: (f64, u32)) -> bool {
        a.0 < b.0 || (a.0 == b.0 && a.1 < b.1)
    }

    pub(crate) fn push(&mut self, priority: f64, number: u32) {
        let entry = (priority, number);
        let mut i = self.0.len();
        self.0.push(entry);
        while i > 0 {
            let parent = (i - 1) / 4;
            if !Self::before(entry, self.0[parent]) {
                break;
            }
            self.0[i] = self.0[parent];
            i = parent;
        }
        self.0[i] = entry;
    }

    pub(crate) fn pop(&mut self) -> Option<(f64, u32)> {
        let top = *self.0.first()?;
        let entry = self.0.pop()?;
        let n = self.0.len();
        if n > 0 {
            let mut i = 0;
            loop {
                let first = 4 * i + 1;
                if first >= n {
                    break;
                }
                let mut child = first;
                for k in first + 1..(first + 4).min(n) {
                    if Self::before(self.0[k], self.0[child]) {
                        child = k;
                    }
                }
                if !Self::before(self.0[child], entry) {
                    break;
                }
                self.0[i] = self.0[child];
                i = child;
            }
            self.0[i] = entry;
        }
        Some(top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heap_sorts() {
        let mut heap = Heap::default();
        let mut state = 1_u64;
        for i in 0..1000 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            heap.push((state >> 58) as f64, i);
        }
        let mut last = (-1.0, 0);
        for _ in 0..1000 {
            let next = heap.pop().unwrap();
            assert!(Heap::before(last, next));
            last = next;
        }
        assert!(heap.pop().is_none());
    }
}
