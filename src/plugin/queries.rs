//! Asking surfaces in world space.

use bevy::ecs::system::SystemParam;
use bevy::log::warn_once;
use bevy::math::{Affine3A, Mat3A, Ray3d, Vec3A};
use bevy::prelude::*;
use glam::{DAffine3, DVec3};

use super::deformed::DeformedSurface;
use super::surface::BuiltSurface;
use crate::geodesic::{GeodesicPath, PathError, WalkStop};
use crate::surface::{PointError, Surface, SurfacePoint};

/// Axes may differ by this share before a scale counts as non-uniform.
const UNIFORM: f32 = 1e-3;

/// Surfaces as a system parameter: rays, closest points, paths and walks in world space.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_surface_splines::prelude::*;
/// fn shoot(surfaces: SurfaceQueries, planet: Single<Entity, With<SplineSurface>>) -> Result {
///     let Some(surface) = surfaces.get(*planet) else { return Ok(()) }; // none until it is ready
///     let Some(hit) = surface.ray(Ray3d::new(Vec3::Z * 5.0, Dir3::NEG_Z)) else { return Ok(()) };
///     let Some(goal) = surface.closest_point(Vec3::X) else { return Ok(()) };
///     let path = surface.shortest_path(hit.point, goal.point)?;
///     let there = surface.walk(hit.point, Vec3::Y, 0.5 * path.length())?;
///     info!("from {} to {}", hit.position, there.position);
///     Ok(())
/// }
/// ```
#[derive(SystemParam)]
pub struct SurfaceQueries<'w, 's> {
    surfaces:
        Query<'w, 's, (&'static BuiltSurface, Option<&'static GlobalTransform>, Option<&'static DeformedSurface>)>,
}

/// Why a surface cannot be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SurfaceQueryError {
    /// It does not exist or is not built yet.
    #[error("{0} has no built surface: wait for On<SurfaceReady>, or look at its SurfaceState")]
    NotReady(Entity),
    /// Its transform is not a rotation, translation and uniform scale.
    #[error(
        "{0} is scaled differently along its axes, so lengths on it have no one unit: scale the mesh itself \
         (Mesh::scaled_by) and make the transform's scale uniform"
    )]
    NonUniformScale(Entity),
}

impl SurfaceQueries<'_, '_> {
    /// The surface of an entity; none until it is ready, and none (with one line in the log) where its scale is not uniform.
    pub fn get(&self, entity: Entity) -> Option<SurfaceView<'_>> {
        match self.try_get(entity) {
            Ok(view) => Some(view),
            Err(error @ SurfaceQueryError::NonUniformScale(_)) => {
                warn_once!("{error}");
                None
            }
            Err(SurfaceQueryError::NotReady(_)) => None,
        }
    }

    /// The surface of an entity, or why there is none.
    ///
    /// # Errors
    /// [`SurfaceQueryError`], whose text names the remedy.
    pub fn try_get(&self, entity: Entity) -> Result<SurfaceView<'_>, SurfaceQueryError> {
        let (surface, transform, deformed) =
            self.surfaces.get(entity).map_err(|_| SurfaceQueryError::NotReady(entity))?;
        let to_world = transform.map_or(Affine3A::IDENTITY, GlobalTransform::affine);
        match deformed {
            Some(deformed) => Ok(SurfaceView::of_deformed(surface, to_world, deformed)),
            None => SurfaceView::new(surface, to_world).ok_or(SurfaceQueryError::NonUniformScale(entity)),
        }
    }
}

/// A surface where it stands in the world: takes and gives world positions and directions; lengths along it are in its
/// local unit.
///
/// Of a surface that joints or morph targets deform ([`DeformedSurface`]), positions, normals, directions, rays and nearest places are those of the
/// pose; paths and walks go by the mesh as it was made.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceView<'a> {
    surface: &'a Surface,
    deformed: Option<&'a DeformedSurface>,
    to_world: Affine3A,
    /// Not in single precision: a ray that grazes the surface would meet it elsewhere.
    from_world: DAffine3,
    scale: f32,
}

/// Where a ray meets a surface, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldHit {
    /// The place.
    pub point: SurfacePoint,
    /// Its position.
    pub position: Vec3,
    /// The unit normal of its face.
    pub normal: Vec3,
    /// Distance from the ray's origin.
    pub distance: f32,
}

/// A place on a surface and its distance from the position asked about, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldPlace {
    /// The place.
    pub point: SurfacePoint,
    /// Its position.
    pub position: Vec3,
    /// Its distance from the position asked about.
    pub distance: f32,
}

/// Where a walk led.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldWalk {
    /// The place at its end.
    pub point: SurfacePoint,
    /// The position there, in world space.
    pub position: Vec3,
    /// The direction there, in world space, of unit length.
    pub direction: Vec3,
    /// What ended the walk early, if anything did.
    pub stopped: Option<WalkStop>,
    /// The way that was walked; its length is in local units.
    pub path: GeodesicPath,
}

impl<'a> SurfaceView<'a> {
    /// A surface under a transform; none if that scales the axes differently or does not exist in numbers.
    pub fn new(surface: &'a Surface, to_world: Affine3A) -> Option<Self> {
        let scale = uniform_scale(&to_world.matrix3)?;
        Some(Self { surface, deformed: None, to_world, from_world: to_world.as_daffine3().inverse(), scale })
    }

    /// A surface that is deformed: the transform tells no more than about its size.
    fn of_deformed(surface: &'a Surface, to_world: Affine3A, deformed: &'a DeformedSurface) -> Self {
        let scale = uniform_scale(&to_world.matrix3).unwrap_or(1.0);
        Self { surface, deformed: Some(deformed), to_world, from_world: to_world.as_daffine3().inverse(), scale }
    }

    /// Whether joints or morph targets deform it, so that [`to_world`](Self::to_world) does not tell where it is.
    pub fn is_deformed(&self) -> bool {
        self.deformed.is_some()
    }

    /// The surface itself, which speaks local `f64`.
    pub fn surface(&self) -> &'a Surface {
        self.surface
    }

    /// From local to world space; of a deformed surface, the entity's transform.
    pub fn to_world(&self) -> Affine3A {
        self.to_world
    }

    /// World units a local unit.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Position of a point; NaN if it does not belong to this surface.
    pub fn position(&self, point: SurfacePoint) -> Vec3 {
        match self.deformed {
            Some(deformed) => deformed.position(&point),
            None => self.out(self.surface.position(&point)),
        }
    }

    /// Unit normal at a point; NaN if it does not belong to this surface.
    pub fn normal(&self, point: SurfacePoint) -> Vec3 {
        match self.deformed {
            Some(deformed) => deformed.normal(&point),
            None => self.direction_out(self.surface.normal(&point)),
        }
    }

    /// Where a position on the surface, in local space, is in the world. Of a deformed surface this costs a search, and a position that is
    /// off it counts as the nearest on it; `RidingCurve` is how curves are placed.
    pub(crate) fn seen(&self, local: Vec3) -> Vec3 {
        match self.deformed {
            Some(_) => {
                let found = self.surface.closest_point(local.as_dvec3());
                found.map_or(Vec3::NAN, |found| self.position(found.point))
            }
            None => self.to_world.transform_point3(local),
        }
    }

    /// The first place where a ray meets the surface, from either side.
    pub fn ray(&self, ray: Ray3d) -> Option<WorldHit> {
        if let Some(deformed) = self.deformed {
            let hit = deformed.ray(ray)?;
            let (position, normal) = (hit.position.as_vec3(), hit.normal.as_vec3());
            return Some(WorldHit { point: hit.point, position, normal, distance: hit.distance as f32 });
        }
        let origin = self.inward(ray.origin);
        let direction = self.from_world.transform_vector3(ray.direction.as_dvec3());
        let hit = self.surface.ray(origin, direction.normalize_or_zero())?;
        Some(WorldHit {
            point: hit.point,
            position: self.out(hit.position),
            normal: self.direction_out(hit.normal),
            distance: (hit.distance / direction.length()) as f32,
        })
    }

    /// The place nearest to a position; none for a position that is not finite.
    pub fn closest_point(&self, position: Vec3) -> Option<WorldPlace> {
        if let Some(deformed) = self.deformed {
            let found = deformed.closest_point(position)?;
            let (position, distance) = (found.position.as_vec3(), found.distance as f32);
            return Some(WorldPlace { point: found.point, position, distance });
        }
        let found = self.surface.closest_point(self.inward(position))?;
        let distance = found.distance as f32 * self.scale;
        Some(WorldPlace { point: found.point, position: self.out(found.position), distance })
    }

    /// A locally shortest path; for many, keep a [`PathFinder`](crate::geodesic::PathFinder) and ask
    /// [`surface`](Self::surface).
    ///
    /// # Errors
    /// [`PathError`] if the points lie on separate pieces or do not belong to the surface.
    pub fn shortest_path(&self, from: SurfacePoint, to: SurfacePoint) -> Result<GeodesicPath, PathError> {
        self.surface.shortest_path(&from, &to)
    }

    /// Walks straight ahead: `heading` is a direction in world space, of any length, projected to the tangent plane;
    /// `distance` is in local units.
    ///
    /// # Errors
    /// [`PointError`] if the point does not belong to the surface.
    pub fn walk(&self, from: SurfacePoint, heading: Vec3, distance: f64) -> Result<WorldWalk, PointError> {
        let heading = match self.deformed {
            Some(deformed) => deformed.with_posed(|posed| posed.direction_at_rest(from.face, heading.as_dvec3()))?,
            None => self.from_world.transform_vector3(heading.as_dvec3()),
        };
        let walk = self.surface.walk(&from, &self.surface.tangent(&from, heading)?, distance)?;
        let point = walk.path.end();
        let ahead = self.surface.tangent_in_space(&walk.heading)?;
        let direction = match self.deformed {
            Some(deformed) => {
                let ahead = deformed.with_posed(|posed| posed.direction_now(point.face, ahead))?;
                ahead.as_vec3().normalize_or_zero()
            }
            None => self.direction_out(ahead),
        };
        Ok(WorldWalk { point, position: self.position(point), direction, stopped: walk.stopped, path: walk.path })
    }

    fn out(&self, local: DVec3) -> Vec3 {
        self.to_world.transform_point3(local.as_vec3())
    }

    fn direction_out(&self, local: DVec3) -> Vec3 {
        let direction = self.to_world.transform_vector3(local.as_vec3());
        if direction.is_nan() { direction } else { direction.normalize_or_zero() }
    }

    fn inward(&self, world: Vec3) -> DVec3 {
        self.from_world.transform_point3(world.as_dvec3())
    }
}

/// The factor by which a matrix scales lengths, if it is the same in all directions.
fn uniform_scale(m: &Mat3A) -> Option<f32> {
    let lengths = Vec3A::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    let scale = lengths.element_sum() / 3.0;
    let shear = m.x_axis.dot(m.y_axis).abs().max(m.y_axis.dot(m.z_axis).abs()).max(m.z_axis.dot(m.x_axis).abs());
    let uniform = (lengths - scale).abs().max_element() <= UNIFORM * scale && shear <= UNIFORM * scale * scale;
    (uniform && scale > 0.0 && scale.is_finite()).then_some(scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_scales_are_told_from_others() {
        let of = |t: Transform| uniform_scale(&t.compute_affine().matrix3);
        let turn = Transform::from_rotation(Quat::from_euler(EulerRot::XYZ, 0.3, 1.0, -2.0));
        assert!((of(turn.with_scale(Vec3::splat(3.0))).unwrap() - 3.0).abs() < 1e-5);
        assert!(of(turn.with_scale(Vec3::new(-2.0, 2.0, 2.0))).is_some());
        assert!(of(turn.with_scale(Vec3::new(1.0, 1.1, 1.0))).is_none());
        assert!(of(turn.with_scale(Vec3::ZERO)).is_none());
        assert!(of(Transform::from_scale(Vec3::splat(f32::NAN))).is_none());
    }
}
