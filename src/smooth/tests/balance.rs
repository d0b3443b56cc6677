//! Gauss and Bonnet: what a closed line turns by, and the curvature it goes around, are a full turn together.

use std::collections::HashSet;
use std::f64::consts::{FRAC_PI_2, TAU};

use super::*;
use crate::smooth::{fan::Fan, layout::Layout, metric::Metric, nodes, progress::Watch, strip::Strip};

/// Turn in the strip and curvature of all vertices to the left of it, for lines whose left is what they go around.
///
/// A vertex that the line is at counts for the side on which the strip passes it.
fn balance(surface: &Surface, strip: &Strip) -> Option<f64> {
    let (mut metric, mut layout, mut fan, mut found) =
        (Metric::default(), Layout::default(), Fan::default(), Vec::new());
    layout.build(surface, &mut metric, strip);
    // Where one crossing is at a vertex and the next one at it too, but seen from the other side, there is no turn to speak of.
    nodes::find(surface, &mut metric, strip, &layout, &mut fan, &mut found);
    // A hair beside a vertex a crossing counts as being at it, which costs digits.
    let hair = |t: &f64| (*t > 0.0 && *t < 1e-7) || (*t < 1.0 && *t > 1.0 - 1e-7);
    if strip.at.iter().any(hair) {
        return None;
    }
    let short = |j: usize| layout.stretch(j, &strip.at).length() < 1e-6;
    if found.iter().any(|node| short(node.first) || short(layout.after(node.last))) {
        return None;
    }
    let at_end = |i: usize| strip.at[i] <= 1e-9 || strip.at[i] >= 1.0 - 1e-9;
    if at_end(0) && at_end(strip.len() - 1) {
        return None; // a node may reach over the seam
    }
    let turn: f64 = found.iter().map(|node| node.turn).sum();
    // Faces of the strip, and the vertices to its left that can be reached without crossing it.
    let right: HashSet<u32> = (0..strip.len()).map(|i| strip.end_vertex(surface, i, false)).collect();
    let mut open: Vec<u32> = (0..strip.len()).map(|i| strip.end_vertex(surface, i, true)).collect();
    let mut inside: HashSet<u32> = open.iter().copied().collect();
    if right.intersection(&inside).next().is_some() {
        return None; // it touches itself
    }
    while let Some(vertex) = open.pop() {
        let first = surface.outgoing[vertex as usize];
        let mut h = first;
        loop {
            let other = surface.target(h);
            if !right.contains(&other) && inside.insert(other) {
                open.push(other);
            }
            h = surface.counter_clockwise(h);
            if !h.is_some() || h == first {
                break;
            }
        }
    }
    let enclosed: f64 = inside.iter().filter(|v| !surface.boundary[**v as usize]).map(|v| surface.curvature(*v)).sum();
    Some(turn + enclosed)
}

/// Smooths a ring by everything there is and balances every line on the way.
fn balanced(surface: &Surface, line: &SurfacePolyline, least: usize) {
    let (mut count, mut all) = (0, 0);
    let mut worst = 0.0_f64;
    for (mode, iteration) in [
        (SmoothingMode::Tether { closeness: 10.0 }, Iteration::Solve),
        (SmoothingMode::Geodesic, Iteration::Solve),
        (SmoothingMode::Geodesic, Iteration::Symmetric),
        (SmoothingMode::Geodesic, Iteration::Sequential),
        (SmoothingMode::Stencil { scale: 1.0, passes: 5 }, Iteration::Solve),
        (SmoothingMode::Stencil { scale: 1.0, passes: 5 }, Iteration::Symmetric),
        (SmoothingMode::Budget { share: 0.3 }, Iteration::Symmetric),
    ] {
        let smoothing = Smoothing { roughness: 0.0, iteration, max_sweeps: 300, ..Smoothing::by(mode) };
        let mut workspace = SmoothWorkspace::default();
        let mut see = |strip: &Strip| {
            if strip.len() < 3 {
                return;
            }
            all += 1;
            if let Some(balance) = balance(surface, strip) {
                count += 1;
                worst = worst.max((balance - TAU).abs());
                assert!((balance - TAU).abs() < 1e-9, "{mode:?} {iteration:?}: {}", balance - TAU);
            }
        };
        workspace.prepare(surface, line).unwrap();
        let _ = workspace.run(surface, &smoothing, &mut Watch::seeing(&mut see));
    }
    println!("{count} of {all} lines on the way could be judged, off by at most {worst:e}");
    assert!(count >= least, "{count}");
}

#[test]
fn every_line_on_the_way_balances_on_the_plane() {
    let surface = built(&crate::surface::shapes::grid(40, 40, 1.0, 1.0));
    let around = |k: u32| {
        let a = f64::from(k) * TAU / 40.0;
        DVec3::new(0.503 + 0.3 * a.cos(), 0.497 + 0.3 * a.sin(), 0.0)
    };
    let line = shaken(&surface, &ring(&surface, (0..40).map(around)), &mut Random(1), 0.5);
    balanced(&surface, &line, 300);
}

#[test]
fn every_line_on_the_way_balances_on_a_sphere_and_a_bumpy_one() {
    let mut mesh = crate::surface::shapes::icosphere(4);
    for bumps in [0.0, 0.2] {
        for p in &mut mesh.positions {
            *p *= 1.0 + bumps * (5.0 * p.x).sin() * (4.0 * p.y + 1.0).sin();
        }
        let surface = built(&mesh);
        let around = |k: u32| {
            let a = f64::from(k) * TAU / 30.0 + 0.01;
            DVec3::new(0.6 * a.cos(), 0.6 * a.sin(), 0.83)
        };
        let line = shaken(&surface, &ring(&surface, (0..30).map(around)), &mut Random(2), 0.5);
        balanced(&surface, &line, 200);
    }
}

/// Around a cube's corner, whose angle lacks a right one, three quarters of a turn are left.
#[test]
fn around_a_corner_of_a_cube() {
    let surface = built(&crate::surface::shapes::cube());
    let line = ring(&surface, [DVec3::new(0.4, 0.1, 0.0), DVec3::new(0.0, 0.4, 0.1), DVec3::new(0.1, 0.0, 0.4)]);
    let mut strip = Strip::default();
    line.strip_into(&surface, &mut strip).unwrap();
    let mut layout = Layout::default();
    layout.build(&surface, &mut Metric::default(), &strip);
    let turn: f64 = (0..strip.len()).map(|i| layout.turn(i, &strip.at)).sum();
    assert!((turn.abs() - 3.0 * FRAC_PI_2).abs() < 1e-12, "{turn}");
}

/// A small circle at colatitude ½ turns by 2π cos ½ in all.
#[test]
fn around_a_sphere() {
    let surface = built(&crate::surface::shapes::icosphere(6));
    let around = |k: u32| {
        let a = f64::from(k) * TAU / 400.0 + 1e-3;
        DVec3::new(0.5_f64.sin() * a.cos(), 0.5_f64.sin() * a.sin(), 0.5_f64.cos())
    };
    let line = ring(&surface, (0..400).map(around));
    let mut workspace = SmoothWorkspace::default();
    let metrics = measure(&surface, &mut workspace, &line, None).unwrap();
    // All that is enclosed is sampled by vertices: a row of them more or less.
    assert!((metrics.length - TAU * 0.5_f64.sin()).abs() < 2e-3, "{}", metrics.length);
    let mut strip = Strip::default();
    line.strip_into(&surface, &mut strip).unwrap();
    let mut layout = Layout::default();
    layout.build(&surface, &mut Metric::default(), &strip);
    let turn: f64 = (0..strip.len()).map(|i| layout.turn(i, &strip.at)).sum();
    assert!((turn.abs() - 5.514_013_858_7).abs() < 0.02, "{turn}");
    assert!(matches!(
        smooth(&surface, &mut workspace, &line, &Smoothing::by(SmoothingMode::Geodesic)),
        Err(SmoothError::Collapsed { .. })
    ));
    // It shrinks on the way there.
    let few = Smoothing { iteration: Iteration::Sequential, max_sweeps: 30, ..Smoothing::by(SmoothingMode::Geodesic) };
    let smaller = smooth(&surface, &mut workspace, &line, &few).unwrap();
    assert!(smaller.met_bound && smaller.after.length < 0.999 * metrics.length, "{}", smaller.after.length);
    // The equator is a closed geodesic: one by which the mesh is its own mirror image.
    let around = |k: u32| DVec3::new((f64::from(k) * TAU / 60.0).cos(), (f64::from(k) * TAU / 60.0).sin(), 0.0);
    let equator = ring(&surface, (0..60).map(around));
    let kept = smooth(&surface, &mut workspace, &equator, &Smoothing::by(SmoothingMode::Geodesic)).unwrap();
    assert!((kept.after.length - TAU).abs() < 2e-3, "{}", kept.after.length);
    assert!(kept.line.positions(&surface).iter().all(|p| p.z.abs() < 0.05));
    let around = |k: u32| DVec3::new((f64::from(k) * TAU / 60.0).cos(), (f64::from(k) * TAU / 60.0).sin(), 0.01);
    let equator = ring(&surface, (0..60).map(around));
    for mode in [SmoothingMode::Tether { closeness: 10.0 }, SmoothingMode::Stencil { scale: 1.0, passes: 5 }] {
        let kept = smooth(&surface, &mut workspace, &equator, &Smoothing::by(mode)).unwrap();
        assert!((kept.after.length - TAU).abs() < 5e-3, "{mode:?}: {}", kept.after.length);
    }
}
