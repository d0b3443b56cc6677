//! The one way by which splines change: [`EditSpline`] messages, applied by one system.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::spline::SurfaceSpline;
use super::surface::{BuiltSurface, OnSurface};
use crate::curve::{EditError, Spline, SplineEdit};
use crate::geodesic::PathFinder;

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

/// Applies edits.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Edit`].
#[derive(Debug, Default)]
pub struct EditPlugin;

impl Plugin for EditPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_type::<GestureId>()
            .add_message::<EditSpline>()
            .add_message::<EndGesture>()
            .add_message::<SplineEdited>()
            .add_message::<GestureEnded>()
            .init_resource::<Gestures>()
            .add_systems(PostUpdate, apply_edits.in_set(SurfaceSplineSystems::Edit));
    }
}

/// Gestures that have begun and not ended.
#[derive(Resource, Debug, Default)]
struct Gestures(HashMap<GestureId, Gesture>);

#[derive(Debug)]
struct Gesture {
    spline: Entity,
    before: Spline,
    refused: bool,
}

type Splines<'w, 's> = Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>;
type Surfaces<'w, 's> = Query<'w, 's, &'static BuiltSurface>;

/// Splines as they will be at the end of the frame.
struct Desk<'a, 'w, 's> {
    splines: &'a Splines<'w, 's>,
    surfaces: &'a Surfaces<'w, 's>,
    finder: &'a mut PathFinder,
    changed: EntityHashMap<Spline>,
}

impl Desk<'_, '_, '_> {
    fn current(&self, entity: Entity) -> Result<Spline, EditRefusal> {
        let stored = || self.splines.get(entity).ok().map(|(spline, _)| (**spline).clone());
        self.changed.get(&entity).cloned().or_else(stored).ok_or(EditRefusal::NoSpline(entity))
    }

    fn apply(&mut self, entity: Entity, spline: &mut Spline, edit: &SplineEdit) -> Result<SplineEdit, EditRefusal> {
        let (_, on) = self.splines.get(entity).map_err(|_| EditRefusal::NoSpline(entity))?;
        let surface = self.surfaces.get(on.0).map_err(|_| EditRefusal::SurfaceNotReady)?;
        Ok(spline.apply(surface, self.finder, edit)?)
    }
}

fn apply_edits(
    mut commands: Commands,
    (mut edits, mut ends): (MessageReader<EditSpline>, MessageReader<EndGesture>),
    (mut edited, mut ended): (MessageWriter<SplineEdited>, MessageWriter<GestureEnded>),
    mut gestures: ResMut<Gestures>,
    mut finder: Local<PathFinder>,
    splines: Splines,
    surfaces: Surfaces,
) {
    let mut desk =
        Desk { splines: &splines, surfaces: &surfaces, finder: &mut finder, changed: EntityHashMap::default() };
    for message in edits.read() {
        let outcome = match message.gesture {
            None => apply_alone(&mut desk, &mut gestures, message),
            Some(id) => apply_in_gesture(&mut desk, &mut gestures, id, message),
        };
        let EditSpline { spline: entity, edit, undoable, gesture } = message.clone();
        match outcome {
            Ok(inverse) => drop(edited.write(SplineEdited { entity, edit, inverse, undoable, gesture })),
            Err(Some(reason)) => commands.trigger(SplineEditRefused { entity, edit, reason }),
            Err(None) => {}
        }
    }
    for end in ends.read() {
        let Some(gesture) = gestures.0.remove(&end.gesture) else { continue };
        let entity = gesture.spline;
        if end.cancel {
            desk.changed.insert(entity, gesture.before);
        }
        ended.write(GestureEnded { gesture: end.gesture, entity, cancelled: end.cancel });
    }
    gestures.0.retain(|_, gesture| splines.contains(gesture.spline));
    for (entity, spline) in desk.changed {
        if splines.get(entity).is_ok_and(|(now, _)| **now != spline) {
            commands.entity(entity).try_insert(SurfaceSpline::new(spline));
        }
    }
}

/// Applies an edit to the spline as it is; gestures that go on about the same spline begin from there.
fn apply_alone(
    desk: &mut Desk,
    gestures: &mut Gestures,
    message: &EditSpline,
) -> Result<SplineEdit, Option<EditRefusal>> {
    let mut spline = desk.current(message.spline)?;
    let inverse = desk.apply(message.spline, &mut spline, &message.edit)?;
    desk.changed.insert(message.spline, spline);
    for gesture in gestures.0.values_mut().filter(|g| g.spline == message.spline) {
        // Where the start of the gesture refuses it, the edit lasts until the gesture's next one.
        let _ = desk.apply(message.spline, &mut gesture.before, &message.edit);
    }
    Ok(inverse)
}

/// Applies an edit to the spline as it was when the gesture began.
fn apply_in_gesture(
    desk: &mut Desk,
    gestures: &mut Gestures,
    id: GestureId,
    message: &EditSpline,
) -> Result<SplineEdit, Option<EditRefusal>> {
    let entity = message.spline;
    if let std::collections::hash_map::Entry::Vacant(entry) = gestures.0.entry(id) {
        entry.insert(Gesture { spline: entity, before: desk.current(entity)?, refused: false });
    }
    let Some(gesture) = gestures.0.get_mut(&id).filter(|g| g.spline == entity) else {
        return Err(Some(EditRefusal::NoSpline(entity)));
    };
    let mut spline = gesture.before.clone();
    match desk.apply(entity, &mut spline, &message.edit) {
        Ok(inverse) => {
            gesture.refused = false;
            desk.changed.insert(entity, spline);
            Ok(inverse)
        }
        Err(reason) => Err((!std::mem::replace(&mut gesture.refused, true)).then_some(reason)),
    }
}
