//! Characters whose paths are bound to their joints.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use glam::DAffine2;

use super::cache::Cached;
use super::{Character, CharacterError, JoinChange, Part};
use crate::skin::{BoundChain, BoundSkin, Chain, JoinRules, Measure, Posed, Quadrature, SkinError, WeightField};

/// A character whose paths are bound to its joints: handle `i` of the skin is joint `i`.
#[derive(Clone, Debug)]
pub struct BoundCharacter {
    /// All paths, one chain each.
    pub skin: BoundSkin,
    /// The paths in the order in which they are painted. Those of one shape come one after the other: they are filled together.
    pub paths: Vec<CharacterPath>,
    /// From the drawing to the frames of joints at rest.
    pub inverse_rest: Vec<DAffine2>,
}

/// A path of a bound character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharacterPath {
    /// The shape of the drawing.
    pub shape: usize,
    /// The path of the shape.
    pub path: usize,
    /// The chain of the skin.
    pub chain: usize,
    /// The part that the shape belongs to.
    pub part: usize,
    /// The order of its part.
    pub z: f64,
}

/// Watches binding from another thread, and can stop it.
#[derive(Debug, Default)]
pub struct BindProgress {
    permille: AtomicU32,
    cancelled: AtomicBool,
}

impl BindProgress {
    /// How far binding has come, from 0 to 1.
    pub fn fraction(&self) -> f32 {
        self.permille.load(Ordering::Relaxed) as f32 / 1000.0
    }

    /// Asks binding to stop; it ends with [`CharacterError::Cancelled`] at its next step. The weights of one part are a step.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    fn step(&self, done: usize, all: usize) -> Result<(), CharacterError> {
        let permille = done.saturating_mul(1000) / all.max(1);
        self.permille.store(permille.min(1000) as u32, Ordering::Relaxed);
        if self.cancelled.load(Ordering::Relaxed) { Err(CharacterError::Cancelled) } else { Ok(()) }
    }
}

impl BoundCharacter {
    /// What moves places of the drawing: one transform for each joint, by what leads from the frames of joints to the drawing. Takes no memory once
    /// `out` has room.
    pub fn transforms(&self, worlds: &[DAffine2], out: &mut Vec<DAffine2>) {
        out.clear();
        out.extend(worlds.iter().zip(&self.inverse_rest).map(|(world, inverse)| *world * *inverse));
    }

    /// Poses all paths by what leads from the frames of joints to the drawing.
    ///
    /// # Errors
    /// As [`BoundSkin::pose_plane`].
    pub fn pose(&self, worlds: &[DAffine2], posed: &mut Posed) -> Result<(), SkinError> {
        let mut transforms = Vec::with_capacity(worlds.len());
        self.transforms(worlds, &mut transforms);
        self.skin.pose_plane(&transforms, posed)
    }
}

/// Solving for weights takes as long as binding so many segments, for each joint.
const SOLVING: usize = 200;

/// What is to be bound: the paths of a part.
pub(super) struct Work<'a> {
    pub(super) part: &'a Part,
    number: usize,
    /// The joints that it follows, in ascending order.
    pub(super) joints: Vec<u32>,
    /// Each with its place among all.
    pub(super) chains: Vec<(CharacterPath, Chain)>,
}

impl Character {
    /// Binds all paths to the joints that they follow. With [`WeightSource::Shepard`](super::WeightSource::Shepard) that takes about a microsecond
    /// for each segment and joint; weights that are solved for may take a second, and are worth [keeping](Self::bind_cached).
    ///
    /// # Errors
    /// [`CharacterError::Fault`] as [`check`](Self::check); [`CharacterError::Weights`], [`CharacterError::FeatureOff`], [`CharacterError::Skin`],
    /// [`CharacterError::Cancelled`].
    pub fn bind(&self, progress: &BindProgress) -> Result<BoundCharacter, CharacterError> {
        Ok(self.bind_work(&self.work()?, None, progress)?.0)
    }

    /// The paths of all parts that have some.
    pub(super) fn work(&self) -> Result<Vec<Work<'_>>, CharacterError> {
        let assigned = self.assigned()?;
        let mut works: Vec<Work<'_>> = Vec::with_capacity(self.parts.len());
        for (number, part) in self.parts.iter().enumerate() {
            let mut joints: Vec<u32> = part.follows.iter().map(|joint| *joint as u32).collect();
            joints.sort_unstable();
            works.push(Work { part, number, joints, chains: Vec::new() });
        }
        let mut changes: HashMap<(usize, &str), Vec<&JoinChange>> = HashMap::new();
        for (number, part) in self.parts.iter().enumerate() {
            part.joins.iter().for_each(|join| changes.entry((number, &join.shape)).or_default().push(join));
        }
        let mut count = 0;
        for (number, (shape, part)) in self.drawing.shapes.iter().zip(assigned).enumerate() {
            let Some(work) = part.and_then(|part| works.get_mut(part)) else { continue };
            let own = shape.id.as_deref().and_then(|id| changes.get(&(work.number, id)));
            let first = work.chains.len();
            for (path, of_path) in shape.paths.iter().enumerate() {
                let (part, z) = (work.number, work.part.z);
                let place = CharacterPath { shape: number, path, chain: count, part, z };
                work.chains.push((place, Chain::planar(of_path, &JoinRules::default())));
                count += 1;
            }
            for join in own.into_iter().flatten() {
                if let Some((_, chain)) = work.chains.get_mut(first.saturating_add(join.path)) {
                    // Joins were checked.
                    let _ = chain.set_join(join.anchor, join.kind);
                }
            }
        }
        works.retain(|work| !work.chains.is_empty());
        Ok(works)
    }

    /// Binds paths, with weights of a cache where it has them; gives the weights that had to be solved for.
    pub(super) fn bind_work(
        &self,
        works: &[Work<'_>],
        cached: Option<&Cached>,
        progress: &BindProgress,
    ) -> Result<(BoundCharacter, Vec<f64>), CharacterError> {
        let count = works.iter().map(|work| work.chains.len()).sum();
        let mut bound: Vec<Option<BoundChain>> = vec![None; count];
        let (mut paths, mut solved) = (Vec::with_capacity(count), Vec::new());
        let all: usize = works.iter().map(|work| self.cost(work, cached)).sum();
        let (mut done, mut from) = (0, 0);
        for work in works {
            progress.step(done, all)?;
            let is_solved = self.is_solved(work.part);
            let weights = match cached.filter(|_| is_solved) {
                Some(cached) => Source::Cached(cached, &mut from),
                None => {
                    let chains: Vec<&Chain> = work.chains.iter().map(|(_, chain)| chain).collect();
                    Source::Field(Box::new(self.field_of(work.part, &work.joints, &chains)?))
                }
            };
            self.bind_chains(work, weights, is_solved.then_some(&mut solved), &mut bound, &mut paths, progress)?;
            done += self.cost(work, cached);
        }
        progress.step(all, all)?;
        let chains: Vec<BoundChain> = bound.into_iter().flatten().collect();
        let skin =
            BoundSkin::of_bound(chains, self.joints.len()).map_err(|source| {
                let (SkinError::Singular { chain }
                | SkinError::TooLarge { chain }
                | SkinError::OtherHandles { chain, .. }) = source
                else {
                    return self.skin_error(None, source);
                };
                self.skin_error(paths.iter().find(|path: &&CharacterPath| path.chain == chain), source)
            })?;
        paths.sort_by(|a, b| a.z.total_cmp(&b.z).then(a.chain.cmp(&b.chain)));
        let inverse_rest = self.joints.iter().map(|joint| joint.rest_world().inverse()).collect();
        Ok((BoundCharacter { skin, paths, inverse_rest }, solved))
    }

    fn bind_chains(
        &self,
        work: &Work<'_>,
        mut weights: Source<'_>,
        mut keep: Option<&mut Vec<f64>>,
        bound: &mut [Option<BoundChain>],
        paths: &mut Vec<CharacterPath>,
        progress: &BindProgress,
    ) -> Result<(), CharacterError> {
        let handles = work.joints.len();
        for (path, chain) in &work.chains {
            if progress.cancelled.load(Ordering::Relaxed) {
                return Err(CharacterError::Cancelled);
            }
            let sampled;
            let (rule, samples) = match &mut weights {
                Source::Field(field) => {
                    let rule = field.quadrature().rule();
                    sampled = BoundChain::sample(chain, path.chain, &**field, &rule)
                        .map_err(|source| self.skin_error(Some(path), source))?;
                    if let Some(keep) = &mut keep {
                        keep.extend_from_slice(&sampled);
                    }
                    (rule, &sampled[..])
                }
                Source::Cached(cached, from) => {
                    let rule = Quadrature::PIECEWISE.rule();
                    let range = sample_range(**from, chain, handles);
                    **from = range.end;
                    (rule, cached.values.get(range).unwrap_or_default())
                }
            };
            let one = BoundChain::of_samples(chain, handles, &rule, samples, Measure::default());
            if let Some(place) = bound.get_mut(path.chain) {
                *place = Some(one.among(&work.joints, self.joints.len()));
            }
            paths.push(*path);
        }
        Ok(())
    }

    /// How long binding a part takes, in segments times joints.
    fn cost(&self, work: &Work<'_>, cached: Option<&Cached>) -> usize {
        let segments: usize = work.chains.iter().map(|(_, chain)| chain.segment_count()).sum();
        let solving = if cached.is_none() && self.is_solved(work.part) { SOLVING } else { 0 };
        (segments + solving) * work.joints.len()
    }

    fn skin_error(&self, path: Option<&CharacterPath>, source: SkinError) -> CharacterError {
        let shape = path.and_then(|path| self.drawing.shapes.get(path.shape));
        let shape = shape.map(|shape| shape.id.clone().unwrap_or_else(|| shape.element.clone()));
        let part = path.and_then(|path| self.parts.get(path.part)).map(|part| part.name.clone());
        CharacterError::Skin {
            part: part.unwrap_or_default(),
            shape: shape.unwrap_or_default(),
            path: path.map_or(0, |path| path.path),
            source,
        }
    }
}

/// Where weights at the nodes of chains come from.
enum Source<'a> {
    Field(Box<super::weights::PartField>),
    /// With the place of the next ones.
    Cached(&'a Cached, &'a mut usize),
}

/// Places of a chain's weights in a cache.
pub(super) fn sample_range(from: usize, chain: &Chain, handles: usize) -> Range<usize> {
    let Quadrature { nodes, pieces } = Quadrature::PIECEWISE;
    from..from + chain.segment_count() * (nodes * pieces) as usize * handles
}
