//! The meshes that benches run on, each with its control polygons.

use std::{
    env, fs,
    path::{Path, PathBuf},
};

use bevy_surface_splines::{
    format::read_mesh,
    surface::{FaceId, Surface, SurfaceOptions, SurfacePoint, TriangleMesh},
};

use super::{
    arguments::Arguments,
    cases::{self, CasePoint},
    made,
    random::{self, SplitMix64},
    records::Records,
};

/// From which case on the control polygons are local ones.
const FIRST_LOCAL: usize = 100;

/// Whether a polygon spans the model or lies in a ball of a twentieth of its diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Random,
    Local,
}

impl Kind {
    pub(crate) const ALL: [Self; 2] = [Self::Random, Self::Local];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Local => "local",
        }
    }
}

/// A control polygon.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    /// Its number among those recorded.
    pub(crate) number: usize,
    pub(crate) kind: Kind,
    pub(crate) polygon: [SurfacePoint; 4],
}

/// A mesh and its control polygons.
pub(crate) struct Sample {
    pub(crate) name: String,
    pub(crate) mesh: TriangleMesh,
    pub(crate) surface: Surface,
    pub(crate) cases: Vec<Case>,
}

/// All meshes there are: those of the reference, or some of our own making.
pub(crate) struct Samples {
    pub(crate) records: Records,
    sources: Vec<Source>,
    quick: bool,
}

enum Source {
    File { mesh: PathBuf, cases: PathBuf },
    Sphere { level: u32 },
}

impl Samples {
    /// Looks for the reference in `SURFACE_REFERENCE` or beside the checkout, and says what was found.
    pub(crate) fn find(arguments: &Arguments) -> Self {
        let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/reference");
        let folder = env::var_os("SURFACE_REFERENCE").map_or(beside, PathBuf::from);
        let mut files: Vec<PathBuf> = fs::read_dir(folder.join("meshes"))
            .map(|entries| entries.filter_map(|entry| Some(entry.ok()?.path())).collect())
            .unwrap_or_default();
        files.sort_by_key(|file| fs::metadata(file).map_or(0, |m| m.len()));
        let mut sources: Vec<Source> = files
            .into_iter()
            .filter_map(|mesh| Some(Source::File { cases: cases::file_for(&folder.join("cases"), &mesh)?, mesh }))
            .collect();
        if sources.is_empty() {
            println!("No reference meshes ($SURFACE_REFERENCE): made spheres instead, and nothing recorded.");
            sources = [5, 6, 8].map(|level| Source::Sphere { level }).into();
        } else {
            println!("Reference meshes.");
        }
        sources.retain(|source| arguments.wants(&source.name()));
        if arguments.quick && !arguments.names_meshes() {
            sources.truncate(2);
        }
        Self { records: Records::read(&folder), sources, quick: arguments.quick }
    }

    /// The meshes, small ones first, one at a time: together they would fill the memory.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Sample> + '_ {
        self.sources.iter().map(|source| source.sample(self.quick))
    }

    /// The largest mesh.
    pub(crate) fn largest(&self) -> Option<Sample> {
        Some(self.sources.last()?.sample(self.quick))
    }
}

impl Source {
    fn name(&self) -> String {
        match self {
            Self::File { mesh, .. } => mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            Self::Sphere { level } => format!("sphere{level}"),
        }
    }

    fn sample(&self, quick: bool) -> Sample {
        let mesh = match self {
            Self::File { mesh, .. } => read_mesh(mesh).unwrap_or_else(|e| panic!("{}: {e}", mesh.display())),
            Self::Sphere { level } => made::bumpy_sphere(*level),
        };
        let name = self.name();
        let surface = Surface::build(&mesh, &SurfaceOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut cases = match self {
            Self::File { cases, .. } => recorded_cases(cases),
            Self::Sphere { .. } => made_cases(&surface),
        };
        if quick {
            cases.retain(|case| case.number < 6 || (FIRST_LOCAL..FIRST_LOCAL + 6).contains(&case.number));
        }
        Sample { name, mesh, surface, cases }
    }
}

fn recorded_cases(file: &Path) -> Vec<Case> {
    let polygons = cases::read::<4>(file).unwrap_or_else(|error| panic!("{error}"));
    let kind = |number| if number < FIRST_LOCAL { Kind::Random } else { Kind::Local };
    let point = |p: CasePoint| SurfacePoint::new(FaceId(p.face), p.weights()).unwrap_or_else(|error| panic!("{error}"));
    let polygons = polygons.into_iter().enumerate();
    polygons.map(|(number, polygon)| Case { number, kind: kind(number), polygon: polygon.map(point) }).collect()
}

fn made_cases(surface: &Surface) -> Vec<Case> {
    let mut random = SplitMix64::new(FIRST_LOCAL as u64);
    let spanning = (0..20).filter_map(|i| Some((i, Kind::Random, random::polygon(surface, &mut random)?)));
    let mut found: Vec<_> = spanning.collect();
    for i in FIRST_LOCAL..FIRST_LOCAL + 20 {
        found.push((i, Kind::Local, local_polygon(surface, &mut random, 0.05)));
    }
    found.into_iter().map(|(number, kind, polygon)| Case { number, kind, polygon }).collect()
}

/// Four points at most so far, as a share of the diagonal, from a random point of the surface.
pub(crate) fn local_polygon(surface: &Surface, random: &mut SplitMix64, reach: f64) -> [SurfacePoint; 4] {
    let centre = random_point(surface, random);
    let along = surface.corners(centre.face).map_or(glam::DVec3::X, |[a, b, _]| b - a);
    [(); 4].map(|()| {
        let distance = reach * surface.diagonal() * random.unit().sqrt();
        let heading = surface.tangent(&centre, along).map(|t| t.rotated(random.unit() * std::f64::consts::TAU));
        let walk = heading.and_then(|heading| surface.walk(&centre, &heading, distance));
        walk.map_or(centre, |walk| walk.path.end())
    })
}

/// A random place of a random face.
pub(crate) fn random_point(surface: &Surface, random: &mut SplitMix64) -> SurfacePoint {
    loop {
        let face = FaceId((random.next() % surface.face_count().max(1) as u64) as u32);
        let (a, b) = (random.unit(), random.unit());
        let (u, v) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
        if let Ok(point) = surface.point(face, [1.0 - u - v, u, v]) {
            return point;
        }
    }
}
