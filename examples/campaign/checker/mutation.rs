//! Ways to spoil a path, whoever made it. Each gives nothing where the path offers no place for it.

use super::{
    Stretch,
    joint::{self, Joint},
    topology::Topology,
};

/// How a path leaves stretch `i` for the next, if it crosses a side there.
fn crossing(topology: &Topology, path: &[Stretch], i: usize) -> Option<super::plane::Passage> {
    match joint::locate(topology, i, path.get(i)?, path.get(i + 1)?).ok()?.joint {
        Joint::Across(passage) => Some(passage),
        _ => None,
    }
}

/// Moves the crossing after stretch `i` by a share of its side, towards the side's farther end.
pub(crate) fn moved_crossing(topology: &Topology, path: &[Stretch], i: usize, by: f64) -> Option<Vec<Stretch>> {
    let passage = crossing(topology, path, i)?;
    let (k, l) = (passage.leave, (passage.leave + 1) % 3);
    let share = path[i].to[l];
    let share = if share < 0.5 { share + by } else { share - by };
    let mut to = [0.0; 3];
    (to[k], to[l]) = (1.0 - share, share);
    let mut path = path.to_vec();
    path[i].to = to;
    path[i + 1].from = respelled(topology, path[i].face, to, path[i + 1].face)?;
    Some(path)
}

/// Leaves out stretch `i`, and with it a face of the strip.
pub(crate) fn without_face(path: &[Stretch], i: usize) -> Option<Vec<Stretch>> {
    (i > 0 && i + 1 < path.len()).then(|| [&path[..i], &path[i + 1..]].concat())
}

/// Leads the path through the nearer end of the side that it crosses after stretch `i`, round the *other* side of that vertex:
/// what straightening would have to flip. None where the boundary bars the way, or where the path stays no longer about the
/// vertex than its own faces.
pub(crate) fn undone_flip(topology: &Topology, path: &[Stretch], i: usize) -> Option<Vec<Stretch>> {
    let (run, vertex) = run_about(topology, path, i)?;
    let (before, after) = (path[run.start], path[run.end]);
    let corner = topology.corner_of(before.face, vertex)?;
    let other = topology.other_side(before.face, vertex, crossing(topology, path, run.start)?.leave)?;
    let at_vertex = |face: u32| {
        let mut weights = [0.0; 3];
        weights[topology.corner_of(face, vertex)?] = 1.0;
        Some(weights)
    };
    let mut mutant = path[..run.start].to_vec();
    let mut weights = [0.0; 3];
    weights[corner] = 1.0;
    mutant.push(Stretch { to: weights, ..before });
    for (face, _) in topology.fan(vertex, before.face, other) {
        if face == after.face {
            mutant.push(Stretch { from: at_vertex(face)?, ..after });
            mutant.extend_from_slice(&path[run.end + 1..]);
            return Some(mutant);
        }
        mutant.push(Stretch { face, from: at_vertex(face)?, to: at_vertex(face)? });
    }
    None
}

/// As [`undone_flip`], but passing the vertex at a share of each spoke.
pub(crate) fn wrapped(topology: &Topology, path: &[Stretch], i: usize, share: f64) -> Option<Vec<Stretch>> {
    let (run, vertex) = run_about(topology, path, i)?;
    let mut mutant = undone_flip(topology, path, i)?;
    let end = mutant.len() - (path.len() - run.end);
    for j in run.start..end {
        let (face, next) = (mutant[j].face, mutant[j + 1].face);
        let [k, l] = shared_side(topology, face, next, vertex)?;
        let mut to = [0.0; 3];
        (to[k], to[l]) = (1.0 - share, share);
        mutant[j].to = to;
        mutant[j + 1].from = respelled(topology, face, to, next)?;
    }
    Some(mutant)
}

/// The stretches about the vertex nearest to the crossing after stretch `i`: from the first to the last that crosses one of
/// its spokes.
fn run_about(topology: &Topology, path: &[Stretch], i: usize) -> Option<(std::ops::Range<usize>, u32)> {
    let passage = crossing(topology, path, i)?;
    let (k, l) = (passage.leave, (passage.leave + 1) % 3);
    let t = topology.corners[path[i].face as usize];
    let vertex = if path[i].to[l] < 0.5 { t[k] } else { t[l] };
    let spoke = |j: usize| {
        let found = crossing(topology, path, j);
        found.is_some_and(|p| {
            let t = topology.corners[path[j].face as usize];
            t[p.leave] == vertex || t[(p.leave + 1) % 3] == vertex
        })
    };
    let start = (0..=i).rev().take_while(|j| spoke(*j)).last()?;
    let end = (i..path.len()).take_while(|j| spoke(*j)).last()? + 1;
    Some((start..end, vertex))
}

/// The places in `face` of `vertex` and of the other end of a side shared with `next`.
fn shared_side(topology: &Topology, face: u32, next: u32, vertex: u32) -> Option<[usize; 2]> {
    let k = topology.corner_of(face, vertex)?;
    let side = [k, (k + 2) % 3].into_iter().find(|s| topology.across(face, *s).is_some_and(|(f, _)| f == next))?;
    Some([k, if side == k { (k + 1) % 3 } else { side }])
}

/// Weights in another face of a point on a side that both share.
fn respelled(topology: &Topology, face: u32, weights: [f64; 3], other: u32) -> Option<[f64; 3]> {
    let mut out = [0.0; 3];
    for (k, w) in weights.into_iter().enumerate().filter(|(_, w)| *w != 0.0) {
        out[topology.corner_of(other, topology.corners[face as usize][k])?] = w;
    }
    Some(out)
}
