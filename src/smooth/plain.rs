//! Smoothing by sweeps: every crossing to where the line turns there as it should between its neighbours, again and again.
//!
//! That is the thesis' way, kept to compare with and for line lengths that are to be met on the way ([`Budget`]).
//!
//! [`Budget`]: super::SmoothingMode::Budget

use super::{
    engine::{Done, Engine, Plan},
    flip::Rule,
    hinge,
    metrics::Gauge,
    progress::Watch,
    strip::Strip,
};
use crate::surface::Surface;

/// Crossings this near to an end of their side, as a share of it, are at the vertex.
const CLAMPED: f64 = 1e-6;
/// Nothing moves any more when no crossing moves by more than this, in mean edges.
const STILL: f64 = 1e-5;
/// Sweeps after which the line has to be shorter, and by which share of its length.
const PATIENCE: u32 = 500;
const STALLED: f64 = 1e-4;
/// Sweeps without a vertex passed, before an end.
const QUIET: u32 = 2;
/// How much of its way a crossing goes that is to turn.
const DAMPING: f64 = 0.5;
/// How often vertices are passed in a row between two sweeps.
const CASCADES: usize = 32;

/// In which order crossings are moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// All at once, from where they were.
    Symmetric,
    /// Every other one, then those between.
    Sequential,
}

/// Scratch memory of sweeps.
#[derive(Debug, Default)]
pub(crate) struct Sweeper {
    next: Vec<f64>,
    clamped: Vec<bool>,
}

impl Engine {
    /// Sweeps until nothing moves, or the sum of turns is at most `enough`.
    #[expect(clippy::too_many_arguments, reason = "a driver's whole setting, called from one place")]
    pub(crate) fn sweep(
        &mut self,
        surface: &Surface,
        strip: &mut Strip,
        plan: &Plan,
        order: Order,
        max_sweeps: u32,
        mut enough: Option<(f64, &mut Gauge)>,
        watch: &mut Watch<'_>,
    ) -> Done {
        let mut done = Done::default();
        self.flipper.counts.clear();
        let (mut quiet, mut before, mut since) = (0, strip.length(surface), 0);
        loop {
            if let Some((least, gauge)) = &mut enough
                && gauge.total_turn(surface, strip) <= *least
            {
                return done;
            }
            if done.steps >= max_sweeps {
                done.met_bound = true;
                return done;
            }
            if watch.stops(&done, || before) {
                return done;
            }
            done.steps += 1;
            self.prepare(surface, strip, plan);
            let moved = self.sweep_once(strip, plan, order);
            watch.see(strip);
            let mut flips = 0;
            for _ in 0..CASCADES {
                let passed = self.pass_clamped(surface, strip, plan);
                if strip.closed && strip.len() < 3 {
                    done.collapsed = true;
                    return done;
                }
                if passed == 0 {
                    break;
                }
                watch.see(strip);
                flips += passed;
                self.prepare(surface, strip, plan);
            }
            done.flips += flips as u32;
            quiet = if flips == 0 { quiet + 1 } else { 0 };
            if strip.closed && strip.length(surface) < 1e-3 * plan.mean {
                done.collapsed = true;
                return done;
            }
            let length = strip.length(surface);
            if length < before * (1.0 - STALLED) {
                (before, since) = (length, done.steps);
            } else if done.steps > since + PATIENCE {
                return done;
            }
            if moved < STILL * plan.mean && quiet > QUIET {
                return done;
            }
        }
    }

    fn prepare(&mut self, surface: &Surface, strip: &mut Strip, plan: &Plan) {
        if strip.closed {
            let _ = strip.seam_off_vertices(surface, |_, off| off <= CLAMPED);
        }
        self.layout.build(surface, &mut self.metric, strip);
        self.fill_bounds(surface, strip, plan);
        if plan.profile {
            self.profile.wished(strip, &mut self.wished);
        } else {
            self.wished.clear();
            self.wished.resize(strip.len(), 0.0);
        }
    }

    /// Moves every crossing once; gives the longest way.
    fn sweep_once(&mut self, strip: &mut Strip, plan: &Plan, order: Order) -> f64 {
        let Self { layout, sweeper, wished, bounds, .. } = self;
        let mut longest = 0.0_f64;
        let mut to = |i: usize, at: &[f64]| {
            let length = layout.lengths[i];
            let [p, q] = layout.around(i, at);
            let here = at[i];
            let place = if length > 0.0 { hinge::turning(p, q, wished[i]) } else { None };
            let place = place.map_or(here, |t| t / length);
            let share = if plan.profile { DAMPING } else { 1.0 };
            let there = (here + share * (place - here)).clamp(bounds[i][0], bounds[i][1]);
            longest = longest.max((there - here).abs() * length);
            there
        };
        match order {
            Order::Symmetric => {
                sweeper.next.clear();
                for i in 0..strip.len() {
                    let next = to(i, &strip.at);
                    sweeper.next.push(next);
                }
                strip.at.copy_from_slice(&sweeper.next);
            }
            Order::Sequential => {
                for first in [0, 1] {
                    for i in (first..strip.len()).step_by(2) {
                        strip.at[i] = to(i, &strip.at);
                    }
                }
            }
        }
        longest
    }

    /// Passes vertices that crossings were clamped to; gives how many.
    fn pass_clamped(&mut self, surface: &Surface, strip: &mut Strip, plan: &Plan) -> usize {
        let Self { metric, layout, flipper, sweeper, wished, bounds, line, .. } = self;
        sweeper.clamped.clear();
        sweeper.clamped.extend(
            strip
                .at
                .iter()
                .zip(bounds.iter())
                .map(|(at, [low, high])| low < high && (*at <= CLAMPED || *at >= 1.0 - CLAMPED)),
        );
        let mut allowed = |vertex: u32| {
            let off = line.nearest(surface.positions[vertex as usize], None);
            plan.envelope.is_none_or(|reach| off.is_some_and(|near| near.distance <= reach))
        };
        let all = 0..strip.len();
        let mut rule = Rule {
            near: 0.0,
            wished: &|_, k| wished[k],
            allowed: &mut allowed,
            straight: true,
            windows: std::slice::from_ref(&all),
        };
        let count = flipper.flip(surface, metric, strip, layout, &mut rule).count;
        if count == 0 && plan.envelope.is_none() {
            flipper.release(surface, metric, strip, layout, &sweeper.clamped);
        }
        count
    }
}
