//! The orbit camera. The model fits the unit sphere, so that distances need no other measure.
//!
//! Middle drag, or Alt and left drag, orbits about the point under the pointer; Shift and middle drag pans; the wheel zooms to the
//! pointer. On a touchpad two fingers orbit, with Shift they pan, and a pinch zooms. F frames, 1, 3, 7 look along the axes, and 5
//! takes perspective away or gives it back. Nothing starts while the pointer is on a panel.

use bevy::camera::ScalingMode;
use bevy::input::gestures::PinchGesture;
use bevy::input::mouse::{AccumulatedMouseScroll, MouseScrollUnit};
use bevy::prelude::*;
use bevy::window::{CursorMoved, PrimaryWindow};

use super::input::{FreeView, Modifiers, NumberExpected, PanelInput, keyboard_is_free};
use super::model::{Model, ModelOpened};
use super::selection::Selection;
use super::tools::TakesWheel;
use crate::format::document::View;
use crate::plugin::{OnSurface, SplineTrace, SurfaceQueries};

const RADIANS_PER_PIXEL: f32 = 0.007;
/// How much nearer one notch of the wheel brings what is under the pointer.
const NOTCH: f32 = 0.86;
/// How much of the way two fingers make the camera turns.
const FINGERS: f32 = 0.6;
/// The angle of view of the perspective camera, from bottom to top.
pub(crate) const FIELD_OF_VIEW: f32 = 0.6;
const NEAREST: f32 = 0.01;
const FARTHEST: f32 = 15.0;
/// How far away a camera without perspective stands.
const ORTHOGRAPHIC_DISTANCE: f32 = 40.0;

/// A turntable camera.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(Camera3d, Projection = perspective())]
pub struct Orbit {
    /// About the vertical, and up from the horizon, in radians.
    pub(crate) yaw: f32,
    pub(crate) pitch: f32,
    /// What the camera turns about, pans with and frames.
    pub(crate) pivot: Vec3,
    gesture: Gesture,
    /// Whether the view is to be set up anew, about this centre and of this radius.
    framing: Option<(Vec3, f32)>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Gesture {
    #[default]
    None,
    Orbit(MouseButton),
    Pan,
}

impl Default for Orbit {
    fn default() -> Self {
        let (pivot, gesture) = (Vec3::ZERO, Gesture::None);
        Self { yaw: 0.35, pitch: 0.62, pivot, gesture, framing: Some((Vec3::ZERO, 1.0)) }
    }
}

pub(crate) fn perspective() -> Projection {
    Projection::Perspective(PerspectiveProjection { fov: FIELD_OF_VIEW, near: 0.002, far: 200.0, ..default() })
}

impl Orbit {
    /// Which way it looks.
    pub fn rotation(&self) -> Quat {
        Quat::from_euler(EulerRot::YXZ, self.yaw, -self.pitch, 0.0)
    }

    /// Shows a sphere as large as fits, from the side from which the camera looks.
    pub fn frame(&mut self, centre: Vec3, radius: f32) {
        self.framing = Some((centre, radius));
    }

    /// Turns about the pivot, which stays where it is on the screen.
    fn turn_to(&mut self, yaw: f32, pitch: f32, transform: &mut Transform) {
        let limit = std::f32::consts::FRAC_PI_2;
        (self.yaw, self.pitch) = (yaw, pitch.clamp(-limit, limit));
        let turn = self.rotation() * transform.rotation.inverse();
        transform.translation = self.pivot + turn * (transform.translation - self.pivot);
        transform.rotation = self.rotation();
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.add_observer(frame_opened)
        .init_resource::<FreeView>()
        .init_resource::<PanelInput>()
        .add_message::<PinchGesture>()
        .init_resource::<NumberExpected>()
        .add_systems(
            Update,
            (begin_gestures, follow_gestures, scroll, strike_keys.in_set(ViewKeys).run_if(keyboard_is_free)).chain(),
        )
        .add_systems(PostUpdate, frame.before(TransformSystems::Propagate));
}

type Cameras<'w, 's> =
    Query<'w, 's, (&'static mut Orbit, &'static mut Transform, &'static Camera, &'static mut Projection)>;

/// What is under the pointer, of all models.
#[derive(bevy::ecs::system::SystemParam)]
struct Pointed<'w, 's> {
    windows: Query<'w, 's, &'static Window, With<PrimaryWindow>>,
    models: Query<'w, 's, Entity, With<Model>>,
    surfaces: SurfaceQueries<'w, 's>,
}

impl Pointed<'_, '_> {
    fn ray(&self, camera: &Camera, transform: &Transform) -> Option<Ray3d> {
        let pixel = self.windows.single().ok()?.cursor_position()?;
        camera.viewport_to_world(&GlobalTransform::from(*transform), pixel).ok()
    }

    /// The point on a model, or else the one on the ray that is as deep as the pivot.
    fn point(&self, camera: &Camera, transform: &Transform, pivot: Vec3) -> Option<Vec3> {
        let ray = self.ray(camera, transform)?;
        let hits = self.models.iter().filter_map(|model| self.surfaces.get(model)?.ray(ray));
        let nearest = hits.min_by(|a, b| a.distance.total_cmp(&b.distance)).map(|hit| hit.position);
        let depth = (pivot - ray.origin).dot(*transform.forward()).max(NEAREST);
        nearest.or_else(|| Some(ray.get_point(depth / ray.direction.dot(*transform.forward()).max(0.1))))
    }
}

fn begin_gestures(
    mut cameras: Cameras,
    pointed: Pointed,
    mouse: Res<ButtonInput<MouseButton>>,
    keys: Res<ButtonInput<KeyCode>>,
    panel: Res<PanelInput>,
) {
    let Modifiers { alt, shift, .. } = Modifiers::of(&keys);
    let gesture = if mouse.just_pressed(MouseButton::Middle) {
        if shift { Gesture::Pan } else { Gesture::Orbit(MouseButton::Middle) }
    } else if alt && mouse.just_pressed(MouseButton::Left) {
        Gesture::Orbit(MouseButton::Left)
    } else {
        return;
    };
    if panel.pointer {
        return;
    }
    for (mut orbit, transform, camera, _) in &mut cameras {
        orbit.gesture = gesture;
        if let Some(point) = pointed.point(camera, &transform, orbit.pivot) {
            orbit.pivot = point;
        }
    }
}

fn follow_gestures(mut cameras: Cameras, mouse: Res<ButtonInput<MouseButton>>, mut moves: MessageReader<CursorMoved>) {
    // The pointer's own way, so that what is panned stays under it.
    let motion: Vec2 = moves.read().filter_map(|moved| moved.delta).sum();
    for (mut orbit, mut transform, camera, projection) in &mut cameras {
        let held = match orbit.gesture {
            Gesture::None => continue,
            Gesture::Orbit(button) => button,
            Gesture::Pan => MouseButton::Middle,
        };
        if !mouse.pressed(held) {
            orbit.gesture = Gesture::None;
        } else if motion == Vec2::ZERO {
            continue;
        } else if orbit.gesture == Gesture::Pan {
            pan(&mut orbit, &mut transform, camera, &projection, motion);
        } else {
            let turn = motion * RADIANS_PER_PIXEL;
            let (yaw, pitch) = (orbit.yaw - turn.x, orbit.pitch + turn.y);
            orbit.turn_to(yaw, pitch, &mut transform);
        }
    }
}

fn scroll(
    mut cameras: Cameras,
    pointed: Pointed,
    (scroll, mut pinches): (Res<AccumulatedMouseScroll>, MessageReader<PinchGesture>),
    (panel, keys): (Res<PanelInput>, Res<ButtonInput<KeyCode>>),
    taken: Option<Res<TakesWheel>>,
) {
    // A pinch of a tenth is about one notch.
    let pinched: f32 = pinches.read().map(|pinch| pinch.0 * 10.0).sum();
    let (lines, fingers) = match scroll.unit {
        MouseScrollUnit::Line => (scroll.delta.y, Vec2::ZERO),
        MouseScrollUnit::Pixel => (0.0, scroll.delta),
    };
    let notches = pinched + lines;
    if panel.pointer || taken.is_some_and(|taken| taken.0) || (notches == 0.0 && fingers == Vec2::ZERO) {
        return;
    }
    let pans = Modifiers::of(&keys).shift;
    for (mut orbit, mut transform, camera, mut projection) in &mut cameras {
        if notches != 0.0
            && let Some(target) = pointed.point(camera, &transform, orbit.pivot)
        {
            zoom(&mut orbit, &mut transform, &mut projection, target, notches);
        }
        if fingers != Vec2::ZERO && pans {
            pan(&mut orbit, &mut transform, camera, &projection, fingers);
        } else if fingers != Vec2::ZERO {
            let turn = fingers * FINGERS * RADIANS_PER_PIXEL;
            let (yaw, pitch) = (orbit.yaw - turn.x, orbit.pitch + turn.y);
            orbit.turn_to(yaw, pitch, &mut transform);
        }
    }
}

/// Brings the camera nearer to a target, which stays where it is on the screen.
fn zoom(orbit: &mut Orbit, transform: &mut Transform, projection: &mut Projection, target: Vec3, notches: f32) {
    let wanted = NOTCH.powf(notches.clamp(-40.0, 40.0));
    if let Projection::Orthographic(lens) = projection {
        let scale = (lens.scale * wanted).clamp(1e-4, 1e3);
        let share = scale / lens.scale;
        lens.scale = scale;
        // Across the view alone: how deep the camera stands does not matter.
        let aside = (transform.translation - target).reject_from(*transform.forward());
        transform.translation += aside * (share - 1.0);
    } else {
        let distance = transform.translation.distance(target).max(NEAREST);
        let wanted = (distance * wanted).clamp(NEAREST, FARTHEST);
        transform.translation = target + (transform.translation - target) * (wanted / distance);
    }
    orbit.pivot = target;
}

fn pan(orbit: &mut Orbit, transform: &mut Transform, camera: &Camera, projection: &Projection, motion: Vec2) {
    let depth = (orbit.pivot - transform.translation).dot(*transform.forward()).max(NEAREST);
    let step = motion * world_per_pixel(camera, projection, depth);
    let shift = transform.rotation * Vec3::new(-step.x, step.y, 0.0);
    transform.translation += shift;
    orbit.pivot += shift;
}

/// Takes perspective away, or gives it back; what is as deep as the pivot keeps its size.
fn toggle_perspective(orbit: &Orbit, transform: &mut Transform, projection: &mut Projection) {
    let depth = (orbit.pivot - transform.translation).dot(*transform.forward()).max(NEAREST);
    let height_at_one = 2.0 * (0.5 * FIELD_OF_VIEW).tan();
    if let Projection::Orthographic(lens) = projection {
        let wanted = (lens.scale / height_at_one).clamp(NEAREST, FARTHEST);
        transform.translation += *transform.forward() * (depth - wanted);
        *projection = perspective();
    } else {
        // Far enough away that nothing is behind the camera.
        transform.translation -= *transform.forward() * (ORTHOGRAPHIC_DISTANCE - depth);
        *projection = Projection::Orthographic(OrthographicProjection {
            scaling_mode: ScalingMode::FixedVertical { viewport_height: 1.0 },
            scale: depth * height_at_one,
            near: 0.0,
            far: 2.0 * ORTHOGRAPHIC_DISTANCE,
            ..OrthographicProjection::default_3d()
        });
    }
}

/// The keys that turn the view, which come after those that may expect a number.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ViewKeys;

fn strike_keys(
    mut cameras: Cameras,
    keys: Res<ButtonInput<KeyCode>>,
    (number, time): (Res<NumberExpected>, Res<Time<Real>>),
    selection: Res<Selection>,
    traces: Query<(&SplineTrace, &OnSurface)>,
    surfaces: SurfaceQueries,
) {
    use std::f32::consts::FRAC_PI_2;
    let is_number = number.is_near(time.elapsed());
    let struck = |key, pad| !is_number && (keys.just_pressed(key) || keys.just_pressed(pad));
    let side = if struck(KeyCode::Digit1, KeyCode::Numpad1) {
        Some((0.0, 0.0))
    } else if struck(KeyCode::Digit3, KeyCode::Numpad3) {
        Some((FRAC_PI_2, 0.0))
    } else if struck(KeyCode::Digit7, KeyCode::Numpad7) {
        Some((0.0, FRAC_PI_2))
    } else {
        None
    };
    for (mut orbit, mut transform, _, mut projection) in &mut cameras {
        if struck(KeyCode::Digit5, KeyCode::Numpad5) {
            toggle_perspective(&orbit, &mut transform, &mut projection);
        }
        if let Some((yaw, pitch)) = side {
            orbit.turn_to(yaw, pitch, &mut transform);
        }
        if side.is_some() || keys.any_just_pressed([KeyCode::KeyF, KeyCode::Home]) {
            let selected = || selection.splines().iter().filter_map(|spline| traces.get(*spline).ok());
            let world = selected().flat_map(|(trace, on)| {
                let view = surfaces.get(on.0);
                let place = move |p: &Vec3| Some(view.as_ref()?.to_world().transform_point3(*p));
                trace.polyline().iter().filter_map(place).collect::<Vec<_>>()
            });
            let around = sphere_around(world);
            let framed = around.filter(|_| side.is_none());
            let (centre, radius) = framed.map_or((Vec3::ZERO, 1.0), |(centre, radius)| (centre, 1.4 * radius));
            orbit.frame(centre, radius);
        }
    }
}

/// Where a camera stands, for a document.
pub(crate) fn view_of(orbit: &Orbit, place: &Transform, projection: &Projection) -> View {
    let depth = (orbit.pivot - place.translation).dot(*place.forward()).max(NEAREST);
    let (orthographic, distance) = match projection {
        Projection::Orthographic(lens) => (true, lens.scale / (2.0 * (0.5 * FIELD_OF_VIEW).tan())),
        _ => (false, depth),
    };
    // What is in the middle of the view, as deep as the pivot.
    let target = (place.translation + *place.forward() * depth).as_dvec3().to_array();
    let (yaw, pitch) = (f64::from(orbit.yaw), f64::from(orbit.pitch));
    View { target, yaw, pitch, distance: f64::from(distance), orthographic }
}

/// Puts a camera where a document says.
pub(crate) fn set_view(view: &View, orbit: &mut Orbit, place: &mut Transform, projection: &mut Projection) {
    let target = glam::DVec3::from_array(view.target).as_vec3();
    let distance = (view.distance as f32).clamp(NEAREST, FARTHEST);
    *orbit =
        Orbit { yaw: view.yaw as f32, pitch: view.pitch as f32, pivot: target, gesture: Gesture::None, framing: None };
    place.rotation = orbit.rotation();
    place.translation = target - *place.forward() * distance;
    *projection = perspective();
    if view.orthographic {
        toggle_perspective(orbit, place, projection);
    }
}

/// The centre and radius of a sphere that holds some positions.
pub fn sphere_around(positions: impl Iterator<Item = Vec3>) -> Option<(Vec3, f32)> {
    let (min, max) = positions.fold(None, |bounds, p| {
        let (min, max) = bounds.unwrap_or((p, p));
        Some((min.min(p), max.max(p)))
    })?;
    Some((0.5 * (min + max), (0.5 * min.distance(max)).max(NEAREST)))
}

fn frame_opened(_: On<ModelOpened>, mut orbits: Query<&mut Orbit>) {
    orbits.iter_mut().for_each(|mut orbit| *orbit = Orbit::default());
}

/// Moves back until what is framed fits into the part of the window that no panel covers, and centres it there.
fn frame(mut cameras: Cameras, free: Res<FreeView>) {
    for (mut orbit, mut transform, camera, mut projection) in &mut cameras {
        let (Some((centre, radius)), Some(window)) = (orbit.framing, camera.logical_viewport_size()) else { continue };
        let free = free.0.unwrap_or(Rect::from_corners(Vec2::ZERO, window));
        if free.size().min_element() <= 1.0 {
            continue;
        }
        if let Projection::Orthographic(lens) = &mut *projection {
            lens.scale = 2.0 * radius * window.y / (0.94 * free.size().min_element());
            let aside = (free.center() - 0.5 * window) * lens.scale / window.y;
            transform.rotation = orbit.rotation();
            transform.translation = centre + transform.rotation * Vec3::new(-aside.x, aside.y, ORTHOGRAPHIC_DISTANCE);
            (orbit.pivot, orbit.framing) = (centre, None);
            continue;
        }
        let pixel_at_one = world_per_pixel(camera, &projection, 1.0);
        if !(pixel_at_one > 0.0 && pixel_at_one.is_finite()) {
            continue;
        }
        // Half the picture at distance one, with a little air around; a sphere looks larger than the circle in its middle.
        let half = 0.5 * 0.94 * free.size().min_element() * pixel_at_one;
        let distance = radius * (1.0 + 1.0 / (half * half)).sqrt();
        let aside = (free.center() - 0.5 * window) * pixel_at_one * distance;
        transform.rotation = orbit.rotation();
        transform.translation = centre + transform.rotation * Vec3::new(-aside.x, aside.y, distance);
        orbit.pivot = centre;
        orbit.framing = None;
    }
}

/// World length of a pixel at some depth.
pub(crate) fn world_per_pixel(camera: &Camera, projection: &Projection, depth: f32) -> f32 {
    let Some(size) = camera.logical_viewport_size() else { return 0.0 };
    match projection {
        Projection::Perspective(lens) => 2.0 * depth * (0.5 * lens.fov).tan() / size.y,
        Projection::Orthographic(lens) => lens.scale / size.y,
        Projection::Custom(_) => 0.0,
    }
}
