//! Every tool by pointer and keys.

use bevy::prelude::*;
use bevy_surface_splines::curve::HandleSide;
use bevy_surface_splines::editor::{EditorAction, Tool};
use bevy_surface_splines::plugin::testing::update_until;
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

/// Where the anchors of the only spline are seen.
fn anchor_pixels(studio: &mut Studio) -> Vec<Vec2> {
    let spline = studio.spline();
    spline.anchors().iter().map(|anchor| studio.pixel(anchor.point())).collect()
}

fn assert_near(seen: &[Vec2], wanted: &[Vec2], slack: f32) {
    assert_eq!(seen.len(), wanted.len());
    let apart = seen.iter().zip(wanted).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(apart < slack, "{seen:?} instead of {wanted:?}");
}

#[test]
fn what_is_selected_is_moved_turned_and_scaled() {
    let mut studio = Studio::with_plane();
    let places = [at(-100.0, 0.0), at(0.0, -60.0), at(60.0, 20.0)];
    studio.draw(&places);
    let before = studio.document();
    let (entity, _) = studio.splines()[0].clone();
    // A drag of the curve moves it all.
    studio.act(EditorAction::Select(entity));
    studio.settle();
    let middle = places[0].lerp(places[1], 0.5);
    let shift = Vec2::new(40.0, 30.0);
    studio.drag(&[middle, middle + 0.5 * shift, middle + shift]);
    studio.settle();
    assert_near(&anchor_pixels(&mut studio), &places.map(|p| p + shift), 1.5);
    assert_eq!(studio.names()[0].as_deref(), Some("Move selection"));
    studio.undo();
    assert_eq!(studio.document(), before);
    // R turns about the active anchor by what is typed.
    studio.act(EditorAction::Select(entity));
    studio.settle();
    studio.click(places[0]);
    studio.control(KeyCode::KeyA);
    studio.hand.move_to(&mut studio.app, at(200.0, 100.0));
    studio.hand.move_to(&mut studio.app, places[0]);
    studio.strike(KeyCode::KeyR);
    studio.hand.write(&mut studio.app, '9');
    studio.hand.write(&mut studio.app, '0');
    studio.strike(KeyCode::Enter);
    studio.settle();
    // Counter-clockwise on the screen, whose y goes down, about the place under the pointer.
    let turned = places.map(|p| places[0] + Vec2::new((p - places[0]).y, -(p - places[0]).x));
    assert_near(&anchor_pixels(&mut studio), &turned, 1.0);
    studio.undo();
    // S scales as the pointer goes away from the centre; Escape takes it back.
    studio.hand.move_to(&mut studio.app, at(0.0, 100.0));
    studio.strike(KeyCode::KeyS);
    studio.app.update();
    studio.hand.move_to(&mut studio.app, at(80.0, 100.0));
    assert_ne!(studio.document(), before, "it follows the pointer");
    studio.strike(KeyCode::Escape);
    studio.settle();
    assert_eq!(studio.document(), before);
    assert_eq!(studio.tool(), Tool::Select);
    // Of several selected anchors all follow the one that is dragged.
    studio.drag(&[at(-150.0, -100.0), at(-20.0, -40.0), at(30.0, 10.0)]);
    assert_eq!(studio.selection().anchors().len(), 2, "the first two are in the box");
    studio.drag(&[places[1], places[1] + Vec2::Y * 20.0, places[1] + Vec2::Y * 40.0]);
    studio.settle();
    let down = Vec2::Y * 40.0;
    assert_near(&anchor_pixels(&mut studio), &[places[0] + down, places[1] + down, places[2]], 1.0);
}

#[test]
fn freehand_lines_become_splines() {
    let mut studio = Studio::with_sphere();
    studio.strike(KeyCode::KeyN);
    assert_eq!(studio.tool(), Tool::Freehand);
    let wave: Vec<Vec2> =
        (0..40u8).map(|i| at(-150.0 + 7.5 * f32::from(i), 60.0 * (f32::from(i) * 0.2).sin())).collect();
    studio.drag(&wave);
    assert!(update_until(&mut studio.app, |world| { world.query::<&SplineTrace>().iter(world).count() == 1 }));
    studio.settle();
    let spline = studio.spline();
    assert!(!spline.is_closed() && (2..=8).contains(&spline.anchors().len()), "{} anchors", spline.anchors().len());
    // Every place of the line is near the curve.
    let world = studio.app.world_mut();
    let trace = world.query::<&SplineTrace>().single(world).expect("a trace").trace().clone();
    let tolerance = 0.004 * studio.surface().diagonal();
    let half_a_pixel = 0.002;
    for place in &wave {
        let ray = studio.app.world().get::<Camera>(studio.camera).expect("a camera");
        let transform = studio.app.world().get::<GlobalTransform>(studio.camera).expect("a place");
        let ray = ray.viewport_to_world(transform, *place).expect("a ray");
        let hit = studio.surface().ray(ray.origin.as_dvec3(), ray.direction.as_dvec3()).expect("a hit");
        let nearest = trace.nearest(studio.surface(), hit.position).expect("a place");
        assert!(nearest.distance < tolerance + half_a_pixel, "{} from the line", nearest.distance);
    }
    // A smaller tolerance takes more anchors, as long as nothing else was clicked.
    let before = spline.anchors().len();
    studio.app.world_mut().resource_mut::<bevy_surface_splines::editor::FreehandSettings>().tolerance = 0.0002;
    let more = |world: &mut World| {
        let spline = world.query::<&SurfaceSpline>().single(world).expect("a spline");
        spline.anchors().len() > before
    };
    assert!(update_until(&mut studio.app, more), "more anchors within a smaller tolerance");
    // A line that ends where it began is closed.
    let ring: Vec<Vec2> = (0..=40u8)
        .map(|i| at(0.0, 0.0) + 120.0 * Vec2::from_angle(f32::from(i) / 40.0 * std::f32::consts::TAU))
        .collect();
    studio.drag(&ring);
    assert!(update_until(&mut studio.app, |world| { world.query::<&SplineTrace>().iter(world).count() == 2 }));
    assert!(studio.splines()[1].1.is_closed());
    // Of lines drawn faster than they are fitted none is lost.
    for y in [-200.0, -170.0, -140.0] {
        let line: Vec<Vec2> = (0..8u8).map(|i| at(-80.0 + 20.0 * f32::from(i), y)).collect();
        studio.drag(&line);
    }
    assert!(update_until(&mut studio.app, |world| { world.query::<&SplineTrace>().iter(world).count() == 5 }));
}

#[test]
fn copies_are_pasted_at_the_pointer() {
    let mut studio = Studio::with_plane();
    let places = [at(-150.0, 0.0), at(-100.0, -60.0), at(-50.0, 20.0)];
    studio.draw(&places);
    let (entity, first) = studio.splines()[0].clone();
    studio.act(EditorAction::Select(entity));
    studio.settle();
    studio.control(KeyCode::KeyC);
    studio.hand.move_to(&mut studio.app, at(50.0, 100.0));
    studio.control(KeyCode::KeyV);
    studio.settle();
    let splines = studio.splines();
    assert_eq!(splines.len(), 2);
    let seen: Vec<Vec2> = splines[1].1.anchors().iter().map(|anchor| studio.pixel(anchor.point())).collect();
    assert_near(&seen, &places.map(|p| p + Vec2::new(200.0, 100.0)), 0.5);
    assert_eq!(studio.selection().splines(), [splines[1].0], "the copy is selected");
    studio.control(KeyCode::KeyD);
    studio.settle();
    assert_eq!(studio.splines().len(), 3);
    assert_eq!(studio.splines()[2].1, studio.splines()[1].1);
    studio.undo();
    studio.undo();
    assert_eq!(studio.splines().iter().map(|(_, spline)| spline.clone()).collect::<Vec<_>>(), [first]);
}

#[test]
fn nothing_to_do_is_said() {
    let mut studio = Studio::with_plane();
    studio.hand.move_to(&mut studio.app, CENTRE);
    for (held, key) in [
        (&[][..], KeyCode::KeyG),
        (&[KeyCode::ControlLeft][..], KeyCode::KeyC),
        (&[KeyCode::ControlLeft][..], KeyCode::KeyV),
        (&[KeyCode::ControlLeft][..], KeyCode::KeyD),
        (&[][..], KeyCode::KeyK),
        (&[][..], KeyCode::KeyJ),
    ] {
        let before = studio.app.world().resource::<bevy_surface_splines::editor::Notices>().all().len();
        studio.hand.strike_with(&mut studio.app, held, key);
        studio.settle();
        let notices = studio.app.world().resource::<bevy_surface_splines::editor::Notices>().all();
        assert_eq!(notices.len(), before + 1, "{key:?} says why nothing happens");
    }
}

#[test]
fn keys_bind_the_handle_that_is_dragged() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, 0.0), at(0.0, -80.0), at(150.0, 0.0)]);
    let (entity, _) = studio.splines()[0].clone();
    studio.act(EditorAction::Select(entity));
    studio.settle();
    studio.click(at(0.0, -80.0));
    studio.act(EditorAction::SetJoin(Join::Smooth));
    studio.settle();
    let before = studio.document();
    let anchor = at(0.0, -80.0);
    let handle = |studio: &mut Studio, side| {
        let point = studio.spline().anchors()[1].handle(side).point();
        studio.pixel(point)
    };
    let from = handle(&mut studio, HandleSide::Outgoing);
    let partner = handle(&mut studio, HandleSide::Incoming);
    let drag_with = |studio: &mut Studio, key: KeyCode, to: Vec2| {
        studio.hand.move_to(&mut studio.app, from);
        studio.hand.press(&mut studio.app, MouseButton::Left);
        studio.hand.move_to(&mut studio.app, from + Vec2::new(0.0, 6.0));
        studio.hand.hold(&mut studio.app, key);
        studio.hand.move_to(&mut studio.app, to);
        studio.hand.release(&mut studio.app, MouseButton::Left);
        studio.hand.let_go(&mut studio.app, key);
        studio.settle();
    };
    let to = from + Vec2::new(20.0, 45.0);
    drag_with(&mut studio, KeyCode::AltLeft, to);
    assert!(handle(&mut studio, HandleSide::Outgoing).distance(to) < 0.5);
    assert!(handle(&mut studio, HandleSide::Incoming).distance(partner) < 0.5, "Alt leaves the partner alone");
    assert_eq!(studio.spline().anchors()[1].join(), Join::Corner);
    studio.undo();
    assert_eq!(studio.document(), before);
    drag_with(&mut studio, KeyCode::ControlLeft, to);
    let now = handle(&mut studio, HandleSide::Outgoing);
    let turn = (from - anchor).angle_to(now - anchor).to_degrees();
    assert!(turn.abs() > 10.0 && (turn / 15.0 - (turn / 15.0).round()).abs() < 0.02, "Ctrl turns by {turn}");
    assert!(((now - anchor).length() / (to - anchor).length() - 1.0).abs() < 0.01);
    studio.undo();
    drag_with(&mut studio, KeyCode::ShiftLeft, to);
    let now = handle(&mut studio, HandleSide::Outgoing);
    assert!((from - anchor).angle_to(now - anchor).abs() < 0.01, "Shift keeps the direction");
    studio.undo();
    assert_eq!(studio.document(), before);
}

#[test]
fn many_steps_back_may_be_asked_at_once() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, 0.0), at(0.0, -80.0), at(150.0, 0.0), at(180.0, 60.0)]);
    for _ in 0..3 {
        studio.app.world_mut().write_message(EditorAction::Undo);
    }
    studio.app.update();
    studio.settle();
    assert!(studio.splines().is_empty(), "all three entries are taken back");
}

#[test]
fn a_curve_that_is_removed_while_it_is_changed_does_not_stop_the_history() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, 0.0), at(0.0, -80.0), at(150.0, 0.0)]);
    let (entity, _) = studio.splines()[0].clone();
    studio.act(EditorAction::Select(entity));
    studio.settle();
    studio.hand.move_to(&mut studio.app, at(10.0, 10.0));
    studio.strike(KeyCode::KeyG);
    studio.hand.move_to(&mut studio.app, at(40.0, 40.0));
    studio.act(EditorAction::Remove(entity));
    studio.strike(KeyCode::Enter);
    studio.settle();
    assert!(studio.splines().is_empty());
    studio.undo();
    assert_eq!(studio.splines().len(), 1, "undo goes on");
}

#[test]
fn what_happens_in_the_middle_of_a_gesture_is_an_entry_of_its_own() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, 0.0), at(0.0, -80.0)]);
    let before = studio.document();
    studio.strike(KeyCode::KeyP);
    studio.hand.move_to(&mut studio.app, at(100.0, 0.0));
    studio.hand.press(&mut studio.app, MouseButton::Left);
    for x in [110.0, 120.0, 130.0] {
        studio.hand.move_to(&mut studio.app, at(x, 30.0));
    }
    studio.act(EditorAction::Duplicate);
    studio.hand.release(&mut studio.app, MouseButton::Left);
    studio.settle();
    assert_eq!(studio.splines().len(), 2);
    studio.undo();
    studio.undo();
    assert_eq!(studio.document(), before, "nothing was lost between the entries");
}

#[test]
fn the_gizmo_turns_scales_and_moves() {
    let mut studio = Studio::with_plane();
    let places = [at(-150.0, 60.0), at(0.0, -120.0), at(150.0, 60.0)]; // their middle is the window's
    studio.draw(&places);
    let before = studio.document();
    let (entity, _) = studio.splines()[0].clone();
    studio.act(EditorAction::Select(entity));
    studio.settle();
    // The ring, from below to the right: a quarter of a turn counter-clockwise on the screen.
    let radius = 64.0;
    let below = |degrees: f32| CENTRE + radius * Vec2::from_angle((90.0 - degrees).to_radians());
    studio.drag(&[below(0.0), below(20.0), below(60.0), below(90.0)]);
    studio.settle();
    let turned = places.map(|p| CENTRE + Vec2::new((p - CENTRE).y, -(p - CENTRE).x));
    assert_near(&anchor_pixels(&mut studio), &turned, 1.5);
    assert_eq!(studio.names()[0].as_deref(), Some("Turn selection"));
    studio.undo();
    assert_eq!(studio.document(), before);
    // The knob at the right of the ring.
    studio.drag(&[at(radius, 0.0), at(80.0, 0.0), at(1.5 * radius, 0.0)]);
    studio.settle();
    assert_near(&anchor_pixels(&mut studio), &places.map(|p| CENTRE + 1.5 * (p - CENTRE)), 2.0);
    studio.undo();
    // The middle.
    let shift = Vec2::new(30.0, 25.0);
    studio.drag(&[CENTRE, CENTRE + 0.5 * shift, CENTRE + shift]);
    studio.settle();
    assert_near(&anchor_pixels(&mut studio), &places.map(|p| p + shift), 1.5);
    assert_eq!(studio.names()[0].as_deref(), Some("Move selection"));
    studio.undo();
    // A click on it keeps the selection; where nothing is selected there is none, and a drag is a box.
    studio.click(below(0.0));
    assert_eq!(studio.selection().splines(), [entity]);
    studio.click(at(-250.0, -200.0));
    assert!(studio.selection().is_empty());
    studio.drag(&[below(0.0), below(20.0), below(60.0)]);
    studio.settle();
    assert_eq!(studio.document(), before);
}

#[test]
fn a_field_that_is_dragged_is_one_entry() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-100.0, 0.0), at(60.0, 20.0)]);
    let (entity, spline) = studio.splines()[0].clone();
    let before = studio.document();
    studio.act(EditorAction::Select(entity));
    studio.settle();
    studio.click(at(60.0, 20.0));
    assert_eq!(studio.selection().anchors(), [(entity, 1)]);
    let from = studio.surface().position(&spline.anchors()[1].point());
    for step in 1..=5 {
        let place = from + 0.02 * f64::from(step) * glam::DVec3::Y;
        let to = studio.surface().closest_point(place).expect("a place").point;
        studio.act(EditorAction::SlideAnchorTo(to));
    }
    studio.act(EditorAction::EndSlide);
    studio.settle();
    let moved = studio.spline().anchors()[1].point();
    assert!((studio.surface().position(&moved).y - from.y - 0.1).abs() < 1e-6);
    assert_eq!(studio.names()[0].as_deref(), Some("Move anchor"));
    studio.undo();
    assert_eq!(studio.document(), before, "one entry");
}

#[test]
fn what_is_behind_is_taken_when_asked() {
    let mut studio = Studio::with_sphere();
    studio.draw(&[at(-60.0, 0.0), at(60.0, 0.0)]);
    // Behind the sphere: the same curve, seen from the other side.
    let behind = Transform::from_xyz(0.0, 0.0, -3.0).looking_at(Vec3::ZERO, Vec3::Y);
    let camera = studio.camera;
    studio.app.world_mut().entity_mut(camera).insert(behind);
    studio.settle();
    let anchor = studio.spline().anchors()[0].point();
    let seen = studio.pixel(anchor);
    studio.click(seen);
    assert!(studio.selection().is_empty(), "the model is in front of it");
    studio.strike(KeyCode::KeyZ);
    studio.click(seen);
    assert!(!studio.selection().is_empty(), "now it is in reach");
    studio.strike(KeyCode::KeyZ);
    studio.click(at(0.0, -200.0));
    studio.click(seen);
    assert!(studio.selection().is_empty());
}

#[test]
fn the_pen_begins_another_curve_unless_it_stands_on_an_end() {
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, -80.0), at(-60.0, -80.0)]);
    let (first, _) = studio.splines()[0].clone();
    // A whole curve is selected: the pen begins anew.
    studio.act(EditorAction::Select(first));
    studio.strike(KeyCode::KeyP);
    studio.click(at(-100.0, 60.0));
    studio.click(at(0.0, 60.0));
    studio.strike(KeyCode::Enter);
    studio.settle();
    assert_eq!(studio.splines().len(), 2);
    // Its last anchor is clicked with the pen: the curve goes on there.
    studio.act(EditorAction::Select(first));
    studio.settle();
    studio.strike(KeyCode::KeyP);
    studio.click(at(-60.0, -80.0));
    studio.click(at(30.0, -120.0));
    studio.settle();
    let splines = studio.splines();
    assert_eq!((splines.len(), splines[0].1.anchors().len(), splines[1].1.anchors().len()), (2, 3, 2));
}

/// Strikes keys within one frame, as a frame that takes long sees them.
fn strike_at_once(studio: &mut Studio, keys: &[KeyCode]) {
    use bevy::input::ButtonState::{Pressed, Released};
    use bevy::input::keyboard::{Key, KeyboardInput, NativeKey};
    let world = studio.app.world_mut();
    let window = world.query_filtered::<Entity, With<Window>>().single(world).expect("a window");
    for key_code in keys {
        for state in [Pressed, Released] {
            let (key_code, logical_key) = (*key_code, Key::Unidentified(NativeKey::Unidentified));
            world.write_message(KeyboardInput { key_code, logical_key, state, text: None, repeat: false, window });
        }
    }
    for _ in 0..3 {
        studio.app.update();
    }
}

#[test]
fn numbers_are_what_was_typed_however_fast() {
    use KeyCode::{Digit0, Digit1, Digit2, Digit5, Enter, KeyG, KeyS, Period};
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, -80.0), at(-60.0, -80.0)]);
    studio.act(EditorAction::Take(Tool::Select));
    let size = |studio: &mut Studio| {
        let (_, spline) = studio.splines().swap_remove(0);
        let surface = studio.app.world().get::<BuiltSurface>(studio.model).expect("a surface");
        let [a, b] = [0, 1].map(|k: usize| surface.position(&spline.anchors()[k].point()));
        (a, a.distance(b))
    };
    studio.act(EditorAction::SelectAll);
    let (start, before) = size(&mut studio);
    strike_at_once(&mut studio, &[KeyS, Digit0, Period, Digit2, Digit5, Enter]);
    studio.settle();
    let (_, after) = size(&mut studio);
    assert!((after - 0.25 * before).abs() < 1e-6 * before, "{before} {after}");
    studio.act(EditorAction::Undo);
    studio.settle();
    // Not in one frame, and by the keyboard alone: to the right.
    strike_at_once(&mut studio, &[KeyG]);
    strike_at_once(&mut studio, &[Digit0, Period, Digit1]);
    strike_at_once(&mut studio, &[Enter]);
    studio.settle();
    let (moved, after) = size(&mut studio);
    assert!((after - before).abs() < 1e-6 * before);
    assert!((moved.distance(start) - 0.1).abs() < 1e-6, "{start} {moved}");
}

#[test]
fn keys_count_in_the_order_in_which_they_were_struck() {
    use bevy::input::ButtonState::{Pressed, Released};
    use bevy::input::keyboard::{Key, KeyboardInput, NativeKey};
    let mut studio = Studio::with_plane();
    studio.draw(&[at(-150.0, -80.0), at(-60.0, -80.0)]);
    let world = studio.app.world_mut();
    let window = world.query_filtered::<Entity, With<Window>>().single(world).expect("a window");
    // A frame that took so long that all of Ctrl+Z happened in it.
    let steps = [
        (KeyCode::ControlLeft, Pressed),
        (KeyCode::KeyZ, Pressed),
        (KeyCode::KeyZ, Released),
        (KeyCode::ControlLeft, Released),
    ];
    for (key_code, state) in steps {
        let logical_key = Key::Unidentified(NativeKey::Unidentified);
        world.write_message(KeyboardInput { key_code, logical_key, state, text: None, repeat: false, window });
    }
    studio.app.update();
    studio.settle();
    assert!(studio.splines().is_empty(), "undone");
    let settings = studio.app.world().resource::<bevy_surface_splines::plugin::SplinePickingSettings>();
    assert!(!settings.see_through, "it was not Z alone");
}
