//! The command line.

use std::path::{Path, PathBuf};

pub(crate) const USAGE: &str = "\
skin_report — binds SVG drawings to handles, poses them, and measures what becomes of them

usage: skin_report SVG_OR_DIR... [options]

  --handles H  so many handles, spread over each drawing (4)
  --poses N    so many random poses (100)
  --csv FILE   writes a line for each drawing
  --help       this text
";

/// What to do.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Args {
    pub(crate) drawings: Vec<PathBuf>,
    pub(crate) handles: usize,
    pub(crate) poses: usize,
    pub(crate) csv: Option<PathBuf>,
}

/// What is wrong with the command line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum ArgsError {
    #[error("name at least one drawing, or a folder of drawings")]
    NoDrawings,
    #[error("{0} needs a value after it")]
    NoValue(String),
    #[error("{0} needs a number from 1 to 10000 after it")]
    NoNumber(String),
    #[error("there is no option {0}")]
    Unknown(String),
    #[error("{0}: there is no such folder, or it holds no drawing")]
    Missing(String),
}

impl Args {
    /// Reads the command line; none if help is asked for.
    pub(crate) fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, ArgsError> {
        let mut args = Self { drawings: Vec::new(), handles: 4, poses: 100, csv: None };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or_else(|| ArgsError::NoValue(argument.clone()));
            let number = |text: String| {
                let number = text.parse().ok().filter(|n| (1..=10_000).contains(n));
                number.ok_or_else(|| ArgsError::NoNumber(argument.clone()))
            };
            match argument.as_str() {
                "--help" | "-h" => return Ok(None),
                "--handles" => args.handles = number(value()?)?,
                "--poses" => args.poses = number(value()?)?,
                "--csv" => args.csv = Some(value()?.into()),
                option if option.starts_with("--") => return Err(ArgsError::Unknown(argument)),
                path => args.drawings.push(path.into()),
            }
        }
        if args.drawings.is_empty() { Err(ArgsError::NoDrawings) } else { Ok(Some(args)) }
    }

    /// The drawings, those of folders in order of their names.
    pub(crate) fn files(&self) -> Result<Vec<PathBuf>, ArgsError> {
        let is_drawing = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("svg"));
        let mut files = Vec::new();
        for path in &self.drawings {
            if !path.is_dir() {
                files.push(path.clone());
                continue;
            }
            let entries = path.read_dir().map_err(|_| ArgsError::Missing(path.display().to_string()))?;
            let mut inside: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(|p| is_drawing(p)).collect();
            if inside.is_empty() {
                return Err(ArgsError::Missing(path.display().to_string()));
            }
            inside.sort();
            files.append(&mut inside);
        }
        Ok(files)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_read() {
        let parse = |line: &str| Args::parse(line.split_whitespace().map(str::to_owned));
        let args = parse("a.svg --handles 7 c.svg --csv d.csv").unwrap().unwrap();
        assert_eq!(args.drawings, [PathBuf::from("a.svg"), PathBuf::from("c.svg")]);
        assert_eq!((args.handles, args.poses, args.csv), (7, 100, Some("d.csv".into())));
        assert_eq!(parse("a.svg --help"), Ok(None));
        assert_eq!(parse(""), Err(ArgsError::NoDrawings));
        assert_eq!(parse("a.svg --csv"), Err(ArgsError::NoValue("--csv".into())));
        assert_eq!(parse("a.svg --poses 0"), Err(ArgsError::NoNumber("--poses".into())));
        assert_eq!(parse("--fast a.svg"), Err(ArgsError::Unknown("--fast".into())));
    }
}
