//! An order of faces in which neighbours in space are near in memory.

use glam::DVec3;

/// Faces sorted along the Morton curve of their centroids; ties keep the given order.
pub(crate) fn order(triangles: &[[u32; 3]], positions: &[DVec3], min: DVec3, max: DVec3) -> Vec<u32> {
    let extent = (max - min).max_element();
    let scale = if extent > 0.0 { f64::from((1_u32 << 21) - 1) / extent } else { 0.0 };
    let mut keyed: Vec<(u64, u32)> = triangles
        .iter()
        .enumerate()
        .map(|(face, t)| {
            let [a, b, c] = t.map(|v| positions[v as usize] - min);
            let cell = (a + b + c) / 3.0 * scale;
            (spread(cell.x as u64) | spread(cell.y as u64) << 1 | spread(cell.z as u64) << 2, face as u32)
        })
        .collect();
    super::sort::sort_distinct(&mut keyed);
    keyed.into_iter().map(|(_, face)| face).collect()
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
