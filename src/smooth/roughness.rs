//! Where a drawn line is rough, and how much stiffer its tether is where it is not.

use super::{SmoothRange, engine::Engine, nodes, strip::Strip};
use crate::surface::Surface;

/// What is as stiff as that is fixed.
const SMOOTH: f64 = 1e3;
/// Turns on either side of a place by which it is judged to be rough or smooth.
const BESIDE: isize = 8;
/// Turns below this are none.
const TURN: f64 = 0.02;
/// How stiff a tether gets at most where the line is smooth already.
const STIFFEST: f64 = 1e4;
/// What a range weighs at least where it is not fixed.
const LIGHTEST: f64 = 1e-6;

impl Engine {
    /// Fills in by how much stiffer the tether is where the drawn line is smooth.
    ///
    /// A line is rough where it turns to and fro: where of its nearest turns more than two pairs of neighbours point to different sides, by
    /// more than `roughness` in all. Where it is smoother the tether is stiffer by the eighth power of the ratio. Turns are
    /// counted, not lengths: so neither the mesh nor the speed of a hand decides.
    ///
    /// Of a range it is stiffer too where that weighs less. What is known already is not found again.
    pub(crate) fn judge(&mut self, surface: &Surface, strip: &Strip, roughness: f64, range: Option<&SmoothRange>) {
        let by = (roughness, range.copied());
        if self.judged == Some(by) {
            return;
        }
        self.hold_alike();
        if roughness > 0.0 {
            self.stiffen(surface, strip, roughness);
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

    fn stiffen(&mut self, surface: &Surface, strip: &Strip, roughness: f64) {
        self.layout.build(surface, &mut self.metric, strip);
        nodes::find(surface, &mut self.metric, strip, &self.layout, &mut self.fan, &mut self.nodes);
        let Self { nodes, turns, fros, factors, .. } = self;
        turns.clear();
        turns.extend(nodes.iter().filter(|node| node.fold.abs() > TURN).map(|node| (node.first, node.fold)));
        let count = turns.len();
        if count == 0 {
            factors.fill(STIFFEST);
            return;
        }
        // The stretch that begins at a crossing.
        let stretch = |crossing: usize| if strip.closed { crossing } else { crossing + 1 };
        // By how much it turns to and fro between a turn and the next.
        fros.clear();
        fros.extend((0..count).map(|j| match turns.get(j + 1).or(turns.first().filter(|_| strip.closed)) {
            Some((_, after)) if turns[j].1 * after < 0.0 => turns[j].1.abs().min(after.abs()),
            _ => 0.0,
        }));
        let mut next = 0;
        for (k, factor) in factors.iter_mut().enumerate() {
            while next < count && stretch(turns[next].0) <= k {
                next += 1;
            }
            let (mut sum, mut largest) = (0.0, [0.0_f64; 2]);
            let begin = next as isize - BESIDE;
            let mut at = if strip.closed { begin.rem_euclid(count as isize) } else { begin };
            for _ in 0..2 * BESIDE - 1 {
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
