//! How long does smoothing take? Jagged lines across a rippled torus, by every mode, and a slider that is
//! moved: there, around a sphere, and over its poles, where faces are slivers.
//!
//! CPU time, the median of a few runs. `--quick` for fewer.

mod common;

use bevy_surface_splines::{
    curve::DrawnLine,
    smooth::{LiveSmoothing, SmoothWorkspace, Smoothed, Smoothing, SmoothingMode, SurfacePolyline, smooth_into},
    surface::{Surface, SurfaceOptions, shapes},
};
use common::{
    arguments::Arguments,
    clock, made,
    random::SplitMix64,
    stats::Times,
    table::{self, Table},
};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

const SEED: u64 = 7;

/// A line around the torus that trembles by some edges, of about so many crossings.
fn trembling(surface: &Surface, workspace: &mut SmoothWorkspace, crossings: usize) -> SurfacePolyline {
    let mut random = SplitMix64::new(SEED);
    let mut line = DrawnLine::new(0.0);
    let edge = surface.mean_edge_length(bevy_surface_splines::surface::FaceId(0)).unwrap_or(0.01);
    let mut angle = 0.0_f64;
    while line.paths().iter().map(|path| path.crossings().len()).sum::<usize>() < crossings {
        angle += 2.0 * edge / 3.0;
        let out = 2.0 + 1.1 * (0.37 * angle).sin().abs();
        let tremor = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5) * 6.0 * edge;
        let Some(hit) = surface.closest_point(DVec3::new(out * angle.cos(), out * angle.sin(), 1.0) + tremor) else {
            continue;
        };
        if let Err(error) = line.push(surface, &mut workspace.finder, hit.point) {
            panic!("{error}");
        }
    }
    SurfacePolyline::drawn(surface, &line).unwrap_or_else(|error| panic!("{error}"))
}

fn main() {
    let arguments = Arguments::read();
    let repeats = if arguments.quick { 3 } else { 15 };
    let surface = Surface::build(&made::rippled_torus(400_000), &SurfaceOptions::default());
    let surface = surface.unwrap_or_else(|error| panic!("{error}"));
    let mut workspace = SmoothWorkspace::default();
    println!("Jagged lines on a torus of {} faces, seed {SEED}.", surface.face_count());
    let table = Table::new(&["crossings", "mode", "ms", "turn left", "rounds", "steps", "max distance / edge"]);
    for count in [410, 2_000, 10_000] {
        let line = trembling(&surface, &mut workspace, count);
        let mean = surface.mean_edge_length(line.crossings()[0].face).unwrap_or(1.0);
        let mut out = Smoothed::blank();
        for mode in [
            SmoothingMode::Tether { closeness: 10.0 },
            SmoothingMode::Tether { closeness: 100.0 },
            SmoothingMode::Geodesic,
            SmoothingMode::Stencil { scale: 1.0, passes: 5 },
            SmoothingMode::Budget { share: 0.25 },
            SmoothingMode::Lift { weight: 1.0 },
            SmoothingMode::Conformal { weight: 10.0 },
        ] {
            let smoothing = Smoothing::by(mode);
            let times = (0..repeats).map(|_| {
                let (ms, done) = clock::cpu_ms(|| smooth_into(&surface, &mut workspace, &line, &smoothing, &mut out));
                assert!(done.is_ok(), "{done:?}");
                ms
            });
            let times = Times::new(times.collect::<Vec<_>>());
            table.row([
                line.crossings().len().to_string(),
                format!("{} {}", mode.name(), number(&mode)),
                table::number(times.median()),
                format!("{:.3}", out.after.total_turn / out.before.total_turn),
                out.rounds.to_string(),
                out.steps.to_string(),
                format!("{:.2}", out.after.max_distance / mean),
            ]);
        }
    }
    let frames = if arguments.quick { 20 } else { 120 };
    // What leads there and back is left out: two thousand crossings stay.
    let line = trembling(&surface, &mut workspace, 2_460);
    slider("around a torus", &surface, line, frames);
    let sphere = uv_sphere();
    for (name, poles) in [("around a sphere", false), ("over its poles", true)] {
        let line = ring(&sphere, &mut workspace, poles, 2_000);
        slider(name, &sphere, line, frames);
    }
}

fn number(mode: &SmoothingMode) -> String {
    match mode {
        SmoothingMode::Geodesic => String::new(),
        SmoothingMode::Stencil { scale, .. } => scale.to_string(),
        SmoothingMode::Budget { share } => share.to_string(),
        SmoothingMode::Tether { closeness: weight }
        | SmoothingMode::Lift { weight }
        | SmoothingMode::Conformal { weight } => weight.to_string(),
    }
}

/// A unit sphere of 380 × 190 quads, at its poles slivers.
fn uv_sphere() -> Surface {
    let ring = |j: u32| (f64::from(j) * PI / 190.0).sin_cos();
    let profile: Vec<_> = (0..=190).map(ring).map(|(r, z)| (if r < 1e-9 { 0.0 } else { r }, -z)).collect();
    Surface::build(&shapes::revolution(&profile, 380), &SurfaceOptions::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

/// A closed line around a sphere, or over its poles, that trembles by some edges, of about so many crossings.
fn ring(sphere: &Surface, workspace: &mut SmoothWorkspace, poles: bool, crossings: usize) -> SurfacePolyline {
    let mut random = SplitMix64::new(SEED);
    let mut drawn = |tremor: f64| {
        let points: Vec<_> = (0..500)
            .filter_map(|k| {
                let a = TAU * f64::from(k) / 500.0;
                let off = 0.3 * (2.0 * a).sin() + tremor * (2.0 * random.unit() - 1.0);
                let p = if poles { DVec3::new(a.cos(), off, a.sin()) } else { DVec3::new(a.cos(), a.sin(), off) };
                Some(sphere.closest_point(p)?.point)
            })
            .collect();
        let line = SurfacePolyline::through(sphere, &mut workspace.finder, &points, true);
        line.unwrap_or_else(|error| panic!("{error}"))
    };
    let tremors = (10..60).map(|k| 0.002 * f64::from(k));
    let long = tremors.map(&mut drawn).find(|line| line.crossings().len() >= crossings);
    long.unwrap_or_else(|| panic!("no line of {crossings} crossings"))
}

/// Closeness from nearly straight to nearly what was drawn, a step a frame.
fn slider(name: &str, surface: &Surface, line: SurfacePolyline, frames: u32) {
    let crossings = line.crossings().len();
    let mut live = LiveSmoothing::new(surface, line, Smoothing::default()).unwrap_or_else(|error| panic!("{error}"));
    let mut times = Vec::new();
    for frame in 0..frames {
        let closeness = 10.0_f64.powf(-1.0 + 4.0 * f64::from(frame) / f64::from(frames - 1));
        let (ms, done) = clock::cpu_ms(|| live.smooth(surface, closeness).map(|_| ()));
        assert!(done.is_ok(), "{done:?}");
        times.push(ms);
    }
    let times = Times::new(times);
    let of = |share: f64| times.quantile(share).unwrap_or(0.0);
    println!(
        "\nA slider over {crossings} crossings {name}, {frames} places from closeness 0.1 to 1,000: median {:.2}, 90 % {:.2}, max {:.2} ms.",
        of(0.5),
        of(0.9),
        of(1.0)
    );
}
