//! The paths of characters bound to their joints, once for all that share a file, in the background.

use std::sync::Arc;

use bevy::asset::AssetServer;
use bevy::asset::io::AssetWriterError;
use bevy::log::debug;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on, futures_lite::future};

use super::character_asset::CharacterAsset;
use super::skin_binding::SkinBinding;
use crate::character::{BindProgress, BoundCharacter, Character};
use crate::vector::{Picture, PictureOptions, Shape};

/// All that characters of one file share.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) character: Arc<Character>,
    /// For the plane, and for surfaces, on which edges must not be long.
    pub(super) bindings: [SkinBinding; 2],
    pub(super) inverse_rest: Vec<Mat4>,
}

/// What is bound, and what is being bound.
#[derive(Resource, Default)]
pub(super) struct Bindings {
    of: HashMap<AssetId<CharacterAsset>, Binding>,
}

struct Binding {
    character: Arc<Character>,
    progress: Arc<BindProgress>,
    task: Option<Task<Result<Prepared, String>>>,
    done: Option<Result<Arc<Prepared>, String>>,
    is_wanted: bool,
}

impl Drop for Binding {
    fn drop(&mut self) {
        // Nobody waits for it any more.
        self.progress.cancel();
    }
}

impl Bindings {
    pub(super) fn begin_frame(&mut self) {
        self.of.values_mut().for_each(|binding| binding.is_wanted = false);
    }

    /// Lets go of what no character wants.
    pub(super) fn end_frame(&mut self) {
        self.of.retain(|_, binding| binding.is_wanted);
    }

    /// What came of an asset; how far it is if it is not done.
    pub(super) fn of(
        &mut self,
        id: AssetId<CharacterAsset>,
        asset: &CharacterAsset,
        server: Option<&AssetServer>,
    ) -> Result<Result<&Arc<Prepared>, &str>, f32> {
        let is_it = self.of.get(&id).is_some_and(|binding| Arc::ptr_eq(&binding.character, asset.character()));
        if !is_it {
            self.of.insert(id, Binding::begin(id, asset, server));
        }
        let Some(binding) = self.of.get_mut(&id) else { return Err(0.0) };
        binding.is_wanted = true;
        if let Some(result) = binding.task.as_mut().and_then(|task| block_on(future::poll_once(task))) {
            binding.task = None;
            binding.done = Some(result.map(Arc::new));
        }
        match &binding.done {
            None => Err(binding.progress.fraction()),
            Some(Ok(prepared)) => Ok(Ok(prepared)),
            Some(Err(reason)) => Ok(Err(reason)),
        }
    }
}

impl Binding {
    fn begin(id: AssetId<CharacterAsset>, asset: &CharacterAsset, server: Option<&AssetServer>) -> Self {
        let (character, progress) = (asset.character().clone(), Arc::new(BindProgress::default()));
        let (own, watched) = (character.clone(), progress.clone());
        let cache = server.and_then(|server| Cache::of(id, server));
        let work = async move {
            let bytes = match &cache {
                Some(cache) => cache.read().await,
                None => Vec::new(),
            };
            let (bound, new) = own.bind_with(&bytes, &watched).map_err(|error| error.to_string())?;
            if let (Some(cache), Some(new)) = (cache, new) {
                cache.write(&new).await;
            }
            prepare(own, bound)
        };
        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(work);
        Self { character, progress, task: Some(task), done: None, is_wanted: true }
    }
}

/// On a surface, no edge is longer than the character's extent over this.
const EDGES: f32 = 40.0;

/// Puts together what is shared.
fn prepare(character: Arc<Character>, bound: BoundCharacter) -> Result<Prepared, String> {
    let drawing = &character.drawing;
    // Shapes in the order in which they are painted, each with those of its paths that are bound.
    let mut shapes: Vec<(usize, Shape)> = Vec::new();
    for path in &bound.paths {
        let Some(shape) = drawing.shapes.get(path.shape) else { continue };
        if shapes.last().is_none_or(|(number, _)| *number != path.shape) {
            shapes.push((path.shape, Shape { paths: Vec::new(), ..shape.clone() }));
        }
        if let Some((_, last)) = shapes.last_mut() {
            last.paths.extend(shape.paths.get(path.path).cloned());
        }
    }
    let painted = shapes.iter().map(|(_, shape)| (&shape.paths[..], &shape.style));
    let options = PictureOptions { origin: Some(drawing.centre()), ..PictureOptions::default() };
    let plane = Picture::planar(painted.clone(), &drawing.gradients, &options);
    let spaced = PictureOptions { spacing: Some(plane.extent() / EDGES), ..options };
    let spaced = Picture::planar(painted, &drawing.gradients, &spaced);
    let mut paths = vec![0; bound.skin.chains().len()];
    for (number, path) in bound.paths.iter().enumerate() {
        if let Some(place) = paths.get_mut(path.chain) {
            *place = number;
        }
    }
    let inverse = |m: &glam::DAffine2| Mat4::from(crate::skin::in_space(m).as_affine3a());
    let inverse_rest = bound.inverse_rest.iter().map(inverse).collect();
    let skin = Arc::new(bound.skin);
    let bind = |picture| SkinBinding::new(skin.clone(), picture, &paths);
    let bindings = bind(plane).zip(bind(spaced)).ok_or("its paths do not fit its drawing: load it again")?;
    Ok(Prepared { character, bindings: bindings.into(), inverse_rest })
}

/// Where solved weights are kept: beside the character's file.
struct Cache {
    server: AssetServer,
    path: bevy::asset::AssetPath<'static>,
}

impl Cache {
    /// Of a character that came from a file.
    fn of(id: AssetId<CharacterAsset>, server: &AssetServer) -> Option<Self> {
        let path = server.get_path(id)?.into_owned();
        let file = Character::cache_path(path.path());
        let path = bevy::asset::AssetPath::from(file).with_source(path.source().clone_owned());
        Some(Self { server: server.clone(), path })
    }

    /// The cache; empty if there is none.
    async fn read(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        if let Ok(source) = self.server.get_source(self.path.source())
            && let Ok(mut reader) = source.reader().read(self.path.path()).await
            && reader.read_to_end(&mut bytes).await.is_err()
        {
            bytes.clear();
        }
        bytes
    }

    /// Keeps a cache, where assets can be written.
    async fn write(&self, bytes: &[u8]) {
        let written: Result<(), AssetWriterError> = async {
            if let Ok(source) = self.server.get_source(self.path.source())
                && let Ok(writer) = source.writer()
            {
                writer.write_bytes(self.path.path(), bytes).await?;
            }
            Ok(())
        }
        .await;
        if let Err(error) = written {
            debug!("the weights of {} are not kept: {error}", self.path);
        }
    }
}
