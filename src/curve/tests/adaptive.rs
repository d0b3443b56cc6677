//! What adaptive traces promise, measured on the traces themselves.

use super::*;
use crate::curve::*;
use crate::geodesic::inner::InnerPath;

/// The largest turn between consecutive paths of a segment.
fn largest_turn(surface: &Surface, segment: &SegmentTrace) -> f64 {
    let mut finder = PathFinder::new();
    let averager = average::Averager { surface, finder: &mut finder };
    let legs: Vec<_> = segment.paths().iter().map(|p| InnerPath::from_outer(surface, p).unwrap()).collect();
    let whole = |leg| average::Span::new(leg, 0.0, 1.0);
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
