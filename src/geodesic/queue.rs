//! Labels in the order of their priorities, roughly: a queue of buckets.

/// More buckets than this are one.
const MAX_BUCKETS: usize = 1 << 16;
const NONE: u32 = u32::MAX;

/// Numbers 0, 1, 2 … by priority: those within a bucket's width come in the order in which they were pushed.
///
/// What is pushed after something was popped comes after it, even where its priority is less. Pushing and popping cost the
/// same however many there are.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    /// Priority and next in the bucket, of every number.
    entries: Vec<(f64, u32)>,
    /// First and last of each bucket.
    buckets: Vec<(u32, u32)>,
    at: usize,
    first_priority: f64,
    per_width: f64,
}

impl Queue {
    /// Empties the queue; buckets are `width` wide from then on.
    pub(crate) fn clear(&mut self, width: f64) {
        self.entries.clear();
        self.buckets.clear();
        self.at = 0;
        self.per_width = 1.0 / width.max(f64::MIN_POSITIVE);
    }

    /// Adds the next number.
    #[inline]
    pub(crate) fn push(&mut self, priority: f64) {
        let number = self.entries.len() as u32;
        if number == 0 {
            // Later ones may be less by what a face is large.
            self.first_priority = priority - 8.0 / self.per_width;
        }
        // A cast saturates: what is less than the first counts as the first.
        let place = (((priority - self.first_priority) * self.per_width) as usize).min(MAX_BUCKETS).max(self.at);
        if self.buckets.len() <= place {
            self.buckets.resize(place + 1, (NONE, NONE));
        }
        self.entries.push((priority, NONE));
        let (first, last) = self.buckets[place];
        if first == NONE {
            self.buckets[place] = (number, number);
        } else {
            self.entries[last as usize].1 = number;
            self.buckets[place].1 = number;
        }
    }

    /// Takes the next number of a priority below `limit`.
    #[inline]
    pub(crate) fn pop(&mut self, limit: f64) -> Option<u32> {
        while let Some(bucket) = self.buckets.get_mut(self.at) {
            let number = bucket.0;
            if number == NONE {
                self.at += 1;
                continue;
            }
            let (priority, next) = self.entries[number as usize];
            bucket.0 = next;
            if priority < limit {
                return Some(number);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_by_bucket_and_then_by_age() {
        let mut queue = Queue::default();
        for _ in 0..2 {
            queue.clear(0.5);
            [10.0, 13.0, 11.1, 11.4, 1e300, 9.0, 12.0].into_iter().for_each(|p| queue.push(p));
            let order: Vec<u32> = std::iter::from_fn(|| queue.pop(1e100)).collect();
            assert_eq!(order, [5, 0, 2, 3, 6, 1]);
            assert_eq!(queue.pop(f64::INFINITY), None);
        }
        queue.clear(0.0);
        [f64::NAN, 2.0, 1.0].into_iter().for_each(|p| queue.push(p));
        assert_eq!(queue.pop(1.5), Some(2));
    }
}
