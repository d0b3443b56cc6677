//! A grey sphere that turns slowly, with an orange curve on it: smooth, closed, through the three points where the axes
//! pierce the sphere. The curve appears a moment after the sphere, when its surface is built, and turns with it.
//!
//! `cargo run --example hello_curve --features render`

use bevy::prelude::*;
use bevy_surface_splines::prelude::*;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, SurfaceSplinePlugins))
        .add_systems(Startup, setup)
        .add_systems(Update, turn)
        .add_observer(|failed: On<SurfaceFailed>| error!("no surface: {}", failed.reason))
        .add_observer(|traced: On<TraceChanged>| info!("{} segments traced", traced.retraced))
        .run()
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let planet = commands
        .spawn((
            Mesh3d(meshes.add(Sphere::new(1.0))),
            MeshMaterial3d(materials.add(Color::srgb(0.5, 0.5, 0.55))),
            SplineSurface::default(),
        ))
        .id();
    // The nearest surface points, in the planet's local space. Nothing to wait for: the spline is pending until the
    // surface is ready.
    commands.spawn((OnSurface(planet), SplineSource::smooth_through([Vec3::X, Vec3::Y, Vec3::Z]).closed()));

    let eye = Vec3::new(2.0, 2.0, 3.0);
    commands.spawn((Camera3d::default(), Transform::from_translation(eye).looking_at(Vec3::ZERO, Vec3::Y)));
    commands.spawn((DirectionalLight::default(), Transform::from_xyz(3.0, 5.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y)));
}

fn turn(time: Res<Time>, mut planets: Query<&mut Transform, With<SplineSurface>>) {
    for mut transform in &mut planets {
        transform.rotate_y(0.3 * time.delta_secs());
    }
}
