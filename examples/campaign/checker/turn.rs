//! How sharply a polyline of geodesics turns at its points.

use super::{
    Stretch,
    fan::{self, Wedge},
    joint::{self, Joint},
    plane::angle,
    topology::Topology,
};

/// A stretch shorter than this share of its face's longest side has no direction to speak of.
const NO_LENGTH: f64 = 1e-12;

/// How a polyline turns where two of its paths meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    pub(crate) degrees: f64,
    /// Length of the shorter one of the two paths.
    pub(crate) shorter: f64,
}

/// The turns from each path to the next.
///
/// The turn is the angle between the direction in which one path arrives and the direction in which the next one leaves.
/// Inside a face it is measured in the face, on a side after laying the two faces flat. At a vertex the faces of the fan are
/// spread evenly to a full turn (at the boundary they are taken as they are), and the turn is what is missing from half of
/// it. Paths without length are skipped.
pub(crate) fn all(topology: &Topology, paths: &[Vec<Stretch>]) -> Vec<Turn> {
    let moves = |s: &&Stretch| s.length(topology) > NO_LENGTH * topology.size(s.face);
    let ends = paths.iter().filter_map(|path| {
        let first = path.iter().find(moves)?;
        path.iter().rfind(moves).map(|last| (*first, *last, super::length(topology, path)))
    });
    let ends: Vec<(Stretch, Stretch, f64)> = ends.collect();
    let between = |w: &[(Stretch, Stretch, f64)]| Turn {
        degrees: turn(topology, &w[0].1, &w[1].0).to_degrees(),
        shorter: w[0].2.min(w[1].2),
    };
    ends.windows(2).map(between).collect()
}

fn turn(topology: &Topology, arriving: &Stretch, leaving: &Stretch) -> f64 {
    let (d, e) = (arriving.vector(topology), leaving.vector(topology));
    let Ok(located) = joint::locate(topology, 0, arriving, leaving) else { return angle(d, e) };
    if let Some((vertex, share)) = located.near
        && share <= joint::AT_VERTEX
    {
        return at_vertex(topology, vertex, arriving, leaving).unwrap_or_else(|| angle(d, e));
    }
    match located.joint {
        Joint::Inside | Joint::Corner => angle(d, e),
        Joint::Across(passage) => {
            // Both faces lie on the same side of their common edge's other one when unfolded: compare the angles with it.
            let edge = |face: u32, side: usize| {
                let p = topology.places(face);
                p[(side + 1) % 3] - p[side]
            };
            let same_way = topology.corners[arriving.face as usize][passage.leave]
                == topology.corners[leaving.face as usize][passage.enter];
            let other = edge(leaving.face, passage.enter);
            let along = if same_way { other } else { -other };
            (angle(edge(arriving.face, passage.leave), d) - angle(along, e)).abs()
        }
    }
}

fn at_vertex(topology: &Topology, vertex: u32, arriving: &Stretch, leaving: &Stretch) -> Option<f64> {
    let (before, after) = ((arriving.face, arriving.from), (leaving.face, leaving.to));
    let (total, closed) = fan::total_angle(topology, vertex, arriving.face)?;
    let half = std::f64::consts::PI;
    let wedge = if arriving.face == leaving.face {
        Wedge::within(topology, vertex, before, after)
    } else {
        let corner = topology.corner_of(arriving.face, vertex)?;
        [corner, (corner + 2) % 3].into_iter().find_map(|side| Wedge::around(topology, vertex, before, side, after))
    };
    let angle = wedge?.angle;
    Some(if closed { (half - angle * std::f64::consts::TAU / total).abs() } else { (half - angle).abs() })
}
