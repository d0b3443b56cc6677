//! Traces follow their splines: only segments that changed are traced again.

use std::ops::Range;
use std::sync::{Arc, Weak};

use bevy::log::warn;
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::spline::{SplineState, SurfaceSpline, without_surface};
use super::surface::{BuiltSurface, OnSurface, SurfaceState};
use crate::curve::{Trace, TraceWorkspace};
use crate::surface::Surface;

/// The curve of a spline: a system writes it whenever spline or surface change. Derived: it is never saved.
#[derive(Component, Clone, Debug, Deref)]
#[component(immutable)]
pub struct SplineTrace {
    #[deref]
    trace: Arc<Trace>,
    polyline: Arc<[Vec3]>,
    pieces: Arc<[Range<usize>]>,
    surface: Weak<Surface>,
}

impl SplineTrace {
    /// The trace itself.
    pub fn trace(&self) -> &Arc<Trace> {
        &self.trace
    }

    /// Positions along the curve in the surface's local space, crossings of edges included.
    pub fn polyline(&self) -> &[Vec3] {
        &self.polyline
    }

    /// The unbroken pieces of the [`polyline`](Self::polyline): a single one, unless the curve is torn, which curves of the
    /// schemes for comparison may be.
    pub fn pieces(&self) -> impl Iterator<Item = &[Vec3]> {
        self.pieces.iter().filter_map(|piece| self.polyline.get(piece.clone()))
    }

    /// Whether it was traced on this very surface.
    pub fn is_on(&self, surface: &BuiltSurface) -> bool {
        std::ptr::eq(self.surface.as_ptr(), Arc::as_ptr(&surface.0))
    }
}

/// Happens when a spline has a new trace.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct TraceChanged {
    /// The spline.
    pub entity: Entity,
    /// How many segments were traced; the others are shared with the trace before.
    pub retraced: u32,
}

/// What tracing cost in the last frame in which anything was traced.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct TraceStatistics {
    /// Time spent, in milliseconds.
    pub milliseconds: f64,
    /// Segments traced.
    pub segments: u32,
}

/// Traces splines.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Trace`].
#[derive(Debug, Default)]
pub struct RetracePlugin;

impl Plugin for RetracePlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_type::<TraceStatistics>()
            .init_resource::<TraceStatistics>()
            .add_systems(PostUpdate, retrace_splines.in_set(SurfaceSplineSystems::Trace));
    }
}

type Splines<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        Ref<'static, SurfaceSpline>,
        Ref<'static, OnSurface>,
        Option<&'static SplineTrace>,
        &'static mut SplineState,
    ),
>;

fn retrace_splines(
    mut commands: Commands,
    mut workspace: Local<TraceWorkspace>,
    mut statistics: ResMut<TraceStatistics>,
    mut splines: Splines,
    surfaces: Query<(Option<Ref<BuiltSurface>>, Option<&SurfaceState>)>,
) {
    let (begin, mut segments) = (Instant::now(), 0);
    for (entity, spline, on, old, mut state) in &mut splines {
        let (built, surface_state) = surfaces.get(on.0).unwrap_or((None, None));
        let Some(built) = built else {
            state.set_if_neq(without_surface(surface_state));
            if old.is_some() {
                commands.entity(entity).try_remove::<SplineTrace>();
            }
            continue;
        };
        let old = old.filter(|old| old.is_on(&built));
        let fresh = old.is_some() || matches!(*state, SplineState::Failed { .. });
        if fresh && !(spline.is_changed() || on.is_changed() || built.is_changed()) {
            continue;
        }
        match spline.trace(&built, &mut workspace, old.map(|old| &**old.trace())) {
            Ok(trace) => {
                state.set_if_neq(SplineState::Ready);
                let retraced = trace.retraced().len() as u32;
                segments += retraced;
                if old.is_some_and(|old| same_segments(old, &trace)) {
                    continue;
                }
                let polyline = trace.positions().iter().map(|p| p.as_vec3()).collect();
                let pieces = trace.pieces().into();
                let surface = Arc::downgrade(&built.0);
                commands.entity(entity).try_insert(SplineTrace { trace: Arc::new(trace), polyline, pieces, surface });
                commands.trigger(TraceChanged { entity, retraced });
            }
            Err(error) => {
                let reason = error.to_string();
                warn!("the spline {entity} cannot be traced: {reason}");
                state.set_if_neq(SplineState::Failed { reason });
                commands.entity(entity).try_remove::<SplineTrace>();
            }
        }
    }
    if segments > 0 {
        *statistics = TraceStatistics { milliseconds: begin.elapsed().as_secs_f64() * 1e3, segments };
    }
}

/// Whether two traces share all their segments.
fn same_segments(a: &Trace, b: &Trace) -> bool {
    a.segments().len() == b.segments().len() && a.segments().iter().zip(b.segments()).all(|(a, b)| Arc::ptr_eq(a, b))
}
