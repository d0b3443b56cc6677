//! Broken characters load or are refused; what loads is bound and posed in bounded time and memory.

use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use bevy_surface_splines::character::{BindProgress, Character, CharacterError};
use cpu_time::ProcessTime;

use super::{DRAWING, TAILS, text};
use crate::Random;
use crate::broken_child::break_in_a_child;
use crate::documents::broken::{mutated, peak_kib};

/// Tells the test that it is the child process, and how many mutations it is to make.
const CHILD: &str = "SURFACE_SPLINES_CHARACTER_MUTATIONS";
/// Of processor time, which does not depend on what else the machine does; the child does nothing else.
const LIMIT: Duration = Duration::from_secs(1);
const MEMORY_LIMIT_KIB: u64 = 256 * 1024;

const WORDS: &[&str] = &[
    "true",
    "false",
    "None",
    "Some",
    "Corner",
    "Smooth",
    "Mirrored",
    "Angle",
    "Step",
    "Linear",
    "Cubic",
    "Shepard",
    "Bounded",
    "Cage",
    "Rotation",
    "Translation",
    "Scale",
    "hips",
    "chest",
    "upper",
    "fore",
    "tail",
    "figure",
    "sleeve",
    "trunk",
    "joints",
    "parts",
    "clips",
    "keys",
    "loops",
    "tip",
    "parent",
    "",
    "r#true",
];

#[test]
fn broken_characters_load_or_are_refused() {
    break_in_a_child("characters::broken::child_breaks_characters", CHILD, MEMORY_LIMIT_KIB);
}

/// Not a test of its own: what the child process runs.
#[test]
fn child_breaks_characters() {
    let Some(mutations) = std::env::var(CHILD).ok().and_then(|text| text.parse::<u32>().ok()) else { return };
    let texts = TAILS.map(text);
    let text = &texts[0];
    let mut judge = Judge::default();

    let (mut loaded, begin) = (0, Instant::now());
    for end in 0..text.len() {
        loaded += u32::from(judge.survives(&text.as_bytes()[..end], DRAWING.as_bytes()));
    }
    println!("{} bytes; of all prefixes {loaded} load; {:.1?}", text.len(), begin.elapsed());
    // Without the line's end it is whole.
    assert_eq!(loaded, 1);
    assert!((4_000..8_000).contains(&text.len()));

    let seed = 0x0b10_c5ee_d001 + u64::from(mutations);
    println!("seed {seed:#x}, {mutations} mutations");
    let (mut random, mut loaded, begin) = (Random(seed), 0, Instant::now());
    for _ in 0..mutations {
        let text = &texts[[0, 0, 1, 2][random.below(4)]];
        let (mut broken, mut drawing) = (text.clone().into_bytes(), DRAWING.as_bytes().to_vec());
        for _ in 0..=random.below(3) {
            if random.below(8) == 0 {
                drawing = mutated(
                    drawing,
                    &["", "g", "use", "path", "figure", "#arm", "defs", "z", "matrix(0)"],
                    &mut random,
                );
            } else {
                broken = mutated(broken, WORDS, &mut random);
            }
        }
        loaded += u32::from(judge.survives(&broken, &drawing));
    }
    println!("{loaded} of {mutations} load; {:.1?}", begin.elapsed());
    println!("{} bound, the slowest in {:.1?}; {} poses", judge.bound, judge.slowest, judge.poses);
    // Neither everything nor nothing is refused.
    assert!(loaded > mutations / 20 && loaded < mutations * 19 / 20);
    assert!(judge.bound > mutations / 20 && judge.poses > mutations / 4);
    the_most_that_a_file_can_ask_for();
    println!("peak KiB: {}", peak_kib());
}

/// Reads broken characters, and uses what comes of them.
#[derive(Default)]
struct Judge {
    bound: u32,
    poses: u32,
    slowest: Duration,
}

impl Judge {
    /// Whether a character loads; fails the test on a panic, and on what takes too long.
    fn survives(&mut self, bytes: &[u8], drawing: &[u8]) -> bool {
        let outcome = catch_unwind(AssertUnwindSafe(|| self.used(bytes, drawing)));
        outcome.unwrap_or_else(|_| panic!("a panic on this character:\n{}", String::from_utf8_lossy(bytes)))
    }

    fn used(&mut self, bytes: &[u8], drawing: &[u8]) -> bool {
        let begin = ProcessTime::now();
        let character = match Character::parse("broken.character.ron", bytes, |_| Ok(drawing.to_vec())) {
            Ok(character) => character,
            Err(error) => {
                assert!(error.to_string().starts_with("broken.character.ron"), "{error}");
                return false;
            }
        };
        // What loads can be saved, and is the same then.
        let text = character.to_ron().unwrap();
        let again = Character::parse("again", text.as_bytes(), |_| Ok(drawing.to_vec())).unwrap();
        assert_eq!(again, character);
        assert_eq!(again.to_ron().unwrap(), text);
        match character.bind(&BindProgress::default()) {
            Ok(bound) => {
                self.bound += 1;
                let (mut locals, mut worlds) = (character.rest_poses(), Vec::new());
                let mut posed = bound.skin.at_rest();
                for clip in 0..character.clips.len().min(8) {
                    for share in [0.0, 0.3, 0.9] {
                        character.sample(clip, character.clips[clip].duration * share, &mut locals);
                        character.worlds(&locals, &mut worlds);
                        // Joints that are stretched too far are refused.
                        if bound.pose(&worlds, &mut posed).is_ok() {
                            assert!([posed.x(), posed.y()].into_iter().flatten().all(|x| x.is_finite()));
                            self.poses += 1;
                        }
                    }
                }
            }
            Err(CharacterError::Weights { .. } | CharacterError::FeatureOff { .. } | CharacterError::Skin { .. }) => {}
            Err(other) => panic!("{other}"),
        }
        let took = begin.elapsed();
        assert!(took < LIMIT, "{took:?}: {}", String::from_utf8_lossy(bytes));
        self.slowest = self.slowest.max(took);
        true
    }
}

/// Characters at the limits of what is read.
fn the_most_that_a_file_can_ask_for() {
    let head = |joints: usize| {
        let joints = (0..joints).fold(String::new(), |mut all, i| {
            let parent = if i > 0 { format!("parent: \"j{}\", ", i - 1) } else { String::new() };
            let _ = writeln!(all, "(name: \"j{i}\", {parent}at: ({}, {}), tip: ({}, 3)),", i % 40, i / 40, i % 40);
            all
        });
        format!("(version: 1, name: \"x\", drawing: \"x.svg\", joints: [{joints}], ")
    };
    let follow = |joints: usize| (0..joints).map(|i| format!("\"j{i}\",")).collect::<String>();
    let drawing = |segments: usize, size: f64| {
        let curve = format!("c {size} {size} 0 {size} {size} 0 c 0 -{size} -{size} -{size} -{size} 0");
        format!("<svg xmlns='http://www.w3.org/2000/svg'><path id='p' d='M 0 0 {}'/></svg>", curve.repeat(segments / 2))
    };
    let part = |joints: usize, weights: &str| {
        format!("parts: [(name: \"p\", shapes: [\"p\"], follows: [{}]{weights})],", follow(joints))
    };
    let keys: String = (0..99_999).map(|i| format!("({},1)", f64::from(i) * 1e-5) + ",").collect();
    let clip = format!("clips: [(name: \"c\", duration: 1, tracks: [(joint: \"j0\", keys: Rotation([{keys}]))])])");
    let mut cases = vec![
        ("512 joints, 390 segments", head(512) + &part(512, "") + ")", drawing(390, 30.0)),
        ("one joint, 50,000 segments", head(1) + &part(1, "") + ")", drawing(50_000, 30.0)),
        ("two joints, 49,998 segments", head(2) + &part(2, "") + ")", drawing(49_998, 30.0)),
        ("99,999 keys", head(1) + &part(1, "") + &clip, drawing(10, 30.0)),
    ];
    if cfg!(feature = "weights") {
        let bounded = |triangles: usize| format!(", weights: Bounded(triangles: {triangles})");
        cases.push(("2 × 4,000 triangles", head(2) + &part(2, &bounded(4_000)) + ")", drawing(100, 30.0)));
        cases.push(("24 × 500 triangles", head(24) + &part(24, &bounded(500)) + ")", drawing(100, 30.0)));
        let corners = |count: usize| {
            let place = |i: usize| std::f64::consts::TAU * i as f64 / count as f64;
            let corner = |i| format!("(\"j{}\", ({}, {})),", i % 2, 90.0 * place(i).cos(), 90.0 * place(i).sin());
            (0..count).map(corner).collect::<String>()
        };
        let cage =
            |count: usize, triangles| format!(", weights: Cage(triangles: {triangles}, corners: [{}])", corners(count));
        cases.push(("a cage of 9 × 20,000", head(2) + &part(2, &cage(9, 20_000)) + ")", drawing(100, 30.0)));
        cases.push(("a cage of 100 × 1,500", head(2) + &part(2, &cage(100, 1_500)) + ")", drawing(100, 30.0)));
        // Teeth so thin that they take all vertices that there may be.
        let teeth: String = (0..120)
            .map(|i| format!("({}, 1), ({}, 60),", 0.1 + 0.3 * f64::from(i), 0.2501 + 0.3 * f64::from(i)))
            .collect();
        let comb =
            format!(", weights: Bounded(triangles: 4000, outline: [(-2, 1), {teeth} (38, 1), (38, -9), (-2, -9)])");
        let joints = "(version: 1, name: \"x\", drawing: \"x.svg\", joints: [(name: \"j0\", at: (1, -4), tip: (15, -4)), (name: \"j1\", at: (20, -4), tip: (35, -4))], ";
        cases.push(("a comb", joints.to_owned() + &part(2, &comb) + ")", drawing(100, 30.0)));
    }
    let mut too_slow = Vec::new();
    for (what, text, drawing) in cases {
        let begin = ProcessTime::now();
        let character = Character::parse("most", text.as_bytes(), |_| Ok(drawing.into_bytes()));
        let character = character.unwrap_or_else(|error| panic!("{what}: {error}"));
        let read = begin.elapsed();
        let bound = character.bind(&BindProgress::default());
        let bind = begin.elapsed() - read;
        let bound = bound.unwrap_or_else(|error| panic!("{what}: {error}"));
        let (mut locals, mut worlds, mut posed) = (character.rest_poses(), Vec::new(), bound.skin.at_rest());
        character.sample(0, 0.7, &mut locals);
        character.worlds(&locals, &mut worlds);
        bound.pose(&worlds, &mut posed).unwrap();
        let all = begin.elapsed();
        println!("{what}: read in {read:.1?}, bound in {bind:.1?}, all in {all:.1?}; so far {} KiB", peak_kib());
        if all > LIMIT {
            too_slow.push(what);
        }
    }
    // What is not optimised may take its time.
    assert!(too_slow.is_empty() || cfg!(debug_assertions), "{too_slow:?}");
}
