//! Sorting, on the caller's thread pool where the feature `parallel` is on.

/// Sorts items that are all different, so that the order does not depend on the number of threads.
pub(crate) fn sort_distinct<T: Ord + Send>(items: &mut [T]) {
    #[cfg(feature = "parallel")]
    rayon::slice::ParallelSliceMut::par_sort_unstable(items);
    #[cfg(not(feature = "parallel"))]
    items.sort_unstable();
}
