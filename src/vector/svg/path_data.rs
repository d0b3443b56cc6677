//! Path data: commands to segments.

use glam::{DAffine2, DVec2};
use svgtypes::{PathParser, PathSegment};

use super::report::{LeftOutReason, SegmentCounts, SegmentKind};
use crate::vector::{Added, PathBuilder};

/// What an element's geometry is: paths, and what became of its segments.
#[derive(Default)]
pub(super) struct Outline {
    pub(super) builder: PathBuilder,
    pub(super) found: SegmentCounts,
    pub(super) drawn: SegmentCounts,
    /// Segments that are not drawn.
    pub(super) left_out: Vec<(LeftOutReason, SegmentCounts)>,
}

impl Outline {
    pub(super) fn under(transform: &DAffine2) -> Self {
        Self { builder: PathBuilder::under(*transform), ..Self::default() }
    }

    /// Accounts for a segment.
    pub(super) fn count(&mut self, kind: SegmentKind, added: Added) {
        self.found[kind] += 1;
        match added {
            Added::Drawn => self.drawn[kind] += 1,
            Added::NoLength if kind == SegmentKind::Closing => self.leave_out(LeftOutReason::NothingToClose, kind),
            Added::NoLength => self.leave_out(LeftOutReason::NoLength, kind),
        }
    }

    fn leave_out(&mut self, reason: LeftOutReason, kind: SegmentKind) {
        let known = self.left_out.iter().position(|(known, _)| *known == reason);
        let place = known.unwrap_or_else(|| {
            self.left_out.push((reason, SegmentCounts::default()));
            self.left_out.len() - 1
        });
        self.left_out[place].1[kind] += 1;
    }

    pub(super) fn line_to(&mut self, to: DVec2) {
        let added = self.builder.line_to(to);
        self.count(SegmentKind::Line, added);
    }
}

/// Where the control point of the last segment was, for those that mirror it.
#[derive(Clone, Copy)]
enum Last {
    Other,
    Cubic(DVec2),
    Quadratic(DVec2),
}

/// Reads path data as far as they can be read, and hardly more than `most` segments.
pub(super) fn read(data: &str, transform: &DAffine2, most: usize) -> Outline {
    let mut outline = Outline::under(transform);
    let mut last = Last::Other;
    // `none` and nothing at all are paths without segments.
    if data.trim() == "none" {
        return outline;
    }
    for segment in PathParser::from(data) {
        if outline.found.total() > most as u64 || outline.builder.segment_count() > most {
            break;
        }
        match segment {
            Ok(segment) => last = add(&mut outline, segment, last),
            Err(error) => {
                let at = broken_at(&error, data);
                outline.left_out.push((LeftOutReason::BrokenPathData(at), SegmentCounts::default()));
                break;
            }
        }
    }
    outline
}

/// Which character the parser stumbled over, from one.
fn broken_at(error: &svgtypes::Error, data: &str) -> usize {
    use svgtypes::Error;
    match error {
        Error::UnexpectedData(at) | Error::InvalidNumber(at) | Error::InvalidString(_, at) => *at,
        Error::InvalidChar(_, at) => *at,
        _ => data.chars().count(),
    }
}

fn add(outline: &mut Outline, segment: PathSegment, last: Last) -> Last {
    let pen = outline.builder.pen();
    let point = |abs: bool, x: f64, y: f64| if abs { DVec2::new(x, y) } else { pen + DVec2::new(x, y) };
    let cubic = |outline: &mut Outline, c1: DVec2, c2: DVec2, to: DVec2| {
        let added = outline.builder.cubic_to(c1, c2, to);
        outline.count(SegmentKind::Cubic, added);
        Last::Cubic(c2)
    };
    let quadratic = |outline: &mut Outline, control: DVec2, to: DVec2| {
        let added = outline.builder.quadratic_to(control, to);
        outline.count(SegmentKind::Quadratic, added);
        Last::Quadratic(control)
    };
    match segment {
        PathSegment::MoveTo { abs, x, y } => outline.builder.move_to(point(abs, x, y)),
        PathSegment::LineTo { abs, x, y } => outline.line_to(point(abs, x, y)),
        PathSegment::HorizontalLineTo { abs, x } => outline.line_to(DVec2::new(if abs { x } else { pen.x + x }, pen.y)),
        PathSegment::VerticalLineTo { abs, y } => outline.line_to(DVec2::new(pen.x, if abs { y } else { pen.y + y })),
        PathSegment::CurveTo { abs, x1, y1, x2, y2, x, y } => {
            return cubic(outline, point(abs, x1, y1), point(abs, x2, y2), point(abs, x, y));
        }
        PathSegment::SmoothCurveTo { abs, x2, y2, x, y } => {
            let c1 = if let Last::Cubic(c) = last { 2.0 * pen - c } else { pen };
            return cubic(outline, c1, point(abs, x2, y2), point(abs, x, y));
        }
        PathSegment::Quadratic { abs, x1, y1, x, y } => {
            return quadratic(outline, point(abs, x1, y1), point(abs, x, y));
        }
        PathSegment::SmoothQuadratic { abs, x, y } => {
            let control = if let Last::Quadratic(c) = last { 2.0 * pen - c } else { pen };
            return quadratic(outline, control, point(abs, x, y));
        }
        PathSegment::EllipticalArc { abs, rx, ry, x_axis_rotation, large_arc, sweep, x, y } => {
            let (radii, to) = (DVec2::new(rx, ry), point(abs, x, y));
            let added = outline.builder.arc_to(radii, x_axis_rotation.to_radians(), large_arc, sweep, to);
            outline.count(SegmentKind::Arc, added);
        }
        PathSegment::ClosePath { .. } => {
            let added = outline.builder.close();
            outline.count(SegmentKind::Closing, added);
        }
    }
    Last::Other
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_but_legal_data_are_read() {
        for (data, kinds, cubics) in [
            ("M10-20A5.5.3-4 110-.1", "1 (1 arc)", 3),
            ("m 0 0 10 0 10 10 z m 5 5 h 1 v 1 z", "6 (4 line, 2 closing)", 6),
            ("M0 0 t 1 1 T 3 0 q 1 1 2 0 t 2 0", "4 (4 quadratic)", 4),
            ("M0 0 s 1 1 2 0 S 3 3 4 0 c1 1 2 2 3 3 s 4 4 5 5", "4 (4 cubic)", 4),
            ("M1 1 L 1 1 z", "2 (1 line, 1 closing)", 0),
            ("", "0", 0),
            ("none", "0", 0),
        ] {
            let outline = read(data, &DAffine2::IDENTITY, 100);
            assert_eq!(outline.found.to_string(), kinds, "{data}");
            let paths = outline.builder.finish();
            assert_eq!(paths.iter().map(|p| p.segment_count()).sum::<usize>(), cubics, "{data}");
        }
    }

    #[test]
    fn what_stands_before_an_error_is_kept() {
        let outline = read("M 30 40 L 110 160 L 150#80", &DAffine2::IDENTITY, 100);
        assert_eq!(outline.drawn.total(), 1);
        assert_eq!(outline.left_out, [(LeftOutReason::BrokenPathData(24), SegmentCounts::default())]);
        for data in ["L 1 1", "M", "M 1", "M 0 0 C NaN 1 2 3 4 5", "M 0 0 L 1e400 1", "M 0 0 z 1", "ä"] {
            let outline = read(data, &DAffine2::IDENTITY, 100);
            assert!(matches!(outline.left_out[..], [.., (LeftOutReason::BrokenPathData(_), _)]), "{data}");
        }
    }

    #[test]
    fn smooth_segments_mirror_the_last_handle() {
        let outline = read("M0 0 C 0 1 1 2 2 2 S 4 1 4 0", &DAffine2::IDENTITY, 100);
        let path = outline.builder.finish().remove(0);
        assert_eq!(path.handles(1), [Some(DVec2::new(-1.0, 0.0)), Some(DVec2::new(1.0, 0.0))]);
    }
}
