//! Symmetric positive definite systems whose entries lie near the diagonal, save for a few last rows.

/// A symmetric positive definite matrix, lower half, and its Cholesky factor in the same place.
///
/// Rows before the last `border` ones have entries in `width` columns before the diagonal; the last ones in all. A chain of segments gives
/// a band; a closed one gives rows that couple its first anchor with both ends of the band.
#[derive(Clone, Debug, Default)]
pub(crate) struct Band {
    size: usize,
    width: usize,
    border: usize,
    /// Row after row, `width + 1` entries, the last of which is on the diagonal. In the factor the diagonal has reciprocals.
    rows: Vec<f64>,
    /// Border rows, `size` entries each.
    edges: Vec<f64>,
}

impl Band {
    /// Makes it a matrix of zeros.
    pub(crate) fn reset(&mut self, size: usize, width: usize, border: usize) {
        (self.size, self.width, self.border) = (size, width, border.min(size));
        self.rows.clear();
        self.rows.resize((size - self.border) * (width + 1), 0.0);
        self.edges.clear();
        self.edges.resize(self.border * size, 0.0);
    }

    /// Rows before the border.
    fn inner(&self) -> usize {
        self.size - self.border
    }

    /// Adds to the entry of a row and a column, and to its mirror image.
    #[inline]
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        let (row, column) = (row.max(column), row.min(column));
        let inner = self.inner();
        if row < inner {
            debug_assert!(row - column <= self.width, "{row} {column} {}", self.width);
            self.rows[row * (self.width + 1) + column + self.width - row] += value;
        } else {
            self.edges[(row - inner) * self.size + column] += value;
        }
    }

    /// Factors it; gives the first row that is not positive.
    pub(crate) fn factor(&mut self) -> Result<(), usize> {
        let (w, inner, size) = (self.width, self.inner(), self.size);
        for i in 0..inner {
            let low = i.saturating_sub(w);
            let (before, from_row) = self.rows.split_at_mut(i * (w + 1));
            let row = &mut from_row[..=w];
            for j in low..i {
                // Entries of columns that both rows have.
                let other = &before[j * (w + 1)..(j + 1) * (w + 1)];
                let first = low.max(j.saturating_sub(w));
                let count = j - first;
                let a = &row[first + w - i..][..count];
                let b = &other[first + w - j..][..count];
                let sum: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                row[j + w - i] = (row[j + w - i] - sum) * other[w];
            }
            let sum: f64 = row[low + w - i..w].iter().map(|a| a * a).sum();
            row[w] = reciprocal_root(row[w], sum).ok_or(i)?;
        }
        for e in 0..self.border {
            let (before, from_edge) = self.edges.split_at_mut(e * size);
            let edge = &mut from_edge[..size];
            for j in 0..inner {
                let other = &self.rows[j * (w + 1)..(j + 1) * (w + 1)];
                let first = j.saturating_sub(w);
                let sum: f64 = edge[first..j].iter().zip(&other[first + w - j..w]).map(|(a, b)| a * b).sum();
                edge[j] = (edge[j] - sum) * other[w];
            }
            for f in 0..e {
                let other = &before[f * size..(f + 1) * size];
                let sum: f64 = edge[..inner + f].iter().zip(other).map(|(a, b)| a * b).sum();
                edge[inner + f] = (edge[inner + f] - sum) * other[inner + f];
            }
            let sum: f64 = edge[..inner + e].iter().map(|a| a * a).sum();
            edge[inner + e] = reciprocal_root(edge[inner + e], sum).ok_or(inner + e)?;
        }
        Ok(())
    }

    /// Replaces right sides by solutions, `columns` at once: entry `c` of row `i` is at `i * columns + c`.
    pub(crate) fn solve(&self, sides: &mut [f64], columns: usize) {
        for i in 0..self.size {
            let (first, entries, diagonal) = self.row(i);
            let (before, from) = sides.split_at_mut(i * columns);
            let own = &mut from[..columns];
            for (k, l) in (first..i).zip(entries) {
                subtract(own, &before[k * columns..(k + 1) * columns], *l);
            }
            own.iter_mut().for_each(|x| *x *= diagonal);
        }
        for i in (0..self.size).rev() {
            let (first, entries, diagonal) = self.row(i);
            let (before, from) = sides.split_at_mut(i * columns);
            let own = &mut from[..columns];
            own.iter_mut().for_each(|x| *x *= diagonal);
            for (k, l) in (first..i).zip(entries) {
                subtract(&mut before[k * columns..(k + 1) * columns], own, *l);
            }
        }
    }

    /// The first column of a row of the factor, its entries before the diagonal, and the reciprocal of the diagonal.
    fn row(&self, i: usize) -> (usize, &[f64], f64) {
        let (w, inner) = (self.width, self.inner());
        if i < inner {
            let first = i.saturating_sub(w);
            let row = &self.rows[i * (w + 1)..(i + 1) * (w + 1)];
            (first, &row[first + w - i..w], row[w])
        } else {
            let edge = &self.edges[(i - inner) * self.size..][..=i];
            (0, &edge[..i], edge[i])
        }
    }
}

#[inline]
fn subtract(from: &mut [f64], what: &[f64], by: f64) {
    from.iter_mut().zip(what).for_each(|(x, y)| *x -= by * y);
}

/// One over the root of what is left of a diagonal entry, unless digits were lost.
fn reciprocal_root(entry: f64, sum: f64) -> Option<f64> {
    let left = entry - sum;
    (left > 1e-14 * entry && left.is_finite()).then(|| 1.0 / left.sqrt()).filter(|r| r.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_solve() {
        let mut state = 7_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for (size, width, border) in [(1, 0, 0), (5, 3, 0), (12, 3, 2), (6, 7, 6), (40, 5, 3), (20, 11, 9)] {
            let mut full = vec![0.0; size * size];
            let mut band = Band::default();
            band.reset(size, width, border);
            for i in 0..size {
                for j in 0..=i {
                    let inside = i >= size - border || i - j <= width;
                    let value = if i == j { 12.0 + random() } else { random() } * f64::from(inside);
                    full[i * size + j] = value;
                    full[j * size + i] = value;
                    if inside {
                        band.add(j, i, value);
                    }
                }
            }
            let columns = 3;
            let wanted: Vec<f64> = (0..size * columns).map(|_| random()).collect();
            let mut sides = vec![0.0; size * columns];
            for i in 0..size {
                for j in 0..size {
                    for c in 0..columns {
                        sides[i * columns + c] += full[i * size + j] * wanted[j * columns + c];
                    }
                }
            }
            band.factor().unwrap();
            band.solve(&mut sides, columns);
            let off = sides.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-13, "{size} {width} {border}: {off}");
        }
    }

    #[test]
    fn what_is_not_positive_is_refused() {
        let mut band = Band::default();
        band.reset(2, 1, 0);
        for (i, j, value) in [(0, 0, 1.0), (1, 0, 2.0), (1, 1, 1.0)] {
            band.add(i, j, value);
        }
        assert_eq!(band.factor(), Err(1));
    }
}
