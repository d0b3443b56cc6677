//! How long do thousands of small curves take? 2,000 seeded cubic polygons, each in a ball of one per cent of the diagonal, on
//! a surface of 400,000 faces, by Lane–Riesenfeld subdivision of four and of six levels.
//!
//! Wall time, the median of a few runs: `points` by tracers that compute the points alone, `traces` by `Spline::trace_all`, which
//! joins them by geodesics.

mod common;

use bevy_surface_splines::{
    curve::{Scheme, Spline, TraceWorkspace, Tracer},
    surface::{Surface, SurfaceOptions, SurfacePoint},
};
use common::{
    arguments::Arguments,
    clock, made,
    random::SplitMix64,
    samples,
    stats::Times,
    table::{self, Table},
    threads,
};

const SEED: u64 = 2000;
/// Of the diagonal.
const REACH: f64 = 0.01;

fn main() {
    let arguments = Arguments::read();
    let (count, faces, repeats) = if arguments.quick { (200, 40_000, 1) } else { (2_000, 400_000, 5) };
    let surface = Surface::build(&made::rippled_torus(faces), &SurfaceOptions::default());
    let surface = surface.unwrap_or_else(|error| panic!("{error}"));
    let mut random = SplitMix64::new(SEED);
    let polygons: Vec<_> = (0..count).map(|_| samples::local_polygon(&surface, &mut random, REACH)).collect();
    let mut workspace = TraceWorkspace::default();
    let bezier = |polygon: &[SurfacePoint; 4]| Spline::bezier(&surface, &mut workspace.finder, *polygon);
    let splines: Vec<Spline> = polygons.iter().map(bezier).collect::<Result<_, _>>().unwrap_or_else(|e| panic!("{e}"));

    println!("{count} curves on a torus of {} faces, seed {SEED}.", surface.face_count());
    let table = Table::new(&["levels", "threads", "points ms", "traces ms"]);
    for levels in [4, 6] {
        let scheme = Scheme::lane_riesenfeld().with_levels(levels);
        let splines: Vec<Spline> = splines.iter().map(|spline| spline.clone().with_scheme(scheme)).collect();
        for &threads in threads::COUNTS {
            let median = |work: &(dyn Fn() + Sync)| {
                let times = (0..repeats).map(|_| clock::wall_ms(work).0);
                Times::new(threads::on(threads, || times.collect::<Vec<_>>())).median()
            };
            table.row([
                levels.to_string(),
                threads.to_string(),
                table::number(median(&|| trace_points(&surface, &polygons, &scheme))),
                table::number(median(&|| {
                    let traces = Spline::trace_all(&surface, &splines);
                    assert!(traces.iter().all(Result::is_ok), "every polygon has a trace");
                })),
            ]);
        }
    }
}

#[cfg(feature = "parallel")]
fn trace_points(surface: &Surface, polygons: &[[SurfacePoint; 4]], scheme: &Scheme) {
    use rayon::prelude::*;
    polygons.par_iter().for_each_init(
        || (Tracer::new(surface), Vec::new()),
        |(tracer, points), polygon| points_of(tracer, polygon, scheme, points),
    );
}

#[cfg(not(feature = "parallel"))]
fn trace_points(surface: &Surface, polygons: &[[SurfacePoint; 4]], scheme: &Scheme) {
    let (mut tracer, mut points) = (Tracer::new(surface), Vec::new());
    polygons.iter().for_each(|polygon| points_of(&mut tracer, polygon, scheme, &mut points));
}

fn points_of(tracer: &mut Tracer<'_>, polygon: &[SurfacePoint; 4], scheme: &Scheme, points: &mut Vec<SurfacePoint>) {
    let traced = tracer.trace_points(polygon, scheme, points);
    assert!(traced.is_ok(), "every polygon has a curve");
}
