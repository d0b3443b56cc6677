//! Undo and redo, by the inverses that the plugin reports. One gesture is one entry.
//!
//! Only edits that ask to ([`EditSpline::undoable`](crate::plugin::EditSpline::undoable)) are remembered. Those of one frame about one
//! spline are one entry, a gesture is one when it ends, and whatever happens between [`History::begin`] and [`History::end`]
//! is one, of however many splines.

mod playing;

use std::collections::{HashMap, VecDeque};

use bevy::prelude::*;

use super::curves::{Curve, Shelved};
use crate::curve::{Anchor, SplineEdit};
use crate::plugin::{GestureEnded, GestureId, LineSmoothing, SplineEdited, SurfaceLine};
use playing::{Direction, Playing};

/// What was done and can be taken back.
#[derive(Resource, Debug)]
pub struct History {
    undo: VecDeque<Entry>,
    redo: Vec<Entry>,
    /// An entry being played back, whose edits come round as [`SplineEdited`].
    playing: Option<Playing>,
    /// The newest inverse of each gesture that has not ended.
    gestures: HashMap<GestureId, Entry>,
    /// What is one entry when it ends; one may begin inside another, and is a part of that.
    groups: Vec<Group>,
    /// What is to be played, one after the other.
    asked: VecDeque<PlayHistory>,
    /// Bytes that entries may take.
    limit: usize,
    /// The state before the oldest entry, and the number of the next.
    base: u64,
    next: u64,
    /// How often something changed that no entry holds.
    touches: u64,
    /// The state in which the document was saved.
    saved: Revision,
}

/// A state of the document: no two have the same, and undo and redo lead back to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Revision {
    /// The entry that was done last.
    entry: u64,
    touches: u64,
}

#[derive(Clone, Debug)]
struct Entry {
    /// Names the state that it leads to.
    id: u64,
    name: String,
    /// Taken back from the last to the first.
    steps: Vec<Step>,
}

/// What takes a part of an entry back.
#[derive(Clone, Debug)]
enum Step {
    Edit(Entity, SplineEdit),
    Shelve(Entity),
    Unshelve(Entity),
    /// Name and look.
    Restyle(Entity, Curve),
    /// The course of a line, and how it is smoothed.
    Redraw(Entity, Box<(SurfaceLine, Option<LineSmoothing>)>),
}

impl Step {
    fn spline(&self) -> Entity {
        let (Self::Edit(of, _) | Self::Shelve(of) | Self::Unshelve(of) | Self::Restyle(of, _) | Self::Redraw(of, _)) =
            self;
        *of
    }
}

#[derive(Debug)]
struct Group {
    entry: Entry,
    gestures: Vec<GestureId>,
    is_ending: bool,
    is_taken_back: bool,
}

/// Takes the last entry back; does nothing where there is none.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayHistory {
    /// Takes the last entry back.
    Undo,
    /// Does again what was taken back last.
    Redo,
}

/// Entries may take so many bytes together, unless asked otherwise.
const LIMIT: usize = 256 << 20;

impl Default for History {
    fn default() -> Self {
        Self {
            undo: VecDeque::new(),
            redo: Vec::new(),
            playing: None,
            gestures: HashMap::new(),
            groups: Vec::new(),
            asked: VecDeque::new(),
            limit: LIMIT,
            base: 0,
            next: 1,
            touches: 0,
            saved: Revision::default(),
        }
    }
}

impl History {
    /// The names of what undo and redo would do.
    pub fn names(&self) -> [Option<&str>; 2] {
        [self.undo.back(), self.redo.last()].map(|entry| entry.map(|entry| entry.name.as_str()))
    }

    /// The names of all that can be undone, the oldest first, and of all that can be redone, the next one first.
    pub fn all_names(&self) -> (impl ExactSizeIterator<Item = &str>, impl ExactSizeIterator<Item = &str>) {
        (self.undo.iter().map(Entry::name), self.redo.iter().rev().map(Entry::name))
    }

    /// Whether an entry is being played back, is waiting for a gesture to end, or collects steps.
    pub fn is_busy(&self) -> bool {
        self.playing.is_some() || !self.groups.is_empty() || !self.gestures.is_empty() || !self.asked.is_empty()
    }

    /// How many bytes entries may take together; the oldest are forgotten beyond.
    pub fn set_limit(&mut self, bytes: usize) {
        self.limit = bytes;
    }

    /// Makes one entry of everything that is done until [`end`](Self::end), other groups that begin and end meanwhile with it.
    pub fn begin(&mut self, name: impl Into<String>) {
        let entry = Entry { id: 0, name: name.into(), steps: Vec::new() };
        self.groups.push(Group { entry, gestures: Vec::new(), is_ending: false, is_taken_back: false });
    }

    /// Ends the group that began last: what is on its way still belongs to it.
    pub fn end(&mut self) {
        if let Some(group) = self.groups.iter_mut().rev().find(|group| !group.is_ending) {
            group.is_ending = true;
        }
    }

    /// Ends the group that began last, and takes back what it did: no entry comes of it.
    pub fn take_back(&mut self) {
        if let Some(group) = self.groups.iter_mut().rev().find(|group| !group.is_ending) {
            (group.is_ending, group.is_taken_back) = (true, true);
        }
    }

    /// Notes a spline that the user made.
    pub(crate) fn note_added(&mut self, name: &str, spline: Entity) {
        self.push(name, vec![Step::Shelve(spline)]);
    }

    /// Notes a spline that was taken off its surface.
    pub(crate) fn note_removed(&mut self, name: &str, spline: Entity) {
        self.push(name, vec![Step::Unshelve(spline)]);
    }

    /// Notes name and look of a curve before they changed.
    pub(crate) fn note_restyled(&mut self, name: &str, spline: Entity, before: Curve, after: &Curve) {
        // A colour that is being mixed changes many times: of one row the first is what undo leads back to.
        let only_colour = |a: &Curve, b: &Curve| Curve { color: b.color, ..a.clone() } == *b;
        let again = only_colour(&before, after)
            && self.undo.back().is_some_and(|last| match &last.steps[..] {
                [Step::Restyle(of, first)] => last.name == name && *of == spline && only_colour(first, &before),
                _ => false,
            });
        if again && self.groups.is_empty() && self.redo.is_empty() {
            self.mark_touched();
        } else {
            self.push(name, vec![Step::Restyle(spline, before)]);
        }
    }

    /// Notes a line before it was drawn or smoothed another way.
    pub(crate) fn note_redrawn(
        &mut self,
        name: &str,
        entity: Entity,
        line: &SurfaceLine,
        smoothing: Option<&LineSmoothing>,
    ) {
        self.push(name, vec![Step::Redraw(entity, Box::new((line.clone(), smoothing.copied())))]);
    }

    /// Whether anything changed since the document was saved or opened.
    pub fn is_dirty(&self) -> bool {
        self.saved != self.revision()
    }

    /// Forgets all entries; what is now counts as saved.
    fn forget(&mut self) {
        let (limit, base, touches) = (self.limit, self.next, self.touches);
        *self = Self { limit, base, next: base + 1, touches, ..Self::default() };
        self.saved = self.revision();
    }

    /// The state of the document.
    pub(crate) fn revision(&self) -> Revision {
        Revision { entry: self.undo.back().map_or(self.base, |entry| entry.id), touches: self.touches }
    }

    /// The document is saved as it was in a state.
    pub(crate) fn mark_saved(&mut self, revision: Revision) {
        self.saved = revision;
    }

    /// Something changed that no entry holds.
    pub(crate) fn mark_touched(&mut self) {
        self.touches += 1;
    }

    /// What takes back the gesture about a spline that is under way.
    pub(crate) fn inverse_of_gesture(&self, spline: Entity) -> Option<&SplineEdit> {
        let steps = self.gestures.values().flat_map(|entry| &entry.steps);
        steps.into_iter().find_map(|step| match step {
            Step::Edit(of, inverse) if *of == spline => Some(inverse),
            _ => None,
        })
    }

    fn push(&mut self, name: &str, steps: Vec<Step>) {
        match self.groups.last_mut() {
            Some(group) => group.entry.steps.extend(steps),
            None => self.note(Entry { id: 0, name: name.into(), steps }),
        }
    }

    fn note(&mut self, entry: Entry) {
        if entry.steps.is_empty() {
            return;
        }
        self.undo.push_back(Entry { id: self.next, ..entry });
        self.next += 1;
        self.redo.clear();
        self.forget_oldest();
    }

    fn forget_oldest(&mut self) {
        let mut bytes: usize = self.undo.iter().map(Entry::bytes).sum();
        while bytes > self.limit
            && self.undo.len() > 1
            && let Some(oldest) = self.undo.pop_front()
        {
            bytes -= oldest.bytes();
            self.base = oldest.id;
        }
    }

    /// Groups become entries once nothing of them is on its way, or a part of the one in which they began.
    fn finish_groups(&mut self) {
        for index in (0..self.groups.len()).rev() {
            if !self.groups.get(index).is_some_and(|group| group.is_ending && group.gestures.is_empty()) {
                continue;
            }
            let group = self.groups.remove(index);
            if group.is_taken_back {
                self.playing = Some(Playing::new(group.entry, Direction::Back));
            } else if let Some(outer) = index.checked_sub(1).and_then(|outer| self.groups.get_mut(outer)) {
                // Steps are taken back from the last to the first, and those around these came before as well as after.
                outer.entry.steps.extend(group.entry.steps);
            } else {
                self.note(group.entry);
            }
        }
    }

    /// Notes an undoable edit.
    fn record(&mut self, edit: &SplineEdited, name: String, batch: &mut Option<Entry>) {
        let step = Step::Edit(edit.entity, edit.inverse.clone());
        if let Some(gesture) = edit.gesture {
            self.gestures.insert(gesture, Entry { id: 0, name, steps: vec![step] });
            let is_known = self.groups.iter().any(|group| group.gestures.contains(&gesture));
            if let Some(group) = self.groups.last_mut().filter(|_| !is_known) {
                group.gestures.push(gesture);
            }
        } else if let Some(group) = self.groups.last_mut() {
            group.entry.steps.push(step);
        } else if let Some(Entry { steps, .. }) = batch.as_mut().filter(|batch| batch.is_about(edit.entity)) {
            steps.push(step);
        } else if let Some(before) = batch.replace(Entry { id: 0, name, steps: vec![step] }) {
            self.note(before);
        }
    }

    fn end_gesture(&mut self, end: &GestureEnded) {
        let entry = self.gestures.remove(&end.gesture).filter(|_| !end.cancelled);
        let group = self.groups.iter_mut().find(|group| group.gestures.contains(&end.gesture));
        match group {
            Some(group) => {
                group.gestures.retain(|gesture| *gesture != end.gesture);
                group.entry.steps.extend(entry.into_iter().flat_map(|entry| entry.steps));
            }
            None => entry.into_iter().for_each(|entry| self.note(entry)),
        }
    }
}

impl Entry {
    fn name(&self) -> &str {
        &self.name
    }

    fn is_about(&self, spline: Entity) -> bool {
        self.steps.iter().all(|step| matches!(step, Step::Edit(of, _) if *of == spline))
    }

    /// About how much memory it holds.
    fn bytes(&self) -> usize {
        let anchors = |anchors: &[Anchor]| anchors.iter().map(anchor_bytes).sum::<usize>();
        let edit = |edit: &SplineEdit| match edit {
            SplineEdit::Restore(patch) => anchors(patch.anchors()),
            SplineEdit::Replace(spline) | SplineEdit::Join { other: spline, .. } => anchors(spline.anchors()),
            _ => 0,
        };
        let step = |step: &Step| match step {
            Step::Edit(_, change) => edit(change),
            Step::Redraw(_, before) => size_of_val(before.0.crossings()),
            _ => 0,
        };
        self.steps.iter().map(|s| size_of::<Step>() + step(s)).sum::<usize>() + self.name.len()
    }
}

fn anchor_bytes(anchor: &Anchor) -> usize {
    let legs = [Some(anchor.incoming().leg()), Some(anchor.outgoing().leg()), anchor.middle()];
    let crossings: usize = legs.into_iter().flatten().map(|leg| size_of_val(leg.crossings())).sum();
    size_of::<Anchor>() + crossings
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<History>()
        .add_message::<PlayHistory>()
        .add_observer(playing::give_up)
        .add_systems(PreUpdate, (record, playing::play).chain().in_set(HistorySystems));
}

/// Where what was edited in the frame before is remembered, and undo and redo begin: in `PreUpdate`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct HistorySystems;

fn record(
    mut history: ResMut<History>,
    mut edited: MessageReader<SplineEdited>,
    mut ended: MessageReader<GestureEnded>,
    curves: Query<&Curve>,
) {
    if edited.is_empty() && ended.is_empty() && history.groups.is_empty() {
        return;
    }
    let mut batch: Option<Entry> = None;
    for edit in edited.read() {
        if edit.undoable {
            let of = curves.get(edit.entity).ok().map(|curve| curve.name.as_str());
            history.record(edit, name_of(&edit.edit, of), &mut batch);
        } else if edit.gesture.is_none() {
            history.come_round(edit);
        }
    }
    batch.into_iter().for_each(|entry| history.note(entry));
    ended.read().for_each(|end| history.end_gesture(end));
    history.finish_groups();
}

/// What an edit is called: what was done, and to which curve.
fn name_of(edit: &SplineEdit, curve: Option<&str>) -> String {
    let what = match edit {
        SplineEdit::MoveAnchor { anchor, .. } | SplineEdit::DragAnchor { anchor, .. } => {
            format!("Move anchor {}", anchor + 1)
        }
        SplineEdit::MoveHandle { anchor, .. }
        | SplineEdit::FreeHandle { anchor, .. }
        | SplineEdit::DragHandle { anchor, .. } => {
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
        SplineEdit::Replace(_) => "Reshape".into(),
        SplineEdit::SetScheme(_) => "Change scheme".into(),
        SplineEdit::SetJumps(_) => "Change what happens at jumps".into(),
        _ => "Edit".into(),
    };
    curve.map_or(what.clone(), |curve| format!("{what} of {curve}"))
}

/// Forgets everything, and splines that only the history kept; for another document.
pub(crate) fn clear(commands: &mut Commands, history: &mut History, shelved: &Query<Entity, With<Shelved>>) {
    history.forget();
    shelved.iter().for_each(|entity| commands.entity(entity).despawn());
}
