//! The polyline a scheme produces.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

use super::{SplineT, segment::SegmentKey};
use crate::geodesic::{GeodesicPath, inner::InnerPath};
use crate::surface::{Surface, SurfacePoint};

/// What kept an adaptive trace from being as straight as asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TraceBound {
    /// A piece was halved twenty times.
    Depth,
    /// The segment has 4,096 pieces.
    Pieces,
    /// A bent piece is shorter than 1e-10 of the surface's diagonal: a cusp.
    Length,
}

/// A place where points of a trace are apart however near their parameters are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// The local parameter.
    pub t: f64,
    /// How far apart the points are, in local units.
    pub length: f64,
}

/// The trace of one segment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SegmentTrace {
    pub(crate) key: Option<SegmentKey>,
    points: Vec<SurfacePoint>,
    pub(crate) parameters: Vec<f64>,
    paths: Vec<GeodesicPath>,
    polyline: Vec<DVec3>,
    /// Distance along the trace of each vertex of the polyline.
    pub(crate) distances: Vec<f64>,
    /// Where each path begins in the polyline, and one past the end.
    pub(crate) begins: Vec<u32>,
    bound: Option<TraceBound>,
    pub(crate) jumps: Vec<Jump>,
}

impl SegmentTrace {
    /// Becomes the trace made of the geodesics between consecutive points, keeping memory.
    pub(crate) fn fill(&mut self, surface: &Surface, paths: &[InnerPath], bound: Option<TraceBound>) {
        self.bound = bound;
        self.points.clear();
        self.polyline.clear();
        self.distances.clear();
        self.begins.clear();
        self.paths.truncate(paths.len());
        let (mut sum, mut last) = (0.0, None);
        for (i, path) in paths.iter().enumerate() {
            if i == 0 {
                self.push(surface, surface.inner_position(&path.start), &mut last, &mut sum);
            }
            self.points.push(surface.outer_point(&path.start));
            self.begins.push(self.polyline.len() as u32 - 1);
            for k in 0..path.strip.len() {
                self.push(surface, path.crossing_position(surface, k), &mut last, &mut sum);
            }
            self.push(surface, surface.inner_position(&path.end), &mut last, &mut sum);
            match self.paths.get_mut(i) {
                Some(out) => path.outer_into(surface, out),
                None => self.paths.push(path.to_outer(surface)),
            }
        }
        self.points.extend(paths.last().map(|path| surface.outer_point(&path.end)));
        self.begins.push(self.polyline.len().saturating_sub(1) as u32);
    }

    /// Adds a vertex to the polyline.
    fn push(&mut self, surface: &Surface, p: DVec3, last: &mut Option<DVec3>, sum: &mut f64) {
        // Lengths are measured before the origin is added: far away it would swallow their digits.
        *sum += last.map_or(0.0, |last| last.distance(p));
        *last = Some(p);
        self.polyline.push(surface.origin + p);
        self.distances.push(*sum);
    }

    /// The scheme's points.
    pub fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    /// The positions of the scheme's points.
    pub fn point_positions(&self) -> impl Iterator<Item = DVec3> + '_ {
        let begins = self.begins.get(..self.points.len()).unwrap_or_default();
        begins.iter().filter_map(|begin| self.polyline.get(*begin as usize).copied())
    }

    /// The local parameter of each point, growing from 0 to 1.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// The geodesics between consecutive points.
    pub fn paths(&self) -> &[GeodesicPath] {
        &self.paths
    }

    /// Points and crossings of sides, as positions in order.
    pub fn polyline(&self) -> &[DVec3] {
        &self.polyline
    }

    /// Length along the trace.
    pub fn length(&self) -> f64 {
        self.distances.last().copied().unwrap_or(0.0)
    }

    /// Distance along the trace of each vertex of the polyline.
    pub(crate) fn distances(&self) -> &[f64] {
        &self.distances
    }

    /// The local parameter at a distance along this segment.
    pub(crate) fn parameter_along(&self, distance: f64) -> f64 {
        let Some(last) = self.distances.len().checked_sub(1) else { return 0.0 };
        let path = self.path_at(self.distances.partition_point(|d| *d < distance).min(last));
        let ends = |values: &dyn Fn(usize) -> f64| [values(path), values(path + 1)];
        let [from, to] = ends(&|k| self.begins.get(k).map_or(0.0, |begin| self.distances[*begin as usize]));
        let [t0, t1] = ends(&|k| self.parameters.get(k).copied().unwrap_or(1.0));
        let share = if to > from { ((distance - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        t0 + share * (t1 - t0)
    }

    /// What kept an adaptive trace from being as straight as asked for, if anything did.
    pub fn bound(&self) -> Option<TraceBound> {
        self.bound
    }

    /// Where the curve is torn: of the schemes that are there for comparison only, others have no such place.
    pub fn jumps(&self) -> &[Jump] {
        &self.jumps
    }

    /// The path that a vertex of the polyline belongs to: the one that ends at or after it.
    fn path_at(&self, vertex: usize) -> usize {
        let after = self.begins.partition_point(|b| (*b as usize) < vertex.max(1));
        (after - 1).min(self.paths.len().saturating_sub(1))
    }

    /// The path that a local parameter is on, and the share of it that lies before.
    fn path_share(&self, local: f64) -> Option<(usize, f64)> {
        let last = self.paths.len().checked_sub(1)?;
        let i = self.parameters.partition_point(|p| *p <= local).saturating_sub(1).min(last);
        let [from, to] = [self.parameters[i], self.parameters[i + 1]];
        let share = if to > from { (local - from) / (to - from) } else { 0.0 };
        Some((i, share.clamp(0.0, 1.0)))
    }

    /// The polyline's position at a local parameter.
    fn position_at(&self, local: f64) -> Option<DVec3> {
        let (path, share) = self.path_share(local)?;
        let [first, last] = [path, path + 1].map(|i| self.begins[i] as usize);
        let distances = &self.distances[first..=last];
        let [from, to] = [distances[0], distances[last - first]];
        let along = from + share * (to - from);
        let after = distances.partition_point(|d| *d < along).clamp(1, last - first);
        let [before, after] = [first + after - 1, first + after];
        let [from, to] = [self.distances[before], self.distances[after]];
        let share = if to > from { ((along - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        Some(self.polyline[before].lerp(self.polyline[after], share))
    }

    /// Local parameter and point at a distance along this segment.
    fn at_distance(&self, surface: &Surface, distance: f64) -> Option<(f64, SurfacePoint)> {
        let distance = distance.clamp(0.0, self.length());
        let vertex = self.distances.partition_point(|d| *d < distance).min(self.distances.len() - 1);
        let path = self.path_at(vertex);
        let [from, to] = [path, path + 1].map(|i| self.distances[self.begins[i] as usize]);
        let share = if to > from { ((distance - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        let [t0, t1] = [self.parameters[path], self.parameters[path + 1]];
        Some((t0 + share * (t1 - t0), self.paths[path].at(surface, share).ok()?))
    }
}

/// The trace of a spline: its segments' traces, shared with earlier traces where nothing changed.
///
/// It depends on surface and spline alone: the same bits whatever was traced before, and on however many threads.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    pub(super) segments: Vec<Arc<SegmentTrace>>,
    pub(super) retraced: Vec<u32>,
}

/// Two traces are equal if their segments are; how they came about does not count.
impl PartialEq for Trace {
    fn eq(&self, other: &Self) -> bool {
        self.segments == other.segments
    }
}

/// The place on a trace that is nearest to a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestOnTrace {
    /// Its parameter.
    pub t: SplineT,
    /// Its distance along the trace.
    pub along: f64,
    /// The place.
    pub point: SurfacePoint,
    /// Its position.
    pub position: DVec3,
    /// Its distance from the position asked about.
    pub distance: f64,
}

impl Trace {
    pub(crate) fn new(segments: Vec<Arc<SegmentTrace>>, retraced: Vec<u32>) -> Self {
        Self { segments, retraced }
    }

    /// The traces of the segments, in order.
    pub fn segments(&self) -> &[Arc<SegmentTrace>] {
        &self.segments
    }

    /// The segments that were computed when this trace was made; the others are shared with the one before.
    pub fn retraced(&self) -> &[u32] {
        &self.retraced
    }

    /// Length along the trace, in local units.
    pub fn length(&self) -> f64 {
        self.segments.iter().map(|s| s.length()).fold(0.0, |sum, length| sum + length)
    }

    /// Points and crossings of sides, as positions in order; points where segments meet appear once.
    pub fn positions(&self) -> Vec<DVec3> {
        let mut out: Vec<DVec3> = Vec::new();
        for segment in &self.segments {
            let skip = usize::from(!out.is_empty());
            out.extend(segment.polyline.iter().skip(skip));
        }
        out
    }

    /// The points of the [`positions`](Self::positions) on the surface, one each, spelled in a face in which the curve runs there; none
    /// for a segment of another surface.
    pub fn surface_points(&self, surface: &Surface) -> Vec<SurfacePoint> {
        let mut out: Vec<SurfacePoint> = Vec::new();
        for segment in &self.segments {
            let start = segment.paths.first().map(GeodesicPath::start).filter(|_| out.is_empty());
            out.extend(start);
            let stretches = segment.paths.iter().flat_map(|path| path.segments(surface));
            out.extend(stretches.map(|stretch| SurfacePoint { face: stretch.face, weights: stretch.to }));
        }
        out
    }

    /// The unbroken pieces of the trace, as ranges of its [`positions`](Self::positions): a single one, unless the curve is
    /// torn. The path across a [`Jump`] is on no piece.
    pub fn pieces(&self) -> Vec<Range<usize>> {
        let mut pieces = Vec::new();
        let (mut begin, mut end) = (0, 0);
        for segment in self.segments.iter().filter(|segment| !segment.polyline.is_empty()) {
            // A segment's first position is the last one of the segment before.
            for (path, _) in segment.jumps.iter().filter_map(|jump| segment.path_share(jump.t)) {
                let [from, to] = [path, path + 1].map(|i| end + segment.begins[i] as usize);
                pieces.push(begin..from + 1);
                begin = to;
            }
            end += segment.polyline.len() - 1;
        }
        pieces.push(begin..end + 1);
        pieces.retain(|piece| piece.len() > 1);
        pieces
    }

    /// The polyline's point at a parameter, clamped to the trace; none for an empty trace, NaN or another surface.
    ///
    /// This is a place on the polyline, within its distance from the curve; [`Spline::evaluate`](super::Spline::evaluate)
    /// gives the curve's own point.
    pub fn point_at(&self, surface: &Surface, t: SplineT) -> Option<SurfacePoint> {
        let (segment, local) = t.split(self.segments.len())?;
        let trace = &self.segments[segment];
        let (path, share) = trace.path_share(local)?;
        trace.paths[path].at(surface, share).ok()
    }

    /// The position of [`point_at`](Self::point_at), to rounding, without the surface; none for an empty trace or NaN.
    ///
    /// At the parameter of one of the scheme's points it is that point's position, bit for bit. Cost: logarithmic in the
    /// points of a segment.
    pub fn position_at(&self, t: SplineT) -> Option<DVec3> {
        let (segment, local) = t.split(self.segments.len())?;
        self.segments[segment].position_at(local)
    }

    /// The point at a distance along the trace, clamped to it; none for an empty trace, NaN or another surface.
    pub fn at_distance(&self, surface: &Surface, distance: f64) -> Option<SurfacePoint> {
        let (segment, rest) = self.segment_at(distance)?;
        Some(self.segments[segment].at_distance(surface, rest)?.1)
    }

    fn segment_at(&self, distance: f64) -> Option<(usize, f64)> {
        if distance.is_nan() {
            return None;
        }
        let mut rest = distance.max(0.0);
        for (i, segment) in self.segments.iter().enumerate() {
            if rest <= segment.length() || i + 1 == self.segments.len() {
                return Some((i, rest));
            }
            rest -= segment.length();
        }
        None
    }

    /// The place on the trace that is nearest to a position (straight through space); none for an empty trace, a position
    /// that is not finite, or another surface.
    ///
    /// Cost: linear in the polyline.
    pub fn nearest(&self, surface: &Surface, position: DVec3) -> Option<NearestOnTrace> {
        if !position.is_finite() {
            return None;
        }
        let (mut best, mut before) = (None, 0.0);
        let mut least = f64::INFINITY;
        for (i, segment) in self.segments.iter().enumerate() {
            for (k, pair) in segment.polyline.windows(2).enumerate() {
                let (a, along) = (pair[0], pair[1] - pair[0]);
                let share = ((position - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                let distance = position.distance_squared(a + share * along);
                if distance < least {
                    least = distance;
                    let [from, to] = [segment.distances[k], segment.distances[k + 1]];
                    best = Some((i, before, from + share * (to - from)));
                }
            }
            before += segment.length();
        }
        let (i, before, local) = best?;
        let (t, point) = self.segments[i].at_distance(surface, local)?;
        let found = surface.position(&point);
        Some(NearestOnTrace {
            t: SplineT(i as f64 + t),
            along: before + local,
            point,
            position: found,
            distance: found.distance(position),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{Method, Scheme, Spline, TraceWorkspace, Tracer};
    use crate::surface::{FaceId, SurfaceOptions, shapes};

    fn torus() -> Surface {
        Surface::build(&shapes::torus(1.0, 0.45, 48, 24), &SurfaceOptions::default()).expect("a surface")
    }

    /// A control polygon on the torus; at 0.75 it is so large that the schemes for comparison break.
    fn polygon(surface: &Surface, size: f64) -> Vec<SurfacePoint> {
        let near = |(u, v): (f64, f64)| {
            let (u, v) = (3.0 * size * u, 0.6 * size * v + 1.0);
            let out = 1.0 + 0.45 * v.cos();
            surface.closest_point(DVec3::new(out * u.sin(), 0.45 * v.sin(), out * u.cos())).expect("a place").point
        };
        [(-1.0, -0.5), (-0.45, 1.0), (0.45, -1.0), (1.0, 0.5)].map(near).to_vec()
    }

    #[test]
    fn every_position_has_its_point() {
        for mesh in [shapes::torus(2.0, 0.7, 24, 12), shapes::grid(6, 6, 2.0, 2.0)] {
            let surface = Surface::build(&mesh, &SurfaceOptions::default()).unwrap();
            let point = |face: u32| SurfacePoint { face: FaceId(face), weights: [0.2, 0.5, 0.3] };
            let faces = surface.face_count() as u32;
            let through: Vec<_> = [1, faces / 5, faces / 2, faces - 3].map(point).into();
            let mut workspace = TraceWorkspace::default();
            for closed in [false, true] {
                let spline = Spline::smooth_through(&surface, &mut workspace.finder, &through, closed).unwrap();
                let trace = spline.trace(&surface, &mut workspace, None).unwrap();
                let (points, positions) = (trace.surface_points(&surface), trace.positions());
                assert_eq!(points.len(), positions.len());
                let apart = points.iter().zip(&positions).map(|(p, at)| surface.position(p).distance(*at));
                assert!(apart.fold(0.0, f64::max) < 1e-12);
            }
        }
    }

    #[test]
    fn positions_on_the_polyline_are_those_of_its_points() {
        let surface = torus();
        for scheme in Method::ALL.map(Scheme::of) {
            let trace = Tracer::new(&surface).trace(&polygon(&surface, 0.5), &scheme).expect("a trace");
            let count = trace.segments().len() as f64;
            for i in -10..=1_010 {
                let t = SplineT(f64::from(i) / 1_000.0 * count);
                let point = trace.point_at(&surface, t).expect("a point");
                let position = trace.position_at(t).expect("a position");
                assert!(surface.position(&point).distance(position) < 1e-12, "{scheme:?} at {t:?}");
            }
            for (i, segment) in trace.segments().iter().enumerate() {
                for (point, t) in segment.points().iter().zip(segment.parameters()) {
                    let position = segment.position_at(*t).expect("a position");
                    assert!(segment.polyline().contains(&position), "{scheme:?}: {i} + {t} is a vertex, bit for bit");
                    assert!(surface.position(point).distance(position) < 1e-12);
                }
            }
            assert_eq!(trace.position_at(SplineT(f64::NAN)), None);
        }
        assert_eq!(Trace::default().position_at(SplineT(0.0)), None);
    }

    #[test]
    fn a_torn_trace_has_pieces_and_every_other_one() {
        let surface = torus();
        let polygon = polygon(&surface, 0.75);
        for scheme in Method::ALL.map(Scheme::of) {
            let trace = Tracer::new(&surface).trace(&polygon, &scheme).expect("a trace");
            let jumps: usize = trace.segments().iter().map(|s| s.jumps().len()).sum();
            assert_eq!(jumps > 0, scheme.method.is_for_comparison(), "{scheme:?}");
            let (positions, pieces) = (trace.positions(), trace.pieces());
            assert_eq!((pieces[0].start, pieces[pieces.len() - 1].end), (0, positions.len()));
            assert_eq!(pieces.len(), jumps + 1);
            // What lies between pieces is long, for it bridges a jump.
            for (pair, jump) in pieces.windows(2).zip(trace.segments().iter().flat_map(|s| s.jumps())) {
                let bridge = &positions[pair[0].end - 1..=pair[1].start];
                let length: f64 = bridge.windows(2).map(|p| p[0].distance(p[1])).sum();
                assert!(length > 0.5 * jump.length, "{length} across {jump:?}");
            }
        }
        assert!(Trace::default().pieces().is_empty());
    }
}
