//! Edits in background tasks: of each spline one at a time; what else is asked of the spline waits for it.

use std::collections::VecDeque;
use std::sync::Arc;

use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on, futures_lite::future};

use super::background::wait_for;
use super::controls::ControlKind;
use super::edit::{EditSpline, EndGesture, GestureId};
use super::spline::SurfaceSpline;
use super::workspaces::Workspaces;
use crate::curve::{EditError, Spline, SplineEdit};
use crate::surface::{Surface, SurfacePoint};

/// The newest edit of a spline that is not applied yet, because that takes longer than a frame has; gone when all are.
///
/// Only edits of gestures that move control points are computed in the background, and edits that come after them wait.
/// Derived: a system writes it.
#[derive(Component, Clone, Debug, PartialEq)]
#[component(immutable, clone_behavior = Ignore)]
pub struct PendingEdit {
    edit: SplineEdit,
}

impl PendingEdit {
    pub(crate) fn new(edit: SplineEdit) -> Self {
        Self { edit }
    }

    /// The edit; of a control point that is led along a way not known yet, the move without the way.
    pub fn edit(&self) -> &SplineEdit {
        &self.edit
    }

    /// The control point that it moves, and where to: show it there at once, the spline follows.
    pub fn moved(&self) -> Option<(ControlKind, SurfacePoint)> {
        match &self.edit {
            SplineEdit::MoveAnchor { anchor, to } => Some((ControlKind::Anchor(*anchor), *to)),
            SplineEdit::DragAnchor { anchor, along } => Some((ControlKind::Anchor(*anchor), along.end())),
            SplineEdit::MoveHandle { anchor, side, to } | SplineEdit::FreeHandle { anchor, side, to } => {
                Some((ControlKind::Handle(*anchor, *side), *to))
            }
            SplineEdit::DragHandle { anchor, side, along } => Some((ControlKind::Handle(*anchor, *side), along.end())),
            _ => None,
        }
    }
}

impl ControlKind {
    /// Where a control point is to be shown: where an edit that is not applied yet moves it, else where it is.
    pub fn shown(self, spline: &Spline, pending: Option<&PendingEdit>) -> Option<SurfacePoint> {
        let moved = pending.and_then(PendingEdit::moved).filter(|(kind, _)| *kind == self);
        let point = self.point(spline)?;
        Some(moved.map_or(point, |(_, to)| to))
    }
}

/// What is asked of a spline.
#[derive(Clone, Debug)]
pub(crate) enum Item {
    Edit(EditSpline),
    End(EndGesture),
}

impl Item {
    fn is_edit_of(&self, gesture: GestureId) -> bool {
        matches!(self, Self::Edit(message) if message.gesture == Some(gesture))
    }

    fn is_end_of(&self, gesture: GestureId) -> bool {
        matches!(self, Self::End(end) if end.gesture == gesture)
    }
}

/// What is asked of one spline, in order: an edit that is computed, and what waits for it.
#[derive(Default)]
pub(crate) struct Queue {
    pub(crate) running: Option<RunningEdit>,
    waiting: VecDeque<Item>,
}

/// An edit of a gesture that is computed in a task.
pub(crate) struct RunningEdit {
    pub(crate) message: EditSpline,
    pub(crate) gesture: GestureId,
    pub(crate) surface: Arc<Surface>,
    task: Task<AppliedEdit>,
}

/// What came of an edit.
pub(crate) struct AppliedEdit {
    /// The spline after it, and its inverse.
    pub(crate) result: Result<(Spline, SplineEdit), EditError>,
    pub(crate) seconds: f64,
}

/// Applies an edit to a spline.
pub(crate) fn apply(mut spline: Spline, surface: &Surface, edit: &SplineEdit, workspaces: &Workspaces) -> AppliedEdit {
    let begin = Instant::now();
    let inverse = workspaces.lend(|workspace| spline.apply(surface, &mut workspace.finder, edit));
    AppliedEdit { result: inverse.map(|inverse| (spline, inverse)), seconds: begin.elapsed().as_secs_f64() }
}

impl RunningEdit {
    /// Begins to apply an edit to the spline from which its gesture began.
    pub(crate) fn begin(
        message: EditSpline,
        gesture: GestureId,
        before: Spline,
        surface: Arc<Surface>,
        workspaces: Workspaces,
    ) -> Self {
        let (edit, on) = (message.edit.clone(), surface.clone());
        let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
        let task = pool.spawn(async move { apply(before, &on, &edit, &workspaces) });
        Self { message, gesture, surface, task }
    }

    /// Lets the frame wait for it, for so many seconds at most.
    pub(crate) fn wait(&mut self, seconds: f64) -> Option<AppliedEdit> {
        wait_for(&self.task, seconds);
        self.collect()
    }

    fn collect(&mut self) -> Option<AppliedEdit> {
        block_on(future::poll_once(&mut self.task))
    }
}

impl Queue {
    /// Adds what comes; of the edits of a gesture that wait, the last before its end alone counts.
    pub(crate) fn push(&mut self, item: Item) {
        if let Item::Edit(EditSpline { gesture: Some(gesture), .. }) = item {
            let over = self.waiting.iter().rposition(|waiting| waiting.is_end_of(gesture)).map_or(0, |end| end + 1);
            let mut places = 0..;
            self.waiting
                .retain(|waiting| places.next().is_some_and(|place| place < over) || !waiting.is_edit_of(gesture));
        }
        self.waiting.push_back(item);
    }

    /// Forgets the edits of a gesture.
    pub(crate) fn forget(&mut self, gesture: GestureId) {
        self.waiting.retain(|waiting| !waiting.is_edit_of(gesture));
        self.running.take_if(|running| running.gesture == gesture);
    }

    /// What has waited longest.
    pub(crate) fn pop(&mut self) -> Option<Item> {
        self.waiting.pop_front()
    }

    /// Fetches an edit that is done.
    pub(crate) fn collect(&mut self) -> Option<(RunningEdit, AppliedEdit)> {
        let applied = self.running.as_mut()?.collect()?;
        Some((self.running.take()?, applied))
    }

    /// The newest edit that is not applied.
    pub(crate) fn newest(&self) -> Option<&SplineEdit> {
        let waiting = self.waiting.iter().rev().find_map(|item| match item {
            Item::Edit(message) => Some(&message.edit),
            Item::End(_) => None,
        });
        waiting.or(self.running.as_ref().map(|running| &running.message.edit))
    }
}

/// What is no spline any more has no edits.
pub(crate) fn remove_pending(removed: On<Remove, SurfaceSpline>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<PendingEdit>();
    }
}
