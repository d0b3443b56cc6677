//! Smoothing a line.

use std::ops::ControlFlow;

use super::{
    LineBend, LineMetrics, SmoothError, Smoothing, SurfacePolyline,
    driver::Smoother,
    engine::{Done, Engine, somewhere},
    metrics::Gauge,
    progress::{SmoothProgress, Watch},
    strip::Strip,
    tree::LineTree,
};
use crate::geodesic::{PathFinder, inner::InnerPath};
use crate::surface::{HalfEdge, Surface};

/// Scratch memory for smoothing; keep one a thread and reuse it, for any surface.
#[derive(Debug, Default)]
pub struct SmoothWorkspace {
    /// The path finder inside, free for queries of one's own.
    pub finder: PathFinder,
    pub(super) engine: Engine,
    pub(super) gauge: Gauge,
    pub(super) strip: Strip,
    pub(super) given: Strip,
    pub(super) kept: Strip,
    pub(super) positions: Vec<glam::DVec3>,
    pub(super) path: InnerPath,
    pub(super) around: Vec<HalfEdge>,
    pub(super) tree: LineTree,
    /// Of the line given, once that is measured.
    before: Option<LineMetrics>,
}

/// A smoothed line.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// The line; open or closed as it was.
    pub line: SurfacePolyline,
    /// Of the line given.
    pub before: LineMetrics,
    /// Of the line made, its distances from the line given.
    pub after: LineMetrics,
    /// By what tether: closer than asked for within an envelope, and where a closed line would have shrunk to a point. None
    /// without a tether.
    pub closeness: Option<f64>,
    /// How often vertices were passed, all that pressed at once.
    pub rounds: u32,
    /// Newton steps, or sweeps.
    pub steps: u32,
    /// How many vertices were passed.
    pub flips: u32,
    /// Whether a bound on rounds or sweeps was met first; the line is valid all the same.
    pub met_bound: bool,
    /// Whether nothing that was tried made the line smoother: it is the one given then.
    pub kept: bool,
}

impl Smoothed {
    /// Something to be overwritten by [`smooth_into`].
    pub fn blank() -> Self {
        Self {
            line: SurfacePolyline::blank(),
            before: LineMetrics::default(),
            after: LineMetrics::default(),
            closeness: None,
            rounds: 0,
            steps: 0,
            flips: 0,
            met_bound: false,
            kept: false,
        }
    }
}

impl Smoothed {
    /// Becomes a line that nothing was done to.
    pub(super) fn become_given(&mut self, line: &SurfacePolyline, metrics: LineMetrics) {
        let mut out = Self { before: metrics, after: metrics, kept: true, ..Self::blank() };
        std::mem::swap(&mut out.line, &mut self.line);
        out.line.clone_from(line);
        *self = out;
    }
}

/// Smooths a line.
///
/// The result depends on surface, line and options alone. Fixed crossings and ends stay; the line stays on its side of what it cannot
/// pass (handles, holes), and of vertices where going round would be longer.
///
/// Cost: about 5 µs a crossing by the default, up to three times that where closeness is below 1; sweeps take a hundred times as long.
///
/// # Errors
/// [`SmoothError`] if the line belongs to another surface, an option makes no sense, or a closed line shrinks to a point.
pub fn smooth(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &SurfacePolyline,
    smoothing: &Smoothing,
) -> Result<Smoothed, SmoothError> {
    let mut out = Smoothed::blank();
    smooth_into(surface, workspace, line, smoothing, &mut out)?;
    Ok(out)
}

/// [`smooth`] into memory that is reused: once warm, nothing is allocated.
///
/// # Errors
/// As [`smooth`]; `out` is then as it was.
pub fn smooth_into(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &SurfacePolyline,
    smoothing: &Smoothing,
    out: &mut Smoothed,
) -> Result<(), SmoothError> {
    smooth_watched(surface, workspace, line, smoothing, out, &mut Watch::nobody())
}

/// [`smooth_into`], asking `go_on` after every round whether to; for lines so long that somebody waits.
///
/// It is asked after some milliseconds within a round too; but straightening an open line is one piece of work.
///
/// # Errors
/// As [`smooth_into`], and [`SmoothError::Stopped`] if it is not to go on; `out` is then as it was.
pub fn smooth_while(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &SurfacePolyline,
    smoothing: &Smoothing,
    out: &mut Smoothed,
    go_on: &mut dyn FnMut(&SmoothProgress) -> ControlFlow<()>,
) -> Result<(), SmoothError> {
    smooth_watched(surface, workspace, line, smoothing, out, &mut Watch::asking(go_on))
}

fn smooth_watched(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &SurfacePolyline,
    smoothing: &Smoothing,
    out: &mut Smoothed,
    watch: &mut Watch<'_>,
) -> Result<(), SmoothError> {
    smoothing.check()?;
    workspace.prepare(surface, line)?;
    let done = workspace.run(surface, smoothing, watch)?;
    workspace.give(surface, done, out);
    Ok(())
}

/// Measures a line, and how far it runs from another, if one is given.
///
/// # Errors
/// [`SmoothError`] if a line does not belong to the surface.
pub fn measure(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &SurfacePolyline,
    from: Option<&SurfacePolyline>,
) -> Result<LineMetrics, SmoothError> {
    let SmoothWorkspace { gauge, strip, positions, tree, .. } = workspace;
    if let Some(from) = from {
        from.strip_into(surface, strip)?;
        strip.positions_into(surface, positions);
        tree.build(positions);
    }
    line.strip_into(surface, strip)?;
    let mean = mean_edge(surface, strip);
    Ok(gauge.measure(surface, strip, from.map(|_| &*tree), mean))
}

/// Fills in where a line bends and by how much, in order: its geodesic curvature along it.
///
/// A closed line begins at a crossing that is at no vertex, if there is one.
///
/// # Errors
/// [`SmoothError`] if the line does not belong to the surface.
pub fn bends_into(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &SurfacePolyline,
    out: &mut Vec<LineBend>,
) -> Result<(), SmoothError> {
    let SmoothWorkspace { gauge, strip, .. } = workspace;
    line.strip_into(surface, strip)?;
    gauge.bends_into(surface, strip, mean_edge(surface, strip), out);
    Ok(())
}

fn mean_edge(surface: &Surface, strip: &Strip) -> f64 {
    let face = strip.sides.first().map_or(strip.start.face, |h| h.face());
    surface.mean_edge[surface.sheet[face as usize] as usize].max(f64::MIN_POSITIVE)
}

impl SmoothWorkspace {
    /// Takes up a line: what depends on it alone.
    pub(super) fn prepare(&mut self, surface: &Surface, line: &SurfacePolyline) -> Result<(), SmoothError> {
        self.before = None;
        let Self { given, positions, engine, .. } = self;
        let turned = line.turned_strip_into(surface, given)?;
        given.positions_into(surface, positions);
        // A closed line whose seam moved begins with one of its last crossings.
        let first = if turned > 0 { given.along.get(given.len() - turned).copied() } else { None };
        engine.take_up(positions, first.unwrap_or(0.0));
        Ok(())
    }

    /// Smooths the line taken up, into the workspace's strip.
    pub(super) fn run(
        &mut self,
        surface: &Surface,
        smoothing: &Smoothing,
        watch: &mut Watch<'_>,
    ) -> Result<Done, SmoothError> {
        let mean = mean_edge(surface, &self.given);
        let done = Smoother::new(surface, smoothing, self, mean, watch).run();
        if watch.is_stopped() {
            return Err(SmoothError::Stopped);
        }
        if done.collapsed {
            let at = surface.outer_point(&somewhere(&self.strip));
            return Err(SmoothError::Collapsed { at });
        }
        Ok(done)
    }

    /// Measures what was made, and gives it.
    pub(super) fn give(&mut self, surface: &Surface, done: Done, out: &mut Smoothed) {
        out.before = self.measured_given(surface);
        let Self { gauge, strip, given, engine, .. } = self;
        out.after = gauge.measure(surface, strip, Some(&engine.line), mean_edge(surface, given));
        out.line.set(surface, strip);
        (out.rounds, out.steps, out.flips) = (done.rounds, done.steps, done.flips);
        (out.closeness, out.met_bound, out.kept) = (done.closeness, done.met_bound, done.kept);
    }

    /// Measures the line taken up, once.
    pub(super) fn measured_given(&mut self, surface: &Surface) -> LineMetrics {
        let Self { gauge, given, before, .. } = self;
        *before.get_or_insert_with(|| gauge.measure(surface, given, None, mean_edge(surface, given)))
    }
}
