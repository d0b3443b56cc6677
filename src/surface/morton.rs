//! An order of faces in which neighbours in space are near in memory.

use super::{BuildProgress, SurfaceError, TriangleMesh, buckets::Buckets, parallel, sift::Sifted};

/// How many of a cell's 63 bits faces are grouped by before they are sorted: a million faces lie in some thousand of the
/// 2^15 cells that a cube is cut into.
const COARSE_BITS: u32 = 15;

/// The kept faces sorted along the Morton curve of their centroids; ties keep the input's order.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn order(mesh: &TriangleMesh, sifted: &Sifted, progress: &BuildProgress) -> Result<Vec<u32>, SurfaceError> {
    let (kept, min) = (&sifted.kept, sifted.min);
    let extent = (sifted.max - min).max_element();
    let scale = if extent > 0.0 { f64::from((1_u32 << 21) - 1) / extent } else { 0.0 };
    let cells: Vec<u64> = parallel::table(kept.len(), 0, progress, |i| {
        let [a, b, c] = mesh.faces[kept[i] as usize].map(|v| mesh.positions[v as usize] - min);
        let cell = (a + b + c) / 3.0 * scale;
        spread(cell.x as u64) | spread(cell.y as u64) << 1 | spread(cell.z as u64) << 2
    })?;
    let keyed = || cells.iter().zip(kept).map(|(cell, face)| ((cell >> (63 - COARSE_BITS)) as u32, (*cell, *face)));
    let sorted = Buckets::new(1 << COARSE_BITS, keyed, progress)?;
    parallel::table(kept.len(), 0, progress, |i| sorted.items()[i].1)
}

/// Puts two zero bits after each of the low 21 bits.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x1f_0000_0000_ffff;
    x = (x | x << 16) & 0x1f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread() {
        assert_eq!(spread(0b1011), 0b1_000_001_001);
        assert_eq!(spread(0x1f_ffff), 0x1249_2492_4924_9249);
    }
}
