//! How the segments of a path meet.

use std::f64::consts::PI;

use super::VectorPath;

/// How two segments meet at an anchor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PathJoin {
    /// With a corner, or one of the handles has no length, or there is only one segment.
    Corner,
    /// With opposite handles.
    Smooth,
    /// With opposite handles of the same length.
    Mirrored,
}

/// When handles count as opposite, and as equally long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JoinTolerance {
    /// By how much handles may miss being opposite, in radians.
    pub angle: f64,
    /// By how much their lengths may differ, as a share of the longer one.
    pub length: f64,
    /// By how far a handle's end may miss the line through the other, as a share of the path's extent: what rounding of coordinates
    /// leaves of short handles.
    pub rounding: f64,
}

impl Default for JoinTolerance {
    fn default() -> Self {
        Self { angle: 1e-9, length: 1e-9, rounding: 1e-13 }
    }
}

impl VectorPath {
    /// How the segments meet at an anchor; `extent` is the path's [`extent`](Self::extent), asked for once.
    pub fn join(&self, anchor: usize, extent: f64, tolerance: &JoinTolerance) -> PathJoin {
        let [Some(incoming), Some(outgoing)] = self.handles(anchor) else { return PathJoin::Corner };
        let (short, long) = (incoming.length().min(outgoing.length()), incoming.length().max(outgoing.length()));
        // A handle that is hardly longer than rounding says nothing.
        if short <= 10.0 * tolerance.rounding * extent {
            return PathJoin::Corner;
        }
        let missing = PI - incoming.perp_dot(outgoing).atan2(incoming.dot(outgoing)).abs();
        // Rounding turns a handle by so much at most.
        let rounding = tolerance.rounding * extent / short;
        if missing > tolerance.angle.max(rounding) {
            return PathJoin::Corner;
        }
        if long - short <= (tolerance.length * long).max(tolerance.rounding * extent) {
            PathJoin::Mirrored
        } else {
            PathJoin::Smooth
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn join(incoming: DVec2, outgoing: DVec2) -> PathJoin {
        let at = DVec2::new(100.0, 50.0);
        let points = [DVec2::ZERO, DVec2::X, at + incoming, at, at + outgoing, DVec2::Y, DVec2::ONE];
        let path = VectorPath::from_points(points.to_vec(), false).unwrap();
        assert_eq!(path.join(0, path.extent(), &JoinTolerance::default()), PathJoin::Corner);
        path.join(1, path.extent(), &JoinTolerance::default())
    }

    #[test]
    fn joins_are_told_apart_at_any_length() {
        for length in [1e-6, 1e-3, 1.0, 40.0] {
            let u = DVec2::from_angle(0.3) * length;
            assert_eq!(join(-u, u), PathJoin::Mirrored, "{length}");
            assert_eq!(join(-u, 1.5 * u), PathJoin::Smooth, "{length}");
            assert_eq!(join(-u, u.rotate(DVec2::from_angle(1e-3))), PathJoin::Corner, "{length}");
            assert_eq!(join(u, 1.5 * u), PathJoin::Corner, "{length}");
            assert_eq!(join(DVec2::ZERO, u), PathJoin::Corner);
        }
    }
}
