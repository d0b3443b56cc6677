//! Which meshes there are, and everything that a mesh needs before its cases can run.

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    time::Instant,
};

use bevy_surface_splines::{
    format,
    surface::{PointError, Surface, SurfaceOptions, SurfacePoint},
};

use crate::{
    args::Args,
    cases::{self, CasePoint, CasesError},
    checker::Topology,
    clock,
    hash::Fnv,
    random::{self, SplitMix64},
    worker::on_surface,
};

/// Endings of files taken from a folder.
const EXTENSIONS: [&str; 6] = ["obj", "stl", "ply", "off", "gltf", "glb"];

/// A mesh file to do, and whether it was named or found in a folder.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeshFile {
    pub(crate) path: PathBuf,
    pub(crate) named: bool,
}

/// Files as they are, folders by their mesh files in order of name (subfolders included).
pub(crate) fn mesh_files(paths: &[PathBuf]) -> Vec<MeshFile> {
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            collect(path, &mut files, 0);
        } else {
            files.push(MeshFile { path: path.clone(), named: true });
        }
    }
    files
}

fn collect(folder: &Path, files: &mut Vec<MeshFile>, depth: usize) {
    const DEEPEST: usize = 32; // links may form circles
    let Ok(entries) = fs::read_dir(folder) else { return };
    let mut entries: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    entries.sort();
    for path in entries {
        let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        if path.is_dir() {
            if depth < DEEPEST {
                collect(&path, files, depth + 1);
            }
        } else if ending.is_some_and(|e| EXTENSIONS.contains(&e.as_str())) {
            files.push(MeshFile { path, named: false });
        }
    }
}

/// A mesh that is ready to run.
#[derive(Debug)]
pub(crate) struct Prepared {
    /// The file's stem.
    pub(crate) name: String,
    pub(crate) surface: Surface,
    pub(crate) topology: Topology,
    /// Polygons from the file of cases.
    pub(crate) cases: Vec<[CasePoint; 4]>,
    /// Random polygons; their numbers follow those of the cases.
    pub(crate) random: Vec<[SurfacePoint; 4]>,
    pub(crate) pairs: Vec<[CasePoint; 2]>,
    /// How many random polygons could not be drawn.
    pub(crate) undrawn: usize,
    /// Wall time of building the surface.
    pub(crate) prepare_ms: f64,
    /// Most memory held until the surface was built, the raw mesh included.
    pub(crate) prepare_mb: Option<f64>,
}

/// Why a mesh could not be made ready.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PrepareError {
    /// The mesh is refused.
    #[error("{0}")]
    Mesh(String),
    /// What was asked for cannot be done.
    #[error(transparent)]
    Cases(#[from] CasesError),
}

impl Prepared {
    /// Loads a mesh, builds its surface, reads or draws its cases.
    ///
    /// # Errors
    /// [`PrepareError`] if the mesh is refused or its file of cases is wrong.
    pub(crate) fn new(path: &Path, args: &Args) -> Result<Self, PrepareError> {
        clock::forget_peak();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mesh = caught("reading", || format::read_mesh(path).map_err(|e| e.to_string()))?;
        let started = Instant::now();
        let build = || Surface::build(&mesh, &SurfaceOptions::default()).map_err(|e| e.to_string());
        let surface = caught("building", build)?;
        let prepare_ms = started.elapsed().as_secs_f64() * 1e3;
        let prepare_mb = clock::peak_mb();
        let topology = Topology::new(&mesh);
        drop(mesh);
        let mut random = Vec::new();
        let mut numbers = SplitMix64::new(args.seed ^ name_hash(&name));
        for _ in 0..args.random {
            // One failure stands for all: six sides and thousands of rays were tried.
            let Some(polygon) = random::polygon(&surface, &mut numbers) else { break };
            random.push(polygon);
        }
        Ok(Self {
            cases: read_cases(args.cases.as_deref(), path)?,
            pairs: read_cases(args.pairs.as_deref(), path)?,
            undrawn: args.random - random.len(),
            name,
            surface,
            topology,
            random,
            prepare_ms,
            prepare_mb,
        })
    }

    /// How many polygons there are, random ones included.
    pub(crate) fn polygons(&self) -> usize {
        self.cases.len() + self.random.len()
    }

    /// A polygon by its number.
    pub(crate) fn polygon(&self, case: usize) -> Result<[SurfacePoint; 4], PointError> {
        match self.cases.get(case) {
            Some(points) => on_surface(&self.surface, points),
            None => Ok(self.random[case - self.cases.len()]),
        }
    }

    /// A pair by its number.
    pub(crate) fn pair(&self, case: usize) -> Result<[SurfacePoint; 2], PointError> {
        on_surface(&self.surface, &self.pairs[case])
    }
}

fn read_cases<const N: usize>(from: Option<&Path>, mesh: &Path) -> Result<Vec<[CasePoint; N]>, CasesError> {
    match from.and_then(|cases| cases::file_for(cases, mesh)) {
        Some(file) => cases::read(&file),
        None => Ok(Vec::new()),
    }
}

/// Each mesh draws its own numbers, whatever other meshes are done.
fn name_hash(name: &str) -> u64 {
    let mut hash = Fnv::default();
    hash.text(name);
    hash.0
}

/// A panic while a mesh is made ready is a refusal in words.
fn caught<T>(what: &str, make: impl FnOnce() -> Result<T, String>) -> Result<T, PrepareError> {
    let made = catch_unwind(AssertUnwindSafe(make));
    made.unwrap_or_else(|_| Err(format!("{what} it panicked"))).map_err(PrepareError::Mesh)
}
