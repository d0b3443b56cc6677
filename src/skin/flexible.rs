//! Poses in which the ratios of handle lengths are free.
//!
//! The energy is not quadratic then. Two systems that are, take turns: lengths and anchors with directions held, and all with ratios held.
//! Each starts from what the other leaves, so the energy falls, but for handles that are held at their shortest. The best state is kept.

use glam::{DAffine3, DVec3};

use super::bound::read;
use super::system::Link;
use super::{BoundChain, SkinError, SolveWorkspace};

/// When to stop, and how short handles may become.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct FlexibleOptions {
    /// Pairs of solves at most, a thousand whatever is asked for; five or six are usual.
    pub pairs: u32,
    /// It is done when no control point moves by more than this share of the chain's extent,
    pub moved: f64,
    /// or a pair takes less than this share of the energy away.
    pub gained: f64,
    /// Handles are kept longer than this share of their rest length, unless the skinned curve itself has them shorter.
    pub shortest: f64,
}

impl Default for FlexibleOptions {
    fn default() -> Self {
        Self { pairs: 20, moved: 1e-5, gained: 1e-6, shortest: 2e-3 }
    }
}

/// What a flexible solve came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct FlexibleOutcome {
    /// Pairs of solves that were made.
    pub pairs: u32,
    /// Whether it stopped because hardly anything changed.
    pub settled: bool,
    /// Energy of the regular pose above the least that loose segments have, in units of length cubed.
    pub regular: f64,
    /// The same of the flexible pose, which is never more.
    pub flexible: f64,
}

/// Pairs of solves that nothing asks for more of.
const MOST_PAIRS: u32 = 1000;
/// How often magnitudes are held or released in a solve.
const ROUNDS: u32 = 6;

impl BoundChain {
    /// Solves with free ratios of handle lengths where joins allow it; otherwise like [`solve`](Self::solve).
    ///
    /// # Errors
    /// [`SkinError::PoseLength`], [`SkinError::PoseNotFinite`], [`SkinError::Singular`] if 64 bits are not enough for the regular pose.
    pub fn solve_flexible(
        &self,
        transforms: &[DAffine3],
        options: &FlexibleOptions,
        workspace: &mut SolveWorkspace,
        out: &mut Vec<DVec3>,
    ) -> Result<FlexibleOutcome, SkinError> {
        self.check(transforms)?;
        workspace.turns.clear();
        let outcome = self.flex(transforms, options, workspace)?;
        self.write(&workspace.best, out);
        Ok(outcome)
    }

    /// Whether a ratio is free.
    pub(crate) fn is_flexible(&self) -> bool {
        self.ties.iter().flatten().any(|tie| tie.flexible)
    }

    /// Solves into the workspace's best points.
    pub(crate) fn flex(
        &self,
        transforms: &[DAffine3],
        options: &FlexibleOptions,
        workspace: &mut SolveWorkspace,
    ) -> Result<FlexibleOutcome, SkinError> {
        self.solve_regular(transforms, workspace)?;
        let mut loose = std::mem::take(&mut workspace.loose);
        self.loose(transforms, &mut loose);
        let outcome = if self.is_flexible() {
            self.sides(transforms, &mut workspace.sides);
            Alternation::new(self, workspace, &loose, options).run(options)
        } else {
            workspace.best.clone_from(&workspace.points);
            let energy = self.excess(&workspace.points, &loose);
            FlexibleOutcome { settled: true, regular: energy, flexible: energy, ..Default::default() }
        };
        workspace.loose = loose;
        Ok(outcome)
    }
}

/// A flexible join during the alternation.
#[derive(Clone, Copy, Debug)]
struct Bend {
    /// Directions of the handles.
    incoming: DVec3,
    outgoing: DVec3,
    /// Shortest lengths.
    floors: [f64; 2],
    /// Which lengths are held there.
    held: [bool; 2],
    /// Length of the outgoing handle over that of the incoming one.
    ratio: f64,
}

struct Alternation<'a> {
    bound: &'a BoundChain,
    workspace: &'a mut SolveWorkspace,
    loose: &'a [[DVec3; 4]],
    bends: Vec<Option<Bend>>,
}

impl<'a> Alternation<'a> {
    fn new(
        bound: &'a BoundChain,
        workspace: &'a mut SolveWorkspace,
        loose: &'a [[DVec3; 4]],
        options: &FlexibleOptions,
    ) -> Self {
        let segments = bound.chain.segment_count();
        let bend = |anchor: usize| {
            bound.ties[anchor].filter(|tie| tie.flexible)?;
            let [incoming, outgoing] = bound.chain.handles(anchor)?;
            let before = loose.get(if anchor > 0 { anchor - 1 } else { segments - 1 })?;
            let behind = loose.get(anchor)?;
            let floor = |rest: f64, wished: f64| (options.shortest * rest).min(wished).max(1e-9 * rest);
            let floors = [
                floor(incoming.length(), before[2].distance(before[3])),
                floor(outgoing.length(), behind[1].distance(behind[0])),
            ];
            let ratio = outgoing.length() / incoming.length();
            Some(Bend { incoming, outgoing, floors, held: [false; 2], ratio })
        };
        let bends = (0..bound.ties.len()).map(bend).collect();
        Self { bound, workspace, loose, bends }
    }

    fn run(mut self, options: &FlexibleOptions) -> FlexibleOutcome {
        let bound = self.bound;
        let extent = bound.chain.extent();
        let regular = bound.excess(&self.workspace.points, self.loose);
        // What rounding leaves of the energy.
        let nothing = 1e-22 * bound.lengths.iter().sum::<f64>() * extent * extent;
        self.workspace.best.clone_from(&self.workspace.points);
        let mut outcome = FlexibleOutcome { regular, flexible: regular, ..Default::default() };
        let mut last = regular;
        while outcome.pairs < options.pairs.min(MOST_PAIRS) && !outcome.settled {
            if last <= nothing {
                outcome.settled = true;
                break;
            }
            outcome.pairs += 1;
            self.aim();
            if !self.solve_lengths() {
                break;
            }
            let even = bound.excess(&self.workspace.even, self.loose);
            if even < outcome.flexible && !self.is_short(&self.workspace.even) {
                outcome.flexible = even;
                self.workspace.best.clone_from(&self.workspace.even);
            }
            self.measure();
            if !self.solve_directions() {
                break;
            }
            let odd = bound.excess(&self.workspace.odd, self.loose);
            if odd < outcome.flexible && !self.is_short(&self.workspace.odd) {
                outcome.flexible = odd;
                self.workspace.best.clone_from(&self.workspace.odd);
            }
            let moves = self.workspace.odd.iter().zip(&self.workspace.points).map(|(a, b)| (a - b).abs());
            let moved = moves.fold(0.0, f64::max);
            outcome.settled = moved < options.moved * extent || (last - odd).abs() < options.gained * odd;
            last = odd;
            std::mem::swap(&mut self.workspace.points, &mut self.workspace.odd);
        }
        outcome
    }

    /// The vectors from an anchor to its handles.
    fn handles(&self, points: &[f64], anchor: usize) -> [DVec3; 2] {
        let (d, n) = (self.bound.dimension(), self.bound.chain.points().len());
        let at = 3 * anchor;
        let place = read(points, at, d);
        [if at > 0 { at - 1 } else { n - 1 }, at + 1].map(|handle| read(points, handle, d) - place)
    }

    /// Takes directions from both handles of each join, by their lengths.
    fn aim(&mut self) {
        for anchor in 0..self.bends.len() {
            let Some(mut bend) = self.bends[anchor] else { continue };
            let turn = self.bound.posed_turn(anchor, &self.workspace.turns);
            let [p, q] = self.handles(&self.workspace.points, anchor);
            let sum = p + turn.transpose() * q;
            // A handle without length keeps the direction that it had, at first that at rest.
            if let Some(direction) = sum.try_normalize() {
                bend.incoming = direction;
            } else {
                bend.incoming = bend.incoming.normalize_or_zero();
            }
            bend.outgoing = turn * bend.incoming;
            self.bends[anchor] = Some(bend);
        }
    }

    /// Takes ratios from the state with free lengths.
    fn measure(&mut self) {
        for anchor in 0..self.bends.len() {
            let Some(mut bend) = self.bends[anchor] else { continue };
            let [p, q] = self.handles(&self.workspace.even, anchor);
            let ratio = q.length() / p.length();
            if ratio > 0.0 && ratio.is_finite() {
                bend.ratio = ratio;
            }
            self.bends[anchor] = Some(bend);
        }
    }

    /// Solves for anchors and lengths with directions held; those that would become too short are held at their shortest, and released where
    /// the energy pulls them out again.
    fn solve_lengths(&mut self) -> bool {
        for round in 0..ROUNDS {
            let Self { bound, workspace, bends, .. } = self;
            let coupled = bound.dimension();
            let turns = &workspace.turns;
            let link = |anchor: usize| match &bends[anchor] {
                Some(bend) => {
                    let held = [0, 1].map(|side| bend.held[side].then_some(bend.floors[side]));
                    Link::Along { incoming: bend.incoming, outgoing: bend.outgoing, held }
                }
                None => bound.posed_link(anchor, turns),
            };
            if workspace.system.build(&bound.chain, &bound.grams, coupled, link).is_err() {
                return false;
            }
            workspace.even.clone_from(&workspace.sides);
            workspace.system.solve(&bound.chain, &bound.grams, &mut workspace.even, 1, Some(0));
            if !self.revise(round + 2 < ROUNDS) {
                break;
            }
        }
        true
    }

    /// Holds lengths that are too short, or releases some; whether that changes anything.
    fn revise(&mut self, may_release: bool) -> bool {
        let mut holds = false;
        for anchor in 0..self.bends.len() {
            let Some(mut bend) = self.bends[anchor] else { continue };
            let [p, q] = self.handles(&self.workspace.even, anchor);
            for (side, length) in [p.dot(bend.incoming), q.dot(bend.outgoing)].into_iter().enumerate() {
                if !bend.held[side] && length < bend.floors[side] {
                    bend.held[side] = true;
                    holds = true;
                }
            }
            self.bends[anchor] = Some(bend);
        }
        if holds || !may_release {
            return holds;
        }
        let mut releases = false;
        for anchor in 0..self.bends.len() {
            let Some(mut bend) = self.bends[anchor] else { continue };
            if bend.held == [false; 2] {
                continue;
            }
            let segments = self.bound.chain.segment_count();
            let before = if anchor > 0 { anchor - 1 } else { segments - 1 };
            let pulls = [self.slope(before, 2).dot(bend.incoming), self.slope(anchor, 1).dot(bend.outgoing)];
            let least = 1e-12 * self.bound.chain.extent();
            for (held, pull) in bend.held.iter_mut().zip(pulls) {
                if *held && pull < -least {
                    *held = false;
                    releases = true;
                }
            }
            self.bends[anchor] = Some(bend);
        }
        releases
    }

    /// How the energy changes with a control point of a segment.
    fn slope(&self, segment: usize, k: usize) -> DVec3 {
        let (bound, d) = (self.bound, self.bound.dimension());
        let places = bound.chain.places(segment);
        let off = |l: usize| read(&self.workspace.even, places[l], d) - self.loose[segment][l];
        let gram = &bound.grams[segment][k];
        let sum = gram.iter().enumerate().map(|(l, g)| off(l) * *g).sum::<DVec3>();
        sum / bound.lengths[segment]
    }

    /// Solves with ratios held.
    fn solve_directions(&mut self) -> bool {
        let Self { bound, workspace, bends, .. } = self;
        let coupled = bound.coupled();
        let turns = &workspace.turns;
        let link = |anchor: usize| match &bends[anchor] {
            Some(bend) => Link::Tied(bound.posed_turn(anchor, turns) * bend.ratio),
            None => bound.posed_link(anchor, turns),
        };
        if workspace.system.build(&bound.chain, &bound.grams, coupled, link).is_err() {
            return false;
        }
        workspace.odd.clone_from(&workspace.sides);
        let columns = bound.dimension() / coupled;
        workspace.system.solve(&bound.chain, &bound.grams, &mut workspace.odd, columns, Some(0));
        true
    }

    /// Whether a solve left a handle shorter than its floor, or turned it round while the other stayed.
    fn is_short(&self, points: &[f64]) -> bool {
        self.bends.iter().enumerate().any(|(anchor, bend)| {
            bend.is_some_and(|bend| {
                let [p, q] = self.handles(points, anchor);
                let turned_round = (p.dot(bend.incoming) < 0.0) != (q.dot(bend.outgoing) < 0.0);
                turned_round || p.length() < 0.999 * bend.floors[0] || q.length() < 0.999 * bend.floors[1]
            })
        })
    }
}
