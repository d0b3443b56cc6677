//! The eel: a closed body that stands upright, ten joints in a chain, and a clip in which waves run up through it.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};

use super::glb::{Data, Numbers};

/// Its height, and how far joints are apart.
const HEIGHT: f64 = 4.0;
const JOINTS: usize = 10;
const BONE: f64 = HEIGHT / JOINTS as f64;
/// Rings of vertices between tail and nose, and vertices in each.
const RINGS: usize = 72;
const ROUND: usize = 32;
/// Length of the clip in seconds, and steps between its keys.
const DURATION: f64 = 4.0;
const STEPS: usize = 16;

/// The file.
pub(crate) fn file() -> Vec<u8> {
    let (mut data, body) = (Data::default(), vertices());
    let positions: Vec<[f32; 3]> = body.iter().map(|v| rounded(v.position)).collect();
    let normals: Vec<[f32; 3]> = body.iter().map(|v| rounded(v.normal)).collect();
    let (colors, (joints, weights)): (Vec<_>, (Vec<_>, Vec<_>)) =
        body.iter().map(|v| (v.color, weights_at(v.position.y))).unzip();
    let (count, faces) = (body.len(), faces());
    let indices: Vec<u8> = faces.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    let attributes = [
        ("POSITION", data.floats("VEC3", &positions, &bounds(&positions))),
        ("NORMAL", data.floats("VEC3", &normals, "")),
        ("COLOR_0", data.add(Numbers::Bytes { normalized: true }, "VEC4", count, colors.as_flattened(), "")),
        ("JOINTS_0", data.add(Numbers::Bytes { normalized: false }, "VEC4", count, joints.as_flattened(), "")),
        ("WEIGHTS_0", data.add(Numbers::Bytes { normalized: true }, "VEC4", count, weights.as_flattened(), "")),
    ];
    let attributes = list(attributes.iter().map(|(name, accessor)| format!(r#""{name}":{accessor}"#)));
    let indices = data.add(Numbers::Shorts, "SCALAR", 3 * faces.len(), &indices, "");
    let binds: Vec<[f32; 16]> = (0..JOINTS).map(inverse_bind).collect();
    let binds = data.floats("MAT4", &binds, "");
    let clip = clip(&mut data);
    let nodes = list((0..JOINTS).map(|joint| {
        let child = if joint + 1 < JOINTS { format!(r#","children":[{}]"#, joint + 2) } else { String::new() };
        let up = if joint == 0 { 0.0 } else { BONE };
        format!(r#"{{"name":"joint {joint}","translation":[0,{up},0]{child}}}"#)
    }));
    let joints = list((1..=JOINTS).map(|node| node.to_string()));
    data.into_file(&format!(
        r#""scene":0,"scenes":[{{"nodes":[0,1]}}],"nodes":[{{"name":"eel","mesh":0,"skin":0}},{nodes}],
        "meshes":[{{"name":"eel","primitives":[{{"attributes":{{{attributes}}},"indices":{indices},"material":0}}]}}],
        "materials":[{{"name":"skin","pbrMetallicRoughness":{{"metallicFactor":0,"roughnessFactor":0.6}}}}],
        "skins":[{{"name":"eel","joints":[{joints}],"inverseBindMatrices":{binds}}}],"animations":[{clip}]"#
    ))
}

struct Vertex {
    position: DVec3,
    normal: DVec3,
    color: [u8; 4],
}

/// The tail, ring after ring, the nose.
fn vertices() -> Vec<Vertex> {
    let place = |step: f64, angle: f64| {
        let [radius, height] = outline(step);
        DVec3::new(radius * angle.sin(), height, radius * angle.cos())
    };
    let mut vertices = vec![Vertex { position: place(0.0, 0.0), normal: DVec3::NEG_Y, color: color(0.0, 0.0) }];
    for ring in 1..=RINGS {
        let step = ring as f64 / (RINGS + 1) as f64;
        let [before, after] = [step - 1e-4, step + 1e-4].map(outline);
        for k in 0..ROUND {
            let angle = k as f64 / ROUND as f64 * TAU;
            let (sin, cos) = angle.sin_cos();
            let (out, up) = (after[1] - before[1], before[0] - after[0]);
            let normal = DVec3::new(out * sin, up, out * cos).normalize();
            vertices.push(Vertex { position: place(step, angle), normal, color: color(step, angle) });
        }
    }
    vertices.push(Vertex { position: place(1.0, 0.0), normal: DVec3::Y, color: color(1.0, 0.0) });
    vertices
}

/// Radius and height at a share of the way from tail to nose, in which the ends take as much room as they need to be round.
fn outline(step: f64) -> [f64; 2] {
    let share = 0.5 - 0.5 * (PI * step).cos();
    let narrow = (share / 0.8).min(1.0);
    let body = 0.44 - 0.25 * narrow * narrow * (3.0 - 2.0 * narrow);
    let head = 0.15 * (-((share - 0.9) / 0.07).powi(2)).exp();
    let [tail, nose] = [0.06 - share, share - 0.88].map(|past| past.max(0.0));
    let round = (1.0 - (tail / 0.06).powi(2)).max(0.0).sqrt() * (1.0 - (nose / 0.12).powi(2)).max(0.0).sqrt();
    [(body + head) * round, HEIGHT * share]
}

/// Green above, pale below (to where the angle is 0), two dark eyes.
fn color(step: f64, angle: f64) -> [u8; 4] {
    let share = 0.5 - 0.5 * (PI * step).cos();
    let belly = (0.5 + 0.5 * angle.cos()).powi(6);
    let from_eye = |eye: f64| ((share - 0.915) / 0.024).powi(2) + ((angle - eye) / 0.34).powi(2);
    if from_eye(0.9).min(from_eye(TAU - 0.9)) < 1.0 {
        return [2, 2, 3, 255];
    }
    let mixed = |back: f64, belly_color: f64| (back + belly * (belly_color - back)).round() as u8;
    [mixed(8.0, 90.0), mixed(48.0, 100.0), mixed(42.0, 52.0), 255]
}

fn faces() -> Vec<[u16; 3]> {
    let at = |ring: usize, k: usize| (1 + ring * ROUND + k % ROUND) as u16;
    let nose = (1 + RINGS * ROUND) as u16;
    let mut faces = Vec::new();
    for k in 0..ROUND {
        faces.push([0, at(0, k + 1), at(0, k)]);
        for ring in 0..RINGS - 1 {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
        faces.push([at(RINGS - 1, k), at(RINGS - 1, k + 1), nose]);
    }
    faces
}

/// The joints of a height and their shares of 255: a cubic B-spline's, so that the body bends smoothly.
fn weights_at(height: f64) -> ([u8; 4], [u8; 4]) {
    let place = (height / BONE).clamp(0.0, JOINTS as f64 - 1e-9);
    let f = place.fract();
    let spline =
        [(1.0 - f).powi(3), 3.0 * f.powi(3) - 6.0 * f * f + 4.0, 3.0 * (f + f * f - f.powi(3)) + 1.0, f.powi(3)];
    let (mut shares, first) = ([0.0; JOINTS], place.floor() as i64 - 1);
    for (joint, share) in (first..).zip(spline) {
        shares[joint.clamp(0, JOINTS as i64 - 1) as usize] += share / 6.0;
    }
    let first = (first.max(0) as usize).min(JOINTS - 4);
    let joints = [0, 1, 2, 3].map(|k| (first + k) as u8);
    let mut weights = [0, 1, 2, 3].map(|k| (255.0 * shares[first + k]).floor() as u8);
    let missing = 255 - weights.iter().sum::<u8>();
    if let Some(most) = weights.iter_mut().max() {
        *most += missing;
    }
    // Who has no share is no joint.
    let named = |k: usize| if weights[k] > 0 { joints[k] } else { 0 };
    ([0, 1, 2, 3].map(named), weights)
}

fn inverse_bind(joint: usize) -> [f32; 16] {
    let mut matrix = [0.0; 16];
    [0, 5, 10, 15].into_iter().for_each(|place| matrix[place] = 1.0);
    matrix[13] = -(BONE * joint as f64) as f32;
    matrix
}

/// Waves from side to side, and others to and fro, that run from joint to joint.
fn clip(data: &mut Data) -> String {
    let times: Vec<[f32; 1]> = (0..=STEPS).map(|key| [(DURATION * key as f64 / STEPS as f64) as f32]).collect();
    let times = data.floats("SCALAR", &times, &format!(r#","min":[0],"max":[{DURATION}]"#));
    let keys: Vec<usize> = (0..JOINTS)
        .map(|joint| {
            let turn = |key: usize| {
                // The last key is the first again.
                let (time, lag) = ((key % STEPS) as f64 / STEPS as f64 * TAU, 0.62 * joint as f64);
                let strength = (joint as f64 / 2.0).min(1.0);
                let aside = 0.27 * strength * (time - lag).sin();
                let ahead = 0.22 * strength * (time - lag + 1.3).sin() + 0.04 * strength;
                let turn = DQuat::from_rotation_z(aside) * DQuat::from_rotation_x(ahead);
                turn.to_array().map(|x| round(x) as f32)
            };
            data.floats("VEC4", &(0..=STEPS).map(turn).collect::<Vec<_>>(), "")
        })
        .collect();
    let samplers = list(keys.iter().map(|keys| format!(r#"{{"input":{times},"output":{keys}}}"#)));
    let channels = list(
        (0..JOINTS)
            .map(|joint| format!(r#"{{"sampler":{joint},"target":{{"node":{},"path":"rotation"}}}}"#, joint + 1)),
    );
    format!(r#"{{"name":"sway","samplers":[{samplers}],"channels":[{channels}]}}"#)
}

/// To six digits behind the point, so that the file is the same wherever it is made.
fn round(x: f64) -> f64 {
    (x * 1e6).round() / 1e6 + 0.0
}

fn rounded(place: DVec3) -> [f32; 3] {
    place.to_array().map(|x| round(x) as f32)
}

fn bounds(places: &[[f32; 3]]) -> String {
    let most =
        |pick: fn(f32, f32) -> f32| places.iter().fold(places[0], |a, b| std::array::from_fn(|k| pick(a[k], b[k])));
    format!(r#","min":{:?},"max":{:?}"#, most(f32::min), most(f32::max))
}

fn list(items: impl Iterator<Item = String>) -> String {
    items.collect::<Vec<_>>().join(",")
}

#[cfg(all(test, feature = "formats"))]
mod tests {
    use super::*;
    use bevy_surface_splines::format::{MeshFormat, SkinnedMeshOptions, parse_skinned_mesh};
    use bevy_surface_splines::surface::{Surface, SurfaceOptions};

    #[test]
    fn the_eel_is_one_closed_sheet_with_joints() {
        let read =
            parse_skinned_mesh(&file(), MeshFormat::Glb, None, &SkinnedMeshOptions::default()).expect("a skinned mesh");
        assert_eq!((read.joints.len(), read.mesh.positions.len()), (JOINTS, 2 + RINGS * ROUND));
        let surface = Surface::build(&read.mesh, &SurfaceOptions::default()).expect("a mesh without errors");
        let report = surface.report();
        assert!(report.is_closed() && !report.repaired() && report.consistently_oriented);
        assert_eq!((report.sheets, report.euler_characteristic), (1, 2));
        let corner = |i: u32| read.mesh.positions[i as usize];
        let volume: f64 = read.mesh.faces.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum();
        assert!((0.8..2.0).contains(&(volume / 6.0)), "volume {}", volume / 6.0);
    }

    #[test]
    fn shares_are_whole() {
        for step in 0..=400 {
            let (joints, weights) = weights_at(HEIGHT * f64::from(step) / 400.0);
            assert_eq!(weights.iter().map(|w| u32::from(*w)).sum::<u32>(), 255);
            assert!(joints.iter().all(|joint| usize::from(*joint) < JOINTS));
        }
    }
}
