//! What lines are made from: places, faces; and what is made from lines.

use bevy::log::warn;
use bevy::prelude::*;

use super::line::{LineFailed, LineState, SurfaceLine};
use super::smooth_lines::without_surface;
use super::smoothed_line::SmoothedLine;
use super::spline::{SurfaceSpline, nearest_points};
use super::surface::{BuiltSurface, OnSurface, SurfaceState};
use super::workspaces::Workspaces;
use crate::curve::{Fit, FitError, FitOptions, Spline, TraceWorkspace};
use crate::geodesic::PathFinder;
use crate::smooth::{PolylineError, SurfacePolyline};
use crate::surface::{FaceId, PointError, Surface, SurfacePoint};

/// What a line is to be made from; becomes a [`SurfaceLine`] once the surface is ready.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_surface_splines::prelude::*;
/// # fn setup(mut commands: Commands, planet: Single<Entity, With<SplineSurface>>) {
/// let zigzag = (0..20).map(|k| Vec3::new(0.1 * k as f32 - 1.0, if k % 2 == 0 { 0.1 } else { -0.1 }, 1.0));
/// commands.spawn((OnSurface(*planet), LineSource::through(zigzag), LineSmoothing::tether(10.0)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(LineState)]
pub struct LineSource {
    from: SourceLine,
    closed: bool,
}

#[derive(Reflect, Clone, Debug, PartialEq)]
enum SourceLine {
    Positions(Vec<Vec3>),
    Points(Vec<SurfacePoint>),
    Faces(Vec<FaceId>),
}

impl LineSource {
    /// A line from one surface point to the next by shortest paths, each nearest to a position in the surface's local space.
    pub fn through(positions: impl IntoIterator<Item = Vec3>) -> Self {
        Self { from: SourceLine::Positions(positions.into_iter().collect()), closed: false }
    }

    /// The same through exact points, picked ones say.
    pub fn through_points(points: impl IntoIterator<Item = SurfacePoint>) -> Self {
        Self { from: SourceLine::Points(points.into_iter().collect()), closed: false }
    }

    /// The longest line between some faces and all others, the faces to its left. For all of them:
    /// [`spawn_lines_around`](LineCommands::spawn_lines_around).
    pub fn around_faces(faces: impl IntoIterator<Item = FaceId>) -> Self {
        Self { from: SourceLine::Faces(faces.into_iter().collect()), closed: false }
    }

    /// Joins the last point to the first.
    pub fn closed(mut self) -> Self {
        self.closed = true;
        self
    }

    /// Makes the line.
    fn resolve(&self, surface: &Surface, finder: &mut PathFinder) -> Result<SurfaceLine, String> {
        let through = |finder: &mut PathFinder, points: &[SurfacePoint]| {
            let line = SurfacePolyline::through(surface, finder, points, self.closed);
            line.map(SurfaceLine::new).map_err(|error| error.to_string())
        };
        match &self.from {
            SourceLine::Positions(positions) => through(finder, &nearest_points(surface, positions)?),
            SourceLine::Points(points) => through(finder, points),
            SourceLine::Faces(faces) => {
                let lines = SurfaceLine::around_faces(surface, faces).map_err(|error| error.to_string())?;
                lines.into_iter().next().ok_or_else(|| NO_BOUNDARY.to_string())
            }
        }
    }
}

const NO_BOUNDARY: &str =
    "no line runs between these faces and others: give some of the surface's faces, at least three, and not all";

impl SurfaceLine {
    /// The lines between some faces and all others, the longest first: see [`SurfacePolyline::around_faces`].
    ///
    /// # Errors
    /// [`PointError`] if a face does not exist or was dropped.
    pub fn around_faces(surface: &Surface, faces: &[FaceId]) -> Result<Vec<Self>, PointError> {
        let lines = SurfacePolyline::around_faces(surface, faces)?;
        let mut lines: Vec<_> = lines.into_iter().map(|line| (line.length(surface), line)).collect();
        lines.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(lines.into_iter().map(|(_, line)| Self::new(line)).collect())
    }
}

/// Why a line cannot become a spline.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LineFitError {
    /// The line cannot be followed.
    #[error(transparent)]
    Line(#[from] PolylineError),
    /// No spline follows it.
    #[error(transparent)]
    Fit(#[from] FitError),
}

impl SmoothedLine {
    /// The spline that follows the line, closed if that is: see [`Spline::fit`].
    ///
    /// # Errors
    /// [`LineFitError`] if the surface is another one, or the tolerance cannot be met.
    pub fn fit(
        &self,
        surface: &Surface,
        workspace: &mut TraceWorkspace,
        options: &FitOptions,
    ) -> Result<Fit, LineFitError> {
        Ok(Spline::fit(surface, workspace, &self.line.to_drawn(surface)?, options)?)
    }
}

/// What game code asks of lines by `Commands`.
pub trait LineCommands {
    /// Spawns the lines between some faces of a surface and all others, the longest first, each with a clone of a bundle.
    ///
    /// If the surface is not ready, or a face does not exist, that is said by [`LineFailed`] about the surface's entity.
    fn spawn_lines_around(
        &mut self,
        surface: Entity,
        faces: impl IntoIterator<Item = FaceId>,
        each: impl Bundle + Clone,
    );

    /// Turns a line into a spline that follows its [`SmoothedLine`]: the same entity, which is a line no more.
    ///
    /// Takes some milliseconds a hundred edges. If it cannot be done the line stays, and [`LineFailed`] says why.
    fn turn_into_spline(&mut self, line: Entity, options: FitOptions);
}

impl LineCommands for Commands<'_, '_> {
    fn spawn_lines_around(
        &mut self,
        surface: Entity,
        faces: impl IntoIterator<Item = FaceId>,
        each: impl Bundle + Clone,
    ) {
        let faces: Vec<FaceId> = faces.into_iter().collect();
        self.queue(move |world: &mut World| {
            let lines = match world.get::<BuiltSurface>(surface) {
                Some(built) => SurfaceLine::around_faces(built, &faces).map_err(|error| error.to_string()),
                None => Err("its surface is not ready: wait for On<SurfaceReady>".to_string()),
            };
            match lines.and_then(|lines| if lines.is_empty() { Err(NO_BOUNDARY.into()) } else { Ok(lines) }) {
                Ok(lines) => lines.into_iter().for_each(|line| {
                    world.spawn((OnSurface(surface), line, each.clone()));
                }),
                Err(reason) => fail(world, surface, reason),
            }
        });
    }

    fn turn_into_spline(&mut self, line: Entity, options: FitOptions) {
        self.queue(move |world: &mut World| match fitted(world, line, &options) {
            Ok(spline) => {
                if let Ok(mut entity) = world.get_entity_mut(line) {
                    entity.remove::<(SurfaceLine, super::line::LineSmoothing, LineState, SmoothedLine)>();
                    entity.insert(SurfaceSpline::new(spline));
                }
            }
            Err(reason) => fail(world, line, reason),
        });
    }
}

fn fitted(world: &World, line: Entity, options: &FitOptions) -> Result<Spline, String> {
    let smoothed = world.get::<SmoothedLine>(line).ok_or("it is no line, or not ready: wait for On<LineChanged>")?;
    let on = world.get::<OnSurface>(line).ok_or("it is on no surface: insert OnSurface")?;
    let built = world.get::<BuiltSurface>(on.0).ok_or("its surface is not ready: wait for On<SurfaceReady>")?;
    let spare = Workspaces::default();
    let workspaces = world.get_resource::<Workspaces>().unwrap_or(&spare);
    let fit = workspaces.lend(|workspace| smoothed.fit(built, workspace, options));
    fit.map(|fit| fit.spline).map_err(|error| error.to_string())
}

fn fail(world: &mut World, entity: Entity, reason: String) {
    warn!("{entity}: {reason}");
    if world.get_entity(entity).is_ok() {
        world.trigger(LineFailed { entity, reason });
    }
}

/// The surfaces that lines lie on.
type Surfaces<'w, 's> = Query<'w, 's, (Option<Ref<'static, BuiltSurface>>, Option<&'static SurfaceState>)>;

pub(crate) fn resolve_line_sources(
    mut commands: Commands,
    mut finder: Local<PathFinder>,
    mut sources: Query<(Entity, Ref<LineSource>, Ref<OnSurface>, &mut LineState)>,
    surfaces: Surfaces,
) {
    for (entity, source, on, mut state) in &mut sources {
        let Ok((built, surface_state)) = surfaces.get(on.0) else { continue };
        let Some(built) = built else {
            state.set_if_neq(without_surface(surface_state));
            continue;
        };
        let is_asked = source.is_changed() || on.is_changed() || built.is_changed();
        if matches!(*state, LineState::Failed { .. }) && !is_asked {
            continue;
        }
        match source.resolve(&built, &mut finder) {
            Ok(line) => drop(commands.entity(entity).try_insert(line).try_remove::<LineSource>()),
            Err(reason) => {
                if state.set_if_neq(LineState::Failed { reason: reason.clone() }) {
                    warn!("the line {entity} cannot be made: {reason}");
                    commands.trigger(LineFailed { entity, reason });
                }
            }
        }
    }
}
