//! Crossings that gather about a vertex.
//!
//! Corners are rounded off while a line is solved for. Crossings that are nearer to one another than the rounding may lie anywhere within it: nothing
//! that can be seen, but turns to and fro by a radian, and they count. What gathers about a vertex is laid straight past it, or on it.

use std::f64::consts::{PI, TAU};

use super::{
    engine::{Engine, NEAR},
    flip::touching,
    strip::{AT_VERTEX, Run, Strip},
};
use crate::surface::Surface;

/// No crossing is moved farther than this, in mean edges: what is farther off has been solved for.
const FAR: f64 = 0.05;
/// Crossings are moved only if the line then turns by so much less, in radians: bends that were solved for stay.
const GAIN: f64 = 1e-2;

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
            let is_free = |strip: &Strip| !strip.fixed[run.first..=run.last].contains(&true);
            if run.first < run.last && is_inside && is_free(strip) {
                self.straighten_run(surface, strip, &run, FAR * mean);
            }
        }
    }

    fn straighten_run(&mut self, surface: &Surface, strip: &mut Strip, run: &Run, far: f64) {
        let Self { metric, layout, fan, bounds, places, .. } = self;
        let (before, after) = (run.first - 1, run.last + 1);
        // How the line bends at another vertex is not for single crossings to say.
        let is_at_vertex = |k: usize| strip.at[k] <= AT_VERTEX || strip.at[k] >= 1.0 - AT_VERTEX;
        if is_at_vertex(before) || is_at_vertex(after) {
            return;
        }
        let turns = |strip: &Strip| (before..=after).map(|k| layout.turn(k, &strip.at).abs()).sum::<f64>();
        let was = turns(strip);
        fan.unfold(surface, metric, strip, layout, run);
        let is_past = fan.angle < PI;
        let place = |k: usize| {
            let off = if is_past { fan.chord(k - run.first) / layout.lengths[k].max(f64::MIN_POSITIVE) } else { 0.0 };
            if run.left { 1.0 - off } else { off }
        };
        places.clear();
        for (k, [low, high]) in (run.first..=run.last).zip(&bounds[run.first..=run.last]) {
            let (old, new) = (strip.at[k], place(k));
            let fits = *low <= new && new <= *high;
            if !fits || (new - old).abs() * layout.lengths[k] > far {
                return;
            }
            places.push([old, new]);
        }
        let put = |strip: &mut Strip, which: usize| {
            strip.at[run.first..=run.last].iter_mut().zip(places.iter()).for_each(|(at, place)| *at = place[which]);
        };
        put(strip, 1);
        // What is at the vertex has no turn of its own: the line bends there, by its share of the angle about it.
        let bends = !is_past && !surface.boundary[run.vertex as usize];
        let bend = if bends { TAU / metric.angle(surface, run.vertex) * fan.angle - PI } else { 0.0 };
        if turns(strip) + bend.abs() >= was - GAIN {
            put(strip, 0);
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
        assert!(all < 1.3 * seen, "{all} of {seen}");
    }
}
