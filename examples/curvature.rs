//! Plots the geodesic curvature of a B-spline and of smoothly joined Bézier segments, on finer and finer spheres.
//!
//! ```text
//! cargo run --release --no-default-features --example curvature -- docs/curvature.svg
//! ```
//!
//! One should see two rows of curves, one colour a mesh. The B-spline's run through the knots (dashed), those of the joined
//! segments are torn there, and the finer the mesh the clearer. The largest jumps at knots are printed.

use std::fmt::Write as _;

use bevy_surface_splines::curve::{Scheme, Spline, SplineT, Trace, TraceWorkspace};
use bevy_surface_splines::surface::{FaceId, Surface, SurfaceOptions, SurfacePoint, shapes};
use glam::{DQuat, DVec3};

const HEIGHTS: [f64; 6] = [0.5, -0.4, 0.3, 0.2, -0.6, 0.1];
const COLOURS: [&str; 3] = ["#c9a227", "#d1495b", "#00798c"];
const WIDTH: f64 = 760.0;
const ROW: f64 = 190.0;
/// Curvatures from −HIGHEST to HIGHEST are shown.
const HIGHEST: f64 = 3.5;

type AnyResult<T> = Result<T, Box<dyn std::error::Error>>;

/// Curvature at places of even parameters, a gap at each knot.
type Runs = Vec<Vec<(f64, f64)>>;

fn main() -> AnyResult<()> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "curvature.svg".into());
    let mut svg = String::new();
    writeln!(
        svg,
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {}" font-family="sans-serif" font-size="12">"##,
        2.0 * ROW
    )?;
    writeln!(svg, r##"<rect width="100%" height="100%" fill="#ffffff"/>"##)?;
    for (row, name) in ["B-spline: C²", "smoothly joined Bézier segments: C¹"].into_iter().enumerate() {
        frame(&mut svg, row, name)?;
        for (level, colour) in (5..=7).zip(COLOURS) {
            let surface = Surface::build(&shapes::icosphere(level), &SurfaceOptions::default())?;
            let (runs, jump) = curvatures(&surface, row == 0)?;
            println!("{name}, {} faces: largest jump {jump:.3}", surface.face_count());
            for run in &runs {
                let points: Vec<String> = run.iter().map(|(t, k)| format!("{:.1},{:.1}", x(*t), y(row, *k))).collect();
                writeln!(
                    svg,
                    r##"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="1.5"/>"##,
                    points.join(" ")
                )?;
            }
            let at = 330.0 + 130.0 * f64::from(level - 5);
            writeln!(
                svg,
                r##"<text x="{at}" y="{}" fill="{colour}">{} faces</text>"##,
                top(row) + 16.0,
                surface.face_count()
            )?;
        }
    }
    writeln!(svg, "</svg>")?;
    std::fs::write(&file, svg)?;
    println!("{file}");
    Ok(())
}

/// Where a row begins.
fn top(row: usize) -> f64 {
    row as f64 * ROW
}

fn x(t: f64) -> f64 {
    40.0 + t / 6.0 * (WIDTH - 60.0)
}

fn y(row: usize, curvature: f64) -> f64 {
    top(row) + 0.5 * (ROW + 10.0) - curvature.clamp(-HIGHEST, HIGHEST) / HIGHEST * 0.4 * ROW
}

fn frame(svg: &mut String, row: usize, name: &str) -> std::fmt::Result {
    writeln!(svg, r##"<text x="40" y="{}">{name}</text>"##, top(row) + 16.0)?;
    for value in [-HIGHEST, 0.0, HIGHEST] {
        let at = y(row, value);
        writeln!(svg, r##"<text x="32" y="{:.1}" text-anchor="end" fill="#666">{value}</text>"##, at + 4.0)?;
        writeln!(svg, r##"<line x1="40" x2="{}" y1="{at:.1}" y2="{at:.1}" stroke="#ccc"/>"##, WIDTH - 20.0)?;
    }
    for knot in 0..=6 {
        let (at, from, to) = (x(f64::from(knot)), y(row, HIGHEST), y(row, -HIGHEST));
        writeln!(
            svg,
            r##"<line x1="{at:.1}" x2="{at:.1}" y1="{from:.1}" y2="{to:.1}" stroke="#999" stroke-dasharray="3 3"/>"##
        )?;
    }
    Ok(())
}

/// Curvature along a closed curve, seen with steps of four mean edges, and its largest jump at a knot.
fn curvatures(surface: &Surface, b_spline: bool) -> AnyResult<(Runs, f64)> {
    let mut workspace = TraceWorkspace::default();
    // Turned away from the mesh's own symmetries.
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.7, 0.4, 1.1);
    let point = |(k, height): (usize, &f64)| -> AnyResult<SurfacePoint> {
        let angle = k as f64 / 6.0 * std::f64::consts::TAU;
        let place = turn * DVec3::new(angle.cos(), angle.sin(), *height).normalize();
        Ok(surface.closest_point(place).ok_or("an empty surface")?.point)
    };
    let points = HEIGHTS.iter().enumerate().map(point).collect::<AnyResult<Vec<_>>>()?;
    let spline = if b_spline {
        Spline::b_spline(surface, &points, true)?.with_scheme(Scheme::b_spline().with_levels(9).on_curve())
    } else {
        let spline = Spline::smooth_through(surface, &mut workspace.finder, &points, true)?;
        spline.with_scheme(Scheme::de_casteljau().with_levels(9).on_curve())
    };
    let trace: Trace = spline.trace(surface, &mut workspace, None)?;
    let step = 4.0 * surface.mean_edge_length(FaceId(0))?;
    let mut runs: Runs = Vec::new();
    for (i, segment) in trace.segments().iter().enumerate() {
        // A place nearer to a knot than a step would see both sides of it.
        let margin = step / segment.length();
        let places = (0..=60).map(|k| margin + (1.0 - 2.0 * margin) * f64::from(k) / 60.0);
        let at = |t: f64| Some((t, trace.curvature_at(surface, &mut workspace.finder, SplineT(t), step)?));
        runs.push(places.map(|local| i as f64 + local).filter_map(at).collect());
    }
    let jump = |i: usize| Some((runs[i].last()?.1 - runs[(i + 1) % runs.len()].first()?.1).abs());
    let largest = (0..runs.len()).filter_map(jump).fold(0.0, f64::max);
    Ok((runs, largest))
}
