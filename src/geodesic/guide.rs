//! What tells a search how long a path through a side may become.

use glam::{DVec2, DVec3};

use super::{corridor::Corridor, stamps::Stamps};
use crate::surface::{HalfEdge, Surface};

/// How a side is reached, in the side's frame: origin at (0, 0), target at (width, 0), travel downwards.
pub(crate) struct Arrival {
    pub(crate) side: HalfEdge,
    pub(crate) twin: HalfEdge,
    pub(crate) width: f64,
    pub(crate) per_width: f64,
    /// The pseudo-source, and the distance from the start to it.
    pub(crate) source: DVec2,
    pub(crate) to_source: f64,
    /// The distance from the start to the side's middle.
    pub(crate) to_middle: f64,
}

/// Puts sides in order.
pub(crate) trait Guide {
    /// Length of the shortest path that may run through a side; none if there is no way on.
    fn length_through(&self, surface: &Surface, arrival: &Arrival) -> Option<f64>;
}

/// Straight through space to a goal: never too much.
pub(crate) struct ThroughSpace {
    pub(crate) goal: DVec3,
}

impl Guide for ThroughSpace {
    #[inline]
    fn length_through(&self, surface: &Surface, arrival: &Arrival) -> Option<f64> {
        let squared = |vertex: u32| surface.positions[vertex as usize].distance_squared(self.goal);
        let (right, left) = (squared(surface.origin(arrival.side)), squared(surface.target(arrival.side)));
        let Arrival { source, width, per_width, .. } = *arrival;
        Some(arrival.to_source + shortest_through(source, width, per_width, right, left))
    }
}

/// Straight through space to a goal, but through faces of a corridor only.
pub(crate) struct Inside<'a> {
    pub(crate) corridor: &'a Corridor,
    pub(crate) through_space: ThroughSpace,
}

impl Guide for Inside<'_> {
    #[inline]
    fn length_through(&self, surface: &Surface, arrival: &Arrival) -> Option<f64> {
        self.corridor.aim(surface, arrival.twin.face())?;
        self.through_space.length_through(surface, arrival)
    }
}

/// The way a search came that went from the goal to where this one starts.
pub(crate) struct BackAlong<'a> {
    pub(crate) known: &'a Stamps,
}

impl BackAlong<'_> {
    /// Known distances are those of the other search's labels, which may be improved upon by a little.
    const TRUST: f64 = 0.999;
}

impl Guide for BackAlong<'_> {
    #[inline]
    fn length_through(&self, _: &Surface, arrival: &Arrival) -> Option<f64> {
        let known = |side: HalfEdge| self.known.get(side).map_or(f64::INFINITY, |reached| reached.to_middle);
        let back = known(arrival.side).min(known(arrival.twin));
        (back < f64::INFINITY).then_some(arrival.to_middle + Self::TRUST * back)
    }
}

/// Length of the shortest way from `source` through a side of length `width` to the goal, of which the squared distances from
/// the side's origin and target are given. The goal lies in space: the way is straight to the side and straight on.
#[inline]
fn shortest_through(source: DVec2, width: f64, per_width: f64, right_squared: f64, left_squared: f64) -> f64 {
    // The goal in the plane of the side and itself, turned to lie opposite the source.
    let along = 0.5 * ((right_squared - left_squared) * per_width + width);
    let squared = right_squared - along * along;
    let beyond = if squared > 0.0 { squared.sqrt() } else { 0.0 };
    let (rise, run) = (source.y + beyond, along - source.x);
    let crossing = source.x * rise + run * source.y; // times rise
    if crossing < 0.0 {
        source.length() + right_squared.sqrt()
    } else if crossing > width * rise {
        source.distance(DVec2::new(width, 0.0)) + left_squared.sqrt()
    } else {
        DVec2::new(run, rise).length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shortest_way_through_a_side_is_straight_or_turns_at_an_end() {
        let side = [DVec3::ZERO, DVec3::X * 2.0];
        for (source, goal) in [
            (DVec2::new(0.5, 1.0), DVec3::new(1.5, -1.0, 0.0)),
            (DVec2::new(0.5, 1.0), DVec3::new(1.5, 0.6, 0.8)),
            (DVec2::new(-3.0, 0.5), DVec3::new(-2.0, 0.0, 1.0)),
            (DVec2::new(4.0, 0.5), DVec3::new(3.0, -1.0, 1.0)),
            (DVec2::new(1.0, 0.0), DVec3::new(1.0, 0.0, 0.0)),
        ] {
            let squared = side.map(|p| p.distance_squared(goal));
            let found = shortest_through(source, 2.0, 0.5, squared[0], squared[1]);
            let through = |k: u32| {
                let x = 2.0 * f64::from(k) / 1e5;
                source.distance(DVec2::new(x, 0.0)) + goal.distance(DVec3::X * x)
            };
            let best = (0..=100_000).map(through).fold(f64::INFINITY, f64::min);
            assert!(found <= best + 1e-12 && found > best - 1e-8, "{found} {best}");
        }
    }
}
