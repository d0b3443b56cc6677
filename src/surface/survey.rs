//! Counting what the mesh looked like before it was cut and split.

use glam::DVec3;

use super::{
    FaceId, HalfEdge, Repair, SurfaceReport, TriangleMesh,
    adjacency::Adjacency,
    fans::Fans,
    orientation::{Orientation, turned},
};

/// Counts vertices, pieces and edges as they came, and what orienting did.
pub(crate) fn survey(links: &Adjacency, orientation: &Orientation, fans: &Fans, welded_count: usize) -> SurfaceReport {
    let fans_at = fans_as_they_came(links, orientation, fans, welded_count);
    SurfaceReport {
        split_vertices: fans.welded.len() - welded_count,
        components: components(orientation, fans, welded_count),
        sheets: orientation.sheets,
        boundary_edges: links.boundary_edges,
        nonmanifold_edges: links.crowded.len(),
        nonmanifold_vertices: fans_at.iter().filter(|n| **n > 1).count(),
        euler_characteristic: welded_count as i64 - links.edges as i64 + fans.triangles.len() as i64,
        orientable: orientation.cuts.is_empty(),
        consistently_oriented: orientation.consistent && links.crowded.is_empty(),
        orientation_cuts: orientation.cuts.len(),
        flipped_faces: orientation.flip.iter().filter(|f| **f).count(),
        ..SurfaceReport::default()
    }
}

/// For each welded vertex, how many fans it had before edges with many faces, and those that could not be oriented, were
/// cut.
fn fans_as_they_came(links: &Adjacency, orientation: &Orientation, fans: &Fans, welded_count: usize) -> Vec<u32> {
    let mut joined = UnionFind::new(fans.welded.len());
    let vertex = |h: HalfEdge| fans.triangles[h.face() as usize][h.side()];
    let crowded = links.crowded.iter().flat_map(|run| run.windows(2).map(|pair| [pair[0], pair[1]]));
    for sides in crowded.chain(orientation.cuts.iter().copied()) {
        let sides = sides.map(|h| turned(&orientation.flip, h));
        let [[a, b], [c, d]] = sides.map(|h| [vertex(h), vertex(h.next())]);
        let along = fans.welded[a as usize] == fans.welded[c as usize];
        let (c, d) = if along { (c, d) } else { (d, c) };
        joined.union(a, c);
        joined.union(b, d);
    }
    let mut fans_at = vec![0; welded_count];
    for (fan, &welded) in fans.welded.iter().enumerate() {
        fans_at[welded as usize] += u32::from(joined.is_root(fan as u32));
    }
    fans_at
}

/// Where something was done: the first of each kind. `position` is that of a welded vertex.
pub(crate) fn places(
    mesh: &TriangleMesh,
    dropped: impl Iterator<Item = FaceId>,
    (links, orientation, fans): (&Adjacency, &Orientation, &Fans),
    position: impl Fn(u32) -> DVec3,
) -> Vec<(Repair, DVec3)> {
    let at = |vertex: u32| position(fans.welded[vertex as usize]);
    let middle_of_face = |face: usize| fans.triangles[face].iter().map(|v| at(*v)).sum::<DVec3>() / 3.0;
    let middle_of_side = |h: HalfEdge| {
        let h = turned(&orientation.flip, h);
        let vertex = |h: HalfEdge| at(fans.triangles[h.face() as usize][h.side()]);
        0.5 * (vertex(h) + vertex(h.next()))
    };
    let corners = |face: FaceId| mesh.faces[face.0 as usize].map(|v| mesh.positions[v as usize]);
    let dropped = dropped.map(|face| corners(face).into_iter().sum::<DVec3>() / 3.0).filter(|p| p.is_finite());
    let flipped = orientation.flip.iter().enumerate().filter(|(_, flip)| **flip).map(|(face, _)| middle_of_face(face));
    let crowded = links.crowded.iter().filter_map(|run| run.first()).map(|h| middle_of_side(*h));
    let cut = orientation.cuts.iter().map(|[h, _]| middle_of_side(*h));
    // New vertices are numbered by first use, so a welded vertex that comes again was split.
    let mut seen = vec![false; fans.welded.iter().max().map_or(0, |most| *most as usize + 1)];
    let again = |welded: &&u32| std::mem::replace(&mut seen[**welded as usize], true);
    let split = fans.welded.iter().filter(again).map(|welded| position(*welded));
    let mut places = Vec::new();
    let mut keep = |repair: Repair, found: &mut dyn Iterator<Item = DVec3>| {
        places.extend(found.take(SurfaceReport::MOST_PLACES).map(|place| (repair, place)));
    };
    keep(Repair::Dropped, &mut { dropped });
    keep(Repair::Flipped, &mut { flipped });
    keep(Repair::NonManifoldEdge, &mut { crowded });
    keep(Repair::Cut, &mut { cut });
    keep(Repair::Split, &mut { split });
    places
}

/// How many pieces sheets make that share vertices.
fn components(orientation: &Orientation, fans: &Fans, welded_count: usize) -> usize {
    const UNSEEN: u32 = u32::MAX;
    let mut joined = UnionFind::new(orientation.sheets);
    let mut sheet_at = vec![UNSEEN; welded_count];
    for (&welded, h) in fans.welded.iter().zip(&fans.outgoing) {
        let sheet = orientation.sheet[h.face() as usize];
        match &mut sheet_at[welded as usize] {
            first if *first == UNSEEN => *first = sheet,
            first => joined.union(*first, sheet),
        }
    }
    (0..orientation.sheets as u32).filter(|sheet| joined.is_root(*sheet)).count()
}

/// Sets of things joined one pair at a time.
struct UnionFind(Vec<u32>);

impl UnionFind {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn find(&mut self, mut x: u32) -> u32 {
        while self.0[x as usize] != x {
            self.0[x as usize] = self.0[self.0[x as usize] as usize];
            x = self.0[x as usize];
        }
        x
    }

    fn union(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    fn is_root(&self, x: u32) -> bool {
        self.0[x as usize] == x
    }
}
