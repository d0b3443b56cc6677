//! From characters to text.

use std::fmt::Write;

use ron::extensions::Extensions;
use ron::ser::PrettyConfig;
use serde::Serialize;

use super::stored::{
    Degrees, Depth, Power, Seconds, Spot, StoredCharacter, StoredClip, StoredJoin, StoredJoint, StoredKeys, StoredPart,
    StoredTrack, StoredWeights, Stretch, Triangles,
};
use super::{Character, CharacterError, Clip, Keys, Part, WeightSource};

impl Character {
    /// The character as text, which reads back to the same character: the same text for the same character. Angles that no number of degrees
    /// gives just so are off by a rounding.
    ///
    /// The drawing is not in the text; whoever changed it saves it beside (`export_svg` wants it with y down).
    ///
    /// # Errors
    /// [`CharacterError::Fault`] where the text could not be read again.
    pub fn to_ron(&self) -> Result<String, CharacterError> {
        self.check()?;
        let stored = self.stored();
        let mut out = String::from("(\n");
        let _ = writeln!(out, "  version: {},", stored.version);
        let _ = writeln!(out, "  name: {},", line(&stored.name));
        let _ = writeln!(out, "  drawing: {},", line(&stored.drawing));
        let _ = writeln!(out, "  weights: {},", line(&stored.weights));
        list(&mut out, 1, "joints", &stored.joints);
        list(&mut out, 1, "parts", &stored.parts);
        out.push_str("  clips: [\n");
        for clip in &stored.clips {
            let StoredClip { name, duration, loops, tracks } = clip;
            let loops = if *loops { ", loops: true" } else { "" };
            let _ = writeln!(out, "    (name: {}, duration: {}{loops},", line(name), line(duration));
            list(&mut out, 3, "tracks", tracks);
            out.push_str("    ),\n");
        }
        out.push_str("  ],\n)\n");
        Ok(out)
    }

    fn stored(&self) -> StoredCharacter {
        let joints = self.joints.iter().map(|joint| StoredJoint {
            name: joint.name.clone(),
            parent: joint.parent.map(|parent| self.name_of(parent)),
            at: Spot(Spot::flipped(joint.at)),
            tip: joint.tip.map(|tip| Spot(Spot::flipped(tip))),
            angle: Degrees::of_radians(joint.angle),
        });
        StoredCharacter {
            version: Self::VERSION,
            name: self.name.clone(),
            drawing: self.drawing_path.clone(),
            joints: joints.collect(),
            weights: self.stored_weights(&self.weights),
            parts: self.parts.iter().map(|part| self.stored_part(part)).collect(),
            clips: self.clips.iter().map(|clip| self.stored_clip(clip)).collect(),
        }
    }

    fn name_of(&self, joint: usize) -> String {
        self.joints.get(joint).map(|joint| joint.name.clone()).unwrap_or_default()
    }

    fn stored_weights(&self, weights: &WeightSource) -> StoredWeights {
        match weights {
            WeightSource::Shepard { power } => StoredWeights::Shepard { power: Power(*power) },
            WeightSource::Bounded { triangles, outline } => StoredWeights::Bounded {
                triangles: Triangles(*triangles),
                outline: outline.iter().map(|corner| Spot(Spot::flipped(*corner))).collect(),
            },
            WeightSource::Cage { triangles, corners } => StoredWeights::Cage {
                triangles: Triangles(*triangles),
                corners: corners.iter().map(|c| (self.name_of(c.joint), Spot(Spot::flipped(c.at)))).collect(),
            },
        }
    }

    fn stored_part(&self, part: &Part) -> StoredPart {
        let joins = part.joins.iter().map(|join| StoredJoin {
            shape: join.shape.clone(),
            path: u32::try_from(join.path).unwrap_or(u32::MAX),
            anchor: u32::try_from(join.anchor).unwrap_or(u32::MAX),
            kind: join.kind,
        });
        StoredPart {
            name: part.name.clone(),
            shapes: part.shapes.clone(),
            follows: part.follows.iter().map(|joint| self.name_of(*joint)).collect(),
            z: Depth(part.z),
            weights: part.weights.as_ref().map(|weights| self.stored_weights(weights)),
            joins: joins.collect(),
        }
    }

    fn stored_clip(&self, clip: &Clip) -> StoredClip {
        let spots =
            |keys: &[(f64, glam::DVec2)]| keys.iter().map(|k| (Seconds(k.0), Spot(Spot::flipped(k.1)))).collect();
        let tracks = clip.tracks.iter().map(|track| StoredTrack {
            joint: self.name_of(track.joint),
            easing: track.easing,
            keys: match &track.keys {
                Keys::Translation(keys) => StoredKeys::Translation(spots(keys)),
                Keys::Rotation(keys) => {
                    StoredKeys::Rotation(keys.iter().map(|k| (Seconds(k.0), Degrees::of_radians(k.1))).collect())
                }
                Keys::Scale(keys) => StoredKeys::Scale(keys.iter().map(|k| (Seconds(k.0), Stretch(k.1))).collect()),
            },
        });
        StoredClip {
            name: clip.name.clone(),
            duration: Seconds(clip.duration),
            loops: clip.loops,
            tracks: tracks.collect(),
        }
    }
}

/// A value on one line.
fn line(value: &impl Serialize) -> String {
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    let style = PrettyConfig::new().depth_limit(0);
    // Nothing that is stored can fail to be written.
    options.to_string_pretty(value, style).unwrap_or_default()
}

/// A list with a line for each entry.
fn list(out: &mut String, depth: usize, name: &str, entries: &[impl Serialize]) {
    let indent = "  ".repeat(depth);
    let _ = writeln!(out, "{indent}{name}: [");
    for entry in entries {
        let _ = writeln!(out, "{indent}  {},", line(entry));
    }
    let _ = writeln!(out, "{indent}],");
}
