//! Which faces meet, recomputed from positions and corners alone.

use std::collections::HashMap;

use bevy_surface_splines::surface::TriangleMesh;
use glam::DVec3;

/// No face, no vertex.
pub(crate) const NONE: u32 = u32::MAX;

/// A side of a face as seen from across: the face and which of its sides it is.
pub(crate) type Side = (u32, usize);

/// The mesh as the checker sees it: vertices with one position are one, and two faces meet in a side if no third does.
#[derive(Debug)]
pub(crate) struct Topology {
    /// Positions of the welded vertices.
    pub(crate) positions: Vec<DVec3>,
    /// Welded corners of every input face; three times [`NONE`] for a face that cannot be part of a surface.
    pub(crate) corners: Vec<[u32; 3]>,
    /// Across side `k` (corner k to corner k + 1): `3 · face + side`, or [`NONE`].
    across: Vec<[u32; 3]>,
    /// The sheet of each face.
    sheets: Vec<u32>,
    /// Whether a sheet cannot be oriented. An engine has to cut such a sheet somewhere, and may do so where it likes.
    one_sided: Vec<bool>,
    /// Length of the bounding box's diagonal.
    pub(crate) diagonal: f64,
}

impl Topology {
    /// Welds, sifts and links; O(F log F).
    pub(crate) fn new(mesh: &TriangleMesh) -> Self {
        let (of_input, positions) = weld(&mesh.positions);
        let corners = sift(mesh, &of_input);
        let across = link(&corners);
        let (sheets, one_sided) = spread(&corners, &across);
        let used = corners.iter().flatten().filter(|v| **v != NONE).map(|v| positions[*v as usize]);
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (min, max) = used.fold(start, |(lo, hi), p| (lo.min(p), hi.max(p)));
        Self { positions, corners, across, sheets, one_sided, diagonal: (max - min).length().max(0.0) }
    }

    /// Whether the face exists and can be part of a surface.
    pub(crate) fn has(&self, face: u32) -> bool {
        self.corners.get(face as usize).is_some_and(|t| t[0] != NONE)
    }

    /// The side met across a side, if exactly two faces meet there.
    pub(crate) fn across(&self, face: u32, side: usize) -> Option<Side> {
        let packed = self.across[face as usize][side];
        (packed != NONE).then_some((packed / 3, packed as usize % 3))
    }

    /// Whether a path can lead from one face to the other.
    pub(crate) fn joined(&self, a: u32, b: u32) -> bool {
        self.sheets[a as usize] == self.sheets[b as usize]
    }

    /// Whether the face's sheet cannot be oriented.
    pub(crate) fn is_one_sided(&self, face: u32) -> bool {
        self.one_sided[self.sheets[face as usize] as usize]
    }

    /// Opens sides of one-sided sheets whose middles are among some places: where an engine says that it cut them.
    ///
    /// A line ends there, and a vertex on such a side is one of the boundary. Sides of other sheets stay, whatever is said of them.
    pub(crate) fn open(&mut self, middles: &[DVec3]) {
        let hair = 1e-12 * self.diagonal;
        for face in 0..self.corners.len() {
            if middles.is_empty() || !self.has(face as u32) || !self.is_one_sided(face as u32) {
                continue;
            }
            for side in 0..3 {
                let [a, b] = [side, (side + 1) % 3].map(|k| self.positions[self.corners[face][k] as usize]);
                if middles.iter().any(|middle| middle.distance(a.midpoint(b)) <= hair) {
                    self.across[face][side] = NONE;
                }
            }
        }
    }

    /// Positions of a face's corners.
    pub(crate) fn places(&self, face: u32) -> [DVec3; 3] {
        self.corners[face as usize].map(|v| self.positions[v as usize])
    }

    /// The longest side of a face.
    pub(crate) fn size(&self, face: u32) -> f64 {
        let [a, b, c] = self.places(face);
        a.distance(b).max(b.distance(c)).max(c.distance(a))
    }

    /// Where a vertex stands among a face's corners.
    pub(crate) fn corner_of(&self, face: u32, vertex: u32) -> Option<usize> {
        self.corners[face as usize].iter().position(|v| *v == vertex)
    }

    /// The other of the two sides of `face` that meet in `vertex`.
    pub(crate) fn other_side(&self, face: u32, vertex: u32, side: usize) -> Option<usize> {
        let corner = self.corner_of(face, vertex)?;
        let before = (corner + 2) % 3;
        Some(if side == corner { before } else { corner })
    }

    /// The end of `side` that is not `vertex`.
    pub(crate) fn far_end(&self, face: u32, side: usize, vertex: u32) -> u32 {
        let t = self.corners[face as usize];
        if t[side] == vertex { t[(side + 1) % 3] } else { t[side] }
    }

    /// Whether turning about `vertex` leads from one face to the other.
    pub(crate) fn same_fan(&self, vertex: u32, from: u32, to: u32) -> bool {
        if from == to {
            return true;
        }
        let Some(corner) = self.corner_of(from, vertex) else { return false };
        [corner, (corner + 2) % 3].into_iter().any(|side| self.fan(vertex, from, side).any(|(face, _)| face == to))
    }

    /// The faces met when `from` is left through `side` and one turns on about `vertex`, each with the side through which
    /// it is entered; ends at the boundary, or with `from` itself.
    pub(crate) fn fan(&self, vertex: u32, from: u32, side: usize) -> impl Iterator<Item = Side> + '_ {
        let mut leave = Some((from, side));
        std::iter::from_fn(move || {
            let (face, side) = leave?;
            let (next, entered) = self.across(face, side)?;
            leave = if next == from { None } else { self.other_side(next, vertex, entered).map(|s| (next, s)) };
            Some((next, entered))
        })
    }
}

/// Joins equal positions; −0 equals 0, positions that are not finite join nothing.
fn weld(positions: &[DVec3]) -> (Vec<u32>, Vec<DVec3>) {
    let mut names: HashMap<[u64; 3], u32> = HashMap::with_capacity(positions.len());
    let mut welded = Vec::new();
    let of_input = positions.iter().map(|p| {
        if !p.is_finite() {
            return NONE;
        }
        let key = [p.x, p.y, p.z].map(|x| if x == 0.0 { 0 } else { x.to_bits() });
        *names.entry(key).or_insert_with(|| {
            welded.push(*p);
            welded.len() as u32 - 1
        })
    });
    (of_input.collect(), welded)
}

/// Welded corners; faces with a corner that is missing or repeated, and later copies of a face, are taken out.
fn sift(mesh: &TriangleMesh, of_input: &[u32]) -> Vec<[u32; 3]> {
    let name = |v: u32| of_input.get(v as usize).copied().unwrap_or(NONE);
    let mut corners: Vec<[u32; 3]> = mesh.faces.iter().map(|t| t.map(name)).collect();
    let mut copies: Vec<([u32; 3], usize)> = Vec::with_capacity(corners.len());
    for (face, t) in corners.iter_mut().enumerate() {
        let [a, b, c] = *t;
        if t.contains(&NONE) || a == b || b == c || c == a {
            *t = [NONE; 3];
        } else {
            let least = a.min(b).min(c);
            copies.push((
                if least == a {
                    [a, b, c]
                } else if least == b {
                    [b, c, a]
                } else {
                    [c, a, b]
                },
                face,
            ));
        }
    }
    copies.sort_unstable();
    for pair in copies.windows(2).filter(|w| w[0].0 == w[1].0) {
        corners[pair[1].1] = [NONE; 3];
    }
    corners
}

/// Links the sides of edges that have exactly two.
fn link(corners: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(corners.len() * 3);
    for (face, t) in corners.iter().enumerate().filter(|(_, t)| t[0] != NONE) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), (3 * face + k) as u32));
        }
    }
    sides.sort_unstable();
    let mut across = vec![[NONE; 3]; corners.len()];
    for run in sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        if let [(.., x), (.., y)] = *run {
            across[x as usize / 3][x as usize % 3] = y;
            across[y as usize / 3][y as usize % 3] = x;
        }
    }
    across
}

/// Numbers the sheets, and finds those where going round brings one back on the other side.
fn spread(corners: &[[u32; 3]], across: &[[u32; 3]]) -> (Vec<u32>, Vec<bool>) {
    let mut sheets = vec![NONE; corners.len()];
    let mut turned = vec![false; corners.len()];
    let mut one_sided = Vec::new();
    let mut open = Vec::new();
    for first in 0..corners.len() {
        if sheets[first] != NONE {
            continue;
        }
        let sheet = one_sided.len() as u32;
        one_sided.push(false);
        sheets[first] = sheet;
        open.push(first);
        while let Some(face) = open.pop() {
            for k in 0..3 {
                let packed = across[face][k];
                if packed == NONE {
                    continue;
                }
                let (other, side) = (packed as usize / 3, packed as usize % 3);
                let same_way = corners[face][k] == corners[other][side];
                let expected = turned[face] ^ same_way;
                if sheets[other] == NONE {
                    sheets[other] = sheet;
                    turned[other] = expected;
                    open.push(other);
                } else if turned[other] != expected {
                    one_sided[sheet as usize] = true;
                }
            }
        }
    }
    (sheets, one_sided)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_surface_splines::surface::shapes;

    #[test]
    fn a_cube_is_one_two_sided_sheet() {
        let topology = Topology::new(&shapes::cube());
        assert_eq!(topology.positions.len(), 8);
        assert!((0..12).all(|f| (0..3).all(|k| topology.across(f, k).is_some())));
        assert!((0..12).all(|f| topology.joined(0, f) && !topology.is_one_sided(f)));
    }

    #[test]
    fn a_third_face_opens_an_edge() {
        let mut mesh = shapes::grid(1, 1, 1.0, 1.0);
        mesh.positions.push(DVec3::Z);
        mesh.faces.push([0, 3, 4]); // 0–3 is the diagonal of the only cell
        let topology = Topology::new(&mesh);
        assert!((0..3).all(|f| (0..3).all(|k| topology.across(f, k).is_none())));
        assert!(!topology.joined(0, 1));
    }

    #[test]
    fn copies_and_broken_faces_are_out() {
        let mut mesh = shapes::grid(1, 1, 1.0, 1.0);
        let [a, b, c] = mesh.faces[0];
        mesh.faces.extend([[b, c, a], [a, a, b]]);
        let topology = Topology::new(&mesh);
        assert_eq!([0, 1, 2, 3, 9].map(|f| topology.has(f)), [true, true, false, false, false]);
    }

    #[test]
    fn a_moebius_band_has_one_side() {
        // Ten pairs of points; the last pair is joined to the first one crosswise.
        let mut mesh = TriangleMesh::default();
        for i in 0..10 {
            let (sin, cos) = (f64::from(i) / 10.0 * std::f64::consts::TAU).sin_cos();
            let (s, c) = (f64::from(i) / 20.0 * std::f64::consts::TAU).sin_cos();
            for side in [-0.3, 0.3] {
                mesh.positions.push(DVec3::new(cos, sin, 0.0) * (1.0 + side * c) + DVec3::Z * side * s);
            }
        }
        for i in 0..10_u32 {
            let (a, b) = (2 * i, 2 * i + 1);
            let (c, d) = if i == 9 { (1, 0) } else { (2 * i + 2, 2 * i + 3) };
            mesh.faces.extend([[a, c, b], [b, c, d]]);
        }
        let mut topology = Topology::new(&mesh);
        assert!(topology.is_one_sided(0) && topology.joined(0, 19));
        let (face, side) = topology.across(0, 1).expect("the band goes on");
        topology.open(&[mesh.positions[2].midpoint(mesh.positions[1])]);
        assert!(topology.across(0, 1).is_none() && topology.across(face, side).is_none());
        let mut cube = Topology::new(&shapes::cube());
        let [a, b, _] = cube.places(0);
        cube.open(&[a.midpoint(b)]);
        assert!(cube.across(0, 0).is_some());
    }
}
