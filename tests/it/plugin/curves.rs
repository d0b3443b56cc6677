//! Traces as curves of `bevy_math`.

use bevy::math::curve::Interval;
use bevy::prelude::*;
use bevy_surface_splines::plugin::testing::headless_app;
use bevy_surface_splines::prelude::*;
use glam::DVec3;

use super::{spawn_spline, spawn_surface, surface_of};

/// A sphere with a spline of five anchors, its trace and its curve.
fn sphere(scheme: Scheme, closed: bool) -> (App, Entity, Entity, SplineTrace, TraceCurve) {
    let mut app = headless_app();
    let surface = spawn_surface(&mut app, Sphere::new(1.0).mesh().uv(48, 24));
    let positions = [Vec3::X, Vec3::new(0.5, 0.8, 0.3), Vec3::Z, Vec3::new(-0.6, -0.4, 0.7), Vec3::new(-0.9, 0.1, 0.0)];
    let source = SplineSource::smooth_through(positions).scheme(scheme);
    let spline = spawn_spline(&mut app, surface, if closed { source.closed() } else { source });
    let trace = app.world().get::<SplineTrace>(spline).expect("a trace").clone();
    let curve = trace.curve().expect("a curve");
    (app, surface, spline, trace, curve)
}

#[test]
fn a_curve_runs_where_the_trace_does() {
    for (scheme, closed) in [
        (Scheme::lane_riesenfeld(), false),
        (Scheme::de_casteljau().adaptive(), true),
        (Scheme::b_spline(), true),
        (Scheme::quadratic_b_spline(), false),
    ] {
        let (app, surface, _, trace, curve) = sphere(scheme, closed);
        let surface = surface_of(&app, surface);
        let count = trace.segments().len() as f32;
        assert_eq!(curve.domain(), Interval::new(0.0, count).expect("an interval"));
        let at = |t: f32| {
            let point = trace.point_at(surface, SplineT(f64::from(t))).expect("a point");
            surface.position(&point).as_vec3()
        };
        let parameters: Vec<f32> = (0..=500u16).map(|i| f32::from(i) / 500.0 * count).collect();
        for (t, position) in parameters.iter().zip(curve.sample_iter(parameters.iter().copied())) {
            assert!(position.expect("inside").distance(at(*t)) < 1e-6, "{scheme:?} at {t}");
        }
        // Outside there is nothing, and clamping gives the ends.
        assert_eq!(curve.sample_iter([-0.1, count + 0.1, f32::NAN]).collect::<Vec<_>>(), [None; 3]);
        let ends = [trace.polyline()[0], trace.polyline()[trace.polyline().len() - 1]];
        assert_eq!([curve.sample_clamped(-1.0), curve.sample_clamped(1e9)], ends);
        assert!(curve.sample_unchecked(f32::NAN).is_nan());
    }
}

#[test]
fn a_curve_passes_through_the_vertices_of_the_trace() {
    let (.., trace, curve) = sphere(Scheme::de_casteljau(), false);
    let mut exact = 0;
    for (i, segment) in trace.segments().iter().enumerate() {
        for (point, t) in segment.points().iter().zip(segment.parameters()) {
            let t = i as f64 + t;
            let position = trace.trace().position_at(SplineT(t)).expect("a position").as_vec3();
            assert!(trace.polyline().contains(&position), "{point:?} is a vertex");
            // Parameters that single precision can hold are met exactly.
            if f64::from(t as f32) == t {
                assert_eq!(curve.sample(t as f32), Some(position));
                exact += 1;
            }
        }
    }
    assert!(exact > 4 * 16, "halves, quarters … are held: {exact}");
}

#[test]
fn what_bevy_does_with_curves_works_with_it() {
    let (.., trace, curve) = sphere(Scheme::lane_riesenfeld(), false);
    // Backwards, and by shares of the whole.
    let whole = curve.clone().reparametrize_linear(Interval::UNIT).expect("bounded");
    assert_eq!(whole.domain(), Interval::UNIT);
    assert!(whole.sample_clamped(0.5).distance(curve.sample_clamped(2.0)) < 1e-6);
    let eased = curve.clone().reparametrize(Interval::UNIT, |s| 4.0 * s * s);
    assert_eq!(eased.sample(0.5), curve.sample(1.0));
    let back = curve.clone().reverse().expect("bounded");
    assert!(back.sample_clamped(1.0).distance(curve.sample_clamped(3.0)) < 1e-6);
    // As an object, moved into the world, and out of reach of later edits.
    let boxed: Box<dyn Curve<Vec3> + Send + Sync> = Box::new(curve.clone().map(|p| 2.0 * p + Vec3::Y));
    assert_eq!(boxed.sample(1.5), curve.sample(1.5).map(|p| 2.0 * p + Vec3::Y));
    // Its length is the trace's.
    let samples: Vec<Vec3> = curve.samples(20_000).expect("bounded").collect();
    let length: f64 = samples.windows(2).map(|p| f64::from(p[0].distance(p[1]))).sum();
    assert!((length / trace.length() - 1.0).abs() < 1e-3, "{length} is not {}", trace.length());
    // Chords of the vertices alone fall short a little.
    let chords: f64 = trace.positions().windows(2).map(|p: &[DVec3]| p[0].distance(p[1])).sum();
    assert!((chords / trace.length() - 1.0).abs() < 1e-12);
}

#[test]
fn a_curve_is_a_copy_and_an_empty_trace_has_none() {
    let (mut app, _, spline, trace, curve) = sphere(Scheme::lane_riesenfeld(), false);
    assert_eq!(trace.curve(), Some(curve.clone()));
    let before = curve.sample(0.7);
    // An open cubic B-spline of three anchors has no segment.
    for edit in
        [SplineEdit::SetScheme(Scheme::b_spline()), SplineEdit::Delete { anchor: 4 }, SplineEdit::Delete { anchor: 0 }]
    {
        app.world_mut().write_message(EditSpline::new(spline, edit));
    }
    app.update();
    let trace = app.world().get::<SplineTrace>(spline).expect("a trace");
    assert_eq!((trace.segments().len(), trace.curve()), (0, None));
    assert_eq!((curve.sample(0.7), trace.pieces().count()), (before, 0));
}
