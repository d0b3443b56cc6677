//! Anchors and handles of the selected spline, as marks of constant size on the screen: squares for corners, discs for other
//! anchors, small discs for handles.

use bevy::ecs::system::SystemParam;
use bevy::picking::hover::HoverMap;
use bevy::prelude::*;
use bevy_egui::egui::{self, Color32, CornerRadius, Pos2, Stroke, StrokeKind};
use bevy_surface_splines::prelude::*;

use crate::camera::Orbit;
use crate::draw::{is_hovered, shown_leg};
use crate::selection::Selection;
use crate::theme;
use crate::tools::PenStart;

const ANCHOR: f32 = 9.0;
const HANDLE: f32 = 7.0;
/// What is this share of the model's diagonal behind its surface is hidden by it.
const BEHIND: f64 = 2e-3;

/// What marks are made from.
#[derive(SystemParam)]
pub(crate) struct Marks<'w, 's> {
    cameras: Query<'w, 's, (&'static Camera, &'static Transform), With<Orbit>>,
    surfaces: SurfaceQueries<'w, 's>,
    splines: Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface, Option<&'static PendingEdit>)>,
    controls: Query<'w, 's, (Entity, &'static ControlPoint)>,
    selection: Res<'w, Selection>,
    pen: Res<'w, PenStart>,
    hover: Res<'w, HoverMap>,
}

/// A mark on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mark {
    pub(crate) at: Vec2,
    pub(crate) kind: MarkKind,
    pub(crate) visible: bool,
    selected: bool,
    hovered: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MarkKind {
    Corner(u32),
    Smooth(u32),
    Handle,
}

impl Mark {
    /// Half its width.
    pub(crate) fn radius(&self) -> f32 {
        let size = if self.kind == MarkKind::Handle { HANDLE } else { ANCHOR };
        0.5 * size + if self.hovered { 0.5 } else { 0.0 }
    }
}

impl Marks<'_, '_> {
    /// The marks of the selected spline and of the pen, handles before anchors.
    pub(crate) fn all(&self) -> Vec<Mark> {
        let mut marks = self.of_selected().unwrap_or_default();
        marks.extend(self.of_pen());
        // Painted in this order: anchors on top.
        marks.sort_by_key(|mark| mark.kind != MarkKind::Handle);
        marks
    }

    fn of_selected(&self) -> Option<Vec<Mark>> {
        let entity = self.selection.spline?;
        let (spline, on, pending) = self.splines.get(entity).ok()?;
        let mark = |kind: ControlKind| {
            let mut mark = self.mark(on.0, &kind.shown(spline, pending)?, self.kind(spline, kind)?)?;
            mark.selected = matches!(kind, ControlKind::Anchor(anchor) if self.selection.anchor == Some(anchor));
            let control = self.controls.iter().find(|(_, c)| c.spline == entity && c.kind == kind);
            mark.hovered = control.is_some_and(|(control, _)| is_hovered(&self.hover, control));
            Some(mark)
        };
        Some(ControlKind::all(spline).into_iter().filter_map(mark).collect())
    }

    fn kind(&self, spline: &SurfaceSpline, kind: ControlKind) -> Option<MarkKind> {
        // Joins do not count in a B-spline.
        let has_joins = !spline.scheme().method.is_b_spline();
        let is_corner = |i: u32| Some(has_joins && spline.anchors().get(i as usize)?.join() == Join::Corner);
        Some(match kind {
            ControlKind::Anchor(i) if is_corner(i)? => MarkKind::Corner(i),
            ControlKind::Anchor(i) => MarkKind::Smooth(i),
            ControlKind::Handle(..) => shown_leg(spline, kind).map(|_| MarkKind::Handle)?,
        })
    }

    fn of_pen(&self) -> Option<Mark> {
        let (on, point) = self.pen.0?;
        Some(Mark { selected: true, ..self.mark(on, &point, MarkKind::Corner(0))? })
    }

    fn mark(&self, on: Entity, point: &SurfacePoint, kind: MarkKind) -> Option<Mark> {
        let position = self.surfaces.get(on)?.position(*point);
        let (at, visible) = (self.pixel(position)?, self.is_visible(on, position));
        Some(Mark { at, kind, visible, selected: false, hovered: false })
    }

    /// Where a position appears, in logical pixels.
    pub(crate) fn pixel(&self, position: Vec3) -> Option<Vec2> {
        let (camera, transform) = self.cameras.single().ok()?;
        camera.world_to_viewport(&GlobalTransform::from(*transform), position).ok()
    }

    /// Whether the surface does not hide a position on it.
    pub(crate) fn is_visible(&self, on: Entity, position: Vec3) -> bool {
        let seen = || {
            let (_, camera) = self.cameras.single().ok()?;
            let view = self.surfaces.get(on)?;
            let way = position - camera.translation;
            let hit = view.ray(Ray3d::new(camera.translation, Dir3::new(way).ok()?));
            let slack = BEHIND as f32 * view.surface().diagonal() as f32 * view.scale();
            Some(hit.is_none_or(|hit| hit.distance > way.length() - slack))
        };
        seen().unwrap_or(false)
    }
}

/// Paints the marks under all panels.
pub(crate) fn paint(ctx: &egui::Context, marks: &Marks) {
    let painter = ctx.layer_painter(egui::LayerId::background());
    for mark in marks.all() {
        let opacity = if mark.visible { 1.0 } else { theme::BEHIND };
        let accent = if mark.hovered { theme::hovered(theme::ACCENT) } else { theme::ACCENT };
        let accent = theme::egui_color(accent, opacity);
        let white = theme::egui_color(Color::WHITE, opacity);
        let dark = Color32::from_black_alpha((150.0 * opacity) as u8);
        let (at, radius) = (Pos2::new(mark.at.x, mark.at.y), mark.radius());
        let (fill, edge) = if mark.selected { (accent, white) } else { (white, accent) };
        let edge = Stroke::new(1.5, edge);
        match mark.kind {
            MarkKind::Corner(_) => {
                let square = egui::Rect::from_center_size(at, egui::Vec2::splat(2.0 * radius));
                painter.rect_filled(square.expand(1.0), CornerRadius::ZERO, dark);
                painter.rect(square, CornerRadius::ZERO, fill, edge, StrokeKind::Inside);
            }
            MarkKind::Smooth(_) => {
                painter.circle_filled(at, radius + 1.0, dark);
                painter.circle(at, radius - 0.75, fill, edge);
            }
            MarkKind::Handle => {
                painter.circle_filled(at, radius + 0.5, dark);
                painter.circle_filled(at, radius - 0.5, if mark.hovered { white } else { accent });
            }
        }
    }
}
