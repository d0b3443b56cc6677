//! Anchors and handles in normal coordinates: by directions and lengths instead of places, so that they can be turned, scaled
//! and put down elsewhere.

use glam::{DMat2, DVec2};

use super::{Anchor, EditError, Handle, Join, Spline, handles};
use crate::geodesic::{
    PathError, PathFinder, PathQuality, Tangent,
    inner::InnerPath,
    tangent::{InnerTangent, turn_at, unit},
    transport::{angle_at, initial_direction, transport},
    walk::walk_in,
};
use crate::surface::{InnerPoint, PointError, Surface, SurfacePoint};

/// What the coordinates of anchors are counted from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum Coordinates {
    /// All from the centre: right for curves that are small against the surface. Beyond the cut locus neighbours may be
    /// reached by different ways, and are torn apart by a turn.
    #[default]
    Normal,
    /// The nearest anchor from the centre, every other one from its neighbour: keeps the shape of long splines, of which far
    /// ends then come to lie where the surface in between leads them.
    Chained,
}

/// What the coordinates of one anchor are counted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Origin {
    Centre,
    /// The anchor before it in the list.
    Before,
    /// The anchor behind it in the list.
    Behind,
}

/// An anchor in normal coordinates.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct NormalAnchor {
    origin: Origin,
    /// Straight walks one after the other, each in the frame that the one before carried along. One is enough, but where the
    /// shortest path bends at vertices: no straight walk leads there.
    steps: Vec<DVec2>,
    join: Join,
    incoming: NormalHandle,
    outgoing: NormalHandle,
}

/// A handle in the frame at its anchor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
struct NormalHandle {
    /// Unit direction; zero where it never had one.
    heading: DVec2,
    /// The length asked for.
    length: f64,
}

/// Most walks to one anchor.
const MAX_STEPS: usize = 8;
/// An anchor is reached within this share of the diagonal.
const REACHED: f64 = 1e-10;
/// Where the path bends, the first walk turns aside by this much (radians): one that meets vertices exactly would not lead
/// near there any more once it is turned a little.
const ASIDE: f64 = 1e-3;
/// Walks longer than this many diagonals are cut short.
const MAX_LENGTH: f64 = 16.0;

/// A place with a direction that angles are counted from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    at: InnerPoint,
    x: InnerTangent,
}

impl Frame {
    /// The frame at a point; its x axis is that of the point's face unless another is given.
    pub(crate) fn new(surface: &Surface, at: &SurfacePoint, axis: Option<&Tangent>) -> Result<Self, EditError> {
        let axis = axis.copied().unwrap_or(Tangent { face: at.face, vector: DVec2::X });
        let (at, x) = surface.inner_tangent_at(at, &axis)?;
        let vector = unit(x.vector);
        if vector == DVec2::ZERO {
            return Err(EditError::BadTransform);
        }
        Ok(Self { at, x: InnerTangent { vector, ..x } })
    }

    /// The frame carried along a path that begins at it.
    pub(crate) fn carried(&self, surface: &Surface, path: &InnerPath) -> Self {
        let x = transport(surface, path, &self.x);
        Self { at: path.end, x: InnerTangent { vector: unit(x.vector), ..x } }
    }

    /// Where a straight walk leads, and whether the boundary cut it short.
    fn walked(&self, surface: &Surface, spare: &mut InnerPath, step: DVec2) -> (Self, bool) {
        // A document may say anything.
        let step = if step.is_finite() { step } else { DVec2::ZERO };
        let heading = self.heading(surface, step);
        let length = step.length().min(MAX_LENGTH * surface.diagonal());
        let walk = walk_in(surface, &self.at, &heading, length, std::mem::take(spare));
        *spare = walk.path;
        (self.carried(surface, spare), walk.stopped.is_some() && length - spare.length > REACHED * surface.diagonal())
    }

    fn heading(&self, surface: &Surface, direction: DVec2) -> InnerTangent {
        turn_at(surface, &self.at, &self.x, direction.y.atan2(direction.x))
    }

    /// Angle of a tangent at the frame's place.
    fn angle_of(&self, surface: &Surface, at: &InnerPoint, tangent: &InnerTangent) -> f64 {
        angle_at(surface, at, &self.x, tangent)
    }

    /// The walks that lead to a point, and the frame there.
    fn steps_to(
        &self,
        surface: &Surface,
        finder: &mut PathFinder,
        goal: &InnerPoint,
    ) -> Result<(Vec<DVec2>, Self), PathError> {
        let (mut path, mut spare) = (finder.lend_path(), finder.lend_path());
        let reached = REACHED * surface.diagonal();
        let (mut frame, mut steps) = (*self, Vec::with_capacity(1));
        for k in 0..MAX_STEPS {
            finder.shortest_inner(surface, &frame.at, goal, PathQuality::Default, &mut path)?;
            if path.length <= reached && k > 0 {
                break;
            }
            let bends = path.at.iter().any(|at| *at == 0.0 || *at == 1.0);
            let direction = initial_direction(surface, &path);
            if direction.vector == DVec2::ZERO {
                steps.push(DVec2::ZERO);
                break;
            }
            let angle = frame.angle_of(surface, &path.start, &direction) + if bends { ASIDE } else { 0.0 };
            let step = DVec2::from_angle(angle) * path.length;
            steps.push(step);
            frame = frame.walked(surface, &mut spare, step).0;
            let there = surface.inner_position(&frame.at).distance(surface.inner_position(goal)) <= reached;
            if !bends && there {
                break;
            }
        }
        finder.take_path_back(path);
        finder.take_path_back(spare);
        Ok((steps, frame))
    }
}

/// Anchors in normal coordinates about a frame.
pub(crate) fn normalised(
    surface: &Surface,
    finder: &mut PathFinder,
    centre: &Frame,
    anchors: &[&Anchor],
    coordinates: Coordinates,
) -> Result<Vec<NormalAnchor>, PathError> {
    let points = anchors.iter().map(|a| surface.inner_point(&a.point)).collect::<Result<Vec<_>, _>>()?;
    let mut out: Vec<Option<NormalAnchor>> = vec![None; anchors.len()];
    let mut place = |i: usize, origin: Origin, from: &Frame| -> Result<Frame, PathError> {
        let (steps, frame) = from.steps_to(surface, finder, &points[i])?;
        let anchor = anchors[i];
        let handle = |handle: &Handle| -> Result<NormalHandle, PointError> {
            let heading = surface.inner_tangent(&handle.heading)?;
            let flat = if heading.vector == DVec2::ZERO {
                DVec2::ZERO
            } else {
                DVec2::from_angle(frame.angle_of(surface, &points[i], &heading))
            };
            Ok(NormalHandle { heading: flat, length: handle.wished_length })
        };
        let (incoming, outgoing) = (handle(&anchor.incoming)?, handle(&anchor.outgoing)?);
        out[i] = Some(NormalAnchor { origin, steps, join: anchor.join, incoming, outgoing });
        Ok(frame)
    };
    match coordinates {
        Coordinates::Normal => {
            for i in 0..anchors.len() {
                place(i, Origin::Centre, centre)?;
            }
        }
        Coordinates::Chained => {
            let here = surface.inner_position(&centre.at);
            let far = |i: &usize| surface.inner_position(&points[*i]).distance_squared(here);
            let nearest = (0..anchors.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
            if let Some(nearest) = nearest {
                let first = place(nearest, Origin::Centre, centre)?;
                let mut frame = first;
                for i in nearest + 1..anchors.len() {
                    frame = place(i, Origin::Before, &frame)?;
                }
                frame = first;
                for i in (0..nearest).rev() {
                    frame = place(i, Origin::Behind, &frame)?;
                }
            }
        }
    }
    Ok(out.into_iter().flatten().collect())
}

/// An anchor put down, and whether the boundary was in its way.
pub(crate) struct Placed {
    pub(crate) anchor: Anchor,
    pub(crate) clipped: bool,
}

/// Anchors from their normal coordinates about a frame, mapped by a matrix.
pub(crate) fn placed(
    surface: &Surface,
    centre: &Frame,
    anchors: &[NormalAnchor],
    matrix: DMat2,
) -> Result<Vec<Placed>, PointError> {
    let mut frames: Vec<Option<(Frame, bool)>> = vec![None; anchors.len()];
    let mut spare = InnerPath::default();
    let mut walk = |from: Frame, anchor: &NormalAnchor| {
        let mut clipped = false;
        let mut frame = from;
        for step in &anchor.steps {
            let (next, stopped) = frame.walked(surface, &mut spare, matrix * *step);
            // A short way on from where a long one met the boundary is no help.
            clipped |= stopped;
            frame = next;
        }
        (frame, clipped)
    };
    for (anchor, out) in anchors.iter().zip(&mut frames).filter(|(anchor, _)| anchor.origin == Origin::Centre) {
        *out = Some(walk(*centre, anchor));
    }
    for i in 1..anchors.len() {
        if let (Origin::Before, Some((before, clipped))) = (anchors[i].origin, frames[i - 1]) {
            let (frame, own) = walk(before, &anchors[i]);
            frames[i] = Some((frame, own || clipped));
        }
    }
    for i in (1..anchors.len()).rev() {
        if let (Origin::Behind, Some((behind, clipped))) = (anchors[i - 1].origin, frames[i]) {
            let (frame, own) = walk(behind, &anchors[i - 1]);
            frames[i - 1] = Some((frame, own || clipped));
        }
    }
    let place = |(anchor, found): (&NormalAnchor, Option<(Frame, bool)>)| {
        // Nothing that was copied is without a frame, but a document may say anything.
        let (frame, clipped) = found.unwrap_or((*centre, true));
        let point = handles::without_negative_zeros(surface.outer_point(&frame.at));
        let mut out = handles::bare_anchor(surface, point)?;
        out.join = anchor.join;
        out.incoming = handle_in(surface, &frame, &point, &anchor.incoming, matrix)?;
        out.outgoing = handle_in(surface, &frame, &point, &anchor.outgoing, matrix)?;
        Ok(Placed { anchor: out, clipped })
    };
    anchors.iter().zip(frames).map(place).collect()
}

/// A handle from its direction and length in a frame.
fn handle_in(
    surface: &Surface,
    frame: &Frame,
    point: &SurfacePoint,
    handle: &NormalHandle,
    matrix: DMat2,
) -> Result<Handle, PointError> {
    let mapped = matrix * handle.heading;
    if mapped == DVec2::ZERO || !mapped.is_finite() {
        return Ok(handles::bare_handle(*point));
    }
    let length = handle.length.max(0.0) * mapped.length();
    let heading = frame.heading(surface, mapped);
    handles::ahead(surface, point, &heading, if length.is_finite() { length } else { 0.0 })
}

/// Puts anchors with automatic joins, and those beside, where their neighbours ask for.
pub(crate) fn settle_automatic(
    surface: &Surface,
    finder: &mut PathFinder,
    spline: &mut Spline,
    moved: &[usize],
) -> Result<(), PathError> {
    let mut around: Vec<usize> = Vec::new();
    for i in moved {
        let (before, after) = spline.neighbours(*i);
        around.extend([before, Some(*i), after].into_iter().flatten());
    }
    around.sort_unstable();
    around.dedup();
    for i in around {
        if spline.anchors.get(i).is_some_and(|anchor| anchor.join == Join::Automatic) {
            handles::place_automatic(surface, finder, spline, i)?;
        }
    }
    Ok(())
}
