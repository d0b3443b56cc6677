//! The drawings of the corpus on surfaces.

use bevy_surface_splines::curve::{Anchor, Join};
use bevy_surface_splines::placement::{Boundary, PathOutcome, PlaceOptions, Placement, place_drawing};
use bevy_surface_splines::surface::{Surface, SurfaceOptions, TriangleMesh, shapes};
use bevy_surface_splines::vector::{Drawing, read_svg};
use glam::{DVec2, DVec3};

use super::{corpus, table};

/// The drawings of the corpus, with their names.
fn drawings() -> Option<Vec<(String, Drawing)>> {
    let corpus = corpus()?;
    let read = |row: &Vec<String>| (row[0].clone(), read_svg(corpus.join(&row[0])).unwrap().drawing);
    Some(table(&corpus.join("svg.csv")).iter().map(read).collect())
}

fn built(mesh: &TriangleMesh) -> Surface {
    Surface::build(mesh, &SurfaceOptions::default()).unwrap()
}

/// Options that take everything, and hold the drawing by the middle of what is drawn; and the size of that.
fn options(drawing: &Drawing) -> (PlaceOptions, f64) {
    let (low, high) = drawing.bounds().unwrap();
    let origin = Some(0.5 * (low + high));
    (PlaceOptions { origin, invisible: true, ..PlaceOptions::default() }, low.distance(high))
}

#[test]
fn on_a_flat_surface_the_result_is_the_drawing() {
    let Some(drawings) = drawings() else { return };
    let surface = built(&shapes::grid(61, 47, 1.0, 1.0));
    let (mut worst, mut points) = (0.0_f64, 0);
    for (k, (name, drawing)) in drawings.iter().enumerate() {
        let (options, size) = options(drawing);
        let centre = DVec2::new(0.47, 0.52);
        let up = DVec2::from_angle(k as f64);
        let at = surface.closest_point(centre.extend(0.0)).unwrap().point;
        let scale = 0.9 / size;
        let placed = place_drawing(&surface, drawing, &Placement { at, up: up.extend(0.0), scale }, &options).unwrap();
        assert_eq!(placed.splines.len(), drawing.paths().count(), "{name}");
        let expected = |q: DVec2| {
            let v = (q - options.origin.unwrap()) * scale;
            centre - v.x * up.perp() - v.y * up
        };
        for (one, (shape, path)) in placed.splines.iter().zip(drawing.paths()) {
            assert_eq!(one.shape as usize, shape);
            for (i, planar) in path.segments().enumerate() {
                for (point, q) in one.spline.polygon(i).unwrap().iter().zip(planar) {
                    // Handles may reach over the boundary, and are cut there.
                    let to = expected(q);
                    if (0.0..=1.0).contains(&to.x) && (0.0..=1.0).contains(&to.y) {
                        worst = worst.max(surface.position(point).truncate().distance(to));
                        points += 1;
                    }
                }
            }
        }
    }
    println!("{points} control points, off by {worst:.1e} of a side of 1 at most");
    assert!(worst < 1e-9);
}

/// By how much the legs at an anchor miss being opposite, measured on positions; none where faces bend under them.
fn missing(surface: &Surface, anchor: &Anchor) -> Option<f64> {
    let [incoming, outgoing] = [anchor.incoming(), anchor.outgoing()].map(|handle| {
        let tangent = handle.leg().initial_tangent(surface).unwrap();
        (tangent.face, tangent.length(), surface.tangent_in_space(&tangent).unwrap())
    });
    let shortest = 1e-7 * surface.diagonal();
    if incoming.0 != outgoing.0 || incoming.1 < shortest || outgoing.1 < shortest {
        return None;
    }
    let (a, b) = (incoming.2.normalize(), outgoing.2.normalize());
    Some((a + b).length()) // 2 sin(half of what is missing)
}

#[test]
fn on_curved_surfaces_smooth_joins_stay_smooth() {
    let Some(drawings) = drawings() else { return };
    for (label, mesh) in [("sphere", shapes::icosphere(5)), ("torus", shapes::torus(2.0, 0.8, 160, 80))] {
        let surface = built(&mesh);
        let at = surface.closest_point(DVec3::new(3.0, 0.4, 0.3)).unwrap().point;
        let (mut worst, mut looked_at, mut other_faces) = (0.0_f64, 0, 0);
        for (name, drawing) in &drawings {
            let (options, size) = options(drawing);
            let scale = 0.5 * surface.diagonal() / size;
            let placement = Placement { at, up: DVec3::new(0.3, 0.2, 1.0), scale };
            let placed = place_drawing(&surface, drawing, &placement, &options).unwrap();
            assert!(placed.paths.iter().all(|p| p.outcome == PathOutcome::Placed && p.clipped_handles == 0), "{name}");
            // What is smooth in the plane is told here anew.
            for (one, (_, path)) in placed.splines.iter().zip(drawing.paths()) {
                for (i, anchor) in one.spline.anchors().iter().enumerate() {
                    let [Some(incoming), Some(outgoing)] = path.handles(i) else { continue };
                    let planar = (incoming.normalize_or_zero() + outgoing.normalize_or_zero()).length();
                    let is_marked = matches!(anchor.join(), Join::Smooth | Join::Mirrored);
                    if !(planar < 1e-9 || is_marked) || incoming == DVec2::ZERO || outgoing == DVec2::ZERO {
                        continue;
                    }
                    match missing(&surface, anchor) {
                        Some(missing) => {
                            worst = worst.max(missing);
                            looked_at += 1;
                        }
                        None => other_faces += 1,
                    }
                }
            }
        }
        println!(
            "{label}: {looked_at} smooth joins, off by {worst:.1e} rad at most; {other_faces} too short or on a side"
        );
        assert!(worst < 1e-6 && looked_at > 10_000 && other_faces < looked_at / 20);
    }
}

#[test]
fn drawings_are_cut_at_the_boundary() {
    let Some(drawings) = drawings() else { return };
    let surface = built(&shapes::grid(30, 30, 1.0, 1.0));
    let at = surface.closest_point(DVec3::new(0.8, 0.3, 0.0)).unwrap().point;
    for (name, drawing) in &drawings {
        let (options, size) = options(drawing);
        let placement = Placement { at, up: DVec3::new(0.4, 1.0, 0.0), scale: 1.2 / size };
        let whole = place_drawing(&surface, drawing, &placement, &options).unwrap();
        let clip = PlaceOptions { boundary: Boundary::Clip, ..options };
        let cut = place_drawing(&surface, drawing, &placement, &clip).unwrap();
        assert_eq!(whole.paths.len(), cut.paths.len());
        for (a, b) in whole.paths.iter().zip(&cut.paths) {
            match a.outcome {
                PathOutcome::Placed => assert_eq!(b.outcome, PathOutcome::Placed, "{name}"),
                _ => assert!(b.outcome != PathOutcome::Placed, "{name}"),
            }
        }
        assert!(cut.dropped() <= whole.dropped(), "{name}");
    }
}
