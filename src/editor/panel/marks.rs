//! Anchors and handles of the selected spline, as marks of constant size on the screen: squares for corners, discs for other
//! anchors, small discs for handles.

use crate::curve::HandleSide;
use crate::prelude::*;
use bevy::ecs::system::SystemParam;
use bevy::picking::hover::HoverMap;
use bevy::prelude::*;
use bevy_egui::egui::{self, Color32, CornerRadius, Pos2, Stroke, StrokeKind};

use super::theme;
use crate::editor::colors;
use crate::editor::selection::Selection;
use crate::editor::tools::insert::InsertPreview;
use crate::editor::tools::pen::{PenPull, PenStart};
use crate::editor::tools::select::BoxSelection;
use crate::editor::view::draw::{is_hovered, shown_leg};

const ANCHOR: f32 = 9.0;
const HANDLE: f32 = 7.0;
/// What is this share of the model's diagonal behind its surface is hidden by it.
const BEHIND: f64 = 2e-3;

type Cameras<'w, 's> =
    Query<'w, 's, (&'static Camera, &'static Transform, &'static GlobalTransform, Has<ChildOf>), With<Camera3d>>;

/// What marks are made from.
#[derive(SystemParam)]
pub struct Marks<'w, 's> {
    cameras: Cameras<'w, 's>,
    surfaces: SurfaceQueries<'w, 's>,
    editable: Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface, Option<&'static PendingEdit>), With<Editable>>,
    places: Query<'w, 's, &'static OnSurface>,
    controls: Query<'w, 's, (Entity, &'static ControlPoint)>,
    selection: Res<'w, Selection>,
    pen: Res<'w, PenStart>,
    pull: Res<'w, PenPull>,
    insert: Res<'w, InsertPreview>,
    boxed: Res<'w, BoxSelection>,
    hover: Res<'w, HoverMap>,
}

/// A mark on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Its middle, in logical pixels.
    pub at: Vec2,
    /// What it stands for.
    pub kind: MarkKind,
    /// Whether the model does not hide it.
    pub visible: bool,
    selected: bool,
    hovered: bool,
}

/// What a mark stands for; anchors by their number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// An anchor that is a corner.
    Corner(u32),
    /// Any other anchor.
    Smooth(u32),
    /// A handle.
    Handle,
}

impl Mark {
    /// Half its width.
    pub fn radius(&self) -> f32 {
        let size = if self.kind == MarkKind::Handle { HANDLE } else { ANCHOR };
        0.5 * size + if self.hovered { 0.5 } else { 0.0 }
    }
}

impl Marks<'_, '_> {
    /// The marks of the selected spline and of the pen, handles before anchors.
    pub fn all(&self) -> Vec<Mark> {
        let mut marks: Vec<Mark> =
            self.selection.splines().iter().filter_map(|spline| self.of_spline(*spline)).flatten().collect();
        marks.extend(self.of_pen());
        marks.extend(self.of_insert());
        // Painted in this order: anchors on top.
        marks.sort_by_key(|mark| mark.kind != MarkKind::Handle);
        marks
    }

    fn of_spline(&self, entity: Entity) -> Option<Vec<Mark>> {
        let (spline, on, pending) = self.editable.get(entity).ok()?;
        let mut controls = self.controls.iter().filter(|(_, control)| control.spline == entity);
        let hovered = controls.find(|(control, _)| is_hovered(&self.hover, *control)).map(|(_, control)| control.kind);
        let mark = |kind: ControlKind| {
            let mut mark = self.mark(on.0, &kind.shown(spline, pending)?, self.kind(spline, kind)?)?;
            mark.selected = matches!(kind, ControlKind::Anchor(anchor) if self.selection.has_anchor(entity, anchor));
            mark.hovered = hovered == Some(kind);
            Some(mark)
        };
        // Beyond the last anchor there is no segment yet whose handle it were.
        let pulled = self.pull.0.filter(|(of, _)| *of == entity);
        let pulled = pulled.map(|(_, anchor)| ControlKind::Handle(anchor, HandleSide::Outgoing));
        Some(ControlKind::all(spline).into_iter().chain(pulled).filter_map(mark).collect())
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

    /// The first point of a spline that is not there yet, and the handle that is pulled out of it.
    fn of_pen(&self) -> Vec<Mark> {
        let Some(first) = self.pen.0 else { return Vec::new() };
        let kind = if first.handle.is_some() { MarkKind::Smooth(0) } else { MarkKind::Corner(0) };
        let anchor = self.mark(first.on, &first.at, kind).map(|mark| Mark { selected: true, ..mark });
        let handle = first.handle.and_then(|handle| self.mark(first.on, &handle, MarkKind::Handle));
        anchor.into_iter().chain(handle).collect()
    }

    /// Where a click would insert an anchor.
    fn of_insert(&self) -> Option<Mark> {
        let (spline, point) = self.insert.0?;
        Some(Mark { hovered: true, ..self.mark(self.places.get(spline).ok()?.0, &point, MarkKind::Smooth(0))? })
    }

    fn mark(&self, on: Entity, point: &SurfacePoint, kind: MarkKind) -> Option<Mark> {
        let position = self.surfaces.get(on)?.position(*point);
        let (at, visible) = (self.pixel(position)?, self.is_visible(on, position));
        Some(Mark { at, kind, visible, selected: false, hovered: false })
    }

    /// Where a position appears, in logical pixels.
    pub fn pixel(&self, position: Vec3) -> Option<Vec2> {
        let (camera, place) = self.camera()?;
        camera.world_to_viewport(&place, position).ok()
    }

    /// The camera, where it is in this frame: what hangs on nothing has moved already.
    fn camera(&self) -> Option<(&Camera, GlobalTransform)> {
        let active = self.cameras.iter().find(|(camera, ..)| camera.is_active);
        active.map(|(camera, own, global, hangs)| (camera, if hangs { *global } else { GlobalTransform::from(*own) }))
    }

    /// Whether the surface does not hide a position on it.
    pub fn is_visible(&self, on: Entity, position: Vec3) -> bool {
        let seen = || {
            let (camera, place) = self.camera()?;
            let view = self.surfaces.get(on)?;
            let ray = camera.viewport_to_world(&place, self.pixel(position)?).ok()?;
            let slack = BEHIND as f32 * view.surface().diagonal() as f32 * view.scale();
            Some(view.ray(ray).is_none_or(|hit| hit.distance > ray.origin.distance(position) - slack))
        };
        seen().unwrap_or(false)
    }
}

/// Paints the marks, and the box that is drawn, under all panels.
pub(crate) fn paint(ctx: &egui::Context, marks: &Marks) {
    let painter = ctx.layer_painter(egui::LayerId::background());
    if let Some(part) = marks.boxed.0 {
        let part = egui::Rect::from_min_max(egui::pos2(part.min.x, part.min.y), egui::pos2(part.max.x, part.max.y));
        let edge = Stroke::new(1.0, theme::egui_color(colors::ACCENT, 1.0));
        painter.rect(part, CornerRadius::ZERO, theme::egui_color(colors::ACCENT, 0.08), edge, StrokeKind::Inside);
    }
    for mark in marks.all() {
        let opacity = if mark.visible { 1.0 } else { colors::BEHIND };
        let accent = if mark.hovered { colors::hovered(colors::ACCENT) } else { colors::ACCENT };
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
