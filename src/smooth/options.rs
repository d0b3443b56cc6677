//! What is asked of smoothing, and what can be wrong with it.

use super::{PolylineError, SmoothRange};
use crate::geodesic::PathError;
use crate::surface::{PointError, SurfacePoint};

/// What a line becomes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum SmoothingMode {
    /// As short as it can be without being led over a handle of the surface: straight, as far as that goes. An open line becomes what
    /// [`PathFinder`](crate::geodesic::PathFinder) makes of it; a closed one a closed geodesic, or nothing.
    Geodesic,
    /// Its own geodesic curvature, evened out along it: a density, so that it does not depend on the mesh, averaged with its neighbours
    /// `passes` times and multiplied by `scale`. With scale 1 the line turns by as much in all as before; with 0 it is
    /// straight, and with more than 1 a closed line grows. It may drift from where it was drawn.
    Stencil {
        /// What the evened-out curvature is multiplied by, 0 to 2.
        scale: f64,
        /// How often it is averaged, at most 1,000; 5 is a good number.
        passes: u32,
    },
    /// Shortened by plain sweeps until the sizes of its turns add up to a share of what they did.
    Budget {
        /// The share, 0 to 1.
        share: f64,
    },
    /// Length against the distance from where it was drawn: the default.
    ///
    /// Minimises Σ|Δx| + ½ closeness Σ Δs (d / reach)², d the distance of a crossing to the drawn line. The closeness has no
    /// unit: 0.1 is nearly straight, 10 keeps the shape, 1,000 is nearly what was drawn. Where the drawn line is smooth already
    /// the tether is stiffer ([`Smoothing::roughness`]).
    Tether {
        /// How close the line stays, 0 to 1e6.
        closeness: f64,
    },
    /// Shortest on the surface lifted by the potential weight · reach · (d / reach)² into a fourth dimension, d the distance of vertices
    /// to the drawn line: the thesis' proposal.
    ///
    /// Exact and quick, and not smooth: a potential that is linear in every face refracts the line at every side, so that with weights of 10
    /// and more it is rougher than what was drawn.
    Lift {
        /// The weight, 0 to 1e6.
        weight: f64,
    },
    /// Shortest where sides count 1 + weight · (d / reach)² times their length. Refracted as well, about half as much as with a lift.
    Conformal {
        /// The weight, 0 to 1e6.
        weight: f64,
    },
}

impl Default for SmoothingMode {
    fn default() -> Self {
        Self::Tether { closeness: 10.0 }
    }
}

impl SmoothingMode {
    /// A word for it.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Geodesic => "geodesic",
            Self::Stencil { .. } => "stencil",
            Self::Budget { .. } => "budget",
            Self::Tether { .. } => "tether",
            Self::Lift { .. } => "lift",
            Self::Conformal { .. } => "conformal",
        }
    }
}

/// How far a line may go from where it was drawn, in local units, through space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum Envelope {
    /// Stops at that distance: corners may be where it does.
    Hard(f64),
    /// Is tethered just enough to stay within it, and has no corners for that.
    Soft(f64),
}

/// How crossings are moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum Iteration {
    /// All together, by solving for them.
    #[default]
    Solve,
    /// Each for itself, sweep after sweep, from where its neighbours were; thousands of sweeps. For geodesic, stencil and budget.
    Symmetric,
    /// Likewise, from where its neighbours are: every other crossing, then those between.
    Sequential,
}

/// How a line is smoothed.
///
/// The default suits lines drawn by hand: tethered with closeness 10, what is smooth already stays. On jagged lines that closeness leaves less than a
/// thousandth of the squared curvature, a mean edge and a third from where they were drawn; 100 leaves thirty times as much, three quarters as far
/// (the example `smoothing_report` measures it).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct Smoothing {
    /// What the line becomes.
    pub mode: SmoothingMode,
    /// The length that distances are compared with, in local units; none: ten mean edges.
    pub reach: Option<f64>,
    /// A tethered line counts as rough where its nearest turns point to and fro by more than this (radians in all); where it is smoother it
    /// stays where it is, the more the smoother it is: curves, and corners between straight stretches too. Corners of a radian or more, six
    /// mean edges apart at most, count as to and fro to whatever side they turn, and what is smooth over less than twelve mean edges beside
    /// what is rough is smoothed with it. 0 tethers all of it alike.
    pub roughness: f64,
    /// How far it may go.
    pub envelope: Option<Envelope>,
    /// The boundary keeps the line off within this distance (local units); none: the line may run along it.
    pub barrier: Option<f64>,
    /// Which part of it is smoothed, by the mode tether; none: all.
    pub range: Option<SmoothRange>,
    /// How crossings are moved.
    pub iteration: Iteration,
    /// How often vertices are passed, at most.
    pub max_rounds: u32,
    /// How often crossings are swept, at most, by the iterations that do.
    pub max_sweeps: u32,
}

impl Default for Smoothing {
    fn default() -> Self {
        Self {
            mode: SmoothingMode::default(),
            reach: None,
            roughness: 0.3,
            envelope: None,
            barrier: None,
            range: None,
            iteration: Iteration::Solve,
            max_rounds: 4_000,
            max_sweeps: 200_000,
        }
    }
}

impl Smoothing {
    /// The default by a mode.
    pub fn by(mode: SmoothingMode) -> Self {
        Self { mode, ..Self::default() }
    }

    /// Tethered with a closeness.
    pub fn tether(closeness: f64) -> Self {
        Self::by(SmoothingMode::Tether { closeness })
    }

    /// The same for a part of the line.
    pub fn only(self, range: SmoothRange) -> Self {
        Self { range: Some(range), ..self }
    }

    /// The same within an envelope.
    pub fn within(self, envelope: Envelope) -> Self {
        Self { envelope: Some(envelope), ..self }
    }

    /// Whether all numbers make sense.
    pub(crate) fn check(&self) -> Result<(), SmoothError> {
        let between = |x: f64, low: f64, high: f64| (low..=high).contains(&x);
        let fine = match self.mode {
            SmoothingMode::Geodesic => true,
            SmoothingMode::Stencil { scale, passes } => between(scale, 0.0, 2.0) && passes <= 1_000,
            SmoothingMode::Budget { share } => between(share, 0.0, 1.0),
            SmoothingMode::Tether { closeness: weight }
            | SmoothingMode::Lift { weight }
            | SmoothingMode::Conformal { weight } => between(weight, 0.0, 1e6),
        };
        let sweeps =
            matches!(self.mode, SmoothingMode::Geodesic | SmoothingMode::Stencil { .. } | SmoothingMode::Budget { .. });
        let length = |x: Option<f64>| x.is_none_or(|x| x.is_finite() && x > 0.0);
        let envelope = self.envelope.map(|(Envelope::Hard(far) | Envelope::Soft(far))| far);
        let tethered = matches!(self.mode, SmoothingMode::Tether { .. });
        let word = if !fine {
            "the mode's numbers: scale 0 to 2, at most 1,000 passes, share 0 to 1, closeness and weights 0 to 1,000,000"
        } else if !length(self.reach) || !length(self.barrier) || !length(envelope) {
            "reach, barrier and envelope are lengths: give finite numbers above 0, or none"
        } else if !between(self.roughness, 0.0, f64::MAX) {
            "the roughness is an angle: give a finite number, 0 or more"
        } else if self.range.is_some_and(|range| !range.is_fine() || !tethered) {
            "a range is for the mode tether: a finite place, a radius above 0, a falloff of 0 to 1 and a strength of 0.001 to 1"
        } else if self.iteration != Iteration::Solve && !sweeps {
            "sweeps are for the modes geodesic, stencil and budget: leave the iteration at Solve"
        } else {
            return Ok(());
        };
        Err(SmoothError::Options(word))
    }
}

/// Why a line could not be smoothed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SmoothError {
    /// An option makes no sense.
    #[error("{0}")]
    Options(&'static str),
    /// A closed line that nothing holds shrank to a point.
    #[error(
        "the closed line shrank to a point at {}: nothing of the surface holds it; tether it closer, or fix a crossing", at.face
    )]
    Collapsed {
        /// Where.
        at: SurfacePoint,
    },
    /// The line was taken up on another surface.
    #[error("the line was taken up on another surface: take it up again on this one")]
    OtherSurface,
    /// It was not to go on.
    #[error("smoothing was stopped; the line is as it was")]
    Stopped,
    /// The line does not belong to the surface.
    #[error(transparent)]
    Line(#[from] PolylineError),
    /// The line does not belong to the surface.
    #[error(transparent)]
    Path(#[from] PathError),
}

impl From<PointError> for SmoothError {
    fn from(error: PointError) -> Self {
        Self::Line(error.into())
    }
}
