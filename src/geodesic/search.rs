//! Any-angle search: a strip of faces in which a short path runs.
//!
//! A label sits on a crossed side and holds, in the plane of the faces unfolded so far, a pseudo-source, the distance up to
//! it, and the wedge it sees through the side. Labels are immutable records in a pool: overwriting a label that others
//! descend from would give them a history that never was, and three times as many bad paths.

use glam::{DVec2, DVec3};

use super::corridor::{Aim, Guide};
use crate::surface::{HalfEdge, InnerPoint, Surface, metric};

/// A new label must beat the old one by this factor, or rounding makes endless improvements.
const BETTER: f64 = 1.0 - 1e-6;

/// The search gives up after this many labels a side of the surface; sound meshes need less than one.
const MAX_LABELS_A_SIDE: usize = 64;

/// A side longer than this many mean edges is long.
const LONG: f64 = 4.0;

/// What is known about reaching a side, seen in the side's frame: origin at (0, 0), target at (length, 0), the face that is
/// left above, travel downwards; left is the target's side.
#[derive(Clone, Copy, Debug)]
struct Label {
    source: DVec2,
    left: DVec2,
    right: DVec2,
    /// Distance from the start to the pseudo-source.
    to_source: f64,
    /// Distance from the start to the side's middle.
    to_middle: f64,
    side: HalfEdge,
    parent: u32,
}

const NO_PARENT: u32 = u32::MAX;

#[derive(Clone, Copy, Debug, Default)]
struct Best {
    epoch: u32,
    label: u32,
}

/// Scratch memory of the search; 8 bytes a side of the largest surface seen, and about 90 a label.
#[derive(Debug, Default)]
pub(crate) struct Search {
    pool: Vec<Label>,
    best: Vec<Best>,
    epoch: u32,
    heap: Heap,
    mean_edge: f64,
    targets: Vec<InnerPoint>,
}

/// The answer of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// The start, in the spelling of the strip's first face.
    pub(crate) start: InnerPoint,
    /// The end, in the spelling of the strip's last face.
    pub(crate) end: InnerPoint,
}

impl Search {
    /// Looks for a strip from `from` to `to`, which must lie on one sheet and share no face; `strip` receives the sides
    /// through which its faces are left.
    ///
    /// Cost: about 0.3 µs a label; labels fill an ellipse about the path.
    pub(crate) fn run(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        to: &InnerPoint,
        strip: &mut Vec<HalfEdge>,
    ) -> Option<Found> {
        let anywhere = Anywhere(Aim { at: surface.inner_position(to), to_go: 0.0 });
        self.run_guided(surface, from, to, &anywhere, strip).or_else(|| self.flood(surface, from, strip))
    }

    /// [`run`](Self::run) where a guide leads; none if it does not lead to the goal.
    pub(crate) fn run_guided(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        to: &InnerPoint,
        guide: &impl Guide,
        strip: &mut Vec<HalfEdge>,
    ) -> Option<Found> {
        self.begin(surface);
        let sheet = surface.sheet[from.face as usize] as usize;
        let slack = surface.slack[sheet];
        self.mean_edge = surface.mean_edge[sheet];
        let length = |h: HalfEdge| surface.length(h) + slack;
        let goal = surface.inner_position(to);
        self.targets.clear();
        let targets = &mut self.targets;
        surface.for_each_spelling(to, |p| targets.push(p));
        let mut longest = 0.0_f64;
        let mut note = |face: u32| (0..3).for_each(|k| longest = longest.max(length(HalfEdge::new(face, k))));
        self.targets.iter().for_each(|p| note(p.face));
        surface.for_each_spelling(from, |p| note(p.face));
        // Labels know their distance at the middle of a side only; going on for half a face past the first arrival
        // catches the strips that were undervalued by that.
        let patience = 0.5 * longest.min(LONG * self.mean_edge);
        surface.for_each_spelling(from, |start| self.seed(surface, &start, slack, guide));

        let (mut arrived, mut last, mut end) = (f64::INFINITY, NO_PARENT, *to);
        while let Some((priority, index)) = self.heap.pop() {
            if priority >= arrived + patience {
                break;
            }
            let label = self.pool[index as usize];
            if self.best[label.side.index()].label != index {
                continue; // a better label took its place while it waited
            }
            if priority >= arrived && label.lower_bound(surface, slack, goal) >= arrived {
                continue; // no path through this side can be shorter, however the middle misleads
            }
            if self.pool.len() > MAX_LABELS_A_SIDE * 3 * surface.triangles.len() {
                break;
            }
            let twin = surface.twin(label.side);
            let width = length(label.side);
            let [a, b] = [DVec2::ZERO, DVec2::new(width, 0.0)];
            let c = metric::apex(b, a, width, length(twin.prev()), length(twin.next()));
            for target in self.targets.iter().filter(|t| t.face == twin.face()) {
                let k = twin.side();
                let x = target.weights[k] * b + target.weights[(k + 1) % 3] * a + target.weights[(k + 2) % 3] * c;
                let distance = label.to_source + label.distance_through(x);
                if distance < arrived {
                    (arrived, last, end) = (distance, index, *target);
                }
            }
            for (side, right, left) in [(twin.prev(), c, b), (twin.next(), a, c)] {
                if surface.twin(side).is_some() {
                    let next = label.propagate(index, side, right, left);
                    self.offer(surface, next, guide, arrived + patience);
                }
            }
        }
        if last == NO_PARENT {
            return None;
        }
        strip.clear();
        let mut at = last;
        while at != NO_PARENT {
            strip.push(self.pool[at as usize].side);
            at = self.pool[at as usize].parent;
        }
        strip.reverse();
        let first = strip[0].face();
        let mut start = *from;
        surface.for_each_spelling(from, |p| {
            if p.face == first {
                start = p;
            }
        });
        Some(Found { start, end })
    }

    /// The strip of fewest faces, for when the search ran out of labels: it always exists on a sheet.
    fn flood(&self, surface: &Surface, from: &InnerPoint, strip: &mut Vec<HalfEdge>) -> Option<Found> {
        let mut came_by = vec![HalfEdge::NONE; surface.triangles.len()];
        let mut queue = vec![from.face];
        let mut head = 0;
        while let Some(&face) = queue.get(head) {
            head += 1;
            if let Some(&end) = self.targets.iter().find(|t| t.face == face) {
                strip.clear();
                let mut at = face;
                while at != from.face {
                    let side = came_by[at as usize];
                    strip.push(side);
                    at = side.face();
                }
                strip.reverse();
                return Some(Found { start: *from, end });
            }
            for k in 0..3 {
                let side = HalfEdge::new(face, k);
                let twin = surface.twin(side);
                if twin.is_some() && twin.face() != from.face && !came_by[twin.face() as usize].is_some() {
                    came_by[twin.face() as usize] = side;
                    queue.push(twin.face());
                }
            }
        }
        None
    }

    fn begin(&mut self, surface: &Surface) {
        let sides = surface.triangles.len() * 3;
        if self.best.len() < sides {
            self.best.resize(sides, Best::default());
        }
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.best.fill(Best::default());
            self.epoch = 1;
        }
        self.pool.clear();
        self.heap.clear();
    }

    /// Puts labels on the sides of a face that do not contain the start.
    fn seed(&mut self, surface: &Surface, start: &InnerPoint, slack: f64, guide: &impl Guide) {
        for k in 0..3 {
            let side = HalfEdge::new(start.face, k);
            let [w0, w1, w2] = [side, side.next(), side.prev()].map(|h| start.weights[h.side()]);
            if w2 == 0.0 || !surface.twin(side).is_some() {
                continue;
            }
            let length = |h: HalfEdge| surface.length(h) + slack;
            let width = length(side);
            let end = DVec2::new(width, 0.0);
            let apex = metric::apex(DVec2::ZERO, end, width, length(side.prev()), length(side.next()));
            let source = w0 * DVec2::ZERO + w1 * end + w2 * apex;
            let to_middle = source.distance(0.5 * end);
            let label =
                Label { source, left: end, right: DVec2::ZERO, to_source: 0.0, to_middle, side, parent: NO_PARENT };
            self.offer(surface, label, guide, f64::INFINITY);
        }
    }

    /// Keeps a label if it is the best on its side so far, not worse than the one on the side's other face, and of a
    /// priority below `limit`, at which the search ends.
    fn offer(&mut self, surface: &Surface, label: Label, guide: &impl Guide, limit: f64) {
        let known = |h: HalfEdge| {
            let best = self.best[h.index()];
            if best.epoch == self.epoch { self.pool[best.label as usize].to_middle } else { f64::INFINITY }
        };
        if known(label.side) * BETTER <= label.to_middle || known(surface.twin(label.side)) <= label.to_middle * BETTER
        {
            return;
        }
        let [a, b] = [surface.origin(label.side), surface.target(label.side)];
        let middle = 0.5 * (surface.positions[a as usize] + surface.positions[b as usize]);
        let Some(aim) = guide.aim(surface, surface.twin(label.side).face()) else { return };
        let mut priority = label.to_middle + aim.from(middle);
        // The middle of a side far longer than most says little about a path that crosses near its end.
        if surface.length(label.side) > LONG * self.mean_edge {
            priority = priority.min(label.lower_bound(surface, 0.0, aim.at) + aim.to_go + 0.5 * LONG * self.mean_edge);
        }
        if priority >= limit {
            return;
        }
        let index = self.pool.len() as u32;
        self.best[label.side.index()] = Best { epoch: self.epoch, label: index };
        self.heap.push(priority, index);
        self.pool.push(label);
    }
}

/// No guide at all: straight for the goal.
struct Anywhere(Aim);

impl Guide for Anywhere {
    #[inline]
    fn aim(&self, _: &Surface, _: u32) -> Option<&Aim> {
        Some(&self.0)
    }
}

impl Label {
    /// No path that this label stands for is shorter: up to the nearest place on the side, and on through space.
    fn lower_bound(&self, surface: &Surface, slack: f64, goal: DVec3) -> f64 {
        let width = surface.length(self.side) + slack;
        let foot = DVec2::new(self.source.x.clamp(0.0, width), 0.0);
        let [a, b] = [surface.origin(self.side), surface.target(self.side)].map(|v| surface.positions[v as usize]);
        let along = b - a;
        let share = ((goal - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        self.to_source + self.source.distance(foot) + goal.distance(a + share * along)
    }

    /// Distance from the pseudo-source to `x` behind the side, bending at an end of the wedge where `x` lies outside.
    fn distance_through(&self, x: DVec2) -> f64 {
        if turn(self.source, self.left, x) > 0.0 {
            self.source.distance(self.left) + self.left.distance(x)
        } else if turn(self.source, self.right, x) < 0.0 {
            self.source.distance(self.right) + self.right.distance(x)
        } else {
            self.source.distance(x)
        }
    }

    /// The label of a side of the face behind, whose ends are `right` and `left` in this label's frame.
    fn propagate(&self, index: u32, side: HalfEdge, right: DVec2, left: DVec2) -> Self {
        let middle = 0.5 * (right + left);
        let (mut source, mut to_source) = (self.source, self.to_source);
        let (mut wedge_left, mut wedge_right) = (left, right);
        let to_middle;
        let bend = if turn(self.source, self.left, right) > 0.0 {
            Some(self.left)
        } else if turn(self.source, self.right, left) < 0.0 {
            Some(self.right)
        } else {
            None
        };
        if let Some(vertex) = bend {
            to_source += self.source.distance(vertex);
            source = vertex;
            to_middle = to_source + vertex.distance(middle);
        } else {
            to_middle = self.to_source + self.distance_through(middle);
            if turn(self.source, self.left, left) > 0.0 {
                wedge_left = self.left;
            }
            if turn(self.source, self.right, right) < 0.0 {
                wedge_right = self.right;
            }
        }
        // Into the frame of the new side.
        let along = left - right;
        let width = along.length();
        let unit = if width > 0.0 { along / width } else { DVec2::X };
        let frame = |p: DVec2| {
            let d = p - right;
            DVec2::new(d.dot(unit), unit.perp_dot(d))
        };
        Self {
            source: frame(source),
            left: frame(wedge_left),
            right: frame(wedge_right),
            to_source,
            to_middle,
            side,
            parent: index,
        }
    }
}

/// Positive where a → b → c turns left.
#[inline]
pub(crate) fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// A four-ary heap of labels by priority; ties go to the older label, so that the order is defined.
#[derive(Debug, Default)]
pub(super) struct Heap(Vec<(f64, u32)>);

impl Heap {
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    fn before(a: (f64, u32), b: (f64, u32)) -> bool {
        a.0 < b.0 || (a.0 == b.0 && a.1 < b.1)
    }

    pub(super) fn push(&mut self, priority: f64, label: u32) {
        let entry = (priority, label);
        let mut i = self.0.len();
        self.0.push(entry);
        while i > 0 {
            let parent = (i - 1) / 4;
            if !Self::before(entry, self.0[parent]) {
                break;
            }
            self.0[i] = self.0[parent];
            i = parent;
        }
        self.0[i] = entry;
    }

    pub(super) fn pop(&mut self) -> Option<(f64, u32)> {
        let top = *self.0.first()?;
        let entry = self.0.pop()?;
        let n = self.0.len();
        if n > 0 {
            let mut i = 0;
            loop {
                let first = 4 * i + 1;
                if first >= n {
                    break;
                }
                let mut child = first;
                for k in first + 1..(first + 4).min(n) {
                    if Self::before(self.0[k], self.0[child]) {
                        child = k;
                    }
                }
                if !Self::before(self.0[child], entry) {
                    break;
                }
                self.0[i] = self.0[child];
                i = child;
            }
            self.0[i] = entry;
        }
        Some(top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flooding_finds_a_strip() {
        use crate::surface::{SurfaceOptions, shapes};
        let surface = Surface::build(&shapes::torus(2.0, 1.0, 12, 8), &SurfaceOptions::default()).unwrap();
        let at = |face| InnerPoint { face, weights: [0.2, 0.3, 0.5] };
        let mut search = Search::default();
        search.targets.push(at(150));
        let mut strip = Vec::new();
        let found = search.flood(&surface, &at(3), &mut strip).unwrap();
        assert_eq!((found.start, found.end, strip[0].face()), (at(3), at(150), 3));
        assert!(strip.windows(2).all(|w| surface.twin(w[0]).face() == w[1].face()));
        assert_eq!(surface.twin(strip[strip.len() - 1]).face(), 150);
    }

    #[test]
    fn heap_sorts() {
        let mut heap = Heap::default();
        let mut state = 1_u64;
        for i in 0..1000 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            heap.push((state >> 58) as f64, i);
        }
        let mut last = (-1.0, 0);
        for _ in 0..1000 {
            let next = heap.pop().unwrap();
            assert!(Heap::before(last, next));
            last = next;
        }
        assert!(heap.pop().is_none());
    }
}
