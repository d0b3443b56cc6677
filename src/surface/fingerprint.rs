//! By what a mesh is known again, whatever file or engine it came from.

use super::{BuildProgress, SurfaceError, TriangleMesh, parallel};

/// Coordinates between these are rounded to `f32`: that is what STL, glTF, most PLY files and engines hold.
const SINGLE: std::ops::RangeInclusive<f64> = 1e-30..=1e37;

/// Hashes the corners' positions of all input faces, in the order of the input.
///
/// Numbers of vertices do not count, nor vertices without a face: an STL file has neither. So positions are hashed as welding
/// leaves them, where −0 is 0 too.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn of(mesh: &TriangleMesh, progress: &BuildProgress) -> Result<u64, SurfaceError> {
    let corners = |face: usize| mesh.faces[face].into_iter().map(|v| mesh.positions.get(v as usize));
    let largest = parallel::map_pieces(mesh.faces.len(), progress, |faces| {
        let all = faces.flat_map(corners).flatten().map(|p| p.abs().max_element());
        all.filter(|x| x.is_finite()).fold(0.0, f64::max)
    })?;
    let single = SINGLE.contains(&largest.into_iter().fold(0.0, f64::max));
    let pieces = parallel::map_pieces(mesh.faces.len(), progress, |faces| {
        let mut hash = Words::default();
        for corner in faces.flat_map(corners) {
            let p = corner.filter(|p| p.is_finite()).map(|p| p.to_array());
            match p {
                None => hash.mix(u64::MAX),
                Some(p) if single => {
                    let [x, y, z] = p.map(|x| u64::from((x as f32 + 0.0).to_bits()));
                    hash.mix(x << 32 | y);
                    hash.mix(z);
                }
                Some(p) => p.iter().for_each(|x| hash.mix((x + 0.0).to_bits())),
            }
        }
        hash.0
    })?;
    let mut hash = Words::default();
    hash.mix(mesh.faces.len() as u64);
    pieces.into_iter().for_each(|piece| hash.mix(piece));
    Ok(hash.0)
}

/// A 64-bit hash of words: multiply and xor-shift.
pub(crate) struct Words(pub(crate) u64);

impl Default for Words {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Words {
    #[inline]
    pub(crate) fn mix(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0xff51_afd7_ed55_8ccd);
        self.0 ^= self.0 >> 32;
    }
}

impl TriangleMesh {
    /// A 64-bit hash of the faces' corner positions in input order, rounded to `f32`: the same for every file format, and for
    /// the mesh of an engine.
    ///
    /// It is the [`fingerprint`](super::Surface::fingerprint) of the surface built from this mesh. O(faces).
    pub fn fingerprint(&self) -> u64 {
        of(self, &BuildProgress::default()).unwrap_or_default() // nobody can cancel
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Surface, SurfaceOptions, shapes};
    use glam::DVec3;

    #[test]
    fn numbers_of_vertices_do_not_count() {
        let torus = shapes::torus(1.0, 0.3, 24, 12);
        let soup = TriangleMesh {
            positions: torus.faces.iter().flatten().map(|v| torus.positions[*v as usize]).collect(),
            faces: (0..torus.faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(),
        };
        let mut rounded = torus.clone();
        rounded.positions.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
        rounded.positions.push(DVec3::NAN);
        let fingerprint = torus.fingerprint();
        assert_eq!([soup.fingerprint(), rounded.fingerprint()], [fingerprint; 2]);
        for mesh in [&torus, &soup, &rounded] {
            let surface = Surface::build(mesh, &SurfaceOptions::default()).unwrap();
            assert_eq!(surface.fingerprint(), fingerprint);
        }
    }

    #[test]
    fn every_other_change_counts() {
        let mesh = shapes::icosphere(2);
        let mut others = vec![mesh.clone(); 6];
        others[0].positions[5].x += 1e-5;
        others[1].faces.swap(3, 4);
        others[2].faces[3].rotate_left(1);
        others[3].faces[3].swap(1, 2);
        others[4].faces.pop();
        others[5].positions.iter_mut().for_each(|p| *p *= 1e-50);
        let mut tinier = others[5].clone();
        tinier.positions[0] *= 1.5;
        let mut seen: Vec<u64> = others.iter().chain([&mesh, &tinier]).map(TriangleMesh::fingerprint).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 8);
        let mut zeros = mesh.clone();
        zeros.positions.iter_mut().for_each(|p| *p = -(-*p + DVec3::ZERO));
        assert_eq!(zeros.fingerprint(), mesh.fingerprint());
    }
}
