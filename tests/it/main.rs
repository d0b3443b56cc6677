//! Tests that use several parts at once, in one binary.

#[cfg(feature = "document")]
mod broken_child;
#[cfg(all(feature = "svg", feature = "document"))]
mod characters;
#[cfg(feature = "formats")]
mod corpus;
#[cfg(feature = "document")]
mod documents;
#[cfg(feature = "svg")]
mod drawings;
#[cfg(feature = "tools")]
mod editor;
mod exports;
#[cfg(feature = "formats")]
mod formats;
#[cfg(feature = "bevy")]
mod plugin;
#[cfg(any(feature = "svg", feature = "formats"))]
mod skins;

/// Small, seeded random numbers (splitmix64).
#[cfg(feature = "document")]
struct Random(u64);

#[cfg(feature = "document")]
impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to 1.
    fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}
