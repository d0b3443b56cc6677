//! The ways that drags lead control points over a surface: each continued from where the pointer was to where it is, in the
//! frame or, where that takes longer than a frame has, in the background.
//!
//! A way depends on all places that the pointer was at and on nothing else, so none is left out, and where it is computed
//! does not matter. Its edits come when it is known; the end of its gesture waits for the last of them.

use std::collections::VecDeque;
use std::sync::Arc;

use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on, futures_lite::future};

use super::background::{SAFE_FACES, wait_for};
use super::controls::ControlKind;
use super::costs::Pace;
use super::edit::{EditSpline, EndGesture, GestureId};
use super::edit_costs::lead_work;
use super::workspaces::Workspaces;
use crate::curve::SplineEdit;
use crate::geodesic::GeodesicPath;
use crate::surface::{Surface, SurfacePoint};

/// The ways that are not over, in the order of their gestures.
#[derive(Resource, Default)]
pub(super) struct Ways {
    open: VecDeque<Way>,
    /// How long it takes to lead on.
    pace: Pace,
}

/// The way of one gesture.
pub(super) struct Way {
    pub(super) spline: Entity,
    pub(super) kind: ControlKind,
    pub(super) gesture: GestureId,
    surface: Arc<Surface>,
    /// As far as it is known; none where it broke off: edits then say no more than where to.
    known: Option<GeodesicPath>,
    /// Where the pointer was since then, and is.
    ahead: Vec<SurfacePoint>,
    newest: SurfacePoint,
    running: Option<Task<Led>>,
    /// Whether the pointer has let go.
    is_over: bool,
}

/// A way that was led on: modelled work, and the seconds that it took.
struct Led {
    way: Option<GeodesicPath>,
    last: SurfacePoint,
    work: f64,
    seconds: f64,
}

/// What is sent.
pub(super) enum Sent {
    Edit(EditSpline),
    End(EndGesture),
}

impl Way {
    /// The way of a gesture that begins at a point.
    pub(super) fn new(
        spline: Entity,
        kind: ControlKind,
        gesture: GestureId,
        surface: Arc<Surface>,
        from: SurfacePoint,
    ) -> Self {
        let known = Some(GeodesicPath::at_rest(from));
        Self { spline, kind, gesture, surface, known, ahead: Vec::new(), newest: from, running: None, is_over: false }
    }

    pub(super) fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    fn edit(&self, to: SurfacePoint) -> EditSpline {
        let along = self.known.clone();
        let edit: SplineEdit = along.map_or(self.kind.moved(to), |along| self.kind.dragged(along));
        EditSpline::new(self.spline, edit).undoable().in_gesture(self.gesture)
    }

    fn take(&mut self, led: Led, pace: &mut Pace) -> EditSpline {
        pace.learn(led.work, led.seconds);
        self.known = led.way;
        self.edit(led.last)
    }

    /// Leads the way to where the pointer is, as far as that is possible in so many seconds; gives the edit that follows from it.
    fn lead(&mut self, seconds: f64, pace: &mut Pace, workspaces: &Workspaces) -> Option<EditSpline> {
        let begin = Instant::now();
        let mut edit = None;
        if let Some(task) = &mut self.running {
            let led = block_on(future::poll_once(task))?;
            self.running = None;
            edit = Some(self.take(led, pace));
        }
        let Some(&last) = self.ahead.last() else { return edit };
        let places = std::mem::take(&mut self.ahead);
        let Some(known) = self.known.clone() else { return Some(self.edit(last)) };
        let work = lead_work(&self.surface, &known, &places);
        let left = seconds - begin.elapsed().as_secs_f64();
        let fits = pace.expect(work) <= left;
        let (surface, workspaces) = (self.surface.clone(), workspaces.clone());
        let led = move || led(&surface, known, &places, last, work, &workspaces);
        if fits && (self.surface.face_count() <= SAFE_FACES || seconds.is_infinite()) {
            return Some(self.take(led(), pace));
        }
        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(async move { led() });
        let running = self.running.insert(task);
        if fits && wait_for(running, left) {
            // It is done, so this ends here.
            return self.lead(0.0, pace, &Workspaces::default()).or(edit);
        }
        edit
    }
}

/// Continues a way through some places.
fn led(
    surface: &Surface,
    way: GeodesicPath,
    places: &[SurfacePoint],
    last: SurfacePoint,
    work: f64,
    workspaces: &Workspaces,
) -> Led {
    let begin = Instant::now();
    let on = |way: GeodesicPath, to: &SurfacePoint| {
        workspaces.lend(|workspace| workspace.finder.continued(surface, &way, to).ok())
    };
    let way = places.iter().try_fold(way, on);
    Led { way, last, work, seconds: begin.elapsed().as_secs_f64() }
}

impl Ways {
    pub(super) fn begin(&mut self, way: Option<Way>) {
        self.open.extend(way);
    }

    /// Whether a way of a spline is not over.
    pub(super) fn has_one_of(&self, spline: Entity) -> bool {
        self.open.iter().any(|way| way.spline == spline)
    }

    /// Where the control points are to be that are led along ways not known yet.
    pub(super) fn unknown(&self) -> impl Iterator<Item = (Entity, SplineEdit)> {
        let unknown = self.open.iter().filter(|way| way.running.is_some() || !way.ahead.is_empty());
        unknown.map(|way| (way.spline, way.kind.moved(way.newest)))
    }

    /// Drops the way of a gesture.
    pub(super) fn forget(&mut self, gesture: GestureId) {
        self.open.retain(|way| way.gesture != gesture);
    }

    /// Drops the ways that lead nowhere any more.
    pub(super) fn retain(&mut self, leads_on: impl Fn(&Way) -> bool) {
        for way in self.open.iter_mut().filter(|way| !leads_on(way)) {
            (way.running, way.known) = (None, None);
        }
    }

    /// The pointer of a gesture has moved; says whether the gesture has a way.
    pub(super) fn follow(&mut self, gesture: GestureId, to: SurfacePoint) -> bool {
        let way = self.open.iter_mut().find(|way| way.gesture == gesture);
        way.is_some_and(|way| {
            way.ahead.push(to);
            way.newest = to;
            true
        })
    }

    /// A gesture ends; says whether its end is to wait for its way.
    pub(super) fn finish(&mut self, end: EndGesture) -> bool {
        if end.cancel {
            self.forget(end.gesture);
            return false;
        }
        let way = self.open.iter_mut().find(|way| way.gesture == end.gesture);
        way.map(|way| way.is_over = true).is_some()
    }

    /// Leads ways on, for about so many seconds, and sends what follows from them: of one gesture after the other, because what
    /// the next one begins with is what the last one made.
    pub(super) fn lead(&mut self, seconds: f64, workspaces: &Workspaces, mut send: impl FnMut(Sent)) {
        let begin = Instant::now();
        while let Some(way) = self.open.front_mut() {
            let left = seconds - begin.elapsed().as_secs_f64();
            if let Some(edit) = way.lead(left, &mut self.pace, workspaces) {
                send(Sent::Edit(edit));
            }
            if !way.is_over || way.running.is_some() {
                return;
            }
            send(Sent::End(EndGesture { gesture: way.gesture, cancel: false }));
            self.open.pop_front();
        }
    }
}
