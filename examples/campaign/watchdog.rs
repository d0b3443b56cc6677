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

    fn running_longer_than(&self, seconds: f64) -> Option<usize> {
        let now = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        now.filter(|(_, since)| since.elapsed().as_secs_f64() > seconds).map(|(job, _)| job)
    }
}

/// Waits until the other end of `finished` is gone. A case that runs longer than `seconds` cannot be stopped from outside: it
/// is named, and the program ends with status 3.
pub(crate) fn watch(finished: &Receiver<()>, workers: &[Started], seconds: f64, mesh: &str, jobs: &[Job]) {
    while let Err(RecvTimeoutError::Timeout) = finished.recv_timeout(Duration::from_millis(250)) {
        if let Some(job) = workers.iter().find_map(|w| w.running_longer_than(seconds)) {
            eprintln!("{mesh}: {:?} has not ended after {seconds} s: giving up", jobs[job]);
            process::exit(3);
        }
    }
}
