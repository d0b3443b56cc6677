//! Drawing by hand: the line that the pointer draws becomes a spline within a tolerance, which may be changed until the next click.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on, futures_lite::future};
use std::collections::VecDeque;
use std::sync::Arc;

use super::{PointerEvent, Tool, ToolPointer};
use crate::curve::{DrawnLine, FitOptions, Spline, SplineEdit, TraceWorkspace};
use crate::editor::curves::{self, NextNumber};
use crate::editor::history::History;
use crate::editor::notices::Notices;
use crate::editor::selection::Selection;
use crate::geodesic::PathFinder;
use crate::plugin::{BuiltSurface, EditSpline, EndGesture, GestureId, LineSmoothing, SurfaceLine, SurfaceSpline};
use crate::smooth::SurfacePolyline;
use crate::surface::Surface;

/// A line that ends this near to where it began, in pixels, is closed.
const CLOSES: f32 = 10.0;
/// Points nearer than this to the last one, in pixels, are left out.
const THINNING: f32 = 3.0;
/// A slider that has not moved for so many frames has come to rest.
const REST: u32 = 20;

/// How drawn lines become splines.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct FreehandSettings {
    /// Largest distance between line and spline, as a share of the surface's diagonal.
    pub tolerance: f64,
    /// Whether what is drawn stays a line, which is smoothed live, instead of becoming a spline.
    pub as_line: bool,
}

impl Default for FreehandSettings {
    fn default() -> Self {
        Self { tolerance: 0.004, as_line: false }
    }
}

/// The line that is drawn, and the one drawn last.
#[derive(Resource, Debug, Default)]
pub struct Freehand {
    stroke: Option<Stroke>,
    fitting: Option<Fitting>,
    /// Lines that were drawn before the one that is fitted was done.
    waiting: VecDeque<(Entity, Arc<DrawnLine>)>,
    /// What changes with the tolerance.
    fresh: Option<Fresh>,
}

#[derive(Debug)]
struct Stroke {
    on: Entity,
    line: DrawnLine,
    from: Vec2,
    last: Vec2,
}

#[derive(Debug)]
struct Fitting {
    task: Task<Result<Spline, String>>,
    line: Arc<DrawnLine>,
    on: Entity,
    tolerance: f64,
    /// The spline that it replaces; none: a new one.
    replaces: Option<Entity>,
}

#[derive(Debug)]
struct Fresh {
    /// All that the tolerance changes in one go is one entry of the history.
    gesture: Option<GestureId>,
    /// Frames since it changed last.
    idle: u32,
    spline: Entity,
    on: Entity,
    line: Arc<DrawnLine>,
    tolerance: f64,
}

impl Freehand {
    /// Where the line runs that is drawn, and the model.
    pub fn drawn(&self) -> Option<(Entity, &DrawnLine)> {
        let stroke = self.stroke.as_ref().map(|stroke| (stroke.on, &stroke.line));
        stroke.or_else(|| self.fitting.as_ref().filter(|f| f.replaces.is_none()).map(|f| (f.on, &*f.line)))
    }

    /// Whether a line is being fitted.
    pub fn is_fitting(&self) -> bool {
        self.fitting.is_some() || !self.waiting.is_empty()
    }

    /// Whether the tolerance changes the line drawn last.
    pub fn is_fresh(&self) -> bool {
        self.fresh.is_some()
    }
}

/// What drawing works with.
#[derive(SystemParam)]
pub(crate) struct Desk<'w, 's> {
    commands: Commands<'w, 's>,
    finder: Local<'s, PathFinder>,
    state: ResMut<'w, Freehand>,
    settings: Res<'w, FreehandSettings>,
    next: ResMut<'w, NextNumber>,
    selection: ResMut<'w, Selection>,
    notices: ResMut<'w, Notices>,
    history: ResMut<'w, History>,
    edits: MessageWriter<'w, EditSpline>,
    ends: MessageWriter<'w, EndGesture>,
    splines: Query<'w, 's, &'static SurfaceSpline>,
    surfaces: Query<'w, 's, &'static BuiltSurface>,
}

pub(crate) fn draw(tool: Res<Tool>, pointer: Res<ToolPointer>, mut desk: Desk) {
    desk.collect();
    if *tool != Tool::Freehand {
        if desk.state.stroke.is_some() || desk.state.fresh.is_some() {
            desk.state.stroke = None;
            desk.forget_fresh();
        }
        return;
    }
    for event in &pointer.events {
        match *event {
            PointerEvent::Press { at, .. } => {
                desk.forget_fresh();
                if let Some((on, point)) = at.surface {
                    desk.begin(on, point, at.at);
                }
            }
            PointerEvent::Drag { to, .. } => desk.go_on(to.surface, to.at),
            PointerEvent::DragEnd { to, .. } => {
                desk.go_on(to.surface, to.at);
                desk.finish(to.at);
            }
            PointerEvent::Click { .. } | PointerEvent::Cancel => desk.state.stroke = None,
            PointerEvent::DragStart { .. } => {}
        }
    }
    desk.refit();
}

impl Desk<'_, '_> {
    fn begin(&mut self, on: Entity, point: crate::surface::SurfacePoint, at: Vec2) {
        let Ok(surface) = self.surfaces.get(on) else { return };
        let mut line = DrawnLine::new(0.0);
        if line.push(surface, &mut self.finder, point).is_ok() {
            self.state.stroke = Some(Stroke { on, line, from: at, last: at });
        }
    }

    /// Off the model, and over another piece of it, the line waits.
    fn go_on(&mut self, surface: Option<(Entity, crate::surface::SurfacePoint)>, at: Vec2) {
        let Some(stroke) = &mut self.state.stroke else { return };
        let Some((_, point)) = surface.filter(|(on, _)| *on == stroke.on) else { return };
        let Ok(surface) = self.surfaces.get(stroke.on) else { return };
        if stroke.last.distance(at) >= THINNING && stroke.line.push(surface, &mut self.finder, point).is_ok() {
            stroke.last = at;
        }
    }

    fn finish(&mut self, at: Vec2) {
        let Some(mut stroke) = self.state.stroke.take() else { return };
        let Ok(surface) = self.surfaces.get(stroke.on) else { return };
        let closes = stroke.from.distance(at) <= CLOSES && stroke.line.points().len() > 8;
        let ended = if closes {
            stroke.line.close(surface, &mut self.finder)
        } else {
            stroke.line.end(surface, &mut self.finder)
        };
        match ended {
            Ok(()) if self.settings.as_line => match SurfacePolyline::drawn(surface, &stroke.line) {
                Ok(line) => self.keep_line(stroke.on, line),
                Err(error) => self.notices.warn(error.to_string()),
            },
            Ok(()) => self.fit(stroke.on, Arc::new(stroke.line), None),
            Err(error) => self.notices.warn(error.to_string()),
        }
    }

    /// What was drawn stays a line, smoothed from the start.
    fn keep_line(&mut self, on: Entity, line: SurfacePolyline) {
        let mut curve = self.next.curve(None);
        curve.name = curve.name.replacen("Curve", "Line", 1);
        let smoothing = Some(LineSmoothing::default());
        let entity = curves::spawn_line(&mut self.commands, on, curve, SurfaceLine::new(line), smoothing);
        self.history.note_added("Draw by hand", entity);
        self.selection.select(entity);
    }

    fn fit(&mut self, on: Entity, line: Arc<DrawnLine>, replaces: Option<Entity>) {
        let Ok(surface) = self.surfaces.get(on) else { return };
        if self.state.fitting.as_ref().is_some_and(|before| before.replaces.is_none()) {
            self.state.waiting.push_back((on, line));
            return;
        }
        let (surface, drawn, share) = (surface.0.clone(), line.clone(), self.settings.tolerance);
        let options = FitOptions::within(share * surface.diagonal());
        let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
        let task = pool.spawn(async move { fit(&surface, &drawn, &options) });
        self.state.fitting = Some(Fitting { task, line, on, tolerance: share, replaces });
    }

    /// Nothing follows the tolerance any more.
    fn forget_fresh(&mut self) {
        let gesture = self.state.fresh.take().and_then(|fresh| fresh.gesture);
        self.ends.write_batch(gesture.map(|gesture| EndGesture { gesture, cancel: false }));
    }

    /// The tolerance was changed.
    fn refit(&mut self) {
        // A slider that rests has arrived.
        if let Some(fresh) = &mut self.state.fresh {
            fresh.idle = fresh.idle.saturating_add(1);
            if fresh.idle == REST {
                let gesture = fresh.gesture.take();
                self.ends.write_batch(gesture.map(|gesture| EndGesture { gesture, cancel: false }));
            }
        }
        let changed = self.state.fresh.as_ref().filter(|fresh| fresh.tolerance != self.settings.tolerance);
        if let Some(fresh) = changed
            && self.state.fitting.is_none()
        {
            let (on, line, spline) = (fresh.on, fresh.line.clone(), fresh.spline);
            self.fit(on, line, Some(spline));
        }
    }

    /// Takes over what was fitted.
    fn collect(&mut self) {
        let Some(fitting) = &mut self.state.fitting else { return };
        let Some(result) = block_on(future::poll_once(&mut fitting.task)) else { return };
        let Some(Fitting { line, on, tolerance, replaces, .. }) = self.state.fitting.take() else { return };
        if let Some((on, line)) = self.state.waiting.pop_front() {
            self.fit(on, line, None);
        }
        if !self.surfaces.contains(on) {
            return;
        }
        match (result, replaces) {
            (Ok(spline), None) => {
                let curve = self.next.curve(None);
                let entity = curves::spawn(&mut self.commands, on, curve, spline);
                self.history.begin("Draw by hand");
                self.history.note_added("Draw by hand", entity);
                self.history.end();
                self.selection.select(entity);
                self.forget_fresh();
                self.state.fresh = Some(Fresh { gesture: None, idle: 0, spline: entity, on, line, tolerance });
            }
            (Ok(spline), Some(entity)) => {
                let is_there = self.splines.contains(entity);
                if let Some(fresh) = self.state.fresh.as_mut().filter(|fresh| is_there && fresh.spline == entity) {
                    (fresh.tolerance, fresh.idle) = (tolerance, 0);
                    let gesture = *fresh.gesture.get_or_insert_with(GestureId::next);
                    let edit = EditSpline::new(entity, SplineEdit::Replace(spline)).undoable();
                    self.edits.write(edit.in_gesture(gesture));
                }
            }
            (Err(reason), _) => {
                self.notices.warn(reason);
                if let Some(fresh) = &mut self.state.fresh {
                    fresh.tolerance = tolerance;
                }
            }
        }
    }
}

fn fit(surface: &Surface, line: &DrawnLine, options: &FitOptions) -> Result<Spline, String> {
    let fit = Spline::fit(surface, &mut TraceWorkspace::default(), line, options);
    fit.map(|fit| fit.spline).map_err(|error| error.to_string())
}
