//! Tests of skinning across its files: chains and poses at random, and a dense solver to compare with.

mod comparison;
mod dense;
mod flexible;
mod hostile;
mod poses;
mod regular;

use glam::{DAffine2, DAffine3, DMat3, DQuat, DVec2, DVec3};

use super::*;
use crate::vector::{SpatialPath, VectorPath};

/// Small, seeded random numbers (splitmix64).
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From `low` to `high`.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    /// Within a ball, or a disc if it is in the plane.
    pub(super) fn vector(&mut self, spatial: bool) -> DVec3 {
        let z = if spatial { self.between(-1.0, 1.0) } else { 0.0 };
        DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), z)
    }
}

/// A chain whose joins are at random of the given kinds. Handles are as long as segments and longer, as no drawing has them.
pub(super) fn random_chain(
    random: &mut Random,
    segments: usize,
    closed: bool,
    spatial: bool,
    kinds: &[JoinKind],
) -> Chain {
    let anchors = segments + usize::from(!closed);
    let mut points = Vec::new();
    let mut place = DVec3::ZERO;
    for anchor in 0..anchors {
        place += random.vector(spatial) + DVec3::X * if anchor % 7 < 4 { 0.8 } else { -0.8 };
        let handle = random.vector(spatial) * 0.5;
        let kind = kinds[random.below(kinds.len())];
        let ratio = random.between(0.5, 2.0);
        let other = match kind {
            JoinKind::Corner => random.vector(spatial) * 0.5,
            JoinKind::Mirrored => -handle,
            JoinKind::Smooth => -handle * ratio,
            JoinKind::Angle if spatial => {
                let axis = random.vector(true);
                let normal = handle.cross(axis).normalize();
                let angle = random.between(0.4, 2.7);
                DMat3::from_axis_angle(normal, angle) * handle * ratio
            }
            JoinKind::Angle => DMat3::from_axis_angle(DVec3::Z, random.between(0.4, 2.7)) * handle * ratio,
        };
        points.push((place, handle, other, kind));
    }
    let mut list = Vec::new();
    for (anchor, (place, handle, other, _)) in points.iter().enumerate() {
        if closed || anchor > 0 {
            list.push(*place + *handle);
        }
        list.push(*place);
        if closed || anchor + 1 < anchors {
            list.push(*place + *other);
        }
    }
    if closed {
        list.rotate_left(1);
    }
    let rules = JoinRules { degenerate: 0.0, ..JoinRules::default() };
    let mut chain = if spatial {
        Chain::spatial(&SpatialPath::from_points(list, closed).unwrap(), &rules)
    } else {
        let flat = list.iter().map(|p| p.truncate()).collect();
        Chain::planar(&VectorPath::from_points(flat, closed).unwrap(), &rules)
    };
    for (anchor, (.., kind)) in points.iter().enumerate() {
        if closed || (anchor > 0 && anchor + 1 < anchors) {
            chain.set_join(anchor, *kind).unwrap();
        }
    }
    chain
}

/// Handles about the origin of chains.
pub(super) fn random_handles(random: &mut Random, count: usize, spatial: bool) -> Shepard {
    let handles: Vec<HandleShape> = (0..count)
        .map(|i| {
            let place = random.vector(spatial) * 4.0;
            if i % 3 == 2 {
                HandleShape::Bone(place, place + random.vector(spatial))
            } else {
                HandleShape::Point(place)
            }
        })
        .collect();
    Shepard::new(&handles).unwrap()
}

/// Transforms that turn, stretch, shear and shift.
pub(super) fn random_pose(random: &mut Random, count: usize, spatial: bool) -> Vec<DAffine3> {
    let one = |_| {
        let turn = random.between(-1.5, 1.5);
        if spatial {
            let scale = DVec3::from_array([0; 3].map(|_| random.between(0.6, 1.6)));
            let axis = (random.vector(true) + DVec3::Z * 1e-3).normalize();
            DAffine3::from_scale_rotation_translation(scale, DQuat::from_axis_angle(axis, turn), random.vector(true))
        } else {
            let scale = DVec2::new(random.between(0.6, 1.6), random.between(0.6, 1.6));
            let shift = random.vector(false).truncate();
            in_space(&DAffine2::from_scale_angle_translation(scale, turn, shift))
        }
    };
    (0..count).map(one).collect()
}

pub(super) fn bind(chain: &Chain, weights: &Shepard) -> BoundChain {
    BoundChain::new(chain, 0, weights, &BindOptions::default()).unwrap()
}

pub(super) fn solve(bound: &BoundChain, pose: &[DAffine3]) -> Vec<DVec3> {
    let mut out = Vec::new();
    bound.solve(pose, &mut SolveWorkspace::default(), &mut out).unwrap();
    out
}

/// The largest distance between points of two lists of the same length.
pub(super) fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, worse)
}

/// The larger one, or what is no number.
pub(super) fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}
