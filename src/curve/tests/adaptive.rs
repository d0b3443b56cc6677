//! What adaptive traces promise, measured on the traces themselves.

use super::*;
use crate::curve::*;
use crate::geodesic::inner::InnerPath;

/// The largest turn between consecutive paths of a segment.
fn largest_turn(surface: &Surface, segment: &SegmentTrace) -> f64 {
    let mut finder = PathFinder::new();
    let averager = average::Averager { surface, finder: &mut finder, quality: PathQuality::Default };
    let legs: Vec<_> = segment.paths().iter().map(|p| InnerPath::from_outer(surface, p).unwrap()).collect();
    let whole = |leg| average::Span::whole(leg);
    legs.windows(2).map(|w| averager.turn(whole(&w[0]), whole(&w[1])).abs()).fold(0.0, f64::max)
}

/// Moving the end of a piece to where its deeper neighbour begins turns the piece's last leg: the joint before that leg has to
/// be looked at again.
#[test]
fn pieces_joined_to_deeper_neighbours_stay_straight_enough() {
    let surface = built(&shapes::torus(2.0, 0.8, 48, 24));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(17);
    let mut bounds = 0;
    for _ in 0..40 {
        let polygon = [(); 4].map(|()| at(&surface, random.in_square() * 5.0 - DVec3::new(2.5, 2.5, -0.4)));
        for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld(), Scheme::lane_riesenfeld().on_curve()] {
            let trace = tracer.trace(&polygon, &scheme.adaptive()).unwrap();
            let segment = &trace.segments()[0];
            let turn = largest_turn(&surface, segment).to_degrees();
            assert!(segment.bound().is_some() || turn <= 5.0 + 1e-9, "{scheme:?}: {turn}");
            bounds += u32::from(segment.bound().is_some());
        }
    }
    assert!(bounds < 12, "{bounds}");
}

/// A leg without length between two others must not hide their turn: these polygons passed for straight.
#[test]
fn doubled_control_points_hide_no_corner() {
    let surface = built(&shapes::grid(7, 7, 1.0, 1.0));
    let mut tracer = Tracer::new(&surface);
    let [a, b, c] = [(0.11, 0.13), (0.8, 0.2), (0.77, 0.9)].map(|(x, y)| at(&surface, DVec3::new(x, y, 0.0)));
    for (polygon, bound) in [([a, b, b, c], None), ([a, b, b, a], Some(TraceBound::Length)), ([a, a, b, c], None)] {
        for scheme in [Scheme::de_casteljau(), Scheme::de_casteljau().on_curve()] {
            let exact = tracer.trace(&polygon, &scheme.with_levels(8)).unwrap().length();
            let trace = tracer.trace(&polygon, &scheme.adaptive()).unwrap();
            assert_eq!(trace.segments()[0].bound(), bound);
            assert!((trace.length() - exact).abs() < 5e-3 * exact, "{} for {exact}", trace.length());
        }
    }
}

/// A nearly straight polygon half around a cylinder was joined by the way back, on the other side: 1.8 instead of 4.5.
#[test]
fn points_on_the_curve_are_joined_the_way_the_curve_goes() {
    let surface = built(&shapes::cylinder(48, 12, 2.0));
    let mut tracer = Tracer::new(&surface);
    for reach in [1.2_f64, 1.5] {
        let polygon = [0.0, 1.0, 2.0, 3.0].map(|k| {
            let angle = k * reach;
            at(&surface, DVec3::new(angle.cos(), angle.sin(), 0.1 * angle + 0.5))
        });
        let exact = tracer.trace(&polygon, &Scheme::de_casteljau().with_levels(6)).unwrap().length();
        for scheme in [Scheme::de_casteljau(), Scheme::lane_riesenfeld()] {
            let trace = tracer.trace(&polygon, &scheme.adaptive().on_curve()).unwrap();
            assert!((trace.length() - exact).abs() < 1e-2 * exact, "{} for {exact}", trace.length());
        }
    }
}

/// Segments are traced one by one, and yet the trace is to be straight enough where they meet, and to be in one piece.
#[test]
fn segments_meet_straight_enough_and_in_one_place() {
    for mesh in [shapes::icosphere(4), super::edits::bumpy(4), shapes::torus(2.0, 0.8, 48, 24)] {
        let surface = built(&mesh);
        let mut workspace = TraceWorkspace::default();
        let mut random = Random(18);
        for round in 0..12 {
            let closed = round % 2 == 0;
            let points: Vec<_> = (0..6).map(|_| at(&surface, 2.5 * random.on_sphere())).collect();
            let smooth = Spline::smooth_through(&surface, &mut workspace.finder, &points, closed).unwrap();
            let control = Spline::b_spline(&surface, &points, closed).unwrap();
            let of = |spline: &Spline, scheme| spline.clone().with_scheme(scheme);
            for spline in [
                of(&smooth, Scheme::de_casteljau().adaptive().on_curve()),
                of(&control, Scheme::b_spline().adaptive()),
                of(&control, Scheme::b_spline().adaptive().on_curve()),
                of(&control, Scheme::b_spline().with_length(0.2 * surface.diagonal())),
            ] {
                let trace = spline.trace(&surface, &mut workspace, None).unwrap();
                let count = trace.segments().len();
                for k in 0..if closed { count } else { count - 1 } {
                    let [before, after] = [k, (k + 1) % count].map(|k| trace.segments()[k].paths());
                    let [end, start] = [before[before.len() - 1].clone(), after[0].clone()];
                    let [p, q] = [end.end(), start.start()].map(|p| surface.position(&p));
                    assert!(p.distance(q) < 1e-12, "{:?}: {}", spline.scheme(), p.distance(q));
                    if matches!(spline.scheme().sampling, Sampling::Adaptive { .. }) {
                        let [a, b] = [end, start].map(|p| InnerPath::from_outer(&surface, &p).unwrap());
                        let averager = average::Averager {
                            surface: &surface,
                            finder: &mut workspace.finder,
                            quality: PathQuality::Default,
                        };
                        let turn = piece::leg_turn(&averager, &a, &b).to_degrees();
                        assert!(turn <= 5.0 + 1e-9, "{:?}: {turn}°", spline.scheme());
                    }
                }
            }
        }
    }
}
