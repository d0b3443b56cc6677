//! The command line.

use std::path::PathBuf;

use bevy_surface_splines::geodesic::PathQuality;

use crate::scheme::{self, NamedScheme};

const USAGE: &str = "\
campaign — traces many curves (and paths) on many meshes, and judges every one of them

usage: campaign MESH_OR_DIR... [options]

  --cases FILE_OR_DIR    control polygons, one a line: f0 u0 v0  f1 u1 v1  f2 u2 v2  f3 u3 v3
                         (input faces from 0; u and v weigh the face's second and third corner);
                         of a folder, the file with the mesh's stem
  --pairs FILE_OR_DIR    pairs of points to join by shortest paths, likewise: f0 u0 v0  f1 u1 v1
  --random N             N random polygons a mesh, seen from one side (100 if no cases and no pairs are given)
  --seed S               seed of the random polygons (default 1)
  --schemes A,B,…        from the list below; default rdc,olr
  --quality Q            how hard paths are looked for: fast, default or best
  --threads T            worker threads (default 1)
  --timeout SECONDS      CPU time after which a case counts as failed (default 60), of the schemes for comparison as timed
                         out; at ten (for comparison: a hundred) times that the run is given up
  --csv FILE             writes the results; with cases and pairs, those of pairs go to FILE with `.pairs` before its extension
  --reference DIR        a folder with curves.csv and pairs.csv to compare with (default: beside the cases, if there)
  --smooth N             instead of tracing: N random jagged lines a mesh (walks over 200 faces; open, closed, crossing themselves),
                         smoothed and judged
  --mode M               by what they are smoothed: geodesic, stencil, budget, tether (default), lift or conformal;
                         tradeoff: a table of all modes at five settings each
  --hash                 prints one number for the bits of all paths
  --shuffle S            runs the cases in an order shuffled with seed S; reports stay in order
  --fresh                a fresh workspace for every case

Peak memory is the process's: what an allocator keeps from earlier meshes counts. Run a mesh by itself for its own.

Adaptive traces may not turn by more than 5° unless they say which bound they met; how many say so is counted. Of the schemes
for comparison it is counted how many curves are broken and how many timed out; neither is a failure.

schemes:
";

/// What lines can be smoothed by.
pub(crate) const MODES: [&str; 7] = ["geodesic", "stencil", "budget", "tether", "lift", "conformal", "tradeoff"];

/// The help.
pub(crate) fn usage() -> String {
    format!("{USAGE}{}", scheme::table())
}

/// What to do.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Args {
    pub(crate) meshes: Vec<PathBuf>,
    pub(crate) cases: Option<PathBuf>,
    pub(crate) pairs: Option<PathBuf>,
    pub(crate) random: usize,
    pub(crate) seed: u64,
    pub(crate) schemes: Vec<NamedScheme>,
    pub(crate) quality: PathQuality,
    pub(crate) threads: usize,
    pub(crate) timeout_s: f64,
    pub(crate) csv: Option<PathBuf>,
    pub(crate) reference: Option<PathBuf>,
    pub(crate) smooth: usize,
    pub(crate) mode: String,
    pub(crate) hash: bool,
    pub(crate) shuffle: Option<u64>,
    pub(crate) fresh: bool,
}

/// What is wrong with the command line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum ArgsError {
    #[error("no mesh given")]
    NoMesh,
    #[error("unknown option {0}")]
    Unknown(String),
    #[error("{0} needs a value")]
    NoValue(String),
    #[error("{option}: {value:?} is not {expected}")]
    Bad { option: String, value: String, expected: &'static str },
    #[error("unknown scheme {name:?}: known are {}", scheme::known())]
    Scheme { name: String },
}

impl Args {
    /// Reads the arguments after the program's name; none if help is asked for.
    ///
    /// # Errors
    /// [`ArgsError`] names the option and what it expects.
    pub(crate) fn parse(arguments: impl IntoIterator<Item = String>) -> Result<Option<Self>, ArgsError> {
        let mut args = Self {
            meshes: Vec::new(),
            cases: None,
            pairs: None,
            random: 0,
            seed: 1,
            schemes: scheme::DEFAULT.to_vec(),
            quality: PathQuality::Default,
            threads: 1,
            timeout_s: 60.0,
            csv: None,
            reference: None,
            smooth: 0,
            mode: "tether".to_owned(),
            hash: false,
            shuffle: None,
            fresh: false,
        };
        let mut asked_random = false;
        let mut arguments = arguments.into_iter();
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or_else(|| ArgsError::NoValue(argument.clone()));
            match argument.as_str() {
                "--help" | "-h" => return Ok(None),
                "--cases" => args.cases = Some(value()?.into()),
                "--pairs" => args.pairs = Some(value()?.into()),
                "--csv" => args.csv = Some(value()?.into()),
                "--reference" => args.reference = Some(value()?.into()),
                "--random" => {
                    asked_random = true;
                    args.random = number(&argument, value()?, "a number of polygons")?;
                }
                "--seed" => args.seed = number(&argument, value()?, "a whole number")?,
                "--smooth" => args.smooth = number(&argument, value()?, "a number of lines")?,
                "--mode" => {
                    args.mode = value()?;
                    if !MODES.contains(&args.mode.as_str()) {
                        let (option, value) = (argument, args.mode);
                        return Err(ArgsError::Bad { option, value, expected: "a mode" });
                    }
                }
                "--shuffle" => args.shuffle = Some(number(&argument, value()?, "a whole number")?),
                "--threads" => {
                    args.threads = number::<usize>(&argument, value()?, "a number of threads")?.clamp(1, 1024);
                }
                "--quality" => args.quality = quality(&argument, value()?)?,
                "--timeout" => args.timeout_s = seconds(&argument, value()?)?,
                "--schemes" => args.schemes = schemes(&value()?)?,
                "--hash" => args.hash = true,
                "--fresh" => args.fresh = true,
                option if option.starts_with("--") => return Err(ArgsError::Unknown(argument)),
                _ => args.meshes.push(argument.into()),
            }
        }
        if args.meshes.is_empty() {
            return Err(ArgsError::NoMesh);
        }
        if args.cases.is_none() && args.pairs.is_none() && !asked_random && args.smooth == 0 {
            args.random = 100;
        }
        args.schemes.iter_mut().for_each(|named| named.scheme.quality = args.quality);
        Ok(Some(args))
    }
}

fn number<T: std::str::FromStr>(option: &str, value: String, expected: &'static str) -> Result<T, ArgsError> {
    value.parse().map_err(|_| ArgsError::Bad { option: option.to_owned(), value, expected })
}

fn quality(option: &str, value: String) -> Result<PathQuality, ArgsError> {
    match value.as_str() {
        "fast" => Ok(PathQuality::Fast),
        "default" => Ok(PathQuality::Default),
        "best" => Ok(PathQuality::Best),
        _ => Err(ArgsError::Bad { option: option.to_owned(), value, expected: "fast, default or best" }),
    }
}

fn seconds(option: &str, value: String) -> Result<f64, ArgsError> {
    let expected = "a number of seconds between 0.001 and 1000000";
    let seconds: f64 = number(option, value.clone(), expected)?;
    if (1e-3..=1e6).contains(&seconds) {
        Ok(seconds)
    } else {
        Err(ArgsError::Bad { option: option.to_owned(), value, expected })
    }
}

fn schemes(list: &str) -> Result<Vec<NamedScheme>, ArgsError> {
    let find = |name: &str| scheme::find(name).ok_or_else(|| ArgsError::Scheme { name: name.to_owned() });
    list.split(',').map(str::trim).filter(|n| !n.is_empty()).map(find).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Option<Args>, ArgsError> {
        Args::parse(line.split_whitespace().map(str::to_owned))
    }

    #[test]
    fn options_are_read_and_the_default_is_a_hundred_random_polygons() {
        let args = parse("a.ply dir --schemes olr --threads 2 --csv out.csv --hash").unwrap().unwrap();
        assert_eq!((args.meshes.len(), args.random, args.threads, args.hash), (2, 100, 2, true));
        let names = |args: &Args| args.schemes.iter().map(|s| s.name).collect::<Vec<_>>();
        assert_eq!(names(&args), ["olr"]);
        assert_eq!(names(&parse("a.ply").unwrap().unwrap()), ["rdc", "olr"]);
        assert_eq!(names(&parse("a.ply --schemes rcm,,olr-adaptive").unwrap().unwrap()), ["rcm", "olr-adaptive"]);
        assert_eq!(parse("a.ply --cases c").unwrap().unwrap().random, 0);
        assert_eq!(parse("--help"), Ok(None));
    }

    #[test]
    fn mistakes_are_named() {
        assert_eq!(parse("--hash"), Err(ArgsError::NoMesh));
        assert_eq!(parse("m --seed"), Err(ArgsError::NoValue("--seed".into())));
        assert_eq!(parse("m --sed 3"), Err(ArgsError::Unknown("--sed".into())));
        let args = parse("a.ply --quality best --schemes olr").unwrap().unwrap();
        assert_eq!((args.quality, args.schemes[0].scheme.quality), (PathQuality::Best, PathQuality::Best));
        assert!(matches!(parse("m --quality good"), Err(ArgsError::Bad { .. })));
        assert!(matches!(parse("m --timeout nan"), Err(ArgsError::Bad { .. })));
        let unknown = parse("m --schemes rdc,rdc-adaptiv").unwrap_err().to_string();
        assert!(unknown.starts_with("unknown scheme \"rdc-adaptiv\": known are rdc, olr, rdc-adaptive, "), "{unknown}");
    }

    #[test]
    fn help_names_every_scheme() {
        let help = usage();
        assert!(scheme::ALL.iter().all(|s| help.contains(&format!("\n  {} ", s.name))), "{help}");
    }
}
