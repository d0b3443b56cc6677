//! Every tool by pointer and keys.

use bevy::prelude::*;
use bevy_surface_splines::curve::HandleSide;
use bevy_surface_splines::editor::{EditorAction, Tool};
use bevy_surface_splines::prelude::*;

use super::{CENTRE, Studio};

fn at(x: f32, y: f32) -> Vec2 {
    CENTRE + Vec2::new(x, y)
}

#[test]
fn the_pen_draws_corners_and_closes() {
    let mut studio = Studio::with_sphere();
    studio.strike(KeyCode::KeyP);
    assert_eq!(studio.tool(), Tool::Pen);
    for place in [at(-100.0, 0.0), at(0.0, -80.0), at(100.0, 0.0)] {
        studio.click(place);
    }
    let spline = studio.spline();
    assert_eq!(spline.anchors().len(), 3);
    assert!(spline.anchors().iter().all(|anchor| anchor.join() == Join::Corner));
    for (anchor, place) in spline.anchors().iter().zip([at(-100.0, 0.0), at(0.0, -80.0), at(100.0, 0.0)]) {
        assert!(studio.pixel(anchor.point()).distance(place) < 0.1);
    }
    studio.click(at(-100.0, 0.0));
    assert!(studio.spline().is_closed(), "a click on the first anchor closes");
    studio.settle();
    assert_eq!(studio.names()[0].as_deref(), Some("Close of Curve 1"));
    studio.strike(KeyCode::Escape);
    assert_eq!(studio.tool(), Tool::Select);
}

#[test]
fn the_pen_pulls_handles() {
    let mut studio = Studio::with_plane();
    studio.strike(KeyCode::KeyP);
    studio.drag(&[at(-100.0, 0.0), at(-80.0, -20.0), at(-60.0, -60.0)]);
    assert!(studio.splines().is_empty(), "one point is no spline yet");
    studio.drag(&[at(100.0, 0.0), at(110.0, 20.0), at(130.0, 50.0)]);
    studio.settle();
    let spline = studio.spline();
    let [first, second] = spline.anchors() else { panic!("two anchors") };
    assert_eq!((first.join(), second.join()), (Join::Mirrored, Join::Mirrored));
    assert!(studio.pixel(first.outgoing().point()).distance(at(-60.0, -60.0)) < 0.5);
    assert!(studio.pixel(second.outgoing().point()).distance(at(130.0, 50.0)) < 0.5);
    assert!(studio.pixel(second.incoming().point()).distance(at(70.0, -50.0)) < 0.5, "the partner is mirrored");
    assert_eq!(studio.names()[0].as_deref(), Some("Draw smooth anchor"), "one gesture, one entry");
    // A click on the last anchor cuts its handle.
    studio.click(at(100.0, 0.0));
    let spline = studio.spline();
    assert_eq!(spline.anchors()[1].join(), Join::Corner);
    assert_eq!(spline.anchors()[1].outgoing().leg().length(), 0.0);
    assert!(spline.anchors()[1].incoming().leg().length() > 0.0);
    for _ in 0..2 {
        studio.undo();
    }
    assert!(studio.splines().is_empty(), "undone as a whole");
}

#[test]
fn escape_takes_a_pull_back() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-100.0, 0.0), at(0.0, 0.0)]);
    let before = studio.document();
    studio.strike(KeyCode::KeyP);
    studio.hand.move_to(&mut studio.app, at(90.0, 0.0));
    studio.hand.press(&mut studio.app, MouseButton::Left);
    studio.hand.move_to(&mut studio.app, at(120.0, 30.0));
    studio.hand.move_to(&mut studio.app, at(130.0, 60.0));
    studio.strike(KeyCode::Escape);
    studio.hand.release(&mut studio.app, MouseButton::Left);
    studio.settle();
    assert_eq!(studio.document(), before);
    assert_eq!(studio.names(), [Some("Add spline".to_string()), None], "nothing to undo came of it");
}

#[test]
fn select_by_click_shift_and_box() {
    let mut studio = Studio::with_sphere();
    studio.draw(&[at(-150.0, -50.0), at(-50.0, -120.0), at(30.0, -60.0)]);
    studio.draw(&[at(-150.0, 60.0), at(-50.0, 120.0), at(60.0, 80.0)]);
    let [(first, _), (second, _)] = studio.splines()[..] else { panic!("two splines") };
    studio.click(at(200.0, 0.0));
    assert!(studio.selection().is_empty(), "a click on the bare surface selects nothing");
    studio.click(at(-150.0, -50.0));
    assert_eq!(studio.selection().splines(), [first], "a click on an end of a curve selects it");
    studio.click(at(-150.0, -50.0));
    assert_eq!(studio.selection().anchors(), [(first, 0)], "now that its anchors are there, the anchor");
    studio.hand.hold(&mut studio.app, KeyCode::ShiftLeft);
    studio.click(at(-50.0, 120.0));
    studio.hand.let_go(&mut studio.app, KeyCode::ShiftLeft);
    assert_eq!(studio.selection().splines(), [first, second], "Shift adds");
    studio.drag(&[at(-200.0, -170.0), at(0.0, 0.0), at(80.0, 150.0)]);
    assert_eq!(studio.selection().anchors().len(), 6, "a box from the bare surface");
    studio.control(KeyCode::KeyA);
    assert_eq!(studio.selection().splines(), [first, second]);
    studio.strike(KeyCode::Delete);
    studio.settle();
    assert!(studio.splines().is_empty());
    studio.undo();
    assert_eq!(studio.splines().len(), 2);
}

#[test]
fn insert_and_delete_anchors() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, 0.0), at(150.0, 0.0)]);
    studio.strike(KeyCode::KeyI);
    studio.click(at(20.0, 0.0));
    studio.settle();
    let spline = studio.spline();
    assert_eq!(spline.anchors().len(), 3);
    assert!(studio.pixel(spline.anchors()[1].point()).distance(at(20.0, 0.0)) < 1.0);
    assert_eq!(studio.selection().anchor(), Some(1), "the new one is selected");
    studio.strike(KeyCode::KeyX);
    studio.settle();
    assert_eq!(studio.spline().anchors().len(), 2);
    studio.undo();
    assert_eq!(studio.spline().anchors().len(), 3);
}

#[test]
fn joins_cycle_by_tool_and_key() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, 0.0), at(0.0, -80.0), at(150.0, 0.0)]);
    let (entity, _) = studio.splines()[0].clone();
    studio.act(EditorAction::Select(entity));
    studio.strike(KeyCode::KeyC);
    assert_eq!(studio.tool(), Tool::Join, "without an anchor C is a tool");
    let mut seen = Vec::new();
    for _ in 0..4 {
        studio.click(at(0.0, -80.0));
        studio.settle();
        seen.push(studio.spline().anchors()[1].join());
    }
    assert_eq!(seen, [Join::Smooth, Join::Mirrored, Join::Automatic, Join::Corner]);
    studio.strike(KeyCode::KeyV);
    studio.strike(KeyCode::KeyC);
    studio.settle();
    assert_eq!(studio.spline().anchors()[1].join(), Join::Smooth);
}

#[test]
fn split_join_reverse_close_and_segments() {
    let mut studio = Studio::with_plane();
    let places = [at(-150.0, 0.0), at(-50.0, -80.0), at(50.0, 0.0), at(150.0, -80.0)];
    studio.draw(&places);
    let whole = studio.document();
    let (entity, _) = studio.splines()[0].clone();
    let select = |studio: &mut Studio, place: Vec2| {
        studio.act(EditorAction::Select(entity));
        studio.settle();
        studio.click(place);
    };
    select(&mut studio, places[2]);
    studio.strike(KeyCode::KeyK);
    studio.settle();
    let counts = |studio: &mut Studio| studio.splines().iter().map(|(_, s)| s.anchors().len()).collect::<Vec<_>>();
    assert_eq!(counts(&mut studio), [3, 2], "split at the third anchor");
    studio.control(KeyCode::KeyA);
    studio.strike(KeyCode::KeyJ);
    studio.settle();
    assert_eq!(counts(&mut studio), [4], "joined at the ends that are in one place");
    studio.undo();
    assert_eq!(counts(&mut studio), [3, 2]);
    studio.undo();
    assert_eq!(studio.document(), whole);
    select(&mut studio, places[1]);
    studio.shift(KeyCode::KeyX);
    studio.settle();
    assert_eq!(counts(&mut studio), [2, 2], "the segment in the middle is gone");
    studio.undo();
    assert_eq!(studio.document(), whole);
    select(&mut studio, places[0]);
    studio.shift(KeyCode::KeyR);
    studio.settle();
    let first = studio.spline().anchors()[0].point();
    assert!(studio.pixel(first).distance(places[3]) < 0.1, "reversed");
    studio.undo();
    studio.strike(KeyCode::KeyO);
    studio.settle();
    assert!(studio.spline().is_closed());
    select(&mut studio, places[1]);
    studio.strike(KeyCode::KeyO);
    studio.settle();
    assert!(!studio.spline().is_closed());
    assert_eq!(studio.spline().anchors().len(), 5, "opened where it then begins and ends");
}

#[test]
fn hidden_and_locked_curves_are_left_alone() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, 0.0), at(150.0, 0.0)]);
    let (entity, _) = studio.splines()[0].clone();
    let curve = studio.document()[0].0.clone();
    for (hidden, locked) in [(true, false), (false, true)] {
        let changed = bevy_surface_splines::editor::Curve { hidden, locked, ..curve.clone() };
        studio.act(EditorAction::Restyle(entity, changed));
        studio.settle();
        assert!(studio.selection().is_empty());
        studio.click(at(0.0, 0.0));
        assert!(studio.selection().is_empty(), "hidden {hidden}, locked {locked}");
        studio.control(KeyCode::KeyA);
        assert!(studio.selection().is_empty());
        studio.undo();
        assert_eq!(studio.document()[0].0, curve);
    }
    studio.click(at(0.0, 0.0));
    assert_eq!(studio.selection().splines(), [entity]);
}

#[test]
fn a_second_click_takes_what_is_behind() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, 0.0), at(150.0, 0.0)]);
    studio.draw(&[at(0.0, -150.0), at(0.0, 150.0)]);
    studio.click(at(200.0, 200.0));
    let mut seen = Vec::new();
    for _ in 0..3 {
        studio.click(at(0.0, 0.0));
        seen.push(studio.selection().spline());
    }
    assert!(seen[0].is_some() && seen[0] != seen[1] && seen[0] == seen[2], "{seen:?}");
}

#[test]
fn handles_are_dragged_in_one_go() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, 0.0), at(0.0, -80.0), at(150.0, 0.0)]);
    let (entity, _) = studio.splines()[0].clone();
    studio.act(EditorAction::Select(entity));
    studio.settle();
    studio.click(at(0.0, -80.0));
    studio.act(EditorAction::SetJoin(Join::Smooth));
    studio.settle();
    let handle = studio.spline().anchors()[1].handle(HandleSide::Outgoing).point();
    let from = studio.pixel(handle);
    studio.drag(&[from, from + Vec2::new(10.0, 20.0), from + Vec2::new(20.0, 40.0)]);
    studio.settle();
    let moved = studio.spline().anchors()[1].handle(HandleSide::Outgoing).point();
    assert!(studio.pixel(moved).distance(from + Vec2::new(20.0, 40.0)) < 0.5);
    assert_eq!(studio.names()[0].as_deref(), Some("Move handle of anchor 2 of Curve 1"));
}
