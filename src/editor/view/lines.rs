//! Curves as lines on the model, kept by the renderer until they change: thousands of them cost nothing while they rest. What is
//! behind the model shines through faintly; a curve that is being traced is dashed; where a curve is torn, its line is.

use bevy::ecs::entity::EntityHashSet;
use bevy::gizmos::GizmoAsset;
use bevy::gizmos::config::GizmoLineStyle;
use bevy::gizmos::retained::Gizmo;
use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::PointerId;
use bevy::prelude::*;

use super::draw::{IN_FRONT_OF_ALL, ON_TOP};
use crate::editor::colors;
use crate::editor::curves::Curve;
use crate::editor::selection::Selection;
use crate::plugin::{OnSurface, SplineTrace, SurfaceSpline, SurfaceSplineSystems, TracePreview};

/// A line of a curve, as an entity that hangs on the model; goes with its curve.
#[derive(Component)]
#[relationship(relationship_target = CurveLines)]
pub(super) struct LineOf(pub(super) Entity);

/// The lines of a curve: one on the model, one that shines through it.
#[derive(Component, Default)]
#[relationship_target(relationship = LineOf, linked_spawn)]
pub(super) struct CurveLines(Vec<Entity>);

/// Marks lines that shine through the model. Lines hide what is drawn behind them later, so these must come last. The renderer
/// draws entities in the order in which it met their archetypes, and met in one frame that is any order: so it meets a line without this
/// component in the first frame ([`prime`]), and those with it later ([`is_primed`]).
#[derive(Component)]
pub(super) struct ShinesThrough;

/// How the lines of a curve look at present.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
struct Look {
    on: Entity,
    color: Color,
    width: f32,
    dashed: bool,
}

pub(crate) fn plugin(app: &mut App) {
    app.add_observer(drop_lines)
        .add_systems(Startup, prime)
        .add_systems(PostUpdate, draw_curves.in_set(SurfaceSplineSystems::Draw).run_if(is_primed));
}

/// Spawns a line of nothing, as all lines on the model are: see [`ShinesThrough`].
fn prime(mut commands: Commands, mut gizmos: ResMut<Assets<GizmoAsset>>) {
    let nowhere = commands.spawn((Transform::default(), Visibility::Hidden)).id();
    let gizmo = Gizmo { handle: gizmos.add(GizmoAsset::new()), ..default() };
    commands.spawn((gizmo, LineOf(nowhere), ChildOf(nowhere)));
}

/// From the second frame on.
pub(super) fn is_primed(mut before: Local<bool>) -> bool {
    std::mem::replace(&mut *before, true)
}

type Curves<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        Option<Ref<'static, SplineTrace>>,
        Option<Ref<'static, TracePreview>>,
        &'static OnSurface,
        Option<&'static Curve>,
        Option<(&'static Look, &'static CurveLines)>,
    ),
    With<SurfaceSpline>,
>;

/// Makes the lines anew of what has changed.
fn draw_curves(
    mut commands: Commands,
    curves: Curves,
    (selection, hover): (Res<Selection>, Res<HoverMap>),
    mut gizmos: ResMut<Assets<GizmoAsset>>,
    mut leaving: Local<Vec<Entity>>,
) {
    leaving.drain(..).for_each(|line| commands.entity(line).try_despawn());
    let selected: EntityHashSet = selection.splines().iter().copied().collect();
    let hovered = hover.get(&PointerId::Mouse);
    for (entity, trace, preview, on, curve, before) in &curves {
        let hidden = curve.is_some_and(|curve| curve.hidden);
        if hidden || (trace.is_none() && preview.is_none()) {
            if before.is_some() {
                commands.entity(entity).despawn_related::<CurveLines>().try_remove::<Look>();
            }
            continue;
        }
        let is_hovered = hovered.is_some_and(|hovered| hovered.contains_key(&entity));
        let own = curve.map_or(colors::CURVES[0], |curve| curve.color);
        let color = if selected.contains(&entity) { colors::ACCENT } else { own };
        let look = Look {
            on: on.0,
            color: if is_hovered { colors::hovered(color) } else { color },
            width: curve.map_or(Curve::WIDTH, |curve| curve.width) + if is_hovered { 1.0 } else { 0.0 },
            dashed: preview.is_some(),
        };
        let moved = trace.as_ref().is_some_and(|trace| trace.is_changed())
            || preview.as_ref().is_some_and(|preview| preview.is_changed());
        if before.is_some_and(|(before, _)| *before == look) && !moved {
            continue;
        }
        let pieces: Vec<&[Vec3]> = match (&preview, &trace) {
            (Some(preview), _) => preview.pieces().collect(),
            (None, Some(trace)) => trace.pieces().collect(),
            (None, None) => continue,
        };
        let mut line = |depth_bias: f32, opacity: f32| {
            let mut asset = GizmoAsset::new();
            let color = look.color.with_alpha(opacity * look.color.alpha());
            pieces.iter().for_each(|piece| asset.linestrip(piece.iter().copied(), color));
            // Where see-through lines overlap, at joints, they would be less so.
            let joints = if opacity < 1.0 { GizmoLineJoint::None } else { GizmoLineJoint::Round(3) };
            let style = if look.dashed { dashes() } else { GizmoLineStyle::Solid };
            let line_config = GizmoLineConfig { width: look.width, joints, style, ..default() };
            (Gizmo { handle: gizmos.add(asset), line_config, depth_bias }, LineOf(entity), ChildOf(look.on))
        };
        let (near, through) = (line(ON_TOP, 1.0), line(IN_FRONT_OF_ALL, colors::BEHIND));
        // The renderer has new lines with the next frame: the old ones stay until then.
        leaving.extend(before.iter().flat_map(|(_, lines)| lines.iter()));
        commands.entity(entity).try_insert(look);
        commands.spawn(near);
        commands.spawn((through, ShinesThrough));
    }
}

fn dashes() -> GizmoLineStyle {
    GizmoLineStyle::Dashed { gap_scale: 3.0, line_scale: 5.0 }
}

/// What is no spline any more has no lines.
fn drop_lines(removed: On<Remove, SurfaceSpline>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.queue_silenced(|mut entity: EntityWorldMut| {
            entity.despawn_related::<CurveLines>();
            entity.remove::<Look>();
        });
    }
}
