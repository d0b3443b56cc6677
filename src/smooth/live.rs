//! Smoothing a line again and again: a slider that is dragged, a brush that is moved.

use std::ops::ControlFlow;

use super::{
    SmoothError, SmoothProgress, SmoothRange, SmoothWorkspace, Smoothed, Smoothing, SmoothingMode, SurfacePolyline,
    progress::Watch,
};
use crate::surface::Surface;

/// A line that is smoothed by one closeness after the other, or by one mode after the other.
///
/// What depends on the line alone is done once. Every result is that of [`smooth`](super::smooth), whatever came before it; once
/// warm nothing is allocated. It holds no reference to its surface, and may go to another thread.
///
/// ```
/// # use bevy_surface_splines::{geodesic::PathFinder, smooth::*, surface::{Surface, SurfaceOptions, shapes}};
/// # use glam::DVec3;
/// # let surface = Surface::build(&shapes::icosphere(4), &SurfaceOptions::default())?;
/// # let at = |k: u32| {
/// #     let (a, tremor) = (0.05 * f64::from(k), if k % 2 == 0 { 0.08 } else { -0.08 });
/// #     surface.closest_point(DVec3::new(a.cos(), a.sin(), tremor)).unwrap().point
/// # };
/// # let points: Vec<_> = (0..60).map(at).collect();
/// let drawn = SurfacePolyline::through(&surface, &mut PathFinder::new(), &points, false)?;
/// let mut live = LiveSmoothing::new(&surface, drawn, Smoothing::default())?;
/// let loose = live.smooth(&surface, 1.0)?.after;
/// let close = live.smooth(&surface, 100.0)?.after;
/// assert!(close.max_distance < loose.max_distance && close.length > loose.length);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LiveSmoothing {
    workspace: SmoothWorkspace,
    line: SurfacePolyline,
    smoothing: Smoothing,
    surface: u64,
    out: Smoothed,
}

impl LiveSmoothing {
    /// Takes up a line. The mode of `smoothing` is set by every [`smooth`](Self::smooth); the rest of it stays.
    ///
    /// # Errors
    /// [`SmoothError`] if the line belongs to another surface.
    pub fn new(surface: &Surface, line: SurfacePolyline, smoothing: Smoothing) -> Result<Self, SmoothError> {
        let mut live = Self {
            workspace: SmoothWorkspace::default(),
            line: SurfacePolyline::blank(),
            smoothing,
            surface: 0,
            out: Smoothed::blank(),
        };
        live.take_up(surface, line)?;
        Ok(live)
    }

    /// Takes up another line, or what became of this one, and keeps the memory.
    ///
    /// # Errors
    /// [`SmoothError`] if the line belongs to another surface; all is then as it was.
    pub fn take_up(&mut self, surface: &Surface, line: SurfacePolyline) -> Result<(), SmoothError> {
        self.workspace.prepare(surface, &line)?;
        let before = self.workspace.measured_given(surface);
        self.surface = surface.identity();
        self.out.become_given(&line, before);
        self.line = line;
        Ok(())
    }

    /// Smooths the line that was taken up by a tether of this closeness.
    ///
    /// # Errors
    /// [`SmoothError`] as of [`smooth`](super::smooth), or if the surface is not the one on which the line was taken up;
    /// [`result`](Self::result) is then as it was.
    pub fn smooth(&mut self, surface: &Surface, closeness: f64) -> Result<&Smoothed, SmoothError> {
        self.watched(surface, SmoothingMode::Tether { closeness }, &mut Watch::nobody())
    }

    /// [`smooth`](Self::smooth), asking after every round whether to go on: the slider may have moved on.
    ///
    /// # Errors
    /// As [`smooth`](Self::smooth), and [`SmoothError::Stopped`].
    pub fn smooth_while(
        &mut self,
        surface: &Surface,
        closeness: f64,
        go_on: &mut dyn FnMut(&SmoothProgress) -> ControlFlow<()>,
    ) -> Result<&Smoothed, SmoothError> {
        self.watched(surface, SmoothingMode::Tether { closeness }, &mut Watch::asking(go_on))
    }

    /// Smooths the line that was taken up by any mode, asking after every round whether to go on.
    ///
    /// # Errors
    /// As [`smooth_while`](Self::smooth_while).
    pub fn smooth_by(
        &mut self,
        surface: &Surface,
        mode: SmoothingMode,
        go_on: &mut dyn FnMut(&SmoothProgress) -> ControlFlow<()>,
    ) -> Result<&Smoothed, SmoothError> {
        self.watched(surface, mode, &mut Watch::asking(go_on))
    }

    fn watched(
        &mut self,
        surface: &Surface,
        mode: SmoothingMode,
        watch: &mut Watch<'_>,
    ) -> Result<&Smoothed, SmoothError> {
        if surface.identity() != self.surface {
            return Err(SmoothError::OtherSurface);
        }
        self.smoothing.mode = mode;
        self.smoothing.check()?;
        let done = self.workspace.run(surface, &self.smoothing, watch)?;
        self.workspace.give(surface, done, &mut self.out);
        Ok(&self.out)
    }

    /// Smooths only a part of the line from now on, or all of it.
    pub fn set_range(&mut self, range: Option<SmoothRange>) {
        self.smoothing.range = range;
    }

    /// The line that was taken up.
    pub fn given(&self) -> &SurfacePolyline {
        &self.line
    }

    /// What came out last; the line as it was taken up, before anything did.
    pub fn result(&self) -> &Smoothed {
        &self.out
    }

    /// What came out last.
    pub fn into_line(self) -> SurfacePolyline {
        self.out.line
    }
}
