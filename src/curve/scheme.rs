//! How a control polygon becomes a curve.

/// How a control polygon becomes a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum Scheme {
    /// Recursive de Casteljau: every level halves each piece of the polygon; 3 · 2^levels legs. C¹.
    DeCasteljau {
        /// How often each piece is halved, at most [`Scheme::MAX_LEVELS`].
        levels: u8,
    },
    /// Open-uniform Lane–Riesenfeld: every level doubles the intervals of a B-spline; 2^levels + 3 points. C² inside.
    LaneRiesenfeld {
        /// How often the intervals are doubled, at most [`Scheme::MAX_LEVELS`].
        levels: u8,
    },
}

impl Scheme {
    /// More levels than this are counted as this many: 2^12 pieces a segment.
    pub const MAX_LEVELS: u8 = 12;

    /// Recursive de Casteljau with four levels (48 legs).
    pub const fn de_casteljau() -> Self {
        Self::DeCasteljau { levels: 4 }
    }

    /// Lane–Riesenfeld with six levels (67 points).
    pub const fn lane_riesenfeld() -> Self {
        Self::LaneRiesenfeld { levels: 6 }
    }

    /// The same scheme with another number of levels.
    pub const fn with_levels(self, levels: u8) -> Self {
        match self {
            Self::DeCasteljau { .. } => Self::DeCasteljau { levels },
            Self::LaneRiesenfeld { .. } => Self::LaneRiesenfeld { levels },
        }
    }

    /// Number of levels, at most [`Scheme::MAX_LEVELS`].
    pub const fn levels(self) -> u8 {
        let (Self::DeCasteljau { levels } | Self::LaneRiesenfeld { levels }) = self;
        if levels < Self::MAX_LEVELS { levels } else { Self::MAX_LEVELS }
    }
}

impl Default for Scheme {
    fn default() -> Self {
        Self::de_casteljau()
    }
}
