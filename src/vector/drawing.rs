//! A drawing: shapes with their styles.

use glam::DVec2;

use super::{Gradient, Style, VectorPath};

/// A rectangle that says which part of the plane a drawing is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewBox {
    /// The corner with the smallest coordinates.
    pub min: DVec2,
    /// Width and height.
    pub size: DVec2,
}

impl ViewBox {
    /// Its centre.
    pub fn centre(&self) -> DVec2 {
        self.min + 0.5 * self.size
    }
}

/// A planar drawing: shapes in the order in which they are painted.
///
/// Coordinates are those of SVG: x to the right, y down, in the units of the view box.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// What the drawing is about, where it says so.
    pub view_box: Option<ViewBox>,
    /// What is painted, from the bottom up.
    pub shapes: Vec<Shape>,
    /// The gradients that paints name by their place.
    pub gradients: Vec<Gradient>,
    /// The groups that shapes name by their place, those that have a name.
    pub groups: Vec<Group>,
}

/// A named group of shapes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Its name.
    pub id: String,
    /// The named group that it lies in, always one with a smaller number.
    pub parent: Option<u32>,
}

/// One or more paths that are painted together: a path inside another may be a hole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// The name that the drawing gives it.
    pub id: Option<String>,
    /// The innermost named group that it lies in.
    pub group: Option<u32>,
    /// What it was made from: `path`, `rect`, …
    pub element: String,
    /// Its paths.
    pub paths: Vec<VectorPath>,
    /// How it is painted.
    pub style: Style,
}

impl Drawing {
    /// All paths in order, each with the place of its shape.
    pub fn paths(&self) -> impl Iterator<Item = (usize, &VectorPath)> {
        self.shapes.iter().enumerate().flat_map(|(i, shape)| shape.paths.iter().map(move |path| (i, path)))
    }

    /// The named groups about a shape with their numbers, from the inside out.
    pub fn groups_of(&self, shape: &Shape) -> impl Iterator<Item = (u32, &Group)> {
        let known = |number: u32| self.groups.get(number as usize).map(|group| (number, group));
        let around = move |inner: &(u32, &Group)| inner.1.parent.filter(|outer| *outer < inner.0).and_then(known);
        std::iter::successors(shape.group.and_then(known), around)
    }

    /// Number of cubic segments.
    pub fn segment_count(&self) -> usize {
        self.paths().map(|(_, path)| path.segment_count()).sum()
    }

    /// Smallest and largest coordinates of all control points; none of an empty drawing.
    pub fn bounds(&self) -> Option<(DVec2, DVec2)> {
        let all = self.paths().filter_map(|(_, path)| path.bounds());
        all.reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))
    }

    /// Where a drawing is held when it is placed: the centre of its view box, or of its bounds where it has none.
    pub fn centre(&self) -> DVec2 {
        let bounds = || self.bounds().map_or(DVec2::ZERO, |(low, high)| 0.5 * (low + high));
        self.view_box.map_or_else(bounds, |view| view.centre())
    }
}
