//! How fast does a ray find the surface? 10,000 shuffled rays to random surface points and 10,000 misses on a torus of a million
//! faces; with the feature `engine_rays`, beside the engine's own ray cast over its mesh, which looks at every triangle.
//!
//! Wall time of one thread, read before and after every ray: medians, with the cost of reading the clock in them.

mod common;

use std::time::Instant;

use bevy_surface_splines::surface::{Surface, SurfaceOptions, TriangleMesh};
use common::{
    arguments::Arguments,
    clock, made,
    random::SplitMix64,
    samples,
    stats::Times,
    table::{self, Table},
    threads,
};
use glam::DVec3;

const SEED: u64 = 10_000;

/// Where a ray begins, and where it goes.
#[derive(Clone, Copy)]
struct Ray {
    origin: DVec3,
    direction: DVec3,
}

fn main() {
    let arguments = Arguments::read();
    let (faces, count) = if arguments.quick { (40_000, 500) } else { (1_000_000, 10_000) };
    let mesh = made::rippled_torus(faces);
    println!("A torus of {} faces, {count} hits and {count} misses, seed {SEED}.", mesh.faces.len());

    let table = Table::new(&["threads", "whole surface built in ms"]);
    for &threads in threads::COUNTS {
        let built = || Surface::build(&mesh, &SurfaceOptions::default()).map(drop);
        let times = (0..3).map(|_| threads::on(threads, || clock::wall_ms(built).0));
        table.row([threads.to_string(), table::number(Times::new(times).quantile(0.0))]);
    }

    let surface = Surface::build(&mesh, &SurfaceOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let mut random = SplitMix64::new(SEED);
    let hits: Vec<Ray> = (0..count).map(|_| to_surface(&surface, &mut random)).collect();
    let misses: Vec<Ray> = (0..count).map(|_| past_surface(&surface, &mut random)).collect();
    let table = Table::new(&["rays", "found", "median µs", "99 % µs", "engine's own cast, median µs", "engine / ours"]);
    for (name, rays) in [("to surface points", hits), ("misses", misses)] {
        let mut found = 0;
        let time = |ray: &Ray| {
            let start = Instant::now();
            found += usize::from(surface.ray(ray.origin, ray.direction).is_some());
            start.elapsed().as_secs_f64() * 1e6
        };
        let times = Times::new(rays.iter().map(time));
        let engine = engine::median_us(&mesh, &rays);
        table.row([
            name.to_owned(),
            found.to_string(),
            table::number(times.median()),
            table::number(times.quantile(0.99)),
            table::number(engine),
            table::number(engine.zip(times.median()).map(|(engine, ours)| engine / ours)),
        ]);
    }
}

/// A random place on the sphere of the diagonal's size about the middle.
fn outside(surface: &Surface, random: &mut SplitMix64) -> DVec3 {
    let (min, max) = surface.bounds();
    let z = 2.0 * random.unit() - 1.0;
    let (sin, cos) = (std::f64::consts::TAU * random.unit()).sin_cos();
    let flat = (1.0 - z * z).sqrt();
    (min + max) / 2.0 + surface.diagonal() * DVec3::new(flat * cos, flat * sin, z)
}

fn to_surface(surface: &Surface, random: &mut SplitMix64) -> Ray {
    let origin = outside(surface, random);
    let goal = surface.position(&samples::random_point(surface, random));
    Ray { origin, direction: (goal - origin).normalize() }
}

/// A ray through the bounding box that meets nothing: through the hole of the torus or past its corners.
fn past_surface(surface: &Surface, random: &mut SplitMix64) -> Ray {
    let (min, max) = surface.bounds();
    loop {
        let origin = outside(surface, random);
        let goal = min + (max - min) * DVec3::new(random.unit(), random.unit(), random.unit());
        let direction = (goal - origin).normalize();
        if surface.ray(origin, direction).is_none() {
            return Ray { origin, direction };
        }
    }
}

#[cfg(feature = "engine_rays")]
mod engine {
    use std::time::Instant;

    use bevy::{
        math::{Affine3A, Dir3, Ray3d},
        picking::mesh_picking::ray_cast::{Backfaces, ray_mesh_intersection},
    };

    use super::{Ray, Times, TriangleMesh};

    /// Rays that are cast: each takes milliseconds.
    const RAYS: usize = 50;

    pub(super) fn median_us(mesh: &TriangleMesh, rays: &[Ray]) -> Option<f64> {
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.as_vec3().to_array()).collect();
        let indices: Vec<u32> = mesh.faces.iter().flatten().copied().collect();
        let time = |ray: &Ray| {
            let direction = Dir3::new(ray.direction.as_vec3()).ok()?;
            let ray = Ray3d::new(ray.origin.as_vec3(), direction);
            let start = Instant::now();
            let hit = ray_mesh_intersection(
                ray,
                &Affine3A::IDENTITY,
                &positions,
                None,
                Some(&indices),
                None,
                Backfaces::Include,
            );
            let us = start.elapsed().as_secs_f64() * 1e6;
            std::hint::black_box(hit);
            Some(us)
        };
        Times::new(rays.iter().take(RAYS).filter_map(time)).median()
    }
}

#[cfg(not(feature = "engine_rays"))]
mod engine {
    use super::{Ray, TriangleMesh};

    pub(super) fn median_us(_mesh: &TriangleMesh, _rays: &[Ray]) -> Option<f64> {
        None
    }
}
