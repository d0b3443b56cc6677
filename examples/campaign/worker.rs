//! Does one case after the other, with one workspace.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bevy_surface_splines::{
    curve::Tracer,
    geodesic::{PathFinder, PathQuality},
    surface::{FaceId, PointError, Surface, SurfacePoint},
};

use crate::{
    cases::CasePoint,
    clock::CpuClock,
    hash::Fnv,
    judge::{self, Rejected},
    outcome::{Job, Outcome, Status, Verdict},
    prepare::Prepared,
    scheme::NamedScheme,
};

/// What holds for all cases of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules<'a> {
    pub(crate) schemes: &'a [NamedScheme],
    /// Of paths between pairs; schemes have their own.
    pub(crate) quality: PathQuality,
    pub(crate) timeout_s: f64,
    /// A fresh workspace for every case.
    pub(crate) fresh: bool,
}

/// Works through cases of one mesh.
pub(crate) struct Worker<'a> {
    mesh: &'a Prepared,
    rules: Rules<'a>,
    /// None until it is needed, and after a panic, which may have left it in any state.
    tracer: Option<Tracer<'a>>,
    finder: Option<PathFinder>,
    points: Vec<SurfacePoint>,
}

impl<'a> Worker<'a> {
    pub(crate) fn new(mesh: &'a Prepared, rules: Rules<'a>) -> Self {
        Self { mesh, rules, tracer: None, finder: None, points: Vec::new() }
    }

    /// Does one case. A panic of what is tested is a failed case, not the end.
    pub(crate) fn run(&mut self, job: Job) -> Outcome {
        if self.rules.fresh {
            (self.tracer, self.finder) = (None, None);
        }
        let done = catch_unwind(AssertUnwindSafe(|| match job {
            Job::Curve { case, scheme } => self.curve(job, case, &self.rules.schemes[scheme]),
            Job::Pair { case } => self.pair(job, case),
        }));
        let outcome = done.unwrap_or_else(|_| {
            (self.tracer, self.finder) = (None, None);
            Outcome::new(job).ended(Status::Error("panic"), "the library panicked")
        });
        if self.in_time(outcome.ms.max(outcome.ms_points)) {
            return outcome;
        }
        let status = match job {
            Job::Curve { scheme, .. } if self.may_be_slow(scheme, outcome.status) => Status::Slow,
            _ => Status::Timeout,
        };
        outcome.ended(status, "it took longer than allowed")
    }

    fn in_time(&self, ms: f64) -> bool {
        ms <= self.rules.timeout_s * 1e3
    }

    /// Being slow excuses no other failure.
    fn may_be_slow(&self, scheme: usize, status: Status) -> bool {
        self.rules.schemes[scheme].is_for_comparison() && status.verdict() != Verdict::Failed
    }

    fn curve(&mut self, job: Job, case: usize, scheme: &NamedScheme) -> Outcome {
        let (surface, topology) = (&self.mesh.surface, &self.mesh.topology);
        let mut outcome = Outcome::new(job);
        let polygon = match self.mesh.polygon(case) {
            Ok(polygon) => polygon,
            Err(error) => return rejected(outcome, judge::point_refused(&error)),
        };
        let polygon = &polygon[..scheme.takes];
        let tracer = self.tracer.get_or_insert_with(|| Tracer::new(surface));
        let clock = CpuClock::start();
        let counted = tracer.trace_points(polygon, &scheme.scheme, &mut self.points);
        outcome.ms_points = clock.ms();
        if counted.is_ok() && outcome.ms_points > self.rules.timeout_s * 1e3 {
            return outcome; // the rest takes no less
        }
        let clock = CpuClock::start();
        let traced = tracer.trace(polygon, &scheme.scheme);
        outcome.ms = clock.ms();
        let trace = match (counted, traced) {
            (Ok(_), Ok(trace)) => trace,
            (Err(error), _) | (_, Err(error)) => return rejected(outcome, judge::trace_refused(topology, &error)),
        };
        outcome.points = self.points.len();
        outcome.length = trace.length();
        let mut hash = Fnv::default();
        trace.segments().iter().flat_map(|s| s.paths()).for_each(|path| hash.path(path));
        outcome.hash = hash.0;
        match judge::trace(surface, topology, polygon, scheme, &trace, &self.points) {
            Ok(judged) => {
                outcome.undecided = judged.undecided;
                outcome.max_turn_deg = judged.max_turn_deg;
                outcome.status = judged.status;
                outcome
            }
            Err(reason) => rejected(outcome, reason),
        }
    }

    fn pair(&mut self, job: Job, case: usize) -> Outcome {
        let (surface, topology) = (&self.mesh.surface, &self.mesh.topology);
        let mut outcome = Outcome::new(job);
        let [from, to] = match self.mesh.pair(case) {
            Ok(pair) => pair,
            Err(error) => return rejected(outcome, judge::point_refused(&error)),
        };
        let finder = self.finder.get_or_insert_with(PathFinder::new);
        let clock = CpuClock::start();
        let found = finder.shortest_with_quality(surface, &from, &to, self.rules.quality);
        outcome.ms = clock.ms();
        let path = match found {
            Ok(path) => path,
            Err(error) => return rejected(outcome, judge::path_refused(topology, &error)),
        };
        outcome.points = 2;
        outcome.length = path.length();
        let mut hash = Fnv::default();
        hash.path(&path);
        outcome.hash = hash.0;
        match judge::path(surface, topology, &path, &from, &to) {
            Ok(undecided) => outcome.undecided = undecided,
            Err(reason) => return rejected(outcome, reason),
        }
        outcome
    }
}

fn rejected(outcome: Outcome, reason: Rejected) -> Outcome {
    outcome.ended(reason.status, reason.detail)
}

/// The points of a case on a surface.
pub(crate) fn on_surface<const N: usize>(
    surface: &Surface,
    points: &[CasePoint; N],
) -> Result<[SurfacePoint; N], PointError> {
    let mut out = [SurfacePoint { face: FaceId(0), weights: [1.0, 0.0, 0.0] }; N];
    for (out, point) in out.iter_mut().zip(points) {
        *out = surface.point(FaceId(point.face), point.weights())?;
    }
    Ok(out)
}
