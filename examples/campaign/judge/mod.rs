//! Puts paths before the checker, and refusals into words.

use bevy_surface_splines::{
    curve::TraceError,
    geodesic::{GeodesicPath, PathError},
    surface::{PointError, Surface, SurfacePoint},
};

use crate::{
    checker::{self, Claim, Fault, Stretch, Topology},
    outcome::Status,
};

mod curve;

pub(crate) use curve::trace;

/// Why a result does not count as a success.
#[derive(Debug)]
pub(crate) struct Rejected {
    pub(crate) status: Status,
    pub(crate) detail: String,
}

impl Rejected {
    fn new(kind: &'static str, detail: impl std::fmt::Display) -> Self {
        Self { status: Status::Error(kind), detail: detail.to_string() }
    }
}

/// A path's stretches as the checker wants them.
pub(crate) fn stretches(surface: &Surface, path: &GeodesicPath) -> Vec<Stretch> {
    path.segments(surface).map(|s| Stretch { face: s.face.0, from: s.from, to: s.to }).collect()
}

/// Judges a path between two points; returns how many places could not be decided.
pub(crate) fn path(
    surface: &Surface,
    topology: &Topology,
    path: &GeodesicPath,
    from: &SurfacePoint,
    to: &SurfacePoint,
) -> Result<usize, Rejected> {
    judge_stretches(topology, path, &stretches(surface, path), from, to)
}

fn judge_stretches(
    topology: &Topology,
    path: &GeodesicPath,
    stretches: &[Stretch],
    from: &SurfacePoint,
    to: &SurfacePoint,
) -> Result<usize, Rejected> {
    let claim = Claim { start: spelled(from), end: spelled(to), length: path.length(), stretches };
    checker::check(topology, &claim).map_err(|fault| match fault {
        Fault::Bent { .. } if path.is_frozen() => Rejected { status: Status::Frozen, detail: fault.to_string() },
        _ => Rejected::new(fault.kind(), fault),
    })
}

fn spelled(point: &SurfacePoint) -> (u32, [f64; 3]) {
    (point.face.0, point.weights)
}

/// What a refused trace means.
pub(crate) fn trace_refused(topology: &Topology, error: &TraceError) -> Rejected {
    match error {
        TraceError::Path(error) => path_refused(topology, error),
        _ => Rejected::new("trace", error),
    }
}

/// What a refused path means: that there is none counts only if the checker sees two sheets as well.
pub(crate) fn path_refused(topology: &Topology, error: &PathError) -> Rejected {
    match error {
        PathError::Point(error) => point_refused(error),
        PathError::NoPath { from, to } => match checker::connected(topology, from.face.0, to.face.0) {
            Some(false) => Rejected { status: Status::NoPath, detail: error.to_string() },
            _ => Rejected::new("lost_path", error),
        },
    }
}

/// What a refused point means.
pub(crate) fn point_refused(error: &PointError) -> Rejected {
    match error {
        PointError::FaceDropped(..) => Rejected { status: Status::DroppedFace, detail: error.to_string() },
        PointError::NoSuchFace(..) => Rejected::new("no_such_face", error),
        PointError::BadWeights(..) => Rejected::new("weights", error),
        _ => Rejected::new("point", error),
    }
}
