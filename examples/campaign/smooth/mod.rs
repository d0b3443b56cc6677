//! Smooths many jagged lines on many meshes, and judges every one.

mod judge;
mod lines;
mod settings;
mod table;

use std::{
    error::Error,
    fs::File,
    io::{BufWriter, Write},
    panic::{AssertUnwindSafe, catch_unwind},
    process::ExitCode,
};

use bevy_surface_splines::{
    smooth::{SmoothError, SmoothWorkspace, Smoothed, Smoothing, SurfacePolyline, smooth},
    surface::{Repair, Surface},
};

use crate::{
    args::Args,
    clock::CpuClock,
    prepare::{self, PrepareError, Prepared},
};
use judge::Judge;
use lines::{Kind, Line};
use settings::Setting;
use table::{Case, Table};

const HEADING: &str = "mesh,case,kind,boundary,mode,setting,ms,crossings,crossings_after,length,length_after,turn,turn_after,\
                       square,square_after,max_distance,mean_distance,max_missed,rounds,steps,flips,kept,status";

/// Does mesh after mesh.
pub(crate) fn campaign(args: &Args) -> Result<ExitCode, Box<dyn Error>> {
    let settings = settings::of_mode(&args.mode);
    let mut csv = args.csv.as_ref().map(|path| File::create(path).map(BufWriter::new)).transpose()?;
    if let Some(csv) = &mut csv {
        writeln!(csv, "{HEADING}")?;
    }
    let mut table = Table::default();
    for file in prepare::mesh_files(&args.meshes) {
        let mut mesh = match Prepared::new(&file.path, args) {
            Ok(mesh) => mesh,
            Err(PrepareError::Mesh(reason)) => {
                println!("{}: refused: {reason}", file.path.display());
                continue;
            }
            Err(error @ PrepareError::Cases(_)) => return Err(error.into()),
        };
        // What cannot be oriented is cut somewhere: lines end there, as at a boundary.
        let report = mesh.surface.report();
        let cuts: Vec<_> = report.places.iter().filter(|(repair, _)| *repair == Repair::Cut).map(|(_, p)| *p).collect();
        mesh.topology.open(&cuts);
        let mut workspace = SmoothWorkspace::default();
        let lines = lines::of_mesh(&mesh, args, &mut workspace);
        let mut found = Table::default();
        for setting in &settings {
            for line in &lines {
                let case = one(&mesh, &mut workspace, line, setting);
                if let Some(csv) = &mut csv {
                    case.write(csv, &mesh.name)?;
                }
                if case.failed() {
                    println!(
                        "  FAILED {} {} {:?} {}: {}",
                        mesh.name,
                        line.number,
                        line.kind,
                        setting.name(),
                        case.status
                    );
                }
                found.add(case);
            }
        }
        println!("{}: {} lines: {}", mesh.name, lines.len(), found.summary());
        found.leave_out();
        table.merge(found);
    }
    if let Some(csv) = &mut csv {
        csv.flush()?;
    }
    println!("\noverall, seed {}", args.seed);
    table.print();
    println!("{} passed, {} failed", table.passed(), table.failed());
    Ok(if table.failed() > 0 { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Smooths one line and judges it; a panic of what is tested is a failed case.
fn one(mesh: &Prepared, workspace: &mut SmoothWorkspace, line: &Line, setting: &Setting) -> Case {
    let surface = &mesh.surface;
    let clock = CpuClock::start();
    let options = &setting.smoothing;
    let done = catch_unwind(AssertUnwindSafe(|| smooth(surface, workspace, &line.line, options)));
    let ms = clock.ms();
    let mean = line.mean_edge;
    let mut case = Case::new(line, setting, ms, mean);
    match done {
        Err(_) => {
            *workspace = SmoothWorkspace::default();
            case.status = "panic".to_owned();
        }
        Ok(Err(SmoothError::Collapsed { .. })) if line.line.is_closed() => {
            case.status = "collapsed".to_owned();
            // A line that nothing held before may be tethered by nothing: that is no failure.
        }
        Ok(Err(error)) => case.status = error.to_string(),
        Ok(Ok(smoothed)) => {
            let verdict = Judge { topology: &mesh.topology }.judge(line, &smoothed, setting);
            case.set(&smoothed);
            case.status = match verdict {
                Ok(()) => "ok".to_owned(),
                Err(reason) => reason,
            };
            if case.status == "ok" && line.kind == Kind::Trace {
                case.status = trace(surface, workspace, line, &smoothed, options);
            }
        }
    }
    case
}

/// What is smooth already keeps its length and its place, and moves no farther when it is smoothed again.
fn trace(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    line: &Line,
    smoothed: &Smoothed,
    options: &Smoothing,
) -> String {
    let grown = (smoothed.after.length / smoothed.before.length - 1.0).abs();
    if grown > 1e-6 {
        return format!("a trace's length changed by {grown:.1e} of it (total turn {:.2})", smoothed.before.total_turn);
    }
    if smoothed.after.max_distance > 0.1 * line.mean_edge {
        return format!("a trace moved by {:.3} mean edges", smoothed.after.max_distance / line.mean_edge);
    }
    again(surface, workspace, &smoothed.line, smoothed.after.max_distance, line.mean_edge, options)
}

fn again(
    surface: &Surface,
    workspace: &mut SmoothWorkspace,
    once: &SurfacePolyline,
    moved: f64,
    mean: f64,
    options: &Smoothing,
) -> String {
    match smooth(surface, workspace, once, options) {
        Ok(twice) if twice.after.max_distance <= moved + 1e-6 * mean => "ok".to_owned(),
        Ok(twice) => format!("moved by {:.3e} at first, and then by {:.3e}", moved, twice.after.max_distance),
        Err(error) => format!("a second time: {error}"),
    }
}
