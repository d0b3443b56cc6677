//! Items grouped by a number.

use super::{
    BuildProgress, SurfaceError,
    parallel::{self, PIECE},
};

/// Items grouped by a number, one group behind the other, each sorted.
///
/// Counting where a group begins takes less memory and time than sorting all items by their numbers.
pub(crate) struct Buckets<T> {
    /// Where each bucket begins, and the end of the last.
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T: Copy + Default + Ord + Send> Buckets<T> {
    /// Sorts all different items into `count` buckets; `items` gives their numbers with them, the same ones every time.
    ///
    /// # Errors
    /// [`SurfaceError::Cancelled`].
    pub(crate) fn new<I: Iterator<Item = (u32, T)>>(
        count: usize,
        items: impl Fn() -> I,
        progress: &BuildProgress,
    ) -> Result<Self, SurfaceError> {
        // Entry b + 1 counts bucket b − 1 first, then is where the next item of bucket b goes, and so becomes its end.
        let mut starts = vec![0_u32; count + 2];
        for (i, (bucket, _)) in items().enumerate() {
            starts[bucket as usize + 2] += 1;
            if i % PIECE == 0 {
                progress.check()?;
            }
        }
        let mut total = 0;
        for start in &mut starts {
            total += *start;
            *start = total;
        }
        let mut placed = vec![T::default(); total as usize];
        for (i, (bucket, item)) in items().enumerate() {
            let next = &mut starts[bucket as usize + 1];
            placed[*next as usize] = item;
            *next += 1;
            if i % PIECE == 0 {
                progress.check()?;
            }
        }
        starts.truncate(count + 1);
        sort_each(&starts, &mut placed, progress)?;
        Ok(Self { starts, items: placed })
    }

    /// The items of a bucket, sorted.
    #[inline]
    pub(crate) fn of(&self, bucket: u32) -> &[T] {
        &self.items[self.starts[bucket as usize] as usize..self.starts[bucket as usize + 1] as usize]
    }

    /// All items, bucket by bucket.
    pub(crate) fn items(&self) -> &[T] {
        &self.items
    }
}

/// Sorts each bucket by itself; `items` begins where the first of `starts` says.
fn sort_each<T: Ord + Send>(starts: &[u32], items: &mut [T], progress: &BuildProgress) -> Result<(), SurfaceError> {
    if items.len() <= PIECE || starts.len() <= 2 {
        progress.check()?;
        let mut rest = items;
        for ends in starts.windows(2) {
            let (bucket, behind) = rest.split_at_mut((ends[1] - ends[0]) as usize);
            parallel::sort_distinct(bucket);
            rest = behind;
        }
        return Ok(());
    }
    let middle = starts.len() / 2;
    let (left, right) = items.split_at_mut((starts[middle] - starts[0]) as usize);
    let (left, right) = parallel::join(
        || sort_each(&starts[..=middle], left, progress),
        || sort_each(&starts[middle..], right, progress),
    );
    left.and(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_hold_their_items_in_order() {
        let items = || (0..50_000_u32).map(|i| (i * 7919 % 997 / 3, i * 31 % 50_000));
        let buckets = Buckets::new(400, items, &BuildProgress::default()).unwrap();
        for bucket in 0..400 {
            let mut expected: Vec<u32> = items().filter(|item| item.0 == bucket).map(|item| item.1).collect();
            expected.sort_unstable();
            assert_eq!(buckets.of(bucket), expected);
        }
        assert_eq!(buckets.items().len(), 50_000);
    }
}
