//! Traces follow their splines: in the same frame if that has time for it, else in the background. Only segments that
//! changed are traced again.

use std::sync::Arc;

use bevy::ecs::entity::EntityHashMap;
use bevy::log::warn;
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::background::{Arrival, Job, Outcome, Request, answer_all};
use super::budget::{self, FrameTime, TraceBudget};
use super::costs::Pace;
use super::preview::{TracePreview, remove_preview};
use super::spline::{SplineState, SurfaceSpline, without_surface};
use super::surface::{BuiltSurface, OnSurface, SurfaceState};
use super::trace::{SplineTrace, TraceChanged};
use super::workspaces::Workspaces;

/// What tracing cost in the last frame that had to do with it.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct TraceStatistics {
    /// Time that the frame itself spent, in milliseconds.
    pub milliseconds: f64,
    /// Time that background tasks had spent on the traces that came from them in that frame, in milliseconds.
    pub background_milliseconds: f64,
    /// Segments traced, in the frame itself or in those tasks.
    pub segments: u32,
}

/// Traces splines.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Trace`].
#[derive(Debug, Default)]
pub struct RetracePlugin;

impl Plugin for RetracePlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        budget::configure(app);
        app.register_type::<TraceStatistics>()
            .init_resource::<TraceStatistics>()
            .init_resource::<Workspaces>()
            .init_resource::<Records>()
            .add_observer(remove_preview)
            .add_systems(PostUpdate, retrace_splines.in_set(SurfaceSplineSystems::Trace));
    }
}

/// What is known of the splines' traces besides the traces themselves.
#[derive(Resource, Default)]
pub(crate) struct Records {
    of: EntityHashMap<Record>,
    /// How long traces take, of whatever spline.
    pace: Pace,
}

/// What is known of one spline's traces.
#[derive(Default)]
struct Record {
    /// How long they take; none before the first.
    pace: Option<Pace>,
    /// The work in the background.
    job: Option<Job>,
}

type Splines<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        Ref<'static, SurfaceSpline>,
        Ref<'static, OnSurface>,
        Option<&'static SplineTrace>,
        Has<TracePreview>,
        &'static mut SplineState,
    ),
>;
type Surfaces<'w, 's> = Query<'w, 's, (Option<Ref<'static, BuiltSurface>>, Option<&'static SurfaceState>)>;

pub(crate) fn retrace_splines(
    commands: Commands,
    mut records: ResMut<Records>,
    mut statistics: ResMut<TraceStatistics>,
    (budget, mut frame, workspaces): (Res<TraceBudget>, ResMut<FrameTime>, Res<Workspaces>),
    mut splines: Splines,
    surfaces: Surfaces,
) {
    let begin = Instant::now();
    records.of.retain(|entity, _| splines.contains(*entity));
    let mut desk = Desk {
        commands,
        records: &mut records,
        workspaces: &workspaces,
        budget: *budget,
        left: frame.left(&budget),
        now: Vec::new(),
        soon: Vec::new(),
        done: Vec::new(),
        statistics: None,
    };
    desk.look_at_all(&mut splines, &surfaces);
    desk.trace_now();
    desk.wait(frame.left(&budget), begin, &mut splines, &surfaces);
    desk.deliver(&mut splines);
    frame.spend(begin.elapsed());
    if let Some(made) = desk.statistics {
        *statistics = TraceStatistics { milliseconds: begin.elapsed().as_secs_f64() * 1e3, ..made };
    }
}

/// The traces of one frame.
struct Desk<'a, 'w, 's> {
    commands: Commands<'w, 's>,
    records: &'a mut Records,
    workspaces: &'a Workspaces,
    budget: TraceBudget,
    /// Seconds that this frame has left.
    left: f64,
    /// What is traced in this frame.
    now: Vec<(Entity, Request)>,
    /// What was begun in the background and should be there before this frame is over.
    soon: Vec<Entity>,
    done: Vec<(Entity, Outcome)>,
    /// If anything was traced or begun.
    statistics: Option<TraceStatistics>,
}

/// A spline as a frame finds it, on a surface that is built.
struct Found<'q> {
    entity: Entity,
    spline: &'q SurfaceSpline,
    surface: &'q BuiltSurface,
    trace: Option<&'q SplineTrace>,
    /// Whether it was changed, or its surface, and whether it came to another one.
    has_changed: bool,
    has_moved: bool,
}

impl<'q> Found<'q> {
    fn new(
        entity: Entity,
        spline: &'q Ref<SurfaceSpline>,
        on: &Ref<OnSurface>,
        surface: &'q Ref<BuiltSurface>,
        trace: Option<&'q SplineTrace>,
    ) -> Self {
        let has_moved = on.is_changed();
        let has_changed = has_moved || spline.is_changed() || surface.is_changed();
        Self { entity, spline, surface, trace, has_changed, has_moved }
    }

    /// Its trace, if that is on its surface.
    fn known(&self) -> Option<&SplineTrace> {
        self.trace.filter(|trace| trace.is_on(self.surface))
    }

    fn request(&self, record: &Record) -> Request {
        let newest = record.job.as_ref().and_then(Job::newest).or(self.known());
        Request::new(Arc::new((**self.spline).clone()), self.surface.0.clone(), newest.cloned())
    }
}

impl Desk<'_, '_, '_> {
    fn look_at_all(&mut self, splines: &mut Splines, surfaces: &Surfaces) {
        for (entity, spline, on, trace, has_preview, mut state) in splines {
            let (built, surface_state) = surfaces.get(on.0).unwrap_or((None, None));
            let Some(built) = built else {
                state.set_if_neq(without_surface(surface_state));
                self.records.of.remove(&entity);
                if trace.is_some() || has_preview {
                    self.commands.entity(entity).try_remove::<(SplineTrace, TracePreview)>();
                }
                continue;
            };
            let found = Found::new(entity, &spline, &on, &built, trace);
            let mut record = self.records.of.remove(&entity).unwrap_or_default();
            self.look_at(&found, &mut record, &mut state);
            self.records.of.insert(entity, record);
        }
    }

    /// Finds out whether a spline is to be traced, now or in the background, and how its background work goes on.
    fn look_at(&mut self, found: &Found, record: &mut Record, state: &mut Mut<SplineState>) {
        record.job = record.job.take().filter(|job| job.is_on(found.surface));
        if let Some(job) = record.job.as_mut().filter(|_| found.has_changed) {
            job.replace();
        }
        if self.collect(found.entity, record) {
            return;
        }
        let is_due = match &record.job {
            Some(job) => job.is_idle(),
            None => found.has_changed || found.known().is_none() && !matches!(**state, SplineState::Failed { .. }),
        };
        if is_due {
            let request = found.request(record);
            let expected = record.pace.unwrap_or(self.records.pace).expect(request.work());
            let fits = expected <= self.left;
            if fits {
                self.left -= expected;
            }
            if fits && (request.is_safe() || self.left.is_infinite()) {
                record.job = None;
                self.now.push((found.entity, request));
            } else {
                let is_long = expected > self.budget.preview_after.as_secs_f64();
                record.job.get_or_insert_with(|| Job::new(found.surface.0.clone())).queue(request, is_long);
                if fits {
                    self.soon.push(found.entity);
                } else {
                    self.put_off(found, record, state);
                }
            }
        }
        if let Some(job) = &mut record.job {
            job.go_on(self.workspaces);
            self.statistics.get_or_insert_default();
        }
    }

    /// Shows that a trace is left to the background.
    fn put_off(&mut self, found: &Found, record: &mut Record, state: &mut Mut<SplineState>) {
        let (entity, Some(job)) = (found.entity, &mut record.job) else { return };
        state.set_if_neq(SplineState::Tracing);
        // In the space of another surface it would be somewhere else.
        let before = found.trace.filter(|_| !found.has_moved).and_then(|trace| job.show_before(trace.shown()));
        if let Some(before) = before {
            self.commands.entity(entity).try_insert(before);
        } else if found.has_moved {
            self.commands.entity(entity).try_remove::<TracePreview>();
        }
        if found.trace.is_some() && found.known().is_none() {
            self.commands.entity(entity).try_remove::<SplineTrace>();
        }
    }

    /// Waits for what was begun and should be there soon, for so many seconds at most; what is not is put off.
    fn wait(&mut self, seconds: f64, begin: Instant, splines: &mut Splines, surfaces: &Surfaces) {
        for entity in std::mem::take(&mut self.soon) {
            let mut record = self.records.of.remove(&entity).unwrap_or_default();
            if let Some(job) = &record.job {
                job.wait(seconds - begin.elapsed().as_secs_f64());
            }
            if !self.collect(entity, &mut record)
                && let Ok((_, spline, on, trace, _, mut state)) = splines.get_mut(entity)
                && let Ok((Some(built), _)) = surfaces.get(on.0)
            {
                let found = Found::new(entity, &spline, &on, &built, trace);
                self.put_off(&found, &mut record, &mut state);
            }
            self.records.of.insert(entity, record);
        }
    }

    /// Fetches what came from the background; whether that is the trace of the spline as it is now.
    fn collect(&mut self, entity: Entity, record: &mut Record) -> bool {
        let Some(job) = &mut record.job else { return false };
        let mut preview = job.collect_preview();
        let arrival = job.collect_exact();
        let is_current = arrival.as_ref().is_some_and(|arrival| arrival.is_current);
        if let Some(Arrival { outcome, preview: outdated, .. }) = arrival {
            preview = outdated.or(preview);
            let statistics = self.statistics.get_or_insert_default();
            statistics.background_milliseconds += outcome.seconds * 1e3;
            self.count(record, &outcome);
            if is_current {
                record.job = None;
                self.done.push((entity, outcome));
            }
        }
        if let Some(preview) = preview.filter(|_| !is_current) {
            self.commands.entity(entity).try_insert(preview);
        }
        is_current
    }

    /// Traces what this frame has time for.
    fn trace_now(&mut self) {
        let (entities, requests): (Vec<_>, Vec<_>) = std::mem::take(&mut self.now).into_iter().unzip();
        for (entity, outcome) in entities.into_iter().zip(answer_all(&requests, self.workspaces)) {
            let mut record = self.records.of.remove(&entity).unwrap_or_default();
            self.count(&mut record, &outcome);
            self.records.of.insert(entity, record);
            self.done.push((entity, outcome));
        }
    }

    /// Learns from what a trace took.
    fn count(&mut self, record: &mut Record, outcome: &Outcome) {
        if outcome.traced > 0 {
            self.statistics.get_or_insert_default().segments += outcome.traced;
            record.pace.get_or_insert(self.records.pace).learn(outcome.work, outcome.seconds);
            self.records.pace.learn(outcome.work, outcome.seconds);
        }
    }

    /// Hands traces over to their splines.
    fn deliver(&mut self, splines: &mut Splines) {
        for (entity, outcome) in std::mem::take(&mut self.done) {
            let Ok((_, _, _, before, _, mut state)) = splines.get_mut(entity) else { continue };
            let mut commands = self.commands.entity(entity);
            commands.try_remove::<TracePreview>();
            match outcome.result {
                Ok(trace) => {
                    state.set_if_neq(SplineState::Ready);
                    if before.is_some_and(|before| before.is_same(&trace)) {
                        continue;
                    }
                    let retraced = trace.segments_not_in(before);
                    commands.try_insert(trace);
                    self.commands.trigger(TraceChanged { entity, retraced });
                }
                Err(error) => {
                    let reason = error.to_string();
                    warn!("the spline {entity} cannot be traced: {reason}");
                    state.set_if_neq(SplineState::Failed { reason });
                    commands.try_remove::<SplineTrace>();
                }
            }
        }
    }
}
