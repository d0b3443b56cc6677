//! Drawings and curves that follow handles: all drawings of the corpus, and skinned models. Needs `SURFACE_CORPUS`.

use std::path::PathBuf;

use bevy_surface_splines::skin::{BindOptions, BoundSkin, SolveWorkspace};
use glam::{DAffine3, DVec3};

/// The folder of the corpus, or a message that the test is skipped.
fn corpus() -> Option<PathBuf> {
    let folder = std::env::var_os("SURFACE_CORPUS").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: SURFACE_CORPUS is not set");
    }
    folder
}

/// Small, seeded random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Turned about an axis, stretched and moved, about a place.
    fn transform(&mut self, place: DVec3, axis: DVec3, extent: f64) -> DAffine3 {
        let mut shift = DVec3::from_array([0; 3].map(|_| self.between(-0.1, 0.1))) * extent;
        if axis == DVec3::Z {
            shift.z = 0.0;
        }
        DAffine3::from_translation(place + shift)
            * DAffine3::from_axis_angle(axis, self.between(-1.0, 1.0))
            * DAffine3::from_scale(DVec3::splat(self.between(0.8, 1.25)))
            * DAffine3::from_translation(-place)
    }
}

/// Poses a skin: all points are finite, in some poses joins are kept.
fn pose_all(skin: &BoundSkin, poses: &[Vec<DAffine3>], extent: f64) -> f64 {
    let (mut posed, mut workspace, mut points) = (skin.at_rest(), SolveWorkspace::default(), Vec::new());
    let mut worst: f64 = 0.0;
    for (number, pose) in poses.iter().enumerate() {
        skin.pose(pose, &mut posed).unwrap();
        assert!([posed.x(), posed.y(), posed.z()].into_iter().flatten().all(|x| x.is_finite()), "pose {number}");
        if number % 10 != 0 {
            continue;
        }
        for bound in skin.chains() {
            bound.solve(pose, &mut workspace, &mut points).unwrap();
            worst = worst.max(bound.violation(pose, &points, false) / extent);
            if number == 0 {
                let outcome = bound.solve_flexible(pose, &Default::default(), &mut workspace, &mut points).unwrap();
                assert!(outcome.flexible <= outcome.regular);
                worst = worst.max(bound.violation(pose, &points, true) / extent);
            }
        }
    }
    worst
}

#[cfg(feature = "svg")]
#[test]
fn all_drawings_bind_to_four_handles_and_take_poses() {
    use bevy_surface_splines::skin::{Chain, HandleShape, JoinRules, Shepard};
    use bevy_surface_splines::vector::read_svg;
    use glam::DVec2;

    let Some(corpus) = corpus() else { return };
    let mut files: Vec<PathBuf> = std::fs::read_dir(corpus.join("svg")).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    assert!(files.len() > 20, "{} drawings", files.len());
    for file in files {
        let drawing = read_svg(&file).unwrap().drawing;
        let chains: Vec<Chain> = drawing.paths().map(|(_, path)| Chain::planar(path, &JoinRules::default())).collect();
        let (low, high) = drawing.bounds().unwrap();
        let extent = low.distance(high);
        let places = [(0.25, 0.25), (0.75, 0.3), (0.7, 0.75), (0.3, 0.7)].map(|p| low + DVec2::from(p) * (high - low));
        let weights = Shepard::new(&places.map(HandleShape::planar)).unwrap();
        let skin = BoundSkin::bind(chains, &weights, &BindOptions::default()).unwrap();
        let mut random = Random(11);
        let poses: Vec<Vec<DAffine3>> = (0..100)
            .map(|_| places.iter().map(|p| random.transform(p.extend(0.0), DVec3::Z, extent)).collect())
            .collect();
        let worst = pose_all(&skin, &poses, extent);
        println!("{}: joins missed by {worst:.1e} of the drawing", file.display());
        assert!(worst < 1e-9, "{}: {worst:e}", file.display());
    }
}

/// Curves beside skinned models of glTF take the weights of the closest points, and follow the joints of the file.
#[cfg(feature = "formats")]
mod rigs {
    use base64::Engine as _;
    use base64::engine::general_purpose::STANDARD;
    use bevy_surface_splines::format::{
        Cause, FormatError, MeshFormat, SkinnedMesh, SkinnedMeshOptions, parse_skinned_mesh, read_mesh,
        read_skinned_mesh,
    };
    use bevy_surface_splines::skin::{Chain, JoinKind, JoinRules, SkinError, WeightField};
    use bevy_surface_splines::surface::{FaceId, Surface, SurfaceOptions};
    use bevy_surface_splines::vector::SpatialPath;
    use glam::{DAffine3, DMat4};

    use super::*;

    /// Vertices of a file as its joints move them at rest, by another reader: where the skin puts them, or their node.
    fn skinned_at_rest(path: &std::path::Path) -> Vec<DVec3> {
        let gltf::Gltf { document, blob } = gltf::Gltf::open(path).unwrap();
        let bytes = |buffer: gltf::Buffer<'_>| match buffer.source() {
            gltf::buffer::Source::Bin => blob.clone().unwrap(),
            gltf::buffer::Source::Uri(uri) => STANDARD.decode(uri.split_once(',').unwrap().1).unwrap(),
        };
        let buffers: Vec<Vec<u8>> = document.buffers().map(bytes).collect();
        let mut out = Vec::new();
        let scene = document.default_scene().or_else(|| document.scenes().next()).unwrap();
        let mut open: Vec<(gltf::Node<'_>, DMat4)> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
        let mut worlds = vec![DMat4::IDENTITY; document.nodes().len()];
        let mut order = Vec::new();
        open.reverse();
        while let Some((node, parent)) = open.pop() {
            let local = node.transform().matrix().map(|column| column.map(f64::from));
            worlds[node.index()] = parent * DMat4::from_cols_array_2d(&local);
            let below: Vec<_> = node.children().map(|child| (child, worlds[node.index()])).collect();
            open.extend(below.into_iter().rev());
            order.push(node);
        }
        for node in order {
            let Some(mesh) = node.mesh() else { continue };
            let mut seen = Vec::new();
            for primitive in mesh.primitives() {
                let accessor = primitive.get(&gltf::Semantic::Positions).unwrap().index();
                if seen.contains(&accessor) {
                    continue;
                }
                seen.push(accessor);
                let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()][..]));
                let mut sums = Vec::new();
                if let Some(skin) = node.skin() {
                    let of_skin = skin.reader(|buffer| Some(&buffers[buffer.index()][..]));
                    let binds: Vec<DMat4> = of_skin
                        .read_inverse_bind_matrices()
                        .unwrap()
                        .map(|m| DMat4::from_cols_array_2d(&m.map(|column| column.map(f64::from))))
                        .collect();
                    let moves: Vec<DMat4> =
                        skin.joints().zip(binds).map(|(joint, bind)| worlds[joint.index()] * bind).collect();
                    for set in 0.. {
                        let (Some(joints), Some(weights)) = (reader.read_joints(set), reader.read_weights(set)) else {
                            break;
                        };
                        sums.resize(joints.clone().into_u16().len(), DMat4::ZERO);
                        for (sum, (joints, weights)) in sums.iter_mut().zip(joints.into_u16().zip(weights.into_f32())) {
                            for (joint, weight) in joints.into_iter().zip(weights).filter(|(_, w)| *w != 0.0) {
                                *sum += moves[usize::from(joint)] * f64::from(weight);
                            }
                        }
                    }
                }
                for (vertex, position) in reader.read_positions().unwrap().enumerate() {
                    let moved = sums.get(vertex).copied().unwrap_or(worlds[node.index()]);
                    let place = moved * DVec3::from_array(position.map(f64::from)).extend(1.0);
                    out.push(place.truncate() / place.w);
                }
            }
        }
        out
    }

    /// A curve from corner to corner of a surface that comes near to it now and then.
    fn curve(surface: &Surface) -> Chain {
        let (low, high) = surface.bounds();
        let place = |i| {
            let t = f64::from(i) / 30.0;
            low.lerp(high, t) + DVec3::new((7.0 * t).sin(), (5.0 * t).cos(), 0.0) * 0.05 * surface.diagonal()
        };
        let path = SpatialPath::from_points((0..31).map(place).collect(), false).unwrap();
        let mut chain = Chain::spatial(&path, &JoinRules::default());
        for anchor in 1..10 {
            chain.set_join(anchor, JoinKind::ALL[anchor % 4]).unwrap();
        }
        chain
    }

    fn check(name: &str, model: &SkinnedMesh, path: &std::path::Path) {
        assert_eq!(model.mesh, read_mesh(path).unwrap(), "{name}");
        let vertices = model.mesh.positions.len();
        let sums: Vec<f64> =
            (0..vertices).map(|v| model.sets.iter().flat_map(|set| set.weights[v]).map(f64::from).sum()).collect();
        assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-6), "{name}");
        // Joints move vertices to where another reader of the file finds them.
        let rest = model.pose(&model.locals()).unwrap();
        let wished = skinned_at_rest(path);
        assert_eq!(wished.len(), vertices, "{name}");
        let size = wished.iter().map(|p| p.length()).fold(0.0, f64::max);
        let mut worst: f64 = 0.0;
        for (v, (place, wished)) in model.mesh.positions.iter().zip(&wished).enumerate() {
            let of_set = |set: &bevy_surface_splines::format::JointSet| {
                let pairs = set.joints[v].into_iter().zip(set.weights[v]);
                pairs.map(|(j, w)| rest[usize::from(j)].transform_point3(*place) * f64::from(w)).sum::<DVec3>()
            };
            worst = worst.max(model.sets.iter().map(of_set).sum::<DVec3>().distance(*wished) / size);
        }
        // At the corners of faces weights are those of the file.
        let surface = Surface::build(&model.mesh, &SurfaceOptions::default()).unwrap();
        let field = model.weights(&surface).unwrap();
        let mut out = vec![0.0; field.handle_count()];
        for (number, face) in model.mesh.faces.iter().enumerate().step_by(37) {
            let Ok(point) = surface.point(FaceId(number as u32), [1.0, 0.0, 0.0]) else { continue };
            field.weights_on(&point, &mut out);
            let mut wished = vec![0.0; out.len()];
            for set in &model.sets {
                let v = face[0] as usize;
                let pairs = set.joints[v].into_iter().zip(set.weights[v]);
                pairs.for_each(|(joint, weight)| wished[usize::from(joint)] += f64::from(weight));
            }
            let many = wished.iter().filter(|w| **w > 0.0).count() > 8;
            assert!(many || out.iter().zip(&wished).all(|(a, b)| (a - b).abs() < 1e-6), "{name} {number}");
        }
        // A curve takes poses of the joints, and random ones.
        let skin = BoundSkin::bind(vec![curve(&surface)], &field, &BindOptions::default()).unwrap();
        let mut random = Random(12);
        let poses: Vec<Vec<DAffine3>> = (0..20)
            .map(|_| {
                let mut locals = model.locals();
                let turn = |random: &mut Random| DAffine3::from_rotation_x(random.between(-0.3, 0.3));
                locals.iter_mut().for_each(|local| *local *= turn(&mut random));
                model.pose(&locals).unwrap()
            })
            .collect();
        let moved = poses.iter().flatten().map(|t| t.transform_point3(surface.bounds().0).length()).fold(0.0, f64::max);
        let extent = surface.diagonal().max(moved);
        let missed = pose_all(&skin, &poses, extent);
        println!(
            "{name}: {vertices} vertices, {} joints, {} sets, {} vertices missed a sum of one, by up to {:.2}; at rest {worst:.1e} \
             from another reader's places; joins of a curve missed by {missed:.1e}",
            model.joints.len(),
            model.sets.len(),
            model.uneven,
            model.worst_miss
        );
        assert!(missed < 1e-9, "{name}: {missed:e}");
        assert!(worst < 1e-6, "{name}: {worst:e}");
    }

    #[test]
    fn curves_follow_the_joints_of_models() {
        let Some(corpus) = corpus() else { return };
        let table = std::fs::read_to_string(corpus.join("rigs.csv")).unwrap();
        let mut count = 0;
        for line in table.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let (name, joints, skins): (_, usize, usize) =
                (cells[0], cells[3].parse().unwrap(), cells[4].parse().unwrap());
            let path = corpus.join(name);
            let model = read_skinned_mesh(&path, &SkinnedMeshOptions::default()).unwrap();
            // As the table says, and one more for each mesh that hangs on its node.
            let hanging = model.joints.len() - joints;
            let is_pure =
                matches!(name, "rigs/fox.glb" | "rigs/cesium_man.glb" | "rigs/quad_skin.glb" | "rigs/simple_skin.gltf");
            assert!(skins <= 1 && (!is_pure || hanging == 0), "{name}: {hanging} meshes hang on their nodes");
            check(name, &model, &path);
            count += 1;
        }
        assert!(count >= 8, "{count} rigs");
    }

    #[test]
    fn broken_skins_are_refused_by_name() {
        let Some(corpus) = corpus() else { return };
        let read = |name: &str| read_skinned_mesh(corpus.join("bad").join(name), &SkinnedMeshOptions::default());
        let good = read("skin_ok_reference.glb").unwrap();
        assert_eq!((good.joints.len(), good.uneven), (2, 0));
        let cause = |name| match read(name) {
            Err(FormatError::Content { cause, .. }) => cause,
            other => panic!("{name}: {other:?}"),
        };
        assert!(matches!(cause("skin_zero_weights.glb"), Cause::BadWeights { .. }));
        assert!(matches!(cause("skin_nan_weight.glb"), Cause::BadWeights { .. }));
        assert!(matches!(cause("skin_joint_out_of_range.glb"), Cause::NoSuchJoint { joints: 2, .. }));
        assert!(matches!(cause("skin_node_cycle.glb"), Cause::NotATree));
        assert!(matches!(read("empty.obj"), Err(FormatError::NoSkins { .. })));
    }

    #[test]
    fn damaged_rigs_are_refused_or_fit_together() {
        let Some(corpus) = corpus() else { return };
        let mut random = crate::Random(13);
        println!("seed 13");
        let (mut read, mut refused) = (0, 0);
        for name in ["bad/skin_ok_reference.glb", "rigs/quad_skin.glb", "rigs/simple_skin.gltf"] {
            let whole = std::fs::read(corpus.join(name)).unwrap();
            let format = MeshFormat::from_extension(name).unwrap();
            for _ in 0..1500 {
                let mut bytes = whole.clone();
                for _ in 0..=random.below(4) {
                    // Numbers of the document by others, bytes of its buffers by any; other text would hardly ever parse.
                    let tries = (0..20).map(|_| random.below(bytes.len())).collect::<Vec<_>>();
                    let is_text = |at: &&usize| bytes[**at].is_ascii_graphic() && !bytes[**at].is_ascii_digit();
                    let Some(at) = tries.iter().find(|at| !is_text(at)).copied() else { continue };
                    let is_digit = bytes[at].is_ascii_digit();
                    bytes[at] = if is_digit { b'0' + random.below(10) as u8 } else { random.below(256) as u8 };
                }
                if random.below(10) == 0 {
                    bytes.truncate(random.below(bytes.len()));
                }
                let Ok(model) = parse_skinned_mesh(&bytes, format, None, &SkinnedMeshOptions::default()) else {
                    refused += 1;
                    continue;
                };
                read += 1;
                for set in &model.sets {
                    let vertices = model.mesh.positions.len();
                    assert_eq!((set.joints.len(), set.weights.len()), (vertices, vertices));
                    assert!(set.joints.as_flattened().iter().all(|joint| usize::from(*joint) < model.joints.len()));
                    assert!(set.weights.as_flattened().iter().all(|weight| (0.0..=1.0).contains(weight)));
                }
                assert!(model.joints.iter().all(|joint| joint.parent.is_none_or(|parent| parent < model.joints.len())));
                if let Ok(pose) = model.pose(&model.locals()) {
                    assert!(pose.iter().all(DAffine3::is_finite));
                }
            }
        }
        println!("{read} read, {refused} refused");
        assert!(read > 500 && refused > 500, "{read} {refused}");
    }

    #[test]
    fn poses_that_do_not_fit_the_joints_are_refused() {
        let Some(corpus) = corpus() else { return };
        let fox = read_skinned_mesh(corpus.join("rigs/fox.glb"), &SkinnedMeshOptions::default()).unwrap();
        let joints = fox.joints.len();
        assert_eq!(fox.pose(&[]), Err(SkinError::PoseLength { handles: joints, found: 0 }));
        let tail = fox.joint_named("b_Tail01_012").unwrap();
        let mut locals = fox.locals();
        let before = fox.pose(&locals).unwrap();
        locals[tail] *= DAffine3::from_rotation_x(0.5);
        let after = fox.pose(&locals).unwrap();
        let moved: Vec<&str> = (0..joints)
            .filter(|j| !before[*j].abs_diff_eq(after[*j], 1e-12))
            .filter_map(|j| fox.joints[j].name.as_deref())
            .collect();
        assert_eq!(
            moved,
            ["b_Tail01_012", "b_Tail02_013", "b_Tail03_014"],
            "what is below the joint, and nothing else"
        );
    }
}
