//! From a piece of a curve to the geodesics of its trace: halved evenly, or where the trace would turn too much.

use super::{
    Sampling, TraceBound,
    average::{Averager, Span},
    casteljau::Legs,
    piece::{Control, is_flat, joint_turn},
};
use crate::geodesic::{PathError, inner::InnerPath};

/// Adaptive sampling halves no piece more often.
const MAX_DEPTH: u8 = 20;
/// It makes no more pieces of a segment.
const MAX_LEAVES: usize = 4096;
/// It halves no polygon shorter than this share of the diagonal: at a cusp the turn stays whatever one does.
const SHORTEST: f64 = 1e-6;

/// The geodesics of a trace and what belongs to them.
#[derive(Debug, Default)]
pub(crate) struct Sampled {
    pub(crate) paths: Vec<InnerPath>,
    /// Parameter of each point, one more than there are paths.
    pub(crate) parameters: Vec<f64>,
    pub(crate) bound: Option<TraceBound>,
}

/// Traces a piece; `on_curve` joins the ends of its parts, else the control points of the parts are joined.
pub(crate) fn sample(
    averager: &mut Averager<'_>,
    control: Control,
    sampling: Sampling,
    on_curve: bool,
) -> Result<Sampled, PathError> {
    if let Sampling::Adaptive { turn, length } = sampling {
        let limits = Limits { turn: turn.max(0.0), length: length.unwrap_or(f64::INFINITY), on_curve };
        return adapt(averager, control, limits);
    }
    let levels = sampling.levels(control.longest_leg()).unwrap_or(0);
    let mut controls = vec![control];
    for _ in 0..levels {
        let halves = controls.iter().map(|control| control.halve(averager));
        controls = halves.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    }
    let width = 1.0 / controls.len() as f64;
    let mut out = Sampled { parameters: vec![0.0], ..Sampled::default() };
    for (i, control) in controls.into_iter().enumerate() {
        let legs = control.into_bezier(averager)?;
        let paths = if on_curve { vec![chord(averager, &legs)?] } else { legs };
        out.append(paths, i as f64 * width, width);
    }
    Ok(out)
}

impl Sampled {
    /// Adds the paths of a part of the curve.
    fn append(&mut self, paths: Vec<InnerPath>, from: f64, width: f64) {
        let count = paths.len();
        self.parameters.extend((1..=count).map(|k| from + width * (k as f64 / count as f64)));
        self.paths.extend(paths);
    }
}

/// A piece that is halved no further, as far as one knows.
struct Leaf {
    control: Control,
    /// The Bézier polygon that stands for it.
    legs: Legs,
    /// What it adds to the trace: its legs, or the one path from end to end.
    out: Vec<InnerPath>,
    from: f64,
    depth: u8,
}

impl Leaf {
    fn new(
        averager: &mut Averager<'_>,
        control: Control,
        from: f64,
        depth: u8,
        on_curve: bool,
    ) -> Result<Self, PathError> {
        let legs = control.bezier(averager)?;
        let out = if on_curve { vec![chord(averager, &legs)?] } else { legs.clone() };
        Ok(Self { control, legs, out, from, depth })
    }

    fn width(&self) -> f64 {
        0.5_f64.powi(i32::from(self.depth))
    }

    fn halve(&self, averager: &mut Averager<'_>, on_curve: bool) -> Result<[Self; 2], PathError> {
        let depth = self.depth + 1;
        let [left, right] = self.control.halve(averager)?;
        let middle = self.from + 0.5 * self.width();
        Ok([
            Self::new(averager, left, self.from, depth, on_curve)?,
            Self::new(averager, right, middle, depth, on_curve)?,
        ])
    }
}

/// The path from the first point of a polygon to its last.
fn chord(averager: &mut Averager<'_>, legs: &[InnerPath]) -> Result<InnerPath, PathError> {
    let Some((first, rest)) = legs.split_first() else { return Ok(InnerPath::default()) };
    let mut path = first.clone();
    for leg in rest {
        path = averager.bridge(Span::new(&path, 0.0, 1.0), Span::new(leg, 0.0, 1.0))?;
    }
    Ok(path)
}

/// What an adaptive trace is to keep.
#[derive(Clone, Copy)]
struct Limits {
    turn: f64,
    length: f64,
    on_curve: bool,
}

/// How a leaf is joined to the next: neighbours of different depth place their common point differently by a hair, and one
/// of them is joined to the other's.
#[derive(Default)]
struct Seam {
    /// Takes the place of the last path before the joint.
    before: Option<InnerPath>,
    /// Takes the place of the first path after it.
    after: Option<InnerPath>,
    /// Whether the trace turns too much there.
    bent: bool,
    /// Whether it is up to date.
    known: bool,
}

/// A leaf of an adaptive trace.
struct Part {
    leaf: Leaf,
    /// Whether its own polygon turns too much or is too long.
    bent: bool,
    /// How it is joined to the next.
    seam: Seam,
}

impl Part {
    fn new(averager: &Averager<'_>, leaf: Leaf, limits: Limits) -> Self {
        let bent = !is_flat(averager, &leaf.legs, limits.turn, limits.length);
        Self { leaf, bent, seam: Seam::default() }
    }

    /// What forbids to halve it, in a trace of `count` parts.
    fn bound(&self, averager: &Averager<'_>, count: usize) -> Option<TraceBound> {
        let length: f64 = self.leaf.legs.iter().map(|leg| leg.length).sum();
        if length < SHORTEST * averager.surface.diagonal() {
            Some(TraceBound::Length)
        } else if self.leaf.depth >= MAX_DEPTH {
            Some(TraceBound::Depth)
        } else {
            (count >= MAX_LEAVES).then_some(TraceBound::Pieces)
        }
    }
}

/// Halves pieces that are bent, or that meet at too large an angle, until none is.
fn adapt(averager: &mut Averager<'_>, control: Control, limits: Limits) -> Result<Sampled, PathError> {
    let root = Leaf::new(averager, control, 0.0, 0, limits.on_curve)?;
    let mut parts = vec![Part::new(averager, root, limits)];
    loop {
        // The turn of each piece is looked at once, that of each joint when one of its pieces is new.
        for i in 1..parts.len() {
            if !parts[i - 1].seam.known {
                parts[i - 1].seam = seam(averager, &parts[i - 1].leaf, &parts[i].leaf, limits.turn)?;
            }
        }
        let mut wanted: Vec<bool> = parts.iter().map(|part| part.bent).collect();
        for (i, pair) in parts.windows(2).enumerate().filter(|(_, pair)| pair[0].seam.bent) {
            let [a, b] = [pair[0].leaf.depth, pair[1].leaf.depth];
            wanted[i] |= a <= b;
            wanted[i + 1] |= b <= a;
        }
        let mut bound = None;
        let mut count = parts.len();
        for (part, wanted) in parts.iter().zip(&mut wanted).filter(|(_, wanted)| **wanted) {
            let met = part.bound(averager, count);
            bound = bound.or(met);
            *wanted = met.is_none();
            count += usize::from(*wanted);
        }
        if !wanted.contains(&true) {
            return collect(averager, parts, bound);
        }
        let old = std::mem::replace(&mut parts, Vec::with_capacity(count));
        for (part, wanted) in old.into_iter().zip(wanted) {
            if !wanted {
                parts.push(part);
                continue;
            }
            if let Some(before) = parts.last_mut() {
                before.seam.known = false;
            }
            for half in part.leaf.halve(averager, limits.on_curve)? {
                parts.push(Part::new(averager, half, limits));
            }
        }
    }
}

fn seam(averager: &mut Averager<'_>, a: &Leaf, b: &Leaf, turn: f64) -> Result<Seam, PathError> {
    let mut seam = Seam { known: true, ..Seam::default() };
    let (Some(before), Some(after)) = (a.out.last(), b.out.first()) else { return Ok(seam) };
    let surface = averager.surface;
    if !surface.same_place(&surface.outer_point(&before.end), &surface.outer_point(&after.start)) {
        // The deeper piece knows better where the point is.
        if a.depth < b.depth {
            seam.before = Some(averager.leg(&before.start, &after.start)?);
        } else {
            seam.after = Some(averager.leg(&before.end, &after.end)?);
        }
    }
    let (before, after) = (seam.before.as_ref().unwrap_or(before), seam.after.as_ref().unwrap_or(after));
    seam.bent = joint_turn(averager, before, after) > turn;
    Ok(seam)
}

/// Puts the paths of all leaves one after the other.
fn collect(averager: &mut Averager<'_>, parts: Vec<Part>, bound: Option<TraceBound>) -> Result<Sampled, PathError> {
    let mut out = Sampled { bound, parameters: vec![0.0], ..Sampled::default() };
    let mut first: Option<InnerPath> = None;
    for Part { leaf, seam, .. } in parts {
        let (from, width, mut paths) = (leaf.from, leaf.width(), leaf.out);
        match (&mut paths[..], first.take(), seam.before) {
            // A single path that is replaced at both ends.
            ([only], Some(new), Some(last)) => *only = averager.leg(&new.start, &last.end)?,
            (paths, new, last) => {
                if let (Some(new), Some(old)) = (new, paths.first_mut()) {
                    *old = new;
                }
                if let (Some(new), Some(old)) = (last, paths.last_mut()) {
                    *old = new;
                }
            }
        }
        out.append(paths, from, width);
        first = seam.after;
    }
    Ok(out)
}
