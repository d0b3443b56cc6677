//! Splines put together from anchors whose handles are known by direction and length.

use std::f64::consts::PI;

use super::{Anchor, Join, JumpPolicy, Scheme, Spline, handles};
use crate::geodesic::{
    inner::InnerPath,
    tangent::{InnerTangent, turn_at},
};
use crate::surface::{InnerPoint, PointError, Surface};

/// An anchor to be made: tangent vectors to its handles, zero where there is none.
pub(crate) struct AnchorPlan {
    pub(crate) at: InnerPoint,
    pub(crate) join: Join,
    pub(crate) incoming: InnerTangent,
    pub(crate) outgoing: InnerTangent,
}

impl AnchorPlan {
    /// The anchor, with handles walked straight ahead; at smooth joins the incoming one lies opposite to the outgoing one, whatever
    /// its direction says. `spare` is overwritten.
    pub(crate) fn anchor(&self, surface: &Surface, spare: &mut InnerPath) -> Result<Anchor, PointError> {
        let mut anchor = handles::bare_anchor(surface, surface.outer_point(&self.at))?;
        anchor.join = self.join;
        let (reach_in, reach_out) = (self.incoming.vector.length(), self.outgoing.vector.length());
        let incoming = match self.join {
            Join::Smooth | Join::Mirrored => turn_at(surface, &self.at, &self.outgoing, PI),
            Join::Corner | Join::Automatic => self.incoming,
        };
        let point = anchor.point;
        if reach_in > 0.0 {
            handles::set_ahead(surface, spare, &point, &incoming, reach_in, &mut anchor.incoming)?;
        }
        if reach_out > 0.0 {
            handles::set_ahead(surface, spare, &point, &self.outgoing, reach_out, &mut anchor.outgoing)?;
        }
        Ok(anchor)
    }
}

impl Spline {
    /// The spline of some anchors, which must lie on one sheet: at least two, of a closed one at least one.
    pub(crate) fn of_anchors(anchors: Vec<Anchor>, closed: bool, scheme: Scheme) -> Self {
        Self { anchors, closed, scheme, jumps: JumpPolicy::default() }
    }
}
