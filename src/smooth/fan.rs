//! The faces about a vertex that a line passes, laid flat around it.

use std::f64::consts::PI;

use glam::DVec2;

use super::{
    layout::Layout,
    metric::Metric,
    strip::{Run, Strip},
};
use crate::surface::{HalfEdge, Surface};

/// Polar coordinates about the vertex of a run: the point before lies at angle 0.
#[derive(Debug, Default)]
pub(crate) struct Fan {
    /// Distances of the points before and after from the vertex.
    pub(crate) radii: [f64; 2],
    /// Angle of each crossed side.
    pub(crate) spokes: Vec<f64>,
    /// Angle of the point after.
    pub(crate) angle: f64,
}

impl Fan {
    /// Lays a run's faces flat.
    pub(crate) fn unfold(&mut self, surface: &Surface, metric: &mut Metric, strip: &Strip, layout: &Layout, run: &Run) {
        self.spokes.clear();
        let [before, after] = arms(strip, layout, run);
        self.radii = [before.1, after.1];
        let mut angle = before.0;
        self.spokes.push(angle);
        for h in &strip.sides[run.first..run.last] {
            angle += metric.corner(surface, behind(surface, *h, run.left));
            self.spokes.push(angle);
        }
        self.angle = angle + after.0;
    }

    /// The same points, seen over the other faces about the vertex: through the sides of `fan`.
    pub(crate) fn unfold_other(
        &mut self,
        surface: &Surface,
        metric: &mut Metric,
        strip: &Strip,
        layout: &Layout,
        run: &Run,
        sides: &[HalfEdge],
    ) {
        self.spokes.clear();
        let [before, after] = arms(strip, layout, run);
        self.radii = [before.1, after.1];
        // From the point before on to the first of the other sides: what its face has left.
        let first = strip.sides[run.first];
        let own = if run.left { first.next() } else { first };
        let mut angle = metric.corner(surface, own) - before.0;
        for (k, h) in sides.iter().enumerate() {
            if k > 0 {
                angle += metric.corner(surface, behind(surface, sides[k - 1], !run.left));
            }
            let _ = h;
            self.spokes.push(angle);
        }
        let last = strip.sides[run.last];
        self.angle = angle + metric.corner(surface, behind(surface, last, run.left)) - after.0;
    }

    /// Where the straight line between the points crosses spoke `k`: distance from the vertex. Only if the angle is below π.
    pub(crate) fn chord(&self, k: usize) -> f64 {
        let [p, q] = self.radii;
        let here = self.spokes[k];
        let across = p * here.sin() + q * (self.angle - here).sin();
        if across > 0.0 { p * q * self.angle.sin() / across } else { 0.0 }
    }

    /// By how much the line bends about the vertex when it runs through it.
    pub(crate) fn turn(&self) -> f64 {
        self.angle - PI
    }
}

/// The half-edge out of the vertex in the face that a crossed side leads into.
fn behind(surface: &Surface, h: HalfEdge, left: bool) -> HalfEdge {
    let twin = surface.twin(h);
    if left { twin } else { twin.next() }
}

/// Angle from the first side to the point before, and from the last side to the point after, each with its distance.
fn arms(strip: &Strip, layout: &Layout, run: &Run) -> [(f64, f64); 2] {
    let end = if run.left { 1.0 } else { 0.0 };
    let n = strip.len();
    let (leg, next) = (&layout.legs[run.first], layout.after(run.last));
    let from = match run.first.checked_sub(1) {
        Some(before) => strip.at[before],
        None if strip.closed => strip.at[n - 1],
        None => 0.0,
    };
    let back = DVec2::new(0.0, from * leg.enter) - leg.offset - end * leg.leave;
    let spoke = if run.left { -leg.leave } else { leg.leave };
    let length = layout.lengths[run.last];
    let vertex = DVec2::new(0.0, end * length);
    let to = strip.at.get(next).copied().unwrap_or(0.0);
    let ahead = layout.legs[next].offset + to * layout.legs[next].leave - vertex;
    let down = DVec2::new(0.0, 1.0 - 2.0 * end);
    let between = |a: DVec2, b: DVec2| a.perp_dot(b).abs().atan2(a.dot(b));
    [(between(spoke, back), back.length()), (between(down, ahead), ahead.length())]
}
