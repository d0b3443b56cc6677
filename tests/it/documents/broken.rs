//! Broken documents load or are refused; what loads can be traced in bounded time and memory.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use bevy_surface_splines::curve::{Spline, TraceWorkspace};
use bevy_surface_splines::format::document::{Document, SurfaceReference};
use bevy_surface_splines::surface::Surface;
use cpu_time::ProcessTime;

use super::{build, everything, mesh, restore};
use crate::Random;
use crate::broken_child::break_in_a_child;

/// Tells the test that it is the child process, and how many mutations it is to make.
const CHILD: &str = "SURFACE_SPLINES_MUTATIONS";
/// Of processor time, which does not depend on what else the machine does; the child does nothing else.
const TRACE_LIMIT: Duration = Duration::from_secs(1);
const MEMORY_LIMIT_KIB: u64 = 256 * 1024;

#[test]
fn broken_documents_load_or_are_refused() {
    break_in_a_child("documents::broken::child_breaks_documents", CHILD, MEMORY_LIMIT_KIB);
}

/// Not a test of its own: what the child process runs.
#[test]
fn child_breaks_documents() {
    let Some(mutations) = std::env::var(CHILD).ok().and_then(|text| text.parse::<u32>().ok()) else { return };
    let surface = build(&mesh(20, 10));
    let whole = everything(&surface);
    let text = whole.to_ron().unwrap();
    let mut judge = Judge::new(surface, &whole);

    let (mut loaded, begin) = (0, Instant::now());
    for end in 0..text.len() {
        loaded += u32::from(judge.survives(&text.as_bytes()[..end]));
    }
    println!("{} bytes; of all prefixes {loaded} load; {:.1?}", text.len(), begin.elapsed());
    // Without the line's end it is whole.
    assert_eq!(loaded, 1);

    let seed = 0x0b10_c5ee_d000 + u64::from(mutations);
    println!("seed {seed:#x}, {mutations} mutations");
    let (mut random, mut loaded, begin) = (Random(seed), 0, Instant::now());
    for _ in 0..mutations {
        let mut broken = text.clone().into_bytes();
        for _ in 0..=random.below(3) {
            broken = mutated(broken, WORDS, &mut random);
        }
        loaded += u32::from(judge.survives(&broken));
    }
    println!("{loaded} of {mutations} load; {:.1?}", begin.elapsed());
    println!(
        "{} restored, {} of them by mapping; {} splines traced, the slowest in {:.1?}",
        judge.restored, judge.mapped, judge.traced, judge.slowest
    );
    trace_finely(&judge.surface, &text);
    println!("peak KiB: {}", peak_kib());
    // Neither everything nor nothing is refused.
    assert!(loaded > mutations / 20 && loaded < mutations * 19 / 20);
    assert!(judge.restored > 0 && judge.mapped > 0 && judge.traced > mutations / 100);
}

/// Reads broken documents, and uses what comes of them.
struct Judge {
    surface: Surface,
    known: SurfaceReference,
    workspace: TraceWorkspace,
    /// Splines that were traced already.
    seen: Vec<Spline>,
    restored: u32,
    mapped: u32,
    traced: u32,
    slowest: Duration,
}

impl Judge {
    fn new(surface: Surface, whole: &Document) -> Self {
        let known = whole.surface.clone();
        let workspace = TraceWorkspace::default();
        let seen = restore(whole, &surface, &known).unwrap().splines.into_iter().flatten().collect();
        Self { surface, known, workspace, seen, restored: 0, mapped: 0, traced: 0, slowest: Duration::ZERO }
    }

    /// Whether a document loads; fails the test on a panic, and on what takes too long.
    fn survives(&mut self, bytes: &[u8]) -> bool {
        let outcome = catch_unwind(AssertUnwindSafe(|| self.used(bytes)));
        outcome.unwrap_or_else(|_| panic!("a panic on this document:\n{}", String::from_utf8_lossy(bytes)))
    }

    fn used(&mut self, bytes: &[u8]) -> bool {
        let begin = ProcessTime::now();
        let document = match Document::from_bytes(bytes) {
            Ok(document) => document,
            Err(error) => {
                assert!(!error.to_string().is_empty());
                return false;
            }
        };
        // What loads can be saved, and is the same then.
        let text = document.to_ron().unwrap();
        let again = Document::from_ron(&text).unwrap();
        assert_eq!(again.to_ron().unwrap(), text);
        let Ok(restored) = restore(&document, &self.surface, &self.known) else { return true };
        assert!(begin.elapsed() < TRACE_LIMIT, "restoring took {:?}", begin.elapsed());
        self.restored += 1;
        self.mapped += u32::from(restored.mapping.is_some());
        for spline in restored.splines.into_iter().flatten() {
            if self.seen.contains(&spline) {
                continue;
            }
            let begin = ProcessTime::now();
            let traced = spline.trace(&self.surface, &mut self.workspace, None);
            let took = begin.elapsed();
            assert!(took < TRACE_LIMIT, "{took:?}: {}", String::from_utf8_lossy(bytes));
            self.slowest = self.slowest.max(took);
            if let Ok(trace) = traced {
                assert!(trace.positions().iter().all(|p| p.is_finite()));
                self.traced += 1;
            }
            if self.seen.len() < 64 {
                self.seen.push(spline);
            }
        }
        true
    }
}

/// Words that mean something in documents.
const WORDS: &[&str] = &[
    "true",
    "false",
    "None",
    "Some",
    "Corner",
    "Smooth",
    "Mirrored",
    "Automatic",
    "Sticky",
    "Allow",
    "AutoSplit",
    "DeCasteljau",
    "LaneRiesenfeld",
    "BSpline",
    "QuadraticBSpline",
    "Direct",
    "CentreOfMass",
    "Levels",
    "Length",
    "Adaptive",
    "Fast",
    "Default",
    "Best",
    "leg",
    "middle",
    "anchors",
    "",
    "Cut",
    "r#true",
    "Some(None)",
    "Levels(12)",
    "Levels(255)",
    "Length(1e-300)",
    "Adaptive(turn: 0.0, length: Some(0.0))",
];

/// One change to a text: of bytes, of words, of lines. `words` are those that mean something in it.
pub(crate) fn mutated(mut bytes: Vec<u8>, words: &[&str], random: &mut Random) -> Vec<u8> {
    const TELLING: &[u8] = b"0123456789-.,:() \n[]{}\"\\#/e";
    const NUMBERS: &[&str] = &[
        "NaN",
        "inf",
        "-inf",
        "-1",
        "-0.0",
        "0",
        "1",
        "1.0",
        "0.5",
        "2.0",
        "7",
        "12",
        "255",
        "256",
        "4294967295",
        "4294967296",
        "18446744073709551616",
        "1e308",
        "-1e308",
        "1e-320",
        "1e999",
        "0x10",
        "1_0",
        "3.4e38",
        "1e30",
    ];
    if bytes.is_empty() {
        return bytes;
    }
    let kind = random.below(17);
    if kind < 5 {
        let at = random.below(bytes.len());
        match kind {
            0 => bytes[at] = random.below(256) as u8,
            1 => bytes[at] = TELLING[random.below(TELLING.len())],
            2 => bytes[at] ^= 1 << random.below(8),
            3 => bytes.insert(at, TELLING[random.below(TELLING.len())]),
            _ => drop(bytes.drain(at..(at + 1 + random.below(12)).min(bytes.len()))),
        }
        return bytes;
    }
    let Ok(text) = String::from_utf8(bytes) else { return b"(version: 1)".to_vec() };
    if kind < 8 {
        return lines_changed(&text, kind, random).into_bytes();
    }
    if kind == 16 {
        // Another mesh.
        const BEFORE: &str = "fingerprint: \"";
        let Some(at) = text.find(BEFORE).map(|at| at + BEFORE.len()) else { return text.into_bytes() };
        let mut bytes = text.into_bytes();
        bytes[at] = b'0' + random.below(10) as u8;
        return bytes;
    }
    let is_number = kind < 13;
    let belongs = |c: char| {
        if is_number { c.is_ascii_digit() || matches!(c, '.' | '-' | 'e') } else { c.is_ascii_alphabetic() || c == '_' }
    };
    let found = ranges_of(&text, belongs);
    let Some(range) = found.get(random.below(found.len())).cloned() else { return text.into_bytes() };
    let word = &text[range.clone()];
    let instead = match kind {
        8 | 9 => NUMBERS[random.below(NUMBERS.len())].to_owned(),
        // A number near by, or of another size.
        10 | 11 => {
            let digit = |c: char| if c.is_ascii_digit() { char::from(b'0' + random.below(10) as u8) } else { c };
            let keep = word.len() / 2;
            word[..keep].to_owned() + &word[keep..].chars().map(digit).collect::<String>()
        }
        12 => format!("{word}{}", TELLING[random.below(13)] as char),
        13..=15 => words[random.below(words.len())].to_owned(),
        _ => String::new(),
    };
    format!("{}{instead}{}", &text[..range.start], &text[range.end..]).into_bytes()
}

/// Where words are that consist of certain characters.
fn ranges_of(text: &str, belongs: impl Fn(char) -> bool) -> Vec<std::ops::Range<usize>> {
    let mut found: Vec<std::ops::Range<usize>> = Vec::new();
    for (at, c) in text.char_indices().filter(|(_, c)| belongs(*c)) {
        match found.last_mut().filter(|range| range.end == at) {
            Some(range) => range.end = at + c.len_utf8(),
            None => found.push(at..at + c.len_utf8()),
        }
    }
    found
}

/// Doubles a line, removes one, or swaps two.
fn lines_changed(text: &str, kind: usize, random: &mut Random) -> String {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let (a, b) = (random.below(lines.len()), random.below(lines.len()));
    match kind {
        5 => lines.insert(b, lines[a]),
        6 => drop(lines.remove(a)),
        _ => lines.swap(a, b),
    }
    lines.concat()
}

/// The most costly schemes that a document can ask for.
fn trace_finely(surface: &Surface, text: &str) {
    let known = Document::from_ron(text).unwrap().surface;
    let begin_of = |at: usize| text[at..].find("scheme: (").map(|i| at + i);
    let mut slowest = Duration::ZERO;
    for method in ["DeCasteljau", "LaneRiesenfeld", "BSpline", "QuadraticBSpline", "Direct", "CentreOfMass"] {
        for sampling in ["Levels(255)", "Length(0.0)", "Length(1e-300)", "Adaptive(turn: 0.0, length: Some(0.0))"] {
            let scheme = format!("scheme: (method: {method}, sampling: {sampling}, on_curve: true, quality: Best)");
            let (mut changed, mut at) = (String::new(), 0);
            while let Some(begin) = begin_of(at) {
                let end = begin + text[begin..].find("        ),").unwrap() + "        )".len();
                changed.push_str(&text[at..begin]);
                changed.push_str(&scheme);
                at = end;
            }
            changed.push_str(&text[at..]);
            let document = Document::from_ron(&changed).unwrap();
            for spline in restore(&document, surface, &known).unwrap().splines.iter().flatten() {
                let begin = ProcessTime::now();
                let trace = spline.trace(surface, &mut TraceWorkspace::default(), None);
                let took = begin.elapsed();
                assert!(trace.is_ok(), "{method}, {sampling}");
                slowest = slowest.max(took);
            }
        }
    }
    println!("with the finest schemes the slowest took {slowest:.1?}");
    assert!(slowest < TRACE_LIMIT);
}

/// The most memory that this process ever held.
pub(crate) fn peak_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
