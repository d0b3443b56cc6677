//! Labels in the order of their priorities, roughly: a queue of buckets.

/// More buckets than this are one.
const MAX_BUCKETS: i32 = 1 << 16;
/// The bucket of the first number: later ones may be less, by what a face is large and by what a guide counts too much.
const FIRST: f64 = 128.0;
/// So many buckets back are looked at again when something is pushed there.
const BACK: usize = 64;
const NONE: u32 = u32::MAX;

/// Numbers 0, 1, 2 … by priority: those within a bucket's width come in the order in which they were pushed.
///
/// Priorities much less than what was popped count as a little less. Pushing and popping cost the same however many there are.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    /// The next in the bucket, of every number.
    next: Vec<u32>,
    /// First and last of each bucket.
    buckets: Vec<(u32, u32)>,
    at: usize,
    /// The bucket that begins at priority zero.
    zero: f64,
    width: f64,
    per_width: f64,
}

impl Queue {
    /// Empties the queue; buckets are `width` wide from then on.
    pub(crate) fn clear(&mut self, width: f64) {
        self.next.clear();
        self.buckets.clear();
        self.at = 0;
        self.width = width.max(f64::MIN_POSITIVE);
        self.per_width = 1.0 / self.width;
    }

    /// Adds the next number.
    #[inline]
    pub(crate) fn push(&mut self, priority: f64) {
        let number = self.next.len() as u32;
        let place = priority * self.per_width;
        if number == 0 {
            (self.zero, self.at) = (FIRST - place, FIRST as usize);
        }
        // A cast saturates: what is less than the first counts as the first.
        let place = ((place + self.zero) as i32).clamp(0, MAX_BUCKETS) as usize;
        let place = place.max(self.at.saturating_sub(BACK));
        self.at = self.at.min(place);
        if self.buckets.len() <= place {
            self.buckets.resize(place + 1, (NONE, NONE));
        }
        self.next.push(NONE);
        let bucket = &mut self.buckets[place];
        let last = std::mem::replace(&mut bucket.1, number);
        if bucket.0 == NONE {
            bucket.0 = number;
        } else {
            self.next[last as usize] = number;
        }
    }

    /// Takes the next number, unless it and all others are of a priority of `limit` or more.
    #[inline]
    pub(crate) fn pop(&mut self, limit: f64) -> Option<u32> {
        while let Some(bucket) = self.buckets.get_mut(self.at) {
            let number = bucket.0;
            if number != NONE {
                bucket.0 = self.next[number as usize];
                return Some(number);
            }
            self.at += 1;
            if (self.at as f64 - self.zero) * self.width >= limit {
                self.buckets.clear();
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
            let order: Vec<u32> = std::iter::from_fn(|| queue.pop(20.0)).collect();
            assert_eq!(order, [5, 0, 2, 3, 6, 1]);
            assert_eq!(queue.pop(f64::INFINITY), None);
        }
        // Back to what comes late, but not far back.
        queue.clear(1.0);
        [50.0, 400.0, 300.0].into_iter().for_each(|p| queue.push(p));
        assert_eq!([queue.pop(1e3), queue.pop(1e3)], [Some(0), Some(2)]);
        [350.0, 299.0, 0.0, 236.5].into_iter().for_each(|p| queue.push(p));
        let order: Vec<u32> = std::iter::from_fn(|| queue.pop(400.0)).collect();
        assert_eq!(order, [5, 6, 4, 3]);
        queue.clear(0.0);
        [f64::NAN, 2.0, 1.0].into_iter().for_each(|p| queue.push(p));
        assert_eq!(queue.pop(1.5), Some(1));
    }
}
