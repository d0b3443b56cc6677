//! Drawn lines in the editor: drawing, smoothing, the brush, and what becomes of them.

use bevy::prelude::*;
use bevy_surface_splines::editor::{BrushSettings, Curve, EditorAction, FreehandSettings, History, Tool};
use bevy_surface_splines::plugin::testing::update_until;
use bevy_surface_splines::prelude::*;

use super::{CENTRE, Studio};

fn at(x: f32, y: f32) -> Vec2 {
    CENTRE + Vec2::new(x, y)
}

/// A line that trembles, from left to right.
fn trembling() -> Vec<Vec2> {
    (0..60u8).map(|i| at(-180.0 + 6.0 * f32::from(i), if i % 2 == 0 { 8.0 } else { -8.0 })).collect()
}

/// A studio with a fine sphere, on which a trembling line was drawn.
fn with_line() -> Studio {
    let mut studio = Studio::with_mesh(Sphere::new(1.0).mesh().ico(24).expect("a sphere"));
    studio.app.world_mut().resource_mut::<FreehandSettings>().as_line = true;
    studio.strike(KeyCode::KeyN);
    studio.drag(&trembling());
    studio.settle();
    assert_eq!(studio.lines().len(), 1);
    studio
}

fn shown(studio: &mut Studio) -> SmoothedLine {
    let world = studio.app.world_mut();
    world.query::<&SmoothedLine>().single(world).expect("a line").clone()
}

#[test]
fn drawn_lines_stay_lines_and_are_smoothed_by_a_slider() {
    let mut studio = with_line();
    let drawn = studio.lines();
    let first = shown(&mut studio);
    assert!(first.after.total_turn < 0.2 * first.before.total_turn, "smoothed from the start");
    assert_eq!(studio.names()[0].as_deref(), Some("Draw by hand"));
    // The way of a slider is one entry.
    for closeness in [20.0, 50.0, 200.0] {
        studio.act(EditorAction::SlideSmoothing(LineSmoothing::tether(closeness)));
        studio.app.update();
    }
    studio.act(EditorAction::EndSlide);
    studio.settle();
    let closer = shown(&mut studio);
    assert!(closer.after.max_distance < first.after.max_distance, "a closer tether keeps it nearer");
    assert_eq!(studio.lines()[0].2, Some(LineSmoothing::tether(200.0)));
    assert!(studio.app.world().resource::<History>().is_dirty());
    studio.undo();
    assert_eq!(studio.lines(), drawn);
    studio.app.update();
    assert_eq!(shown(&mut studio).polyline(), first.polyline(), "and so is what is shown, bit for bit");
    studio.redo();
    assert_eq!(studio.lines()[0].2, Some(LineSmoothing::tether(200.0)));
    // Switched off, it is as it was drawn.
    studio.act(EditorAction::SetSmoothing(None));
    studio.settle();
    let off = shown(&mut studio);
    assert_eq!(off.polyline(), off.drawn_polyline());
    for _ in 0..3 {
        studio.undo();
    }
    assert!(studio.lines().is_empty(), "the line itself is undone");
    studio.redo();
    assert_eq!(studio.lines(), drawn);
}

#[test]
fn the_brush_smooths_where_it_is_dragged() {
    let mut studio = with_line();
    studio.act(EditorAction::SetSmoothing(None));
    studio.settle();
    let before = studio.lines();
    let rough = shown(&mut studio);
    studio.strike(KeyCode::KeyB);
    assert_eq!(studio.tool(), Tool::Brush);
    *studio.app.world_mut().resource_mut::<BrushSettings>() =
        BrushSettings { radius: 40.0, strength: 1.0, closeness: 1.0 };
    studio.drag(&[at(60.0, 0.0), at(80.0, 0.0), at(100.0, 0.0), at(120.0, 0.0)]);
    studio.settle();
    let brushed = shown(&mut studio);
    assert!(brushed.before.total_turn < 0.9 * rough.before.total_turn, "smoother than before");
    // The left half is as it was, to the last bit.
    let left = |line: &SmoothedLine| line.polyline().iter().filter(|p| p.x < -0.1).copied().collect::<Vec<_>>();
    assert!(left(&rough).len() > 10, "{} places", left(&rough).len());
    assert_eq!(left(&brushed), left(&rough));
    assert_eq!(studio.names()[0].as_deref(), Some("Brush"));
    let after = studio.lines();
    studio.undo();
    assert_eq!(studio.lines(), before, "a stroke is one entry");
    studio.redo();
    assert_eq!(studio.lines(), after);
    // Escape takes a stroke back.
    studio.undo();
    studio.hand.move_to(&mut studio.app, at(60.0, 0.0));
    studio.hand.press(&mut studio.app, MouseButton::Left);
    studio.hand.move_to(&mut studio.app, at(80.0, 0.0));
    studio.hand.move_to(&mut studio.app, at(100.0, 0.0));
    studio.strike(KeyCode::Escape);
    studio.hand.release(&mut studio.app, MouseButton::Left);
    studio.settle();
    assert_eq!(studio.lines(), before);
}

#[test]
fn lines_are_selected_deleted_and_become_splines() {
    let mut studio = with_line();
    let before = studio.lines();
    let entity = before[0].3;
    studio.strike(KeyCode::KeyV);
    studio.click(at(0.0, -250.0));
    assert!(studio.selection().is_empty());
    studio.click(CENTRE);
    assert_eq!(studio.selection().splines(), [entity]);
    studio.strike(KeyCode::Delete);
    studio.settle();
    assert!(studio.lines().is_empty());
    studio.undo();
    assert_eq!(studio.lines(), before);
    // To a spline, and to a line again.
    studio.act(EditorAction::Select(entity));
    studio.act(EditorAction::ToSplines);
    assert!(update_until(&mut studio.app, |world| world.query::<&SplineTrace>().iter(world).count() == 1));
    studio.settle();
    assert!(studio.lines().is_empty());
    let (spline, _) = studio.splines()[0].clone();
    assert_eq!(studio.app.world().get::<Curve>(spline).expect("a curve").name, before[0].0.name, "it keeps its name");
    studio.act(EditorAction::Select(spline));
    studio.act(EditorAction::ToLines);
    studio.settle();
    assert_eq!((studio.lines().len(), studio.splines().len()), (1, 0));
    studio.undo();
    assert_eq!((studio.lines().len(), studio.splines().len()), (0, 1));
    studio.undo();
    assert_eq!(studio.lines(), before, "and back to what was drawn");
}
