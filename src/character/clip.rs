//! Clips: how joints move in time.

use glam::DVec2;

use super::{Character, JointPose};

/// A movement of some joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clip {
    /// Its name; no two clips have the same.
    pub name: String,
    /// How long it is, in seconds.
    pub duration: f64,
    /// Whether it begins anew where it ends. The last key of a track leads to its first one then, which is not repeated at the end.
    pub loops: bool,
    /// What moves; no two tracks move the same of a joint. What no track moves stays at rest.
    pub tracks: Vec<Track>,
}

/// What one joint does in a clip.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// The joint.
    pub joint: usize,
    /// How it goes from key to key.
    pub easing: Easing,
    /// What moves, and where it is when.
    pub keys: Keys,
}

/// Values at times in seconds, in ascending order.
#[derive(Clone, Debug, PartialEq)]
pub enum Keys {
    /// How far the joint is from its place at rest, along the axes of its parent, in the drawing's units.
    Translation(Vec<(f64, DVec2)>),
    /// By how much it is turned from its direction at rest, in radians, counter-clockwise.
    Rotation(Vec<(f64, f64)>),
    /// By how much it is stretched along its own axes.
    Scale(Vec<(f64, DVec2)>),
}

/// How values go from key to key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[derive(serde::Serialize, serde::Deserialize)]
pub enum Easing {
    /// They stay until the next key.
    Step,
    /// At one speed.
    Linear,
    /// Smoothly, by cubics that never go beyond the keys (Fritsch and Butland 1984). Values come to rest at the ends of a clip that does not loop.
    #[default]
    Cubic,
}

impl Keys {
    /// Number of keys.
    pub fn len(&self) -> usize {
        match self {
            Self::Translation(keys) | Self::Scale(keys) => keys.len(),
            Self::Rotation(keys) => keys.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The time of a key, if there is such a one.
    pub fn time(&self, key: usize) -> Option<f64> {
        match self {
            Self::Translation(keys) | Self::Scale(keys) => keys.get(key).map(|key| key.0),
            Self::Rotation(keys) => keys.get(key).map(|key| key.0),
        }
    }

    /// What of the joint they move, by its name in files.
    pub fn channel(&self) -> &'static str {
        match self {
            Self::Translation(_) => "translation",
            Self::Rotation(_) => "rotation",
            Self::Scale(_) => "scale",
        }
    }
}

impl Clip {
    /// The time in the clip that a time since its beginning is: between its ends, or around and around if it loops.
    pub fn time_at(&self, time: f64) -> f64 {
        if !(time.is_finite() && self.duration > 0.0) {
            0.0
        } else if self.loops {
            time.rem_euclid(self.duration)
        } else {
            time.clamp(0.0, self.duration)
        }
    }

    /// Moves a joint from where it is at rest to where a track has it at a time since the beginning of the clip.
    pub fn apply(&self, track: &Track, time: f64, pose: &mut JointPose) {
        let (time, easing) = (self.time_at(time), track.easing);
        let period = self.loops.then_some(self.duration);
        match &track.keys {
            Keys::Translation(keys) => pose.translation += along_both(keys, easing, period, time, DVec2::ZERO),
            Keys::Rotation(keys) => pose.rotation += along(keys, |angle| *angle, easing, period, time).unwrap_or(0.0),
            Keys::Scale(keys) => pose.scale *= along_both(keys, easing, period, time, DVec2::ONE),
        }
    }
}

impl Character {
    /// The clip of a name.
    pub fn clip_named(&self, name: &str) -> Option<usize> {
        self.clips.iter().position(|clip| clip.name == name)
    }

    /// Where all joints are in the frames of their parents at a time since the beginning of a clip; at rest if there is no such clip.
    pub fn sample(&self, clip: usize, time: f64, locals: &mut [JointPose]) {
        locals.iter_mut().enumerate().for_each(|(joint, local)| *local = self.rest_pose(joint));
        let Some(clip) = self.clips.get(clip) else { return };
        for track in &clip.tracks {
            if let Some(local) = locals.get_mut(track.joint) {
                clip.apply(track, time, local);
            }
        }
    }
}

fn along_both(keys: &[(f64, DVec2)], easing: Easing, period: Option<f64>, time: f64, none: DVec2) -> DVec2 {
    let x = along(keys, |value| value.x, easing, period, time);
    let y = along(keys, |value| value.y, easing, period, time);
    DVec2::new(x.unwrap_or(none.x), y.unwrap_or(none.y))
}

/// The value at a time; none without keys.
fn along<V>(
    keys: &[(f64, V)],
    number: impl Fn(&V) -> f64,
    easing: Easing,
    period: Option<f64>,
    time: f64,
) -> Option<f64> {
    let count = keys.len() as isize;
    // Keys before the first and behind the last are those of the rounds before and behind.
    let key = |at: isize| {
        let round = at.div_euclid(count.max(1));
        let (time, value) = keys.get(at.rem_euclid(count.max(1)) as usize)?;
        match period {
            Some(period) => Some((time + period * round as f64, number(value))),
            None => (round == 0).then(|| (*time, number(value))),
        }
    };
    let before = keys.partition_point(|(t, _)| *t <= time) as isize - 1;
    let (from, to) = match (key(before), key(before + 1)) {
        (Some(from), Some(to)) => (from, to),
        (one, other) => return one.or(other).map(|key| key.1),
    };
    let length = to.0 - from.0;
    let share = if length > 0.0 { ((time - from.0) / length).clamp(0.0, 1.0) } else { 0.0 };
    let difference = to.1 - from.1;
    Some(match easing {
        Easing::Step => from.1,
        Easing::Linear => from.1 + difference * share,
        Easing::Cubic => {
            let [out, into] =
                [slope(key(before - 1), from, Some(to)) * length, slope(Some(from), to, key(before + 2)) * length];
            let (t, s) = (share, 1.0 - share);
            from.1 + t * t * (3.0 - 2.0 * t) * difference + t * s * (s * out - t * into)
        }
    })
}

/// The slope at a key between others: zero where they are both above or both below, or one of them is missing.
fn slope(before: Option<(f64, f64)>, at: (f64, f64), behind: Option<(f64, f64)>) -> f64 {
    let (Some(before), Some(behind)) = (before, behind) else { return 0.0 };
    let (h, k) = (at.0 - before.0, behind.0 - at.0);
    let (u, v) = ((at.1 - before.1) / h, (behind.1 - at.1) / k);
    // So that neither a difference of signs nor a slope that is no number counts.
    if u * v > 0.0 {
        let (a, b) = (2.0 * k + h, k + 2.0 * h);
        (a + b) / (a / u + b / v)
    } else {
        0.0
    }
}
