//! What a ray hits.

use glam::DVec3;

use super::closest::closest_to_origin;
use super::{Bounds, Bvh, Frame, corners};

/// A triangle whose doubled area across the ray is less than this times the square of its size there is a line but for
/// rounding: the quotients of its determinants are noise, and the place closest to the ray is taken instead.
const NEARLY_EDGE_ON: f64 = 1e-4;

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayTriangleHit {
    /// Index of the triangle.
    pub(crate) face: u32,
    /// Barycentric weights of its corners: none negative, sum one, exactly zero for a hit on a side.
    pub(crate) weights: [f64; 3],
    /// Distance from the ray's origin, in the positions' unit.
    pub(crate) distance: f64,
}

impl Bvh {
    /// The first hit of a ray, from either side of a face, at a distance of at most `max_distance`.
    ///
    /// `direction` may have any length. Of hits at one distance, the smaller face is taken. A ray through a side or
    /// corner that faces share hits at least one of them; a face seen exactly edge-on is not hit. `None` also for a ray
    /// that is not finite, has no direction, or starts further away than 1e150 times the size of the mesh. About 1 µs
    /// for rays close to each other and 3 µs for random ones, at 1.3 M faces.
    pub(crate) fn ray(
        &self,
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        origin: DVec3,
        direction: DVec3,
        max_distance: f64,
    ) -> Option<RayTriangleHit> {
        let ray = Ray::new(&self.frame, origin, direction)?;
        let limit = self.frame.limit(max_distance)?;
        let mut nearest: Option<RayTriangleHit> = None;
        self.walk(
            limit,
            |bounds| ray.entry(bounds),
            |face, limit| match corners(positions, triangles, face).and_then(|corners| ray.hit(corners)) {
                Some((weights, distance)) if distance <= limit => {
                    let tie = |hit: &RayTriangleHit| distance == hit.distance && hit.face < face;
                    if !nearest.as_ref().is_some_and(tie) {
                        nearest = Some(RayTriangleHit { face, weights, distance });
                    }
                    distance
                }
                _ => limit,
            },
        );
        nearest.map(|hit| RayTriangleHit { distance: hit.distance / self.frame.scale, ..hit })
    }

    /// Shows `visit` every hit of a ray, as [`Bvh::ray`] understands hits, in no order.
    ///
    /// A ray through a side or corner may hit each of the faces there.
    pub(crate) fn ray_all(
        &self,
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        origin: DVec3,
        direction: DVec3,
        max_distance: f64,
        visit: &mut dyn FnMut(RayTriangleHit),
    ) {
        let Some(ray) = Ray::new(&self.frame, origin, direction) else { return };
        let Some(limit) = self.frame.limit(max_distance) else { return };
        self.walk(
            limit,
            |bounds| ray.entry(bounds),
            |face, limit| {
                let hit = corners(positions, triangles, face).and_then(|corners| ray.hit(corners));
                if let Some((weights, distance)) = hit.filter(|(_, distance)| *distance <= limit) {
                    visit(RayTriangleHit { face, weights, distance: distance / self.frame.scale });
                }
                limit
            },
        );
    }
}

/// A ray made ready for boxes and triangles.
///
/// Triangles: Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013). Corners are sheared so that the
/// ray becomes the z axis. What a corner becomes depends on it and the ray alone, and the signs of the sides'
/// determinants are exact from there on, so that neighbours always agree on which side of their common side the ray
/// passes.
struct Ray {
    origin: DVec3,
    scale: f64,
    /// The direction's largest coordinate, which becomes z; the others follow in cyclic order.
    axis: usize,
    /// What z adds to x and y, and 1 / z of the unit direction.
    shear: DVec3,
    /// 1 / direction, kept finite.
    inverse: DVec3,
    /// The origin in the frame, moved by the pad away from the boxes' minima and maxima.
    from_min: DVec3,
    from_max: DVec3,
}

impl Ray {
    fn new(frame: &Frame, origin: DVec3, direction: DVec3) -> Option<Self> {
        let at = frame.place(origin)?;
        let pad = DVec3::splat(frame.pad(at));
        // By the largest coordinate first: the square of a tiny or huge direction leaves the range of f64.
        let direction = (direction / direction.abs().max_element()).normalize();
        if !direction.is_finite() {
            return None;
        }
        let axis = direction.abs().max_position();
        let turned = to_z(direction, axis);
        Some(Self {
            origin,
            scale: frame.scale,
            axis,
            shear: DVec3::new(turned.x / turned.z, turned.y / turned.z, 1.0 / turned.z),
            // 0 · ∞ would be NaN; 0 · 1e300 is 0.
            inverse: direction.map(|d| 1.0 / d.abs().max(1e-300).copysign(d)),
            from_min: at + pad,
            from_max: at - pad,
        })
    }

    /// Where the ray enters a box, or NaN if it misses.
    #[inline]
    fn entry(&self, bounds: &Bounds) -> f64 {
        let to_min = (bounds.min.as_dvec3() - self.from_min) * self.inverse;
        let to_max = (bounds.max.as_dvec3() - self.from_max) * self.inverse;
        let (enter, leave) = (to_min.min(to_max).max_element().max(0.0), to_min.max(to_max).min_element());
        if enter <= leave { enter } else { f64::NAN }
    }

    /// Weights and distance (in the frame's unit) of the hit with a triangle.
    #[inline]
    fn hit(&self, corners: [DVec3; 3]) -> Option<([f64; 3], f64)> {
        let [a, b, c] = corners.map(|p| {
            let p = to_z((p - self.origin) * self.scale, self.axis);
            DVec3::new(p.x - self.shear.x * p.z, p.y - self.shear.y * p.z, self.shear.z * p.z)
        });
        let u = determinant(c.x, c.y, b.x, b.y);
        let v = determinant(a.x, a.y, c.x, c.y);
        let w = determinant(b.x, b.y, a.x, a.y);
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 || !sum.is_finite() {
            return None; // edge-on, or without area
        }
        let largest = [a, b, c].map(|p| p.x * p.x + p.y * p.y).into_iter().fold(0.0, f64::max);
        let weights = if sum.abs() > NEARLY_EDGE_ON * largest {
            [u / sum, v / sum, w / sum]
        } else {
            closest_to_origin([a, b, c].map(|p| p.with_z(0.0)), [0, 1, 2]).0
        };
        let distance = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
        (distance >= 0.0).then_some((weights, distance))
    }
}

/// Turns coordinates so that `axis` becomes z.
#[inline]
fn to_z(p: DVec3, axis: usize) -> DVec3 {
    match axis {
        0 => DVec3::new(p.y, p.z, p.x),
        1 => DVec3::new(p.z, p.x, p.y),
        _ => p,
    }
}

/// a·d − b·c with an exact sign (barring underflow).
#[inline]
fn determinant(a: f64, b: f64, c: f64, d: f64) -> f64 {
    // Rounding keeps order, so that the difference of the rounded products has the right sign or is zero.
    let (ad, bc) = (a * d, b * c);
    if ad == bc { a.mul_add(d, -ad) - b.mul_add(c, -bc) } else { ad - bc }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Mesh, Random, moved, soup, sphere, tree};
    use super::*;

    /// Möller & Trumbore (1997): distance along the unit direction.
    fn moller_trumbore([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
        let (ab, ac, from) = (b - a, c - a, origin - a);
        let p = direction.cross(ac);
        let q = from.cross(ab);
        let scale = ab.dot(p);
        let (v, w, t) = (from.dot(p) / scale, direction.dot(q) / scale, ac.dot(q) / scale);
        (v >= 0.0 && w >= 0.0 && v + w <= 1.0 && t >= 0.0).then_some(t)
    }

    /// Where the hit's weights say it is, against where its distance does.
    fn check_hit(mesh: &Mesh, hit: &RayTriangleHit, origin: DVec3, direction: DVec3, tolerance: f64) {
        let [a, b, c] = corners(&mesh.0, &mesh.1, hit.face).unwrap();
        let [u, v, w] = hit.weights;
        assert!(u >= 0.0 && v >= 0.0 && w >= 0.0 && (u + v + w - 1.0).abs() < 1e-15, "{hit:?}");
        let off = (a * u + b * v + c * w).distance(origin + direction.normalize() * hit.distance);
        assert!(off < tolerance, "{hit:?} is off by {off:e}");
    }

    #[test]
    fn random_rays_agree_with_all_faces() {
        let seed = 11;
        let mut random = Random(seed);
        let mesh = soup(800, &mut random);
        let bvh = tree(&mesh);
        let faces = |face: u32| corners(&mesh.0, &mesh.1, face).unwrap();
        let mut found = 0;
        for round in 0..1000 {
            let origin = random.place() * 1.5;
            let face = round % 800;
            // Faces without area are no aims: whether they are hit is noise in the check.
            let aim = if face % 7 == 0 { random.place() } else { faces(face).iter().sum::<DVec3>() / 3.0 };
            let unit = (aim - origin).normalize();
            let limit = if round % 2 == 0 { f64::INFINITY } else { 0.7 };
            let expected: Vec<(u32, f64)> = (0..800)
                .filter_map(|face| moller_trumbore(faces(face), origin, unit).map(|t| (face, t)))
                .filter(|(_, t)| *t <= limit)
                .collect();
            let first = expected.iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let hit = bvh.ray(&mesh.0, &mesh.1, origin, unit * 7.0, limit);
            assert_eq!(hit.map(|h| h.face), first.map(|f| f.0), "seed {seed}, round {round}");
            if let (Some(hit), Some(first)) = (hit, first) {
                assert!((hit.distance - first.1).abs() < 1e-11, "seed {seed}, round {round}");
                check_hit(&mesh, &hit, origin, unit, 1e-12);
                found += 1;
            }
            let mut all = Vec::new();
            bvh.ray_all(&mesh.0, &mesh.1, origin, unit, limit, &mut |hit| all.push(hit.face));
            all.sort_unstable();
            assert_eq!(all, expected.iter().map(|e| e.0).collect::<Vec<_>>(), "seed {seed}, round {round}");
        }
        assert!(found > 300, "only {found} rays hit anything");
    }

    #[test]
    fn answers_do_not_depend_on_the_tree() {
        let mut random = Random(12);
        for (scale, by, away) in [(1.0, DVec3::ZERO, 1.0), (1e-3, DVec3::splat(1e6), 1.0), (1.0, DVec3::ZERO, 1e12)] {
            let mesh = moved(&sphere(3), scale, by);
            let bvh = tree(&mesh);
            for _ in 0..300 {
                let origin = random.place() * away * scale + by;
                let direction = mesh.0[(random.number().abs() * 200.0) as usize] - origin;
                let ray = Ray::new(&bvh.frame, origin, direction).unwrap();
                let mut first: Option<(u32, f64)> = None;
                for face in 0..mesh.1.len() as u32 {
                    let hit = ray.hit(corners(&mesh.0, &mesh.1, face).unwrap());
                    if let Some((_, t)) = hit.filter(|hit| first.is_none_or(|f| hit.1 < f.1)) {
                        first = Some((face, t));
                    }
                }
                let hit = bvh.ray(&mesh.0, &mesh.1, origin, direction, f64::INFINITY);
                assert_eq!(hit.map(|h| (h.face, h.distance)), first.map(|f| (f.0, f.1 / bvh.frame.scale)));
            }
        }
    }

    /// Rays from inside a closed mesh at each corner and the middle of each side.
    fn check_watertight(mesh: &Mesh, origin: DVec3) {
        let bvh = tree(mesh);
        for &[a, b, c] in &mesh.1 {
            for (i, j) in [(a, a), (b, b), (c, c), (a, b), (b, c), (c, a)] {
                let direction = mesh.0[i as usize] * 0.5 + mesh.0[j as usize] * 0.5 - origin;
                let hit = bvh.ray(&mesh.0, &mesh.1, origin, direction, f64::INFINITY);
                let hit = hit.unwrap_or_else(|| panic!("from {origin} past {direction}"));
                assert!((hit.distance / direction.length() - 1.0).abs() < 1e-6, "{hit:?}");
            }
        }
    }

    #[test]
    fn rays_do_not_slip_between_faces() {
        let mut random = Random(13);
        let mesh = sphere(4);
        check_watertight(&mesh, DVec3::ZERO);
        for _ in 0..10 {
            check_watertight(&mesh, random.place() * 0.5);
        }
        let by = DVec3::new(1e6, -1e6, 3e6);
        let far = moved(&mesh, 1e-3, by);
        check_watertight(&far, by + random.place() * 5e-4);
        for scale in [1e50, 1e-50] {
            check_watertight(&moved(&mesh, scale, DVec3::ZERO), random.place() * 0.5 * scale);
        }
        // Needles: a sphere pressed flat until neighbours are all but in one plane, seen from within.
        let flat: Vec<DVec3> = mesh.0.iter().map(|p| *p * DVec3::new(1.0, 1e-5, 1.0)).collect();
        check_watertight(&(flat, mesh.1), DVec3::new(0.1, 1e-6, 0.2));
    }

    #[test]
    fn rays_through_a_corner_of_a_degenerate_patch_hit() {
        // A square whose diagonal carries a face without area: 1 is the middle of 0 and 2.
        let positions = [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)];
        let positions = positions.map(|(x, y)| DVec3::new(x, y, 0.1 * x - 0.3 * y));
        let triangles = [[0, 3, 2], [0, 2, 1], [0, 1, 4], [1, 2, 4]];
        let bvh = tree(&(positions.to_vec(), triangles.to_vec()));
        let mut random = Random(14);
        for _ in 0..2000 {
            let at = positions[2] * (0.5 + 0.4 * random.number());
            let origin = at + DVec3::new(random.number(), random.number(), 3.0);
            for aim in [at, positions[1]] {
                let hit = bvh.ray(&positions, &triangles, origin, aim - origin, 10.0).unwrap();
                check_hit(&(positions.to_vec(), triangles.to_vec()), &hit, origin, aim - origin, 1e-14);
            }
        }
    }

    #[test]
    fn hits_are_closed_form_on_one_face() {
        let (positions, triangles) = ([DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0], [[0, 1, 2]]);
        let bvh = tree(&(positions.to_vec(), triangles.to_vec()));
        let ray = |x, y, z, limit| {
            let hit = bvh.ray(&positions, &triangles, DVec3::new(x, y, z), DVec3::Z * -1e-200 * z, limit);
            hit.map(|hit| (hit.weights, hit.distance))
        };
        let far = f64::INFINITY;
        assert_eq!(ray(1.0, 2.0, 8.0, far), Some(([0.25, 0.25, 0.5], 8.0)));
        assert_eq!(ray(1.0, 2.0, -8.0, far), Some(([0.25, 0.25, 0.5], 8.0)));
        assert_eq!(ray(1.0, 2.0, 8.0, 8.0), Some(([0.25, 0.25, 0.5], 8.0)));
        assert_eq!(ray(1.0, 2.0, 8.0, 7.9), None);
        assert_eq!(ray(2.0, 0.0, 8.0, far), Some(([0.5, 0.5, 0.0], 8.0)));
        assert_eq!(ray(0.0, 4.0, 8.0, far), Some(([0.0, 0.0, 1.0], 8.0)));
        assert_eq!(ray(2.0, 2.1, 8.0, far), None);
        assert_eq!(ray(1.0, 1.0, 0.0, far), None); // no direction
        let edge_on = bvh.ray(&positions, &triangles, DVec3::new(-1.0, 1.0, 0.0), DVec3::X, far);
        assert_eq!(edge_on, None);
    }
}
