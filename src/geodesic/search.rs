//! Any-angle search: a strip of faces in which a short path runs.
//!
//! A label sits on a crossed side and holds, in the plane of the faces unfolded so far, a pseudo-source, the distance up to
//! it, and the wedge it sees through the side. Labels are immutable records in a pool: overwriting a label that others
//! descend from would give them a history that never was, and three times as many bad paths.
//!
//! Labels wait in the order of the shortest path that may run through their side: straight to the best place on it, and straight
//! on through space. Which of two labels on a side is the better one is told by their distances to its middle.

use glam::DVec2;

use super::{
    corridor::Corridor,
    guide::{Arrival, BackAlong, Guide, Inside, ThroughSpace},
    queue::Queue,
    stamps::{Reached, Stamps},
};
use crate::surface::{HalfEdge, InnerPoint, Surface, metric};

/// A new label must beat the old one by this factor, or rounding makes endless improvements.
const BETTER: f64 = 1.0 - 1e-6;

/// Labels count as equally promising within this share of the mean edge.
const BUCKET: f64 = 0.02;

/// The search gives up after this many labels a side of the surface; sound meshes need less than one.
const MAX_LABELS_A_SIDE: usize = 64;

/// What is known about reaching a side, seen in the side's frame: origin at (0, 0), target at (length, 0), the face that is
/// left above, travel downwards; left is the target's side.
#[derive(Clone, Copy, Debug)]
struct Label {
    source: DVec2,
    left: DVec2,
    right: DVec2,
    /// Distance from the start to the pseudo-source.
    to_source: f64,
    side: HalfEdge,
    parent: u32,
}

const NO_PARENT: u32 = u32::MAX;

/// Scratch memory of the search: 64 bytes a face where it has been, and 64 a label.
#[derive(Debug, Default)]
pub(crate) struct Search {
    pool: Vec<Label>,
    reached: Stamps,
    queue: Queue,
    targets: Vec<InnerPoint>,
    /// Added to every side's length.
    slack: f64,
    /// No path of this length or longer is wanted.
    limit: f64,
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
    /// Cost: about 0.1 µs a label; labels fill an ellipse about the path.
    pub(crate) fn run(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        to: &InnerPoint,
        strip: &mut Vec<HalfEdge>,
    ) -> Option<Found> {
        self.begin(surface, from, to, f64::INFINITY);
        let guide = ThroughSpace { goal: surface.inner_position(to) };
        let bound = bound_of(surface);
        self.flow(surface, from, &guide, bound, strip).or_else(|| self.flood(surface, from, strip))
    }

    /// [`run`](Self::run) with so many labels only; none if that takes more.
    pub(crate) fn run_briefly(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        to: &InnerPoint,
        labels: usize,
        strip: &mut Vec<HalfEdge>,
    ) -> Option<Found> {
        self.begin(surface, from, to, f64::INFINITY);
        let guide = ThroughSpace { goal: surface.inner_position(to) };
        let found = self.flow(surface, from, &guide, labels, strip);
        found.filter(|_| self.pool.len() <= labels)
    }

    /// [`run`](Self::run) inside a corridor; none if there is no way inside.
    pub(crate) fn run_inside(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        to: &InnerPoint,
        corridor: &Corridor,
        strip: &mut Vec<HalfEdge>,
    ) -> Option<Found> {
        self.begin(surface, from, to, f64::INFINITY);
        let guide = Inside { corridor, through_space: ThroughSpace { goal: surface.inner_position(to) } };
        self.flow(surface, from, &guide, bound_of(surface), strip)
    }

    /// Looks for a strip the other way round, between the same points, after another search: among the sides that were reached
    /// then, for a path of about length `known` or less.
    pub(crate) fn run_back(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        to: &InnerPoint,
        there: &Self,
        known: f64,
        strip: &mut Vec<HalfEdge>,
    ) -> Option<Found> {
        // Distances to the middles of sides make paths longer than they are, by up to about half a side where they begin.
        let slack = 0.5 * surface.mean_edge[surface.sheet[from.face as usize] as usize];
        self.begin(surface, from, to, known + slack);
        self.flow(surface, from, &BackAlong { known: &there.reached }, bound_of(surface), strip)
    }

    /// Spreads labels from the start until none that waits can lead to a shorter path than the one found, or there are more than
    /// `bound`.
    fn flow(
        &mut self,
        surface: &Surface,
        from: &InnerPoint,
        guide: &impl Guide,
        bound: usize,
        strip: &mut Vec<HalfEdge>,
    ) -> Option<Found> {
        surface.for_each_spelling(from, |start| self.seed(surface, &start, guide));
        let (mut last, mut end) = (NO_PARENT, None);
        while let Some(index) = self.queue.pop(self.limit) {
            if self.pool.len() > bound {
                break;
            }
            let label = self.pool[index as usize];
            if self.reached.get(label.side).is_none_or(|reached| reached.label != index) {
                continue; // a better label took its place while it waited
            }
            let behind = Behind::of(surface, label.side, self.slack);
            for target in self.targets.iter().filter(|t| t.face == behind.twin.face()) {
                let distance = label.to_source + label.wedge().distance(behind.spell(target));
                if distance < self.limit {
                    (self.limit, last, end) = (distance, index, Some(*target));
                }
            }
            self.expand(surface, &label, index, &behind, guide);
        }
        let end = end?;
        self.read_strip(last, strip);
        Some(Found { start: spelled_in(surface, from, strip[0].face()), end })
    }

    /// The sides on the way to a label.
    fn read_strip(&self, last: u32, strip: &mut Vec<HalfEdge>) {
        strip.clear();
        let mut at = last;
        while at != NO_PARENT {
            strip.push(self.pool[at as usize].side);
            at = self.pool[at as usize].parent;
        }
        strip.reverse();
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

    fn begin(&mut self, surface: &Surface, from: &InnerPoint, to: &InnerPoint, limit: f64) {
        self.reached.clear(surface.triangles.len());
        self.pool.clear();
        self.queue.clear(BUCKET * surface.mean_edge[surface.sheet[from.face as usize] as usize]);
        self.slack = surface.slack[surface.sheet[from.face as usize] as usize];
        self.limit = limit;
        self.targets.clear();
        let targets = &mut self.targets;
        surface.for_each_spelling(to, |p| targets.push(p));
    }

    /// Puts labels on the sides of a face that do not contain the start.
    fn seed(&mut self, surface: &Surface, start: &InnerPoint, guide: &impl Guide) {
        for k in 0..3 {
            let side = HalfEdge::new(start.face, k);
            let [w0, w1, w2] = [side, side.next(), side.prev()].map(|h| start.weights[h.side()]);
            if w2 == 0.0 || !surface.twin(side).is_some() {
                continue;
            }
            let length = |h: HalfEdge| surface.length(h) + self.slack;
            let width = length(side);
            let end = DVec2::new(width, 0.0);
            let apex = metric::apex(DVec2::ZERO, end, width, length(side.prev()), length(side.next()));
            let source = w0 * DVec2::ZERO + w1 * end + w2 * apex;
            let to_middle = source.distance(0.5 * end);
            let twin = surface.twin(side);
            let arrival = Arrival { side, twin, width, per_width: 1.0 / width, source, to_source: 0.0, to_middle };
            if self.is_improvement([side, twin], to_middle)
                && let Some(priority) = guide.length_through(surface, &arrival)
            {
                let label = Label { source, left: end, right: DVec2::ZERO, to_source: 0.0, side, parent: NO_PARENT };
                self.keep(label, to_middle, priority);
            }
        }
    }

    /// Whether a distance to a side's middle is less than what is known, and not worse than what is known from the side's other
    /// face.
    #[inline]
    fn is_improvement(&self, [side, twin]: [HalfEdge; 2], to_middle: f64) -> bool {
        let known = |h: HalfEdge| self.reached.get(h).map_or(f64::INFINITY, |reached| reached.to_middle);
        to_middle < known(side) * BETTER && to_middle * BETTER < known(twin)
    }

    #[inline]
    fn keep(&mut self, label: Label, to_middle: f64, priority: f64) {
        if priority < self.limit {
            let index = self.pool.len() as u32;
            self.reached.set(label.side, Reached { label: index, to_middle });
            self.queue.push(priority);
            self.pool.push(label);
        }
    }

    /// Offers labels to the two sides of the face behind a label's side.
    #[inline]
    fn expand(&mut self, surface: &Surface, label: &Label, index: u32, behind: &Behind, guide: &impl Guide) {
        let Label { source, left, right, to_source, .. } = *label;
        let apex = behind.apex;
        let twins = &surface.twins[behind.twin.face() as usize];
        // Where the apex lies beyond a limit of the wedge, the wedge misses one side, which is reached around that limit.
        let beyond_left = turn(source, left, apex) > 0.0;
        let beyond_right = turn(source, right, apex) < 0.0;
        let (side, far) = (behind.twin.prev(), behind.left);
        let twin = twins[side.side()];
        if twin.is_some() {
            let wedge = if beyond_left {
                Wedge::around(left, to_source + source.distance(left), apex, far)
            } else {
                let left = if turn(source, left, far) > 0.0 { left } else { far };
                Wedge { source, to_source, left, right: if beyond_right { right } else { apex } }
            };
            let exit = Exit { side, twin, right: apex, left: far, width: behind.to_left };
            self.offer(surface, index, &wedge, &exit, guide);
        }
        let (side, far) = (behind.twin.next(), DVec2::ZERO);
        let twin = twins[side.side()];
        if twin.is_some() {
            let wedge = if beyond_right {
                Wedge::around(right, to_source + source.distance(right), far, apex)
            } else {
                let right = if turn(source, right, far) < 0.0 { right } else { far };
                Wedge { source, to_source, left: if beyond_left { left } else { apex }, right }
            };
            let exit = Exit { side, twin, right: far, left: apex, width: behind.to_right };
            self.offer(surface, index, &wedge, &exit, guide);
        }
    }

    /// Keeps what a wedge says about a side of the face behind, if it is an improvement.
    #[inline]
    fn offer(&mut self, surface: &Surface, parent: u32, wedge: &Wedge, exit: &Exit, guide: &impl Guide) {
        let Exit { side, twin, right, left, width } = *exit;
        let to_middle = wedge.to_source + wedge.distance(0.5 * (right + left));
        if !self.is_improvement([side, twin], to_middle) {
            return;
        }
        // Into the frame of the side.
        let per_width = 1.0 / width;
        let unit = (left - right) * per_width;
        let frame = |p: DVec2| {
            let d = p - right;
            DVec2::new(d.dot(unit), unit.perp_dot(d))
        };
        let source = frame(wedge.source);
        let to_source = wedge.to_source;
        let arrival = Arrival { side, twin, width, per_width, source, to_source, to_middle };
        let Some(priority) = guide.length_through(surface, &arrival) else { return };
        if priority < self.limit {
            let label = Label {
                source,
                left: if wedge.left == left { DVec2::new(width, 0.0) } else { frame(wedge.left) },
                right: if wedge.right == right { DVec2::ZERO } else { frame(wedge.right) },
                to_source,
                side,
                parent,
            };
            self.keep(label, to_middle, priority);
        }
    }
}

/// More labels than this are no use, or have no numbers.
fn bound_of(surface: &Surface) -> usize {
    (MAX_LABELS_A_SIDE * 3 * surface.triangles.len()).min(u32::MAX as usize / 2)
}

/// The spelling of a point in a face around it.
fn spelled_in(surface: &Surface, point: &InnerPoint, face: u32) -> InnerPoint {
    let mut found = *point;
    surface.for_each_spelling(point, |p| {
        if p.face == face {
            found = p;
        }
    });
    found
}

/// The face behind a side, in the frame of the label on the side.
struct Behind {
    twin: HalfEdge,
    /// The side's target, at the left; its origin, at the right, is zero.
    left: DVec2,
    apex: DVec2,
    /// Lengths of the sides from the apex to the left and to the right end.
    to_left: f64,
    to_right: f64,
}

impl Behind {
    #[inline]
    fn of(surface: &Surface, side: HalfEdge, slack: f64) -> Self {
        let twin = surface.twin(side);
        let lengths = surface.lengths[twin.face() as usize];
        let length = |h: HalfEdge| lengths[h.side()] + slack;
        let (width, to_right, to_left) = (length(twin), length(twin.next()), length(twin.prev()));
        let left = DVec2::new(width, 0.0);
        let apex = metric::apex(left, DVec2::ZERO, width, to_left, to_right);
        Self { twin, left, apex, to_left, to_right }
    }

    /// A point of the face.
    fn spell(&self, p: &InnerPoint) -> DVec2 {
        p.weights[self.twin.side()] * self.left + p.weights[self.twin.prev().side()] * self.apex
    }
}

/// A side of the face behind, in the frame of the label's side.
struct Exit {
    side: HalfEdge,
    twin: HalfEdge,
    right: DVec2,
    left: DVec2,
    width: f64,
}

/// What is seen of the plane behind a side: from a pseudo-source, between two limits.
struct Wedge {
    source: DVec2,
    to_source: f64,
    left: DVec2,
    right: DVec2,
}

impl Wedge {
    /// All between two points, seen from a vertex.
    #[inline]
    fn around(vertex: DVec2, to_vertex: f64, right: DVec2, left: DVec2) -> Self {
        Self { source: vertex, to_source: to_vertex, left, right }
    }

    /// Distance from the pseudo-source to `x`, bending at a limit where `x` lies outside.
    #[inline]
    fn distance(&self, x: DVec2) -> f64 {
        if turn(self.source, self.left, x) > 0.0 {
            self.source.distance(self.left) + self.left.distance(x)
        } else if turn(self.source, self.right, x) < 0.0 {
            self.source.distance(self.right) + self.right.distance(x)
        } else {
            self.source.distance(x)
        }
    }
}

impl Label {
    fn wedge(&self) -> Wedge {
        Wedge { source: self.source, to_source: self.to_source, left: self.left, right: self.right }
    }
}

/// Positive where a → b → c turns left.
#[inline]
pub(crate) fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
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
}
