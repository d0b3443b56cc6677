//! Ends the program when a case does not end.

use std::{
    process,
    sync::{
        Mutex, PoisonError,
        mpsc::{Receiver, RecvTimeoutError},
    },
    time::{Duration, Instant},
};

use crate::outcome::Job;

/// What a worker is doing, and since when.
#[derive(Debug, Default)]
pub(crate) struct Started(Mutex<Option<(usize, Instant)>>);

impl Started {
    pub(crate) fn begin(&self, job: usize) {
        self.set(Some((job, Instant::now())));
    }

    pub(crate) fn end(&self) {
        self.set(None);
    }

    fn set(&self, to: Option<(usize, Instant)>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = to;
    }

    /// The job that is running, and for how many seconds.
    fn running(&self) -> Option<(usize, f64)> {
        let now = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        now.map(|(job, since)| (job, since.elapsed().as_secs_f64()))
    }
}

/// Waits until the other end of `finished` is gone. A case that runs longer than `patience` says, in seconds, cannot be stopped
/// from outside: it is named, and the program ends with status 3.
pub(crate) fn watch(
    finished: &Receiver<()>,
    workers: &[Started],
    patience: impl Fn(Job) -> f64,
    mesh: &str,
    jobs: &[Job],
) {
    while let Err(RecvTimeoutError::Timeout) = finished.recv_timeout(Duration::from_millis(250)) {
        let overdue = |(job, seconds): &(usize, f64)| *seconds > patience(jobs[*job]);
        if let Some((job, seconds)) = workers.iter().filter_map(Started::running).find(overdue) {
            eprintln!("{mesh}: {:?} has not ended after {seconds:.0} s: giving up", jobs[job]);
            process::exit(3);
        }
    }
}
