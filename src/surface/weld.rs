//! Vertices with one position become one vertex.

use glam::DVec3;

use super::{BuildProgress, SurfaceError, parallel::PIECE};

/// No vertex: the position is not finite.
pub(crate) const NOT_FINITE: u32 = u32::MAX;

/// The result of welding; welded vertices are numbered by first occurrence.
pub(crate) struct Welded {
    /// For every input vertex its welded vertex, or [`NOT_FINITE`].
    pub(crate) of_input: Vec<u32>,
    /// For every welded vertex the first input vertex at its position.
    pub(crate) first: Vec<u32>,
}

/// Joins vertices whose positions are equal (−0 equals 0). Linear expected time; the result depends on the input order
/// alone.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn weld(positions: &[DVec3], progress: &BuildProgress) -> Result<Welded, SurfaceError> {
    const EMPTY: u32 = u32::MAX;
    let slots = (positions.len() * 2).next_power_of_two().max(16);
    let mut table = vec![EMPTY; slots];
    let mut welded =
        Welded { of_input: Vec::with_capacity(positions.len()), first: Vec::with_capacity(positions.len()) };
    for (i, &p) in positions.iter().enumerate() {
        if i % PIECE == 0 {
            progress.check()?;
        }
        if !p.is_finite() {
            welded.of_input.push(NOT_FINITE);
            continue;
        }
        let mut slot = hash(without_negative_zero(p)) as usize & (slots - 1);
        let id = loop {
            match table[slot] {
                EMPTY => {
                    let id = welded.first.len() as u32;
                    table[slot] = id;
                    welded.first.push(i as u32);
                    break id;
                }
                id if positions[welded.first[id as usize] as usize] == p => break id,
                _ => slot = (slot + 1) & (slots - 1),
            }
        };
        welded.of_input.push(id);
    }
    welded.first.shrink_to_fit();
    Ok(welded)
}

/// −0 becomes +0, so that equal positions have equal bits.
#[inline]
pub(crate) fn without_negative_zero(p: DVec3) -> DVec3 {
    p + DVec3::ZERO
}

/// Multiply–xorshift over the three words: neighbouring grid positions differ in few low mantissa bits, which a plain
/// shift-and-xor would pile onto few slots.
fn hash(p: DVec3) -> u64 {
    let mut h = 0x9e37_79b9_7f4a_7c15_u64;
    for word in [p.x.to_bits(), p.y.to_bits(), p.z.to_bits()] {
        h = (h ^ word).wrapping_mul(0xff51_afd7_ed55_8ccd);
        h ^= h >> 32;
    }
    h.wrapping_mul(0xc4ce_b9fe_1a85_ec53) >> 20
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_positions_weld_and_others_do_not() {
        let p = DVec3::new(1.0, 0.0, -0.0);
        let positions = [p, DVec3::new(1.0, -0.0, 0.0), DVec3::NAN, DVec3::new(1.0, 1e-300, 0.0)];
        let welded = weld(&positions, &BuildProgress::default()).unwrap();
        assert_eq!(welded.of_input, [0, 0, NOT_FINITE, 1]);
        assert_eq!(welded.first, [0, 3]);
    }
}
