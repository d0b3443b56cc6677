//! Work spread over the caller's thread pool with the feature `parallel`, and done in turn without it.

/// What `work` makes of each item, in their order. `scratch` makes memory that is lent from one item to another.
pub(super) fn map<T: Sync, S, R: Send>(
    items: &[T],
    scratch: impl Fn() -> S + Sync + Send,
    work: impl Fn(&mut S, usize, &T) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        items.par_iter().enumerate().map_init(scratch, |scratch, (i, item)| work(scratch, i, item)).collect()
    }
    #[cfg(not(feature = "parallel"))]
    {
        let mut scratch = scratch();
        items.iter().enumerate().map(|(i, item)| work(&mut scratch, i, item)).collect()
    }
}

/// Does two things, at once if a thread is free.
#[inline]
pub(super) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    #[cfg(feature = "parallel")]
    return rayon::join(a, b);
    #[cfg(not(feature = "parallel"))]
    (a(), b())
}
