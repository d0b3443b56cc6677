//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;

use bevy::prelude::*;

pub(crate) const HELP: &str = "\
Usage: editor [FILE] [--scripted-drag [--screenshots DIR] | --tour DIR]

Opens the editor on FILE: a mesh (OBJ, STL, PLY, OFF, glTF or GLB) or a document (RON); without it on the bundled model.

  --tour DIR          uses every tool by itself on the bundled model, leaves a picture of each in DIR, and ends
  --scripted-drag     drags an anchor by itself, checks the pictures of before and after, and ends
  --screenshots DIR   where those pictures go, before.png and after.png; made if it is not there [default: .]
  -h, --help          prints this
";

/// What the editor was asked to do.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub(crate) struct Arguments {
    pub(crate) mesh: Option<PathBuf>,
    /// Where the pictures of the scripted drag go; none without it.
    pub(crate) script: Option<PathBuf>,
    /// Where the pictures of the tour go; none without it.
    pub(crate) tour: Option<PathBuf>,
}

impl Arguments {
    /// Whether the editor is used by itself.
    pub(crate) fn is_scripted(&self) -> bool {
        self.script.is_some() || self.tour.is_some()
    }
}

#[derive(Debug, PartialEq)]
pub(crate) enum Request {
    Run(Arguments),
    Help,
}

pub(crate) fn read(words: impl Iterator<Item = OsString>) -> Result<Request, String> {
    let (mut mesh, mut scripted, mut screenshots, mut tour, mut options_end) = (None, false, None, None, false);
    let mut words = words;
    while let Some(word) = words.next() {
        match word.to_str() {
            Some("--") if !options_end => options_end = true,
            Some("-h" | "--help") if !options_end => return Ok(Request::Help),
            Some("--scripted-drag") if !options_end => scripted = true,
            Some("--tour") if !options_end => {
                tour = Some(PathBuf::from(words.next().ok_or("--tour needs a folder after it")?));
            }
            Some("--screenshots") if !options_end => {
                let folder = words.next().ok_or("--screenshots needs a folder after it")?;
                screenshots = Some(PathBuf::from(folder));
            }
            Some(option) if option.starts_with('-') && !options_end => {
                return Err(format!("there is no option {option}"));
            }
            _ if mesh.is_some() => return Err(format!("one mesh at a time: {} is too much", word.display())),
            _ => mesh = Some(PathBuf::from(word)),
        }
    }
    if screenshots.is_some() && !scripted {
        return Err("--screenshots goes with --scripted-drag".into());
    }
    if tour.is_some() && (scripted || mesh.is_some()) {
        return Err("--tour stands alone: it shows the bundled model".into());
    }
    let script = scripted.then(|| screenshots.unwrap_or_else(|| PathBuf::from(".")));
    Ok(Request::Run(Arguments { mesh, script, tour }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(words: &[&str]) -> Result<Request, String> {
        read(words.iter().map(OsString::from))
    }

    fn run(mesh: Option<&str>, script: Option<&str>) -> Result<Request, String> {
        Ok(Request::Run(Arguments { mesh: mesh.map(PathBuf::from), script: script.map(PathBuf::from), tour: None }))
    }

    #[test]
    fn words_are_understood_or_refused() {
        assert_eq!(of(&[]), run(None, None));
        assert_eq!(of(&["a.obj"]), run(Some("a.obj"), None));
        assert_eq!(of(&["--scripted-drag"]), run(None, Some(".")));
        assert_eq!(of(&["a.obj", "--scripted-drag", "--screenshots", "x"]), run(Some("a.obj"), Some("x")));
        assert_eq!(of(&["--", "--help"]), run(Some("--help"), None));
        assert_eq!(of(&["a", "--help"]), Ok(Request::Help));
        let tour = Some(PathBuf::from("x"));
        assert_eq!(of(&["--tour", "x"]), Ok(Request::Run(Arguments { tour, ..Arguments::default() })));
        for bad in [
            &["-x"][..],
            &["--tour"],
            &["a", "--tour", "x"],
            &["--tour", "x", "--scripted-drag"],
            &["a", "b"],
            &["--screenshots"],
            &["--screenshots", "x"],
        ] {
            assert!(of(bad).is_err(), "{bad:?}");
        }
    }
}
