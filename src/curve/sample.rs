//! From a piece of a curve to the geodesics of its trace: halved evenly, or where the trace would turn too much.

use std::f64::consts::PI;

use super::{
    Sampling, TraceBound,
    average::{Averager, Span},
    piece::{Control, is_flat, leg_turn, with_length},
};
use crate::geodesic::{PathError, inner::InnerPath, tangent::spell_in};
use crate::surface::InnerPoint;

/// Adaptive sampling halves no piece more often.
const MAX_DEPTH: u8 = 20;
/// It makes no more pieces of a segment.
const MAX_LEAVES: usize = 4096;
/// It halves no polygon shorter than this share of the diagonal: at a cusp the turn stays whatever one does. A curve that
/// passes a cusp at a small distance turns within the square of that distance, so this must be far below what one sees.
const SHORTEST: f64 = 1e-10;

/// The geodesics of a trace and what belongs to them.
#[derive(Debug, Default)]
pub(crate) struct Sampled {
    pub(crate) paths: Vec<InnerPath>,
    /// Parameter of each point, one more than there are paths.
    pub(crate) parameters: Vec<f64>,
    pub(crate) bound: Option<TraceBound>,
}

/// How often a B-spline's interval is halved towards a knot to find the point where its trace ends. Where the next interval's
/// trace begins is found the same way, however deep either is traced.
const KNOT_DEPTH: u32 = 8;

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
    let knots = match sampling {
        Sampling::Length(_) => knots(averager, &control)?,
        _ => None, // equally deep, neighbours end in one place
    };
    // A chord is up to as many times as long as a leg as the degree says.
    let reach = if on_curve { control.legs().len() as f64 } else { 1.0 };
    let levels = sampling.levels(reach * control.longest_leg()).unwrap_or(0);
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
    if let Some([start, end]) = knots {
        if let Some(path) = out.paths.first_mut() {
            pin(averager, path, start, path.end)?;
        }
        if let Some(path) = out.paths.last_mut() {
            pin(averager, path, path.start, end)?;
        }
    }
    Ok(out)
}

/// The points between which a B-spline's interval runs; none for a Bézier polygon, whose ends are known.
fn knots(averager: &mut Averager<'_>, control: &Control) -> Result<Option<[InnerPoint; 2]>, PathError> {
    let Control::Interval(interval) = control else { return Ok(None) };
    if interval.knots.intervals == 1 {
        return Ok(None);
    }
    let [mut first, mut last] = [interval.clone(), interval.clone()];
    for _ in 0..KNOT_DEPTH {
        [first, _] = first.halve(averager)?;
        [_, last] = last.halve(averager)?;
    }
    let [first, last] = [first.bezier(averager)?, last.bezier(averager)?];
    Ok(first.first().zip(last.last()).map(|(first, last)| [first.start, last.end]))
}

/// Lets a path begin and end at other points, where it does not yet; says whether that moved it.
fn pin(
    averager: &mut Averager<'_>,
    path: &mut InnerPath,
    start: InnerPoint,
    end: InnerPoint,
) -> Result<bool, PathError> {
    let surface = averager.surface;
    let is_there = |a, b| surface.same_place(&surface.outer_point(a), &surface.outer_point(b));
    if is_there(&path.start, &start) && is_there(&path.end, &end) {
        return Ok(false);
    }
    *path = averager.leg(&start, &end)?;
    Ok(true)
}

impl Sampled {
    /// Adds the paths of a part of the curve.
    fn append(&mut self, paths: Vec<InnerPath>, from: f64, width: f64) {
        let count = paths.len();
        self.parameters.extend((1..=count).map(|k| from + width * (k as f64 / count as f64)));
        self.paths.extend(paths);
    }
}

/// The path from the first point of a polygon to its last.
fn chord(averager: &mut Averager<'_>, legs: &[InnerPath]) -> Result<InnerPath, PathError> {
    let Some((first, rest)) = legs.split_first() else { return Ok(InnerPath::default()) };
    let mut path = first.clone();
    for leg in rest {
        path = averager.bridge(Span::whole(&path), Span::whole(leg))?;
    }
    Ok(path)
}

/// The angles between a polygon and the path from its first point to its last, at either end: nearly a half turn where the
/// shortest path goes another way than the curve. Zero for a polygon of no length.
fn departures(averager: &Averager<'_>, legs: &[InnerPath], chord: &InnerPath) -> [f64; 2] {
    let surface = averager.surface;
    let backwards = |leg: &InnerPath| {
        let mut back = leg.clone();
        back.reverse(surface);
        back
    };
    let first = with_length(averager, legs).next().map_or(0.0, |leg| PI - leg_turn(averager, &backwards(leg), chord));
    let last = with_length(averager, legs).next_back();
    [first, last.map_or(0.0, |leg| PI - leg_turn(averager, chord, &backwards(leg)))]
}

/// What an adaptive trace is to keep.
#[derive(Clone, Copy)]
struct Limits {
    turn: f64,
    length: f64,
    on_curve: bool,
}

/// A piece that is halved no further, as far as one knows.
struct Part {
    control: Control,
    /// What it adds to the trace: the legs of its polygon, or the one path from end to end.
    paths: Vec<InnerPath>,
    /// Whether its polygon turns too much, where that is not what it adds.
    hides_bends: bool,
    /// Length of its polygon.
    length: f64,
    from: f64,
    depth: u8,
    /// Whether it ends where the next one begins.
    joined: bool,
    /// Whether the turns are known: those of its own paths, and the one where the next part begins.
    looked_at: bool,
    bent: bool,
    bent_after: bool,
}

impl Part {
    fn new(
        averager: &mut Averager<'_>,
        control: Control,
        from: f64,
        depth: u8,
        limits: Limits,
    ) -> Result<Self, PathError> {
        let mut paths = control.bezier(averager)?;
        let length = paths.iter().map(|leg| leg.length).sum();
        let mut hides_bends = false;
        if limits.on_curve {
            let chord = chord(averager, &paths)?;
            // A chord lies within two turns of its polygon. At the segment's ends half a turn is left for this side of the joint.
            let at_end = [from == 0.0, from + 0.5_f64.powi(i32::from(depth)) == 1.0];
            let departs = departures(averager, &paths, &chord).into_iter().zip(at_end);
            hides_bends = !is_flat(averager, &paths, limits.turn, limits.length)
                || departs.into_iter().any(|(angle, end)| angle > if end { 0.5 } else { 2.0 } * limits.turn);
            paths = vec![chord];
        }
        let (joined, looked_at, bent, bent_after) = (false, false, false, false);
        Ok(Self { control, paths, hides_bends, length, from, depth, joined, looked_at, bent, bent_after })
    }

    fn width(&self) -> f64 {
        0.5_f64.powi(i32::from(self.depth))
    }

    fn halve(&self, averager: &mut Averager<'_>, limits: Limits) -> Result<[Self; 2], PathError> {
        let depth = self.depth + 1;
        let [left, right] = self.control.halve(averager)?;
        let middle = self.from + 0.5 * self.width();
        Ok([Self::new(averager, left, self.from, depth, limits)?, Self::new(averager, right, middle, depth, limits)?])
    }

    /// What forbids to halve it, in a trace of `count` parts.
    fn bound(&self, averager: &Averager<'_>, count: usize) -> Option<TraceBound> {
        if self.length < SHORTEST * averager.surface.diagonal() {
            Some(TraceBound::Length)
        } else if self.depth >= MAX_DEPTH {
            Some(TraceBound::Depth)
        } else {
            (count >= MAX_LEAVES).then_some(TraceBound::Pieces)
        }
    }
}

/// Halves pieces that are bent, or that meet at too large an angle, until none is.
fn adapt(averager: &mut Averager<'_>, control: Control, limits: Limits) -> Result<Sampled, PathError> {
    let knots = knots(averager, &control)?;
    let mut parts = vec![Part::new(averager, control, 0.0, 0, limits)?];
    loop {
        // Joining two parts moves an end of one, which turns the path there: all are joined before any turn is looked at.
        for i in 1..parts.len() {
            join(averager, &mut parts[i - 1..=i])?;
        }
        if let Some([start, end]) = knots {
            if let Some(part) = parts.first_mut()
                && let Some(path) = part.paths.first_mut()
            {
                part.looked_at &= !pin(averager, path, start, path.end)?;
            }
            if let Some(part) = parts.last_mut()
                && let Some(path) = part.paths.last_mut()
            {
                part.looked_at &= !pin(averager, path, path.start, end)?;
            }
        }
        look_at(averager, &mut parts, limits);
        let mut wanted: Vec<bool> = parts.iter().map(|part| part.bent).collect();
        for (i, pair) in parts.windows(2).enumerate().filter(|(_, pair)| pair[0].bent_after) {
            let [a, b] = [pair[0].depth, pair[1].depth];
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
            return Ok(collect(parts, bound));
        }
        let old = std::mem::replace(&mut parts, Vec::with_capacity(count));
        for (part, wanted) in old.into_iter().zip(wanted) {
            if !wanted {
                parts.push(part);
                continue;
            }
            if let Some(before) = parts.last_mut() {
                before.joined = false;
            }
            parts.extend(part.halve(averager, limits)?);
        }
    }
}

/// Sees that a part ends where the next one begins: neighbours of different depth place their common point differently by a
/// hair, and the deeper one knows better where it is.
fn join(averager: &mut Averager<'_>, pair: &mut [Part]) -> Result<(), PathError> {
    let [a, b] = pair else { return Ok(()) };
    if std::mem::replace(&mut a.joined, true) {
        return Ok(());
    }
    a.looked_at = false;
    let (Some(before), Some(after)) = (a.paths.last_mut(), b.paths.first_mut()) else { return Ok(()) };
    if before.end == after.start {
        return Ok(());
    }
    let surface = averager.surface;
    if surface.same_place(&surface.outer_point(&before.end), &surface.outer_point(&after.start))
        && let Some(end) = spell_in(surface, &after.start, before.end.face)
    {
        // On small faces even rounding shows.
        before.end = end;
        before.measure(surface);
        return Ok(());
    }
    if a.depth < b.depth {
        *before = averager.leg(&before.start, &after.start)?;
    } else {
        *after = averager.leg(&before.end, &after.end)?;
        b.looked_at = false;
    }
    Ok(())
}

/// Measures the turns that are not known: each once, and again when a path beside it was moved.
fn look_at(averager: &Averager<'_>, parts: &mut [Part], limits: Limits) {
    let is_new: Vec<bool> = parts.iter().map(|part| !part.looked_at).collect();
    for i in 0..parts.len() {
        if is_new[i] {
            let flat = is_flat(averager, &parts[i].paths, limits.turn, limits.length);
            parts[i].bent = parts[i].hides_bends || !flat;
            parts[i].looked_at = true;
        }
        if i + 1 < parts.len() && (is_new[i] || is_new[i + 1]) {
            let before = with_length(averager, &parts[i].paths).next_back();
            let after = with_length(averager, &parts[i + 1].paths).next();
            parts[i].bent_after = before.zip(after).is_some_and(|(a, b)| leg_turn(averager, a, b) > limits.turn);
        }
    }
}

/// Puts the paths of all parts one after the other.
fn collect(parts: Vec<Part>, bound: Option<TraceBound>) -> Sampled {
    let mut out = Sampled { bound, parameters: vec![0.0], ..Sampled::default() };
    for part in parts {
        let (from, width) = (part.from, part.width());
        out.append(part.paths, from, width);
    }
    out
}
