//! The schemes that break: that they do, and that they say so; and what points on the curve gain.

use glam::DVec3;

use super::edits::bumpy;
use super::*;
use crate::curve::*;

/// A polygon about the north pole whose legs get long: at 1 its ends are nearly on the other side.
fn spread(surface: &Surface, share: f64) -> [SurfacePoint; 4] {
    [(-1.0, -0.35), (-0.9, 0.8), (0.9, -0.75), (1.0, 0.45)].map(|(x, y)| {
        let (angle, reach) = (f64::atan2(y, x), share * f64::hypot(x, y) * 2.4);
        at(surface, DVec3::new(reach.sin() * angle.cos(), reach.sin() * angle.sin(), reach.cos()))
    })
}

/// Random polygons as large as their surfaces; on a sphere nothing is torn, since two of its points have several shortest
/// ways only where they are opposite, which two moving points happen not to be.
fn large_polygons() -> Vec<(&'static str, Surface, Vec<[SurfacePoint; 4]>)> {
    let mut random = Random(3);
    [
        ("sphere", shapes::icosphere(4)),
        ("bumpy", bumpy(4)),
        ("torus", shapes::torus(2.0, 0.8, 60, 30)),
        ("cube", shapes::cube()),
    ]
    .map(|(name, mesh)| {
        let surface = built(&mesh);
        let polygons = (0..30).map(|_| [(); 4].map(|()| at(&surface, 2.5 * random.on_sphere()))).collect();
        (name, surface, polygons)
    })
    .into()
}

#[test]
fn naive_schemes_are_torn_where_polygons_are_large() {
    for (name, surface, polygons) in large_polygons() {
        let mut tracer = Tracer::new(&surface);
        let schemes = [Scheme::direct(), Scheme::centre_of_mass(), Scheme::de_casteljau(), Scheme::lane_riesenfeld()];
        let torn = schemes.map(|scheme| {
            let mut traces = polygons.iter().map(|polygon| tracer.trace(polygon, &scheme).unwrap());
            traces
                .by_ref()
                .take(if scheme == Scheme::centre_of_mass() { 6 } else { 30 })
                .filter(|trace| !trace.segments()[0].jumps().is_empty())
                .count()
        });
        println!("{name}: of 30 direct, 6 centre of mass, 30 recursive, 30 subdivided, torn are {torn:?}");
        assert_eq!(torn[0] > 0, name != "sphere");
        assert_eq!(torn[2..], [0, 0]);
    }
}

/// A jump is a jump: at the parameter given, points as near as one likes stay apart.
#[test]
fn torn_places_are_where_they_are_said_to_be() {
    let mut found = 0;
    for (_, surface, polygons) in large_polygons() {
        let mut tracer = Tracer::new(&surface);
        for polygon in &polygons {
            let trace = tracer.trace(polygon, &Scheme::direct()).unwrap();
            for jump in trace.segments()[0].jumps() {
                let [before, behind] =
                    [-2e-5, 2e-5].map(|d| tracer.evaluate(polygon, &Scheme::direct(), jump.t + d).unwrap());
                let apart = surface.shortest_path(&before, &behind).unwrap().length();
                assert!((apart - jump.length).abs() < 0.1 * jump.length, "{jump:?} {apart}");
                found += 1;
            }
        }
    }
    assert!(found >= 5, "{found}");
}

#[test]
fn small_polygons_are_the_same_under_every_scheme() {
    let surface = built(&shapes::icosphere(6));
    let mut tracer = Tracer::new(&surface);
    let polygon = spread(&surface, 0.1);
    for k in 0..=16 {
        let t = f64::from(k) / 16.0;
        let mut place = |scheme: Scheme| surface.position(&tracer.evaluate(&polygon, &scheme, t).unwrap());
        let expected = place(Scheme::de_casteljau());
        for scheme in [Scheme::lane_riesenfeld(), Scheme::direct(), Scheme::centre_of_mass()] {
            let off = place(scheme).distance(expected);
            assert!(off < 2e-3, "{scheme:?} {t} {off}");
        }
    }
}

/// On the sphere the centre of mass of two points is between them, of symmetric ones in their middle.
#[test]
fn centres_of_mass_balance() {
    let surface = built(&shapes::icosphere(5));
    let mut tracer = Tracer::new(&surface);
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let square = corners.map(|(x, y)| at(&surface, DVec3::new(0.3 * x, 0.3 * y, 1.0).normalize()));
    let found = surface.position(&tracer.evaluate(&square, &Scheme::centre_of_mass(), 0.5).unwrap()).normalize();
    // Weights 1, 3, 3, 1: between the second and third corner's side and the middle of the square, on the axis of symmetry.
    assert!(found.y.abs() < 2e-3 && found.x < -0.05 && found.x > -0.3, "{found}");
    // The logarithms' mean is zero: that is what balance means.
    let here = at(&surface, found);
    let mut sum = DVec3::ZERO;
    for (p, w) in square.iter().zip([0.125, 0.375, 0.375, 0.125]) {
        sum += w * surface.tangent_in_space(&surface.log(&here, p).unwrap()).unwrap();
    }
    assert!(sum.length() < 2e-3, "{sum}");
}

#[test]
fn points_on_the_curve_are_nearer_to_it() {
    let surface = built(&shapes::icosphere(6));
    let mut tracer = Tracer::new(&surface);
    let polygon = S2.map(|p| at(&surface, tilted(p)));
    let mut off = |scheme: Scheme, deep: Scheme| {
        let deep = tracer.trace(&polygon, &deep.with_levels(9).on_curve()).unwrap();
        let trace = tracer.trace(&polygon, &scheme).unwrap();
        let middles = (0..400).map(|k| trace.at_distance(&surface, trace.length() * f64::from(k) / 400.0).unwrap());
        let off = middles.map(|p| deep.nearest(&surface, surface.position(&p)).unwrap().distance).fold(0.0, f64::max);
        (off, trace.segments()[0].points().len())
    };
    // De Casteljau's polygon has three legs a piece, so that one level more on the curve still has fewer points.
    let (rdc, olr) = (Scheme::de_casteljau(), Scheme::lane_riesenfeld());
    for (scheme, on_curve) in [(rdc, rdc.with_levels(5)), (olr, olr), (olr.with_levels(4), olr.with_levels(4))] {
        let (polygon, polygon_points) = off(scheme, scheme);
        let (curve, curve_points) = off(on_curve.on_curve(), scheme);
        println!(
            "{}: off by {polygon:.2e} with {polygon_points}, {curve:.2e} with {curve_points}",
            scheme.method.name()
        );
        let gain = if scheme.method == Method::DeCasteljau { 0.6 } else { 0.8 };
        assert!(curve < gain * polygon && curve_points <= polygon_points);
    }
}

/// Near the ends it is measured a little further on, and was left there, in a face that the point may not touch.
#[test]
fn derivatives_of_centres_of_mass_are_where_the_point_is() {
    let surface = built(&shapes::icosphere(5));
    let mut tracer = Tracer::new(&surface);
    let mut random = Random(6);
    for _ in 0..60 {
        let middle = random.on_sphere();
        let polygon = [(); 4].map(|()| at(&surface, middle + 0.4 * random.on_sphere()));
        for t in [0.0, 1e-12, 1.0 - 2e-4] {
            let found = tracer.curve_point(&polygon, &Scheme::centre_of_mass(), t).unwrap();
            assert!(surface.inner_tangent_at(&found.point, &found.derivative).is_ok(), "{t}");
        }
    }
}
