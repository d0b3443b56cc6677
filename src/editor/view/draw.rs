//! The legs of handles and of control polygons, lines that are being drawn by hand, and drawings that are being placed; what is
//! behind the model shines through faintly.
//!
//! Gizmo groups differ in what a group can differ in: width, and how far in front of the model it is drawn.

use crate::curve::HandleSide;
use crate::geodesic::GeodesicPath;
use crate::prelude::*;
use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::PointerId;
use bevy::prelude::*;

use crate::editor::colors;
use crate::editor::tools::drawing::DrawingInHand;
use crate::editor::tools::freehand::Freehand;
use crate::editor::tools::pen::PenPull;

/// A little towards the eye, so that lines do not fight with the faces they lie on: about 1/200 of the distance.
pub(super) const ON_TOP: f32 = -0.0007;
/// At -1 rounding clips pieces of lines at the near plane.
pub(super) const IN_FRONT_OF_ALL: f32 = -0.9;

/// Drawings that are being placed, 2 px.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct CurveLines;
/// Lines that are being drawn, 3 px.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct HoveredLines;
/// Legs, 1 px.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct LegLines;
/// Legs behind the model.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct FaintLegLines;

pub(crate) fn plugin(app: &mut App) {
    app.insert_gizmo_config(CurveLines, lines(2.0, ON_TOP))
        .insert_gizmo_config(HoveredLines, lines(3.0, ON_TOP))
        .insert_gizmo_config(LegLines, lines(1.0, ON_TOP))
        .insert_gizmo_config(FaintLegLines, faint_lines(1.0))
        .add_systems(PostUpdate, (draw_legs, draw_stroke, draw_drawing).in_set(SurfaceSplineSystems::Draw));
}

fn lines(width: f32, depth_bias: f32) -> GizmoConfig {
    let line = GizmoLineConfig { width, joints: GizmoLineJoint::Round(3), ..default() };
    GizmoConfig { depth_bias, line, ..default() }
}

/// Where see-through lines overlap, at joints, they would be less so.
fn faint_lines(width: f32) -> GizmoConfig {
    let mut config = lines(width, IN_FRONT_OF_ALL);
    config.line.joints = GizmoLineJoint::None;
    config
}

fn draw_legs(
    (mut plain, mut faint): (Gizmos<LegLines>, Gizmos<FaintLegLines>),
    surfaces: SurfaceQueries,
    splines: Query<(Entity, &SurfaceSpline, &OnSurface, Option<&ControlPolygon>), With<Editable>>,
    pull: Res<PenPull>,
) {
    let color = colors::ACCENT.mix(&Color::WHITE, 0.55);
    for (entity, spline, on, polygon) in &splines {
        let Some(view) = surfaces.get(on.0) else { continue };
        let pulled = pull.0.filter(|(of, _)| *of == entity);
        let pulled = pulled.map(|(_, anchor)| ControlKind::Handle(anchor, HandleSide::Outgoing));
        let handles = ControlKind::all(spline).into_iter().chain(pulled).filter_map(|kind| shown_leg(spline, kind));
        let handles = handles.map(|leg| leg.positions(view.surface()).iter().map(|p| p.as_vec3()).collect());
        let polygon = polygon.into_iter().flat_map(|polygon| polygon.legs()).map(<[Vec3]>::to_vec);
        for local in handles.chain(polygon) {
            let line: Vec<Vec3> = local.iter().map(|p| view.to_world().transform_point3(*p)).collect();
            faint.linestrip(line.iter().copied(), color.with_alpha(colors::BEHIND));
            plain.linestrip(line, color);
        }
    }
}

/// The line that is being drawn by hand.
fn draw_stroke(mut wide: Gizmos<HoveredLines>, surfaces: SurfaceQueries, freehand: Res<Freehand>) {
    let Some((on, line)) = freehand.drawn() else { return };
    let Some(view) = surfaces.get(on) else { return };
    for path in line.paths() {
        let positions = path.positions(view.surface());
        wide.linestrip(positions.iter().map(|p| view.to_world().transform_point3(p.as_vec3())), colors::ACCENT);
    }
}

/// The drawing that is about to be placed.
fn draw_drawing(mut plain: Gizmos<CurveLines>, surfaces: SurfaceQueries, hand: Res<DrawingInHand>) {
    let Some((on, lines)) = hand.preview() else { return };
    let Some(view) = surfaces.get(on) else { return };
    for line in lines {
        plain.linestrip(line.iter().map(|p| view.to_world().transform_point3(p.as_vec3())), colors::ACCENT);
    }
}

/// The leg of a handle that is shown: those of no length lie on their anchor.
pub(crate) fn shown_leg(spline: &SurfaceSpline, kind: ControlKind) -> Option<&GeodesicPath> {
    let ControlKind::Handle(anchor, side) = kind else { return None };
    let anchor = spline.anchors().get(anchor as usize)?;
    let handle = match side {
        HandleSide::Incoming => anchor.incoming(),
        HandleSide::Outgoing => anchor.outgoing(),
    };
    Some(handle.leg()).filter(|leg| leg.length() > 0.0)
}

/// Whether the mouse is over an entity.
pub(crate) fn is_hovered(hover: &HoverMap, entity: Entity) -> bool {
    hover.get(&PointerId::Mouse).is_some_and(|hovered| hovered.contains_key(&entity))
}
