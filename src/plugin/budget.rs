//! How long a frame may work on splines, and how much of that it has used.

use std::time::Duration;

use bevy::prelude::*;

/// How long a frame may work on drags, edits and traces.
///
/// What is expected to fit in is done in the frame, so that an edit and its trace show at once. What is not is computed in
/// the background and no frame waits for it: see [`TracePreview`](super::TracePreview) and
/// [`SplineState::Tracing`](super::SplineState::Tracing). Either way the result is the same, bit for bit.
///
/// Expected is what the last edit or trace of the same spline took, in proportion to the work: how many segments changed, and
/// how many faces they cross. Where that is wrong on a large surface, it is left to the background after all when the time
/// is over. Only edits that move control points in a gesture are put off; others are applied in the frame, unless one that
/// was put off is before them.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct TraceBudget {
    /// For drags, edits and traces together; zero: all is computed in the background.
    pub per_frame: Duration,
    /// A trace that is expected to take longer than this gets a preview of its own; while a shorter one is computed, the
    /// one before is shown.
    pub preview_after: Duration,
}

impl TraceBudget {
    /// All is done in the frame, whatever it takes.
    pub const UNLIMITED: Self = Self { per_frame: Duration::MAX, preview_after: Duration::MAX };
}

impl Default for TraceBudget {
    /// 3 ms a frame, and previews of what takes two frames.
    fn default() -> Self {
        Self { per_frame: Duration::from_millis(3), preview_after: Duration::from_millis(33) }
    }
}

/// What drags, edits and traces have taken in this frame.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct FrameTime {
    spent: Duration,
}

impl FrameTime {
    /// What is left, in seconds.
    pub(crate) fn left(&self, budget: &TraceBudget) -> f64 {
        if *budget == TraceBudget::UNLIMITED {
            return f64::INFINITY;
        }
        budget.per_frame.saturating_sub(self.spent).as_secs_f64()
    }

    pub(crate) fn spend(&mut self, time: Duration) {
        self.spent = self.spent.saturating_add(time);
    }
}

/// Adds budget and frame time; every plugin that spends them calls it, and calling it again changes nothing.
pub(crate) fn configure(app: &mut App) {
    if app.world().contains_resource::<FrameTime>() {
        return;
    }
    app.register_type::<TraceBudget>()
        .init_resource::<TraceBudget>()
        .init_resource::<FrameTime>()
        .add_systems(First, begin_frame);
}

fn begin_frame(mut frame: ResMut<FrameTime>) {
    *frame = FrameTime::default();
}
