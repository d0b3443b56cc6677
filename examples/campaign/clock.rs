//! Time and memory, as the system counts them.

use std::{fs, time::Instant};

/// Measures the CPU time of the calling thread.
///
/// The system's own counter of a thread's CPU time moves by scheduler ticks of some milliseconds when it is read from
/// `/proc`, which is too coarse for one curve. What is exact there is the time a thread spent ready but waiting for a core; so
/// CPU time is taken as wall time less that. The work measured must not sleep. Elsewhere than on Linux it is wall time.
pub(crate) struct CpuClock {
    waited: u64,
    started: Instant,
}

impl CpuClock {
    pub(crate) fn start() -> Self {
        Self { waited: waited_ns(), started: Instant::now() }
    }

    /// Milliseconds since the start.
    pub(crate) fn ms(&self) -> f64 {
        let wall = self.started.elapsed().as_nanos() as f64;
        let waited = waited_ns().saturating_sub(self.waited) as f64;
        (wall - waited).max(0.0) * 1e-6
    }
}

/// Nanoseconds that this thread was ready but did not run: the second number of its `schedstat`.
fn waited_ns() -> u64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split_whitespace().nth(1).and_then(|n| n.parse().ok()).unwrap_or(0)
}

/// The most memory the process has held since [`forget_peak`], in MB; none where the system does not say.
pub(crate) fn peak_mb() -> Option<f64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kb: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kb * 1024e-6)
}

/// Starts the count of [`peak_mb`] anew, where the system allows it.
pub(crate) fn forget_peak() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_passes_and_memory_is_held() {
        let clock = CpuClock::start();
        let sum: f64 = (0..200_000).map(|i| f64::from(i).sqrt()).sum();
        assert!(sum > 0.0 && clock.ms() > 0.0);
        if cfg!(target_os = "linux") {
            assert!(peak_mb().is_some_and(|mb| mb > 0.1));
        }
    }
}
