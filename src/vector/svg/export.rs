//! Drawings as SVG text.

use std::fmt::Write;

use glam::DAffine2;

use crate::vector::{
    Color, Drawing, FillRule, Gradient, GradientKind, LineCap, LineJoin, Paint, SpreadMethod, Style, VectorPath,
};

/// Writes a drawing as SVG.
///
/// Paths are written as cubic segments with coordinates that read back to the same bits, so that what was exported imports as it was.
/// Gradients are written once for each paint that has them, in the drawing's coordinates.
pub fn export_svg(drawing: &Drawing) -> String {
    let mut out = String::from("<svg xmlns=\"http://www.w3.org/2000/svg\"");
    if let Some(view) = drawing.view_box {
        let [x, y, w, h] = [view.min.x, view.min.y, view.size.x, view.size.y].map(Number);
        let _ = write!(out, " viewBox=\"{x} {y} {w} {h}\"");
    }
    out.push_str(">\n");
    let mut gradients = Definitions { drawing, text: String::new(), count: 0 };
    let mut shapes = String::new();
    let mut open: Vec<u32> = Vec::new();
    for shape in &drawing.shapes {
        let mut around: Vec<u32> = drawing.groups_of(shape).map(|(number, _)| number).collect();
        around.reverse();
        let same = open.iter().zip(&around).take_while(|(a, b)| a == b).count();
        open.drain(same..).for_each(|_| shapes.push_str("  </g>\n"));
        for number in &around[same..] {
            let id = drawing.groups.get(*number as usize).map_or("", |group| group.id.as_str());
            let _ = writeln!(shapes, "  <g id=\"{}\">", escaped(id));
        }
        open = around;
        shapes.push_str("  <path");
        if let Some(id) = &shape.id {
            let _ = write!(shapes, " id=\"{}\"", escaped(id));
        }
        write_style(&mut shapes, &shape.style, &mut gradients);
        shapes.push_str(" d=\"");
        for path in &shape.paths {
            write_path(&mut shapes, path);
        }
        shapes.push_str("\"/>\n");
    }
    open.iter().for_each(|_| shapes.push_str("  </g>\n"));
    if !gradients.text.is_empty() {
        let _ = write!(out, "  <defs>\n{}  </defs>\n", gradients.text);
    }
    out + &shapes + "</svg>\n"
}

/// A number in the fewest digits that read back to the same bits.
struct Number(f64);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let size = self.0.abs();
        if size != 0.0 && !(1e-5..1e15).contains(&size) { write!(f, "{:e}", self.0) } else { write!(f, "{}", self.0) }
    }
}

fn write_path(out: &mut String, path: &VectorPath) {
    let Some(start) = path.points().first() else { return };
    let _ = write!(out, "M{} {}", Number(start.x), Number(start.y));
    for segment in path.segments() {
        let [_, b, c, d] = segment;
        let [bx, by, cx, cy, dx, dy] = [b.x, b.y, c.x, c.y, d.x, d.y].map(Number);
        let _ = write!(out, "C{bx} {by} {cx} {cy} {dx} {dy}");
    }
    if path.is_closed() {
        out.push('z');
    }
}

/// Gradients as they are referred to.
struct Definitions<'d> {
    drawing: &'d Drawing,
    text: String,
    count: usize,
}

impl Definitions<'_> {
    /// Writes a gradient for a paint; its name, or none if the drawing has no such gradient.
    fn add(&mut self, index: u32, to_drawing: &DAffine2) -> Option<String> {
        let gradient = self.drawing.gradients.get(index as usize)?;
        self.count += 1;
        let name = format!("paint{}", self.count);
        write_gradient(&mut self.text, gradient, &name, to_drawing);
        Some(name)
    }
}

fn write_gradient(out: &mut String, gradient: &Gradient, name: &str, to_drawing: &DAffine2) {
    let spread = match gradient.spread {
        SpreadMethod::Pad => "pad",
        SpreadMethod::Reflect => "reflect",
        SpreadMethod::Repeat => "repeat",
    };
    let [a, b, c, d, e, f] = to_drawing.to_cols_array().map(Number);
    let common = format!(
        "id=\"{name}\" gradientUnits=\"userSpaceOnUse\" spreadMethod=\"{spread}\" gradientTransform=\"matrix({a} {b} {c} {d} {e} {f})\""
    );
    let element = match gradient.kind {
        GradientKind::Linear { from, to } => {
            let [x1, y1, x2, y2] = [from.x, from.y, to.x, to.y].map(Number);
            let _ = write!(out, "    <linearGradient {common} x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\">");
            "linearGradient"
        }
        GradientKind::Radial { centre, radius, focus, focus_radius } => {
            let [cx, cy, r, fx, fy, fr] = [centre.x, centre.y, radius, focus.x, focus.y, focus_radius].map(Number);
            let _ = write!(
                out,
                "    <radialGradient {common} cx=\"{cx}\" cy=\"{cy}\" r=\"{r}\" fx=\"{fx}\" fy=\"{fy}\" fr=\"{fr}\">"
            );
            "radialGradient"
        }
    };
    for stop in gradient.stops.iter() {
        let _ = write!(out, "<stop offset=\"{}\" stop-color=\"{}\"", stop.offset, Hex(stop.color));
        if stop.color.alpha != 1.0 {
            let _ = write!(out, " stop-opacity=\"{}\"", stop.color.alpha);
        }
        out.push_str("/>");
    }
    let _ = writeln!(out, "</{element}>");
}

/// A colour without its transparency.
struct Hex(Color);

impl std::fmt::Display for Hex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b] = [self.0.red, self.0.green, self.0.blue].map(|v| (v * 255.0).round().clamp(0.0, 255.0) as u8);
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

fn write_style(out: &mut String, style: &Style, gradients: &mut Definitions<'_>) {
    match &style.fill {
        None => out.push_str(" fill=\"none\""),
        Some(paint) => write_paint(out, "fill", paint, gradients),
    }
    if style.fill_rule == FillRule::EvenOdd {
        out.push_str(" fill-rule=\"evenodd\"");
    }
    if style.opacity != 1.0 {
        let _ = write!(out, " opacity=\"{}\"", style.opacity);
    }
    let Some(stroke) = &style.stroke else { return };
    write_paint(out, "stroke", &stroke.paint, gradients);
    let _ = write!(out, " stroke-width=\"{}\"", Number(stroke.width));
    match stroke.cap {
        LineCap::Butt => {}
        LineCap::Round => out.push_str(" stroke-linecap=\"round\""),
        LineCap::Square => out.push_str(" stroke-linecap=\"square\""),
    }
    match stroke.join {
        LineJoin::Miter => {}
        LineJoin::Round => out.push_str(" stroke-linejoin=\"round\""),
        LineJoin::Bevel => out.push_str(" stroke-linejoin=\"bevel\""),
    }
    if stroke.miter_limit != 4.0 {
        let _ = write!(out, " stroke-miterlimit=\"{}\"", Number(stroke.miter_limit));
    }
    if !stroke.dashes.is_empty() {
        let dashes: Vec<String> = stroke.dashes.iter().map(|dash| Number(*dash).to_string()).collect();
        let _ = write!(out, " stroke-dasharray=\"{}\"", dashes.join(" "));
        let _ = write!(out, " stroke-dashoffset=\"{}\"", Number(stroke.dash_offset));
    }
}

fn write_paint(out: &mut String, property: &str, paint: &Paint, gradients: &mut Definitions<'_>) {
    let opacity = match paint {
        Paint::Color(color) => {
            let _ = write!(out, " {property}=\"{}\"", Hex(*color));
            color.alpha
        }
        Paint::Gradient { index, to_drawing, opacity } => {
            match gradients.add(*index, to_drawing) {
                Some(name) => drop(write!(out, " {property}=\"url(#{name})\"")),
                None => drop(write!(out, " {property}=\"none\"")),
            }
            *opacity
        }
    };
    if opacity != 1.0 {
        let _ = write!(out, " {property}-opacity=\"{opacity}\"");
    }
}

/// A text as an attribute may hold it; what XML cannot hold at all is left out.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '"' => out.push_str("&quot;"),
            '\t' => out.push_str("&#9;"),
            '\n' => out.push_str("&#10;"),
            '\r' => out.push_str("&#13;"),
            c if (c as u32) < 0x20 || matches!(c, '\u{fffe}' | '\u{ffff}') => {}
            c => out.push(c),
        }
    }
    out
}
