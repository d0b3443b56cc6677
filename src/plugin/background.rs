//! Traces as requests: answered at once, or by background tasks, of which a spline has at most one, and one for its preview.

use std::sync::Arc;

use bevy::platform::time::Instant;
use bevy::tasks::{AsyncComputeTaskPool, ComputeTaskPool, Task, TaskPool, block_on, futures_lite::future};

use super::costs;
use super::preview::{PreviewKind, TracePreview, rough};
use super::surface::BuiltSurface;
use super::trace::{Polyline, SplineTrace};
use super::workspaces::Workspaces;
use crate::curve::{SegmentTrace, Spline, Trace, TraceError, TraceWorkspace};
use crate::surface::Surface;

/// Where all previews and exact traces share one thread, an exact one waits while newer previews are wanted; after this many
/// it is its turn all the same, so that it comes even if the spline never rests.
const PREVIEWS_IN_A_ROW: u32 = 8;

/// On surfaces of so many faces a search takes some milliseconds even if it looks at all of them.
pub(crate) const SAFE_FACES: usize = 10_000;

/// A trace that is wanted.
pub(crate) struct Request {
    spline: Arc<Spline>,
    surface: Arc<Surface>,
    /// A trace whose segments the result may share.
    known: Option<SplineTrace>,
    /// The segments that it has not.
    missing: Vec<usize>,
    work: f64,
}

/// What came of a request.
pub(crate) struct Outcome {
    pub(crate) result: Result<SplineTrace, TraceError>,
    /// Modelled work, and the seconds that it took.
    pub(crate) work: f64,
    pub(crate) seconds: f64,
    /// How many segments were traced.
    pub(crate) traced: u32,
}

impl Request {
    pub(crate) fn new(spline: Arc<Spline>, surface: Arc<Surface>, known: Option<SplineTrace>) -> Self {
        let missing = costs::segments_to_trace(&spline, known.as_ref().map(|known| &**known.spline()));
        let work = costs::trace_work(&surface, &spline, &missing);
        Self { spline, surface, known, missing, work }
    }

    /// Whether a frame may answer it itself where that is expected to fit in. On a larger surface a search may take many times
    /// what was expected, and it cannot be stopped: there a task does it, and the frame waits for that as long as it has time.
    pub(crate) fn is_safe(&self) -> bool {
        self.missing.is_empty() || self.surface.face_count() <= SAFE_FACES
    }

    /// Modelled work.
    pub(crate) fn work(&self) -> f64 {
        self.work
    }

    /// Answers it here and now.
    pub(crate) fn answer(&self, workspaces: &Workspaces) -> Outcome {
        let begin = Instant::now();
        let known = self.known.as_ref().map(|known| &**known.trace());
        let traced = workspaces.lend(|workspace| self.spline.trace(&self.surface, workspace, known));
        self.outcome(traced, begin.elapsed().as_secs_f64())
    }

    /// Answers it in a task: its segments side by side, where that is possible.
    async fn answer_aside(self, workspaces: Workspaces) -> Outcome {
        if self.missing.len() < 2 || self.spline.scheme().method.is_b_spline() {
            return self.answer(&workspaces);
        }
        let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
        let trace = |segment| {
            let (spline, surface, workspaces) =
                (alone(&self.spline, segment), self.surface.clone(), workspaces.clone());
            pool.spawn(async move {
                let begin = Instant::now();
                let traced = workspaces.lend(|workspace| spline.trace(&surface, workspace, None));
                (traced, begin.elapsed().as_secs_f64())
            })
        };
        let tasks: Vec<_> = self.missing.iter().map(|segment| trace(*segment)).collect();
        let (mut segments, mut seconds) = (Vec::with_capacity(tasks.len()), 0.0);
        for task in tasks {
            let (traced, took) = task.await;
            seconds += took;
            match traced {
                Ok(trace) => segments.extend_from_slice(trace.segments()),
                Err(error) => return self.outcome(Err(error), seconds),
            }
        }
        let begin = Instant::now();
        let traced = workspaces.lend(|workspace| self.assemble(segments, workspace));
        self.outcome(traced, seconds + begin.elapsed().as_secs_f64())
    }

    /// The whole trace from known segments and those that were missing. What goes where is decided by tracing once more: it
    /// takes a segment only if that is the one it would compute.
    fn assemble(&self, traced: Vec<Arc<SegmentTrace>>, workspace: &mut TraceWorkspace) -> Result<Trace, TraceError> {
        let mut traced = self.missing.iter().zip(traced).peekable();
        let mut segments = Vec::with_capacity(self.spline.segment_count());
        for i in 0..self.spline.segment_count() {
            let found = match traced.next_if(|(missing, _)| **missing == i) {
                Some((_, segment)) => Some(segment),
                None => self.known.as_ref().and_then(|known| {
                    let place = costs::segment_in(known.spline(), &self.spline, i)?;
                    known.segments().get(place).cloned()
                }),
            };
            segments.extend(found);
        }
        let whole = self.spline.trace(&self.surface, workspace, Some(&Trace::new(segments, Vec::new())))?;
        let retraced = self.missing.iter().map(|i| *i as u32).collect();
        Ok(Trace::new(whole.segments().to_vec(), retraced))
    }

    fn outcome(&self, traced: Result<Trace, TraceError>, seconds: f64) -> Outcome {
        let count = traced.as_ref().map_or(0, |trace| trace.retraced().len() as u32);
        let result = traced.map(|trace| SplineTrace::new(trace, self.spline.clone(), &self.surface));
        Outcome { result, work: self.work, seconds, traced: count }
    }
}

/// Answers some requests at once, in order; side by side if there are several.
pub(crate) fn answer_all(requests: &[Request], workspaces: &Workspaces) -> Vec<Outcome> {
    if requests.len() < 2 {
        return requests.iter().map(|request| request.answer(workspaces)).collect();
    }
    ComputeTaskPool::get_or_init(TaskPool::default).scope(|scope| {
        for request in requests {
            scope.spawn(async move { request.answer(workspaces) });
        }
    })
}

/// A segment of a chain of Bézier segments as a spline of its own, with the same trace.
fn alone(spline: &Spline, segment: usize) -> Spline {
    let ends = [segment, (segment + 1) % spline.anchors.len()];
    let anchors = ends.map(|i| spline.anchors[i].clone()).into();
    Spline { anchors, closed: false, scheme: spline.scheme, jumps: spline.jumps }
}

/// An exact trace that came from the background.
pub(crate) struct Arrival {
    pub(crate) outcome: Outcome,
    /// Whether the spline is still the one that was traced.
    pub(crate) is_current: bool,
    /// If not, it may be shown.
    pub(crate) preview: Option<TracePreview>,
}

/// The background work about one spline on one surface; dropping it stops what has not begun.
pub(crate) struct Job {
    surface: Arc<Surface>,
    /// The number of the spline as it is now; the one before all this had number 0.
    version: u64,
    /// Its trace, before a task is begun for it.
    queued: Option<Request>,
    /// Whether it takes so long that it gets a preview of its own.
    is_long: bool,
    exact: Option<Errand<Outcome>>,
    preview: Option<Errand<Result<(Trace, Polyline), TraceError>>>,
    /// The newest exact trace, of a spline that is no longer.
    newest: Option<SplineTrace>,
    /// The newest rough trace, and the spline that a preview was last begun of.
    rough: Option<Trace>,
    previewed: Option<u64>,
    previews_in_a_row: u32,
    /// The spline that the newest preview shows.
    shown: Option<u64>,
}

/// A task, and the version of the spline that it is about.
struct Errand<T> {
    version: u64,
    task: Task<T>,
}

impl<T: Send + 'static> Errand<T> {
    fn begin(version: u64, work: impl Future<Output = T> + Send + 'static) -> Self {
        Self { version, task: AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(work) }
    }
}

/// Lets the frame wait for a task, for so many seconds at most; whether it is done.
pub(crate) fn wait_for<T>(task: &Task<T>, seconds: f64) -> bool {
    let begin = Instant::now();
    while !task.is_finished() && begin.elapsed().as_secs_f64() < seconds {
        // Whoever sleeps may wake too late, by more than all of this is about.
        std::thread::yield_now();
    }
    task.is_finished()
}

/// The result of an errand that is done, with its version.
fn collect<T>(errand: &mut Option<Errand<T>>) -> Option<(u64, T)> {
    let running = errand.as_mut()?;
    let result = block_on(future::poll_once(&mut running.task))?;
    let version = running.version;
    *errand = None;
    Some((version, result))
}

impl Job {
    pub(crate) fn new(surface: Arc<Surface>) -> Self {
        Self {
            surface,
            version: 1,
            queued: None,
            is_long: false,
            exact: None,
            preview: None,
            newest: None,
            rough: None,
            previewed: None,
            previews_in_a_row: 0,
            shown: None,
        }
    }

    pub(crate) fn is_on(&self, surface: &BuiltSurface) -> bool {
        Arc::ptr_eq(&self.surface, &surface.0)
    }

    /// The newest exact trace, of a spline that is no longer; newer than the entity's.
    pub(crate) fn newest(&self) -> Option<&SplineTrace> {
        self.newest.as_ref()
    }

    /// The spline has changed: what is queued is of no use.
    pub(crate) fn replace(&mut self) {
        self.version += 1;
        self.queued = None;
    }

    /// Whether the trace of the spline as it is now is neither running nor queued.
    pub(crate) fn is_idle(&self) -> bool {
        self.queued.is_none() && self.exact.as_ref().is_none_or(|exact| exact.version != self.version)
    }

    pub(crate) fn queue(&mut self, request: Request, is_long: bool) {
        self.queued = Some(request);
        self.is_long = is_long;
    }

    /// Lets the frame wait for the trace of the spline as it is now, if that has begun, for so many seconds at most.
    pub(crate) fn wait(&self, seconds: f64) {
        if let Some(exact) = self.exact.as_ref().filter(|exact| exact.version == self.version) {
            wait_for(&exact.task, seconds);
        }
    }

    /// Fetches an exact trace that is done.
    pub(crate) fn collect_exact(&mut self) -> Option<Arrival> {
        let (version, outcome) = collect(&mut self.exact)?;
        if version == self.version {
            return Some(Arrival { outcome, is_current: true, preview: None });
        }
        let mut preview = None;
        if let Ok(trace) = &outcome.result {
            preview = self.show(version, PreviewKind::Previous, trace.shown());
            self.newest = Some(trace.clone());
            // The trace of the spline as it is now may share segments with this one.
            self.queued = None;
        }
        Some(Arrival { outcome, is_current: false, preview })
    }

    /// Fetches a preview of its own that is done, unless something newer is shown.
    pub(crate) fn collect_preview(&mut self) -> Option<TracePreview> {
        let (version, traced) = collect(&mut self.preview)?;
        let (trace, polyline) = traced.ok()?;
        self.rough = Some(trace);
        self.show(version, PreviewKind::Fast, polyline)
    }

    /// What there was before, as a preview.
    pub(crate) fn show_before(&mut self, polyline: Polyline) -> Option<TracePreview> {
        self.show(0, PreviewKind::Previous, polyline)
    }

    /// A preview of some version, unless a newer one is shown.
    fn show(&mut self, version: u64, kind: PreviewKind, polyline: Polyline) -> Option<TracePreview> {
        if self.shown.is_some_and(|shown| shown >= version) {
            return None;
        }
        self.shown = Some(version);
        Some(TracePreview::new(kind, polyline))
    }

    /// Begins what is to be begun.
    pub(crate) fn go_on(&mut self, workspaces: &Workspaces) {
        if self.is_long
            && self.preview.is_none()
            && self.previewed != Some(self.version)
            && let Some(request) = &self.queued
        {
            let preview =
                trace_roughly(request.spline.clone(), self.surface.clone(), self.rough.take(), workspaces.clone());
            self.preview = Some(Errand::begin(self.version, preview));
            self.previewed = Some(self.version);
            self.previews_in_a_row += 1;
        }
        let has_threads = AsyncComputeTaskPool::get_or_init(TaskPool::default).thread_num() > 1;
        let has_turn = self.preview.is_none() || has_threads || self.previews_in_a_row >= PREVIEWS_IN_A_ROW;
        if self.exact.is_none()
            && has_turn
            && let Some(request) = self.queued.take()
        {
            self.previews_in_a_row = 0;
            self.exact = Some(Errand::begin(self.version, request.answer_aside(workspaces.clone())));
        }
    }
}

/// The preview of a spline; `known` may share segments with it.
async fn trace_roughly(
    spline: Arc<Spline>,
    surface: Arc<Surface>,
    known: Option<Trace>,
    workspaces: Workspaces,
) -> Result<(Trace, Polyline), TraceError> {
    let trace = workspaces.lend(|workspace| rough(&spline).trace(&surface, workspace, known.as_ref()))?;
    let polyline = Polyline::of(&trace);
    Ok((trace, polyline))
}
