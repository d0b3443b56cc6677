//! Smoothed lines follow their lines and what is wished of them: in the same frame if that has time for it, else in the background.

use std::ops::ControlFlow;
use std::sync::Arc;

use bevy::log::warn;
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::budget::{FrameTime, TraceBudget};
use super::costs::Pace;
use super::line::{LineChanged, LineFailed, LineSmoothing, LineState, SurfaceLine};
use super::line_work::{Given, Outcome, Record, Running, Wish, Wishes};
use super::smoothed_line::SmoothedLine;
use super::surface::{BuiltSurface, OnSurface, SurfaceState};
use super::workspaces::Workspaces;
use crate::smooth::{SmoothError, SmoothWorkspace, Smoothing};

/// For so many seconds a task may answer a wish that is no longer the newest: while a slider is moved, what comes of places it has
/// passed is shown. After that it is stopped, so that the newest does not wait for long.
const PATIENCE: f64 = 0.1;

/// After so many updates without a new wish what was prepared is let go.
const REST: u32 = 600;

type Lines<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        Ref<'static, SurfaceLine>,
        Option<Ref<'static, LineSmoothing>>,
        Ref<'static, OnSurface>,
        Option<&'static SmoothedLine>,
        &'static mut LineState,
    ),
>;
type Surfaces<'w, 's> = Query<'w, 's, (Option<&'static BuiltSurface>, Option<&'static SurfaceState>)>;

pub(crate) fn smooth_lines(
    commands: Commands,
    mut wishes: ResMut<Wishes>,
    (budget, mut frame): (Res<TraceBudget>, ResMut<FrameTime>),
    workspaces: Res<Workspaces<SmoothWorkspace>>,
    mut lines: Lines,
    surfaces: Surfaces,
) {
    let begin = Instant::now();
    let left = frame.left(&budget);
    let wishes = &mut *wishes;
    wishes.of.retain(|entity, _| lines.contains(*entity));
    let mut desk = Desk { commands, workspaces: &workspaces, begin, left, has_worked: false };
    for (entity, line, smoothing, on, smoothed, mut state) in &mut lines {
        let (built, surface_state) = surfaces.get(on.0).unwrap_or((None, None));
        let Some(built) = built else {
            state.set_if_neq(without_surface(surface_state));
            wishes.of.remove(&entity);
            if smoothed.is_some() {
                desk.commands.entity(entity).try_remove::<SmoothedLine>();
            }
            continue;
        };
        let record = wishes.of.entry(entity).or_default();
        record.notice(&line, smoothing.as_ref(), built, smoothed.is_some(), &state);
        let mut found = Found { entity, smoothed, state: &mut state };
        desk.collect(&mut found, record, &mut wishes.pace);
        desk.go_on(&mut found, record, &mut wishes.pace);
    }
    if desk.has_worked {
        frame.spend(begin.elapsed());
    }
}

/// The state of a line whose surface is not there.
pub(crate) fn without_surface(surface: Option<&SurfaceState>) -> LineState {
    match surface {
        Some(SurfaceState::Failed { reason }) => {
            LineState::Failed { reason: format!("its surface cannot be used: {reason}") }
        }
        _ => LineState::Pending,
    }
}

/// What is no line any more, or on no surface, has no smoothed one.
pub(crate) fn remove_smoothed<C: Component>(
    removed: On<Remove, C>,
    mut commands: Commands,
    mut states: Query<&mut LineState>,
) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<SmoothedLine>();
    }
    if let Ok(mut state) = states.get_mut(removed.entity) {
        state.set_if_neq(LineState::Pending);
    }
}

impl Record {
    /// Notes what is wished for, if that is new.
    fn notice(
        &mut self,
        line: &Ref<SurfaceLine>,
        smoothing: Option<&Ref<LineSmoothing>>,
        built: &BuiltSurface,
        has_result: bool,
        state: &LineState,
    ) {
        let wanted = smoothing.and_then(|smoothing| smoothing.wish());
        let is_touched = smoothing.is_some_and(|smoothing| smoothing.is_changed());
        let known = self.wish.as_ref().filter(|wish| Arc::ptr_eq(&wish.given.surface, &built.0) && !line.is_changed());
        self.at_rest = self.at_rest.saturating_add(1);
        match known {
            None => {
                let given = Arc::new(Given::new(line.line().clone(), built.0.clone()));
                self.wish = Some(Wish { given, smoothing: wanted });
                // What is being answered is of another line.
                self.running.iter().for_each(|running| running.stop());
            }
            Some(wish) if is_other(is_touched, wish.smoothing.as_ref(), wanted.as_ref()) => {
                self.wish = Some(Wish { given: wish.given.clone(), smoothing: wanted });
            }
            // Somebody took the result away.
            Some(_) if !has_result && self.running.is_none() && !matches!(state, LineState::Failed { .. }) => {}
            Some(_) => return,
        }
        (self.is_due, self.at_rest) = (true, 0);
    }

    /// Learns from what smoothing took. What was stopped would have taken longer: that it was short says nothing.
    fn learn(&mut self, pace: &mut Pace, wish: &Wish, outcome: &Outcome) {
        let was_stopped = matches!(outcome.result, Err(SmoothError::Stopped));
        if was_stopped && outcome.seconds < self.pace.unwrap_or(*pace).expect(wish.work()) {
            return;
        }
        self.pace.get_or_insert(*pace).learn(wish.work(), outcome.seconds);
        pace.learn(wish.work(), outcome.seconds);
    }
}

/// Whether something else is wished for; what is no number is no other wish in every frame.
fn is_other(is_touched: bool, known: Option<&Smoothing>, wanted: Option<&Smoothing>) -> bool {
    known.is_some() != wanted.is_some() || is_touched && known != wanted
}

/// A line as a frame finds it.
struct Found<'a, 'q> {
    entity: Entity,
    smoothed: Option<&'a SmoothedLine>,
    state: &'a mut Mut<'q, LineState>,
}

/// The smoothing of one frame.
struct Desk<'a, 'w, 's> {
    commands: Commands<'w, 's>,
    workspaces: &'a Workspaces<SmoothWorkspace>,
    begin: Instant,
    /// Seconds that this frame had left in the beginning.
    left: f64,
    /// Whether it had to do with any line.
    has_worked: bool,
}

impl Desk<'_, '_, '_> {
    /// Fetches what came from the background.
    fn collect(&mut self, found: &mut Found, record: &mut Record, pace: &mut Pace) {
        let Some(outcome) = record.running.as_mut().and_then(Running::collect) else { return };
        let Some(running) = record.running.take() else { return };
        self.has_worked = true;
        record.learn(pace, &running.wish, &outcome);
        record.prepared = outcome.prepared;
        let is_of_line = record.wish.as_ref().is_some_and(|wish| Arc::ptr_eq(&wish.given, &running.wish.given));
        match outcome.result {
            // It was asked to stop because there is something newer.
            Err(SmoothError::Stopped) => record.is_due = true,
            result if is_of_line => self.deliver(found, record, result, !record.is_due),
            _ => {}
        }
    }

    /// Answers what is due if this frame has time for it, or leaves it to the background.
    fn go_on(&mut self, found: &mut Found, record: &mut Record, pace: &mut Pace) {
        if self.left.is_infinite() && record.running.take().is_some() {
            record.is_due = true;
        }
        if record.is_due && record.running.is_none() {
            record.is_due = false;
            self.answer(found, record, pace);
        }
        let Some(running) = &record.running else {
            if record.at_rest > REST {
                record.prepared = None;
            }
            return;
        };
        if record.is_due && running.age() > PATIENCE {
            running.stop();
        }
        let (rounds, length) = running.progress();
        found.state.set_if_neq(LineState::Smoothing { rounds, length });
        // In the space of another surface it would be somewhere else.
        if found.smoothed.is_some_and(|smoothed| !smoothed.is_of(&running.wish.given.surface)) {
            self.commands.entity(found.entity).try_remove::<SmoothedLine>();
        }
    }

    fn answer(&mut self, found: &mut Found, record: &mut Record, pace: &mut Pace) {
        let Some(wish) = record.wish.clone() else { return };
        self.has_worked = true;
        let expected = record.pace.unwrap_or(*pace).expect(wish.work());
        let mut prepared = record.prepared.take();
        if expected <= self.left - self.begin.elapsed().as_secs_f64() {
            let (begin, left) = (self.begin, self.left);
            let outcome = wish.answer(prepared, self.workspaces, &mut |_| {
                if begin.elapsed().as_secs_f64() > left { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            record.learn(pace, &wish, &outcome);
            prepared = outcome.prepared;
            if !matches!(outcome.result, Err(SmoothError::Stopped)) {
                record.prepared = prepared;
                return self.deliver(found, record, outcome.result, true);
            }
        }
        record.running = Some(wish.begin(prepared, self.workspaces.clone()));
    }

    /// Hands a result over to its line.
    fn deliver(
        &mut self,
        found: &mut Found,
        record: &Record,
        result: Result<SmoothedLine, SmoothError>,
        is_current: bool,
    ) {
        let entity = found.entity;
        match result {
            Ok(smoothed) => {
                if is_current {
                    found.state.set_if_neq(LineState::Ready);
                }
                self.commands.entity(entity).try_insert(smoothed);
                self.commands.trigger(LineChanged { entity, is_current });
            }
            Err(error) if is_current => {
                let reason = error.to_string();
                if found.state.set_if_neq(LineState::Failed { reason: reason.clone() }) {
                    warn!("the line {entity} cannot be smoothed: {reason}");
                    self.commands.trigger(LineFailed { entity, reason });
                }
                // What the same line was before may be shown on.
                let is_known = |smoothed: &SmoothedLine, wish: &Wish| Arc::ptr_eq(smoothed.drawn(), &wish.given.line);
                let keeps = found.smoothed.zip(record.wish.as_ref()).is_some_and(|(known, wish)| is_known(known, wish));
                if !keeps {
                    self.commands.entity(entity).try_remove::<SmoothedLine>();
                }
            }
            Err(_) => {}
        }
    }
}
