//! How long does a curve take? Random and local control polygons on all reference meshes, beside the paper's method and what
//! was recorded of the paper's own program.
//!
//! CPU time of one thread, medians; like is compared with like: the points alone, without joining them by geodesics, which
//! has a column of its own. Each method goes over all curves by itself, after a few to warm up.

mod baseline;
mod common;

use baseline::{Baseline, curves::Uniform, mesh::Mesh};
use bevy_surface_splines::{
    curve::{Scheme, Tracer},
    geodesic::PathQuality,
    surface::SurfacePoint,
};
use common::{
    arguments::Arguments,
    clock,
    records::CurveRecord,
    samples::{Case, Kind, Sample, Samples},
    stats::Times,
    table::{self, Table},
};

/// Curves to trace before the clock counts.
const WARM_UP: usize = 3;

/// A scheme under its three names.
struct Compared {
    title: &'static str,
    recorded: &'static str,
    ours: Scheme,
    baseline: Uniform,
}

const SCHEMES: [Compared; 2] = [
    Compared {
        title: "Lane–Riesenfeld, 6 levels, 67 points",
        recorded: "olr_uniform6",
        ours: Scheme::lane_riesenfeld(),
        baseline: Uniform::LaneRiesenfeld,
    },
    Compared {
        title: "Recursive de Casteljau, 4 levels, 48 legs",
        recorded: "rdc_uniform4",
        ours: Scheme::de_casteljau(),
        baseline: Uniform::DeCasteljau,
    },
];

fn main() {
    let arguments = Arguments::read();
    let samples = Samples::find(&arguments);
    for scheme in &SCHEMES {
        println!("\n{}:", scheme.title);
        let table = Table::new(&[
            "mesh",
            "faces",
            "curves",
            "recorded ms",
            "baseline ms",
            "baseline / recorded",
            "Fast ms",
            "Default ms",
            "Default joined ms",
            "recorded / Fast",
            "recorded / Default",
            "baseline / Fast",
            "baseline / Default",
            "lengths within 1 % of recorded: baseline",
            "Default",
        ]);
        for sample in samples.iter() {
            let curves = traced(&sample, &samples, scheme);
            for kind in Kind::ALL {
                print(&sample, kind, &curves, &table);
            }
        }
    }
}

/// What the methods made of a control polygon: milliseconds, and lengths.
struct Curve {
    case: Case,
    record: Option<CurveRecord>,
    fast: Option<f64>,
    default: Option<f64>,
    joined: Option<f64>,
    length: Option<f64>,
    baseline: Option<f64>,
    baseline_length: Option<f64>,
}

fn traced(sample: &Sample, samples: &Samples, scheme: &Compared) -> Vec<Curve> {
    let mut curves: Vec<Curve> = sample
        .cases
        .iter()
        .map(|case| Curve {
            record: samples.records.curve(&sample.name, case.number, scheme.recorded),
            case: case.clone(),
            fast: None,
            default: None,
            joined: None,
            length: None,
            baseline: None,
            baseline_length: None,
        })
        .collect();
    if curves.iter().any(|curve| curve.record.is_some()) {
        curves.retain(|curve| curve.record.is_some());
    }

    let mut tracer = Tracer::new(&sample.surface);
    let mut out = Vec::new();
    let mut points = |curve: &Curve, quality: PathQuality| {
        let scheme = scheme.ours.with_quality(quality);
        let (ms, result) = clock::cpu_ms(|| tracer.trace_points(&curve.case.polygon, &scheme, &mut out));
        result.is_ok().then_some(ms)
    };
    curves.iter().take(WARM_UP).for_each(|curve| _ = points(curve, PathQuality::Fast));
    curves.iter_mut().for_each(|curve| curve.fast = points(curve, PathQuality::Fast));
    curves.iter().take(WARM_UP).for_each(|curve| _ = points(curve, PathQuality::Default));
    curves.iter_mut().for_each(|curve| curve.default = points(curve, PathQuality::Default));
    for curve in &mut curves {
        let (ms, trace) = clock::cpu_ms(|| tracer.trace(&curve.case.polygon, &scheme.ours));
        if let Ok(trace) = trace {
            (curve.joined, curve.length) = (Some(ms), Some(trace.length()));
        }
    }
    trace_baseline(sample, scheme, &mut curves);
    curves
}

fn trace_baseline(sample: &Sample, scheme: &Compared, curves: &mut [Curve]) {
    let mut baseline = Baseline::new(Mesh::new(&sample.mesh));
    let mut points = |curve: &Curve| -> (f64, Option<Vec<SurfacePoint>>) {
        clock::cpu_ms(|| baseline.curve(&curve.case.polygon, scheme.baseline))
    };
    curves.iter().take(WARM_UP).for_each(|curve| _ = points(curve));
    let found: Vec<_> = curves.iter().map(points).collect();
    for (curve, (ms, points)) in curves.iter_mut().zip(found) {
        if let Some(points) = points {
            curve.baseline = Some(ms);
            curve.baseline_length = baseline.joined_length(&points);
        }
    }
}

fn print(sample: &Sample, kind: Kind, curves: &[Curve], table: &Table) {
    let curves: Vec<&Curve> = curves.iter().filter(|curve| curve.case.kind == kind).collect();
    let times = |ms: &dyn Fn(&Curve) -> Option<f64>| Times::new(curves.iter().filter_map(|curve| ms(curve)));
    let recorded = times(&|curve| Some(curve.record?.ms));
    let baseline = times(&|curve| curve.baseline);
    let (fast, default) = (times(&|curve| curve.fast), times(&|curve| curve.default));
    let alike = |length: &dyn Fn(&Curve) -> Option<f64>| {
        let off = curves.iter().filter_map(|curve| Some(length(curve)? / curve.record?.length - 1.0));
        let off: Vec<f64> = off.collect();
        table::share(off.iter().filter(|off| off.abs() < 0.01).count(), off.len())
    };
    table.row([
        sample.name.clone(),
        sample.surface.face_count().to_string(),
        format!("{} {}", curves.len(), kind.name()),
        table::number(recorded.median()),
        table::number(baseline.median()),
        table::ratio(&baseline, &recorded),
        table::number(fast.median()),
        table::number(default.median()),
        table::number(times(&|curve| curve.joined).median()),
        table::ratio(&recorded, &fast),
        table::ratio(&recorded, &default),
        table::against_baseline(&baseline, &recorded, &fast),
        table::against_baseline(&baseline, &recorded, &default),
        alike(&|curve| curve.baseline_length),
        alike(&|curve| curve.length),
    ]);
}
