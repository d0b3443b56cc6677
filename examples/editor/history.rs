//! Undo and redo, by the inverses that the plugin reports. One gesture is one entry.

use std::collections::HashMap;

use bevy::prelude::*;
use bevy_surface_splines::plugin::GestureEnded;
use bevy_surface_splines::prelude::*;

use crate::curves::{self, Shelved};
use crate::model::ModelOpened;

/// What was done and can be taken back.
#[derive(Resource, Debug, Default)]
pub(crate) struct History {
    undo: Vec<Entry>,
    redo: Vec<Entry>,
    /// Entries being played back, whose edits come round as [`SplineEdited`].
    pending: Vec<Pending>,
    /// The newest inverse of each gesture that has not ended.
    gestures: HashMap<GestureId, Entry>,
}

#[derive(Clone, Debug)]
struct Entry {
    name: String,
    spline: Entity,
    step: Step,
}

/// What takes an entry back.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    /// Edits, the last one first.
    Edits(Vec<SplineEdit>),
    Shelve,
    Unshelve,
}

#[derive(Debug)]
struct Pending {
    entry: Entry,
    /// Edits that have not come round.
    left: usize,
    undoing: bool,
}

type Splines<'w, 's> = Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>;

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<History>().add_observer(forget_all).add_systems(PreUpdate, record);
}

impl History {
    /// Notes something that was done.
    pub(crate) fn push(&mut self, name: &str, spline: Entity, step: Step) {
        self.undo.push(Entry { name: name.into(), spline, step });
        self.redo.clear();
    }

    /// The names of what undo and redo would do.
    pub(crate) fn names(&self) -> [Option<&str>; 2] {
        [&self.undo, &self.redo].map(|entries| entries.last().map(|entry| entry.name.as_str()))
    }

    /// The spline that undo, or redo, would change.
    pub(crate) fn next(&self, undo: bool) -> Option<Entity> {
        let entries = if undo { &self.undo } else { &self.redo };
        entries.last().map(|entry| entry.spline)
    }

    /// The edits that were sent for an entry were refused, so they do not come round.
    pub(crate) fn forget_pending(&mut self, spline: Entity) {
        self.pending.retain(|pending| pending.entry.spline != spline);
    }

    pub(crate) fn undo(
        &mut self,
        commands: &mut Commands,
        edits: &mut MessageWriter<EditSpline>,
        splines: &Splines,
        shelved: &Query<&Shelved>,
    ) {
        if let Some(entry) = self.undo.pop() {
            self.play(entry, true, commands, edits, splines, shelved);
        }
    }

    pub(crate) fn redo(
        &mut self,
        commands: &mut Commands,
        edits: &mut MessageWriter<EditSpline>,
        splines: &Splines,
        shelved: &Query<&Shelved>,
    ) {
        if let Some(entry) = self.redo.pop() {
            self.play(entry, false, commands, edits, splines, shelved);
        }
    }

    fn play(
        &mut self,
        mut entry: Entry,
        undoing: bool,
        commands: &mut Commands,
        edits: &mut MessageWriter<EditSpline>,
        splines: &Splines,
        shelved: &Query<&Shelved>,
    ) {
        let spline = entry.spline;
        entry.step = match std::mem::replace(&mut entry.step, Step::Edits(Vec::new())) {
            Step::Edits(steps) => {
                let left = steps.len();
                edits.write_batch(steps.into_iter().rev().map(|edit| EditSpline::new(spline, edit)));
                self.pending.push(Pending { entry, left, undoing });
                return;
            }
            Step::Shelve => {
                let Ok((curve, on)) = splines.get(spline) else { return };
                curves::shelve(commands, spline, curve, on.0);
                Step::Unshelve
            }
            Step::Unshelve => {
                let Ok(kept) = shelved.get(spline) else { return };
                curves::unshelve(commands, spline, kept);
                Step::Shelve
            }
        };
        if undoing { self.redo.push(entry) } else { self.undo.push(entry) }
    }

    /// An edit that was played back has come round, with the inverse that plays the other way.
    fn come_round(&mut self, edited: &SplineEdited) {
        let Some(index) = self.pending.iter().position(|pending| pending.entry.spline == edited.entity) else { return };
        let pending = &mut self.pending[index];
        if let Step::Edits(steps) = &mut pending.entry.step {
            steps.push(edited.inverse.clone());
        }
        pending.left = pending.left.saturating_sub(1);
        if pending.left == 0 {
            let Pending { entry, undoing, .. } = self.pending.remove(index);
            if undoing { self.redo.push(entry) } else { self.undo.push(entry) }
        }
    }
}

/// Notes edits: those of one frame about one spline are one entry, and those of a gesture when it ends.
fn record(
    mut history: ResMut<History>,
    mut edited: MessageReader<SplineEdited>,
    mut ended: MessageReader<GestureEnded>,
) {
    let mut batch: Option<Entry> = None;
    for edit in edited.read() {
        let entry = |steps| Entry { name: name_of(&edit.edit), spline: edit.entity, step: Step::Edits(steps) };
        match (edit.gesture, edit.undoable) {
            (Some(gesture), true) => {
                history.gestures.insert(gesture, entry(vec![edit.inverse.clone()]));
            }
            (None, true) => match &mut batch {
                Some(Entry { spline, step: Step::Edits(steps), .. }) if *spline == edit.entity => {
                    steps.push(edit.inverse.clone());
                }
                _ => {
                    let before = batch.replace(entry(vec![edit.inverse.clone()]));
                    history.note(before);
                }
            },
            (None, false) => history.come_round(edit),
            (Some(_), false) => {}
        }
    }
    history.note(batch);
    for end in ended.read() {
        let entry = history.gestures.remove(&end.gesture).filter(|_| !end.cancelled);
        history.note(entry);
    }
}

impl History {
    fn note(&mut self, entry: Option<Entry>) {
        if let Some(entry) = entry {
            self.undo.push(entry);
            self.redo.clear();
        }
    }
}

fn name_of(edit: &SplineEdit) -> String {
    match edit {
        SplineEdit::MoveAnchor { anchor, .. } | SplineEdit::DragAnchor { anchor, .. } => {
            format!("Move anchor {}", anchor + 1)
        }
        SplineEdit::MoveHandle { anchor, .. } | SplineEdit::DragHandle { anchor, .. } => {
            format!("Move handle of anchor {}", anchor + 1)
        }
        SplineEdit::Append { .. } => "Add anchor".into(),
        SplineEdit::Insert { .. } => "Insert anchor".into(),
        SplineEdit::Delete { anchor } | SplineEdit::DeleteFitted { anchor } => format!("Delete anchor {}", anchor + 1),
        SplineEdit::SetJoin { anchor, .. } => format!("Join of anchor {}", anchor + 1),
        SplineEdit::Straighten { segment } => format!("Straighten segment {}", segment + 1),
        SplineEdit::Close => "Close".into(),
        SplineEdit::Open { anchor } => format!("Open at anchor {}", anchor + 1),
        SplineEdit::Reverse => "Reverse".into(),
        SplineEdit::Cut { anchor, .. } => format!("Cut at anchor {}", anchor + 1),
        SplineEdit::Join { .. } => "Join splines".into(),
        SplineEdit::Transform(_) => "Transform".into(),
        SplineEdit::SetScheme(_) => "Change scheme".into(),
        SplineEdit::SetJumps(_) => "Change what happens at jumps".into(),
        _ => "Edit".into(),
    }
}

/// Another model: nothing of before can be taken back.
fn forget_all(
    _: On<ModelOpened>,
    mut commands: Commands,
    mut history: ResMut<History>,
    shelved: Query<Entity, With<Shelved>>,
) {
    *history = History::default();
    shelved.iter().for_each(|entity| commands.entity(entity).despawn());
}
