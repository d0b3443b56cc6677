//! Weights that were solved for, kept beside the character's file.
//!
//! A cache holds the weights at all nodes that binding asks for, and a fingerprint of all that they depend on. One that is damaged, or of another
//! state of the character, is as good as none: weights are solved for anew.

use std::path::{Path, PathBuf};

use super::bind::{Work, sample_range};
use super::{BindProgress, BoundCharacter, Character, CharacterError, WeightSource};
use crate::format::regular::read_file;
use crate::format::save::{SaveError, replace_file};
use crate::skin::HandleShape;
use crate::surface::fingerprint::Words;

/// The first bytes of a cache; the last of them is raised when weights come out otherwise.
const MAGIC: [u8; 8] = *b"weights\x01";
/// Larger files are no caches.
const MOST_BYTES: u64 = 128 << 20;

/// Weights of a cache that fit the character.
pub(super) struct Cached {
    pub(super) values: Vec<f64>,
}

/// What became of a cache.
#[derive(Debug)]
pub enum CacheUse {
    /// There are no weights that would have to be solved for.
    Unneeded,
    /// The weights are those of the cache.
    Used,
    /// There was none, or it was damaged or of another state of the character: weights were solved for, and saved.
    Rebuilt,
    /// The same, but they could not be saved.
    NotSaved(SaveError),
}

impl Character {
    /// Where the cache of a character's file lies: `hero.character.weights` beside `hero.character.ron`.
    pub fn cache_path(path: impl AsRef<Path>) -> PathBuf {
        path.as_ref().with_extension("weights")
    }

    /// [`bind`](Self::bind) with the weights of a cache, if the file has those of this very character; else they are solved for, and the file is
    /// replaced. The result is the same to the bit. A cache also serves programs that are built without the feature `weights`.
    ///
    /// # Errors
    /// As [`bind`](Self::bind).
    pub fn bind_cached(
        &self,
        cache: impl AsRef<Path>,
        progress: &BindProgress,
    ) -> Result<(BoundCharacter, CacheUse), CharacterError> {
        let works = self.work()?;
        if !self.is_cachable(&works) {
            return Ok((self.bind_work(&works, None, progress)?.0, CacheUse::Unneeded));
        }
        let bytes = read_file(cache.as_ref(), MOST_BYTES).unwrap_or_default();
        let (bound, new) = self.bind_with(&bytes, progress)?;
        let Some(new) = new else { return Ok((bound, CacheUse::Used)) };
        let saved = replace_file(cache, |file| file.write_all(&new));
        Ok((bound, saved.map_or_else(CacheUse::NotSaved, |()| CacheUse::Rebuilt)))
    }

    /// [`bind_cached`](Self::bind_cached) for those who keep bytes themselves: `cache` may be empty. Gives the bytes of a new cache if there are
    /// weights to keep and the old one did not do.
    ///
    /// # Errors
    /// As [`bind`](Self::bind).
    pub fn bind_with(
        &self,
        cache: &[u8],
        progress: &BindProgress,
    ) -> Result<(BoundCharacter, Option<Vec<u8>>), CharacterError> {
        let works = self.work()?;
        let fingerprint = self.fingerprint(&works);
        let cached = self.read_cache(cache, fingerprint, &works);
        let (bound, solved) = self.bind_work(&works, cached.as_ref(), progress)?;
        let new = (cached.is_none() && !solved.is_empty()).then(|| write_cache(fingerprint, &solved));
        Ok((bound, new))
    }

    fn is_cachable(&self, works: &[Work<'_>]) -> bool {
        works.iter().any(|work| self.is_solved(work.part))
    }

    /// The weights of a cache that is whole and of this very character.
    fn read_cache(&self, bytes: &[u8], fingerprint: u64, works: &[Work<'_>]) -> Option<Cached> {
        let solved = || works.iter().filter(|work| self.is_solved(work.part));
        let count = solved().fold(0, |from, work| {
            work.chains.iter().fold(from, |from, (_, chain)| sample_range(from, chain, work.joints.len()).end)
        });
        let (body, sum) = bytes.split_at_checked(bytes.len().checked_sub(8)?)?;
        let (head, values) = body.split_at_checked(16)?;
        let is_whole = head.get(..8) == Some(&MAGIC)
            && head.get(8..) == Some(&fingerprint.to_le_bytes())
            && values.len() == 8 * count
            && sum == checksum(body).to_le_bytes();
        if !is_whole || count == 0 {
            return None;
        }
        let values: Vec<f64> =
            values.chunks_exact(8).filter_map(|b| Some(f64::from_le_bytes(b.try_into().ok()?))).collect();
        // A forged cache does no more harm than a strange pose.
        let mut from = 0;
        for work in solved() {
            let handles = work.joints.len();
            for (_, chain) in &work.chains {
                let range = sample_range(from, chain, handles);
                from = range.end;
                let fits = |node: &[f64]| {
                    node.iter().all(|w| (0.0..=1.0).contains(w)) && (node.iter().sum::<f64>() - 1.0).abs() < 1e-9
                };
                if !values.get(range)?.chunks_exact(handles).all(fits) {
                    return None;
                }
            }
        }
        Some(Cached { values })
    }

    /// A hash of all that weights depend on that are solved for.
    fn fingerprint(&self, works: &[Work<'_>]) -> u64 {
        let mut words = Words::default();
        let mut mix = |list: &[f64]| {
            words.mix(list.len() as u64);
            list.iter().for_each(|x| words.mix(x.to_bits()));
        };
        for work in works.iter().filter(|work| self.is_solved(work.part)) {
            for shape in self.handles_of(work.part, &work.joints) {
                match shape {
                    HandleShape::Point(place) => mix(&place.to_array()),
                    HandleShape::Bone(from, to) => mix(&[from.x, from.y, to.x, to.y]),
                }
            }
            match self.source_of(work.part) {
                WeightSource::Shepard { power } => mix(&[*power]),
                WeightSource::Bounded { triangles, outline } => {
                    mix(&[f64::from(*triangles), 0.0]);
                    outline.iter().for_each(|corner| mix(&corner.to_array()));
                }
                WeightSource::Cage { triangles, corners } => {
                    mix(&[f64::from(*triangles), 1.0]);
                    let place = |joint: usize| work.joints.iter().position(|of| *of as usize == joint);
                    let place = |joint| place(joint).unwrap_or(usize::MAX) as f64;
                    corners.iter().for_each(|corner| mix(&[corner.at.x, corner.at.y, place(corner.joint)]));
                }
            }
            for (_, chain) in &work.chains {
                mix(&[f64::from(u8::from(chain.is_closed()))]);
                chain.points().iter().for_each(|p| mix(&[p.x, p.y]));
            }
        }
        words.0
    }
}

fn write_cache(fingerprint: u64, values: &[f64]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(24 + 8 * values.len());
    bytes.extend(MAGIC);
    bytes.extend(fingerprint.to_le_bytes());
    values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    bytes.extend(checksum(&bytes).to_le_bytes());
    bytes
}

fn checksum(bytes: &[u8]) -> u64 {
    let mut words = Words::default();
    for eight in bytes.chunks(8) {
        let mut word = [0; 8];
        word[..eight.len()].copy_from_slice(eight);
        words.mix(u64::from_le_bytes(word));
    }
    words.0
}
