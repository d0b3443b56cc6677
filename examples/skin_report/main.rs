//! Binds SVG drawings to handles spread over them, poses them at random, and measures what becomes of them.
//!
//! ```text
//! cargo run --release --no-default-features --features svg,parallel --example skin_report -- drawings/ --handles 4
//! ```
//!
//! One should see, for each drawing, its curves and joins, what binding, a pose and a flexible pose take, how well joins are kept, and the
//! energy of our curves beside those of naive ways; last `N passed, M failed`. A drawing passes if all poses are finite and keep their joins,
//! single precision is near to double, free ratios are never worse, and nothing is nearer to the skinned curves than loose segments. It ends
//! with status 0 if nothing failed, 1 if something did, 2 if it could not do what was asked.

mod args;
mod measure;
mod report;
mod rig;

use std::{env, error::Error, process::ExitCode};

use args::Args;

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

/// Does drawing after drawing.
fn run(args: &Args) -> Result<ExitCode, Box<dyn Error>> {
    let files = args.files()?;
    let mut csv = args.csv.as_deref().map(report::CsvWriter::new).transpose()?;
    let (mut passed, mut failed) = (0, 0);
    for file in &files {
        let outcome = report::Outcome::of(file, args.handles, args.poses);
        print!("{outcome}");
        if let Some(csv) = &mut csv {
            csv.write(&outcome)?;
        }
        if outcome.passed() { passed += 1 } else { failed += 1 }
    }
    println!("{passed} passed, {failed} failed");
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
