//! Checks pictures: whether a curve is where its trace, projected, says it is.

use std::path::Path;

use bevy::prelude::*;
use bevy_surface_splines::editor::colors;
use bevy_surface_splines::editor::marks::Marks;

/// How near the curve's colour must be, in pixels.
const NEAR: i32 = 3;
/// How near a pixel must come to the curve's colour, of 255 in each channel.
const SAME_COLOR: u8 = 28;
/// The share of places on the line where it must be seen.
const ENOUGH: f32 = 0.9;
/// Places this near to each other, in pixels, are checked.
const STEP: f32 = 2.0;
/// Fewer places than this prove nothing.
const FEWEST: usize = 20;

/// A picture, and where the curve must be seen on it.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    pub(crate) image: Option<Image>,
    pub(crate) line: Vec<Vec2>,
}

/// The pixels of a line on a surface that nothing covers: neither the surface itself, nor panels, nor marks.
pub(crate) fn visible_line(marks: &Marks, on: Entity, positions: impl Iterator<Item = Vec3>, free: Rect) -> Vec<Vec2> {
    let covers = marks.all();
    let covered = |at: Vec2| covers.iter().any(|mark| mark.at.distance(at) < mark.radius() + NEAR as f32 + 1.0);
    let seen = |at: Vec2, position: Vec3| free.contains(at) && !covered(at) && marks.is_visible(on, position);
    let mut line = Vec::new();
    let mut before: Option<(Vec3, Vec2)> = None;
    for position in positions {
        let Some(at) = marks.pixel(position) else {
            before = None;
            continue;
        };
        let (from_position, from) = before.unwrap_or((position, at));
        let steps = (from.distance(at) / STEP).ceil().clamp(1.0, 1e4) as u32;
        for step in 1..=steps {
            let share = step as f32 / steps as f32;
            let between = from_position.lerp(position, share);
            let pixel = marks.pixel(between).filter(|pixel| seen(*pixel, between));
            if let Some(pixel) = pixel.filter(|p| line.last().is_none_or(|last: &Vec2| last.distance(*p) >= 0.5 * STEP))
            {
                line.push(pixel);
            }
        }
        before = Some((position, at));
    }
    line
}

/// The share of places on the line near which the picture has the colour of the selected curve.
pub(crate) fn share_of_line_found(picture: &Picture) -> Result<f32, String> {
    let image = picture.image.clone().ok_or("it was not taken")?;
    let pixels = image.try_into_dynamic().map_err(|error| error.to_string())?.to_rgba8();
    if picture.line.len() < FEWEST {
        return Err(format!("only {} places of the curve can be seen", picture.line.len()));
    }
    let wanted = colors::ACCENT.to_srgba().to_u8_array();
    let has_color = |x: i32, y: i32| {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return false };
        let Some(pixel) = pixels.get_pixel_checked(x, y) else { return false };
        (0..3).all(|channel| pixel.0[channel].abs_diff(wanted[channel]) <= SAME_COLOR)
    };
    let found = |at: &&Vec2| {
        let near = |x: i32, y: i32| (Vec2::new(x as f32, y as f32) + 0.5).distance(**at) <= NEAR as f32;
        let (x, y) = (at.x.floor() as i32, at.y.floor() as i32);
        (x - NEAR..=x + NEAR).any(|x| (y - NEAR..=y + NEAR).any(|y| near(x, y) && has_color(x, y)))
    };
    let share = picture.line.iter().filter(found).count() as f32 / picture.line.len() as f32;
    if share < ENOUGH {
        return Err(format!(
            "the curve is seen within {NEAR} px of its projected trace at {:.1} % of {} places, and {:.0} % are needed",
            100.0 * share,
            picture.line.len(),
            100.0 * ENOUGH
        ));
    }
    Ok(share)
}

/// How far apart two lines are where they are farthest, in pixels.
pub(crate) fn farthest_apart(line: &[Vec2], other: &[Vec2]) -> f32 {
    let farthest = |from: &[Vec2], to: &[Vec2]| from.iter().map(|at| distance_to(*at, to)).fold(0.0, f32::max);
    farthest(line, other).max(farthest(other, line))
}

/// Distance from a place to the nearest of others; none is nowhere.
pub(crate) fn distance_to(at: Vec2, others: &[Vec2]) -> f32 {
    others.iter().map(|other| other.distance(at)).fold(f32::INFINITY, f32::min)
}

/// A PNG that is written to its end ends with an empty chunk of this name.
pub(crate) fn require_whole_png(path: &Path) -> Result<(), String> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let end = bytes.len().checked_sub(8).and_then(|end| bytes.get(end..end + 4));
    let whole = bytes.starts_with(b"\x89PNG") && end == Some(b"IEND");
    if whole { Ok(()) } else { Err(format!("{} is not a whole picture", path.display())) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::asset::RenderAssetUsages;
    use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

    /// A grey picture of 64 × 64 with a horizontal line of the accent colour at half height.
    fn picture(line: Vec<Vec2>) -> Picture {
        let size = Extent3d { width: 64, height: 64, depth_or_array_layers: 1 };
        let accent = colors::ACCENT.to_srgba().to_u8_array();
        let pixel = |i: u32| if i / 64 == 32 { accent } else { [90, 90, 90, 255] };
        let bytes = (0..64 * 64).flat_map(pixel).collect();
        let format = TextureFormat::Rgba8UnormSrgb;
        let image = Image::new(size, TextureDimension::D2, bytes, format, RenderAssetUsages::default());
        Picture { image: Some(image), line }
    }

    fn line_at(y: f32) -> Vec<Vec2> {
        (4..60).map(|x| Vec2::new(x as f32, y)).collect()
    }

    #[test]
    fn a_line_is_found_where_it_is_and_nowhere_else() {
        assert_eq!(share_of_line_found(&picture(line_at(32.5))), Ok(1.0));
        assert_eq!(share_of_line_found(&picture(line_at(35.0))), Ok(1.0));
        assert!(share_of_line_found(&picture(line_at(37.0))).is_err());
        assert!(share_of_line_found(&picture(Vec::new())).is_err());
        assert!(share_of_line_found(&Picture { image: None, line: line_at(32.5) }).is_err());
    }

    #[test]
    fn lines_are_as_far_apart_as_their_farthest_place() {
        assert_eq!(farthest_apart(&line_at(10.0), &line_at(13.0)), 3.0);
        let half = line_at(10.0).into_iter().filter(|at| at.x < 30.0).collect::<Vec<_>>();
        assert_eq!(farthest_apart(&line_at(10.0), &half), 30.0);
    }
}
