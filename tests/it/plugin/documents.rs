//! Documents as assets, from files: restored, reloaded, in conflict, saved, broken.

use std::fs;
use std::path::{Path, PathBuf};

use bevy::asset::AssetPath;
use bevy::asset::saver::{SavedAsset, save_using_saver};
use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use bevy::tasks::block_on;
use bevy_surface_splines::curve::Spline;
use bevy_surface_splines::format::document::{Document, SurfaceReference};
use bevy_surface_splines::geodesic::PathFinder;
use bevy_surface_splines::plugin::testing::{unfinished_headless_app_with, update_until};
use bevy_surface_splines::plugin::{
    ConflictChoice, DocumentAsset, DocumentConflict, DocumentFailed, DocumentRestored, DocumentSaved, DocumentSaver,
    DocumentState, DocumentedSpline, ResolveConflict, SaveDocument, SplineDocument, SplineDocuments, mesh_from,
    triangle_mesh_from,
};
use bevy_surface_splines::prelude::*;
use bevy_surface_splines::surface::{Surface, SurfaceOptions, shapes};
use glam::DVec3;

const FILE: &str = "planet.splines.ron";

/// What happened, in order.
#[derive(Resource, Default)]
struct Log(Vec<String>);

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("document_assets_{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn mesh(level: u32) -> Mesh {
    mesh_from(&shapes::icosphere(level))
}

/// The surface that the app will build.
fn surface(level: u32) -> Surface {
    Surface::build(&triangle_mesh_from(&mesh(level)).expect("triangles"), &SurfaceOptions::default())
        .expect("a surface")
}

fn spline(surface: &Surface, turn: f64) -> Spline {
    let at = |x: f64, y: f64, z: f64| surface.closest_point(DVec3::new(x, y + turn, z)).expect("a place").point;
    let points = [at(1.0, 0.1, 0.2), at(0.1, 1.0, 0.3), at(-0.2, 0.3, 1.0)];
    Spline::smooth_through(surface, &mut PathFinder::new(), &points, true).expect("a spline")
}

/// A document with a spline for each turn.
fn document(turns: &[f64]) -> Document {
    let surface = surface(3);
    let mut document = Document::new(SurfaceReference::of(&surface).at("planet.obj"));
    for (i, turn) in turns.iter().enumerate() {
        let added = document.add(&surface, format!("orbit {i}"), &spline(&surface, *turn)).expect("a spline");
        (added.hidden, added.locked, added.style.width) = (i == 1, i == 0, 5.0);
    }
    document
}

/// An app with a planet whose document lies in the folder.
fn app(folder: &Path, level: u32) -> (App, Entity) {
    let assets = AssetPlugin { file_path: folder.to_string_lossy().into_owned(), ..default() };
    let mut app = unfinished_headless_app_with(assets);
    app.add_plugins(SurfaceSplinePlugins);
    app.finish();
    app.cleanup();
    app.init_resource::<Log>()
        .add_observer(|event: On<DocumentRestored>, mut log: ResMut<Log>| {
            log.0.push(if event.mapping.is_some() { "mapped" } else { "restored" }.to_owned());
        })
        .add_observer(|_: On<DocumentConflict>, mut log: ResMut<Log>| log.0.push("conflict".to_owned()))
        .add_observer(|_: On<DocumentSaved>, mut log: ResMut<Log>| log.0.push("saved".to_owned()))
        .add_observer(|event: On<DocumentFailed>, mut log: ResMut<Log>| {
            log.0.push(format!("failed: {}", event.reason))
        });
    let document = app.world().resource::<AssetServer>().load(FILE);
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh(level));
    let planet = app.world_mut().spawn((Mesh3d(mesh), SplineSurface::default(), SplineDocument(document))).id();
    (app, planet)
}

fn until_logged(app: &mut App) -> String {
    assert!(update_until(app, |world| !world.resource::<Log>().0.is_empty()), "something happens");
    app.update();
    std::mem::take(&mut app.world_mut().resource_mut::<Log>().0).join(", ")
}

fn reload(app: &mut App) -> String {
    app.world().resource::<AssetServer>().reload(FILE);
    until_logged(app)
}

/// The planet's splines, in order.
fn splines(app: &App, planet: Entity) -> Vec<(Entity, Spline)> {
    let items = app.world().get::<SurfaceItems>(planet).map(|items| items.iter().collect::<Vec<_>>());
    let found = items.unwrap_or_default().into_iter().filter_map(|item| {
        let spline: &SurfaceSpline = app.world().get(item)?;
        Some((item, Spline::clone(spline)))
    });
    found.collect()
}

/// Those of a document, on the surface it was made on.
fn expected(turns: &[f64]) -> Vec<Spline> {
    let surface = surface(3);
    turns.iter().map(|turn| spline(&surface, *turn)).collect()
}

fn only_splines(app: &App, planet: Entity) -> Vec<Spline> {
    splines(app, planet).into_iter().map(|(_, spline)| spline).collect()
}

fn is_unsaved(app: &mut App, planet: Entity) -> bool {
    app.world_mut()
        .run_system_once(move |documents: SplineDocuments| documents.has_unsaved_edits(planet))
        .expect("runs")
}

fn edit(app: &mut App, planet: Entity) {
    let (entity, _) = splines(app, planet).remove(0);
    app.world_mut().write_message(EditSpline::new(entity, SplineEdit::Reverse));
    app.update();
}

#[test]
fn a_document_appears_and_follows_its_file() {
    let folder = folder("follows");
    document(&[0.0, 0.2]).save(folder.join(FILE)).expect("saved");
    let (mut app, planet) = app(&folder, 3);
    assert_eq!(app.world().get::<DocumentState>(planet), Some(&DocumentState::Pending));
    assert_eq!(until_logged(&mut app), "restored");
    assert_eq!(app.world().get::<DocumentState>(planet), Some(&DocumentState::Ready));
    assert_eq!(only_splines(&app, planet), expected(&[0.0, 0.2]), "bit for bit");
    let entities: Vec<Entity> = splines(&app, planet).iter().map(|(entity, _)| *entity).collect();
    for (i, entity) in entities.iter().enumerate() {
        assert_eq!(app.world().get::<Name>(*entity).map(Name::as_str), Some(format!("orbit {i}").as_str()));
        let part = app.world().get::<DocumentedSpline>(*entity).expect("a part of the document");
        assert_eq!((part.locked, part.style.width), (i == 0, 5.0));
        assert_eq!(app.world().get::<Visibility>(*entity) == Some(&Visibility::Hidden), i == 1);
        assert_eq!(app.world().get::<SplineState>(*entity), Some(&SplineState::Ready));
    }
    assert!(!is_unsaved(&mut app, planet));
    // More splines, others, fewer.
    for turns in [&[0.0, 0.3, 0.5][..], &[0.4], &[0.0, 0.2]] {
        document(turns).save(folder.join(FILE)).expect("saved");
        assert_eq!(reload(&mut app), "restored");
        assert_eq!(only_splines(&app, planet), expected(turns));
        assert_eq!(splines(&app, planet)[0].0, entities[0], "entities stay");
        assert!(!is_unsaved(&mut app, planet));
    }
}

#[test]
fn unsaved_edits_are_never_lost_silently() {
    let folder = folder("conflict");
    document(&[0.0, 0.2]).save(folder.join(FILE)).expect("saved");
    let (mut app, planet) = app(&folder, 3);
    assert_eq!(until_logged(&mut app), "restored");
    edit(&mut app, planet);
    let mine = only_splines(&app, planet);
    assert_ne!(mine, expected(&[0.0, 0.2]));
    assert!(is_unsaved(&mut app, planet));
    for choice in [ConflictChoice::KeepMine, ConflictChoice::TakeTheirs] {
        document(&[0.5]).save(folder.join(FILE)).expect("saved");
        assert_eq!(reload(&mut app), "conflict");
        assert_eq!(app.world().get::<DocumentState>(planet), Some(&DocumentState::Conflict));
        assert_eq!(only_splines(&app, planet), mine, "nothing was changed");
        for _ in 0..5 {
            app.update();
        }
        assert_eq!(only_splines(&app, planet), mine);
        app.world_mut().write_message(ResolveConflict { surface: planet, choice });
        app.update();
        app.update();
        assert_eq!(app.world().get::<DocumentState>(planet), Some(&DocumentState::Ready));
        let is_mine = choice == ConflictChoice::KeepMine;
        assert_eq!(only_splines(&app, planet), if is_mine { mine.clone() } else { expected(&[0.5]) });
        assert_eq!(is_unsaved(&mut app, planet), is_mine);
        app.world_mut().resource_mut::<Log>().0.clear();
    }
    // Taken theirs, the file leads again.
    document(&[0.1]).save(folder.join(FILE)).expect("saved");
    assert_eq!(reload(&mut app), "restored");
    assert_eq!(only_splines(&app, planet), expected(&[0.1]));
    // A spline that was removed, one that was added and one that was renamed are edits too.
    let entity = splines(&app, planet)[0].0;
    app.world_mut().entity_mut(entity).insert(Name::new("another"));
    assert!(is_unsaved(&mut app, planet));
    assert_eq!(reload(&mut app), "conflict");
    app.world_mut().despawn(entity);
    assert!(is_unsaved(&mut app, planet));
}

#[test]
fn what_is_saved_is_no_conflict() {
    let folder = folder("saved");
    let path = folder.join(FILE);
    document(&[0.0, 0.2]).save(&path).expect("saved");
    let (mut app, planet) = app(&folder, 3);
    assert_eq!(until_logged(&mut app), "restored");
    edit(&mut app, planet);
    let extra = spline(&surface(3), 0.7);
    app.world_mut().spawn((OnSurface(planet), SurfaceSpline::new(extra.clone()), DocumentedSpline::default()));
    app.world_mut().spawn((OnSurface(planet), SurfaceSpline::new(extra))); // not a part of the document
    app.update();
    let mine = only_splines(&app, planet);
    app.world_mut().write_message(SaveDocument { surface: planet, path: path.clone() });
    assert_eq!(until_logged(&mut app), "saved");
    assert!(!is_unsaved(&mut app, planet));
    let saved = Document::open(&path).expect("a document");
    assert_eq!((saved.splines.len(), saved.surface.path.as_deref()), (3, Some("planet.obj")));
    assert_eq!((saved.splines[1].hidden, saved.splines[0].locked, saved.splines[2].name.as_str()), (true, true, ""));
    let restored = saved.restore(&surface(3), &mut PathFinder::new()).expect("restored");
    assert_eq!(restored.splines.into_iter().flatten().collect::<Vec<_>>(), mine[..3]);
    assert_eq!(reload(&mut app), "restored");
    assert_eq!(only_splines(&app, planet), mine);
    // Where nothing can be saved, everything stays as it is.
    edit(&mut app, planet);
    let bytes = fs::read(&path).expect("the file");
    app.world_mut().write_message(SaveDocument { surface: planet, path: path.join("no") });
    let said = until_logged(&mut app);
    assert!(said.starts_with("failed: ") && said.contains("was not saved"), "{said}");
    assert!(is_unsaved(&mut app, planet) && fs::read(&path).expect("the file") == bytes);
}

#[test]
fn broken_files_change_nothing() {
    let folder = folder("broken");
    let path = folder.join(FILE);
    let sound = document(&[0.0, 0.2]);
    sound.save(&path).expect("saved");
    let (mut app, planet) = app(&folder, 3);
    assert_eq!(until_logged(&mut app), "restored");
    let text = fs::read_to_string(&path).expect("a text");
    for (from, to, named) in [
        ("version: 1", "version: 2", "newer program"),
        ("closed: true", "closed: maybe", "splines[0].geometry.closed"),
        ("length: ", "length: 1", "spline 0 (`orbit 0`)"),
    ] {
        fs::write(&path, text.replacen(from, to, 1)).expect("written");
        let said = reload(&mut app);
        assert!(said.starts_with("failed: ") && said.contains(named), "{said}");
        assert_eq!(only_splines(&app, planet), expected(&[0.0, 0.2]));
    }
    fs::write(&path, text).expect("written");
    assert_eq!(reload(&mut app), "restored");
    assert_eq!(app.world().get::<DocumentState>(planet), Some(&DocumentState::Ready));
}

#[test]
fn a_document_of_another_mesh_is_mapped() {
    let folder = folder("mapped");
    document(&[0.0, 0.2]).save(folder.join(FILE)).expect("saved");
    let (mut app, planet) = app(&folder, 4);
    assert_eq!(until_logged(&mut app), "mapped");
    let (before, after) = (expected(&[0.0, 0.2]), only_splines(&app, planet));
    let (coarse, fine) = (surface(3), surface(4));
    assert_eq!(after.len(), 2);
    for (a, b) in before.iter().zip(&after).flat_map(|(a, b)| a.anchors().iter().zip(b.anchors())) {
        assert!(coarse.position(&a.point()).distance(fine.position(&b.point())) < 0.01);
    }
    assert!(!is_unsaved(&mut app, planet));
    assert_eq!(reload(&mut app), "mapped");
}

#[test]
fn the_engines_saver_writes_what_its_loader_reads() {
    let folder = folder("saver");
    let other = document(&[0.3]);
    let (mut app, planet) = app(&folder, 3);
    let said = until_logged(&mut app);
    assert!(said.starts_with("failed: "), "there is no file yet: {said}");
    assert!(matches!(app.world().get::<DocumentState>(planet), Some(DocumentState::Failed { .. })));
    let asset = DocumentAsset(other.clone());
    let server = app.world().resource::<AssetServer>().clone();
    let path = AssetPath::parse(FILE);
    block_on(save_using_saver(server, &DocumentSaver, &path, SavedAsset::from_asset(&asset), &())).expect("saved");
    assert_eq!(Document::open(folder.join(FILE)).expect("a document"), other);
    assert_eq!(reload(&mut app), "restored");
    assert_eq!(only_splines(&app, planet), expected(&[0.3]));
}
