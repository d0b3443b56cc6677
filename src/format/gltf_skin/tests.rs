//! Documents made by hand, sound and damaged.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

use super::super::error::Place;
use super::super::gltf::{parse_json, parse_skinned_json};
use super::*;
use crate::skin::SkinError;

/// Joints and weights of three vertices.
const JOINTS: [[u8; 4]; 3] = [[0, 9, 9, 9], [1, 0, 9, 9], [0, 1, 0, 9]];
const WEIGHTS: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.25, 0.0, 0.0], [0.25, 0.5, 0.25, 0.0]];

/// A triangle that two joints move, one above the other with a node between them, and another triangle that hangs on the lower joint.
fn document(joints: [[u8; 4]; 3], weights: [[f32; 4]; 3]) -> String {
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bind = |x: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, 0.0, 0.0, 1.0];
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let parts = [
        floats(corners.as_flattened()),
        joints.as_flattened().to_vec(),
        floats(weights.as_flattened()),
        floats([bind(-1.0), bind(-3.0)].as_flattened()),
    ];
    let data = STANDARD.encode(parts.concat());
    format!(
        r#"{{"asset":{{"version":"2.0"}},
        "nodes":[{{"name":"skinned","mesh":0,"skin":0,"translation":[0,0,5]}},
        {{"name":"upper","children":[2],"translation":[1,0,0]}},
        {{"name":"between","children":[3],"translation":[1,0,0]}},
        {{"name":"lower","children":[4],"translation":[1,0,0]}},
        {{"name":"hanging","mesh":1,"scale":[2,2,2]}}],
        "skins":[{{"joints":[1,3],"inverseBindMatrices":3}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}}}}]}},
        {{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "buffers":[{{"byteLength":224,"uri":"data:application/octet-stream;base64,{data}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":12}},
        {{"buffer":0,"byteOffset":48,"byteLength":48}},{{"buffer":0,"byteOffset":96,"byteLength":128}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
        {{"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"}},
        {{"bufferView":2,"componentType":5126,"count":3,"type":"VEC4"}},
        {{"bufferView":3,"componentType":5126,"count":2,"type":"MAT4"}}]}}"#
    )
}

fn read(document: &str) -> Result<SkinnedMesh, Fault> {
    parse_skinned_json(document.as_bytes(), None, &SkinnedMeshOptions::default())
}

fn fails(from: &str, to: &str) -> (String, Cause) {
    let good = document(JOINTS, WEIGHTS);
    assert!(good.contains(from), "{from}");
    let fault = read(&good.replace(from, to)).unwrap_err();
    let Place::Item(item) = fault.place else { panic!("{:?}", fault.place) };
    (item, fault.cause)
}

#[test]
fn joints_have_names_parents_and_frames() {
    let skinned = read(&document(JOINTS, WEIGHTS)).unwrap();
    assert_eq!(skinned.mesh, parse_json(document(JOINTS, WEIGHTS).as_bytes(), None).unwrap());
    let names: Vec<_> = skinned.joints.iter().map(|joint| joint.name.as_deref().unwrap()).collect();
    assert_eq!(names, ["upper", "lower", "hanging"]);
    assert_eq!(skinned.joints.iter().map(|joint| joint.parent).collect::<Vec<_>>(), [None, Some(0), Some(1)]);
    assert_eq!(skinned.joints.iter().map(|joint| joint.node).collect::<Vec<_>>(), [1, 3, 4]);
    assert_eq!(skinned.joint_named("lower"), Some(1));
    assert_eq!(skinned.joint_named("between"), None);
    // Moved by what lies between.
    assert_eq!(skinned.joints[1].local, DAffine3::from_translation(DVec3::X * 2.0));
    // The mesh stands five above where it was bound.
    assert_eq!(skinned.joints[1].bind, DAffine3::from_translation(DVec3::new(-3.0, 0.0, -5.0)));
}

#[test]
fn weights_are_brought_to_a_sum_of_one() {
    let skinned = read(&document(JOINTS, WEIGHTS)).unwrap();
    assert_eq!((skinned.uneven, skinned.worst_miss), (1, 0.25));
    let [set] = &skinned.sets[..] else { panic!("{:?}", skinned.sets) };
    assert_eq!(set.joints[..3], [[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]]);
    assert_eq!(set.weights[1], [2.0 / 3.0, 1.0 / 3.0, 0.0, 0.0]);
    // What has no skin hangs on its node.
    assert_eq!((&set.joints[3..], &set.weights[3..]), (&[[2, 0, 0, 0]; 3][..], &[[1.0, 0.0, 0.0, 0.0]; 3][..]));
    let strict = parse_skinned_json(document(JOINTS, WEIGHTS).as_bytes(), None, &SkinnedMeshOptions { uneven: 0.2 });
    assert_eq!(strict.unwrap_err().cause, Cause::BadWeights { vertex: 1, sum: "0.75".into() });
}

#[test]
fn poses_are_products_down_the_tree() {
    let skinned = read(&document(JOINTS, WEIGHTS)).unwrap();
    let mut locals = skinned.locals();
    // At rest joints are where they were bound, but for the mesh's own place; what hangs does not move.
    let rest = skinned.pose(&locals).unwrap();
    let down = DAffine3::from_translation(DVec3::Z * -5.0);
    for (found, wished) in rest.iter().zip([down, down, DAffine3::IDENTITY]) {
        assert!(found.abs_diff_eq(wished, 1e-15), "{found:?}");
    }
    locals[0] *= DAffine3::from_rotation_z(std::f64::consts::FRAC_PI_2);
    let posed = skinned.pose(&locals).unwrap();
    // About (1, 0, 0), a quarter turn.
    let turned = |p: DVec3| DVec3::new(1.0 - p.y, p.x - 1.0, p.z);
    for place in [DVec3::ZERO, DVec3::new(3.0, 0.5, 2.0)] {
        assert!(posed[1].transform_point3(place).distance(turned(place - DVec3::Z * 5.0)) < 1e-14);
        assert!(posed[2].transform_point3(place).distance(turned(place)) < 1e-14);
    }
    assert_eq!(skinned.pose(&locals[..2]), Err(SkinError::PoseLength { handles: 3, found: 2 }));
    locals[0].translation.x = f64::NAN;
    assert_eq!(skinned.pose(&locals), Err(SkinError::PoseNotFinite { handle: 0 }));
}

#[test]
fn skins_stand_once_for_each_place_of_their_meshes() {
    let twice = document(JOINTS, WEIGHTS).replace(r#""mesh":1,"#, r#""mesh":0,"skin":0,"#);
    let skinned = read(&twice).unwrap();
    assert_eq!(skinned.joints.len(), 4);
    assert_eq!(skinned.joints[3].parent, Some(2));
    assert_eq!(skinned.sets[0].joints[3..], [[2, 0, 0, 0], [3, 2, 0, 0], [2, 3, 2, 0]]);
    let same = twice.replace(r#""scale":[2,2,2]"#, r#""translation":[-3,0,5]"#);
    assert_eq!(read(&same).unwrap().joints.len(), 2);
    // Named twice, a node is two joints.
    let again = read(&document(JOINTS, WEIGHTS).replace(r#""joints":[1,3]"#, r#""joints":[1,1]"#)).unwrap();
    assert_eq!(again.joints.iter().map(|joint| joint.parent).collect::<Vec<_>>(), [None, None, Some(0)]);
}

#[test]
fn what_is_missing_or_damaged_is_named() {
    let primitive = "mesh 0, primitive 0".to_owned();
    let missing = |what| Cause::Missing(what);
    let no_joints = missing("an attribute `JOINTS_n` of the skinned mesh");
    let no_weights = missing("an attribute `WEIGHTS_n` of the skinned mesh");
    let nothing = |what: &str| Cause::NoSuchItem(what.into());
    for (from, to, item, cause) in [
        (r#","JOINTS_0":1"#, "", &*primitive, no_joints.clone()),
        (r#","WEIGHTS_0":2"#, "", &primitive, no_weights.clone()),
        (r#","WEIGHTS_0":2"#, r#","WEIGHTS_0":2,"WEIGHTS_1":2"#, &primitive, no_joints),
        (r#","WEIGHTS_0":2"#, r#","WEIGHTS_0":2,"JOINTS_1":1"#, &primitive, no_weights),
        (r#""JOINTS_0":1"#, r#""JOINTS_0":8"#, "the document", nothing("accessor 8")),
        (r#""WEIGHTS_0":2"#, r#""WEIGHTS_0":8"#, "the document", nothing("accessor 8")),
        (r#""inverseBindMatrices":3"#, r#""inverseBindMatrices":9"#, "the document", nothing("accessor 9")),
        (r#""joints":[1,3]"#, r#""joints":[1,7]"#, "skin 0", nothing("node 7")),
        (r#""joints":[1,3]"#, r#""joints":[]"#, "skin 0", missing("a joint of the skin")),
        (r#""skin":0"#, r#""skin":4"#, "node 0", nothing("skin 4")),
    ] {
        assert_eq!(fails(from, to), (item.to_owned(), cause), "{to}");
    }
    let short = fails(r#""joints":[1,3]"#, r#""joints":[1,3,2]"#);
    assert!(matches!(short.1, Cause::Invalid(_)) && short.0 == "skin 0", "{short:?}");
    let flat = fails(r#""translation":[0,0,5]"#, r#""scale":[1,1,0]"#);
    assert!(matches!(flat.1, Cause::Unsupported { .. }) && flat.0 == "node 0", "{flat:?}");
    let fewer = fails(r#""componentType":5121,"count":3"#, r#""componentType":5121,"count":2"#);
    assert!(matches!(fewer.1, Cause::Invalid(_)) && fewer.0 == primitive, "{fewer:?}");
    let vectors = fails(r#""count":3,"type":"VEC4"},"#, r#""count":3,"type":"VEC3"},"#);
    assert!(matches!(vectors.1, Cause::Invalid(_)), "{vectors:?}");
}

#[test]
fn joints_and_weights_that_make_no_sense_are_refused() {
    let cause = |joints, weights| read(&document(joints, weights)).unwrap_err().cause;
    let mut joints = JOINTS;
    joints[2][1] = 2;
    assert_eq!(cause(joints, WEIGHTS), Cause::NoSuchJoint { vertex: 2, joint: "2".into(), joints: 2 });
    for (bad, sum) in [
        ([0.0; 4], "0"),
        ([f32::NAN, 0.0, 0.0, 0.0], "NaN"),
        ([f32::INFINITY, 0.0, 0.0, 0.0], "inf"),
        ([1.5, -0.5, 0.0, 0.0], "1"),
        ([2.0, 0.5, 0.0, 0.0], "2.5"),
    ] {
        let mut weights = WEIGHTS;
        weights[1] = bad;
        assert_eq!(cause(JOINTS, weights), Cause::BadWeights { vertex: 1, sum: sum.into() });
    }
}
