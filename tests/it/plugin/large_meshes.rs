//! Drags on a model of 1.4 million faces: how long frames work, and when what comes.

use std::sync::Arc;
use std::time::Instant;

use bevy::prelude::*;
use bevy_surface_splines::curve::{Spline, TraceWorkspace};
use bevy_surface_splines::plugin::TraceStatistics;
use bevy_surface_splines::plugin::testing::{headless_app, update_until};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::{Surface, SurfacePoint};

use super::drags::bits;

/// How many steps a drag has, each of this share of the diagonal.
const STEPS: u32 = 40;
const STEP: f64 = 0.002;
/// Time between frames, in milliseconds.
const FRAME: f64 = 16.0;

/// The reference's model, and its control polygons: 100 that span it, 20 that do not.
fn reference() -> Option<(Arc<Surface>, Vec<[SurfacePoint; 4]>)> {
    let folder = std::env::var_os("SURFACE_REFERENCE").map(std::path::PathBuf::from)?;
    let surface = Surface::from_file(folder.join("meshes/armadillo_1384k.ply")).ok()?;
    let text = std::fs::read_to_string(folder.join("cases/armadillo_1384k.txt")).ok()?;
    let polygon = |line: &str| {
        let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let point = |i: usize| {
            let [face, u, v] = [numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]];
            surface.point(FaceId(face as u32), [1.0 - u - v, u, v]).expect("a point")
        };
        (numbers.len() == 12).then(|| std::array::from_fn(point))
    };
    let polygons = text.lines().filter_map(polygon).collect();
    Some((Arc::new(surface), polygons))
}

/// Times in milliseconds.
#[derive(Default)]
struct Times(Vec<f64>);

impl Times {
    fn summary(&mut self) -> String {
        self.0.sort_by(f64::total_cmp);
        let at = |share: usize| self.0.get(self.0.len() * share / 100).copied().unwrap_or(0.0);
        let most = self.0.last().copied().unwrap_or(0.0);
        format!("median {:.2}, 95 % {:.2}, 99 % {:.2}, most {most:.2}", at(50), at(95), at(99))
    }
}

#[derive(Default)]
struct Report {
    /// What frames took as a whole, and those before the drag, in which nothing happens.
    frames: Times,
    idle: Times,
    /// What tracing took of that.
    own: Times,
    /// What came with how many frames between.
    shown: u32,
    traced: u32,
    /// From the last step to the exact trace.
    rest: Times,
}

/// Drags a control point of a spline through four points, one step a frame, by messages as drags send them.
fn drag(surface: &Arc<Surface>, polygon: &[SurfacePoint; 4], kind: ControlKind, join: Join, report: &mut Report) {
    let mut app = headless_app();
    let stage = app.world_mut().spawn(BuiltSurface(surface.clone())).id();
    let mut workspace = TraceWorkspace::default();
    let finder = &mut workspace.finder;
    let mut spline = Spline::smooth_through(surface, finder, polygon, false).expect("a spline");
    for anchor in 0..4 {
        spline.apply(surface, finder, &SplineEdit::SetJoin { anchor, join }).expect("a join");
    }
    let entity = app.world_mut().spawn((OnSurface(stage), SurfaceSpline::new(spline.clone()), Editable)).id();
    app.update();
    app.insert_resource(TraceBudget::default());
    for _ in 0..10 {
        let begin = Instant::now();
        app.update();
        report.idle.0.push(begin.elapsed().as_secs_f64() * 1e3);
    }
    let goal = surface.position(&polygon[3]);
    let mut place = kind.point(&spline).expect("a control point");
    let gesture = GestureId::next();
    for _ in 0..STEPS {
        let at = surface.position(&place);
        let towards = at + (goal - at).normalize_or_zero() * STEP * surface.diagonal();
        place = surface.closest_point(towards).expect("a place").point;
        app.world_mut().write_message(EditSpline::new(entity, kind.moved(place)).in_gesture(gesture));
        let before = app.world().get::<SplineTrace>(entity).map(|trace| Arc::as_ptr(trace.trace()));
        let shown = app.world().get::<TracePreview>(entity).map(|preview| preview.polyline().as_ptr());
        app.insert_resource(TraceStatistics::default());
        let begin = Instant::now();
        app.update();
        let took = begin.elapsed().as_secs_f64() * 1e3;
        report.frames.0.push(took);
        report.own.0.push(app.world().resource::<TraceStatistics>().milliseconds);
        let trace = app.world().get::<SplineTrace>(entity).map(|trace| Arc::as_ptr(trace.trace()));
        let preview = app.world().get::<TracePreview>(entity).map(|preview| preview.polyline().as_ptr());
        report.traced += u32::from(trace != before);
        report.shown += u32::from(trace != before || preview.is_some() && preview != shown);
        std::thread::sleep(std::time::Duration::from_secs_f64((FRAME - took).max(0.0) * 1e-3));
    }
    let begin = Instant::now();
    assert!(update_until(&mut app, |world| {
        world.get::<PendingEdit>(entity).is_none() && world.get(entity) == Some(&SplineState::Ready)
    }));
    report.rest.0.push(begin.elapsed().as_secs_f64() * 1e3);
    let spline = app.world().get::<SurfaceSpline>(entity).expect("a spline");
    let scratch = spline.trace(surface, &mut workspace, None).expect("a trace");
    let trace = app.world().get::<SplineTrace>(entity).expect("a trace");
    assert_eq!(bits(trace.trace()), bits(&scratch));
    assert_eq!(kind.point(spline).map(|p| surface.position(&p)), Some(surface.position(&place)));
}

#[test]
fn no_frame_waits_on_a_large_mesh() {
    let Some((surface, polygons)) = reference() else {
        println!("skipped: set SURFACE_REFERENCE to the reference's folder");
        return;
    };
    let handle = ControlKind::Handle(1, HandleSide::Outgoing);
    for (name, polygons) in [("local", &polygons[100..104]), ("spanning", &polygons[..4])] {
        for (what, kind, join) in [
            ("anchor", ControlKind::Anchor(1), Join::Smooth),
            ("handle", handle, Join::Smooth),
            ("automatic anchor", ControlKind::Anchor(1), Join::Automatic),
        ] {
            let mut report = Report::default();
            polygons.iter().for_each(|polygon| drag(&surface, polygon, kind, join, &mut report));
            let [frames, rest, idle, own] =
                [&mut report.frames, &mut report.rest, &mut report.idle, &mut report.own].map(Times::summary);
            let steps = report.frames.0.len();
            println!(
                "{name} {what}: frames {frames} ms (idle {idle} ms; own tracing {own} ms); {} of {steps} show something new, {} a trace; rest {rest} ms",
                report.shown, report.traced
            );
            assert!(report.own.0[steps / 2] < 4.0, "most frames work less than 4 ms");
        }
    }
}
