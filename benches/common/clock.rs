//! Time, as the processor and as the user see it.

use std::time::Instant;

use cpu_time::ThreadTime;

/// Milliseconds of CPU time that the calling thread spends on some work, and what the work gives.
pub(crate) fn cpu_ms<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = ThreadTime::now();
    let result = work();
    (start.elapsed().as_secs_f64() * 1e3, result)
}

/// Milliseconds that pass while some work is done, and what the work gives.
pub(crate) fn wall_ms<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let result = work();
    (start.elapsed().as_secs_f64() * 1e3, result)
}
