//! What keys, or whoever else, ask of handles that are dragged.

use bevy::prelude::*;

use crate::curve::{Spline, SplineEdit};
use crate::geodesic::Tangent;
use crate::surface::{Surface, SurfacePoint};

use super::controls::ControlKind;

/// How a handle that is dragged is bound, from the next move of the pointer on.
///
/// Nothing writes it but the editor and the game: bind keys as you like.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct DragModifiers {
    /// It moves by itself: the join becomes a corner.
    pub free: bool,
    /// It turns in steps of this angle, in radians, from where it pointed when it was grabbed.
    pub snap: Option<f64>,
    /// It keeps its direction.
    pub keep_direction: bool,
}

impl DragModifiers {
    /// Where a handle goes that is dragged to a place; a handle without a direction goes anywhere.
    pub(super) fn bound(
        &self,
        surface: &Surface,
        spline: &Spline,
        kind: ControlKind,
        to: SurfacePoint,
    ) -> SurfacePoint {
        let ControlKind::Handle(anchor, side) = kind else { return to };
        if !self.keep_direction && self.snap.is_none() {
            return to;
        }
        let bound = || {
            let anchor = spline.anchors().get(anchor as usize)?;
            let at = anchor.point();
            let heading = anchor.handle(side).heading();
            if heading.length() <= 0.0 {
                return None;
            }
            let wanted = surface.log(&at, &to).ok()?;
            let step = self.snap.filter(|step| !self.keep_direction && step.is_finite() && *step > 1e-3);
            let (heading, share) = nearest_heading(surface, &at, &heading, &wanted, step)?;
            let length = (wanted.length() * share).max(0.0);
            Some(surface.walk(&at, &heading, length).ok()?.path.end())
        };
        bound().unwrap_or(to)
    }

    /// The edit that moves a control point so.
    pub(super) fn edit(&self, kind: ControlKind, to: SurfacePoint) -> SplineEdit {
        match kind {
            ControlKind::Handle(anchor, side) if self.free => SplineEdit::FreeHandle { anchor, side, to },
            _ => kind.moved(to),
        }
    }
}

/// The heading, turned by whole steps or not at all, that comes nearest to the wanted one; and the share of the wanted way
/// that lies along it: all if it may turn, the projection if not.
fn nearest_heading(
    surface: &Surface,
    at: &SurfacePoint,
    heading: &Tangent,
    wanted: &Tangent,
    step: Option<f64>,
) -> Option<(Tangent, f64)> {
    let in_space = |tangent: &Tangent| surface.tangent_in_space(tangent).ok().map(|way| way.normalize_or_zero());
    let goal = in_space(wanted)?;
    let Some(step) = step else {
        return Some((*heading, in_space(heading)?.dot(goal)));
    };
    let turns = (std::f64::consts::TAU / step).ceil().min(720.0) as u32;
    let turned = (0..turns).filter_map(|i| surface.turned(at, heading, f64::from(i) * step).ok());
    let cosines = turned.filter_map(|heading| Some((heading, in_space(&heading)?.dot(goal))));
    cosines.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(heading, _)| (heading, 1.0))
}
