//! What became of a case.

use std::fmt;

use bevy_surface_splines::curve::TraceBound;

/// What is to be done: the number of the case, and with what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Job {
    /// Trace a control polygon; `scheme` counts in the list of schemes asked for.
    Curve { case: usize, scheme: usize },
    /// Join two points.
    Pair { case: usize },
}

/// How a case ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Status {
    Ok,
    /// An adaptive trace that says what kept it from being straight enough.
    Bound(TraceBound),
    /// A curve of a scheme for comparison that says where it is torn.
    Broken,
    /// The points lie on separate sheets, and the checker agrees.
    NoPath,
    /// Straightening gave up, and the path is not shortest.
    Frozen,
    /// It took longer than allowed.
    Timeout,
    /// Likewise, but nothing better can be asked of the scheme.
    Slow,
    /// A point lies in a face that is not part of the surface.
    DroppedFace,
    /// A path shorter than the exact distance.
    Undercut,
    /// Anything else; see [`Outcome::detail`].
    Error(&'static str),
}

/// Whether a status counts for or against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Passed,
    Failed,
    Neither,
}

impl Status {
    pub(crate) fn verdict(self) -> Verdict {
        match self {
            Self::Ok | Self::Bound(_) | Self::Broken => Verdict::Passed,
            Self::NoPath | Self::Slow => Verdict::Neither,
            _ => Verdict::Failed,
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ok => f.write_str("ok"),
            Self::Bound(TraceBound::Depth) => f.write_str("depth_bound"),
            Self::Bound(TraceBound::Pieces) => f.write_str("pieces_bound"),
            Self::Bound(TraceBound::Length) => f.write_str("length_bound"),
            Self::Broken => f.write_str("broken"),
            Self::NoPath => f.write_str("no_path"),
            Self::Frozen => f.write_str("frozen"),
            Self::Timeout | Self::Slow => f.write_str("timeout"),
            Self::DroppedFace => f.write_str("dropped_face"),
            Self::Undercut => f.write_str("undercut"),
            Self::Error(kind) => write!(f, "error:{kind}"),
        }
    }
}

/// The result of one case.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    pub(crate) job: Job,
    /// CPU time, in milliseconds.
    pub(crate) ms: f64,
    /// CPU time for the scheme's points alone.
    pub(crate) ms_points: f64,
    /// How many points the scheme gave.
    pub(crate) points: usize,
    /// In the file's unit.
    pub(crate) length: f64,
    /// The largest turn between consecutive geodesics.
    pub(crate) max_turn_deg: f64,
    pub(crate) status: Status,
    /// What was wrong, in words.
    pub(crate) detail: String,
    /// Places that the checker could not decide.
    pub(crate) undecided: usize,
    /// Over the bits of all paths.
    pub(crate) hash: u64,
}

impl Outcome {
    pub(crate) fn new(job: Job) -> Self {
        Self {
            job,
            ms: 0.0,
            ms_points: 0.0,
            points: 0,
            length: 0.0,
            max_turn_deg: 0.0,
            status: Status::Ok,
            detail: String::new(),
            undecided: 0,
            hash: 0,
        }
    }

    /// The same with the given end.
    pub(crate) fn ended(mut self, status: Status, detail: impl fmt::Display) -> Self {
        self.status = status;
        self.detail = detail.to_string();
        self
    }

    /// Whether there is a time to count.
    pub(crate) fn is_timed(&self) -> bool {
        self.ms > 0.0 && !matches!(self.status, Status::NoPath | Status::DroppedFace)
    }
}
