//! Documents: what they restore, what they refuse, how they are saved.

pub(crate) mod broken;
mod saving;
mod surfaces;

use bevy_surface_splines::curve::{HandleSide, Join, JumpPolicy, Scheme, Spline, SplineEdit, TraceWorkspace};
use bevy_surface_splines::format::document::{
    Document, DocumentError, Frame, Restored, SplineFault, SplineStyle, SurfaceReference, View,
};
use bevy_surface_splines::geodesic::PathFinder;
use bevy_surface_splines::surface::{NonManifoldEdges, Surface, SurfaceOptions, SurfacePoint, TriangleMesh, shapes};
use glam::DVec3;

/// An open shape: a torus of which a window is missing.
fn mesh(around: u32, across: u32) -> TriangleMesh {
    let mut mesh = shapes::torus(1.0, 0.45, around, across);
    let centre = |face: &[u32; 3]| face.iter().map(|v| mesh.positions[*v as usize]).sum::<DVec3>() / 3.0;
    let faces = mesh.faces.iter().filter(|face| centre(face).distance(DVec3::new(1.4, 0.0, 0.0)) > 0.25);
    mesh.faces = faces.copied().collect();
    mesh
}

fn build(mesh: &TriangleMesh) -> Surface {
    Surface::build(mesh, &SurfaceOptions::default()).unwrap()
}

/// The place at angles around the torus and across it, with weights that are no round numbers.
fn at(surface: &Surface, u: f64, v: f64) -> SurfacePoint {
    let out = 1.0 + 0.45 * v.cos();
    surface.closest_point(DVec3::new(out * u.cos(), out * u.sin(), 0.45 * v.sin())).unwrap().point
}

/// A spline of all kinds of joins, closed.
fn joined(surface: &Surface, finder: &mut PathFinder) -> Spline {
    let points = [(1.2, 0.1), (1.5, 0.6), (1.8, 0.2), (1.5, -0.5)].map(|(u, v)| at(surface, u, v));
    let mut spline = Spline::smooth_through(surface, finder, &points, true).unwrap();
    let joins = [Join::Corner, Join::Smooth, Join::Mirrored, Join::Automatic];
    for (anchor, join) in (0..).zip(joins) {
        spline.apply(surface, finder, &SplineEdit::SetJoin { anchor, join }).unwrap();
    }
    spline.with_scheme(Scheme::lane_riesenfeld().with_levels(3))
}

/// An open spline whose middle legs belong to it and go the longer way, with a handle that the boundary cuts short and one
/// that was pushed back into its anchor.
fn sticky(surface: &Surface, finder: &mut PathFinder) -> Spline {
    let polygon = [(2.6, 0.3), (2.8, 0.5), (3.4, 0.4), (3.6, 0.2)].map(|(u, v)| at(surface, u, v));
    let mut spline = Spline::bezier(surface, finder, polygon).unwrap();
    let mut apply = |edit: SplineEdit| spline.apply(surface, finder, &edit).map(drop).unwrap();
    apply(SplineEdit::SetJumps(JumpPolicy::Sticky));
    for v in [1.0, 1.8, 2.6, 3.0] {
        let to = at(surface, 3.4, v);
        apply(SplineEdit::MoveHandle { anchor: 1, side: HandleSide::Incoming, to });
    }
    let to = at(surface, 2.6, 0.3);
    apply(SplineEdit::MoveHandle { anchor: 0, side: HandleSide::Outgoing, to });
    spline.with_scheme(Scheme::de_casteljau().adaptive().on_curve())
}

/// A handle that is cut short at the window.
fn clipped(surface: &Surface, finder: &mut PathFinder) -> Spline {
    let points = [(0.5, 0.0), (0.8, 0.9)].map(|(u, v)| at(surface, u, v));
    let mut spline = Spline::smooth_through(surface, finder, &points, false).unwrap();
    let to = at(surface, 1.2, 0.0);
    let mut apply = |edit: SplineEdit| spline.apply(surface, finder, &edit).map(drop).unwrap();
    apply(SplineEdit::MoveHandle { anchor: 0, side: HandleSide::Outgoing, to });
    apply(SplineEdit::SetJoin { anchor: 0, join: Join::Mirrored });
    apply(SplineEdit::MoveHandle { anchor: 0, side: HandleSide::Outgoing, to });
    assert!(spline.anchors()[0].incoming().is_clipped(), "the window is in the way");
    spline.with_scheme(Scheme::de_casteljau().with_length(0.05))
}

fn b_spline(surface: &Surface) -> Spline {
    let points = [(4.0, 0.0), (4.3, 1.0), (4.6, 0.2)].map(|(u, v)| at(surface, u, v));
    Spline::quadratic_b_spline(surface, &points, false).unwrap()
}

fn splines(surface: &Surface) -> Vec<Spline> {
    let mut finder = PathFinder::new();
    let [joined, sticky, clipped] = [joined, sticky, clipped].map(|make| make(surface, &mut finder));
    vec![joined, sticky, clipped, b_spline(surface)]
}

/// A document that uses all that there is.
fn everything(surface: &Surface) -> Document {
    let mut reference = SurfaceReference::of(surface).at("../models/torus \"open\".obj");
    reference.options.nonmanifold_edges = NonManifoldEdges::Pair;
    reference.frame = Frame { centre: [0.1, -2.0, 1e-3], unit: 2.5 };
    let mut document = Document::new(reference);
    for (i, spline) in splines(surface).iter().enumerate() {
        let added = document.add(surface, format!("Spline {i} \\ \"ä\"\n"), spline).unwrap();
        added.style = SplineStyle { colour: [0.1, 0.2, 0.3 + 0.1 * i as f32, 1.0], width: 1.5 };
        (added.hidden, added.locked) = (i == 1, i == 2);
    }
    let target = [0.1, 0.2, -0.3];
    document.view = Some(View { target, yaw: -0.7, pitch: 0.3, distance: 4.2, orthographic: true });
    document
}

/// The document's splines on the surface it was made on, in its frame.
fn restore(document: &Document, surface: &Surface, known: &SurfaceReference) -> Result<Restored, DocumentError> {
    document.restore_as(surface, known, &mut PathFinder::new())
}

/// Every bit of a spline, as text: equality of numbers does not see the sign of zero.
fn bits(surface: &Surface, spline: &Spline) -> String {
    let mut document = Document::new(SurfaceReference::of(surface));
    document.add(surface, "", spline).unwrap();
    document.to_ron().unwrap()
}

#[test]
fn splines_come_back_bit_for_bit() {
    let surface = build(&mesh(20, 10));
    let document = everything(&surface);
    let text = document.to_ron().unwrap();
    println!("{} bytes:\n{text}", text.len());
    assert!((4_000..=8_192).contains(&text.len()), "{} bytes", text.len());
    let read = Document::from_ron(&text).unwrap();
    assert_eq!(read, document);
    assert_eq!(read.to_ron().unwrap(), text, "saved, loaded and saved");
    let restored = restore(&read, &surface, &document.surface).unwrap();
    assert!(restored.mapping.is_none());
    let originals = splines(&surface);
    let mut workspace = TraceWorkspace::default();
    for (original, restored) in originals.iter().zip(&restored.splines) {
        let restored = restored.as_ref().unwrap();
        assert_eq!(restored, original);
        assert_eq!(bits(&surface, restored), bits(&surface, original));
        let mut trace = |spline: &Spline| spline.trace(&surface, &mut workspace, None).unwrap();
        assert_eq!(trace(restored), trace(original));
    }
    // Once more from what was restored.
    let mut again = read.clone();
    again.splines.clear();
    for (spline, was) in restored.splines.iter().flatten().zip(&read.splines) {
        let added = again.add(&surface, &was.name, spline).unwrap();
        (added.style, added.hidden, added.locked) = (was.style, was.hidden, was.locked);
    }
    assert_eq!(again.to_ron().unwrap(), text);
}

#[test]
fn many_edited_splines_come_back() {
    let surface = build(&mesh(48, 24));
    let (mut finder, mut checked) = (PathFinder::new(), 0);
    let mut random = crate::Random(0xd0c);
    println!("seed 0xd0c");
    for round in 0..40 {
        let mut place = || at(&surface, 0.6 + 5.0 * random.share(), 6.2 * random.share());
        let points = [place(), place(), place(), place()];
        let mut spline = Spline::smooth_through(&surface, &mut finder, &points, round % 2 == 0).unwrap();
        if round % 4 < 2 {
            spline.apply(&surface, &mut finder, &SplineEdit::SetJumps(JumpPolicy::Sticky)).unwrap();
        }
        for anchor in 0..4 {
            let side = if random.share() < 0.5 { HandleSide::Incoming } else { HandleSide::Outgoing };
            let mut place = || at(&surface, 0.6 + 5.0 * random.share(), 6.2 * random.share());
            let edits =
                [SplineEdit::MoveHandle { anchor, side, to: place() }, SplineEdit::MoveAnchor { anchor, to: place() }];
            for edit in edits {
                spline.apply(&surface, &mut finder, &edit).unwrap();
                let mut document = Document::new(SurfaceReference::of(&surface));
                document.add(&surface, "", &spline).unwrap();
                let read = Document::from_ron(&document.to_ron().unwrap()).unwrap();
                let restored = read.restore(&surface, &mut finder).unwrap();
                let restored = restored.splines[0].as_ref().unwrap();
                assert_eq!(bits(&surface, restored), bits(&surface, &spline));
                checked += 1;
            }
        }
    }
    println!("{checked} splines");
}

#[test]
fn forged_legs_are_refused() {
    let surface = build(&mesh(20, 10));
    let mut document = Document::new(SurfaceReference::of(&surface));
    document.add(&surface, "forged", &joined(&surface, &mut PathFinder::new())).unwrap();
    let text = document.to_ron().unwrap();
    // The first crossing of the first leg that has some.
    let start = text.find("crossings: [(").unwrap() + "crossings: [(".len();
    let crossing = &text[start..start + text[start..].find(')').unwrap()];
    let [face, side, place] = crossing.split(", ").collect::<Vec<_>>()[..] else { panic!("{crossing}") };
    let other_face = face.parse::<u32>().unwrap() + 7;
    let other_side = (side.parse::<u32>().unwrap() + 1) % 3;
    let opposite = 1.0 - place.parse::<f64>().unwrap();
    for (forged, is_expected) in [
        (format!("{other_face}, {side}, {place}"), "breaks off"),
        (format!("{face}, {other_side}, {place}"), "breaks off"),
        (format!("{face}, {side}, {opposite:?}"), "long, and not"),
        (format!("4000000000, {side}, {place}"), "does not exist"),
    ] {
        let text = text.replacen(crossing, &forged, 1);
        let error = Document::from_ron(&text).unwrap().restore(&surface, &mut PathFinder::new()).unwrap_err();
        println!("{error}");
        assert!(error.to_string().contains(is_expected), "{error}");
        assert!(matches!(&error, DocumentError::Spline { index: 0, name, .. } if name == "forged"));
    }
    for (forged, field) in [
        (format!("{face}, 3, {place}"), "crossings[0]"),
        (format!("{face}, {side}, 1.0000000000000002"), "crossings[0]"),
        (format!("{face}, {side}, NaN"), "crossings[0]"),
        (format!("{face}, {side}, -1e-300"), "crossings[0]"),
        (format!("-1, {side}, {place}"), "crossings[0]"),
    ] {
        let error = Document::from_ron(&text.replacen(crossing, &forged, 1)).unwrap_err();
        println!("{error}");
        let line = text[..start].lines().count();
        assert!(
            matches!(&error, DocumentError::Content { field: found, line: l, .. } if found.contains(field) && *l == line),
            "{error}"
        );
    }
    // A handle that begins somewhere else, on a leg that is sound by itself.
    let leg = text.find("leg: Some((end").expect("a leg that begins at its anchor") + "leg: Some((".len();
    let begins = format!("{}start: Some((0, 0.25, 0.25, 0.5)), {}", &text[..leg], &text[leg..]);
    let error = Document::from_ron(&begins).unwrap().restore(&surface, &mut PathFinder::new()).unwrap_err();
    let DocumentError::Spline { fault, .. } = &error else { panic!("{error}") };
    assert!(matches!(**fault, SplineFault::Point(_)), "{error}");
}

#[test]
fn ranges_and_versions_are_checked() {
    let surface = build(&mesh(20, 10));
    let text = everything(&surface).to_ron().unwrap();
    for (what, instead, field, problem) in [
        ("pitch: 0.3", "pitch: NaN", "view.pitch", "not a number from"),
        ("pitch: 0.3", "pitch: 3.0", "view.pitch", "3.0 is not a number from -2.0 to 2.0"),
        ("distance: 4.2", "distance: 0.0", "view.distance", "not a number from"),
        ("distance: 4.2", "distance: inf", "view.distance", "not a number from"),
        ("width: 1.5", "width: -1", "splines[0].style.width", "not a number from"),
        ("colour: (0.1,", "colour: (1.1,", "splines[0].style.colour", "from 0.0 to 1.0"),
        ("Levels(3)", "Levels(300)", "splines[0].geometry.scheme.sampling", "out of bounds"),
        ("Length(0.05)", "Length(NaN)", "splines[2].geometry.scheme", "not a number"),
        ("hidden: true", "hidden: 1", "splines[1].hidden", "boolean"),
        ("hidden: true", "hiden: true", "splines[1]", "hiden"),
        ("join: Corner", "join: Cornered", "splines[0].geometry.anchors[0].join", "Cornered"),
        ("unit: 2.5", "unit: -2.5", "surface.frame.unit", "not a number from"),
        ("fingerprint: \"", "fingerprint: \"x", "surface.fingerprint", "sixteen"),
    ] {
        assert!(text.contains(what), "{what}");
        let error = Document::from_ron(&text.replacen(what, instead, 1)).unwrap_err();
        println!("{error}");
        let line = text[..text.find(what).unwrap()].lines().count();
        let DocumentError::Content { line: l, field: f, problem: p, .. } = &error else { panic!("{error}") };
        assert!((line..line + 4).contains(l) && f.starts_with(field) && p.contains(problem), "{error}");
    }
    for (version, expected) in [
        ("2", "has version 2"),
        ("99999999999999999999", "version 18446744073709551615"),
        ("0", "begins with"),
        ("-1", "begins with"),
        ("one", "begins with"),
    ] {
        let error = Document::from_ron(&text.replacen("version: 1", &format!("version: {version}"), 1)).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    // Whatever a newer version looks like.
    let newer = Document::from_ron("(version: 7, <<<").unwrap_err();
    assert!(matches!(newer, DocumentError::NewerVersion { found: 7 }), "{newer}");
    assert!(matches!(Document::from_ron("v 0 0 0").unwrap_err(), DocumentError::NoDocument { line: 1, column: 1 }));
    assert!(matches!(
        Document::from_bytes(b"(version: 1,\n \xff").unwrap_err(),
        DocumentError::Content { line: 2, column: 2, .. }
    ));
    // What could not be read again is not written.
    let mut document = everything(&surface);
    document.splines[3].style.width = f32::NAN;
    let path = std::env::temp_dir().join(format!("never_written_{}.splines.ron", std::process::id()));
    let error = document.save(&path).unwrap_err();
    assert!(error.to_string().contains("splines[3].style.width") && !path.exists(), "{error}");
}

#[test]
fn another_mesh_is_mapped_with_a_report() {
    let surface = build(&mesh(20, 10));
    let document = everything(&surface);
    let finer = build(&mesh(61, 37));
    let frame = document.surface.frame;
    let known = SurfaceReference { frame, ..SurfaceReference::of(&finer) };
    let restored = restore(&document, &finer, &known).unwrap();
    let report = restored.mapping.expect("a report");
    println!("{report}");
    assert_eq!((report.refused(), restored.splines.len()), (0, 4));
    // Chords of the coarse torus lie inside the fine one.
    assert!(report.largest_distance() < 0.1 && report.largest_distance() > 1e-6, "{report}");
    let mut workspace = TraceWorkspace::default();
    for (i, (original, mapped)) in splines(&surface).iter().zip(&restored.splines).enumerate() {
        let mapped = mapped.as_ref().unwrap();
        assert_eq!(
            (mapped.is_closed(), mapped.scheme(), mapped.jumps()),
            (original.is_closed(), original.scheme(), original.jumps())
        );
        let mut furthest = 0.0_f64;
        for (a, b) in original.anchors().iter().zip(mapped.anchors()) {
            assert_eq!(a.join(), b.join());
            let points =
                |x: &bevy_surface_splines::curve::Anchor| [x.point(), x.incoming().point(), x.outgoing().point()];
            for (p, q) in points(a).iter().zip(&points(b)).take(if a.join() == Join::Corner { 3 } else { 1 }) {
                furthest = furthest.max(surface.position(p).distance(finer.position(q)));
            }
            assert_eq!(b.middle().is_some(), a.middle().is_some());
        }
        assert!(furthest <= report.splines[i].largest_distance + 1e-7, "{furthest}");
        assert!(report.splines[i].points >= original.anchors().len());
        mapped.trace(&finer, &mut workspace, None).unwrap();
    }
    // A surface in two pieces, with anchors on both: that spline is left out, and the others are placed.
    let mut pieces = mesh(61, 37);
    let wall = |p: DVec3| (p.y.atan2(p.x)).rem_euclid(std::f64::consts::TAU);
    let positions = pieces.positions.clone();
    pieces.faces.retain(|f| f.iter().all(|v| !(1.6..1.75).contains(&wall(positions[*v as usize]))));
    pieces.faces.retain(|f| f.iter().all(|v| !(2.2..2.4).contains(&wall(positions[*v as usize]))));
    let pieces = build(&pieces);
    let known = SurfaceReference { frame, ..SurfaceReference::of(&pieces) };
    let restored = restore(&document, &pieces, &known).unwrap();
    let report = restored.mapping.expect("a report");
    println!("{report}");
    assert_eq!(restored.splines.iter().map(Option::is_some).collect::<Vec<_>>(), [false, true, true, true]);
    assert!(report.splines[0].refused.is_some() && report.refused() == 1);
    // The same mesh in another frame: nothing is mapped, lengths are measured.
    let mut scaled = mesh(20, 10);
    scaled.positions.iter_mut().for_each(|p| *p *= 10.0);
    let scaled = build(&scaled);
    let known = SurfaceReference { frame: Frame { unit: frame.unit / 10.0, ..frame }, ..document.surface.clone() };
    let restored = restore(&document, &scaled, &known).unwrap();
    assert!(restored.mapping.is_none());
    for (original, scaled) in splines(&surface).iter().zip(restored.splines.iter().flatten()) {
        for (a, b) in original.anchors().iter().zip(scaled.anchors()) {
            let lengths =
                |x: &bevy_surface_splines::curve::Anchor| [x.outgoing().leg().length(), x.incoming().wished_length()];
            for (a, b) in lengths(a).into_iter().zip(lengths(b)) {
                assert!((10.0 * a - b).abs() < 1e-9, "{a} {b}");
            }
        }
    }
}
