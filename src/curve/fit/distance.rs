//! How far two lines in space are apart at most.

use glam::DVec3;

/// A polyline with its length up to each vertex, counted from any place.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) positions: &'a [DVec3],
    pub(super) along: &'a [f64],
}

impl Line<'_> {
    fn length(&self) -> f64 {
        let [first, last] = [self.along.first(), self.along.last()].map(|d| d.copied().unwrap_or(0.0));
        last - first
    }

    fn start(&self) -> f64 {
        self.along.first().copied().unwrap_or(0.0)
    }
}

/// The place of a line that is nearest to a position.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    pub(super) distance: f64,
    pub(super) position: DVec3,
    /// Length of the line up to there.
    pub(super) along: f64,
    stretch: usize,
}

/// Places are compared with those of the other line whose share of the length differs by no more than this.
const WINDOW: f64 = 0.12;
/// A stretch is halved this often where the bound for it is larger than it need be.
const HALVINGS: u32 = 4;
/// So many stretches ahead of the last one are looked at before all in the window are.
const AHEAD: usize = 6;

/// A bound for the distance from every place of `a` to `b`, and where on `a` (by length) it is largest.
///
/// Between places that are matched in order, the distance of two straight stretches is a convex function, largest at an end;
/// so the bound holds everywhere, not at vertices alone. Places are compared with those at about the same share of the
/// length: lines that run together for a while do not count for one another later.
pub(super) fn farthest(a: Line<'_>, b: Line<'_>, tolerance: f64) -> (f64, f64) {
    let nothing = (f64::INFINITY, a.start());
    let scale = b.length() / a.length().max(f64::MIN_POSITIVE);
    let mut search = Farthest { a, b, scale, tolerance, bound: 0.0, at: a.start() };
    let Some(first) = a.positions.first() else { return nothing };
    let Some(mut from) = search.matched(*first, a.start(), 0) else { return nothing };
    search.note(from.distance, a.start());
    for (pair, along) in a.positions.windows(2).zip(a.along.windows(2)) {
        let Some(to) = search.matched(pair[1], along[1], from.stretch) else { return nothing };
        search.stretch([(pair[0], along[0], from), (pair[1], along[1], to)], HALVINGS);
        from = to;
    }
    (search.bound, search.at)
}

struct Farthest<'a> {
    a: Line<'a>,
    b: Line<'a>,
    scale: f64,
    tolerance: f64,
    bound: f64,
    at: f64,
}

impl Farthest<'_> {
    fn note(&mut self, distance: f64, at: f64) {
        if distance > self.bound {
            (self.bound, self.at) = (distance, at);
        }
    }

    /// A place of `b` that is near to a position of `a`: the nearest one a little ahead of the last, or, where that is far, in
    /// the whole window.
    fn matched(&self, position: DVec3, along: f64, last: usize) -> Option<Nearest> {
        let begin = last.saturating_sub(1);
        let near = self.b.nearest_of(position, begin, begin + AHEAD);
        if near.is_some_and(|near| near.distance <= 0.25 * self.tolerance) {
            return near;
        }
        let expected = self.b.start() + (along - self.a.start()) * self.scale;
        let all = self.b.nearest_within(position, expected, self.tolerance);
        [near, all].into_iter().flatten().min_by(|x, y| x.distance.total_cmp(&y.distance))
    }

    fn stretch(&mut self, ends: [(DVec3, f64, Nearest); 2], halvings: u32) {
        let [(p, from, match_p), (q, to, match_q)] = ends;
        self.note(match_q.distance, to);
        let bound = self.between(ends);
        if bound <= self.bound {
            return;
        }
        let (middle, half) = (p.midpoint(q), 0.5 * (from + to));
        if bound > 0.5 * self.tolerance
            && halvings > 0
            && let Some(between) = self.matched(middle, half, match_p.stretch)
        {
            self.stretch([(p, from, match_p), (middle, half, between)], halvings - 1);
            self.stretch([(middle, half, between), (q, to, match_q)], halvings - 1);
            return;
        }
        self.note(bound, half);
    }

    /// A bound for a stretch of `a` whose ends are matched.
    fn between(&self, [(p, _, match_p), (q, _, match_q)]: [(DVec3, f64, Nearest); 2]) -> f64 {
        let ends = match_p.distance.max(match_q.distance);
        // Nothing is farther from both ends than their middle is.
        let at_most = 0.5 * (match_p.distance + match_q.distance + p.distance(q));
        if match_q.stretch < match_p.stretch {
            return at_most;
        }
        let (way, mut share, mut bound) = (q - p, 0.0_f64, ends);
        for vertex in &self.b.positions[match_p.stretch + 1..=match_q.stretch] {
            let there = (*vertex - p).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
            share = share.max(there.clamp(0.0, 1.0));
            bound = bound.max(vertex.distance(p + share * way));
        }
        bound.min(at_most)
    }
}

impl Line<'_> {
    /// The nearest place on some stretches.
    fn nearest_of(&self, position: DVec3, first: usize, end: usize) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        for k in first..end.min(self.positions.len().saturating_sub(1)) {
            let way = [self.positions[k], self.positions[k + 1]];
            let (distance, share) = to_stretch(position, way);
            if best.is_none_or(|best| distance < best.distance) {
                let along = self.along[k] + share * (self.along[k + 1] - self.along[k]);
                best = Some(Nearest { distance, position: way[0].lerp(way[1], share), along, stretch: k });
            }
        }
        best
    }

    /// The nearest place about a length.
    fn nearest_within(&self, position: DVec3, expected: f64, tolerance: f64) -> Option<Nearest> {
        let reach = WINDOW * self.length() + 4.0 * tolerance;
        let first = self.along.partition_point(|d| *d < expected - reach).saturating_sub(1);
        let end = self.along.partition_point(|d| *d <= expected + reach);
        self.nearest_of(position, first, end.max(first + 1))
    }

    /// The nearest place to a position that lies at a share of another line's length.
    pub(super) fn nearest(&self, position: DVec3, share: f64, tolerance: f64) -> Option<Nearest> {
        self.nearest_within(position, self.start() + share * self.length(), tolerance)
    }
}

/// Distance of a position from a stretch, and the share of it that lies before the nearest place.
fn to_stretch(p: DVec3, [a, b]: [DVec3; 2]) -> (f64, f64) {
    let way = b - a;
    let share = ((p - a).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (p.distance(a + share * way), share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_holds_between_vertices() {
        // A tent over a straight line that has no vertex beneath its top, and the other way round.
        let tent = [DVec3::ZERO, DVec3::new(1.0, 0.1, 0.0), DVec3::new(2.0, 0.0, 0.0)];
        let flat = [DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0)];
        let (a, b) =
            (Line { positions: &tent, along: &[0.0, 1.005, 2.01] }, Line { positions: &flat, along: &[0.0, 2.0] });
        let (there, at) = farthest(a, b, 0.01);
        assert!((there - 0.1).abs() < 1e-12 && (at - 1.005).abs() < 1e-12);
        let (back, at) = farthest(b, a, 0.01);
        assert!((0.0995..0.1001).contains(&back) && (at - 1.0).abs() < 0.1, "{back} {at}");
        // The same line with other vertices is no distance away.
        let many: Vec<_> = (0..=70).map(|k| DVec3::X * f64::from(k) / 35.0).collect();
        let along: Vec<_> = many.iter().map(|p| p.x).collect();
        let c = Line { positions: &many, along: &along };
        assert!(farthest(b, c, 1e-9).0 < 1e-15 && farthest(c, b, 1e-9).0 < 1e-15);
    }
}
