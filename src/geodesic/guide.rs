//! What tells a search how long a path through a side may become.

use glam::{DVec2, DVec3};

use super::{corridor::Corridor, stamps::Stamps};
use crate::surface::{HalfEdge, Surface};

/// A side in the plane, to be crossed: seen from the pseudo-source at (0, 0), its target at the left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portal {
    pub(crate) right: DVec2,
    pub(crate) left: DVec2,
    /// What the guide says of the right and the left end.
    pub(crate) squared: [f64; 2],
    pub(crate) width: f64,
    pub(crate) per_width: f64,
}

impl Portal {
    #[inline]
    pub(crate) fn new([right, left]: [DVec2; 2], squared: [f64; 2], width: f64) -> Self {
        Self { right, left, squared, width, per_width: 1.0 / width }
    }
}

/// How a side is reached.
pub(crate) struct Arrival<'a> {
    pub(crate) side: HalfEdge,
    pub(crate) twin: HalfEdge,
    pub(crate) portal: &'a Portal,
    /// The distance from the start to the pseudo-source.
    pub(crate) to_source: f64,
    /// The distance from the start to the side's middle.
    pub(crate) to_middle: f64,
}

/// Puts sides in order.
pub(crate) trait Guide {
    /// The squared distance from a vertex to the goal, if the guide wants to know it.
    fn squared(&self, surface: &Surface, vertex: u32) -> f64;

    /// Length of the shortest path that may run through a side; none if there is no way on.
    fn length_through(&self, surface: &Surface, arrival: &Arrival) -> Option<f64>;
}

/// Straight through space to a goal: never too much, unless it is told to count more.
pub(crate) struct ThroughSpace {
    goal: DVec3,
    /// The square of the factor by which distances to the goal count.
    factor: f64,
}

impl ThroughSpace {
    /// Distances count as what they are.
    pub(crate) fn to(goal: DVec3) -> Self {
        Self { goal, factor: 1.0 }
    }

    /// Distances count as longer by a factor.
    pub(crate) fn stretched(goal: DVec3, factor: f64) -> Self {
        Self { goal, factor: factor * factor }
    }
}

impl Guide for ThroughSpace {
    #[inline]
    fn squared(&self, surface: &Surface, vertex: u32) -> f64 {
        self.factor * surface.positions[vertex as usize].distance_squared(self.goal)
    }

    #[inline]
    fn length_through(&self, _: &Surface, arrival: &Arrival) -> Option<f64> {
        Some(arrival.to_source + shortest_through(arrival.portal))
    }
}

/// Straight through space to a goal, but through faces of a corridor only.
pub(crate) struct Inside<'a> {
    pub(crate) corridor: &'a Corridor,
    pub(crate) through_space: ThroughSpace,
}

impl Guide for Inside<'_> {
    #[inline]
    fn squared(&self, surface: &Surface, vertex: u32) -> f64 {
        self.through_space.squared(surface, vertex)
    }

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
    fn squared(&self, _: &Surface, _: u32) -> f64 {
        0.0
    }

    #[inline]
    fn length_through(&self, _: &Surface, arrival: &Arrival) -> Option<f64> {
        let back = self.known.to_middle(arrival.side).min(self.known.to_middle(arrival.twin));
        (back < f64::INFINITY).then_some(arrival.to_middle + Self::TRUST * back)
    }
}

/// Length of the shortest way from (0, 0) through a side to the goal, of which the squared distances from the side's ends are
/// given. The goal lies in space: the way is straight to the side and straight on.
#[inline]
fn shortest_through(portal: &Portal) -> f64 {
    let Portal { right, left, squared: [right_squared, left_squared], width, per_width } = *portal;
    // The pseudo-source in the frame of the side: the right end at the origin, the left end along x, travel downwards.
    let unit = (left - right) * per_width;
    let (x, y) = (-right.dot(unit), right.perp_dot(unit));
    // The goal in the plane of the side and itself, turned to lie opposite the source.
    let along = 0.5 * ((right_squared - left_squared) * per_width + width);
    let squared = right_squared - along * along;
    let beyond = if squared > 0.0 { squared.sqrt() } else { 0.0 };
    let (rise, run) = (y + beyond, along - x);
    let crossing = x * rise + run * y; // times rise
    if crossing < 0.0 {
        right.length() + right_squared.sqrt()
    } else if crossing > width * rise {
        left.length() + left_squared.sqrt()
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
            let ends = [DVec2::ZERO, DVec2::X * 2.0].map(|end| end - source);
            let found = shortest_through(&Portal::new(ends, squared, 2.0));
            let through = |k: u32| {
                let x = 2.0 * f64::from(k) / 1e5;
                source.distance(DVec2::new(x, 0.0)) + goal.distance(DVec3::X * x)
            };
            let best = (0..=100_000).map(through).fold(f64::INFINITY, f64::min);
            assert!(found <= best + 1e-12 && found > best - 1e-8, "{found} {best}");
        }
    }
}
