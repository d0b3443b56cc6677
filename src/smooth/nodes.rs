//! The places where a line can bend: crossings, and vertices that several crossings in a row are at.

use std::f64::consts::{PI, TAU};

use super::{
    fan::Fan,
    layout::Layout,
    metric::Metric,
    strip::{AT_VERTEX, Run, Strip},
};
use crate::surface::Surface;

/// A place where a line can bend.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// First and last of its crossings.
    pub(crate) first: usize,
    pub(crate) last: usize,
    /// The turn in the strip laid flat, positive to the left; about a vertex it may exceed π.
    pub(crate) turn: f64,
    /// By how much the line could be straightened there. That is its turn, but none at a vertex of negative curvature that it
    /// runs through with at least π on either side: it is straight there already, whatever its share of the angle.
    pub(crate) fold: f64,
    /// The turn on the surface: at a vertex a share of its total angle, none on the boundary (Polthier & Schmies 1998).
    pub(crate) bend: f64,
}

/// Finds all nodes of a line; one with less than a hair between crossings that share a vertex is at it.
pub(crate) fn find(
    surface: &Surface,
    metric: &mut Metric,
    strip: &Strip,
    layout: &Layout,
    fan: &mut Fan,
    out: &mut Vec<Node>,
) {
    out.clear();
    let mut i = 0;
    while i < strip.len() {
        let at = strip.at[i];
        let left = at >= 1.0 - AT_VERTEX;
        if at > AT_VERTEX && !left {
            let turn = layout.turn(i, &strip.at);
            out.push(Node { first: i, last: i, turn, fold: turn, bend: turn });
            i += 1;
            continue;
        }
        let vertex = strip.end_vertex(surface, i, left);
        let touches = |k: usize| {
            let there = if left { strip.at[k] >= 1.0 - AT_VERTEX } else { strip.at[k] <= AT_VERTEX };
            there && strip.end_vertex(surface, k, left) == vertex
        };
        let first = i;
        while i + 1 < strip.len() && touches(i + 1) {
            i += 1;
        }
        fan.unfold(surface, metric, strip, layout, &Run { first, last: i, vertex, left });
        if fan.radii.iter().any(|r| *r <= 1e-12 * layout.lengths[first]) {
            out.push(Node { first, last: i, turn: 0.0, fold: 0.0, bend: 0.0 });
            i += 1;
            continue;
        }
        let turn = if left { fan.turn() } else { -fan.turn() };
        let angle = metric.angle(surface, vertex);
        let right = if left { fan.angle } else { angle - fan.angle };
        let bend = if surface.boundary[vertex as usize] { 0.0 } else { TAU / angle * right - PI };
        // To the right with less than π there, to the left likewise; beside a peak maybe both.
        let (to_right, to_left) = ((right - PI).min(0.0), (PI - (angle - right)).max(0.0));
        let fold = if surface.boundary[vertex as usize] {
            0.0
        } else if -to_right > to_left {
            to_right
        } else {
            to_left
        };
        out.push(Node { first, last: i, turn, fold, bend });
        i += 1;
    }
}
