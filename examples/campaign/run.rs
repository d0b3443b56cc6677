//! Runs all cases of a mesh on some threads.

use std::{
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
        mpsc,
    },
    thread,
};

use crate::{
    args::Args,
    outcome::{Job, Outcome},
    prepare::Prepared,
    random::SplitMix64,
    watchdog::{self, Started},
    worker::{Rules, Worker},
};

/// Outcomes of all cases, in their order, whatever the order and the threads they were done by.
pub(crate) fn run(mesh: &Prepared, args: &Args) -> Vec<Outcome> {
    let jobs = jobs(mesh, args);
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    if let Some(seed) = args.shuffle {
        SplitMix64::new(seed).shuffle(&mut order);
    }
    let rules = Rules { schemes: &args.schemes, quality: args.quality, timeout_s: args.timeout_s, fresh: args.fresh };
    let done: Mutex<Vec<Option<Outcome>>> = Mutex::new(vec![None; jobs.len()]);
    let next = AtomicUsize::new(0);
    let threads = args.threads.min(jobs.len()).max(1);
    let started: Vec<Started> = (0..threads).map(|_| Started::default()).collect();
    let work = |started: &Started| {
        let mut worker = Worker::new(mesh, rules);
        while let Some(&i) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            started.begin(i);
            let outcome = worker.run(jobs[i]);
            started.end();
            done.lock().unwrap_or_else(PoisonError::into_inner)[i] = Some(outcome);
        }
    };
    let patience = |job| match job {
        Job::Curve { scheme, .. } if args.schemes[scheme].is_for_comparison() => 100.0 * args.timeout_s,
        _ => 10.0 * args.timeout_s,
    };
    thread::scope(|scope| {
        let (finished, wait) = mpsc::channel();
        let (started, jobs, work) = (&started, &jobs, &work);
        scope.spawn(move || watchdog::watch(&wait, started, patience, &mesh.name, jobs));
        thread::scope(|workers| started.iter().for_each(|s| drop(workers.spawn(move || work(s)))));
        drop(finished);
    });
    done.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().flatten().collect()
}

fn jobs(mesh: &Prepared, args: &Args) -> Vec<Job> {
    let schemes = 0..args.schemes.len();
    let curves = schemes.flat_map(|scheme| (0..mesh.polygons()).map(move |case| Job::Curve { case, scheme }));
    curves.chain((0..mesh.pairs.len()).map(|case| Job::Pair { case })).collect()
}
