//! Shapes as outlines.

use glam::{DAffine2, DVec2};
use roxmltree::Node;
use svgtypes::NumberListParser;

use super::path_data::Outline;
use super::report::{LeftOutReason, SegmentCounts, SegmentKind};
use super::values::{Of, Units};

/// The names of the shapes that are no paths.
pub(super) const SHAPES: [&str; 6] = ["rect", "circle", "ellipse", "line", "polyline", "polygon"];

/// The outline of a shape.
///
/// A rectangle is four lines, with round corners four lines and four arcs; a circle or an ellipse four arcs; a line one line; a polyline
/// of n points n − 1 lines, a polygon n. Shapes without extent have as many segments, all of them left out. Hardly more than `most` segments are
/// made.
pub(super) fn outline(node: &Node<'_, '_>, units: &Units, transform: &DAffine2, most: usize) -> Outline {
    let mut outline = Outline::under(transform);
    let made = match node.tag_name().name() {
        "rect" => rect(node, units, &mut outline),
        "circle" | "ellipse" => ellipse(node, units, &mut outline),
        "line" => line(node, units, &mut outline),
        name => points(node, name == "polygon", most, &mut outline),
    };
    if let Err((reason, kind, count)) = made {
        let mut left = SegmentCounts::default();
        left[kind] = count;
        outline.found += left;
        outline.left_out.push((reason, left));
    }
    outline
}

/// Why no segment of a shape is drawn, and what they would have been.
type Refused = (LeftOutReason, SegmentKind, u64);

fn rect(node: &Node<'_, '_>, units: &Units, outline: &mut Outline) -> Result<(), Refused> {
    let refused = |reason| (reason, SegmentKind::Line, 4);
    let of = |name, of| units.attribute(node, name, of).map_err(refused);
    let (x, y) = (of("x", Of::Width)?.unwrap_or(0.0), of("y", Of::Height)?.unwrap_or(0.0));
    let (w, h) = (of("width", Of::Width)?.unwrap_or(0.0), of("height", Of::Height)?.unwrap_or(0.0));
    let (rx, ry) = (of("rx", Of::Width)?.filter(|r| *r >= 0.0), of("ry", Of::Height)?.filter(|r| *r >= 0.0));
    if w <= 0.0 || h <= 0.0 {
        return Err(refused(LeftOutReason::NoExtent));
    }
    let rx = rx.or(ry).unwrap_or(0.0).min(0.5 * w);
    let ry = ry.or(Some(rx).filter(|_| node.attribute("rx").is_some())).unwrap_or(0.0).min(0.5 * h);
    let at = |dx: f64, dy: f64| DVec2::new(x + dx, y + dy);
    if rx <= 0.0 || ry <= 0.0 {
        outline.builder.move_to(at(0.0, 0.0));
        [at(w, 0.0), at(w, h), at(0.0, h), at(0.0, 0.0)].into_iter().for_each(|to| outline.line_to(to));
    } else {
        outline.builder.move_to(at(rx, 0.0));
        let corners = [
            (at(w - rx, 0.0), at(w, 0.0), at(w, ry)),
            (at(w, h - ry), at(w, h), at(w - rx, h)),
            (at(rx, h), at(0.0, h), at(0.0, h - ry)),
            (at(0.0, ry), at(0.0, 0.0), at(rx, 0.0)),
        ];
        for (from, corner, to) in corners {
            outline.line_to(from);
            quarter(outline, corner, to);
        }
    }
    outline.builder.close();
    Ok(())
}

fn ellipse(node: &Node<'_, '_>, units: &Units, outline: &mut Outline) -> Result<(), Refused> {
    let refused = |reason| (reason, SegmentKind::Arc, 4);
    let of = |name, of| units.attribute(node, name, of).map_err(refused);
    let centre = DVec2::new(of("cx", Of::Width)?.unwrap_or(0.0), of("cy", Of::Height)?.unwrap_or(0.0));
    let (rx, ry) = if node.tag_name().name() == "circle" {
        let r = of("r", Of::Diagonal)?.unwrap_or(0.0);
        (r, r)
    } else {
        let (rx, ry) = (of("rx", Of::Width)?, of("ry", Of::Height)?);
        (rx.or(ry).unwrap_or(0.0), ry.or(rx).unwrap_or(0.0))
    };
    if rx <= 0.0 || ry <= 0.0 {
        return Err(refused(LeftOutReason::NoExtent));
    }
    let at = |x: f64, y: f64| centre + DVec2::new(x * rx, y * ry);
    outline.builder.move_to(at(1.0, 0.0));
    for (corner, to) in [
        (at(1.0, 1.0), at(0.0, 1.0)),
        (at(-1.0, 1.0), at(-1.0, 0.0)),
        (at(-1.0, -1.0), at(0.0, -1.0)),
        (at(1.0, -1.0), at(1.0, 0.0)),
    ] {
        quarter(outline, corner, to);
    }
    outline.builder.close();
    Ok(())
}

/// A quarter of an ellipse, from the pen to a point, inside the corner where its tangents meet.
fn quarter(outline: &mut Outline, corner: DVec2, to: DVec2) {
    // 4/3 tan(90°/4)
    const REACH: f64 = 0.552_284_749_830_793_4;
    let from = outline.builder.pen();
    let added = outline.builder.cubic_to(from.lerp(corner, REACH), to.lerp(corner, REACH), to);
    outline.count(SegmentKind::Arc, added);
}

fn line(node: &Node<'_, '_>, units: &Units, outline: &mut Outline) -> Result<(), Refused> {
    let of = |name, of| match units.attribute(node, name, of) {
        Ok(value) => Ok(value.unwrap_or(0.0)),
        Err(reason) => Err((reason, SegmentKind::Line, 1)),
    };
    outline.builder.move_to(DVec2::new(of("x1", Of::Width)?, of("y1", Of::Height)?));
    outline.line_to(DVec2::new(of("x2", Of::Width)?, of("y2", Of::Height)?));
    Ok(())
}

fn points(node: &Node<'_, '_>, closed: bool, most: usize, outline: &mut Outline) -> Result<(), Refused> {
    let text = node.attribute("points").unwrap_or("");
    let mut start = None;
    let mut numbers = NumberListParser::from(text.trim());
    // Pairs as far as they can be read; an odd number is ignored, as SVG asks for.
    while outline.found.total() <= most as u64 {
        let (x, y) = match (numbers.next(), numbers.next()) {
            (Some(Ok(x)), Some(Ok(y))) => (x, y),
            (Some(Err(_)), _) | (_, Some(Err(_))) => {
                outline.left_out.push((LeftOutReason::BadAttribute("points"), SegmentCounts::default()));
                break;
            }
            _ => break,
        };
        let to = DVec2::new(x, y);
        match start {
            Some(_) => outline.line_to(to),
            None => {
                outline.builder.move_to(to);
                start = Some(to);
            }
        }
    }
    if let Some(start) = start.filter(|_| closed) {
        outline.line_to(start);
        outline.builder.close();
    }
    Ok(())
}
