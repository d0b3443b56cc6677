//! Work spread over the caller's thread pool with the feature `parallel`, and done in turn without it.
//!
//! Work is cut in the same pieces on however many threads, and results come in the order of the items, so that nothing
//! made of them depends on threads. Every piece asks first whether the build was cancelled.

use std::ops::Range;

use super::{BuildProgress, SurfaceError};

/// Items in a piece: enough to be worth handing over, few enough to stop soon.
pub(crate) const PIECE: usize = 1 << 14;

/// Does two things, at once if a thread is free.
#[inline]
pub(crate) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    #[cfg(feature = "parallel")]
    return rayon::join(a, b);
    #[cfg(not(feature = "parallel"))]
    (a(), b())
}

/// Sorts items that are all different, so that the order does not depend on the number of threads.
pub(crate) fn sort_distinct<T: Ord + Send>(items: &mut [T]) {
    #[cfg(feature = "parallel")]
    if items.len() > PIECE {
        return rayon::slice::ParallelSliceMut::par_sort_unstable(items);
    }
    items.sort_unstable();
}

/// What `work` makes of each piece of `0..count`, in order.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn map_pieces<T: Send>(
    count: usize,
    progress: &BuildProgress,
    work: impl Fn(Range<usize>) -> T + Sync,
) -> Result<Vec<T>, SurfaceError> {
    let mut made: Vec<Option<T>> = (0..count.div_ceil(PIECE)).map(|_| None).collect();
    for_each(&mut made, 0, 1, progress, &|first, slots: &mut [Option<T>]| {
        for (slot, piece) in slots.iter_mut().zip(first..) {
            *slot = Some(work(piece * PIECE..count.min((piece + 1) * PIECE)));
        }
    })?;
    Ok(made.into_iter().flatten().collect())
}

/// A table of `count` entries, each made from its place.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn table<T: Clone + Send>(
    count: usize,
    blank: T,
    progress: &BuildProgress,
    entry: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>, SurfaceError> {
    let mut table = vec![blank; count];
    update(&mut table, progress, |at, slot| *slot = entry(at))?;
    Ok(table)
}

/// Calls `change` with every item and its place.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn update<T: Send>(
    items: &mut [T],
    progress: &BuildProgress,
    change: impl Fn(usize, &mut T) + Sync,
) -> Result<(), SurfaceError> {
    for_each(items, 0, PIECE, progress, &|first, piece: &mut [T]| {
        piece.iter_mut().zip(first..).for_each(|(item, at)| change(at, item));
    })
}

/// Halves items down to pieces of at most `most`, and calls `work` with the place of each piece's first item.
fn for_each<T: Send>(
    items: &mut [T],
    first: usize,
    most: usize,
    progress: &BuildProgress,
    work: &(impl Fn(usize, &mut [T]) + Sync),
) -> Result<(), SurfaceError> {
    if items.len() <= most {
        progress.check()?;
        work(first, items);
        return Ok(());
    }
    let middle = items.len() / 2;
    let (left, right) = items.split_at_mut(middle);
    let (left, right) =
        join(|| for_each(left, first, most, progress, work), || for_each(right, first + middle, most, progress, work));
    left.and(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_everything_in_order() {
        let progress = BuildProgress::default();
        for count in [0, 1, PIECE, PIECE + 1, 5 * PIECE + 3] {
            let pieces = map_pieces(count, &progress, |range| range).unwrap();
            assert!(pieces.into_iter().flatten().eq(0..count));
            let table = table(count, 0, &progress, |at| at).unwrap();
            assert!(table.into_iter().eq(0..count));
        }
        progress.cancel();
        assert_eq!(map_pieces(3, &progress, |_| ()), Err(SurfaceError::Cancelled));
        assert_eq!(table(3, 0, &progress, |at| at), Err(SurfaceError::Cancelled));
    }
}
