//! Where a drawn line is rough, and how much stiffer its tether is where it is not.

use glam::DVec3;

use super::{SmoothRange, engine::Engine, nodes, strip::Strip};
use crate::surface::Surface;

/// What is as stiff as that is fixed.
const SMOOTH: f64 = 1e3;
/// Turns on either side of a place by which it is judged to be rough or smooth.
const BESIDE: isize = 8;
/// Turns below this are none.
const TURN: f64 = 0.02;
/// Turns to one side within so many mean edges are a corner, if they are so large together: a smooth line as tight as that turns once
/// round within ten edges.
const CORNER: (f64, f64) = (1.5, 1.0);
/// Corners this many mean edges apart at most are jags, to whatever side they turn.
const JAG: f64 = 6.0;
/// How stiff a tether gets at most where the line is smooth already.
const STIFFEST: f64 = 1e4;
/// What is smooth over fewer mean edges than these, between what is not or between that and an end, is rough too: it would stick out of a
/// line that is smoothed beside it.
const SHORT: f64 = 12.0;
/// What a range weighs at least where it is not fixed.
const LIGHTEST: f64 = 1e-6;

/// A turn of the drawn line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    /// At which of its crossings.
    crossing: usize,
    by: f64,
    /// Length of the line up to there.
    along: f64,
    /// Where a corner begins or ends: by how much it turns in all. Elsewhere 0.
    begins: f64,
    ends: f64,
}

impl Engine {
    /// Fills in by how much stiffer the tether is where the drawn line is smooth.
    ///
    /// A line is rough where it turns to and fro: where of its nearest turns more than two pairs of neighbours point to different sides, by
    /// more than `roughness` in all. Corners in quick succession count as such pairs, whatever side they turn to: a hand that trembles by
    /// more than its step goes round in loops as often as it turns back. Where the line is smoother the tether is stiffer by the eighth power
    /// of the ratio; not where that is short. Turns are counted, so that the speed of a hand does not decide; corners, and what is short, are
    /// measured in mean edges.
    ///
    /// Of a range it is stiffer too where that weighs less. What is known already is not found again.
    pub(crate) fn judge(
        &mut self,
        surface: &Surface,
        strip: &Strip,
        mean: f64,
        roughness: f64,
        range: Option<&SmoothRange>,
    ) {
        let by = (roughness, range.copied());
        if self.judged == Some(by) {
            return;
        }
        self.hold_alike();
        if roughness > 0.0 {
            self.stiffen(surface, strip, mean, roughness);
        }
        if let Some(range) = range {
            let mut factors = std::mem::take(&mut self.factors);
            let weight = |i: usize| self.weight(strip, i, range);
            let of_stretch = |k: usize| {
                if strip.closed {
                    0.5 * (weight(k) + weight((k + 1) % strip.len()))
                } else {
                    // Before the first crossing and behind the last one: what these weigh.
                    0.5 * (weight(k.saturating_sub(1)) + weight(k.min(strip.len().saturating_sub(1))))
                }
            };
            if !strip.sides.is_empty() {
                factors.iter_mut().enumerate().for_each(|(k, factor)| *factor /= of_stretch(k).max(LIGHTEST));
            }
            self.factors = factors;
        }
        self.judged = Some(by);
    }

    /// What a range weighs at a crossing of the drawn line.
    fn weight(&self, strip: &Strip, i: usize, range: &SmoothRange) -> f64 {
        let share = strip.along.get(i).map_or(0.0, |share| share - self.begin);
        let share = if strip.closed { share.rem_euclid(1.0) } else { share };
        range.weight(share * self.length, self.length, strip.closed)
    }

    fn stiffen(&mut self, surface: &Surface, strip: &Strip, mean: f64, roughness: f64) {
        self.layout.build(surface, &mut self.metric, strip);
        nodes::find(surface, &mut self.metric, strip, &self.layout, &mut self.fan, &mut self.nodes);
        let Self { nodes, turns, fros, factors, length, .. } = self;
        turns.clear();
        turns.extend(nodes.iter().filter(|node| node.fold.abs() > TURN).map(|node| {
            let along = strip.along[node.first] * *length;
            Turn { crossing: node.first, by: node.fold, along, begins: 0.0, ends: 0.0 }
        }));
        let count = turns.len();
        find_corners(turns, CORNER.0 * mean, CORNER.1);
        if count == 0 {
            factors.fill(STIFFEST);
            return;
        }
        // The stretch that begins at a crossing.
        let stretch = |crossing: usize| if strip.closed { crossing } else { crossing + 1 };
        let once_round = strip.closed.then_some(*length);
        find_to_and_fro(turns, once_round, JAG * mean, fros);
        let mut next = 0;
        for (k, factor) in factors.iter_mut().enumerate() {
            while next < count && stretch(turns[next].crossing) <= k {
                next += 1;
            }
            let (mut sum, mut largest) = (0.0, [0.0_f64; 2]);
            let begin = next as isize - BESIDE;
            let mut at = if strip.closed { begin.rem_euclid(count as isize) } else { begin };
            // Each pair once, where a closed line has few.
            let pairs = if strip.closed { (2 * BESIDE - 1).min(count as isize) } else { 2 * BESIDE - 1 };
            for _ in 0..pairs {
                let fro = usize::try_from(at).ok().and_then(|at| fros.get(at)).copied().unwrap_or(0.0);
                sum += fro;
                largest = if fro > largest[0] { [fro, largest[0]] } else { [largest[0], largest[1].max(fro)] };
                at += 1;
                if strip.closed && at == count as isize {
                    at = 0;
                }
            }
            // Smooth lines turn to the other side once in a while.
            let rough = sum - largest[0] - largest[1];
            if rough < roughness {
                *factor = (roughness / rough.max(1e-9)).powi(8).min(STIFFEST);
            }
        }
        loosen_short(factors, self.line.points(), strip.closed, SHORT * mean);
    }

    /// Tethers all of the drawn line alike.
    pub(crate) fn hold_alike(&mut self) {
        self.judged = None;
        self.factors.clear();
        self.factors.resize(self.line.points().len().saturating_sub(1), 1.0);
    }

    /// Fixes the crossings of the drawn line where it is as smooth as can be.
    pub(crate) fn fix_smooth(&self, strip: &mut Strip) {
        for i in 0..strip.len() {
            let stretches = if strip.closed { [i, (i + strip.len() - 1) % strip.len()] } else { [i, i + 1] };
            let smooth = |k: &usize| self.factors.get(*k).is_some_and(|factor| *factor >= SMOOTH);
            strip.fixed[i] |= stretches.iter().all(smooth);
        }
    }

    /// Fixes the crossings of the drawn line that are outside a range.
    pub(crate) fn fix_outside(&self, strip: &mut Strip, range: &SmoothRange) {
        for i in 0..strip.len() {
            strip.fixed[i] |= self.weight(strip, i, range) <= 0.0;
        }
    }
}

/// Fills in by how much a line turns to and fro between each turn and the next one: by turns to different sides, or corners near one
/// another. After the last turn of a closed line, of the length given, comes the first one.
fn find_to_and_fro(turns: &[Turn], once_round: Option<f64>, near: f64, fros: &mut Vec<f64>) {
    let both = |a: f64, b: f64| a.abs().min(b.abs());
    let corner_before = |turns: &[Turn]| turns.iter().rev().find(|turn| turn.ends != 0.0).copied();
    let behind = |turn: Turn, length: f64| Turn { along: turn.along + length, ..turn };
    let mut corner = once_round.and_then(|length| Some(behind(corner_before(turns)?, -length)));
    fros.clear();
    fros.extend(turns.iter().enumerate().map(|(j, turn)| {
        let first = || once_round.map(|length| behind(turns[0], length));
        let Some(after) = turns.get(j + 1).copied().or_else(first) else { return 0.0 };
        if turn.ends != 0.0 {
            corner = Some(*turn);
        }
        let fro = if turn.by * after.by < 0.0 { both(turn.by, after.by) } else { 0.0 };
        match corner {
            Some(corner) if after.along - corner.along <= near => fro.max(both(corner.ends, after.begins)),
            _ => fro,
        }
    }));
}

/// Puts turns to one side within a width together, and marks where what is sharp begins and ends.
fn find_corners(turns: &mut [Turn], width: f64, sharp: f64) {
    let mut first = 0;
    while first < turns.len() {
        let Turn { by: side, along: begin, .. } = turns[first];
        let is_beside = |turn: &&Turn| turn.by * side > 0.0 && turn.along - begin <= width;
        let count = turns[first..].iter().take_while(is_beside).count().max(1);
        let corner = &mut turns[first..first + count];
        let by = corner.iter().map(|turn| turn.by).sum::<f64>();
        if by.abs() >= sharp {
            corner[0].begins = by;
            corner[count - 1].ends = by;
            first += count;
        } else {
            first += 1;
        }
    }
}

/// Loosens what is stiff over less than a length between what is not; at the ends of an open line too.
fn loosen_short(factors: &mut [f64], points: &[DVec3], closed: bool, short: f64) {
    let n = factors.len();
    let Some(first) = factors.iter().position(|factor| *factor <= 1.0) else { return };
    // From a place that is not stiff on, once round; at the ends of an open line runs end.
    let (mut count, mut length) = (0, 0.0);
    for i in 0..=n {
        let k = (first + i) % n;
        let is_stiff = factors[k] > 1.0;
        if is_stiff {
            (count, length) = (count + 1, length + points[k].distance(points[k + 1]));
        }
        if !is_stiff || (!closed && k + 1 == n) {
            let end = i + usize::from(is_stiff);
            if length < short {
                (end - count..end).for_each(|j| factors[(first + j) % n] = 1.0);
            }
            (count, length) = (0, 0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smooth::{SmoothWorkspace, Smoothing, SurfacePolyline, bends_into, smooth, tests::*};
    use crate::surface::shapes;

    fn turn(by: f64, along: f64) -> Turn {
        Turn { crossing: 0, by, along, begins: 0.0, ends: 0.0 }
    }

    #[test]
    fn corners_are_turns_to_one_side_within_a_width() {
        let mut turns =
            [(0.5, 0.0), (0.75, 1.0), (0.4, 2.0), (-1.0, 2.1), (-0.25, 2.2), (0.5, 2.3)].map(|(b, a)| turn(b, a));
        find_corners(&mut turns, 1.5, 1.0);
        assert_eq!(turns.map(|turn| turn.begins), [1.25, 0.0, 0.0, -1.25, 0.0, 0.0]);
        assert_eq!(turns.map(|turn| turn.ends), [0.0, 1.25, 0.0, 0.0, -1.25, 0.0]);
        let mut late = [(0.05, 0.0), (0.75, 1.4), (0.75, 1.6)].map(|(b, a)| turn(b, a));
        find_corners(&mut late, 1.5, 1.0);
        assert_eq!(late.map(|turn| turn.begins), [0.0, 1.5, 0.0]);
    }

    /// To the other side what is there; to the same side corners alone, if they are near, whatever lies between them.
    #[test]
    fn corners_near_one_another_are_to_and_fro() {
        let corner = |by: f64, along: f64| Turn { begins: by, ends: by, ..turn(by, along) };
        let turns = [corner(1.5, 1.0), turn(0.1, 2.0), corner(1.25, 3.0), corner(2.0, 8.0), turn(-0.5, 9.0)];
        let found = |once_round: Option<f64>, near: f64| {
            let mut fros = Vec::new();
            find_to_and_fro(&turns, once_round, near, &mut fros);
            fros
        };
        assert_eq!(found(None, 2.0), [0.0, 1.25, 0.0, 0.5, 0.0]);
        assert_eq!(found(None, 1.0), [0.0, 0.0, 0.0, 0.5, 0.0]);
        assert_eq!(found(Some(9.5), 5.0), [0.0, 1.25, 1.25, 0.5, 1.5]);
    }

    #[test]
    fn short_stiff_stretches_are_loosened() {
        let points: Vec<DVec3> = (0..9).map(|k| f64::from(k) * DVec3::X).collect();
        let loosened = |stiff: [u8; 8], closed: bool| {
            let mut factors = stiff.map(|s| if s == 1 { 50.0 } else { 1.0 });
            loosen_short(&mut factors, &points, closed, 2.5);
            factors.map(|factor| u8::from(factor > 1.0))
        };
        assert_eq!(loosened([1, 1, 0, 1, 1, 1, 0, 1], false), [0, 0, 0, 1, 1, 1, 0, 0]);
        assert_eq!(loosened([1, 1, 0, 1, 1, 0, 0, 1], true), [1, 1, 0, 0, 0, 0, 0, 1]);
        assert_eq!(loosened([0, 0, 1, 1, 0, 1, 1, 1], false), [0, 0, 0, 0, 0, 1, 1, 1]);
        assert_eq!(loosened([1; 8], true), [1; 8]);
        assert_eq!(loosened([0; 8], false), [0; 8]);
    }

    /// A hand that trembles by more than its step goes round in loops now and then: no part of that is smooth.
    #[test]
    fn no_spike_of_a_trembling_line_is_left() {
        let surface = built(&shapes::icosphere(6));
        let mut workspace = SmoothWorkspace::default();
        for seed in 0..6 {
            let mut random = Random(70 + seed);
            let points: Vec<_> = (0..400)
                .map(|k| {
                    let a = std::f64::consts::TAU * f64::from(k) / 400.0;
                    let tremor = DVec3::new(random.next(), random.next(), random.next()) - 0.5;
                    at(&surface, DVec3::new(a.cos(), a.sin(), 0.3 * (2.0 * a).sin()) + 0.1 * tremor)
                })
                .collect();
            let line = SurfacePolyline::through(&surface, &mut workspace.finder, &points, true).unwrap();
            let smoothed = smooth(&surface, &mut workspace, &line, &Smoothing::default()).unwrap();
            let mut bends = Vec::new();
            bends_into(&surface, &mut workspace, &smoothed.line, &mut bends).unwrap();
            let sharpest = bends.iter().fold(0.0_f64, |most, bend| most.max(bend.turn.abs()));
            let left = smoothed.after.total_turn / smoothed.before.total_turn;
            println!(
                "seed {seed}: {left:.4} of {:.0} rad left, at most {sharpest:.2} in a place",
                smoothed.before.total_turn
            );
            assert!(left < 0.04 && sharpest < 1.0, "{left} {sharpest}");
        }
    }
}
