//! Weights that are solved for, and their caches.

use super::*;

fn with_weights(weights: &str) -> Character {
    parse(&TEXT.replacen("Shepard(power: 3)", weights, 1)).unwrap()
}

/// Control points of all paths at a time.
fn points(character: &Character, bound: &BoundCharacter) -> Vec<glam::Vec3> {
    let (mut locals, mut worlds, mut posed) = (character.rest_poses(), Vec::new(), bound.skin.at_rest());
    character.sample(0, 0.5, &mut locals);
    character.worlds(&locals, &mut worlds);
    bound.pose(&worlds, &mut posed).unwrap();
    (0..bound.paths.len()).flat_map(|chain| bound.skin.points(&posed, chain).collect::<Vec<_>>()).collect()
}

const SOLVED: [&str; 3] = [
    "Bounded(triangles: 500)",
    "Bounded(triangles: 400, outline: [(110, 80), (160, 85), (210, 80), (210, 120), (160, 115), (110, 120)])",
    "Cage(triangles: 500, corners: [(\"upper\", (110, 80)), (\"upper\", (150, 80)), (\"fore\", (170, 80)), (\"fore\", (210, 80)), (\"fore\", (210, 120)), (\"upper\", (110, 120))])",
];

#[test]
fn caches_serve_until_something_changes() {
    let path = std::env::temp_dir().join(format!("cache_test_{}.weights", std::process::id()));
    for weights in SOLVED {
        let _ = std::fs::remove_file(&path);
        let character = with_weights(weights);
        let progress = BindProgress::default();
        let fresh = points(&character, &character.bind(&progress).unwrap());
        assert_eq!(progress.fraction(), 1.0);
        let bind = |character: &Character| {
            let (bound, used) = character.bind_cached(&path, &BindProgress::default()).unwrap();
            (points(character, &bound), used)
        };
        let (first, used) = bind(&character);
        assert!(matches!(used, CacheUse::Rebuilt), "{used:?}");
        let (second, used) = bind(&character);
        assert!(matches!(used, CacheUse::Used), "{used:?}");
        assert_eq!((&first, &second), (&fresh, &fresh), "to the bit");
        // What weights do not depend on.
        let mut other = character.clone();
        other.clips.clear();
        other.joints[3].at.x += 1.0;
        assert!(matches!(bind(&other).1, CacheUse::Used));
        // What they do.
        let mut other = character.clone();
        other.joints[2].tip.as_mut().unwrap().x -= 1e-9;
        let is_cage = weights.starts_with("Cage");
        let used = bind(&other).1;
        assert!(matches!(used, CacheUse::Rebuilt) || is_cage, "{used:?}");
        bind(&character);
        let bytes = std::fs::read(&path).unwrap();
        println!("{} bytes for {weights}", bytes.len());
        // Damaged in one bit, cut short, or longer.
        for change in 0..200 {
            let mut broken = bytes.clone();
            match change {
                0 => broken.clear(),
                1 => broken.truncate(bytes.len() - 1),
                2 => broken.push(0),
                _ => broken[change * 7919 % bytes.len()] ^= 1 << (change % 8),
            }
            let (_, new) = character.bind_with(&broken, &BindProgress::default()).unwrap();
            assert!(new.is_some_and(|new| new == bytes), "{change}");
            if change > 8 && !is_cage {
                break;
            }
        }
        std::fs::create_dir_all(path.with_extension("d")).unwrap();
        let (_, used) = character.bind_cached(path.with_extension("d"), &BindProgress::default()).unwrap();
        assert!(matches!(used, CacheUse::NotSaved(_)), "{used:?}");
        std::fs::remove_dir(path.with_extension("d")).unwrap();
    }
    let _ = std::fs::remove_file(&path);
    let (_, used) = doll().bind_cached(&path, &BindProgress::default()).unwrap();
    assert!(matches!(used, CacheUse::Unneeded) && !path.exists(), "{used:?}");
}

#[test]
fn weights_that_cannot_be_are_named_with_their_part() {
    let crossing = "Bounded(triangles: 400, outline: [(110, 80), (210, 120), (210, 80), (110, 120)])";
    let error = with_weights(crossing).bind(&BindProgress::default()).unwrap_err().to_string();
    assert!(error.starts_with("part `arm`: edges 0 and 2 of the cage cross"), "{error}");
    let outside = "Bounded(triangles: 400, outline: [(0, 0), (10, 0), (10, 10)])";
    let error = with_weights(outside).bind(&BindProgress::default()).unwrap_err().to_string();
    assert!(error.starts_with("part `arm`: handle 0 lies outside"), "{error}");
}

/// Every place of an arm moves by a share between those of its joints: near the shoulder with one, at the hand with the other.
#[test]
fn solved_weights_fade_from_joint_to_joint() {
    for weights in SOLVED {
        let character = with_weights(weights);
        let bound = character.bind(&BindProgress::default()).unwrap();
        let mut worlds = character.rest_worlds();
        worlds[2].translation.y += 10.0;
        let mut posed = bound.skin.at_rest();
        bound.pose(&worlds, &mut posed).unwrap();
        let path =
            bound.paths.iter().find(|p| character.drawing.shapes[p.shape].id.as_deref() == Some("sleeve")).unwrap();
        let rest = bound.skin.at_rest();
        // Anchors lie on the curve.
        for (point, at) in bound.skin.points(&posed, path.chain).zip(bound.skin.points(&rest, path.chain)).step_by(3) {
            let share = (point.y - at.y) / 10.0;
            assert!((-0.2..=1.2).contains(&share), "{weights} {at} {share}");
            assert!(at.x > 130.0 || share < 0.3, "{weights} {at} {share}");
            assert!(at.x < 185.0 || share > 0.7, "{weights} {at} {share}");
        }
    }
}
