//! What an element looks like: its properties, inherited and its own.

use std::rc::Rc;
use std::str::FromStr;

use roxmltree::{Node, NodeId};
use svgtypes::{Length, LengthListParser, PaintFallback};

use super::{
    SvgError,
    cascade::Cascade,
    values::{Of, Units},
};
use crate::vector::{Color, FillRule, LineCap, LineJoin};

/// A paint before gradients are looked up.
#[derive(Clone, Copy)]
pub(super) enum PaintSource {
    None,
    Color(Color),
    Server { target: Option<NodeId>, fallback: Option<Color> },
}

/// The properties of an element that drawings have, with those of its parents where they are inherited.
#[derive(Clone)]
pub(super) struct Properties {
    pub(super) fill: PaintSource,
    pub(super) fill_opacity: f32,
    pub(super) fill_rule: FillRule,
    pub(super) stroke: PaintSource,
    pub(super) stroke_opacity: f32,
    pub(super) stroke_width: f64,
    pub(super) cap: LineCap,
    pub(super) join: LineJoin,
    pub(super) miter_limit: f64,
    pub(super) dashes: Rc<[f64]>,
    pub(super) dash_offset: f64,
    /// Of the element and of everything around it.
    pub(super) opacity: f32,
    pub(super) color: Color,
    pub(super) visible: bool,
    pub(super) font_size: f64,
    // Not inherited.
    pub(super) displayed: bool,
    /// What is asked for and not followed.
    pub(super) not_applied: Vec<&'static str>,
}

impl Default for Properties {
    fn default() -> Self {
        Self {
            fill: PaintSource::Color(Color::BLACK),
            fill_opacity: 1.0,
            fill_rule: FillRule::NonZero,
            stroke: PaintSource::None,
            stroke_opacity: 1.0,
            stroke_width: 1.0,
            cap: LineCap::Butt,
            join: LineJoin::Miter,
            miter_limit: 4.0,
            dashes: Rc::new([]),
            dash_offset: 0.0,
            opacity: 1.0,
            color: Color::BLACK,
            visible: true,
            font_size: 16.0,
            displayed: true,
            not_applied: Vec::new(),
        }
    }
}

/// Looks up what an `url(#…)` or `#…` refers to.
pub(super) type Lookup<'l> = dyn Fn(&str) -> Option<NodeId> + 'l;

impl Properties {
    /// Those of a child.
    pub(super) fn of_child<'a>(
        &self,
        node: &Node<'a, '_>,
        cascade: &Cascade<'a>,
        viewport: glam::DVec2,
        lookup: &Lookup<'_>,
    ) -> Result<Self, SvgError> {
        let mut own = Self { displayed: true, not_applied: Vec::new(), ..self.clone() };
        let mut declarations: Vec<(&str, &str)> = Vec::new();
        cascade.declarations(node, |name, value| {
            if is_known(name) {
                declarations.push((name, value.trim()));
            }
        })?;
        // Others are said in terms of these.
        for (name, value) in &declarations {
            match *name {
                "color" => own.color = color(value, own.color).unwrap_or(own.color),
                "font-size" => {
                    let units = Units { viewport: glam::DVec2::splat(self.font_size), font_size: self.font_size };
                    let size = Length::from_str(value).ok().map(|l| units.length(l, Of::Width));
                    own.font_size = size.filter(|s| s.is_finite() && *s >= 0.0).unwrap_or(self.font_size);
                }
                _ => {}
            }
        }
        let units = Units { viewport, font_size: own.font_size };
        let mut opacity = 1.0;
        for (name, value) in declarations {
            if value == "inherit" {
                own.inherit(name, self);
            } else if name == "opacity" {
                opacity = share(value).unwrap_or(opacity);
            } else {
                own.set(name, value, &units, lookup);
            }
        }
        own.opacity = self.opacity * opacity;
        Ok(own)
    }

    fn inherit(&mut self, name: &str, parent: &Self) {
        match name {
            "fill" => self.fill = parent.fill,
            "fill-opacity" => self.fill_opacity = parent.fill_opacity,
            "fill-rule" => self.fill_rule = parent.fill_rule,
            "stroke" => self.stroke = parent.stroke,
            "stroke-opacity" => self.stroke_opacity = parent.stroke_opacity,
            "stroke-width" => self.stroke_width = parent.stroke_width,
            "stroke-linecap" => self.cap = parent.cap,
            "stroke-linejoin" => self.join = parent.join,
            "stroke-miterlimit" => self.miter_limit = parent.miter_limit,
            "stroke-dasharray" => self.dashes = parent.dashes.clone(),
            "stroke-dashoffset" => self.dash_offset = parent.dash_offset,
            "visibility" => self.visible = parent.visible,
            _ => {}
        }
    }

    /// Sets a property; a value that makes no sense changes nothing.
    fn set(&mut self, name: &str, value: &str, units: &Units, lookup: &Lookup<'_>) {
        let length = |of| Length::from_str(value).ok().map(|l| units.length(l, of)).filter(|l| l.is_finite());
        match name {
            "fill" => self.fill = paint(value, self.color, lookup).unwrap_or(self.fill),
            "fill-opacity" => self.fill_opacity = share(value).unwrap_or(self.fill_opacity),
            "fill-rule" => {
                self.fill_rule = match value {
                    "nonzero" => FillRule::NonZero,
                    "evenodd" => FillRule::EvenOdd,
                    _ => self.fill_rule,
                }
            }
            "stroke" => self.stroke = paint(value, self.color, lookup).unwrap_or(self.stroke),
            "stroke-opacity" => self.stroke_opacity = share(value).unwrap_or(self.stroke_opacity),
            "stroke-width" => {
                self.stroke_width = length(Of::Diagonal).filter(|w| *w >= 0.0).unwrap_or(self.stroke_width);
            }
            "stroke-linecap" => {
                self.cap = match value {
                    "butt" => LineCap::Butt,
                    "round" => LineCap::Round,
                    "square" => LineCap::Square,
                    _ => self.cap,
                }
            }
            "stroke-linejoin" => {
                self.join = match value {
                    "miter" | "miter-clip" | "arcs" => LineJoin::Miter,
                    "round" => LineJoin::Round,
                    "bevel" => LineJoin::Bevel,
                    _ => self.join,
                }
            }
            "stroke-miterlimit" => {
                let limit = value.parse().ok().filter(|l: &f64| l.is_finite() && *l >= 1.0);
                self.miter_limit = limit.unwrap_or(self.miter_limit);
            }
            "stroke-dasharray" => self.dashes = dashes(value, units),
            "stroke-dashoffset" => self.dash_offset = length(Of::Diagonal).unwrap_or(self.dash_offset),
            "display" => self.displayed = value != "none",
            "visibility" => self.visible = value == "visible",
            _ => {
                let not_applied = NOT_APPLIED.iter().find(|known| **known == name);
                if let Some(known) = not_applied.filter(|_| value != "none" && value != "normal" && !value.is_empty())
                    && !self.not_applied.contains(known)
                {
                    self.not_applied.push(known);
                }
            }
        }
    }
}

/// Properties that change how something looks, and that drawings do not have.
const NOT_APPLIED: [&str; 8] =
    ["clip-path", "mask", "filter", "marker-start", "marker-mid", "marker-end", "marker", "mix-blend-mode"];

fn is_known(name: &str) -> bool {
    const OTHERS: [&str; 6] = ["color", "font-size", "opacity", "display", "visibility", "fill"];
    OTHERS.contains(&name) || name.starts_with("fill-") || name.starts_with("stroke") || NOT_APPLIED.contains(&name)
}

/// A number or percentage, from 0 to 1.
pub(super) fn share(text: &str) -> Option<f32> {
    let text = text.trim();
    let value: f64 = match text.strip_suffix('%') {
        Some(percent) => percent.trim().parse::<f64>().ok()? / 100.0,
        None => text.parse().ok()?,
    };
    value.is_finite().then_some(value.clamp(0.0, 1.0) as f32)
}

/// A colour.
pub(super) fn color(text: &str, current: Color) -> Option<Color> {
    if text.eq_ignore_ascii_case("currentcolor") {
        return Some(current);
    }
    svgtypes::Color::from_str(text).ok().map(converted)
}

fn converted(color: svgtypes::Color) -> Color {
    let part = |v: u8| f32::from(v) / 255.0;
    Color { red: part(color.red), green: part(color.green), blue: part(color.blue), alpha: part(color.alpha) }
}

fn paint(text: &str, current: Color, lookup: &Lookup<'_>) -> Option<PaintSource> {
    match svgtypes::Paint::from_str(text).ok()? {
        svgtypes::Paint::None => Some(PaintSource::None),
        svgtypes::Paint::CurrentColor => Some(PaintSource::Color(current)),
        svgtypes::Paint::Color(color) => Some(PaintSource::Color(converted(color))),
        svgtypes::Paint::FuncIRI(target, fallback) => {
            let fallback = match fallback {
                Some(PaintFallback::Color(color)) => Some(converted(color)),
                Some(PaintFallback::CurrentColor) => Some(current),
                Some(PaintFallback::None) | None => None,
            };
            Some(PaintSource::Server { target: lookup(target), fallback })
        }
        svgtypes::Paint::Inherit | svgtypes::Paint::ContextFill | svgtypes::Paint::ContextStroke => None,
    }
}

/// Lengths of dashes: an odd number of them is said twice; none where one is negative or all are zero.
fn dashes(text: &str, units: &Units) -> Rc<[f64]> {
    /// No line has more kinds of dashes.
    const MOST: usize = 1000;
    let mut found = Vec::new();
    for length in LengthListParser::from(text).take(MOST) {
        match length.map(|l| units.length(l, Of::Diagonal)) {
            Ok(length) if length >= 0.0 && length.is_finite() => found.push(length),
            _ => return Rc::new([]),
        }
    }
    if found.iter().sum::<f64>() <= 0.0 {
        return Rc::new([]);
    }
    if found.len() % 2 == 1 {
        found.extend_from_within(..);
    }
    found.into()
}
