//! Lengths of sides: those of the surface, or stretched where a line leaves what was drawn.

use std::collections::HashMap;

use super::tree::LineTree;
use crate::surface::{HalfEdge, Surface, metric};

/// How sides are measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Kind {
    /// As they are.
    #[default]
    Surface,
    /// Sides of the graph of a potential: the surface lifted by φ = weight · reach · (d / reach)² into a fourth dimension, where d
    /// is the distance from the drawn line.
    Lift,
    /// Sides times 1 + weight · (d / reach)², the mean along the side.
    Conformal,
}

/// Lengths of sides; what is known of vertices is kept until [`Metric::set`] is called again.
#[derive(Debug, Default)]
pub(crate) struct Metric {
    kind: Kind,
    weight: f64,
    reach: f64,
    tree: LineTree,
    distances: HashMap<u32, f64>,
    /// How often it was set.
    count: u64,
}

impl Metric {
    /// Measures sides as they are.
    pub(crate) fn set_surface(&mut self) {
        self.kind = Kind::Surface;
        self.distances.clear();
    }

    /// Measures sides by their distance from a line.
    pub(crate) fn set(&mut self, kind: Kind, weight: f64, reach: f64, line: &LineTree) {
        (self.kind, self.weight, self.reach) = (kind, weight, reach);
        self.tree.copy_from(line);
        self.distances.clear();
        self.count += 1;
    }

    /// A number for how sides are measured: 0 as they are.
    pub(crate) fn version(&self) -> u64 {
        if self.is_surface() { 0 } else { self.count }
    }

    /// Whether sides are as they are.
    pub(crate) fn is_surface(&self) -> bool {
        self.kind == Kind::Surface
    }

    /// Distance of a vertex from the line, in reaches.
    fn distance(&mut self, surface: &Surface, vertex: u32) -> f64 {
        let Self { tree, distances, reach, .. } = self;
        let far = || tree.nearest(surface.positions[vertex as usize], None).map_or(0.0, |near| near.distance / *reach);
        *distances.entry(vertex).or_insert_with(far)
    }

    /// Length of a side.
    #[inline]
    pub(crate) fn length(&mut self, surface: &Surface, h: HalfEdge) -> f64 {
        let length = surface.length(h);
        if self.kind == Kind::Surface {
            return length;
        }
        let [a, b] = [surface.origin(h), surface.target(h)].map(|v| self.distance(surface, v));
        match self.kind {
            Kind::Surface => length,
            Kind::Lift => length.hypot(self.weight * self.reach * (a * a - b * b)),
            Kind::Conformal => length * (1.0 + self.weight * (a * a + a * b + b * b) / 3.0),
        }
    }

    /// Angle of the corner at the origin of `h`.
    pub(crate) fn corner(&mut self, surface: &Surface, h: HalfEdge) -> f64 {
        if self.kind == Kind::Surface {
            return surface.corner_angle(h);
        }
        let [a, b, c] = [h, h.prev(), h.next()].map(|h| self.length(surface, h));
        metric::corner_angle(a, b, c)
    }

    /// Total angle about a vertex.
    pub(crate) fn angle(&mut self, surface: &Surface, vertex: u32) -> f64 {
        if self.kind == Kind::Surface {
            return surface.angle[vertex as usize];
        }
        let first = surface.outgoing[vertex as usize];
        let (mut h, mut sum) = (first, 0.0);
        loop {
            sum += self.corner(surface, h);
            h = surface.counter_clockwise(h);
            if !h.is_some() || h == first {
                return sum;
            }
        }
    }
}
