//! A character as its file holds it: joints by their names, y down, degrees.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::Easing;
use crate::skin::JoinKind;

/// Coordinates of places.
pub(super) const FARTHEST: f64 = 1e9;
/// Angles, in degrees: some thousand turns.
pub(super) const MOST_DEGREES: f64 = 1e6;
/// Stretches.
pub(super) const MOST_SCALE: f64 = 1e3;
/// Times, in seconds: a day.
pub(super) const LONGEST: f64 = 86_400.0;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredCharacter {
    pub(super) version: u32,
    pub(super) name: String,
    pub(super) drawing: String,
    pub(super) joints: Vec<StoredJoint>,
    #[serde(default)]
    pub(super) weights: StoredWeights,
    pub(super) parts: Vec<StoredPart>,
    #[serde(default)]
    pub(super) clips: Vec<StoredClip>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredJoint {
    pub(super) name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) parent: Option<String>,
    pub(super) at: Spot,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) tip: Option<Spot>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) angle: Degrees,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) enum StoredWeights {
    Shepard {
        #[serde(default)]
        power: Power,
    },
    Bounded {
        #[serde(default)]
        triangles: Triangles,
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        outline: Vec<Spot>,
    },
    Cage {
        #[serde(default)]
        triangles: Triangles,
        corners: Vec<(String, Spot)>,
    },
}

impl Default for StoredWeights {
    fn default() -> Self {
        Self::Shepard { power: Power::default() }
    }
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredPart {
    pub(super) name: String,
    pub(super) shapes: Vec<String>,
    pub(super) follows: Vec<String>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) z: Depth,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) weights: Option<StoredWeights>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) joins: Vec<StoredJoin>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredJoin {
    pub(super) shape: String,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) path: u32,
    pub(super) anchor: u32,
    pub(super) kind: JoinKind,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredClip {
    pub(super) name: String,
    pub(super) duration: Seconds,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) loops: bool,
    pub(super) tracks: Vec<StoredTrack>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredTrack {
    pub(super) joint: String,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) easing: Easing,
    pub(super) keys: StoredKeys,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum StoredKeys {
    Translation(Vec<(Seconds, Spot)>),
    Rotation(Vec<(Seconds, Degrees)>),
    Scale(Vec<(Seconds, Stretch)>),
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Numbers in a range, which is checked while they are read, where line and column are known.
macro_rules! ranged {
    ($(#[$doc:meta])* $name:ident($number:ty), $least:expr, $most:expr, $default:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(try_from = "Number", into = "Number")]
        pub(super) struct $name(pub(super) $number);

        impl Default for $name {
            fn default() -> Self {
                Self($default)
            }
        }

        impl From<$name> for Number {
            fn from(value: $name) -> Self {
                Self(f64::from(value.0))
            }
        }

        impl TryFrom<Number> for $name {
            type Error = String;

            fn try_from(Number(x): Number) -> Result<Self, String> {
                Ok(Self(within(x, $least, $most)? as $number))
            }
        }
    };
}

/// Any number.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(transparent)]
struct Number(f64);

ranged!(
    /// An angle, counter-clockwise.
    Degrees(f64), -1.02 * MOST_DEGREES, 1.02 * MOST_DEGREES, 0.0
);
ranged!(
    /// A time.
    Seconds(f64), 0.0, LONGEST, 0.0
);
ranged!(
    /// An order of painting.
    Depth(f64), -FARTHEST, FARTHEST, 0.0
);
ranged!(
    /// The power of a distance.
    Power(f64), 1.0, 8.0, 4.0
);

/// A number of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct Triangles(pub(super) u32);

impl Default for Triangles {
    fn default() -> Self {
        Self(1_000)
    }
}

/// A place in the drawing, or a way; y goes down.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "(f64, f64)", into = "(f64, f64)")]
pub(super) struct Spot(pub(super) DVec2);

impl From<Spot> for (f64, f64) {
    fn from(Spot(place): Spot) -> Self {
        place.into()
    }
}

impl TryFrom<(f64, f64)> for Spot {
    type Error = String;

    fn try_from((x, y): (f64, f64)) -> Result<Self, String> {
        Ok(Self(DVec2::new(within(x, -FARTHEST, FARTHEST)?, within(y, -FARTHEST, FARTHEST)?)))
    }
}

impl Spot {
    /// With y up, or from y up. Twice is once, but for the sign of zero.
    pub(super) fn flipped(place: DVec2) -> DVec2 {
        DVec2::new(place.x, 0.0 - place.y)
    }
}

/// Factors along both axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "(f64, f64)", into = "(f64, f64)")]
pub(super) struct Stretch(pub(super) DVec2);

impl From<Stretch> for (f64, f64) {
    fn from(Stretch(by): Stretch) -> Self {
        by.into()
    }
}

impl TryFrom<(f64, f64)> for Stretch {
    type Error = String;

    fn try_from((x, y): (f64, f64)) -> Result<Self, String> {
        Ok(Self(DVec2::new(within(x, -MOST_SCALE, MOST_SCALE)?, within(y, -MOST_SCALE, MOST_SCALE)?)))
    }
}

fn within(x: f64, least: f64, most: f64) -> Result<f64, String> {
    let fits = (least..=most).contains(&x);
    fits.then_some(x).ok_or_else(|| format!("{x:?} is not a number from {least:?} to {most:?}"))
}

impl Degrees {
    /// The degrees that are read as so many radians, of those the ones with the fewest digits; the nearest where none are read as just that.
    pub(super) fn of_radians(radians: f64) -> Self {
        let nearest = radians.to_degrees();
        let near = |digits: usize| format!("{nearest:.digits$e}").parse::<f64>().unwrap_or(nearest);
        // Rounding may have led to a neighbour.
        let beside = [nearest.next_down(), nearest.next_up()];
        let mut tried = (0..17).map(near).chain(beside);
        Self(tried.find(|degrees| degrees.to_radians() == radians).unwrap_or(nearest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_come_back_with_the_digits_that_they_had() {
        for tenths in -7200..=7200_i32 {
            let degrees = f64::from(tenths) / 10.0;
            assert_eq!(Degrees::of_radians(degrees.to_radians()).0, degrees);
        }
        // Any radians that can be read are written as what is read as them.
        let mut x = 0.1_f64;
        for _ in 0..10_000 {
            x = (x * 1.7 + 0.123).rem_euclid(400.0);
            let radians = x.to_radians();
            assert_eq!(Degrees::of_radians(radians).0.to_radians(), radians);
        }
    }
}
