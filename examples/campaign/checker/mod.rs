//! An independent judge of paths: recomputes adjacency, angles and lengths from the positions in the file, and shares no
//! code with what it judges.
//!
//! A path passes if
//!
//! * every stretch lies in a face, and each begins where the one before ended: in the same face, across a side with exactly
//!   these two faces, or about a vertex;
//! * it starts and ends where it was asked to;
//! * its length is that of its stretches, within 1e-9 of it;
//! * nowhere between its ends can it be shortened by more than 1e-9 of its length. At a side, the two faces are laid flat and
//!   the line is pulled taut; at a vertex the fan of faces is laid flat on both sides, at the boundary on the inner one.
//!
//! Lengths below 1e-13 of the bounding box's diagonal count as rounding.

mod fan;
mod joint;
mod plane;
mod shortness;
mod topology;
mod turn;

#[cfg(test)]
mod mutation;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod walker;

use glam::DVec3;

pub(crate) use joint::same_place;
pub(crate) use topology::Topology;
pub(crate) use turn::Turn;

/// What counts as shorter, as a share of the path's length.
const RELATIVE: f64 = 1e-9;
/// What counts as rounding, as a share of the bounding box's diagonal.
const ROUNDING: f64 = 1e-13;

/// A straight piece of a path inside one input face, by the weights of the face's corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) face: u32,
    pub(crate) from: [f64; 3],
    pub(crate) to: [f64; 3],
}

impl Stretch {
    /// From its begin to its end, in space.
    fn vector(&self, topology: &Topology) -> DVec3 {
        let [a, b, c] = topology.places(self.face);
        let d = |k: usize| self.to[k] - self.from[k];
        (b - a) * d(1) + (c - a) * d(2)
    }

    fn length(&self, topology: &Topology) -> f64 {
        self.vector(topology).length()
    }
}

/// What a path claims to be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Claim<'a> {
    /// Where it was asked to start: face and weights.
    pub(crate) start: (u32, [f64; 3]),
    /// Where it was asked to end.
    pub(crate) end: (u32, [f64; 3]),
    /// Its length.
    pub(crate) length: f64,
    /// Its pieces, in order.
    pub(crate) stretches: &'a [Stretch],
}

/// What is wrong with a path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(crate) enum Fault {
    #[error("it has no stretches")]
    Empty,
    #[error("stretch {stretch} is in face {face}, which is not part of the surface")]
    NoFace { stretch: usize, face: u32 },
    #[error("stretch {stretch} has weights that are not finite")]
    NotFinite { stretch: usize },
    #[error("stretch {stretch} has weights that are not barycentric")]
    Weights { stretch: usize },
    #[error("stretches {joint} and {} do not meet", joint + 1)]
    Torn { joint: usize },
    #[error("it starts somewhere else")]
    Start,
    #[error("it ends somewhere else")]
    End,
    #[error("its length is given as {given:e} and measures {measured:e}")]
    Length { given: f64, measured: f64 },
    #[error("after stretch {joint} (face {face}) it can be shortened by {gain:e}")]
    Bent { joint: usize, face: u32, gain: f64 },
}

impl Fault {
    /// A word for tables.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Empty => "empty",
            Self::NoFace { .. } => "no_such_face",
            Self::NotFinite { .. } => "not_finite",
            Self::Weights { .. } => "weights",
            Self::Torn { .. } => "torn",
            Self::Start | Self::End => "wrong_end",
            Self::Length { .. } => "wrong_length",
            Self::Bent { .. } => "not_shortest",
        }
    }
}

/// Judges one path; returns how many of its places could not be decided (see [`shortness::check`]).
///
/// # Errors
/// The first [`Fault`] found.
pub(crate) fn check(topology: &Topology, claim: &Claim) -> Result<usize, Fault> {
    for (i, s) in claim.stretches.iter().enumerate() {
        check_stretch(topology, i, s)?;
    }
    let (Some(first), Some(last)) = (claim.stretches.first(), claim.stretches.last()) else { return Err(Fault::Empty) };
    if !joint::same_place(topology, claim.start, (first.face, first.from)) {
        return Err(Fault::Start);
    }
    if !joint::same_place(topology, claim.end, (last.face, last.to)) {
        return Err(Fault::End);
    }
    let pairs = claim.stretches.windows(2).enumerate();
    let joints = pairs.map(|(i, w)| joint::locate(topology, i, &w[0], &w[1])).collect::<Result<Vec<_>, _>>()?;
    let measured = length(topology, claim.stretches);
    let allowed = RELATIVE * measured + ROUNDING * topology.diagonal;
    let agrees = (claim.length - measured).abs() <= allowed; // not so for NaN
    if !agrees {
        return Err(Fault::Length { given: claim.length, measured });
    }
    shortness::check(topology, claim.stretches, &joints, allowed)
}

/// Length in space.
pub(crate) fn length(topology: &Topology, stretches: &[Stretch]) -> f64 {
    stretches.iter().map(|s| s.length(topology)).sum()
}

/// Whether the two points lie on one sheet, so that a path must exist; none if they are no points of the surface.
pub(crate) fn connected(topology: &Topology, a: u32, b: u32) -> Option<bool> {
    (topology.has(a) && topology.has(b)).then(|| topology.joined(a, b))
}

/// The turns from each path to the next at the points where they meet; see [`turn`].
pub(crate) fn turns(topology: &Topology, paths: &[Vec<Stretch>]) -> Vec<Turn> {
    turn::all(topology, paths)
}

/// The largest of some turns, in degrees.
pub(crate) fn largest_turn<'a>(turns: impl IntoIterator<Item = &'a Turn>) -> f64 {
    turns.into_iter().map(|turn| turn.degrees).fold(0.0, f64::max)
}

fn check_stretch(topology: &Topology, stretch: usize, s: &Stretch) -> Result<(), Fault> {
    if !topology.has(s.face) {
        return Err(Fault::NoFace { stretch, face: s.face });
    }
    for weights in [s.from, s.to] {
        if !weights.iter().all(|w| w.is_finite()) {
            return Err(Fault::NotFinite { stretch });
        }
        let inside = weights.iter().all(|w| *w >= -joint::WEIGHT);
        if !inside || (weights.iter().sum::<f64>() - 1.0).abs() > joint::WEIGHT {
            return Err(Fault::Weights { stretch });
        }
    }
    Ok(())
}
