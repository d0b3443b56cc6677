//! The surface itself.

use glam::{DVec2, DVec3};

use super::{
    BuildProgress, Bvh, Clusters, FaceId, HalfEdge, PointError, SurfaceError, SurfacePoint, SurfaceReport,
    TriangleMesh, VertexId, build, fans, metric, options::SurfaceOptions,
};

/// Marks an input face that is not part of the surface.
pub(crate) const DROPPED: u32 = u32::MAX;
/// Set where input corners two and three are swapped inside; face numbers need 30 bits.
pub(crate) const FLIPPED: u32 = 1 << 31;

/// A triangle mesh that one can walk on: welded, oriented, every edge with at most two faces, every vertex one fan.
///
/// Built once, immutable, shared by reference. About 100 bytes a face, and hardly more while it is built;
/// [`memory`](Self::memory) tells what for.
///
/// ```
/// use bevy_surface_splines::surface::{FaceId, Surface, SurfaceOptions, shapes};
///
/// let surface = Surface::build(&shapes::icosphere(2), &SurfaceOptions::default())?;
/// let point = surface.point(FaceId(7), [0.2, 0.3, 0.5])?;
/// assert!((surface.position(&point).length() - 1.0).abs() < 0.1);
/// assert!(surface.report().is_closed());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Surface {
    /// Corners of each inner face.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Across each side: the side it meets.
    pub(crate) twins: Vec<[HalfEdge; 3]>,
    /// Length of each side.
    pub(crate) lengths: Vec<[f64; 3]>,
    /// Relative to `origin`.
    pub(crate) positions: Vec<DVec3>,
    /// Where the inner coordinates begin: zero, unless the mesh lies so far away that lengths would lose digits.
    pub(crate) origin: DVec3,
    /// An outgoing half-edge of each vertex, the most clockwise one at a boundary.
    pub(crate) outgoing: Vec<HalfEdge>,
    /// Total angle of the faces about each vertex.
    pub(crate) angle: Vec<f64>,
    pub(crate) boundary: Vec<bool>,
    /// The sheet of each inner face.
    pub(crate) sheet: Vec<u32>,
    /// For each sheet what the search adds to every side so that needles become ordinary triangles (intrinsic
    /// mollification, Sharp & Crane 2020). Zero on sound meshes.
    pub(crate) slack: Vec<f64>,
    /// Mean length of a side, for each sheet.
    pub(crate) mean_edge: Vec<f64>,
    /// Input face → inner face, with [`FLIPPED`], or [`DROPPED`].
    pub(crate) inner_of: Vec<u32>,
    /// Inner face → input face, with [`FLIPPED`].
    pub(crate) outer_of: Vec<u32>,
    /// Hash of all that points and paths depend on, exactly.
    pub(crate) identity: u64,
    /// Hash by which the mesh is known again.
    pub(crate) fingerprint: u64,
    pub(crate) min: DVec3,
    pub(crate) max: DVec3,
    pub(crate) report: SurfaceReport,
    pub(crate) bvh: Bvh,
    pub(crate) clusters: Clusters,
}

/// A point in inner spelling: inner face, weights of its inner corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InnerPoint {
    pub(crate) face: u32,
    pub(crate) weights: [f64; 3],
}

/// Where a ray meets the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The place.
    pub point: SurfacePoint,
    /// Its position.
    pub position: DVec3,
    /// The unit normal of the face, towards the side from which its corners run counter-clockwise.
    pub normal: DVec3,
    /// Distance from the ray's origin.
    pub distance: f64,
}

/// The place on the surface that is nearest to some position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// The place.
    pub point: SurfacePoint,
    /// Its position.
    pub position: DVec3,
    /// Its distance from the position asked about.
    pub distance: f64,
}

/// # Building
impl Surface {
    /// Builds a surface from raw triangles, repairing what can be repaired; [`report`](Self::report) says what was done.
    ///
    /// Cost: O(F log F); half a second for a million faces, on two threads with the feature `parallel`. The result does not
    /// depend on threads.
    ///
    /// # Errors
    /// [`SurfaceError`] if there is nothing to build from, or if the options refuse what was found.
    pub fn build(mesh: &TriangleMesh, options: &SurfaceOptions) -> Result<Self, SurfaceError> {
        build::build(mesh, options, &BuildProgress::default())
    }

    /// As [`build`](Self::build), while another thread watches and may cancel.
    ///
    /// # Errors
    /// As [`build`](Self::build), and [`SurfaceError::Cancelled`].
    pub fn build_observed(
        mesh: &TriangleMesh,
        options: &SurfaceOptions,
        progress: &BuildProgress,
    ) -> Result<Self, SurfaceError> {
        build::build(mesh, options, progress)
    }

    /// What was found in the mesh, and what was done about it.
    pub fn report(&self) -> &SurfaceReport {
        &self.report
    }
}

/// # Size
impl Surface {
    /// Number of input faces; some may have been dropped.
    pub fn face_count(&self) -> usize {
        self.inner_of.len()
    }

    /// Number of vertices after welding and splitting.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Lower and upper corner of the bounding box.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        (self.min, self.max)
    }

    /// A 64-bit hash of welded positions and input faces, by which documents know the mesh again: the same for every file
    /// format and for the mesh of an engine, since positions count as `f32`
    /// ([`TriangleMesh::fingerprint`](super::TriangleMesh::fingerprint)).
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// A 64-bit hash of positions and faces as they are inside: surfaces that share it have the same points and paths to the
    /// last bit.
    pub(crate) fn identity(&self) -> u64 {
        self.identity
    }

    /// Length of the bounding box's diagonal, by which relative tolerances are measured.
    pub fn diagonal(&self) -> f64 {
        self.report.diagonal
    }
}

/// # Points
impl Surface {
    /// Makes a point from a face and the weights of its corners.
    ///
    /// # Errors
    /// [`PointError`] if the weights are not barycentric, the face does not exist or was dropped.
    pub fn point(&self, face: FaceId, weights: [f64; 3]) -> Result<SurfacePoint, PointError> {
        let point = SurfacePoint::new(face, weights)?;
        self.inner_face(face)?;
        Ok(point)
    }

    /// Position of a point; NaN if the point does not belong to this surface.
    pub fn position(&self, point: &SurfacePoint) -> DVec3 {
        match (self.inner_point(point), self.inner_face(point.face)) {
            (Ok(_), Ok(face)) => {
                let weights = unflip(point.weights, self.outer_of[face as usize]);
                self.origin + self.inner_position(&InnerPoint { face, weights })
            }
            _ => DVec3::NAN,
        }
    }

    /// Unit normal of the point's face, towards the side from which the (oriented) corners run counter-clockwise; zero
    /// for a face without area, NaN if the point does not belong to this surface.
    pub fn normal(&self, point: &SurfacePoint) -> DVec3 {
        match self.inner_face(point.face) {
            Ok(face) => self.face_normal(face),
            Err(_) => DVec3::NAN,
        }
    }

    /// Positions of a face's corners, in input order.
    ///
    /// # Errors
    /// [`PointError`] if the face does not exist or was dropped.
    pub fn corners(&self, face: FaceId) -> Result<[DVec3; 3], PointError> {
        Ok(self.vertices(face)?.map(|v| self.origin + self.positions[v.0 as usize]))
    }

    /// Vertices at a face's corners, in input order.
    ///
    /// # Errors
    /// [`PointError`] if the face does not exist or was dropped.
    pub fn vertices(&self, face: FaceId) -> Result<[VertexId; 3], PointError> {
        let inner = self.inner_face(face)?;
        let t = self.triangles[inner as usize];
        Ok(unflip(t, self.outer_of[inner as usize]).map(VertexId))
    }

    /// Position of a vertex, if there is such a vertex.
    pub fn vertex_position(&self, vertex: VertexId) -> Option<DVec3> {
        Some(self.origin + *self.positions.get(vertex.0 as usize)?)
    }

    /// The sheet a face belongs to: paths exist only between faces of one sheet.
    ///
    /// # Errors
    /// [`PointError`] if the face does not exist or was dropped.
    pub fn sheet(&self, face: FaceId) -> Result<u32, PointError> {
        Ok(self.sheet[self.inner_face(face)? as usize])
    }

    /// Mean length of the edges of the sheet that a face lies on.
    ///
    /// # Errors
    /// As [`sheet`](Self::sheet).
    pub fn mean_edge_length(&self, face: FaceId) -> Result<f64, PointError> {
        Ok(self.mean_edge[self.sheet(face)? as usize])
    }

    /// The spelling of a point with the smallest face number: a point on a side or corner has one spelling a face.
    ///
    /// # Errors
    /// [`PointError`] if the point does not belong to this surface.
    pub fn canonical(&self, point: &SurfacePoint) -> Result<SurfacePoint, PointError> {
        let inner = self.inner_point(point)?;
        let mut best = *point;
        self.for_each_spelling(&inner, |spelling| {
            let spelling = self.outer_point(&spelling);
            if spelling.face < best.face {
                best = spelling;
            }
        });
        Ok(best)
    }

    /// Whether two points are one place: positions within 1e-12 of the diagonal, and a face in common.
    pub fn same_place(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        let (Ok(p), Ok(q)) = (self.inner_point(a), self.inner_point(b)) else { return false };
        let near = self.inner_position(&p).distance(self.inner_position(&q)) <= 1e-12 * self.diagonal();
        let mut shared = p.face == q.face;
        if near && !shared {
            self.for_each_spelling(&p, |s| self.for_each_spelling(&q, |t| shared |= s.face == t.face));
        }
        near && shared
    }
}

/// # Queries in space
impl Surface {
    /// The first place where a ray meets the surface, from either side.
    pub fn ray(&self, origin: DVec3, direction: DVec3) -> Option<RayHit> {
        let hit = self.bvh.ray(&self.positions, &self.triangles, origin - self.origin, direction, f64::INFINITY)?;
        Some(self.ray_hit(hit.face, hit.weights, hit.distance))
    }

    /// All places where a ray meets the surface, from either side, nearest first.
    pub fn ray_through(&self, origin: DVec3, direction: DVec3) -> Vec<RayHit> {
        let mut hits = Vec::new();
        let origin = origin - self.origin;
        self.bvh.ray_all(&self.positions, &self.triangles, origin, direction, f64::INFINITY, &mut |hit| {
            hits.push(self.ray_hit(hit.face, hit.weights, hit.distance));
        });
        hits.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.point.face.cmp(&b.point.face)));
        hits
    }

    fn ray_hit(&self, face: u32, weights: [f64; 3], distance: f64) -> RayHit {
        let inner = InnerPoint { face, weights };
        RayHit {
            point: self.outer_point(&inner),
            position: self.origin + self.inner_position(&inner),
            normal: self.face_normal(face),
            distance,
        }
    }

    /// The place on the surface that is nearest to a position; none for a position that is not finite, or so far away (1e150
    /// sizes of the mesh) that no distance can be told.
    pub fn closest_point(&self, position: DVec3) -> Option<ClosestPoint> {
        let found = self.bvh.closest(&self.positions, &self.triangles, position - self.origin, f64::INFINITY)?;
        let inner = InnerPoint { face: found.face, weights: found.weights };
        Some(ClosestPoint {
            point: self.outer_point(&inner),
            position: self.origin + self.inner_position(&inner),
            distance: found.distance,
        })
    }
}

// Inner spelling.
impl Surface {
    pub(crate) fn inner_face(&self, face: FaceId) -> Result<u32, PointError> {
        match self.inner_of.get(face.0 as usize) {
            None => Err(PointError::NoSuchFace(face, self.inner_of.len())),
            Some(&DROPPED) => {
                let found = self.report.dropped.binary_search_by_key(&face, |d| d.0);
                let reason = found.map_or(super::DropReason::RepeatedCorner, |i| self.report.dropped[i].1);
                Err(PointError::FaceDropped(face, reason))
            }
            Some(inner) => Ok(inner & !FLIPPED),
        }
    }

    pub(crate) fn inner_point(&self, point: &SurfacePoint) -> Result<InnerPoint, PointError> {
        let face = self.inner_face(point.face)?;
        let sum: f64 = point.weights.iter().sum();
        if !point.weights.iter().all(|w| *w >= 0.0) || (sum - 1.0).abs() > 1e-6 {
            return Err(PointError::BadWeights(point.face, point.weights));
        }
        Ok(InnerPoint { face, weights: unflip(point.weights, self.outer_of[face as usize]) }.snapped())
    }

    pub(crate) fn outer_point(&self, inner: &InnerPoint) -> SurfacePoint {
        let outer = self.outer_of[inner.face as usize];
        SurfacePoint { face: FaceId(outer & !FLIPPED), weights: unflip(inner.weights, outer) }
    }

    /// Position relative to `origin`.
    pub(crate) fn inner_position(&self, p: &InnerPoint) -> DVec3 {
        let t = self.triangles[p.face as usize];
        p.weights[0] * self.positions[t[0] as usize]
            + p.weights[1] * self.positions[t[1] as usize]
            + p.weights[2] * self.positions[t[2] as usize]
    }

    pub(crate) fn face_normal(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.triangles[face as usize].map(|v| self.positions[v as usize]);
        // Scaled first: the cross product of tiny sides must not underflow.
        let scale = 1.0 / self.lengths[face as usize].iter().fold(0.0_f64, |m, l| m.max(*l));
        ((b - a) * scale).cross((c - a) * scale).normalize_or_zero()
    }

    #[inline]
    pub(crate) fn twin(&self, h: HalfEdge) -> HalfEdge {
        self.twins[h.face() as usize][h.side()]
    }

    #[inline]
    pub(crate) fn origin(&self, h: HalfEdge) -> u32 {
        self.triangles[h.face() as usize][h.side()]
    }

    #[inline]
    pub(crate) fn target(&self, h: HalfEdge) -> u32 {
        let side = h.side();
        self.triangles[h.face() as usize][if side == 2 { 0 } else { side + 1 }]
    }

    /// Length of a side.
    #[inline]
    pub(crate) fn length(&self, h: HalfEdge) -> f64 {
        self.lengths[h.face() as usize][h.side()]
    }

    /// Total angle about a vertex and, unless it lies on the boundary, its curvature 2π − angle.
    #[inline]
    pub(crate) fn curvature(&self, vertex: u32) -> f64 {
        std::f64::consts::TAU - self.angle[vertex as usize]
    }

    /// The next outgoing half-edge counter-clockwise about the same vertex, or none at the boundary.
    #[inline]
    pub(crate) fn counter_clockwise(&self, h: HalfEdge) -> HalfEdge {
        fans::counter_clockwise(&self.twins, h)
    }

    /// Corners of a face laid flat: corner 0 at the origin, corner 1 on the x axis, corner 2 above it.
    pub(crate) fn flat(&self, face: u32) -> [DVec2; 3] {
        let l = self.lengths[face as usize];
        let b = DVec2::new(l[0], 0.0);
        [DVec2::ZERO, b, metric::apex(DVec2::ZERO, b, l[0], l[2], l[1])]
    }

    /// Angle of the corner at the origin of `h`, between `h` and the side before it.
    pub(crate) fn corner_angle(&self, h: HalfEdge) -> f64 {
        metric::corner_angle(self.length(h), self.length(h.prev()), self.length(h.next()))
    }

    /// Visits all spellings of a point: one for a point inside a face, one a face around its side or corner. Only weights
    /// of exactly zero count; the given spelling comes first.
    pub(crate) fn for_each_spelling(&self, p: &InnerPoint, mut visit: impl FnMut(InnerPoint)) {
        visit(*p);
        match p.zeros() {
            Zeros::None => {}
            Zeros::Side(k) => {
                let h = HalfEdge::new(p.face, k);
                if let Some(other) = self.across(p, h) {
                    visit(other);
                }
            }
            Zeros::Corner(k) => {
                let vertex = self.triangles[p.face as usize][k as usize];
                let first = self.outgoing[vertex as usize];
                let mut h = first;
                loop {
                    if h.face() != p.face {
                        let mut weights = [0.0; 3];
                        weights[h.side()] = 1.0;
                        visit(InnerPoint { face: h.face(), weights });
                    }
                    h = self.counter_clockwise(h);
                    if !h.is_some() || h == first {
                        break;
                    }
                }
            }
        }
    }

    /// The spelling across side `h` of a point on that side, unless the side is boundary.
    pub(crate) fn across(&self, p: &InnerPoint, h: HalfEdge) -> Option<InnerPoint> {
        let twin = self.twin(h);
        if !twin.is_some() {
            return None;
        }
        let mut weights = [0.0; 3];
        weights[twin.next().side()] = p.weights[h.side()];
        weights[twin.side()] = p.weights[h.next().side()];
        Some(InnerPoint { face: twin.face(), weights })
    }
}

/// Where an inner point lies, judged by weights of exactly zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Zeros {
    None,
    Side(u32),
    Corner(u32),
}

impl InnerPoint {
    pub(crate) fn zeros(&self) -> Zeros {
        match self.weights.map(|w| w == 0.0) {
            [false, true, true] => Zeros::Corner(0),
            [true, false, true] => Zeros::Corner(1),
            [true, true, false] => Zeros::Corner(2),
            [false, false, true] => Zeros::Side(0),
            [true, false, false] => Zeros::Side(1),
            [false, true, false] => Zeros::Side(2),
            _ => Zeros::None,
        }
    }

    /// The point as geodesics see it: weights below 1e-10 are zero. A point a hair beside a side or corner would make stretches
    /// too short to have a direction.
    pub(crate) fn snapped(self) -> Self {
        const ON_ELEMENT: f64 = 1e-10;
        if self.weights.iter().all(|w| *w == 0.0 || *w >= ON_ELEMENT) {
            return self;
        }
        let weights = self.weights.map(|w| if w < ON_ELEMENT { 0.0 } else { w });
        let sum: f64 = weights.iter().sum();
        Self { face: self.face, weights: weights.map(|w| w / sum) }
    }

    /// A point on side `h`, at `t` of the way from its origin.
    pub(crate) fn on_side(h: HalfEdge, t: f64) -> Self {
        let mut weights = [0.0; 3];
        weights[h.side()] = 1.0 - t;
        weights[h.next().side()] = t;
        Self { face: h.face(), weights }
    }
}

/// Swaps corners two and three where the face is flipped; its own inverse.
fn unflip<T: Copy>(of_corners: [T; 3], face: u32) -> [T; 3] {
    let [a, b, c] = of_corners;
    if face & FLIPPED != 0 { [a, c, b] } else { [a, b, c] }
}

impl Surface {
    /// An inner half-edge as input face and input side, and whether its direction is reversed there.
    pub(crate) fn outer_side(&self, h: HalfEdge) -> (FaceId, u8, bool) {
        let outer = self.outer_of[h.face() as usize];
        let flipped = outer & FLIPPED != 0;
        let side = h.side() as u8;
        (FaceId(outer & !FLIPPED), if flipped { 2 - side } else { side }, flipped)
    }

    /// The inner half-edge of an input face's side, and whether its direction is reversed.
    pub(crate) fn inner_side(&self, face: FaceId, side: u8) -> Result<(HalfEdge, bool), PointError> {
        let inner = self.inner_face(face)?;
        if side > 2 {
            return Err(PointError::BadCrossing(face));
        }
        let flipped = self.outer_of[inner as usize] & FLIPPED != 0;
        let side = u32::from(side);
        Ok((HalfEdge::new(inner, if flipped { 2 - side } else { side }), flipped))
    }
}
