//! What does smoothing cost in distance, by which mode? A table and a plot.
//!
//! ```text
//! cargo run --release --no-default-features --features formats --example smoothing_report -- docs/smoothing.svg [MESH...]
//! ```
//!
//! One should see a line for each mode and setting, medians over jagged lines: how much of the squared curvature is left, and how far the
//! line went from where it was drawn, in mean edges. The plot shows the same, lower left being best. Without meshes it makes three of its
//! own, so that the plot can be made anew by anyone.

mod plot;
mod walks;

use std::{collections::BTreeMap, error::Error, path::Path, process::ExitCode};

use bevy_surface_splines::{
    format,
    smooth::{SmoothError, SmoothWorkspace, Smoothed, Smoothing, SmoothingMode, smooth_into},
    surface::{FaceId, Surface, SurfaceOptions, shapes},
};

/// Lines a mesh.
const LINES: usize = 60;
const SEED: u64 = 1;

/// Medians of a mode with a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) mode: &'static str,
    pub(crate) setting: f64,
    /// What is left of the squared curvature.
    pub(crate) square: f64,
    /// Largest distance from the line given, in mean edges.
    pub(crate) distance: f64,
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "smoothing.svg".to_owned());
    match report(Path::new(&file), &arguments.collect::<Vec<_>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn report(file: &Path, meshes: &[String]) -> Result<(), Box<dyn Error>> {
    let surfaces = if meshes.is_empty() { made()? } else { read(meshes)? };
    let mut found: BTreeMap<usize, Vec<[f64; 2]>> = BTreeMap::new();
    let mut lost = 0;
    let settings = settings();
    for surface in &surfaces {
        let mean = surface.mean_edge_length(FaceId(0)).unwrap_or(1.0);
        let (mut workspace, mut out) = (SmoothWorkspace::default(), Smoothed::blank());
        for line in walks::lines(surface, LINES, SEED) {
            let mut pairs = Vec::with_capacity(settings.len());
            for (_, mode) in &settings {
                match smooth_into(surface, &mut workspace, &line, &Smoothing::by(*mode), &mut out) {
                    Ok(()) => pairs.push([
                        out.after.square_curvature / out.before.square_curvature,
                        out.after.max_distance / mean,
                    ]),
                    Err(SmoothError::Collapsed { .. }) => break,
                    Err(error) => return Err(error.into()),
                }
            }
            // Modes are compared by the same lines: by those that none of them made a point of.
            if pairs.len() == settings.len() {
                pairs.into_iter().enumerate().for_each(|(k, pair)| found.entry(k).or_default().push(pair));
            } else {
                lost += 1;
            }
        }
    }
    println!("| mode | setting | square curvature left | largest distance, mean edges |\n|---|---|---|---|");
    let mut entries = Vec::new();
    for (k, (setting, mode)) in settings.iter().enumerate() {
        let of = |which: usize| median(found.get(&k).into_iter().flatten().map(|pair| pair[which]).collect());
        let name = if matches!(mode, SmoothingMode::Budget { .. }) { "plain" } else { mode.name() };
        let entry = Entry { mode: name, setting: *setting, square: of(0), distance: of(1) };
        println!("| {name} | {setting} | {:.5} | {:.3} |", entry.square, entry.distance);
        entries.push(entry);
    }
    println!(
        "\n{} surfaces, {LINES} lines each, seed {SEED}; {lost} of them closed ones that shrank to a point by some mode, and are left out",
        surfaces.len()
    );
    std::fs::write(file, plot::svg(&entries))?;
    println!("{}", file.display());
    Ok(())
}

fn made() -> Result<Vec<Surface>, Box<dyn Error>> {
    let mut bumpy = shapes::icosphere(5);
    for p in &mut bumpy.positions {
        *p *= 1.0 + 0.2 * (5.0 * p.x).sin() * (4.0 * p.y + 1.0).sin() * (6.0 * p.z + 2.0).sin();
    }
    let meshes = [bumpy, shapes::torus(2.0, 0.7, 120, 60), shapes::grid(70, 70, 1.0, 1.0)];
    meshes.iter().map(|mesh| Ok(Surface::build(mesh, &SurfaceOptions::default())?)).collect()
}

fn read(meshes: &[String]) -> Result<Vec<Surface>, Box<dyn Error>> {
    let surface = |path: &String| Ok(Surface::build(&format::read_mesh(path)?, &SurfaceOptions::default())?);
    meshes.iter().map(surface).collect()
}

/// Five settings of each mode; plain are sweeps until so much of the turns is left.
fn settings() -> Vec<(f64, SmoothingMode)> {
    let mut all = Vec::new();
    all.extend([0.8, 0.6, 0.4, 0.2, 0.1].map(|share| (share, SmoothingMode::Budget { share })));
    all.extend([1.0, 0.75, 0.5, 0.25, 0.1].map(|scale| (scale, SmoothingMode::Stencil { scale, passes: 5 })));
    let weights = [0.1, 1.0, 10.0, 100.0, 1000.0];
    all.extend(weights.map(|closeness| (closeness, SmoothingMode::Tether { closeness })));
    all.extend(weights.map(|weight| (weight, SmoothingMode::Lift { weight })));
    all.extend(weights.map(|weight| (weight, SmoothingMode::Conformal { weight })));
    all
}

fn median(mut values: Vec<f64>) -> f64 {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
