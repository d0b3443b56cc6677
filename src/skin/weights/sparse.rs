//! Sparse symmetric matrices of a triangulation, and their factors.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};

use super::WeightsError;
use super::plane_mesh::PlaneMesh;

/// A symmetric matrix, all entries of each row.
#[derive(Clone, Debug)]
pub(super) struct Symmetric {
    starts: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

/// The factor of a matrix.
pub(super) struct Factor(Llt<usize, f64>);

/// The places of entries, analysed once for all matrices that have them.
pub(super) struct Pattern {
    symbolic: SymbolicSparseColMat<usize>,
    factor: SymbolicLlt<usize>,
}

impl Symmetric {
    /// The Laplacian of cotangents of a triangulation, positive semidefinite, and a third of the area about each vertex.
    pub(super) fn laplacian(mesh: &PlaneMesh) -> (Self, Vec<f64>) {
        let n = mesh.positions.len();
        let mut entries: Vec<(usize, usize, f64)> = (0..n).map(|i| (i, i, 0.0)).collect();
        let mut areas = vec![0.0; n];
        for triangle in &mesh.triangles {
            let corners = triangle.map(|v| v as usize);
            let places = corners.map(|v| mesh.positions[v]);
            let twice = (places[1] - places[0]).perp_dot(places[2] - places[0]).abs();
            for k in 0..3 {
                let (i, j) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
                let (u, v) = (places[(k + 1) % 3] - places[k], places[(k + 2) % 3] - places[k]);
                let half = 0.5 * u.dot(v) / twice;
                entries.extend([(i, i, half), (j, j, half), (i, j, -half), (j, i, -half)]);
                areas[corners[k]] += twice / 6.0;
            }
        }
        (Self::of_entries(n, entries), areas)
    }

    fn of_entries(n: usize, mut entries: Vec<(usize, usize, f64)>) -> Self {
        entries.sort_by_key(|(i, j, _)| (*i, *j));
        let mut found = Self { starts: vec![0; n + 1], columns: Vec::new(), values: Vec::new() };
        for group in entries.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            found.columns.push(group[0].1);
            found.values.push(group.iter().map(|(.., value)| value).sum());
            found.starts[group[0].0 + 1] += 1;
        }
        (0..n).for_each(|i| found.starts[i + 1] += found.starts[i]);
        found
    }

    /// This, times a diagonal matrix of reciprocals, times this.
    pub(super) fn squared(&self, divisors: &[f64]) -> Self {
        let n = self.size();
        let (mut sums, mut seen) = (vec![0.0; n], vec![usize::MAX; n]);
        let mut found = Self { starts: vec![0; n + 1], columns: Vec::new(), values: Vec::new() };
        for i in 0..n {
            let mut columns = Vec::new();
            for (k, a) in self.row(i) {
                for (j, b) in self.row(k) {
                    if seen[j] != i {
                        seen[j] = i;
                        sums[j] = 0.0;
                        columns.push(j);
                    }
                    sums[j] += a * b / divisors[k];
                }
            }
            columns.sort_unstable();
            found.values.extend(columns.iter().map(|j| sums[*j]));
            found.columns.append(&mut columns);
            found.starts[i + 1] = found.columns.len();
        }
        found
    }

    pub(super) fn size(&self) -> usize {
        self.starts.len() - 1
    }

    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.starts[i]..self.starts[i + 1];
        self.columns[range.clone()].iter().copied().zip(self.values[range].iter().copied())
    }

    pub(super) fn diagonal(&self, i: usize) -> f64 {
        self.row(i).find(|(j, _)| *j == i).map_or(0.0, |(_, value)| value)
    }

    pub(super) fn times(&self, x: &[f64]) -> Vec<f64> {
        (0..self.size()).map(|i| self.row(i).map(|(j, a)| a * x[j]).sum()).collect()
    }

    pub(super) fn pattern(&self) -> Result<Pattern, WeightsError> {
        let n = self.size();
        let symbolic = SymbolicSparseColMat::new_checked(n, n, self.starts.clone(), None, self.columns.clone());
        let factor = SymbolicLlt::try_new(symbolic.as_ref(), Side::Lower).map_err(|_| WeightsError::Singular)?;
        Ok(Pattern { symbolic, factor })
    }

    /// Factors this, with something added to the diagonal, and with rows of values that are fixed left out.
    pub(super) fn factor(
        &self,
        pattern: &Pattern,
        more: f64,
        is_fixed: impl Fn(usize) -> bool,
    ) -> Result<Factor, WeightsError> {
        let mut values = Vec::with_capacity(self.values.len());
        for i in 0..self.size() {
            values.extend(self.row(i).map(|(j, value)| match (i == j, is_fixed(i) || is_fixed(j)) {
                (true, true) => 1.0,
                (true, false) => value + more,
                (false, true) => 0.0,
                (false, false) => value,
            }));
        }
        let matrix = SparseColMat::new(pattern.symbolic.clone(), values);
        let factor = Llt::try_new_with_symbolic(pattern.factor.clone(), matrix.as_ref(), Side::Lower);
        factor.map(Factor).map_err(|_| WeightsError::Singular)
    }
}

impl Factor {
    /// Replaces a right side by the solution.
    pub(super) fn solve(&self, side: &mut [f64]) {
        let mut columns = Mat::from_fn(side.len(), 1, |i, _| side[i]);
        self.0.solve_in_place(&mut columns);
        side.iter_mut().enumerate().for_each(|(i, x)| *x = columns[(i, 0)]);
    }
}
