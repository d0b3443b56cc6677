//! Puts curves before the checker.

use bevy_surface_splines::{
    curve::{SegmentTrace, Trace, TraceBound},
    geodesic::GeodesicPath,
    surface::{Surface, SurfacePoint},
};

use super::{Rejected, judge_stretches, spelled, stretches};
use crate::{
    checker::{self, Topology, Turn},
    outcome::Status,
    scheme::NamedScheme,
};

/// An adaptive trace may turn by so much more than it was asked to, in degrees: rounding.
const TURN_ROUNDING: f64 = 1e-6;
/// A trace that was kept from being straight by short pieces turns only where a path is shorter than this share of the
/// diagonal.
const SHORT: f64 = 1e-10;

/// What the checker found in a curve that passed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Judged {
    pub(crate) undecided: usize,
    pub(crate) max_turn_deg: f64,
    /// Ok, or what the trace says of itself.
    pub(crate) status: Status,
}

/// Judges a trace: its points are those given without the joining, it runs from the first control point to the last, its
/// segments meet, every path joins its two points and is locally shortest, the length is the paths' sum, and it turns no more
/// than its scheme allows.
pub(crate) fn trace(
    surface: &Surface,
    topology: &Topology,
    polygon: &[SurfacePoint],
    scheme: &NamedScheme,
    trace: &Trace,
    points_alone: &[SurfacePoint],
) -> Result<Judged, Rejected> {
    let curve = Curve::new(topology, scheme, trace)?;
    curve.check_ends(topology, polygon)?;
    curve.check_points_alone(topology, points_alone)?;
    let (undecided, turns) = curve.judge_paths(surface, topology)?;
    curve.check_length(trace.length())?;
    let status = what_it_says(scheme, &turns, SHORT * topology.diagonal, curve.bound, curve.jumps)?;
    Ok(Judged { undecided, max_turn_deg: checker::largest_turn(&turns), status })
}

/// The segments of a trace one after the other.
struct Curve<'a> {
    /// Those where segments meet appear once.
    points: Vec<&'a SurfacePoint>,
    paths: Vec<&'a GeodesicPath>,
    bound: Option<TraceBound>,
    jumps: usize,
}

impl<'a> Curve<'a> {
    fn new(topology: &Topology, scheme: &NamedScheme, trace: &'a Trace) -> Result<Self, Rejected> {
        let segments = trace.segments();
        if segments.len() != scheme.segments() {
            let detail = format!("{} segments instead of {}", segments.len(), scheme.segments());
            return Err(Rejected::new("segments", detail));
        }
        let mut curve = Self { points: Vec::new(), paths: Vec::new(), bound: None, jumps: 0 };
        for (i, segment) in segments.iter().enumerate() {
            check_counts(segment)?;
            let [first, rest @ ..] = segment.points() else { continue };
            match curve.points.last() {
                Some(last) if !checker::same_place(topology, spelled(last), spelled(first)) => {
                    return Err(Rejected::new("segments_apart", format!("segments {} and {i} do not meet", i - 1)));
                }
                Some(_) => {}
                None => curve.points.push(first),
            }
            curve.points.extend(rest);
            curve.paths.extend(segment.paths());
            curve.bound = curve.bound.or(segment.bound());
            curve.jumps += segment.jumps().len();
        }
        Ok(curve)
    }

    fn check_ends(&self, topology: &Topology, polygon: &[SurfacePoint]) -> Result<(), Rejected> {
        let ends = [(self.points.first(), polygon.first()), (self.points.last(), polygon.last())];
        let right = ends.into_iter().all(|ends| match ends {
            (Some(a), Some(b)) => checker::same_place(topology, spelled(a), spelled(b)),
            _ => false,
        });
        if right {
            return Ok(());
        }
        Err(Rejected::new("wrong_end", "the curve does not run from the first control point to the last"))
    }

    fn check_points_alone(&self, topology: &Topology, alone: &[SurfacePoint]) -> Result<(), Rejected> {
        if self.points.len() != alone.len() {
            return Err(Rejected::new("points", format!("{} points alone, {} joined", alone.len(), self.points.len())));
        }
        if self.points.iter().zip(alone).all(|(a, b)| checker::same_place(topology, spelled(a), spelled(b))) {
            return Ok(());
        }
        Err(Rejected::new("points", "the points alone differ from the joined ones"))
    }

    /// Returns how many places could not be decided, and the turns from path to path.
    fn judge_paths(&self, surface: &Surface, topology: &Topology) -> Result<(usize, Vec<Turn>), Rejected> {
        let mut undecided = 0;
        let mut all = Vec::with_capacity(self.paths.len());
        for (i, path) in self.paths.iter().enumerate() {
            let stretches = stretches(surface, path);
            let verdict = judge_stretches(topology, path, &stretches, self.points[i], self.points[i + 1]);
            undecided += verdict.map_err(|r| Rejected { detail: format!("path {i}: {}", r.detail), ..r })?;
            all.push(stretches);
        }
        Ok((undecided, checker::turns(topology, &all)))
    }

    fn check_length(&self, given: f64) -> Result<(), Rejected> {
        let sum: f64 = self.paths.iter().map(|path| path.length()).sum();
        let agrees = (given - sum).abs() <= 1e-9 * sum; // not so for NaN
        if agrees {
            return Ok(());
        }
        Err(Rejected::new("wrong_length", format!("given as {given:e}, its paths measure {sum:e}")))
    }
}

/// One path fewer than points; parameters that grow from 0 to 1.
fn check_counts(segment: &SegmentTrace) -> Result<(), Rejected> {
    let (points, paths, parameters) = (segment.points().len(), segment.paths().len(), segment.parameters());
    if points != paths + 1 || points != parameters.len() {
        let detail = format!("{points} points, {paths} paths and {} parameters", parameters.len());
        return Err(Rejected::new("points", detail));
    }
    let ends = [parameters.first(), parameters.last()].map(|t| t.copied());
    if ends != [Some(0.0), Some(1.0)] || !parameters.windows(2).all(|w| w[0] < w[1]) {
        return Err(Rejected::new("parameters", "they do not grow from 0 to 1"));
    }
    Ok(())
}

/// Weighs what a trace says of itself against what its scheme is to keep.
fn what_it_says(
    scheme: &NamedScheme,
    turns: &[Turn],
    short: f64,
    bound: Option<TraceBound>,
    jumps: usize,
) -> Result<Status, Rejected> {
    if jumps > 0 {
        let excused = scheme.is_for_comparison();
        return if excused { Ok(Status::Broken) } else { Err(Rejected::new("jumps", format!("{jumps} of them"))) };
    }
    let Some(most) = scheme.most_turn_deg() else {
        return match bound {
            Some(bound) => Err(Rejected::new("bound", format!("{bound:?}: the scheme has none"))),
            None => Ok(Status::Ok),
        };
    };
    let excused = |turn: &&Turn| match bound {
        Some(TraceBound::Length) => turn.shorter < short,
        Some(_) => true,
        None => false,
    };
    let straight = |turn: &Turn| turn.degrees <= most + TURN_ROUNDING; // not so for NaN
    match turns.iter().filter(|turn| !excused(turn)).find(|turn| !straight(turn)) {
        Some(turn) => {
            let Turn { degrees, shorter } = turn;
            let says = bound.map_or("no bound".to_owned(), |bound| format!("{bound:?} as a bound"));
            let detail = format!(
                "{degrees:.6}° beside a path of length {shorter:e}, where {most:.6}° are allowed; it names {says}"
            );
            Err(Rejected::new("turn", detail))
        }
        None => Ok(bound.map_or(Status::Ok, Status::Bound)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{random, random::SplitMix64, scheme};
    use bevy_surface_splines::{
        curve::{Sampling, Scheme, Tracer},
        surface::{SurfaceOptions, shapes},
    };

    fn named(name: &str) -> NamedScheme {
        scheme::find(name).unwrap()
    }

    /// Traces random polygons on a torus by one scheme and judges them as if another had made them; gives the verdicts'
    /// words, and how far each trace turns.
    fn judged(traced: Scheme, claimed: &NamedScheme, spoil: fn(&mut Vec<SurfacePoint>)) -> Vec<(String, f64)> {
        let mesh = shapes::torus(2.0, 0.8, 48, 24);
        let surface = Surface::build(&mesh, &SurfaceOptions::default()).unwrap();
        let topology = Topology::new(&mesh);
        let mut random = SplitMix64::new(3);
        let mut tracer = Tracer::new(&surface);
        let one = |_| {
            let polygon = random::polygon(&surface, &mut random).unwrap();
            let polygon = &polygon[..claimed.takes];
            let trace = tracer.trace(polygon, &traced).unwrap();
            let mut alone = Vec::new();
            tracer.trace_points(polygon, &traced, &mut alone).unwrap();
            spoil(&mut alone);
            let paths = trace.segments().iter().flat_map(|s| s.paths());
            let stretches: Vec<_> = paths.map(|path| stretches(&surface, path)).collect();
            let turn = checker::largest_turn(&checker::turns(&topology, &stretches));
            let verdict = super::trace(&surface, &topology, polygon, claimed, &trace, &alone);
            (verdict.map_or_else(|r| r.status, |j| j.status).to_string(), turn)
        };
        (0..20).map(one).collect()
    }

    #[test]
    fn every_scheme_passes_as_itself() {
        for scheme in scheme::ALL.iter().filter(|s| !s.is_for_comparison()) {
            for (verdict, turn) in judged(scheme.scheme, scheme, |_| ()) {
                assert_eq!(verdict, "ok", "{}: {turn}", scheme.name);
            }
        }
    }

    #[test]
    fn traces_that_turn_more_than_they_claim_fail() {
        for (scheme, name) in [(Scheme::de_casteljau(), "rdc-adaptive"), (Scheme::lane_riesenfeld(), "olr-adaptive")] {
            let loose = Sampling::Adaptive { turn: 8.0_f64.to_radians(), length: None };
            let mut failed = 0;
            for (verdict, turn) in judged(Scheme { sampling: loose, ..scheme }, &named(name), |_| ()) {
                assert_eq!(verdict, if turn > 5.0 { "error:turn" } else { "ok" }, "{turn}");
                failed += usize::from(turn > 5.0);
            }
            assert!(failed >= 10, "{failed}");
        }
    }

    #[test]
    fn a_bound_excuses_adaptive_traces_alone() {
        let says = |name: &str, degrees: f64, bound: Option<TraceBound>| {
            let turns = [Turn { degrees: 1.0, shorter: 1.0 }, Turn { degrees, shorter: 0.1 }];
            what_it_says(&named(name), &turns, 0.01, bound, 0).unwrap_or_else(|r| r.status).to_string()
        };
        let bound = Some(TraceBound::Pieces);
        for (name, turn, bound, expected) in [
            ("olr-adaptive", 6.0, None, "error:turn"),
            ("olr-adaptive", 5.000_01, None, "error:turn"),
            ("olr-adaptive", 5.000_000_1, None, "ok"),
            ("olr-adaptive", f64::NAN, None, "error:turn"),
            ("olr-adaptive", 6.0, bound, "pieces_bound"),
            ("olr", 90.0, None, "ok"),
            ("olr", 3.0, bound, "error:bound"),
            ("rcm", 180.0, None, "ok"),
        ] {
            assert_eq!(says(name, turn, bound), expected, "{name} {turn}");
        }
    }

    #[test]
    fn short_pieces_excuse_turns_beside_short_paths_alone() {
        for (shorter, expected) in [(0.009, "length_bound"), (0.1, "error:turn")] {
            let turns = [Turn { degrees: 90.0, shorter }];
            let says = what_it_says(&named("rdc-adaptive"), &turns, 0.01, Some(TraceBound::Length), 0);
            assert_eq!(says.unwrap_or_else(|r| r.status).to_string(), expected);
        }
    }

    #[test]
    fn only_schemes_for_comparison_may_jump() {
        let says = |name: &str| what_it_says(&named(name), &[], 0.0, None, 2).unwrap_or_else(|r| r.status).to_string();
        assert_eq!(
            ["direct", "rcm", "rdc", "olr-adaptive"].map(says),
            ["broken", "broken", "error:jumps", "error:jumps"]
        );
    }

    #[test]
    fn other_curves_and_other_points_fail() {
        let (spline, bezier) = (named("bspline2"), named("rdc"));
        assert!(judged(spline.scheme, &bezier, |_| ()).iter().all(|(verdict, _)| verdict == "error:segments"));
        assert!(judged(bezier.scheme, &spline, |_| ()).iter().all(|(verdict, _)| verdict == "error:segments"));
        let verdicts = [
            judged(spline.scheme, &spline, |points| points.truncate(points.len() - 1)),
            judged(spline.scheme, &spline, |points| points.swap(7, 8)),
        ];
        assert!(verdicts.iter().flatten().all(|(verdict, _)| verdict == "error:points"), "{verdicts:?}");
    }
}
