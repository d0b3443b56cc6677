//! The gizmo of the selection, on the surface: a ring to turn it by, a knob on the ring to scale it by, and its middle to move it by. While
//! a transform is under way it shows what that does.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use glam::DVec3;

use super::transform::{Active, TransformMode, Transforming};
use super::{Tool, transform};
use crate::editor::selection::Selection;
use crate::plugin::{OnSurface, SurfaceQueries, SurfaceSpline, SurfaceView};
use crate::surface::SurfacePoint;

/// Radius of the ring along the surface, about so many logical pixels, but no larger than this share of the diagonal.
const RADIUS: f32 = 64.0;
const LARGEST: f64 = 0.2;
/// Parts are under the pointer this near, in logical pixels.
const REACH: f32 = 8.0;
/// Sides of the ring.
const SIDES: u32 = 48;
/// Beyond this factor the ring of a scaling does not grow any more.
const MOST: f64 = 4.0;

/// What of the gizmo is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GizmoPart {
    Middle,
    Ring,
    Knob,
}

impl GizmoPart {
    /// What dragging it does.
    pub(crate) fn mode(self) -> TransformMode {
        match self {
            Self::Middle => TransformMode::Move,
            Self::Ring => TransformMode::Turn,
            Self::Knob => TransformMode::Scale,
        }
    }
}

/// The gizmo as it is on the screen; none where nothing is selected that it could be for.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub(crate) struct SelectionGizmo(pub(crate) Option<Gizmo>);

/// Places are logical pixels.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Gizmo {
    pub(crate) centre: SurfacePoint,
    pub(crate) middle: Vec2,
    /// Closed; with gaps where it leaves the surface or the view.
    pub(crate) ring: Vec<Option<Vec2>>,
    pub(crate) knob: Option<Vec2>,
    /// Of the transform that is under way: the ring as it becomes, or spokes from the middle.
    pub(crate) becomes: Vec<Option<Vec2>>,
    pub(crate) spokes: Vec<Vec2>,
}

impl SelectionGizmo {
    /// What of it is near a place on the screen.
    pub(crate) fn part_at(&self, at: Vec2) -> Option<GizmoPart> {
        let gizmo = self.0.as_ref()?;
        let is_near = |place: Vec2| place.distance(at) <= REACH;
        if gizmo.knob.is_some_and(is_near) {
            return Some(GizmoPart::Knob);
        }
        if is_near(gizmo.middle) {
            return Some(GizmoPart::Middle);
        }
        let next = gizmo.ring.iter().cycle().skip(1);
        let mut sides = gizmo.ring.iter().zip(next).filter_map(|(a, b)| a.zip(*b));
        sides.any(|(a, b)| distance_to_side(at, a, b) <= REACH).then_some(GizmoPart::Ring)
    }
}

fn distance_to_side(at: Vec2, a: Vec2, b: Vec2) -> f32 {
    let side = b - a;
    let share = ((at - a).dot(side) / side.length_squared().max(f32::EPSILON)).clamp(0.0, 1.0);
    at.distance(a + share * side)
}

/// What the gizmo is made from.
#[derive(SystemParam)]
pub(crate) struct Scene<'w, 's> {
    tool: Res<'w, Tool>,
    selection: Res<'w, Selection>,
    transforming: Res<'w, Transforming>,
    splines: Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>,
    surfaces: SurfaceQueries<'w, 's>,
    cameras: Query<'w, 's, (&'static Camera, &'static GlobalTransform), With<Camera3d>>,
}

/// Puts the gizmo where the selection is.
pub(crate) fn place(scene: Scene, mut gizmo: ResMut<SelectionGizmo>) {
    let placed = SelectionGizmo(scene.gizmo());
    gizmo.set_if_neq(placed);
}

impl Scene<'_, '_> {
    fn gizmo(&self) -> Option<Gizmo> {
        let active = self.transforming.0.as_ref();
        let (model, centre) = match active {
            Some(active) => (active.model, active.centre),
            None => self.middle()?,
        };
        let view = self.surfaces.get(model)?;
        let (camera, eye) = self.cameras.iter().find(|(camera, _)| camera.is_active)?;
        let eye_view = EyeView { view, camera, eye };
        let mut gizmo = eye_view.gizmo(centre)?;
        if let Some(active) = active {
            eye_view.show(active, &mut gizmo);
        }
        Some(gizmo)
    }

    /// The middle of what is selected: of more than one anchor, or of whole curves. A single anchor is its own handle.
    fn middle(&self) -> Option<(Entity, SurfacePoint)> {
        if *self.tool != Tool::Select || self.selection.anchors().len() == 1 {
            return None;
        }
        let model = self.splines.get(self.selection.spline()?).ok()?.1.0;
        let view = self.surfaces.get(model)?;
        let whole = self.selection.anchors().is_empty();
        let splines = self.selection.splines().iter().filter_map(|entity| {
            let (spline, on) = self.splines.get(*entity).ok()?;
            (on.0 == model).then_some((*entity, spline))
        });
        let anchors = splines.flat_map(|(entity, spline)| {
            let taken = move |index: u32| whole || self.selection.has_anchor(entity, index);
            (0..).zip(spline.anchors()).filter(move |(index, _)| taken(*index)).map(|(_, anchor)| anchor.point())
        });
        Some((model, transform::middle(view.surface(), anchors)?))
    }
}

/// A surface as a camera sees it.
struct EyeView<'a> {
    view: SurfaceView<'a>,
    camera: &'a Camera,
    eye: &'a GlobalTransform,
}

impl EyeView<'_> {
    fn pixel(&self, position: Vec3) -> Option<Vec2> {
        self.camera.world_to_viewport(self.eye, position).ok()
    }

    fn gizmo(&self, centre: SurfacePoint) -> Option<Gizmo> {
        let middle = self.pixel(self.view.position(centre))?;
        let radius = self.radius(centre)?;
        let ring: Vec<_> = (0..SIDES).map(|side| self.at(centre, turn(side), radius)).collect();
        let knob = ring.first().copied().flatten();
        Some(Gizmo { centre, middle, ring, knob, becomes: Vec::new(), spokes: Vec::new() })
    }

    /// The ring's radius in local units.
    fn radius(&self, centre: SurfacePoint) -> Option<f64> {
        let at = self.view.position(centre);
        let aside = 0.01 * at.distance(self.eye.translation());
        let pixels = self.pixel(at)?.distance(self.pixel(at + *self.eye.right() * aside)?);
        let radius = f64::from(RADIUS * aside / (pixels * self.view.scale()));
        (radius > 0.0 && radius.is_finite()).then(|| radius.min(LARGEST * self.view.surface().diagonal()))
    }

    /// The place at so many radians counter-clockwise on the surface from what is to the right on the screen.
    fn at(&self, centre: SurfacePoint, angle: f64, radius: f64) -> Option<Vec2> {
        let surface = self.view.surface();
        let right = self.view.to_world().inverse().transform_vector3(*self.eye.right()).as_dvec3();
        let right = surface.tangent(&centre, right).ok()?;
        // Seen along the surface, any direction is as good.
        let right = if right.length() > 1e-6 { right } else { surface.tangent(&centre, DVec3::ONE).ok()? };
        let heading = surface.turned(&centre, &right, angle).ok()?;
        let walk = surface.walk(&centre, &heading, radius).ok()?;
        walk.stopped.is_none().then(|| self.pixel(self.view.position(walk.path.end())))?
    }

    /// What a transform does: how far it moves, turns or scales.
    fn show(&self, active: &Active, gizmo: &mut Gizmo) {
        let Some(radius) = self.radius(active.centre) else { return };
        match active.mode {
            TransformMode::Move => {
                let way = active.to.and_then(|to| self.view.surface().log(&active.centre, &to).ok());
                let walk = way.and_then(|way| self.view.surface().exp(&active.centre, &way).ok());
                let positions = walk.map(|walk| walk.path.positions(self.view.surface()));
                let to_world = self.view.to_world();
                let seen = |p: &DVec3| self.pixel(to_world.transform_point3(p.as_vec3()));
                gizmo.spokes = positions.into_iter().flatten().filter_map(|p| seen(&p)).collect();
            }
            TransformMode::Turn => {
                let angle = active.amount.to_radians();
                let ends = [self.at(active.centre, angle, radius), Some(gizmo.middle), gizmo.knob];
                gizmo.spokes = ends.into_iter().flatten().collect();
                gizmo.knob = ends[0];
            }
            TransformMode::Scale => {
                let radius = radius * active.amount.abs().min(MOST);
                let half = if active.amount < 0.0 { std::f64::consts::PI } else { 0.0 };
                gizmo.becomes = (0..SIDES).map(|side| self.at(active.centre, half + turn(side), radius)).collect();
                gizmo.knob = gizmo.becomes.first().copied().flatten();
            }
        }
    }
}

fn turn(side: u32) -> f64 {
    std::f64::consts::TAU * f64::from(side) / f64::from(SIDES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_where_they_are_drawn() {
        let ring = (0..SIDES).map(|side| Some(100.0 + 64.0 * Vec2::from_angle(turn(side) as f32))).collect::<Vec<_>>();
        let centre = SurfacePoint { face: crate::surface::FaceId(0), weights: [1.0, 0.0, 0.0] };
        let (becomes, spokes, middle) = (Vec::new(), Vec::new(), Vec2::splat(100.0));
        let gizmo = SelectionGizmo(Some(Gizmo { centre, middle, knob: ring[0], ring, becomes, spokes }));
        assert_eq!(gizmo.part_at(Vec2::new(100.0, 103.0)), Some(GizmoPart::Middle));
        assert_eq!(gizmo.part_at(Vec2::new(166.0, 103.0)), Some(GizmoPart::Knob));
        assert_eq!(gizmo.part_at(Vec2::new(100.0, 38.0)), Some(GizmoPart::Ring));
        assert_eq!(gizmo.part_at(Vec2::new(130.0, 100.0)), None);
        assert_eq!(SelectionGizmo::default().part_at(Vec2::ZERO), None);
    }
}
