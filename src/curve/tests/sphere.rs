//! Schemes on finer and finer icospheres approach those of the smooth sphere.

use glam::DVec3;

use super::*;
use crate::curve::*;

/// The point at a share of the great circle between two points.
fn average(a: DVec3, b: DVec3, share: f64) -> DVec3 {
    let angle = a.angle_between(b);
    if angle == 0.0 {
        return a;
    }
    (((1.0 - share) * angle).sin() * a + (share * angle).sin() * b) / angle.sin()
}

fn direct([a, b, c, d]: [DVec3; 4], t: f64) -> DVec3 {
    let on = |p, q| average(p, q, t);
    let [e, f, g] = [on(a, b), on(b, c), on(c, d)];
    on(on(e, f), on(f, g))
}

fn recursive([a, b, c, d]: [DVec3; 4], t: f64) -> DVec3 {
    let (mut polygon, mut t) = ([a, b, c, d], t);
    for _ in 0..25 {
        let [a, b, c, d] = polygon;
        let on = |p, q| average(p, q, 0.5);
        let [e, f, g] = [on(a, b), on(b, c), on(c, d)];
        let [h, i] = [on(e, f), on(f, g)];
        let x = on(h, i);
        (polygon, t) = if t < 0.5 { ([a, e, h, x], 2.0 * t) } else { ([x, i, g, d], 2.0 * t - 1.0) };
    }
    direct(polygon, t)
}

/// Control points after some levels of Lane–Riesenfeld subdivision (two at least).
fn subdivided(polygon: [DVec3; 4], levels: u32) -> Vec<DVec3> {
    let [a, b, c, d] = polygon;
    let on = average;
    let mut p = vec![a, on(a, b, 0.5), on(b, c, 0.5), on(c, d, 0.5), d];
    p = vec![
        p[0],
        on(p[0], p[1], 0.5),
        on(p[1], p[2], 0.25),
        on(on(p[1], p[2], 0.625), on(p[2], p[3], 0.375), 0.5),
        on(p[2], p[3], 0.75),
        on(p[3], p[4], 0.5),
        p[4],
    ];
    for _ in 2..levels {
        let n = p.len() - 3;
        let left = |p: &[DVec3]| {
            [p[0], on(p[0], p[1], 0.5), on(p[1], p[2], 0.25), on(on(p[1], p[2], 0.625), on(p[2], p[3], 0.25), 0.5)]
        };
        let mut next = left(&p).to_vec();
        for j in 2..n {
            next.push(on(p[j], p[j + 1], 0.5));
            if j + 1 < n {
                next.push(on(on(p[j], p[j + 1], 0.75), on(p[j + 1], p[j + 2], 0.25), 0.5));
            }
        }
        let mirrored: Vec<DVec3> = p.iter().rev().copied().collect();
        next.extend(left(&mirrored).iter().rev());
        p = next;
    }
    p
}

/// The limit of Lane–Riesenfeld subdivision at t = k / 64.
fn limit(polygon: [DVec3; 4], k: usize) -> DVec3 {
    let p = subdivided(polygon, 11);
    let i = k * ((p.len() - 3) / 64) + 1;
    match k {
        0 => p[0],
        64 => p[p.len() - 1],
        _ => average(average(p[i - 1], p[i], 2.0 / 3.0), average(p[i], p[i + 1], 1.0 / 3.0), 0.5),
    }
}

fn polygon(figure: [[f64; 3]; 4]) -> [DVec3; 4] {
    figure.map(|p| DVec3::from(p).normalize())
}

fn length(p: &[DVec3]) -> f64 {
    p.windows(2).map(|w| w[0].angle_between(w[1])).sum()
}

#[test]
fn references_have_the_published_figures() {
    for (found, expected) in [
        (direct(polygon(S2), 0.25), [0.838_919_472_6, 0.475_820_351_2, 0.264_214_140_2]),
        (direct(polygon(S2), 0.5), [0.512_551_755_5, 0.709_258_079_3, 0.483_987_267_3]),
        (direct(polygon(S2), 0.3), [0.779_638_983_7, 0.543_323_599_9, 0.311_388_055_2]),
        (recursive(polygon(S2), 0.25), [0.839_041_457_2, 0.475_811_904_8, 0.263_841_741_0]),
        (recursive(polygon(S2), 0.5), [0.512_551_755_5, 0.709_258_079_3, 0.483_987_267_3]),
        (recursive(polygon(S2), 0.3), [0.779_815_084_9, 0.543_318_542_1, 0.310_955_616_0]),
        (limit(polygon(S2), 32), [0.512_487_417_7, 0.709_438_082_7, 0.483_791_539_3]),
        (direct(polygon(S1), 0.25), [0.617_183_042_1, 0.736_937_091_1, 0.275_696_964_5]),
        (recursive(polygon(S1), 0.25), [0.629_412_873_1, 0.732_928_908_9, 0.258_175_617_9]),
        (recursive(polygon(S1), 0.5), [0.129_712_649_0, 0.731_870_126_8, 0.668_984_862_5]),
        (limit(polygon(S1), 32), [0.129_523_255_9, 0.732_037_212_0, 0.668_838_729_8]),
    ] {
        assert!(found.distance(DVec3::from(expected)) < 1e-9, "{found} for {expected:?}");
    }
    for (figure, six, ten) in [(S2, 1.806_006_906, 1.805_879_364), (S1, 2.507_708_565, 2.507_034_163)] {
        assert!((length(&subdivided(polygon(figure), 6)) - six).abs() < 1e-8);
        assert!((length(&subdivided(polygon(figure), 10)) - ten).abs() < 1e-8);
    }
}

/// Least-squares slope of log₂ of errors, per step.
fn slope(errors: &[f64]) -> f64 {
    let n = errors.len() as f64;
    let mean_x = (n - 1.0) / 2.0;
    let logs: Vec<f64> = errors.iter().map(|e| -e.log2()).collect();
    let mean_y = logs.iter().sum::<f64>() / n;
    let (mut xy, mut xx) = (0.0, 0.0);
    for (i, y) in logs.iter().enumerate() {
        xy += (i as f64 - mean_x) * (y - mean_y);
        xx += (i as f64 - mean_x).powi(2);
    }
    xy / xx
}

/// Root mean square of the errors that `square` gives the squares of, on icospheres of edges halved again and again.
fn errors(square: impl Fn(&Surface) -> f64) -> Vec<f64> {
    // Without optimisation the finest one takes long.
    let finest = if cfg!(debug_assertions) { 6 } else { 7 };
    (3..=finest).map(|level| square(&built(&shapes::icosphere(level))).sqrt()).collect()
}

/// Turns that have nothing to do with the icosphere's symmetries.
fn turns(count: usize) -> Vec<glam::DQuat> {
    let mut random = Random(3);
    (0..count).map(|_| glam::DQuat::from_axis_angle(random.on_sphere(), 6.0 * random.next())).collect()
}

/// What polyhedral geodesics themselves allow: the curvature they meet is that of single vertices, which push them aside
/// now left, now right. The metrics differ by h², their slopes by h, and a random walk of steps h over 1/h vertices leads
/// away by h^1.5.
#[test]
fn points_of_single_geodesics_approach_by_the_power_of_one_and_a_half() {
    let mut random = Random(8);
    let pairs: Vec<[DVec3; 2]> = (0..200).map(|_| [random.on_sphere(), random.on_sphere()]).collect();
    let near = |[a, b]: &&[DVec3; 2]| a.angle_between(*b) < 2.2;
    let errors = errors(|surface| {
        let square = |[a, b]: &[DVec3; 2]| {
            let path = surface.shortest_path(&at(surface, *a), &at(surface, *b)).unwrap();
            let found = surface.position(&path.at(surface, 0.5).unwrap()).normalize();
            found.distance_squared(average(*a, *b, 0.5))
        };
        pairs.iter().filter(near).map(square).sum::<f64>() / pairs.iter().filter(near).count() as f64
    });
    let slope = slope(&errors);
    assert!((1.3..2.2).contains(&slope), "{slope} {errors:?}");
}

/// Curves approach no slower than the geodesics they are made of.
#[test]
fn curves_approach_the_smooth_ones() {
    type Reference = fn([DVec3; 4], usize) -> DVec3;
    let schemes: [(Scheme, Reference); 3] = [
        (Scheme::de_casteljau(), |p, k| recursive(p, k as f64 / 64.0)),
        (Scheme::lane_riesenfeld(), limit),
        (Scheme::direct(), |p, k| direct(p, k as f64 / 64.0)),
    ];
    let turns = turns(if cfg!(debug_assertions) { 4 } else { 12 });
    for (figure, (scheme, reference)) in [S1, S2].into_iter().flat_map(|f| schemes.map(|s| (f, s))) {
        let smooth: Vec<DVec3> = (0..64).map(|k| reference(polygon(figure), k)).collect();
        let errors = errors(|surface| {
            let mut tracer = Tracer::new(surface);
            let mut sum = 0.0;
            for turn in &turns {
                let points = polygon(figure).map(|p| at(surface, *turn * p));
                for (k, expected) in smooth.iter().enumerate() {
                    let found = tracer.evaluate(&points, &scheme, k as f64 / 64.0).unwrap();
                    sum += surface.position(&found).normalize().distance_squared(*turn * *expected);
                }
            }
            sum / (64 * turns.len()) as f64
        });
        let slope = slope(&errors);
        println!("{} slope {slope:.3} {errors:?}", scheme.method.name());
        assert!((1.3..2.2).contains(&slope) && errors[3] < 2e-4, "{scheme:?} {slope} {errors:?}");
    }
}

#[test]
fn lengths() {
    let surface = built(&shapes::icosphere(6));
    for (figure, expected) in [(S2, 1.806_006_906), (S1, 2.507_708_565)] {
        let points = polygon(figure).map(|p| at(&surface, tilted(p.into())));
        let length = Tracer::new(&surface).trace(&points, &Scheme::lane_riesenfeld()).unwrap().length();
        assert!((length - expected).abs() < 1e-3, "{length} for {expected}");
    }
}
