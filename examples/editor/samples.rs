//! Sample curves: three on the bundled model, and one that the scripted drag can take hold of on any other.

use std::f32::consts::{FRAC_PI_2, TAU};

use bevy::prelude::*;
use bevy_surface_splines::curve::Spline;
use bevy_surface_splines::editor::{CurveSpawner, Model, ModelOpened, Notices, Orbit, Selection};
use bevy_surface_splines::geodesic::PathFinder;
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::Surface;

use crate::arguments::Arguments;

pub(crate) fn plugin(app: &mut App) {
    app.add_observer(spawn_samples);
}

fn spawn_samples(
    opened: On<ModelOpened>,
    mut spawner: CurveSpawner,
    arguments: Res<Arguments>,
    models: Query<(&Model, &BuiltSurface, &Transform)>,
    mut selection: ResMut<Selection>,
    mut notices: ResMut<Notices>,
) {
    let Ok((model, surface, transform)) = models.get(opened.entity) else { return };
    selection.clear();
    let mut finder = PathFinder::default();
    let samples = if model.bundled {
        pebble_samples(model, surface, &mut finder)
    } else if arguments.script.is_some() {
        Vec::from_iter(facing_wave(surface, transform, &mut finder).map(|spline| ("Wave", Ok(spline))))
    } else {
        Vec::new()
    };
    for (name, sample) in samples {
        match sample {
            Ok(spline) => {
                let entity = spawner.spawn(opened.entity, Some(name), spline);
                // Nothing is selected at the start: the pen would go on with it.
                if arguments.is_scripted() && selection.is_empty() {
                    selection.select(entity);
                }
            }
            Err(reason) => notices.warn(format!("The sample {name} could not be made: {reason}")),
        }
    }
}

type Sample = (&'static str, Result<Spline, String>);

/// Smooth, closed, corners.
fn pebble_samples(model: &Model, surface: &Surface, finder: &mut PathFinder) -> Vec<Sample> {
    let wave = vec![(-0.55, 0.95), (0.0, 0.15), (0.5, 1.0), (1.05, 0.3)];
    let wave = near_ring(model, surface, wave);
    let ring = (0..5).map(|i| (1.95, i as f32 / 5.0 * TAU + 0.4));
    let ring = near_ring(model, surface, ring.collect());
    let zigzag = near_ring(model, surface, vec![(-2.9, 1.2), (-2.5, 2.2), (-2.1, 1.1), (-1.7, 2.1), (-1.35, 1.3)]);
    let text = |error: &dyn std::fmt::Display| error.to_string();
    vec![
        ("Wave (smooth)", Spline::smooth_through(surface, finder, &wave, false).map_err(|e| text(&e))),
        ("Ring (closed)", Spline::smooth_through(surface, finder, &ring, true).map_err(|e| text(&e))),
        ("Zigzag (corners)", Spline::corners_through(surface, finder, &zigzag, false).map_err(|e| text(&e))),
    ]
}

/// Points of the pebble: by the angle around the hole (0 in front, growing to the right), and that across the ring
/// (0 outside, a quarter turn on top).
fn near_ring(model: &Model, surface: &Surface, angles: Vec<(f32, f32)>) -> Vec<SurfacePoint> {
    let position = |(around, across): (f32, f32)| {
        let outwards = 1.0 + 0.45 * across.cos();
        Vec3::new(outwards * around.sin(), 0.45 * across.sin(), outwards * around.cos())
    };
    let nearest = |at| Some(surface.closest_point(model.of_file(position(at).as_dvec3()))?.point);
    angles.into_iter().filter_map(nearest).collect()
}

/// A wave on whatever faces the first view, as large as fits.
fn facing_wave(surface: &Surface, transform: &Transform, finder: &mut PathFinder) -> Option<Spline> {
    let wave = [(-0.9, -0.2), (-0.3, 0.35), (0.3, -0.35), (0.9, 0.2)].map(|(x, y)| Vec2::new(x, y));
    let view = SurfaceView::new(surface, transform.compute_affine())?;
    let eye = Orbit::default().rotation();
    let place = |at: Vec2| {
        let origin = eye * at.extend(2.0);
        let hit = view.ray(Ray3d::new(origin, Dir3::new(eye * Vec3::NEG_Z).ok()?))?;
        // What is seen at a grazing angle cannot be dragged well.
        (hit.normal.dot(eye * Vec3::Z).abs() > 0.35).then_some(hit.point)
    };
    for size in [0.5, 0.35, 0.25, 0.18, 0.12, 0.08, 0.05, 0.03, 0.015] {
        for ring in 0..5 {
            for step in 0..(1 + 8 * ring) {
                let angle = step as f32 / (8 * ring).max(1) as f32 * TAU + FRAC_PI_2;
                let centre = 0.2 * ring as f32 * Vec2::from_angle(angle);
                let points: Option<Vec<_>> = wave.iter().map(|at| place(centre + size * *at)).collect();
                let Some(points) = points.filter(|points| on_one_sheet(surface, points)) else { continue };
                if let Ok(spline) = Spline::smooth_through(surface, finder, &points, false) {
                    return Some(spline);
                }
            }
        }
    }
    None
}

fn on_one_sheet(surface: &Surface, points: &[SurfacePoint]) -> bool {
    let mut sheets = points.iter().map(|point| surface.sheet(point.face).ok());
    let first = sheets.next().flatten();
    first.is_some() && sheets.all(|sheet| sheet == first)
}
