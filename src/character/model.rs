//! The character itself.

use super::{Clip, Joint, Part, WeightSource};
use crate::vector::Drawing;

/// A drawing, the joints that move it, and clips.
///
/// ```
/// use bevy_surface_splines::character::{BindProgress, Character};
///
/// let text = r#"(version: 1, name: "worm", drawing: "worm.svg",
///   joints: [(name: "tail", at: (0, 0), tip: (50, 0)), (name: "head", parent: "tail", at: (50, 0), tip: (100, 0))],
///   parts: [(name: "body", shapes: ["skin"], follows: ["tail", "head"])],
///   clips: [(name: "nod", duration: 1, loops: true, tracks: [(joint: "head", keys: Rotation([(0, 0), (0.5, 30)]))])],
/// )"#;
/// let drawing = r#"<svg xmlns="http://www.w3.org/2000/svg"><path id="skin" d="M 0 -5 C 30 -5 70 -5 100 -5 V 5 H 0 z"/></svg>"#;
/// let worm = Character::parse("worm.character.ron", text.as_bytes(), |_| Ok(drawing.into()))?;
///
/// let bound = worm.bind(&BindProgress::default())?;
/// let (mut locals, mut worlds, mut posed) = (worm.rest_poses(), Vec::new(), bound.skin.at_rest());
/// worm.sample(0, 0.5, &mut locals);
/// worm.worlds(&locals, &mut worlds);
/// bound.pose(&worlds, &mut posed)?;
/// let end = bound.skin.points(&posed, 0).nth(3).unwrap();
/// assert!(end.y > 20.0); // y goes up
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Character {
    /// Its name for people.
    pub name: String,
    /// Where the drawing lies, seen from the character's file, with `/` between folders.
    pub drawing_path: String,
    /// The drawing, with y up.
    pub drawing: Drawing,
    /// What moves it, parents before children.
    pub joints: Vec<Joint>,
    /// Which joints its shapes follow.
    pub parts: Vec<Part>,
    /// Where the weights of parts come from that say nothing else.
    pub weights: WeightSource,
    /// How it moves.
    pub clips: Vec<Clip>,
}

impl Character {
    /// The version of the format that is written, and the newest that is read.
    pub const VERSION: u32 = 1;
    /// How files of characters end.
    pub const EXTENSION: &str = "character.ron";
    /// How many joints there may be.
    pub const MOST_JOINTS: usize = 512;
    /// How many keys there may be, those of all clips together.
    pub const MOST_KEYS: usize = 100_000;
}
