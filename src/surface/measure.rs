//! Lengths, angles and what follows from them.

use glam::DVec3;

use super::{
    BuildProgress, SurfaceError, metric,
    parallel::{self, PIECE},
};

/// Shortest admissible slack of a triangle's sides, as a share of the mean edge (see [`Surface::slack`](super::Surface)).
const MOLLIFICATION: f64 = 1e-5;

/// Lengths of the sides of each face.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn lengths(
    triangles: &[[u32; 3]],
    positions: &[DVec3],
    progress: &BuildProgress,
) -> Result<Vec<[f64; 3]>, SurfaceError> {
    parallel::table(triangles.len(), [0.0; 3], progress, |face| {
        let t = triangles[face];
        let p = t.map(|v| positions[v as usize]);
        // Both faces of an edge must see the same bits, so always measure from the smaller vertex number.
        let side = |i: usize, j: usize| if t[i] < t[j] { (p[j] - p[i]).length() } else { (p[i] - p[j]).length() };
        [side(0, 1), side(1, 2), side(2, 0)]
    })
}

/// Total angle of the faces about each vertex, and the smallest angle of all.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn angles(
    triangles: &[[u32; 3]],
    lengths: &[[f64; 3]],
    vertices: usize,
    progress: &BuildProgress,
) -> Result<(Vec<f64>, f64), SurfaceError> {
    /// Faces whose corners are measured at a time, for all threads.
    const BLOCK: usize = 16 * PIECE;
    let (mut total, mut smallest) = (vec![0.0; vertices], f64::INFINITY);
    for (triangles, lengths) in triangles.chunks(BLOCK).zip(lengths.chunks(BLOCK)) {
        let corners = parallel::table(lengths.len(), [0.0; 3], progress, |face| {
            let [a, b, c] = lengths[face];
            [metric::corner_angle(a, c, b), metric::corner_angle(b, a, c), metric::corner_angle(c, b, a)]
        })?;
        // Added up in the order of faces, whatever thread measured them: sums depend on the order.
        for (&v, &corner) in triangles.as_flattened().iter().zip(corners.as_flattened()) {
            total[v as usize] += corner;
            smallest = smallest.min(corner);
        }
    }
    Ok((total, smallest))
}

/// What is known of each sheet's lengths.
pub(crate) struct Sheets {
    /// Mean length of a side.
    pub(crate) mean_edge: Vec<f64>,
    /// What must be added to every side so that needles become ordinary triangles.
    pub(crate) slack: Vec<f64>,
}

/// Measures each sheet.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn sheets(
    lengths: &[[f64; 3]],
    sheet: &[u32],
    sheets: usize,
    progress: &BuildProgress,
) -> Result<Sheets, SurfaceError> {
    let pieces = || lengths.chunks(PIECE).zip(sheet.chunks(PIECE));
    let mut sums = vec![(0.0_f64, 0_usize); sheets];
    for (lengths, sheet) in pieces() {
        progress.check()?;
        for (l, sheet) in lengths.iter().zip(sheet) {
            let sum = &mut sums[*sheet as usize];
            *sum = (sum.0 + l[0] + l[1] + l[2], sum.1 + 3);
        }
    }
    let mean_edge: Vec<f64> = sums.iter().map(|(sum, count)| sum / (*count).max(1) as f64).collect();
    let mut slack = vec![0.0_f64; sheets];
    for (lengths, sheet) in pieces() {
        progress.check()?;
        for (l, sheet) in lengths.iter().zip(sheet) {
            let sheet = *sheet as usize;
            let least = MOLLIFICATION * mean_edge[sheet];
            for k in 0..3 {
                slack[sheet] = slack[sheet].max(least - (l[k] + l[(k + 1) % 3] - l[(k + 2) % 3]));
            }
        }
    }
    Ok(Sheets { mean_edge, slack })
}

/// What stands out among the faces.
pub(crate) struct Extremes {
    pub(crate) shortest: f64,
    pub(crate) longest: f64,
    /// Faces without area to speak of.
    pub(crate) degenerate: usize,
}

/// Looks for short, long and flat faces.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(crate) fn extremes(lengths: &[[f64; 3]], progress: &BuildProgress) -> Result<Extremes, SurfaceError> {
    let none = || Extremes { shortest: f64::INFINITY, longest: 0.0, degenerate: 0 };
    let pieces = parallel::map_pieces(lengths.len(), progress, |faces| {
        lengths[faces].iter().fold(none(), |out, &[a, b, c]| {
            let side = a.max(b).max(c);
            let flat = 2.0 * metric::area(a, b, c) <= 1e-10 * side * side;
            Extremes {
                shortest: out.shortest.min(a).min(b).min(c),
                longest: out.longest.max(side),
                degenerate: out.degenerate + usize::from(flat),
            }
        })
    })?;
    Ok(pieces.into_iter().fold(none(), |a, b| Extremes {
        shortest: a.shortest.min(b.shortest),
        longest: a.longest.max(b.longest),
        degenerate: a.degenerate + b.degenerate,
    }))
}
