//! The character that the project brings along.

use std::path::PathBuf;

use bevy_surface_splines::character::{BindProgress, Character};
use bevy_surface_splines::skin::JoinKind;
use bevy_surface_splines::vector::FillRule;
use glam::{DAffine2, DVec2};

/// How fast the ground passes by while it walks, in the drawing's units a second, and how high it lies.
const SPEED: f64 = 186.67;
const GROUND: f64 = -521.0;

fn hero() -> Character {
    Character::read(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/hero.character.ron")).unwrap()
}

/// From the frames of joints to the drawing at a time of a clip.
fn worlds(hero: &Character, clip: &str, time: f64) -> Vec<DAffine2> {
    let (mut locals, mut worlds) = (hero.rest_poses(), Vec::new());
    hero.sample(hero.clip_named(clip).unwrap(), time, &mut locals);
    hero.worlds(&locals, &mut worlds);
    worlds
}

#[test]
fn the_hero_has_all_that_a_character_may_have() {
    let hero = hero();
    println!("{} segments, {} joints, {} parts", hero.drawing.segment_count(), hero.joints.len(), hero.parts.len());
    assert!(hero.drawing.segment_count() >= 150 && hero.joints.len() >= 12);
    let holes = hero.drawing.shapes.iter().filter(|s| s.paths.len() > 1 && s.style.fill_rule == FillRule::EvenOdd);
    assert!(holes.count() > 0);
    let clips: Vec<&str> = hero.clips.iter().map(|clip| clip.name.as_str()).collect();
    assert_eq!(clips, ["idle", "walk", "wave"]);
    assert!(hero.clips.iter().all(|clip| clip.loops));
    // Limbs are one smooth outline over two joints.
    let bound = hero.bind(&BindProgress::default()).unwrap();
    for limb in ["near-leg", "far-leg", "near-sleeve", "far-sleeve"] {
        let shape = hero.drawing.shapes.iter().position(|shape| shape.id.as_deref() == Some(limb)).unwrap();
        let path = bound.paths.iter().find(|path| path.shape == shape).unwrap();
        let chain = bound.skin.chains()[path.chain].chain();
        assert!(chain.is_closed() && chain.joins().iter().all(|join| join.kind == JoinKind::Smooth), "{limb}");
        assert_eq!(hero.parts[path.part].follows.len(), 2);
    }
    let text = hero.to_ron().unwrap();
    let svg = std::fs::read(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/hero.svg")).unwrap();
    let again = Character::parse("hero.character.ron", text.as_bytes(), |_| Ok(svg)).unwrap();
    assert_eq!(again, hero);
    assert_eq!(again.to_ron().unwrap(), text);
}

#[test]
fn clips_loop_without_a_seam() {
    let hero = hero();
    let moved = |a: &[DAffine2], b: &[DAffine2]| {
        let corners = [DVec2::ZERO, DVec2::X * 50.0];
        let far = |(a, b): (&DAffine2, &DAffine2)| {
            corners.map(|p| a.transform_point2(p).distance(b.transform_point2(p))).into_iter().fold(0.0, f64::max)
        };
        a.iter().zip(b).map(far).fold(0.0, f64::max)
    };
    for clip in ["idle", "walk", "wave"] {
        let duration = hero.clips[hero.clip_named(clip).unwrap()].duration;
        assert!(moved(&worlds(&hero, clip, 0.0), &worlds(&hero, clip, duration)) < 1e-9);
        // Nothing jumps, at the seam or elsewhere: steps half as long go half as far.
        for step in 0..200 {
            let (time, h) = (duration * f64::from(step) / 200.0, duration / 400.0);
            let at = worlds(&hero, clip, time);
            let (whole, half) =
                (moved(&at, &worlds(&hero, clip, time + h)), moved(&at, &worlds(&hero, clip, time + 0.5 * h)));
            assert!(half < 0.75 * whole + 0.2, "{clip} {time} {whole} {half}");
        }
    }
}

#[test]
fn feet_stay_where_they_are_put() {
    let hero = hero();
    let sole = |side: &str, t: f64| {
        let joint = hero.joint_named(&format!("{side}-foot")).unwrap();
        let at = hero.joints[joint].at;
        let [heel, ball] = [-15.0, 28.0].map(|x| DVec2::new(at.x + x, at.y - 27.0));
        let moved = worlds(&hero, "walk", t)[joint] * hero.joints[joint].rest_world().inverse();
        [heel, ball].map(|p| moved.transform_point2(p) + DVec2::X * SPEED * t)
    };
    for (side, phase) in [("near", 0.0), ("far", 0.5)] {
        let (mut slid, mut sunk) = (0.0_f64, 0.0_f64);
        let flat = |k: u32| sole(side, phase + 0.1 + 0.26 * f64::from(k) / 20.0);
        let first = flat(0);
        for k in 0..=20 {
            for (p, q) in flat(k).iter().zip(&first) {
                slid = slid.max((p.x - q.x).abs());
                sunk = sunk.max((p.y - GROUND).abs());
            }
        }
        // The ball stays while the heel lifts.
        for k in 0..=20 {
            let ball = sole(side, phase + 0.36 + 0.24 * f64::from(k) / 20.0)[1];
            slid = slid.max((ball.x - first[1].x).abs());
            sunk = sunk.max((ball.y - GROUND).abs());
        }
        println!("{side} foot: slides by {slid:.2}, off the ground by {sunk:.2}, of a height of 510");
        assert!(slid < 4.0 && sunk < 4.0, "{side} {slid} {sunk}");
    }
}

#[test]
fn smooth_outlines_stay_smooth_in_all_clips() {
    let hero = hero();
    let bound = hero.bind(&BindProgress::default()).unwrap();
    let mut posed = bound.skin.at_rest();
    let (mut worst, mut checked) = (0.0_f64, 0);
    for clip in &hero.clips {
        for step in 0..16 {
            let worlds = worlds(&hero, &clip.name, clip.duration * f64::from(step) / 16.0);
            bound.pose(&worlds, &mut posed).unwrap();
            for path in &bound.paths {
                let chain = bound.skin.chains()[path.chain].chain();
                let points: Vec<DVec2> =
                    bound.skin.points(&posed, path.chain).map(|p| p.truncate().as_dvec2()).collect();
                let count = points.len();
                for (anchor, join) in chain.joins().iter().enumerate().filter(|(_, j)| j.kind == JoinKind::Smooth) {
                    assert_eq!(join.pinned, None);
                    let at = 3 * anchor;
                    let [before, behind] =
                        [points[(at + count - 1) % count] - points[at], points[(at + 1) % count] - points[at]];
                    if before.length() > 0.5 && behind.length() > 0.5 {
                        worst = worst.max((before.normalize() + behind.normalize()).length());
                        checked += 1;
                    }
                }
            }
        }
    }
    println!("{checked} smooth joins, off by {worst:e} at most");
    assert!(checked > 1000 && worst < 1e-3);
}
