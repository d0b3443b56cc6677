//! Paints the gizmo of the selection, with what the transform that is under way amounts to, and the places of repairs.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::{self, Color32, CornerRadius, Painter, Pos2, Stroke, StrokeKind};

use super::marks::Marks;
use super::properties::significant;
use super::theme;
use crate::editor::actions::ShownRepairs;
use crate::editor::colors;
use crate::editor::model::Model;
use crate::editor::tools::ToolPointer;
use crate::editor::tools::gizmo::{Gizmo, GizmoPart, SelectionGizmo};
use crate::editor::tools::pointer::Target;
use crate::editor::tools::transform::{TransformMode, Transforming};
use crate::plugin::{BuiltSurface, SurfaceQueries};

/// Half the width of the knob, and of the crosses, in logical pixels.
const KNOB: f32 = 5.0;
const CROSS: f32 = 5.0;

/// What is painted.
#[derive(SystemParam)]
pub(crate) struct GizmoLook<'w, 's> {
    gizmo: Res<'w, SelectionGizmo>,
    pointer: Res<'w, ToolPointer>,
    transforming: Res<'w, Transforming>,
    repairs: Res<'w, ShownRepairs>,
    models: Query<'w, 's, (Entity, &'static BuiltSurface), With<Model>>,
    surfaces: SurfaceQueries<'w, 's>,
}

/// Paints under all panels.
pub(crate) fn paint(ctx: &egui::Context, look: &GizmoLook, marks: &Marks) {
    let painter = ctx.layer_painter(egui::LayerId::background());
    if look.repairs.0 {
        paint_repairs(&painter, look, marks);
    }
    let Some(gizmo) = &look.gizmo.0 else { return };
    let active = look.transforming.0.as_ref();
    let hovered = look.pointer.hover.and_then(|moment| match moment.target {
        Target::Gizmo(part) => Some(part),
        _ => None,
    });
    let taken = |part: GizmoPart| active.map_or(hovered == Some(part), |active| active.mode == part.mode());
    paint_gizmo(&painter, gizmo, taken);
    if let Some(active) = active {
        let unit = if active.mode == TransformMode::Turn { "°" } else { "" };
        let text = format!("{}{unit}", significant(active.amount, 3));
        let font = egui::FontId::proportional(13.0);
        let at = gizmo.knob.unwrap_or(gizmo.middle) + Vec2::new(12.0, -10.0);
        let galley = painter.layout_no_wrap(text, font, Color32::WHITE);
        let place = egui::Rect::from_min_size(pos(at), galley.size()).expand(3.0);
        painter.rect_filled(place, 3.0, Color32::from_black_alpha(160));
        painter.galley(pos(at), galley, Color32::WHITE);
    }
}

fn pos(at: Vec2) -> Pos2 {
    Pos2::new(at.x, at.y)
}

fn paint_gizmo(painter: &Painter, gizmo: &Gizmo, taken: impl Fn(GizmoPart) -> bool) {
    let color = |part| if taken(part) { Color32::WHITE } else { theme::egui_color(colors::ACCENT, 0.8) };
    let width = |part| if taken(part) { 2.5 } else { 1.5 };
    let stroke = |part| Stroke::new(width(part), color(part));
    paint_ring(painter, &gizmo.ring, stroke(GizmoPart::Ring));
    paint_ring(painter, &gizmo.becomes, stroke(GizmoPart::Knob));
    let spokes: Vec<Pos2> = gizmo.spokes.iter().map(|at| pos(*at)).collect();
    painter.add(egui::Shape::line(spokes, Stroke::new(1.5, Color32::WHITE)));
    if let Some(knob) = gizmo.knob {
        let square = egui::Rect::from_center_size(pos(knob), egui::Vec2::splat(2.0 * KNOB));
        let fill = color(GizmoPart::Knob);
        painter.rect(square, CornerRadius::ZERO, fill, stroke(GizmoPart::Knob), StrokeKind::Inside);
    }
    paint_cross(painter, gizmo.middle, false, stroke(GizmoPart::Middle));
}

/// A closed line with gaps.
fn paint_ring(painter: &Painter, ring: &[Option<Vec2>], stroke: Stroke) {
    let next = ring.iter().cycle().skip(1);
    for (a, b) in ring.iter().zip(next).filter_map(|(a, b)| a.zip(*b)) {
        painter.line_segment([pos(a), pos(b)], stroke);
    }
}

fn paint_cross(painter: &Painter, at: Vec2, diagonal: bool, stroke: Stroke) {
    let arms = if diagonal { [Vec2::new(1.0, 1.0), Vec2::new(1.0, -1.0)] } else { [Vec2::X, Vec2::Y] };
    for arm in arms {
        painter.line_segment([pos(at - CROSS * arm), pos(at + CROSS * arm)], stroke);
    }
}

/// Crosses where the model was repaired, also behind it.
fn paint_repairs(painter: &Painter, look: &GizmoLook, marks: &Marks) {
    for (entity, surface) in &look.models {
        let Some(view) = look.surfaces.get(entity) else { continue };
        for (_, place) in &surface.report().places {
            let Some(at) = marks.pixel(view.to_world().transform_point3(place.as_vec3())) else { continue };
            paint_cross(painter, at, true, Stroke::new(4.0, Color32::from_black_alpha(150)));
            paint_cross(painter, at, true, Stroke::new(2.0, theme::WARNING));
        }
    }
}
