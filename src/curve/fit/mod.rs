//! Splines that follow a drawn line within a tolerance.

mod distance;
mod line;
mod piece;
mod planar;
mod shape;

pub use line::DrawnLine;

use std::f64::consts::{FRAC_PI_3, PI};

use super::{Join, Scheme, Spline, Trace, TraceError, TraceWorkspace, handles};
use crate::geodesic::{PathError, tangent::InnerTangent};
use crate::surface::{PointError, Surface, SurfacePoint};
use piece::{Fitter, Piece};
use shape::Shape;

/// How a drawn line becomes a spline.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct FitOptions {
    /// Largest distance between line and traced spline, in local units; none: half a hundredth of the line's length.
    pub tolerance: Option<f64>,
    /// Points where the line turns by more than this (radians) within twice the tolerance become corners.
    pub corner_angle: f64,
    /// How the spline is traced, which is a part of what is compared with the line; no B-spline.
    pub scheme: Scheme,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { tolerance: None, corner_angle: FRAC_PI_3, scheme: Scheme::default() }
    }
}

impl FitOptions {
    /// The default with a tolerance, in local units.
    pub fn within(tolerance: f64) -> Self {
        Self { tolerance: Some(tolerance), ..Self::default() }
    }
}

/// A spline that follows a drawn line.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The spline; closed if the line is.
    pub spline: Spline,
    /// Its trace, the same as [`Spline::trace`] gives.
    pub trace: Trace,
    /// A bound for the distance, through space, between any place of the line and the trace, and any place of the trace and
    /// the line. Each segment is compared with the stretch of the line that it stands for.
    pub max_distance: f64,
    /// How many corners of the line were found and kept.
    pub corners: u32,
    /// How many segments are straight, because no smooth one was near enough; more than a few say that the tolerance is
    /// smaller than the line's noise.
    pub straight: u32,
}

/// Why a line could not be followed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Too few points.
    #[error("a line needs at least two distinct points, and there is {count}: draw further")]
    TooFewPoints {
        /// How many there are.
        count: usize,
    },
    /// An option makes no sense.
    #[error("{0}")]
    Options(&'static str),
    /// Not even a straight segment is near enough to the line.
    #[error(
        "at {} the trace stays {distance} from the line, more than {tolerance}: allow more or draw in smaller steps",
        at.face
    )]
    NotReached {
        /// Where.
        at: SurfacePoint,
        /// How far they are apart.
        distance: f64,
        /// What was asked for.
        tolerance: f64,
    },
    /// A point does not belong to the surface.
    #[error(transparent)]
    Point(#[from] PointError),
    /// The line was drawn on another surface.
    #[error(transparent)]
    Path(#[from] PathError),
    /// A segment cannot be traced.
    #[error(transparent)]
    Trace(#[from] TraceError),
}

impl Spline {
    /// Makes the spline that follows a drawn line within a tolerance, with few segments.
    ///
    /// Points where the line turns sharply become corners, and between them the spline is smooth (G¹). A stretch becomes one
    /// segment whose end tangents are those of the line and whose two handle lengths are found by least squares, first in
    /// the plane into which the line is rolled out, then on the surface. Where the trace is not near enough it is split at the
    /// point where it is farthest. A stretch between two neighbouring points that no smooth segment follows becomes straight,
    /// with corners, so that the tolerance is met however noisy the line is.
    ///
    /// Cost: two or three traces for each segment of the result; the line is rolled out once. A line of 500 points across a scan of
    /// 70,000 to 100,000 faces takes 10 to 20 ms.
    ///
    /// Source: Schneider 1990, “An algorithm for automatically fitting digitized curves”, carried to surfaces.
    ///
    /// # Errors
    /// [`FitError`] for lines of less than two points, options that make no sense, and a tolerance so small that rounding
    /// is larger.
    pub fn fit(
        surface: &Surface,
        workspace: &mut TraceWorkspace,
        line: &DrawnLine,
        options: &FitOptions,
    ) -> Result<Fit, FitError> {
        let tolerance = checked(line, options)?;
        let finder = &mut workspace.finder;
        let mut shape = Shape::of(surface, finder, line, 0)?;
        if shape.length() <= 0.0 {
            return Err(FitError::TooFewPoints { count: 1 });
        }
        let mut corners = corners(&shape, tolerance, options.corner_angle, line.is_closed());
        if let (true, Some(first)) = (line.is_closed(), corners.first().copied()) {
            shape = Shape::of(surface, finder, line, first)?;
            corners.iter_mut().for_each(|corner| *corner -= first);
        }
        let mut fitter = Fitter::new(surface, workspace, shape, options, tolerance, corners, line.is_closed())?;
        let pieces = fitter.all()?;
        assemble(surface, line, options, fitter.corners(), pieces)
    }
}

/// Lengths of the two handles with which one segment follows a line best, its end tangents given (both away from there), and how
/// far they are apart then; none for a line of no length.
pub(crate) fn refit(
    surface: &Surface,
    workspace: &mut TraceWorkspace,
    line: &DrawnLine,
    scheme: Scheme,
    tangents: [InnerTangent; 2],
    guess: [f64; 2],
) -> Result<Option<([f64; 2], f64)>, TraceError> {
    let options = FitOptions { scheme, ..FitOptions::default() };
    if line.paths().is_empty() {
        return Ok(None);
    }
    let shape = Shape::of(surface, &mut workspace.finder, line, 0)?;
    if shape.length() <= 0.0 {
        return Ok(None);
    }
    let tolerance = 1e-3 * shape.length();
    let mut fitter = Fitter::new(surface, workspace, shape, &options, tolerance, Vec::new(), false)?;
    Ok(Some(fitter.refit(tangents, guess)?))
}

/// The tolerance, if the options make sense.
fn checked(line: &DrawnLine, options: &FitOptions) -> Result<f64, FitError> {
    if line.paths().is_empty() {
        return Err(FitError::TooFewPoints { count: line.points().len() });
    }
    let tolerance = options.tolerance.unwrap_or_else(|| 0.005 * line.length());
    if !tolerance.is_finite() || tolerance <= 0.0 {
        return Err(FitError::Options("the tolerance of a fit is not a length: give a positive number"));
    }
    if options.corner_angle.is_nan() {
        return Err(FitError::Options("the corner angle of a fit is not a number: give one between 0 and π"));
    }
    if options.scheme.method.is_b_spline() {
        return Err(FitError::Options("a line is fitted by Bézier segments: fit with another scheme, then convert"));
    }
    if !options.scheme.is_sound() {
        return Err(FitError::Options("a length or an angle of the scheme is not a number: give numbers"));
    }
    Ok(tolerance)
}

/// Points where the line turns sharply, in order.
fn corners(shape: &Shape, tolerance: f64, angle: f64, closed: bool) -> Vec<usize> {
    /// Of what a corner turns this share is turned in the inner half of what is looked at; a bend turns half.
    const SUDDEN: f64 = 0.7;
    let (count, length) = (shape.leg_count(), shape.length());
    let reach = (2.0 * tolerance).max(1.5 * length / count as f64).min(0.25 * length);
    let candidates = if closed { 0..count } else { 1..count };
    let mut sharp: Vec<(usize, f64)> = candidates
        .filter_map(|i| {
            let turn = shape.turn(i, reach).abs();
            (turn > angle && shape.turn(i, 0.5 * reach).abs() > SUDDEN * turn).then_some((i, turn))
        })
        .collect();
    sharp.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut kept: Vec<usize> = Vec::new();
    for (i, _) in sharp {
        let apart = |k: &usize| {
            let d = (shape.at(i) - shape.at(*k)).abs();
            (if closed { d.min(length - d) } else { d }) > reach
        };
        if kept.iter().all(apart) {
            kept.push(i);
        }
    }
    kept.sort_unstable();
    kept
}

/// The spline made of pieces.
fn assemble(
    surface: &Surface,
    line: &DrawnLine,
    options: &FitOptions,
    corners: &[usize],
    mut pieces: Vec<Piece>,
) -> Result<Fit, FitError> {
    let (count, closed) = (pieces.len(), line.is_closed());
    let mut anchors = Vec::with_capacity(count + 1);
    for k in 0..if closed { count } else { count + 1 } {
        let before = if closed { Some((k + count - 1) % count) } else { k.checked_sub(1) };
        let after = (k < count).then_some(k);
        let point = after.map_or_else(|| pieces[count - 1].end, |k| pieces[k].start);
        let mut anchor = handles::bare_anchor(surface, point)?;
        if let (Some(b), Some(a)) = (before, after)
            && !pieces[b].straight
            && !pieces[a].straight
            && !corners.contains(&pieces[a].from)
        {
            anchor.join = Join::Smooth;
        }
        if let Some(before) = before {
            anchor.incoming.clone_from(&pieces[before].incoming);
        }
        if let Some(after) = after {
            anchor.outgoing.clone_from(&pieces[after].outgoing);
        }
        anchors.push(anchor);
    }
    let max_distance = pieces.iter().map(|piece| piece.distance).fold(0.0, f64::max);
    let straight = pieces.iter().filter(|piece| piece.straight).count() as u32;
    let segments = pieces.iter_mut().map(|piece| std::mem::take(&mut piece.trace)).collect();
    Ok(Fit {
        spline: Spline { anchors, closed, scheme: options.scheme, jumps: Default::default() },
        trace: Trace::new(segments, (0..count as u32).collect()),
        max_distance,
        corners: corners.len() as u32,
        straight,
    })
}

/// The direction back.
fn reversed(direction: f64) -> f64 {
    direction + PI
}
