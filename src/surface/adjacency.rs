//! Which sides of which faces meet.

use std::ops::Range;

use glam::DVec3;

use super::{
    BuildProgress, FaceId, HalfEdge, NonManifoldEdges, SurfaceError, arranged::Arranged, buckets::Buckets,
    options::SurfaceOptions, parallel,
};

/// Neighbours across the sides of each face, before orientation and splitting.
#[derive(Default)]
pub(crate) struct Adjacency {
    /// Across each side: the side it meets, or [`HalfEdge::NONE`].
    pub(crate) twins: Vec<[HalfEdge; 3]>,
    /// Undirected edges in all.
    pub(crate) edges: usize,
    /// Edges with one face.
    pub(crate) boundary_edges: usize,
    /// The half-edges on each undirected edge with three or more faces; they are not linked.
    pub(crate) crowded: Vec<Vec<HalfEdge>>,
}

/// Links the sides of edges that have two faces. Linear time, but for vertices with very many faces.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn link(
    triangles: &[[u32; 3]],
    vertices: usize,
    progress: &BuildProgress,
) -> Result<Adjacency, SurfaceError> {
    let sides = Sides::new(triangles, vertices, progress)?;
    let mut out = Adjacency::default();
    for piece in parallel::map_pieces(vertices, progress, |vertices| sides.survey(vertices))? {
        out.edges += piece.edges;
        out.boundary_edges += piece.boundary_edges;
        out.crowded.extend(piece.crowded);
    }
    out.twins = parallel::table(triangles.len(), [HalfEdge::NONE; 3], progress, |face| {
        [0, 1, 2].map(|k| sides.twin(triangles, HalfEdge::new(face as u32, k)))
    })?;
    Ok(out)
}

/// All sides, grouped by the smaller of their vertices, in order of the larger and then of faces.
struct Sides(Buckets<u64>);

impl Sides {
    fn new(triangles: &[[u32; 3]], vertices: usize, progress: &BuildProgress) -> Result<Self, SurfaceError> {
        let sides = || {
            (0..triangles.len() as u32).flat_map(|face| {
                [0, 1, 2].map(|k| {
                    let h = HalfEdge::new(face, k);
                    let [low, high] = edge_of(triangles, h);
                    (low, u64::from(high) << 32 | u64::from(h.0))
                })
            })
        };
        Ok(Self(Buckets::new(vertices, sides, progress)?))
    }

    /// Counts the edges from some vertices to larger ones; links nothing.
    fn survey(&self, vertices: Range<usize>) -> Adjacency {
        let mut out = Adjacency::default();
        for low in vertices {
            for run in self.0.of(low as u32).chunk_by(|a, b| a >> 32 == b >> 32) {
                out.edges += 1;
                out.boundary_edges += usize::from(run.len() == 1);
                if run.len() > 2 {
                    out.crowded.push(run.iter().map(|side| HalfEdge(*side as u32)).collect());
                }
            }
        }
        out
    }

    /// The only other side on the edge of `h`.
    #[inline]
    fn twin(&self, triangles: &[[u32; 3]], h: HalfEdge) -> HalfEdge {
        let [low, high] = edge_of(triangles, h);
        let sides = self.0.of(low);
        let first = sides.partition_point(|side| side >> 32 < u64::from(high));
        let on_edge = |i: usize| sides.get(first + i).filter(|side| **side >> 32 == u64::from(high));
        match (on_edge(0), on_edge(1), on_edge(2)) {
            (Some(a), Some(b), None) => HalfEdge(if *a as u32 == h.0 { *b as u32 } else { *a as u32 }),
            _ => HalfEdge::NONE,
        }
    }
}

/// The two vertices of a side, the smaller first.
#[inline]
fn edge_of(triangles: &[[u32; 3]], h: HalfEdge) -> [u32; 2] {
    let t = triangles[h.face() as usize];
    let (a, b) = (t[h.side()], t[h.next().side()]);
    [a.min(b), a.max(b)]
}

impl Adjacency {
    /// Groups of faces that have the same three corners.
    pub(crate) fn copies(&self, triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
        // Copies meet on all three sides: either no other face is there, or one of the edges is crowded.
        let closed_in = |row: &[HalfEdge; 3]| row[0].is_some() && row.iter().all(|t| t.face() == row[0].face());
        let pillows = self.twins.iter().zip(0_u32..).filter(|(row, _)| closed_in(row)).map(|(_, face)| face);
        let mut faces: Vec<u32> = self.crowded.iter().flatten().map(|h| h.face()).chain(pillows).collect();
        faces.sort_unstable();
        faces.dedup();
        let key = |face: &u32| {
            let mut key = triangles[*face as usize];
            key.sort_unstable();
            key
        };
        faces.sort_by_cached_key(key);
        faces.chunk_by(|a, b| key(a) == key(b)).filter(|group| group.len() > 1).map(<[u32]>::to_vec).collect()
    }

    /// Does what the options say about edges with three or more faces.
    ///
    /// # Errors
    /// [`SurfaceError::NonManifoldEdge`] where the options refuse those.
    pub(crate) fn settle_crowded(
        &mut self,
        faces: &Arranged,
        position: impl Fn(u32) -> DVec3,
        options: &SurfaceOptions,
    ) -> Result<(), SurfaceError> {
        // What is done depends on the order of the input, not on that in memory.
        let mut crowded = std::mem::take(&mut self.crowded);
        crowded.sort_by_cached_key(|run| {
            let [a, b] = edge_of(&faces.triangles, run[0]).map(|v| faces.input_vertex[v as usize]);
            (a.min(b), a.max(b))
        });
        for run in &mut crowded {
            run.sort_unstable_by_key(|h| (faces.outer_of[h.face() as usize], h.side()));
            match options.nonmanifold_edges {
                NonManifoldEdges::Cut => {}
                NonManifoldEdges::Pair => self.pair_by_wedge(run, faces, &position),
                NonManifoldEdges::Refuse => {
                    let face = FaceId(faces.outer_of[run[0].face() as usize]);
                    return Err(SurfaceError::NonManifoldEdge { face, count: run.len() });
                }
            }
        }
        self.crowded = crowded;
        Ok(())
    }

    fn join(&mut self, a: HalfEdge, b: HalfEdge) {
        self.twins[a.face() as usize][a.side()] = b;
        self.twins[b.face() as usize][b.side()] = a;
    }

    /// Sorts the faces by their angle about the edge and joins consecutive pairs whose facing sides bound one wedge. Faces
    /// at one angle stay in the order given.
    ///
    /// A face "opens" a wedge when its front looks along growing angle. An opening face followed by a closing one encloses
    /// space between their fronts; faces left without such a partner stay open.
    fn pair_by_wedge(&mut self, run: &[HalfEdge], faces: &Arranged, position: impl Fn(u32) -> DVec3) {
        let corner = |h: HalfEdge, k: usize| faces.triangles[h.face() as usize][(h.side() + k) % 3];
        let mut edge = edge_of(&faces.triangles, run[0]);
        edge.sort_unstable_by_key(|v| faces.input_vertex[*v as usize]);
        let [from, to] = edge;
        let origin = position(from);
        let axis = (position(to) - origin).normalize_or_zero();
        if axis == DVec3::ZERO {
            return; // an edge without a direction has no order around it: its sides stay open
        }
        let (e1, e2) = axis.any_orthonormal_pair();
        let mut around: Vec<(f64, bool, HalfEdge)> = run
            .iter()
            .map(|&h| {
                let d = position(corner(h, 2)) - origin;
                (d.dot(e2).atan2(d.dot(e1)), corner(h, 0) == from, h)
            })
            .collect();
        around.sort_by(|a, b| a.0.total_cmp(&b.0));
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
        let triangles = vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        let faces = Arranged { triangles, outer_of: vec![0, 1, 2], input_vertex: (0..5).collect() };
        let linked = |nonmanifold_edges| {
            let mut links = link(&faces.triangles, positions.len(), &BuildProgress::default()).unwrap();
            let options = SurfaceOptions { nonmanifold_edges, ..Default::default() };
            links.settle_crowded(&faces, |v| positions[v as usize], &options).map(|()| links)
        };
        let cut = linked(NonManifoldEdges::Cut).unwrap();
        assert_eq!((cut.crowded.len(), cut.boundary_edges, cut.edges), (1, 6, 7));
        assert!(cut.twins.iter().flatten().all(|t| !t.is_some()));
        let paired = linked(NonManifoldEdges::Pair).unwrap();
        assert_eq!(paired.twins[0][0], HalfEdge::new(1, 0));
        assert_eq!(paired.twins[2][0], HalfEdge::NONE);
        let refused = linked(NonManifoldEdges::Refuse).err();
        assert!(matches!(refused, Some(SurfaceError::NonManifoldEdge { face: FaceId(0), count: 3 })));
    }

    #[test]
    fn copies_are_found_among_others_and_alone() {
        let triangles = [[0, 1, 2], [2, 1, 0], [0, 1, 3], [4, 5, 6], [5, 6, 4], [7, 8, 9], [9, 8, 10]];
        let links = link(&triangles, 11, &BuildProgress::default()).unwrap();
        assert_eq!(links.copies(&triangles), [vec![0, 1], vec![3, 4]]);
    }
}
