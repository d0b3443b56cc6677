//! Traces as components.

use std::ops::Range;
use std::sync::{Arc, Weak};

use bevy::prelude::*;

use super::surface::BuiltSurface;
use crate::curve::{Spline, Trace};
use crate::surface::Surface;

/// The curve of a spline: a system writes it whenever spline or surface change. Derived: it is never saved.
///
/// It is always exact, and what [`Spline::trace`] gives, bit for bit; but it may lag behind its
/// [`SurfaceSpline`](super::SurfaceSpline), while a trace that takes longer than a frame has is computed in the background:
/// [`SplineState`](super::SplineState) is `Tracing` then, and a [`TracePreview`](super::TracePreview) is there to be shown.
#[derive(Component, Clone, Debug, Deref)]
#[component(immutable)]
pub struct SplineTrace {
    #[deref]
    trace: Arc<Trace>,
    polyline: Polyline,
    /// What was traced; splines that differ in other things than their curve may have the same trace.
    spline: Arc<Spline>,
    surface: Weak<Surface>,
}

impl SplineTrace {
    pub(crate) fn new(trace: Trace, spline: Arc<Spline>, surface: &Arc<Surface>) -> Self {
        let polyline = Polyline::of(&trace);
        Self { trace: Arc::new(trace), polyline, spline, surface: Arc::downgrade(surface) }
    }

    /// The trace itself.
    pub fn trace(&self) -> &Arc<Trace> {
        &self.trace
    }

    /// Positions along the curve in the surface's local space, crossings of edges included.
    pub fn polyline(&self) -> &[Vec3] {
        self.polyline.positions()
    }

    /// The unbroken pieces of the [`polyline`](Self::polyline): a single one, unless the curve is torn, which curves of the
    /// schemes for comparison may be.
    pub fn pieces(&self) -> impl Iterator<Item = &[Vec3]> {
        self.polyline.pieces()
    }

    /// Whether it was traced on this very surface.
    pub fn is_on(&self, surface: &BuiltSurface) -> bool {
        std::ptr::eq(self.surface.as_ptr(), Arc::as_ptr(&surface.0))
    }

    /// The centre and radius of a sphere that holds the polyline, in local space.
    pub(crate) fn bounds(&self) -> (Vec3, f32) {
        self.polyline.bounds()
    }

    /// The spline that was traced.
    pub(crate) fn spline(&self) -> &Arc<Spline> {
        &self.spline
    }

    /// Its polyline, to be shown elsewhere.
    pub(crate) fn shown(&self) -> Polyline {
        self.polyline.clone()
    }

    /// How many segments another trace does not share, at their place or shifted by one.
    pub(crate) fn segments_not_in(&self, other: Option<&Self>) -> u32 {
        let known = other.map_or(&[][..], |other| other.segments());
        let near = |i: usize| &known[i.saturating_sub(1).min(known.len())..(i + 2).min(known.len())];
        let is_new = |(i, segment): &(usize, &Arc<_>)| !near(*i).iter().any(|k| Arc::ptr_eq(k, segment));
        self.segments().iter().enumerate().filter(is_new).count() as u32
    }

    /// Whether two traces are of one surface and share all their segments.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let (a, b) = (self.segments(), other.segments());
        Weak::ptr_eq(&self.surface, &other.surface)
            && a.len() == b.len()
            && a.iter().zip(b).all(|(a, b)| Arc::ptr_eq(a, b))
    }
}

/// Happens when a spline has a new [`SplineTrace`].
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct TraceChanged {
    /// The spline.
    pub entity: Entity,
    /// How many segments are new; the others are shared with the trace before.
    pub retraced: u32,
}

/// Positions in local space, in unbroken pieces; cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Polyline {
    positions: Arc<[Vec3]>,
    pieces: Arc<[Range<usize>]>,
    /// A sphere that holds it: centre and radius.
    bounds: (Vec3, f32),
}

impl Polyline {
    pub(crate) fn of(trace: &Trace) -> Self {
        let positions: Arc<[Vec3]> = trace.positions().iter().map(|p| p.as_vec3()).collect();
        let bounds = sphere_around(&positions);
        Self { positions, pieces: trace.pieces().into(), bounds }
    }

    /// A single piece.
    pub(crate) fn unbroken(positions: impl Iterator<Item = Vec3>) -> Self {
        let positions: Arc<[Vec3]> = positions.collect();
        let bounds = sphere_around(&positions);
        let pieces = std::iter::once(0..positions.len()).collect();
        Self { positions, pieces, bounds }
    }

    pub(crate) fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// The centre and radius of a sphere that holds it.
    pub(crate) fn bounds(&self) -> (Vec3, f32) {
        self.bounds
    }

    pub(crate) fn pieces(&self) -> impl Iterator<Item = &[Vec3]> {
        self.pieces.iter().filter_map(|piece| self.positions.get(piece.clone()))
    }
}

fn sphere_around(positions: &[Vec3]) -> (Vec3, f32) {
    let fold = |(min, max): (Vec3, Vec3), p: &Vec3| (min.min(*p), max.max(*p));
    let (min, max) = positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), fold);
    let centre = 0.5 * (min + max);
    (centre, positions.iter().map(|p| p.distance(centre)).fold(0.0, f32::max))
}
