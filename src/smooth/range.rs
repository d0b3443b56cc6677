//! Smoothing a part of a line: what a brush does.

/// A part of a line that is smoothed, and fades out to what stays.
///
/// Crossings outside it stay to the last bit. Inside, the tether is the closer the less the brush weighs: its full strength in the middle,
/// falling off smoothly to nothing at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct SmoothRange {
    /// The middle: length along the line from its start (of a closed one, its first crossing), in local units. On a closed line it may be
    /// any number.
    pub center: f64,
    /// How far it reaches to either side, in local units along the line.
    pub radius: f64,
    /// Which share of the radius it fades out over, 0 to 1.
    pub falloff: f64,
    /// How much it weighs in the middle, 0.001 to 1: the closeness is divided by that.
    pub strength: f64,
}

impl SmoothRange {
    /// A range that fades out over all of its radius, at full strength.
    pub fn about(center: f64, radius: f64) -> Self {
        Self { center, radius, falloff: 1.0, strength: 1.0 }
    }

    /// Whether its numbers make sense.
    pub(crate) fn is_fine(&self) -> bool {
        let Self { center, radius, falloff, strength } = *self;
        center.is_finite()
            && radius.is_finite()
            && radius > 0.0
            && (0.0..=1.0).contains(&falloff)
            && (1e-3..=1.0).contains(&strength)
    }

    /// What it weighs at a length along a line of a length, 0 where that is outside.
    pub(crate) fn weight(&self, along: f64, length: f64, closed: bool) -> f64 {
        let mut off = (along - self.center).abs();
        if closed && length > 0.0 {
            off = off.rem_euclid(length);
            off = off.min(length - off);
        }
        if off >= self.radius {
            return 0.0;
        }
        let fade = self.falloff * self.radius;
        let x = if fade > 0.0 { ((self.radius - off) / fade).min(1.0) } else { 1.0 };
        self.strength * x * x * (3.0 - 2.0 * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_fall_off_smoothly_and_go_around() {
        let range = SmoothRange { center: 0.5, radius: 1.0, falloff: 0.5, strength: 0.8 };
        let known = [(0.5, 0.8), (1.0, 0.8), (1.25, 0.4), (1.5, 0.0), (9.5, 0.0), (-0.25, 0.4)];
        for (along, weight) in known {
            assert!((range.weight(along, 10.0, false) - weight).abs() < 1e-15, "{along}");
        }
        // 9.75 of 10 is 0.25 before the start, 0.75 before the middle.
        assert!((range.weight(9.75, 10.0, true) - 0.4).abs() < 1e-15);
        let far = SmoothRange { center: 20.5, ..range };
        assert!((far.weight(9.75, 10.0, true) - 0.4).abs() < 1e-15);
        assert!(SmoothRange::about(0.0, 1.0).is_fine() && !SmoothRange::about(f64::NAN, 1.0).is_fine());
        assert!(!SmoothRange { strength: 0.0, ..range }.is_fine() && !SmoothRange::about(0.0, 0.0).is_fine());
    }
}
