//! Documents beside surfaces: their splines appear, follow the file, and are saved.
//!
//! When a file changes on disk, its splines follow, unless there are edits that are not saved: then nothing is changed, and
//! [`DocumentConflict`] asks for a [`ResolveConflict`].

use std::path::PathBuf;

use bevy::asset::{AssetEventSystems, AssetLoadFailedEvent};
use bevy::ecs::system::SystemParam;
use bevy::log::{info, warn};
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::document_asset::{DocumentAsset, DocumentLoader};
use super::edit_queue::PendingEdit;
use super::spline::SurfaceSpline;
use super::surface::{BuiltSurface, OnSurface, SurfaceItems};
use crate::curve::Spline;
use crate::format::document::{Document, DocumentError, DocumentSpline, MappingReport, SplineStyle, SurfaceReference};
use crate::geodesic::PathFinder;

/// Puts the splines of a document on the surface of this entity, as soon as both are there.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_surface_splines::plugin::SplineDocument;
/// # use bevy_surface_splines::prelude::*;
/// # fn setup(mut commands: Commands, assets: Res<AssetServer>, mut meshes: ResMut<Assets<Mesh>>) {
/// commands.spawn((
///     Mesh3d(meshes.add(Sphere::new(1.0))),
///     SplineSurface::default(),
///     SplineDocument(assets.load("planet.splines.ron")),
/// ));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(DocumentState, Base)]
pub struct SplineDocument(pub Handle<DocumentAsset>);

/// How far the document of an entity is.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub enum DocumentState {
    /// The file is not loaded, or the surface is not built.
    #[default]
    Pending,
    /// Its splines are there.
    Ready,
    /// The file has changed, and so have the splines: [`ResolveConflict`] says which are to stay.
    Conflict,
    /// It cannot be used.
    Failed {
        /// Why, and what to do about it.
        reason: String,
    },
}

/// Marks a spline as part of the document of its surface, with what is not geometry; its name is a `Name`, and it is hidden by
/// `Visibility::Hidden`.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct DocumentedSpline {
    /// How it is drawn.
    pub style: SplineStyle,
    /// Whether it is not to be edited.
    pub locked: bool,
}

/// How the mesh of a surface is known to documents; without it, it is taken to be as it is in its file.
///
/// For programs that move or scale what they read, see [`Frame`](crate::format::document::Frame).
#[derive(Component, Clone, Debug, PartialEq)]
pub struct KnownMesh(pub SurfaceReference);

/// Asks to save the document of a surface: all splines on it that are [`DocumentedSpline`]s.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct SaveDocument {
    /// The entity with the surface.
    pub surface: Entity,
    /// Where to, in the file system.
    pub path: PathBuf,
}

/// Settles a [`DocumentConflict`].
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResolveConflict {
    /// The entity with the surface and the document.
    pub surface: Entity,
    /// Which splines stay.
    pub choice: ConflictChoice,
}

/// Which splines stay where both file and splines have changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
pub enum ConflictChoice {
    /// Those that are there; they stay unsaved.
    KeepMine,
    /// Those of the file; unsaved edits are lost.
    TakeTheirs,
}

/// Happens when the splines of a document have appeared, or have followed their file.
#[derive(EntityEvent, Clone, Debug)]
pub struct DocumentRestored {
    /// The entity with the surface and the document.
    pub entity: Entity,
    /// Present if the surface is not the document's, so that all points went to closest places.
    pub mapping: Option<MappingReport>,
}

/// Happens when a file has changed while there are unsaved edits; nothing was changed.
#[derive(EntityEvent, Clone, Debug)]
pub struct DocumentConflict {
    /// The entity with the surface and the document.
    pub entity: Entity,
}

/// Happens when a document was saved.
#[derive(EntityEvent, Clone, Debug)]
pub struct DocumentSaved {
    /// The entity with the surface.
    pub entity: Entity,
    /// Where to.
    pub path: PathBuf,
}

/// Happens when a document cannot be loaded, restored or saved; splines that are there stay, and so does the old file.
#[derive(EntityEvent, Clone, Debug)]
pub struct DocumentFailed {
    /// The entity with the surface.
    pub entity: Entity,
    /// Why, and what to do about it.
    pub reason: String,
}

/// The document as it was last restored or saved; none before.
#[derive(Component, Clone, Debug, Default)]
#[component(clone_behavior = Ignore)]
struct Base(Option<Document>);

/// Restores documents, follows their files, saves them.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Resolve`], after `AssetEventSystems`. Needs Bevy's `AssetPlugin`; files
/// are watched if its feature `file_watcher` is on.
#[derive(Debug, Default)]
pub struct DocumentPlugin;

impl Plugin for DocumentPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_type::<SplineDocument>()
            .register_type::<DocumentState>()
            .register_type::<ConflictChoice>()
            .add_message::<SaveDocument>()
            .add_message::<ResolveConflict>()
            .add_systems(
                PostUpdate,
                (save_documents, resolve_conflicts, restore_documents)
                    .chain()
                    .in_set(SurfaceSplineSystems::Resolve)
                    .after(AssetEventSystems)
                    .run_if(resource_exists::<Assets<DocumentAsset>>),
            );
        if app.world().contains_resource::<AssetServer>() {
            app.init_asset::<DocumentAsset>().register_asset_loader(DocumentLoader);
        } else {
            warn!("documents need Bevy's AssetPlugin: add it before DocumentPlugin");
        }
    }
}

/// Why there is no document of a surface.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// The entity has no surface, or it is not built yet.
    #[error("{0} has no surface that is ready: wait for On<SurfaceReady>")]
    NoSurface(Entity),
    /// A spline does not lie on it.
    #[error(transparent)]
    Document(#[from] DocumentError),
}

/// Takes down the splines of surfaces as documents.
#[derive(SystemParam)]
pub struct SplineDocuments<'w, 's> {
    surfaces: Query<
        'w,
        's,
        (&'static BuiltSurface, Option<&'static KnownMesh>, Option<&'static SurfaceItems>, Option<&'static Base>),
    >,
    splines: Query<
        'w,
        's,
        (
            &'static SurfaceSpline,
            &'static DocumentedSpline,
            Option<&'static Name>,
            Option<&'static Visibility>,
            Has<PendingEdit>,
        ),
    >,
}

impl SplineDocuments<'_, '_> {
    /// The document of a surface: all splines on it that are [`DocumentedSpline`]s, with the path and the view of the document
    /// that was restored or saved last.
    ///
    /// # Errors
    /// [`CaptureError`].
    pub fn capture(&self, surface: Entity) -> Result<Document, CaptureError> {
        let (built, known, _, base) = self.surfaces.get(surface).map_err(|_| CaptureError::NoSurface(surface))?;
        let mut reference = reference(built, known);
        let base = base.and_then(|base| base.0.as_ref());
        if let (None, Some(base)) = (&reference.path, base) {
            reference.path.clone_from(&base.surface.path);
        }
        let mut document = Document::new(reference);
        document.view = base.and_then(|base| base.view);
        for (_, (spline, part, name, visibility, _)) in self.documented(surface) {
            let name = name.map_or_else(String::new, |name| name.as_str().to_owned());
            let added = document.add(built, name, spline)?;
            (added.style, added.locked) = (part.style, part.locked);
            added.hidden = visibility == Some(&Visibility::Hidden);
        }
        Ok(document)
    }

    /// Whether the splines of a surface differ from the document that was last restored or saved.
    pub fn has_unsaved_edits(&self, surface: Entity) -> bool {
        let Ok((.., base)) = self.surfaces.get(surface) else { return false };
        if self.documented(surface).any(|(_, (.., is_pending))| is_pending) {
            return true;
        }
        let before = base.and_then(|base| base.0.as_ref()).map_or(&[][..], |base| &base.splines);
        self.capture(surface).map_or(true, |now| now.splines != before)
    }

    /// The splines of the document, in order.
    fn documented(&self, surface: Entity) -> impl Iterator<Item = (Entity, Part<'_>)> {
        let items = self.surfaces.get(surface).ok().and_then(|(_, _, items, _)| items);
        items.into_iter().flat_map(|items| items.iter()).filter_map(|item| Some((item, self.splines.get(item).ok()?)))
    }
}

type Part<'a> = (&'a SurfaceSpline, &'a DocumentedSpline, Option<&'a Name>, Option<&'a Visibility>, bool);

fn reference(built: &BuiltSurface, known: Option<&KnownMesh>) -> SurfaceReference {
    known.map_or_else(|| SurfaceReference::of(built), |known| known.0.clone())
}

fn save_documents(mut commands: Commands, mut messages: MessageReader<SaveDocument>, documents: SplineDocuments) {
    for SaveDocument { surface, path } in messages.read() {
        let entity = *surface;
        let saved = documents.capture(entity).and_then(|document| {
            document.save(path)?;
            Ok(document)
        });
        match saved {
            Ok(document) => {
                commands.entity(entity).try_insert(Base(Some(document)));
                commands.trigger(DocumentSaved { entity, path: path.clone() });
            }
            Err(error) => {
                warn!("{error}");
                commands.trigger(DocumentFailed { entity, reason: error.to_string() });
            }
        }
    }
}

/// Settles conflicts: whoever takes theirs restores again.
fn resolve_conflicts(
    mut messages: MessageReader<ResolveConflict>,
    mut documents: Query<(&mut DocumentState, &mut Base)>,
) {
    for ResolveConflict { surface, choice } in messages.read() {
        let Ok((mut state, mut base)) = documents.get_mut(*surface) else { continue };
        if *state != DocumentState::Conflict {
            continue;
        }
        match choice {
            ConflictChoice::KeepMine => *state = DocumentState::Ready,
            ConflictChoice::TakeTheirs => {
                (*state, base.0) = (DocumentState::Pending, None);
            }
        }
    }
}

type Waiting<'w, 's> = Query<'w, 's, (Entity, Ref<'static, SplineDocument>, Mut<'static, DocumentState>)>;

fn restore_documents(
    mut commands: Commands,
    mut finder: Local<PathFinder>,
    assets: Res<Assets<DocumentAsset>>,
    mut events: MessageReader<AssetEvent<DocumentAsset>>,
    mut failures: MessageReader<AssetLoadFailedEvent<DocumentAsset>>,
    mut waiting: Waiting,
    documents: SplineDocuments,
) {
    let failures: Vec<_> = failures.read().collect();
    let modified: Vec<AssetId<DocumentAsset>> = events
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    for (entity, document, mut state) in &mut waiting {
        let id = document.0.id();
        if let Some(failure) = failures.iter().find(|failure| failure.id == id) {
            let reason = failure.error.to_string();
            if *state == DocumentState::Pending {
                *state = DocumentState::Failed { reason: reason.clone() };
            }
            commands.trigger(DocumentFailed { entity, reason });
        }
        let has_changed = document.is_changed() || modified.contains(&id);
        if !has_changed && *state != DocumentState::Pending {
            continue;
        }
        let (Some(asset), Ok((built, known, _, base))) = (assets.get(id), documents.surfaces.get(entity)) else {
            continue;
        };
        let is_first = base.is_none_or(|base| base.0.is_none());
        let restored = match asset.restore_as(built, &reference(built, known), &mut finder) {
            Ok(restored) => restored,
            Err(error) => {
                let reason = error.to_string();
                warn!("the document of {entity} cannot be used: {reason}");
                *state = DocumentState::Failed { reason: reason.clone() };
                commands.trigger(DocumentFailed { entity, reason });
                continue;
            }
        };
        let pairs = restored.splines.into_iter().zip(&asset.splines);
        let pairs: Vec<(Spline, &DocumentSpline)> = pairs.filter_map(|(spline, part)| Some((spline?, part))).collect();
        let theirs = match taken_down(built, &reference(built, known), asset, &pairs) {
            Ok(theirs) => theirs,
            Err(error) => {
                *state = DocumentState::Failed { reason: error.to_string() };
                continue;
            }
        };
        if !is_first && documents.has_unsaved_edits(entity) {
            // What is there may be what the file says by now.
            let is_same = documents.capture(entity).is_ok_and(|mine| mine.splines == theirs.splines);
            if !is_same {
                if *state != DocumentState::Conflict {
                    *state = DocumentState::Conflict;
                    info!("the document of {entity} has changed on disk, and there are unsaved edits");
                }
                commands.trigger(DocumentConflict { entity });
                continue;
            }
        }
        let old: Vec<Entity> = documents.documented(entity).map(|(item, _)| item).collect();
        put_on(&mut commands, entity, &old, pairs);
        commands.entity(entity).try_insert(Base(Some(theirs)));
        state.set_if_neq(DocumentState::Ready);
        if let Some(report) = &restored.mapping {
            warn!("the document of {entity}: {report}");
        }
        commands.trigger(DocumentRestored { entity, mapping: restored.mapping });
    }
}

/// What a capture will say once the splines are there.
fn taken_down(
    built: &BuiltSurface,
    reference: &SurfaceReference,
    asset: &Document,
    pairs: &[(Spline, &DocumentSpline)],
) -> Result<Document, DocumentError> {
    let mut reference = reference.clone();
    reference.path = reference.path.or_else(|| asset.surface.path.clone());
    let mut document = Document::new(reference);
    document.view = asset.view;
    for (spline, part) in pairs {
        let added = document.add(built, part.name.clone(), spline)?;
        (added.style, added.hidden, added.locked) = (part.style, part.hidden, part.locked);
    }
    Ok(document)
}

/// Puts splines on a surface in the place of those that are there.
fn put_on(commands: &mut Commands, surface: Entity, old: &[Entity], pairs: Vec<(Spline, &DocumentSpline)>) {
    old.iter().skip(pairs.len()).for_each(|entity| commands.entity(*entity).try_despawn());
    for (i, (spline, part)) in pairs.into_iter().enumerate() {
        let visibility = if part.hidden { Visibility::Hidden } else { Visibility::default() };
        let DocumentSpline { style, locked, .. } = *part;
        let bundle =
            (SurfaceSpline::new(spline), DocumentedSpline { style, locked }, Name::new(part.name.clone()), visibility);
        match old.get(i) {
            Some(entity) => drop(commands.entity(*entity).try_insert(bundle)),
            None => drop(commands.spawn((OnSurface(surface), bundle))),
        }
    }
}
