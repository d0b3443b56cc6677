//! Legs that stay on their side of a hill or a hole and are not the shortest any more: amber, with how much longer they are.

use bevy::prelude::*;
use bevy::tasks::{Task, block_on, futures_lite::future};

use super::draw::ON_TOP;
use crate::curve::JumpPolicy;
use crate::editor::colors;
use crate::editor::documents::spawn;
use crate::editor::selection::Selection;
use crate::geodesic::PathFinder;
use crate::plugin::{BuiltSurface, DragState, OnSurface, SurfaceQueries, SurfaceSpline, SurfaceSplineSystems};

/// Less than this share is rounding.
const LEAST: f64 = 1e-6;

/// By what share the middle leg of each segment is longer than the shortest way. Derived, for sticky splines that are selected, when
/// nothing is dragged.
#[derive(Component, Debug, Default)]
pub(crate) struct Excess {
    shares: Vec<f64>,
    task: Option<Task<Vec<f64>>>,
    is_stale: bool,
}

impl Excess {
    /// The segments whose legs are longer than the shortest way, and by what share.
    pub(crate) fn segments(&self) -> impl Iterator<Item = (usize, f64)> {
        self.shares.iter().copied().enumerate().filter(|(_, share)| *share > LEAST)
    }
}

/// Amber legs, 2 px.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct StickyLines;

pub(crate) fn plugin(app: &mut App) {
    let line = GizmoLineConfig { width: 2.0, joints: GizmoLineJoint::Round(3), ..default() };
    app.insert_gizmo_config(StickyLines, GizmoConfig { depth_bias: ON_TOP, line, ..default() })
        .add_systems(PostUpdate, (measure, draw).chain().in_set(SurfaceSplineSystems::Draw));
}

fn measure(
    mut commands: Commands,
    (selection, drag): (Res<Selection>, Res<DragState>),
    mut splines: Query<(Entity, Ref<SurfaceSpline>, &OnSurface, Option<&mut Excess>)>,
    surfaces: Query<&BuiltSurface>,
) {
    for entity in selection.splines() {
        let Ok((entity, spline, on, excess)) = splines.get_mut(*entity) else { continue };
        if spline.jumps() != JumpPolicy::Sticky {
            if excess.is_some() {
                commands.entity(entity).try_remove::<Excess>();
            }
            continue;
        }
        let Some(mut excess) = excess else {
            commands.entity(entity).try_insert(Excess { is_stale: true, ..default() });
            continue;
        };
        if spline.is_changed() {
            (excess.is_stale, excess.task) = (true, None);
        }
        if let Some(shares) = excess.task.as_mut().and_then(|task| block_on(future::poll_once(task))) {
            (excess.shares, excess.task) = (shares, None);
        }
        if excess.is_stale && *drag == DragState::Idle {
            let Ok(surface) = surfaces.get(on.0) else { continue };
            let (surface, spline) = (surface.0.clone(), (**spline).clone());
            excess.is_stale = false;
            excess.task = Some(spawn(move || {
                let mut finder = PathFinder::new();
                let segments = 0..spline.segment_count() as u32;
                segments.map(|segment| spline.excess(&surface, &mut finder, segment).unwrap_or(0.0)).collect()
            }));
        }
    }
}

fn draw(
    mut lines: Gizmos<StickyLines>,
    selection: Res<Selection>,
    splines: Query<(&SurfaceSpline, &OnSurface, &Excess)>,
    surfaces: SurfaceQueries,
) {
    for (spline, on, excess) in selection.splines().iter().filter_map(|entity| splines.get(*entity).ok()) {
        let Some(view) = surfaces.get(on.0) else { continue };
        let legs = excess.segments().filter_map(|(segment, _)| spline.anchors().get(segment)?.middle());
        for leg in legs {
            let positions = leg.positions(view.surface());
            lines.linestrip(positions.iter().map(|p| view.to_world().transform_point3(p.as_vec3())), colors::STICKY);
        }
    }
}
