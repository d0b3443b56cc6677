//! Where a closed line begins: its seam, over which no vertex is passed and no window reaches.

use std::ops::Range;

use super::{engine::Engine, layout::Layout, strip::Strip, windows::MARGIN};
use crate::surface::Surface;

impl Engine {
    /// Moves the seam of a closed line, which is laid flat, off the vertices that the line touches; and off what the last flips changed, unless all is
    /// to be solved for anyway: a change at the seam would have all of the line solved for in its place. Where a run was left because it is at
    /// the seam, it `must` move.
    pub(crate) fn move_seam(&mut self, surface: &Surface, strip: &mut Strip, near: f64, all: bool, must: bool) {
        let Self { layout, flipper, .. } = self;
        let changed = &mut flipper.changed;
        let first = seam_place(surface, strip, layout, near, if all || must { &[] } else { changed }, must);
        if first > 0 {
            strip.rotate(first);
            layout.rotate(first);
            turn_along(changed, first, strip.len());
        }
    }
}

/// The crossing before which the seam is to be: where it is, if that is good enough.
fn seam_place(
    surface: &Surface,
    strip: &Strip,
    layout: &Layout,
    near: f64,
    changed: &[Range<usize>],
    must: bool,
) -> usize {
    let n = strip.len();
    if n == 0 {
        return 0;
    }
    let free = |i: &usize| strip.is_seam_free(surface, *i, |k, off| off * layout.lengths[k] <= near);
    let is_apart = changed.iter().all(|range| range.start > MARGIN && range.end + MARGIN < n);
    let gap = widest_gap(changed, n);
    let middle = gap.start + gap.len() / 2;
    let outwards =
        (0..=gap.len() / 2).flat_map(|k| [middle - k, middle + k]).filter(|i| gap.contains(i)).map(|i| i % n);
    let here = (is_apart && !must).then_some(0).into_iter();
    if let Some(first) = here.chain(outwards).chain(0..n).find(free) {
        return first;
    }
    if !must {
        return 0;
    }
    // Where the line touches vertices all along, the seam goes from run to run, so that each is passed in its turn.
    let vertex = |i: usize| strip.end_vertex(surface, i % n, strip.at[i % n] > 0.5);
    let in_next_run = (1..n).find(|i| vertex(*i) != vertex(i - 1) && vertex(*i) == vertex(i + 1));
    in_next_run.map_or(0, |i| (i + 1) % n)
}

/// The widest gap between changed ranges of a closed line of `n` crossings, without the margins of these; it may reach beyond `n`.
fn widest_gap(changed: &[Range<usize>], n: usize) -> Range<usize> {
    let starts = changed.iter().skip(1).map(|range| range.start).chain(changed.first().map(|range| range.start + n));
    let gaps = changed.iter().zip(starts).map(|(range, next)| range.end + MARGIN + 1..next.saturating_sub(MARGIN));
    gaps.max_by_key(ExactSizeIterator::len).unwrap_or(0..0)
}

/// Changed ranges of a closed line of `n` crossings that begins with crossing `first` now; all of it where one lies about that.
fn turn_along(changed: &mut Vec<Range<usize>>, first: usize, n: usize) {
    if changed.iter().any(|range| range.start < first && first < range.end) {
        changed.clear();
        changed.push(0..n);
        return;
    }
    let before = changed.iter().take_while(|range| range.start < first).count();
    changed.rotate_left(before);
    for range in changed {
        let start = (range.start + n - first) % n;
        *range = start..start + range.len();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smooth::tests::{Random, built, ring, shaken};
    use crate::surface::shapes;
    use glam::DVec3;

    /// What changed is what it was, lies apart from the seam where there is room, and what is laid flat goes along.
    #[test]
    fn a_seam_moves_off_what_changed() {
        let surface = built(&shapes::icosphere(4));
        let around = (0..60).map(|k| f64::from(k) * std::f64::consts::TAU / 60.0);
        let line = ring(&surface, around.map(|a| DVec3::new(a.cos(), a.sin(), 0.2 * (3.0 * a).sin())));
        let mut random = Random(5);
        let line = shaken(&surface, &line, &mut random, 0.6);
        let (mut strip, mut engine, mut fresh) = (Strip::default(), Engine::default(), Layout::default());
        line.strip_into(&surface, &mut strip).unwrap();
        let n = strip.len();
        assert!(n > 100, "{n}");
        for _ in 0..200 {
            // A few ranges anywhere, often at the seam.
            let mut changed: Vec<Range<usize>> = Vec::new();
            let mut start = (random.word() % 12) as usize;
            while start + 6 < n && changed.len() < 4 {
                changed.push(start..start + 1 + (random.word() % 5) as usize);
                start += 6 + (random.word() % 60) as usize;
            }
            let sides = |strip: &Strip, changed: &[Range<usize>]| {
                let mut all: Vec<_> = changed.iter().map(|range| strip.sides[range.clone()].to_vec()).collect();
                all.sort();
                all
            };
            let was = sides(&strip, &changed);
            engine.flipper.changed = changed;
            engine.layout.build(&surface, &mut engine.metric, &strip);
            engine.move_seam(&surface, &mut strip, 1e-9, false, false);
            let changed = engine.flipper.changed.clone();
            assert_eq!(sides(&strip, &changed), was);
            assert!(changed.is_sorted_by_key(|range| range.start), "{changed:?}");
            engine.choose_windows(&strip, false);
            let most: usize = changed.iter().map(|range| range.len() + 2 * MARGIN).sum();
            let solved: usize = engine.windows.iter().map(ExactSizeIterator::len).sum();
            assert!(solved <= most, "{solved} of {n}: {changed:?}");
            fresh.build(&surface, &mut engine.metric, &strip);
            for i in 0..n {
                assert_eq!(engine.layout.turn(i, &strip.at), fresh.turn(i, &strip.at));
                assert_eq!(engine.layout.place(i, 0.3), fresh.place(i, 0.3));
            }
        }
    }

    #[test]
    fn changed_ranges_go_along() {
        let turned = |changed: &[Range<usize>], first: usize| {
            let mut changed = changed.to_vec();
            turn_along(&mut changed, first, 10);
            changed
        };
        assert_eq!(turned(&[1..2, 4..6, 8..9], 7), [1..2, 4..5, 7..9]);
        assert_eq!(turned(&[1..2, 4..6], 4), [0..2, 7..8]);
        assert_eq!(turned(&[1..2, 4..6], 5), std::slice::from_ref(&(0..10)), "one lies about the seam");
        assert!(turned(&[], 3).is_empty());
        assert_eq!(widest_gap(&[10..12, 70..71], 100), 12 + MARGIN + 1..70 - MARGIN);
        assert_eq!(widest_gap(&[10..12, 40..41], 100), 41 + MARGIN + 1..110 - MARGIN);
        assert!(widest_gap(&[0..3, 8..9], 16).is_empty());
    }

    /// A line there and back along an edge touches vertices everywhere; its seam comes into either run.
    #[test]
    fn a_seam_among_vertices_goes_from_run_to_run() {
        let surface = built(&shapes::icosphere(2));
        let line = ring(&surface, [DVec3::X, DVec3::Y, DVec3::Z]);
        let (mut strip, mut engine) = (Strip::default(), Engine::default());
        line.strip_into(&surface, &mut strip).unwrap();
        for (i, t) in strip.at.iter_mut().enumerate() {
            *t = if i % 7 < 3 { 0.0 } else { 1.0 };
        }
        let mut firsts = std::collections::HashSet::new();
        for _ in 0..strip.len() {
            engine.layout.build(&surface, &mut engine.metric, &strip);
            engine.move_seam(&surface, &mut strip, 1e-9, true, true);
            let vertex = |i: usize| strip.end_vertex(&surface, i, strip.at[i] > 0.5);
            assert_eq!(vertex(0), vertex(strip.len() - 1));
            firsts.insert(vertex(0));
        }
        assert!(firsts.len() > 2, "{}", firsts.len());
    }
}
