//! Tests of characters across their files.

#[cfg(feature = "weights")]
mod caches;
mod faults;
mod poses;
mod texts;

use super::*;

/// A trunk with a hole, an arm of two bones in one outline, a head, and a guide line that is not painted.
pub(super) const DRAWING: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 200">
  <defs><linearGradient id="g"><stop stop-color="#f00"/><stop offset="1" stop-color="#00f"/></linearGradient></defs>
  <path id="guide" d="M 0 0 L 200 0" fill="none"/>
  <g id="figure">
    <path id="trunk" fill="url(#g)" fill-rule="evenodd" d="M 80 100 C 80 80 120 80 120 100 L 120 160 H 80 z M 95 120 h 10 v 10 h -10 z"/>
    <g id="arm">
      <path id="sleeve" fill="#234" stroke="#111" d="M 120 95 C 140 93 150 93 160 95 C 170 97 190 93 195 97 C 199 101 190 107 160 105 C 150 104.3 140 107 120 105 C 117 103 117 97 120 95 z"/>
      <path id="hand" d="M 195 97 q 10 5 0 8 z"/>
    </g>
    <circle id="head" cx="100" cy="60" r="20"/>
  </g>
</svg>
"##;

pub(super) const TEXT: &str = r#"(
  version: 1,
  name: "doll",
  drawing: "doll.svg",
  weights: Shepard(power: 3),
  joints: [
    (name: "hips", at: (100, 160), tip: (100, 95), angle: 90),
    (name: "fore", parent: "upper", at: (160, 100), tip: (195, 100)),
    (name: "upper", parent: "hips", at: (120, 100), tip: (160, 100), angle: -7.3),
    (name: "neck", parent: "hips", at: (100, 80)),
  ],
  parts: [
    (name: "body", shapes: ["figure"], follows: ["hips"]),
    (name: "arm", shapes: ["arm"], follows: ["fore", "upper"], z: 1.5, joins: [(shape: "sleeve", anchor: 2, kind: Corner)]),
    (name: "head", shapes: ["head"], follows: ["neck"], z: -1),
  ],
  clips: [
    (name: "wave", duration: 2, loops: true, tracks: [
      (joint: "fore", keys: Rotation([(0, 0), (0.5, 40), (1, 10), (1.5, 40.3)])),
      (joint: "neck", easing: Linear, keys: Rotation([(0, -5), (1, 5)])),
      (joint: "hips", keys: Translation([(0, (0, 0)), (1, (0, -4.1))])),
    ]),
    (name: "jump", duration: 0.8, tracks: [
      (joint: "hips", easing: Step, keys: Translation([(0.1, (3, 8)), (0.5, (0, -40))])),
      (joint: "hips", keys: Scale([(0, (1, 1)), (0.8, (1.1, 0.9))])),
    ]),
  ],
)
"#;

pub(super) fn parse(text: &str) -> Result<Character, CharacterError> {
    Character::parse("doll.character.ron", text.as_bytes(), |_| Ok(DRAWING.into()))
}

pub(super) fn doll() -> Character {
    parse(TEXT).unwrap()
}

/// The line, counted from one, in which a text stands for the first time.
pub(super) fn line_of(text: &str, what: &str) -> usize {
    1 + text[..text.find(what).unwrap()].matches('\n').count()
}
