//! Polygons about drawings.

use glam::{DAffine2, DVec2};

use super::WeightsError;
use crate::skin::Chain;
use crate::skin::bound::point;
use crate::skin::quadrature::bernstein;

/// Corners that a cage may have: all its edges are compared with one another.
const MOST: usize = 4096;

/// A polygon without crossings, about what is to move: its corners are handles, or it is the outline of what handles inside move.
///
/// It may wind either way; corners keep their order. What lies outside moves like the nearest place of the polygon:
/// [`holds`](Self::holds) says whether something does.
#[derive(Clone, Debug, PartialEq)]
pub struct Cage {
    corners: Vec<DVec2>,
}

impl Cage {
    /// A polygon of its corners. Costs the square of their number.
    ///
    /// # Errors
    /// [`WeightsError::Corners`], [`WeightsError::NotFinite`], [`WeightsError::CrossesItself`].
    pub fn new(corners: &[DVec2]) -> Result<Self, WeightsError> {
        let n = corners.len();
        if !(3..=MOST).contains(&n) {
            return Err(WeightsError::Corners { found: n, most: MOST });
        }
        if let Some(point) = corners.iter().position(|corner| !corner.is_finite()) {
            return Err(WeightsError::NotFinite { point });
        }
        let cage = Self { corners: corners.to_vec() };
        let near = 1e-9 * cage.extent();
        for i in 0..n {
            let [a, b] = cage.edge(i);
            for j in i + 1..n {
                let [c, d] = cage.edge(j);
                // Neighbours share a corner; they touch beyond it if one turns back along the other.
                let touches = if j == i + 1 {
                    on_edge(d, a, b, near) || on_edge(a, c, d, near)
                } else if i == 0 && j == n - 1 {
                    on_edge(c, a, b, near) || on_edge(b, c, d, near)
                } else {
                    cross(a, b, c, d)
                        || [(c, a, b), (d, a, b), (a, c, d), (b, c, d)]
                            .iter()
                            .any(|(p, e, f)| on_edge(*p, *e, *f, near))
                };
                if touches {
                    return Err(WeightsError::CrossesItself { edges: [i, j] });
                }
            }
        }
        Ok(cage)
    }

    /// A rectangle about two opposite corners, wider on each side by a share of its diagonal.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn around(low: DVec2, high: DVec2, margin: f64) -> Result<Self, WeightsError> {
        let wider = DVec2::splat(margin * low.distance(high));
        let (low, high) = (low.min(high) - wider, low.max(high) + wider);
        Self::new(&[low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)])
    }

    /// The corners.
    pub fn corners(&self) -> &[DVec2] {
        &self.corners
    }

    /// Whether a place is inside.
    pub fn contains(&self, place: DVec2) -> bool {
        let mut inside = false;
        for i in 0..self.corners.len() {
            let [a, b] = self.edge(i);
            if (a.y > place.y) != (b.y > place.y) && place.x < a.x + (place.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                inside = !inside;
            }
        }
        inside
    }

    /// Whether chains lie inside, looked at in sixteen places of each segment; by a millionth of the cage they may leave it.
    ///
    /// # Errors
    /// [`WeightsError::Leaves`] names the segment that leaves it most.
    pub fn holds(&self, chains: &[Chain]) -> Result<(), WeightsError> {
        let mut worst = None;
        let mut most = 1e-6 * self.extent();
        for (chain, of_chain) in chains.iter().enumerate() {
            for segment in 0..of_chain.segment_count() {
                let control = of_chain.segment(segment);
                for i in 0..16 {
                    let place = point(&control, &bernstein(f64::from(i) / 15.0)).truncate();
                    let distance = if self.contains(place) { 0.0 } else { self.nearest(place).2 };
                    if distance > most {
                        most = distance;
                        worst = Some(WeightsError::Leaves { chain, segment, distance });
                    }
                }
            }
        }
        worst.map_or(Ok(()), Err)
    }

    /// The pose in which corners move to other places.
    ///
    /// # Errors
    /// [`WeightsError::Length`].
    pub fn pose(&self, moved: &[DVec2]) -> Result<Vec<DAffine2>, WeightsError> {
        if moved.len() != self.corners.len() {
            return Err(WeightsError::Length { found: moved.len(), expected: self.corners.len() });
        }
        Ok(moved.iter().zip(&self.corners).map(|(to, from)| DAffine2::from_translation(*to - *from)).collect())
    }

    /// The distance between opposite corners of its bounds.
    pub(crate) fn extent(&self) -> f64 {
        let low = self.corners.iter().copied().fold(DVec2::MAX, DVec2::min);
        let high = self.corners.iter().copied().fold(DVec2::MIN, DVec2::max);
        low.distance(high)
    }

    /// The nearest edge, by its first corner, the share along it, and the distance.
    pub(crate) fn nearest(&self, place: DVec2) -> (usize, f64, f64) {
        let of_edge = |i: usize| {
            let [a, b] = self.edge(i);
            let t = share(place, a, b);
            (i, t, place.distance(a.lerp(b, t)))
        };
        (0..self.corners.len()).map(of_edge).min_by(|a, b| a.2.total_cmp(&b.2)).unwrap_or((0, 0.0, 0.0))
    }

    fn edge(&self, i: usize) -> [DVec2; 2] {
        [self.corners[i], self.corners[(i + 1) % self.corners.len()]]
    }
}

/// The share along an edge of the place nearest to a point.
fn share(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let squared = (b - a).length_squared();
    if squared > 0.0 { ((p - a).dot(b - a) / squared).clamp(0.0, 1.0) } else { 0.0 }
}

fn on_edge(p: DVec2, a: DVec2, b: DVec2, near: f64) -> bool {
    p.distance(a.lerp(b, share(p, a, b))) <= near
}

fn cross(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p) > 0.0;
    side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_that_cross_or_touch_themselves_are_refused() {
        let cage = |corners: &[(f64, f64)]| Cage::new(&corners.iter().copied().map(DVec2::from).collect::<Vec<_>>());
        let crossing = cage(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]);
        assert_eq!(crossing, Err(WeightsError::CrossesItself { edges: [0, 2] }));
        for bad in [
            &[(0.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 1.0)][..],
            &[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 0.0), (0.0, 2.0)],
            &[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)],
            &[(0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (1.0, 1.0)],
        ] {
            assert!(matches!(cage(bad), Err(WeightsError::CrossesItself { .. })), "{bad:?}");
        }
        assert_eq!(cage(&[(0.0, 0.0), (1.0, 0.0)]), Err(WeightsError::Corners { found: 2, most: MOST }));
        assert_eq!(cage(&[(0.0, 0.0), (f64::NAN, 0.0), (1.0, 1.0)]), Err(WeightsError::NotFinite { point: 1 }));
        // Either way round.
        assert!(
            cage(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]).is_ok() && cage(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0)]).is_ok()
        );
    }
}
