//! Lines to be smoothed: jagged walks, and traces, which are smooth already.

use bevy_surface_splines::{
    curve::{Scheme, Tracer},
    geodesic::Crossing,
    smooth::{SmoothWorkspace, SurfacePolyline},
    surface::{FaceId, SurfacePoint},
};

use crate::{
    args::Args,
    checker::Topology,
    hash::Fnv,
    prepare::Prepared,
    random::{self, SplitMix64},
};

/// Faces that a walk passes.
const STEPS: usize = 200;
/// Draws of a line before it is given up.
const DRAWS: usize = 20;

/// What a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Open,
    Closed,
    Trace,
}

/// A line to be smoothed.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub(crate) number: usize,
    pub(crate) kind: Kind,
    /// Whether a face that it passes has a corner on the boundary.
    pub(crate) boundary: bool,
    pub(crate) line: SurfacePolyline,
    pub(crate) mean_edge: f64,
}

/// The lines of a mesh: every third one closed, and with the mode `tether` as many traces.
pub(crate) fn of_mesh(mesh: &Prepared, args: &Args, workspace: &mut SmoothWorkspace) -> Vec<Line> {
    let mut name = Fnv::default();
    name.text(&mesh.name);
    let mut random = SplitMix64::new(args.seed ^ name.0 ^ 0x5300);
    let mut lines = Vec::new();
    let rim = rim(&mesh.topology);
    let mut left_out = [0, 0];
    for number in 0..args.smooth {
        let kind = if number % 3 == 2 { Kind::Closed } else { Kind::Open };
        let line = (0..DRAWS).find_map(|_| {
            let open = walk(mesh, &mut random)?;
            match kind {
                Kind::Closed => open.closed_home(&mesh.surface, &mut workspace.finder).ok(),
                _ => Some(open),
            }
        });
        let line = line.and_then(|line| finished(mesh, &rim, number, kind, line));
        if line.is_none() {
            println!(
                "  LEFT OUT {} {number} {kind:?}: none of {DRAWS} walks makes a line that crosses a side",
                mesh.name
            );
        }
        lines.extend(line);
    }
    if args.mode == "tether" {
        let mut tracer = Tracer::new(&mesh.surface);
        for number in 0..args.smooth {
            let line = random::polygon(&mesh.surface, &mut random)
                .and_then(|polygon| tracer.trace(&polygon, &Scheme::lane_riesenfeld()).ok())
                .and_then(|trace| SurfacePolyline::along(&mesh.surface, &trace, false).ok())
                .and_then(|line| finished(mesh, &rim, number, Kind::Trace, line));
            left_out[1] += usize::from(line.is_none());
            lines.extend(line);
        }
    }
    if left_out != [0, 0] {
        let [walks, traces] = left_out;
        println!(
            "  {}: {walks} walks and {traces} traces left out that cross no side, or whose ends cannot be joined",
            mesh.name
        );
    }
    lines
}

/// Which welded vertices lie on the boundary.
fn rim(topology: &Topology) -> Vec<bool> {
    let mut rim = vec![false; topology.positions.len()];
    for (face, corners) in topology.corners.iter().enumerate().filter(|(f, _)| topology.has(*f as u32)) {
        for side in (0..3).filter(|side| topology.across(face as u32, *side).is_none()) {
            rim[corners[side] as usize] = true;
            rim[corners[(side + 1) % 3] as usize] = true;
        }
    }
    rim
}

fn finished(mesh: &Prepared, rim: &[bool], number: usize, kind: Kind, line: SurfacePolyline) -> Option<Line> {
    let first = line.crossings().first()?;
    let mean_edge = mesh.surface.mean_edge_length(first.face).ok()?;
    let corners = |c: &Crossing| mesh.topology.corners[c.face.0 as usize];
    let boundary = line.crossings().iter().any(|c| corners(c).iter().any(|v| rim[*v as usize]));
    Some(Line { number, kind, boundary, line, mean_edge })
}

/// A walk from face to face that does not turn back at once, crossing sides anywhere between a tenth and nine.
fn walk(mesh: &Prepared, random: &mut SplitMix64) -> Option<SurfacePolyline> {
    let topology = &mesh.topology;
    let faces = topology.corners.len().max(1) as u64;
    let first = (0..1000).map(|_| (random.next() % faces) as u32).find(|face| topology.has(*face))?;
    let (mut face, mut entered) = (first, None);
    let mut crossings = Vec::new();
    for _ in 0..STEPS {
        let ways: Vec<usize> =
            (0..3).filter(|side| Some(*side) != entered && topology.across(face, *side).is_some()).collect();
        if ways.is_empty() {
            break;
        }
        let side = ways[(random.next() % ways.len() as u64) as usize];
        let at = 0.1 + 0.8 * random.unit();
        crossings.push(Crossing { face: FaceId(face), side: side as u8, at });
        let (next, there) = topology.across(face, side)?;
        (face, entered) = (next, Some(there));
    }
    let middle = |face: u32| SurfacePoint { face: FaceId(face), weights: [1.0 / 3.0; 3] };
    SurfacePolyline::open(&mesh.surface, middle(first), crossings, middle(face)).ok()
}
