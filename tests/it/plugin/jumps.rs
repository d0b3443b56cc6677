//! A handle dragged around a ring with the pointer, past the place where the shortest way to it changes sides, under each
//! policy.

use bevy::prelude::*;
use bevy_surface_splines::curve::{Spline, Trace, TraceWorkspace};
use bevy_surface_splines::geodesic::PathFinder;
use bevy_surface_splines::plugin::testing::{PointerScript, pixel_of};
use bevy_surface_splines::prelude::*;

use super::{app_with_camera, spawn_spline, spawn_surface, surface_of};

struct Ring {
    app: App,
    camera: Entity,
    surface: Entity,
    spline: Entity,
}

/// On top of the ring, where the camera sees it.
fn on_top(angle: f32) -> Vec3 {
    Vec3::new(2.0 * angle.cos(), 0.5, 2.0 * angle.sin())
}

impl Ring {
    /// A ring seen from above, and a segment along it; the dragged handle starts at an angle of 0.8.
    fn new(jumps: JumpPolicy) -> Self {
        let (mut app, camera) = app_with_camera(Vec3::Y * 8.0);
        let torus = Torus { minor_radius: 0.5, major_radius: 2.0 };
        let surface = spawn_surface(&mut app, torus.mesh().minor_resolution(24).major_resolution(72));
        let place = |angle: f32| {
            let found = surface_of(&app, surface).closest_point(on_top(angle).as_dvec3());
            found.expect("a surface").point
        };
        let source = SplineSource::bezier([0.0, 0.4, 0.8, 1.2].map(place));
        let spline = spawn_spline(&mut app, surface, source);
        app.world_mut().write_message(EditSpline::new(spline, SplineEdit::SetJumps(jumps)));
        app.world_mut().entity_mut(spline).insert(Editable);
        (0..3).for_each(|_| app.update());
        let ring = Self { app, camera, surface, spline };
        assert_eq!(ring.spline().jumps(), jumps);
        ring
    }

    fn spline(&self) -> Spline {
        (**self.app.world().get::<SurfaceSpline>(self.spline).expect("a spline")).clone()
    }

    fn trace(&self) -> Trace {
        (**self.app.world().get::<SplineTrace>(self.spline).expect("a trace").trace()).clone()
    }

    fn pixel(&self, angle: f32) -> Vec2 {
        pixel_of(self.app.world(), self.camera, on_top(angle)).expect("on screen")
    }

    /// Drags the second handle around to an angle; gives the splines and the largest step of the curve from frame to frame.
    fn drag(&mut self, to: f32) -> (Vec<Spline>, f64) {
        let mut pointer = PointerScript::mouse(&mut self.app).expect("a window");
        let handle = ControlKind::Handle(1, HandleSide::Incoming);
        let start = self.pixel(0.8);
        pointer.move_to(&mut self.app, start);
        pointer.press(&mut self.app);
        assert_eq!(self.app.world().resource::<DragState>().held().map(|g| g.kind), Some(handle));
        let (mut splines, mut largest) = (Vec::new(), 0.0_f64);
        let mut before = self.trace();
        for k in 1..=60u8 {
            let angle = 0.8 + (to - 0.8) * f32::from(k) / 60.0;
            let place = self.pixel(angle);
            pointer.move_to(&mut self.app, place);
            let (spline, trace) = (self.spline(), self.trace());
            let surface = surface_of(&self.app, self.surface);
            // What is shown is what the document alone asks for.
            assert_eq!(trace, spline.trace(surface, &mut TraceWorkspace::default(), None).expect("a trace"));
            let at = |trace: &Trace, share: f64| {
                let point = trace.at_distance(surface, share * trace.length()).expect("a place");
                surface.position(&point)
            };
            for share in (0..=10).map(|i| f64::from(i) / 10.0) {
                largest = largest.max(at(&trace, share).distance(at(&before, share)));
            }
            before = trace;
            splines.push(spline);
        }
        pointer.release(&mut self.app);
        (splines, largest)
    }
}

/// Beyond half around from the first handle.
const FAR: f32 = 0.4 + std::f32::consts::PI + 0.7;

#[test]
fn each_policy_does_what_it_says() {
    let [(allowed, jump), (sticky, steady), (split, divided)] =
        [JumpPolicy::Allow, JumpPolicy::Sticky, JumpPolicy::AutoSplit].map(|jumps| {
            let mut ring = Ring::new(jumps);
            let (splines, step) = ring.drag(FAR);
            let surface = surface_of(&ring.app, ring.surface);
            let mut finder = PathFinder::new();
            let last = splines.last().expect("frames");
            let excess = last.excess(surface, &mut finder, 0).expect("a middle leg");
            ((splines.iter().map(|s| s.anchors().len()).collect::<Vec<_>>(), excess), step)
        });
    println!("largest steps: allowed {jump:.3}, sticky {steady:.3}, split {divided:.3}");
    assert!(allowed.0.iter().all(|n| *n == 2) && sticky.0.iter().all(|n| *n == 2));
    assert!(jump > 5.0 * steady && jump > 3.0 * divided, "{jump} {steady} {divided}");
    assert!(allowed.1 == 0.0 && sticky.1 > 0.05, "{} {}", allowed.1, sticky.1);
    assert!(split.0.is_sorted() && split.0.last() > Some(&2), "{:?}", split.0);
}

#[test]
fn going_back_undoes_it_all() {
    for jumps in [JumpPolicy::Sticky, JumpPolicy::AutoSplit] {
        let mut ring = Ring::new(jumps);
        let start = ring.spline();
        let mut pointer = PointerScript::mouse(&mut ring.app).expect("a window");
        let place = ring.pixel(0.8);
        pointer.move_to(&mut ring.app, place);
        pointer.press(&mut ring.app);
        for angle in [1.5, 2.5, 3.5, FAR, 3.5, 2.5, 1.5, 0.9] {
            let place = ring.pixel(angle);
            pointer.move_to(&mut ring.app, place);
        }
        // Back where it began, the split is gone and the leg is the one it was.
        let back = ring.spline();
        assert_eq!(back.anchors().len(), 2);
        let surface = surface_of(&ring.app, ring.surface);
        assert!(back.excess(surface, &mut PathFinder::new(), 0).expect("a leg") < 1e-9);
        pointer.escape(&mut ring.app);
        assert_eq!(ring.spline(), start);
    }
}
