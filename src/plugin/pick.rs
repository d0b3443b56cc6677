//! Picking: surfaces by their BVH, control points, curves and lines by their distance on the screen.

use bevy::camera::RenderTarget;
use bevy::ecs::system::SystemParam;
use bevy::math::{Affine3A, Ray3d};
use bevy::picking::PickingSystems;
use bevy::picking::backend::ray::RayMap;
use bevy::picking::backend::{HitData, PointerHits};
use bevy::picking::pointer::{Location, PointerId, PointerLocation};
use bevy::prelude::*;
use bevy::window::PrimaryWindow;

use super::controls::{ControlKind, ControlPoint, Editable};
use super::queries::{SurfaceQueries, SurfaceView, WorldHit};
use super::riding::RidingCurve;
use super::smoothed_line::{LinePlace, SmoothedLine};
use super::spline::SurfaceSpline;
use super::surface::{BuiltSurface, OnSurface};
use super::trace::SplineTrace;
use crate::curve::{HandleSide, SplineT};
use crate::surface::SurfacePoint;

/// Something counts as behind the model if that is nearer to the eye by more than this share of the model's diagonal.
const BEHIND: f32 = 2e-3;

/// How control points, curves and lines are grabbed.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct SplinePickingSettings {
    /// How near the pointer must be, in logical pixels.
    pub grab_radius: f32,
    /// Whether things behind a surface can be grabbed.
    pub see_through: bool,
    /// The control point, by spline and kind, that is grabbed before all others that are near enough.
    pub preferred: Option<(Entity, ControlKind)>,
}

impl Default for SplinePickingSettings {
    fn default() -> Self {
        Self { grab_radius: 12.0, see_through: false, preferred: None }
    }
}

/// Extra data of a hit on a surface: `hit.extra_as::<SurfaceHit>()`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// The place: face and barycentric weights.
    pub point: SurfacePoint,
}

/// Extra data of a hit on a spline: `hit.extra_as::<CurveHit>()`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveHit {
    /// The parameter.
    pub t: SplineT,
    /// The place.
    pub point: SurfacePoint,
}

/// Extra data of a hit on a line: `hit.extra_as::<LineHit>()`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineHit {
    /// Length along its [`SmoothedLine`] from its start, in local units.
    pub distance: f64,
    /// The place.
    pub point: SurfacePoint,
}

/// A picking back end for surfaces, control points, and splines and lines with [`Editable`] or `Pickable`.
///
/// Handles come before anchors, these before curves and lines, these before surfaces (by the order of `PointerHits`: + 0.3, + 0.2, + 0.1
/// above the camera's); among equals the nearer to the eye.
///
/// Schedule: `PreUpdate`, set `PickingSystems::Backend`. Needs Bevy's `PickingPlugin`; without it nothing runs.
#[derive(Debug, Default)]
pub struct PickPlugin;

impl Plugin for PickPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_type::<SplinePickingSettings>()
            .init_resource::<SplinePickingSettings>()
            .add_message::<PointerHits>()
            .add_systems(PreUpdate, write_hits.in_set(PickingSystems::Backend).run_if(resource_exists::<RayMap>));
    }
}

/// What is under a pixel, as a system parameter.
#[derive(SystemParam)]
pub struct Picker<'w, 's> {
    settings: Res<'w, SplinePickingSettings>,
    cameras: Query<'w, 's, (Entity, &'static Camera, &'static RenderTarget, &'static GlobalTransform)>,
    primary_window: Query<'w, 's, Entity, With<PrimaryWindow>>,
    queries: SurfaceQueries<'w, 's>,
    surfaces: Query<'w, 's, Entity, With<BuiltSurface>>,
    built: Query<'w, 's, &'static BuiltSurface>,
    controls: Query<'w, 's, (Entity, &'static ControlPoint)>,
    splines: Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>,
    curves: Query<
        'w,
        's,
        (Entity, &'static SplineTrace, &'static OnSurface, Option<&'static RidingCurve>),
        Or<(With<Editable>, With<Pickable>)>,
    >,
    lines: Query<'w, 's, (Entity, &'static SmoothedLine, &'static OnSurface), Or<(With<Editable>, With<Pickable>)>>,
}

/// Something that is near enough to a pixel to be grabbed.
struct Grab {
    entity: Entity,
    kind: GrabKind,
    position: Vec3,
    depth: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum GrabKind {
    Curve,
    Anchor,
    Handle,
}

impl Picker<'_, '_> {
    /// The active cameras that show a location, topmost first.
    pub fn cameras_at(&self, location: &Location) -> Vec<Entity> {
        let shows = |camera: &Camera, target| location.is_in_viewport(camera, target, &self.primary_window);
        let active = self.cameras.iter().filter(|(_, camera, target, _)| camera.is_active && shows(camera, target));
        let mut found: Vec<_> = active.map(|(entity, camera, ..)| (std::cmp::Reverse(camera.order), entity)).collect();
        found.sort();
        found.into_iter().map(|(_, entity)| entity).collect()
    }

    /// Where the surface of an entity is under a pixel (logical, of the camera's target).
    pub fn surface_under(&self, camera: Entity, pixel: Vec2, surface: Entity) -> Option<WorldHit> {
        self.queries.get(surface)?.ray(self.ray(camera, pixel)?)
    }

    /// The surface that is nearest to the eye under a pixel, and where.
    pub fn nearest_surface_under(&self, camera: Entity, pixel: Vec2) -> Option<(Entity, WorldHit)> {
        let ray = self.ray(camera, pixel)?;
        let hits = self.surfaces.iter().filter_map(|entity| Some((entity, self.queries.get(entity)?.ray(ray)?)));
        hits.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))
    }

    /// The control point that a press at a pixel grabs: the one that is preferred ([`SplinePickingSettings::preferred`]), if it is
    /// there, or else the first of [`controls_under`](Self::controls_under).
    pub fn control_under(&self, camera: Entity, pixel: Vec2) -> Option<Entity> {
        let grabs = self.controls_under(camera, pixel);
        let is_preferred = |entity: &&Entity| {
            let control = self.controls.get(**entity).ok().map(|(_, control)| (control.spline, control.kind));
            control.is_some() && control == self.settings.preferred
        };
        grabs.iter().find(is_preferred).or(grabs.first()).copied()
    }

    /// All control points near a pixel: handles before anchors, and of those the nearest to the eye first.
    pub fn controls_under(&self, camera: Entity, pixel: Vec2) -> Vec<Entity> {
        let Some(eye) = Eye::new(self, camera) else { return Vec::new() };
        let mut grabs = self.grabbed_controls(&eye, pixel);
        grabs.sort_by(|a, b| b.kind.cmp(&a.kind).then(a.depth.total_cmp(&b.depth)).then(a.entity.cmp(&b.entity)));
        grabs.into_iter().map(|grab| grab.entity).collect()
    }

    /// All curves that can be picked near a pixel, the nearest to the eye first.
    pub fn curves_under(&self, camera: Entity, pixel: Vec2) -> Vec<(Entity, CurveHit)> {
        let Some(eye) = Eye::new(self, camera) else { return Vec::new() };
        let mut grabs = self.grabbed_curves(&eye, pixel);
        // Of equals the older first: which one must not depend on what else they are.
        grabs.sort_by(|a, b| a.0.depth.total_cmp(&b.0.depth).then(a.0.entity.cmp(&b.0.entity)));
        grabs.into_iter().map(|(grab, hit)| (grab.entity, hit)).collect()
    }

    /// All lines that can be picked near a pixel, the nearest to the eye first.
    pub fn lines_under(&self, camera: Entity, pixel: Vec2) -> Vec<(Entity, LineHit)> {
        let Some(eye) = Eye::new(self, camera) else { return Vec::new() };
        let mut grabs = self.grabbed_lines(&eye, pixel);
        grabs.sort_by(|a, b| a.0.depth.total_cmp(&b.0.depth).then(a.0.entity.cmp(&b.0.entity)));
        grabs.into_iter().map(|(grab, hit)| (grab.entity, hit)).collect()
    }

    /// The anchors of splines that can be picked, as far as they are seen in a part of the window (logical pixels): each with
    /// its spline.
    pub fn anchors_in(&self, camera: Entity, part: Rect) -> Vec<(Entity, u32)> {
        let Some(eye) = Eye::new(self, camera) else { return Vec::new() };
        let mut found = Vec::new();
        for (entity, ..) in &self.curves {
            let Some((spline, view)) =
                self.splines.get(entity).ok().and_then(|(s, on)| Some((s, self.queries.get(on.0)?)))
            else {
                continue;
            };
            for (index, anchor) in (0..).zip(spline.anchors()) {
                let position = view.position(anchor.point());
                let inside = eye.pixel(position).is_some_and(|at| part.contains(at));
                if inside && self.visible_depth(&eye, position).is_some() {
                    found.push((entity, index));
                }
            }
        }
        found
    }

    /// The pixel at which a control point appears.
    pub fn control_on_screen(&self, camera: Entity, control: Entity) -> Option<Vec2> {
        let (_, control) = self.controls.get(control).ok()?;
        Eye::new(self, camera)?.pixel(self.control_position(control)?)
    }

    fn ray(&self, camera: Entity, pixel: Vec2) -> Option<Ray3d> {
        let (_, camera, _, transform) = self.cameras.get(camera).ok()?;
        camera.viewport_to_world(transform, pixel).ok()
    }

    fn control_position(&self, control: &ControlPoint) -> Option<Vec3> {
        let (spline, on) = self.splines.get(control.spline).ok()?;
        Some(self.queries.get(on.0)?.position(control.kind.point(spline)?))
    }

    /// Whether a handle has no length: it lies on its anchor, which is what one means to grab there.
    fn is_retracted(&self, control: &ControlPoint) -> bool {
        let ControlKind::Handle(anchor, side) = control.kind else { return false };
        let Ok((spline, _)) = self.splines.get(control.spline) else { return false };
        spline.anchors().get(anchor as usize).is_some_and(|anchor| {
            let handle = if side == HandleSide::Incoming { anchor.incoming() } else { anchor.outgoing() };
            handle.leg().length() == 0.0
        })
    }

    fn grabbed_controls(&self, eye: &Eye, pixel: Vec2) -> Vec<Grab> {
        let mut grabs = Vec::new();
        for (entity, control) in self.controls.iter().filter(|(_, control)| !self.is_retracted(control)) {
            let Some(position) = self.control_position(control) else { continue };
            let near = eye.pixel(position).is_some_and(|at| at.distance(pixel) <= self.settings.grab_radius);
            if near && let Some(depth) = self.visible_depth(eye, position) {
                let handle = matches!(control.kind, ControlKind::Handle(..));
                let kind = if handle { GrabKind::Handle } else { GrabKind::Anchor };
                grabs.push(Grab { entity, kind, position, depth });
            }
        }
        grabs
    }

    fn grabbed_curves(&self, eye: &Eye, pixel: Vec2) -> Vec<(Grab, CurveHit)> {
        let mut grabs = Vec::new();
        for (entity, trace, on, riding) in &self.curves {
            let Some(view) = self.queries.get(on.0) else { continue };
            let found = match riding {
                // Where it was traced, the curve has the same places in the same order.
                Some(riding) => eye
                    .nearest_on(riding.pieces(), Affine3A::IDENTITY, pixel, self.settings.grab_radius)
                    .and_then(|world| riding.at_rest(world, trace.polyline())),
                None => self.near(eye, pixel, &view, trace.bounds(), trace.pieces()),
            };
            let Some(local) = found else { continue };
            let Some(nearest) = trace.nearest(view.surface(), local.as_dvec3()) else { continue };
            let position = view.position(nearest.point);
            if let Some(depth) = self.visible_depth(eye, position) {
                let hit = CurveHit { t: nearest.t, point: nearest.point };
                grabs.push((Grab { entity, kind: GrabKind::Curve, position, depth }, hit));
            }
        }
        grabs
    }

    fn grabbed_lines(&self, eye: &Eye, pixel: Vec2) -> Vec<(Grab, LineHit)> {
        let mut grabs = Vec::new();
        for (entity, line, on) in &self.lines {
            let (Some(view), Ok(built)) = (self.queries.get(on.0), self.built.get(on.0)) else { continue };
            let found = self.near(eye, pixel, &view, line.bounds(), std::iter::once(line.polyline()));
            let Some(LinePlace { distance, point }) = found.and_then(|local| line.nearest(built, local)) else {
                continue;
            };
            let position = view.position(point);
            if let Some(depth) = self.visible_depth(eye, position) {
                grabs.push((Grab { entity, kind: GrabKind::Curve, position, depth }, LineHit { distance, point }));
            }
        }
        grabs
    }

    /// The position (local) on some polylines in a sphere (local) that appears nearest to a pixel, if it can be grabbed there.
    fn near<'p>(
        &self,
        eye: &Eye,
        pixel: Vec2,
        view: &SurfaceView,
        (centre, radius): (Vec3, f32),
        polylines: impl Iterator<Item = &'p [Vec3]>,
    ) -> Option<Vec3> {
        let (centre, within) = (view.to_world().transform_point3(centre), self.settings.grab_radius);
        let may_be = eye.may_see(centre, view.scale() * radius, pixel, within);
        may_be.then(|| eye.nearest_on(polylines, view.to_world(), pixel, within))?
    }

    /// Distance from the near plane to a position, unless a surface hides it.
    fn visible_depth(&self, eye: &Eye, position: Vec3) -> Option<f32> {
        let ray = eye.camera.viewport_to_world(eye.transform, eye.pixel(position)?).ok()?;
        let depth = ray.origin.distance(position);
        let hides = |surface: Entity| {
            let Some(view) = self.queries.get(surface) else { return false };
            let slack = BEHIND * view.surface().diagonal() as f32 * view.scale();
            view.ray(ray).is_some_and(|hit| hit.distance < depth - slack)
        };
        (self.settings.see_through || !self.surfaces.iter().any(hides)).then_some(depth)
    }
}

/// A camera and how it projects.
struct Eye<'a> {
    camera: &'a Camera,
    transform: &'a GlobalTransform,
    clip_from_world: Mat4,
    viewport: Rect,
}

impl<'a> Eye<'a> {
    fn new(picker: &'a Picker, camera: Entity) -> Option<Self> {
        let (_, camera, _, transform) = picker.cameras.get(camera).ok()?;
        let clip_from_world = camera.clip_from_view() * transform.to_matrix().inverse();
        Some(Self { camera, transform, clip_from_world, viewport: camera.logical_viewport_rect()? })
    }

    /// Where a position appears; none behind the eye.
    fn pixel(&self, position: Vec3) -> Option<Vec2> {
        self.project(&self.clip_from_world, position)
    }

    fn project(&self, clip: &Mat4, position: Vec3) -> Option<Vec2> {
        let at = *clip * position.extend(1.0);
        let ndc = at.truncate() / at.w;
        let share = Vec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
        (at.w > 0.0 && (0.0..=1.0).contains(&ndc.z)).then(|| self.viewport.min + share * self.viewport.size())
    }

    /// Whether something in a sphere may appear within some pixels of a pixel. Never wrong by no.
    fn may_see(&self, centre: Vec3, radius: f32, pixel: Vec2, within: f32) -> bool {
        let ray = |pixel| self.camera.viewport_to_world(self.transform, pixel).ok();
        let (Some(middle), Some(edge)) = (ray(pixel), ray(pixel + Vec2::X * 1.5 * within)) else { return true };
        let along = (centre - middle.origin).dot(*middle.direction);
        // How far the rays are apart where the sphere ends.
        let far = (along + radius).max(0.0);
        let apart = middle.get_point(far).distance(edge.get_point(far));
        middle.get_point(along).distance(centre) <= radius + apart
    }

    /// The position (local) on some polylines that appears nearest to a pixel, if it is within a radius.
    fn nearest_on<'p>(
        &self,
        polylines: impl Iterator<Item = &'p [Vec3]>,
        to_world: Affine3A,
        pixel: Vec2,
        radius: f32,
    ) -> Option<Vec3> {
        let clip = self.clip_from_world * Mat4::from(to_world);
        let mut best = (radius, None);
        for polyline in polylines {
            let mut before: Option<(Vec3, Vec2)> = None;
            for &position in polyline {
                let at = self.project(&clip, position);
                if let (Some((a, from)), Some(to)) = (before, at) {
                    let way = to - from;
                    let share = ((pixel - from).dot(way) / way.length_squared().max(1e-12)).clamp(0.0, 1.0);
                    let distance = pixel.distance(from + share * way);
                    if distance <= best.0 {
                        best = (distance, Some(a.lerp(position, share)));
                    }
                }
                before = at.map(|at| (position, at));
            }
        }
        best.1
    }
}

fn write_hits(
    rays: Res<RayMap>,
    pointers: Query<(&PointerId, &PointerLocation)>,
    picker: Picker,
    mut out: MessageWriter<PointerHits>,
) {
    for (id, ray) in rays.iter() {
        let Some(eye) = Eye::new(&picker, id.camera) else { continue };
        let order = eye.camera.order as f32;
        let hits = |entity, depth, position: Vec3, normal, extra: Extra| {
            let (position, camera) = (Some(position), id.camera);
            let data = match extra {
                Extra::Surface(hit) => HitData::new_with_extra(camera, depth, position, normal, hit),
                Extra::Curve(hit) => HitData::new_with_extra(camera, depth, position, normal, hit),
                Extra::Line(hit) => HitData::new_with_extra(camera, depth, position, normal, hit),
                Extra::None => HitData::new(camera, depth, position, normal),
            };
            (entity, data)
        };
        let mut surfaces = Vec::new();
        for entity in &picker.surfaces {
            let Some(hit) = picker.queries.get(entity).and_then(|view| view.ray(*ray)) else { continue };
            let extra = Extra::Surface(SurfaceHit { point: hit.point });
            surfaces.push(hits(entity, hit.distance, hit.position, Some(hit.normal), extra));
        }
        let mut layers = [(order, surfaces), (order + 0.1, vec![]), (order + 0.2, vec![]), (order + 0.3, vec![])];
        let pixel = pointers.iter().find(|(p, _)| **p == id.pointer).and_then(|(_, at)| at.location());
        if let Some(pixel) = pixel.map(|location| location.position) {
            for (grab, hit) in picker.grabbed_curves(&eye, pixel) {
                layers[1].1.push(hits(grab.entity, grab.depth, grab.position, None, Extra::Curve(hit)));
            }
            for (grab, hit) in picker.grabbed_lines(&eye, pixel) {
                layers[1].1.push(hits(grab.entity, grab.depth, grab.position, None, Extra::Line(hit)));
            }
            for grab in picker.grabbed_controls(&eye, pixel) {
                let layer = if grab.kind == GrabKind::Handle { 3 } else { 2 };
                layers[layer].1.push(hits(grab.entity, grab.depth, grab.position, None, Extra::None));
            }
        }
        for (order, picks) in layers.into_iter().filter(|(_, picks)| !picks.is_empty()) {
            out.write(PointerHits::new(id.pointer, picks, order));
        }
    }
}

/// What a hit carries besides its position.
enum Extra {
    None,
    Surface(SurfaceHit),
    Curve(CurveHit),
    Line(LineHit),
}
