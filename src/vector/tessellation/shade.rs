//! The colour of a paint at a place.

use glam::{DAffine2, DVec2};

use crate::vector::{Color, Gradient, GradientKind, GradientStop, Paint, SpreadMethod};

/// A paint made ready to be asked at places; colours are linear, with an alpha that is not premultiplied.
#[derive(Clone, Debug)]
pub(super) enum Shade {
    Plain([f32; 4]),
    Gradient(Box<Ramp>),
}

/// A gradient at a place.
#[derive(Clone, Debug)]
pub(super) struct Ramp {
    to_gradient: DAffine2,
    gradient: Gradient,
    opacity: f32,
}

/// Parts that an edge as long as the whole gradient is divided into.
const PARTS: f64 = 8.0;

impl Shade {
    /// What a paint of a drawing with such gradients is; a gradient that there is not, or that has no extent, is its last colour or nothing.
    pub(super) fn new(paint: &Paint, gradients: &[Gradient], opacity: f32) -> Self {
        match paint {
            Paint::Color(color) => Self::Plain(linear(*color, opacity)),
            Paint::Gradient { index, to_drawing, opacity: own } => {
                let opacity = opacity * own;
                let Some(gradient) = gradients.get(*index as usize) else { return Self::Plain([0.0; 4]) };
                let to_gradient = to_drawing.inverse();
                if to_gradient.is_finite() {
                    let gradient = gradient.clone();
                    return Self::Gradient(Box::new(Ramp { to_gradient, gradient, opacity }));
                }
                Self::Plain(gradient.stops.last().map_or([0.0; 4], |stop| linear(stop.color, opacity)))
            }
        }
    }

    /// The colour at a place of the drawing.
    pub(super) fn at(&self, place: DVec2) -> [f32; 4] {
        match self {
            Self::Plain(color) => *color,
            Self::Gradient(ramp) => {
                let at = spread(ramp.parameter(place), ramp.gradient.spread);
                linear(mixed(&ramp.gradient.stops, at as f32), ramp.opacity)
            }
        }
    }

    /// In how many parts an edge is divided so that its colours come near to the gradient's.
    pub(super) fn parts(&self, edge: DVec2) -> u32 {
        let Self::Gradient(ramp) = self else { return 1 };
        let along = ramp.to_gradient.transform_vector2(edge);
        let share = match ramp.gradient.kind {
            GradientKind::Linear { from, to } => along.dot(to - from).abs() / (to - from).length_squared(),
            GradientKind::Radial { radius, .. } => along.length() / radius,
        };
        // A gradient without extent has one edge, which no division catches.
        if share.is_finite() { (PARTS * share).ceil().clamp(1.0, PARTS) as u32 } else { 1 }
    }
}

impl Ramp {
    /// How far along the gradient a place is: 0 at its beginning, 1 at its end.
    fn parameter(&self, place: DVec2) -> f64 {
        let p = self.to_gradient.transform_point2(place);
        match self.gradient.kind {
            GradientKind::Linear { from, to } => (p - from).dot(to - from) / (to - from).length_squared(),
            GradientKind::Radial { centre, radius, focus, focus_radius } => {
                // The largest t for which p is on the circle about focus + t (centre − focus) with radius f + t (r − f), not negative.
                let (way, from, grows) = (centre - focus, p - focus, radius - focus_radius);
                let (a, b, c) = (
                    way.length_squared() - grows * grows,
                    from.dot(way) + focus_radius * grows,
                    from.length_squared() - focus_radius * focus_radius,
                );
                let root = (b * b - a * c).max(0.0).sqrt();
                let both = if a.abs() > 1e-12 * (b.abs() + c.abs()) {
                    [(b + root) / a, (b - root) / a]
                } else {
                    [c / (2.0 * b); 2]
                };
                let fits = both.into_iter().filter(|t| focus_radius + t * grows >= 0.0);
                fits.fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }
}

/// A place from 0 to 1 for one beyond the gradient's ends.
fn spread(t: f64, method: SpreadMethod) -> f64 {
    let t = if t.is_nan() { 1.0 } else { t };
    match method {
        _ if t.is_infinite() => {
            if t > 0.0 {
                1.0
            } else {
                0.0
            }
        }
        SpreadMethod::Pad => t.clamp(0.0, 1.0),
        SpreadMethod::Repeat => t.rem_euclid(1.0),
        SpreadMethod::Reflect => 1.0 - (t.rem_euclid(2.0) - 1.0).abs(),
    }
}

/// The colour of some stops at a place.
fn mixed(stops: &[GradientStop], at: f32) -> Color {
    let next = stops.partition_point(|stop| stop.offset <= at);
    let (Some(after), Some(before)) = (stops.get(next), next.checked_sub(1).and_then(|i| stops.get(i))) else {
        let end = if next == 0 { stops.first() } else { stops.last() };
        return end.map_or(Color { alpha: 0.0, ..Color::BLACK }, |stop| stop.color);
    };
    let share = (at - before.offset) / (after.offset - before.offset);
    let mix = |a: f32, b: f32| a + (b - a) * share;
    let (a, b) = (before.color, after.color);
    Color {
        red: mix(a.red, b.red),
        green: mix(a.green, b.green),
        blue: mix(a.blue, b.blue),
        alpha: mix(a.alpha, b.alpha),
    }
}

/// A colour without the curve of sRGB (IEC 61966-2-1).
fn linear(color: Color, opacity: f32) -> [f32; 4] {
    let straight = |c: f32| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    [straight(color.red), straight(color.green), straight(color.blue), color.alpha * opacity]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shade(kind: GradientKind, spread: SpreadMethod) -> Shade {
        let stop = |offset, red| GradientStop { offset, color: Color { red, ..Color::BLACK } };
        let gradient =
            Gradient { id: None, kind, stops: [stop(0.0, 0.0), stop(1.0, 1.0)].into(), spread, of_bounds: false };
        let paint = Paint::Gradient { index: 0, to_drawing: DAffine2::from_scale(DVec2::splat(2.0)), opacity: 0.5 };
        Shade::new(&paint, &[gradient], 0.5)
    }

    /// The share of red at a place, as sRGB.
    fn red(shade: &Shade, x: f64, y: f64) -> f32 {
        let [red, _, _, alpha] = shade.at(DVec2::new(x, y));
        assert_eq!(alpha, 0.25);
        if red <= 0.003_130_8 { red * 12.92 } else { 1.055 * red.powf(1.0 / 2.4) - 0.055 }
    }

    #[test]
    fn gradients_run_as_they_say() {
        let line = GradientKind::Linear { from: DVec2::ZERO, to: DVec2::X };
        for (spread, beyond) in [(SpreadMethod::Pad, 1.0), (SpreadMethod::Repeat, 0.25), (SpreadMethod::Reflect, 0.75)]
        {
            let shade = shade(line, spread);
            assert!((red(&shade, 0.5, 9.0) - 0.25).abs() < 1e-5);
            assert!((red(&shade, 2.5, 0.0) - beyond).abs() < 1e-5, "{spread:?}");
        }
        let (centre, focus) = (DVec2::new(1.0, 1.0), DVec2::new(1.0, 1.5));
        for focus in [centre, focus] {
            let shade =
                shade(GradientKind::Radial { centre, radius: 1.0, focus, focus_radius: 0.0 }, SpreadMethod::Pad);
            assert!((red(&shade, 4.0, 2.0) - 1.0).abs() < 1e-5, "the rim is the end");
            assert!(red(&shade, 2.0 * focus.x, 2.0 * focus.y).abs() < 1e-5, "the focus is the beginning");
            assert!((red(&shade, 2.0, 2.0 * focus.y + 0.5 * (4.0 - 2.0 * focus.y)) - 0.5).abs() < 1e-5);
        }
    }

    #[test]
    fn gradients_without_extent_have_a_colour() {
        let nowhere = GradientKind::Linear { from: DVec2::ZERO, to: DVec2::ZERO };
        assert!(red(&shade(nowhere, SpreadMethod::Repeat), 1.0, 1.0) >= 0.0);
        let none = Shade::new(&Paint::Gradient { index: 3, to_drawing: DAffine2::IDENTITY, opacity: 1.0 }, &[], 1.0);
        assert_eq!(none.at(DVec2::ZERO)[3], 0.0);
    }
}
