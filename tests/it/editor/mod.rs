//! The editor's tools in a headless app, driven by mouse and keys.

mod documents;
mod gestures;
mod lines;
#[cfg(feature = "editor")]
mod panel;
mod tools;

use bevy::prelude::*;
use bevy_surface_splines::curve::Spline;
use bevy_surface_splines::editor::{
    CameraPlugin, Curve, EditorAction, EditorToolsPlugin, History, ModelPlugin, Orbit, Selection, Tool,
};
use bevy_surface_splines::plugin::SurfaceSplinePlugins;
use bevy_surface_splines::plugin::testing::{Hand, pixel_of, unfinished_headless_app, update_until};
use bevy_surface_splines::prelude::*;

/// The middle of the window.
const CENTRE: Vec2 = Vec2::new(640.0, 360.0);

/// An app with all tools, a camera, and a model that faces it.
struct Studio {
    app: App,
    hand: Hand,
    camera: Entity,
    model: Entity,
}

impl Studio {
    /// With a sphere of radius 1 in front of a camera that sees it as a disc of about 330 pixels' radius.
    fn with_sphere() -> Self {
        Self::with_mesh(Sphere::new(1.0).mesh().uv(32, 18))
    }

    /// With a flat square of two units.
    fn with_plane() -> Self {
        Self::with_mesh(Rectangle::new(2.0, 2.0).mesh().build())
    }

    fn with_mesh(mesh: impl Into<Mesh>) -> Self {
        let mut app = unfinished_headless_app();
        app.add_plugins((SurfaceSplinePlugins, EditorToolsPlugin));
        app.finish();
        app.cleanup();
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh.into());
        let model = app.world_mut().spawn((Mesh3d(mesh), SplineSurface::default())).id();
        let place = Transform::from_xyz(0.0, 0.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
        let camera = app.world_mut().spawn((Camera3d::default(), place)).id();
        assert!(update_until(&mut app, |world| world.get::<BuiltSurface>(model).is_some()), "the surface is built");
        let hand = Hand::new(&mut app).expect("a window");
        app.update();
        Self { app, hand, camera, model }
    }

    fn strike(&mut self, key: KeyCode) {
        self.hand.strike(&mut self.app, key);
    }

    fn control(&mut self, key: KeyCode) {
        self.hand.strike_with(&mut self.app, &[KeyCode::ControlLeft], key);
    }

    fn shift(&mut self, key: KeyCode) {
        self.hand.strike_with(&mut self.app, &[KeyCode::ShiftLeft], key);
    }

    fn undo(&mut self) {
        self.control(KeyCode::KeyZ);
        self.settle();
    }

    fn redo(&mut self) {
        self.control(KeyCode::KeyY);
        self.settle();
    }

    fn click(&mut self, at: Vec2) {
        self.hand.click(&mut self.app, at);
    }

    fn drag(&mut self, places: &[Vec2]) {
        self.hand.drag(&mut self.app, places.iter().copied());
    }

    /// Lets everything that is on its way arrive.
    fn settle(&mut self) {
        for _ in 0..3 {
            self.app.update();
        }
        assert!(update_until(&mut self.app, |world| !world.resource::<History>().is_busy()), "the history is at rest");
    }

    fn tool(&self) -> Tool {
        *self.app.world().resource::<Tool>()
    }

    fn selection(&self) -> Selection {
        self.app.world().resource::<Selection>().clone()
    }

    fn act(&mut self, action: EditorAction) {
        self.app.world_mut().write_message(action);
        self.app.update();
    }

    /// All splines that lie on a surface, by their number.
    fn splines(&mut self) -> Vec<(Entity, Spline)> {
        let world = self.app.world_mut();
        let mut query = world.query::<(Entity, &SurfaceSpline, &Curve)>();
        let mut found: Vec<_> = query.iter(world).map(|(e, s, c)| (c.number, e, (**s).clone())).collect();
        found.sort_by_key(|(number, ..)| *number);
        found.into_iter().map(|(_, entity, spline)| (entity, spline)).collect()
    }

    /// The only spline.
    fn spline(&mut self) -> Spline {
        let splines = self.splines();
        assert_eq!(splines.len(), 1, "one spline");
        splines.into_iter().map(|(_, spline)| spline).next().expect("a spline")
    }

    /// What the document is: names, looks and splines, bit for bit.
    fn document(&mut self) -> Vec<(Curve, Spline)> {
        let world = self.app.world_mut();
        let mut query = world.query::<(&SurfaceSpline, &Curve)>();
        let mut found: Vec<_> = query.iter(world).map(|(s, c)| (c.clone(), (**s).clone())).collect();
        found.sort_by_key(|(curve, _)| curve.number);
        found
    }

    /// All lines, as they were drawn, and how they are smoothed.
    fn lines(&mut self) -> Vec<(Curve, SurfaceLine, Option<LineSmoothing>, Entity)> {
        let world = self.app.world_mut();
        let mut query = world.query::<(&Curve, &SurfaceLine, Option<&LineSmoothing>, Entity)>();
        let mut found: Vec<_> = query.iter(world).map(|(c, l, s, e)| (c.clone(), l.clone(), s.copied(), e)).collect();
        found.sort_by_key(|(curve, ..)| curve.number);
        found
    }

    /// All there is: splines and lines.
    #[allow(clippy::type_complexity, reason = "two lists")]
    fn whole(&mut self) -> (Vec<(Curve, Spline)>, Vec<(Curve, SurfaceLine, Option<LineSmoothing>, Entity)>) {
        (self.document(), self.lines())
    }

    fn names(&self) -> [Option<String>; 2] {
        self.app.world().resource::<History>().names().map(|name| name.map(str::to_string))
    }

    fn surface(&self) -> &bevy_surface_splines::surface::Surface {
        self.app.world().get::<BuiltSurface>(self.model).expect("a surface")
    }

    /// Where a surface point is seen.
    fn pixel(&self, point: SurfacePoint) -> Vec2 {
        let position = self.surface().position(&point).as_vec3();
        pixel_of(self.app.world(), self.camera, position).expect("on screen")
    }

    /// Draws corners with the pen, and takes the selecting tool again.
    fn draw(&mut self, places: &[Vec2]) {
        self.strike(KeyCode::KeyP);
        self.act(EditorAction::BeginSpline);
        for place in places {
            self.click(*place);
        }
        self.strike(KeyCode::Enter);
        self.settle();
    }
}

#[test]
fn the_camera_orbits_zooms_and_changes_its_lens() {
    let mut app = unfinished_headless_app();
    app.add_plugins((SurfaceSplinePlugins, EditorToolsPlugin, ModelPlugin, CameraPlugin));
    app.finish();
    app.cleanup();
    let camera = app.world_mut().spawn(Orbit::default()).id();
    assert!(update_until(&mut app, |world| world.query::<&BuiltSurface>().iter(world).count() == 1));
    for _ in 0..3 {
        app.update();
    }
    let mut hand = Hand::new(&mut app).expect("a window");
    let place = |app: &App| *app.world().get::<Transform>(camera).expect("a camera");
    let before = place(&app);
    hand.move_to(&mut app, CENTRE);
    hand.press(&mut app, MouseButton::Middle);
    hand.move_to(&mut app, CENTRE + Vec2::X * 100.0);
    hand.release(&mut app, MouseButton::Middle);
    let turned = place(&app);
    assert!(before.rotation.angle_between(turned.rotation) > 0.5, "middle drag orbits");
    hand.wheel(&mut app, 3.0);
    let near = place(&app);
    assert!((near.translation.length() - turned.translation.length()) < -0.1, "the wheel goes nearer");
    hand.strike(&mut app, KeyCode::Digit1);
    app.update();
    assert!(place(&app).rotation.angle_between(Quat::IDENTITY) < 1e-3, "1 looks from the front");
    let height = |app: &mut App| {
        let top = pixel_of(app.world(), camera, Vec3::Y).expect("on screen");
        let bottom = pixel_of(app.world(), camera, Vec3::NEG_Y).expect("on screen");
        bottom.distance(top)
    };
    let seen = height(&mut app);
    hand.strike(&mut app, KeyCode::Digit5);
    assert!(matches!(app.world().get::<Projection>(camera), Some(Projection::Orthographic(_))));
    let flat = height(&mut app);
    assert!((flat / seen - 1.0).abs() < 0.03, "what is in the middle keeps its size: {seen} and {flat}");
    hand.strike(&mut app, KeyCode::Digit5);
    assert!((height(&mut app) / seen - 1.0).abs() < 1e-3);
}
