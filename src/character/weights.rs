//! Weights of the joints that a part follows.

use glam::{DVec2, DVec3};

use super::{Character, CharacterError, Part, WeightSource};
#[cfg(feature = "weights")]
use crate::skin::{Cage, MeshedWeights, WeightsError};
use crate::skin::{Chain, HandleShape, Quadrature, Shepard, SkinError, WeightField};

/// Weights of the joints that a part follows, in ascending order of joints.
pub(super) enum PartField {
    /// There is one joint.
    Rigid,
    Smooth(Shepard),
    #[cfg(feature = "weights")]
    Bounded(MeshedWeights),
    /// Corners of a cage, each with the place of its joint among those that the part follows.
    #[cfg(feature = "weights")]
    Cage {
        field: MeshedWeights,
        joints: Vec<usize>,
        count: usize,
    },
}

impl WeightField for PartField {
    fn handle_count(&self) -> usize {
        match self {
            Self::Rigid => 1,
            Self::Smooth(field) => field.handle_count(),
            #[cfg(feature = "weights")]
            Self::Bounded(field) => field.handle_count(),
            #[cfg(feature = "weights")]
            Self::Cage { count, .. } => *count,
        }
    }

    fn weights_at(&self, place: DVec3, out: &mut [f64]) {
        match self {
            Self::Rigid => out.fill(1.0),
            Self::Smooth(field) => field.weights_at(place, out),
            #[cfg(feature = "weights")]
            Self::Bounded(field) => field.weights_at(place, out),
            #[cfg(feature = "weights")]
            Self::Cage { field, joints, .. } => {
                out.fill(0.0);
                let mut corners = vec![0.0; joints.len()];
                field.weights_at(place, &mut corners);
                for (joint, weight) in joints.iter().zip(corners) {
                    if let Some(out) = out.get_mut(*joint) {
                        *out += weight;
                    }
                }
            }
        }
    }

    fn quadrature(&self) -> Quadrature {
        match self {
            // All rules are exact.
            Self::Rigid => Quadrature { nodes: 4, pieces: 1 },
            Self::Smooth(field) => field.quadrature(),
            #[cfg(feature = "weights")]
            Self::Bounded(_) | Self::Cage { .. } => Quadrature::PIECEWISE,
        }
    }
}

/// A bone that counts in bounded weights is shorter by this share at either end.
const SHORTER: f64 = 0.1;

/// Vertices that a thin outline may add, as a multiple of triangles: twice those of an even one.
#[cfg(feature = "weights")]
const SPARE: usize = 1;

impl Character {
    /// Where the weights of a part come from.
    pub(super) fn source_of<'a>(&'a self, part: &'a Part) -> &'a WeightSource {
        part.weights.as_ref().unwrap_or(&self.weights)
    }

    /// Whether weights of a part have to be solved for, so that keeping them is worth while.
    pub(super) fn is_solved(&self, part: &Part) -> bool {
        part.follows.len() > 1 && !matches!(self.source_of(part), WeightSource::Shepard { .. })
    }

    /// What a part is held by: `joints` are those that it follows.
    pub(super) fn handles_of(&self, part: &Part, joints: &[u32]) -> Vec<HandleShape> {
        let shorter = matches!(self.source_of(part), WeightSource::Bounded { .. });
        let followed = joints.iter().filter_map(|joint| self.joints.get(*joint as usize));
        let shape = |from: DVec2, to: DVec2| {
            let off = if shorter { SHORTER * (to - from) } else { DVec2::ZERO };
            HandleShape::Bone((from + off).extend(0.0), (to - off).extend(0.0))
        };
        followed.map(|j| j.tip.map_or(HandleShape::planar(j.at), |tip| shape(j.at, tip))).collect()
    }

    /// The weights of a part by its `joints`, on its chains.
    pub(super) fn field_of(&self, part: &Part, joints: &[u32], chains: &[&Chain]) -> Result<PartField, CharacterError> {
        if joints.len() == 1 {
            return Ok(PartField::Rigid);
        }
        let handles = self.handles_of(part, joints);
        match self.source_of(part) {
            WeightSource::Shepard { power } => {
                let field = Shepard::with_power(&handles, *power).map_err(|source| no_weights(part, source));
                Ok(PartField::Smooth(field?))
            }
            source => solved(part, source, joints, &handles, chains),
        }
    }
}

/// Handles were checked, so this is not for people to see.
fn no_weights(part: &Part, source: SkinError) -> CharacterError {
    CharacterError::Skin { part: part.name.clone(), shape: part.shapes.concat(), path: 0, source }
}

#[cfg(not(feature = "weights"))]
fn solved(
    part: &Part,
    source: &WeightSource,
    _joints: &[u32],
    _handles: &[HandleShape],
    _chains: &[&Chain],
) -> Result<PartField, CharacterError> {
    let source_name = if matches!(source, WeightSource::Cage { .. }) { "`Cage`" } else { "`Bounded`" };
    Err(CharacterError::FeatureOff { part: part.name.clone(), source_name })
}

#[cfg(feature = "weights")]
fn solved(
    part: &Part,
    source: &WeightSource,
    joints: &[u32],
    handles: &[HandleShape],
    chains: &[&Chain],
) -> Result<PartField, CharacterError> {
    let failed = |source: WeightsError| CharacterError::Weights { part: part.name.clone(), source };
    match source {
        WeightSource::Cage { triangles, corners } => {
            let places: Vec<DVec2> = corners.iter().map(|corner| corner.at).collect();
            let cage = Cage::new(&places).map_err(failed)?;
            let field = MeshedWeights::harmonic_within(&cage, *triangles as usize, SPARE).map_err(failed)?;
            let place = |joint: usize| joints.iter().position(|of| *of as usize == joint).unwrap_or(usize::MAX);
            let joints_of_corners = corners.iter().map(|corner| place(corner.joint)).collect();
            Ok(PartField::Cage { field, joints: joints_of_corners, count: joints.len() })
        }
        WeightSource::Bounded { triangles, outline } => {
            let cage = if outline.is_empty() { around(handles, chains) } else { Cage::new(outline) };
            let field = MeshedWeights::biharmonic_within(&cage.map_err(failed)?, handles, *triangles as usize, SPARE);
            Ok(PartField::Bounded(field.map_err(failed)?))
        }
        WeightSource::Shepard { .. } => Ok(PartField::Rigid),
    }
}

/// A rectangle about what moves and what it follows.
#[cfg(feature = "weights")]
fn around(handles: &[HandleShape], chains: &[&Chain]) -> Result<Cage, WeightsError> {
    let ends = handles.iter().flat_map(HandleShape::ends);
    let all = || ends.clone().chain(chains.iter().flat_map(|chain| chain.points().iter().copied()));
    let (low, high) = (all().fold(DVec3::MAX, DVec3::min), all().fold(DVec3::MIN, DVec3::max));
    Cage::around(low.truncate(), high.truncate(), 0.05)
}
