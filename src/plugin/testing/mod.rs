//! Testing apps with splines: a headless app with real picking, and a pointer that follows a script.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_surface_splines::plugin::testing::{PointerScript, headless_app, update_until};
//! use bevy_surface_splines::prelude::*;
//!
//! let mut app = headless_app();
//! let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(Sphere::new(1.0));
//! let planet = app.world_mut().spawn((Mesh3d(mesh), SplineSurface::default())).id();
//! app.world_mut().spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 5.0)));
//! assert!(update_until(&mut app, |world| world.get::<BuiltSurface>(planet).is_some()));
//! let mut pointer = PointerScript::mouse(&mut app).ok_or("no window")?;
//! pointer.move_to(&mut app, Vec2::new(640.0, 360.0));
//! pointer.press(&mut app);
//! pointer.release(&mut app);
//! # Ok::<(), &str>(())
//! ```

use std::time::{Duration, Instant};

use bevy::camera::visibility::VisibilitySystems;
use bevy::camera::{CameraUpdateSystems, NormalizedRenderTarget, RenderTarget, RenderTargetInfo};
use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::picking::pointer::{Location, PointerAction, PointerId, PointerInput};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy::window::{PrimaryWindow, WindowRef};

use super::{SurfaceSplinePlugins, TraceBudget};

mod hand;

pub use hand::Hand;

/// Time that passes in each update of a [`headless_app`].
pub const FRAME: Duration = Duration::from_millis(16);

/// An app with [`SurfaceSplinePlugins`], picking, assets and a window entity of 1280 × 720 that never opens; ready to be
/// updated. Further plugins must be added to an [`unfinished_headless_app`].
///
/// Edits and traces are done in the frame whatever they take ([`TraceBudget::UNLIMITED`]), so that a test does not depend on how
/// fast the machine is.
pub fn headless_app() -> App {
    let mut app = unfinished_headless_app();
    app.add_plugins(SurfaceSplinePlugins);
    app.finish();
    app.cleanup();
    app
}

/// The same without [`SurfaceSplinePlugins`], before `finish` and `cleanup`.
pub fn unfinished_headless_app() -> App {
    unfinished_headless_app_with(AssetPlugin::default())
}

/// The same with assets from elsewhere.
pub fn unfinished_headless_app_with(assets: AssetPlugin) -> App {
    unfinished_headless_app_from(App::new(), assets)
}

/// The same of an app that has asset sources of its own already.
pub fn unfinished_headless_app_from(mut app: App, assets: AssetPlugin) -> App {
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        bevy::input::InputPlugin,
        // What closes windows is the app's to say.
        bevy::window::WindowPlugin { close_when_requested: false, ..default() },
        assets,
        ImagePlugin::default(),
        bevy::mesh::MeshPlugin,
        bevy::camera::CameraPlugin,
        bevy::gizmos::GizmoPlugin,
        bevy::world_serialization::WorldSerializationPlugin,
        bevy::picking::DefaultPickingPlugins,
        #[cfg(any(feature = "characters", feature = "engine_gltf"))]
        bevy::animation::AnimationPlugin,
    ))
    .insert_resource(TimeUpdateStrategy::ManualDuration(FRAME))
    .insert_resource(TraceBudget::UNLIMITED)
    .add_systems(PostUpdate, update_cameras.in_set(CameraUpdateSystems).before(VisibilitySystems::UpdateFrusta));
    app
}

/// Updates until a condition holds, for at most a minute; whether it holds.
///
/// Sleeps between updates, so that background work gets on. A minute is far more than anything takes; on a machine that does much
/// else besides, ten seconds were not always enough.
pub fn update_until(app: &mut App, mut holds: impl FnMut(&mut World) -> bool) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(60) {
        app.update();
        if holds(app.world_mut()) {
            return true;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    false
}

/// The logical pixel at which a camera shows a position; none if it does not show it.
pub fn pixel_of(world: &World, camera: Entity, position: Vec3) -> Option<Vec2> {
    let transform = world.get::<GlobalTransform>(camera)?;
    world.get::<Camera>(camera)?.world_to_viewport(transform, position).ok()
}

/// A scripted pointer: every call sends one message and updates the app once.
#[derive(Clone, Debug)]
pub struct PointerScript {
    id: PointerId,
    window: Entity,
    target: NormalizedRenderTarget,
    at: Vec2,
}

impl PointerScript {
    /// The mouse on the primary window; none without a window.
    pub fn mouse(app: &mut App) -> Option<Self> {
        let world = app.world_mut();
        let window = world.query_filtered::<Entity, With<PrimaryWindow>>().single(world).ok()?;
        let target = RenderTarget::Window(WindowRef::Primary).normalize(Some(window))?;
        Some(Self { id: PointerId::Mouse, window, target, at: Vec2::ZERO })
    }

    /// Where it is, in logical pixels of the window.
    pub fn position(&self) -> Vec2 {
        self.at
    }

    /// Moves.
    pub fn move_to(&mut self, app: &mut App, to: Vec2) {
        let delta = to - self.at;
        self.at = to;
        self.send(app, PointerAction::Move { delta });
    }

    /// Presses the primary button.
    pub fn press(&self, app: &mut App) {
        self.send(app, PointerAction::Press(PointerButton::Primary));
    }

    /// Lets the primary button go.
    pub fn release(&self, app: &mut App) {
        self.send(app, PointerAction::Release(PointerButton::Primary));
    }

    /// Cancels, as a touch that the system takes away.
    pub fn cancel(&self, app: &mut App) {
        self.send(app, PointerAction::Cancel);
    }

    /// Strikes Escape: one update with the key down, one with it up.
    pub fn escape(&self, app: &mut App) {
        for state in [ButtonState::Pressed, ButtonState::Released] {
            let (key_code, logical_key) = (KeyCode::Escape, Key::Escape);
            let window = self.window;
            app.world_mut().write_message(KeyboardInput {
                key_code,
                logical_key,
                state,
                text: None,
                repeat: false,
                window,
            });
            app.update();
        }
    }

    fn send(&self, app: &mut App, action: PointerAction) {
        let location = Location { target: self.target.clone(), position: self.at };
        app.world_mut().write_message(PointerInput::new(self.id, location, action));
        app.update();
    }
}

/// Does what `camera_system` of the renderer does: sizes and projections from render targets.
fn update_cameras(
    windows: Query<&Window>,
    primary: Query<Entity, With<PrimaryWindow>>,
    images: Option<Res<Assets<Image>>>,
    mut cameras: Query<(&mut Camera, &RenderTarget, &mut Projection)>,
) {
    let primary = primary.iter().next();
    for (mut camera, target, mut projection) in &mut cameras {
        let (physical_size, scale_factor) = match target.normalize(primary) {
            Some(NormalizedRenderTarget::Window(window)) => match windows.get(window.entity()) {
                Ok(window) => (window.physical_size(), window.scale_factor()),
                Err(_) => continue,
            },
            Some(NormalizedRenderTarget::Image(image)) => match images.as_ref().and_then(|i| i.get(&image.handle)) {
                Some(found) => (found.size(), image.scale_factor),
                None => continue,
            },
            Some(NormalizedRenderTarget::None { width, height }) => (UVec2::new(width, height), 1.0),
            Some(NormalizedRenderTarget::TextureView(_)) | None => continue,
        };
        camera.computed.target_info = Some(RenderTargetInfo { physical_size, scale_factor });
        if let Some(size) = camera.logical_viewport_size().filter(|size| size.min_element() > 0.0) {
            projection.update(size.x, size.y);
            camera.computed.clip_from_view = projection.get_clip_from_view();
        }
    }
}
