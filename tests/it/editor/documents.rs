//! Opening, saving, exporting and placing drawings, as the editor does it.

use std::path::{Path, PathBuf};
use std::time::Duration;

use bevy::prelude::*;
use bevy_surface_splines::editor::{
    AutosaveSettings, CameraPlugin, DocumentFile, DrawingInHand, EditorAction, EditorToolsPlugin, ExportKind,
    FileRequest, FirstModel, FreehandSettings, History, Model, ModelPlugin, Notices, Orbit, Severity, Tool,
};
use bevy_surface_splines::format::document::Document;
use bevy_surface_splines::plugin::SurfaceSplinePlugins;
use bevy_surface_splines::plugin::testing::{Hand, unfinished_headless_app, update_until};
use bevy_surface_splines::prelude::*;

use super::{CENTRE, Studio};

/// A folder that goes with the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("splines-editor-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, text).expect("a file");
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A square of four by four cells, turned towards the camera, moved and scaled.
fn sheet(size: f64) -> String {
    fine_sheet(size, 4)
}

/// The same with so many cells along a side, each of this size.
fn fine_sheet(size: f64, cells: u32) -> String {
    let (mut text, row) = (String::new(), cells + 1);
    for i in 0..row {
        for k in 0..row {
            text += &format!("v {} {} 3\n", 10.0 + size * f64::from(k), -5.0 + size * f64::from(i));
        }
    }
    for i in 0..cells {
        for k in 0..cells {
            let a = row * i + k + 1;
            text += &format!("f {} {} {} {}\n", a, a + 1, a + row + 1, a + row);
        }
    }
    text
}

const SVG: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">
<path id="wave" d="M 10 50 C 30 10 70 90 90 50" stroke="#204060" fill="none"/>
<circle id="dot" cx="50" cy="50" r="20" fill="red"/>
</svg>"##;

/// The whole program without its window.
fn program(first: Option<PathBuf>, settings: AutosaveSettings) -> Studio {
    let mut app = unfinished_headless_app();
    app.insert_resource(FirstModel(first)).insert_resource(settings).add_plugins((
        SurfaceSplinePlugins,
        EditorToolsPlugin,
        ModelPlugin,
        CameraPlugin,
    ));
    app.finish();
    app.cleanup();
    let camera = app.world_mut().spawn(Orbit::default()).id();
    assert!(update_until(&mut app, |world| world.query::<&Model>().iter(world).count() == 1), "the model is there");
    let hand = Hand::new(&mut app).expect("a window");
    let world = app.world_mut();
    let model = world.query_filtered::<Entity, With<Model>>().single(world).expect("a model");
    let mut studio = Studio { app, hand, camera, model };
    studio.strike(KeyCode::Digit1);
    studio.settle();
    studio
}

fn ask(studio: &mut Studio, request: FileRequest) {
    studio.app.world_mut().write_message(request);
    // What is done in the background may begin a frame later, and one thing after the other.
    for _ in 0..3 {
        studio.app.update();
        assert!(update_until(&mut studio.app, |world| world.resource::<DocumentFile>().working().is_none()));
    }
    let world = studio.app.world_mut();
    studio.model = world.query_filtered::<Entity, With<Model>>().single(world).expect("a model");
    studio.settle();
}

fn errors(studio: &Studio) -> Vec<String> {
    let notices = studio.app.world().resource::<Notices>().all();
    notices.iter().filter(|n| n.severity == Severity::Error).map(|n| n.text.clone()).collect()
}

fn is_dirty(studio: &Studio) -> bool {
    studio.app.world().resource::<History>().is_dirty()
}

#[test]
fn a_document_is_saved_opened_and_the_same() {
    let folder = Folder::new("documents");
    let mesh = folder.file("sheet.obj", &sheet(2.0));
    let mut studio = program(Some(mesh.clone()), AutosaveSettings::default());
    studio.draw(&[CENTRE + Vec2::new(-100.0, 0.0), CENTRE, CENTRE + Vec2::new(80.0, 60.0)]);
    assert!(is_dirty(&studio));
    let saved = studio.document();
    let path = folder.0.join("drawing.splines.ron");
    ask(&mut studio, FileRequest::Save);
    assert_eq!(studio.app.world().resource::<DocumentFile>().places_wanted(), 1, "it has no place yet");
    ask(&mut studio, FileRequest::SaveAs(folder.0.join("drawing")));
    assert_eq!(errors(&studio), Vec::<String>::new());
    assert!(path.is_file() && !is_dirty(&studio));
    assert_eq!(studio.app.world().resource::<DocumentFile>().path(), Some(path.as_path()));
    let bytes = std::fs::read(&path).expect("a file");
    let document = Document::open(&path).expect("a document");
    assert_eq!(document.surface.path.as_deref(), Some("sheet.obj"));

    // In another program, which shows another model.
    let mut other = program(None, AutosaveSettings::default());
    ask(&mut other, FileRequest::Open(path.clone()));
    assert_eq!(errors(&other), Vec::<String>::new());
    assert_eq!(other.document(), saved, "opened, it is what was saved");
    assert!(!is_dirty(&other));
    ask(&mut other, FileRequest::Save);
    assert_eq!(std::fs::read(&path).expect("a file"), bytes, "saved again, byte for byte");

    // Unsaved edits are not lost without a question.
    other.draw(&[CENTRE + Vec2::new(-50.0, 80.0), CENTRE + Vec2::new(50.0, 80.0)]);
    let edited = other.document();
    ask(&mut other, FileRequest::Open(path.clone()));
    assert!(other.app.world().resource::<DocumentFile>().question().is_some());
    assert_eq!(other.document(), edited);
    ask(&mut other, FileRequest::Answer(false));
    assert_eq!(other.document(), edited);
    ask(&mut other, FileRequest::Open(path));
    ask(&mut other, FileRequest::Answer(true));
    assert_eq!(other.document(), saved);
}

#[test]
fn what_cannot_be_opened_changes_nothing() {
    let folder = Folder::new("broken");
    let mesh = folder.file("sheet.obj", &sheet(2.0));
    let mut studio = program(Some(mesh), AutosaveSettings::default());
    studio.draw(&[CENTRE + Vec2::new(-100.0, 0.0), CENTRE]);
    let path = folder.0.join("good.splines.ron");
    ask(&mut studio, FileRequest::SaveAs(path.clone()));
    let before = studio.document();
    let good = std::fs::read_to_string(&path).expect("text");
    let half = folder.file("half.splines.ron", &good[..good.len() / 2]);
    let newer = folder.file("newer.splines.ron", &good.replacen("version: 1", "version: 99", 1));
    let forged = folder.file("forged.splines.ron", &good.replacen("1.0), position", "7.5), position", 1));
    for (count, bad) in [half, newer, forged, folder.0.join("missing.splines.ron"), folder.file("no.obj", "v 0 0")]
        .into_iter()
        .enumerate()
    {
        ask(&mut studio, FileRequest::Open(bad.clone()));
        assert!(update_until(&mut studio.app, |world| {
            let notices = world.resource::<Notices>().all();
            notices.iter().filter(|n| n.severity == Severity::Error).count() > count
        }));
        studio.settle();
        assert_eq!(studio.document(), before, "{}", bad.display());
        assert_eq!(errors(&studio).len(), count + 1, "{}: {:?}", bad.display(), errors(&studio));
    }
    // A document without its mesh goes to the nearest places of the model that is there, and says so.
    let small = folder.file("small.obj", &sheet(1.0));
    ask(&mut studio, FileRequest::Open(small));
    assert!(update_until(&mut studio.app, |world| world
        .query::<&Model>()
        .single(world)
        .is_ok_and(|m| m.name == "small.obj")));
    std::fs::remove_file(folder.0.join("sheet.obj")).expect("removed");
    ask(&mut studio, FileRequest::Open(path));
    let notices = studio.app.world().resource::<Notices>().all();
    assert!(notices.iter().any(|n| n.text.contains("nearest places")), "{notices:?}");
    assert!(is_dirty(&studio), "it is not what was saved");
}

#[test]
fn unsaved_edits_are_kept_and_found_again() {
    let folder = Folder::new("autosave");
    let mesh = folder.file("sheet.obj", &sheet(2.0));
    let settings = AutosaveSettings { every: Duration::ZERO, folder: Some(folder.0.clone()), enabled: true };
    let mut studio = program(Some(mesh.clone()), settings.clone());
    studio.draw(&[CENTRE + Vec2::new(-100.0, 0.0), CENTRE]);
    let path = folder.0.join("kept.splines.ron");
    ask(&mut studio, FileRequest::SaveAs(path.clone()));
    studio.draw(&[CENTRE + Vec2::new(-50.0, 80.0), CENTRE + Vec2::new(50.0, 80.0)]);
    let edited = studio.document();
    let autosave = bevy_surface_splines::format::document::Autosave::beside(&path);
    assert!(update_until(&mut studio.app, |_| autosave.recovery().is_some()), "kept");
    drop(studio); // as if it had crashed

    let quiet = AutosaveSettings { enabled: false, ..settings };
    let mut other = program(Some(mesh), quiet);
    ask(&mut other, FileRequest::Open(path.clone()));
    assert!(other.app.world().resource::<DocumentFile>().question().is_some(), "it asks");
    ask(&mut other, FileRequest::Answer(true));
    assert_eq!(errors(&other), Vec::<String>::new());
    assert_eq!(other.document(), edited);
    assert!(is_dirty(&other), "recovered, not saved");
    ask(&mut other, FileRequest::Save);
    assert!(!is_dirty(&other) && autosave.recovery().is_none());
}

/// All numbers of the paths of a drawing, in order.
fn drawing_numbers(svg: &str) -> Vec<f32> {
    let paths = svg.split(" d=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let words = paths.flat_map(|path| path.split(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c))));
    words.filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn a_window_with_unsaved_edits_asks_before_it_closes() {
    use bevy::window::{PrimaryWindow, WindowCloseRequested};
    let folder = Folder::new("closing");
    let settings = AutosaveSettings { every: Duration::from_secs(3600), folder: Some(folder.0.clone()), enabled: true };
    let mut studio = program(None, settings.clone());
    let window = |studio: &mut Studio| {
        let world = studio.app.world_mut();
        world.query_filtered::<Entity, With<PrimaryWindow>>().iter(world).next()
    };
    let close = |studio: &mut Studio| {
        let window = window(studio).expect("a window");
        studio.app.world_mut().write_message(WindowCloseRequested { window });
        studio.app.update();
        studio.app.update();
    };
    studio.draw(&[CENTRE + Vec2::new(-100.0, 0.0), CENTRE]);
    close(&mut studio);
    assert!(studio.app.world().resource::<DocumentFile>().question().is_some() && window(&mut studio).is_some());
    ask(&mut studio, FileRequest::Answer(false));
    assert!(window(&mut studio).is_some(), "it stays");
    // A program that ends without a question keeps them.
    let kept = bevy_surface_splines::format::document::Autosave::in_folder(&folder.0, None);
    studio.app.world_mut().write_message(AppExit::Success);
    studio.app.update();
    assert!(kept.recovery().is_some(), "kept when the program ends");
    // Whoever does not want them loses them.
    close(&mut studio);
    ask(&mut studio, FileRequest::Answer(true));
    assert!(window(&mut studio).is_none() && kept.recovery().is_none());
    // Where all is saved there is no question.
    let settings = AutosaveSettings { enabled: false, ..settings };
    let mut studio = program(None, settings.clone());
    close(&mut studio);
    assert!(window(&mut studio).is_none());
    // Once it is saved, the question has answered itself.
    let mut studio = program(None, settings);
    studio.draw(&[CENTRE + Vec2::new(-100.0, 0.0), CENTRE]);
    close(&mut studio);
    let question = studio.app.world().resource::<DocumentFile>().question().cloned().expect("asked");
    assert!(question.offers_saving());
    let path = folder.0.join("saved_first.splines.ron");
    studio.app.world_mut().write_message(FileRequest::SaveAs(path.clone()));
    assert!(update_until(&mut studio.app, |world| {
        world.query_filtered::<Entity, With<PrimaryWindow>>().iter(world).next().is_none()
    }));
    assert!(path.exists());
}

#[test]
fn drawn_lines_are_saved_and_opened() {
    let folder = Folder::new("lines");
    let mesh = folder.file("sheet.obj", &sheet(2.0));
    let mut studio = program(Some(mesh.clone()), AutosaveSettings::default());
    studio.app.world_mut().resource_mut::<FreehandSettings>().as_line = true;
    studio.strike(KeyCode::KeyN);
    studio.drag(
        &(0..20u8).map(|i| CENTRE + Vec2::new(10.0 * f32::from(i) - 100.0, f32::from(i % 3))).collect::<Vec<_>>(),
    );
    studio.settle();
    let drawn = studio.lines();
    assert_eq!(drawn.len(), 1);
    let path = folder.0.join("lines.splines.ron");
    ask(&mut studio, FileRequest::SaveAs(path.clone()));
    assert_eq!(errors(&studio), Vec::<String>::new());
    let mut other = program(Some(mesh), AutosaveSettings { enabled: false, ..default() });
    ask(&mut other, FileRequest::Open(path));
    assert_eq!(errors(&other), Vec::<String>::new());
    let opened = other.lines();
    assert_eq!(opened.len(), 1);
    assert_eq!((&opened[0].0.name, &opened[0].1, &opened[0].2), (&drawn[0].0.name, &drawn[0].1, &drawn[0].2));
    assert!(!is_dirty(&other));
}

#[test]
fn traces_and_drawings_are_exported() {
    let folder = Folder::new("exports");
    let mut studio = program(None, AutosaveSettings::default());
    let export = |studio: &mut Studio, name: &str| {
        let path = folder.0.join(name);
        ask(studio, FileRequest::Export(path.clone(), ExportKind::Unrolled));
        path
    };
    assert!(!export(&mut studio, "none.obj").exists());
    assert_eq!(errors(&studio).len(), 1, "nothing to export is said");
    studio.draw(&[CENTRE + Vec2::new(-200.0, 0.0), CENTRE + Vec2::new(-160.0, 60.0)]);
    for name in ["lines.obj", "lines.csv", "lines.glb", "drawing.svg"] {
        let path = export(&mut studio, name);
        assert!(std::fs::metadata(&path).is_ok_and(|file| file.len() > 100), "{name}: {:?}", errors(&studio));
    }
    let path = folder.0.join("seen.svg");
    ask(&mut studio, FileRequest::Export(path.clone(), ExportKind::AsSeen));
    let text = std::fs::read_to_string(&path).expect("a drawing");
    // The page has its middle where the window has it, y down, as drawings have it.
    let numbers = drawing_numbers(&text);
    let is_there = |place: Vec2| numbers.windows(2).any(|pair| Vec2::new(pair[0], pair[1]).distance(place) < 1.0);
    assert!(is_there(Vec2::new(-200.0, 0.0)) && is_there(Vec2::new(-160.0, 60.0)), "{text}");
    export(&mut studio, "lines.xyz");
    assert_eq!(errors(&studio).len(), 2, "an unknown format is refused");
}

#[test]
fn what_is_cancelled_changes_nothing() {
    let folder = Folder::new("cancel");
    let mesh = folder.file("sheet.obj", &sheet(2.0));
    let mut studio = program(Some(mesh), AutosaveSettings::default());
    studio.draw(&[CENTRE + Vec2::new(-100.0, 0.0), CENTRE]);
    let path = folder.0.join("there.splines.ron");
    ask(&mut studio, FileRequest::SaveAs(path.clone()));
    let before = studio.document();
    // Large enough that it is not there before it can be cancelled.
    let other = folder.file("other.obj", &fine_sheet(1.0, 250));
    for request in [FileRequest::Open(path), FileRequest::Open(other)] {
        studio.app.world_mut().write_message(request);
        studio.app.update();
        ask(&mut studio, FileRequest::Cancel);
        for _ in 0..50 {
            studio.app.update();
            std::thread::sleep(Duration::from_millis(1));
        }
    }
    assert!(studio.app.world().resource::<DocumentFile>().working().is_none());
    assert_eq!(errors(&studio), Vec::<String>::new());
    assert!(studio.app.world().get::<Model>(studio.model).is_some_and(|model| model.name == "sheet.obj"));
    assert_eq!(studio.document(), before);
}

fn take_drawing(studio: &mut Studio, path: &Path) {
    studio.app.world_mut().write_message(FileRequest::Open(path.to_owned()));
    assert!(update_until(&mut studio.app, |world| world.resource::<DrawingInHand>().name().is_some()));
}

#[test]
fn a_drawing_follows_the_pointer_and_is_placed() {
    let folder = Folder::new("drawings");
    let mesh = folder.file("sheet.obj", &sheet(2.0));
    let svg = folder.file("dot.svg", SVG);
    let mut studio = program(Some(mesh), AutosaveSettings::default());
    take_drawing(&mut studio, &svg);
    assert_eq!(studio.tool(), Tool::Drawing);
    studio.hand.move_to(&mut studio.app, CENTRE);
    studio.app.update();
    let extent = |studio: &Studio| {
        let (_, lines) = studio.app.world().resource::<DrawingInHand>().preview().expect("a preview");
        let xs: Vec<f64> = lines.flatten().map(|p| p.x).collect();
        xs.iter().copied().fold(f64::MIN, f64::max) - xs.iter().copied().fold(f64::MAX, f64::min)
    };
    let before = extent(&studio);
    let camera = *studio.app.world().get::<Transform>(studio.camera).expect("a camera");
    studio.hand.wheel(&mut studio.app, 2.0);
    studio.app.update();
    assert!((extent(&studio) / before - 1.21).abs() < 1e-6, "the wheel scales");
    assert_eq!(*studio.app.world().get::<Transform>(studio.camera).expect("a camera"), camera, "and does not zoom");
    studio.click(CENTRE);
    assert!(update_until(&mut studio.app, |world| world.query::<&SplineTrace>().iter(world).count() == 2));
    studio.settle();
    let document = studio.document();
    assert_eq!(document.iter().map(|(curve, _)| curve.name.as_str()).collect::<Vec<_>>(), ["wave", "dot"]);
    assert!(document[1].1.is_closed());
    assert_eq!(document[0].0.color.to_srgba().to_u8_array()[..3], [0x20, 0x40, 0x60]);
    studio.undo();
    assert!(studio.document().is_empty(), "one entry");
    studio.redo();
    assert_eq!(studio.document(), document);
    // A drag from its middle turns and scales it: the middle of its upper edge follows the pointer.
    let right = CENTRE + Vec2::X * 90.0;
    studio.drag(&[CENTRE, CENTRE + Vec2::X * 30.0, right]);
    assert!(update_until(&mut studio.app, |world| world.query::<&SplineTrace>().iter(world).count() == 4));
    studio.settle();
    let dot = studio.document().swap_remove(3).1;
    let centre = studio.pixel(dot.anchors()[0].point()).midpoint(studio.pixel(dot.anchors()[2].point()));
    assert!(centre.distance(CENTRE) < 1.5, "its middle stays: {centre}");
    studio.undo();
    // What is no drawing is said.
    let empty = folder.file("empty.svg", "<svg xmlns='http://www.w3.org/2000/svg'/>");
    studio.app.world_mut().write_message(FileRequest::Open(empty));
    assert!(update_until(&mut studio.app, |world| world
        .resource::<Notices>()
        .all()
        .iter()
        .any(|n| n.severity == Severity::Error)));
    studio.act(EditorAction::Take(Tool::Select));
}
