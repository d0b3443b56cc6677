//! How long does a step of a drag take? 200 seeded steps, each a straightest walk of 0.2 % of the diagonal, of anchors and
//! handles of curves on the largest reference mesh, and of local ones on a mesh four times as fine made of it.
//!
//! Wall time, on two cores where the library is parallel. A step is the edit, which a frame waits for, and the new trace, in
//! which what the edit did not touch is reused; beside it the preview that is traced with `PathQuality::Fast`. After every
//! step the trace is compared with a full one from fresh memory, bit for bit.

mod common;

use bevy_surface_splines::{
    curve::{HandleSide, Scheme, Spline, Trace, TraceWorkspace},
    geodesic::PathQuality,
    surface::{Surface, SurfaceOptions, SurfacePoint},
};
use common::{
    arguments::Arguments,
    clock,
    drag::{Drag, Grip},
    made,
    samples::{Case, Kind, Samples},
    stats::Times,
    table::{self, Table},
    threads,
};

/// Steps of all drags of a row together.
const STEPS: usize = 200;
/// Curves of a row.
const CURVES: usize = 4;

/// What is dragged.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    /// One segment with the case's control polygon.
    Curve,
    /// Three segments smoothly through the case's four points, of which a middle anchor is dragged.
    Chain,
}

fn main() {
    let arguments = Arguments::read();
    let samples = Samples::find(&arguments);
    let steps = if arguments.quick { 16 } else { STEPS };
    let Some(sample) = samples.largest() else { return };
    let table = Table::new(&[
        "mesh",
        "faces",
        "dragged",
        "steps",
        "edit ms 50 %",
        "99 %",
        "max",
        "trace ms 50 %",
        "95 %",
        "99 %",
        "max",
        "full trace ms 50 %",
        "preview ms 50 %",
        "95 %",
        "max",
        "incremental equals full",
    ]);
    let measure = |name: &str, surface: &Surface, kind: Kind, shape: Shape| {
        let times = threads::on(2, || dragged(surface, &sample.cases, kind, shape, steps));
        times.print(name, surface, kind, shape, &table);
    };
    measure(&sample.name, &sample.surface, Kind::Local, Shape::Curve);
    measure(&sample.name, &sample.surface, Kind::Local, Shape::Chain);
    measure(&sample.name, &sample.surface, Kind::Random, Shape::Curve);

    let fine = Surface::build(&made::refined(&sample.mesh), &SurfaceOptions::default());
    let fine = fine.unwrap_or_else(|error| panic!("{error}"));
    let on_fine: Vec<Case> = sample.cases.iter().map(|case| moved(&sample.surface, &fine, case)).collect();
    for shape in [Shape::Curve, Shape::Chain] {
        let times = threads::on(2, || dragged(&fine, &on_fine, Kind::Local, shape, steps));
        times.print(&format!("{}, refined", sample.name), &fine, Kind::Local, shape, &table);
    }
}

/// The case on a finer mesh of the same surface.
fn moved(from: &Surface, to: &Surface, case: &Case) -> Case {
    let point = |p: SurfacePoint| to.closest_point(from.position(&p)).map_or(p, |closest| closest.point);
    Case { polygon: case.polygon.map(point), ..case.clone() }
}

/// Milliseconds of all steps.
#[derive(Default)]
struct Steps {
    edit: Vec<f64>,
    trace: Vec<f64>,
    full: Vec<f64>,
    preview: Vec<f64>,
    equal: usize,
    refused: usize,
}

fn dragged(surface: &Surface, cases: &[Case], kind: Kind, shape: Shape, steps: usize) -> Steps {
    let mut found = Steps::default();
    let mut workspace = TraceWorkspace::default();
    for case in cases.iter().filter(|case| case.kind == kind).take(CURVES) {
        let finder = &mut workspace.finder;
        let spline = match shape {
            Shape::Curve => Spline::bezier(surface, finder, case.polygon),
            Shape::Chain => Spline::smooth_through(surface, finder, &case.polygon, false),
        };
        let spline = spline.unwrap_or_else(|error| panic!("case {}: {error}", case.number));
        let spline = spline.with_scheme(Scheme::lane_riesenfeld());
        let anchor = u32::from(shape == Shape::Chain);
        for grip in [Grip::Anchor(anchor), Grip::Handle(anchor, HandleSide::Outgoing)] {
            let drag = Drag::new(grip, case.number as u64);
            found.drag(surface, spline.clone(), drag, steps / CURVES / 2, &mut workspace);
        }
    }
    found
}

impl Steps {
    fn drag(
        &mut self,
        surface: &Surface,
        mut spline: Spline,
        mut drag: Drag,
        steps: usize,
        workspace: &mut TraceWorkspace,
    ) {
        let fast = spline.scheme().with_quality(PathQuality::Fast);
        let mut trace = spline.trace(surface, workspace, None).unwrap_or_else(|error| panic!("{error}"));
        let mut preview = spline.clone().with_scheme(fast).trace(surface, workspace, None).ok();
        for _ in 0..steps {
            let edit = drag.step(surface, &spline);
            let (edit_ms, edited) = clock::wall_ms(|| spline.apply(surface, &mut workspace.finder, &edit));
            if edited.is_err() {
                self.refused += 1;
                continue;
            }
            let rough = spline.clone().with_scheme(fast);
            let (preview_ms, roughly) = clock::wall_ms(|| rough.trace(surface, workspace, preview.as_ref()));
            let (trace_ms, next) = clock::wall_ms(|| spline.trace(surface, workspace, Some(&trace)));
            let mut fresh = TraceWorkspace::default();
            let (full_ms, full) = clock::wall_ms(|| spline.trace(surface, &mut fresh, None));
            let (Ok(next), Ok(full)) = (next, full) else {
                self.refused += 1;
                continue;
            };
            self.edit.push(edit_ms);
            self.trace.push(trace_ms);
            self.full.push(full_ms);
            self.preview.push(preview_ms);
            self.equal += usize::from(same_bits(&next, &full));
            trace = next;
            preview = roughly.ok();
        }
    }

    fn print(self, name: &str, surface: &Surface, kind: Kind, shape: Shape, table: &Table) {
        let count = self.trace.len();
        let [edit, trace, full, preview] = [self.edit, self.trace, self.full, self.preview].map(Times::new);
        let refused = if self.refused > 0 { format!(" ({} refused)", self.refused) } else { String::new() };
        table.row([
            name.to_owned(),
            surface.face_count().to_string(),
            match (kind, shape) {
                (Kind::Local, Shape::Curve) => "local curve".into(),
                (Kind::Local, Shape::Chain) => "local chain".into(),
                (Kind::Random, Shape::Curve) => "spanning curve".into(),
                (Kind::Random, Shape::Chain) => "spanning chain".into(),
            },
            format!("{count}{refused}"),
            table::number(edit.median()),
            table::number(edit.quantile(0.99)),
            table::number(edit.quantile(1.0)),
            table::number(trace.median()),
            table::number(trace.quantile(0.95)),
            table::number(trace.quantile(0.99)),
            table::number(trace.quantile(1.0)),
            table::number(full.median()),
            table::number(preview.median()),
            table::number(preview.quantile(0.95)),
            table::number(preview.quantile(1.0)),
            format!("{} of {count}", self.equal),
        ]);
    }
}

/// Whether two traces are the same to the last bit.
fn same_bits(a: &Trace, b: &Trace) -> bool {
    let bits = |trace: &Trace| {
        let points = trace.segments().iter().flat_map(|segment| segment.points());
        let points: Vec<_> = points.map(|p| (p.face, p.weights.map(f64::to_bits))).collect();
        let positions = trace.positions().into_iter().map(|p| p.to_array().map(f64::to_bits));
        (points, positions.collect::<Vec<_>>())
    };
    a.segments() == b.segments() && bits(a) == bits(b)
}
