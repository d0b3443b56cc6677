//! Painted paths as meshes: made again only where control points moved.

use std::sync::{Arc, Weak};

use bevy::asset::{AssetEventSystems, RenderAssetUsages};
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{NoAutoAabb, VisibilitySystems};
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::CharacterSystems;
use super::drawing::Placement;
use super::laid_paths::{self, LaidState};
use super::workspaces::Workspaces;
use crate::placement::PlaneWalk;
use crate::surface::Surface;
use crate::vector::{Picture, PictureChange, PictureMesh, PicturePoints, Tessellator};

/// Paths of cubic Bézier segments with fills and strokes, planar or nearly so, shown as one mesh in the entity's own space.
///
/// A [`Picture`] says what is painted; it is shared by all that show it. Control points are moved by [`set_points`](Self::set_points) or by a
/// [`SplineSkin`](super::SplineSkin), and only shapes with paths that moved are tessellated again. The mesh, a `Mesh3d` with colours at its vertices,
/// is this entity's own: it is made when there is none, and bounds for culling are kept right. With the feature `render` it gets a material that
/// shows those colours without light, if it has none.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_surface_splines::{plugin::BezierPaths, vector::{Drawing, Picture, PictureOptions}};
/// fn show(mut commands: Commands, drawing: Drawing) {
///     let picture = Picture::of_drawing(&drawing, &PictureOptions::default());
///     // Drawings have y down.
///     commands.spawn((BezierPaths::new(picture), Transform::from_scale(Vec3::new(1.0, -1.0, 1.0))));
/// }
/// ```
#[derive(Component, Clone, Debug)]
#[require(Transform, Visibility, PathMesh)]
pub struct BezierPaths {
    picture: Arc<Picture>,
    points: PicturePoints,
}

impl BezierPaths {
    /// The paths of a picture, as they were drawn.
    pub fn new(picture: impl Into<Arc<Picture>>) -> Self {
        let picture = picture.into();
        Self { points: picture.points(), picture }
    }

    /// What is painted.
    pub fn picture(&self) -> &Arc<Picture> {
        &self.picture
    }

    /// The control points of a path as they are now; empty if there is no such path.
    pub fn points_of(&self, path: usize) -> &[Vec3] {
        self.points.of(path)
    }

    /// Moves the control points of a path; whether one was elsewhere before. What is missing, too much or not finite stays as it is.
    pub fn set_points(&mut self, path: usize, points: impl IntoIterator<Item = Vec3>) -> bool {
        self.points.set(path, points)
    }

    /// How often a path moved, which is how often it was tessellated again (once a frame at most).
    pub fn moved(&self, path: usize) -> u32 {
        self.points.moved(path)
    }
}

/// The triangles of an entity's paths.
#[derive(Component, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub(super) struct PathMesh {
    triangles: PictureMesh,
    /// What they were made of.
    picture: Option<Arc<Picture>>,
    /// The asset, which is no other entity's.
    mesh: Option<Handle<Mesh>>,
    /// Whether the lists of the mesh are in `triangles` at the moment, which they are while it is made.
    is_lent: bool,
    must_make: bool,
    change: PictureChange,
    /// What is laid onto a surface.
    pub(super) laid: Laid,
}

/// A mesh that is laid onto a surface: triangles stay in their plane, and the asset has them as they lie.
#[derive(Debug, Default)]
pub(super) struct Laid {
    /// Whether triangles changed since they were last laid.
    pub(super) is_stale: bool,
    pub(super) surface: Weak<Surface>,
}

impl PathMesh {
    /// Makes it forget where it lies, so that all is made again.
    pub(super) fn forget(&mut self) {
        (self.picture, self.laid) = (None, Laid::default());
    }

    pub(super) fn triangles(&self) -> &PictureMesh {
        &self.triangles
    }

    /// Its asset and the lists of it, to be filled.
    pub(super) fn own_mesh(&mut self, meshes: &mut Assets<Mesh>) -> Handle<Mesh> {
        self.mesh.get_or_insert_with(|| meshes.add(empty_mesh())).clone()
    }
}

/// What tessellating cost in the last frame.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct PathStatistics {
    /// Entities whose mesh changed.
    pub meshes: u32,
    /// What was made again, of all of them.
    pub made: PictureChange,
    /// Time, in milliseconds.
    pub milliseconds: f64,
}

/// Makes meshes of [`BezierPaths`].
///
/// Schedule: `PostUpdate`, set [`CharacterSystems::Tessellate`]. Needs `Mesh` assets.
#[derive(Debug, Default)]
pub struct PathPlugin;

impl Plugin for PathPlugin {
    fn build(&self, app: &mut App) {
        super::character_systems::configure(app);
        app.register_type::<PathStatistics>()
            .init_resource::<PathStatistics>()
            .register_type::<LaidState>()
            .init_resource::<Workspaces<Tessellator>>()
            .init_resource::<Workspaces<PlaneWalk>>()
            .add_observer(laid_paths::follow_changed_surface)
            .add_observer(laid_paths::leave_surface)
            .add_observer(drop_paths)
            .add_systems(
                PostUpdate,
                (tessellate_paths, laid_paths::lay_paths)
                    .chain()
                    .in_set(CharacterSystems::Tessellate)
                    .before(AssetEventSystems)
                    .before(VisibilitySystems::CalculateBounds)
                    .run_if(resource_exists::<Assets<Mesh>>),
            );
        app.add_systems(
            PostUpdate,
            laid_paths::follow_moving_surfaces
                .after(TransformSystems::Propagate)
                .before(VisibilitySystems::CheckVisibility),
        );
        #[cfg(feature = "render")]
        material::build(app);
    }
}

type Moved<'w, 's> = Query<
    'w,
    's,
    (Entity, &'static BezierPaths, &'static mut PathMesh, Option<&'static Mesh3d>, Has<Placement>),
    Or<(Changed<BezierPaths>, Added<Placement>)>,
>;

/// Fewer meshes than this are made one after the other: sharing them out takes memory and time.
const SHARED_FROM: usize = 2;

fn tessellate_paths(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut statistics: ResMut<PathStatistics>,
    mut paths: Moved,
    mut bounds: Query<&mut Aabb>,
    tessellators: Res<Workspaces<Tessellator>>,
) {
    let begin = Instant::now();
    let mut count = 0;
    for (entity, paths, mut made, shown, is_laid) in &mut paths {
        let is_other = made.picture.as_ref().is_none_or(|picture| !Arc::ptr_eq(picture, &paths.picture));
        // The lists of a mesh that lay in its plane are in the asset.
        if is_other || is_laid && made.triangles.positions.is_empty() {
            made.picture = Some(paths.picture.clone());
            made.triangles = PictureMesh::default();
        } else if made.triangles.is_current(&paths.points) {
            continue;
        }
        made.must_make = true;
        count += 1;
        let handle = made.own_mesh(&mut meshes);
        if shown.is_none_or(|shown| shown.0 != handle) {
            let mut shown = commands.entity(entity);
            // Bounds that a clone brought are set below, before this is carried out.
            shown.try_insert((Mesh3d(handle.clone()), NoAutoAabb)).try_insert_if_new(Aabb::default());
        }
        if !is_laid && let Some(mut mesh) = meshes.get_mut(&handle) {
            lend(&mut mesh, &mut made.triangles);
            made.is_lent = true;
        }
    }
    let make = |paths: &BezierPaths, made: &mut PathMesh| {
        if std::mem::take(&mut made.must_make) {
            let mut work = |tessellator: &mut Tessellator| {
                made.change = made.triangles.update(&paths.picture, &paths.points, tessellator);
            };
            tessellators.lend(&mut work);
            made.laid.is_stale = true;
        }
    };
    if count < SHARED_FROM {
        paths.iter_mut().for_each(|(_, paths, mut made, ..)| make(paths, &mut made));
    } else {
        paths.par_iter_mut().for_each(|(_, paths, mut made, ..)| make(paths, &mut made));
    }
    let mut now = PathStatistics::default();
    for (entity, _, mut made, ..) in &mut paths {
        let change = std::mem::take(&mut made.change);
        if change != PictureChange::default() {
            now.meshes += 1;
            now.made += change;
        }
        if !std::mem::take(&mut made.is_lent) {
            continue;
        }
        set_bounds(entity, made.triangles.bounds(), &mut bounds, &mut commands);
        if let Some(mut mesh) = made.mesh.clone().and_then(|handle| meshes.get_mut(&handle)) {
            give_back(&mut mesh, &mut made.triangles);
        }
    }
    if now.meshes > 0 {
        now.milliseconds = begin.elapsed().as_secs_f64() * 1e3;
    }
    statistics.set_if_neq(now);
}

/// Takes what was shown from an entity that has no paths any more.
fn drop_paths(removed: On<Remove, BezierPaths>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<(PathMesh, Mesh3d, Aabb, NoAutoAabb, LaidState)>();
    }
}

/// Bounds for culling.
pub(super) fn set_bounds(
    entity: Entity,
    bounds: Option<[Vec3; 2]>,
    known: &mut Query<&mut Aabb>,
    commands: &mut Commands,
) {
    let [low, high] = bounds.unwrap_or_default();
    let aabb = Aabb::from_min_max(low, high);
    match known.get_mut(entity) {
        Ok(mut known) => drop(known.set_if_neq(aabb)),
        // It is on its way.
        Err(_) => drop(commands.entity(entity).try_insert((aabb, NoAutoAabb))),
    }
}

fn empty_mesh() -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
}

/// Overwrites the lists of a mesh in the memory that they have.
pub(super) fn overwrite(
    mesh: &mut Mesh,
    positions: impl Iterator<Item = [f32; 3]>,
    colors: &[[f32; 4]],
    indices: impl Iterator<Item = u32>,
) {
    let mut own = PictureMesh::default();
    lend(mesh, &mut own);
    own.positions.clear();
    own.positions.extend(positions);
    own.colors.clear();
    own.colors.extend_from_slice(colors);
    own.indices.clear();
    own.indices.extend(indices);
    give_back(mesh, &mut own);
}

/// Lends the lists of a mesh. What somebody else did to it is undone when they are given back.
fn lend(mesh: &mut Mesh, triangles: &mut PictureMesh) {
    if let Ok(VertexAttributeValues::Float32x3(own)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION) {
        triangles.positions = std::mem::take(own);
    }
    if let Ok(VertexAttributeValues::Float32x4(own)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_COLOR) {
        triangles.colors = std::mem::take(own);
    }
    if let Ok(Indices::U32(own)) = mesh.try_indices_mut() {
        triangles.indices = std::mem::take(own);
    }
}

/// Gives lists back.
pub(super) fn give_back(mesh: &mut Mesh, triangles: &mut PictureMesh) {
    let PictureMesh { positions, colors, indices, .. } = triangles;
    fill(mesh, std::mem::take(positions), std::mem::take(colors), std::mem::take(indices));
}

/// Gives lists to a mesh.
fn fill(mesh: &mut Mesh, mut positions: Vec<[f32; 3]>, mut colors: Vec<[f32; 4]>, mut indices: Vec<u32>) {
    if indices.is_empty() {
        // Renderers want something to draw, even if it has no extent.
        positions.push([0.0; 3]);
        colors.push([0.0; 4]);
        indices.extend([0; 3]);
    }
    // They fail only for meshes that are in the render world alone, which this one is not.
    let _ = mesh.try_insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    let _ = mesh.try_insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
    let _ = mesh.try_insert_indices(Indices::U32(indices));
}

/// Materials, for those who render.
#[cfg(feature = "render")]
mod material {
    use super::*;

    /// The material of all that has none of its own.
    #[derive(Resource)]
    struct PathMaterial(Handle<StandardMaterial>);

    pub(super) fn build(app: &mut App) {
        app.add_systems(
            PostUpdate,
            give_materials.in_set(CharacterSystems::Tessellate).run_if(resource_exists::<Assets<StandardMaterial>>),
        );
    }

    fn give_materials(
        mut commands: Commands,
        mut materials: ResMut<Assets<StandardMaterial>>,
        shared: Option<Res<PathMaterial>>,
        bare: Query<Entity, (With<BezierPaths>, Without<MeshMaterial3d<StandardMaterial>>)>,
    ) {
        if bare.is_empty() {
            return;
        }
        let material = shared.map(|shared| shared.0.clone()).unwrap_or_else(|| {
            // It blends and writes no depth, so that shapes of one mesh cover one another in their order.
            let material = materials.add(StandardMaterial {
                unlit: true,
                alpha_mode: AlphaMode::Blend,
                cull_mode: None,
                double_sided: true,
                ..default()
            });
            commands.insert_resource(PathMaterial(material.clone()));
            material
        });
        for entity in &bare {
            commands.entity(entity).try_insert(MeshMaterial3d(material.clone()));
        }
    }
}
