//! Whether a path can be shortened near any of the places where it goes from face to face.

use std::f64::consts::PI;

use super::{
    Fault, Stretch,
    fan::Wedge,
    joint::{AT_VERTEX, Joint, Located},
    plane::{self, Passage},
    topology::Topology,
};

/// A stretch shorter than this share of its face's longest side has no direction to speak of.
const NO_LENGTH: f64 = 1e-12;

/// What could be saved around one or more joints.
enum Gain {
    /// Just this much.
    Exactly(f64),
    /// This much, unless the engine had to cut the surface here.
    AtMost(f64),
    /// This much, and perhaps more.
    AtLeast(f64),
}

/// Looks at every place between the stretches, and at neighbouring ones together where they all but coincide.
///
/// Returns how many places could not be decided: about vertices of sheets that cannot be oriented (an engine has to cut
/// those, and where is its choice), and where faces without area crowd in one place.
///
/// # Errors
/// [`Fault::Bent`] if more than `allowed` can be saved.
pub(crate) fn check(
    topology: &Topology,
    stretches: &[Stretch],
    joints: &[Located],
    allowed: f64,
) -> Result<usize, Fault> {
    let lengths: Vec<f64> = stretches.iter().map(|s| s.length(topology)).collect();
    let tiny = |i: usize| lengths[i] <= NO_LENGTH * topology.size(stretches[i].face);
    // The path proper begins where it first goes anywhere.
    let Some(first) = (0..stretches.len()).find(|i| !tiny(*i)) else { return Ok(0) };
    let last = (0..stretches.len()).rfind(|i| !tiny(*i)).unwrap_or(first);
    let mut undecided = 0;
    let mut begin = first;
    while begin < last {
        // Joint i stands between stretch i and stretch i + 1.
        let mut end = begin;
        while end + 1 < last && (tiny(end + 1) || together(&joints[end], &joints[end + 1])) {
            end += 1;
        }
        let actual: f64 = lengths[begin..=end + 1].iter().sum();
        let gain = look(topology, &stretches[begin..=end + 1], &joints[begin..=end], actual);
        match gain {
            Gain::Exactly(gain) | Gain::AtLeast(gain) if gain > allowed => {
                return Err(Fault::Bent { joint: begin, face: stretches[begin].face, gain });
            }
            Gain::AtMost(gain) if gain <= allowed => {}
            Gain::Exactly(_) => {}
            Gain::AtMost(_) | Gain::AtLeast(_) => undecided += 1,
        }
        begin = end + 1;
    }
    Ok(undecided)
}

fn together(a: &Located, b: &Located) -> bool {
    matches!((a.near, b.near), (Some((v, _)), Some((w, _))) if v == w)
}

fn look(topology: &Topology, stretches: &[Stretch], joints: &[Located], actual: f64) -> Gain {
    let (vertex, all_near) = match joints[0].near {
        Some((vertex, _)) => (vertex, joints.iter().all(|j| j.near.is_some_and(|n| n.0 == vertex))),
        None => (0, false),
    };
    if all_near && let Some(gain) = past_vertex(topology, vertex, stretches, joints, actual) {
        return gain;
    }
    let crowded = joints.len() > 1 && joints.iter().any(|j| j.near.is_some());
    match along_strip(topology, stretches, joints) {
        Some(taut) if crowded => Gain::AtLeast(actual - taut),
        Some(taut) => Gain::Exactly(actual - taut),
        None => Gain::AtLeast(0.0),
    }
}

/// Length of the path pulled taut within the faces it runs through.
fn along_strip(topology: &Topology, stretches: &[Stretch], joints: &[Located]) -> Option<f64> {
    let mut faces = vec![stretches[0].face];
    let mut passages: Vec<Passage> = Vec::with_capacity(joints.len());
    for (joint, after) in joints.iter().zip(&stretches[1..]) {
        match joint.joint {
            Joint::Inside => {}
            // There and back through one side is the same as staying.
            Joint::Across(passage) if passages.last().is_some_and(|p| p.enter == passage.leave) => {
                passages.pop();
                faces.pop();
            }
            Joint::Across(passage) => {
                passages.push(passage);
                faces.push(after.face);
            }
            Joint::Corner => return None,
        }
    }
    let (from, to) = (stretches[0].from, stretches[stretches.len() - 1].to);
    if passages.is_empty() {
        return Some(Stretch { face: faces[0], from, to }.length(topology));
    }
    let (a, portals, c) = plane::unfold(topology, &faces, &passages, from, to)?;
    plane::taut(a, &portals, c)
}

/// Looks for a shorter way past a vertex.
///
/// A path through the vertex itself may go either side. One that passes by is held to its own side, unless it is wrapped
/// around the vertex there: a straight line just beside a sharp vertex is locally shortest although the other side may
/// be shorter by far.
fn past_vertex(
    topology: &Topology,
    vertex: u32,
    stretches: &[Stretch],
    joints: &[Located],
    actual: f64,
) -> Option<Gain> {
    let (first, last) = (stretches[0], stretches[stretches.len() - 1]);
    let (before, after) = ((first.face, first.from), (last.face, last.to));
    let corner = topology.corner_of(first.face, vertex)?;
    let sides = [corner, (corner + 2) % 3];
    let around = |side: usize| Wedge::around(topology, vertex, before, side, after);
    let through = joints.iter().all(|j| j.near.is_some_and(|n| n.1 <= AT_VERTEX));
    if !through {
        let Joint::Across(passage) = joints[0].joint else { return None };
        let own = around(*sides.iter().find(|s| **s == passage.leave)?)?;
        if own.angle < PI {
            return Some(Gain::Exactly(actual - own.shortest()));
        }
    }
    let within = (first.face == last.face).then(|| Wedge::within(topology, vertex, before, after)).flatten();
    let ways = sides.into_iter().filter_map(around).chain(within);
    let shortest = ways.map(|wedge| wedge.shortest()).fold(actual, f64::min);
    let gain = actual - shortest;
    Some(if topology.is_one_sided(first.face) { Gain::AtMost(gain) } else { Gain::Exactly(gain) })
}
