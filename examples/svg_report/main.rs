//! Imports SVG drawings and says what became of every segment; with a mesh, also places and traces them.
//!
//! ```text
//! cargo run --release --no-default-features --features svg,formats,parallel --example svg_report -- drawings/ --on bunny.obj
//! ```
//!
//! One should see, for each drawing, its segments by kind as they were found, drawn and left out, the latter with their reasons, and last
//! `N passed, M failed`. It ends with status 0 if nothing failed, 1 if something did, 2 if it could not do what was asked.

mod args;
mod csv;
mod placing;
mod report;

use std::{env, error::Error, process::ExitCode};

use args::Args;
use placing::Stage;

fn main() -> ExitCode {
    match Args::parse(env::args().skip(1)) {
        Ok(Some(args)) => run(&args).unwrap_or_else(|error| {
            eprintln!("{error}");
            ExitCode::from(2)
        }),
        Ok(None) => {
            print!("{}", args::USAGE);
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}\n\n{}", args::USAGE);
            ExitCode::from(2)
        }
    }
}

/// Does drawing after drawing: read, place, report.
fn run(args: &Args) -> Result<ExitCode, Box<dyn Error>> {
    let files = args.files()?;
    let stage = args.on.as_deref().map(Stage::new).transpose()?;
    let mut csv = args.csv.as_deref().map(csv::CsvWriter::new).transpose()?;
    let (mut passed, mut failed) = (0, 0);
    for file in &files {
        let outcome = report::Outcome::of(file, stage.as_ref());
        print!("{outcome}");
        if let Some(csv) = &mut csv {
            csv.write(&outcome)?;
        }
        if outcome.passed() { passed += 1 } else { failed += 1 }
    }
    println!("{passed} passed, {failed} failed");
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
