//! Smoothing a line.

use super::{
    Envelope, Iteration, LineMetrics, SmoothError, Smoothing, SmoothingMode, SurfacePolyline,
    engine::{Done, Engine, Plan, somewhere},
    metric::Kind,
    metrics::{Gauge, stays_within},
    plain::Order,
    strip::{AT_VERTEX, Strip, share_on, turn_into},
    tree::LineTree,
};
use crate::geodesic::{PathFinder, inner::InnerPath};
use crate::surface::{HalfEdge, InnerPoint, Surface};

/// Mean edges in the default reach.
const REACH: f64 = 10.0;
/// Closeness of the tether that holds closed lines of which only the turns are wished.
const ANCHOR: f64 = 0.3;
/// Bisections of an envelope's tether, from closeness to closeness.
const BISECTIONS: u32 = 8;
const CLOSENESSES: [f64; 2] = [1e-3, 1e6];
/// Shares of a hard envelope that crossings are kept within, one after the other, until no stretch leaves it.
const WITHIN: [f64; 4] = [0.999, 0.95, 0.8, 0.5];
/// How often a closed line is straightened across its seam.
const SEAMS: usize = 8;
/// What counts as shorter.
const SHORTER: f64 = 1.0 - 1e-11;

/// Scratch memory for smoothing; keep one a thread and reuse it, for any surface.
#[derive(Debug, Default)]
pub struct SmoothWorkspace {
    /// The path finder inside, free for queries of one's own.
    pub finder: PathFinder,
    engine: Engine,
    gauge: Gauge,
    strip: Strip,
    given: Strip,
    kept: Strip,
    positions: Vec<glam::DVec3>,
    path: InnerPath,
    around: Vec<HalfEdge>,
    tree: LineTree,
}

#[cfg(test)]
impl SmoothWorkspace {
    /// Lets watchers see every step of every solve.
    pub(crate) fn watch_steps(&mut self) {
        self.engine.watched = true;
    }
}

/// A smoothed line.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// The line; open or closed as it was.
    pub line: SurfacePolyline,
    /// Of the line given.
    pub before: LineMetrics,
    /// Of the line made, its distances from the line given.
    pub after: LineMetrics,
    /// How often vertices were passed, all that pressed at once.
    pub rounds: u32,
    /// Newton steps, or sweeps.
    pub steps: u32,
    /// How many vertices were passed.
    pub flips: u32,
    /// Whether a bound on rounds or sweeps was met first; the line is valid all the same.
    pub met_bound: bool,
}

impl Smoothed {
    /// Something to be overwritten by [`smooth_into`].
    pub fn blank() -> Self {
        Self {
            line: SurfacePolyline::blank(),
            before: LineMetrics::default(),
            after: LineMetrics::default(),
            rounds: 0,
            steps: 0,
            flips: 0,
            met_bound: false,
        }
    }
}

/// Smooths a line.
///
/// The result depends on surface, line and options alone. Fixed crossings and ends stay; the line stays on its side of what it cannot
/// pass (handles, holes), and of vertices where going round would be longer.
///
/// Cost: about 3 µs a crossing by the default.
///
/// # Errors
/// [`SmoothError`] if the line belongs to another surface, an option makes no sense, or a closed line shrinks to a point.
pub fn smooth(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &SurfacePolyline,
    smoothing: &Smoothing,
) -> Result<Smoothed, SmoothError> {
    let mut out = Smoothed::blank();
    smooth_into(surface, workspace, line, smoothing, &mut out)?;
    Ok(out)
}

/// [`smooth`] into memory that is reused: once warm, nothing is allocated.
///
/// # Errors
/// As [`smooth`]; `out` is then as it was.
pub fn smooth_into(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &SurfacePolyline,
    smoothing: &Smoothing,
    out: &mut Smoothed,
) -> Result<(), SmoothError> {
    let done = smooth_watched(surface, workspace, line, smoothing, &mut |_| {})?;
    let mean = mean_edge(surface, &workspace.strip);
    let SmoothWorkspace { gauge, strip, given, engine, .. } = workspace;
    out.before = gauge.measure(surface, given, None, mean);
    out.after = gauge.measure(surface, strip, Some(&engine.line), mean);
    out.line.set(surface, strip);
    (out.rounds, out.steps, out.flips, out.met_bound) = (done.rounds, done.steps, done.flips, done.met_bound);
    Ok(())
}

/// Measures a line, and how far it runs from another, if one is given.
///
/// # Errors
/// [`SmoothError`] if a line does not belong to the surface.
pub fn measure(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &SurfacePolyline,
    from: Option<&SurfacePolyline>,
) -> Result<LineMetrics, SmoothError> {
    let SmoothWorkspace { gauge, strip, positions, tree, .. } = workspace;
    if let Some(from) = from {
        from.strip_into(surface, strip)?;
        strip.positions_into(surface, positions);
        tree.build(positions);
    }
    line.strip_into(surface, strip)?;
    let mean = mean_edge(surface, strip);
    Ok(gauge.measure(surface, strip, from.map(|_| &*tree), mean))
}

fn mean_edge(surface: &Surface, strip: &Strip) -> f64 {
    let face = strip.sides.first().map_or(strip.start.face, |h| h.face());
    surface.mean_edge[surface.sheet[face as usize] as usize].max(f64::MIN_POSITIVE)
}

/// Smooths a line into the workspace's strip; `watch` sees every line on the way.
pub(crate) fn smooth_watched(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &SurfacePolyline,
    smoothing: &Smoothing,
    watch: &mut dyn FnMut(&Strip),
) -> Result<Done, SmoothError> {
    smoothing.check()?;
    line.strip_into(surface, &mut workspace.given)?;
    let SmoothWorkspace { given, positions, engine, .. } = workspace;
    given.positions_into(surface, positions);
    engine.line.build(positions);
    let mut run = Smoother { mean: mean_edge(surface, given), surface, smoothing, workspace, reach: 0.0 };
    run.reach = smoothing.reach.unwrap_or(REACH * run.mean);
    let mut done = run.enveloped(watch)?;
    run.unfix();
    let _ = run.workspace.strip.seam_off_vertices(at_vertex);
    if !done.collapsed && run.is_rougher() {
        done.add(run.smoother(watch)?);
    }
    if done.collapsed {
        let at = surface.outer_point(&somewhere(&workspace.strip));
        return Err(SmoothError::Collapsed { at });
    }
    Ok(done)
}

/// Whether a crossing is at a vertex.
fn at_vertex(strip: &Strip, i: usize) -> bool {
    strip.at[i] <= AT_VERTEX || strip.at[i] >= 1.0 - AT_VERTEX
}

/// One smoothing under way.
struct Smoother<'a> {
    surface: &'a Surface,
    smoothing: &'a Smoothing,
    workspace: &'a mut SmoothWorkspace,
    mean: f64,
    reach: f64,
}

impl Smoother<'_> {
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
        let SmoothWorkspace { gauge, strip, given, .. } = &mut *self.workspace;
        let shrinks = match self.smoothing.mode {
            SmoothingMode::Geodesic | SmoothingMode::Budget { .. } | SmoothingMode::Tether { .. } => true,
            SmoothingMode::Stencil { scale, .. } => scale <= 1.0,
            SmoothingMode::Lift { .. } | SmoothingMode::Conformal { .. } => false,
        };
        let more = |after: f64, before: f64| after > before * (1.0 + 1e-9) + 1e-9;
        shrinks
            && (more(gauge.total_turn(self.surface, strip), gauge.total_turn(self.surface, given))
                || strip.length(self.surface) > given.length(self.surface) * (1.0 + 1e-9))
    }

    /// What else there is where a line became rougher: wishes that are scaled down, and at last the line given.
    fn smoother(&mut self, watch: &mut dyn FnMut(&Strip)) -> Result<Done, SmoothError> {
        let mut all = Done::default();
        if let (SmoothingMode::Stencil { scale, passes }, None) = (self.smoothing.mode, self.smoothing.envelope) {
            for share in [0.75, 0.5, 0.25] {
                let smoothing =
                    Smoothing { mode: SmoothingMode::Stencil { scale: share * scale, passes }, ..*self.smoothing };
                let Smoother { surface, mean, reach, .. } = *self;
                let mut run = Smoother { surface, smoothing: &smoothing, workspace: self.workspace, mean, reach };
                let done = run.once(None, None, watch)?;
                all.add(Done { collapsed: false, ..done });
                if !done.collapsed && !run.is_rougher() {
                    return Ok(all);
                }
            }
        }
        let SmoothWorkspace { strip, given, .. } = &mut *self.workspace;
        strip.copy_from(given);
        Ok(all)
    }

    /// Smooths within the envelope, if there is one.
    fn enveloped(&mut self, watch: &mut dyn FnMut(&Strip)) -> Result<Done, SmoothError> {
        let own = match self.smoothing.mode {
            SmoothingMode::Tether { closeness } => Some(closeness),
            _ => None,
        };
        match self.smoothing.envelope {
            None => self.once(own, None, watch),
            Some(Envelope::Soft(far)) => self.tethered_within(far, own, watch),
            Some(Envelope::Hard(far)) => {
                if own.is_some() {
                    return self.tethered_within(far, own, watch);
                }
                self.clamped_within(far, own, watch)
            }
        }
    }

    /// With the loosest tether that keeps the line within a distance.
    fn tethered_within(
        &mut self,
        far: f64,
        own: Option<f64>,
        watch: &mut dyn FnMut(&Strip),
    ) -> Result<Done, SmoothError> {
        let mut all = self.once(own, None, watch)?;
        if !all.collapsed && self.is_within(far) {
            return Ok(all);
        }
        let [mut loose, mut close] = CLOSENESSES.map(f64::ln);
        loose = own.map_or(loose, |own| own.max(CLOSENESSES[0]).ln());
        let mut found = false;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (loose + close);
            let done = self.once(Some(middle.exp()), None, watch)?;
            all.add(Done { collapsed: false, ..done });
            if !done.collapsed && self.is_within(far) {
                close = middle;
                let SmoothWorkspace { strip, kept, .. } = &mut *self.workspace;
                kept.copy_from(strip);
                found = true;
            } else {
                loose = middle;
            }
        }
        all.collapsed = false;
        if found {
            let SmoothWorkspace { strip, kept, .. } = &mut *self.workspace;
            strip.copy_from(kept);
            return Ok(all);
        }
        all.add(self.clamped_within(far, Some(CLOSENESSES[1]), watch)?);
        Ok(all)
    }

    /// With crossings that stop at a distance; closer if stretches between them go beyond it.
    fn clamped_within(
        &mut self,
        far: f64,
        closeness: Option<f64>,
        watch: &mut dyn FnMut(&Strip),
    ) -> Result<Done, SmoothError> {
        let mut all = Done::default();
        for share in WITHIN {
            let done = self.once(closeness, Some(share * far), watch)?;
            all.add(done);
            if done.collapsed || self.is_within(far) {
                return Ok(all);
            }
        }
        // What was drawn is within any distance of itself.
        let SmoothWorkspace { strip, given, .. } = &mut *self.workspace;
        strip.copy_from(given);
        Ok(all)
    }

    /// Whether the smoothed line stays within a distance of the drawn one.
    fn is_within(&mut self, far: f64) -> bool {
        let SmoothWorkspace { strip, positions, engine, .. } = &mut *self.workspace;
        strip.positions_into(self.surface, positions);
        stays_within(positions, &engine.line, far, self.mean)
    }

    /// Smooths once, from the line given.
    fn once(
        &mut self,
        tether: Option<f64>,
        envelope: Option<f64>,
        watch: &mut dyn FnMut(&Strip),
    ) -> Result<Done, SmoothError> {
        let SmoothWorkspace { engine, strip, given, gauge, .. } = &mut *self.workspace;
        let (surface, smoothing) = (self.surface, self.smoothing);
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
        };
        let order = match smoothing.iteration {
            Iteration::Solve => None,
            Iteration::Symmetric => Some(Order::Symmetric),
            Iteration::Sequential => Some(Order::Sequential),
        };
        if tether.is_some() {
            engine.measure_roughness(surface, given, smoothing.roughness);
            engine.fix_smooth(strip);
        }
        match smoothing.mode {
            SmoothingMode::Geodesic => {
                let plain = tether.is_none() && envelope.is_none() && plan.barrier.is_none();
                let free = plain && !given.fixed.contains(&true);
                match order {
                    Some(order) => {
                        return Ok(engine.sweep(surface, strip, &plan, order, smoothing.max_sweeps, None, watch));
                    }
                    None if free && !given.closed => return Ok(self.straightened(watch)),
                    None => {}
                }
                let done = engine.relax(surface, strip, &plan, watch);
                if free && !done.collapsed {
                    return self.tightened(&plan, done, watch);
                }
                Ok(done)
            }
            SmoothingMode::Stencil { scale, passes } => {
                (plan.profile, plan.shrinks) = (true, scale <= 1.0);
                engine.measure_profile(surface, given, passes, scale);
                if given.closed && scale > 0.0 && tether.is_none() && order.is_none() {
                    // Turns alone say neither where a closed line is nor how large.
                    engine.hold_alike();
                    plan.tether = Some(ANCHOR);
                }
                Ok(match order {
                    Some(order) => engine.sweep(surface, strip, &plan, order, smoothing.max_sweeps, None, watch),
                    None => engine.relax(surface, strip, &plan, watch),
                })
            }
            SmoothingMode::Budget { share } => {
                let enough = share * gauge.total_turn(surface, given);
                let order = order.unwrap_or(Order::Symmetric);
                if tether.is_some() {
                    // A budget of a tethered line is met by its tether alone.
                    return Ok(engine.relax(surface, strip, &plan, watch));
                }
                let enough = Some((enough, gauge));
                Ok(engine.sweep(surface, strip, &plan, order, smoothing.max_sweeps, enough, watch))
            }
            SmoothingMode::Tether { .. } => Ok(engine.relax(surface, strip, &plan, watch)),
            SmoothingMode::Lift { weight } => {
                engine.metric.set(Kind::Lift, weight, self.reach, &engine.line);
                Ok(engine.relax(surface, strip, &plan, watch))
            }
            SmoothingMode::Conformal { weight } => {
                engine.metric.set(Kind::Conformal, weight, self.reach, &engine.line);
                Ok(engine.relax(surface, strip, &plan, watch))
            }
        }
    }

    /// An open line, straightened as paths are.
    fn straightened(&mut self, watch: &mut dyn FnMut(&Strip)) -> Done {
        let SmoothWorkspace { finder, strip, path, .. } = &mut *self.workspace;
        finder.continue_inner(self.surface, &strip.start, &strip.end, &mut strip.sides, path);
        let met_bound = path.frozen;
        set_path(self.surface, strip, path);
        watch(strip);
        Done { rounds: 1, met_bound, ..Done::default() }
    }

    /// Straightens a closed line as an open one that begins and ends at a crossing, again and again, until that makes it no
    /// shorter.
    fn tightened(&mut self, plan: &Plan, mut done: Done, watch: &mut dyn FnMut(&Strip)) -> Result<Done, SmoothError> {
        for _ in 0..SEAMS {
            let SmoothWorkspace { finder, strip, path, kept, around, engine, .. } = &mut *self.workspace;
            let surface = self.surface;
            kept.copy_from(strip);
            let length = strip.length(surface);
            let cut = (0..strip.len()).max_by(|a, b| {
                let room = |i: usize| strip.at[i].min(1.0 - strip.at[i]) * surface.length(strip.sides[i]);
                room(*a).total_cmp(&room(*b))
            });
            let Some(cut) = cut else { return Ok(done) };
            strip.rotate(cut);
            let (h, at) = (strip.sides[0], strip.at[0]);
            let (start, end) = (InnerPoint::on_side(surface.twin(h), 1.0 - at), InnerPoint::on_side(h, at));
            finder.continue_inner(surface, &start, &end, &mut strip.sides[1..], path);
            strip.clear();
            around.clear();
            for (h, at) in path.strip.iter().zip(&path.at) {
                strip.push(surface, *h, *at, 0.0, false);
            }
            let joins = turn_into(surface, &path.end, path.start.face, around);
            for h in around.iter() {
                strip.push(surface, *h, share_on(surface, &path.end, *h), 0.0, false);
            }
            strip.close_seam(surface);
            if !joins || strip.len() < 3 {
                strip.copy_from(kept);
                return Ok(done);
            }
            strip.measure(surface);
            if strip.length(surface) >= length * SHORTER {
                strip.copy_from(kept);
                return Ok(done);
            }
            watch(strip);
            let more = engine.relax(surface, strip, plan, watch);
            done.add(more);
            if more.collapsed {
                return Ok(done);
            }
            if strip.length(surface) > length {
                strip.copy_from(kept);
                return Ok(done);
            }
        }
        Ok(done)
    }
}

/// A path as a strip.
fn set_path(surface: &Surface, strip: &mut Strip, path: &InnerPath) {
    (strip.start, strip.end) = (path.start, path.end);
    strip.sides.clone_from(&path.strip);
    strip.at.clone_from(&path.at);
    strip.fixed.clear();
    strip.fixed.resize(path.strip.len(), false);
    strip.measure(surface);
}
