//! Weights that are solved for on a triangulation: harmonic and bounded biharmonic.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::bounded::{Minimum, minimise};
use super::plane_mesh::PlaneMesh;
use super::sparse::Symmetric;
use super::{Cage, HandleShape, WeightField, WeightsError};
use crate::skin::{Quadrature, spread};

/// Weights at the vertices of a triangulation of the plane, linear on its triangles.
///
/// What lies outside the triangulation has the weights of the nearest place of its rim. z does not count.
#[derive(Clone, Debug)]
pub struct MeshedWeights {
    mesh: PlaneMesh,
    handles: usize,
    /// Of the first vertex, then of the second, …; they sum to one.
    values: Vec<f64>,
    report: MeshedReport,
}

/// How weights were solved for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshedReport {
    /// Triangles.
    pub triangles: usize,
    /// Rounds of the active set that a handle took at most; 0 where bounds need not be watched.
    pub rounds: u32,
    /// Whether the minimum was reached for all handles. If not, weights are still within their bounds and sum to one.
    pub settled: bool,
    /// Smallest and largest sum of weights before they were brought to one.
    pub sums: [f64; 2],
}

/// Numbers that weights may be: half a gigabyte.
const MOST_NUMBERS: usize = 1 << 26;
/// Places that handles may hold: more than the finest triangulation has vertices.
const MOST_PLACES: usize = 1 << 18;

/// Vertices that thin cages may add, as a multiple of triangles; even ones take half as many as triangles.
const SPARE: usize = 8;

/// What a vertex is fixed to: shares of at most two handles.
type Fixed = Option<[(usize, f64); 2]>;

/// Places that handles hold, in cells so small that one is of one handle.
struct Taken {
    origin: DVec2,
    /// How far apart places of different handles have to be.
    apart: f64,
    cells: HashMap<[i64; 2], (DVec2, usize)>,
}

impl Taken {
    /// Takes a place for a handle; gives another handle that holds it.
    fn take(&mut self, place: DVec2, handle: usize) -> Option<usize> {
        let cell = ((place - self.origin) / (self.apart * std::f64::consts::FRAC_1_SQRT_2)).floor();
        let at = |x: i64, y: i64| [(cell.x as i64).saturating_add(x), (cell.y as i64).saturating_add(y)];
        let around = (-2..=2).flat_map(|x| (-2..=2).map(move |y| (x, y)));
        let near = around.filter_map(|(x, y)| self.cells.get(&at(x, y)));
        let holds = |(other, of): &&(DVec2, usize)| *of != handle && other.distance(place) < self.apart;
        let found = near.filter(holds).map(|(_, of)| *of).next();
        self.cells.insert(at(0, 0), (place, handle));
        found
    }
}

impl MeshedWeights {
    /// Harmonic coordinates of a cage, whose corners are the handles (Joshi et al. 2007): linear along its edges, and inside as smooth
    /// as a stretched skin. About `triangles` triangles; from ten to forty thousand are usual. Solving costs a factor and a
    /// solve for each corner.
    ///
    /// # Errors
    /// [`WeightsError::Triangulation`], [`WeightsError::Singular`], [`WeightsError::TooMany`].
    pub fn harmonic(cage: &Cage, triangles: usize) -> Result<Self, WeightsError> {
        Self::harmonic_within(cage, triangles, SPARE)
    }

    /// [`harmonic`](Self::harmonic) with a bound on vertices that thin cages may add.
    pub(crate) fn harmonic_within(cage: &Cage, triangles: usize, spare: usize) -> Result<Self, WeightsError> {
        let mesh = PlaneMesh::new(cage, &[], triangles, spare)?;
        bound_numbers(&mesh, cage.corners().len())?;
        let fixed = on_cage(&mesh, cage);
        let (laplacian, _) = Symmetric::laplacian(&mesh);
        let pattern = laplacian.pattern()?;
        let factor = laplacian.factor(&pattern, 0.0, |i| fixed[i].is_some())?;
        let handles: Vec<usize> = (0..cage.corners().len()).collect();
        let solve = |_: &mut (), _: usize, handle: &usize| {
            let value = |i: usize| fixed[i].map(|shares| share_of(&shares, *handle));
            let of_row = |i: usize| match value(i) {
                Some(value) => value,
                None => -laplacian.row(i).map(|(j, a)| a * value(j).unwrap_or(0.0)).sum::<f64>(),
            };
            let mut side: Vec<f64> = (0..laplacian.size()).map(of_row).collect();
            factor.solve(&mut side);
            side.iter_mut().for_each(|w| *w = w.clamp(0.0, 1.0));
            Ok(Minimum { values: side, rounds: 0, settled: true })
        };
        Self::gathered(mesh, spread::map(&handles, || (), solve))
    }

    /// Bounded biharmonic weights of points and bones inside an outline (Jacobson et al. 2011): each moves its surroundings alone, and fades
    /// smoothly. About `triangles` triangles; a few thousand are usual. Solving costs some ten factors for each handle.
    ///
    /// # Errors
    /// [`WeightsError::NoHandles`], [`WeightsError::NotFinite`], [`WeightsError::HandleOutside`], [`WeightsError::SamePlace`],
    /// [`WeightsError::Triangulation`], [`WeightsError::Singular`], [`WeightsError::TooMany`].
    pub fn biharmonic(outline: &Cage, handles: &[HandleShape], triangles: usize) -> Result<Self, WeightsError> {
        Self::biharmonic_within(outline, handles, triangles, SPARE)
    }

    /// [`biharmonic`](Self::biharmonic) with a bound on vertices that thin outlines may add.
    pub(crate) fn biharmonic_within(
        outline: &Cage,
        handles: &[HandleShape],
        triangles: usize,
        spare: usize,
    ) -> Result<Self, WeightsError> {
        if handles.is_empty() {
            return Err(WeightsError::NoHandles);
        }
        let extent = outline.extent();
        let mut places: Vec<(DVec2, usize)> = Vec::new();
        let origin = outline.corners().first().copied().unwrap_or_default();
        let mut taken = Taken { origin, apart: 1e-6 * extent, cells: HashMap::new() };
        // As far apart as vertices will be.
        let step = extent / (triangles.clamp(16, 1 << 18) as f64).sqrt();
        for (handle, shape) in handles.iter().enumerate() {
            let [from, to] = shape.ends().map(DVec3::truncate);
            if !(from.is_finite() && to.is_finite()) {
                return Err(WeightsError::NotFinite { point: handle });
            }
            let pieces = (from.distance(to) / step).ceil().clamp(0.0, 4096.0) as u32;
            for piece in 0..=pieces {
                let place = from.lerp(to, f64::from(piece) / f64::from(pieces.max(1)));
                let distance = outline.nearest(place).2;
                if !outline.contains(place) && distance > 1e-9 * extent {
                    return Err(WeightsError::HandleOutside { handle, distance });
                }
                if let Some(other) = taken.take(place, handle) {
                    return Err(WeightsError::SamePlace { handles: [other, handle] });
                }
                places.push((place, handle));
                if places.len() > MOST_PLACES {
                    return Err(WeightsError::TooMany { handles: handles.len(), vertices: places.len() });
                }
            }
        }
        let only: Vec<DVec2> = places.iter().map(|(place, _)| *place).collect();
        let mesh = PlaneMesh::new(outline, &only, triangles, spare)?;
        let mut fixed: Vec<Fixed> = vec![None; mesh.positions.len()];
        for (place, handle) in places {
            let vertex = mesh.vertex_at(place, extent).ok_or(WeightsError::Triangulation)?;
            fixed[vertex] = Some([(handle, 1.0), (handle, 0.0)]);
        }
        Self::bounded(mesh, &fixed, handles.len())
    }

    /// Bounded biharmonic weights of a cage, whose corners are the handles: linear along its edges, smooth inside.
    ///
    /// # Errors
    /// [`WeightsError::Triangulation`], [`WeightsError::Singular`], [`WeightsError::TooMany`].
    pub fn biharmonic_cage(cage: &Cage, triangles: usize) -> Result<Self, WeightsError> {
        let mesh = PlaneMesh::new(cage, &[], triangles, SPARE)?;
        let fixed = on_cage(&mesh, cage);
        Self::bounded(mesh, &fixed, cage.corners().len())
    }

    fn bounded(mesh: PlaneMesh, fixed: &[Fixed], handles: usize) -> Result<Self, WeightsError> {
        bound_numbers(&mesh, handles)?;
        let solved = solve_bounded(&mesh, fixed, handles)?;
        Self::gathered(mesh, solved.into_iter().map(Ok).collect())
    }

    /// Brings the weights of each vertex to a sum of one.
    fn gathered(mesh: PlaneMesh, solved: Vec<Result<Minimum, WeightsError>>) -> Result<Self, WeightsError> {
        let solved = solved.into_iter().collect::<Result<Vec<_>, _>>()?;
        let (n, handles) = (mesh.positions.len(), solved.len());
        let mut report = MeshedReport {
            triangles: mesh.triangles.len(),
            rounds: solved.iter().map(|one| one.rounds).max().unwrap_or(0),
            settled: solved.iter().all(|one| one.settled),
            sums: [f64::INFINITY, f64::NEG_INFINITY],
        };
        let mut values = Vec::with_capacity(n * handles);
        for vertex in 0..n {
            let sum: f64 = solved.iter().map(|one| one.values[vertex]).sum();
            report.sums = [report.sums[0].min(sum), report.sums[1].max(sum)];
            // Where no handle reaches, all do alike.
            let of_handle = |one: &Minimum| if sum > 1e-9 { one.values[vertex] / sum } else { 1.0 / handles as f64 };
            values.extend(solved.iter().map(of_handle));
        }
        Ok(Self { mesh, handles, values, report })
    }

    /// How they were solved for.
    pub fn report(&self) -> MeshedReport {
        self.report
    }

    /// Vertices of the triangulation, each with the weights of all handles.
    pub fn vertices(&self) -> impl Iterator<Item = (DVec2, &[f64])> + '_ {
        self.mesh.positions.iter().copied().zip(self.values.chunks_exact(self.handles))
    }
}

impl WeightField for MeshedWeights {
    fn handle_count(&self) -> usize {
        self.handles
    }

    fn weights_at(&self, place: DVec3, out: &mut [f64]) {
        out.fill(0.0);
        for (vertex, share) in self.mesh.locate(place.truncate()) {
            let values = &self.values[vertex * self.handles..][..self.handles];
            out.iter_mut().zip(values).for_each(|(out, w)| *out += share * w);
        }
    }

    fn quadrature(&self) -> Quadrature {
        Quadrature::PIECEWISE
    }
}

/// The program of each handle, with Q = L M⁻¹ L.
pub(super) fn solve_bounded(mesh: &PlaneMesh, fixed: &[Fixed], handles: usize) -> Result<Vec<Minimum>, WeightsError> {
    let (laplacian, areas) = Symmetric::laplacian(mesh);
    let q = laplacian.squared(&areas);
    let pattern = q.pattern()?;
    let handles: Vec<usize> = (0..handles).collect();
    let solved = spread::map(
        &handles,
        || (),
        |(), _, handle| {
            let fixed: Vec<Option<f64>> = fixed.iter().map(|f| f.map(|shares| share_of(&shares, *handle))).collect();
            minimise(&q, &pattern, &fixed)
        },
    );
    solved.into_iter().collect()
}

/// Refuses more weights than there should be.
fn bound_numbers(mesh: &PlaneMesh, handles: usize) -> Result<(), WeightsError> {
    let vertices = mesh.positions.len();
    let fits = vertices.saturating_mul(handles) <= MOST_NUMBERS;
    if fits { Ok(()) } else { Err(WeightsError::TooMany { handles, vertices }) }
}

/// Vertices on the cage, with their shares of two corners.
fn on_cage(mesh: &PlaneMesh, cage: &Cage) -> Vec<Fixed> {
    let count = cage.corners().len();
    let of_vertex = |(place, on_cage): (&DVec2, &bool)| {
        let (edge, t, _) = cage.nearest(*place);
        on_cage.then_some([(edge, 1.0 - t), ((edge + 1) % count, t)])
    };
    mesh.positions.iter().zip(&mesh.on_cage).map(of_vertex).collect()
}

fn share_of(shares: &[(usize, f64); 2], handle: usize) -> f64 {
    shares.iter().filter(|(of, _)| *of == handle).map(|(_, share)| share).sum()
}
