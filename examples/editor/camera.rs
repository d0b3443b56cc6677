//! The orbit camera. The model fits the unit sphere, so that distances need no other measure.
//!
//! Middle drag, or Alt and left drag, orbits about the point under the pointer; Shift and middle drag pans; the wheel zooms to the
//! pointer; F frames, and 1, 3, 7 look along the axes. Nothing starts while the pointer is on a panel.

use bevy::input::mouse::{AccumulatedMouseScroll, MouseScrollUnit};
use bevy::prelude::*;
use bevy::window::{CursorMoved, PrimaryWindow};
use bevy_egui::input::EguiWantsInput;
use bevy_surface_splines::prelude::*;

use crate::keys::keyboard_is_free;
use crate::model::{Model, ModelOpened};
use crate::panel::Layout;
use crate::selection::Selection;

const RADIANS_PER_PIXEL: f32 = 0.007;
/// How much nearer one notch of the wheel brings what is under the pointer.
const NOTCH: f32 = 0.86;
/// Pixels of a touchpad that count as one notch.
const PIXELS_PER_NOTCH: f32 = 40.0;
const NEAREST: f32 = 0.01;
const FARTHEST: f32 = 60.0;

/// A turntable camera.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub(crate) struct Orbit {
    /// About the vertical, and up from the horizon, in radians.
    yaw: f32,
    pitch: f32,
    /// What the camera turns about, pans with and frames.
    pivot: Vec3,
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

impl Orbit {
    pub(crate) fn rotation(&self) -> Quat {
        Quat::from_euler(EulerRot::YXZ, self.yaw, -self.pitch, 0.0)
    }

    /// Shows a sphere as large as fits, from the side from which the camera looks.
    pub(crate) fn frame(&mut self, centre: Vec3, radius: f32) {
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
        .add_systems(Update, (begin_gestures, follow_gestures, zoom, strike_keys.run_if(keyboard_is_free)).chain())
        .add_systems(PostUpdate, frame.before(TransformSystems::Propagate));
}

type Cameras<'w, 's> =
    Query<'w, 's, (&'static mut Orbit, &'static mut Transform, &'static Camera, &'static Projection)>;

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
    egui: Res<EguiWantsInput>,
) {
    let alt = keys.any_pressed([KeyCode::AltLeft, KeyCode::AltRight]);
    let shift = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    let gesture = if mouse.just_pressed(MouseButton::Middle) {
        if shift { Gesture::Pan } else { Gesture::Orbit(MouseButton::Middle) }
    } else if alt && mouse.just_pressed(MouseButton::Left) {
        Gesture::Orbit(MouseButton::Left)
    } else {
        return;
    };
    if egui.wants_any_pointer_input() {
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
            let depth = (orbit.pivot - transform.translation).dot(*transform.forward()).max(NEAREST);
            let step = motion * world_per_pixel(camera, projection, depth);
            let shift = transform.rotation * Vec3::new(-step.x, step.y, 0.0);
            transform.translation += shift;
            orbit.pivot += shift;
        } else {
            let turn = motion * RADIANS_PER_PIXEL;
            let (yaw, pitch) = (orbit.yaw - turn.x, orbit.pitch + turn.y);
            orbit.turn_to(yaw, pitch, &mut transform);
        }
    }
}

fn zoom(mut cameras: Cameras, pointed: Pointed, scroll: Res<AccumulatedMouseScroll>, egui: Res<EguiWantsInput>) {
    if scroll.delta.y == 0.0 || egui.wants_any_pointer_input() {
        return;
    }
    let notches = match scroll.unit {
        MouseScrollUnit::Line => scroll.delta.y,
        MouseScrollUnit::Pixel => scroll.delta.y / PIXELS_PER_NOTCH,
    };
    for (mut orbit, mut transform, camera, _) in &mut cameras {
        let Some(target) = pointed.point(camera, &transform, orbit.pivot) else { continue };
        let distance = transform.translation.distance(target).max(NEAREST);
        let wanted = (distance * NOTCH.powf(notches)).clamp(NEAREST, FARTHEST);
        transform.translation = target + (transform.translation - target) * (wanted / distance);
        orbit.pivot = target;
    }
}

fn strike_keys(
    mut cameras: Cameras,
    keys: Res<ButtonInput<KeyCode>>,
    selection: Res<Selection>,
    traces: Query<(&SplineTrace, &OnSurface)>,
    surfaces: SurfaceQueries,
) {
    use std::f32::consts::FRAC_PI_2;
    let struck = |key, pad| keys.just_pressed(key) || keys.just_pressed(pad);
    let side = if struck(KeyCode::Digit1, KeyCode::Numpad1) {
        Some((0.0, 0.0))
    } else if struck(KeyCode::Digit3, KeyCode::Numpad3) {
        Some((FRAC_PI_2, 0.0))
    } else if struck(KeyCode::Digit7, KeyCode::Numpad7) {
        Some((0.0, FRAC_PI_2))
    } else {
        None
    };
    for (mut orbit, mut transform, ..) in &mut cameras {
        if let Some((yaw, pitch)) = side {
            orbit.turn_to(yaw, pitch, &mut transform);
        }
        if side.is_some() || keys.just_pressed(KeyCode::KeyF) {
            let selected = selection.spline.and_then(|spline| traces.get(spline).ok());
            let around = selected.and_then(|(trace, on)| {
                let view = surfaces.get(on.0)?;
                sphere_around(trace.polyline().iter().map(|p| view.to_world().transform_point3(*p)))
            });
            let framed = around.filter(|_| side.is_none());
            let (centre, radius) = framed.map_or((Vec3::ZERO, 1.0), |(centre, radius)| (centre, 1.4 * radius));
            orbit.frame(centre, radius);
        }
    }
}

/// The centre and radius of a sphere that holds some positions.
pub(crate) fn sphere_around(positions: impl Iterator<Item = Vec3> + Clone) -> Option<(Vec3, f32)> {
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
fn frame(mut cameras: Cameras, layout: Res<Layout>) {
    for (mut orbit, mut transform, camera, projection) in &mut cameras {
        let (Some((centre, radius)), Some(window)) = (orbit.framing, camera.logical_viewport_size()) else { continue };
        let Some(free) = layout.free.filter(|free| free.size().min_element() > 1.0) else { continue };
        let pixel_at_one = world_per_pixel(camera, projection, 1.0);
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
fn world_per_pixel(camera: &Camera, projection: &Projection, depth: f32) -> f32 {
    let (Projection::Perspective(lens), Some(size)) = (projection, camera.logical_viewport_size()) else { return 0.0 };
    2.0 * depth * (0.5 * lens.fov).tan() / size.y
}
