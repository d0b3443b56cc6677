//! Splines made of a drawing.

use glam::DVec2;

use super::{
    PlaceError, Placement, clip,
    frame::{Frame, Landing, Miss},
};
use crate::curve::{Anchor, Handle, Join, Scheme, Spline, TraceWorkspace, assemble::AnchorPlan, handles};
use crate::geodesic::{WalkStop, inner::InnerPath, tangent::InnerTangent};
use crate::surface::{PointError, Surface};
use crate::vector::{Drawing, JoinTolerance, PathJoin, VectorPath};

/// How handles come onto the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub enum HandleRule {
    /// From their anchor, along axes that are carried there: tangents are kept exactly.
    #[default]
    Relative,
    /// Like anchors, by polar coordinates from the centre, as in the b/Surf paper; smooth joins are made smooth again.
    Polar,
}

/// What becomes of paths that leave the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub enum Boundary {
    /// A path with an anchor off the surface is dropped whole.
    #[default]
    Drop,
    /// It is cut where it leaves the surface; what is left of it becomes open splines.
    Clip,
}

/// How a drawing is placed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaceOptions {
    /// How handles come onto the surface.
    pub handles: HandleRule,
    /// What becomes of paths that leave it.
    pub boundary: Boundary,
    /// When joins of the drawing count as smooth. Such joins are made exactly so, which moves handles by no more than this.
    pub joins: JoinTolerance,
    /// How the splines are traced.
    pub scheme: Scheme,
    /// The point of the drawing that lies at the placement's; its [`centre`](Drawing::centre) if there is none.
    pub origin: Option<DVec2>,
    /// Whether paths without fill and stroke are placed too.
    pub invisible: bool,
}

/// Why a path is not on the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum DropReason {
    /// It leaves the surface.
    #[error("it leaves the surface: place it elsewhere, or smaller, or let it be clipped")]
    OffSurface,
    /// It is farther from the centre than sixteen diagonals of the surface.
    #[error("it is far larger than the surface: place it smaller")]
    TooFar,
    /// The walk to it took too many steps.
    #[error("the way to it crosses too many faces: place it smaller")]
    StepLimit,
    /// It has neither fill nor stroke.
    #[error("it has neither fill nor stroke")]
    Invisible,
}

/// What became of a path of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathOutcome {
    /// It became one spline.
    Placed,
    /// It was cut at the boundary.
    Clipped {
        /// How many of its segments are off the surface as a whole.
        gone: u32,
    },
    /// There is nothing of it.
    Dropped(DropReason),
}

/// A path of a drawing, and what became of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlacedPath {
    /// Its shape's place in the drawing.
    pub shape: u32,
    /// Its place in the shape.
    pub path: u32,
    /// What became of it.
    pub outcome: PathOutcome,
    /// How many handles the boundary cut short.
    pub clipped_handles: u32,
}

/// A spline that a path of a drawing became, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedSpline {
    /// The shape's place in the drawing.
    pub shape: u32,
    /// The path's place in the shape.
    pub path: u32,
    /// The spline.
    pub spline: Spline,
}

/// A drawing on a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlacedDrawing {
    /// The splines, in the order of the paths.
    pub splines: Vec<PlacedSpline>,
    /// What became of each path, in order.
    pub paths: Vec<PlacedPath>,
}

impl PlacedDrawing {
    /// How many paths were dropped, those that are invisible aside.
    pub fn dropped(&self) -> usize {
        let dropped = |path: &&PlacedPath| match path.outcome {
            PathOutcome::Dropped(reason) => reason != DropReason::Invisible,
            _ => false,
        };
        self.paths.iter().filter(dropped).count()
    }
}

/// Places a drawing on a surface.
///
/// Joins that are smooth or mirrored in the drawing become so on the surface, others are corners. With the feature `parallel` paths are
/// spread over the caller's rayon pool; the result does not depend on the number of threads.
///
/// Cost: about three walks an anchor, 50 ns for each face crossed.
///
/// # Errors
/// [`PlaceError`] if the placement makes no sense. What becomes of single paths stands in the result.
///
/// ```
/// use bevy_surface_splines::{placement::*, surface::{Surface, SurfaceOptions, shapes}, vector::*};
/// use glam::{DVec2, DVec3};
///
/// let mut pen = PathBuilder::default();
/// pen.move_to(DVec2::new(1.0, 0.0));
/// pen.arc_to(DVec2::ONE, 0.0, false, true, DVec2::new(-1.0, 0.0));
/// pen.arc_to(DVec2::ONE, 0.0, false, true, DVec2::new(1.0, 0.0));
/// pen.close();
/// let fill = Some(Paint::Color(Color::BLACK));
/// let circle = Shape { paths: pen.finish(), style: Style { fill, opacity: 1.0, ..Style::default() }, ..Shape::default() };
/// let drawing = Drawing { shapes: vec![circle], ..Drawing::default() };
///
/// let surface = Surface::build(&shapes::icosphere(4), &SurfaceOptions::default())?;
/// let at = surface.closest_point(DVec3::X).unwrap().point;
/// let placement = Placement { at, up: DVec3::Z, scale: 0.3 };
/// let placed = place_drawing(&surface, &drawing, &placement, &PlaceOptions::default())?;
/// let circle = &placed.splines[0].spline;
/// assert!(circle.is_closed() && circle.anchors().len() == 4);
/// let up = surface.position(&circle.anchors()[3].point()); // the anchor at (0, −1): SVG's y runs down
/// assert!((up.z - 0.3_f64.sin()).abs() < 1e-2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn place_drawing(
    surface: &Surface,
    drawing: &Drawing,
    placement: &Placement,
    options: &PlaceOptions,
) -> Result<PlacedDrawing, PlaceError> {
    let frame = Frame::new(surface, placement, options.origin.unwrap_or_else(|| drawing.centre()))?;
    let jobs: Vec<(u32, u32, &VectorPath, bool)> = drawing
        .shapes
        .iter()
        .zip(0..)
        .flat_map(|(shape, i)| {
            let wanted = options.invisible || shape.style.is_visible();
            shape.paths.iter().zip(0..).map(move |(path, k)| (i, k, path, wanted))
        })
        .collect();
    let place = |workspace: &mut Workspace, (shape, path, curve, wanted): &(u32, u32, &VectorPath, bool)| {
        let mut made = Made::default();
        let outcome = if *wanted {
            place_path(&frame, curve, options, workspace, &mut made)?
        } else {
            PathOutcome::Dropped(DropReason::Invisible)
        };
        let (shape, path) = (*shape, *path);
        let splines: Vec<_> = made.splines.into_iter().map(|spline| PlacedSpline { shape, path, spline }).collect();
        Ok((splines, PlacedPath { shape, path, outcome, clipped_handles: made.clipped_handles }))
    };
    #[cfg(feature = "parallel")]
    let placed: Vec<Result<_, PointError>> = {
        use rayon::prelude::*;
        jobs.par_iter().map_init(Workspace::default, place).collect()
    };
    #[cfg(not(feature = "parallel"))]
    let placed: Vec<Result<_, PointError>> = {
        let mut workspace = Workspace::default();
        jobs.iter().map(|job| place(&mut workspace, job)).collect()
    };
    let mut all = PlacedDrawing::default();
    for one in placed {
        let (splines, path) = one?;
        all.splines.extend(splines);
        all.paths.push(path);
    }
    Ok(all)
}

/// Scratch memory of one thread.
#[derive(Default)]
struct Workspace {
    walk: InnerPath,
    handle: InnerPath,
    trace: TraceWorkspace,
}

/// What a path became.
#[derive(Default)]
struct Made {
    splines: Vec<Spline>,
    clipped_handles: u32,
}

fn place_path(
    frame: &Frame<'_>,
    path: &VectorPath,
    options: &PlaceOptions,
    workspace: &mut Workspace,
    made: &mut Made,
) -> Result<PathOutcome, PointError> {
    let miss = match land_all(frame, path, workspace) {
        Ok(landings) => {
            place_whole(frame, path, &landings, options, workspace, made)?;
            return Ok(PathOutcome::Placed);
        }
        Err(miss) => miss,
    };
    let reason = match miss {
        Miss::TooFar => DropReason::TooFar,
        Miss::Stopped(WalkStop::Boundary) => DropReason::OffSurface,
        Miss::Stopped(WalkStop::StepLimit) => DropReason::StepLimit,
    };
    if options.boundary == Boundary::Drop || reason != DropReason::OffSurface {
        return Ok(PathOutcome::Dropped(reason));
    }
    let (parts, gone) = clip::parts(frame, path, &mut workspace.walk);
    for part in &parts {
        if let Ok(landings) = land_all(frame, part, workspace) {
            place_whole(frame, part, &landings, options, workspace, made)?;
        }
    }
    Ok(if made.splines.is_empty() { PathOutcome::Dropped(reason) } else { PathOutcome::Clipped { gone } })
}

/// Where all anchors of a path come to lie.
fn land_all(frame: &Frame<'_>, path: &VectorPath, workspace: &mut Workspace) -> Result<Vec<Landing>, Miss> {
    let anchors = (0..path.anchor_count()).filter_map(|i| path.anchor(i));
    anchors.map(|anchor| frame.land(anchor, &mut workspace.walk)).collect()
}

/// A handle that is shorter than asked for by less than this share of the surface's diagonal is not cut, but rounded.
const ROUNDING: f64 = 1e-12;

/// Makes the spline of a path whose anchors are all on the surface.
fn place_whole(
    frame: &Frame<'_>,
    path: &VectorPath,
    landings: &[Landing],
    options: &PlaceOptions,
    workspace: &mut Workspace,
    made: &mut Made,
) -> Result<(), PointError> {
    let extent = path.extent();
    let mut anchors = Vec::with_capacity(landings.len());
    for (i, landing) in landings.iter().enumerate() {
        let join = path.join(i, extent, &options.joins);
        let is_long = |handle: &DVec2| handle.length() > 10.0 * options.joins.rounding * extent;
        let planar = path.handles(i).map(|h| h.filter(is_long).map_or(DVec2::ZERO, |handle| frame.planar(handle)));
        let [incoming, outgoing] = aligned(planar, join).map(|vector| frame.tangent(landing, vector));
        let join = match join {
            PathJoin::Corner => Join::Corner,
            PathJoin::Smooth => Join::Smooth,
            PathJoin::Mirrored => Join::Mirrored,
        };
        let plan = AnchorPlan { at: landing.at, join, incoming, outgoing };
        let mut anchor = plan.anchor(frame.surface, &mut workspace.handle)?;
        if options.handles == HandleRule::Polar {
            move_to_polar(frame, path, i, &plan, &mut anchor, workspace)?;
        }
        let is_cut =
            |handle: &&Handle| handle.wished_length() - handle.leg().length() > ROUNDING * frame.surface.diagonal();
        made.clipped_handles += [anchor.incoming(), anchor.outgoing()].iter().filter(|h| is_cut(h)).count() as u32;
        anchors.push(anchor);
    }
    made.splines.push(Spline::of_anchors(anchors, path.is_closed(), options.scheme));
    Ok(())
}

/// The handles of a join made exactly what the join says: the shorter one is turned, which moves its end the least.
fn aligned([incoming, outgoing]: [DVec2; 2], join: PathJoin) -> [DVec2; 2] {
    let (reach_in, reach_out) = (incoming.length(), outgoing.length());
    match join {
        PathJoin::Corner => [incoming, outgoing],
        PathJoin::Smooth if reach_in > reach_out => [incoming, incoming * (-reach_out / reach_in)],
        PathJoin::Smooth => [outgoing * (-reach_in / reach_out), outgoing],
        PathJoin::Mirrored => {
            let half = 0.5 * (outgoing - incoming);
            [-half, half]
        }
    }
}

/// Moves the handles of an anchor to where their own polar coordinates lead; one that is off the surface stays.
fn move_to_polar(
    frame: &Frame<'_>,
    path: &VectorPath,
    i: usize,
    plan: &AnchorPlan,
    anchor: &mut Anchor,
    workspace: &mut Workspace,
) -> Result<(), PointError> {
    let Some(at) = path.anchor(i) else { return Ok(()) };
    let [incoming, outgoing] = path.handles(i);
    let point = anchor.point();
    let is_drawn = |vector: &InnerTangent| vector.vector != DVec2::ZERO;
    let sides = [
        (incoming.filter(|_| is_drawn(&plan.incoming)), &mut anchor.incoming),
        (outgoing.filter(|_| is_drawn(&plan.outgoing)), &mut anchor.outgoing),
    ];
    for (vector, handle) in sides {
        let Some(vector) = vector else { continue };
        let Ok(landing) = frame.land(at + vector, &mut workspace.walk) else { continue };
        let to = frame.surface.outer_point(&landing.at);
        // Both lie on one sheet, since both were walked to from one point.
        if let Ok(moved) = handles::towards(frame.surface, &mut workspace.trace.finder, &point, &to) {
            *handle = moved;
        }
    }
    match plan.join {
        Join::Smooth => handles::align(frame.surface, anchor, false),
        Join::Mirrored => handles::align(frame.surface, anchor, true),
        Join::Corner | Join::Automatic => Ok(()),
    }
}
