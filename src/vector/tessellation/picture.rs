//! What is painted, without where it is now.

use std::ops::Range;

use glam::{DVec2, Vec2, Vec3};

use super::dash::{Part, dashes};
use super::points::PicturePoints;
use super::shade::Shade;
use crate::vector::{Drawing, FillRule, Gradient, LineCap, LineJoin, SpatialPath, Style, VectorPath};

/// How a [`Picture`] is made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct PictureOptions {
    /// By how much straight edges may miss their curves, in the picture's units; a two-thousandth of its extent if there is none.
    pub tolerance: Option<f32>,
    /// How far each shape lies above the one before, in the picture's units. Zero is right for materials that blend; those that write depth
    /// want a little.
    pub layer: f32,
    /// How long edges may be at most, in the picture's units, for those who bend the picture afterwards; there is no limit if there is none.
    pub spacing: Option<f32>,
    /// The place that lies at the point where the picture is placed on a surface; the middle of its bounds, or what a drawing says, if there is
    /// none.
    pub origin: Option<DVec2>,
}

/// Shapes with their paint, and their paths as they were drawn. It does not change, and is shared by all who show it.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    pub(super) shapes: Vec<PictureShape>,
    pub(super) paths: Vec<PicturePath>,
    rest: Vec<Vec3>,
    /// The plane that spatial shapes are tessellated in.
    pub(super) axes: [Vec3; 2],
    pub(super) tolerance: f32,
    pub(super) layer: f32,
    pub(super) spacing: f32,
    origin: DVec2,
    /// What brings the picture to a size of about a thousand, which the tessellator is made for.
    pub(super) magnified: f32,
}

#[derive(Clone, Debug)]
pub(super) struct PictureShape {
    pub(super) paths: Range<usize>,
    pub(super) fill: Option<(Shade, FillRule)>,
    pub(super) stroke: Option<Pen>,
}

/// A stroke made ready.
#[derive(Clone, Debug)]
pub(super) struct Pen {
    pub(super) shade: Shade,
    pub(super) width: f32,
    pub(super) cap: LineCap,
    pub(super) join: LineJoin,
    pub(super) miter_limit: f32,
    /// Of each path of the shape; none for an unbroken line.
    pub(super) dashes: Vec<Option<Vec<Vec<Part>>>>,
}

#[derive(Clone, Debug)]
pub(super) struct PicturePath {
    pub(super) points: Range<usize>,
    pub(super) closed: bool,
}

impl PicturePath {
    pub(super) fn segment_count(&self) -> usize {
        self.points.len() / 3
    }

    /// The control points of a segment of the path.
    pub(super) fn segment(&self, points: &[Vec3], segment: usize) -> [Vec3; 4] {
        let own = &points[self.points.clone()];
        let at = 3 * segment;
        [own[at], own[at + 1], own[at + 2], if at + 3 < own.len() { own[at + 3] } else { own[0] }]
    }
}

/// A point of a cubic.
pub(super) fn point([a, b, c, d]: [Vec3; 4], t: f32) -> Vec3 {
    let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
    ab.lerp(bc, t).lerp(bc.lerp(cd, t), t)
}

/// Steps in which lengths for dashes are taken.
const DASH_STEPS: usize = 16;

impl Picture {
    /// The picture of a drawing, in its own coordinates.
    pub fn of_drawing(drawing: &Drawing, options: &PictureOptions) -> Self {
        let shapes = drawing.shapes.iter().map(|shape| (shape.paths.as_slice(), &shape.style));
        let origin = options.origin.or_else(|| Some(drawing.centre()));
        Self::planar(shapes, &drawing.gradients, &PictureOptions { origin, ..*options })
    }

    /// The picture of planar shapes, from the bottom up.
    pub fn planar<'a>(
        shapes: impl IntoIterator<Item = (&'a [VectorPath], &'a Style)>,
        gradients: &[Gradient],
        options: &PictureOptions,
    ) -> Self {
        let mut picture = Self { axes: [Vec3::X, Vec3::Y], ..Self::default() };
        for (paths, style) in shapes {
            let first = picture.paths.len();
            for path in paths {
                picture.add(path.points().iter().map(|p| p.as_vec2().extend(0.0)), path.is_closed());
            }
            picture.paint(first, style, gradients);
        }
        picture.finish(options)
    }

    /// The picture of shapes in space. Fills are tessellated as they look against the direction in which all paths together have the largest
    /// area, and strokes are parallel to that plane: right for what is nearly flat.
    pub fn spatial<'a>(
        shapes: impl IntoIterator<Item = (&'a [SpatialPath], &'a Style)>,
        gradients: &[Gradient],
        options: &PictureOptions,
    ) -> Self {
        let mut picture = Self::default();
        let mut painted = Vec::new();
        for (paths, style) in shapes {
            let first = picture.paths.len();
            for path in paths {
                picture.add(path.points().iter().map(|p| p.as_vec3()), path.is_closed());
            }
            painted.push((first..picture.paths.len(), style));
        }
        picture.axes = picture.widest_plane();
        let all = std::mem::take(&mut picture.paths);
        for (range, style) in painted {
            let first = picture.paths.len();
            picture.paths.extend_from_slice(&all[range]);
            picture.paint(first, style, gradients);
        }
        picture.finish(options)
    }

    fn add(&mut self, points: impl Iterator<Item = Vec3>, closed: bool) {
        let first = self.rest.len();
        // What is too large for single precision is nowhere.
        self.rest.extend(points.map(|p| if p.is_finite() { p } else { Vec3::ZERO }));
        self.paths.push(PicturePath { points: first..self.rest.len(), closed });
    }

    /// Makes a shape of the paths from `first` on.
    fn paint(&mut self, first: usize, style: &Style, gradients: &[Gradient]) {
        let paths = first..self.paths.len();
        let shade = |paint| Shade::new(paint, gradients, style.opacity);
        let fill = style.fill.as_ref().map(|paint| (shade(paint), style.fill_rule));
        let stroke = style.stroke.as_ref().filter(|stroke| stroke.width > 0.0 && stroke.width.is_finite());
        let stroke = stroke.map(|stroke| {
            let cut = |path: &PicturePath| dashes(&self.lengths(path), &stroke.dashes, stroke.dash_offset);
            Pen {
                shade: shade(&stroke.paint),
                width: stroke.width as f32,
                cap: stroke.cap,
                join: stroke.join,
                miter_limit: stroke.miter_limit as f32,
                dashes: self.paths[paths.clone()].iter().map(cut).collect(),
            }
        });
        let is_visible = style.opacity > 0.0;
        self.shapes.push(PictureShape {
            paths,
            fill: fill.filter(|_| is_visible),
            stroke: stroke.filter(|_| is_visible),
        });
    }

    /// Lengths of the segments of a path up to parameters in equal steps.
    fn lengths(&self, path: &PicturePath) -> Vec<Vec<f64>> {
        let of_segment = |segment| {
            let control = path.segment(&self.rest, segment);
            let places = (0..=DASH_STEPS).map(|i| point(control, i as f32 / DASH_STEPS as f32));
            let mut before = control[0];
            let far = |length: &mut f64, place: Vec3| {
                *length += f64::from(place.distance(std::mem::replace(&mut before, place)));
                Some(*length)
            };
            places.scan(0.0, far).collect()
        };
        (0..path.segment_count()).map(of_segment).collect()
    }

    /// Two directions at a right angle that span the plane in which the paths have the largest area.
    fn widest_plane(&self) -> [Vec3; 2] {
        let middle = self.rest.iter().sum::<Vec3>() / self.rest.len().max(1) as f32;
        let area = |path: &PicturePath| {
            let own = &self.rest[path.points.clone()];
            let pairs = own.iter().zip(own.iter().cycle().skip(1));
            pairs.map(|(a, b)| (a - middle).cross(b - middle)).sum::<Vec3>()
        };
        let areas: Vec<Vec3> = self.paths.iter().map(area).collect();
        // Loops may turn either way.
        let largest = areas.iter().copied().max_by(|a, b| a.length().total_cmp(&b.length())).unwrap_or(Vec3::Z);
        let sum: Vec3 = areas.iter().map(|area| if area.dot(largest) < 0.0 { -area } else { *area }).sum();
        let normal = sum.try_normalize().unwrap_or(Vec3::Z);
        let normal = if normal.z < 0.0 { -normal } else { normal };
        // The plane's own x is nearest to x, or to y where that stands upright on it.
        let across = (Vec3::X - normal * normal.x).try_normalize().filter(|_| normal.x.abs() < 0.99);
        let across = across.unwrap_or_else(|| (Vec3::Y - normal * normal.y).normalize_or(Vec3::X));
        [across, normal.cross(across)]
    }

    fn finish(mut self, options: &PictureOptions) -> Self {
        let low = self.rest.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let high = self.rest.iter().copied().reduce(Vec3::max).unwrap_or_default();
        let extent = low.distance(high);
        let extent = if extent > 0.0 && extent.is_finite() { extent } else { 1.0 };
        let own = extent / 2000.0;
        let tolerance = options.tolerance.filter(|tolerance| *tolerance > 0.0).unwrap_or(own);
        self.tolerance = tolerance.max(1e-3 * own);
        self.layer = if options.layer.is_finite() { options.layer } else { 0.0 };
        let middle = self.flat(0.5 * (low + high)).as_dvec2();
        self.origin = options.origin.filter(|origin| origin.is_finite()).unwrap_or(middle);
        // Finer than the tolerance makes no sense.
        let spacing = options.spacing.filter(|spacing| *spacing > 0.0).unwrap_or(f32::INFINITY);
        self.spacing = spacing.max(2e-3 * extent);
        self.magnified = 1000.0 / extent;
        self
    }

    /// Number of shapes.
    pub fn shape_count(&self) -> usize {
        self.shapes.len()
    }

    /// Number of paths of all shapes.
    pub fn path_count(&self) -> usize {
        self.paths.len()
    }

    /// Number of cubic segments.
    pub fn segment_count(&self) -> usize {
        self.paths.iter().map(PicturePath::segment_count).sum()
    }

    /// The place that lies at the point where it is placed on a surface.
    pub fn origin(&self) -> DVec2 {
        self.origin
    }

    /// How long edges may be at most, in its units; infinite if there is no limit.
    pub fn spacing(&self) -> f32 {
        self.spacing
    }

    /// The distance between opposite corners of its bounds; 1 of a picture without extent.
    pub fn extent(&self) -> f32 {
        if self.magnified > 0.0 { 1000.0 / self.magnified } else { 1.0 }
    }

    /// The paths of a shape; empty if there is no such shape.
    pub fn paths_of(&self, shape: usize) -> Range<usize> {
        self.shapes.get(shape).map_or(0..0, |shape| shape.paths.clone())
    }

    /// The control points of a path as they were drawn; empty if there is no such path.
    pub fn rest_of(&self, path: usize) -> &[Vec3] {
        self.paths.get(path).map_or(&[], |path| &self.rest[path.points.clone()])
    }

    /// Whether a path is closed.
    pub fn is_closed(&self, path: usize) -> bool {
        self.paths.get(path).is_some_and(|path| path.closed)
    }

    /// The control points as they were drawn, to be moved.
    pub fn points(&self) -> PicturePoints {
        PicturePoints::new(&self.rest, self.paths.iter().map(|path| path.points.clone()).collect())
    }

    pub(super) fn rest(&self) -> &[Vec3] {
        &self.rest
    }

    /// A place in the plane that shapes are tessellated in.
    #[inline]
    pub(super) fn flat(&self, place: Vec3) -> Vec2 {
        Vec2::new(place.dot(self.axes[0]), place.dot(self.axes[1]))
    }

    /// A place in the coordinates of gradients.
    pub(super) fn drawn(&self, place: Vec3) -> DVec2 {
        self.flat(place).as_dvec2()
    }

    /// A vector of that plane in space.
    pub(super) fn lifted(&self, vector: Vec2) -> Vec3 {
        self.axes[0] * vector.x + self.axes[1] * vector.y
    }

    /// How far a shape lies above the drawing.
    pub(super) fn above(&self, shape: usize) -> Vec3 {
        self.axes[0].cross(self.axes[1]) * (self.layer * shape as f32)
    }
}
