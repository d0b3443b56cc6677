//! Selections that are moved, turned and scaled, and splines that are copied.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2, DVec3};

use super::{edits::bumpy, *};
use crate::curve::*;

fn apply(surface: &Surface, spline: &Spline, transform: SelectionTransform) -> Spline {
    let mut next = spline.clone();
    let back = next.apply(surface, &mut PathFinder::new(), &SplineEdit::Transform(transform)).unwrap();
    let mut again = next.clone();
    again.apply(surface, &mut PathFinder::new(), &back).unwrap();
    assert_eq!(format!("{again:?}"), format!("{spline:?}"));
    next
}

/// Positions of all anchors and handles.
fn controls(surface: &Surface, spline: &Spline) -> Vec<DVec3> {
    let points = |a: &Anchor| [a.point(), a.incoming().point(), a.outgoing().point()];
    spline.anchors().iter().flat_map(points).map(|p| surface.position(&p)).collect()
}

fn farthest(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
}

fn smooth_everywhere(surface: &Surface, spline: &Spline) -> bool {
    let off = |a: &Anchor| (handle_angle(surface, a) - 0.5 * TAU).abs();
    spline.anchors().iter().filter(|a| a.join() == Join::Smooth).all(|a| off(a) < 1e-9)
}

/// The surface point nearest to a position, moved off sides and corners: at a vertex there is no tangent plane, and what is
/// turned about one by a hair jumps by a part of its curvature.
fn inside_a_face(surface: &Surface, p: DVec3) -> SurfacePoint {
    let point = at(surface, p);
    surface.point(point.face, point.weights.map(|w| 0.9 * w + 0.1 / 3.0)).unwrap()
}

/// A closed smooth curve about a place.
fn around(surface: &Surface, random: &mut Random, middle: DVec3, size: f64) -> Spline {
    let points: Vec<_> = (0..5)
        .map(|k| {
            let a = (f64::from(k) + 0.5 * random.next()) / 5.0 * TAU;
            let normal = surface.normal(&at(surface, middle));
            let (out, up) = normal.any_orthonormal_pair();
            inside_a_face(surface, middle + size * (0.4 + 0.6 * random.next()) * (a.cos() * out + a.sin() * up))
        })
        .collect();
    Spline::smooth_through(surface, &mut PathFinder::new(), &points, true).unwrap()
}

/// A vertex; of a square one about its middle, so that curves around have room.
fn somewhere(surface: &Surface, random: &mut Random) -> DVec3 {
    let vertex = surface.positions[random.below(surface.positions.len())];
    let is_square = surface.bounds().1.z == 0.0;
    if is_square { DVec3::new(0.5, 0.5, 0.0) + 0.2 * (vertex - DVec3::new(0.5, 0.5, 0.0)) } else { vertex }
}

#[test]
fn in_the_plane_they_are_affine_maps() {
    let surface = built(&jittered_square(30));
    let mut random = Random(81);
    for round in 0..30 {
        let points: Vec<_> = (0..5).map(|_| 0.5 * (random.in_square() - DVec3::new(0.5, 0.5, 0.0))).collect();
        let points: Vec<_> = points.iter().map(|p| *p * 0.6 + DVec3::new(0.5, 0.5, 0.0)).collect();
        let spline = spline_on(&surface, &points, round % 2 == 0);
        let centre = 0.2 * random.in_square() + DVec3::new(0.4, 0.4, 0.0);
        let to = centre + 0.05 * DVec3::new(random.next() - 0.5, random.next() - 0.5, 0.0);
        let matrix = match round % 4 {
            0 => DMat2::IDENTITY,
            1 => DMat2::from_angle(TAU * random.next()),
            2 => DMat2::from_diagonal(DVec2::splat(0.5 + random.next())),
            _ => DMat2::from_cols_array(&[0.9, 0.3 * random.next(), -0.4, 0.2 + random.next()]),
        };
        let [from, goal] = [centre, to].map(|p| at(&surface, p));
        let axis = surface.tangent(&from, DVec3::X).unwrap();
        let mapped = |p: &DVec3| to + (matrix * (*p - centre).truncate()).extend(0.0);
        for coordinates in [Coordinates::Normal, Coordinates::Chained] {
            let transform =
                SelectionTransform { to: goal, axis: Some(axis), coordinates, ..SelectionTransform::new(from, matrix) };
            let found = apply(&surface, &spline, transform.clone());
            let expected: Vec<_> = controls(&surface, &spline).iter().map(mapped).collect();
            let off = farthest(&controls(&surface, &found), &expected);
            assert!(off < 1e-10, "{round} {coordinates:?}: {off}");
            // Of a part the rest stays.
            let part = apply(&surface, &spline, transform.of([3, 1, 3]));
            for (i, anchor) in part.anchors().iter().enumerate() {
                let old = &spline.anchors()[i];
                if i == 1 || i == 3 {
                    let [a, b] = [anchor, &found.anchors()[i]].map(|a| surface.position(&a.point()));
                    assert!(a.distance(b) < 1e-10);
                } else {
                    assert_eq!(anchor, old);
                }
            }
        }
    }
}

#[test]
fn turning_a_sphere_keeps_circles_of_latitude() {
    let surface = built(&shapes::icosphere(6));
    let pole = DVec3::new(0.3, -0.5, 0.8).normalize();
    let (x, y) = (pole.any_orthonormal_pair().0, pole.any_orthonormal_pair().1);
    let centre = at(&surface, pole);
    let circle = |k: f64, polar: f64| polar.cos() * pole + polar.sin() * ((k * TAU).cos() * x + (k * TAU).sin() * y);
    for polar in [0.2_f64, 0.7, 1.4] {
        let points: Vec<_> = (0..8).map(|k| circle(f64::from(k) / 8.0, polar)).collect();
        let spline = spline_on(&surface, &points, true);
        for angle in [0.1, 1.0, -2.5] {
            let turned = apply(&surface, &spline, SelectionTransform::rotation(centre, angle));
            for (k, anchor) in turned.anchors().iter().enumerate() {
                let found = surface.position(&anchor.point()).normalize();
                // A mesh is no sphere: paths near vertices are pushed aside by a part of an edge.
                assert!((found.angle_between(pole) - polar).abs() < 0.01, "{polar} {angle}");
                let turn = if x.cross(y).dot(pole) > 0.0 { angle } else { -angle };
                let expected = circle(k as f64 / 8.0 + turn / TAU, polar);
                assert!(found.distance(expected) < 0.03, "{polar} {angle}: {}", found.distance(expected));
            }
            assert!(smooth_everywhere(&surface, &turned));
        }
    }
}

#[test]
fn nothing_happens_by_nothing_and_little_by_little() {
    for (m, mesh) in [shapes::torus(2.0, 0.8, 60, 30), bumpy(5), jittered_square(20)].iter().enumerate() {
        let surface = built(mesh);
        let mut random = Random(90 + m as u64);
        let reach = 0.2 * surface.diagonal();
        for round in 0..30 {
            let middle = somewhere(&surface, &mut random);
            let spline = around(&surface, &mut random, middle, reach);
            let centre = inside_a_face(&surface, middle + 0.5 * reach * random.on_sphere());
            for chained in [false, true] {
                let in_coordinates = |t: SelectionTransform| if chained { t.chained() } else { t };
                let still = apply(&surface, &spline, in_coordinates(SelectionTransform::rotation(centre, 0.0)));
                assert_eq!(format!("{still:?}"), format!("{spline:?}"));
                let near = at(&surface, surface.position(&centre) + 1e-9 * random.on_sphere());
                for transform in [
                    SelectionTransform::rotation(centre, 1e-9),
                    SelectionTransform::scaling(centre, 1.0 + 1e-9),
                    SelectionTransform::translation(centre, near),
                ] {
                    let transform = in_coordinates(transform);
                    let mut finder = PathFinder::new();
                    let made = spline.transformed(&surface, &mut finder, &transform).unwrap();
                    assert!(made.clipped.is_empty(), "mesh {m} {round}");
                    let anchors = |s: &Spline| -> Vec<DVec3> {
                        s.anchors().iter().map(|a| surface.position(&a.point())).collect()
                    };
                    let off = farthest(&anchors(&made.spline), &anchors(&spline));
                    assert!(off < 1e-7 * surface.diagonal(), "mesh {m} {round} {transform:?}: {off}");
                }
            }
        }
    }
}

#[test]
fn what_is_turned_back_is_where_it_was() {
    for (m, mesh) in [shapes::torus(2.0, 0.8, 60, 30), shapes::icosphere(5), bumpy(5)].iter().enumerate() {
        let surface = built(mesh);
        let mut random = Random(95 + m as u64);
        let mut finder = PathFinder::new();
        let mut judged = 0;
        for round in 0..60 {
            let middle = surface.positions[random.below(surface.positions.len())];
            let spline = around(&surface, &mut random, middle, 0.12 * surface.diagonal());
            let centre = at(&surface, middle);
            let angle = TAU * random.next();
            let turned = apply(&surface, &spline, SelectionTransform::rotation(centre, angle));
            let back = apply(&surface, &turned, SelectionTransform::rotation(centre, -angle));
            assert!(smooth_everywhere(&surface, &turned) && smooth_everywhere(&surface, &back));
            for i in 0..spline.anchors().len() {
                let [p, q, r] = [&spline, &turned, &back].map(|s| s.anchors()[i].point());
                let mut path = |p| finder.shortest(&surface, &centre, &p).unwrap();
                let (there, after) = (path(p), path(q));
                // The way back must be the way there.
                let bends = there.crossings().iter().chain(after.crossings()).any(|c| c.at == 0.0 || c.at == 1.0);
                if bends || (there.length() - after.length()).abs() > 1e-9 {
                    continue;
                }
                let off = surface.position(&p).distance(surface.position(&r));
                assert!(off < 1e-9 * surface.diagonal(), "mesh {m} {round} {i}: {off}");
                judged += 1;
            }
        }
        println!("mesh {m}: {judged} anchors turned there and back");
        assert!(judged > 100, "{judged}");
    }
}

#[test]
fn joins_stay_as_smooth_as_they_are() {
    let surface = built(&bumpy(4));
    let mut random = Random(99);
    for round in 0..60 {
        let middle = surface.positions[random.below(surface.positions.len())];
        let mut spline = around(&surface, &mut random, middle, 0.5);
        let mirrored = SplineEdit::SetJoin { anchor: 1, join: Join::Mirrored };
        spline.apply(&surface, &mut PathFinder::new(), &mirrored).unwrap();
        if round % 3 == 0 {
            spline.apply(&surface, &mut PathFinder::new(), &SplineEdit::SetJumps(JumpPolicy::Sticky)).unwrap();
        }
        let matrix = DMat2::from_cols_array(&[0; 4].map(|_| 2.0 * random.next() - 1.0));
        let [centre, to] = [at(&surface, middle), at(&surface, middle + random.on_sphere())];
        let transform = SelectionTransform { to, ..SelectionTransform::new(centre, matrix) };
        let joins = |s: &Spline| s.anchors().iter().map(|a| a.join()).collect::<Vec<_>>();
        let made = apply(&surface, &spline, transform);
        assert!(smooth_everywhere(&surface, &made), "{round}");
        assert_eq!(joins(&made), joins(&spline));
        let anchor = &made.anchors()[1];
        assert!((handle_angle(&surface, anchor) - 0.5 * TAU).abs() < 1e-9);
        assert!((anchor.incoming().wished_length() - anchor.outgoing().wished_length()).abs() < 1e-9);
        assert!(made.trace(&surface, &mut TraceWorkspace::default(), None).is_ok());
    }
}

/// A gesture computes every step from where it began.
#[test]
fn gestures_start_from_where_they_began() {
    let surface = built(&shapes::icosphere(4));
    let before = spline_on(&surface, &[DVec3::X, DVec3::Y, DVec3::Z], true);
    let mut finder = PathFinder::new();
    let mut kept = before.clone();
    let centre = at(&surface, DVec3::ONE);
    for k in 0..10 {
        let edit = SplineEdit::Transform(SelectionTransform::rotation(centre, 0.1 * f64::from(k)).of([0, 2]));
        kept.assign_after(&surface, &mut finder, &before, &edit).unwrap();
        let mut applied = before.clone();
        applied.apply(&surface, &mut finder, &edit).unwrap();
        assert_eq!(kept, applied);
    }
}

/// Two balls in one mesh.
fn two_balls() -> TriangleMesh {
    let mut mesh = shapes::icosphere(3);
    let count = mesh.positions.len() as u32;
    let far: Vec<_> = mesh.positions.iter().map(|p| *p + DVec3::X * 5.0).collect();
    let faces: Vec<_> = mesh.faces.iter().map(|f| f.map(|v| v + count)).collect();
    mesh.positions.extend(far);
    mesh.faces.extend(faces);
    mesh
}

#[test]
fn other_pieces_of_the_surface_stay() {
    let surface = built(&two_balls());
    let spline = spline_on(&surface, &[DVec3::X, DVec3::Y, DVec3::Z], false);
    let centre = at(&surface, DVec3::new(5.0, 0.0, 1.0));
    let mut finder = PathFinder::new();
    let made = spline.transformed(&surface, &mut finder, &SelectionTransform::rotation(centre, 1.0)).unwrap();
    assert_eq!((made.left, made.spline), (vec![0, 1, 2], spline.clone()));
    let apart = SelectionTransform::translation(centre, spline.anchors()[0].point());
    assert!(matches!(spline.transformed(&surface, &mut finder, &apart), Err(EditError::Path(_))));
    let copied = SplineClip::copy(&surface, &mut finder, &[&spline], &centre, None, Coordinates::Normal).unwrap();
    assert!(copied.clip.is_empty() && copied.left_out == [0]);
}

#[test]
fn odd_transforms_are_refused_in_words_or_do_nothing() {
    let surface = built(&jittered_square(8));
    let spline = spline_on(&surface, &[(0.2, 0.3), (0.5, 0.6), (0.8, 0.4)].map(|(x, y)| DVec3::new(x, y, 0.0)), false);
    let centre = at(&surface, DVec3::new(0.4, 0.4, 0.0));
    let mut finder = PathFinder::new();
    let bad = SurfacePoint { face: crate::surface::FaceId(1 << 30), ..centre };
    for transform in [
        SelectionTransform::rotation(centre, f64::NAN),
        SelectionTransform::scaling(centre, 0.0),
        SelectionTransform::scaling(centre, f64::INFINITY),
        SelectionTransform::scaling(centre, 1e-300),
        SelectionTransform::scaling(centre, 1e300),
        SelectionTransform::new(centre, DMat2::from_diagonal(DVec2::X)),
        SelectionTransform::rotation(centre, 1.0).of([0, 3]),
        SelectionTransform::translation(bad, centre),
        SelectionTransform::translation(centre, bad),
        SelectionTransform::rotation(SurfacePoint { weights: [f64::NAN; 3], ..centre }, 1.0),
    ] {
        let mut same = spline.clone();
        let edit = SplineEdit::Transform(transform);
        let error = same.apply(&surface, &mut finder, &edit).unwrap_err();
        assert!(!error.to_string().is_empty() && same == spline, "{edit:?}");
    }
    let nobody = SelectionTransform::rotation(centre, 1.0).of([]);
    assert_eq!(spline.transformed(&surface, &mut finder, &nobody).unwrap().spline, spline);
    for transform in [SelectionTransform::scaling(centre, 1e6), SelectionTransform::scaling(centre, -1.0)] {
        let made = spline.transformed(&surface, &mut finder, &transform).unwrap();
        assert_eq!(made.clipped.is_empty(), transform.matrix.x_axis.x < 0.0);
        assert!(made.spline.trace(&surface, &mut TraceWorkspace::default(), None).is_ok());
    }
    let mut empty = spline.clone();
    empty.anchors.clear();
    let turn = SelectionTransform::rotation(centre, 1.0);
    assert_eq!(empty.transformed(&surface, &mut finder, &turn).unwrap().spline, empty);
    assert_eq!(empty.transformed(&surface, &mut finder, &turn.chained()).unwrap().spline, empty);
    let copied = SplineClip::copy(&surface, &mut finder, &[&empty], &centre, None, Coordinates::Chained).unwrap();
    assert_eq!(copied.clip.paste(&surface, &mut finder, &Paste::at(centre)).unwrap().splines, [empty]);
    for paste in [
        Paste { scale: 0.0, ..Paste::at(centre) },
        Paste { turn: f64::NAN, ..Paste::at(centre) },
        Paste::at(bad),
        Paste { axis: Some(surface.tangent(&centre, DVec3::Z).unwrap()), ..Paste::at(centre) },
    ] {
        assert!(copied.clip.paste(&surface, &mut finder, &paste).is_err(), "{paste:?}");
    }
}

#[test]
fn a_copy_at_its_own_place_is_the_same_curve() {
    for (m, mesh) in [shapes::torus(2.0, 0.8, 60, 30), bumpy(5), jittered_square(20)].iter().enumerate() {
        let surface = built(mesh);
        let mut random = Random(110 + m as u64);
        let mut workspace = TraceWorkspace::default();
        for round in 0..30 {
            let middle = somewhere(&surface, &mut random);
            let spline = around(&surface, &mut random, middle, 0.2 * surface.diagonal());
            let centre = inside_a_face(&surface, middle + 0.1 * surface.diagonal() * random.on_sphere());
            for coordinates in [Coordinates::Normal, Coordinates::Chained] {
                let finder = &mut workspace.finder;
                let copied = SplineClip::copy(&surface, finder, &[&spline], &centre, None, coordinates).unwrap();
                let pasted = copied.clip.paste(&surface, finder, &Paste::at(centre)).unwrap();
                assert!(pasted.clipped.is_empty() && pasted.splines.len() == 1, "{m} {round} {:?}", pasted.clipped);
                let copy = &pasted.splines[0];
                let off = farthest(&controls(&surface, copy), &controls(&surface, &spline));
                assert!(off < 1e-9 * surface.diagonal(), "mesh {m} {round} {coordinates:?}: {off}");
                let [a, b] = [&spline, copy].map(|s| s.trace(&surface, &mut TraceWorkspace::default(), None).unwrap());
                let off = b.positions().iter().map(|p| a.nearest(&surface, *p).unwrap().distance).fold(0.0, f64::max);
                assert!(off < 1e-8 * surface.diagonal(), "mesh {m} {round} {coordinates:?}: {off}");
                assert!(smooth_everywhere(&surface, copy) && copy.is_closed());
            }
        }
    }
}

#[test]
fn a_copy_is_put_down_elsewhere_turned_scaled_and_clipped() {
    let [small, large] = [1.0, 4.0].map(|size| {
        let mut mesh = shapes::grid(20, 20, size, size);
        mesh.positions.iter_mut().for_each(|p| *p += DVec3::new(0.0, 0.0, size));
        built(&mesh)
    });
    let mut finder = PathFinder::new();
    let place = |x: f64, y: f64| at(&small, DVec3::new(x, y, 1.0));
    let points = [place(0.413, 0.527), place(0.611, 0.631), place(0.547, 0.389)];
    let spline = Spline::smooth_through(&small, &mut finder, &points, false).unwrap();
    let spline = spline.with_scheme(Scheme::lane_riesenfeld());
    let centre = place(0.507, 0.489);
    let axis = small.tangent(&centre, DVec3::X).unwrap();
    let copied =
        SplineClip::copy(&small, &mut finder, &[&spline, &spline], &centre, Some(&axis), Coordinates::Normal).unwrap();
    assert!((copied.clip.ratio(&large) - 4.0).abs() < 1e-12 && copied.clip.len() == 2);
    let to = at(&large, DVec3::new(2.03, 1.91, 4.0));
    let paste = Paste {
        axis: Some(large.tangent(&to, DVec3::X).unwrap()),
        turn: 0.7,
        scale: copied.clip.ratio(&large),
        ..Paste::at(to)
    };
    let pasted = copied.clip.paste(&large, &mut finder, &paste).unwrap();
    let [from, goal] = [small.position(&centre), large.position(&to)];
    let matrix = 4.0 * DMat2::from_angle(0.7);
    let expected: Vec<_> =
        controls(&small, &spline).iter().map(|p| goal + (matrix * (*p - from).truncate()).extend(0.0)).collect();
    for copy in &pasted.splines {
        assert!(farthest(&controls(&large, copy), &expected) < 1e-10);
        assert_eq!((copy.scheme(), copy.is_closed()), (spline.scheme(), false));
    }
    // At the boundary some of it has no room.
    let edge = at(&large, DVec3::new(3.9, 1.91, 4.0));
    let pasted =
        copied.clip.paste(&large, &mut finder, &Paste { at: edge, axis: None, turn: 0.1, scale: 4.0 }).unwrap();
    assert!(!pasted.clipped.is_empty() && pasted.clipped.len() < 6);
    for [s, a] in pasted.clipped {
        let p = large.position(&pasted.splines[s as usize].anchors()[a as usize].point());
        let room = p.truncate().min_element().min((DVec2::splat(4.0) - p.truncate()).min_element());
        assert!(room.abs() < 1e-12, "{p}");
    }
}

#[cfg(feature = "document")]
#[test]
fn transforms_and_clips_are_plain_data() {
    let surface = built(&shapes::icosphere(4));
    let mut finder = PathFinder::new();
    let spline = spline_on(&surface, &[DVec3::X, DVec3::Y, DVec3::Z], true);
    let centre = at(&surface, DVec3::ONE);
    let edit = SplineEdit::Transform(SelectionTransform::rotation(centre, 0.3).of([2, 0]).chained());
    let read: SplineEdit = ron::from_str(&ron::to_string(&edit).unwrap()).unwrap();
    assert_eq!(read, edit);
    let clip = SplineClip::copy(&surface, &mut finder, &[&spline], &centre, None, Coordinates::Chained).unwrap().clip;
    let text = ron::to_string(&clip).unwrap();
    let read: SplineClip = ron::from_str(&text).unwrap();
    assert_eq!(read, clip);
    // A document may say anything, also that every anchor is counted from another.
    for odd in [text.replace("Centre", "Before"), text.replace("Centre", "Behind")] {
        let odd: SplineClip = ron::from_str(&odd).unwrap();
        let pasted = odd.paste(&surface, &mut finder, &Paste::at(centre)).unwrap();
        assert!(!pasted.clipped.is_empty());
    }
}
