//! Characters: broken files, and the one that the project brings along.

mod broken;
mod hero;

/// A drawing with all that a character's parts may be: groups, holes, joins of several kinds, things without an id.
const DRAWING: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 240 240">
  <defs><linearGradient id="g"><stop stop-color="#f00"/><stop offset="1" stop-color="#00f"/></linearGradient></defs>
  <g id="figure">
    <path id="trunk" fill="url(#g)" fill-rule="evenodd" d="M 80 100 C 80 80 120 80 120 100 L 120 160 H 80 z M 95 120 h 10 v 10 h -10 z"/>
    <g id="arm">
      <path id="sleeve" fill="#234" stroke="#111" d="M 120 95 C 140 93 150 93 160 95 C 170 97 190 93 195 97 C 199 101 190 107 160 105 C 150 104.3 140 107 120 105 C 117 103 117 97 120 95 z"/>
      <path id="hand" d="M 195 97 q 10 5 0 8 z"/>
      <path d="M 120 100 L 195 101" fill="none" stroke="#fff" stroke-dasharray="3 2"/>
    </g>
    <circle id="head" cx="100" cy="60" r="20"/>
    <path id="tail" d="M 80 150 C 60 150 50 160 30 158 S 10 170 5 160 C 10 150 60 130 80 140 z" fill="#777"/>
  </g>
</svg>
"##;

/// A character with all that its file may hold.
const TEXT: &str = r#"(
  version: 1,
  name: "doll",
  drawing: "doll.svg",
  weights: Shepard(power: 3),
  joints: [
    (name: "hips", at: (100, 160), tip: (100, 95), angle: 90),
    (name: "chest", parent: "hips", at: (100, 120), tip: (100, 80)),
    (name: "fore", parent: "upper", at: (160, 100), tip: (195, 100)),
    (name: "upper", parent: "chest", at: (120, 100), tip: (160, 100), angle: -7.3),
    (name: "hand", parent: "fore", at: (195, 101)),
    (name: "neck", parent: "chest", at: (100, 80), tip: (100, 40)),
    (name: "tail 1", parent: "hips", at: (80, 145), tip: (40, 150)),
    (name: "tail 2", parent: "tail 1", at: (40, 150), tip: (5, 160)),
  ],
  parts: [
    (name: "body", shapes: ["figure"], follows: ["hips", "chest"]),
    (name: "arm", shapes: ["arm"], follows: ["fore", "upper"], z: 1.5, joins: [
      (shape: "sleeve", anchor: 2, kind: Corner),
      (shape: "sleeve", path: 0, anchor: 4, kind: Smooth),
      (shape: "sleeve", anchor: 1, kind: Mirrored),
      (shape: "sleeve", anchor: 3, kind: Angle),
    ]),
    (name: "hand", shapes: ["hand"], follows: ["hand"], z: 1.5),
    (name: "head", shapes: ["head"], follows: ["neck"], z: -1, weights: Shepard(power: 2)),
    (
      name: "tail",
      shapes: ["tail"],
      follows: ["tail 1", "tail 2"],
      z: -2,
      weights: TAIL,
    ),
  ],
  clips: [
    (name: "wave", duration: 2, loops: true, tracks: [
      (joint: "fore", keys: Rotation([(0, 0), (0.5, 40), (1, 10), (1.5, 40.3)])),
      (joint: "upper", keys: Rotation([(0, 10), (1, 14)])),
      (joint: "neck", easing: Linear, keys: Rotation([(0, -5), (1, 5)])),
      (joint: "hips", keys: Translation([(0, (0, 0)), (1, (0, -4.1))])),
      (joint: "tail 1", keys: Rotation([(0, 12), (0.33, -3.5), (0.67, 8), (1.2, -11), (1.6, 2)])),
      (joint: "tail 2", keys: Rotation([(0.2, 22), (0.53, -13.5), (0.87, 18), (1.4, -21), (1.8, 12)])),
    ]),
    (name: "jump", duration: 0.8, tracks: [
      (joint: "hips", easing: Step, keys: Translation([(0.1, (3, 8)), (0.5, (0, -40))])),
      (joint: "hips", keys: Scale([(0, (1, 1)), (0.8, (1.1, 0.9))])),
      (joint: "chest", keys: Scale([(0, (1, 1)), (0.3, (0.9, 1.15)), (0.5, (1.05, 0.95)), (0.8, (1, 1))])),
      (joint: "tail 1", keys: Rotation([(0.1, 40), (0.2, 33), (0.35, -20), (0.5, -41), (0.7, 7)])),
      (joint: "tail 2", keys: Rotation([(0.15, 60), (0.25, 13), (0.4, -40), (0.55, -61), (0.75, 9)])),
    ]),
    (name: "walk", duration: 1, loops: true, tracks: [
      // One track of everything for each joint that there is.
      (joint: "hips", easing: Linear, keys: Rotation([(0, 2), (0.25, -2), (0.5, 2), (0.75, -2)])),
      (joint: "hips", keys: Translation([(0, (0, 3)), (0.25, (0, -3)), (0.5, (0, 3)), (0.75, (0, -3))])),
      (joint: "chest", easing: Linear, keys: Rotation([(0, -4), (0.5, 4)])),
      (joint: "upper", keys: Rotation([(0, -24), (0.125, -20.5), (0.25, 0), (0.5, 24.25), (0.75, 3)])),
      (joint: "fore", keys: Rotation([(0, 14), (0.125, 20.5), (0.25, 30), (0.5, 44.25), (0.75, 31)])),
      (joint: "hand", keys: Rotation([(0, 4), (0.5, -14.25)])),
      (joint: "neck", keys: Rotation([(0, 3), (0.25, -3), (0.5, 3), (0.75, -3)])),
      (joint: "tail 1", easing: Step, keys: Rotation([(0, 3), (0.25, -3), (0.5, 3), (0.75, -3)])),
      (joint: "tail 2", keys: Scale([(0, (1, 1)), (0.5, (1.2, 0.8))])),
    ]),
    (name: "look around", duration: 6.5, loops: true, tracks: [
      (joint: "neck", keys: Rotation([(0, 0), (1, 12.5), (2.2, 14), (2.6, -3), (3.4, -17.25), (4.8, -15), (5.5, 2)])),
      (joint: "chest", keys: Rotation([(0, 0), (1.1, 2.5), (2.3, 3), (3.5, -4.25), (4.9, -3.5), (5.7, 1)])),
      (joint: "hips", keys: Translation([(0, (0, 0)), (1.5, (2.5, 0.5)), (3, (0, 1)), (4.5, (-2.5, 0.5))])),
      (joint: "upper", easing: Linear, keys: Rotation([(0, -2), (3.25, 2)])),
      (joint: "fore", easing: Step, keys: Rotation([(0, 5), (2, 7.5), (4, 6)])),
      (joint: "tail 1", keys: Rotation([(0, 8), (1.6, -8), (3.2, 8), (4.8, -8)])),
    ]),
  ],
)
"#;

/// Weights for the tail; the last two are solved for.
const TAILS: [&str; 3] = [
    "Shepard(power: 5)",
    "Bounded(triangles: 100, outline: [(0, 120), (90, 120), (90, 180), (0, 180)])",
    "Cage(triangles: 100, corners: [(\"tail 1\", (90, 120)), (\"tail 2\", (0, 120)), (\"tail 2\", (0, 180)), (\"tail 1\", (90, 180))])",
];

/// The text with weights for the tail.
fn text(tail: &str) -> String {
    TEXT.replace("TAIL", tail)
}

/// A character that follows the skeleton of a model: as it was bound nothing moves, and a turned joint turns what follows it.
#[cfg(feature = "formats")]
#[test]
fn a_skeleton_drives_a_drawing() {
    use bevy_surface_splines::character::{BindProgress, Character, DrawingPlane, SkeletonMap};
    use bevy_surface_splines::format::{SkinnedMeshOptions, read_skinned_mesh};
    use glam::{DAffine3, DVec2, DVec3};

    let Some(corpus) = std::env::var_os("SURFACE_CORPUS") else {
        println!("skipped: SURFACE_CORPUS is not set");
        return;
    };
    let path = std::path::Path::new(&corpus).join("rigs/fox.glb");
    let fox = read_skinned_mesh(path, &SkinnedMeshOptions::default()).unwrap();
    let doll = text(TAILS[0]);
    let doll = Character::parse("doll", doll.as_bytes(), |_| Ok(DRAWING.into())).unwrap();
    let pairs = [("hips", "b_Hip_01"), ("neck", "b_Neck_04"), ("upper", "b_LeftUpperArm_09")];
    let map = SkeletonMap::by_names(&doll, &fox, &pairs).unwrap();
    // Seen from its side, which is along x.
    let plane = DrawingPlane { origin: DVec3::new(0.0, 100.0, 50.0), x: DVec3::NEG_Z, y: DVec3::Y };
    let bound = doll.bind(&BindProgress::default()).unwrap();
    let (mut worlds, mut posed) = (Vec::new(), bound.skin.at_rest());
    // The pose that it was bound in.
    let still = vec![DAffine3::IDENTITY; fox.joints.len()];
    map.worlds(&doll, &plane, &still, &mut worlds);
    bound.pose(&worlds, &mut posed).unwrap();
    let rest = bound.skin.at_rest();
    let far = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(far(posed.x(), rest.x()) < 1e-3 && far(posed.y(), rest.y()) < 1e-3);
    // Turned about its neck, in its own pose.
    let [neck, hips] = ["neck", "hips"].map(|name| doll.joint_named(name).unwrap());
    let seen = |angle: f64, worlds: &mut Vec<_>| {
        let mut locals = fox.locals();
        let joint = fox.joint_named("b_Neck_04").unwrap();
        let pose = fox.pose(&locals).unwrap();
        // About the world's x axis, wherever the joint's own axes point.
        let world = pose[joint] * fox.joints[joint].bind.inverse();
        let turn = DAffine3::from_quat(glam::DQuat::from_rotation_x(angle));
        let about =
            DAffine3::from_translation(world.translation) * turn * DAffine3::from_translation(-world.translation);
        locals[joint] = locals[joint] * world.inverse() * about * world;
        map.worlds(&doll, &plane, &fox.pose(&locals).unwrap(), worlds);
        (worlds[neck].transform_vector2(DVec2::X), worlds[hips])
    };
    let (before, hips_before) = seen(0.0, &mut worlds);
    let (after, hips_after) = seen(0.4, &mut worlds);
    assert!((before.angle_to(after) - 0.4).abs() < 1e-6, "{before} {after}");
    assert_eq!(hips_before, hips_after);
    let error = SkeletonMap::by_names(&doll, &fox, &[("hips", "nowhere")]).unwrap_err();
    assert_eq!(error.to_string(), "the model: there is no joint `nowhere`: correct the name, or add the joint");
}
