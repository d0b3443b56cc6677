//! Broken and hostile drawings, each read in a process of its own.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use bevy_surface_splines::vector::{SvgLimits, import_svg, import_svg_within};

use super::{corpus, table};

const CHILD_FILE: &str = "SURFACE_SPLINES_CHILD_DRAWING";
const TIME_LIMIT: Duration = Duration::from_secs(2);
const MEMORY_LIMIT_KIB: u64 = 500 * 1024;

#[test]
fn broken_drawings_meet_their_expectation() {
    let Some(corpus) = corpus() else { return };
    let (mut wrong, mut files) = (Vec::new(), 0);
    for row in table(&corpus.join("bad.csv")).iter().filter(|row| row[0].ends_with(".svg")) {
        let (file, expected) = (&row[0], row[4].as_str());
        let child = read_in_child(&corpus.join(file));
        let (loaded, what) = match &child.outcome {
            Some(Ok(what)) => (Some(true), what.as_str()),
            Some(Err(what)) => (Some(false), what.as_str()),
            None => (None, "DIED OR WAS STOPPED"),
        };
        println!("{file:<40} {:>5} ms {:>7} KiB  {what}", child.time.as_millis(), child.peak_kib);
        let met = match loaded {
            None => false,
            Some(loaded) if expected.starts_with("should load") => loaded,
            Some(_) if expected.contains("load") => true,
            Some(loaded) => !loaded && expected.starts_with("report an error"),
        };
        if !met || child.time > TIME_LIMIT || child.peak_kib > MEMORY_LIMIT_KIB {
            wrong.push(format!("{file}: {what} (expected: {expected})"));
        }
        files += 1;
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(files, 12);
}

/// Drawings that are built to take time or memory: each kind that a limit stands against.
#[test]
fn made_bombs_are_refused_in_time() {
    let svg = |inside: &str| {
        format!("<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink'>{inside}</svg>")
    };
    let nested = |n: usize, inner: &str| format!("{}{inner}{}", "<g>".repeat(n), "</g>".repeat(n));
    let chain: String = (0..2000).map(|i| format!("<g id='a{i}'><use href='#a{}'/></g>", i + 1)).collect();
    let rules = "g g g g g g g g .d {fill:red}".repeat(3000);
    let heavy = format!("<path id='p' d='M0 0{}'/>{}", "h1".repeat(100_000), "<use href='#p'/>".repeat(10_000));
    let attributes: String = (0..200_000).map(|i| format!(" a{i}=''")).collect();
    let quadratic = format!(
        "<!DOCTYPE svg [<!ENTITY a \"{}\">]><svg xmlns='http://www.w3.org/2000/svg'><text>{}</text></svg>",
        "x".repeat(100_000),
        "&a;".repeat(100_000)
    );
    let flat = format!("<path d='M0 0{}'/>", "h1".repeat(5_000_000));
    let polygon = format!("<polygon points='{}'/>", "1 2 ".repeat(5_000_000));
    let hidden =
        format!("<defs id='d'>{}</defs>{}", "<path d='M0 0h1'/>".repeat(1000), "<use href='#d'/>".repeat(2000));
    for (name, text, sound) in [
        ("nested in depth", svg(&nested(5_000, "<path d='M0 0h1'/>")), false),
        ("a chain of use", svg(&chain), false),
        (
            "rules of many steps",
            svg(&format!("<style>{rules}</style>{}", nested(900, &"<g class='d'/>".repeat(2000)))),
            false,
        ),
        ("a heavy path used often", svg(&heavy), false),
        ("attributes", format!("<svg xmlns='http://www.w3.org/2000/svg'{attributes}/>"), false),
        ("an entity used often", quadratic, false),
        ("a path of millions of lines", svg(&flat), false),
        ("a polygon of millions of lines", svg(&polygon), false),
        ("definitions copied often", svg(&hidden), false),
        ("many ids", svg(&"<g id='a'><use href='#a'/></g>".repeat(50_000)), true),
        ("just deep enough", svg(&nested(990, "<path d='M0 0h1'/>")), true),
    ] {
        // Other tests run beside this one: only its own work counts.
        let start = cpu_time::ThreadTime::now();
        let result = import_svg(text.as_bytes());
        let took = start.elapsed();
        let said = result.as_ref().map_or_else(|e| e.to_string(), |i| i.report.found().to_string());
        println!("{name}: {:.0} ms: {said}", took.as_secs_f64() * 1e3);
        assert_eq!(result.is_ok(), sound, "{name}: {said}");
        assert!(took < TIME_LIMIT, "{name} took {took:?}");
    }
}

#[test]
fn damaged_drawings_are_survived() {
    const LARGEST: usize = 40_000;
    const TELLING: &[u8] = b"0123456789-. \n<>&;\"'/#()%{}=eEzMmAaCcUu";
    let Some(corpus) = corpus() else { return };
    let rounds: u64 = std::env::var("SURFACE_SPLINES_ROUNDS").ok().and_then(|text| text.parse().ok()).unwrap_or(30);
    let mut seed = 0x5eed_u64;
    println!("seed {seed:#x}, {rounds} rounds");
    let mut random = move |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % below.max(1)
    };
    let limits = SvgLimits { elements: 20_000, ..SvgLimits::default() };
    let (mut read, mut refused) = (0, 0);
    for row in ["bad.csv", "svg.csv"].iter().flat_map(|list| table(&corpus.join(list))) {
        let sound = std::fs::read(corpus.join(&row[0])).unwrap();
        if !row[0].ends_with(".svg") || sound.len() > LARGEST {
            continue;
        }
        for _ in 0..rounds {
            let mut bytes = sound.clone();
            for _ in 0..=random(4) {
                let at = random(bytes.len());
                match random(6) {
                    0 if random(4) == 0 => bytes.truncate(at),
                    1 => bytes[at] = random(256) as u8,
                    2 => bytes[at] = TELLING[random(TELLING.len())],
                    3 => bytes.insert(at, TELLING[random(TELLING.len())]),
                    4 => bytes.insert(at, b'0' + random(10) as u8),
                    _ => drop(bytes.drain(at..(at + random(9)).min(bytes.len()))),
                }
                if bytes.is_empty() {
                    break;
                }
            }
            let before = Instant::now();
            match import_svg_within(&bytes, &limits) {
                Ok(import) => {
                    read += 1;
                    assert!(import.report.adds_up(), "{}", row[0]);
                    let finite =
                        |path: &bevy_surface_splines::vector::VectorPath| path.points().iter().all(|p| p.is_finite());
                    assert!(import.drawing.paths().all(|(_, path)| finite(path)), "{}", row[0]);
                }
                Err(_) => refused += 1,
            }
            assert!(before.elapsed() < TIME_LIMIT, "{} took too long", row[0]);
        }
    }
    println!("{read} read, {refused} refused");
    assert!(read > 0 && refused > 0);
}

/// Not a test of its own: what the child processes run.
#[test]
fn child_reads_one_drawing() {
    let Some(path) = std::env::var_os(CHILD_FILE) else { return };
    let before = Instant::now();
    let outcome = bevy_surface_splines::vector::read_svg(Path::new(&path));
    let took = before.elapsed().as_micros();
    match outcome {
        Ok(import) => {
            assert!(import.report.adds_up());
            assert!(import.drawing.paths().all(|(_, path)| path.points().iter().all(|p| p.is_finite())));
            let (drawn, left) = (import.report.drawn, import.report.left_out);
            println!("\nLOADED\t{took}\t{}\tdrawn {drawn}, {} left out", peak_kib(), left.len());
            left.iter().for_each(|left| println!("    {left}"));
        }
        Err(error) => println!("\nREFUSED\t{took}\t{}\t{error}", peak_kib()),
    }
}

struct Child {
    /// `None` if the child did not come to an end by itself, or failed.
    outcome: Option<Result<String, String>>,
    time: Duration,
    /// Most memory the process ever held.
    peak_kib: u64,
}

/// Reads a drawing in a child process that is stopped after the time limit and cannot take more than 1 GiB of addresses.
fn read_in_child(path: &Path) -> Child {
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v 1048576; exec \"$0\" \"$@\""]).arg(std::env::current_exe().unwrap());
    command.args(["--exact", "drawings::bad::child_reads_one_drawing", "--nocapture", "--test-threads=1"]);
    command.env(CHILD_FILE, path).stdout(Stdio::piped()).stderr(Stdio::null());
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
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
