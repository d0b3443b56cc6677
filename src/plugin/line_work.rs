//! Smoothing as wishes: answered at once, or by a background task, of which a line has at most one.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use bevy::ecs::entity::EntityHashMap;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on, futures_lite::future};

use super::costs::Pace;
use super::smoothed_line::{SmoothedLine, positions};
use super::trace::Polyline;
use super::workspaces::Workspaces;
use crate::smooth::{
    LiveSmoothing, SmoothError, SmoothProgress, SmoothWorkspace, Smoothed, Smoothing, SmoothingMode, SurfacePolyline,
    bends_into, measure,
};
use crate::surface::Surface;

/// Seconds for each line, and each of its crossings: measured, and smoothed.
const PER_LINE: f64 = 1e-5;
const PER_CROSSING: f64 = 1e-6;
const PER_SMOOTHED: f64 = 4e-6;

/// A line that was drawn, on its surface.
#[derive(Debug)]
pub(crate) struct Given {
    pub(crate) line: Arc<SurfacePolyline>,
    pub(crate) surface: Arc<Surface>,
    polyline: OnceLock<Polyline>,
}

impl Given {
    pub(crate) fn new(line: SurfacePolyline, surface: Arc<Surface>) -> Self {
        Self { line: Arc::new(line), surface, polyline: OnceLock::new() }
    }

    fn polyline(&self) -> Polyline {
        let make = || Polyline::unbroken(positions(&self.surface, &self.line).iter().map(|p| p.as_vec3()));
        self.polyline.get_or_init(make).clone()
    }
}

/// What is wished for of a line.
#[derive(Clone, Debug)]
pub(crate) struct Wish {
    pub(crate) given: Arc<Given>,
    /// None: it stays as it was drawn.
    pub(crate) smoothing: Option<Smoothing>,
}

/// What depends on a line alone: to be used again for the next wish.
pub(crate) struct Prepared {
    given: Arc<Given>,
    /// All but the mode and the range, which may change.
    rest: Smoothing,
    live: LiveSmoothing,
}

/// What came of a wish.
pub(crate) struct Outcome {
    pub(crate) result: Result<SmoothedLine, SmoothError>,
    pub(crate) prepared: Option<Box<Prepared>>,
    pub(crate) seconds: f64,
}

impl Wish {
    /// Modelled work, in seconds.
    pub(crate) fn work(&self) -> f64 {
        let each = if self.smoothing.is_some() { PER_SMOOTHED } else { PER_CROSSING };
        PER_LINE + each * self.given.line.crossings().len() as f64
    }

    /// Answers it here and now, asking after every round whether to go on.
    pub(crate) fn answer(
        &self,
        mut prepared: Option<Box<Prepared>>,
        workspaces: &Workspaces<SmoothWorkspace>,
        go_on: &mut dyn FnMut(&SmoothProgress) -> ControlFlow<()>,
    ) -> Outcome {
        let begin = Instant::now();
        let result = self.smoothed(&mut prepared, workspaces, go_on).and_then(|smoothed| {
            let surface = &self.given.surface;
            let mut bends = Vec::new();
            workspaces.lend(|workspace| bends_into(surface, workspace, &smoothed.line, &mut bends))?;
            let drawn = (self.given.line.clone(), self.given.polyline());
            Ok(SmoothedLine::new(smoothed, self.smoothing, drawn, bends, surface))
        });
        Outcome { result, prepared, seconds: begin.elapsed().as_secs_f64() }
    }

    fn smoothed(
        &self,
        prepared: &mut Option<Box<Prepared>>,
        workspaces: &Workspaces<SmoothWorkspace>,
        go_on: &mut dyn FnMut(&SmoothProgress) -> ControlFlow<()>,
    ) -> Result<Smoothed, SmoothError> {
        let Given { line, surface, .. } = &*self.given;
        let mut out = Smoothed::blank();
        match self.smoothing {
            None => {
                let metrics = workspaces.lend(|workspace| measure(surface, workspace, line, None))?;
                (out.before, out.after, out.kept) = (metrics, metrics, true);
                out.line.clone_from(line);
            }
            Some(smoothing) => {
                let live = &mut self.prepare(prepared, smoothing)?.live;
                live.set_range(smoothing.range);
                out.clone_from(live.smooth_by(surface, smoothing.mode, go_on)?);
            }
        }
        Ok(out)
    }

    /// Prepares the line, as far as that is not done.
    fn prepare<'p>(
        &self,
        prepared: &'p mut Option<Box<Prepared>>,
        smoothing: Smoothing,
    ) -> Result<&'p mut Prepared, SmoothError> {
        let rest = Smoothing { mode: SmoothingMode::default(), range: None, ..smoothing };
        let Given { line, surface, .. } = &*self.given;
        let mut next = match prepared.take() {
            Some(known) if known.rest == rest => known,
            _ => {
                let live = LiveSmoothing::new(surface, (**line).clone(), rest)?;
                Box::new(Prepared { given: self.given.clone(), rest, live })
            }
        };
        if !Arc::ptr_eq(&next.given, &self.given) {
            next.live.take_up(surface, (**line).clone())?;
            next.given = self.given.clone();
        }
        Ok(prepared.insert(next))
    }

    /// Begins to answer it in a task.
    pub(crate) fn begin(self, prepared: Option<Box<Prepared>>, workspaces: Workspaces<SmoothWorkspace>) -> Running {
        let (watch, wish) = (Arc::new(Watch::default()), self.clone());
        let seen = watch.clone();
        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(async move {
            if seen.stop.load(Ordering::Relaxed) {
                return Outcome { result: Err(SmoothError::Stopped), prepared, seconds: 0.0 };
            }
            self.answer(prepared, &workspaces, &mut |progress| seen.look(progress))
        });
        Running { wish, begun: Instant::now(), watch, task }
    }
}

/// What a task and the frames tell each other.
#[derive(Debug, Default)]
struct Watch {
    stop: AtomicBool,
    rounds: AtomicU32,
    length: AtomicU64,
}

impl Watch {
    fn look(&self, progress: &SmoothProgress) -> ControlFlow<()> {
        self.rounds.store(progress.rounds, Ordering::Relaxed);
        self.length.store(progress.length.to_bits(), Ordering::Relaxed);
        if self.stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// A wish that a task answers; dropping it asks the task to stop.
pub(crate) struct Running {
    pub(crate) wish: Wish,
    begun: Instant,
    watch: Arc<Watch>,
    task: Task<Outcome>,
}

impl Running {
    /// Asks the task to stop; it ends soon after, and gives back what was prepared.
    pub(crate) fn stop(&self) {
        self.watch.stop.store(true, Ordering::Relaxed);
    }

    /// Seconds since it began.
    pub(crate) fn age(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }

    /// How often vertices were passed, and how long the line is.
    pub(crate) fn progress(&self) -> (u32, f64) {
        (self.watch.rounds.load(Ordering::Relaxed), f64::from_bits(self.watch.length.load(Ordering::Relaxed)))
    }

    /// What came of it, if it is done.
    pub(crate) fn collect(&mut self) -> Option<Outcome> {
        block_on(future::poll_once(&mut self.task))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop();
    }
}

/// What is known of the lines besides their components.
#[derive(Resource, Default)]
pub(crate) struct Wishes {
    pub(crate) of: EntityHashMap<Record>,
    /// How long smoothing takes, of whatever line.
    pub(crate) pace: Pace,
}

/// What is known of one line.
#[derive(Default)]
pub(crate) struct Record {
    /// The newest wish.
    pub(crate) wish: Option<Wish>,
    /// Whether it is neither answered nor being answered.
    pub(crate) is_due: bool,
    pub(crate) running: Option<Running>,
    pub(crate) prepared: Option<Box<Prepared>>,
    /// How long it takes; none before the first time.
    pub(crate) pace: Option<Pace>,
    /// Updates since anything was wished for.
    pub(crate) at_rest: u32,
}
