//! Handles spread over a drawing, and poses of them.

use bevy_surface_splines::skin::{Chain, HandleShape, in_space};
use glam::{DAffine2, DAffine3, DVec2};

/// SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Point handles of a drawing.
pub(crate) struct Rig {
    pub(crate) places: Vec<DVec2>,
    /// The diagonal of the drawing.
    pub(crate) extent: f64,
}

impl Rig {
    /// Handles at anchors of the drawing, each as far from those before it as can be; the first near the middle.
    pub(crate) fn spread(chains: &[Chain], count: usize) -> Option<Self> {
        let anchors: Vec<DVec2> =
            chains.iter().flat_map(|chain| chain.points().iter().step_by(3)).map(|p| p.truncate()).collect();
        let low = anchors.iter().copied().reduce(DVec2::min)?;
        let high = anchors.iter().copied().reduce(DVec2::max)?;
        let middle = 0.5 * (low + high);
        let mut distances: Vec<f64> = anchors.iter().map(|p| p.distance_squared(middle)).collect();
        let nearest = (0..anchors.len()).min_by(|a, b| distances[*a].total_cmp(&distances[*b]))?;
        let mut places = vec![anchors[nearest]];
        distances.fill(f64::INFINITY);
        while places.len() < count {
            let last = places[places.len() - 1];
            distances.iter_mut().zip(&anchors).for_each(|(d, p)| *d = d.min(p.distance_squared(last)));
            places.push(anchors[(0..anchors.len()).max_by(|a, b| distances[*a].total_cmp(&distances[*b]))?]);
        }
        Some(Self { places, extent: low.distance(high) })
    }

    pub(crate) fn shapes(&self) -> Vec<HandleShape> {
        self.places.iter().map(|place| HandleShape::planar(*place)).collect()
    }

    /// Every handle turned by up to 60°, stretched by up to a quarter each way, and moved by up to a tenth of the drawing.
    pub(crate) fn pose(&self, random: &mut Random) -> Vec<DAffine3> {
        let mut one = |place: &DVec2| {
            let turn = DAffine2::from_scale_angle_translation(
                DVec2::new(random.between(0.8, 1.25), random.between(0.8, 1.25)),
                random.between(-1.05, 1.05),
                DVec2::new(random.between(-0.1, 0.1), random.between(-0.1, 0.1)) * self.extent,
            );
            in_space(&(DAffine2::from_translation(*place) * turn * DAffine2::from_translation(-*place)))
        };
        self.places.iter().map(&mut one).collect()
    }
}
