//! Traces many curves, and finds many shortest paths, on many meshes; an independent checker judges every one.
//!
//! The robustness experiment of the b/Surf paper (Mancinelli, Nazzaro, Pellacini and Puppo 2022, sec. 6.1) on any meshes:
//!
//! ```text
//! cargo run --release --no-default-features --features formats --example campaign -- meshes/ --random 100 --csv curves.csv
//! ```
//!
//! One should see a line a mesh and scheme with times, and last `N passed, M failed`; `--help` lists the options. It ends with
//! status 0 if nothing failed, 1 if something did, 2 if it could not do what was asked, 3 if a case did not end.

mod args;
mod cases;
mod checker;
mod clock;
mod compare;
mod csv;
mod hash;
mod judge;
mod outcome;
mod prepare;
mod random;
mod reference;
mod report;
mod run;
mod scheme;
mod smooth;
mod stats;
mod tally;
mod watchdog;
mod worker;

use std::{env, error::Error, process::ExitCode};

use args::Args;
use csv::CsvWriter;
use prepare::{PrepareError, Prepared};
use reference::Reference;
use report::Report;

fn main() -> ExitCode {
    match Args::parse(env::args().skip(1)) {
        Ok(Some(args)) => {
            if args.smooth > 0 { smooth::campaign(&args) } else { campaign(&args) }.unwrap_or_else(|error| {
                eprintln!("{error}");
                ExitCode::from(2)
            })
        }
        Ok(None) => {
            print!("{}", args::usage());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}\n\n{}", args::usage());
            ExitCode::from(2)
        }
    }
}

/// Does mesh after mesh: load and prepare, run, judge, report.
fn campaign(args: &Args) -> Result<ExitCode, Box<dyn Error>> {
    let reference = Reference::find(args)?;
    let curves = args.cases.is_some() || args.random > 0;
    let csv = args.csv.as_ref().map(|path| CsvWriter::new(path, curves, args.pairs.is_some()));
    let mut csv = csv.transpose()?;
    let mut report = Report::default();
    for file in prepare::mesh_files(&args.meshes) {
        let mesh = match Prepared::new(&file.path, args) {
            Ok(mesh) => mesh,
            Err(PrepareError::Mesh(reason)) => {
                report.refused(&file.path, &reason, file.named);
                continue;
            }
            Err(error @ PrepareError::Cases(_)) => return Err(error.into()),
        };
        let mut outcomes = run::run(&mesh, args);
        reference.fail_undercuts(&mesh.name, &mut outcomes);
        if let Some(csv) = &mut csv {
            csv.write(&mesh.name, &args.schemes, &outcomes)?;
        }
        report.mesh(&mesh, &outcomes, &reference, args);
    }
    let all = report.finish(args);
    if all.total() == 0 && report.refused_by_name == 0 {
        return Err("no case was run: the meshes have no cases of their names, or there are no meshes".into());
    }
    Ok(if all.failed > 0 || report.refused_by_name > 0 { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
