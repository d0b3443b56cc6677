//! How smooth a line is, and how far from another.

use glam::DVec3;

use super::{
    fan::Fan,
    layout::Layout,
    metric::Metric,
    nodes::{self, Node},
    strip::Strip,
    tree::LineTree,
};
use crate::surface::{InnerPoint, Surface, SurfacePoint};

/// Turns below this are straight when inflections are counted.
const STRAIGHT: f64 = 1e-4;
/// Turns less than this apart, in mean edges, count as one where curvature is measured.
const APART: f64 = 0.05;
/// How often a stretch is halved to see whether it stays within a distance.
const HALVINGS: u32 = 14;
/// Samples of a stretch, at most.
const MOST_SAMPLES: f64 = 64.0;

/// How smooth a line on a surface is, and how far it runs from the line it was made of.
///
/// Turns are angles in radians, positive to the left. A line turns where it crosses sides, by its geodesic curvature
/// integrated there; at a vertex turns are shares of its total angle, and a vertex on the boundary has none
/// (Polthier & Schmies 1998).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct LineMetrics {
    /// Length, in local units.
    pub length: f64,
    /// Sum of all turns' sizes: total geodesic curvature, in radians.
    pub total_turn: f64,
    /// Largest geodesic curvature: a turn over the mean length of the stretches beside it, one over local units. Turns less than a
    /// twentieth of a mean edge apart count as one.
    pub max_curvature: f64,
    /// Squared geodesic curvature integrated along the line, one over local units; likewise.
    pub square_curvature: f64,
    /// Sum of the differences between neighbouring turns: how much the line trembles, in radians.
    pub variation: f64,
    /// How often it begins to turn to the other side.
    pub inflections: u32,
    /// Largest distance, through space, of a place of the line from the line it was made of.
    pub max_distance: f64,
    /// Mean distance of its places.
    pub mean_distance: f64,
    /// Largest distance of a place of the line it was made of from it: what was left out, a loop for one.
    pub max_missed: f64,
}

impl LineMetrics {
    /// Squared geodesic curvature, the mean along the line: one over squared local units.
    pub fn mean_square_curvature(&self) -> f64 {
        if self.length > 0.0 { self.square_curvature / self.length } else { 0.0 }
    }
}

/// A place where a line bends: for a plot of the curvature along it, or to colour it by.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct LineBend {
    /// Length of the line up to there, in local units.
    pub distance: f64,
    /// Where on the surface.
    pub point: SurfacePoint,
    /// By what angle it turns there, in radians, positive to the left.
    pub turn: f64,
    /// The geodesic curvature: the turn over the mean length of the stretches beside it.
    pub curvature: f64,
}

/// Nodes in a row that count as one.
struct Bend {
    first: usize,
    turn: f64,
    width: f64,
}

/// Scratch memory of measuring.
#[derive(Debug, Default)]
pub(crate) struct Gauge {
    metric: Metric,
    layout: Layout,
    fan: Fan,
    nodes: Vec<Node>,
    positions: Vec<DVec3>,
    tree: LineTree,
}

impl Gauge {
    /// Measures a line, and its distance from another, if one is given.
    pub(crate) fn measure(
        &mut self,
        surface: &Surface,
        strip: &Strip,
        from: Option<&LineTree>,
        mean_edge: f64,
    ) -> LineMetrics {
        self.find_nodes(surface, strip);
        let mut found = LineMetrics { length: strip.length(surface), ..LineMetrics::default() };
        self.turns(strip, &mut found);
        self.curvature(strip, mean_edge, &mut found);
        if let Some(from) = from {
            strip.positions_into(surface, &mut self.positions);
            let (there, mean) = apart(&self.positions, from, mean_edge);
            self.tree.build(&self.positions);
            let back = farthest(from.points(), &self.tree);
            (found.max_distance, found.mean_distance, found.max_missed) = (there, mean, back);
        }
        found
    }

    /// Sum of all turns' sizes alone.
    pub(crate) fn total_turn(&mut self, surface: &Surface, strip: &Strip) -> f64 {
        self.find_nodes(surface, strip);
        self.nodes.iter().fold(0.0, |sum, node| sum + node.bend.abs())
    }

    /// Curvature of what is too near together to be told apart: crossings that gather at a vertex turn as one.
    fn curvature(&self, strip: &Strip, mean_edge: f64, found: &mut LineMetrics) {
        self.bends(strip, mean_edge, |bend| {
            found.max_curvature = found.max_curvature.max(bend.turn.abs() / bend.width);
            found.square_curvature += bend.turn * bend.turn / bend.width;
        });
    }

    fn bends(&self, strip: &Strip, mean_edge: f64, mut visit: impl FnMut(Bend)) {
        let length = |j: usize| self.layout.stretch(j, &strip.at).length();
        let (Some(first), Some(last)) = (self.nodes.first(), self.nodes.last()) else { return };
        let mut before = length(first.first);
        let (mut turn, mut inside, mut begin) = (0.0, 0.0, first.first);
        for node in &self.nodes {
            turn += node.bend;
            let after = length(self.layout.after(node.last));
            if after < APART * mean_edge && node.last != last.last {
                inside += after;
                continue;
            }
            let width = (0.5 * (before + after) + inside).max(0.5 * APART * mean_edge);
            visit(Bend { first: begin, turn, width });
            (before, turn, inside, begin) = (after, 0.0, 0.0, node.last + 1);
        }
    }

    /// Fills in where a line bends, in order.
    pub(crate) fn bends_into(&mut self, surface: &Surface, strip: &Strip, mean_edge: f64, out: &mut Vec<LineBend>) {
        self.find_nodes(surface, strip);
        let whole = strip.length(surface);
        out.clear();
        self.bends(strip, mean_edge, |bend| {
            let distance = whole * strip.along.get(bend.first).copied().unwrap_or(1.0);
            let at = strip.sides.get(bend.first).zip(strip.at.get(bend.first));
            let point = at.map_or(strip.start, |(h, at)| InnerPoint::on_side(*h, *at));
            let point = surface.outer_point(&point);
            out.push(LineBend { distance, point, turn: bend.turn, curvature: bend.turn / bend.width });
        });
    }

    fn find_nodes(&mut self, surface: &Surface, strip: &Strip) {
        self.metric.set_surface();
        self.layout.build(surface, &mut self.metric, strip);
        nodes::find(surface, &mut self.metric, strip, &self.layout, &mut self.fan, &mut self.nodes);
    }

    fn turns(&self, strip: &Strip, found: &mut LineMetrics) {
        let (mut before, mut side) = (None::<f64>, 0.0);
        let mut first = None;
        for node in &self.nodes {
            let turn = node.bend;
            found.total_turn += turn.abs();
            found.variation += before.map_or(0.0, |before| (turn - before).abs());
            before = Some(turn);
            first = first.or(before);
            if turn.abs() > STRAIGHT {
                found.inflections += u32::from(side * turn < 0.0);
                side = turn.signum();
            }
        }
        if let (true, Some(first), Some(last)) = (strip.closed, first, before) {
            found.variation += (first - last).abs();
        }
    }
}

/// Largest and mean distance of a line's places from another line: ends of stretches, and samples at most half an edge apart.
pub(crate) fn apart(points: &[DVec3], from: &LineTree, mean_edge: f64) -> (f64, f64) {
    let (mut largest, mut sum, mut length) = (0.0_f64, 0.0, 0.0);
    let mut hint = None;
    let mut distance = |p: DVec3| {
        let near = from.nearest(p, hint);
        hint = near.map(|near| near.stretch);
        near.map_or(0.0, |near| near.distance)
    };
    let mut before = points.first().map_or(0.0, |p| distance(*p));
    largest = largest.max(before);
    for pair in points.windows(2) {
        let long = pair[0].distance(pair[1]);
        let samples = (2.0 * long / mean_edge).ceil().clamp(1.0, MOST_SAMPLES) as u32;
        for k in 1..=samples {
            let here = distance(pair[0].lerp(pair[1], f64::from(k) / f64::from(samples)));
            sum += 0.5 * (before + here) * long / f64::from(samples);
            largest = largest.max(here);
            before = here;
        }
        length += long;
    }
    (largest, if length > 0.0 { sum / length } else { largest })
}

/// Largest distance of a line's points from another line. From a point to the next it grows by no more than the way, so that most need not be
/// asked for.
pub(crate) fn farthest(points: &[DVec3], from: &LineTree) -> f64 {
    let (mut largest, mut at_most, mut hint) = (0.0_f64, f64::INFINITY, None);
    let mut before = points.first().copied().unwrap_or_default();
    for p in points {
        at_most += before.distance(*p);
        before = *p;
        if at_most <= largest {
            continue;
        }
        if let Some(near) = from.nearest(*p, hint) {
            (hint, at_most) = (Some(near.stretch), near.distance);
            largest = largest.max(near.distance);
        }
    }
    largest
}

/// Whether all places of a line are within a distance of another, to a thousandth of an edge.
pub(crate) fn stays_within(points: &[DVec3], from: &LineTree, far: f64, mean_edge: f64) -> bool {
    let mut hint = None;
    let mut distance = |p: DVec3| {
        let near = from.nearest(p, hint);
        hint = near.map(|near| near.stretch);
        near.map_or(0.0, |near| near.distance)
    };
    points.windows(2).all(|pair| between(pair[0], pair[1], &mut distance, far, 1e-3 * mean_edge, HALVINGS))
}

/// Whether a stretch is: no place of it is farther than half of what its ends are together, and its length.
fn between(a: DVec3, b: DVec3, distance: &mut impl FnMut(DVec3) -> f64, far: f64, fine: f64, halvings: u32) -> bool {
    let (here, there, long) = (distance(a), distance(b), a.distance(b));
    if here > far || there > far {
        return false;
    }
    if 0.5 * (here + there + long) <= far || long <= fine || halvings == 0 {
        return true;
    }
    let middle = a.midpoint(b);
    between(a, middle, distance, far, fine, halvings - 1) && between(middle, b, distance, far, fine, halvings - 1)
}
