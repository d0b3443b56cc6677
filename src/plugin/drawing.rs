//! SVG drawings on surfaces: an asset, where it is placed, and the splines that it becomes.

use std::sync::Arc;

use bevy::asset::{AssetEventSystems, AssetLoader, LoadContext, LoadState, io::Reader};
use bevy::log::warn;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, block_on, futures_lite::future};

use super::SurfaceSplineSystems;
use super::spline::SurfaceSpline;
use super::surface::{BuiltSurface, OnSurface, SurfaceChanged, SurfaceState};
use crate::geodesic::WalkStop;
use crate::placement::{self, PlaceError, PlaceOptions, PlacedDrawing, PlacedSpline, place_drawing};
use crate::surface::{Surface, SurfacePoint};
use crate::vector::{self, SvgError, SvgReport, import_svg};

/// An SVG drawing that was loaded.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct SvgDrawing {
    /// The drawing.
    pub drawing: Arc<vector::Drawing>,
    /// What was found in the file, drawn and left out.
    pub report: SvgReport,
}

/// Loads `.svg` files as [`SvgDrawing`]s.
#[derive(TypePath, Clone, Copy, Debug, Default)]
pub struct SvgLoader;

/// Why an SVG asset could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum SvgLoadError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// It is no drawing.
    #[error(transparent)]
    Svg(#[from] SvgError),
}

impl AssetLoader for SvgLoader {
    type Asset = SvgDrawing;
    type Settings = ();
    type Error = SvgLoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        _context: &mut LoadContext<'_>,
    ) -> Result<SvgDrawing, SvgLoadError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let import = import_svg(&bytes)?;
        Ok(SvgDrawing { drawing: Arc::new(import.drawing), report: import.report })
    }

    fn extensions(&self) -> &[&str] {
        &["svg"]
    }
}

/// A drawing on the surface that [`OnSurface`] names, where [`Placement`] says.
///
/// It becomes splines, one for each path: entities of their own, on the same surface, which [`DrawingSplines`] lists. They follow when the
/// drawing, the placement or the file changes, and are then made anew: edits of theirs are lost.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(DrawingState, Job)]
pub struct Drawing(pub Handle<SvgDrawing>);

/// Where and how a [`Drawing`] lies on its surface.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, PartialEq)]
pub struct Placement {
    /// Where the centre of its view box lies.
    pub at: SurfacePoint,
    /// Which way is up, in the surface's local space; projected onto the tangent plane, its length does not matter.
    pub up: Vec3,
    /// Length on the surface, in local units, of one unit of the drawing.
    pub scale: f64,
}

impl From<Placement> for placement::Placement {
    fn from(Placement { at, up, scale }: Placement) -> Self {
        Self { at, up: up.as_dvec3(), scale }
    }
}

impl Placement {
    /// Goes straight ahead, in the direction that lies `angle` radians counter-clockwise from upward, for a distance in local units; what is up is
    /// carried along. What stopped it, if anything did.
    ///
    /// # Errors
    /// [`PlaceError`] if the centre does not belong to the surface, nothing is up, or a number is not finite; it stays then.
    pub fn walk(&mut self, surface: &Surface, angle: f64, distance: f64) -> Result<Option<WalkStop>, PlaceError> {
        let walked = placement::Placement::from(*self).walked(surface, angle, distance)?;
        (self.at, self.up) = (walked.placement.at, walked.placement.up.as_vec3());
        Ok(walked.stopped)
    }

    /// Turns counter-clockwise on the spot, as seen against the normal, by an angle in radians.
    ///
    /// # Errors
    /// As [`walk`](Self::walk).
    pub fn turn(&mut self, surface: &Surface, angle: f64) -> Result<(), PlaceError> {
        self.up = placement::Placement::from(*self).turned(surface, angle)?.up.as_vec3();
        Ok(())
    }
}

/// How a [`Drawing`] is placed, where that is to be otherwise than usual.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawingOptions(pub PlaceOptions);

/// How far a [`Drawing`] is.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub enum DrawingState {
    /// The file is not loaded, or the surface is not ready.
    #[default]
    Pending,
    /// It is being placed in the background; splines of an earlier placement stay meanwhile.
    Placing,
    /// Its splines are there.
    Ready {
        /// How many paths are not, because they leave the surface.
        dropped: u32,
    },
    /// It cannot be placed.
    Failed {
        /// Why, and what to do about it.
        reason: String,
    },
}

/// Marks a spline that a drawing made, and says of which of its paths.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, Debug, PartialEq)]
pub struct DrawnPath {
    /// The shape's place in the drawing.
    pub shape: u32,
    /// The path's place in the shape.
    pub path: u32,
}

/// The drawing that a spline belongs to; despawned with it.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, FromWorld, Clone, Debug, PartialEq)]
#[relationship(relationship_target = DrawingSplines)]
pub struct OfDrawing(#[entities] pub Entity);

impl FromWorld for OfDrawing {
    fn from_world(_: &mut World) -> Self {
        Self(Entity::PLACEHOLDER)
    }
}

/// The splines of a drawing, in the order in which its paths are painted.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[relationship_target(relationship = OfDrawing, linked_spawn)]
pub struct DrawingSplines(#[entities] Vec<Entity>);

/// What is being done about a drawing.
#[derive(Component, Default)]
#[component(clone_behavior = Ignore)]
struct Job {
    task: Option<Task<Result<PlacedDrawing, PlaceError>>>,
    /// Whether something changed since the task was begun, or since its splines were made.
    stale: bool,
}

/// Places drawings on surfaces.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Resolve`], after `AssetEventSystems`. Needs Bevy's `AssetPlugin`.
#[derive(Debug, Default)]
pub struct DrawingPlugin;

impl Plugin for DrawingPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_type::<Drawing>()
            .register_type::<Placement>()
            .register_type::<DrawingState>()
            .register_type::<DrawnPath>()
            .register_type::<OfDrawing>()
            .register_type::<DrawingSplines>()
            .add_observer(follow_changed_surface)
            .add_observer(drop_splines)
            .add_systems(
                PostUpdate,
                (notice_changes, place_drawings)
                    .chain()
                    .in_set(SurfaceSplineSystems::Resolve)
                    .after(AssetEventSystems)
                    .run_if(resource_exists::<Assets<SvgDrawing>>),
            );
        if app.world().contains_resource::<AssetServer>() {
            app.init_asset::<SvgDrawing>().init_asset_loader::<SvgLoader>();
        }
    }
}

/// Notes which drawings must be placed anew.
fn notice_changes(
    mut events: MessageReader<AssetEvent<SvgDrawing>>,
    mut drawings: Query<(
        Ref<Drawing>,
        Option<Ref<Placement>>,
        Option<Ref<DrawingOptions>>,
        Option<Ref<OnSurface>>,
        &mut Job,
    )>,
    mut without_options: RemovedComponents<DrawingOptions>,
    surfaces: Query<Ref<BuiltSurface>>,
) {
    let loaded: Vec<AssetId<SvgDrawing>> = events
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    for entity in without_options.read() {
        if let Ok((.., mut job)) = drawings.get_mut(entity) {
            job.stale = true;
        }
    }
    for (drawing, placement, options, on, mut job) in &mut drawings {
        let changed = drawing.is_changed()
            || placement.is_some_and(|placement| placement.is_changed())
            || options.is_some_and(|options| options.is_changed())
            || on.is_some_and(|on| on.is_changed() || surfaces.get(on.0).is_ok_and(|built| built.is_changed()))
            || loaded.contains(&drawing.0.id());
        if changed {
            job.stale = true;
        }
    }
}

/// Drawings of so few segments are placed in the frame on a surface where nothing is far.
const IN_THE_FRAME: usize = 50;

type Drawings<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static Drawing,
        Option<&'static Placement>,
        Option<&'static DrawingOptions>,
        Option<&'static OnSurface>,
        &'static mut DrawingState,
        &'static mut Job,
        Option<&'static DrawingSplines>,
    ),
>;

type Surfaces<'w, 's> = Query<'w, 's, (Option<&'static BuiltSurface>, Option<&'static SurfaceState>)>;

/// Begins placing, and makes splines of what was placed.
fn place_drawings(
    mut commands: Commands,
    assets: Res<Assets<SvgDrawing>>,
    server: Option<Res<AssetServer>>,
    mut drawings: Drawings,
    surfaces: Surfaces,
) {
    for (entity, drawing, placement, options, on, mut state, mut job, splines) in &mut drawings {
        let finished = job.task.as_mut().and_then(|task| block_on(future::poll_once(task)));
        if finished.is_some() {
            job.task = None;
        }
        let mut result = finished;
        if job.stale && job.task.is_none() {
            let sources = Sources { assets: &assets, server: server.as_deref(), surfaces: &surfaces };
            match sources.of(drawing, placement, on) {
                Ok(Some((surface, drawn, placement))) => {
                    job.stale = false;
                    let options = options.copied().unwrap_or_default().0;
                    if drawn.segment_count() <= IN_THE_FRAME && surface.face_count() <= super::background::SAFE_FACES {
                        result = Some(place_drawing(&surface, &drawn, &placement, &options));
                    } else {
                        let pool = AsyncComputeTaskPool::get_or_init(Default::default);
                        let work = async move { place_drawing(&surface, &drawn, &placement, &options) };
                        job.task = Some(pool.spawn(work));
                        state.set_if_neq(DrawingState::Placing);
                    }
                }
                Ok(None) => drop(state.set_if_neq(DrawingState::Pending)),
                Err(reason) => {
                    // A file that is mended loads again, which is noticed.
                    job.stale = false;
                    fail(entity, reason, &mut state, &mut commands);
                    continue;
                }
            }
        }
        match (result, on) {
            (Some(Ok(placed)), Some(on)) => {
                let dropped = placed.dropped() as u32;
                let known: &[Entity] = splines.map_or(&[], |splines| &splines.0);
                make_splines(&mut commands, entity, *on, known, placed.splines);
                if job.task.is_none() {
                    state.set_if_neq(DrawingState::Ready { dropped });
                }
            }
            (Some(Err(error)), _) => fail(entity, error.to_string(), &mut state, &mut commands),
            _ => {}
        }
    }
}

fn fail(entity: Entity, reason: String, state: &mut Mut<DrawingState>, commands: &mut Commands) {
    warn!("the drawing {entity} cannot be placed: {reason}");
    commands.entity(entity).despawn_related::<DrawingSplines>();
    state.set_if_neq(DrawingState::Failed { reason });
}

/// What drawings are made from.
struct Sources<'a, 'w, 's> {
    assets: &'a Assets<SvgDrawing>,
    server: Option<&'a AssetServer>,
    surfaces: &'a Surfaces<'w, 's>,
}

type Ready = (Arc<Surface>, Arc<vector::Drawing>, placement::Placement);

impl Sources<'_, '_, '_> {
    /// What is needed to place a drawing; none if some of it is still to come, and a reason if it never will.
    fn of(
        &self,
        drawing: &Drawing,
        placement: Option<&Placement>,
        on: Option<&OnSurface>,
    ) -> Result<Option<Ready>, String> {
        let Some(asset) = self.assets.get(&drawing.0) else {
            return match self.server.map(|server| server.load_state(&drawing.0)) {
                Some(LoadState::Failed(error)) => Err(format!("its file cannot be used: {error}")),
                _ => Ok(None),
            };
        };
        let Some(on) = on else { return Ok(None) };
        let Ok((built, state)) = self.surfaces.get(on.0) else { return Ok(None) };
        let Some(built) = built else {
            return match state {
                Some(SurfaceState::Failed { reason }) => Err(format!("its surface cannot be used: {reason}")),
                _ => Ok(None),
            };
        };
        let placement = placement.ok_or("it has no place: add a `Placement` to the entity")?;
        Ok(Some((built.0.clone(), asset.drawing.clone(), (*placement).into())))
    }
}

/// Makes the entities of a drawing's splines: those that are there take what comes first, the rest is spawned or despawned.
fn make_splines(commands: &mut Commands, drawing: Entity, on: OnSurface, known: &[Entity], placed: Vec<PlacedSpline>) {
    known.iter().skip(placed.len()).for_each(|surplus| commands.entity(*surplus).try_despawn());
    let mut known = known.iter();
    for PlacedSpline { shape, path, spline } in placed {
        let made = (SurfaceSpline::new(spline), DrawnPath { shape, path }, on);
        match known.next() {
            Some(entity) => drop(commands.entity(*entity).try_insert(made)),
            None => drop(commands.spawn((made, OfDrawing(drawing)))),
        }
    }
}

/// Moves placements to the nearest points of a surface that changed.
fn follow_changed_surface(
    changed: On<SurfaceChanged>,
    surfaces: Query<&BuiltSurface>,
    mut placements: Query<(&mut Placement, &OnSurface), With<Drawing>>,
) {
    let Ok(built) = surfaces.get(changed.entity) else { return };
    for (mut placement, _) in placements.iter_mut().filter(|(_, on)| on.0 == changed.entity) {
        if let Some(nearest) = built.closest_point(changed.previous.position(&placement.at)) {
            placement.at = nearest.point;
        }
    }
}

/// Despawns the splines of an entity that is no drawing any more.
fn drop_splines(removed: On<Remove, Drawing>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.despawn_related::<DrawingSplines>();
    }
}
