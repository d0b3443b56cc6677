//! The drawings of the corpus, counted independently; export and import again.

use std::time::Instant;

use bevy_surface_splines::vector::{Drawing, SegmentCounts, SegmentKind, export_svg, import_svg};

use super::{corpus, table, tokens::Counts, tree};

fn counts(of: &SegmentCounts) -> Counts {
    SegmentKind::ALL.map(|kind| of[kind])
}

#[test]
fn every_segment_is_drawn_or_left_out_with_a_reason() {
    let Some(corpus) = corpus() else { return };
    let (mut wrong, mut files) = (Vec::new(), 0);
    for row in table(&corpus.join("svg.csv")) {
        let text = std::fs::read_to_string(corpus.join(&row[0])).unwrap();
        let start = Instant::now();
        let import = import_svg(text.as_bytes()).unwrap_or_else(|error| panic!("{}: {error}", row[0]));
        let (report, took) = (import.report, start.elapsed());
        let expected = tree::expected(&tree::parse(&text));
        let found = tree::Expected {
            in_paths: counts(&report.in_paths),
            in_shapes: counts(&report.in_shapes),
            in_copies: counts(&report.in_copies),
        };
        println!(
            "{}: found {}, drawn {}, left out {}, {:.1} ms",
            row[0],
            report.found().total(),
            report.drawn,
            report.segments_left_out(),
            took.as_secs_f64() * 1e3
        );
        for left in &report.left_out {
            println!("    {left}");
        }
        if found != expected {
            wrong.push(format!("{}: found {found:?}, expected {expected:?}", row[0]));
        }
        // The corpus has a table of its own.
        let listed: Vec<u64> = row[4..8].iter().map(|n| n.parse().unwrap()).collect();
        if found.in_paths[..4] != listed[..] {
            wrong.push(format!("{}: found {:?}, listed {listed:?}", row[0], found.in_paths));
        }
        let (drawn, left, all) = (counts(&report.drawn), counts(&report.segments_left_out()), counts(&report.found()));
        if (0..5).any(|kind| drawn[kind] + left[kind] != all[kind]) || !report.adds_up() {
            wrong.push(format!("{}: {drawn:?} and {left:?} are not {all:?}", row[0]));
        }
        if report.left_out.iter().any(|left| left.reason.to_string().is_empty() || left.element.is_empty()) {
            wrong.push(format!("{}: something is left out without a reason", row[0]));
        }
        // Every arc is at most four cubics, a closing is at most one, and all else is one.
        let (cubics, arcs) = (import.drawing.segment_count() as u64, drawn[SegmentKind::Arc as usize]);
        let least = report.drawn.total() - drawn[SegmentKind::Closing as usize];
        if !(least..=report.drawn.total() + 3 * arcs).contains(&cubics) {
            wrong.push(format!("{}: {cubics} cubics of {} segments", row[0], report.drawn.total()));
        }
        files += 1;
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(files, 29);
}

#[test]
fn drawings_come_back_as_they_were() {
    let Some(corpus) = corpus() else { return };
    for row in table(&corpus.join("svg.csv")) {
        let bytes = std::fs::read(corpus.join(&row[0])).unwrap();
        let first = import_svg(&bytes).unwrap().drawing;
        let text = export_svg(&first);
        let second = import_svg(text.as_bytes()).unwrap_or_else(|error| panic!("{}: {error}", row[0])).drawing;
        compare(&first, &second).unwrap_or_else(|what| panic!("{}: {what}", row[0]));
        assert_eq!(export_svg(&second), text, "{}", row[0]);
    }
}

/// Compares all but gradients' places, which come back once for each paint, bit for bit.
fn compare(a: &Drawing, b: &Drawing) -> Result<(), String> {
    if a.view_box != b.view_box || a.shapes.len() != b.shapes.len() {
        return Err(format!("{:?} {} and {:?} {}", a.view_box, a.shapes.len(), b.view_box, b.shapes.len()));
    }
    for (i, (a, b)) in a.shapes.iter().zip(&b.shapes).enumerate() {
        if a.paths != b.paths || a.id != b.id {
            return Err(format!("shape {i} differs: {a:?} {b:?}"));
        }
        let (s, t) = (&a.style, &b.style);
        let same_line = match (&s.stroke, &t.stroke) {
            (Some(s), Some(t)) => s.width == t.width && s.dashes == t.dashes && (s.cap, s.join) == (t.cap, t.join),
            (None, None) => true,
            _ => false,
        };
        if s.fill_rule != t.fill_rule || s.fill.is_some() != t.fill.is_some() || s.opacity != t.opacity || !same_line {
            return Err(format!("the style of shape {i} differs: {s:?} {t:?}"));
        }
    }
    Ok(())
}
