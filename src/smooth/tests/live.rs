//! Sliders, brushes, and stopping.

use std::ops::ControlFlow;

use super::*;
use crate::surface::shapes;

fn sphere_and_line(steps: usize) -> (Surface, SurfacePolyline) {
    let surface = built(&shapes::icosphere(5));
    let line = jagged(&surface, &mut Random(51), steps);
    (surface, line)
}

#[test]
fn a_slider_gives_what_smoothing_at_once_gives_in_any_order() {
    let (surface, line) = sphere_and_line(300);
    let mut live = LiveSmoothing::new(&surface, line.clone(), Smoothing::default()).unwrap();
    assert_eq!((&live.result().line, live.result().kept), (&line, true));
    for closeness in [10.0, 0.1, 1000.0, 3.0, 10.0] {
        let at_once = smooth(&surface, &mut SmoothWorkspace::default(), &line, &Smoothing::tether(closeness)).unwrap();
        assert_eq!(live.smooth(&surface, closeness).unwrap(), &at_once, "{closeness}");
    }
    for mode in
        [SmoothingMode::Lift { weight: 1.0 }, SmoothingMode::Stencil { scale: 0.5, passes: 5 }, SmoothingMode::Geodesic]
    {
        let at_once = smooth(&surface, &mut SmoothWorkspace::default(), &line, &Smoothing::by(mode)).unwrap();
        let given = live.smooth_by(&surface, mode, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(given, &at_once, "{mode:?}");
    }
    let last = live.smooth(&surface, 10.0).unwrap().clone();
    let other = built(&shapes::icosphere(4));
    assert_eq!(live.smooth(&other, 1.0), Err(SmoothError::OtherSurface));
    assert!(live.smooth(&surface, f64::NAN).is_err());
    assert_eq!(live.result(), &last);
    // What came out is smoothed further, and another line with the same memory.
    live.take_up(&surface, last.line.clone()).unwrap();
    assert_eq!(live.given(), &last.line);
    assert!(live.smooth(&surface, 10.0).unwrap().after.total_turn <= last.after.total_turn * (1.0 + 1e-9));
}

/// Closed lines, whose seam moves about while they are smoothed.
#[test]
fn a_slider_over_closed_lines_gives_what_smoothing_at_once_gives() {
    let surface = built(&shapes::icosphere(4));
    let mut random = Random(52);
    let mut live: Option<LiveSmoothing> = None;
    for _ in 0..6 {
        let mut tremor = || 0.3 * (random.next() - 0.5);
        let around = (0..90).map(|k| f64::from(k) * std::f64::consts::TAU / 90.0);
        let line =
            ring(&surface, around.map(|a| DVec3::new(a.cos() + tremor(), a.sin() + tremor(), (3.0 * a).sin() * 0.3)));
        let live = match &mut live {
            Some(live) => {
                live.take_up(&surface, line.clone()).unwrap();
                live
            }
            none => none.insert(LiveSmoothing::new(&surface, line.clone(), Smoothing::default()).unwrap()),
        };
        for closeness in [10.0, 0.1, 1000.0, 1.0] {
            let smoothing = Smoothing::tether(closeness);
            let at_once = smooth(&surface, &mut SmoothWorkspace::default(), &line, &smoothing).unwrap();
            assert_eq!(live.smooth(&surface, closeness).unwrap(), &at_once, "{closeness}");
        }
    }
}

#[test]
fn smoothing_stops_when_it_is_told_to() {
    let (surface, line) = sphere_and_line(400);
    let (mut workspace, mut out) = (SmoothWorkspace::default(), Smoothed::blank());
    for mode in [SmoothingMode::default(), SmoothingMode::Budget { share: 0.1 }, SmoothingMode::Lift { weight: 1.0 }] {
        let (mut asked, mut longest) = (0, f64::INFINITY);
        let stopped = smooth_while(&surface, &mut workspace, &line, &Smoothing::by(mode), &mut out, &mut |progress| {
            asked += 1;
            longest = progress.length.min(longest);
            assert_eq!(progress.rounds, asked);
            if asked < 3 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        assert_eq!(stopped, Err(SmoothError::Stopped), "{mode:?}");
        assert!(asked == 3 && longest <= line.length(&surface), "{mode:?}");
        assert_eq!(out, Smoothed::blank());
        // Whoever only looks on changes nothing.
        let mut watched = Smoothed::blank();
        let mut go_on = |_: &SmoothProgress| ControlFlow::Continue(());
        smooth_while(&surface, &mut workspace, &line, &Smoothing::by(mode), &mut watched, &mut go_on).unwrap();
        assert_eq!(watched, smooth(&surface, &mut workspace, &line, &Smoothing::by(mode)).unwrap());
    }
}

/// On a long line somebody is asked before the first round is done.
#[test]
fn smoothing_stops_within_a_round() {
    let (surface, line) = sphere_and_line(8_000);
    let (mut workspace, mut out) = (SmoothWorkspace::default(), Smoothed::blank());
    let smoothing = Smoothing::by(SmoothingMode::Lift { weight: 1.0 });
    let (mut rounds, mut asked) = (Vec::new(), 0);
    let mut go_on = |progress: &SmoothProgress| {
        asked += 1;
        rounds.push(progress.rounds);
        if asked < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let stopped = smooth_while(&surface, &mut workspace, &line, &smoothing, &mut out, &mut go_on);
    assert_eq!((stopped, asked), (Err(SmoothError::Stopped), 2));
    assert_eq!(rounds[0], 0, "before the first round is done");
}

#[test]
fn a_brush_moves_what_is_under_it_and_nothing_else() {
    let surface = built(&shapes::icosphere(5));
    let mut workspace = SmoothWorkspace::default();
    let tremor = |k: u32| {
        let a = 0.021 * f64::from(k);
        at(&surface, DVec3::new(a.cos(), a.sin(), if k.is_multiple_of(2) { 0.03 } else { -0.03 }))
    };
    for (count, closed) in [(120, false), (299, true)] {
        let points: Vec<_> = (0..count).map(tremor).collect();
        let line = SurfacePolyline::through(&surface, &mut workspace.finder, &points, closed).unwrap();
        let length = line.length(&surface);
        let mut weighed = Vec::new();
        for (center, strength) in [(0.5 * length, 1.0), (0.5 * length, 0.05), (0.0, 1.0)] {
            let range = SmoothRange { strength, ..SmoothRange::about(center, 0.15 * length) };
            let brushed = smooth(&surface, &mut workspace, &line, &Smoothing::default().only(range)).unwrap();
            assert!(!brushed.kept && brushed.after.total_turn < 0.95 * brushed.before.total_turn);
            weighed.push(brushed.after.total_turn);
            // Every crossing outside, by its length along the line given, is in the line that came out, bit for bit.
            let mut along = 0.0;
            let mut before = None;
            let mut stayed = 0;
            for (crossing, p) in line.crossings().iter().zip(line.positions(&surface).iter().skip(usize::from(!closed)))
            {
                if !closed && before.is_none() {
                    before = line.positions(&surface).first().copied();
                }
                along += before.map_or(0.0, |before: DVec3| before.distance(*p));
                before = Some(*p);
                if range.weight(along, length, closed) == 0.0 {
                    stayed += 1;
                    assert!(brushed.line.crossings().contains(crossing), "{along} of {length}");
                }
            }
            assert!(stayed > line.crossings().len() / 2, "{stayed}");
            assert!((0..brushed.line.crossings().len()).all(|i| !brushed.line.is_fixed(i)));
        }
        assert!(weighed[0] < weighed[1], "a brush that weighs less smooths less: {weighed:?}");
    }
    let line = jagged(&surface, &mut Random(5), 50);
    let bad = Smoothing::default().only(SmoothRange::about(f64::NAN, 1.0));
    assert!(matches!(smooth(&surface, &mut workspace, &line, &bad), Err(SmoothError::Options(_))));
    let bad = Smoothing::by(SmoothingMode::Geodesic).only(SmoothRange::about(0.0, 1.0));
    assert!(matches!(smooth(&surface, &mut workspace, &line, &bad), Err(SmoothError::Options(_))));
}

#[test]
fn bends_add_up_to_what_the_line_turns() {
    let (surface, line) = sphere_and_line(200);
    let (mut workspace, mut bends) = (SmoothWorkspace::default(), Vec::new());
    bends_into(&surface, &mut workspace, &line, &mut bends).unwrap();
    let metrics = measure(&surface, &mut workspace, &line, None).unwrap();
    let largest = bends.iter().fold(0.0_f64, |most, bend| most.max(bend.curvature.abs()));
    assert_eq!(largest, metrics.max_curvature);
    assert!(bends.windows(2).all(|pair| pair[0].distance <= pair[1].distance));
    assert!(bends.iter().all(|bend| bend.distance <= metrics.length && surface.position(&bend.point).is_finite()));
    assert!(bends.iter().map(|bend| bend.turn.abs()).sum::<f64>() <= metrics.total_turn * (1.0 + 1e-12));
}

#[cfg(feature = "document")]
#[test]
fn lines_and_settings_come_back_from_text() {
    let (surface, mut line) = sphere_and_line(100);
    line.set_fixed(7, true).unwrap();
    let text = ron::to_string(&line).unwrap();
    let back: SurfacePolyline = ron::from_str(&text).unwrap();
    assert_eq!(back, line);
    let smoothing = Smoothing::tether(3.0).only(SmoothRange::about(0.2, 0.1)).within(Envelope::Soft(0.5));
    assert_eq!(ron::from_str::<Smoothing>(&ron::to_string(&smoothing).unwrap()).unwrap(), smoothing);
    // Text that makes no line of this surface is refused when it is used, whatever is wrong with it.
    let mut workspace = SmoothWorkspace::default();
    let mut read = 0;
    for (from, to) in [("face:", "face:9"), ("at:0", "at:7"), ("side:0", "side:200")] {
        if let Ok(line) = ron::from_str::<SurfacePolyline>(&text.replacen(from, to, 40)) {
            read += 1;
            assert!(smooth(&surface, &mut workspace, &line, &Smoothing::default()).is_err(), "{to}");
            assert!(line.positions(&surface).is_empty() && line.to_drawn(&surface).is_err());
        }
    }
    assert!(read >= 2, "{read}");
}
