//! The least squares system of a chain, its joins eliminated.
//!
//! Every coordinate of a control point is a sum of at most four unknowns and a constant: anchors, handles, or what handles are made of at a
//! join. Put into the energy of all segments that leaves a positive definite system without constraints. Unknowns go along the chain, so
//! its matrix is a band; the first anchor of a closed chain is its border.

use glam::{DMat3, DVec3};

use super::{Chain, band::Band};

/// ∫ m mᵀ of a segment's Bernstein polynomials, times the segment's weight.
pub(crate) type Gram = [[f64; 4]; 4];

/// How the two handles of an anchor hang together in a solve.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Link {
    /// Not at all.
    Free,
    /// The outgoing one is the incoming one times a matrix.
    Tied(DMat3),
    /// Their directions are known; lengths are wanted, or held.
    Along { incoming: DVec3, outgoing: DVec3, held: [Option<f64>; 2] },
}

/// A coordinate of a control point as a sum of unknowns.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    len: u32,
    at: [u32; 4],
    by: [f64; 4],
}

impl Row {
    fn push(&mut self, at: usize, by: f64) {
        if let (true, Some(place)) = (by != 0.0, self.at.get_mut(self.len as usize)) {
            *place = at as u32;
            self.by[self.len as usize] = by;
            self.len += 1;
        }
    }

    #[inline]
    fn terms(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.at.iter().zip(&self.by).take(self.len as usize).map(|(at, by)| (*at as usize, *by))
    }
}

/// The system of a chain, and the memory to solve it in.
///
/// Coordinates are coupled where a join turns a handle or its direction is known: then a control point has as many rows as coordinates.
/// Otherwise one row serves all coordinates, which are columns of the right side.
#[derive(Clone, Debug, Default)]
pub(crate) struct System {
    coupled: usize,
    rows: Vec<Row>,
    constants: Vec<DVec3>,
    has_constants: bool,
    unknowns: usize,
    band: Band,
    unknown_sides: Vec<f64>,
}

impl System {
    /// Makes it that of a chain and factors it; `coupled` is 1 or the number of coordinates.
    pub(crate) fn build(
        &mut self,
        chain: &Chain,
        grams: &[Gram],
        coupled: usize,
        link: impl Fn(usize) -> Link,
    ) -> Result<(), usize> {
        self.coupled = coupled;
        self.rows.clear();
        self.rows.resize(chain.points().len() * coupled, Row::default());
        self.constants.clear();
        self.constants.resize(chain.points().len(), DVec3::ZERO);
        self.has_constants = false;
        self.unknowns = 0;
        let anchors = chain.anchor_count();
        // The first anchor of a closed chain comes last.
        let first = usize::from(chain.is_closed());
        (first..anchors).for_each(|anchor| self.eliminate(chain, anchor, link(anchor)));
        let inner = self.unknowns;
        if first == 1 {
            self.eliminate(chain, 0, link(0));
        }
        self.band.reset(self.unknowns, self.width(chain, inner), self.unknowns - inner);
        for (segment, gram) in grams.iter().enumerate() {
            self.add_segment(chain.places(segment), gram);
        }
        self.band.factor()
    }

    /// Replaces right sides by control points. There are `columns` for every row, entry after entry; constants are those of the columns from
    /// `constant` on: one for each coordinate, or one if coordinates are coupled.
    pub(crate) fn solve(
        &mut self,
        chain: &Chain,
        grams: &[Gram],
        sides: &mut [f64],
        columns: usize,
        constant: Option<usize>,
    ) {
        let constant = constant.filter(|_| self.has_constants);
        if let Some(column) = constant {
            for (segment, gram) in grams.iter().enumerate() {
                let places = chain.places(segment);
                for (row, into) in gram.iter().zip(places) {
                    let sum = row.iter().zip(places).map(|(a, from)| *a * self.constants[from]).sum::<DVec3>();
                    self.add_constant(sides, columns, column, into, -sum);
                }
            }
        }
        self.unknown_sides.clear();
        self.unknown_sides.resize(self.unknowns * columns, 0.0);
        for (row, side) in self.rows.iter().zip(sides.chunks_exact(columns)) {
            for (at, by) in row.terms() {
                let unknown = &mut self.unknown_sides[at * columns..][..columns];
                unknown.iter_mut().zip(side).for_each(|(x, y)| *x += by * y);
            }
        }
        self.band.solve(&mut self.unknown_sides, columns);
        for (row, side) in self.rows.iter().zip(sides.chunks_exact_mut(columns)) {
            side.fill(0.0);
            for (at, by) in row.terms() {
                let unknown = &self.unknown_sides[at * columns..][..columns];
                side.iter_mut().zip(unknown).for_each(|(x, y)| *x += by * y);
            }
        }
        if let Some(column) = constant {
            (0..self.constants.len())
                .for_each(|point| self.add_constant(sides, columns, column, point, self.constants[point]));
        }
    }

    fn add_constant(&self, sides: &mut [f64], columns: usize, column: usize, point: usize, value: DVec3) {
        let values = value.to_array();
        if self.coupled == 1 {
            let side = &mut sides[point * columns + column..(point + 1) * columns];
            side.iter_mut().zip(values).for_each(|(x, y)| *x += y);
        } else {
            for (k, y) in values.into_iter().take(self.coupled).enumerate() {
                sides[(point * self.coupled + k) * columns + column] += y;
            }
        }
    }

    /// Writes the control points at an anchor as sums of new unknowns.
    fn eliminate(&mut self, chain: &Chain, anchor: usize, link: Link) {
        let n = chain.points().len();
        let at = 3 * anchor;
        let before = if at > 0 { Some(at - 1) } else { chain.is_closed().then(|| n - 1) };
        let behind = Some(at + 1).filter(|behind| *behind < n);
        let link = if before.is_none() || behind.is_none() { Link::Free } else { link };
        // The incoming handle is the first of what belongs to it, so that the band is narrow.
        let incoming = match (link, before) {
            (Link::Free, Some(_)) => Some(self.take(self.coupled)),
            (Link::Along { held: [None, _], .. }, _) => Some(self.take(1)),
            _ => None,
        };
        match chain.join(anchor).pinned {
            Some(place) => {
                self.has_constants = true;
                for point in [before, Some(at), behind].into_iter().flatten() {
                    // Free handles are unknowns by themselves.
                    if point == at || !matches!(link, Link::Free) {
                        self.constants[point] += place;
                    }
                }
            }
            None => {
                let first = self.take(self.coupled);
                for point in [before, Some(at), behind].into_iter().flatten() {
                    if point == at || !matches!(link, Link::Free) {
                        (0..self.coupled).for_each(|k| self.row(point, k).push(first + k, 1.0));
                    }
                }
            }
        }
        match link {
            Link::Free => {
                if let (Some(point), Some(first)) = (before, incoming) {
                    (0..self.coupled).for_each(|k| self.row(point, k).push(first + k, 1.0));
                }
                if let Some(point) = behind {
                    let first = self.take(self.coupled);
                    (0..self.coupled).for_each(|k| self.row(point, k).push(first + k, 1.0));
                }
            }
            Link::Tied(matrix) => {
                let (Some(before), Some(behind)) = (before, behind) else { return };
                let first = self.take(self.coupled);
                for k in 0..self.coupled {
                    self.row(before, k).push(first + k, 1.0);
                    for l in 0..self.coupled {
                        self.row(behind, k).push(first + l, matrix.col(l)[k]);
                    }
                }
            }
            Link::Along { incoming: u, outgoing: v, held } => {
                let (Some(before), Some(behind)) = (before, behind) else { return };
                let outgoing = held[1].is_none().then(|| self.take(1));
                for (point, direction, unknown, held) in
                    [(before, u, incoming, held[0]), (behind, v, outgoing, held[1])]
                {
                    match (unknown, held) {
                        (Some(first), _) => {
                            (0..self.coupled).for_each(|k| self.row(point, k).push(first, direction[k]));
                        }
                        (None, held) => {
                            self.constants[point] += direction * held.unwrap_or(0.0);
                            self.has_constants = true;
                        }
                    }
                }
            }
        }
    }

    fn take(&mut self, count: usize) -> usize {
        self.unknowns += count;
        self.unknowns - count
    }

    fn row(&mut self, point: usize, coordinate: usize) -> &mut Row {
        &mut self.rows[point * self.coupled + coordinate]
    }

    /// How far apart unknowns of a segment are at most, of those before the border.
    fn width(&self, chain: &Chain, inner: usize) -> usize {
        let of_segment = |segment: usize| {
            let rows = chain.places(segment).into_iter().flat_map(|p| &self.rows[p * self.coupled..][..self.coupled]);
            let inside = rows.flat_map(Row::terms).map(|(at, _)| at).filter(|at| *at < inner);
            let (low, high) = inside.fold((usize::MAX, 0), |(low, high), at| (low.min(at), high.max(at)));
            high.saturating_sub(low)
        };
        (0..chain.segment_count()).map(of_segment).max().unwrap_or(0)
    }

    fn add_segment(&mut self, places: [usize; 4], gram: &Gram) {
        for k in 0..4 {
            for l in 0..=k {
                for coordinate in 0..self.coupled {
                    let (a, b) = (
                        self.rows[places[k] * self.coupled + coordinate],
                        self.rows[places[l] * self.coupled + coordinate],
                    );
                    for (i, by) in a.terms() {
                        let by = by * gram[k][l];
                        for (j, by_other) in b.terms() {
                            if k != l {
                                let twice = if i == j { 2.0 } else { 1.0 };
                                self.band.add(i, j, twice * by * by_other);
                            } else if i >= j {
                                self.band.add(i, j, by * by_other);
                            }
                        }
                    }
                }
            }
        }
    }
}
