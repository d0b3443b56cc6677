//! Puts results before the checker, and refusals into words.

use bevy_surface_splines::{
    curve::{Trace, TraceError},
    geodesic::{GeodesicPath, PathError},
    surface::{PointError, Surface, SurfacePoint},
};

use crate::{
    checker::{self, Claim, Fault, Stretch, Topology},
    outcome::Status,
};

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

/// What the checker found in a curve that passed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Judged {
    pub(crate) undecided: usize,
    pub(crate) max_turn_deg: f64,
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

/// Judges the trace of one segment: its points are those given without the joining, it runs from the first control point to
/// the last, every path joins its two points and is locally shortest, the length is the paths' sum.
pub(crate) fn trace(
    surface: &Surface,
    topology: &Topology,
    polygon: &[SurfacePoint; 4],
    trace: &Trace,
    points_alone: &[SurfacePoint],
) -> Result<Judged, Rejected> {
    let [segment] = trace.segments() else {
        return Err(Rejected::new("segments", format!("{} segments for one polygon", trace.segments().len())));
    };
    let (points, paths) = (segment.points(), segment.paths());
    if points.len() != paths.len() + 1 {
        return Err(Rejected::new("points", format!("{} points and {} paths", points.len(), paths.len())));
    }
    let ends = [(&points[0], &polygon[0]), (&points[points.len() - 1], &polygon[3])];
    if !ends.into_iter().all(|(a, b)| checker::same_place(topology, spelled(a), spelled(b))) {
        return Err(Rejected::new("wrong_end", "the curve does not run from the first control point to the last"));
    }
    if points.len() != points_alone.len() {
        return Err(Rejected::new("points", format!("{} points alone, {} joined", points_alone.len(), points.len())));
    }
    if !points.iter().zip(points_alone).all(|(a, b)| checker::same_place(topology, spelled(a), spelled(b))) {
        return Err(Rejected::new("points", "the points alone differ from the joined ones"));
    }
    let mut judged = Judged::default();
    let mut all = Vec::with_capacity(paths.len());
    for (i, path) in paths.iter().enumerate() {
        let stretches = stretches(surface, path);
        let verdict = judge_stretches(topology, path, &stretches, &points[i], &points[i + 1]);
        judged.undecided += verdict.map_err(|r| Rejected { detail: format!("path {i}: {}", r.detail), ..r })?;
        all.push(stretches);
    }
    let sum: f64 = paths.iter().map(GeodesicPath::length).sum();
    let agrees = (trace.length() - sum).abs() <= 1e-9 * sum; // not so for NaN
    if !agrees {
        return Err(Rejected::new("wrong_length", format!("given as {:e}, its paths measure {sum:e}", trace.length())));
    }
    judged.max_turn_deg = checker::largest_turn(topology, &all);
    Ok(judged)
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
