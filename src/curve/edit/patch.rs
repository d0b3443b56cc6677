//! The difference of two versions of a spline: what inverses are made of.

use super::EditError;
use crate::curve::{Anchor, JumpPolicy, Sampling, Scheme, Spline};
use crate::geodesic::GeodesicPath;
use crate::surface::SurfacePoint;

/// What turns one version of a spline into another: a range of anchors and the two settings.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct SplinePatch {
    /// Hash of the version it applies to.
    version: u64,
    at: u32,
    remove: u32,
    insert: Vec<Anchor>,
    closed: bool,
    scheme: Scheme,
    jumps: JumpPolicy,
}

impl SplinePatch {
    /// The smallest patch that turns `from` into `to`.
    pub(super) fn between(from: &Spline, to: &Spline) -> Self {
        let (a, b) = (&from.anchors, &to.anchors);
        let same = |(x, y): &(&Anchor, &Anchor)| hash_anchor(x) == hash_anchor(y) && x == y;
        let at = a.iter().zip(b).take_while(same).count();
        let rest = a.len().min(b.len()) - at;
        let kept = a.iter().rev().zip(b.iter().rev()).take(rest).take_while(same).count();
        Self {
            version: hash_spline(from),
            at: at as u32,
            remove: (a.len() - kept - at) as u32,
            insert: b[at..b.len() - kept].to_vec(),
            closed: to.closed,
            scheme: to.scheme,
            jumps: to.jumps,
        }
    }

    /// Whether every anchor outside of the range keeps its number.
    #[cfg(feature = "tools")]
    pub(crate) fn keeps_numbers(&self) -> bool {
        self.remove as usize == self.insert.len()
    }

    /// The anchors it puts in.
    #[cfg(feature = "tools")]
    pub(crate) fn anchors(&self) -> &[Anchor] {
        &self.insert
    }
}

/// Hashes every bit of a spline, so that a patch knows the version it was made for.
fn hash_spline(spline: &Spline) -> u64 {
    let mut words = Words::default();
    words.mix(u64::from(spline.closed));
    words.mix(spline.jumps as u64);
    words.scheme(&spline.scheme);
    spline.anchors.iter().for_each(|a| words.mix(hash_anchor(a)));
    words.0
}

fn hash_anchor(anchor: &Anchor) -> u64 {
    let mut words = Words::default();
    words.point(&anchor.point);
    words.mix(anchor.join as u64);
    for handle in [&anchor.incoming, &anchor.outgoing] {
        words.path(&handle.leg);
        words.mix(u64::from(handle.heading.face.0));
        for x in [handle.heading.vector.x, handle.heading.vector.y, handle.wished_length] {
            words.mix(x.to_bits());
        }
    }
    words.mix(u64::from(anchor.middle.is_some()));
    anchor.middle.iter().for_each(|middle| words.path(middle));
    words.0
}

#[derive(Default)]
struct Words(u64);

impl Words {
    fn mix(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0xff51_afd7_ed55_8ccd).wrapping_add(0x9e37_79b9_7f4a_7c15);
        self.0 ^= self.0 >> 32;
    }

    fn path(&mut self, path: &GeodesicPath) {
        self.point(&path.start);
        self.point(&path.end);
        for c in &path.crossings {
            self.mix(u64::from(c.face.0) << 8 | u64::from(c.side));
            self.mix(c.at.to_bits());
        }
        self.mix(path.length.to_bits());
    }

    fn scheme(&mut self, scheme: &Scheme) {
        self.mix(scheme.method as u64 | u64::from(scheme.on_curve) << 8);
        match scheme.sampling {
            Sampling::Levels(levels) => self.mix(u64::from(levels)),
            Sampling::Length(length) => self.mix(length.to_bits()),
            Sampling::Adaptive { turn, length } => {
                self.mix(turn.to_bits());
                self.mix(length.map_or(1, f64::to_bits));
            }
        }
    }

    fn point(&mut self, point: &SurfacePoint) {
        self.mix(u64::from(point.face.0));
        point.weights.iter().for_each(|w| self.mix(w.to_bits()));
    }
}

impl Spline {
    pub(super) fn restore(&mut self, patch: &SplinePatch) -> Result<(), EditError> {
        let (at, remove) = (patch.at as usize, patch.remove as usize);
        let end = at.checked_add(remove).filter(|end| *end <= self.anchors.len()).ok_or(EditError::OtherVersion)?;
        if patch.version != hash_spline(self) {
            return Err(EditError::OtherVersion);
        }
        self.anchors.splice(at..end, patch.insert.iter().cloned());
        (self.closed, self.scheme, self.jumps) = (patch.closed, patch.scheme, patch.jumps);
        Ok(())
    }
}
