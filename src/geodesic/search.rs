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
    guide::{Arrival, BackAlong, Guide, Inside, Portal, ThroughSpace},
    queue::Queue,
    stamps::{Reached, Stamps},
};
use crate::surface::{HalfEdge, InnerPoint, Surface, metric};

/// A new label must beat the old one by this factor, or rounding makes endless improvements.
const BETTER: f64 = 1.0 - 1e-6;

/// Labels count as equally promising within this share of the mean edge.
const BUCKET: f64 = 0.02;

/// Points less than this many mean edges apart are near, and between them the way ahead counts as longer by a factor than it is
/// straight through space. Most surfaces bend by so much, two fifths of the labels are saved, and of random pairs of points as
/// many get a longer path as get a shorter one. Not so of points further apart: there such a search misses shorter ways.
const NEAR: f64 = 20.0;
const BENT: f64 = 1.1;

/// The search gives up after this many labels a side of the surface; sound meshes need less than one.
const MAX_LABELS_A_SIDE: usize = 64;

/// What is known about reaching a side, in the plane of the faces unfolded so far; the pseudo-source is at (0, 0), so that a
/// point is its own direction.
#[derive(Clone, Copy, Debug)]
struct Label {
    portal: Portal,
    wedge: Wedge,
    /// Distance from the start to the pseudo-source.
    to_source: f64,
    side: HalfEdge,
    parent: u32,
    behind: Behind,
}

const NO_PARENT: u32 = u32::MAX;

/// Scratch memory of the search: 64 bytes a face that it reaches, and 170 a label.
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
        let guide = ThroughSpace::to(surface.inner_position(to));
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
        let [start, goal] = [from, to].map(|p| surface.inner_position(p));
        let mean_edge = surface.mean_edge[surface.sheet[from.face as usize] as usize];
        let is_near = start.distance_squared(goal) < (NEAR * mean_edge).powi(2);
        let guide = ThroughSpace::stretched(goal, if is_near { BENT } else { 1.0 });
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
        let guide = Inside { corridor, through_space: ThroughSpace::to(surface.inner_position(to)) };
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
            let apex = label.behind.apex(&label.portal);
            for target in self.targets.iter().filter(|t| t.face == label.behind.twin.face()) {
                let place = label.behind.spell(&label.portal, apex, target);
                let distance = label.to_source + label.wedge.distance(place);
                if distance < self.limit {
                    (self.limit, last, end) = (distance, index, Some(*target));
                }
            }
            self.expand(surface, &label, index, apex, guide);
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
            let (width, end) = (length(side), DVec2::new(length(side), 0.0));
            let apex = metric::apex(DVec2::ZERO, end, width, length(side.prev()), length(side.next()));
            let source = w0 * DVec2::ZERO + w1 * end + w2 * apex;
            let squared = [surface.origin(side), surface.target(side)].map(|v| guide.squared(surface, v));
            let ends = [DVec2::ZERO - source, end - source];
            let (twin, known) = (surface.twin(side), self.reached.to_middle(side));
            let seen = Seen {
                source: DVec2::ZERO,
                to_source: 0.0,
                wedge: Wedge { right: ends[0], left: ends[1] },
                to_middle: (0.5 * (ends[0] + ends[1])).length(),
            };
            let reach = Reach { side, twin, known, ends, squared, width, parent: NO_PARENT };
            self.offer(surface, &reach, &seen, guide);
        }
    }

    /// Keeps a label if its distance to the side's middle is less than what is known, and not worse than what is known from the
    /// side's other face, unless it cannot lead to a shorter path than what is known.
    #[inline(always)]
    fn offer(&mut self, surface: &Surface, reach: &Reach, seen: &Seen, guide: &impl Guide) {
        let Reach { side, twin, known, ends, squared, width, parent } = *reach;
        let Seen { source, to_source, wedge, to_middle } = *seen;
        let is_improvement = to_middle < known * BETTER && to_middle * BETTER < self.reached.to_middle(twin);
        if !is_improvement {
            return;
        }
        let portal = Portal::new(ends.map(|end| end - source), squared, width);
        let arrival = Arrival { side, twin, portal: &portal, to_source, to_middle };
        let Some(priority) = guide.length_through(surface, &arrival) else { return };
        if priority < self.limit {
            self.reached.set(side, Reached { label: self.pool.len() as u32, to_middle });
            self.queue.push(priority);
            let behind = Behind::of(surface, twin, self.slack, guide);
            self.pool.push(Label { portal, wedge, to_source, side, parent, behind });
        }
    }

    /// Offers labels to the two sides of the face behind a label's side.
    #[inline(always)]
    fn expand(&mut self, surface: &Surface, label: &Label, parent: u32, apex: DVec2, guide: &impl Guide) {
        let Label { portal: Portal { right, left, squared, .. }, wedge, to_source, behind, .. } = *label;
        let Behind { twin, twins, lengths, apex_squared } = behind;
        // Where the apex lies beyond a limit of the wedge, the wedge misses one side, which is reached around that limit.
        let beyond_left = wedge.left.perp_dot(apex) > 0.0;
        let beyond_right = wedge.right.perp_dot(apex) < 0.0;
        let sides = [twin.prev(), twin.next()];
        let known = self.reached.to_middles(sides);
        let (side, twin_of_side) = (sides[0], twins[0]);
        if twin_of_side.is_some() {
            let limits = Wedge {
                right: if beyond_right { wedge.right } else { apex },
                left: if wedge.left.perp_dot(left) > 0.0 { wedge.left } else { left },
            };
            let (ends, squared) = ([apex, left], [apex_squared, squared[1]]);
            let seen = Seen::new(beyond_left, wedge.left, limits, to_source, ends);
            let (twin, known, width) = (twin_of_side, known[0], lengths[0]);
            self.offer(surface, &Reach { side, twin, known, ends, squared, width, parent }, &seen, guide);
        }
        let (side, twin_of_side) = (sides[1], twins[1]);
        if twin_of_side.is_some() {
            let limits = Wedge {
                right: if wedge.right.perp_dot(right) < 0.0 { wedge.right } else { right },
                left: if beyond_left { wedge.left } else { apex },
            };
            let (ends, squared) = ([right, apex], [squared[0], apex_squared]);
            let seen = Seen::new(beyond_right, wedge.right, limits, to_source, ends);
            let (twin, known, width) = (twin_of_side, known[1], lengths[1]);
            self.offer(surface, &Reach { side, twin, known, ends, squared, width, parent }, &seen, guide);
        }
    }
}

/// A side that may get a label.
struct Reach {
    side: HalfEdge,
    twin: HalfEdge,
    /// The distance to its middle that is known.
    known: f64,
    /// Its right and left end, and what the guide says of them.
    ends: [DVec2; 2],
    squared: [f64; 2],
    width: f64,
    parent: u32,
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

/// The face behind a label's side, looked up when the label is made: when its turn comes, everything is at hand.
#[derive(Clone, Copy, Debug)]
struct Behind {
    /// The label's side as seen from there.
    twin: HalfEdge,
    /// What lies across the other two sides, the one at the left first, and their lengths.
    twins: [HalfEdge; 2],
    lengths: [f64; 2],
    /// What the guide says of the corner between them.
    apex_squared: f64,
}

impl Behind {
    #[inline(always)]
    fn of(surface: &Surface, twin: HalfEdge, slack: f64, guide: &impl Guide) -> Self {
        let (twins, lengths) = (&surface.twins[twin.face() as usize], &surface.lengths[twin.face() as usize]);
        let [left, right] = [twin.prev().side(), twin.next().side()];
        Self {
            twin,
            twins: [twins[left], twins[right]],
            lengths: [lengths[left] + slack, lengths[right] + slack],
            apex_squared: guide.squared(surface, surface.origin(twin.prev())),
        }
    }

    /// The corner opposite the portal.
    #[inline(always)]
    fn apex(&self, portal: &Portal) -> DVec2 {
        let Portal { right, left, width, per_width, .. } = *portal;
        metric::apex_over(left, right, [width, per_width], self.lengths[0], self.lengths[1])
    }

    /// A point of the face.
    fn spell(&self, portal: &Portal, apex: DVec2, p: &InnerPoint) -> DVec2 {
        let [left, right, opposite] = [self.twin, self.twin.next(), self.twin.prev()].map(|h| p.weights[h.side()]);
        left * portal.left + right * portal.right + opposite * apex
    }
}

/// How a side is seen from the face before it.
struct Seen {
    /// The pseudo-source: another one if the side is reached around a limit of the wedge.
    source: DVec2,
    to_source: f64,
    wedge: Wedge,
    to_middle: f64,
}

impl Seen {
    #[inline(always)]
    fn new(is_missed: bool, limit: DVec2, wedge: Wedge, to_source: f64, ends: [DVec2; 2]) -> Self {
        let middle = 0.5 * (ends[0] + ends[1]);
        if is_missed {
            let to_source = to_source + limit.length();
            let wedge = Wedge { right: ends[0] - limit, left: ends[1] - limit };
            Self { source: limit, to_source, wedge, to_middle: to_source + middle.distance(limit) }
        } else {
            Self { source: DVec2::ZERO, to_source, wedge, to_middle: to_source + wedge.distance(middle) }
        }
    }
}

/// What is seen of the plane behind a side from the pseudo-source: all between two limits.
#[derive(Clone, Copy, Debug)]
struct Wedge {
    right: DVec2,
    left: DVec2,
}

impl Wedge {
    /// Distance from the pseudo-source to `x`, bending at a limit where `x` lies outside.
    #[inline]
    fn distance(&self, x: DVec2) -> f64 {
        if self.left.perp_dot(x) > 0.0 {
            self.left.length() + self.left.distance(x)
        } else if self.right.perp_dot(x) < 0.0 {
            self.right.length() + self.right.distance(x)
        } else {
            x.length()
        }
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
