//! Splines fitted to drawn lines.

use glam::DVec3;

use super::{edits::bumpy, *};
use crate::curve::*;

/// Points of a random smooth curve: a walk that turns gently, through which a spline goes.
fn random_spline(surface: &Surface, random: &mut Random, segments: usize, closed: bool) -> Option<Spline> {
    let (low, high) = surface.bounds();
    let (middle, size) = (0.5 * (low + high), surface.diagonal());
    let points: Vec<_> = if random.next() < 0.5 && !closed {
        let mut point = at(surface, middle + 0.4 * size * random.on_sphere());
        let mut heading = surface.tangent(&point, random.on_sphere()).unwrap();
        let mut points = vec![point];
        for _ in 0..segments {
            heading = surface.turned(&point, &heading, 2.0 * random.next() - 1.0).unwrap();
            let walk = surface.walk(&point, &heading, size * (0.05 + 0.1 * random.next())).unwrap();
            (point, heading) = (walk.path.end(), walk.heading);
            points.push(point);
        }
        points
    } else {
        let count = if closed { segments.max(3) } else { segments + 1 };
        (0..count).map(|_| at(surface, middle + 0.4 * size * random.on_sphere())).collect()
    };
    Spline::smooth_through(surface, &mut PathFinder::new(), &points, closed).ok()
}

/// The line along a trace.
fn line_along(surface: &Surface, finder: &mut PathFinder, trace: &Trace, closed: bool) -> DrawnLine {
    let points: Vec<_> = trace.segments().iter().flat_map(|segment| segment.points().iter().copied()).collect();
    DrawnLine::through(surface, finder, &points, closed).unwrap()
}

/// Largest distance from the line, every half edge of it, to the trace: not as the fit measures it.
fn farthest_from(surface: &Surface, line: &DrawnLine, trace: &Trace) -> f64 {
    let Some(first) = line.points().first() else { return f64::INFINITY };
    let step = 0.5 * surface.mean_edge_length(first.face).unwrap();
    let mut off = 0.0_f64;
    for path in line.paths() {
        let count = (path.length() / step).ceil().max(1.0) as u32;
        for k in 0..=count {
            let p = path.at(surface, f64::from(k) / f64::from(count)).unwrap();
            off = off.max(trace.nearest(surface, surface.position(&p)).unwrap().distance);
        }
    }
    off
}

fn meshes() -> [TriangleMesh; 4] {
    [jittered_square(40), shapes::icosphere(5), shapes::torus(2.0, 0.8, 80, 40), bumpy(5)]
}

/// Fits lines along random smooth curves and judges every fit; gives the numbers of segments found for one that was there.
fn judge(surface: &Surface, seed: u64, count: usize) -> (Vec<f64>, f64) {
    let mut random = Random(seed);
    let mut workspace = TraceWorkspace::default();
    let (mut ratios, mut spent) = (Vec::new(), 0.0);
    for round in 0..4 * count {
        let closed = round % 5 == 4;
        let segments = 1 + random.below(8);
        let Some(spline) = random_spline(surface, &mut random, segments, closed) else { continue };
        let spline = spline.with_scheme(Scheme::lane_riesenfeld());
        let trace = spline.trace(surface, &mut workspace, None).unwrap();
        let line = line_along(surface, &mut workspace.finder, &trace, closed);
        let begun = cpu_time::ThreadTime::now();
        let fit = Spline::fit(surface, &mut workspace, &line, &FitOptions::default()).unwrap();
        spent += begun.elapsed().as_secs_f64();
        let off = farthest_from(surface, &line, &fit.trace);
        assert!(fit.max_distance <= 0.005 * line.length(), "seed {seed}, round {round}: {}", fit.max_distance);
        assert!(off <= fit.max_distance + 1e-9 * surface.diagonal(), "seed {seed}, round {round}: {off}");
        assert_eq!(fit.trace, fit.spline.trace(surface, &mut TraceWorkspace::default(), None).unwrap());
        assert_eq!(fit.spline.is_closed(), closed, "seed {seed}, round {round}");
        let (found, there) = (fit.spline.segment_count(), spline.segment_count());
        assert!(found <= 2 * there, "seed {seed}, round {round}: {found} segments for {there}");
        for (i, anchor) in fit.spline.anchors().iter().enumerate().filter(|(_, a)| a.join() == Join::Smooth) {
            let angle = handle_angle(surface, anchor);
            assert!((angle - std::f64::consts::PI).abs() < 1e-9, "seed {seed}, round {round}, anchor {i}: {angle}");
        }
        ratios.push(found as f64 / there as f64);
        if ratios.len() == count {
            break;
        }
    }
    (ratios, spent)
}

fn report(what: &str, mut ratios: Vec<f64>, spent: f64) {
    ratios.sort_by(f64::total_cmp);
    let count = ratios.len();
    println!(
        "{what}: {count} curves, segments for one: median {:.2}, worst {:.2}; {:.2} ms a fit",
        ratios[count / 2],
        ratios[count - 1],
        spent / count as f64 * 1e3
    );
}

#[test]
fn random_curves_are_followed_within_the_tolerance() {
    for (m, mesh) in meshes().iter().enumerate() {
        let surface = built(mesh);
        let (ratios, spent) = judge(&surface, 500 + m as u64, 125);
        assert_eq!(ratios.len(), 125);
        report(&format!("mesh {m}"), ratios, spent);
    }
}

/// Models from the corpus, of one piece and without one.
#[cfg(feature = "formats")]
#[test]
fn curves_on_scanned_models_are_followed() {
    let Some(corpus) = std::env::var_os("SURFACE_CORPUS") else {
        println!("skipped: SURFACE_CORPUS is not set");
        return;
    };
    let meshes = std::path::Path::new(&corpus).join("meshes");
    for (m, name) in ["bob_small.ply", "stanford_bunny.obj", "three_holes.obj", "hammer_scan.obj", "koala_100k.obj"]
        .iter()
        .enumerate()
    {
        let Ok(surface) = Surface::from_file(meshes.join(name)) else {
            println!("skipped: there is no {name} in the corpus");
            continue;
        };
        let (ratios, spent) = judge(&surface, 600 + m as u64, 25);
        report(name, ratios, spent);
        time_drawn_lines(&surface, name);
    }
}

/// Lines of 500 hits, drawn across a third of the model and more, with a hand that trembles a little.
#[cfg(feature = "formats")]
fn time_drawn_lines(surface: &Surface, name: &str) {
    let mut random = Random(700);
    let mut workspace = TraceWorkspace::default();
    let (mut drawn, mut spent, mut segments, mut count) = (0.0, 0.0, 0, 0);
    while count < 20 {
        let Some(spline) = random_spline(surface, &mut random, 4, false) else { continue };
        let trace = spline.trace(surface, &mut workspace, None).unwrap();
        let (length, noise) = (trace.length(), 5e-4 * trace.length());
        let hits = (0..500).map(|k| trace.at_distance(surface, f64::from(k) / 499.0 * length).unwrap());
        let hits: Vec<_> = hits.map(|p| at(surface, surface.position(&p) + noise * random.on_sphere())).collect();
        let begun = cpu_time::ThreadTime::now();
        let line = DrawnLine::through(surface, &mut workspace.finder, &hits, false).unwrap();
        drawn += begun.elapsed().as_secs_f64() * 1e3;
        let begun = cpu_time::ThreadTime::now();
        let fit = Spline::fit(surface, &mut workspace, &line, &FitOptions::default()).unwrap();
        spent += begun.elapsed().as_secs_f64() * 1e3;
        assert!(fit.straight <= 2 && fit.max_distance <= 0.005 * line.length());
        (segments, count) = (segments + fit.spline.segment_count(), count + 1);
    }
    let of_each = |sum: f64| sum / f64::from(count);
    println!(
        "{name}: lines of 500 hits joined in {:.2} ms, fitted in {:.2} ms by {:.1} segments",
        of_each(drawn),
        of_each(spent),
        of_each(segments as f64)
    );
}

fn on_plane(surface: &Surface, points: &[(f64, f64)], closed: bool) -> DrawnLine {
    let points: Vec<_> = points.iter().map(|(x, y)| at(surface, DVec3::new(*x, *y, 0.0))).collect();
    DrawnLine::through(surface, &mut PathFinder::new(), &points, closed).unwrap()
}

fn fitted(surface: &Surface, line: &DrawnLine, tolerance: f64) -> Fit {
    Spline::fit(surface, &mut TraceWorkspace::default(), line, &FitOptions::within(tolerance)).unwrap()
}

#[test]
fn corners_of_the_line_are_corners_of_the_spline() {
    let surface = built(&jittered_square(20));
    let corners = [(0.2, 0.2), (0.8, 0.25), (0.7, 0.8), (0.3, 0.7)];
    // Drawn from the middle of a side, and only then over a corner.
    let mut points = Vec::new();
    for k in 0..4 {
        let [(ax, ay), (bx, by)] = [corners[k], corners[(k + 1) % 4]];
        points.extend(
            (0..25)
                .map(|i| (f64::from(i) / 25.0, 0.04 * f64::from(i * (25 - i)) / 625.0))
                .map(|(t, bulge)| (ax + t * (bx - ax) + bulge * (by - ay), ay + t * (by - ay) - bulge * (bx - ax))),
        );
    }
    points.rotate_left(10);
    let fit = fitted(&surface, &on_plane(&surface, &points, true), 0.005);
    assert_eq!((fit.corners, fit.straight, fit.spline.segment_count()), (4, 0, 4));
    for (x, y) in corners {
        let corner = DVec3::new(x, y, 0.0);
        let found = fit.spline.anchors().iter().find(|a| surface.position(&a.point()).distance(corner) < 1e-12);
        assert_eq!(found.map(|a| a.join()), Some(Join::Corner));
    }
    // A tight bend is none.
    let bend: Vec<_> = (0..=60)
        .map(|k| match k {
            0..20 => (0.2 + 0.02 * f64::from(k), 0.4),
            20..=40 => {
                let a = std::f64::consts::PI * (f64::from(k - 20) / 20.0 - 0.5);
                (0.6 + 0.03 * a.cos(), 0.43 + 0.03 * a.sin())
            }
            _ => (0.6 - 0.02 * f64::from(k - 40), 0.46),
        })
        .collect();
    let fit = fitted(&surface, &on_plane(&surface, &bend, false), 0.005);
    assert_eq!((fit.corners, fit.straight), (0, 0));
    assert!(fit.spline.anchors()[1..].iter().rev().skip(1).all(|a| a.join() == Join::Smooth));
}

#[test]
fn straight_lines_and_circles_in_the_plane() {
    let surface = built(&jittered_square(20));
    let line: Vec<_> = (0..=50).map(|k| (0.1 + 0.016 * f64::from(k), 0.2 + 0.01 * f64::from(k))).collect();
    let fit = fitted(&surface, &on_plane(&surface, &line, false), 1e-9);
    assert_eq!(fit.spline.segment_count(), 1);
    let circle: Vec<_> = (0..200)
        .map(|k| f64::from(k) / 200.0 * std::f64::consts::TAU)
        .map(|a| (0.5 + 0.4 * a.cos(), 0.5 + 0.4 * a.sin()))
        .collect();
    let fit = fitted(&surface, &on_plane(&surface, &circle, true), 0.002);
    assert!(fit.spline.segment_count() <= 4 && fit.corners == 0);
    for p in fit.trace.positions() {
        assert!((p.distance(DVec3::new(0.5, 0.5, 0.0)) - 0.4).abs() < 0.0021);
    }
}

/// A hand that trembles: by less than the tolerance it costs hardly a segment, by more it costs many, and the end is met.
#[test]
fn noise_is_smoothed_within_the_tolerance_and_followed_beyond() {
    let surface = built(&bumpy(5));
    let mut random = Random(31);
    let mut workspace = TraceWorkspace::default();
    let mut line = |noise: f64| {
        let hits: Vec<_> = (0..500)
            .map(|k| f64::from(k) / 500.0 * 5.0)
            .map(|a| DVec3::new(a.cos(), a.sin(), 0.4 * (2.0 * a).sin()) + noise * random.on_sphere())
            .map(|p| at(&surface, p))
            .collect();
        DrawnLine::through(&surface, &mut PathFinder::new(), &hits, false).unwrap()
    };
    let (calm, trembling) = (line(0.0), line(0.004));
    let smooth = fitted(&surface, &calm, 0.02).spline.segment_count();
    let rough = Spline::fit(&surface, &mut workspace, &trembling, &FitOptions::within(0.02)).unwrap();
    assert!(rough.straight == 0 && rough.spline.segment_count() <= 2 * smooth, "{smooth} {rough:?}");
    let exact = Spline::fit(&surface, &mut workspace, &trembling, &FitOptions::within(1e-4)).unwrap();
    assert!(exact.max_distance <= 1e-4 && exact.spline.segment_count() < trembling.points().len());
    assert!(farthest_from(&surface, &trembling, &exact.trace) <= 1e-4);
}

#[test]
fn odd_lines_and_options_are_refused_in_words() {
    let surface = built(&shapes::icosphere(3));
    let mut workspace = TraceWorkspace::default();
    let p = at(&surface, DVec3::X);
    let line = DrawnLine::through(&surface, &mut workspace.finder, &[p, at(&surface, DVec3::Y)], true).unwrap();
    assert!(!line.is_closed());
    let fit = Spline::fit(&surface, &mut workspace, &line, &FitOptions::default()).unwrap();
    assert_eq!(fit.spline.segment_count(), 1);
    let mut fails = |line: &DrawnLine, options: FitOptions| {
        let error = Spline::fit(&surface, &mut workspace, line, &options).unwrap_err();
        assert!(!error.to_string().is_empty());
        error
    };
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(fails(&line, FitOptions::within(tolerance)), FitError::Options(_)));
    }
    let b_spline = FitOptions { scheme: Scheme::b_spline(), ..FitOptions::default() };
    assert!(matches!(fails(&line, b_spline), FitError::Options(_)));
    let angle = FitOptions { corner_angle: f64::NAN, ..FitOptions::default() };
    assert!(matches!(fails(&line, angle), FitError::Options(_)));
    assert_eq!(fails(&DrawnLine::default(), FitOptions::default()), FitError::TooFewPoints { count: 0 });
    let one = DrawnLine::through(&surface, &mut PathFinder::new(), &[p, p], false).unwrap();
    assert_eq!(fails(&one, FitOptions::default()), FitError::TooFewPoints { count: 1 });
    // Drawn on another surface.
    let other = built(&shapes::icosphere(5));
    let points = [DVec3::X, DVec3::Y, DVec3::Z].map(|p| at(&other, p));
    let foreign = DrawnLine::through(&other, &mut PathFinder::new(), &points, true).unwrap();
    fails(&foreign, FitOptions::default());
    // A tolerance below rounding is met or refused, and no corner angle is too odd.
    for options in [
        FitOptions::within(1e-300),
        FitOptions { corner_angle: -1.0, ..FitOptions::default() },
        FitOptions { corner_angle: f64::INFINITY, ..FitOptions::within(1e300) },
    ] {
        let _ = Spline::fit(&surface, &mut TraceWorkspace::default(), &line, &options);
    }
}

/// Lines that nobody draws on purpose: they are followed, with many segments, and in the end.
#[test]
fn wild_lines_are_followed_too() {
    let mut random = Random(41);
    let mut outcomes = [0; 2];
    for (m, mesh) in [shapes::cube(), shapes::cone(5, 3, 0.4), shapes::icosphere(3), shapes::torus(2.0, 0.8, 9, 5)]
        .iter()
        .enumerate()
    {
        let surface = built(mesh);
        let (low, high) = surface.bounds();
        let [p, q] = [(); 2].map(|()| at(&surface, low + (high - low) * random.on_sphere().abs()));
        let anywhere: Vec<_> = (0..60).map(|_| at(&surface, 0.5 * (low + high) + 2.0 * random.on_sphere())).collect();
        let to_and_fro: Vec<_> = (0..30).map(|k| if k % 2 == 0 { p } else { q }).collect();
        let slow: Vec<_> = (0..200)
            .map(|k| {
                at(
                    &surface,
                    anywhere.iter().map(|p| surface.position(p)).nth(k / 20).unwrap() + 0.1 * random.on_sphere(),
                )
            })
            .collect();
        let vertices: Vec<_> =
            (0..40).map(|_| at(&surface, surface.positions[random.below(surface.positions.len())])).collect();
        for (l, points) in [anywhere, to_and_fro, slow, vertices].iter().enumerate() {
            for closed in [false, true] {
                for tolerance in [0.3, 0.01, 1e-6] {
                    let line = DrawnLine::through(&surface, &mut PathFinder::new(), points, closed).unwrap();
                    let options = FitOptions::within(tolerance * surface.diagonal());
                    match Spline::fit(&surface, &mut TraceWorkspace::default(), &line, &options) {
                        Ok(fit) => {
                            outcomes[0] += 1;
                            let off = farthest_from(&surface, &line, &fit.trace);
                            assert!(off <= tolerance * surface.diagonal(), "{m} {l} {closed} {tolerance}: {off}");
                            assert!(fit.spline.segment_count() <= line.paths().len());
                        }
                        Err(error) => {
                            println!("mesh {m}, line {l}, closed {closed}, {tolerance}: {error}");
                            assert!(matches!(error, FitError::NotReached { .. }));
                            outcomes[1] += 1;
                        }
                    }
                }
            }
        }
    }
    let [followed, refused] = outcomes;
    println!("wild lines: {followed} followed, {refused} refused");
    assert!(followed > 9 * refused);
}

/// Largest distance from the trace of some segments to another trace, as the nearest place of it says.
fn off(surface: &Surface, segments: &[std::sync::Arc<SegmentTrace>], other: &Trace) -> f64 {
    let places = segments.iter().flat_map(|segment| segment.polyline().iter());
    places.map(|p| other.nearest(surface, *p).unwrap().distance).fold(0.0, f64::max)
}

#[test]
fn deleting_with_a_fit_stays_nearer_to_the_curve() {
    let (mut sums, mut nearer, mut count) = ([0.0; 2], 0, 0);
    for (m, mesh) in meshes().iter().enumerate() {
        let surface = built(mesh);
        let seed = 800 + m as u64;
        let mut random = Random(seed);
        let mut workspace = TraceWorkspace::default();
        for round in 0..40 {
            let closed = round % 4 == 3;
            let spline = random_spline(&surface, &mut random, 3, closed).filter(|spline| spline.anchors().len() > 2);
            let Some(spline) = spline else { continue };
            let trace = spline.trace(&surface, &mut workspace, None).unwrap();
            let made = spline.deletion(&surface, &mut workspace.finder, 1).unwrap();
            let mut fitted = spline.clone();
            let back = fitted.apply(&surface, &mut workspace.finder, &SplineEdit::DeleteFitted { anchor: 1 }).unwrap();
            assert_eq!(fitted, made.spline);
            let mut plain = spline.clone();
            plain.apply(&surface, &mut workspace.finder, &SplineEdit::Delete { anchor: 1 }).unwrap();
            let traces = [&fitted, &plain].map(|s| s.trace(&surface, &mut TraceWorkspace::default(), None).unwrap());
            let old = &trace.segments()[..2];
            let length = old.iter().map(|segment| segment.length()).sum::<f64>();
            assert!((made.length - length).abs() < 1e-9 * length);
            let offs = traces.map(|t| off(&surface, old, &t));
            assert!(offs[0] <= made.deviation + 1e-9, "seed {seed} {round}: {offs:?} {}", made.deviation);
            sums = [sums[0] + offs[0] / length, sums[1] + offs[1] / length];
            nearer += usize::from(offs[0] <= offs[1] * (1.0 + 1e-9));
            count += 1;
            // Outer tangents stay, and smooth anchors smooth.
            let [a, b] = [&spline, &fitted].map(|s| s.anchors()[0].outgoing().heading());
            assert!(a.face == b.face && a.vector.distance(b.vector) < 1e-9);
            fitted.apply(&surface, &mut workspace.finder, &back).unwrap();
            assert_eq!(format!("{fitted:?}"), format!("{spline:?}"));
        }
    }
    let [with, without] = sums.map(|sum| sum / count as f64);
    println!(
        "{count} anchors deleted: {with:.4} of the length off with a fit, {without:.4} without; nearer {nearer} times"
    );
    assert!(count > 100 && with < without && nearer * 10 > count * 8, "{with} {without} {nearer} of {count}");
}

/// What was inserted and is deleted again leaves the curve.
#[test]
fn deleting_what_was_inserted_gives_the_curve_back() {
    let surface = built(&jittered_square(20));
    let mut workspace = TraceWorkspace::default();
    let mut random = Random(820);
    for round in 0..20 {
        let points = [(0.2, 0.3), (0.4, 0.7), (0.7, 0.6), (0.8, 0.3)];
        let polygon = points.map(|(x, y)| at(&surface, DVec3::new(x, y, 0.0) + 0.1 * random.in_square()));
        let spline = Spline::bezier(&surface, &mut workspace.finder, polygon).unwrap();
        let mut same = spline.clone();
        let t = SplineT(0.15 + 0.7 * random.next());
        same.apply(&surface, &mut workspace.finder, &SplineEdit::Insert { at: t }).unwrap();
        let made = same.deletion(&surface, &mut workspace.finder, 1).unwrap();
        assert!(made.deviation < 2e-3 * made.length, "{round} {t:?}: {}", made.deviation / made.length);
        for (old, new) in spline.anchors().iter().zip(made.spline.anchors()) {
            let lengths = [old, new].map(|a| a.outgoing().leg().length() + a.incoming().leg().length());
            assert!((lengths[0] - lengths[1]).abs() < 0.03 * lengths[0], "{round}: {lengths:?}");
        }
    }
}

#[test]
fn odd_deletions_do_what_plain_ones_do() {
    let surface = built(&shapes::icosphere(4));
    let mut finder = PathFinder::new();
    let spline = spline_on(&surface, &[DVec3::X, DVec3::Y, DVec3::Z], false);
    for (spline, anchor) in
        [(spline.clone(), 0), (spline.clone(), 2), (spline.clone().with_scheme(Scheme::b_spline()), 1)]
    {
        let mut plain = spline.clone();
        plain.apply(&surface, &mut finder, &SplineEdit::Delete { anchor }).unwrap();
        assert_eq!(spline.deletion(&surface, &mut finder, anchor).unwrap().spline, plain);
    }
    assert!(matches!(spline.deletion(&surface, &mut finder, 3), Err(EditError::NoSuchAnchor { .. })));
    // All in one place, and down to a loop of one anchor.
    let p = at(&surface, DVec3::X);
    let mut point = spline.clone();
    for anchor in 0..3 {
        point.apply(&surface, &mut finder, &SplineEdit::SetJoin { anchor, join: Join::Automatic }).unwrap();
        point.apply(&surface, &mut finder, &SplineEdit::MoveAnchor { anchor, to: p }).unwrap();
    }
    assert!(point.deletion(&surface, &mut finder, 1).is_ok());
    let mut loop_ = spline_on(&surface, &[DVec3::X, DVec3::Y, DVec3::Z], true);
    for _ in 0..2 {
        loop_.apply(&surface, &mut finder, &SplineEdit::DeleteFitted { anchor: 0 }).unwrap();
    }
    assert_eq!((loop_.anchors().len(), loop_.segment_count()), (1, 1));
    assert_eq!(
        loop_.apply(&surface, &mut finder, &SplineEdit::DeleteFitted { anchor: 0 }),
        Err(EditError::TooFewAnchors)
    );
}

/// A spline of many segments is followed by few.
#[test]
fn lines_along_traces_are_followed_by_fewer_segments() {
    let surface = built(&shapes::icosphere(5));
    let mut workspace = TraceWorkspace::default();
    let points: Vec<_> = (0..40)
        .map(|k| f64::from(k) / 40.0 * std::f64::consts::TAU)
        .map(|a| DVec3::new(a.cos(), a.sin(), 0.3 * (2.0 * a).sin()))
        .collect();
    for closed in [false, true] {
        let spline = spline_on(&surface, &points, closed);
        let trace = spline.trace(&surface, &mut workspace, None).unwrap();
        let line = DrawnLine::along(&trace, closed);
        assert!((line.length() - trace.length()).abs() < 1e-9 && line.is_closed() == closed);
        let fit = fitted(&surface, &line, 0.01);
        assert!(fit.spline.segment_count() <= 8 && fit.spline.is_closed() == closed && fit.straight == 0);
        assert!(off(&surface, trace.segments(), &fit.trace) <= 0.01);
    }
    assert_eq!(DrawnLine::along(&Trace::default(), true), DrawnLine::default());
}
