//! What is tried to smooth a line: by its mode, within its envelope, and what else there is where that makes it rougher.

use super::{
    Envelope, Iteration, SmoothWorkspace, Smoothing, SmoothingMode,
    engine::{Done, Plan},
    metric::Kind,
    metrics::stays_within,
    plain::Order,
    progress::Watch,
};
use crate::surface::Surface;

/// Mean edges in the default reach.
const REACH: f64 = 10.0;
/// Closeness of the tether that holds closed lines of which only the turns are wished.
const ANCHOR: f64 = 0.3;
/// Bisections of an envelope's tether, from closeness to closeness.
const BISECTIONS: u32 = 8;
const CLOSENESSES: [f64; 2] = [1e-3, 1e6];
/// Shares of a hard envelope that crossings are kept within, one after the other, until no stretch leaves it.
const WITHIN: [f64; 4] = [0.999, 0.95, 0.8, 0.5];

/// One smoothing under way.
pub(super) struct Smoother<'a, 'w> {
    pub(super) surface: &'a Surface,
    smoothing: &'a Smoothing,
    pub(super) workspace: &'a mut SmoothWorkspace,
    pub(super) watch: &'a mut Watch<'w>,
    mean: f64,
    reach: f64,
    /// Closeness of what holds a closed line of which only the turns are wished.
    anchor: f64,
}

impl<'a, 'w> Smoother<'a, 'w> {
    /// One of the line that the workspace has taken up.
    pub(super) fn new(
        surface: &'a Surface,
        smoothing: &'a Smoothing,
        workspace: &'a mut SmoothWorkspace,
        mean: f64,
        watch: &'a mut Watch<'w>,
    ) -> Self {
        Self {
            surface,
            smoothing,
            workspace,
            watch,
            mean,
            reach: smoothing.reach.unwrap_or(REACH * mean),
            anchor: ANCHOR,
        }
    }

    /// Smooths the line, into the workspace's strip.
    pub(super) fn run(&mut self) -> Done {
        let mut done = self.enveloped();
        if done.collapsed || self.watch.is_stopped() {
            return done;
        }
        self.unfix();
        self.workspace.strip.seam_off_crossings_at_vertices(self.surface);
        if self.is_rougher() {
            done.add(self.smoother());
        }
        done
    }

    /// Leaves fixed what was fixed in the line given.
    fn unfix(&mut self) {
        let SmoothWorkspace { strip, given, .. } = &mut *self.workspace;
        let mut j = 0;
        let Some(first) = strip.along.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map(|(i, _)| i) else {
            return;
        };
        let n = strip.len();
        // Fixed crossings are where they were, in the order in which they were.
        for i in (first..n).chain(0..first) {
            if !strip.fixed[i] {
                continue;
            }
            while j < given.len() && given.along[j] < strip.along[i] {
                j += 1;
            }
            let mut k = j;
            let mut was = false;
            while k < given.len() && given.along[k] == strip.along[i] {
                was |= given.sides[k] == strip.sides[i] && given.fixed[k];
                k += 1;
            }
            strip.fixed[i] = was;
        }
    }

    /// Whether the line turns more than the one given, or is longer, though it is not to.
    fn is_rougher(&mut self) -> bool {
        let before = self.workspace.measured_given(self.surface);
        let SmoothWorkspace { gauge, strip, .. } = &mut *self.workspace;
        let shrinks = match self.smoothing.mode {
            SmoothingMode::Geodesic | SmoothingMode::Budget { .. } | SmoothingMode::Tether { .. } => true,
            SmoothingMode::Stencil { scale, .. } => scale <= 1.0,
            SmoothingMode::Lift { .. } | SmoothingMode::Conformal { .. } => false,
        };
        let more = |after: f64, before: f64| after > before * (1.0 + 1e-9) + 1e-9;
        shrinks
            && (more(gauge.total_turn(self.surface, strip), before.total_turn)
                || strip.length(self.surface) > before.length * (1.0 + 1e-9))
    }

    /// What else there is where a line became rougher: wishes that are scaled down, and at last the line given.
    fn smoother(&mut self) -> Done {
        let mut all = Done::default();
        if let (SmoothingMode::Stencil { scale, passes }, None) = (self.smoothing.mode, self.smoothing.envelope) {
            for share in [0.75, 0.5, 0.25] {
                let done = self.by(SmoothingMode::Stencil { scale: share * scale, passes }, None, None);
                all.add(Done { collapsed: false, ..done });
                if self.watch.is_stopped() || !done.collapsed && !self.is_rougher() {
                    return all;
                }
            }
        }
        self.keep_given();
        Done { kept: true, closeness: None, ..all }
    }

    fn keep_given(&mut self) {
        let SmoothWorkspace { strip, given, .. } = &mut *self.workspace;
        strip.copy_from(given);
    }

    /// Smooths within the envelope, if there is one.
    fn enveloped(&mut self) -> Done {
        let own = match self.smoothing.mode {
            SmoothingMode::Tether { closeness } => Some(closeness),
            _ => None,
        };
        match (self.smoothing.envelope, own) {
            (None, None) => self.anchored(),
            (None, Some(closeness)) => self.held(closeness),
            (Some(Envelope::Hard(far)), None) => self.clamped_within(far, None),
            (Some(Envelope::Hard(far) | Envelope::Soft(far)), _) => self.tethered_within(far, own),
        }
    }

    /// Without a tether of its own; what holds a closed line holds it closer where it would shrink to a point.
    fn anchored(&mut self) -> Done {
        let mut all = self.once(None, None);
        let holds = matches!(self.smoothing.mode, SmoothingMode::Stencil { scale, .. } if scale > 0.0);
        while all.collapsed && holds && self.anchor < CLOSENESSES[1] && !self.watch.is_stopped() {
            self.anchor *= 10.0;
            let done = self.once(None, None);
            all.add(Done { collapsed: false, ..done });
            (all.collapsed, all.met_bound) = (done.collapsed, done.met_bound);
        }
        all
    }

    /// By a tether; by a closer one where a closed line would shrink to a point.
    fn held(&mut self, closeness: f64) -> Done {
        let mut closeness = closeness;
        let mut all = self.once(Some(closeness), None);
        while all.collapsed && closeness < CLOSENESSES[1] && !self.watch.is_stopped() {
            closeness = (10.0 * closeness).clamp(1.0, CLOSENESSES[1]);
            let done = self.once(Some(closeness), None);
            all.add(Done { collapsed: false, ..done });
            (all.collapsed, all.met_bound) = (done.collapsed, done.met_bound);
        }
        all
    }

    /// With the loosest tether that keeps the line within a distance.
    fn tethered_within(&mut self, far: f64, own: Option<f64>) -> Done {
        let mut all = self.once(own, None);
        if self.watch.is_stopped() || !all.collapsed && self.is_within(far) {
            return all;
        }
        let [mut loose, mut close] = CLOSENESSES.map(f64::ln);
        loose = own.map_or(loose, |own| own.max(CLOSENESSES[0]).ln());
        let mut found = None;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (loose + close);
            let done = self.once(Some(middle.exp()), None);
            all.add(Done { collapsed: false, ..done });
            if self.watch.is_stopped() {
                return all;
            }
            if !done.collapsed && self.is_within(far) {
                (close, found) = (middle, done.closeness);
                let SmoothWorkspace { strip, kept, .. } = &mut *self.workspace;
                kept.copy_from(strip);
            } else {
                loose = middle;
            }
        }
        all.collapsed = false;
        if found.is_some() {
            let SmoothWorkspace { strip, kept, .. } = &mut *self.workspace;
            strip.copy_from(kept);
            all.closeness = found;
            return all;
        }
        all.add(self.clamped_within(far, Some(CLOSENESSES[1])));
        all
    }

    /// With crossings that stop at a distance; closer if stretches between them go beyond it.
    fn clamped_within(&mut self, far: f64, closeness: Option<f64>) -> Done {
        let mut all = Done::default();
        for share in WITHIN {
            let done = self.once(closeness, Some(share * far));
            all.add(done);
            if self.watch.is_stopped() || done.collapsed || self.is_within(far) {
                return all;
            }
        }
        // What was drawn is within any distance of itself.
        self.keep_given();
        Done { kept: true, ..all }
    }

    /// Whether the smoothed line stays within a distance of the drawn one.
    fn is_within(&mut self, far: f64) -> bool {
        let SmoothWorkspace { strip, positions, engine, .. } = &mut *self.workspace;
        strip.positions_into(self.surface, positions);
        stays_within(positions, &engine.line, far, self.mean)
    }

    /// Smooths once, from the line given, by the mode asked for.
    fn once(&mut self, tether: Option<f64>, envelope: Option<f64>) -> Done {
        self.by(self.smoothing.mode, tether, envelope)
    }

    /// Smooths once, from the line given.
    fn by(&mut self, mode: SmoothingMode, tether: Option<f64>, envelope: Option<f64>) -> Done {
        let SmoothWorkspace { finder, engine, strip, given, gauge, .. } = &mut *self.workspace;
        let (surface, smoothing, watch) = (self.surface, self.smoothing, &mut *self.watch);
        strip.copy_from(given);
        engine.metric.set_surface();
        let mut plan = Plan {
            profile: false,
            shrinks: false,
            tether,
            reach: self.reach,
            envelope,
            barrier: smoothing.barrier,
            mean: self.mean,
            max_rounds: smoothing.max_rounds,
            is_short: false,
        };
        if tether.is_some() {
            engine.judge(surface, given, self.mean, smoothing.roughness, smoothing.range.as_ref());
            engine.fix_smooth(strip);
            if let Some(range) = &smoothing.range {
                engine.fix_outside(strip, range);
            }
        }
        let mut enough = None;
        match mode {
            SmoothingMode::Geodesic | SmoothingMode::Tether { .. } => {}
            SmoothingMode::Budget { share } => enough = Some(share * gauge.total_turn(surface, given)),
            SmoothingMode::Lift { weight } => engine.metric.set(Kind::Lift, weight, self.reach, &engine.line),
            SmoothingMode::Conformal { weight } => engine.metric.set(Kind::Conformal, weight, self.reach, &engine.line),
            SmoothingMode::Stencil { scale, passes } => {
                (plan.profile, plan.shrinks) = (true, scale <= 1.0);
                engine.measure_profile(surface, given, passes, scale);
                if given.closed && scale > 0.0 && tether.is_none() && smoothing.iteration == Iteration::Solve {
                    // Turns alone say neither where a closed line is nor how large.
                    engine.hold_alike();
                    plan.tether = Some(self.anchor);
                }
            }
        }
        let order = match smoothing.iteration {
            Iteration::Sequential => Some(Order::Sequential),
            Iteration::Symmetric => Some(Order::Symmetric),
            // A budget is met on the way; that of a tethered line by its tether alone.
            Iteration::Solve => (enough.is_some() && tether.is_none()).then_some(Order::Symmetric),
        };
        let plain = tether.is_none() && envelope.is_none() && plan.barrier.is_none();
        let straight = plain && mode == SmoothingMode::Geodesic && !given.fixed.contains(&true);
        let mut done = match order {
            Some(order) => {
                let enough = enough.map(|enough| (enough, gauge));
                engine.sweep(surface, strip, &plan, order, smoothing.max_sweeps, enough, watch)
            }
            None if straight && !given.closed => self.straightened(),
            None => {
                let only_tethered = plan.tether.is_some() && !plan.profile && engine.metric.is_surface();
                plan.is_short = only_tethered && envelope.is_none() && plan.barrier.is_none();
                if plan.is_short {
                    engine.take_shortcuts(surface, finder, strip, &plan, watch);
                }
                engine.relax(surface, strip, &plan, watch)
            }
        };
        if straight && order.is_none() && self.workspace.given.closed && !done.collapsed {
            done = self.tightened(&plan, done);
        }
        // It may have shrunk to a vertex in the last steps.
        let SmoothWorkspace { engine, strip, .. } = &*self.workspace;
        done.collapsed |= strip.closed && (strip.len() < 3 || engine.is_point(surface, strip, plan.mean));
        Done { closeness: tether, ..done }
    }
}
