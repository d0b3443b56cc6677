//! What tracing costs, as Bevy diagnostics.

use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::retrace::TraceStatistics;

/// Measures tracing: one value for every frame that had to do with it.
///
/// Schedule: `PostUpdate`, after [`SurfaceSplineSystems::Trace`]. Measures nothing without
/// [`RetracePlugin`](super::RetracePlugin).
#[derive(Debug, Default)]
pub struct SplineDiagnosticsPlugin;

impl SplineDiagnosticsPlugin {
    /// Time that frames spent on tracing, in milliseconds.
    pub const TRACE_TIME: DiagnosticPath = DiagnosticPath::const_new("surface_splines/trace_time");
    /// Time that background tasks spent on tracing, in milliseconds.
    pub const BACKGROUND_TRACE_TIME: DiagnosticPath =
        DiagnosticPath::const_new("surface_splines/background_trace_time");
    /// Segments that were traced.
    pub const SEGMENTS_RETRACED: DiagnosticPath = DiagnosticPath::const_new("surface_splines/segments_retraced");
}

impl Plugin for SplineDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_diagnostic(Diagnostic::new(Self::TRACE_TIME).with_suffix("ms"))
            .register_diagnostic(Diagnostic::new(Self::BACKGROUND_TRACE_TIME).with_suffix("ms"))
            .register_diagnostic(Diagnostic::new(Self::SEGMENTS_RETRACED))
            .add_systems(
                PostUpdate,
                measure_traces
                    .after(SurfaceSplineSystems::Trace)
                    .run_if(resource_exists_and_changed::<TraceStatistics>),
            );
    }
}

fn measure_traces(mut diagnostics: Diagnostics, statistics: Res<TraceStatistics>) {
    diagnostics.add_measurement(&SplineDiagnosticsPlugin::TRACE_TIME, || statistics.milliseconds);
    diagnostics.add_measurement(&SplineDiagnosticsPlugin::BACKGROUND_TRACE_TIME, || statistics.background_milliseconds);
    diagnostics.add_measurement(&SplineDiagnosticsPlugin::SEGMENTS_RETRACED, || f64::from(statistics.segments));
}
