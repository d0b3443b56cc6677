//! Curves on meshes that joints and morph targets deform.

use bevy::asset::RenderAssetUsages;
use bevy::math::Ray3d;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::picking::backend::HitData;
use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::PointerId;
use bevy::prelude::*;
use bevy_surface_splines::plugin::testing::{PointerScript, headless_app, pixel_of, update_until};
use bevy_surface_splines::plugin::{CurveHit, DeformedSurface, RidingCurve, SurfaceHit};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::SurfacePoint;

use super::{Random, spawn_spline};

/// Rings of the arm, and vertices in each; the last vertex of a ring lies on the first, as at a seam of a texture.
const RINGS: u16 = 25;
const ROUND: u16 = 17;

/// An arm along x with three joints, its vertices bound to the two nearest.
fn arm(rings: u16) -> Mesh {
    let (mut positions, mut joints, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..rings {
        let x = 4.0 * f32::from(i) / f32::from(rings - 1);
        for k in 0..ROUND {
            let (sin, cos) = (std::f32::consts::TAU * f32::from(k % (ROUND - 1)) / f32::from(ROUND - 1)).sin_cos();
            positions.push([x, 0.5 * cos, 0.5 * sin]);
            let place = x / 2.0;
            let near = place.floor().min(1.0);
            joints.push([near as u16, near as u16 + 1, 0, 0]);
            weights.push([1.0 - (place - near), place - near, 0.0, 0.0]);
        }
    }
    let mut indices = Vec::new();
    for i in 0..rings - 1 {
        for k in 0..ROUND - 1 {
            let [a, b] = [i, i + 1].map(|ring| ring * ROUND + k);
            indices.extend([a, b, a + 1, a + 1, b, b + 1]);
        }
    }
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights)
        .with_inserted_indices(Indices::U16(indices))
}

struct Arm {
    app: App,
    surface: Entity,
    spline: Entity,
    joints: Vec<Entity>,
}

impl Arm {
    fn new() -> Self {
        let mut app = headless_app();
        app.init_asset::<SkinnedMeshInverseBindposes>();
        let world = app.world_mut();
        let rests = [0.0, 2.0, 4.0].map(|x| Transform::from_xyz(x, 0.0, 0.0));
        let joints: Vec<Entity> = rests.iter().map(|rest| world.spawn(*rest).id()).collect();
        let inverse: Vec<Mat4> = rests.iter().map(|rest| rest.to_matrix().inverse()).collect();
        let inverse_bindposes = world.resource_mut::<Assets<SkinnedMeshInverseBindposes>>().add(inverse);
        let mesh = world.resource_mut::<Assets<Mesh>>().add(arm(RINGS));
        let skin = SkinnedMesh { inverse_bindposes, joints: joints.clone() };
        // The transform of a skinned mesh counts for nothing, and may be anything.
        let elsewhere = Transform::from_xyz(7.0, 8.0, 9.0).with_scale(Vec3::new(1.0, 2.0, 3.0));
        let surface = world.spawn((Mesh3d(mesh), SplineSurface::default(), skin, elsewhere)).id();
        assert!(update_until(&mut app, |world| world.get::<BuiltSurface>(surface).is_some()));
        let through = [(0.3, 0.0_f32), (1.5, 1.0), (2.6, 2.0), (3.8, 3.5)];
        let places = through.map(|(x, angle)| Vec3::new(x, 0.5 * angle.cos(), 0.5 * angle.sin()));
        let on = surface_points(&app, surface, &places);
        let spline = spawn_spline(&mut app, surface, SplineSource::bezier([on[0], on[1], on[2], on[3]]));
        app.update();
        Self { app, surface, spline, joints }
    }

    fn bend(&mut self, random: &mut Random) {
        for (joint, x) in self.joints.clone().into_iter().zip([0.0, 2.0, 4.0]) {
            let turn = Quat::from_euler(EulerRot::XYZ, random.signed(), random.signed(), random.signed());
            let by = 0.3 * Vec3::new(random.signed(), random.signed(), random.signed());
            let pose = Transform::from_xyz(x, 0.0, 0.0).with_rotation(turn);
            *self.app.world_mut().get_mut::<Transform>(joint).expect("a joint") =
                pose.with_translation(pose.translation + by);
        }
        self.app.update();
    }

    /// All vertices of the mesh where the joints have them, by the plain formula and in `f64`.
    fn vertices(&self) -> Vec<bevy::math::DVec3> {
        let world = self.app.world();
        let mesh = world.resource::<Assets<Mesh>>().get(&world.get::<Mesh3d>(self.surface).expect("a mesh").0);
        let mesh = mesh.expect("loaded");
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|a| a.as_float3()).expect("positions");
        let Some(VertexAttributeValues::Uint16x4(joints)) = mesh.attribute(Mesh::ATTRIBUTE_JOINT_INDEX) else {
            panic!("no joints")
        };
        let Some(VertexAttributeValues::Float32x4(weights)) = mesh.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT) else {
            panic!("no weights")
        };
        let of = |k: u16, p: bevy::math::DVec3| {
            let rest = bevy::math::DVec3::new([0.0, 2.0, 4.0][usize::from(k)], 0.0, 0.0);
            let joint = world.get::<GlobalTransform>(self.joints[usize::from(k)]).expect("a joint");
            joint.to_matrix().as_dmat4().transform_point3(p - rest)
        };
        (0..positions.len())
            .map(|v| {
                let p = Vec3::from_array(positions[v]).as_dvec3();
                (0..4).map(|k| f64::from(weights[v][k]) * of(joints[v][k], p)).sum()
            })
            .collect()
    }

    fn faces(&self) -> Vec<[u32; 3]> {
        let world = self.app.world();
        let mesh = world.resource::<Assets<Mesh>>().get(&world.get::<Mesh3d>(self.surface).expect("a mesh").0);
        let indices: Vec<usize> = mesh.and_then(Mesh::indices).expect("indices").iter().collect();
        indices.as_chunks::<3>().0.iter().map(|face| face.map(|v| v as u32)).collect()
    }

    fn riding(&self) -> &RidingCurve {
        self.app.world().get::<RidingCurve>(self.spline).expect("it rides")
    }
}

fn surface_points(app: &App, surface: Entity, places: &[Vec3]) -> Vec<SurfacePoint> {
    let surface = super::surface_of(app, surface);
    places.iter().map(|place| surface.closest_point(place.as_dvec3()).expect("a place").point).collect()
}

#[test]
fn a_curve_stays_on_the_deformed_mesh() {
    let (mut arm, mut random) = (Arm::new(), Random(2));
    let faces = arm.faces();
    for _ in 0..20 {
        arm.bend(&mut random);
        let vertices = arm.vertices();
        let world = arm.app.world();
        let trace = world.get::<SplineTrace>(arm.spline).expect("a trace");
        let points = trace.surface_points(super::surface_of(&arm.app, arm.surface));
        let positions = arm.riding().positions();
        assert_eq!((positions.len(), points.len()), (trace.polyline().len(), trace.polyline().len()));
        for (position, point) in positions.iter().zip(&points) {
            let corners = faces[point.face.0 as usize].map(|v| vertices[v as usize]);
            let place: bevy::math::DVec3 = (0..3).map(|k| point.weights[k] * corners[k]).sum();
            assert!(position.as_dvec3().distance(place) < 4e-6, "{position} {place}");
        }
    }
}

#[test]
fn a_ray_hits_the_mesh_as_it_is_seen() {
    let (mut arm, mut random) = (Arm::new(), Random(3));
    let (faces, mut hits) = (arm.faces(), 0);
    for _ in 0..10 {
        arm.bend(&mut random);
        let vertices = arm.vertices();
        let deformed = arm.app.world().get::<DeformedSurface>(arm.surface).expect("deformed");
        for _ in 0..100 {
            let origin = 6.0 * Vec3::new(random.signed(), random.signed(), random.signed());
            let goal = vertices[random.below(vertices.len() as u32) as usize].as_vec3();
            let goal = goal + 0.4 * Vec3::new(random.signed(), random.signed(), random.signed());
            let Ok(direction) = Dir3::new(goal - origin) else { continue };
            let found = deformed.ray(Ray3d { origin, direction });
            let expected = brute_force(&vertices, &faces, origin, *direction);
            match (found, expected) {
                (Some(found), Some(distance)) => {
                    hits += 1;
                    assert!((found.distance - distance).abs() < 1e-5, "{} {distance}", found.distance);
                    let there = deformed.position(&found.point).as_dvec3();
                    assert!(there.distance(found.position) < 1e-5);
                }
                (None, None) => {}
                // Within rounding of the rim.
                (found, expected) => assert!(
                    brute_force(&vertices, &faces, origin, (direction.as_vec3() + 1e-4).normalize()).is_some()
                        != brute_force(&vertices, &faces, origin, (direction.as_vec3() - 1e-4).normalize()).is_some(),
                    "{found:?} {expected:?}"
                ),
            }
        }
    }
    assert!(hits > 300, "{hits} hits");
}

#[test]
fn the_pointer_finds_surface_and_curve_where_they_are_seen() {
    let (mut arm, mut random) = (Arm::new(), Random(6));
    let eye = Transform::from_xyz(2.0, 1.0, 9.0).looking_at(Vec3::new(2.0, 0.0, 0.0), Vec3::Y);
    let camera = arm.app.world_mut().spawn((Camera3d::default(), eye)).id();
    let mut pointer = PointerScript::mouse(&mut arm.app).expect("a window");
    let faces = arm.faces();
    let (mut on_surface, mut on_curve) = (0, 0);
    for _ in 0..6 {
        arm.bend(&mut random);
        arm.app.update();
        let vertices = arm.vertices();
        let pixels = |arm: &Arm, places: &[Vec3]| -> Vec<(Vec2, Ray3d)> {
            let world = arm.app.world();
            let pixels = places.iter().filter_map(|place| pixel_of(world, camera, *place));
            let to = world.get::<GlobalTransform>(camera).expect("a place");
            let camera = world.get::<Camera>(camera).expect("a camera");
            pixels.filter_map(|pixel| Some((pixel, camera.viewport_to_world(to, pixel).ok()?))).collect()
        };
        let places: Vec<Vec3> = vertices.iter().step_by(23).map(|p| p.as_vec3() + 0.1).collect();
        for (pixel, ray) in pixels(&arm, &places) {
            let found = hovered(&mut arm, &mut pointer, pixel);
            let expected = brute_force(&vertices, &faces, ray.origin, *ray.direction);
            let (Some((entity, hit)), Some(distance)) = (&found, expected) else {
                assert!(found.is_none() && expected.is_none(), "{pixel}: {found:?} {expected:?}");
                continue;
            };
            assert_eq!(*entity, arm.surface);
            let (at, point) = (hit.position.expect("a place"), hit.extra_as::<SurfaceHit>().expect("a surface").point);
            assert!(at.distance(ray.get_point(distance as f32)) < 1e-4, "{at} {distance}");
            let deformed = arm.app.world().get::<DeformedSurface>(arm.surface).expect("deformed");
            assert!(deformed.position(&point).distance(at) < 1e-4);
            on_surface += 1;
        }
        let spline = arm.spline;
        arm.app.world_mut().entity_mut(spline).insert(Pickable::default());
        let places: Vec<Vec3> = arm.riding().positions().iter().copied().step_by(7).collect();
        for (place, (pixel, ray)) in places.iter().zip(pixels(&arm, &places)) {
            let distance = brute_force(&vertices, &faces, ray.origin, *ray.direction);
            // Not on the far side.
            if distance.is_none_or(|distance| distance < f64::from(ray.origin.distance(*place)) - 1e-3) {
                continue;
            }
            let (entity, hit) = hovered(&mut arm, &mut pointer, pixel).expect("a curve");
            assert_eq!(entity, arm.spline);
            let point = hit.extra_as::<CurveHit>().expect("a curve").point;
            let deformed = arm.app.world().get::<DeformedSurface>(arm.surface).expect("deformed");
            assert!(deformed.position(&point).distance(*place) < 0.02, "{} {place}", deformed.position(&point));
            on_curve += 1;
        }
        arm.app.world_mut().entity_mut(spline).remove::<Pickable>();
    }
    assert!(on_surface > 40 && on_curve > 20, "{on_surface} {on_curve}");
}

fn hovered(arm: &mut Arm, pointer: &mut PointerScript, pixel: Vec2) -> Option<(Entity, HitData)> {
    pointer.move_to(&mut arm.app, pixel);
    let map = arm.app.world().resource::<HoverMap>();
    let hits = map.get(&PointerId::Mouse)?.iter();
    // Without an entity with data of ours it is the window that is hovered.
    hits.filter(|(_, hit)| hit.extra.is_some()).map(|(entity, hit)| (*entity, hit.clone())).next()
}

/// The nearest hit among all faces (Möller and Trumbore), in `f64`.
pub(super) fn brute_force(
    vertices: &[bevy::math::DVec3],
    faces: &[[u32; 3]],
    origin: Vec3,
    direction: Vec3,
) -> Option<f64> {
    let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
    let hits = faces.iter().filter_map(|face| {
        let [a, b, c] = face.map(|v| vertices[v as usize]);
        let (u, v) = (b - a, c - a);
        let across = direction.cross(v);
        let determinant = u.dot(across);
        let from = origin - a;
        let s = from.dot(across) / determinant;
        let beside = from.cross(u);
        let t = direction.dot(beside) / determinant;
        let distance = v.dot(beside) / determinant;
        (s >= 0.0 && t >= 0.0 && s + t <= 1.0 && distance >= 0.0).then_some(distance)
    });
    hits.min_by(f64::total_cmp)
}

#[test]
fn nothing_is_done_where_nothing_moves() {
    let (mut arm, mut random) = (Arm::new(), Random(4));
    arm.bend(&mut random);
    let stamp = |arm: &Arm| arm.app.world().get::<DeformedSurface>(arm.surface).expect("deformed").stamp();
    let changed = |arm: &mut Arm| {
        let world = arm.app.world_mut();
        world.query_filtered::<(), Changed<RidingCurve>>().iter(world).count()
    };
    let (before, place) = (stamp(&arm), arm.riding().positions().as_ptr());
    arm.app.world_mut().clear_trackers();
    for _ in 0..5 {
        arm.app.update();
        assert_eq!((stamp(&arm), changed(&mut arm)), (before, 0));
    }
    arm.bend(&mut random);
    assert_eq!(stamp(&arm), before + 1);
    assert_eq!(arm.riding().positions().as_ptr(), place, "memory is kept");
    // Another curve: bound anew, and it follows in the same frame.
    let on = surface_points(&arm.app, arm.surface, &[Vec3::new(0.2, 0.5, 0.0), Vec3::new(3.0, 0.5, 0.0)]);
    let to = on[1];
    arm.app.world_mut().write_message(EditSpline::new(arm.spline, SplineEdit::MoveAnchor { anchor: 1, to }));
    arm.app.update();
    let trace = arm.app.world().get::<SplineTrace>(arm.spline).expect("a trace");
    assert_eq!(arm.riding().positions().len(), trace.polyline().len());
}

#[test]
fn a_skin_comes_and_goes() {
    let (mut arm, mut random) = (Arm::new(), Random(5));
    arm.bend(&mut random);
    // A joint that is gone leaves its vertices where its matrix is none, and nothing breaks.
    let last = arm.joints[2];
    arm.app.world_mut().despawn(last);
    arm.app.update();
    assert!(arm.riding().positions().iter().all(|p| p.is_finite()));
    let surface = arm.surface;
    let skin = arm.app.world_mut().entity_mut(surface).take::<SkinnedMesh>().expect("a skin");
    arm.app.update();
    arm.app.update();
    let world = arm.app.world();
    assert!(world.get::<DeformedSurface>(surface).is_none() && world.get::<RidingCurve>(arm.spline).is_none());
    arm.app.world_mut().entity_mut(surface).insert(skin);
    arm.app.update();
    arm.app.update();
    assert!(arm.app.world().get::<RidingCurve>(arm.spline).is_some());
    arm.app.world_mut().entity_mut(surface).remove::<(SplineSurface, BuiltSurface)>();
    arm.app.update();
    arm.app.update();
    let world = arm.app.world();
    assert!(world.get::<DeformedSurface>(surface).is_none() && world.get::<RidingCurve>(arm.spline).is_none());
}

#[test]
fn another_mesh_is_ridden_on_once_its_surface_is_there() {
    let (mut arm_now, mut random) = (Arm::new(), Random(6));
    arm_now.bend(&mut random);
    let surface = arm_now.surface;
    for rings in [13, 40] {
        let other = arm_now.app.world_mut().resource_mut::<Assets<Mesh>>().add(arm(rings));
        arm_now.app.world_mut().entity_mut(surface).insert(Mesh3d(other));
        let faces = 2 * usize::from(ROUND - 1) * usize::from(rings - 1);
        let is_there = |world: &mut World| {
            let faces_now = world.get::<BuiltSurface>(surface).map(|built| built.face_count());
            faces_now == Some(faces) && world.get::<DeformedSurface>(surface).is_some()
        };
        assert!(update_until(&mut arm_now.app, is_there), "{rings} rings");
    }
    arm_now.bend(&mut random);
    assert!(arm_now.riding().positions().iter().all(|p| p.is_finite()));
}
