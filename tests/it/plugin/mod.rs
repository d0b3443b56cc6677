//! The Bevy plugin in a headless app.

mod b_splines;
#[cfg(feature = "characters")]
mod characters;
#[cfg(feature = "characters")]
mod characters_laid;
mod curves;
#[cfg(feature = "document")]
mod documents;
pub(crate) mod drags;
#[cfg(feature = "svg")]
mod drawings;
mod jumps;
#[cfg(feature = "formats")]
mod large_meshes;
mod lines;
mod lines_made;
#[cfg(feature = "characters")]
mod paths;
mod picks;
mod previews;
mod riding;
#[cfg(feature = "engine_gltf")]
mod rigs;
mod samples;
mod slow_edits;
mod surfaces;
mod worlds;

use bevy::prelude::*;
use bevy_surface_splines::plugin::testing::{headless_app, update_until};
use bevy_surface_splines::prelude::*;

/// Small, seeded random numbers (splitmix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to 1.
    pub(crate) fn share(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1 << 24) as f32
    }

    /// From −1 to 1.
    pub(crate) fn signed(&mut self) -> f32 {
        2.0 * self.share() - 1.0
    }

    pub(crate) fn below(&mut self, n: u32) -> u32 {
        (self.next() % u64::from(n)) as u32
    }
}

/// An app with a camera at `eye` that looks at the origin.
fn app_with_camera(eye: Vec3) -> (App, Entity) {
    let mut app = headless_app();
    let up = if eye.normalize().y.abs() > 0.9 { Vec3::X } else { Vec3::Y };
    let look = Transform::from_translation(eye).looking_at(Vec3::ZERO, up);
    let camera = app.world_mut().spawn((Camera3d::default(), look)).id();
    (app, camera)
}

/// A surface from a mesh, ready.
fn spawn_surface(app: &mut App, mesh: impl Into<Mesh>) -> Entity {
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh.into());
    let surface = app.world_mut().spawn((Mesh3d(mesh), SplineSurface::default())).id();
    assert!(update_until(app, |world| world.get::<BuiltSurface>(surface).is_some()), "the surface is built");
    surface
}

/// A spline from a source, traced.
fn spawn_spline(app: &mut App, surface: Entity, source: SplineSource) -> Entity {
    let spline = app.world_mut().spawn((OnSurface(surface), source)).id();
    app.update();
    assert_eq!(app.world().get::<SplineState>(spline), Some(&SplineState::Ready));
    spline
}

fn surface_of(app: &App, surface: Entity) -> &bevy_surface_splines::surface::Surface {
    app.world().get::<BuiltSurface>(surface).expect("a surface")
}
