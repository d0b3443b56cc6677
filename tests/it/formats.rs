//! Mesh files of the corpus, sound and broken. Needs `SURFACE_CORPUS`, and `SURFACE_REFERENCE` for the large scan.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use bevy_surface_splines::format::{FormatError, MeshFormat, parse_mesh, parse_mesh_beside, read_mesh};
use bevy_surface_splines::surface::{Surface, SurfaceOptions, TriangleMesh};
use glam::DVec3;

/// Names the file that a child process is to take, and what it is to do with it.
const CHILD_FILE: &str = "SURFACE_SPLINES_CHILD_FILE";
const CHILD_TASK: &str = "SURFACE_SPLINES_CHILD_TASK";
const TIME_LIMIT: Duration = Duration::from_secs(2);
const MEMORY_LIMIT_KIB: u64 = 256 * 1024;

/// What a child process does with a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Task {
    /// Read it.
    Read,
    /// Read it and build a surface of it.
    Load,
}

/// Reads a file and builds a surface of it; gives what came of it, or place and cause parted by a tab.
fn load(path: &Path) -> Result<String, String> {
    let mesh = read(path)?;
    let surface = Surface::build(&mesh, &SurfaceOptions::default()).map_err(|error| format!("surface\t{error}"))?;
    // No NaN out: every vertex of the surface has a position, every corner an angle.
    let (min, max) = surface.bounds();
    assert!(min.is_finite() && max.is_finite() && surface.report().smallest_angle.is_finite());
    Ok(format!("{}; {}", described(&mesh), surface.report()))
}

/// Reads a file; an error is place and cause parted by a tab.
fn read(path: &Path) -> Result<TriangleMesh, String> {
    read_mesh(path).map_err(|error| match &error {
        FormatError::Content { place, cause, .. } => format!("{place}\t{cause}"),
        other => format!("file\t{other}"),
    })
}

fn described(mesh: &TriangleMesh) -> String {
    format!("{} vertices, {} faces", mesh.positions.len(), mesh.faces.len())
}

#[test]
fn corpus_meshes_are_as_listed() {
    let Some(corpus) = folder("SURFACE_CORPUS") else { return };
    let mut wrong = Vec::new();
    for row in table(&corpus.join("meshes.csv")) {
        let before = Instant::now();
        match read_mesh(corpus.join(&row[0])) {
            Ok(mesh) => {
                println!("{}: {:.1} ms", row[0], before.elapsed().as_secs_f64() * 1e3);
                compare(&mesh, &row, &mut wrong);
            }
            Err(error) => wrong.push(format!("{}: {error}", row[0])),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Compares counts and size with a row of `meshes.csv`.
fn compare(mesh: &TriangleMesh, row: &[String], wrong: &mut Vec<String>) {
    let mut check = |what: &str, found: f64, listed: &str, tolerance: f64| {
        let expected: f64 = listed.parse().unwrap();
        if (found - expected).abs() > tolerance * expected {
            wrong.push(format!("{}: {what} {found} instead of {expected}", row[0]));
        }
    };
    let all: Vec<DVec3> = mesh.faces.iter().flatten().map(|corner| mesh.positions[*corner as usize]).collect();
    // Adding zero makes −0 and 0 the same bits.
    let different: HashSet<[u64; 3]> = all.iter().map(|p| (*p + DVec3::ZERO).to_array().map(f64::to_bits)).collect();
    let low = all.iter().copied().reduce(DVec3::min).unwrap();
    let high = all.iter().copied().reduce(DVec3::max).unwrap();
    check("vertices in the file", mesh.positions.len() as f64, &row[3], 0.0);
    check("different vertices", different.len() as f64, &row[4], 0.0);
    check("faces", mesh.faces.len() as f64, &row[5], 0.0);
    check("diagonal", low.distance(high), &row[19], 1e-5);
}

#[test]
fn corpus_cages_and_rigs_are_read() {
    let Some(corpus) = folder("SURFACE_CORPUS") else { return };
    for list in ["cages.csv", "rigs.csv"] {
        for row in table(&corpus.join(list)) {
            let mesh = read_mesh(corpus.join(&row[0])).unwrap_or_else(|error| panic!("{}: {error}", row[0]));
            assert!(!mesh.faces.is_empty(), "{} has no faces", row[0]);
        }
    }
}

#[test]
fn broken_files_meet_their_expectation() {
    let Some(corpus) = folder("SURFACE_CORPUS") else { return };
    let mut wrong = Vec::new();
    println!("{:<40} {:<26} {:>6} {:>7}  cause", "path", "place", "ms", "KiB");
    for row in table(&corpus.join("bad.csv")) {
        let (file, expected) = (&row[0], row[4].as_str());
        if MeshFormat::from_extension(file).is_none() {
            continue;
        }
        let child = run_child(&corpus.join(file), Task::Load);
        let (place, what) = match &child.outcome {
            Some(Ok(loaded)) => ("-", loaded.as_str()),
            Some(Err(refused)) => refused.split_once('\t').unwrap_or(("?", refused)),
            None => ("?", "DIED OR WAS STOPPED"),
        };
        println!("{file:<40} {place:<26} {:>6} {:>7}  {what}", child.time.as_millis(), child.peak_kib);
        let met = match &child.outcome {
            None => false,
            Some(outcome) if expected.starts_with("should load") => outcome.is_ok(),
            Some(_) if expected.contains("load") => true,
            Some(outcome) => outcome.is_err() && expected.starts_with("report an error"),
        };
        if !met || child.time > TIME_LIMIT || child.peak_kib > MEMORY_LIMIT_KIB {
            wrong.push(format!("{file}: {what} (expected: {expected})"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn damaged_files_are_survived() {
    const LARGEST: usize = 20_000;
    const TELLING: &[u8] = b"0123456789-. \n\\{}[],\"#/e";
    let Some(corpus) = folder("SURFACE_CORPUS") else { return };
    let rounds: u64 = std::env::var("SURFACE_SPLINES_ROUNDS").ok().and_then(|text| text.parse().ok()).unwrap_or(30);
    let mut seed = 0x5eed_u64;
    println!("seed {seed:#x}, {rounds} rounds");
    let mut random = move |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % below.max(1)
    };
    for row in ["bad.csv", "meshes.csv", "rigs.csv", "cages.csv"].iter().flat_map(|list| table(&corpus.join(list))) {
        let Some(format) = MeshFormat::from_extension(&row[0]) else { continue };
        let sound = fs::read(corpus.join(&row[0])).unwrap();
        if sound.is_empty() || sound.len() > LARGEST {
            continue;
        }
        for _ in 0..rounds {
            let mut bytes = sound.clone();
            // Half of all damage is done near the start, where headers are.
            let reach = if random(2) == 0 { bytes.len() } else { bytes.len().min(200) };
            for _ in 0..=random(4) {
                let at = random(reach.min(bytes.len()));
                match random(6) {
                    0 => bytes.truncate(at),
                    1 => bytes[at] = random(256) as u8,
                    2 => bytes[at] = TELLING[random(TELLING.len())],
                    3 => bytes[at] ^= 1 << random(8),
                    4 => bytes.insert(at, b'0' + random(10) as u8),
                    _ => drop(bytes.drain(at..(at + random(9)).min(bytes.len()))),
                }
                if bytes.is_empty() {
                    break;
                }
            }
            let before = Instant::now();
            if let Ok(mesh) = parse_mesh(&bytes, format) {
                let vertices = mesh.positions.len();
                assert!(mesh.faces.iter().flatten().all(|corner| (*corner as usize) < vertices), "{}", row[0]);
            }
            assert!(before.elapsed() < TIME_LIMIT, "{} took too long", row[0]);
        }
    }
}

#[test]
fn large_scan_is_quick_and_small() {
    let Some(reference) = folder("SURFACE_REFERENCE") else { return };
    let path = reference.join("meshes/armadillo_1384k.ply");
    let child = run_child(&path, Task::Read);
    let size_kib = fs::metadata(&path).unwrap().len() / 1024;
    println!("{:?} in {:?}, peak {} KiB, file {size_kib} KiB", child.outcome, child.time, child.peak_kib);
    assert!(matches!(child.outcome, Some(Ok(_))));
    if !cfg!(debug_assertions) {
        assert!(child.time < Duration::from_secs(1) && child.peak_kib < 3 * size_kib);
    }
}

#[test]
fn buffers_beside_a_document_are_read() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("buffers_beside_a_document");
    fs::create_dir_all(&folder).unwrap();
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    fs::write(folder.join("one triangle.bin"), bytes).unwrap();
    let document = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "buffers":[{"byteLength":36,"uri":"one%20triangle.bin"}],"bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]}"#;
    fs::write(folder.join("document.gltf"), document).unwrap();
    let mesh = read_mesh(folder.join("document.gltf")).unwrap();
    assert_eq!((mesh.positions[1], mesh.faces), (DVec3::X, vec![[0, 1, 2]]));
    assert_eq!(parse_mesh_beside(document.as_bytes(), MeshFormat::Gltf, &folder).unwrap().positions, mesh.positions);
    for missing in ["two.bin", "/dev/zero", "../../../../../../../../../dev/zero", "http://a.b/c.bin"] {
        let document = document.replace("one%20triangle.bin", missing);
        let error = parse_mesh_beside(document.as_bytes(), MeshFormat::Gltf, &folder).unwrap_err();
        assert!(error.to_string().starts_with("glTF, buffer 0: "), "{error}");
    }
}

/// Not a test of its own: what the child processes run.
#[test]
fn child_loads_one_file() {
    let Some(path) = std::env::var_os(CHILD_FILE) else { return };
    let before = Instant::now();
    let path = Path::new(&path);
    let only_read = std::env::var(CHILD_TASK).is_ok_and(|task| task == "read");
    let outcome = if only_read { read(path).map(|mesh| described(&mesh)) } else { load(path) };
    let took = before.elapsed().as_micros();
    match outcome {
        Ok(loaded) => println!("\nLOADED\t{took}\t{}\t{loaded}", peak_kib()),
        Err(refused) => println!("\nREFUSED\t{took}\t{}\t{refused}", peak_kib()),
    }
}

struct Child {
    /// `None` if the child did not come to an end by itself, or failed.
    outcome: Option<Result<String, String>>,
    /// Of loading where the child says it, else of the process.
    time: Duration,
    /// Most memory the process ever held.
    peak_kib: u64,
}

/// Loads a file in a child process that is stopped after the time limit and cannot take more than 1 GiB of addresses.
fn run_child(path: &Path, task: Task) -> Child {
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v 1048576; exec \"$0\" \"$@\""]).arg(std::env::current_exe().unwrap());
    command.args(["--exact", "formats::child_loads_one_file", "--nocapture", "--test-threads=1"]);
    command.env(CHILD_FILE, path).env(CHILD_TASK, if task == Task::Read { "read" } else { "load" });
    command.stdout(Stdio::piped()).stderr(Stdio::null());
    let start = Instant::now();
    let mut child = command.spawn().unwrap();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > TIME_LIMIT {
            child.kill().unwrap();
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let output = child.wait_with_output().unwrap();
    let mut result = Child { outcome: None, time: start.elapsed(), peak_kib: 0 };
    let said = String::from_utf8_lossy(&output.stdout);
    let line = said.lines().find(|line| line.starts_with("LOADED\t") || line.starts_with("REFUSED\t"));
    if let (true, Some(line)) = (output.status.success(), line) {
        let fields: Vec<&str> = line.splitn(4, '\t').collect();
        result.time = Duration::from_micros(fields[1].parse().unwrap());
        result.peak_kib = fields[2].parse().unwrap();
        let what = fields[3].to_owned();
        result.outcome = Some(if fields[0] == "LOADED" { Ok(what) } else { Err(what) });
    }
    result
}

/// The most memory that this process ever held; 0 where the system does not tell.
fn peak_kib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// The folder that an environment variable names, or a message that the test is skipped.
fn folder(variable: &str) -> Option<PathBuf> {
    let folder = std::env::var_os(variable).map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: {variable} is not set");
    }
    folder
}

/// The rows of a comma-separated table without its heading; quotes may hold commas.
fn table(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    text.lines().skip(1).map(fields).collect()
}

fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            c => fields.last_mut().unwrap().push(c),
        }
    }
    fields
}
