//! Drawings and curves that follow handles: all drawings of the corpus, and skinned models. Needs `SURFACE_CORPUS`.

use std::path::PathBuf;

use bevy_surface_splines::skin::{BindOptions, SolveWorkspace, SplineSkin};
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
fn pose_all(skin: &SplineSkin, poses: &[Vec<DAffine3>], extent: f64) -> f64 {
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
    for file in files {
        let drawing = read_svg(&file).unwrap().drawing;
        let chains: Vec<Chain> = drawing.paths().map(|(_, path)| Chain::planar(path, &JoinRules::default())).collect();
        let (low, high) = drawing.bounds().unwrap();
        let extent = low.distance(high);
        let places = [(0.25, 0.25), (0.75, 0.3), (0.7, 0.75), (0.3, 0.7)].map(|p| low + DVec2::from(p) * (high - low));
        let weights = Shepard::new(&places.map(HandleShape::planar)).unwrap();
        let skin = SplineSkin::bind(chains, &weights, &BindOptions::default()).unwrap();
        let mut random = Random(11);
        let poses: Vec<Vec<DAffine3>> = (0..100)
            .map(|_| places.iter().map(|p| random.transform(p.extend(0.0), DVec3::Z, extent)).collect())
            .collect();
        let worst = pose_all(&skin, &poses, extent);
        println!("{}: joins missed by {worst:.1e} of the drawing", file.display());
        assert!(worst < 1e-9, "{}: {worst:e}", file.display());
    }
}

/// Curves beside skinned models of glTF take the weights of the closest points.
#[cfg(feature = "formats")]
#[test]
fn curves_take_the_weights_of_skinned_models() {
    use bevy_surface_splines::format::read_mesh;
    use bevy_surface_splines::skin::{Chain, JoinRules, SkinSet, SurfaceWeights};
    use bevy_surface_splines::surface::{FaceId, Surface, SurfaceOptions};
    use bevy_surface_splines::vector::SpatialPath;

    let Some(corpus) = corpus() else { return };
    for name in ["fox.glb", "cesium_man.glb", "quad_skin.glb"] {
        let path = corpus.join("rigs").join(name);
        let mesh = read_mesh(&path).unwrap();
        let gltf::Gltf { document, blob } = gltf::Gltf::open(&path).unwrap();
        let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| blob.as_deref());
        type OwnSet = (Vec<[u16; 4]>, Vec<[f32; 4]>);
        let sets: Vec<OwnSet> = (0..)
            .map_while(|set| {
                Some((reader.read_joints(set)?.into_u16().collect(), reader.read_weights(set)?.into_f32().collect()))
            })
            .collect();
        let borrowed: Vec<SkinSet<'_>> = sets.iter().map(|(j, w)| (&j[..], &w[..])).collect();
        let joints = document.skins().next().unwrap().joints().count();
        let surface = Surface::build(&mesh, &SurfaceOptions::default()).unwrap();
        let field = SurfaceWeights::of_skin(&surface, &mesh, joints, &borrowed).unwrap();
        // At the corners of faces weights are those of the file.
        let mut out = vec![0.0; joints];
        for (number, face) in mesh.faces.iter().enumerate().step_by(37) {
            let Ok(point) = surface.point(FaceId(number as u32), [1.0, 0.0, 0.0]) else { continue };
            field.weights_on(&point, &mut out);
            let mut wished = vec![0.0; joints];
            for (of_vertices, weights) in &sets {
                for k in 0..4 {
                    let joint = usize::from(of_vertices[face[0] as usize][k]);
                    let weight = f64::from(weights[face[0] as usize][k]);
                    wished.get_mut(joint).into_iter().for_each(|w| *w += weight);
                }
            }
            let sum: f64 = wished.iter().sum();
            let many = wished.iter().filter(|w| **w > 0.0).count() > 8;
            assert!(many || out.iter().zip(&wished).all(|(a, b)| (a - b / sum).abs() < 1e-6), "{name} {number}");
        }
        // A curve through places near by.
        let diagonal = surface.diagonal();
        let (low, high) = surface.bounds();
        let points: Vec<DVec3> = (0..31)
            .map(|i| {
                let t = f64::from(i) / 30.0;
                low.lerp(high, t) + DVec3::new((7.0 * t).sin(), (5.0 * t).cos(), 0.0) * 0.05 * diagonal
            })
            .collect();
        let mut chain = Chain::spatial(&SpatialPath::from_points(points, false).unwrap(), &JoinRules::default());
        for anchor in 1..10 {
            let kinds = bevy_surface_splines::skin::JoinKind::ALL;
            chain.set_join(anchor, kinds[anchor % 4]).unwrap();
        }
        let skin = SplineSkin::bind(vec![chain], &field, &BindOptions::default()).unwrap();
        let mut random = Random(12);
        let poses: Vec<Vec<DAffine3>> = (0..20)
            .map(|_| (0..joints).map(|_| random.transform(low, DVec3::new(0.6, 0.0, 0.8), diagonal)).collect())
            .collect();
        let worst = pose_all(&skin, &poses, diagonal);
        println!("{name}: {joints} joints, joins of the curve missed by {worst:.1e}");
        assert!(worst < 1e-9, "{name}: {worst:e}");
    }
}
