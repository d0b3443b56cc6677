//! Curves that ride on deformed meshes.

use std::ops::Range;
use std::sync::{Arc, Weak};

use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::deformed::DeformedSurface;
use super::surface::{BuiltSurface, OnSurface};
use super::trace::SplineTrace;
use crate::curve::Trace;
use crate::surface::SurfacePoint;

/// A curve as it lies on its surface's [`DeformedSurface`], in world space: every point of its [`SplineTrace`] stays at its place in its face, so that
/// the curve lies on the mesh exactly, whatever deforms it. Derived: a system writes it beside the trace, and it is never saved.
///
/// It is not traced again for the pose: on a mesh that is stretched differently in two directions, a circle becomes an ellipse. Where joints fold
/// the mesh, the curve folds with it.
///
/// Cost: the vertices about the curve are posed (about 40 ns each) in frames in which something moved; nothing is allocated.
#[derive(Component, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct RidingCurve {
    /// Vertices of the mesh about the curve, in order.
    vertices: Vec<u32>,
    /// Each point by its corners, counted in `vertices`, and its weights.
    points: Vec<([u32; 3], [f32; 3])>,
    pieces: Vec<Range<usize>>,
    trace: Weak<Trace>,
    /// The pose that it has.
    stamp: Option<u64>,
    posed: Vec<Vec3>,
    positions: Vec<Vec3>,
}

impl RidingCurve {
    /// Positions along the curve in the world, one for each of the [`SplineTrace::polyline`].
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// The unbroken pieces of the [`positions`](Self::positions).
    pub fn pieces(&self) -> impl Iterator<Item = &[Vec3]> {
        self.pieces.iter().filter_map(|piece| self.positions.get(piece.clone()))
    }

    /// The place of the polyline at rest that is now nearest to a position in the world.
    pub(crate) fn at_rest(&self, world: Vec3, polyline: &[Vec3]) -> Option<Vec3> {
        let mut best = (f32::INFINITY, None);
        for range in &self.pieces {
            let (Some(now), Some(rest)) = (self.positions.get(range.clone()), polyline.get(range.clone())) else {
                continue;
            };
            for (now, rest) in now.windows(2).zip(rest.windows(2)) {
                let way = now[1] - now[0];
                let share = ((world - now[0]).dot(way) / way.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
                let distance = world.distance_squared(now[0].lerp(now[1], share));
                if distance < best.0 {
                    best = (distance, Some(rest[0].lerp(rest[1], share)));
                }
            }
        }
        best.1
    }

    /// Binds the points of a trace to the corners of their faces, keeping memory.
    fn bind(&mut self, points: &[SurfacePoint], trace: &Arc<Trace>, deformed: &DeformedSurface) {
        let corners = |point: &SurfacePoint| deformed.corners(point.face).unwrap_or([u32::MAX; 3]);
        self.vertices.clear();
        self.vertices.extend(points.iter().flat_map(corners));
        self.vertices.sort_unstable();
        self.vertices.dedup();
        let place = |vertex: u32| self.vertices.binary_search(&vertex).map_or(0, |at| at as u32);
        self.points.clear();
        self.points.extend(points.iter().map(|p| (corners(p).map(place), p.weights.map(|w| w as f32))));
        self.pieces = trace.pieces();
        self.trace = Arc::downgrade(trace);
        self.stamp = None;
    }

    /// Follows the mesh.
    fn follow(&mut self, deformed: &DeformedSurface) {
        self.stamp = Some(deformed.stamp());
        self.posed.clear();
        self.posed.extend(self.vertices.iter().map(|vertex| deformed.vertex(*vertex)));
        self.positions.clear();
        let posed = &self.posed;
        let at = |vertex: u32| posed.get(vertex as usize).copied().unwrap_or(Vec3::NAN);
        self.positions.extend(self.points.iter().map(|([a, b, c], [u, v, w])| *u * at(*a) + *v * at(*b) + *w * at(*c)));
    }
}

/// Keeps the [`RidingCurve`] of splines on deformed surfaces.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Ride`], after [`DeformPlugin`](super::DeformPlugin)'s systems; curves in parallel.
#[derive(Debug, Default)]
pub struct RidingPlugin;

impl Plugin for RidingPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.configure_sets(PostUpdate, RideSystems.in_set(SurfaceSplineSystems::Ride))
            .add_systems(PostUpdate, (begin_riding, ride).chain().in_set(RideSystems));
    }
}

/// The systems by which curves follow, which come after those that pose.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct RideSystems;

/// Curves that should ride and do not, and such that ride without need.
fn begin_riding(
    mut commands: Commands,
    standing: Query<(Entity, &OnSurface), (With<SplineTrace>, Without<RidingCurve>)>,
    riding: Query<(Entity, Option<&OnSurface>, Has<SplineTrace>), With<RidingCurve>>,
    deformed: Query<(), With<DeformedSurface>>,
) {
    for (entity, on) in &standing {
        if deformed.contains(on.0) {
            commands.entity(entity).try_insert(RidingCurve::default());
        }
    }
    for (entity, on, is_traced) in &riding {
        if !is_traced || !on.is_some_and(|on| deformed.contains(on.0)) {
            commands.entity(entity).try_remove::<RidingCurve>();
        }
    }
}

fn ride(
    mut curves: Query<(&mut RidingCurve, &SplineTrace, &OnSurface)>,
    surfaces: Query<(&DeformedSurface, &BuiltSurface)>,
) {
    curves.par_iter_mut().for_each(|(mut curve, trace, on)| {
        // Neither is a trace of another surface of use, nor a pose of none.
        let Ok((deformed, built)) = surfaces.get(on.0) else { return };
        if !trace.is_on(built) {
            return;
        }
        let is_bound = Weak::as_ptr(&curve.trace) == Arc::as_ptr(trace.trace());
        if is_bound && curve.stamp == Some(deformed.stamp()) {
            return;
        }
        let curve = curve.as_mut();
        if !is_bound {
            curve.bind(&trace.surface_points(built), trace.trace(), deformed);
        }
        curve.follow(deformed);
    });
}
