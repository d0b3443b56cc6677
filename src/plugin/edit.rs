//! The one way by which splines change: [`EditSpline`] messages, applied by one system.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bevy::ecs::entity::EntityHashMap;
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::background::SAFE_FACES;
use super::budget::{self, FrameTime, TraceBudget};
use super::costs::Pace;
use super::drag_ways::Ways;
use super::edit_costs::edit_work;
use super::edit_queue::{AppliedEdit, Item, PendingEdit, Queue, RunningEdit, apply, remove_pending};
use super::spline::SurfaceSpline;
use super::surface::{BuiltSurface, OnSurface};
use super::workspaces::Workspaces;
use crate::curve::{EditError, Spline, SplineEdit};
use crate::surface::Surface;

/// Asks for a change to a spline.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_surface_splines::prelude::*;
/// # fn system(spline: Entity, mut edits: MessageWriter<EditSpline>) {
/// edits.write(EditSpline::new(spline, SplineEdit::Delete { anchor: 2 }).undoable());
/// # }
/// ```
#[derive(Message, Clone, Debug, PartialEq)]
pub struct EditSpline {
    /// The entity with the [`SurfaceSpline`].
    pub spline: Entity,
    /// The change.
    pub edit: SplineEdit,
    /// Whether a history should remember it.
    pub undoable: bool,
    /// The gesture it belongs to. Every edit of a gesture is applied to the spline as it was when the gesture began, so
    /// that a drag depends on where it is and not on how it got there.
    pub gesture: Option<GestureId>,
}

impl EditSpline {
    /// A change that no history remembers.
    pub fn new(spline: Entity, edit: SplineEdit) -> Self {
        Self { spline, edit, undoable: false, gesture: None }
    }

    /// The same change, to be remembered by a history.
    pub fn undoable(mut self) -> Self {
        self.undoable = true;
        self
    }

    /// The same change as part of a gesture.
    pub fn in_gesture(mut self, gesture: GestureId) -> Self {
        self.gesture = Some(gesture);
        self
    }
}

/// Names a gesture (a drag, say): edits that replace one another until it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Reflect)]
#[reflect(Clone, Debug, PartialEq, Hash)]
pub struct GestureId(u64);

impl GestureId {
    /// A name that was not used before in this process.
    pub fn next() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Asks to end a gesture, after the edits of the same frame.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub struct EndGesture {
    /// Which one.
    pub gesture: GestureId,
    /// Whether the spline goes back, bit for bit, to what it was when the gesture began.
    pub cancel: bool,
}

/// A spline was edited.
#[derive(Message, Clone, Debug, PartialEq)]
pub struct SplineEdited {
    /// The spline.
    pub entity: Entity,
    /// The change.
    pub edit: SplineEdit,
    /// What takes it back; for an edit of a gesture, back to where the gesture began.
    pub inverse: SplineEdit,
    /// Whether a history should remember it; of a gesture, the last one until [`GestureEnded`].
    pub undoable: bool,
    /// The gesture it belongs to.
    pub gesture: Option<GestureId>,
}

/// A gesture has ended.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub struct GestureEnded {
    /// Which one.
    pub gesture: GestureId,
    /// The spline it edited.
    pub entity: Entity,
    /// Whether it was taken back.
    pub cancelled: bool,
}

/// Happens when an edit is refused; the spline is unchanged. Of a gesture, only the first of a row of refusals is told.
#[derive(EntityEvent, Clone, Debug)]
pub struct SplineEditRefused {
    /// The spline.
    pub entity: Entity,
    /// The change that was asked for.
    pub edit: SplineEdit,
    /// Why, and what to do about it.
    pub reason: EditRefusal,
}

/// Why an edit was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditRefusal {
    /// The entity has no spline.
    #[error("{0} has no SurfaceSpline: edit the entity of the spline, once its state is ready")]
    NoSpline(Entity),
    /// The surface is missing or not built yet.
    #[error("the spline's surface is not ready: wait for On<SurfaceReady>")]
    SurfaceNotReady,
    /// The pointer is over another piece of the surface.
    #[error(
        "the point lies on another piece of the surface, which no curve can reach: stay on the piece of the spline"
    )]
    OtherPiece,
    /// The spline itself refuses.
    #[error(transparent)]
    Edit(#[from] EditError),
}

/// Applies edits: in the frame, or, where a drag moves what takes longer than the frame has, in the background; then
/// the spline has a [`PendingEdit`] meanwhile.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Edit`].
#[derive(Debug, Default)]
pub struct EditPlugin;

impl Plugin for EditPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        budget::configure(app);
        app.register_type::<GestureId>()
            .add_message::<EditSpline>()
            .add_message::<EndGesture>()
            .add_message::<SplineEdited>()
            .add_message::<GestureEnded>()
            .init_resource::<Workspaces>()
            .init_resource::<Ways>()
            .init_resource::<Edits>()
            .add_observer(remove_pending)
            .add_systems(PostUpdate, apply_edits.in_set(SurfaceSplineSystems::Edit));
    }
}

/// Edits that are not over.
#[derive(Resource, Default)]
struct Edits {
    /// Gestures that have begun and not ended.
    gestures: HashMap<GestureId, Gesture>,
    /// What waits for an edit that is computed in the background.
    queues: EntityHashMap<Queue>,
    /// How long edits take.
    pace: Pace,
}

struct Gesture {
    spline: Entity,
    /// The spline when the first edit was applied.
    before: Option<Spline>,
    refused: bool,
    /// How long its edits take; none before the first.
    pace: Option<Pace>,
    /// Modelled work of the edit that runs in the background.
    running: f64,
}

type Splines<'w, 's> = Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>;
type Surfaces<'w, 's> = Query<'w, 's, &'static BuiltSurface>;

fn apply_edits(
    commands: Commands,
    (mut messages, mut ends): (MessageReader<EditSpline>, MessageReader<EndGesture>),
    (edited, ended): (MessageWriter<SplineEdited>, MessageWriter<GestureEnded>),
    mut edits: ResMut<Edits>,
    (budget, mut frame, workspaces): (Res<TraceBudget>, ResMut<FrameTime>, Res<Workspaces>),
    (splines, surfaces): (Splines, Surfaces),
    (pending, ways): (Query<(Entity, &PendingEdit)>, Res<Ways>),
) {
    let begin = Instant::now();
    let mut desk = Desk {
        commands,
        edited,
        ended,
        edits: &mut edits,
        workspaces: &workspaces,
        splines: &splines,
        surfaces: &surfaces,
        left: frame.left(&budget),
        changed: EntityHashMap::default(),
    };
    desk.edits.queues.retain(|entity, _| splines.contains(*entity));
    let mut busy: Vec<Entity> = desk.edits.queues.keys().copied().collect();
    busy.sort();
    busy.into_iter().for_each(|entity| desk.go_on(entity));
    messages.read().for_each(|message| desk.take_edit(message));
    ends.read().for_each(|end| desk.take_end(*end));
    desk.show_pending(&pending, &ways);
    desk.end_gestures_of_missing();
    desk.write_back();
    frame.spend(begin.elapsed());
}

/// The edits of one frame.
struct Desk<'a, 'w, 's> {
    commands: Commands<'w, 's>,
    edited: MessageWriter<'w, SplineEdited>,
    ended: MessageWriter<'w, GestureEnded>,
    edits: &'a mut Edits,
    workspaces: &'a Workspaces,
    splines: &'a Splines<'w, 's>,
    surfaces: &'a Surfaces<'w, 's>,
    /// Seconds that this frame has left.
    left: f64,
    /// Splines as they will be at the end of the frame.
    changed: EntityHashMap<Spline>,
}

/// Why an edit was not applied, if that is to be told.
type Refused = Option<EditRefusal>;

impl Desk<'_, '_, '_> {
    fn take_edit(&mut self, message: &EditSpline) {
        let entity = message.spline;
        if let Some(id) = message.gesture {
            self.edits.gestures.entry(id).or_insert_with(|| Gesture::new(entity));
        }
        self.take(entity, Item::Edit(message.clone()));
    }

    fn take_end(&mut self, end: EndGesture) {
        let Some(gesture) = self.edits.gestures.get(&end.gesture) else { return };
        let entity = gesture.spline;
        if end.cancel
            && let Some(queue) = self.edits.queues.get_mut(&entity)
        {
            queue.forget(end.gesture);
            self.go_on(entity);
        }
        self.take(entity, Item::End(end));
    }

    /// Does something, or lets it wait for what is asked of the spline already.
    fn take(&mut self, entity: Entity, item: Item) {
        match self.edits.queues.get_mut(&entity) {
            Some(queue) => queue.push(item),
            None => self.process(entity, item),
        }
    }

    /// Fetches an edit that was computed in the background, and does what waited for it.
    fn go_on(&mut self, entity: Entity) {
        while let Some(queue) = self.edits.queues.get_mut(&entity) {
            if let Some((running, applied)) = queue.collect() {
                self.finish(entity, running, applied);
            } else if queue.running.is_some() {
                return;
            } else if let Some(item) = queue.pop() {
                self.process(entity, item);
            } else {
                self.edits.queues.remove(&entity);
            }
        }
    }

    fn process(&mut self, entity: Entity, item: Item) {
        match item {
            Item::End(end) => self.end(end),
            Item::Edit(message) => {
                let outcome = match message.gesture {
                    None => self.apply_alone(&message).map(Some),
                    Some(id) => self.apply_in_gesture(id, &message),
                };
                self.report(entity, message, outcome);
            }
        }
    }

    /// Tells what came of an edit, if anything did.
    fn report(&mut self, entity: Entity, message: EditSpline, outcome: Result<Option<SplineEdit>, Refused>) {
        let EditSpline { edit, undoable, gesture, .. } = message;
        match outcome {
            Ok(Some(inverse)) => drop(self.edited.write(SplineEdited { entity, edit, inverse, undoable, gesture })),
            Err(Some(reason)) => self.commands.trigger(SplineEditRefused { entity, edit, reason }),
            Ok(None) | Err(None) => {}
        }
    }

    fn current(&self, entity: Entity) -> Result<Spline, EditRefusal> {
        let stored = || self.splines.get(entity).ok().map(|(spline, _)| (**spline).clone());
        self.changed.get(&entity).cloned().or_else(stored).ok_or(EditRefusal::NoSpline(entity))
    }

    fn surface(&self, entity: Entity) -> Result<Arc<Surface>, EditRefusal> {
        let (_, on) = self.splines.get(entity).map_err(|_| EditRefusal::NoSpline(entity))?;
        Ok(self.surfaces.get(on.0).map_err(|_| EditRefusal::SurfaceNotReady)?.0.clone())
    }

    /// Applies an edit to the spline as it is; gestures that go on about the same spline begin from there.
    fn apply_alone(&mut self, message: &EditSpline) -> Result<SplineEdit, Refused> {
        let entity = message.spline;
        let (before, surface) = (self.current(entity)?, self.surface(entity)?);
        let (spline, inverse) =
            apply(before, &surface, &message.edit, self.workspaces).result.map_err(EditRefusal::from)?;
        self.changed.insert(entity, spline);
        for gesture in self.edits.gestures.values_mut().filter(|g| g.spline == entity) {
            // Where the start of the gesture refuses it, the edit lasts until the gesture's next one.
            if let Some(before) = &gesture.before
                && let Ok((before, _)) = apply(before.clone(), &surface, &message.edit, self.workspaces).result
            {
                gesture.before = Some(before);
            }
        }
        Ok(inverse)
    }

    /// Applies an edit to the spline as it was when the gesture began, or begins to.
    fn apply_in_gesture(&mut self, id: GestureId, message: &EditSpline) -> Result<Option<SplineEdit>, Refused> {
        let entity = message.spline;
        let (current, surface) = (self.current(entity), self.surface(entity));
        // While the edit waited, its gesture may have ended, and begins anew.
        let gesture = self.edits.gestures.entry(id).or_insert_with(|| Gesture::new(entity));
        if gesture.spline != entity {
            return Err(Some(EditRefusal::NoSpline(entity)));
        }
        let before = match &gesture.before {
            Some(before) => before.clone(),
            None => gesture.before.insert(current?).clone(),
        };
        let surface = surface.map_err(|reason| gesture.refuse(reason))?;
        let work = edit_work(&surface, &before, &message.edit).unwrap_or(0.0);
        let expected = gesture.pace.unwrap_or(self.edits.pace).expect(work);
        let (fits, is_safe) = (expected <= self.left, surface.face_count() <= SAFE_FACES || self.left.is_infinite());
        if fits && is_safe {
            let applied = apply(before, &surface, &message.edit, self.workspaces);
            self.left -= applied.seconds;
            return self.settle(id, entity, work, applied).map(Some);
        }
        gesture.running = work;
        let begin = Instant::now();
        let mut running = RunningEdit::begin(message.clone(), id, before, surface, self.workspaces.clone());
        let applied = if fits { running.wait(self.left) } else { None };
        self.left -= begin.elapsed().as_secs_f64();
        if let Some(applied) = applied {
            return self.settle(id, entity, work, applied).map(Some);
        }
        self.edits.queues.entry(entity).or_default().running = Some(running);
        Ok(None)
    }

    /// An edit that was computed in the background is there.
    fn finish(&mut self, entity: Entity, running: RunningEdit, applied: AppliedEdit) {
        // Of another surface it is of no use.
        if !self.surface(entity).is_ok_and(|surface| Arc::ptr_eq(&surface, &running.surface)) {
            return;
        }
        let work = self.edits.gestures.get(&running.gesture).map_or(0.0, |gesture| gesture.running);
        let outcome = self.settle(running.gesture, entity, work, applied).map(Some);
        self.report(entity, running.message, outcome);
    }

    /// Takes over what came of an edit of a gesture.
    fn settle(
        &mut self,
        id: GestureId,
        entity: Entity,
        work: f64,
        applied: AppliedEdit,
    ) -> Result<SplineEdit, Refused> {
        let Some(gesture) = self.edits.gestures.get_mut(&id) else { return Err(None) };
        gesture.pace.get_or_insert(self.edits.pace).learn(work, applied.seconds);
        self.edits.pace.learn(work, applied.seconds);
        let (spline, inverse) = applied.result.map_err(|error| gesture.refuse(error.into()))?;
        gesture.refused = false;
        self.changed.insert(entity, spline);
        Ok(inverse)
    }

    fn end(&mut self, end: EndGesture) {
        let Some(gesture) = self.edits.gestures.remove(&end.gesture) else { return };
        let entity = gesture.spline;
        if let Some(before) = gesture.before.filter(|_| end.cancel) {
            self.changed.insert(entity, before);
        }
        self.ended.write(GestureEnded { gesture: end.gesture, entity, cancelled: end.cancel });
    }

    /// Keeps the [`PendingEdit`]s: of a control point whose way is not known yet there is no edit, but where it is to be is known.
    fn show_pending(&mut self, pending: &Query<(Entity, &PendingEdit)>, ways: &Ways) {
        let queued = self.edits.queues.iter().filter_map(|(entity, queue)| Some((*entity, queue.newest()?.clone())));
        let mut newest: EntityHashMap<SplineEdit> = queued.collect();
        newest.extend(ways.unknown());
        for (entity, _) in pending.iter().filter(|(entity, _)| !newest.contains_key(entity)) {
            self.commands.entity(entity).try_remove::<PendingEdit>();
        }
        for (entity, edit) in newest {
            if pending.get(entity).ok().map(|(_, pending)| pending.edit()) != Some(&edit) {
                self.commands.entity(entity).try_insert(PendingEdit::new(edit));
            }
        }
    }

    /// A gesture about a spline that is gone ends: whoever waits for its end must not wait for ever.
    fn end_gestures_of_missing(&mut self) {
        let Self { edits, ended, splines, .. } = self;
        let gone = edits.gestures.extract_if(|_, gesture| !splines.contains(gesture.spline));
        ended.write_batch(gone.map(|(id, gone)| GestureEnded { gesture: id, entity: gone.spline, cancelled: true }));
    }

    fn write_back(&mut self) {
        for (entity, spline) in std::mem::take(&mut self.changed) {
            if self.splines.get(entity).is_ok_and(|(now, _)| **now != spline) {
                self.commands.entity(entity).try_insert(SurfaceSpline::new(spline));
            }
        }
    }
}

impl Gesture {
    fn new(spline: Entity) -> Self {
        Self { spline, before: None, refused: false, pace: None, running: 0.0 }
    }

    /// Of a row of refusals, the first is told.
    fn refuse(&mut self, reason: EditRefusal) -> Refused {
        (!std::mem::replace(&mut self.refused, true)).then_some(reason)
    }
}
