//! What a bench is asked on its command line.

use std::{env, process};

/// What to run: `--quick` for seconds of work instead of minutes, `--mesh NAME` (again and again) for some meshes only.
#[derive(Clone, Debug, Default)]
pub(crate) struct Arguments {
    pub(crate) quick: bool,
    /// Empty: all.
    meshes: Vec<String>,
}

impl Arguments {
    /// Reads the command line; what is not understood ends the program with status 2.
    pub(crate) fn read() -> Self {
        let mut found = Self::default();
        let mut words = env::args().skip(1);
        while let Some(word) = words.next() {
            match word.as_str() {
                "--quick" => found.quick = true,
                "--mesh" => match words.next() {
                    Some(name) => found.meshes.push(name),
                    None => refuse("--mesh needs a name"),
                },
                "--bench" | "--test" => {} // `cargo bench` and `cargo test` say which of them calls
                other => refuse(&format!("{other:?} is not understood")),
            }
        }
        found
    }

    pub(crate) fn wants(&self, mesh: &str) -> bool {
        self.meshes.is_empty() || self.meshes.iter().any(|name| name == mesh)
    }

    /// Whether meshes were named.
    pub(crate) fn names_meshes(&self) -> bool {
        !self.meshes.is_empty()
    }
}

fn refuse(reason: &str) -> ! {
    eprintln!("{reason}; usage: [--quick] [--mesh NAME]...");
    process::exit(2)
}
