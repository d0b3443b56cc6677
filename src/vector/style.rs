//! How a shape is painted.

use std::sync::Arc;

use glam::{DAffine2, DVec2};

/// A colour in sRGB, without premultiplication; each from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color {
    /// Red.
    pub red: f32,
    /// Green.
    pub green: f32,
    /// Blue.
    pub blue: f32,
    /// 0 transparent, 1 opaque.
    pub alpha: f32,
}

impl Color {
    /// Opaque black.
    pub const BLACK: Self = Self { red: 0.0, green: 0.0, blue: 0.0, alpha: 1.0 };
}

/// What an area or a stroke is painted with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paint {
    /// One colour.
    Color(Color),
    /// A gradient of the drawing.
    Gradient {
        /// Its place in [`Drawing::gradients`](super::Drawing::gradients).
        index: u32,
        /// From the gradient's coordinates to the drawing's.
        to_drawing: DAffine2,
        /// Makes all of it more transparent.
        opacity: f32,
    },
}

/// Which parts of the plane are inside a shape of several or of self-crossing paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FillRule {
    /// Those that the paths wind around.
    #[default]
    NonZero,
    /// Those that they wind around an odd number of times.
    EvenOdd,
}

/// How a stroke ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LineCap {
    /// Where the path ends.
    #[default]
    Butt,
    /// With a half disc.
    Round,
    /// With half a square.
    Square,
}

/// How a stroke goes around a corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LineJoin {
    /// With a point, or bevelled where that would be too long.
    #[default]
    Miter,
    /// With a disc.
    Round,
    /// Cut off.
    Bevel,
}

/// A line along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// What it is painted with.
    pub paint: Paint,
    /// Width, in the drawing's units; under a transform that is no similarity, the mean of its widths.
    pub width: f64,
    /// How it ends.
    pub cap: LineCap,
    /// How it goes around corners.
    pub join: LineJoin,
    /// How many half widths the point at a corner may be long.
    pub miter_limit: f64,
    /// Lengths drawn and left blank in turn; empty for an unbroken line.
    pub dashes: Vec<f64>,
    /// Where in the dashes the path begins.
    pub dash_offset: f64,
}

/// How a shape is painted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Style {
    /// What its inside is painted with, if with anything.
    pub fill: Option<Paint>,
    /// What its inside is.
    pub fill_rule: FillRule,
    /// The line along its paths, if there is one.
    pub stroke: Option<Stroke>,
    /// Opacity of the shape as a whole, those of the groups around included.
    pub opacity: f32,
}

impl Style {
    /// Whether anything is painted.
    pub fn is_visible(&self) -> bool {
        self.opacity > 0.0 && (self.fill.is_some() || self.stroke.is_some())
    }
}

/// A colour of a gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientStop {
    /// Where, from 0 to 1; not smaller than that of the stop before.
    pub offset: f32,
    /// Which colour.
    pub color: Color,
}

/// What a gradient does beyond its ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SpreadMethod {
    /// The last colour goes on.
    #[default]
    Pad,
    /// It turns back.
    Reflect,
    /// It begins anew.
    Repeat,
}

/// How a gradient runs, in its own coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GradientKind {
    /// Along a line.
    Linear {
        /// Where it begins.
        from: DVec2,
        /// Where it ends.
        to: DVec2,
    },
    /// From a circle about the focus to one about the centre.
    Radial {
        /// Centre of the outer circle.
        centre: DVec2,
        /// Its radius.
        radius: f64,
        /// Centre of the inner circle.
        focus: DVec2,
        /// Its radius.
        focus_radius: f64,
    },
}

/// A change of colour over the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// The name that the drawing gives it.
    pub id: Option<String>,
    /// How it runs.
    pub kind: GradientKind,
    /// Its colours; at least one.
    pub stops: Arc<[GradientStop]>,
    /// What it does beyond its ends.
    pub spread: SpreadMethod,
    /// Whether its coordinates are shares of the painted shape's bounds.
    pub of_bounds: bool,
}
