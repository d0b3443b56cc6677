//! Drawings of the corpus: every segment accounted for, broken files refused. Needs `SURFACE_CORPUS`.

mod bad;
mod corpus;
mod placed;
mod tokens;
mod tree;

use std::path::{Path, PathBuf};

/// The folder of the corpus, or a message that the test is skipped.
fn corpus() -> Option<PathBuf> {
    let folder = std::env::var_os("SURFACE_CORPUS").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: SURFACE_CORPUS is not set");
    }
    folder
}

/// The rows of a comma-separated table without its heading; quotes may hold commas.
fn table(path: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let row = |line: &str| {
        let mut fields = vec![String::new()];
        let mut quoted = false;
        for c in line.chars() {
            match c {
                '"' => quoted = !quoted,
                ',' if !quoted => fields.push(String::new()),
                c => fields.last_mut().expect("there is always one").push(c),
            }
        }
        fields
    };
    text.lines().skip(1).map(row).collect()
}
