//! Running on a number of cores.

/// Runs some work in a pool of so many threads.
#[cfg(feature = "parallel")]
pub(crate) fn on<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(error) => panic!("no pool of {threads} threads: {error}"),
    }
}

/// Runs some work on the calling thread: without the feature `parallel` there is no other.
#[cfg(not(feature = "parallel"))]
pub(crate) fn on<T: Send>(_threads: usize, work: impl FnOnce() -> T + Send) -> T {
    work()
}

/// The numbers of threads worth comparing.
pub(crate) const COUNTS: &[usize] = if cfg!(feature = "parallel") { &[1, 2] } else { &[1] };
