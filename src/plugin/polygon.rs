//! The control polygons of B-splines, where no handles show how anchors and curve belong together.

use std::sync::{Arc, Weak};

use bevy::ecs::entity::EntityHashMap;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on, futures_lite::future};

use super::SurfaceSplineSystems;
use super::background::SAFE_FACES;
use super::budget::{self, FrameTime, TraceBudget};
use super::controls::Editable;
use super::costs::Pace;
use super::edit_costs::search_work;
use super::spline::SurfaceSpline;
use super::surface::{BuiltSurface, OnSurface};
use super::workspaces::Workspaces;
use crate::curve::Spline;
use crate::geodesic::PathFinder;
use crate::surface::{Surface, SurfacePoint};

/// The control polygon of an [`Editable`] B-spline: the geodesics between consecutive anchors, back to the first if it is
/// closed. Derived: a system writes it whenever spline or surface change, and it is never saved. Where that takes longer than a
/// frame has, it lags behind.
#[derive(Component, Clone, Debug)]
#[component(immutable)]
pub struct ControlPolygon {
    legs: Vec<Leg>,
    surface: Weak<Surface>,
}

#[derive(Clone, Debug)]
struct Leg {
    ends: [SurfacePoint; 2],
    line: Arc<[Vec3]>,
}

impl ControlPolygon {
    /// The legs in order, as positions in the surface's local space; empty where no path joins two anchors.
    pub fn legs(&self) -> impl Iterator<Item = &[Vec3]> {
        self.legs.iter().map(|leg| &*leg.line)
    }

    fn is_on(&self, surface: &BuiltSurface) -> bool {
        std::ptr::eq(self.surface.as_ptr(), Arc::as_ptr(&surface.0))
    }

    fn is_of(&self, spline: &Spline) -> bool {
        self.legs.iter().map(|leg| leg.ends).eq(ends(spline))
    }
}

/// Keeps the control polygons of editable B-splines.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Controls`].
#[derive(Debug, Default)]
pub struct PolygonPlugin;

impl Plugin for PolygonPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        budget::configure(app);
        app.init_resource::<Workspaces>()
            .init_resource::<Drafts>()
            .add_observer(remove_polygon::<Editable>)
            .add_observer(remove_polygon::<SurfaceSpline>)
            .add_systems(PostUpdate, update_polygons.in_set(SurfaceSplineSystems::Controls));
    }
}

/// Polygons that are drawn in the background, at most one a spline.
#[derive(Resource, Default)]
struct Drafts {
    running: EntityHashMap<Task<Drawn>>,
    /// How long their searches take.
    pace: Pace,
}

/// A polygon to be drawn.
struct Draft {
    ends: Vec<[SurfacePoint; 2]>,
    surface: Arc<Surface>,
    known: Vec<Leg>,
    /// Modelled work of searching the legs that are not known.
    work: f64,
}

/// A polygon, the modelled work, and the seconds that it took.
type Drawn = (ControlPolygon, f64, f64);

impl Draft {
    fn new(spline: &Spline, surface: &BuiltSurface, known: Option<&ControlPolygon>) -> Self {
        let known = known.map_or(Vec::new(), |polygon| polygon.legs.clone());
        let ends: Vec<_> = ends(spline).collect();
        let missing = ends.iter().filter(|ends| !known.iter().any(|leg| leg.ends == **ends));
        let work = missing.map(|[from, to]| search_work(surface, *from, *to)).sum();
        Self { ends, surface: surface.0.clone(), known, work }
    }

    /// Whether a frame may draw it itself where that is expected to fit in: a search on a larger surface may take many times
    /// what was expected, and it cannot be stopped.
    fn is_safe(&self) -> bool {
        self.work == 0.0 || self.surface.face_count() <= SAFE_FACES
    }

    fn draw(&self, workspaces: &Workspaces) -> Drawn {
        let begin = Instant::now();
        let leg = |finder: &mut PathFinder, ends: &_| leg(&self.surface, finder, *ends, &self.known);
        let legs = workspaces.lend(|workspace| self.ends.iter().map(|e| leg(&mut workspace.finder, e)).collect());
        let polygon = ControlPolygon { legs, surface: Arc::downgrade(&self.surface) };
        (polygon, self.work, begin.elapsed().as_secs_f64())
    }
}

impl Drafts {
    /// Fetches a polygon that is done.
    fn collect(&mut self, entity: Entity) -> Option<ControlPolygon> {
        let (polygon, work, seconds) = block_on(future::poll_once(self.running.get_mut(&entity)?))?;
        self.running.remove(&entity);
        self.pace.learn(work, seconds);
        Some(polygon)
    }

    /// Draws a polygon if that takes less than some seconds, else begins to do so in the background.
    fn draw(&mut self, entity: Entity, draft: Draft, left: f64, workspaces: &Workspaces) -> Option<ControlPolygon> {
        if self.pace.expect(draft.work) <= left && (draft.is_safe() || left.is_infinite()) {
            let (polygon, work, seconds) = draft.draw(workspaces);
            self.pace.learn(work, seconds);
            return Some(polygon);
        }
        let (pool, workspaces) = (AsyncComputeTaskPool::get_or_init(TaskPool::default), workspaces.clone());
        self.running.insert(entity, pool.spawn(async move { draft.draw(&workspaces) }));
        None
    }
}

type Splines<'w, 's> = Query<
    'w,
    's,
    (Entity, &'static SurfaceSpline, &'static OnSurface, Option<&'static ControlPolygon>),
    With<Editable>,
>;

fn update_polygons(
    mut commands: Commands,
    mut drafts: ResMut<Drafts>,
    (budget, mut frame, workspaces): (Res<TraceBudget>, ResMut<FrameTime>, Res<Workspaces>),
    splines: Splines,
    surfaces: Query<&BuiltSurface>,
) {
    drafts.running.retain(|entity, _| splines.contains(*entity));
    for (entity, spline, on, old) in &splines {
        let built = surfaces.get(on.0).ok().filter(|_| spline.scheme().method.is_b_spline());
        let Some(built) = built else {
            drafts.running.remove(&entity);
            if old.is_some() {
                commands.entity(entity).try_remove::<ControlPolygon>();
            }
            continue;
        };
        let begin = Instant::now();
        let mut newer = drafts.collect(entity).filter(|polygon| polygon.is_on(built));
        let known = newer.as_ref().or(old).filter(|polygon| polygon.is_on(built));
        if !known.is_some_and(|polygon| polygon.is_of(spline)) && !drafts.running.contains_key(&entity) {
            let draft = Draft::new(spline, built, known);
            newer = drafts.draw(entity, draft, frame.left(&budget), &workspaces).or(newer);
            frame.spend(begin.elapsed());
        }
        match newer {
            Some(polygon) => drop(commands.entity(entity).try_insert(polygon)),
            None if old.is_some_and(|old| !old.is_on(built)) => {
                commands.entity(entity).try_remove::<ControlPolygon>();
            }
            None => {}
        }
    }
}

/// The ends of a control polygon's legs.
fn ends(spline: &Spline) -> impl Iterator<Item = [SurfacePoint; 2]> {
    let anchors = spline.anchors();
    let count = if spline.is_closed() { anchors.len() } else { anchors.len().saturating_sub(1) };
    (0..count).map(move |i| [anchors[i].point(), anchors[(i + 1) % anchors.len()].point()])
}

/// A leg; one that is known is not searched again.
fn leg(surface: &Surface, finder: &mut PathFinder, ends: [SurfacePoint; 2], known: &[Leg]) -> Leg {
    if let Some(same) = known.iter().find(|leg| leg.ends == ends) {
        return same.clone();
    }
    let path = finder.shortest(surface, &ends[0], &ends[1]);
    let positions = path.map(|path| path.positions(surface)).unwrap_or_default();
    Leg { ends, line: positions.iter().map(|p| p.as_vec3()).collect() }
}

/// A spline that is no longer edited shows no polygon.
fn remove_polygon<C: Component>(removed: On<Remove, C>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<ControlPolygon>();
    }
}
