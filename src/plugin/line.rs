//! Lines on surfaces as components: the line as it was drawn, how it is smoothed, how far that is.

use bevy::prelude::*;

use super::line_remap::remap_lines;
use super::line_source::{LineSource, resolve_line_sources};
use super::line_work::Wishes;
use super::smooth_lines::{remove_smoothed, smooth_lines};
use super::surface::OnSurface;
use super::workspaces::Workspaces;
use super::{SurfaceSplineSystems, budget, retrace};
use crate::smooth::{SmoothWorkspace, Smoothing, SmoothingMode, SurfacePolyline};

/// A line drawn on the surface that [`OnSurface`](super::OnSurface) names: jagged, often.
///
/// Immutable: it is replaced by inserting another. What is to be shown of it is its [`SmoothedLine`](super::SmoothedLine), which a system
/// writes: smoothed, if there is a [`LineSmoothing`], else as it was drawn.
#[derive(Component, Reflect, Clone, Debug, PartialEq, Deref)]
#[component(immutable)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(LineState)]
pub struct SurfaceLine(SurfacePolyline);

impl SurfaceLine {
    /// Makes the component.
    pub fn new(line: SurfacePolyline) -> Self {
        Self(line)
    }

    /// The line itself.
    pub fn line(&self) -> &SurfacePolyline {
        &self.0
    }
}

impl From<SurfacePolyline> for SurfaceLine {
    fn from(line: SurfacePolyline) -> Self {
        Self(line)
    }
}

/// How a [`SurfaceLine`] is smoothed; without it the line stays as it was drawn.
///
/// It may change in every frame: what depends on the line alone is done once. What was drawn is never changed.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_surface_splines::prelude::*;
/// fn slide(keys: Res<ButtonInput<KeyCode>>, mut lines: Query<&mut LineSmoothing>) {
///     if keys.pressed(KeyCode::ArrowUp) {
///         for mut smoothing in &mut lines {
///             let closeness = smoothing.closeness().unwrap_or(10.0);
///             smoothing.set_closeness(1.02 * closeness);
///         }
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct LineSmoothing {
    /// Whether the line is smoothed now.
    pub enabled: bool,
    /// What it becomes: the mode, and what holds it back.
    pub options: Smoothing,
}

impl Default for LineSmoothing {
    /// Tethered with closeness 10.
    fn default() -> Self {
        Self { enabled: true, options: Smoothing::default() }
    }
}

impl LineSmoothing {
    /// Where a slider for the closeness should begin and end; it should be logarithmic.
    pub const SLIDER: [f64; 2] = [0.1, 1_000.0];

    /// Tethered: with closeness 0.1 the line is nearly straight, 10 keeps its shape, 1,000 is nearly what was drawn.
    pub fn tether(closeness: f64) -> Self {
        Self::by(SmoothingMode::Tether { closeness })
    }

    /// By a mode.
    pub fn by(mode: SmoothingMode) -> Self {
        Self { enabled: true, options: Smoothing::by(mode) }
    }

    /// The closeness; none if the mode is not the tether.
    pub fn closeness(&self) -> Option<f64> {
        match self.options.mode {
            SmoothingMode::Tether { closeness } => Some(closeness),
            _ => None,
        }
    }

    /// Tethers with a closeness.
    pub fn set_closeness(&mut self, closeness: f64) {
        self.options.mode = SmoothingMode::Tether { closeness };
    }

    /// What is wished for.
    pub(crate) fn wish(&self) -> Option<Smoothing> {
        self.enabled.then_some(self.options)
    }
}

impl From<Smoothing> for LineSmoothing {
    fn from(options: Smoothing) -> Self {
        Self { enabled: true, options }
    }
}

/// How far a line is.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub enum LineState {
    /// Its surface is not ready, or it is on none.
    #[default]
    Pending,
    /// It is smoothed in the background, because that takes longer than a frame has. Until that is done the result before is
    /// shown, if there is one.
    Smoothing {
        /// How often vertices were passed, all that pressed at once. How often they will be nobody knows.
        rounds: u32,
        /// Length of the line as it is now, in local units; 0 at the beginning.
        length: f64,
    },
    /// It has a [`SmoothedLine`](super::SmoothedLine), by its [`LineSmoothing`] as that is.
    Ready,
    /// It cannot be made, does not belong to its surface, or cannot be smoothed like that.
    Failed {
        /// Why, and what to do about it.
        reason: String,
    },
}

/// Happens when a line has a new [`SmoothedLine`](super::SmoothedLine).
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct LineChanged {
    /// The line.
    pub entity: Entity,
    /// Whether that is by the [`LineSmoothing`] as it is now; if not, a newer one is under way.
    pub is_current: bool,
}

/// Happens when a line cannot be made or smoothed.
#[derive(EntityEvent, Clone, Debug)]
pub struct LineFailed {
    /// The line.
    pub entity: Entity,
    /// Why, and what to do about it.
    pub reason: String,
}

/// Turns [`LineSource`]s into [`SurfaceLine`]s, and smooths these: in the frame where that has time for it
/// ([`TraceBudget`](super::TraceBudget)), else in the background.
///
/// Schedule: `PostUpdate`, sets [`SurfaceSplineSystems::Resolve`] and [`SurfaceSplineSystems::Trace`], after splines are traced; an observer of
/// [`SurfaceChanged`](super::SurfaceChanged).
#[derive(Debug, Default)]
pub struct LinePlugin;

impl Plugin for LinePlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        budget::configure(app);
        app.register_type::<SurfaceLine>()
            .register_type::<LineSource>()
            .register_type::<LineSmoothing>()
            .register_type::<LineState>()
            .init_resource::<Workspaces<SmoothWorkspace>>()
            .init_resource::<Wishes>()
            .add_observer(remap_lines)
            .add_observer(remove_smoothed::<SurfaceLine>)
            .add_observer(remove_smoothed::<OnSurface>)
            .add_systems(PostUpdate, resolve_line_sources.in_set(SurfaceSplineSystems::Resolve))
            .add_systems(PostUpdate, smooth_lines.in_set(SurfaceSplineSystems::Trace).after(retrace::retrace_splines));
    }
}
