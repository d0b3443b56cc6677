//! Passing a vertex: from every side, by few faces and by many, and where there is no other side.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::geodesic::PathFinder;
use crate::smooth::{
    fan::Fan,
    flip::{Flipper, Rule},
    layout::Layout,
    metric::Metric,
    strip::Run,
};

/// A fan of triangles about the origin in the plane, whole or open by one triangle, with a ring of triangles around it.
fn wheel(spokes: u32, open: bool) -> Surface {
    let mut mesh = TriangleMesh { positions: vec![DVec3::ZERO], faces: Vec::new() };
    for ring in [1.0, 2.0] {
        for k in 0..spokes {
            let a = f64::from(k) / f64::from(spokes) * TAU + 0.1 * ring;
            mesh.positions.push(ring * DVec3::new(a.cos(), a.sin(), 0.0));
        }
    }
    for k in 0..spokes - u32::from(open) {
        let (a, b) = (1 + k, 1 + (k + 1) % spokes);
        // The hub is now the first corner of its face, now the second or third.
        let own = [[0, a, b], [a, b, 0], [b, 0, a]][k as usize % 3];
        mesh.faces.extend([own, [a, a + spokes, b], [b, a + spokes, b + spokes]]);
    }
    built(&mesh)
}

/// A line over the first `count` spokes behind face 0, close to the hub, in either direction.
fn about_the_hub(surface: &Surface, count: usize, backwards: bool, spin: u32) -> Strip {
    // The hub's face that has input number 3 * spin.
    let face = surface.inner_face(crate::surface::FaceId(3 * spin)).unwrap();
    let hub = (0..3).find(|k| surface.positions[surface.triangles[face as usize][*k] as usize] == DVec3::ZERO).unwrap();
    let mut strip = Strip::default();
    let mut out = HalfEdge::new(face, hub as u32);
    let off = |h: HalfEdge, hub: usize| {
        let mut weights = [0.3; 3];
        weights[hub] = 0.4;
        InnerPoint { face: h.face(), weights }
    };
    strip.start = off(out, hub);
    for _ in 0..count {
        // Around counter-clockwise over the side that comes in, or clockwise over the one that goes out.
        let (side, near) = if backwards { (out, 0.2) } else { (out.prev(), 0.8) };
        strip.push(surface, side, near, 0.0, false);
        out = if backwards { surface.twin(side).next() } else { surface.twin(side) };
    }
    strip.end = off(out, out.side());
    strip.measure(surface);
    strip
}

fn flip(surface: &Surface, strip: &mut Strip, straight: bool) -> usize {
    let (mut metric, mut layout) = (Metric::default(), Layout::default());
    layout.build(surface, &mut metric, strip);
    let all = 0..strip.len();
    let mut rule =
        Rule { near: 1.0, wished: &|_, _| 0.0, allowed: &mut |_| true, straight, windows: std::slice::from_ref(&all) };
    Flipper::default().flip(surface, &mut metric, strip, &layout, &mut rule).count
}

#[test]
fn a_line_passes_the_hub_of_a_wheel_on_its_shorter_side() {
    let spokes = 8;
    let surface = wheel(spokes, false);
    let (mut passed, mut kept) = (0, 0);
    for backwards in [false, true] {
        for spin in 0..spokes {
            for count in 1..=spokes as usize {
                for straight in [false, true] {
                    let mut strip = about_the_hub(&surface, count, backwards, spin);
                    assert!(strip.is_regular(&surface));
                    let before = strip.clone();
                    let flips = flip(&surface, &mut strip, straight);
                    assert!(strip.is_regular(&surface), "{count} {backwards} {spin}: {strip:?}");
                    assert_eq!((strip.start.face, strip.end.face), (before.start.face, before.end.face));
                    // More than half way round, the other side is shorter; all the way round, the run vanishes.
                    let turned = count as f64 * TAU / f64::from(spokes);
                    if turned > PI + 1e-6 {
                        assert_eq!((flips, strip.len()), (1, spokes as usize - count), "{backwards} {spin}");
                        passed += 1;
                    } else if turned < PI - 1e-6 {
                        assert_eq!((flips, &strip), (0, &before));
                        kept += 1;
                    }
                }
            }
        }
    }
    assert!(passed >= 100 && kept >= 90, "{passed} {kept}");
}

#[test]
fn a_boundary_has_no_other_side() {
    let spokes = 8;
    let surface = wheel(spokes, true);
    for count in 5..spokes as usize - 1 {
        let mut strip = about_the_hub(&surface, count, false, 0);
        let before = strip.clone();
        assert_eq!((flip(&surface, &mut strip, true), &strip), (0, &before));
    }
}

#[test]
fn fixed_crossings_and_vertices_that_are_not_allowed_are_not_passed() {
    let surface = wheel(8, false);
    let mut strip = about_the_hub(&surface, 6, false, 0);
    strip.fixed[3] = true;
    assert_eq!(flip(&surface, &mut strip, false), 0);
    let mut strip = about_the_hub(&surface, 6, false, 0);
    let (mut metric, mut layout) = (Metric::default(), Layout::default());
    layout.build(&surface, &mut metric, &strip);
    let all = 0..strip.len();
    let mut rule = Rule {
        near: 1.0,
        wished: &|_, _| 0.0,
        allowed: &mut |_| false,
        straight: false,
        windows: std::slice::from_ref(&all),
    };
    assert_eq!(Flipper::default().flip(&surface, &mut metric, &mut strip, &layout, &mut rule).count, 0);
}

/// Wished turns towards the hub let a line lead around it that would pass it otherwise.
#[test]
fn a_line_that_is_to_turn_leads_around() {
    let surface = wheel(8, false);
    let strip = about_the_hub(&surface, 5, false, 0);
    let (mut metric, mut layout) = (Metric::default(), Layout::default());
    layout.build(&surface, &mut metric, &strip);
    let all = 0..strip.len();
    for (wish, count) in [(0.0, 1), (0.3, 0), (-0.3, 1)] {
        let mut strip = strip.clone();
        let left = strip.run_at(&surface, 0, true).last == 4;
        let wished = |_: &Strip, _: usize| if left { wish } else { -wish };
        let mut rule = Rule {
            near: 1.0,
            wished: &wished,
            allowed: &mut |_| true,
            straight: false,
            windows: std::slice::from_ref(&all),
        };
        let flipped = Flipper::default().flip(&surface, &mut metric, &mut strip, &layout, &mut rule);
        assert_eq!(flipped.count, count, "{wish}");
    }
}

/// In the plane, the chord that the polar form gives is the straight line between the points.
#[test]
fn a_chord_crosses_spokes_where_the_straight_line_does() {
    let surface = wheel(9, false);
    for backwards in [false, true] {
        let strip = about_the_hub(&surface, 3, backwards, 1);
        let (mut metric, mut layout, mut fan) = (Metric::default(), Layout::default(), Fan::default());
        layout.build(&surface, &mut metric, &strip);
        let left = [true, false].into_iter().find(|left| strip.run_at(&surface, 0, *left).last == 2).unwrap();
        let run: Run = strip.run_at(&surface, 0, left);
        fan.unfold(&surface, &mut metric, &strip, &layout, &run);
        let [p, q] = [&strip.start, &strip.end].map(|p| surface.inner_position(p));
        for k in 0..3 {
            let h = strip.sides[k];
            let far = surface.positions[if left { surface.origin(h) } else { surface.target(h) } as usize];
            let across = fan.chord(k) * far.normalize();
            assert!((q - p).cross(across - p).length() < 1e-12, "{k} {backwards}");
        }
    }
}

/// A line over the side between two triangles turns left where its turn is positive: as they are, mirrored, and from either of them.
#[test]
fn a_turn_to_the_left_is_positive() {
    let corners = [DVec3::new(-1.0, 0.2, 0.0), DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.0, 1.0, 0.0), DVec3::X];
    for mirrored in [false, true] {
        for spin in 0..3 {
            let turned = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]][spin];
            let wound = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
            let flip = DVec3::new(1.0, if mirrored { -1.0 } else { 1.0 }, 1.0);
            let faces = [[0, 1, 2], [3, 2, 1]].map(wound).map(turned).to_vec();
            let surface = built(&TriangleMesh { positions: corners.map(|p| p * flip).to_vec(), faces });
            for back in [false, true] {
                let (from, to) = (DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 0.0, 0.0));
                let (from, to) = if back { (to, from) } else { (from, to) };
                let straight = SurfacePolyline::through(
                    &surface,
                    &mut PathFinder::new(),
                    &[from, to].map(|p| at(&surface, p)),
                    false,
                );
                let mut strip = Strip::default();
                straight.unwrap().strip_into(&surface, &mut strip).unwrap();
                for share in [0.2, 0.4, 0.7] {
                    strip.at[0] = share;
                    let here = strip.crossing(&surface, 0) + surface.origin;
                    let left = (here - from).cross(to - here).z;
                    let mut layout = Layout::default();
                    layout.build(&surface, &mut Metric::default(), &strip);
                    let turn = layout.turn(0, &strip.at);
                    assert!(left * turn > 0.0, "{mirrored} {spin} {back} {share}: {turn} {left}");
                }
            }
        }
    }
}

/// What is laid flat after a change is what is laid flat from nothing, to the last bit.
#[test]
fn a_layout_that_changes_is_that_of_the_line() {
    let surface = built(&crate::surface::shapes::icosphere(4));
    let mut random = Random(61);
    let mut changed = Layout::default();
    let mut metric = Metric::default();
    let mut line = jagged(&surface, &mut random, 120);
    for round in 0..60 {
        let mut strip = Strip::default();
        line.strip_into(&surface, &mut strip).unwrap();
        if round % 10 == 9 {
            line = jagged(&surface, &mut random, 20 + round);
        } else {
            // Past a vertex somewhere, or some.
            for _ in 0..1 + round % 3 {
                let i = (random.word() % strip.len() as u64) as usize;
                let run = strip.run_at(&surface, i, random.next() < 0.5);
                let mut fan = Vec::new();
                if !crate::smooth::strip::other_side(&surface, &strip, &run, &mut fan) {
                    continue;
                }
                let mut next = Strip { start: strip.start, end: strip.end, ..Strip::default() };
                let _ = next.append(&surface, &strip, 0..run.first);
                fan.iter().for_each(|h| _ = next.push(&surface, *h, 0.5, 0.0, false));
                let _ = next.append(&surface, &strip, run.last + 1..strip.len());
                strip = next;
            }
            if strip.len() < 10 {
                strip = Strip::default();
                line.strip_into(&surface, &mut strip).unwrap();
            }
            line = SurfacePolyline::of(&surface, strip).unwrap();
        }
        let mut strip = Strip::default();
        line.strip_into(&surface, &mut strip).unwrap();
        let mut anew = Layout::default();
        anew.build(&surface, &mut metric, &strip);
        changed.build(&surface, &mut metric, &strip);
        let legs = |layout: &Layout| format!("{:?}", layout.legs);
        assert_eq!(legs(&changed), legs(&anew), "{round}");
        assert_eq!((&changed.lengths, &changed.rights, &changed.extents), (&anew.lengths, &anew.rights, &anew.extents));
    }
}

/// Every line on the way leads from face to face and never back at once, whatever the mode, also where it crosses itself.
#[test]
fn every_line_on_the_way_is_regular() {
    let mut bumpy = crate::surface::shapes::icosphere(3);
    for p in &mut bumpy.positions {
        *p *= 1.0 + 0.3 * (5.0 * p.x).sin() * (4.0 * p.y + 1.0).sin() * (6.0 * p.z + 2.0).sin();
    }
    for (name, surface) in
        [("bumpy", built(&bumpy)), ("torus", built(&crate::surface::shapes::torus(2.0, 0.7, 40, 20)))]
    {
        let (mut random, mut workspace) = (Random(71), SmoothWorkspace::default());
        for round in 0..60 {
            let mut line = jagged(&surface, &mut random, 200);
            if round % 4 > 0 {
                let Ok(closed) = line.closed_home(&surface, &mut workspace.finder) else { continue };
                line = closed;
            }
            for closeness in [0.3, 10.0, 300.0] {
                let mut seen = 0;
                let mut see = |strip: &Strip| {
                    seen += 1;
                    let n = strip.len();
                    for i in 0..if strip.closed { n } else { n.max(1) - 1 } {
                        let (twin, next) = (surface.twin(strip.sides[i]), strip.sides[(i + 1) % n]);
                        let leads_on = twin.is_some() && twin.face() == next.face() && twin != next;
                        assert!(
                            n < 3 || leads_on,
                            "{name} {round} {closeness} {seen}: {i} of {n}, {:?}",
                            strip.fixed[i]
                        );
                    }
                };
                workspace.prepare(&surface, &line).unwrap();
                let smoothing = Smoothing::tether(closeness);
                let _ = workspace.run(&surface, &smoothing, &mut crate::smooth::progress::Watch::seeing(&mut see));
            }
        }
    }
}
