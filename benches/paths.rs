//! How long does a shortest path take, and how short is it? Point pairs on all reference meshes, in the three qualities, beside
//! the paper's method and what was recorded of the paper's own program.
//!
//! CPU time of one thread, medians. Each method goes over all pairs by itself, after one pass over some of them to warm up.

mod baseline;
mod common;

use baseline::{Baseline, mesh::Mesh};
use bevy_surface_splines::{
    geodesic::{PathFinder, PathQuality},
    surface::SurfacePoint,
};
use common::{
    arguments::Arguments,
    clock,
    records::PairRecord,
    samples::{Kind, Sample, Samples},
    stats::Times,
    table::{self, Table},
};

/// Paths to find before the clock counts.
const WARM_UP: usize = 12;

fn main() {
    let arguments = Arguments::read();
    let samples = Samples::find(&arguments);
    let mut accuracy = Accuracy::default();
    let times = Table::new(&[
        "mesh",
        "faces",
        "pairs",
        "recorded µs",
        "baseline µs",
        "baseline / recorded",
        "Fast µs",
        "Default µs",
        "Best µs",
        "recorded / Fast",
        "recorded / Default",
        "baseline / Fast",
        "baseline / Default",
        "Best / Default",
        "baseline's lengths within 1 %",
    ]);
    for sample in samples.iter() {
        let found = Found::of(&sample, &samples);
        for kind in Kind::ALL {
            found.print(&sample, kind, &times);
        }
        accuracy.add(&sample.name, &found);
    }
    accuracy.print();
}

/// A pair of points and what each method made of it.
struct Pair {
    kind: Kind,
    from: SurfacePoint,
    to: SurfacePoint,
    record: Option<PairRecord>,
    baseline: Measured,
    ours: [Measured; 3],
}

/// CPU time and length of a path; NaN where there is none.
#[derive(Clone, Copy)]
struct Measured {
    us: f64,
    length: f64,
}

impl Measured {
    const NONE: Self = Self { us: f64::NAN, length: f64::NAN };

    fn of(path: impl FnOnce() -> Option<f64>) -> Self {
        let (ms, length) = clock::cpu_ms(path);
        Self { us: ms * 1e3, length: length.unwrap_or(f64::NAN) }
    }
}

/// All pairs of a mesh.
struct Found(Vec<Pair>);

impl Found {
    fn of(sample: &Sample, samples: &Samples) -> Self {
        let mut pairs = pairs(sample, samples);
        let surface = &sample.surface;
        let mut finder = PathFinder::new();
        for (i, quality) in PathQuality::ALL.into_iter().enumerate() {
            let mut path = |pair: &Pair| {
                Measured::of(|| {
                    let path = finder.shortest_with_quality(surface, &pair.from, &pair.to, quality);
                    path.ok().map(|path| path.length())
                })
            };
            pairs.iter().take(WARM_UP).for_each(|pair| _ = path(pair));
            pairs.iter_mut().for_each(|pair| pair.ours[i] = path(pair));
        }
        let mut baseline = Baseline::new(Mesh::new(&sample.mesh));
        let mut path = |pair: &Pair| Measured::of(|| baseline.path(&pair.from, &pair.to).map(|path| path.length()));
        pairs.iter().take(WARM_UP).for_each(|pair| _ = path(pair));
        pairs.iter_mut().for_each(|pair| pair.baseline = path(pair));
        Self(pairs)
    }

    fn print(&self, sample: &Sample, kind: Kind, table: &Table) {
        let pairs: Vec<&Pair> = self.0.iter().filter(|pair| pair.kind == kind).collect();
        let times = |us: &dyn Fn(&Pair) -> Option<f64>| Times::new(pairs.iter().filter_map(|pair| us(pair)));
        let known = |us: f64| us.is_finite().then_some(us);
        let recorded = times(&|pair| Some(pair.record?.us));
        let [fast, default, best] = [0, 1, 2].map(|i| times(&|pair| known(pair.ours[i].us)));
        let baseline = times(&|pair| known(pair.baseline.us));
        let like = baseline.median().zip(recorded.median()).map(|(baseline, recorded)| baseline / recorded);
        let against = |ours: &Times| table::against_baseline(&baseline, &recorded, ours);
        let compared: Vec<f64> =
            pairs.iter().filter_map(|pair| Some(pair.baseline.length / pair.record?.length - 1.0)).collect();
        let alike = compared.iter().filter(|off| off.abs() < 0.01).count();
        table.row([
            sample.name.clone(),
            sample.surface.face_count().to_string(),
            format!("{} {}", pairs.len(), kind.name()),
            table::number(recorded.median()),
            table::number(baseline.median()),
            table::number(like),
            table::number(fast.median()),
            table::number(default.median()),
            table::number(best.median()),
            table::ratio(&recorded, &fast),
            table::ratio(&recorded, &default),
            against(&fast),
            against(&default),
            table::ratio(&best, &default),
            table::share(alike, compared.len()),
        ]);
    }
}

/// Pairs of consecutive control points; where there are records, only those that were recorded.
fn pairs(sample: &Sample, samples: &Samples) -> Vec<Pair> {
    let mut found = Vec::new();
    for case in &sample.cases {
        for (i, ends) in case.polygon.windows(2).enumerate() {
            let record = samples.records.pair(&sample.name, 3 * case.number + i);
            let (from, to) = (ends[0], ends[1]);
            found.push(Pair { kind: case.kind, from, to, record, baseline: Measured::NONE, ours: [Measured::NONE; 3] });
        }
    }
    if found.iter().any(|pair| pair.record.is_some()) {
        found.retain(|pair| pair.record.is_some());
    }
    found
}

/// How lengths compare with exact distances, sound meshes and the one of needles apart.
#[derive(Default)]
struct Accuracy {
    sound: Vec<Excess>,
    needles: Vec<Excess>,
}

/// By how much a pair's paths are too long, relatively: recorded, baseline, ours; and ours against the recorded.
#[derive(Clone, Copy)]
struct Excess {
    over_exact: Option<[f64; 5]>,
    over_recorded: [f64; 3],
}

impl Accuracy {
    fn add(&mut self, mesh: &str, found: &Found) {
        let group = if mesh.contains("needle") { &mut self.needles } else { &mut self.sound };
        group.extend(found.0.iter().filter_map(|pair| {
            let record = pair.record?;
            let [fast, default, best] = pair.ours.map(|ours| ours.length);
            let lengths = [record.length, pair.baseline.length, fast, default, best];
            Some(Excess {
                over_exact: record.exact.map(|exact| lengths.map(|length| length / exact - 1.0)),
                over_recorded: [fast, default, best].map(|length| length / record.length - 1.0),
            })
        }));
    }

    fn print(&self) {
        let columns = ["recorded", "baseline", "Fast", "Default", "Best"];
        for (name, group) in [("sound meshes", &self.sound), ("needles", &self.needles)] {
            let exact: Vec<[f64; 5]> = group.iter().filter_map(|e| e.over_exact).collect();
            if exact.is_empty() {
                continue;
            }
            println!("\nLengths on {name}, of {} pairs with exact distances:", exact.len());
            let table = Table::new(&["method", "> 0.1 % too long", "> 1 %", "worst", "below exact by > 1e-5"]);
            for (i, column) in columns.into_iter().enumerate() {
                let count =
                    |is: &dyn Fn(f64) -> bool| table::share(exact.iter().filter(|e| is(e[i])).count(), exact.len());
                let worst = exact.iter().map(|e| e[i]).fold(0.0, f64::max);
                table.row([
                    column.into(),
                    count(&|e| e > 1e-3),
                    count(&|e| e > 1e-2),
                    format!("{:.3} %", 100.0 * worst),
                    count(&|e| e < -1e-5),
                ]);
            }
            println!("\nNot longer than the recorded path by more than 1e-5, of {} pairs:", group.len());
            let table = Table::new(&["Fast", "Default", "Best"]);
            table.row(
                [0, 1, 2]
                    .map(|i| table::share(group.iter().filter(|e| e.over_recorded[i] <= 1e-5).count(), group.len())),
            );
        }
    }
}
