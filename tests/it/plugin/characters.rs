//! Characters in a headless app: loaded, played, posed, reloaded, saved, cloned.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bevy::asset::io::memory::{Dir, MemoryAssetReader};
use bevy::asset::io::{AssetSourceBuilder, AssetSourceEvent, AssetSourceId, AssetWatcher};
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::system::RunSystemOnce;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy::world_serialization::serde::WorldDeserializer;
use bevy_surface_splines::character::{BindProgress, BoundCharacter, Character, JointPose};
use bevy_surface_splines::plugin::testing::{unfinished_headless_app_from, update_until};
use bevy_surface_splines::plugin::{
    BezierCharacter, BezierPaths, CharacterAsset, CharacterCapture, CharacterFailed, CharacterJoints, CharacterReady,
    CharacterState, PathStatistics, SkinBinding, SplineSkin,
};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::vector::PictureChange;
use serde::de::DeserializeSeed;

pub(super) const DRAWING: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 200">
  <g id="body" stroke="#111" stroke-width="2">
    <path id="trunk" fill="#c33" fill-rule="evenodd" d="M 80 100 C 80 80 120 80 120 100 L 120 160 H 80 z M 95 120 h 10 v 10 h -10 z"/>
    <path id="sleeve" fill="#234" d="M 120 95 C 140 93 150 93 160 95 C 170 97 190 93 195 97 C 199 101 190 107 160 105 C 150 104 140 107 120 105 C 117 103 117 97 120 95 z"/>
    <circle id="head" fill="#eca" cx="100" cy="60" r="20"/>
    <path id="foot" fill="#222" d="M 85 160 h 30 v 8 h -30 z"/>
  </g>
</svg>
"##;

pub(super) const TEXT: &str = r#"(
  version: 1,
  name: "doll",
  drawing: "doll.svg",
  joints: [
    (name: "hips", at: (100, 160), tip: (100, 95)),
    (name: "upper", parent: "hips", at: (120, 100), tip: (160, 100)),
    (name: "fore", parent: "upper", at: (160, 100), tip: (195, 100)),
    (name: "neck", parent: "hips", at: (100, 80)),
  ],
  parts: [
    (name: "body", shapes: ["trunk", "foot"], follows: ["hips"]),
    (name: "arm", shapes: ["sleeve"], follows: ["upper", "fore"], z: 1),
    (name: "head", shapes: ["head"], follows: ["neck"], z: -1),
  ],
  clips: [
    (name: "wave", duration: 2, loops: true, tracks: [
      (joint: "fore", keys: Rotation([(0, 0), (0.5, 80), (1, 10), (1.5, 60)])),
      (joint: "upper", easing: Linear, keys: Rotation([(0, -5), (1, 25)])),
      (joint: "hips", keys: Translation([(0, (0, 0)), (1, (0, -4))])),
    ]),
    (name: "nod", duration: 1, loops: true, tracks: [(joint: "neck", keys: Rotation([(0, -20), (0.5, 20)]))]),
  ],
)
"#;

const FILE: &str = "doll.character.ron";

type Tell = Box<dyn Fn(AssetSourceEvent) + Send>;

/// A folder of assets in memory, and a way to say that one changed.
pub(super) struct Folder {
    dir: Dir,
    changed: Arc<Mutex<Vec<Tell>>>,
}

struct Watcher;
impl AssetWatcher for Watcher {}

impl Folder {
    pub(super) fn write(&self, path: &str, text: &str) {
        self.dir.insert_asset_text(Path::new(path), text);
        for tell in self.changed.lock().expect("a list").iter() {
            tell(AssetSourceEvent::ModifiedAsset(path.into()));
        }
    }
}

/// What happened, in order.
#[derive(Resource, Default)]
struct Log(Vec<String>);

pub(super) fn app() -> (App, Folder) {
    let folder = Folder { dir: Dir::default(), changed: Arc::default() };
    folder.write(FILE, TEXT);
    folder.write("doll.svg", DRAWING);
    let mut app = App::new();
    let (dir, changed) = (folder.dir.clone(), folder.changed.clone());
    let source = AssetSourceBuilder::new(move || Box::new(MemoryAssetReader { root: dir.clone() }));
    let source = source.with_watcher(move |sender| {
        changed.lock().expect("a list").push(Box::new(move |event| drop(sender.try_send(event))));
        Some(Box::new(Watcher))
    });
    app.register_asset_source(AssetSourceId::Default, source);
    let assets = AssetPlugin { watch_for_changes_override: Some(true), ..default() };
    let mut app = unfinished_headless_app_from(app, assets);
    app.add_plugins(SurfaceSplinePlugins);
    app.finish();
    app.cleanup();
    app.init_resource::<Log>()
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(70)))
        .add_observer(|_: On<CharacterReady>, mut log: ResMut<Log>| log.0.push("ready".to_owned()))
        .add_observer(|event: On<CharacterFailed>, mut log: ResMut<Log>| {
            log.0.push(format!("failed{}: {}", if event.kept { ", kept" } else { "" }, event.reason));
        });
    (app, folder)
}

fn until_logged(app: &mut App) -> String {
    assert!(update_until(app, |world| !world.resource::<Log>().0.is_empty()), "something happens");
    std::mem::take(&mut app.world_mut().resource_mut::<Log>().0).join(", ")
}

pub(super) fn spawn(app: &mut App, bundle: impl Bundle) -> Entity {
    let handle = app.world().resource::<AssetServer>().load(FILE);
    let entity = app.world_mut().spawn((BezierCharacter(handle), bundle)).id();
    let is_ready = |world: &mut World| world.get::<CharacterState>(entity) == Some(&CharacterState::Ready);
    assert!(update_until(app, is_ready), "{:?}", app.world().get::<CharacterState>(entity));
    app.update();
    app.world_mut().resource_mut::<Log>().0.clear();
    entity
}

fn asset(app: &App, entity: Entity) -> &CharacterAsset {
    let handle = &app.world().get::<BezierCharacter>(entity).expect("a character").0;
    app.world().resource::<Assets<CharacterAsset>>().get(handle).expect("an asset")
}

fn play(app: &mut App, entity: Entity, clip: &str, at: f32) {
    let node = asset(app, entity).node(clip).expect("a clip");
    let mut player = app.world_mut().get_mut::<AnimationPlayer>(entity).expect("a player");
    player.play(node).repeat().seek_to(at);
}

/// Where the only clip that is played is, in seconds.
fn seek(app: &App, entity: Entity) -> f64 {
    let player = app.world().get::<AnimationPlayer>(entity).expect("a player");
    let times: Vec<f32> = player.playing_animations().map(|(_, active)| active.seek_time()).collect();
    assert_eq!(times.len(), 1);
    f64::from(times[0])
}

fn bound(character: &Character) -> BoundCharacter {
    character.bind(&BindProgress::default()).expect("bound")
}

/// Control points in a pose of the ground floor, path by path.
fn expected(character: &Character, bound: &BoundCharacter, locals: &[JointPose]) -> Vec<Vec<Vec3>> {
    let (mut worlds, mut posed) = (Vec::new(), bound.skin.at_rest());
    character.worlds(locals, &mut worlds);
    bound.pose(&worlds, &mut posed).expect("a pose");
    bound.paths.iter().map(|path| bound.skin.points(&posed, path.chain).collect()).collect()
}

/// How far the control points are from what they should be, as a share of the drawing's size.
fn far(app: &App, entity: Entity, wanted: &[Vec<Vec3>]) -> f32 {
    let paths = app.world().get::<BezierPaths>(entity).expect("paths");
    assert_eq!(paths.picture().path_count(), wanted.len());
    let pairs = wanted.iter().enumerate().flat_map(|(path, points)| paths.points_of(path).iter().zip(points));
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max) / 200.0
}

fn moves(app: &App, entity: Entity) -> Vec<u32> {
    let paths = app.world().get::<BezierPaths>(entity).expect("paths");
    (0..paths.picture().path_count()).map(|path| paths.moved(path)).collect()
}

fn joint(app: &App, entity: Entity, name: &str) -> Entity {
    let number = asset(app, entity).character().joint_named(name).expect("a joint");
    let joints = app.world().get::<CharacterJoints>(entity).expect("joints");
    joints.get(number).expect("a joint")
}

fn check_pose(app: &App, entity: Entity, clip: &str) {
    let character = asset(app, entity).character().clone();
    let bound = bound(&character);
    let mut locals = character.rest_poses();
    character.sample(character.clip_named(clip).expect("a clip"), seek(app, entity), &mut locals);
    let off = far(app, entity, &expected(&character, &bound, &locals));
    assert!(off < 1e-5, "{off} at {}", seek(app, entity));
}

#[test]
fn a_clip_moves_control_points_by_the_formula() {
    let (mut app, _) = app();
    let doll = spawn(&mut app, Transform::from_xyz(1e5, 3.0, 0.0));
    let character = asset(&app, doll).character().clone();
    let rest = expected(&character, &bound(&character), &character.rest_poses());
    assert!(far(&app, doll, &rest) < 1e-6);
    play(&mut app, doll, "wave", 0.0);
    let fore = joint(&app, doll, "fore");
    let mut before = app.world().get::<Transform>(fore).copied();
    for _ in 0..40 {
        app.update();
        let now = app.world().get::<Transform>(fore).copied();
        assert_ne!(now, before, "the clip moves the joint");
        before = now;
        check_pose(&app, doll, "wave");
    }
    assert!(far(&app, doll, &rest) > 1e-2);
    // A clip that leaves joints alone brings them to rest.
    app.world_mut().get_mut::<AnimationPlayer>(doll).expect("a player").stop_all();
    play(&mut app, doll, "nod", 0.3);
    app.update();
    check_pose(&app, doll, "nod");
}

#[test]
fn only_what_moved_is_tessellated() {
    let (mut app, _) = app();
    let doll = spawn(&mut app, ());
    for _ in 0..3 {
        app.update();
        assert_eq!(app.world().resource::<PathStatistics>().made, PictureChange::default());
    }
    let names: Vec<String> = asset(&app, doll).character().joints.iter().map(|joint| joint.name.clone()).collect();
    let mut seen = Vec::new();
    for name in names {
        let (entity, before) = (joint(&app, doll, &name), moves(&app, doll));
        let binding = app.world().get::<SkinBinding>(doll).expect("a binding").clone();
        let joints = asset(&app, doll).character().clone();
        // What the joint carries moves along.
        let carried = |number: usize| {
            let mut next = Some(number);
            std::iter::from_fn(|| {
                let parent = joints.joints[next?].parent;
                std::mem::replace(&mut next, parent)
            })
            .any(|number| joints.joints[number].name == name)
        };
        let is_influenced =
            |path: usize| (0..joints.joints.len()).any(|number| carried(number) && binding.is_influenced(path, number));
        let wanted: Vec<bool> = (0..before.len()).map(is_influenced).collect();
        app.world_mut().get_mut::<Transform>(entity).expect("a joint").rotate_z(0.3);
        app.update();
        let after = moves(&app, doll);
        let found: Vec<bool> = after.iter().zip(&before).map(|(a, b)| a != b).collect();
        assert_eq!(found, wanted, "{name}");
        let made = app.world().resource::<PathStatistics>().made;
        assert_eq!(made.paths as usize, wanted.iter().filter(|moved| **moved).count());
        seen.push(made.paths);
        app.update();
        assert_eq!(moves(&app, doll), after);
    }
    assert_eq!(seen, [5, 1, 1, 1], "paths that hips, upper arm, forearm and neck move");
}

#[test]
fn a_hundred_of_one_file_share_it_and_move_by_themselves() {
    let (mut app, _) = app();
    let all: Vec<Entity> = (0..100).map(|_| spawn(&mut app, ())).collect();
    let picture = |app: &App, entity| app.world().get::<BezierPaths>(entity).expect("paths").picture().clone();
    let skin = |app: &App, entity| app.world().get::<SkinBinding>(entity).expect("a binding").skin().clone();
    for (number, entity) in all.iter().enumerate() {
        assert!(Arc::ptr_eq(&picture(&app, all[0]), &picture(&app, *entity)));
        assert!(Arc::ptr_eq(&skin(&app, all[0]), &skin(&app, *entity)));
        play(&mut app, *entity, "wave", 0.02 * number as f32);
    }
    assert_eq!(app.world().resource::<Assets<AnimationClip>>().len(), 2, "clips are shared");
    for _ in 0..3 {
        app.update();
    }
    let mut times: Vec<f64> = all.iter().map(|entity| seek(&app, *entity)).collect();
    all.iter().step_by(9).for_each(|entity| check_pose(&app, *entity, "wave"));
    times.sort_by(f64::total_cmp);
    times.dedup();
    assert_eq!(times.len(), 100);
    assert_eq!(app.world().resource::<PathStatistics>().meshes, 100);
    // One that is gone takes its joints with it, and nothing from others.
    let count = |app: &mut App| {
        let world = app.world_mut();
        world.query::<&bevy::animation::AnimatedBy>().iter(world).count()
    };
    assert_eq!(count(&mut app), 400);
    app.world_mut().entity_mut(all[7]).despawn();
    app.world_mut().entity_mut(all[8]).remove::<BezierCharacter>();
    app.update();
    assert_eq!(count(&mut app), 392);
    assert!(app.world().get::<BezierPaths>(all[8]).is_none());
    check_pose(&app, all[9], "wave");
}

#[test]
fn files_that_change_go_on_playing() {
    let (mut app, folder) = app();
    let (doll, other) = (spawn(&mut app, ()), spawn(&mut app, ()));
    play(&mut app, doll, "wave", 0.1);
    let fore = joint(&app, doll, "fore");
    // A joint is moved, a clip comes before the others, one joint is new, and the arm is longer.
    let text = TEXT
        .replace("clips: [", "clips: [(name: \"still\", duration: 1, tracks: []),")
        .replace(
            "(name: \"neck\", parent: \"hips\", at: (100, 80))",
            "(name: \"neck\", parent: \"hips\", at: (100, 75)), (name: \"toe\", parent: \"hips\", at: (115, 165))",
        )
        .replace(
            "shapes: [\"trunk\", \"foot\"], follows: [\"hips\"]",
            "shapes: [\"trunk\", \"foot\"], follows: [\"hips\", \"toe\"]",
        );
    folder.write(FILE, &text);
    assert_eq!(until_logged(&mut app), "ready, ready");
    assert_eq!(joint(&app, doll, "fore"), fore, "joints of the same name stay");
    assert_eq!(asset(&app, doll).clips().len(), 3);
    let neck = app.world().get::<Transform>(joint(&app, doll, "neck")).copied().expect("a joint");
    assert_eq!(neck.translation, Vec3::new(0.0, 85.0, 0.0), "what was at rest is at its new rest");
    for _ in 0..5 {
        app.update();
        check_pose(&app, doll, "wave");
    }
    let player = app.world().get::<AnimationPlayer>(other).expect("a player");
    assert_eq!(player.playing_animations().count(), 0);
    // A broken file, then a broken drawing, change nothing.
    for (path, broken, sound) in [
        (FILE, text.replace("parent: \"hips\", at: (115", "parent: \"knee\", at: (115"), text.clone()),
        ("doll.svg", "<svg".to_owned(), DRAWING.replace("r=\"20\"", "r=\"25\"")),
    ] {
        folder.write(path, &broken);
        let said = until_logged(&mut app);
        assert!(said.starts_with("failed, kept: ") && said.contains(FILE), "{said}");
        assert!(matches!(app.world().get::<CharacterState>(doll), Some(CharacterState::Failed { .. })));
        app.update();
        app.update();
        check_pose(&app, doll, "wave");
        folder.write(path, &sound);
        assert_eq!(until_logged(&mut app), "ready, ready");
        assert_eq!(app.world().get::<CharacterState>(doll), Some(&CharacterState::Ready));
        app.update();
        check_pose(&app, doll, "wave");
    }
    let head = app.world().get::<BezierPaths>(doll).expect("paths").picture().rest_of(0).to_vec();
    let width = head.iter().map(|p| p.x).fold(f32::MIN, f32::max) - head.iter().map(|p| p.x).fold(f32::MAX, f32::min);
    assert!((width - 50.0).abs() < 1e-3, "the new drawing is shown: {width}");
    // A joint that the file has no more is gone.
    let toe = joint(&app, doll, "toe");
    folder.write(FILE, TEXT);
    assert_eq!(until_logged(&mut app), "ready, ready");
    app.update();
    assert!(app.world().get_entity(toe).is_err());
    check_pose(&app, doll, "wave");
}

#[test]
fn broken_files_say_so_at_first() {
    let (mut app, folder) = app();
    folder.write(FILE, &TEXT.replace("follows: [\"neck\"]", "follows: [\"necc\"]"));
    let handle = app.world().resource::<AssetServer>().load(FILE);
    let doll = app.world_mut().spawn(BezierCharacter(handle)).id();
    let said = until_logged(&mut app);
    assert!(said.starts_with("failed: ") && said.contains("necc") && said.contains(FILE), "{said}");
    folder.write(FILE, TEXT);
    // What was written before may be read once more.
    let ready = std::iter::repeat_with(|| until_logged(&mut app)).find(|said| !said.starts_with("failed: "));
    assert_eq!(ready.as_deref(), Some("ready"));
    app.update();
    assert!(app.world().get::<CharacterJoints>(doll).is_some_and(|joints| joints.all().len() == 4));
}

#[test]
fn other_files_and_lost_joints() {
    let (mut app, folder) = app();
    let doll = spawn(&mut app, ());
    play(&mut app, doll, "wave", 0.0);
    app.update();
    let fore = joint(&app, doll, "fore");
    app.world_mut().entity_mut(fore).despawn();
    let sleeve = |app: &App| {
        let paths = app.world().get::<BezierPaths>(doll).expect("paths");
        paths.points_of(paths.picture().path_count() - 1).to_vec()
    };
    for _ in 0..3 {
        app.update();
        assert!(sleeve(&app).iter().all(|p| p.is_finite()));
    }
    // Another file gives it back; the other joints stay.
    let neck = joint(&app, doll, "neck");
    folder.write("two.character.ron", &TEXT.replace("\"doll\"", "\"two\""));
    let two = app.world().resource::<AssetServer>().load("two.character.ron");
    app.world_mut().entity_mut(doll).insert(BezierCharacter(two));
    assert_eq!(until_logged(&mut app), "ready");
    app.update();
    assert_eq!(asset(&app, doll).character().name, "two");
    assert_eq!(joint(&app, doll, "neck"), neck);
    assert_ne!(joint(&app, doll, "fore"), fore);
    check_pose(&app, doll, "wave");
}

#[test]
fn a_world_with_characters_survives_saving_loading_and_cloning() {
    let (mut app, _) = app_playing();
    let world = app.world_mut();
    let everything: Vec<Entity> = world
        .query_filtered::<Entity, Or<(With<BezierCharacter>, With<bevy::animation::AnimatedBy>)>>()
        .iter(world)
        .collect();
    assert_eq!(everything.len(), 5);
    let doll = everything.iter().copied().find(|e| app.world().get::<BezierCharacter>(*e).is_some()).expect("a doll");
    let text = super::worlds::saved(&app, everything);
    let (mut other, _) = super::characters::app();
    other.world_mut().spawn_empty(); // so that entities cannot keep their numbers
    let mut map = EntityHashMap::default();
    let loaded = {
        let registry = other.world().resource::<AppTypeRegistry>().clone();
        let registry = registry.read();
        let mut server = other.world().resource::<AssetServer>().clone();
        let mut ron = ron::de::Deserializer::from_str(&text).expect("RON");
        WorldDeserializer { type_registry: &registry, load_from_path: &mut server }
            .deserialize(&mut ron)
            .expect("deserialises")
    };
    loaded.write_to_world(other.world_mut(), &mut map).expect("spawns");
    let twin = map[&doll];
    assert_eq!(until_logged(&mut other), "ready");
    other.update();
    let joints = |app: &App, entity| app.world().get::<CharacterJoints>(entity).expect("joints").all().to_vec();
    let mapped: Vec<Entity> = joints(&app, doll).iter().map(|joint| map[joint]).collect();
    assert_eq!(joints(&other, twin), mapped, "it takes the joints that were saved");
    assert_eq!(other.world().get::<SplineSkin>(twin).expect("a skin").joints, mapped);
    check_pose(&other, twin, "wave");
    assert!(seek(&other, twin) > 0.2, "it goes on where it was");

    // A clone that goes before it has joints of its own leaves those of the other alone.
    let brief = app.world_mut().entity_mut(doll).clone_and_spawn();
    app.world_mut().despawn(brief);
    app.update();
    assert!(joints(&app, doll).iter().all(|joint| app.world().get_entity(*joint).is_ok()));
    // A clone with what is below it, and one without.
    let whole = app.world_mut().entity_mut(doll).clone_and_spawn_with_opt_out(|builder| {
        builder.linked_cloning(true);
    });
    let bare = app.world_mut().entity_mut(doll).clone_and_spawn();
    app.update();
    app.update();
    let all = [doll, whole, bare].map(|entity| joints(&app, entity));
    for (number, own) in all.iter().enumerate() {
        assert_eq!(own.len(), 4);
        assert!(all.iter().skip(number + 1).flatten().all(|joint| !own.contains(joint)), "each has joints of its own");
        check_pose(&app, [doll, whole, bare][number], "wave");
    }
    let world = app.world_mut();
    assert_eq!(world.query::<&bevy::animation::AnimatedBy>().iter(world).count(), 12, "there are no others");
}

fn app_playing() -> (App, Entity) {
    let (mut app, _) = app();
    let doll = spawn(&mut app, ());
    play(&mut app, doll, "wave", 0.25);
    app.update();
    (app, doll)
}

#[test]
fn what_is_posed_can_be_written() {
    let (mut app, doll) = app_playing();
    app.world_mut().get_mut::<AnimationPlayer>(doll).expect("a player").stop_all();
    let (fore, neck) = (joint(&app, doll, "fore"), joint(&app, doll, "neck"));
    app.world_mut().get_mut::<Transform>(fore).expect("a joint").rotation = Quat::from_rotation_z(3.0);
    app.world_mut().get_mut::<Transform>(neck).expect("a joint").translation += Vec3::new(3.0, -2.0, 0.0);
    app.world_mut().get_mut::<Transform>(neck).expect("a joint").scale = Vec3::new(1.5, 0.5, 1.0);
    app.update();
    let taken = app.world_mut().run_system_once(move |capture: CharacterCapture| {
        (capture.pose(doll).expect("a pose"), capture.with_pose(doll, "hello").expect("a character"))
    });
    let (pose, character) = taken.expect("runs");
    let text = character.to_ron().expect("written");
    let back = Character::parse(FILE, text.as_bytes(), |_| Ok(DRAWING.into())).expect("read back");
    assert_eq!(back.clips.iter().map(|clip| clip.name.as_str()).collect::<Vec<_>>(), ["wave", "nod", "hello"]);
    let mut locals = back.rest_poses();
    back.sample(2, 0.0, &mut locals);
    let off = far(&app, doll, &expected(&back, &bound(&back), &locals));
    assert!(off < 1e-5, "{off}");
    assert!((pose[2].rotation - 3.0).abs() < 1e-5);
    let none = app.world_mut().run_system_once(move |capture: CharacterCapture| capture.pose(fore).is_err());
    assert!(none.expect("runs"), "a joint is no character");
}

#[test]
fn a_thousand_frames_let_no_list_grow() {
    let (mut app, doll) = app_playing();
    let capacity = |app: &App| {
        let handle = &app.world().get::<Mesh3d>(doll).expect("a mesh").0;
        let mesh = app.world().resource::<Assets<Mesh>>().get(handle).expect("an asset");
        let Some(VertexAttributeValues::Float32x3(places)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else { return 0 };
        places.capacity()
    };
    for _ in 0..60 {
        app.update();
    }
    let before = capacity(&app);
    for _ in 0..1000 {
        app.update();
    }
    assert_eq!(capacity(&app), before);
    assert!(app.world().resource::<PathStatistics>().made.paths > 0, "it still moves");
    check_pose(&app, doll, "wave");
}
