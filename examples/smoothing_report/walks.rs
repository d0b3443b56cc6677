//! Jagged lines: walks from face to face that do not turn back at once.

use std::collections::HashMap;

use bevy_surface_splines::{
    geodesic::{Crossing, PathFinder},
    smooth::SurfacePolyline,
    surface::{FaceId, Surface, SurfacePoint},
};

/// Faces that a walk passes.
const STEPS: usize = 200;

/// Lines over random faces, every third one closed by the shortest path home.
pub(crate) fn lines(surface: &Surface, count: usize, seed: u64) -> Vec<SurfacePolyline> {
    let across = across(surface);
    let (mut random, mut finder) = (Random(seed), PathFinder::new());
    let walks = (0..count).filter_map(|number| {
        let open = walk(surface, &across, &mut random)?;
        if number % 3 == 2 { open.closed_home(surface, &mut finder).ok() } else { Some(open) }
    });
    walks.collect()
}

/// Which side of which face lies behind each side.
fn across(surface: &Surface) -> HashMap<(u32, u8), (u32, u8)> {
    let (mut seen, mut across) = (HashMap::new(), HashMap::new());
    for face in 0..surface.face_count() as u32 {
        let Ok(vertices) = surface.vertices(FaceId(face)) else { continue };
        for side in 0..3_u8 {
            let [a, b] = [vertices[usize::from(side)].0, vertices[usize::from(side + 1) % 3].0];
            if let Some(other) = seen.insert((a.min(b), a.max(b)), (face, side)) {
                across.insert((face, side), other);
                across.insert(other, (face, side));
            }
        }
    }
    across
}

fn walk(surface: &Surface, across: &HashMap<(u32, u8), (u32, u8)>, random: &mut Random) -> Option<SurfacePolyline> {
    let first = random.below(surface.face_count() as u64) as u32;
    let (mut face, mut entered, mut crossings) = (first, None, Vec::new());
    for _ in 0..STEPS {
        let mut ways: Vec<u8> = (0..3).filter(|side| Some(*side) != entered).collect();
        ways.retain(|side| across.contains_key(&(face, *side)));
        let Some(side) = ways.get(random.below(ways.len().max(1) as u64) as usize).copied() else { break };
        let at = 0.1 + 0.8 * random.unit();
        crossings.push(Crossing { face: FaceId(face), side, at });
        let (next, there) = across.get(&(face, side)).copied()?;
        (face, entered) = (next, Some(there));
    }
    let middle = |face: u32| SurfacePoint { face: FaceId(face), weights: [1.0 / 3.0; 3] };
    SurfacePolyline::open(surface, middle(first), crossings, middle(face)).ok()
}

/// Numbers that are the same everywhere (SplitMix64; Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn below(&mut self, end: u64) -> u64 {
        self.word() % end.max(1)
    }

    fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 53) as f64
    }
}
