//! What keys and panels ask for: messages that any system may write, and that become edits, entries of the history, and changes of
//! the selection.

mod shape;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::clipboard::{self, Changes, Clipboard, CopyDesk};
use super::convert::Convert;
use super::curves::{self, Content, Curve, NextNumber};
use super::documents::FileRequest;
use super::history::{History, PlayHistory};
use super::notices::Notices;
use super::selection::Selection;
use super::tools::Tool;
use super::tools::transform::{BeginTransform, TransformMode};
use crate::curve::{Join, JumpPolicy, Scheme, Spline, SplineEdit, SplineEnd};
use crate::geodesic::PathFinder;
use crate::plugin::{
    BuiltSurface, EditSpline, EndGesture, GestureId, LineSmoothing, OnSurface, SplineEditRefused,
    SplinePickingSettings, SurfaceSpline, SurfaceSplineSystems,
};
use crate::surface::SurfacePoint;

/// Something to be done with what is selected.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum EditorAction {
    /// Takes a tool.
    Take(Tool),
    /// Selects a spline alone.
    Select(Entity),
    /// Selects a spline too, or takes it out of the selection.
    Toggle(Entity),
    /// Selects all that is free.
    SelectAll,
    /// Takes the pen, for a new spline.
    BeginSpline,
    /// Deletes the selected anchors, or the selected splines where none is selected or too few would be left.
    Delete,
    /// Deletes the segment behind the active anchor.
    DeleteSegment,
    /// Removes a spline.
    Remove(Entity),
    /// Corner → smooth → mirrored → automatic, of the selected anchors.
    CycleJoin,
    /// Changes the join of the selected anchors.
    SetJoin(Join),
    /// Joins the ends of the selected splines, or opens them where they begin.
    ToggleClosed,
    /// Cuts the active spline in two at the active anchor.
    Split,
    /// Joins the last two selected splines at the ends that are nearest to each other, or at those that are selected.
    JoinSplines,
    /// Lets the selected splines run the other way.
    Reverse,
    /// Makes the segment behind the active anchor a geodesic.
    Straighten,
    /// Moves the active anchor.
    MoveAnchorTo(SurfacePoint),
    /// Moves the active anchor on its way to another place: all until [`EditorAction::EndSlide`] are one entry of the history.
    SlideAnchorTo(SurfacePoint),
    /// Changes how the selected splines are traced.
    SetScheme(Scheme),
    /// Changes what happens where a leg could go another way.
    SetJumps(JumpPolicy),
    /// A scheme on the way to another: all until [`EditorAction::EndSlide`] are one entry of the history.
    SlideScheme(Scheme),
    /// Ends the way of a slider.
    EndSlide,
    /// Changes how the selected lines are smoothed; none: not at all.
    SetSmoothing(Option<LineSmoothing>),
    /// Smoothing on the way to another: all until [`EditorAction::EndSlide`] are one entry of the history.
    SlideSmoothing(LineSmoothing),
    /// Makes lines of the selected splines, along their traces.
    ToLines,
    /// Makes splines of the selected lines, within the tolerance of the freehand tool.
    ToSplines,
    /// Changes name and look of a curve.
    Restyle(Entity, Curve),
    /// Copies the selected splines.
    Copy,
    /// Pastes what was copied at the pointer; scaled, by how much larger the model is than the one that was copied from.
    Paste {
        /// Whether it is scaled.
        scaled: bool,
    },
    /// Copies the selected splines in place.
    Duplicate,
    /// Begins a transform of the selection that follows the pointer.
    Transform(TransformMode),
    /// Lets the pointer take what is behind the model, or not any more.
    ToggleSeeThrough,
    /// Marks the places where the model was repaired, or not any more.
    ToggleRepairs,
    /// Saves the document, where there is one.
    Save,
    /// Takes the last entry of the history back.
    Undo,
    /// Does again what was taken back last.
    Redo,
}

pub(crate) fn plugin(app: &mut App) {
    app.add_message::<EditorAction>()
        .init_resource::<NextNumber>()
        .init_resource::<Clipboard>()
        .init_resource::<ShownRepairs>()
        .init_resource::<SplinePickingSettings>()
        .add_observer(tell_refusal)
        .add_systems(PostUpdate, perform.before(SurfaceSplineSystems::Edit))
        .add_systems(PostUpdate, curves::show_or_hide.before(SurfaceSplineSystems::Edit));
}

fn tell_refusal(refused: On<SplineEditRefused>, mut notices: ResMut<Notices>) {
    notices.warn(refused.reason.to_string());
}

/// Whether the places where the model was repaired are marked.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ShownRepairs(pub(crate) bool);

/// What actions work with.
#[derive(SystemParam)]
struct Desk<'w, 's> {
    commands: Commands<'w, 's>,
    edits: MessageWriter<'w, EditSpline>,
    ends: MessageWriter<'w, EndGesture>,
    plays: MessageWriter<'w, PlayHistory>,
    transforms: MessageWriter<'w, BeginTransform>,
    files: Option<MessageWriter<'w, FileRequest>>,
    picking: ResMut<'w, SplinePickingSettings>,
    repairs: ResMut<'w, ShownRepairs>,
    copying: CopyDesk<'w, 's>,
    slide: Local<'s, Vec<(Entity, GestureId)>>,
    finder: Local<'s, PathFinder>,
    lines: curves::Lines<'w, 's>,
    conversions: MessageWriter<'w, Convert>,
    sliding_lines: Local<'s, bool>,
    history: ResMut<'w, History>,
    notices: ResMut<'w, Notices>,
    selection: ResMut<'w, Selection>,
    tool: ResMut<'w, Tool>,
    next: ResMut<'w, NextNumber>,
    splines: Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>,
    curves: Query<'w, 's, (Entity, &'static Curve)>,
    surfaces: Query<'w, 's, &'static BuiltSurface>,
}

fn perform(mut actions: MessageReader<EditorAction>, mut desk: Desk) {
    for action in actions.read() {
        desk.perform(action);
    }
}

impl Desk<'_, '_> {
    fn perform(&mut self, action: &EditorAction) {
        match action {
            EditorAction::Take(tool) => *self.tool = *tool,
            EditorAction::Select(entity) => self.selection.select(*entity),
            EditorAction::Toggle(entity) => self.selection.toggle(*entity),
            EditorAction::SelectAll => self.select_all(),
            EditorAction::BeginSpline => {
                self.selection.clear();
                *self.tool = Tool::Pen;
            }
            EditorAction::Undo => drop(self.plays.write(PlayHistory::Undo)),
            EditorAction::Redo => drop(self.plays.write(PlayHistory::Redo)),
            EditorAction::Remove(entity) => self.remove("Remove spline", *entity),
            EditorAction::Delete => self.delete(),
            EditorAction::DeleteSegment => self.delete_segment(),
            EditorAction::CycleJoin => self.cycle_join(),
            EditorAction::SetJoin(join) => self.set_joins(*join),
            EditorAction::ToggleClosed => self.toggle_closed(),
            EditorAction::Split => self.split(),
            EditorAction::JoinSplines => self.join(),
            EditorAction::Reverse => self.for_selected("Reverse", |_| Some(SplineEdit::Reverse)),
            EditorAction::Straighten => self.straighten(),
            EditorAction::MoveAnchorTo(to) => {
                if let Some((spline, anchor)) = self.selection.anchors().last().copied() {
                    self.send(spline, SplineEdit::MoveAnchor { anchor, to: *to });
                }
            }
            EditorAction::SetScheme(scheme) => self.for_selected("Change scheme", |spline| {
                (spline.scheme() != *scheme).then_some(SplineEdit::SetScheme(*scheme))
            }),
            EditorAction::SetJumps(jumps) => self.for_selected("Change what happens at jumps", |spline| {
                (spline.jumps() != *jumps).then_some(SplineEdit::SetJumps(*jumps))
            }),
            EditorAction::SlideAnchorTo(to) => {
                if let Some((spline, anchor)) = self.selection.anchors().last().copied() {
                    self.slide("Move anchor", &[spline], &SplineEdit::MoveAnchor { anchor, to: *to });
                }
            }
            EditorAction::SlideScheme(scheme) => {
                let splines = self.selection.splines().to_vec();
                self.slide("Change scheme", &splines, &SplineEdit::SetScheme(*scheme));
            }
            EditorAction::EndSlide => self.end_slide(),
            EditorAction::SetSmoothing(smoothing) => self.set_smoothing(*smoothing),
            EditorAction::SlideSmoothing(smoothing) => self.slide_smoothing(*smoothing),
            EditorAction::ToLines | EditorAction::ToSplines => drop(self.conversions.write(Convert {
                to_splines: *action == EditorAction::ToSplines,
                entities: self.selection.splines().to_vec(),
            })),
            EditorAction::Restyle(entity, curve) => self.restyle(*entity, curve),
            EditorAction::Save => {
                if let Some(files) = &mut self.files {
                    files.write(FileRequest::Save);
                }
            }
            EditorAction::ToggleSeeThrough => {
                self.picking.see_through = !self.picking.see_through;
                let now = if self.picking.see_through { "can be selected." } else { "cannot be selected any more." };
                self.notices.info_instead("What is behind the model ", now);
            }
            EditorAction::ToggleRepairs => self.repairs.0 = !self.repairs.0,
            EditorAction::Transform(mode) => drop(self.transforms.write(BeginTransform(*mode))),
            EditorAction::Copy | EditorAction::Paste { .. } | EditorAction::Duplicate => self.copy_or_paste(action),
        }
    }

    fn copy_or_paste(&mut self, action: &EditorAction) {
        let mut changes = Changes {
            commands: &mut self.commands,
            history: &mut self.history,
            notices: &mut self.notices,
            selection: &mut self.selection,
            next: &mut self.next,
        };
        match action {
            EditorAction::Copy => self.copying.copy(&self.splines, &self.surfaces, &self.curves, &mut changes),
            EditorAction::Paste { scaled } => self.copying.paste(&self.surfaces, *scaled, &mut changes),
            _ => clipboard::duplicate(&self.splines, &self.curves, &mut changes),
        }
    }

    fn send(&mut self, spline: Entity, edit: SplineEdit) {
        self.edits.write(EditSpline::new(spline, edit).undoable());
    }

    fn spline(&self, entity: Entity) -> Option<&Spline> {
        self.splines.get(entity).ok().map(|(spline, _)| &**spline)
    }

    /// Sends an edit of each selected spline, as one entry of the history.
    fn for_selected(&mut self, name: &str, edit: impl Fn(&Spline) -> Option<SplineEdit>) {
        let of = |entity: &Entity| Some((*entity, edit(self.spline(*entity)?)?));
        let edits: Vec<_> = self.selection.splines().iter().filter_map(of).collect();
        if edits.len() > 1 {
            self.history.begin(format!("{name} of {} curves", edits.len()));
        }
        let many = edits.len() > 1;
        edits.into_iter().for_each(|(entity, edit)| self.send(entity, edit));
        if many {
            self.history.end();
        }
    }

    fn select_all(&mut self) {
        let is_there = |entity| self.splines.contains(entity) || self.lines.contains(entity);
        let mut free: Vec<_> =
            self.curves.iter().filter(|(entity, curve)| curve.is_free() && is_there(*entity)).collect();
        free.sort_by_key(|(_, curve)| curve.number);
        let free: Vec<_> = free.into_iter().map(|(entity, _)| entity).collect();
        self.selection.clear_anchors();
        free.into_iter().for_each(|entity| self.selection.add(entity));
    }

    fn remove(&mut self, name: &str, entity: Entity) {
        if let Ok((line, smoothing, on)) = self.lines.get(entity) {
            let content = Content::Line(line.clone(), smoothing.copied());
            curves::shelve(&mut self.commands, entity, content, on.0);
            self.history.note_removed(name, entity);
            return;
        }
        let Ok((spline, on)) = self.splines.get(entity) else { return };
        let mut spline: Spline = (**spline).clone();
        // A gesture about it ends as if it had not been, so what is kept is the spline as it was before.
        if let (Some(inverse), Ok(surface)) = (self.history.inverse_of_gesture(entity), self.surfaces.get(on.0)) {
            let taken_back = spline.apply(surface, &mut self.finder, inverse);
            taken_back.err().into_iter().for_each(|error| warn!("a gesture is not taken back: {error}"));
        }
        curves::shelve(&mut self.commands, entity, Content::Spline(spline), on.0);
        self.history.note_removed(name, entity);
    }

    fn delete(&mut self) {
        let anchors = self.selection.anchors().to_vec();
        let mut splines = self.selection.splines().to_vec();
        self.history.begin(if anchors.is_empty() { "Remove splines" } else { "Delete anchors" });
        if !anchors.is_empty() {
            splines.retain(|spline| anchors.iter().any(|(of, _)| of == spline));
        }
        for spline in splines {
            let mut gone: Vec<u32> =
                anchors.iter().filter(|(of, _)| *of == spline).map(|(_, anchor)| *anchor).collect();
            let count = self.spline(spline).map_or(0, |spline| spline.anchors().len());
            if gone.is_empty() || count < gone.len() + 2 {
                if !gone.is_empty() && count > gone.len() {
                    self.notices.info("A curve of one anchor is none: it is removed. Undo brings it back.");
                }
                self.remove("Remove spline", spline);
                continue;
            }
            // From the last to the first, so that numbers stay true.
            gone.sort_unstable_by(|a, b| b.cmp(a));
            gone.into_iter().for_each(|anchor| self.send(spline, SplineEdit::DeleteFitted { anchor }));
        }
        self.history.end();
        self.selection.clear_anchors();
    }

    /// The spline falls apart where the segment was.
    fn delete_segment(&mut self) {
        let Some((entity, anchor)) = self.selection.anchors().last().copied() else { return };
        let Ok((spline, on)) = self.splines.get(entity) else { return };
        let (count, on, closed) = (spline.anchors().len() as u32, on.0, spline.is_closed());
        let spline: Spline = (**spline).clone();
        self.history.begin("Delete segment");
        if closed {
            // Cut open behind the segment, it is the last one.
            self.send(entity, SplineEdit::Open { anchor: (anchor + 1) % count });
            self.send(entity, SplineEdit::Delete { anchor: count });
        } else if count == 2 {
            self.remove("Remove spline", entity);
        } else if anchor == 0 || anchor + 2 == count {
            self.send(entity, SplineEdit::Delete { anchor: if anchor == 0 { 0 } else { count - 1 } });
        } else if anchor + 2 < count
            && let Ok([_, behind]) = spline.split(anchor + 1)
        {
            self.send(entity, SplineEdit::Cut { anchor, keep: SplineEnd::Start });
            self.spawn(on, behind, entity);
        }
        self.history.end();
        self.selection.clear_anchors();
    }

    /// Adds a spline that looks like another.
    fn spawn(&mut self, on: Entity, spline: Spline, like: Entity) -> Entity {
        let mut curve = self.next.curve(None);
        if let Ok((_, other)) = self.curves.get(like) {
            curve = Curve { number: curve.number, name: curve.name, ..other.clone() };
        }
        let entity = curves::spawn(&mut self.commands, on, curve, spline);
        self.history.note_added("Add spline", entity);
        entity
    }

    /// Sends an edit that others of its kind follow, as one gesture.
    fn slide(&mut self, name: &str, splines: &[Entity], edit: &SplineEdit) {
        if self.slide.is_empty() {
            if splines.is_empty() {
                return;
            }
            *self.slide = splines.iter().map(|spline| (*spline, GestureId::next())).collect();
            self.history.begin(name);
        }
        for (spline, gesture) in self.slide.iter() {
            self.edits.write(EditSpline::new(*spline, edit.clone()).undoable().in_gesture(*gesture));
        }
    }

    /// Notes the selected lines as they are, and gives them another way of smoothing.
    fn set_smoothing(&mut self, smoothing: Option<LineSmoothing>) {
        self.history.begin("Change smoothing");
        self.smooth_selected(smoothing, true);
        self.history.end();
    }

    fn slide_smoothing(&mut self, smoothing: LineSmoothing) {
        let begins = !std::mem::replace(&mut *self.sliding_lines, true);
        if begins {
            self.history.begin("Change smoothing");
        }
        self.smooth_selected(Some(smoothing), begins);
    }

    fn smooth_selected(&mut self, smoothing: Option<LineSmoothing>, notes: bool) {
        for entity in self.selection.splines().to_vec() {
            let Ok((line, before, _)) = self.lines.get(entity) else { continue };
            if notes {
                self.history.note_redrawn("Change smoothing", entity, line, before);
            } else {
                self.history.mark_touched();
            }
            let mut commands = self.commands.entity(entity);
            match smoothing {
                Some(smoothing) => commands.try_insert(smoothing),
                None => commands.try_remove::<LineSmoothing>(),
            };
        }
    }

    fn end_slide(&mut self) {
        if std::mem::take(&mut *self.sliding_lines) {
            self.history.end();
        }
        if self.slide.is_empty() {
            return;
        }
        let ended: Vec<_> = self.slide.drain(..).collect();
        self.ends.write_batch(ended.iter().map(|(_, gesture)| EndGesture { gesture: *gesture, cancel: false }));
        self.history.end();
    }

    fn restyle(&mut self, entity: Entity, curve: &Curve) {
        let Ok((_, before)) = self.curves.get(entity) else { return };
        if before != curve {
            let name = format!("Change look of {}", before.name);
            self.history.note_restyled(&name, entity, before.clone(), curve);
            self.commands.entity(entity).try_insert(curve.clone());
        }
    }
}
