//! The panel on top of the tools: whose the pointer is, and what a large drawing costs.

use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_egui::EguiPlugin;
use bevy_surface_splines::curve::{Spline, SplineEdit};
use bevy_surface_splines::editor::{
    CameraPlugin, CurveSpawner, EditorAction, FirstModel, FreeView, Model, ModelPlugin, Notices, Orbit, PanelInput,
    SurfaceSplineEditorPlugin, Tool,
};
use bevy_surface_splines::geodesic::PathFinder;
use bevy_surface_splines::plugin::testing::{Hand, unfinished_headless_app, update_until};
use bevy_surface_splines::plugin::{DebugDrawPlugin, SurfaceSplinePlugins};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::shapes;

use super::Studio;
use crate::plugin::Random;

/// The whole editor, but for the window and the renderer.
fn editor(first: Option<std::path::PathBuf>) -> Studio {
    let mut app = unfinished_headless_app();
    app.insert_resource(FirstModel(first))
        .init_asset::<bevy::shader::Shader>()
        .init_asset::<StandardMaterial>()
        .add_plugins(bevy::diagnostic::FrameTimeDiagnosticsPlugin::default())
        .add_plugins(EguiPlugin::default())
        .add_plugins(SurfaceSplinePlugins.build().disable::<DebugDrawPlugin>())
        .add_plugins((SurfaceSplineEditorPlugin, ModelPlugin, CameraPlugin));
    app.finish();
    app.cleanup();
    let camera = app.world_mut().spawn(Orbit::default()).id();
    assert!(update_until(&mut app, |world| world.query::<&Model>().iter(world).count() == 1), "the model is there");
    let hand = Hand::new(&mut app).expect("a window");
    let world = app.world_mut();
    let model = world.query_filtered::<Entity, With<Model>>().single(world).expect("a model");
    let mut studio = Studio { app, hand, camera, model };
    for _ in 0..10 {
        studio.app.update();
    }
    studio
}

fn free(studio: &Studio) -> Rect {
    studio.app.world().resource::<FreeView>().0.expect("the panel leaves room")
}

#[test]
fn the_panel_and_the_model_do_not_steal_from_each_other() {
    let mut studio = editor(None);
    let free = free(&studio);
    assert!(free.width() > 600.0 && free.max.x < 1280.0 && free.min.x > 0.0, "strip and panel are there: {free:?}");
    let middle = free.center() + Vec2::new(0.0, 90.0);
    // A drag that begins on the panel and ends on the model selects nothing.
    studio.draw(&[middle, middle + Vec2::X * 60.0, middle + Vec2::X * 120.0]);
    studio.app.world_mut().resource_mut::<bevy_surface_splines::editor::Selection>().clear();
    let before = studio.document();
    let on_panel = Vec2::new(free.max.x + 60.0, 400.0);
    studio.drag(&[on_panel, on_panel - Vec2::X * 200.0, middle - Vec2::new(50.0, 50.0), middle + Vec2::splat(50.0)]);
    studio.settle();
    assert!(studio.selection().is_empty());
    assert_eq!(studio.document(), before);
    // Over the panel nothing of the model hovers, and the wheel does not zoom.
    studio.hand.move_to(&mut studio.app, on_panel);
    studio.app.update();
    assert!(studio.app.world().resource::<PanelInput>().pointer);
    let camera = *studio.app.world().get::<Transform>(studio.camera).expect("a camera");
    studio.hand.wheel(&mut studio.app, 3.0);
    studio.app.update();
    assert_eq!(*studio.app.world().get::<Transform>(studio.camera).expect("a camera"), camera);
    // A drag that begins on the model goes on over the panel.
    studio.hand.move_to(&mut studio.app, middle);
    studio.app.update();
    studio.click(middle + Vec2::X * 30.0);
    studio.settle();
    assert!(!studio.selection().is_empty(), "back on the model, a click selects the curve");
    studio.hand.move_to(&mut studio.app, middle);
    studio.hand.press(&mut studio.app, MouseButton::Left);
    for share in [0.02, 0.05, 1.0] {
        studio.hand.move_to(&mut studio.app, middle.lerp(on_panel, share));
    }
    assert!(studio.app.world().resource::<DragState>().dragged().is_some(), "it still holds the anchor");
    studio.hand.release(&mut studio.app, MouseButton::Left);
    studio.settle();
    assert_ne!(studio.document(), before);
}

#[test]
fn tools_are_taken_by_the_strip() {
    let mut studio = editor(None);
    // The drawing tool asks for a file, which covers the strip: it comes last.
    let (last, others): (Vec<_>, Vec<_>) =
        Tool::ALL.into_iter().enumerate().partition(|(_, tool)| *tool == Tool::Drawing);
    for (row, tool) in others.into_iter().chain(last) {
        studio.click(Vec2::new(22.0, 24.0 + 35.0 * row as f32));
        for _ in 0..2 {
            studio.app.update();
        }
        assert_eq!(studio.tool(), tool);
    }
}

#[test]
fn a_game_has_the_panel_without_files() {
    let mut app = unfinished_headless_app();
    app.init_asset::<bevy::shader::Shader>()
        .add_plugins(bevy::diagnostic::FrameTimeDiagnosticsPlugin::default())
        .add_plugins(EguiPlugin::default())
        .add_plugins((SurfaceSplinePlugins, SurfaceSplineEditorPlugin));
    app.finish();
    app.cleanup();
    app.world_mut().spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 3.0)));
    for _ in 0..60 {
        app.update();
    }
    assert!(app.world().resource::<FreeView>().0.is_some());
    app.world_mut().resource_mut::<Notices>().error("said");
    app.update();
}

/// Writes a torus of so many faces as a file.
fn write_torus(path: &std::path::Path, around: u32, across: u32) {
    let torus = shapes::torus(1.0, 0.4, around, across);
    let mut text = String::new();
    torus.positions.iter().for_each(|p| text += &format!("v {} {} {}\n", p.x, p.y, p.z));
    torus.faces.iter().for_each(|f| text += &format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1));
    std::fs::write(path, text).expect("a file");
}

#[test]
fn one_anchor_of_two_thousand_curves_is_dragged() {
    // Where nothing is optimised, a smaller one, and its times mean nothing.
    let (curves, around, across) = if cfg!(debug_assertions) { (100, 150, 60) } else { (2_000, 800, 250) };
    let path = std::env::temp_dir().join(format!("splines-torus-{}.obj", std::process::id()));
    write_torus(&path, around, across);
    let mut studio = editor(Some(path.clone()));
    let _ = std::fs::remove_file(&path);
    let faces = studio.surface().face_count();
    let mut random = Random(5);
    let surface = studio.app.world().get::<BuiltSurface>(studio.model).expect("a surface").0.clone();
    let mut finder = PathFinder::new();
    let radius = 0.02 * surface.diagonal();
    let splines: Vec<Spline> = (0..curves)
        .map(|_| {
            let centre = glam::DVec3::new(random.signed().into(), random.signed().into(), random.signed().into());
            let near = |random: &mut Random| {
                let away = glam::DVec3::new(random.signed().into(), random.signed().into(), random.signed().into());
                surface.closest_point(surface.closest_point(centre).expect("a place").position + radius * away)
            };
            let points: Vec<_> = (0..4).filter_map(|_| Some(near(&mut random)?.point)).collect();
            Spline::smooth_through(&surface, &mut finder, &points, false).expect("a spline")
        })
        .collect();
    let model = studio.model;
    studio.app.world_mut().run_system_cached_with(spawn_all, (model, splines)).expect("spawned");
    assert!(update_until(&mut studio.app, |world| world.query::<&SplineTrace>().iter(world).count() == curves));
    // The curve that is nearest to the eye where its second anchor is seen.
    let free = free(&studio).inflate(-40.0);
    let found = studio.splines().into_iter().find_map(|(entity, spline)| {
        let at = studio.pixel(spline.anchors()[1].point());
        studio.act(EditorAction::Select(entity));
        studio.settle();
        let world = studio.app.world_mut();
        let camera = studio.camera;
        let seen = world
            .run_system_cached_with(
                |In((camera, at)): In<(Entity, Vec2)>, picker: bevy_surface_splines::plugin::Picker| {
                    picker.control_under(camera, at).is_some()
                },
                (camera, at),
            )
            .expect("asked");
        (free.contains(at) && seen).then_some((entity, at))
    });
    let (entity, at) = found.expect("an anchor that is seen");
    studio.hand.move_to(&mut studio.app, at);
    studio.hand.press(&mut studio.app, MouseButton::Left);
    let before = studio.splines().len();
    let mut times: Vec<Duration> = Vec::new();
    for step in 0..200u16 {
        let angle = f32::from(step) * 0.1;
        let to = at + 12.0 * Vec2::from_angle(angle) + Vec2::X * 4.0;
        let begin = Instant::now();
        studio.hand.move_to(&mut studio.app, to);
        times.push(begin.elapsed());
    }
    assert!(studio.app.world().resource::<DragState>().dragged().is_some_and(|grip| grip.spline == entity));
    studio.hand.release(&mut studio.app, MouseButton::Left);
    studio.settle();
    assert_eq!(studio.splines().len(), before);
    times.sort();
    let [median, high] = [100, 197].map(|i| times[i].as_secs_f64() * 1e3);
    println!(
        "{curves} curves on {faces} faces: a frame of a drag takes {median:.2} ms, {high:.2} ms at the 99th percentile"
    );
    // Slack for a busy machine.
    assert!(cfg!(debug_assertions) || median < 8.0, "{median} ms");
}

fn spawn_all(In((model, splines)): In<(Entity, Vec<Spline>)>, mut spawner: CurveSpawner) {
    for spline in splines {
        spawner.spawn(model, None, spline);
    }
}

#[test]
fn gestures_of_the_panel_are_edits_like_all_others() {
    let mut studio = editor(None);
    let middle = free(&studio).center() + Vec2::new(0.0, 90.0);
    studio.draw(&[middle, middle + Vec2::X * 60.0, middle + Vec2::X * 120.0]);
    let (entity, spline) = studio.splines()[0].clone();
    studio.act(EditorAction::Select(entity));
    studio.settle();
    // What the panel's buttons write, written by hand.
    studio.act(EditorAction::SetScheme(Scheme::lane_riesenfeld()));
    studio.settle();
    let now = studio.spline();
    let mut by_code = spline;
    let surface = studio.surface();
    by_code.apply(surface, &mut PathFinder::new(), &SplineEdit::SetScheme(Scheme::lane_riesenfeld())).expect("an edit");
    assert_eq!(now, by_code);
}
