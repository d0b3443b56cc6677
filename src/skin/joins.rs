//! How segments meet, and what is kept of it.

use glam::DVec3;

/// What stays the same about two segments that meet at an anchor while handles move them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum JoinKind {
    /// That they meet (C0).
    #[default]
    Corner,
    /// That the handles are opposite and equally long (C1).
    Mirrored,
    /// That the handles are opposite, and the ratio of their lengths (G1). A flexible pose frees the ratio.
    Smooth,
    /// The angle between the handles, and the ratio of their lengths. A flexible pose frees the ratio. In space the angle turns along
    /// with the handles that move the anchor.
    Angle,
}

impl JoinKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Corner, Self::Mirrored, Self::Smooth, Self::Angle];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Corner => "corner",
            Self::Mirrored => "mirrored",
            Self::Smooth => "smooth",
            Self::Angle => "angle",
        }
    }
}

/// A join of a chain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct ChainJoin {
    /// What is kept.
    pub kind: JoinKind,
    /// Where the anchor stays, whatever the handles do.
    pub pinned: Option<DVec3>,
}

/// How the joins of a drawing are recognised.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct JoinRules {
    /// Handles shorter than this share of the chain's extent have no direction: the join is a corner. Ends of an open path that are nearer
    /// to each other than this are joined.
    pub degenerate: f64,
    /// By how much handles may miss being opposite, as the distance of their unit vectors.
    pub opposite: f64,
    /// By how much the cosine of a right angle may miss zero.
    pub right: f64,
    /// By how much the lengths of mirrored handles may differ, as a share of the longer one.
    pub length: f64,
    /// Whether opposite handles of the same length are [`JoinKind::Mirrored`]; else they are [`JoinKind::Smooth`] like others.
    pub keep_mirrored: bool,
    /// Whether right angles are [`JoinKind::Angle`]; else they are corners.
    pub keep_right_angles: bool,
}

impl Default for JoinRules {
    fn default() -> Self {
        Self {
            degenerate: 1e-6,
            opposite: 1e-3,
            right: 1e-3,
            length: 1e-3,
            keep_mirrored: false,
            keep_right_angles: true,
        }
    }
}

impl JoinRules {
    /// The kind of a join by the vectors from its anchor to its handles; `extent` is that of the chain.
    pub fn kind(&self, incoming: DVec3, outgoing: DVec3, extent: f64) -> JoinKind {
        let (p, q) = (incoming.length(), outgoing.length());
        let shortest = (self.degenerate * extent).max(f64::MIN_POSITIVE);
        if p < shortest || q < shortest {
            return JoinKind::Corner;
        }
        let (u, v) = (incoming / p, outgoing / q);
        if (u + v).length() <= self.opposite {
            let same = (p - q).abs() <= self.length * p.max(q);
            if self.keep_mirrored && same { JoinKind::Mirrored } else { JoinKind::Smooth }
        } else if self.keep_right_angles && u.dot(v).abs() <= self.right {
            JoinKind::Angle
        } else {
            JoinKind::Corner
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn kinds_do_not_depend_on_the_scale() {
        let rules = JoinRules::default();
        let mirrored = JoinRules { keep_mirrored: true, ..rules };
        for scale in [1e-6, 1.0, 1e6] {
            let u = DVec2::from_angle(0.7).extend(0.0) * scale;
            let turned = |angle: f64| (DVec2::from_angle(0.7 + angle) * scale).extend(0.0);
            assert_eq!(rules.kind(u, -2.0 * u, scale), JoinKind::Smooth);
            assert_eq!(rules.kind(u, -u, scale), JoinKind::Smooth);
            assert_eq!(mirrored.kind(u, -u, scale), JoinKind::Mirrored);
            assert_eq!(mirrored.kind(u, -1.01 * u, scale), JoinKind::Smooth);
            assert_eq!(rules.kind(u, -turned(0.9e-3), scale), JoinKind::Smooth);
            assert_eq!(rules.kind(u, -turned(1.1e-3), scale), JoinKind::Corner);
            assert_eq!(rules.kind(u, 3.0 * turned(std::f64::consts::FRAC_PI_2), scale), JoinKind::Angle);
            assert_eq!(rules.kind(u, turned(1.0), scale), JoinKind::Corner);
            assert_eq!(rules.kind(u, u, scale), JoinKind::Corner);
            assert_eq!(rules.kind(1e-7 * u, -u, scale), JoinKind::Corner);
            assert_eq!(rules.kind(DVec3::ZERO, -u, 0.0), JoinKind::Corner);
        }
    }
}
