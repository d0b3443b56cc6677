//! Patches of neighbouring faces, and the graph of patches that touch: a coarse picture of the surface.
//!
//! A search across a large mesh first looks for its way from patch to patch, and then at faces near that way only.

use glam::DVec3;

use super::{
    BuildProgress, HalfEdge, SurfaceError,
    memory::{ArrayMemory, array},
    parallel::PIECE,
};

/// Faces of a cluster that has room to grow.
const FULL: usize = 40;
/// A cluster that got stuck between its neighbours with fewer faces than this is given to one of them.
const SMALL: usize = 12;
const NONE: u32 = u32::MAX;

/// A partition of the faces into connected clusters, none across sheets, and which of them touch.
#[derive(Debug, Default)]
pub(crate) struct Clusters {
    /// The cluster of each inner face.
    of_face: Vec<u32>,
    /// Mean position of each cluster's faces.
    centers: Vec<DVec3>,
    /// Where the neighbours of each cluster begin in `neighbours`, and the end.
    first: Vec<u32>,
    /// Clusters that share a side, in rising order.
    neighbours: Vec<u32>,
    /// Mean distance between the centers of neighbours.
    spacing: f64,
}

impl Clusters {
    /// Grows cluster after cluster from the first face that has none; O(F), and about 6 bytes a face.
    ///
    /// Growth is breadth first, so clusters are round where there is room; in Morton order the next face without cluster is
    /// near the last one, and memory is walked as it lies.
    ///
    /// # Errors
    /// [`SurfaceError::Cancelled`].
    pub(crate) fn build(
        triangles: &[[u32; 3]],
        twins: &[[HalfEdge; 3]],
        positions: &[DVec3],
        progress: &BuildProgress,
    ) -> Result<Self, SurfaceError> {
        let mut growth = Growth { of_face: vec![NONE; triangles.len()], ..Growth::default() };
        for face in 0..triangles.len() as u32 {
            if (face as usize).is_multiple_of(PIECE) {
                progress.check()?;
            }
            if growth.of_face[face as usize] == NONE {
                growth.grow(face, twins);
                growth.settle(triangles, positions);
            }
        }
        Ok(growth.finish())
    }

    /// What they hold in memory.
    pub(crate) fn memory(&self) -> ArrayMemory {
        let arrays =
            [array("", &self.of_face), array("", &self.centers), array("", &self.first), array("", &self.neighbours)];
        ArrayMemory { name: "clusters of faces", bytes: arrays.iter().map(|a| a.bytes).sum() }
    }

    /// How many clusters there are.
    pub(crate) fn len(&self) -> usize {
        self.centers.len()
    }

    /// The cluster of an inner face.
    #[inline]
    pub(crate) fn of(&self, face: u32) -> u32 {
        self.of_face[face as usize]
    }

    /// Mean position of a cluster's faces, in inner coordinates.
    #[inline]
    pub(crate) fn center(&self, cluster: u32) -> DVec3 {
        self.centers[cluster as usize]
    }

    /// Mean distance between the centers of neighbouring clusters; zero if there are none.
    pub(crate) fn spacing(&self) -> f64 {
        self.spacing
    }

    /// The clusters that share a side with a cluster, in rising order.
    #[inline]
    pub(crate) fn neighbours(&self, cluster: u32) -> &[u32] {
        let [from, to] = [cluster, cluster + 1].map(|c| self.first[c as usize] as usize);
        &self.neighbours[from..to]
    }
}

/// Clusters while they are made.
#[derive(Debug, Default)]
struct Growth {
    of_face: Vec<u32>,
    /// For each cluster the sum of its faces' positions, and their number.
    sums: Vec<(DVec3, f64)>,
    /// Pairs of clusters that touch; some repeat.
    contacts: Vec<[u32; 2]>,
    /// Faces of the cluster in work, in the order they came.
    members: Vec<u32>,
    /// Older clusters that it touches, and by how many sides.
    around: Vec<(u32, u32)>,
}

impl Growth {
    /// Grows a new cluster from a face until it is full or hemmed in.
    fn grow(&mut self, seed: u32, twins: &[[HalfEdge; 3]]) {
        let cluster = self.sums.len() as u32;
        self.members.clear();
        self.around.clear();
        self.members.push(seed);
        self.of_face[seed as usize] = cluster;
        let mut head = 0;
        while let Some(&face) = self.members.get(head) {
            head += 1;
            for twin in twins[face as usize].iter().filter(|t| t.is_some()) {
                let of = &mut self.of_face[twin.face() as usize];
                if *of == NONE {
                    if self.members.len() < FULL {
                        *of = cluster;
                        self.members.push(twin.face());
                    }
                } else if *of != cluster {
                    match self.around.iter_mut().find(|a| a.0 == *of) {
                        Some(known) => known.1 += 1,
                        None => self.around.push((*of, 1)),
                    }
                }
            }
        }
    }

    /// Makes the faces grown last a cluster, or part of the older one that they touch most.
    fn settle(&mut self, triangles: &[[u32; 3]], positions: &[DVec3]) {
        let mut cluster = self.sums.len() as u32;
        let host = self.around.iter().max_by_key(|a| (a.1, a.0));
        if let (true, Some(&(host, _))) = (self.members.len() < SMALL, host) {
            cluster = host;
            self.members.iter().for_each(|f| self.of_face[*f as usize] = host);
        } else {
            self.sums.push((DVec3::ZERO, 0.0));
        }
        // One corner stands for a face: on the whole that is the mean position of the faces, for a third of the reads.
        let sum: DVec3 = self.members.iter().map(|f| positions[triangles[*f as usize][0] as usize]).sum();
        let old = &mut self.sums[cluster as usize];
        *old = (old.0 + sum, old.1 + self.members.len() as f64);
        for (other, _) in self.around.iter().filter(|a| a.0 != cluster) {
            self.contacts.push([cluster, *other]);
            self.contacts.push([*other, cluster]);
        }
    }

    /// Sorts what touches into rows.
    fn finish(mut self) -> Clusters {
        self.contacts.sort_unstable();
        self.contacts.dedup();
        let mut first = vec![0; self.sums.len() + 1];
        self.contacts.iter().for_each(|c| first[c[0] as usize + 1] += 1);
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let centers: Vec<DVec3> = self.sums.iter().map(|(sum, count)| *sum / count.max(1.0)).collect();
        let distance = |c: &[u32; 2]| centers[c[0] as usize].distance(centers[c[1] as usize]);
        let spacing = self.contacts.iter().map(distance).sum::<f64>() / self.contacts.len().max(1) as f64;
        let neighbours = self.contacts.iter().map(|c| c[1]).collect();
        Clusters { of_face: self.of_face, centers, first, neighbours, spacing }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Surface, SurfaceOptions, TriangleMesh, shapes};
    use std::collections::{BTreeSet, HashMap};

    fn built(mesh: &TriangleMesh) -> Surface {
        Surface::build(mesh, &SurfaceOptions::default()).unwrap()
    }

    /// Two tori, one inside the hole of the other, and a lone triangle.
    fn pieces() -> TriangleMesh {
        let mut mesh = shapes::torus(2.0, 0.5, 60, 30);
        for extra in [shapes::torus(0.8, 0.3, 40, 20), shapes::grid(1, 1, 0.1, 0.1)] {
            let shift = mesh.positions.len() as u32;
            mesh.positions.extend(extra.positions);
            mesh.faces.extend(extra.faces.iter().map(|t| t.map(|v| v + shift)));
        }
        mesh
    }

    #[test]
    fn clusters_are_connected_and_keep_to_their_sheet() {
        for mesh in [pieces(), shapes::icosphere(4), shapes::grid(50, 3, 5.0, 1.0), shapes::cube()] {
            let surface = built(&mesh);
            let clusters = &surface.clusters;
            let mut faces: HashMap<u32, Vec<u32>> = HashMap::new();
            (0..surface.triangles.len() as u32).for_each(|f| faces.entry(clusters.of(f)).or_default().push(f));
            assert_eq!(faces.len(), clusters.len());
            for (cluster, members) in &faces {
                let mut reached = BTreeSet::from([members[0]]);
                let mut queue = vec![members[0]];
                while let Some(face) = queue.pop() {
                    for twin in surface.twins[face as usize].iter().filter(|t| t.is_some()) {
                        if clusters.of(twin.face()) == *cluster && reached.insert(twin.face()) {
                            queue.push(twin.face());
                        }
                    }
                }
                assert_eq!(reached.len(), members.len());
                assert!(members.iter().all(|f| surface.sheet[*f as usize] == surface.sheet[members[0] as usize]));
            }
        }
    }

    #[test]
    fn neighbours_are_those_that_share_a_side() {
        let surface = built(&pieces());
        let clusters = &surface.clusters;
        let mut expected = vec![BTreeSet::new(); clusters.len()];
        for (face, row) in surface.twins.iter().enumerate() {
            for twin in row.iter().filter(|t| t.is_some()) {
                let [a, b] = [face as u32, twin.face()].map(|f| clusters.of(f));
                if a != b {
                    expected[a as usize].insert(b);
                }
            }
        }
        for (cluster, expected) in expected.iter().enumerate() {
            assert!(clusters.neighbours(cluster as u32).iter().eq(expected));
        }
    }

    #[test]
    fn clusters_are_neither_large_nor_small_and_centers_lie_among_their_faces() {
        let surface = built(&shapes::icosphere(5));
        let clusters = &surface.clusters;
        let mut sizes = vec![0; clusters.len()];
        for (face, t) in surface.triangles.iter().enumerate() {
            let cluster = clusters.of(face as u32);
            sizes[cluster as usize] += 1;
            let corner = surface.positions[t[0] as usize];
            assert!(corner.distance(clusters.center(cluster)) < 0.5);
        }
        assert!(sizes.iter().all(|n| (SMALL..4 * FULL).contains(n)), "{sizes:?}");
    }
}
