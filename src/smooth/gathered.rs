//! Crossings that gather about a vertex.
//!
//! Corners are rounded off while the line is solved for, so that crossings nearer to one another than that are anywhere: nothing that can be seen, but
//! turns to and fro by a radian, and they count. What gathers about a vertex is laid straight past it, or on it.

use std::f64::consts::PI;

use super::{
    engine::{Engine, NEAR},
    flip::touching,
    strip::{Run, Strip},
};
use crate::surface::Surface;

/// No crossing is moved farther than this, in mean edges: what is farther off has been solved for.
const FAR: f64 = 0.05;

impl Engine {
    /// Lays crossings that gather about vertices straight, where the line turns less then. The strip is laid flat and its bounds are known.
    pub(crate) fn straighten_gathered(&mut self, surface: &Surface, strip: &mut Strip, mean: f64) {
        let mut i = 0;
        while i < strip.len() {
            let Some(run) = touching(surface, strip, &self.layout, i, NEAR * mean) else {
                i += 1;
                continue;
            };
            i = run.last + 1;
            let is_inside = run.first > 0 && run.last + 1 < strip.len();
            if is_inside && !strip.fixed[run.first..=run.last].contains(&true) {
                self.straighten_run(surface, strip, &run, FAR * mean);
            }
        }
    }

    fn straighten_run(&mut self, surface: &Surface, strip: &mut Strip, run: &Run, far: f64) {
        let Self { metric, layout, fan, bounds, pieces, .. } = self;
        let beside = run.first - 1..run.last + 2;
        let turns = |strip: &Strip| {
            let turn = |k: usize| if k < strip.len() { layout.turn(k, &strip.at).abs() } else { 0.0 };
            beside.clone().map(turn).sum::<f64>()
        };
        let before = turns(strip);
        fan.unfold(surface, metric, strip, layout, run);
        let is_past = fan.angle < PI;
        let place = |k: usize| {
            let off = if is_past { fan.chord(k - run.first) / layout.lengths[k].max(f64::MIN_POSITIVE) } else { 0.0 };
            if run.left { 1.0 - off } else { off }
        };
        // What they were is kept beside what they may be.
        pieces.clear();
        for (k, [low, high]) in (run.first..=run.last).zip(&bounds[run.first..=run.last]) {
            let (old, new) = (strip.at[k], place(k));
            let fits = *low <= new && new <= *high;
            if !fits || (new - old).abs() * layout.lengths[k] > far {
                return;
            }
            pieces.push([old, new]);
        }
        let change = |strip: &mut Strip, which: usize| {
            strip.at[run.first..=run.last].iter_mut().zip(pieces.iter()).for_each(|(at, piece)| *at = piece[which]);
        };
        change(strip, 1);
        // At the vertex the line turns by what the fan says; crossings there have no turn of their own.
        let after = turns(strip) + if is_past { 0.0 } else { fan.turn().abs() };
        if after >= before {
            change(strip, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::smooth::{SmoothWorkspace, Smoothing, bends_into, smooth, tests::Random, tests::built, tests::ring};
    use crate::surface::shapes;
    use glam::DVec3;

    /// What gathers about a vertex turns by no more than what can be seen of it, which is one bend.
    #[test]
    fn turns_too_small_to_be_seen_do_not_add_up() {
        let surface = built(&shapes::icosphere(5));
        let (mut random, mut workspace, mut bends) = (Random(71), SmoothWorkspace::default(), Vec::new());
        let (mut all, mut seen) = (0.0, 0.0);
        for _ in 0..30 {
            let mut tremor = || 0.3 * (random.next() - 0.5);
            let around = (0..120).map(|k| f64::from(k) * std::f64::consts::TAU / 120.0);
            let drawn =
                around.map(|a| DVec3::new(a.cos() + tremor(), a.sin() + tremor(), 0.4 * (3.0 * a).sin() + tremor()));
            let smoothing = Smoothing { roughness: 0.0, ..Smoothing::tether(0.1) };
            let smoothed = smooth(&surface, &mut workspace, &ring(&surface, drawn), &smoothing).unwrap();
            bends_into(&surface, &mut workspace, &smoothed.line, &mut bends).unwrap();
            all += smoothed.after.total_turn;
            seen += bends.iter().map(|bend| bend.turn.abs()).sum::<f64>();
        }
        println!("{all:.2} rad, of which {seen:.2} can be seen");
        assert!(all < 1.2 * seen, "{all} of {seen}");
    }
}
