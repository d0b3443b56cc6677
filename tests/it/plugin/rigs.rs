//! The rigs of the corpus, loaded and played by the engine: a curve rides on each of their meshes, and rays hit them as they are seen.

use std::path::{Path, PathBuf};

use bevy::ecs::system::SystemState;
use bevy::gltf::{Gltf, GltfPlugin};
use bevy::math::{DVec3, Ray3d};
use bevy::mesh::morph::{MeshMorphWeights, MorphWeights};
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::mesh::{Indices, VertexAttributeValues};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_surface_splines::plugin::testing::{FRAME, unfinished_headless_app_with, update_until};
use bevy_surface_splines::plugin::{DeformedSurface, RidingCurve};
use bevy_surface_splines::prelude::*;

use super::Random;

fn rigs() -> Vec<PathBuf> {
    let Some(corpus) = std::env::var_os("SURFACE_CORPUS") else { return Vec::new() };
    let table = std::fs::read_to_string(Path::new(&corpus).join("rigs.csv")).expect("the table of rigs");
    let files = table.lines().skip(1).filter_map(|line| line.split(',').next());
    files.map(|file| Path::new(&corpus).join(file)).collect()
}

#[test]
fn curves_ride_on_all_rigs() {
    let rigs = rigs();
    if rigs.is_empty() {
        println!("skipped: SURFACE_CORPUS is not set");
        return;
    }
    for rig in rigs {
        println!("{}", play(&rig));
    }
}

/// What a rig was seen to do.
#[derive(Default)]
struct Seen {
    /// The most that a curve was off its mesh, as a share of its size.
    off: f64,
    /// The most that a place of a curve moved, as a share of the size of its mesh.
    moved: f32,
    rays: u32,
    equal: u32,
}

/// Plays a rig and checks it at ten times; a line about what was seen.
fn play(path: &Path) -> String {
    let name = path.file_name().expect("a name").to_string_lossy().into_owned();
    let folder = path.parent().expect("a folder").to_string_lossy().into_owned();
    let mut app = unfinished_headless_app_with(AssetPlugin { file_path: folder, ..default() });
    app.add_plugins((GltfPlugin::default(), SurfaceSplinePlugins));
    app.finish();
    app.cleanup();
    let server = app.world().resource::<AssetServer>().clone();
    let gltf: Handle<Gltf> = server.load(name.clone());
    // Textures may come later, or not at all: nothing here looks at them.
    assert!(update_until(&mut app, |_| server.is_loaded(&gltf)), "{name}: {:?}", server.load_state(&gltf));
    let (scene, clip) = {
        let gltf = app.world().resource::<Assets<Gltf>>().get(&gltf).expect("loaded");
        let named = |clip: &Handle<AnimationClip>| gltf.named_animations.iter().find(|(_, named)| *named == clip);
        let clip =
            gltf.animations.last().map(|clip| (clip.clone(), named(clip).map_or("?", |(name, _)| name).to_owned()));
        (gltf.scenes[0].clone(), clip)
    };
    app.world_mut().spawn(WorldAssetRoot(scene));
    assert!(update_until(&mut app, |world| world.query::<&Mesh3d>().iter(world).count() > 0));
    app.update();
    let world = app.world_mut();
    let meshes: Vec<Entity> = world.query_filtered::<Entity, With<Mesh3d>>().iter(world).collect();
    for mesh in &meshes {
        world.entity_mut(*mesh).insert(SplineSurface::default());
    }
    assert!(update_until(&mut app, |world| meshes.iter().all(|mesh| world.get::<BuiltSurface>(*mesh).is_some())));
    let curves: Vec<(Entity, Entity)> =
        meshes.iter().filter_map(|mesh| Some((*mesh, curve_on(&mut app, *mesh)?))).collect();
    assert_eq!(curves.len(), meshes.len(), "{name}: every mesh takes a curve");
    app.update();
    let clip = clip.filter(|(clip, _)| start(&mut app, clip)).map(|(_, name)| name);
    let (mut random, mut seen, mut before) = (Random(9), Seen::default(), Vec::new());
    app.world_mut().insert_resource(TimeUpdateStrategy::ManualDuration(FRAME * 7));
    for step in 0..10 {
        if clip.is_none() {
            bend(&mut app, &mut random);
        }
        app.update();
        for (index, (mesh, curve)) in curves.iter().enumerate() {
            let posed = posed(app.world(), *mesh);
            let positions = world_positions(app.world(), *mesh, *curve);
            seen.off = seen.off.max(distance_from(&posed, app.world(), (*mesh, *curve), &positions));
            shoot(&mut app, *mesh, &posed, &mut random, &mut seen);
            if step == 0 {
                before.push(positions);
            } else {
                let way = before[index].iter().zip(&positions).map(|(a, b): (&Vec3, &Vec3)| a.distance(*b));
                seen.moved = way.fold(0.0, f32::max).max(seen.moved * posed.extent as f32) / posed.extent as f32;
            }
        }
    }
    let Seen { off, moved, rays, equal } = seen;
    assert!(off < 1e-5, "{name}: {off} of the size off the mesh");
    assert!(moved > 1e-3, "{name}: nothing moved ({moved})");
    let (kind, count) = (kind(app.world_mut()), curves.len());
    let clip = clip.map_or("bent by hand".to_owned(), |clip| format!("clip {clip}"));
    format!(
        "{name}: {kind}, {clip}; {count} curves {off:.1e} of the size off, moved by {moved:.2}; {equal} of {rays} picks equal"
    )
}

/// What moves the meshes.
fn kind(world: &mut World) -> &'static str {
    if world.query::<&SkinnedMesh>().iter(world).count() > 0 {
        "skinned"
    } else if world.query::<&MeshMorphWeights>().iter(world).count() > 0 {
        "morphed"
    } else {
        "node-animated"
    }
}

/// How far the places of a curve are from where its points are on the posed mesh, as a share of its size.
fn distance_from(posed: &Posed, world: &World, (mesh, curve): (Entity, Entity), positions: &[Vec3]) -> f64 {
    let trace = world.get::<SplineTrace>(curve).expect("a trace");
    let points = trace.surface_points(&world.get::<BuiltSurface>(mesh).expect("a surface").0);
    assert!(positions.len() == points.len() && points.len() > 1);
    let off = positions.iter().zip(&points).map(|(position, point)| {
        let corners = posed.faces[point.face.0 as usize].map(|v| posed.vertices[v as usize]);
        let place: DVec3 = (0..3).map(|k| point.weights[k] * corners[k]).sum();
        position.as_dvec3().distance(place) / posed.extent
    });
    off.fold(0.0, f64::max)
}

/// A cubic between some faces of one sheet, as far apart as can be; in one face at worst.
fn curve_on(app: &mut App, mesh: Entity) -> Option<Entity> {
    let surface = app.world().get::<BuiltSurface>(mesh)?.0.clone();
    let faces = surface.face_count() as u32;
    let at = |face: u32, k: f64| SurfacePoint { face: FaceId(face), weights: [0.1 + 0.2 * k, 0.8 - 0.2 * k, 0.1] };
    for apart in [faces / 12, faces / 100, 1, 0] {
        for first in (0..faces).step_by((faces / 40).max(1) as usize) {
            let polygon = [0, 1, 2, 3].map(|k| at((first + k * apart) % faces, f64::from(k)));
            let spline = app.world_mut().spawn((OnSurface(mesh), SplineSource::bezier(polygon))).id();
            app.update();
            if app.world().get::<SplineTrace>(spline).is_some() {
                return Some(spline);
            }
            app.world_mut().despawn(spline);
        }
    }
    None
}

/// Plays a clip on the scene's player; whether there is one.
fn start(app: &mut App, clip: &Handle<AnimationClip>) -> bool {
    let (graph, node) = AnimationGraph::from_clip(clip.clone());
    let graph = app.world_mut().resource_mut::<Assets<AnimationGraph>>().add(graph);
    let world = app.world_mut();
    let players: Vec<Entity> = world.query_filtered::<Entity, With<AnimationPlayer>>().iter(world).collect();
    for player in &players {
        world.get_mut::<AnimationPlayer>(*player).expect("there").play(node).repeat();
        world.entity_mut(*player).insert(AnimationGraphHandle(graph.clone()));
    }
    !players.is_empty()
}

/// Without a clip: every joint turns a little.
fn bend(app: &mut App, random: &mut Random) {
    let world = app.world_mut();
    let joints: Vec<Entity> = world.query::<&SkinnedMesh>().iter(world).flat_map(|skin| skin.joints.clone()).collect();
    for joint in joints {
        let turn = Quat::from_euler(EulerRot::XYZ, 0.1 * random.signed(), 0.1 * random.signed(), 0.1 * random.signed());
        world.get_mut::<Transform>(joint).expect("a joint").rotate_local(turn);
    }
}

/// Where the curve is drawn: riding, or under the transform of a mesh that nothing deforms.
fn world_positions(world: &World, mesh: Entity, curve: Entity) -> Vec<Vec3> {
    match world.get::<RidingCurve>(curve) {
        Some(riding) => riding.positions().to_vec(),
        None => {
            assert!(world.get::<DeformedSurface>(mesh).is_none(), "it should ride");
            let to_world = world.get::<GlobalTransform>(mesh).expect("a place").affine();
            let trace = world.get::<SplineTrace>(curve).expect("a trace");
            trace.polyline().iter().map(|p| to_world.transform_point3(*p)).collect()
        }
    }
}

/// A mesh as it is seen.
struct Posed {
    vertices: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// The diagonal of its box.
    extent: f64,
}

/// All vertices where the engine's shaders have them, in `f64`: morph targets first, then joints, or the transform.
fn posed(world: &World, entity: Entity) -> Posed {
    let mesh = world.resource::<Assets<Mesh>>().get(&world.get::<Mesh3d>(entity).expect("a mesh").0).expect("loaded");
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|a| a.as_float3()).expect("positions");
    let mut places: Vec<_> = positions.iter().map(|p| Vec3::from_array(*p).as_dvec3()).collect();
    let weights = match world.get::<MeshMorphWeights>(entity) {
        Some(MeshMorphWeights::Value { weights }) => weights.clone(),
        Some(MeshMorphWeights::Reference(owner)) => {
            world.get::<MorphWeights>(*owner).expect("weights").weights().to_vec()
        }
        None => Vec::new(),
    };
    let targets = mesh.get_morph_targets().unwrap_or_default();
    for (target, weight) in targets.chunks(places.len().max(1)).zip(&weights) {
        places.iter_mut().zip(target).for_each(|(p, t)| *p += f64::from(*weight) * t.position.as_dvec3());
    }
    let global = |entity: Entity| world.get::<GlobalTransform>(entity).expect("a place").to_matrix().as_dmat4();
    match world.get::<SkinnedMesh>(entity) {
        Some(skin) => {
            let inverse = world.resource::<Assets<SkinnedMeshInverseBindposes>>().get(&skin.inverse_bindposes);
            let inverse = inverse.expect("bind poses");
            let matrices: Vec<_> =
                skin.joints.iter().zip(inverse.iter()).map(|(j, i)| global(*j) * i.as_dmat4()).collect();
            let Some(VertexAttributeValues::Uint16x4(joints)) = mesh.attribute(Mesh::ATTRIBUTE_JOINT_INDEX) else {
                panic!("no joints")
            };
            let Some(VertexAttributeValues::Float32x4(shares)) = mesh.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT) else {
                panic!("no weights")
            };
            for (v, place) in places.iter_mut().enumerate() {
                let by = |k: usize| f64::from(shares[v][k]) * (matrices[usize::from(joints[v][k])] * place.extend(1.0));
                *place = (by(0) + by(1) + by(2) + by(3)).truncate();
            }
        }
        None => {
            let matrix = global(entity);
            places.iter_mut().for_each(|p| *p = matrix.transform_point3(*p));
        }
    }
    let indices: Vec<u32> = match mesh.indices() {
        Some(Indices::U16(list)) => list.iter().map(|i| u32::from(*i)).collect(),
        Some(Indices::U32(list)) => list.clone(),
        None => (0..places.len() as u32).collect(),
    };
    let nowhere = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = places.iter().fold(nowhere, |(min, max), p| (min.min(*p), max.max(*p)));
    Posed { vertices: places, faces: indices.as_chunks::<3>().0.to_vec(), extent: min.distance(max) }
}

/// Rays at random places of the mesh: each hits what a look at all faces finds.
fn shoot(app: &mut App, mesh: Entity, posed: &Posed, random: &mut Random, seen: &mut Seen) {
    let Posed { vertices, faces, extent } = posed;
    let mut state = SystemState::<SurfaceQueries>::new(app.world_mut());
    let queries = state.get(app.world()).expect("queries");
    let view = queries.get(mesh).expect("a surface");
    for _ in 0..20 {
        let face = faces[random.below(faces.len() as u32) as usize].map(|v| vertices[v as usize].as_vec3());
        let goal = 0.5 * face[0] + 0.3 * face[1] + 0.2 * face[2];
        let origin = goal + 2.0 * *extent as f32 * Vec3::new(random.signed(), random.signed(), random.signed());
        let Ok(direction) = Dir3::new(goal - origin) else { continue };
        let brute_force = |direction: Vec3| super::riding::brute_force(vertices, faces, origin, direction);
        let (found, expected) = (view.ray(Ray3d { origin, direction }), brute_force(*direction));
        let distance = found.map_or(-1.0, |hit| f64::from(hit.distance));
        seen.rays += 1;
        if (distance - expected.unwrap_or(-1.0)).abs() < 1e-5 * extent {
            seen.equal += 1;
            continue;
        }
        // A ray may pass by a rim closely, on one side or the other by rounding.
        let beside = [1e-5, -1e-5].map(|by| Vec3::new(by, -by, 0.5 * by));
        let near = beside.map(|by| brute_force((*direction + by).normalize()).unwrap_or(-1.0));
        assert!(near.iter().any(|near| (near - distance).abs() < 1e-3 * extent), "{distance} {expected:?} {near:?}");
    }
}
