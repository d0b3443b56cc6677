//! Which clusters of faces a path may lead through: a search on the coarse picture of the surface.

use glam::DVec3;

use super::heap::Heap;
use crate::surface::{InnerPoint, Surface};

/// A cluster of the way aims at the one so many clusters further on: over the next ones the way zigzags from centre to centre.
const AHEAD: usize = 3;
const NONE: u32 = u32::MAX;

/// What is known of a cluster, valid if its epoch is the query's.
#[derive(Clone, Copy, Debug, Default)]
struct Label {
    epoch: u32,
    /// The next cluster on the way to the goal.
    next: u32,
    /// Length of that way, from centre to centre.
    to_go: f64,
    closed: bool,
}

/// Whether a cluster belongs to the corridor, valid if its epoch is the query's.
#[derive(Clone, Copy, Debug, Default)]
struct Mark {
    epoch: u32,
    /// Counts in `aims`.
    aim: u32,
}

/// A place to head for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    pub(crate) at: DVec3,
    /// How far it is from there to the goal.
    pub(crate) to_go: f64,
}

impl Aim {
    /// About how far it is to the goal from a place that heads for this.
    #[inline]
    pub(crate) fn from(&self, place: DVec3) -> f64 {
        place.distance(self.at) + self.to_go
    }
}

/// Says where a search may go, and what for.
pub(crate) trait Guide {
    /// What to head for in a face; none where the search may not go.
    fn aim(&self, surface: &Surface, face: u32) -> Option<&Aim>;
}

impl Guide for Corridor {
    #[inline]
    fn aim(&self, surface: &Surface, face: u32) -> Option<&Aim> {
        let mark = self.marks[surface.clusters.of(face) as usize];
        if mark.epoch == self.epoch { self.aims.get(mark.aim as usize) } else { None }
    }
}

/// Finds ways on the graph of clusters; scratch memory of 32 bytes a cluster.
#[derive(Debug, Default)]
pub(crate) struct Corridor {
    labels: Vec<Label>,
    marks: Vec<Mark>,
    epoch: u32,
    heap: Heap,
    way: Vec<u32>,
    aims: Vec<Aim>,
}

impl Corridor {
    /// Marks the clusters of one short way, and their neighbours.
    pub(crate) fn along_one_way(&mut self, surface: &Surface, from: &InnerPoint, to: &InnerPoint) {
        self.begin(surface);
        self.find_way(surface, from, to);
        let clusters = &surface.clusters;
        let goal = Aim { at: surface.inner_position(to), to_go: 0.0 };
        self.aims.clear();
        for i in 0..self.way.len() {
            self.aims.push(match self.way.get(i + AHEAD) {
                Some(&cluster) if i + AHEAD + 1 < self.way.len() => {
                    Aim { at: clusters.center(cluster), to_go: self.labels[cluster as usize].to_go }
                }
                _ => goal,
            });
        }
        for (aim, &cluster) in self.way.iter().enumerate() {
            let mark = Mark { epoch: self.epoch, aim: aim as u32 };
            self.marks[cluster as usize] = mark;
            clusters.neighbours(cluster).iter().for_each(|n| self.marks[*n as usize] = mark);
        }
    }

    fn begin(&mut self, surface: &Surface) {
        let clusters = surface.clusters.len();
        if self.labels.len() < clusters {
            self.labels.resize(clusters, Label::default());
            self.marks.resize(clusters, Mark::default());
        }
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.labels.fill(Label::default());
            self.marks.fill(Mark::default());
            self.epoch = 1;
        }
    }

    /// A* from the goal's cluster to the start's; fills in `way`, from start to goal.
    fn find_way(&mut self, surface: &Surface, from: &InnerPoint, to: &InnerPoint) {
        let clusters = &surface.clusters;
        let [start, goal] = [from, to].map(|p| surface.inner_position(p));
        let [first, last] = [from, to].map(|p| clusters.of(p.face));
        self.heap.clear();
        self.reach(last, NONE, 0.0);
        self.heap.push(0.0, last);
        while let Some((_, cluster)) = self.heap.pop() {
            let label = &mut self.labels[cluster as usize];
            if label.closed {
                continue;
            }
            label.closed = true;
            if cluster == first {
                break;
            }
            let to_go = label.to_go;
            let here = if cluster == last { goal } else { clusters.center(cluster) };
            for &n in clusters.neighbours(cluster) {
                let there = if n == first { start } else { clusters.center(n) };
                let to_go = to_go + here.distance(there);
                let known = &self.labels[n as usize];
                if known.epoch != self.epoch || to_go < known.to_go {
                    self.reach(n, cluster, to_go);
                    self.heap.push(to_go + there.distance(start), n);
                }
            }
        }
        self.way.clear();
        let mut cluster = first;
        while cluster != NONE {
            self.way.push(cluster);
            cluster = self.labels[cluster as usize].next;
        }
    }

    fn reach(&mut self, cluster: u32, next: u32, to_go: f64) {
        self.labels[cluster as usize] = Label { epoch: self.epoch, next, to_go, closed: false };
    }
}
