//! Surfaces under construction, shared by the entities that wait for them.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Weak};

use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, block_on, futures_lite::future};

use super::mesh::{close_seams, read_triangles};
use crate::surface::{BuildProgress, Surface, SurfaceError, SurfaceOptions, TriangleMesh};

/// Surfaces by mesh asset: running, built (as long as someone uses them) or failed.
#[derive(Resource, Default)]
pub(crate) struct Builds {
    entries: HashMap<AssetId<Mesh>, Vec<Entry>>,
}

struct Entry {
    options: SurfaceOptions,
    stage: Stage,
    /// Of the triangles it was built from.
    fingerprint: u64,
    /// Whether the mesh was modified since.
    stale: bool,
    /// Whether an entity asked since the last [`Builds::drop_unwanted`].
    wanted: bool,
}

enum Stage {
    Running(Running),
    Built(Weak<Surface>),
    Failed(String),
}

/// A build in a task; dropping it asks the build to stop.
struct Running {
    task: Task<Result<Surface, SurfaceError>>,
    progress: Arc<BuildProgress>,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}

/// What came of a request so far.
pub(crate) enum BuildStatus {
    /// The mesh is not loaded, or its build runs; the share that is done.
    Pending(f32),
    /// Done.
    Ready(Arc<Surface>),
    /// It cannot be done.
    Failed {
        /// Why, with the remedy.
        reason: String,
        /// Whether this is the first time that this is said.
        first: bool,
    },
}

impl Builds {
    /// Starts the build, or reports on it.
    pub(crate) fn request(
        &mut self,
        id: AssetId<Mesh>,
        options: &SurfaceOptions,
        meshes: &Assets<Mesh>,
    ) -> BuildStatus {
        let entries = self.entries.entry(id).or_default();
        let known = entries.iter().position(|e| e.options == *options);
        let place = match known.filter(|place| !entries[*place].stale) {
            Some(place) => place,
            None => {
                let Some(mesh) = meshes.get(id) else { return BuildStatus::Pending(0.0) };
                match refresh(entries, known, mesh, options) {
                    Ok(place) => place,
                    Err(reason) => return BuildStatus::Failed { reason, first: true },
                }
            }
        };
        let entry = &mut entries[place];
        entry.wanted = true;
        let (stage, status) = match &mut entry.stage {
            Stage::Running(running) => match block_on(future::poll_once(&mut running.task)) {
                None => return BuildStatus::Pending(running.progress.fraction()),
                Some(Ok(surface)) => {
                    let surface = Arc::new(surface);
                    (Stage::Built(Arc::downgrade(&surface)), BuildStatus::Ready(surface))
                }
                Some(Err(error)) => {
                    let reason = error.to_string();
                    (Stage::Failed(reason.clone()), BuildStatus::Failed { reason, first: true })
                }
            },
            Stage::Failed(reason) => return BuildStatus::Failed { reason: reason.clone(), first: false },
            Stage::Built(surface) => match surface.upgrade() {
                Some(surface) => return BuildStatus::Ready(surface),
                None => {
                    entries.swap_remove(place);
                    return self.request(id, options, meshes);
                }
            },
        };
        entry.stage = stage;
        status
    }

    /// Notes that a mesh was modified: its surfaces hold only if its triangles are the same.
    pub(crate) fn modified(&mut self, id: AssetId<Mesh>) {
        self.entries.entry(id).or_default().iter_mut().for_each(|entry| entry.stale = true);
    }

    /// Forgets what is known of a mesh, because it is gone.
    pub(crate) fn forget(&mut self, id: AssetId<Mesh>) {
        self.entries.remove(&id);
    }

    /// Stops builds that nobody waits for any more, and forgets surfaces that nobody uses.
    pub(crate) fn drop_unwanted(&mut self) {
        self.entries.retain(|_, entries| {
            entries.retain_mut(|entry| match &entry.stage {
                Stage::Running(_) => std::mem::take(&mut entry.wanted),
                Stage::Built(surface) => surface.strong_count() > 0,
                Stage::Failed(_) => true,
            });
            !entries.is_empty()
        });
    }
}

/// Starts a build for a mesh that is new or was modified, unless an entry was built from the same triangles; its place.
fn refresh(
    entries: &mut Vec<Entry>,
    known: Option<usize>,
    mesh: &Mesh,
    options: &SurfaceOptions,
) -> Result<usize, String> {
    let triangles = read_triangles(mesh).map_err(|error| error.to_string());
    let fingerprint = triangles.as_ref().map_or(0, fingerprint);
    let entry = |stage| Entry { options: *options, stage, fingerprint, stale: false, wanted: true };
    let (entry, refused) = match (known, triangles) {
        (Some(place), Ok(_)) if entries[place].fingerprint == fingerprint => {
            entries[place].stale = false;
            return Ok(place);
        }
        (_, Ok(triangles)) => (entry(Stage::Running(start(triangles, *options))), None),
        (_, Err(reason)) => (entry(Stage::Failed(reason.clone())), Some(reason)),
    };
    if let Some(place) = known {
        entries.swap_remove(place);
    }
    entries.push(entry);
    refused.map_or(Ok(entries.len() - 1), Err)
}

/// Starts building in the background.
fn start(mut triangles: TriangleMesh, options: SurfaceOptions) -> Running {
    let progress = Arc::new(BuildProgress::default());
    let watch = progress.clone();
    let task = AsyncComputeTaskPool::get_or_init(Default::default).spawn(async move {
        close_seams(&mut triangles.positions);
        Surface::build_observed(&triangles, &options, &watch)
    });
    Running { task, progress }
}

/// Tells triangles apart.
fn fingerprint(triangles: &TriangleMesh) -> u64 {
    let mut hasher = DefaultHasher::new();
    triangles.positions.iter().for_each(|p| p.to_array().map(f64::to_bits).hash(&mut hasher));
    triangles.faces.hash(&mut hasher);
    hasher.finish()
}
