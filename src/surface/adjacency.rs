//! Which sides of which faces meet.

use glam::DVec3;

use super::{FaceId, HalfEdge, NonManifoldEdges, SurfaceError, options::SurfaceOptions, sort::sort_distinct};

/// Neighbours across the sides of each face, before orientation and splitting.
pub(crate) struct Adjacency {
    /// Across each side: the side it meets, or [`HalfEdge::NONE`].
    pub(crate) twins: Vec<[HalfEdge; 3]>,
    /// Undirected edges in all.
    pub(crate) edges: usize,
    /// Edges with one face.
    pub(crate) boundary_edges: usize,
    /// Edges with three or more faces.
    pub(crate) nonmanifold_edges: usize,
    /// Runs of half-edges on one undirected edge with three or more faces.
    pub(crate) crowded: Vec<Vec<HalfEdge>>,
}

/// Links sides by sorting them by their two vertices: deterministic, O(F log F).
///
/// # Errors
/// [`SurfaceError::NonManifoldEdge`] where the options refuse those.
pub(crate) fn link(
    triangles: &[[u32; 3]],
    positions: &[DVec3],
    options: &SurfaceOptions,
) -> Result<Adjacency, SurfaceError> {
    let mut sides: Vec<(u64, HalfEdge)> = Vec::with_capacity(triangles.len() * 3);
    for (face, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let key = u64::from(a.min(b)) << 32 | u64::from(a.max(b));
            sides.push((key, HalfEdge::new(face as u32, k as u32)));
        }
    }
    sort_distinct(&mut sides);
    let mut out = Adjacency {
        twins: vec![[HalfEdge::NONE; 3]; triangles.len()],
        edges: 0,
        boundary_edges: 0,
        nonmanifold_edges: 0,
        crowded: Vec::new(),
    };
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        out.edges += 1;
        match run {
            [_] => out.boundary_edges += 1,
            [a, b] => out.join(a.1, b.1),
            _ => {
                out.nonmanifold_edges += 1;
                let run: Vec<HalfEdge> = run.iter().map(|s| s.1).collect();
                match options.nonmanifold_edges {
                    NonManifoldEdges::Cut => {}
                    NonManifoldEdges::Pair => out.pair_by_wedge(&run, triangles, positions),
                    NonManifoldEdges::Refuse => {
                        return Err(SurfaceError::NonManifoldEdge { face: FaceId(run[0].face()), count: run.len() });
                    }
                }
                out.crowded.push(run);
            }
        }
    }
    Ok(out)
}

impl Adjacency {
    pub(crate) fn join(&mut self, a: HalfEdge, b: HalfEdge) {
        self.twins[a.face() as usize][a.side()] = b;
        self.twins[b.face() as usize][b.side()] = a;
    }

    /// Sorts the faces by their angle about the edge and joins consecutive pairs whose facing sides bound one wedge.
    ///
    /// A face "opens" a wedge when its front looks along growing angle. An opening face followed by a closing one encloses
    /// space between their fronts; faces left without such a partner stay open.
    fn pair_by_wedge(&mut self, run: &[HalfEdge], triangles: &[[u32; 3]], positions: &[DVec3]) {
        let corner = |h: HalfEdge, k: usize| triangles[h.face() as usize][(h.side() + k) % 3];
        let (low, high) = {
            let (a, b) = (corner(run[0], 0), corner(run[0], 1));
            (a.min(b), a.max(b))
        };
        let origin = positions[low as usize];
        let axis = (positions[high as usize] - origin).normalize_or_zero();
        if axis == DVec3::ZERO {
            return; // an edge without a direction has no order around it: its sides stay open
        }
        let (e1, e2) = axis.any_orthonormal_pair();
        let mut around: Vec<(f64, bool, HalfEdge)> = run
            .iter()
            .map(|&h| {
                let d = positions[corner(h, 2) as usize] - origin;
                (d.dot(e2).atan2(d.dot(e1)), corner(h, 0) == low, h)
            })
            .collect();
        around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        let n = around.len();
        let mut used = vec![false; n];
        for i in 0..n {
            let j = (i + 1) % n;
            let (a, b) = (around[i], around[j]);
            if a.1 && !b.1 && !used[i] && !used[j] && i != j {
                (used[i], used[j]) = (true, true);
                self.join(a.2, b.2);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_faces_on_one_edge_are_cut_or_paired() {
        // Three half planes around the z axis at 0°, 90° and 200°.
        let at = |d: f64| DVec3::new(d.to_radians().cos(), d.to_radians().sin(), 0.5);
        let positions = [DVec3::ZERO, DVec3::Z, at(0.0), at(90.0), at(200.0)];
        let triangles = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        let cut = link(&triangles, &positions, &SurfaceOptions::default()).unwrap();
        assert_eq!((cut.nonmanifold_edges, cut.boundary_edges, cut.edges), (1, 6, 7));
        assert!(cut.twins.iter().flatten().all(|t| !t.is_some()));
        let options = SurfaceOptions { nonmanifold_edges: NonManifoldEdges::Pair, ..Default::default() };
        let paired = link(&triangles, &positions, &options).unwrap();
        assert_eq!(paired.twins[0][0], HalfEdge::new(1, 0));
        assert_eq!(paired.twins[2][0], HalfEdge::NONE);
        let options = SurfaceOptions { nonmanifold_edges: NonManifoldEdges::Refuse, ..Default::default() };
        assert!(matches!(link(&triangles, &positions, &options), Err(SurfaceError::NonManifoldEdge { count: 3, .. })));
    }
}
