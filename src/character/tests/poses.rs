//! Poses against what they are by definition.

use glam::{DAffine2, DVec2, DVec3};

use super::*;
use crate::skin::{
    BindOptions, BoundChain, Chain, HandleShape, JoinKind, JoinRules, Shepard, SolveWorkspace, in_space,
};

#[test]
fn at_rest_nothing_moves() {
    let doll = doll();
    let bound = doll.bind(&BindProgress::default()).unwrap();
    let (mut worlds, mut posed) = (Vec::new(), bound.skin.at_rest());
    doll.worlds(&doll.rest_poses(), &mut worlds);
    for (world, rest) in worlds.iter().zip(doll.rest_worlds()) {
        assert!(world.abs_diff_eq(rest, 1e-13));
    }
    bound.pose(&worlds, &mut posed).unwrap();
    for path in &bound.paths {
        let rest = &doll.drawing.shapes[path.shape].paths[path.path];
        for (point, rest) in bound.skin.points(&posed, path.chain).zip(rest.points()) {
            assert!(point.truncate().as_dvec2().distance(*rest) < 1e-4, "{point} {rest}");
        }
    }
    // A clip that is not there.
    let mut locals = vec![JointPose::default(); 3];
    doll.sample(9, 1.0, &mut locals);
    assert_eq!(locals, doll.rest_poses()[..3]);
    doll.worlds(&locals, &mut worlds);
    assert!(worlds[3].abs_diff_eq(doll.joints[3].rest_world(), 1e-13));
}

#[test]
fn posed_points_are_those_of_the_direct_solve() {
    let doll = doll();
    let bound = doll.bind(&BindProgress::default()).unwrap();
    let size = 200.0;
    let handle = |joint: usize| {
        let joint = &doll.joints[joint];
        let tip = joint.tip.unwrap();
        HandleShape::Bone(joint.at.extend(0.0), tip.extend(0.0))
    };
    let arm = Shepard::with_power(&[handle(1), handle(2)], 3.0).unwrap();
    let (mut worst, mut moved_most) = (0.0_f64, 0.0_f64);
    for step in 0..20 {
        let time = 0.1 * f64::from(step);
        // By hand: rotations about where joints are, in the drawing.
        let turn = |joint: usize, angle: f64| {
            let at = doll.joints[joint].at;
            DAffine2::from_translation(at) * DAffine2::from_angle(angle) * DAffine2::from_translation(-at)
        };
        let mut locals = doll.rest_poses();
        doll.sample(0, time, &mut locals);
        let angles: Vec<f64> = locals.iter().zip(doll.rest_poses()).map(|(l, r)| l.rotation - r.rotation).collect();
        let lift = DAffine2::from_translation(locals[0].translation - doll.joints[0].at);
        let neck = lift * turn(3, angles[3]);
        let transforms = [lift, lift, lift * turn(2, angles[2]), neck];
        let (mut worlds, mut posed) = (Vec::new(), bound.skin.at_rest());
        doll.worlds(&locals, &mut worlds);
        bound.pose(&worlds, &mut posed).unwrap();
        for path in &bound.paths {
            let rest = &doll.drawing.shapes[path.shape].paths[path.path];
            let mut wished: Vec<DVec2> = match path.part {
                0 => rest.points().iter().map(|p| transforms[0].transform_point2(*p)).collect(),
                2 => rest.points().iter().map(|p| transforms[3].transform_point2(*p)).collect(),
                _ => {
                    let mut chain = Chain::planar(rest, &JoinRules::default());
                    if doll.drawing.shapes[path.shape].id.as_deref() == Some("sleeve") {
                        chain.set_join(2, JoinKind::Corner).unwrap();
                    }
                    let direct = BoundChain::new(&chain, 0, &arm, &BindOptions::default()).unwrap();
                    let (mut out, pose) = (Vec::<DVec3>::new(), [transforms[1], transforms[2]].map(|t| in_space(&t)));
                    direct.solve(&pose, &mut SolveWorkspace::default(), &mut out).unwrap();
                    out.iter().map(|p| p.truncate()).collect()
                }
            };
            wished.truncate(bound.skin.chains()[path.chain].chain().points().len());
            for ((point, wished), rest) in bound.skin.points(&posed, path.chain).zip(&wished).zip(rest.points()) {
                worst = worst.max(point.truncate().as_dvec2().distance(*wished));
                moved_most = moved_most.max(wished.distance(*rest));
            }
        }
    }
    println!("off by {worst:e} of {size}, moved by up to {moved_most}");
    assert!(worst < 2e-6 * size && moved_most > 20.0, "{worst} {moved_most}");
}

#[test]
fn children_go_with_their_parents() {
    let doll = doll();
    let mut locals = doll.rest_poses();
    locals[0].rotation += 0.5;
    locals[0].scale = DVec2::new(2.0, 1.0);
    locals[1].rotation -= 0.25;
    let mut worlds = Vec::new();
    doll.worlds(&locals, &mut worlds);
    // The hips' own x axis goes up.
    let hips = doll.joints[0].at;
    let up = |p: DVec2| DVec2::new(p.x, 2.0 * p.y);
    let upper = hips + DVec2::from_angle(0.5).rotate(up(doll.joints[1].at - hips));
    assert!(worlds[1].translation.distance(upper) < 1e-12, "{} {upper}", worlds[1].translation);
    let turned = DVec2::from_angle(0.5).rotate(up(DVec2::from_angle(doll.joints[1].angle - 0.25)));
    assert!(worlds[1].transform_vector2(DVec2::X).distance(turned) < 1e-12);
}

/// Values of a track with keys in one coordinate.
fn value(keys: &[(f64, f64)], easing: Easing, loops: bool, time: f64) -> f64 {
    let track = Track { joint: 0, easing, keys: Keys::Rotation(keys.to_vec()) };
    let clip = Clip { name: String::new(), duration: 4.0, loops, tracks: Vec::new() };
    let mut pose = JointPose::default();
    clip.apply(&track, time, &mut pose);
    pose.rotation
}

#[test]
fn keys_are_reached_and_never_left_behind() {
    let keys = [(0.5, 1.0), (1.0, 3.0), (2.0, 2.0), (3.0, 2.5), (3.5, 4.0)];
    for easing in [Easing::Step, Easing::Linear, Easing::Cubic] {
        for loops in [false, true] {
            for (time, wished) in keys {
                assert_eq!(value(&keys, easing, loops, time), wished, "{easing:?} {loops} {time}");
                let later = value(&keys, easing, loops, time + if loops { 12.0 } else { 0.0 });
                assert!((later - wished).abs() < 1e-12);
            }
            let mut before = value(&keys, easing, loops, 0.0);
            for step in 1..=4000 {
                let time = f64::from(step) * 1e-3;
                let now = value(&keys, easing, loops, time);
                let i = keys.iter().rposition(|key| key.0 <= time);
                let from = i.map_or(if loops { 4.0 } else { 1.0 }, |i| keys[i].1);
                let to = keys.get(i.map_or(0, |i| i + 1)).map_or(if loops { 1.0 } else { 4.0 }, |key| key.1);
                assert!(now >= from.min(to) - 1e-12 && now <= from.max(to) + 1e-12, "{easing:?} {loops} {time}");
                assert!(easing == Easing::Step || (now - before).abs() < 0.02, "{easing:?} {loops} {time}");
                before = now;
            }
        }
    }
    // Before the first and behind the last.
    assert_eq!(value(&keys, Easing::Cubic, false, -1.0), 1.0);
    assert_eq!(value(&keys, Easing::Cubic, false, 9.0), 4.0);
    assert_eq!(value(&keys, Easing::Linear, false, 0.75), 2.0);
    assert!((value(&keys, Easing::Linear, true, 0.0) - 2.5).abs() < 1e-12, "half way from 3.5 to 4.5");
    assert_eq!(value(&keys, Easing::Step, true, 0.25), 4.0);
    assert_eq!(value(&[(1.0, 7.0)], Easing::Cubic, true, 0.3), 7.0);
    assert_eq!(value(&[], Easing::Cubic, true, 0.3), 0.0);
    assert!(value(&keys, Easing::Cubic, true, f64::NAN).is_finite());
}

#[test]
fn cubic_keys_have_the_slopes_of_their_paper() {
    // Fritsch and Butland's slope between secants of 4 over 0.5 and 1 over 1.
    let keys = [(1.0, 0.0), (1.5, 2.0), (2.5, 3.0), (3.0, 3.5)];
    let slope = 3.0 * 1.5 / ((2.0 + 0.5) / 4.0 + (1.0 + 1.0) / 1.0);
    let h = 1e-5;
    let [left, right] =
        [-h, h].map(|h| (value(&keys, Easing::Cubic, false, 1.5 + h) - value(&keys, Easing::Cubic, false, 1.5)) / h);
    assert!((left - slope).abs() < 1e-3 && (right - slope).abs() < 1e-3, "{left} {right} {slope}");
    // Loops are as smooth at their seam as anywhere.
    let keys = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.5), (3.0, -1.0)];
    let [left, right] = [4.0 - h, h].map(|t| value(&keys, Easing::Cubic, true, t) / h);
    assert!((left + right).abs() < 1e-3 && right > 0.5, "{left} {right}");
}
