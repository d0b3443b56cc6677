//! Gradients and what paints make of them.

use std::collections::HashMap;

use glam::{DAffine2, DVec2};
use roxmltree::{Document, Node, NodeId};

use super::{
    SvgError,
    cascade::Cascade,
    expansion::reference,
    properties::{PaintSource, color, share},
    values::{Of, Units, is_regular, transform},
};
use crate::vector::{Color, Gradient, GradientKind, GradientStop, Paint, SpreadMethod};

/// The gradients that were asked for so far.
#[derive(Default)]
pub(super) struct Gradients {
    pub(super) all: Vec<Gradient>,
    known: HashMap<NodeId, Server>,
}

/// What an element that paints refer to is.
#[derive(Clone, Copy)]
enum Server {
    Gradient {
        index: u32,
        transform: DAffine2,
    },
    Color(Color),
    /// It paints nothing.
    Nothing,
    /// A pattern, say.
    Other,
}

/// A paint, and whether it is what the file asks for.
pub(super) struct Found {
    pub(super) paint: Option<Paint>,
    pub(super) as_asked: bool,
}

/// The document, and what its values depend on.
pub(super) struct Context<'c, 'a, 'input> {
    pub(super) document: &'a Document<'input>,
    pub(super) ids: &'c HashMap<&'a str, Node<'a, 'input>>,
    pub(super) cascade: &'c Cascade<'a>,
    pub(super) viewport: DVec2,
}

impl Gradients {
    /// The paint of a shape; `bounds` says what they are in its own coordinates.
    pub(super) fn paint(
        &mut self,
        context: &Context<'_, '_, '_>,
        source: PaintSource,
        opacity: f32,
        bounds: &dyn Fn(bool) -> Option<(DVec2, DVec2)>,
        to_drawing: &DAffine2,
    ) -> Result<Found, SvgError> {
        let solid = |color: Color| Some(Paint::Color(Color { alpha: color.alpha * opacity, ..color }));
        let (target, fallback) = match source {
            PaintSource::None => return Ok(Found { paint: None, as_asked: true }),
            PaintSource::Color(color) => return Ok(Found { paint: solid(color), as_asked: true }),
            PaintSource::Server { target, fallback } => (target, fallback),
        };
        let Some(node) = target.and_then(|id| context.document.get_node(id)) else {
            return Ok(Found { paint: fallback.and_then(solid), as_asked: false });
        };
        let server = match self.known.get(&node.id()) {
            Some(known) => *known,
            None => {
                let read = self.read(context, &node)?;
                self.known.insert(node.id(), read);
                read
            }
        };
        Ok(match server {
            Server::Color(color) => Found { paint: solid(color), as_asked: true },
            Server::Nothing => Found { paint: None, as_asked: true },
            Server::Other => Found { paint: fallback.and_then(solid), as_asked: false },
            Server::Gradient { index, transform } => {
                let of_bounds = self.all.get(index as usize).is_some_and(|g| g.of_bounds);
                let frame = if of_bounds { unit_square_to(bounds(of_bounds)) } else { Some(DAffine2::IDENTITY) };
                let placed = frame.map(|frame| *to_drawing * frame * transform).filter(is_regular);
                match placed {
                    Some(to_drawing) => {
                        Found { paint: Some(Paint::Gradient { index, to_drawing, opacity }), as_asked: true }
                    }
                    None => Found { paint: fallback.and_then(solid), as_asked: true },
                }
            }
        })
    }

    /// Reads a gradient; what it does not say itself, the one says that it refers to.
    fn read(&mut self, context: &Context<'_, '_, '_>, node: &Node<'_, '_>) -> Result<Server, SvgError> {
        /// No drawing has longer chains.
        const LONGEST: usize = 32;
        let linear = match node.tag_name().name() {
            "linearGradient" => true,
            "radialGradient" => false,
            _ => return Ok(Server::Other),
        };
        let mut chain = Vec::new();
        let mut link = context.document.get_node(node.id());
        while let Some(here) = link.filter(|_| chain.len() < LONGEST) {
            chain.push(here);
            link = reference(&here).and_then(|r| context.ids.get(r.strip_prefix('#')?)).copied();
        }
        let attribute = |name| chain.iter().find_map(|n| n.attribute(name));
        let is_stop = |n: &Node<'_, '_>| n.tag_name().name() == "stop";
        let Some(holder) = chain.iter().find(|n| n.children().any(|c| is_stop(&c))) else { return Ok(Server::Nothing) };
        let stops = stops(context, holder)?;
        let [.., last] = stops[..] else { return Ok(Server::Nothing) };
        if stops.len() == 1 {
            return Ok(Server::Color(last.color));
        }
        let of_bounds = attribute("gradientUnits") != Some("userSpaceOnUse");
        let viewport = if of_bounds { DVec2::ONE } else { context.viewport };
        let units = Units { viewport, font_size: 16.0 };
        let length = |name: &'static str, of: Of| {
            chain.iter().find(|n| n.has_attribute(name)).and_then(|n| units.attribute(n, name, of).ok().flatten())
        };
        let kind = if linear {
            let y = length("y1", Of::Height).unwrap_or(0.0);
            let to = DVec2::new(length("x2", Of::Width).unwrap_or(viewport.x), length("y2", Of::Height).unwrap_or(0.0));
            GradientKind::Linear { from: DVec2::new(length("x1", Of::Width).unwrap_or(0.0), y), to }
        } else {
            let half = 0.5 * viewport;
            let centre =
                DVec2::new(length("cx", Of::Width).unwrap_or(half.x), length("cy", Of::Height).unwrap_or(half.y));
            let focus =
                DVec2::new(length("fx", Of::Width).unwrap_or(centre.x), length("fy", Of::Height).unwrap_or(centre.y));
            let diagonal = (0.5 * viewport.length_squared()).sqrt();
            let radius = length("r", Of::Diagonal).unwrap_or(0.5 * diagonal);
            GradientKind::Radial { centre, radius, focus, focus_radius: length("fr", Of::Diagonal).unwrap_or(0.0) }
        };
        let no_extent = match kind {
            GradientKind::Linear { from, to } => from == to,
            GradientKind::Radial { radius, .. } => radius <= 0.0,
        };
        if no_extent {
            return Ok(Server::Color(last.color));
        }
        let said = attribute("gradientTransform").map_or(Ok(DAffine2::IDENTITY), |t| transform(t, "gradientTransform"));
        let Ok(transform) = said else { return Ok(Server::Nothing) };
        let spread = match attribute("spreadMethod") {
            Some("reflect") => SpreadMethod::Reflect,
            Some("repeat") => SpreadMethod::Repeat,
            _ => SpreadMethod::Pad,
        };
        let index = self.all.len() as u32;
        let id = node.attribute("id").map(str::to_owned);
        self.all.push(Gradient { id, kind, stops: stops.into(), spread, of_bounds });
        Ok(Server::Gradient { index, transform })
    }
}

/// The stops of a gradient, offsets made to grow.
fn stops(context: &Context<'_, '_, '_>, holder: &Node<'_, '_>) -> Result<Vec<GradientStop>, SvgError> {
    let mut stops: Vec<GradientStop> = Vec::new();
    let Some(holder) = context.document.get_node(holder.id()) else { return Ok(stops) };
    for node in holder.children().filter(|n| n.tag_name().name() == "stop") {
        let (mut own, mut opacity) = (Color::BLACK, 1.0);
        context.cascade.declarations(&node, |name, value| match name {
            "stop-color" => own = color(value.trim(), Color::BLACK).unwrap_or(own),
            "stop-opacity" => opacity = share(value).unwrap_or(opacity),
            _ => {}
        })?;
        let least = stops.last().map_or(0.0, |stop| stop.offset);
        let offset = node.attribute("offset").and_then(share).unwrap_or(0.0).max(least);
        stops.push(GradientStop { offset, color: Color { alpha: own.alpha * opacity, ..own } });
    }
    Ok(stops)
}

/// The map from the unit square to some bounds; none if they have no area.
fn unit_square_to(bounds: Option<(DVec2, DVec2)>) -> Option<DAffine2> {
    let (low, high) = bounds?;
    let size = high - low;
    (size.min_element() > 0.0).then(|| DAffine2::from_scale_angle_translation(size, 0.0, low))
}
