//! Random numbers and random control polygons.

use bevy_surface_splines::surface::{FaceId, Surface, SurfacePoint};
use glam::DVec3;

/// SplitMix64 (Steele, Lea and Flood 2014): small, seeded, the same everywhere.
#[derive(Clone, Debug)]
pub(crate) struct SplitMix64(u64);

impl SplitMix64 {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Between 0 and 1, without 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Shuffles in place (Fisher and Yates).
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, (self.next() % (i as u64 + 1)) as usize);
        }
    }
}

/// Draws of a whole polygon before the first point's sheet is held fast.
const FREE_DRAWS: usize = 64;
/// Draws after that.
const HELD_DRAWS: usize = 16;
/// Rays sent for one point.
const RAYS: usize = 256;

/// From where the rays come, in the order tried.
const VIEWS: [DVec3; 6] = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y];

/// Four points of one sheet seen from one side (Mancinelli, Nazzaro, Pellacini and Puppo, "b/Surf", sec. 6.1): parallel rays
/// along −z through random places of the bounding rectangle, the first hit each, drawn again until all four lie on one
/// sheet. Where that never happens, from the other sides; where no side shows enough (thin things askew in their bounding
/// box), random places of random faces of one sheet. None if a surface has no face at all.
///
/// Polygons of many small sheets are rare to hit: after some draws the sheet of the first point is held and only the
/// others are drawn again.
pub(crate) fn polygon(surface: &Surface, random: &mut SplitMix64) -> Option<[SurfacePoint; 4]> {
    VIEWS
        .into_iter()
        .find_map(|view| polygon_from(surface, random, view))
        .or_else(|| polygon_of_random_faces(surface, random))
}

/// Draws of a face before a polygon is given up.
const FACE_DRAWS: usize = 100_000;

fn polygon_of_random_faces(surface: &Surface, random: &mut SplitMix64) -> Option<[SurfacePoint; 4]> {
    let mut points: Vec<SurfacePoint> = Vec::new();
    for _ in 0..FACE_DRAWS {
        let face = FaceId((random.next() % surface.face_count().max(1) as u64) as u32);
        let (a, b) = (random.unit(), random.unit());
        let (u, v) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
        let Ok(point) = surface.point(face, [1.0 - u - v, u, v]) else { continue };
        if points.first().is_none_or(|first| surface.sheet(first.face) == surface.sheet(face)) {
            points.push(point);
        }
        if let Ok(polygon) = <[SurfacePoint; 4]>::try_from(points.as_slice()) {
            return Some(polygon);
        }
    }
    None
}

fn polygon_from(surface: &Surface, random: &mut SplitMix64, view: DVec3) -> Option<[SurfacePoint; 4]> {
    for draw in 0..FREE_DRAWS + HELD_DRAWS {
        let first = hit(surface, random, view, None)?;
        let sheet = surface.sheet(first.face).ok()?;
        let held = (draw >= FREE_DRAWS).then_some(sheet);
        let mut points = [first; 4];
        let mut complete = true;
        for point in &mut points[1..] {
            match hit(surface, random, view, held) {
                Some(p) if surface.sheet(p.face) == Ok(sheet) => *point = p,
                _ => {
                    complete = false;
                    break;
                }
            }
        }
        if complete {
            return Some(points);
        }
    }
    None
}

/// The first hit of a random ray, on the given sheet if one is given.
fn hit(surface: &Surface, random: &mut SplitMix64, view: DVec3, sheet: Option<u32>) -> Option<SurfacePoint> {
    let (min, max) = surface.bounds();
    let size = max - min;
    for _ in 0..RAYS {
        let share = DVec3::new(random.unit(), random.unit(), random.unit());
        let through = min + size * share;
        // Start outside the box, on the plane that the view looks from.
        let origin = DVec3::select(view.cmpeq(DVec3::ZERO), through, (min + max) / 2.0 + view * surface.diagonal());
        let found = surface.ray(origin, -view).map(|h| h.point);
        if let Some(point) = found
            && sheet.is_none_or(|s| surface.sheet(point.face) == Ok(s))
        {
            return Some(point);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_surface_splines::surface::{SurfaceOptions, shapes};

    #[test]
    fn splitmix_gives_its_published_numbers() {
        let mut random = SplitMix64::new(1_234_567);
        let expected = [6_457_827_717_110_365_317_u64, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!([random.next(), random.next(), random.next()], expected);
    }

    #[test]
    fn shuffling_keeps_all() {
        let mut items: Vec<u32> = (0..100).collect();
        SplitMix64::new(3).shuffle(&mut items);
        assert_ne!(items[..10], [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
        items.sort_unstable();
        assert!(items.into_iter().eq(0..100));
    }

    #[test]
    fn a_thin_rod_askew_still_gets_polygons() {
        let mut rod = shapes::cylinder(5, 3, 1.0);
        let askew = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.7, 0.6, 0.5);
        rod.positions.iter_mut().for_each(|p| *p = askew * (*p * DVec3::new(1e-6, 1e-6, 1.0)));
        let surface = Surface::build(&rod, &SurfaceOptions::default()).unwrap();
        assert!(polygon(&surface, &mut SplitMix64::new(9)).is_some());
    }

    #[test]
    fn polygons_lie_on_the_side_that_is_seen() {
        let surface = Surface::build(&shapes::icosphere(2), &SurfaceOptions::default()).unwrap();
        let mut random = SplitMix64::new(5);
        for _ in 0..20 {
            let polygon = polygon(&surface, &mut random).unwrap();
            assert!(polygon.iter().all(|p| surface.position(p).z > -0.2));
        }
    }
}
