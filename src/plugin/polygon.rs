//! The control polygons of B-splines, where no handles show how anchors and curve belong together.

use std::sync::{Arc, Weak};

use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::controls::Editable;
use super::spline::SurfaceSpline;
use super::surface::{BuiltSurface, OnSurface};
use crate::curve::Spline;
use crate::geodesic::PathFinder;
use crate::surface::{Surface, SurfacePoint};

/// The control polygon of an [`Editable`] B-spline: the geodesics between consecutive anchors, back to the first if it is
/// closed. Derived: a system writes it whenever spline or surface change, and it is never saved.
#[derive(Component, Clone, Debug)]
#[component(immutable)]
pub struct ControlPolygon {
    legs: Vec<Leg>,
    surface: Weak<Surface>,
}

#[derive(Clone, Debug)]
struct Leg {
    ends: [SurfacePoint; 2],
    line: Arc<[Vec3]>,
}

impl ControlPolygon {
    /// The legs in order, as positions in the surface's local space; empty where no path joins two anchors.
    pub fn legs(&self) -> impl Iterator<Item = &[Vec3]> {
        self.legs.iter().map(|leg| &*leg.line)
    }
}

/// Keeps the control polygons of editable B-splines.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Controls`].
#[derive(Debug, Default)]
pub struct PolygonPlugin;

impl Plugin for PolygonPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.add_observer(remove_polygon::<Editable>)
            .add_observer(remove_polygon::<SurfaceSpline>)
            .add_systems(PostUpdate, update_polygons.in_set(SurfaceSplineSystems::Controls));
    }
}

type Splines<'w, 's> = Query<
    'w,
    's,
    (Entity, Ref<'static, SurfaceSpline>, Ref<'static, OnSurface>, Option<&'static ControlPolygon>),
    With<Editable>,
>;

fn update_polygons(
    mut commands: Commands,
    mut finder: Local<PathFinder>,
    splines: Splines,
    surfaces: Query<Ref<BuiltSurface>>,
) {
    for (entity, spline, on, old) in &splines {
        let built = surfaces.get(on.0).ok().filter(|_| spline.scheme().method.is_b_spline());
        let Some(built) = built else {
            if old.is_some() {
                commands.entity(entity).try_remove::<ControlPolygon>();
            }
            continue;
        };
        let old = old.filter(|old| std::ptr::eq(old.surface.as_ptr(), Arc::as_ptr(&built.0)));
        if old.is_none() || spline.is_changed() || on.is_changed() || built.is_changed() {
            let known = old.map_or(&[][..], |old| &old.legs);
            let legs = ends(&spline).map(|ends| leg(&built, &mut finder, ends, known)).collect();
            commands.entity(entity).try_insert(ControlPolygon { legs, surface: Arc::downgrade(&built.0) });
        }
    }
}

/// The ends of a control polygon's legs.
fn ends(spline: &Spline) -> impl Iterator<Item = [SurfacePoint; 2]> {
    let anchors = spline.anchors();
    let count = if spline.is_closed() { anchors.len() } else { anchors.len().saturating_sub(1) };
    (0..count).map(move |i| [anchors[i].point(), anchors[(i + 1) % anchors.len()].point()])
}

/// A leg; one that is known is not searched again.
fn leg(surface: &Surface, finder: &mut PathFinder, ends: [SurfacePoint; 2], known: &[Leg]) -> Leg {
    if let Some(same) = known.iter().find(|leg| leg.ends == ends) {
        return same.clone();
    }
    let path = finder.shortest(surface, &ends[0], &ends[1]);
    let positions = path.map(|path| path.positions(surface)).unwrap_or_default();
    Leg { ends, line: positions.iter().map(|p| p.as_vec3()).collect() }
}

/// A spline that is no longer edited shows no polygon.
fn remove_polygon<C: Component>(removed: On<Remove, C>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<ControlPolygon>();
    }
}
