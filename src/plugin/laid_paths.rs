//! Painted paths laid onto surfaces.

use std::sync::Arc;

use bevy::camera::primitives::Aabb;
use bevy::log::warn;
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPool};
use glam::{DVec2, DVec3};

use super::drawing::Placement;
use super::paths::{BezierPaths, PathMesh, overwrite, set_bounds};
use super::surface::{BuiltSurface, OnSurface, SurfaceChanged};
use super::workspaces::Workspaces;
use crate::placement::{PlaneMap, PlanePoint, PlaneWalk};
use crate::surface::Surface;

/// How [`BezierPaths`] lie that have a [`Placement`] and are [`OnSurface`]: the plane is laid onto the surface by polar coordinates about the
/// placement's point, anew whenever control points or the placement change.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub enum LaidState {
    /// The surface is not ready.
    #[default]
    Pending,
    /// They lie on it.
    Ready {
        /// Vertices whose way from the placement's point leaves the surface: they are cut off at its boundary.
        off: u32,
        /// Shapes that are cut, or off the surface as a whole.
        clipped: u32,
    },
    /// They cannot be laid.
    Failed {
        /// Why, and what to do about it.
        reason: String,
    },
}

/// How far paths lie above their surface, as a share of its diagonal, so that it does not show through.
const LIFT: f64 = 1e-3;
type LaidPaths<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        Ref<'static, OnSurface>,
        Ref<'static, Placement>,
        &'static BezierPaths,
        &'static mut PathMesh,
        &'static mut Transform,
        Option<&'static mut LaidState>,
    ),
>;

/// Lays paths onto their surfaces.
pub(super) fn lay_paths(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut laid: LaidPaths,
    mut bounds: Query<&mut Aabb>,
    surfaces: Query<(&BuiltSurface, &GlobalTransform)>,
    walks: Res<Workspaces<PlaneWalk>>,
    mut lattice: Local<Lattice>,
) {
    for (entity, on, placement, paths, mut made, mut transform, state) in &mut laid {
        let mut state = state;
        let before = state.as_deref().filter(|state| matches!(state, LaidState::Failed { .. })).cloned();
        let mut set = |next: LaidState| match &mut state {
            Some(state) => drop(state.set_if_neq(next)),
            None => drop(commands.entity(entity).try_insert(next)),
        };
        let Ok((built, place)) = surfaces.get(on.0) else {
            set(LaidState::Pending);
            continue;
        };
        // It lies in the surface's local space.
        transform.set_if_neq(place.compute_transform());
        let surface: &Arc<Surface> = &built.0;
        let is_other = !std::ptr::eq(made.laid.surface.as_ptr(), Arc::as_ptr(surface));
        if !(made.laid.is_stale || is_other || placement.is_changed() || on.is_changed()) {
            continue;
        }
        made.laid.surface = Arc::downgrade(surface);
        made.laid.is_stale = false;
        let map = match PlaneMap::new(surface, &(*placement).into(), paths.picture().origin()) {
            Ok(map) => map,
            Err(error) => {
                let reason = error.to_string();
                let next = LaidState::Failed { reason: reason.clone() };
                if before.as_ref() != Some(&next) {
                    warn!("the paths {entity} cannot be laid onto their surface: {reason}");
                }
                set(next);
                continue;
            }
        };
        let (plane, spacing) = (made.triangles().positions.as_slice(), paths.picture().spacing());
        lattice.lay(&map, plane, spacing, LIFT * surface.diagonal(), &walks);
        let places = &lattice.places;
        let handle = made.own_mesh(&mut meshes);
        let Some(mut mesh) = meshes.get_mut(&handle) else { continue };
        let triangles = made.triangles();
        let is_on = |triangle: &&[u32]| triangle.iter().any(|i| places.get(*i as usize).is_some_and(|(_, off)| !off));
        let indices = triangles.indices.chunks_exact(3).filter(is_on).flatten().copied();
        overwrite(&mut mesh, places.iter().map(|(place, _)| *place), &triangles.colors, indices);
        let mut corners = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        for (place, _) in places.iter() {
            let place = Vec3::from_array(*place);
            corners = [corners[0].min(place), corners[1].max(place)];
        }
        let off = places.iter().filter(|(_, off)| *off).count() as u32;
        let is_cut = |shape: &usize| {
            off > 0 && places.get(triangles.vertices_of(*shape)).is_some_and(|all| all.iter().any(|(_, off)| *off))
        };
        let clipped = (0..paths.picture().shape_count()).filter(is_cut).count() as u32;
        set(LaidState::Ready { off, clipped });
        set_bounds(entity, (!places.is_empty()).then_some(corners), &mut bounds, &mut commands);
    }
}

/// Memory for laying.
#[derive(Default)]
pub(super) struct Lattice {
    /// Node by node, row after row.
    nodes: Vec<Node>,
    /// Those of them that are asked for.
    wanted: Vec<u32>,
    landed: Vec<Landed>,
    places: Vec<([f32; 3], bool)>,
}

/// Where a node came to lie.
#[derive(Clone, Copy, Default)]
struct Landed {
    position: DVec3,
    normal: DVec3,
    is_off: bool,
}

impl From<PlanePoint> for Landed {
    fn from(PlanePoint { position, normal, is_off, .. }: PlanePoint) -> Self {
        Self { position, normal, is_off }
    }
}

/// A node of the lattice, and which of those that landed it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Node {
    #[default]
    Unwanted,
    Wanted(u32),
}

/// Nodes that a task takes at a time.
const BATCH: usize = 64;
/// Nodes along the longer side of a picture at most.
const MOST_NODES: f64 = 128.0;

impl Lattice {
    /// Lays places onto a surface. Ways are walked to the nodes of a lattice about as wide as edges are long, and places between are interpolated, which is as
    /// near to the surface as the edges are. Where a node is off the surface, each place has a way of its own.
    fn lay(&mut self, map: &PlaneMap<'_>, plane: &[[f32; 3]], spacing: f32, lift: f64, walks: &Workspaces<PlaneWalk>) {
        let at = |p: &[f32; 3]| DVec2::new(f64::from(p[0]), f64::from(p[1]));
        let low = plane.iter().map(at).reduce(DVec2::min).unwrap_or_default();
        let size = plane.iter().map(at).reduce(DVec2::max).unwrap_or_default() - low;
        let cell = f64::from(spacing).min(size.max_element() / 32.0).max(size.max_element() / MOST_NODES);
        let cell = if cell > 0.0 { cell } else { 1.0 };
        let columns = (size.x / cell) as usize + 2;
        let rows = (size.y / cell) as usize + 2;
        let Self { nodes, wanted, landed, places } = self;
        nodes.clear();
        nodes.resize(columns * rows, Node::Unwanted);
        wanted.clear();
        // The lower left node of a place's cell, and where in the cell it is.
        let cell_of = |p: DVec2| {
            let within = (p - low) / cell;
            let (x, y) = ((within.x as usize).min(columns - 2), (within.y as usize).min(rows - 2));
            (y * columns + x, within - DVec2::new(x as f64, y as f64))
        };
        for place in plane {
            let (first, _) = cell_of(at(place));
            for node in [first, first + 1, first + columns, first + columns + 1] {
                if nodes[node] == Node::Unwanted {
                    nodes[node] = Node::Wanted(wanted.len() as u32);
                    wanted.push(node as u32);
                }
            }
        }
        let node_at =
            |node: u32| low + cell * DVec2::new((node as usize % columns) as f64, (node as usize / columns) as f64);
        landed.clear();
        landed.resize(wanted.len(), Landed::default());
        let some = |wanted: &[u32], landed: &mut [Landed]| {
            walks.lend(|walk| {
                wanted.iter().zip(landed).for_each(|(node, out)| *out = map.place(node_at(*node), walk).into());
            });
        };
        if wanted.len() <= BATCH {
            some(wanted, landed);
        } else {
            let some = &some;
            ComputeTaskPool::get_or_init(TaskPool::default).scope(|scope| {
                for (wanted, landed) in wanted.chunks(BATCH).zip(landed.chunks_mut(BATCH)) {
                    scope.spawn(async move { some(wanted, landed) });
                }
            });
        }
        let landing = |node: usize| match nodes[node] {
            Node::Wanted(number) => landed[number as usize],
            Node::Unwanted => Landed::default(),
        };
        places.clear();
        walks.lend(|walk| {
            places.extend(plane.iter().map(|place| {
                let (first, share) = cell_of(at(place));
                let corners = [first, first + 1, first + columns, first + columns + 1].map(landing);
                let above = lift + f64::from(place[2]);
                if corners.iter().any(|corner| corner.is_off) {
                    let own = map.place(at(place), walk);
                    return ((own.position + own.normal * above).as_vec3().to_array(), own.is_off);
                }
                let [a, b, c, d] = corners.map(|corner| corner.position + corner.normal * above);
                (a.lerp(b, share.x).lerp(c.lerp(d, share.x), share.y).as_vec3().to_array(), false)
            }));
        });
    }
}

/// Lets what is laid go along with its surface in the same frame, whatever carries it.
pub(super) fn follow_moving_surfaces(
    mut laid: Query<(&OnSurface, &mut GlobalTransform), (With<BezierPaths>, With<Placement>, Without<BuiltSurface>)>,
    surfaces: Query<&GlobalTransform, With<BuiltSurface>>,
) {
    for (on, mut own) in &mut laid {
        if let Ok(place) = surfaces.get(on.0) {
            own.set_if_neq(*place);
        }
    }
}

/// Paths that are laid no more lie in their plane again.
pub(super) fn leave_surface(
    removed: On<Remove, Placement>,
    mut commands: Commands,
    mut laid: Query<(&mut BezierPaths, &mut PathMesh)>,
) {
    if let Ok((mut paths, mut made)) = laid.get_mut(removed.entity) {
        made.forget();
        paths.set_changed();
    }
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<LaidState>();
    }
}

/// Moves placements to the nearest points of a surface that changed.
pub(super) fn follow_changed_surface(
    changed: On<SurfaceChanged>,
    surfaces: Query<&BuiltSurface>,
    mut placements: Query<(&mut Placement, &OnSurface), With<BezierPaths>>,
) {
    let Ok(built) = surfaces.get(changed.entity) else { return };
    for (mut placement, _) in placements.iter_mut().filter(|(_, on)| on.0 == changed.entity) {
        if let Some(nearest) = built.closest_point(changed.previous.position(&placement.at)) {
            placement.at = nearest.point;
        }
    }
}
