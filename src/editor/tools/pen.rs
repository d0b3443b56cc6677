//! The pen: a click adds a corner, a press that is dragged a smooth anchor whose handles follow the pointer.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::{Moment, PointerEvent, Target, Tool, ToolPointer};
use crate::curve::{HandleSide, Join, Spline, SplineEdit, SplineEnd};
use crate::editor::curves::{self, NextNumber};
use crate::editor::history::History;
use crate::editor::notices::Notices;
use crate::editor::selection::Selection;
use crate::geodesic::PathFinder;
use crate::plugin::{
    BuiltSurface, ControlKind, DragState, EditSpline, EndGesture, GestureId, OnSurface, SurfaceSpline,
};
use crate::surface::SurfacePoint;

/// Where the pen is: a first point, as a spline needs two, or a spline that it continues.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PenStart(pub(crate) Option<FirstPoint>, Option<Entity>);

impl PenStart {
    /// The spline that is continued.
    pub(crate) fn continues(&self) -> Option<Entity> {
        self.1
    }
}

/// The handle that is being pulled out of the last anchor of a spline, beyond which there is no segment yet.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PenPull(pub(crate) Option<(Entity, u32)>);

/// The first point of a spline that is not there yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FirstPoint {
    pub(crate) on: Entity,
    pub(crate) at: SurfacePoint,
    /// Where its handle was dragged to.
    pub(crate) handle: Option<SurfacePoint>,
}

/// The handle that is being dragged out of a new anchor.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pulling {
    /// Of the first point, which no spline has yet.
    First,
    /// Of the last anchor of a spline.
    Last { spline: Entity, anchor: u32, gesture: GestureId },
}

/// What the pen works with.
#[derive(SystemParam)]
pub(crate) struct Desk<'w, 's> {
    commands: Commands<'w, 's>,
    finder: Local<'s, PathFinder>,
    pulling: Local<'s, Option<Pulling>>,
    /// Whether an anchor was added that no spline has yet.
    has_added: Local<'s, bool>,
    next: ResMut<'w, NextNumber>,
    selection: ResMut<'w, Selection>,
    start: ResMut<'w, PenStart>,
    pull_shown: ResMut<'w, PenPull>,
    notices: ResMut<'w, Notices>,
    history: ResMut<'w, History>,
    edits: MessageWriter<'w, EditSpline>,
    ends: MessageWriter<'w, EndGesture>,
    splines: Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>,
    surfaces: Query<'w, 's, &'static BuiltSurface>,
}

pub(crate) fn draw(
    tool: Res<Tool>,
    pointer: Res<ToolPointer>,
    drag: Res<DragState>,
    mut later: Local<Vec<PointerEvent>>,
    mut desk: Desk,
) {
    if *tool != Tool::Pen {
        later.clear();
        desk.start.set_if_neq(PenStart::default());
        desk.let_go(false);
        return;
    }
    if tool.is_changed() {
        desk.take();
    }
    later.extend(&pointer.events);
    // An anchor is there in the next frame, and what follows may be about it: in a slow frame there may be more than one click.
    let mut done = 0;
    for event in &*later {
        done += 1;
        match *event {
            // The plugin drags what is there already.
            PointerEvent::DragStart { from } if draws_on(&from) && drag.held().is_none() => desk.begin_pull(&from),
            PointerEvent::Drag { to, .. } => desk.pull(&to),
            PointerEvent::DragEnd { .. } => desk.let_go(false),
            PointerEvent::Cancel => desk.let_go(true),
            PointerEvent::Click { at, .. } => desk.click(&at),
            _ => {}
        }
        if std::mem::take(&mut *desk.has_added) {
            break;
        }
    }
    later.drain(..done);
}

fn draws_on(from: &Moment) -> bool {
    !matches!(from.target, Target::Control { .. }) && from.surface.is_some()
}

impl Desk<'_, '_> {
    /// The pen is taken: it goes on where the last anchor of a curve is selected, else it begins another one.
    fn take(&mut self) {
        let last = self.selection.anchors().last().copied();
        let continued = last.filter(|(entity, anchor)| {
            let spline = self.splines.get(*entity).ok().map(|(spline, _)| spline);
            spline.is_some_and(|spline| !spline.is_closed() && *anchor as usize + 1 == spline.anchors().len())
        });
        self.start.set_if_neq(PenStart(None, continued.map(|(entity, _)| entity)));
    }

    /// The open spline that is drawn on.
    fn active(&self) -> Option<(Entity, &Spline)> {
        let entity = self.start.continues()?;
        let spline: &Spline = self.splines.get(entity).ok()?.0;
        (!spline.is_closed()).then_some((entity, spline))
    }

    fn click(&mut self, at: &Moment) {
        if let Target::Control { spline, kind: ControlKind::Anchor(anchor) } = at.target {
            self.click_anchor(spline, anchor);
        } else if draws_on(at)
            && let Some((on, point)) = at.surface
        {
            self.add_anchor(on, point);
        } else if at.surface.is_none() {
            self.notices.info("Click on the model: the pen draws on its surface.");
        }
    }

    /// A click on the first anchor closes the spline, one on the last cuts its handle.
    fn click_anchor(&mut self, spline: Entity, anchor: u32) {
        let Some((entity, active)) = self.active().filter(|(entity, _)| *entity == spline) else {
            self.continue_at(spline, anchor);
            return;
        };
        let last = active.anchors().len().saturating_sub(1) as u32;
        if anchor == 0 && last > 1 {
            self.edits.write(EditSpline::new(entity, SplineEdit::Close).undoable());
        } else if anchor == 0 {
            self.notices.info("A curve is closed when it has three anchors: add one first.");
        } else if anchor == last
            && let Some(to) = active.anchors().last().map(|last| last.point())
        {
            let send = [
                SplineEdit::SetJoin { anchor, join: Join::Corner },
                SplineEdit::MoveHandle { anchor, side: HandleSide::Outgoing, to },
            ];
            self.edits.write_batch(send.map(|edit| EditSpline::new(entity, edit).undoable()));
        }
    }

    /// A click on the last anchor of another curve continues that.
    fn continue_at(&mut self, entity: Entity, anchor: u32) {
        let Ok((spline, _)) = self.splines.get(entity) else { return };
        if self.start.0.is_none() && !spline.is_closed() && anchor as usize + 1 == spline.anchors().len() {
            self.start.1 = Some(entity);
            self.selection.select_anchor(entity, anchor);
        }
    }

    /// The pen touches the surface: a new anchor, or the beginning of a new spline. Gives the anchor.
    fn add_anchor(&mut self, on: Entity, at: SurfacePoint) -> Option<(Entity, u32)> {
        let is_there = |entity| self.splines.get(entity).is_ok_and(|(_, surface)| surface.0 == on);
        if let Some((entity, spline)) = self.active().filter(|(entity, _)| is_there(*entity)) {
            let anchor = spline.anchors().len() as u32;
            let edit = SplineEdit::Append { end: SplineEnd::End, at };
            self.edits.write(EditSpline::new(entity, edit).undoable());
            self.selection.select_anchor_next(entity, anchor);
            *self.has_added = true;
            return Some((entity, anchor));
        }
        let start = self.start.0.take().filter(|first| first.on == on);
        let Some(first) = start else {
            self.selection.clear();
            *self.start = PenStart(Some(FirstPoint { on, at, handle: None }), None);
            return None;
        };
        match self.new_spline(&first, at) {
            Ok(spline) => {
                let curve = self.next.curve(None);
                let entity = curves::spawn(&mut self.commands, on, curve, spline);
                self.history.note_added("Add spline", entity);
                self.selection.select_anchor_next(entity, 1);
                *self.has_added = true;
                self.start.1 = Some(entity);
                Some((entity, 1))
            }
            Err(reason) => {
                self.start.0 = Some(first);
                self.notices.warn(reason);
                None
            }
        }
    }

    fn new_spline(&mut self, first: &FirstPoint, second: SurfacePoint) -> Result<Spline, String> {
        let surface = self.surfaces.get(first.on).map_err(|_| "the model is gone".to_string())?;
        let finder = &mut self.finder;
        let Some(handle) = first.handle else {
            return Spline::corners_through(surface, finder, &[first.at, second], false)
                .map_err(|error| error.to_string());
        };
        let polygon = [first.at, handle, second, second];
        let mut spline = Spline::bezier(surface, finder, polygon).map_err(|error| error.to_string())?;
        // The join makes both handles alike, and one of them had no length.
        let mirrored = SplineEdit::SetJoin { anchor: 0, join: Join::Mirrored };
        let pulled = SplineEdit::MoveHandle { anchor: 0, side: HandleSide::Outgoing, to: handle };
        for edit in [mirrored, pulled] {
            spline.apply(surface, finder, &edit).map_err(|error| error.to_string())?;
        }
        Ok(spline)
    }

    /// A handle is dragged out of a new anchor.
    fn begin_pull(&mut self, from: &Moment) {
        let Some((on, point)) = from.surface else { return };
        self.history.begin("Draw smooth anchor");
        let added = self.add_anchor(on, point);
        *self.pulling = match added {
            Some((spline, anchor)) => {
                let mirrored = SplineEdit::SetJoin { anchor, join: Join::Mirrored };
                self.edits.write(EditSpline::new(spline, mirrored).undoable());
                Some(Pulling::Last { spline, anchor, gesture: GestureId::next() })
            }
            None if self.start.0.is_some() => Some(Pulling::First),
            None => None,
        };
        if self.pulling.is_none() {
            self.history.end();
        }
    }

    fn pull(&mut self, to: &Moment) {
        let Some((on, point)) = to.surface else { return };
        match *self.pulling {
            Some(Pulling::First) => {
                if let Some(first) = self.start.0.as_mut().filter(|first| first.on == on) {
                    first.handle = Some(point);
                }
            }
            Some(Pulling::Last { spline, anchor, gesture }) => {
                self.pull_shown.set_if_neq(PenPull(Some((spline, anchor))));
                let edit = SplineEdit::MoveHandle { anchor, side: HandleSide::Outgoing, to: point };
                self.edits.write(EditSpline::new(spline, edit).undoable().in_gesture(gesture));
            }
            None => {}
        }
    }

    /// The handle is let go; taken back, the anchor goes as well.
    fn let_go(&mut self, cancel: bool) {
        self.pull_shown.set_if_neq(PenPull(None));
        match self.pulling.take() {
            Some(Pulling::First) if cancel => self.start.0 = None,
            Some(Pulling::Last { gesture, .. }) => {
                self.ends.write(EndGesture { gesture, cancel });
            }
            Some(Pulling::First) => {}
            None => return,
        }
        if cancel { self.history.take_back() } else { self.history.end() }
    }
}
