//! The walk over the tree of a document, which makes its drawing.

use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use glam::{DAffine2, DVec2};
use roxmltree::{Document, Node, NodeId};

use super::{
    SvgError, SvgImport, SvgLimits,
    cascade::Cascade,
    expansion::{UseChain, ids, reference},
    gradients::{Context, Gradients},
    path_data::{self, Outline},
    properties::Properties,
    report::{LeftOut, LeftOutReason, Note, SegmentCounts, SvgReport},
    shapes::{self, SHAPES},
    values::{Of, Units, fit, is_regular, transform, view_box},
};
use crate::vector::{Drawing, Group, Shape, Stroke, Style, VectorPath, ViewBox};

const SVG: &str = "http://www.w3.org/2000/svg";

/// Elements whose contents are drawn only where something refers to them.
const DEFINITIONS: [&str; 12] = [
    "defs",
    "symbol",
    "clipPath",
    "mask",
    "pattern",
    "marker",
    "linearGradient",
    "radialGradient",
    "filter",
    "metadata",
    "cursor",
    "font",
];

/// Elements that say nothing about geometry.
const SILENT: [&str; 6] = ["title", "desc", "style", "stop", "view", "meshgradient"];

/// Elements whose name is one of all that is drawn in them.
const GROUPS: [&str; 6] = ["g", "a", "svg", "symbol", "switch", "use"];

const TEXTS: [&str; 6] = ["text", "tspan", "textPath", "tref", "flowRoot", "altGlyph"];

const MOVING: [&str; 7] = ["animate", "animateTransform", "animateMotion", "animateColor", "set", "script", "discard"];

/// Makes the drawing of a document.
pub(super) fn import(document: &Document<'_>, limits: &SvgLimits) -> Result<SvgImport, SvgError> {
    let root = document.root_element();
    let namespace = root.tag_name().namespace();
    if root.tag_name().name() != "svg" || namespace.is_some_and(|n| n != SVG) {
        return Err(SvgError::NotSvg { root: root.tag_name().name().to_owned() });
    }
    let view = root_view(&root);
    let viewport = view.map_or(DVec2::splat(100.0), |view| view.size);
    let (cascade, ids) = (Cascade::new(document, limits), ids(document));
    let mut walk = Walk {
        namespace,
        context: Context { document, ids: &ids, cascade: &cascade, viewport },
        limits,
        lines: Lines::new(document.input_text()),
        gradients: Gradients::default(),
        drawing: Drawing { view_box: view, ..Drawing::default() },
        report: SvgReport::default(),
        known: HashMap::new(),
        noted: HashSet::new(),
        cubics: 0,
    };
    let state = State {
        properties: Properties::default(),
        transform: DAffine2::IDENTITY,
        viewport,
        hidden: None,
        copy: false,
        uses: None,
        group: None,
    };
    let mut waiting = vec![Visit { node: root, around: Rc::new(state), used: None }];
    while let Some(visit) = waiting.pop() {
        walk.visit(&visit, &mut waiting)?;
    }
    let Walk { mut drawing, mut report, gradients, .. } = walk;
    drawing.gradients = gradients.all;
    report.left_out.sort_by_key(|left| left.line);
    report.notes.sort_by_key(|note| note.line);
    Ok(SvgImport { drawing, report })
}

/// The view box of a document, or its size where it has none.
fn root_view(root: &Node<'_, '_>) -> Option<ViewBox> {
    view_box(root).or_else(|| {
        let units = Units { viewport: DVec2::splat(100.0), font_size: 16.0 };
        let of = |name, of| {
            let is_share = root.attribute(name).is_some_and(|text| text.trim().ends_with('%'));
            units.attribute(root, name, of).ok().flatten().filter(|size| *size > 0.0 && !is_share)
        };
        Some(ViewBox { min: DVec2::ZERO, size: DVec2::new(of("width", Of::Width)?, of("height", Of::Height)?) })
    })
}

/// What holds for the children of an element.
#[derive(Clone)]
struct State {
    properties: Properties,
    /// From the element's coordinates to the drawing's.
    transform: DAffine2,
    viewport: DVec2,
    /// Why nothing below is drawn, if that is so.
    hidden: Option<LeftOutReason>,
    /// Whether this is a copy made by `use`.
    copy: bool,
    uses: Option<Rc<UseChain>>,
    group: Option<Rc<OpenGroup>>,
}

/// A named group that is being visited.
struct OpenGroup {
    id: String,
    around: Option<Rc<OpenGroup>>,
    /// Its place in the drawing, once something is drawn in it.
    number: Cell<Option<u32>>,
}

impl State {
    /// Where paths come to lie; what is hidden is only counted, so a map that flattens it shall not change its segments.
    fn lay(&self) -> DAffine2 {
        if self.hidden.is_some() { DAffine2::IDENTITY } else { self.transform }
    }
}

/// An element that waits to be visited.
struct Visit<'a, 'input> {
    node: Node<'a, 'input>,
    around: Rc<State>,
    /// The `use` that refers to it, if it is visited for that.
    used: Option<Node<'a, 'input>>,
}

struct Walk<'c, 'a, 'input> {
    /// That of SVG, or none in documents that do without.
    namespace: Option<&'a str>,
    context: Context<'c, 'a, 'input>,
    limits: &'c SvgLimits,
    lines: Lines,
    gradients: Gradients,
    drawing: Drawing,
    report: SvgReport,
    /// Places in the list of what is left out.
    known: HashMap<(NodeId, LeftOutReason), usize>,
    noted: HashSet<(NodeId, &'static str)>,
    cubics: usize,
}

impl<'a, 'input> Walk<'_, 'a, 'input> {
    /// Takes what an element draws, and puts its children on the list.
    fn visit(&mut self, visit: &Visit<'a, 'input>, waiting: &mut Vec<Visit<'a, 'input>>) -> Result<(), SvgError> {
        let Visit { node, around, used } = visit;
        self.report.elements += 1;
        if node.tag_name().namespace() != self.namespace {
            let hidden = around.hidden.clone().or(Some(LeftOutReason::Foreign));
            push_children(node, Rc::new(State { hidden, ..State::clone(around) }), waiting);
            return Ok(());
        }
        let mut state = self.state_of(node, around)?;
        let name = node.tag_name().name();
        match name {
            "g" | "a" => {}
            "svg" => self.open_viewport(node, *used, &mut state),
            "symbol" if used.is_some() => self.open_viewport(node, *used, &mut state),
            "switch" => return self.choose(node, state, waiting),
            "use" => return self.copy(node, state, waiting),
            "path" => {
                let outline =
                    path_data::read(node.attribute("d").unwrap_or(""), &state.lay(), self.limits.segments as usize);
                self.take(node, outline, &state, true)?;
            }
            _ if SHAPES.contains(&name) => {
                let units = Units { viewport: state.viewport, font_size: state.properties.font_size };
                let outline = shapes::outline(node, &units, &state.lay(), self.limits.segments as usize);
                self.take(node, outline, &state, false)?;
            }
            _ => self.hide_contents(node, &mut state),
        }
        push_children(node, Rc::new(state), waiting);
        Ok(())
    }

    /// What holds inside an element.
    fn state_of(&mut self, node: &Node<'a, 'input>, around: &State) -> Result<State, SvgError> {
        let ids = self.context.ids;
        let lookup = |id: &str| ids.get(id).map(|node| node.id());
        let properties = around.properties.of_child(node, self.context.cascade, around.viewport, &lookup)?;
        let mut state = State { properties, ..around.clone() };
        let own = node.attribute("transform").map_or(Ok(DAffine2::IDENTITY), |text| transform(text, "transform"));
        let hidden = match own {
            _ if !state.properties.displayed => Some(LeftOutReason::NotDisplayed),
            Err(reason) => Some(reason),
            Ok(own) => {
                state.transform = around.transform * own;
                (!is_regular(&state.transform)).then_some(LeftOutReason::Flattened)
            }
        };
        state.hidden = state.hidden.or(hidden);
        if let Some(id) = node.attribute("id").filter(|_| GROUPS.contains(&node.tag_name().name())) {
            let around = state.group.take();
            state.group = Some(Rc::new(OpenGroup { id: id.to_owned(), around, number: Cell::new(None) }));
        }
        if state.hidden.is_none() {
            for property in std::mem::take(&mut state.properties.not_applied) {
                self.note(node, property);
            }
        }
        Ok(state)
    }

    /// Enters a nested document or a symbol; the outermost document keeps the coordinates of its view box.
    fn open_viewport(&mut self, node: &Node<'a, 'input>, used: Option<Node<'a, 'input>>, state: &mut State) {
        if *node == self.context.document.root_element() && used.is_none() {
            return;
        }
        let units = Units { viewport: state.viewport, font_size: state.properties.font_size };
        let of = |node: &Node<'_, '_>, name, of| units.attribute(node, name, of).ok().flatten();
        let size = |name, axis| used.and_then(|u| of(&u, name, axis)).or_else(|| of(node, name, axis));
        let width = size("width", Of::Width).unwrap_or(state.viewport.x);
        let height = size("height", Of::Height).unwrap_or(state.viewport.y);
        let corner = if node.tag_name().name() == "svg" {
            DVec2::new(of(node, "x", Of::Width).unwrap_or(0.0), of(node, "y", Of::Height).unwrap_or(0.0))
        } else {
            DVec2::ZERO
        };
        let size = DVec2::new(width, height);
        if size.min_element() <= 0.0 {
            state.hidden.get_or_insert(LeftOutReason::NoExtent);
            return;
        }
        state.transform *= DAffine2::from_translation(corner);
        state.viewport = size;
        if let Some(view) = view_box(node) {
            state.transform *= fit(node, &view, size);
            state.viewport = view.size;
        }
        if !is_regular(&state.transform) {
            state.hidden.get_or_insert(LeftOutReason::Flattened);
        }
    }

    /// Visits the first child of a `switch` that applies, and takes account of the others.
    fn choose(
        &mut self,
        node: &Node<'a, 'input>,
        state: State,
        waiting: &mut Vec<Visit<'a, 'input>>,
    ) -> Result<(), SvgError> {
        let applies = |child: &Node<'_, '_>| {
            let english = |text: &str| text.split(',').any(|l| l.trim().starts_with("en"));
            child.tag_name().namespace() == self.namespace
                && child.tag_name().name() != "foreignObject"
                && child.attribute("requiredExtensions").is_none_or(|e| e.trim().is_empty())
                && child.attribute("systemLanguage").is_none_or(english)
        };
        let chosen = node.children().filter(Node::is_element).find(applies);
        let hidden = state.hidden.clone().or(Some(LeftOutReason::NotChosen));
        let (state, others) = (Rc::new(state.clone()), Rc::new(State { hidden, ..state }));
        waiting.extend(node.children().rev().filter(Node::is_element).map(|child| {
            let around = if Some(child) == chosen { &state } else { &others };
            Visit { node: child, around: around.clone(), used: None }
        }));
        Ok(())
    }

    /// Visits what a `use` refers to.
    fn copy(
        &mut self,
        node: &Node<'a, 'input>,
        mut state: State,
        waiting: &mut Vec<Visit<'a, 'input>>,
    ) -> Result<(), SvgError> {
        if state.hidden.is_some() {
            return Ok(());
        }
        let written = reference(node).unwrap_or("");
        let Some(target) = written.strip_prefix('#').and_then(|id| self.context.ids.get(id)) else {
            self.leave_out(node, LeftOutReason::NoTarget(written.to_owned()), SegmentCounts::default());
            return Ok(());
        };
        if UseChain::holds(&state.uses, target.id()) || node.ancestors().any(|around| around == *target) {
            self.leave_out(node, LeftOutReason::Recursive, SegmentCounts::default());
            return Ok(());
        }
        let units = Units { viewport: state.viewport, font_size: state.properties.font_size };
        let place = |name, of| units.attribute(node, name, of).map(|value| value.unwrap_or(0.0));
        match (place("x", Of::Width), place("y", Of::Height)) {
            (Ok(x), Ok(y)) => state.transform *= DAffine2::from_translation(DVec2::new(x, y)),
            (Err(reason), _) | (_, Err(reason)) => {
                self.leave_out(node, reason, SegmentCounts::default());
                return Ok(());
            }
        }
        state.copy = true;
        state.uses = Some(Rc::new(UseChain { target: target.id(), before: state.uses.take() }));
        waiting.push(Visit { node: *target, around: Rc::new(state), used: Some(*node) });
        Ok(())
    }

    /// Lists an element that draws nothing here, and hides what is inside.
    fn hide_contents(&mut self, node: &Node<'a, 'input>, state: &mut State) {
        let name = node.tag_name().name();
        let (reason, listed) = if let Some(known) = DEFINITIONS.iter().find(|known| **known == name) {
            (LeftOutReason::Defined(known), false)
        } else if SILENT.contains(&name) {
            (LeftOutReason::Unsupported, false)
        } else if TEXTS.contains(&name) {
            (LeftOutReason::Text, true)
        } else if name == "image" {
            (LeftOutReason::Image, true)
        } else if MOVING.contains(&name) {
            (LeftOutReason::Animation, true)
        } else {
            (LeftOutReason::Unsupported, true)
        };
        if state.hidden.is_none() {
            if listed {
                self.leave_out(node, reason.clone(), SegmentCounts::default());
            }
            state.hidden = Some(reason);
        }
    }

    /// Takes the outline of an element into the drawing, or leaves it out.
    fn take(
        &mut self,
        node: &Node<'a, 'input>,
        outline: Outline,
        state: &State,
        is_path: bool,
    ) -> Result<(), SvgError> {
        let Outline { builder, found, drawn, left_out } = outline;
        let bucket = match (state.copy, is_path) {
            (true, _) => &mut self.report.in_copies,
            (false, true) => &mut self.report.in_paths,
            (false, false) => &mut self.report.in_shapes,
        };
        *bucket += found;
        self.cubics += builder.segment_count();
        let limit = self.limits.segments;
        if self.report.found().total() > u64::from(limit) || self.cubics > limit as usize {
            return Err(SvgError::TooManySegments { limit });
        }
        let hidden = state.hidden.clone().or((!state.properties.visible).then_some(LeftOutReason::NotVisible));
        if let Some(reason) = hidden {
            if found.total() > 0 {
                self.leave_out(node, reason, found);
            }
            return Ok(());
        }
        for (reason, segments) in left_out {
            self.leave_out(node, reason, segments);
        }
        if drawn.total() == 0 {
            return Ok(());
        }
        let Some(paths) = builder.finish_finite() else {
            self.leave_out(node, LeftOutReason::NotFinite, drawn);
            return Ok(());
        };
        self.report.drawn += drawn;
        let style = self.style(node, state, &paths)?;
        let id = node.attribute("id").map(str::to_owned);
        let group = self.number_of(state.group.as_ref());
        self.drawing.shapes.push(Shape { id, group, element: node.tag_name().name().to_owned(), paths, style });
        Ok(())
    }

    /// The place of a group in the drawing; it and those around get one if they have none.
    fn number_of(&mut self, group: Option<&Rc<OpenGroup>>) -> Option<u32> {
        let mut open: Vec<&OpenGroup> = std::iter::successors(group.map(|g| &**g), |g| g.around.as_deref())
            .take_while(|group| group.number.get().is_none())
            .collect();
        while let Some(group) = open.pop() {
            let parent = group.around.as_ref().and_then(|around| around.number.get());
            group.number.set(Some(self.drawing.groups.len() as u32));
            self.drawing.groups.push(Group { id: group.id.clone(), parent });
        }
        group.and_then(|group| group.number.get())
    }

    /// How an element is painted.
    fn style(&mut self, node: &Node<'a, 'input>, state: &State, paths: &[VectorPath]) -> Result<Style, SvgError> {
        let Properties { fill, fill_opacity, stroke, stroke_opacity, .. } = state.properties;
        let back = state.transform.inverse();
        let bounds = |of_bounds: bool| {
            let own = paths.iter().filter(|_| of_bounds).filter_map(|path| path.transformed(&back)?.curve_bounds());
            own.reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))
        };
        let paint = |walk: &mut Self, source, opacity, property| {
            let found = walk.gradients.paint(&walk.context, source, opacity, &bounds, &state.transform)?;
            if !found.as_asked {
                walk.note(node, property);
            }
            Ok::<_, SvgError>(found.paint)
        };
        let fill = paint(self, fill, fill_opacity, "fill")?;
        let line = paint(self, stroke, stroke_opacity, "stroke")?;
        let own = &state.properties;
        let scale = state.transform.matrix2.determinant().abs().sqrt();
        let stroke = line.filter(|_| own.stroke_width > 0.0).map(|paint| Stroke {
            paint,
            width: own.stroke_width * scale,
            cap: own.cap,
            join: own.join,
            miter_limit: own.miter_limit,
            dashes: own.dashes.iter().map(|dash| dash * scale).collect(),
            dash_offset: own.dash_offset * scale,
        });
        Ok(Style { fill, fill_rule: own.fill_rule, stroke, opacity: own.opacity })
    }

    fn leave_out(&mut self, node: &Node<'a, 'input>, reason: LeftOutReason, segments: SegmentCounts) {
        let list = &mut self.report.left_out;
        let place = *self.known.entry((node.id(), reason)).or_insert_with_key(|(_, reason)| {
            list.push(LeftOut {
                element: node.tag_name().name().to_owned(),
                id: node.attribute("id").map(str::to_owned),
                line: self.lines.of(node.range().start),
                reason: reason.clone(),
                segments: SegmentCounts::default(),
            });
            list.len() - 1
        });
        list[place].segments += segments;
    }

    fn note(&mut self, node: &Node<'a, 'input>, property: &'static str) {
        if self.noted.insert((node.id(), property)) {
            self.report.notes.push(Note {
                element: node.tag_name().name().to_owned(),
                id: node.attribute("id").map(str::to_owned),
                line: self.lines.of(node.range().start),
                property,
            });
        }
    }
}

/// Puts the children of an element on the list, so that the first is visited first.
fn push_children<'a, 'input>(node: &Node<'a, 'input>, around: Rc<State>, waiting: &mut Vec<Visit<'a, 'input>>) {
    let children = node.children().rev().filter(Node::is_element);
    waiting.extend(children.map(|node| Visit { node, around: around.clone(), used: None }));
}

/// Where the lines of a text begin.
struct Lines(Vec<usize>);

impl Lines {
    fn new(text: &str) -> Self {
        Self(text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(at, _)| at).collect())
    }

    /// The line of a byte, from one.
    fn of(&self, byte: usize) -> u32 {
        1 + self.0.partition_point(|end| *end < byte) as u32
    }
}
