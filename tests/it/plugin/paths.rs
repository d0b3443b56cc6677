//! Painted paths and skins in a headless app.

use std::sync::Arc;

use bevy::camera::primitives::Aabb;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_surface_splines::plugin::testing::{headless_app, update_until};
use bevy_surface_splines::plugin::{
    BezierPaths, FlexibleSolve, JointWeights, PathStatistics, SkinBinding, SkinState, SplineSkin,
};
use bevy_surface_splines::skin::{BindOptions, BoundSkin, Chain, FlexibleOptions, HandleShape, JoinRules, Shepard};
use bevy_surface_splines::vector::{
    Color as Ink, LineCap, LineJoin, Paint, PathBuilder, Picture, PictureChange, PictureOptions, Stroke, Style,
    VectorPath,
};
use glam::{DAffine3, DVec2, DVec3};

fn disc(centre: DVec2, radius: f64) -> VectorPath {
    let mut pen = PathBuilder::default();
    let (a, b) = (centre + DVec2::X * radius, centre - DVec2::X * radius);
    pen.move_to(a);
    for to in [b, a] {
        pen.arc_to(DVec2::splat(radius), 0.0, false, true, to);
    }
    pen.close();
    pen.finish().remove(0)
}

fn style() -> Style {
    let stroke = Stroke {
        paint: Paint::Color(Ink::BLACK),
        width: 0.1,
        cap: LineCap::Round,
        join: LineJoin::Round,
        miter_limit: 4.0,
        dashes: Vec::new(),
        dash_offset: 0.0,
    };
    let fill = Some(Paint::Color(Ink { red: 1.0, ..Ink::BLACK }));
    Style { fill, stroke: Some(stroke), opacity: 1.0, ..Style::default() }
}

/// Five discs in a row, two apart.
fn row() -> Arc<Picture> {
    let paths: Vec<[VectorPath; 1]> = (0..5).map(|i| [disc(DVec2::X * 2.0 * f64::from(i), 0.8)]).collect();
    let style = style();
    let shapes = paths.iter().map(|paths| (&paths[..], &style));
    Arc::new(Picture::planar(shapes, &[], &PictureOptions::default()))
}

fn made(app: &App) -> PictureChange {
    app.world().resource::<PathStatistics>().made
}

fn positions(app: &App, entity: Entity) -> Vec<Vec3> {
    let handle = &app.world().get::<Mesh3d>(entity).expect("a mesh").0;
    let mesh = app.world().resource::<Assets<Mesh>>().get(handle).expect("an asset");
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        panic!("no positions")
    };
    assert_eq!(mesh.attribute(Mesh::ATTRIBUTE_COLOR).map(|colors| colors.len()), Some(positions.len()));
    assert!(mesh.indices().is_some_and(|indices| indices.iter().all(|i| i < positions.len())));
    positions.iter().copied().map(Vec3::from_array).collect()
}

fn moves(app: &App, entity: Entity) -> Vec<u32> {
    let paths = app.world().get::<BezierPaths>(entity).expect("paths");
    (0..paths.picture().path_count()).map(|path| paths.moved(path)).collect()
}

#[test]
fn paths_become_meshes_that_follow_them() {
    let mut app = headless_app();
    let entity = app.world_mut().spawn(BezierPaths::new(row())).id();
    app.update();
    assert_eq!(made(&app), PictureChange { paths: 5, filled: 5, kept: 0, stroked: 5 });
    let bounds = |app: &App| *app.world().get::<Aabb>(entity).expect("bounds");
    let check = |app: &App| {
        let all = positions(app, entity);
        let (low, high) = all.iter().fold((Vec3::MAX, Vec3::MIN), |(l, h), p| (l.min(*p), h.max(*p)));
        let aabb = bounds(app);
        assert!(Vec3::from(aabb.min()).distance(low) < 1e-5 && Vec3::from(aabb.max()).distance(high) < 1e-5);
    };
    check(&app);
    for _ in 0..3 {
        app.update();
        assert_eq!(made(&app), PictureChange::default(), "nothing moved");
    }
    let mut paths = app.world_mut().get_mut::<BezierPaths>(entity).expect("paths");
    let aside: Vec<Vec3> = paths.points_of(4).iter().map(|p| *p + Vec3::new(5.0, 3.0, 0.0)).collect();
    assert!(paths.set_points(4, aside.clone()));
    assert!(!paths.set_points(4, aside), "it is there already");
    app.update();
    assert_eq!(made(&app), PictureChange { paths: 1, filled: 0, kept: 1, stroked: 1 });
    assert_eq!(moves(&app, entity), [0, 0, 0, 0, 1]);
    assert!((bounds(&app).max().x - 13.85).abs() < 0.01, "{:?}", bounds(&app));
    check(&app);
    // Another picture replaces all of it.
    app.world_mut().entity_mut(entity).insert(BezierPaths::new(Picture::default()));
    app.update();
    assert_eq!(positions(&app, entity), [Vec3::ZERO]);
    app.world_mut().entity_mut(entity).insert(BezierPaths::new(row()));
    app.update();
    check(&app);
}

#[test]
fn clones_have_meshes_of_their_own() {
    let mut app = headless_app();
    let entity = app.world_mut().spawn(BezierPaths::new(row())).id();
    app.update();
    let clone = app.world_mut().entity_mut(entity).clone_and_spawn();
    app.update();
    let handle = |app: &App, entity| app.world().get::<Mesh3d>(entity).expect("a mesh").0.clone();
    assert_ne!(handle(&app, entity), handle(&app, clone));
    assert_eq!(positions(&app, entity), positions(&app, clone));
    let bounds = |app: &App, entity| *app.world().get::<Aabb>(entity).expect("bounds");
    assert_eq!(bounds(&app, clone), bounds(&app, entity));
    let mut paths = app.world_mut().get_mut::<BezierPaths>(clone).expect("paths");
    assert!(paths.set_points(0, [Vec3::new(9.0, 9.0, 0.0)]));
    app.update();
    assert_ne!(positions(&app, entity), positions(&app, clone));
    assert_eq!((moves(&app, entity)[0], moves(&app, clone)[0]), (0, 1));
    // Without paths nothing is left, and new ones are shown.
    app.world_mut().entity_mut(clone).remove::<BezierPaths>();
    app.update();
    assert!(!app.world().entity(clone).contains::<Mesh3d>());
    app.world_mut().entity_mut(clone).insert(BezierPaths::new(row()));
    app.update();
    assert_eq!(positions(&app, entity), positions(&app, clone));
    assert_eq!(bounds(&app, clone), bounds(&app, entity));
}

/// A row of discs on three joints, bound in the background.
fn skinned(app: &mut App, flexible: FlexibleSolve, weights: JointWeights) -> (Entity, [Entity; 3]) {
    let world = app.world_mut();
    let root = world.spawn((BezierPaths::new(row()), Transform::from_xyz(1e4, -3.0, 2.0))).id();
    let a = world.spawn((Transform::default(), ChildOf(root))).id();
    let b = world.spawn((Transform::from_xyz(4.0, 0.0, 0.0), ChildOf(a))).id();
    let c = world.spawn((Transform::from_xyz(4.0, 0.0, 0.0), ChildOf(b))).id();
    let joints = [a, b, c];
    let inverse = [0.0, 4.0, 8.0].map(|x| Mat4::from_translation(Vec3::X * -x));
    let skin = SplineSkin { weights, flexible, ..SplineSkin::new(joints, inverse) };
    world.entity_mut(root).insert(skin);
    let is_ready = |world: &mut World| world.get::<SkinState>(root) == Some(&SkinState::Ready);
    assert!(update_until(app, is_ready), "{:?}", app.world().get::<SkinState>(root));
    app.update();
    (root, joints)
}

/// The same drawing posed by the ground floor alone.
fn expected(worlds: [DAffine3; 3], weights: JointWeights, flexible: bool) -> Vec<Vec<Vec3>> {
    let at = |x: f64| DVec3::X * x;
    let shapes = match weights {
        JointWeights::Joints(_) => [0.0, 4.0, 8.0].map(|x| HandleShape::Point(at(x))),
        JointWeights::Bones(_) => {
            [HandleShape::Bone(at(0.0), at(4.0)), HandleShape::Bone(at(4.0), at(8.0)), HandleShape::Point(at(8.0))]
        }
    };
    let (JointWeights::Joints(power) | JointWeights::Bones(power)) = weights;
    let picture = row();
    let flat = |path: usize| picture.rest_of(path).iter().map(|p| p.truncate().as_dvec2()).collect();
    let chain =
        |path| Chain::planar(&VectorPath::from_points(flat(path), true).expect("a path"), &JoinRules::default());
    let field = Shepard::with_power(&shapes, power).expect("weights");
    let skin = BoundSkin::bind((0..5).map(chain).collect(), &field, &BindOptions::default()).expect("a skin");
    let mut posed = skin.at_rest();
    let mut transforms = worlds;
    transforms.iter_mut().zip([0.0, 4.0, 8.0]).for_each(|(world, x)| *world *= DAffine3::from_translation(at(-x)));
    if flexible {
        skin.pose_flexible(&transforms, &FlexibleOptions::default(), &mut posed).expect("a pose");
    } else {
        skin.pose(&transforms, &mut posed).expect("a pose");
    }
    (0..5).map(|chain| skin.points(&posed, chain).collect()).collect()
}

fn far(app: &App, entity: Entity, wanted: &[Vec<Vec3>]) -> f32 {
    let paths = app.world().get::<BezierPaths>(entity).expect("paths");
    let pairs = wanted.iter().enumerate().flat_map(|(path, points)| {
        assert_eq!(paths.points_of(path).len(), points.len());
        paths.points_of(path).iter().zip(points)
    });
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

fn turned(x: f64, angle: f64) -> DAffine3 {
    DAffine3::from_rotation_translation(glam::DQuat::from_rotation_z(angle), DVec3::X * x)
}

#[test]
fn joints_move_paths_by_the_formula() {
    for weights in [JointWeights::Joints(2.0), JointWeights::default()] {
        let mut app = headless_app();
        let (root, [a, b, c]) = skinned(&mut app, FlexibleSolve::Never, weights);
        let still = [turned(0.0, 0.0), turned(4.0, 0.0), turned(8.0, 0.0)];
        assert!(far(&app, root, &expected(still, weights, false)) < 1e-5);
        let turn = |app: &mut App, joint: Entity, angle: f32| {
            app.world_mut().get_mut::<Transform>(joint).expect("a joint").rotation = Quat::from_rotation_z(angle);
        };
        for step in 1..6 {
            let angle = 0.2 * f64::from(step);
            turn(&mut app, a, 0.5 * angle as f32);
            turn(&mut app, b, angle as f32);
            turn(&mut app, c, -angle as f32);
            app.update();
            let first = turned(0.0, 0.5 * angle);
            let second = first * turned(4.0, angle);
            let worlds = [first, second, second * turned(4.0, -angle)];
            let off = far(&app, root, &expected(worlds, weights, false));
            assert!(off < 1e-5 * 10.0, "step {step}: {off}");
        }
        // All of it moved is none of it moved.
        let before = moves(&app, root);
        app.world_mut().get_mut::<Transform>(root).expect("a place").translation.y += 7.0;
        app.update();
        app.update();
        assert_eq!(moves(&app, root), before);
        assert_eq!(made(&app), PictureChange::default());
    }
}

#[test]
fn joints_that_are_gone_or_elsewhere() {
    let mut app = headless_app();
    let (root, [_, b, c]) = skinned(&mut app, FlexibleSolve::Never, JointWeights::Joints(4.0));
    // A joint that hangs on nothing is where the world has it.
    let place = app.world().get::<Transform>(root).expect("a place").translation;
    app.world_mut().entity_mut(c).remove::<ChildOf>();
    app.world_mut().get_mut::<Transform>(c).expect("a joint").translation = place + Vec3::new(8.0, 2.0, 0.0);
    app.update();
    let worlds = [turned(0.0, 0.0), turned(4.0, 0.0), DAffine3::from_translation(DVec3::new(8.0, 2.0, 0.0))];
    let off = far(&app, root, &expected(worlds, JointWeights::Joints(4.0), false));
    assert!(off < 2e-3, "ten thousand units away there are not more digits: {off}");
    let before = moves(&app, root);
    app.world_mut().entity_mut(b).despawn();
    for _ in 0..3 {
        app.update();
    }
    assert_eq!(moves(&app, root), before, "what it moved stays where it was");
    assert_eq!(app.world().get::<SkinState>(root), Some(&SkinState::Ready));
}

#[test]
fn flexible_poses_come_on_release_or_always() {
    let weights = JointWeights::Joints(2.0);
    let bend = |app: &mut App, joint: Entity, angle: f32| {
        app.world_mut().get_mut::<Transform>(joint).expect("a joint").rotation = Quat::from_rotation_z(angle);
        app.update();
    };
    let worlds = |angle: f64| {
        let second = turned(4.0, angle);
        [turned(0.0, 0.0), second, second * turned(4.0, 0.0)]
    };
    let mut app = headless_app();
    let (root, [_, b, _]) = skinned(&mut app, FlexibleSolve::OnRelease, weights);
    bend(&mut app, b, 0.5);
    bend(&mut app, b, 1.2);
    let (regular, flexible) = (expected(worlds(1.2), weights, false), expected(worlds(1.2), weights, true));
    assert!(far(&app, root, &regular) < 1e-5);
    app.update();
    assert!(far(&app, root, &flexible) < 1e-5 && far(&app, root, &regular) > 1e-3);
    let before = moves(&app, root);
    app.update();
    assert_eq!(moves(&app, root), before);
    let mut app = headless_app();
    let (root, [_, b, _]) = skinned(&mut app, FlexibleSolve::Always, weights);
    bend(&mut app, b, 1.2);
    assert!(far(&app, root, &flexible) < 1e-5);
}

#[test]
fn bindings_made_before_touch_only_what_is_influenced() {
    let mut app = headless_app();
    let picture = row();
    let flat = |path: usize| picture.rest_of(path).iter().map(|p| p.truncate().as_dvec2()).collect();
    // Each disc follows one joint of five.
    let chains = (0..5).map(|path| {
        let chain = Chain::planar(&VectorPath::from_points(flat(path), true).expect("a path"), &JoinRules::default());
        let alone = Only(path);
        bevy_surface_splines::skin::BoundChain::new(&chain, path, &alone, &BindOptions::default()).expect("a chain")
    });
    let skin = BoundSkin::of_bound(chains.collect(), 5).expect("a skin");
    let binding = SkinBinding::new(skin, picture.clone(), &[0, 1, 2, 3, 4]).expect("a binding");
    assert!(binding.is_influenced(2, 2) && !binding.is_influenced(2, 3));
    assert!(SkinBinding::new(binding.skin().clone(), picture.clone(), &[0, 1]).is_none());
    let root = app.world_mut().spawn(BezierPaths::new(picture)).id();
    let joints: Vec<Entity> =
        (0..5).map(|_| app.world_mut().spawn((Transform::default(), ChildOf(root))).id()).collect();
    app.world_mut().entity_mut(root).insert((SplineSkin::new(joints.clone(), vec![Mat4::IDENTITY; 5]), binding));
    app.update();
    app.update();
    assert_eq!(made(&app), PictureChange::default());
    for (number, joint) in joints.iter().enumerate() {
        let before = moves(&app, root);
        app.world_mut().get_mut::<Transform>(*joint).expect("a joint").translation.y += 1.5;
        app.update();
        let after = moves(&app, root);
        let changed: Vec<usize> = (0..5).filter(|path| after[*path] != before[*path]).collect();
        assert_eq!((changed, made(&app).paths), (vec![number], 1));
    }
    // A pose that is none keeps what is there.
    let before = moves(&app, root);
    app.world_mut().get_mut::<Transform>(joints[0]).expect("a joint").translation.x = f32::NAN;
    app.update();
    assert_eq!(moves(&app, root), before);
}

/// All weight on one of five handles.
struct Only(usize);

impl bevy_surface_splines::skin::WeightField for Only {
    fn handle_count(&self) -> usize {
        5
    }

    fn weights_at(&self, _: DVec3, out: &mut [f64]) {
        out.iter_mut().enumerate().for_each(|(i, out)| *out = f64::from(u8::from(i == self.0)));
    }
}
