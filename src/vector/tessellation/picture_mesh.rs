//! All triangles of a picture in one list.

use std::ops::Range;

use glam::Vec3;

use super::fill::{Fill, FillScratch, Filled};
use super::stroke::{Line, LineScratch};
use super::{Picture, PicturePoints};

/// Memory for tessellating, lent from one picture to another.
#[derive(Debug, Default)]
pub struct Tessellator {
    fill: FillScratch,
    line: LineScratch,
}

/// What an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct PictureChange {
    /// Paths that had moved, each of which was made again.
    pub paths: u32,
    /// Fills that got other triangles.
    pub filled: u32,
    /// Fills that kept their triangles and moved their corners.
    pub kept: u32,
    /// Strokes that were made again.
    pub stroked: u32,
}

impl std::ops::AddAssign for PictureChange {
    fn add_assign(&mut self, other: Self) {
        self.paths += other.paths;
        self.filled += other.filled;
        self.kept += other.kept;
        self.stroked += other.stroked;
    }
}

/// The triangles of a picture: vertices with positions and linear colours, and indices, shape after shape as they are painted, of each its
/// fill and then its stroke.
///
/// The lists are public so that they can be lent to whoever draws them; what was changed in them is made anew when its shape moves.
#[derive(Clone, Debug, Default)]
pub struct PictureMesh {
    /// Positions of vertices.
    pub positions: Vec<[f32; 3]>,
    /// Their colours, linear and not premultiplied.
    pub colors: Vec<[f32; 4]>,
    /// Triangles, counter-clockwise as seen against the picture's normal where fills are concerned.
    pub indices: Vec<u32>,
    shapes: Vec<Painted>,
    /// Of each path, how often it had moved when it was last made.
    seen: Vec<u32>,
    is_made: bool,
}

/// A shape as it was last made.
#[derive(Clone, Debug, Default)]
struct Painted {
    fill: Fill,
    line: Line,
    /// Where its vertices and indices are.
    vertices: Range<usize>,
    indices: Range<usize>,
    bounds: Option<[Vec3; 2]>,
}

impl PictureMesh {
    /// Follows control points: shapes with paths that moved are made again, the first time all. Takes no memory once warm, as long as triangles are
    /// kept; hardly any else.
    pub fn update(
        &mut self,
        picture: &Picture,
        points: &PicturePoints,
        tessellator: &mut Tessellator,
    ) -> PictureChange {
        let mut change = PictureChange::default();
        let whole =
            !self.is_made || self.shapes.len() != picture.shapes.len() || self.seen.len() != points.path_count();
        if whole {
            self.shapes.clear();
            self.shapes.resize_with(picture.shapes.len(), Painted::default);
            self.seen.clear();
            self.seen.resize(points.path_count(), 0);
            self.is_made = true;
        }
        // From here on shapes do not lie where they did.
        let mut shifted = if whole { 0 } else { usize::MAX };
        for (number, (shape, painted)) in picture.shapes.iter().zip(&mut self.shapes).enumerate() {
            let mut moved = 0;
            for (path, seen) in shape.paths.clone().zip(&mut self.seen[shape.paths.clone()]) {
                moved += u32::from(*seen != points.moved(path));
                *seen = points.moved(path);
            }
            if moved == 0 && !whole {
                continue;
            }
            change.paths += if whole { shape.paths.len() as u32 } else { moved };
            let filled = painted.fill.update(picture, shape, points.all(), &mut tessellator.fill);
            if shape.fill.is_some() {
                change.filled += u32::from(filled == Filled::Anew);
                change.kept += u32::from(filled == Filled::Moved);
            }
            painted.line.update(picture, shape, points.all(), &mut tessellator.line);
            change.stroked += u32::from(shape.stroke.is_some());
            let fits = painted.vertex_count() == painted.vertices.len()
                && painted.index_count() == painted.indices.len()
                && self.positions.len() >= painted.vertices.end
                && self.colors.len() >= painted.vertices.end
                && self.indices.len() >= painted.indices.end;
            if !fits {
                shifted = shifted.min(number);
            } else if number < shifted {
                let above = picture.above(number);
                let places = self.positions[painted.vertices.clone()].iter_mut();
                painted.bounds = write_positions(painted.positions(), above, places);
                if filled == Filled::Anew || shape.stroke.is_some() {
                    let colors = self.colors[painted.vertices.clone()].iter_mut();
                    colors.zip(painted.colors()).for_each(|(out, color)| *out = *color);
                    let indices = self.indices[painted.indices.clone()].iter_mut();
                    indices.zip(painted.indices_from(painted.vertices.start)).for_each(|(out, index)| *out = index);
                }
            }
        }
        self.rebuild_from(picture, shifted);
        change
    }

    /// Whether it shows control points as they are, so that an update would do nothing.
    pub fn is_current(&self, points: &PicturePoints) -> bool {
        let paths = self.seen.iter().enumerate();
        self.is_made
            && self.seen.len() == points.path_count()
            && paths.into_iter().all(|(i, seen)| *seen == points.moved(i))
    }

    /// Writes shapes anew from some on, whose places have changed.
    fn rebuild_from(&mut self, picture: &Picture, first: usize) {
        let Some(changed) = self.shapes.get_mut(first..) else { return };
        let (vertex, index) = changed.first().map_or((0, 0), |shape| (shape.vertices.start, shape.indices.start));
        let fits = self.positions.len() >= vertex && self.colors.len() >= vertex && self.indices.len() >= index;
        if !fits && first > 0 {
            return self.rebuild_from(picture, 0);
        }
        self.positions.truncate(vertex);
        self.colors.truncate(vertex);
        self.indices.truncate(index);
        for (number, painted) in (first..).zip(changed) {
            let (vertex, index) = (self.positions.len(), self.indices.len());
            let count = painted.vertex_count();
            self.positions.resize(vertex + count, [0.0; 3]);
            let places = self.positions[vertex..].iter_mut();
            painted.bounds = write_positions(painted.positions(), picture.above(number), places);
            self.colors.extend(painted.colors());
            self.indices.extend(painted.indices_from(vertex));
            painted.vertices = vertex..vertex + count;
            painted.indices = index..self.indices.len();
        }
    }

    /// The smallest and largest coordinates of all vertices; none if there are none.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let all = self.shapes.iter().filter_map(|shape| shape.bounds);
        all.reduce(|[low, high], [l, h]| [low.min(l), high.max(h)])
    }

    /// Where the vertices of a shape are; empty if there is no such shape.
    pub fn vertices_of(&self, shape: usize) -> Range<usize> {
        self.shapes.get(shape).map_or(0..0, |shape| shape.vertices.clone())
    }

    /// Where the indices of a shape are; empty if there is no such shape.
    pub fn indices_of(&self, shape: usize) -> Range<usize> {
        self.shapes.get(shape).map_or(0..0, |shape| shape.indices.clone())
    }

    /// Memory that the lists have taken, in items: it does not grow while a picture moves about.
    pub fn capacity(&self) -> usize {
        let own = self.positions.capacity() + self.colors.capacity() + self.indices.capacity();
        let of_shape = |shape: &Painted| shape.fill.capacity() + shape.line.capacity();
        own + self.shapes.iter().map(of_shape).sum::<usize>()
    }
}

impl Painted {
    fn vertex_count(&self) -> usize {
        self.fill.colors.len() + self.line.positions.len()
    }

    fn index_count(&self) -> usize {
        3 * (self.fill.triangles().len() + self.line.triangles.len())
    }

    fn positions(&self) -> impl Iterator<Item = Vec3> {
        self.fill.positions().take(self.fill.colors.len()).chain(self.line.positions.iter().copied())
    }

    fn colors(&self) -> impl Iterator<Item = &[f32; 4]> {
        self.fill.colors.iter().chain(&self.line.colors)
    }

    fn indices_from(&self, vertex: usize) -> impl Iterator<Item = u32> {
        let (fill, line) = (vertex as u32, (vertex + self.fill.colors.len()) as u32);
        let fills = self.fill.triangles().iter().flatten().map(move |i| fill + i);
        fills.chain(self.line.triangles.iter().flatten().map(move |i| line + i))
    }
}

/// Writes positions, and gives their bounds.
fn write_positions<'a>(
    positions: impl Iterator<Item = Vec3>,
    above: Vec3,
    out: impl Iterator<Item = &'a mut [f32; 3]>,
) -> Option<[Vec3; 2]> {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (position, out) in positions.zip(out) {
        let at = position + above;
        (low, high) = (low.min(at), high.max(at));
        *out = at.to_array();
    }
    (low.x <= high.x).then_some([low, high])
}
