//! The brush: where it is dragged along a drawn line, the line becomes smooth, and the rest stays to the last bit.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::{Moment, PointerEvent, Target, Tool, ToolPointer};
use crate::editor::curves;
use crate::editor::history::History;
use crate::editor::notices::Notices;
use crate::editor::selection::Selection;
use crate::plugin::{BuiltSurface, Picker, SmoothedLine, SurfaceLine, SurfaceQueries};
use crate::smooth::{SmoothRange, SmoothWorkspace, Smoothing, smooth};

/// A stroke smooths again when the brush has moved by this share of its radius.
const SPACING: f32 = 0.2;

/// What the brush is like.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct BrushSettings {
    /// How far it reaches to either side along the line, in logical pixels.
    pub radius: f32,
    /// How much it weighs in its middle, 0.001 to 1.
    pub strength: f64,
    /// How close the line stays to where it was at every touch, as in [`SmoothingMode::Tether`](crate::smooth::SmoothingMode).
    pub closeness: f64,
}

impl Default for BrushSettings {
    fn default() -> Self {
        Self { radius: 40.0, strength: 0.5, closeness: 3.0 }
    }
}

/// The line that is being smoothed, and where the brush touched last.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Brushing(Option<Stroke>);

#[derive(Clone, Copy, Debug, PartialEq)]
struct Stroke {
    line: Entity,
    last: Vec2,
}

/// What the brush works with.
#[derive(SystemParam)]
pub(crate) struct Desk<'w, 's> {
    commands: Commands<'w, 's>,
    workspace: Local<'s, SmoothWorkspace>,
    brushing: ResMut<'w, Brushing>,
    settings: Res<'w, BrushSettings>,
    history: ResMut<'w, History>,
    notices: ResMut<'w, Notices>,
    selection: ResMut<'w, Selection>,
    lines: curves::Lines<'w, 's>,
    shown: Query<'w, 's, &'static SmoothedLine>,
    surfaces: Query<'w, 's, &'static BuiltSurface>,
    views: SurfaceQueries<'w, 's>,
    cameras: Query<'w, 's, (&'static Camera, &'static GlobalTransform)>,
    picker: Picker<'w, 's>,
}

pub(crate) fn brush(tool: Res<Tool>, pointer: Res<ToolPointer>, mut desk: Desk) {
    if *tool != Tool::Brush {
        desk.end(false);
        return;
    }
    for event in &pointer.events {
        match *event {
            PointerEvent::Press { at, .. } => desk.begin(&at),
            PointerEvent::Drag { to, .. } => desk.go_on(&to),
            PointerEvent::DragEnd { .. } | PointerEvent::Click { .. } => desk.end(false),
            PointerEvent::Cancel => desk.end(true),
            PointerEvent::DragStart { .. } => {}
        }
    }
}

impl Desk<'_, '_> {
    fn begin(&mut self, at: &Moment) {
        match at.target {
            Target::Line { line, .. } => {
                self.selection.select(line);
                self.history.begin("Brush");
                if let Ok((course, smoothing, _)) = self.lines.get(line) {
                    self.history.note_redrawn("Brush", line, course, smoothing);
                }
                self.brushing.0 = Some(Stroke { line, last: at.at });
                self.touch(line, at);
            }
            Target::Curve { .. } | Target::Control { .. } => {
                self.notices.info("The brush smooths drawn lines: make a line of the curve first (Properties).");
            }
            _ => self.notices.info("Drag the brush along a drawn line."),
        }
    }

    fn go_on(&mut self, to: &Moment) {
        let Some(stroke) = self.brushing.0 else { return };
        if stroke.last.distance(to.at) >= SPACING * self.settings.radius {
            self.brushing.0 = Some(Stroke { last: to.at, ..stroke });
            self.touch(stroke.line, to);
        }
    }

    /// Smooths the line about the pointer. Away from the line nothing happens.
    fn touch(&mut self, entity: Entity, at: &Moment) {
        let under = self.picker.lines_under(at.camera, at.at);
        let Some((_, place)) = under.into_iter().find(|(line, _)| *line == entity) else { return };
        let (Ok((course, smoothing, on)), Ok(shown)) = (self.lines.get(entity), self.shown.get(entity)) else { return };
        let (Ok(surface), Some(radius)) = (self.surfaces.get(on.0), self.local_radius(at, on.0, &place.point)) else {
            return;
        };
        // What is shown is what is brushed: where the line was smoothed as a whole, that becomes its course.
        let course = if smoothing.is_some() { &shown.smoothed().line } else { course.line() };
        let range = SmoothRange { strength: self.settings.strength, ..SmoothRange::about(place.distance, radius) };
        let options = Smoothing { roughness: 0.0, ..Smoothing::tether(self.settings.closeness) }.only(range);
        match smooth(surface, &mut self.workspace, course, &options) {
            Ok(smoothed) => {
                let line = SurfaceLine::new(smoothed.line);
                curves::set_line(&mut self.commands.entity(entity), line, None);
            }
            Err(error) => self.notices.warn(error.to_string()),
        }
    }

    /// The brush's radius along the surface.
    fn local_radius(&self, at: &Moment, on: Entity, point: &crate::surface::SurfacePoint) -> Option<f64> {
        let view = self.views.get(on)?;
        let (camera, eye) = self.cameras.get(at.camera).ok()?;
        let place = view.position(*point);
        let aside = 0.01 * place.distance(eye.translation());
        let pixel = |position| camera.world_to_viewport(eye, position).ok();
        let pixels = pixel(place)?.distance(pixel(place + *eye.right() * aside)?);
        let radius = f64::from(self.settings.radius * aside / (pixels * view.scale()));
        (radius > 0.0 && radius.is_finite()).then_some(radius)
    }

    fn end(&mut self, cancel: bool) {
        if self.brushing.0.take().is_some() {
            if cancel { self.history.take_back() } else { self.history.end() }
        }
    }
}
