//! Which clusters of faces a path may lead through: searches on the coarse picture of the surface.

use glam::DVec3;

use super::heap::Heap;
use crate::surface::{Clusters, InnerPoint, Surface};

/// A cluster of a way aims at the one so many clusters further on: in between the way zigzags from centre to centre.
const AHEAD: usize = 3;
/// Ways from centre to centre may be longer than the shortest by this share of it, and by this share of the spacing of
/// clusters, to count as short. Distances between centres mislead by a few per cent; with less, paths get worse.
const LONGER: f64 = 0.03;
const LONGER_SPACINGS: f64 = 1.0;
/// Points so many clusters apart are far apart: below that, finding the corridor costs what it saves.
const FAR: f64 = 20.0;
const NONE: u32 = u32::MAX;

/// A place to head for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    at: DVec3,
    /// How far it is from there to the goal.
    to_go: f64,
}

impl Aim {
    /// About how far it is to the goal from a place that heads for this.
    #[inline]
    pub(crate) fn from(&self, place: DVec3) -> f64 {
        place.distance(self.at) + self.to_go
    }
}

/// A set of clusters that leads from start to goal; scratch memory of 64 bytes a cluster.
#[derive(Debug, Default)]
pub(crate) struct Corridor {
    to_goal: Vec<Label>,
    from_start: Vec<Label>,
    marks: Vec<Mark>,
    epoch: u32,
    heap: Heap,
    way: Vec<u32>,
    aims: Vec<Aim>,
}

/// What is known of a cluster, valid if its epoch is the query's.
#[derive(Clone, Copy, Debug, Default)]
struct Label {
    epoch: u32,
    /// The cluster next to it that is nearer.
    next: u32,
    /// Length of the way, from centre to centre.
    distance: f64,
    closed: bool,
}

/// Whether a cluster belongs to the corridor, valid if its epoch is the query's.
#[derive(Clone, Copy, Debug, Default)]
struct Mark {
    epoch: u32,
    /// Counts in `aims`.
    aim: u32,
}

/// Start and goal of a query. They stand for the centres of their clusters.
#[derive(Clone, Copy, Debug)]
struct Ends<'a> {
    clusters: &'a Clusters,
    start: DVec3,
    goal: DVec3,
    first: u32,
    last: u32,
}

impl<'a> Ends<'a> {
    fn new(surface: &'a Surface, from: &InnerPoint, to: &InnerPoint) -> Self {
        let clusters = &surface.clusters;
        let [start, goal] = [from, to].map(|p| surface.inner_position(p));
        Self { clusters, start, goal, first: clusters.of(from.face), last: clusters.of(to.face) }
    }

    #[inline]
    fn place(&self, cluster: u32) -> DVec3 {
        if cluster == self.first {
            self.start
        } else if cluster == self.last {
            self.goal
        } else {
            self.clusters.center(cluster)
        }
    }
}

/// How far it is to the neighbours of a cluster: by its centre, or straight from the cluster before it. Ways that may only turn
/// at every other centre zigzag less.
struct Reach {
    here: (DVec3, f64),
    before: (DVec3, f64),
}

impl Reach {
    fn new(ends: &Ends, labels: &[Label], cluster: u32, distance: f64) -> Self {
        let here = (ends.place(cluster), distance);
        let before = labels[cluster as usize].next;
        let before = if before == NONE { here } else { (ends.place(before), labels[before as usize].distance) };
        Self { here, before }
    }

    #[inline]
    fn distance(&self, there: DVec3) -> f64 {
        let by = |(place, distance): (DVec3, f64)| distance + there.distance(place);
        by(self.here).min(by(self.before))
    }
}

/// Whether points are so far apart that a search between them is worth a corridor.
pub(crate) fn far_apart(surface: &Surface, from: &InnerPoint, to: &InnerPoint) -> bool {
    surface.inner_position(from).distance(surface.inner_position(to)) > FAR * surface.clusters.spacing()
}

impl Corridor {
    /// Marks the clusters of one short way, and their neighbours; each heads for a place further on.
    pub(crate) fn along_one_way(&mut self, surface: &Surface, from: &InnerPoint, to: &InnerPoint) {
        let ends = Ends::new(surface, from, to);
        self.begin(ends.clusters);
        self.measure_to_goal(&ends, |shortest| shortest);
        self.aims.clear();
        for i in 0..self.way.len() {
            let ahead = self.way.get(i + AHEAD).copied().unwrap_or(ends.last);
            self.aims.push(Aim { at: ends.place(ahead), to_go: self.to_goal[ahead as usize].distance });
        }
        for aim in 0..self.way.len() {
            self.mark_about(ends.clusters, self.way[aim], aim as u32);
        }
    }

    /// Marks the clusters of all short ways, and their neighbours; all head for the goal.
    pub(crate) fn along_short_ways(&mut self, surface: &Surface, from: &InnerPoint, to: &InnerPoint) {
        let ends = Ends::new(surface, from, to);
        self.begin(ends.clusters);
        let spare = LONGER_SPACINGS * ends.clusters.spacing();
        let bound = self.measure_to_goal(&ends, |shortest| (1.0 + LONGER) * shortest + spare);
        self.aims.clear();
        self.aims.push(Aim { at: ends.goal, to_go: 0.0 });
        self.mark_from_start(&ends, bound);
        // Distances from both ends may add up to more than the way is long, so it may have been left out.
        for i in 0..self.way.len() {
            self.mark_about(ends.clusters, self.way[i], 0);
        }
    }

    /// Marks a cluster and its neighbours.
    fn mark_about(&mut self, clusters: &Clusters, cluster: u32, aim: u32) {
        let mark = Mark { epoch: self.epoch, aim };
        self.marks[cluster as usize] = mark;
        clusters.neighbours(cluster).iter().for_each(|n| self.marks[*n as usize] = mark);
    }

    /// What a face heads for; none outside the corridor.
    #[inline]
    pub(crate) fn aim(&self, surface: &Surface, face: u32) -> Option<&Aim> {
        let mark = self.marks[surface.clusters.of(face) as usize];
        if mark.epoch == self.epoch { self.aims.get(mark.aim as usize) } else { None }
    }

    fn begin(&mut self, clusters: &Clusters) {
        if self.marks.len() < clusters.len() {
            self.to_goal.resize(clusters.len(), Label::default());
            self.from_start.resize(clusters.len(), Label::default());
            self.marks.resize(clusters.len(), Mark::default());
        }
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.to_goal.fill(Label::default());
            self.from_start.fill(Label::default());
            self.marks.fill(Mark::default());
            self.epoch = 1;
        }
    }

    /// A* from the goal: fills in `way`, and `to_goal` for all clusters through which a way of at most `bound` may lead. Gives
    /// that bound, which follows from the length of the shortest way.
    fn measure_to_goal(&mut self, ends: &Ends, bound_for: impl Fn(f64) -> f64) -> f64 {
        let mut bound = f64::INFINITY;
        self.heap.clear();
        self.heap.push(0.0, ends.last);
        self.to_goal[ends.last as usize] = Label { epoch: self.epoch, next: NONE, distance: 0.0, closed: false };
        while let Some((priority, cluster)) = self.heap.pop() {
            if priority > bound {
                break;
            }
            let label = &mut self.to_goal[cluster as usize];
            if std::mem::replace(&mut label.closed, true) {
                continue;
            }
            let distance = label.distance;
            if cluster == ends.first {
                bound = bound_for(distance);
            }
            let reach = Reach::new(ends, &self.to_goal, cluster, distance);
            for &next in ends.clusters.neighbours(cluster) {
                let there = ends.place(next);
                let distance = reach.distance(there);
                let priority = distance + there.distance(ends.start);
                let known = &mut self.to_goal[next as usize];
                if priority <= bound && (known.epoch != self.epoch || distance < known.distance) {
                    *known = Label { epoch: self.epoch, next: cluster, distance, closed: false };
                    self.heap.push(priority, next);
                }
            }
        }
        self.read_way(ends.first, ends.clusters.len());
        bound
    }

    /// Follows the labels from a cluster to the goal, through `most` clusters at most: where centres lie on one line, rounding
    /// can make two clusters next to each other both ways, and such a way leads nowhere.
    fn read_way(&mut self, first: u32, most: usize) {
        self.way.clear();
        let mut cluster = first;
        while self.way.len() < most
            && let Some(label) = self.to_goal.get(cluster as usize)
        {
            self.way.push(cluster);
            cluster = label.next;
        }
    }

    /// Search from the start, of clusters whose distances from start and goal are `bound` in all at most. Distances to the goal
    /// are known, so it looks at no others.
    fn mark_from_start(&mut self, ends: &Ends, bound: f64) {
        self.heap.clear();
        self.heap.push(0.0, ends.first);
        self.from_start[ends.first as usize] = Label { epoch: self.epoch, next: NONE, distance: 0.0, closed: false };
        while let Some((_, cluster)) = self.heap.pop() {
            let label = &mut self.from_start[cluster as usize];
            if std::mem::replace(&mut label.closed, true) {
                continue;
            }
            let distance = label.distance;
            self.mark_about(ends.clusters, cluster, 0);
            let reach = Reach::new(ends, &self.from_start, cluster, distance);
            for &next in ends.clusters.neighbours(cluster) {
                let to_goal = self.to_goal[next as usize];
                let distance = reach.distance(ends.place(next));
                let known = &mut self.from_start[next as usize];
                if to_goal.epoch == self.epoch
                    && distance + to_goal.distance <= bound
                    && (known.epoch != self.epoch || (!known.closed && distance < known.distance))
                {
                    *known = Label { epoch: self.epoch, next: cluster, distance, closed: false };
                    self.heap.push(distance + to_goal.distance, next);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geodesic::{inner::InnerPath, search::Search, straighten::Straightener},
        surface::{SurfaceOptions, TriangleMesh, shapes},
    };

    fn built(mesh: &TriangleMesh) -> Surface {
        Surface::build(mesh, &SurfaceOptions::default()).unwrap()
    }

    fn at(face: u32) -> InnerPoint {
        InnerPoint { face, weights: [0.2, 0.3, 0.5] }
    }

    /// The faces that a corridor leads to from its start.
    fn reached(surface: &Surface, corridor: &Corridor, from: u32) -> Vec<bool> {
        let mut seen = vec![false; surface.triangles.len()];
        let mut queue = vec![from];
        seen[from as usize] = true;
        while let Some(face) = queue.pop() {
            for twin in surface.twins[face as usize].iter().filter(|t| t.is_some()) {
                if corridor.aim(surface, twin.face()).is_some() && !seen[twin.face() as usize] {
                    seen[twin.face() as usize] = true;
                    queue.push(twin.face());
                }
            }
        }
        seen
    }

    #[test]
    fn corridors_lead_from_start_to_goal() {
        let mut corridor = Corridor::default();
        for mesh in [shapes::torus(2.0, 0.7, 90, 40), shapes::grid(90, 4, 9.0, 0.4), shapes::cube()] {
            let surface = built(&mesh);
            let faces = surface.triangles.len() as u32;
            for i in 0..100_u32 {
                let [from, to] = [i * 389 % faces, (i * 1021 + 7) % faces];
                corridor.along_one_way(&surface, &at(from), &at(to));
                assert!(corridor.aim(&surface, from).is_some());
                let narrow = reached(&surface, &corridor, from);
                assert!(narrow[to as usize]);
                corridor.along_short_ways(&surface, &at(from), &at(to));
                let wide = reached(&surface, &corridor, from);
                assert!(narrow.iter().zip(&wide).all(|(n, w)| *w || !*n));
            }
        }
    }

    #[test]
    fn a_way_that_goes_round_in_a_circle_ends() {
        let label = |next| Label { epoch: 1, next, distance: 1.0, closed: true };
        let mut corridor = Corridor { to_goal: [2, NONE, 3, 2].map(label).to_vec(), ..Corridor::default() };
        corridor.read_way(0, 4);
        assert_eq!(corridor.way, [0, 2, 3, 2]);
        corridor.read_way(1, 4);
        assert_eq!(corridor.way, [1]);
    }

    #[test]
    fn corridors_on_a_plane_are_ellipses() {
        let surface = built(&shapes::grid(120, 120, 12.0, 12.0));
        let face = |x: f64, y: f64| {
            let point = surface.closest_point(DVec3::new(x, y, 0.0)).unwrap().point;
            surface.inner_point(&point).unwrap()
        };
        let mut corridor = Corridor::default();
        let (from, to) = (face(0.5, 6.0), face(11.5, 6.0));
        assert!(far_apart(&surface, &from, &to) && !far_apart(&surface, &from, &face(2.0, 6.0)));
        corridor.along_short_ways(&surface, &from, &to);
        let inside = (0..surface.triangles.len() as u32).filter(|f| corridor.aim(&surface, *f).is_some());
        let heights: Vec<f64> = inside.map(|f| surface.inner_position(&at(f)).y).collect();
        assert!(heights.len() < surface.triangles.len() * 2 / 3, "{}", heights.len());
        assert!(heights.iter().all(|y| (1.0..11.0).contains(y)));
    }

    #[test]
    fn searches_in_corridors_find_what_searches_everywhere_find() {
        let surface = built(&shapes::torus(2.0, 0.7, 200, 80));
        let faces = surface.triangles.len() as u32;
        let (mut corridor, mut search) = (Corridor::default(), Search::default());
        let (mut strip, mut path, mut straightener) = (Vec::new(), InnerPath::default(), Straightener::default());
        for i in 0..60_u32 {
            let (from, to) = (at(i * 389 % faces), at((i * 1021 + 7) % faces));
            corridor.along_short_ways(&surface, &from, &to);
            let inside = search.run_inside(&surface, &from, &to, &corridor, &mut strip).unwrap();
            straightener.run(&surface, inside.start, inside.end, &mut strip, &mut path);
            let length = path.length;
            let everywhere = search.run(&surface, &from, &to, &mut strip).unwrap();
            straightener.run(&surface, everywhere.start, everywhere.end, &mut strip, &mut path);
            assert!(length < path.length * (1.0 + 1e-3), "{i}: {length} {}", path.length);
        }
    }
}
