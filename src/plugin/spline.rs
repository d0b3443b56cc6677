//! Splines as components: where one comes from, the spline itself, its state.

use bevy::log::warn;
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::remap::remap_splines;
use super::surface::{BuiltSurface, OnSurface, SurfaceState};
use crate::curve::{Interpolation, Method, Scheme, Spline, SplineError};
use crate::geodesic::PathFinder;
use crate::surface::{Surface, SurfacePoint};

/// A spline on the surface that [`OnSurface`] names.
///
/// Immutable: it changes by [`EditSpline`](super::EditSpline) alone (or is replaced by inserting another).
#[derive(Component, Reflect, Clone, Debug, PartialEq, Deref)]
#[component(immutable)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(SplineState)]
pub struct SurfaceSpline(Spline);

impl SurfaceSpline {
    /// Makes the component.
    pub fn new(spline: Spline) -> Self {
        Self(spline)
    }
}

impl From<Spline> for SurfaceSpline {
    fn from(spline: Spline) -> Self {
        Self(spline)
    }
}

/// How far a spline is.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub enum SplineState {
    /// Its surface is not ready, or it is on none.
    #[default]
    Pending,
    /// It has a trace, of the spline as it is.
    Ready,
    /// Its trace is computed in the background, because that takes longer than a frame has. Until it is there, an earlier one
    /// may be, and a [`TracePreview`](super::TracePreview).
    Tracing,
    /// It cannot be made or traced.
    Failed {
        /// Why, and what to do about it.
        reason: String,
    },
}

/// What a spline is to be made from; becomes a [`SurfaceSpline`] once the surface is ready.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(SplineState)]
pub struct SplineSource {
    points: SourcePoints,
    closed: bool,
    scheme: Scheme,
}

#[derive(Reflect, Clone, Debug, PartialEq)]
enum SourcePoints {
    Through(Vec<Vec3>),
    Bezier([SurfacePoint; 4]),
    Controls(Vec<Vec3>),
}

impl SplineSource {
    /// A smooth spline through the surface points nearest to positions in the surface's local space.
    ///
    /// With [`Scheme::b_spline`] it is C² where that can be found ([`Spline::c2_through`]), else C¹ as without.
    pub fn smooth_through(positions: impl IntoIterator<Item = Vec3>) -> Self {
        let points = SourcePoints::Through(positions.into_iter().collect());
        Self { points, closed: false, scheme: Scheme::default() }
    }

    /// One cubic segment: anchor, handle, handle, anchor.
    pub fn bezier(polygon: [SurfacePoint; 4]) -> Self {
        Self { points: SourcePoints::Bezier(polygon), closed: false, scheme: Scheme::default() }
    }

    /// A B-spline, whose control points are the surface points nearest to positions in the surface's local space; at least
    /// four, closed or quadratic three.
    ///
    /// It passes near them, and is smoother than a spline that passes through: C². [`scheme`](Self::scheme) makes it a
    /// quadratic one.
    pub fn control_points(positions: impl IntoIterator<Item = Vec3>) -> Self {
        let points = SourcePoints::Controls(positions.into_iter().collect());
        Self { points, closed: false, scheme: Scheme::b_spline() }
    }

    /// Joins the last anchor to the first; a single Bézier segment stays open.
    pub fn closed(mut self) -> Self {
        self.closed = true;
        self
    }

    /// Chooses how the curve is traced.
    pub fn scheme(mut self, scheme: Scheme) -> Self {
        self.scheme = scheme;
        self
    }

    /// Makes the spline.
    fn resolve(&self, surface: &Surface, finder: &mut PathFinder) -> Result<Spline, String> {
        let spline = match &self.points {
            SourcePoints::Bezier(polygon) => Spline::bezier(surface, finder, *polygon),
            SourcePoints::Through(positions) => {
                let points = nearest_points(surface, positions)?;
                require_two_distinct(positions)?;
                if self.scheme.method == Method::BSpline {
                    let found = Spline::c2_through(surface, finder, &points, self.closed);
                    let Interpolation { spline, .. } = found.map_err(|error| error.to_string())?;
                    let method = spline.scheme().method;
                    return Ok(spline.with_scheme(Scheme { method, ..self.scheme }));
                }
                Spline::smooth_through(surface, finder, &points, self.closed)
            }
            SourcePoints::Controls(positions) => {
                let points = nearest_points(surface, positions)?;
                if self.scheme.method == Method::QuadraticBSpline {
                    Spline::quadratic_b_spline(surface, &points, self.closed)
                } else {
                    Spline::b_spline(surface, &points, self.closed)
                }
            }
        };
        Ok(spline.map_err(|error| error.to_string())?.with_scheme(self.scheme))
    }
}

/// The surface points nearest to positions.
pub(crate) fn nearest_points(surface: &Surface, positions: &[Vec3]) -> Result<Vec<SurfacePoint>, String> {
    if let Some(bad) = positions.iter().position(|p| !p.is_finite()) {
        let value = positions[bad];
        return Err(format!("position {bad} is {value}: give finite positions in the surface's local space"));
    }
    let nearest = |p: &Vec3| surface.closest_point(p.as_dvec3()).map(|c| c.point);
    let found: Option<Vec<SurfacePoint>> = positions.iter().map(nearest).collect();
    found.ok_or_else(|| "the surface has no points".to_string())
}

/// Refuses positions that are all the same.
fn require_two_distinct(positions: &[Vec3]) -> Result<(), String> {
    let distinct = usize::from(!positions.is_empty());
    let same = positions.iter().all(|p| *p == positions[0]);
    if same { Err(SplineError::TooFewPoints { distinct }.to_string()) } else { Ok(()) }
}

/// Turns [`SplineSource`]s into [`SurfaceSpline`]s, and maps splines when their surface changes.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Resolve`]; an observer of [`SurfaceChanged`](super::SurfaceChanged).
#[derive(Debug, Default)]
pub struct SplinePlugin;

impl Plugin for SplinePlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_type::<SurfaceSpline>()
            .register_type::<SplineSource>()
            .register_type::<SplineState>()
            .add_observer(remap_splines)
            .add_systems(PostUpdate, resolve_sources.in_set(SurfaceSplineSystems::Resolve));
    }
}

/// The surfaces that splines lie on.
type Surfaces<'w, 's> = Query<'w, 's, (Option<Ref<'static, BuiltSurface>>, Option<Ref<'static, SurfaceState>>)>;

fn resolve_sources(
    mut commands: Commands,
    mut finder: Local<PathFinder>,
    mut sources: Query<(Entity, Ref<SplineSource>, Ref<OnSurface>, &mut SplineState)>,
    surfaces: Surfaces,
) {
    for (entity, source, on, mut state) in &mut sources {
        let Ok((built, surface_state)) = surfaces.get(on.0) else { continue };
        let asked = source.is_changed() || on.is_changed();
        let Some(built) = built else {
            state.set_if_neq(without_surface(surface_state.as_deref()));
            continue;
        };
        if matches!(*state, SplineState::Failed { .. }) && !asked && !built.is_changed() {
            continue;
        }
        match source.resolve(&built, &mut finder) {
            Ok(spline) => {
                commands.entity(entity).try_insert(SurfaceSpline(spline)).try_remove::<SplineSource>();
            }
            Err(reason) => {
                warn!("the spline {entity} cannot be made: {reason}");
                state.set_if_neq(SplineState::Failed { reason });
            }
        }
    }
}

/// The state of a spline whose surface is not there.
pub(crate) fn without_surface(surface: Option<&SurfaceState>) -> SplineState {
    match surface {
        Some(SurfaceState::Failed { reason }) => {
            SplineState::Failed { reason: format!("its surface cannot be used: {reason}") }
        }
        _ => SplineState::Pending,
    }
}
