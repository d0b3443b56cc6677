//! How often is memory taken? Paths between all reference pairs and the points of all curves after one pass to warm up, and the
//! steps of a drag, counted by a published allocator. A block that grows counts like a new one.

mod common;

use std::alloc::System;

use bevy_surface_splines::{
    curve::{HandleSide, Scheme, Spline, Trace, TraceWorkspace, Tracer},
    geodesic::{GeodesicPath, PathFinder, PathQuality},
};
use common::{
    arguments::Arguments,
    drag::{Drag, Grip},
    samples::{Kind, Sample, Samples},
    table::Table,
};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static MEMORY: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Steps of the drag of each thing that can be dragged.
const STEPS: usize = 40;

/// What some work took.
#[derive(Clone, Copy, Default)]
struct Taken {
    allocations: usize,
    /// Blocks that were made larger or smaller.
    reallocations: usize,
}

impl Taken {
    /// What some work takes, and what it gives.
    fn by<T>(work: impl FnOnce() -> T) -> (Self, T) {
        let region = Region::new(MEMORY);
        let result = work();
        let change = region.change();
        (Self { allocations: change.allocations, reallocations: change.reallocations }, result)
    }

    fn count(self) -> usize {
        self.allocations + self.reallocations
    }

    /// The mean of so many times.
    fn each(self, times: usize) -> String {
        format!("{:.1}", self.count() as f64 / times.max(1) as f64)
    }

    fn add(&mut self, other: Self) {
        self.allocations += other.allocations;
        self.reallocations += other.reallocations;
    }
}

fn main() {
    let arguments = Arguments::read();
    let samples = Samples::find(&arguments);
    let table = Table::new(&[
        "mesh",
        "pairs",
        "allocations of all: Fast",
        "Default",
        "Best",
        "curves",
        "of a curve's points",
        "of an edit, spanning curve",
        "of its trace",
        "of an edit, local curve",
        "of its trace",
    ]);
    let (mut pairs, mut all) = (0, [0; 3]);
    for sample in samples.iter() {
        let found = PathQuality::ALL.map(|quality| paths(&sample, quality));
        pairs += found[0].0;
        for (sum, (_, taken)) in all.iter_mut().zip(found) {
            *sum += taken.count();
        }
        let [fast, default, best] = found.map(|(_, taken)| taken.count().to_string());
        let (curves, points) = points(&sample);
        let mut row = vec![sample.name.clone(), found[0].0.to_string(), fast, default, best];
        row.extend([curves.to_string(), points.each(curves)]);
        for kind in Kind::ALL {
            let (steps, taken) = drags(&sample, kind);
            row.extend(taken.map(|taken| taken.each(steps)));
        }
        table.row(row);
    }
    println!("\nAll {pairs} pairs: {} allocations with Fast, {} with Default, {} with Best.", all[0], all[1], all[2]);
}

fn paths(sample: &Sample, quality: PathQuality) -> (usize, Taken) {
    let mut finder = PathFinder::new();
    let Some(first) = sample.cases.first() else { return Default::default() };
    let mut path = GeodesicPath::at_rest(first.polygon[0]);
    let mut pass = || {
        let pairs = sample.cases.iter().flat_map(|case| case.polygon.windows(2));
        pairs.filter(|p| finder.shortest_into(&sample.surface, &p[0], &p[1], quality, &mut path).is_ok()).count()
    };
    pass();
    let (taken, count) = Taken::by(pass);
    (count, taken)
}

fn points(sample: &Sample) -> (usize, Taken) {
    let mut tracer = Tracer::new(&sample.surface);
    let mut out = Vec::new();
    let scheme = Scheme::lane_riesenfeld();
    let mut pass = || {
        let traced = sample.cases.iter().map(|case| tracer.trace_points(&case.polygon, &scheme, &mut out));
        traced.filter(Result::is_ok).count()
    };
    pass();
    let (taken, count) = Taken::by(pass);
    (count, taken)
}

/// Allocations of edits and of the traces after them.
fn drags(sample: &Sample, kind: Kind) -> (usize, [Taken; 2]) {
    let surface = &sample.surface;
    let mut workspace = TraceWorkspace::default();
    let mut sums = [Taken::default(); 2];
    let mut count = 0;
    let Some(case) = sample.cases.iter().find(|case| case.kind == kind) else { return (0, sums) };
    let Ok(spline) = Spline::bezier(surface, &mut workspace.finder, case.polygon) else { return (0, sums) };
    let spline = spline.with_scheme(Scheme::lane_riesenfeld());
    for grip in [Grip::Anchor(0), Grip::Handle(0, HandleSide::Outgoing)] {
        let (mut before, mut after, mut trace) = (spline.clone(), spline.clone(), Trace::default());
        // The same drag twice: the first time to warm up.
        for warm in [false, true] {
            let mut drag = Drag::new(grip, case.number as u64);
            before.clone_from(&spline);
            for _ in 0..STEPS {
                let edit = drag.step(surface, &before);
                let finder = &mut workspace.finder;
                let (editing, edited) = Taken::by(|| after.assign_after(surface, finder, &before, &edit));
                std::mem::swap(&mut before, &mut after);
                let (tracing, traced) = Taken::by(|| before.trace_into(surface, &mut workspace, &mut trace));
                if warm && edited.is_ok() && traced.is_ok() {
                    sums[0].add(editing);
                    sums[1].add(tracing);
                    count += 1;
                }
            }
        }
    }
    (count, sums)
}
