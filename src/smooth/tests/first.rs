//! First looks.
use super::*;
use crate::geodesic::{PathFinder, PathQuality};
use crate::surface::{FaceId, shapes};

/// A random jagged line: a walk on faces without immediate return.
pub(crate) fn jagged(surface: &Surface, random: &mut Random, steps: usize) -> SurfacePolyline {
    use crate::surface::HalfEdge;
    let mut strip = crate::smooth::strip::Strip::default();
    let face = (random.word() % surface.triangles.len() as u64) as u32;
    let center = |face| crate::surface::InnerPoint { face, weights: [1.0 / 3.0; 3] };
    strip.start = center(face);
    let mut here = HalfEdge::new(face, 0);
    let mut first = true;
    for _ in 0..steps {
        let mut options: Vec<HalfEdge> = vec![here.next(), here.prev()];
        if first {
            options.push(here);
        }
        options.retain(|h| surface.twin(*h).is_some());
        if options.is_empty() {
            break;
        }
        let h = options[(random.word() % options.len() as u64) as usize];
        strip.push(surface, h, 0.1 + 0.8 * random.next(), 0.0, false);
        here = surface.twin(h);
        first = false;
    }
    strip.end = center(here.face());
    SurfacePolyline::of(surface, strip).unwrap()
}

#[test]
fn look() {
    let _ = (PathQuality::Default, FaceId(0), PathFinder::new());
    for (name, mesh) in [
        ("grid", shapes::grid(60, 60, 1.0, 1.0)),
        ("sphere", shapes::icosphere(5)),
        ("torus", shapes::torus(2.0, 0.8, 100, 50)),
    ] {
        let surface = built(&mesh);
        let mut workspace = SmoothWorkspace::default();
        let mut random = Random(5);
        for mode in [
            SmoothingMode::Geodesic,
            SmoothingMode::Stencil { scale: 1.0, passes: 50 },
            SmoothingMode::Stencil { scale: 0.5, passes: 5 },
            SmoothingMode::Stencil { scale: 1.0, passes: 5 },
            SmoothingMode::Stencil { scale: 0.0, passes: 5 },
            SmoothingMode::Budget { share: 0.25 },
            SmoothingMode::Tether { closeness: 0.1 },
            SmoothingMode::Tether { closeness: 10.0 },
            SmoothingMode::Tether { closeness: 1000.0 },
            SmoothingMode::Lift { weight: 1.0 },
            SmoothingMode::Lift { weight: 100.0 },
            SmoothingMode::Conformal { weight: 10.0 },
        ] {
            random.0 = 5;
            let mut sums = [0.0; 8];
            let mut worst = 0.0_f64;
            let begun = cpu_time::ThreadTime::now();
            let mut failed = 0;
            for _ in 0..20 {
                let line = jagged(&surface, &mut random, 200);
                match smooth(&surface, &mut workspace, &line, &Smoothing::by(mode)) {
                    Ok(s) => {
                        let m = surface.mean_edge[0];
                        for (sum, x) in sums.iter_mut().zip([
                            s.before.length / m,
                            s.after.length / m,
                            s.before.total_turn,
                            s.after.total_turn,
                            s.before.square_curvature * m,
                            s.after.square_curvature * m,
                            f64::from(s.rounds),
                            f64::from(s.steps),
                        ]) {
                            *sum += x / 20.0;
                        }
                        worst = worst.max(s.after.max_distance / m);
                        if s.met_bound {
                            failed += 1;
                        }
                    }
                    Err(e) => {
                        println!("{e}");
                        failed += 100;
                    }
                }
            }
            println!(
                "{name} {:<10} len {:.1}->{:.1} turn {:.1}->{:.2} sq {:.1}->{:.3} rounds {:.1} steps {:.0} maxd {:.2} ms {:.2} failed {failed}",
                mode.name(),
                sums[0],
                sums[1],
                sums[2],
                sums[3],
                sums[4],
                sums[5],
                sums[6],
                sums[7],
                worst,
                begun.elapsed().as_secs_f64() * 50.0
            );
        }
    }
}
