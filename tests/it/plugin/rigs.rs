//! The rigs of the corpus, loaded and played by the engine: a curve rides on each of their meshes, and rays hit them as they are seen.

use std::path::{Path, PathBuf};

use bevy::animation::AnimationPlugin;
use bevy::gltf::{Gltf, GltfPlugin};
use bevy::math::Ray3d;
use bevy::mesh::morph::{MeshMorphWeights, MorphWeights};
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::mesh::{Indices, VertexAttributeValues};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_surface_splines::plugin::testing::{FRAME, unfinished_headless_app_with, update_until};
use bevy_surface_splines::plugin::{DeformedSurface, RidingCurve, SurfaceSplinePlugins};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::{FaceId, SurfacePoint};

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

/// Plays a rig and checks it at ten times; a line about what was seen.
fn play(path: &Path) -> String {
    let name = path.file_name().expect("a name").to_string_lossy().into_owned();
    let folder = path.parent().expect("a folder").to_string_lossy().into_owned();
    let mut app = unfinished_headless_app_with(AssetPlugin { file_path: folder, ..default() });
    app.add_plugins((AnimationPlugin, GltfPlugin::default(), SurfaceSplinePlugins));
    app.finish();
    app.cleanup();
    let server = app.world().resource::<AssetServer>().clone();
    let gltf: Handle<Gltf> = server.load(name.clone());
    assert!(
        update_until(&mut app, |_| server.is_loaded_with_dependencies(&gltf)),
        "{name}: {:?}",
        server.load_state(&gltf)
    );
    let (scene, clips) = {
        let gltf = app.world().resource::<Assets<Gltf>>().get(&gltf).expect("loaded");
        (gltf.scenes[0].clone(), gltf.animations.clone())
    };
    app.world_mut().spawn(WorldAssetRoot(scene));
    assert!(update_until(&mut app, |world| world.query::<&Mesh3d>().iter(world).count() > 0));
    app.update();
    let world = app.world_mut();
    let meshes: Vec<Entity> = world.query_filtered::<Entity, With<Mesh3d>>().iter(world).collect();
    meshes.iter().for_each(|mesh| drop(world.entity_mut(*mesh).insert(SplineSurface::default())));
    assert!(update_until(&mut app, |world| meshes.iter().all(|mesh| world.get::<BuiltSurface>(*mesh).is_some())));
    let curves: Vec<(Entity, Entity)> =
        meshes.iter().filter_map(|mesh| Some((*mesh, curve_on(&mut app, *mesh)?))).collect();
    assert!(!curves.is_empty(), "{name}: no mesh takes a curve");
    app.update();
    let played = start(&mut app, clips.last().cloned());
    let mut random = Random(9);
    let (mut most, mut size, mut hits, mut moved) = (0.0_f64, 0.0_f64, 0, 0.0_f32);
    let mut before: Vec<Vec<Vec3>> = Vec::new();
    for step in 0..10 {
        app.world_mut().insert_resource(TimeUpdateStrategy::ManualDuration(FRAME * 7));
        if !played {
            bend(&mut app, &mut random);
        }
        app.update();
        for (i, (mesh, curve)) in curves.iter().enumerate() {
            let (vertices, faces) = posed(app.world(), *mesh);
            let extent = extent(&vertices);
            size = size.max(extent);
            let positions = world_positions(app.world(), *mesh, *curve);
            let trace = app.world().get::<SplineTrace>(*curve).expect("a trace");
            let points = trace.surface_points(&app.world().get::<BuiltSurface>(*mesh).expect("a surface").0);
            for (position, point) in positions.iter().zip(&points) {
                let corners = faces[point.face.0 as usize].map(|v| vertices[v as usize]);
                let place: bevy::math::DVec3 = (0..3).map(|k| point.weights[k] * corners[k]).sum();
                most = most.max(position.as_dvec3().distance(place) / extent);
            }
            hits += shoot(&app, *mesh, (&vertices, &faces), extent, &mut random);
            if let Some(before) = before.get(i) {
                moved = before.iter().zip(&positions).map(|(a, b)| a.distance(*b)).fold(moved, f32::max);
            }
            if step == 0 {
                before.push(positions)
            }
        }
    }
    assert!(most < 1e-5, "{name}: {most} of the size off the mesh");
    assert!(moved > 1e-3 * size as f32 || name == "quad_skin.glb", "{name}: nothing moved ({moved})");
    format!("{name}: {} curves, at most {most:.1e} of the size off; {hits} rays hit; moved by {moved:.3}", curves.len())
}

/// A cubic between some faces of one sheet, short enough to be anywhere.
fn curve_on(app: &mut App, mesh: Entity) -> Option<Entity> {
    let surface = app.world().get::<BuiltSurface>(mesh)?.0.clone();
    let faces = surface.face_count() as u32;
    let at = |face: u32| SurfacePoint { face: FaceId(face), weights: [0.3, 0.3, 0.4] };
    for first in (0..faces).step_by((faces / 40).max(1) as usize) {
        let polygon = [0, 1, 2, 3].map(|k| at((first + k * (faces / 12).max(1)) % faces));
        let spline = app.world_mut().spawn((OnSurface(mesh), SplineSource::bezier(polygon))).id();
        app.update();
        if app.world().get::<SplineTrace>(spline).is_some() {
            return Some(spline);
        }
        app.world_mut().despawn(spline);
    }
    None
}

/// Plays a clip on the scene's player; whether there is one.
fn start(app: &mut App, clip: Option<Handle<AnimationClip>>) -> bool {
    let Some(clip) = clip else { return false };
    let (graph, node) = AnimationGraph::from_clip(clip);
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

/// All vertices where the engine's shaders have them, in `f64`: morph targets first, then joints, or the transform.
fn posed(world: &World, entity: Entity) -> (Vec<bevy::math::DVec3>, Vec<[u32; 3]>) {
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
    (places, indices.as_chunks::<3>().0.to_vec())
}

fn extent(places: &[bevy::math::DVec3]) -> f64 {
    let nowhere = (bevy::math::DVec3::INFINITY, bevy::math::DVec3::NEG_INFINITY);
    let (min, max) = places.iter().fold(nowhere, |(min, max), p| (min.min(*p), max.max(*p)));
    min.distance(max)
}

/// Rays at random places of the mesh: each hits what a look at all faces finds. How many hit.
fn shoot(
    app: &App,
    mesh: Entity,
    (vertices, faces): (&[bevy::math::DVec3], &[[u32; 3]]),
    extent: f64,
    random: &mut Random,
) -> u32 {
    let mut hits = 0;
    let deformed = app.world().get::<DeformedSurface>(mesh);
    for _ in 0..20 {
        let face = faces[random.below(faces.len() as u32) as usize].map(|v| vertices[v as usize].as_vec3());
        let goal = 0.5 * face[0] + 0.3 * face[1] + 0.2 * face[2];
        let origin = goal + 2.0 * extent as f32 * Vec3::new(random.signed(), random.signed(), random.signed());
        let Ok(direction) = Dir3::new(goal - origin) else { continue };
        let ray = Ray3d { origin, direction };
        let distance = match deformed {
            Some(deformed) => deformed.ray(ray).map(|hit| hit.distance),
            None => continue,
        };
        let expected = super::riding::brute_force(vertices, faces, origin, *direction);
        let (distance, expected) = (distance.unwrap_or(f64::INFINITY), expected.unwrap_or(f64::INFINITY));
        // A ray may pass by a rim closely, on one side or the other by rounding.
        let off = (distance - expected).abs();
        if off < 1e-5 * extent {
            hits += 1;
        } else {
            let beside =
                |by: f32| super::riding::brute_force(vertices, faces, origin, (direction.as_vec3() + by).normalize());
            let near = [beside(1e-4), beside(-1e-4)].map(|hit| hit.unwrap_or(f64::INFINITY));
            assert!(near.iter().any(|near| (near - distance).abs() < 1e-2 * extent), "{distance} {expected} {near:?}");
        }
    }
    hits
}
