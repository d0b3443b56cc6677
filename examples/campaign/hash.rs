//! One number for all results, to compare runs bit by bit.

use bevy_surface_splines::{geodesic::GeodesicPath, surface::SurfacePoint};

/// FNV-1a over 64-bit words, byte by byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fnv(pub(crate) u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    pub(crate) fn word(&mut self, word: u64) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    pub(crate) fn text(&mut self, text: &str) {
        text.bytes().for_each(|b| self.word(u64::from(b)));
    }

    pub(crate) fn path(&mut self, path: &GeodesicPath) {
        self.point(&path.start());
        for c in path.crossings() {
            self.word(u64::from(c.face.0) << 8 | u64::from(c.side));
            self.word(c.at.to_bits());
        }
        self.point(&path.end());
        self.word(path.length().to_bits());
    }

    fn point(&mut self, point: &SurfacePoint) {
        self.word(u64::from(point.face.0));
        point.weights.iter().for_each(|w| self.word(w.to_bits()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_matters() {
        let of = |words: [u64; 2]| {
            let mut hash = Fnv::default();
            words.iter().for_each(|w| hash.word(*w));
            hash
        };
        assert_ne!(of([1, 2]), of([2, 1]));
        let mut a = Fnv::default();
        a.text("a");
        assert_ne!(a, Fnv::default());
    }
}
