//! Colours of curves, and how states change them.

use bevy::prelude::*;

/// Selected curves and marks; nothing else has this colour.
pub const ACCENT: Color = Color::srgb(1.0, 0.56, 0.08);
/// Curves that are not selected, in turn: dark enough to stand out on the clay.
pub const CURVES: [Color; 5] = [
    Color::srgb(0.0, 0.48, 0.46),
    Color::srgb(0.72, 0.12, 0.45),
    Color::srgb(0.22, 0.5, 0.06),
    Color::srgb(0.16, 0.28, 0.85),
    Color::srgb(0.58, 0.42, 0.02),
];
/// Where a line turns to the left, and to the right, as seen from outside.
pub const LEFT: Color = Color::srgb(0.95, 0.2, 0.25);
/// Where it turns to the right.
pub const RIGHT: Color = Color::srgb(0.2, 0.45, 1.0);
/// A leg that stays on its side and is not the shortest any more.
pub const STICKY: Color = Color::srgb(0.98, 0.78, 0.16);
/// Things behind the model keep this share of their opacity.
pub const BEHIND: f32 = 0.25;
/// Marks behind the model keep this share of theirs when they can be grabbed.
pub const SEE_THROUGH: f32 = 0.7;
/// Curves that are being traced keep this share of theirs.
pub const PREVIEW: f32 = 0.5;
/// How far things under the pointer go towards white.
pub const HOVER: f32 = 0.45;

/// The colour of something under the pointer.
pub fn hovered(color: Color) -> Color {
    color.mix(&Color::WHITE, HOVER)
}
