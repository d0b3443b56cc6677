//! Random gestures, and the history they leave.

use bevy::prelude::*;
use bevy_surface_splines::curve::TraceWorkspace;
use bevy_surface_splines::editor::{
    Conversions, Curve, DrawingInHand, EditorAction, Freehand, FreehandSettings, Notices, TakeDrawing, Tool,
};
use bevy_surface_splines::plugin::ControlKind;
use bevy_surface_splines::plugin::testing::update_until;
use bevy_surface_splines::prelude::*;

use super::{CENTRE, Studio};
use crate::plugin::Random;
use crate::plugin::drags::bits;

/// More anchors than this are not kept alive.
const MOST_ANCHORS: usize = 200;
/// So many gestures are taken back and done again at a time.
const ROUND: usize = 100;

/// Somewhere on the sphere, or off it.
fn somewhere(random: &mut Random) -> Vec2 {
    let angle = random.share() * std::f32::consts::TAU;
    CENTRE + 380.0 * random.share().sqrt() * Vec2::from_angle(angle)
}

/// Somewhere near: an anchor, a handle, or a curve if there is one.
fn on_something(studio: &mut Studio, random: &mut Random) -> Vec2 {
    let splines = studio.splines();
    if splines.is_empty() || random.below(4) == 0 {
        return somewhere(random);
    }
    let (_, spline) = &splines[random.below(splines.len() as u32) as usize];
    let kinds = ControlKind::all(spline);
    let point = kinds[random.below(kinds.len() as u32) as usize].point(spline);
    point.map_or(CENTRE, |point| studio.pixel(point)) + 6.0 * Vec2::new(random.signed(), random.signed())
}

fn way(from: Vec2, random: &mut Random) -> Vec<Vec2> {
    let step = Vec2::new(random.signed(), random.signed()) * 60.0;
    (0..=3u8).map(|i| from + f32::from(i) / 3.0 * step).collect()
}

/// Selects an anchor, if there is one to be seen.
fn take_an_anchor(studio: &mut Studio, random: &mut Random) {
    let splines = studio.splines();
    if splines.is_empty() {
        return;
    }
    let (entity, spline) = &splines[random.below(splines.len() as u32) as usize];
    let anchor = &spline.anchors()[random.below(spline.anchors().len() as u32) as usize];
    let place = studio.pixel(anchor.point());
    studio.strike(KeyCode::KeyV);
    studio.act(EditorAction::Select(*entity));
    studio.settle();
    studio.click(place);
}

/// Something a user might do; what it was.
fn gesture(studio: &mut Studio, random: &mut Random) -> &'static str {
    let anchors: usize = studio.splines().iter().map(|(_, spline)| spline.anchors().len()).sum();
    if anchors > MOST_ANCHORS {
        studio.control(KeyCode::KeyA);
        studio.strike(KeyCode::Delete);
        return "delete all";
    }
    let held = random.below(8) == 0;
    if held {
        studio.hand.hold(&mut studio.app, KeyCode::ShiftLeft);
    }
    let what = match random.below(25) {
        0 => {
            studio.strike(KeyCode::KeyP);
            for _ in 0..=random.below(3) {
                let place = somewhere(random);
                studio.click(place);
            }
            "pen clicks"
        }
        1 => {
            studio.strike(KeyCode::KeyP);
            let places = way(somewhere(random), random);
            studio.drag(&places);
            "pen drag"
        }
        2..=5 => {
            studio.strike(KeyCode::KeyV);
            let places = way(on_something(studio, random), random);
            studio.drag(&places);
            "drag"
        }
        6 => {
            take_an_anchor(studio, random);
            let place = on_something(studio, random);
            studio.click(place);
            "click"
        }
        7 => {
            studio.strike(KeyCode::KeyI);
            let place = on_something(studio, random);
            studio.click(place);
            "insert"
        }
        8 => {
            take_an_anchor(studio, random);
            let key = [KeyCode::KeyC, KeyCode::KeyO, KeyCode::KeyK, KeyCode::KeyJ, KeyCode::KeyL];
            studio.strike(key[random.below(5) as usize]);
            "edit"
        }
        9 => {
            take_an_anchor(studio, random);
            studio.shift(KeyCode::KeyR);
            "reverse"
        }
        10 => {
            studio.strike(KeyCode::KeyX);
            "delete"
        }
        11 => {
            take_an_anchor(studio, random);
            studio.shift(KeyCode::KeyX);
            "delete segment"
        }
        14 => {
            take_an_anchor(studio, random);
            studio.strike([KeyCode::KeyG, KeyCode::KeyR, KeyCode::KeyS][random.below(3) as usize]);
            studio.app.update();
            for _ in 0..3 {
                let place = somewhere(random);
                studio.hand.move_to(&mut studio.app, place);
            }
            studio.strike(if random.below(3) == 0 { KeyCode::Escape } else { KeyCode::Enter });
            "transform"
        }
        15 => {
            studio.strike(KeyCode::KeyN);
            let (from, step) = (somewhere(random), 25.0 * Vec2::new(random.signed(), random.signed()));
            let line: Vec<Vec2> = (0..12u8)
                .map(|i| from + f32::from(i) * step + 10.0 * Vec2::new(random.signed(), random.signed()))
                .collect();
            studio.drag(&line);
            // What was drawn is fitted in the background.
            update_until(&mut studio.app, |world| !world.resource::<Freehand>().is_fitting());
            "freehand"
        }
        16 => {
            take_an_anchor(studio, random);
            studio.control(KeyCode::KeyC);
            let place = somewhere(random);
            studio.hand.move_to(&mut studio.app, place);
            studio.control(KeyCode::KeyV);
            "copy and paste"
        }
        17 => {
            studio.strike(KeyCode::KeyV);
            let corner = somewhere(random);
            let other = somewhere(random);
            studio.drag(&[corner, corner.lerp(other, 0.5), other]);
            let places = way(on_something(studio, random), random);
            studio.drag(&places);
            "box and drag"
        }
        18 => {
            place_drawing(studio, random);
            "drawing"
        }
        19 => {
            take_an_anchor(studio, random);
            slide(studio, random);
            "slide"
        }
        20 => {
            restyle(studio, random);
            "look"
        }
        21 => {
            interrupt(studio, random);
            "keys in the middle of a drag"
        }
        22 => {
            draw_line(studio, random);
            "drawn line"
        }
        23 => {
            change_line(studio, random);
            "line"
        }
        24 => {
            studio.act(EditorAction::Take(Tool::Brush));
            let places = way(on_a_line(studio, random), random);
            studio.drag(&places);
            "brush"
        }
        12 => {
            // Taken back half way.
            studio.strike(KeyCode::KeyV);
            let places = way(on_something(studio, random), random);
            for (index, place) in places.into_iter().enumerate() {
                studio.hand.move_to(&mut studio.app, place);
                if index == 0 {
                    studio.hand.press(&mut studio.app, MouseButton::Left);
                }
            }
            studio.strike(KeyCode::Escape);
            studio.hand.release(&mut studio.app, MouseButton::Left);
            "cancelled drag"
        }
        _ => {
            take_an_anchor(studio, random);
            let scheme = if random.below(2) == 0 { Scheme::de_casteljau() } else { Scheme::lane_riesenfeld() };
            studio.act(EditorAction::SetScheme(scheme.with_levels(3)));
            "scheme"
        }
    };
    if held {
        studio.hand.let_go(&mut studio.app, KeyCode::ShiftLeft);
    }
    what
}

/// Places a small drawing somewhere, if it is not too much already.
fn place_drawing(studio: &mut Studio, random: &mut Random) {
    let path = std::env::temp_dir().join(format!("splines-gestures-{}.svg", std::process::id()));
    let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10">
        <path d="M 1 5 C 3 1 7 9 9 5"/><circle cx="5" cy="5" r="2"/></svg>"#;
    std::fs::write(&path, svg).expect("a file");
    studio.app.world_mut().write_message(TakeDrawing(path.clone()));
    let taken = update_until(&mut studio.app, |world| world.resource::<DrawingInHand>().name().is_some());
    assert!(taken, "the drawing is read");
    let _ = std::fs::remove_file(path);
    let place = somewhere(random);
    studio.hand.move_to(&mut studio.app, place);
    studio.hand.wheel(&mut studio.app, random.signed() * 2.0);
    studio.click(place);
    studio.act(EditorAction::Take(Tool::Select));
    // It is placed in the background.
    update_until(&mut studio.app, |world| !world.resource::<DrawingInHand>().is_busy());
}

/// A line that stays one.
fn draw_line(studio: &mut Studio, random: &mut Random) {
    studio.app.world_mut().resource_mut::<FreehandSettings>().as_line = true;
    studio.strike(KeyCode::KeyN);
    let (from, step) = (somewhere(random), 20.0 * Vec2::new(random.signed(), random.signed()));
    let places = (0..10u8).map(|i| from + f32::from(i) * step + 8.0 * Vec2::new(random.signed(), random.signed()));
    let places: Vec<Vec2> = places.collect();
    studio.drag(&places);
    studio.app.world_mut().resource_mut::<FreehandSettings>().as_line = false;
}

/// A place of a line, if there is one.
fn on_a_line(studio: &mut Studio, random: &mut Random) -> Vec2 {
    let lines = studio.lines();
    if lines.is_empty() {
        return somewhere(random);
    }
    let points = lines[random.below(lines.len() as u32) as usize].1.points();
    studio.pixel(points[random.below(points.len() as u32) as usize])
}

/// A line is smoothed by a slider, or a line or a curve becomes the other.
fn change_line(studio: &mut Studio, random: &mut Random) {
    studio.strike(KeyCode::KeyV);
    let place = on_a_line(studio, random);
    studio.click(place);
    match random.below(4) {
        0 => studio.act(EditorAction::SetSmoothing(None)),
        1 => studio.act(EditorAction::ToLines),
        2 => {
            studio.act(EditorAction::ToSplines);
            update_until(&mut studio.app, |world| !world.resource::<Conversions>().is_busy());
        }
        _ => {
            for _ in 0..3 {
                let closeness = f64::from(10.0_f32.powf(random.signed()));
                studio.act(EditorAction::SlideSmoothing(LineSmoothing::tether(closeness)));
            }
            studio.act(EditorAction::EndSlide);
        }
    }
}

/// A field of the panel is dragged: of the active anchor's position, or of the scheme.
fn slide(studio: &mut Studio, random: &mut Random) {
    for _ in 0..=random.below(4) {
        let action = if random.below(2) == 0 {
            let aim = glam::DVec3::new(random.signed().into(), random.signed().into(), 1.0);
            EditorAction::SlideAnchorTo(studio.surface().closest_point(aim).expect("a place").point)
        } else {
            EditorAction::SlideScheme(Scheme::de_casteljau().with_levels(2 + random.below(3) as u8))
        };
        studio.act(action);
    }
    studio.act(EditorAction::EndSlide);
}

fn restyle(studio: &mut Studio, random: &mut Random) {
    let splines = studio.splines();
    if splines.is_empty() {
        return;
    }
    let (entity, _) = splines[random.below(splines.len() as u32) as usize];
    let mut curve = studio.app.world().get::<Curve>(entity).expect("a curve").clone();
    match random.below(3) {
        0 => curve.hidden = !curve.hidden,
        1 => curve.locked = !curve.locked,
        _ => curve.name = format!("Renamed {}", random.below(1000)),
    }
    studio.act(EditorAction::Restyle(entity, curve));
}

/// Keys are struck, and actions asked for, while something is dragged.
fn interrupt(studio: &mut Studio, random: &mut Random) {
    studio.strike(KeyCode::KeyV);
    let places = way(on_something(studio, random), random);
    for (index, place) in places.into_iter().enumerate() {
        studio.hand.move_to(&mut studio.app, place);
        match index {
            0 => studio.hand.press(&mut studio.app, MouseButton::Left),
            1 => {
                let keys = [KeyCode::KeyX, KeyCode::KeyC, KeyCode::KeyP, KeyCode::KeyO, KeyCode::KeyG, KeyCode::KeyK];
                studio.strike(keys[random.below(6) as usize]);
            }
            2 => {
                let asked =
                    [EditorAction::Undo, EditorAction::Delete, EditorAction::ToggleClosed, EditorAction::Reverse];
                studio.act(asked[random.below(4) as usize].clone());
            }
            _ => {}
        }
    }
    studio.hand.release(&mut studio.app, MouseButton::Left);
    studio.strike(KeyCode::Enter);
}

/// How many entries could be undone.
fn depth(studio: &Studio) -> usize {
    let (done, _) = studio.app.world().resource::<bevy_surface_splines::editor::History>().all_names();
    done.len()
}

fn check_traces(studio: &mut Studio) {
    let world = studio.app.world_mut();
    let mut query = world.query::<(&SurfaceSpline, &SplineTrace, &OnSurface)>();
    let surfaces: Vec<_> =
        query.iter(world).map(|(spline, trace, on)| ((**spline).clone(), trace.trace().clone(), on.0)).collect();
    for (spline, trace, on) in surfaces {
        let surface = world.get::<BuiltSurface>(on).expect("a surface");
        let scratch = spline.trace(surface, &mut TraceWorkspace::default(), None).expect("a trace");
        assert_eq!(bits(&trace), bits(&scratch), "traces equal those from scratch");
    }
}

fn campaign(seed: u64, gestures: usize) {
    println!("seed {seed}, {gestures} gestures");
    let mut random = Random(seed);
    let mut studio = Studio::with_sphere();
    let start = studio.whole();
    let mut checkpoint = (start.clone(), 0);
    for count in 1..=gestures {
        let what = gesture(&mut studio, &mut random);
        studio.settle();
        println!("{count}: {what}, {} entries, {:?}", depth(&studio), studio.names()[0]);
        if count % ROUND != 0 {
            continue;
        }
        println!("{count}: {what}, {} entries", depth(&studio));
        let now = studio.whole();
        check_traces(&mut studio);
        let entries = depth(&studio) - checkpoint.1;
        for left in (0..entries).rev() {
            let name = studio.names()[0].clone();
            studio.undo();
            let notices: Vec<_> =
                studio.app.world().resource::<Notices>().all().iter().map(|n| n.text.clone()).collect();
            assert_eq!(depth(&studio), checkpoint.1 + left, "{name:?} is undone; {notices:?}");
        }
        assert!(studio.whole() == checkpoint.0, "undone to the last round");
        check_traces(&mut studio);
        (0..entries).for_each(|_| studio.redo());
        assert!(studio.whole() == now, "the document is the one that its history rebuilds");
        checkpoint = (now, depth(&studio));
    }
    let end = studio.whole();
    let entries = depth(&studio);
    assert!(entries > gestures / 4, "{entries} entries of {gestures} gestures");
    (0..entries).for_each(|_| studio.undo());
    assert!(studio.whole() == start, "undone to the start");
    (0..entries).for_each(|_| studio.redo());
    assert!(studio.whole() == end, "done again to the end");
    check_traces(&mut studio);
}

#[test]
fn random_gestures_are_undone_and_redone() {
    // Ten thousand where the compiler has done its best.
    if cfg!(debug_assertions) { campaign(1, 500) } else { campaign(1, 10_000) }
}
