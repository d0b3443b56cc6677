//! Drawn lines: as they were drawn, faintly, and as they are now; a selected one by its geodesic curvature.

use bevy::gizmos::GizmoAsset;
use bevy::gizmos::retained::Gizmo;
use bevy::prelude::*;

use super::draw::{IN_FRONT_OF_ALL, ON_TOP};
use super::lines::{CurveLines, LineOf, ShinesThrough, is_primed};
use crate::editor::colors;
use crate::editor::curves::Curve;
use crate::editor::selection::Selection;
use crate::plugin::{LineState, OnSurface, SmoothedLine, SurfaceLine, SurfaceSplineSystems};

/// Width of the line as it was drawn, in logical pixels.
const DRAWN: f32 = 1.0;
/// Curvature counts in full from so many over the mean distance between crossings; less is between the colours.
const STRONG: f32 = 0.2;

/// How a line looks at present.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub(super) struct LineLook {
    on: Entity,
    color: Color,
    width: f32,
    selected: bool,
    busy: bool,
}

pub(crate) fn plugin(app: &mut App) {
    app.add_observer(drop_line)
        .add_systems(PostUpdate, draw_lines.in_set(SurfaceSplineSystems::Draw).run_if(is_primed));
}

type Drawn<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        Ref<'static, SmoothedLine>,
        &'static LineState,
        &'static OnSurface,
        Option<&'static Curve>,
        Option<(&'static LineLook, &'static CurveLines)>,
    ),
    With<SurfaceLine>,
>;

/// Makes the lines anew of what has changed.
fn draw_lines(
    mut commands: Commands,
    lines: Drawn,
    selection: Res<Selection>,
    mut gizmos: ResMut<Assets<GizmoAsset>>,
    mut leaving: Local<Vec<Entity>>,
) {
    leaving.drain(..).for_each(|line| commands.entity(line).try_despawn());
    for (entity, line, state, on, curve, before) in &lines {
        if curve.is_some_and(|curve| curve.hidden) {
            if before.is_some() {
                commands.entity(entity).despawn_related::<CurveLines>().try_remove::<LineLook>();
            }
            continue;
        }
        let look = LineLook {
            on: on.0,
            color: curve.map_or(colors::CURVES[0], |curve| curve.color),
            width: curve.map_or(Curve::WIDTH, |curve| curve.width),
            selected: selection.has_spline(entity),
            busy: matches!(state, LineState::Smoothing { .. }),
        };
        if before.is_some_and(|(before, _)| *before == look) && !line.is_changed() {
            continue;
        }
        leaving.extend(before.iter().flat_map(|(_, lines)| lines.iter()));
        let mut spawn = |asset: GizmoAsset, width: f32, depth_bias: f32, through: bool| {
            let joints = if through { GizmoLineJoint::None } else { GizmoLineJoint::Round(3) };
            let line_config = GizmoLineConfig { width, joints, ..default() };
            let gizmo = Gizmo { handle: gizmos.add(asset), line_config, depth_bias };
            let mut spawned = commands.spawn((gizmo, LineOf(entity), ChildOf(look.on)));
            if through {
                spawned.insert(ShinesThrough);
            }
        };
        let plain = if look.selected { colors::ACCENT } else { look.color };
        let mut now = GizmoAsset::new();
        if look.selected && !look.busy {
            let mean = (line.after.length / line.line.crossings().len().max(1) as f64) as f32;
            now.linestrip_gradient(line.colored([colors::RIGHT, plain, colors::LEFT], STRONG / mean));
        } else {
            let opacity = if look.busy { colors::PREVIEW } else { 1.0 };
            now.linestrip(line.polyline().iter().copied(), plain.with_alpha(opacity * plain.alpha()));
        }
        spawn(now, look.width, ON_TOP, false);
        if look.selected {
            let mut drawn = GizmoAsset::new();
            drawn.linestrip(line.drawn_polyline().iter().copied(), Color::WHITE.with_alpha(0.6));
            spawn(drawn, DRAWN, ON_TOP, false);
        }
        let mut through = GizmoAsset::new();
        through.linestrip(line.polyline().iter().copied(), plain.with_alpha(colors::BEHIND * plain.alpha()));
        spawn(through, look.width, IN_FRONT_OF_ALL, true);
        commands.entity(entity).try_insert(look);
    }
}

/// What is no line any more is not drawn.
fn drop_line(removed: On<Remove, SurfaceLine>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.queue_silenced(|mut entity: EntityWorldMut| {
            entity.despawn_related::<CurveLines>();
            entity.remove::<LineLook>();
        });
    }
}
