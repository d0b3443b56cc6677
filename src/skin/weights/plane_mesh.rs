//! Triangles inside a cage.

use std::collections::HashSet;

use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation, handles::FixedFaceHandle};

use super::{Cage, WeightsError};

/// A Delaunay triangulation of a cage's inside.
#[derive(Clone, Debug)]
pub(super) struct PlaneMesh {
    pub(super) positions: Vec<DVec2>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Whether a vertex is on the cage.
    pub(super) on_cage: Vec<bool>,
    /// Edges of the cage's pieces.
    rim: Vec<[u32; 2]>,
    bins: Bins,
}

/// Which triangles are near.
#[derive(Clone, Debug, Default)]
struct Bins {
    low: DVec2,
    size: f64,
    across: usize,
    up: usize,
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl PlaneMesh {
    /// Triangulates a cage with vertices at some places inside, into about so many triangles. Where the cage is thin there may be more: at most
    /// `spare` times as many vertices besides those of the cage and the places.
    pub(super) fn new(cage: &Cage, places: &[DVec2], triangles: usize, spare: usize) -> Result<Self, WeightsError> {
        let corners = cage.corners();
        // About the origin and of size one, which is what the triangulation likes best.
        let (low, extent) = (corners.iter().copied().fold(DVec2::MAX, DVec2::min), cage.extent());
        let inward = |p: DVec2| (p - low) / extent;
        let vertex = |p: &DVec2| {
            let p = inward(*p);
            Point2::new(p.x, p.y)
        };
        let mut mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
        let mut insert = |p: &DVec2| mesh.insert(vertex(p)).map_err(|_| WeightsError::Triangulation);
        let on_cage = corners.iter().map(&mut insert).collect::<Result<Vec<_>, _>>()?;
        places.iter().try_for_each(|p| insert(p).map(|_| ()))?;
        for (i, from) in on_cage.iter().enumerate() {
            let to = on_cage[(i + 1) % on_cage.len()];
            if *from == to || !mesh.can_add_constraint(*from, to) {
                return Err(WeightsError::Triangulation);
            }
            mesh.add_constraint(*from, to);
        }
        let count = triangles.clamp(16, 1 << 18);
        let edges = (0..corners.len()).map(|i| inward(corners[i]).perp_dot(inward(corners[(i + 1) % corners.len()])));
        let area = 0.5 * edges.sum::<f64>().abs();
        let refined = mesh.refine(
            RefinementParameters::new()
                .exclude_outer_faces(true)
                // Even refinement leaves triangles of two thirds of the largest area.
                .with_max_allowed_area(1.5 * area / count as f64)
                .with_min_required_area(1e-3 * area / count as f64)
                .with_max_additional_vertices(spare * count),
        );
        let outer: HashSet<FixedFaceHandle<_>> = refined.excluded_faces.into_iter().collect();
        let mut numbers = vec![u32::MAX; mesh.num_vertices()];
        let (mut positions, mut kept) = (Vec::new(), Vec::new());
        for face in mesh.inner_faces().filter(|face| !outer.contains(&face.fix())) {
            kept.push(face.vertices().map(|corner| {
                let number = &mut numbers[corner.fix().index()];
                if *number == u32::MAX {
                    *number = positions.len() as u32;
                    let p = corner.position();
                    positions.push(low + DVec2::new(p.x, p.y) * extent);
                }
                *number
            }));
        }
        if kept.is_empty() {
            return Err(WeightsError::Triangulation);
        }
        let mut found = Self {
            on_cage: vec![false; positions.len()],
            positions,
            triangles: kept,
            rim: Vec::new(),
            bins: Bins::default(),
        };
        found.find_rim();
        found.fill_bins();
        Ok(found)
    }

    /// The vertex at a place, if one is.
    pub(super) fn vertex_at(&self, place: DVec2, extent: f64) -> Option<usize> {
        let corners = self.locate(place).into_iter().map(|(vertex, _)| vertex);
        let distances = corners.map(|vertex| (vertex, self.positions[vertex].distance(place)));
        let (vertex, distance) = distances.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (distance <= 1e-9 * extent).then_some(vertex)
    }

    /// Vertices about a place with their shares; about the nearest place of the rim if it lies outside.
    pub(super) fn locate(&self, place: DVec2) -> [(usize, f64); 3] {
        let bins = &self.bins;
        let cell = (place - bins.low) / bins.size;
        if cell.x >= 0.0 && cell.y >= 0.0 && (cell.x as usize) < bins.across && (cell.y as usize) < bins.up {
            let bin = cell.y as usize * bins.across + cell.x as usize;
            for triangle in &bins.triangles[bins.starts[bin] as usize..bins.starts[bin + 1] as usize] {
                let corners = self.triangles[*triangle as usize];
                let [a, b, c] = corners.map(|v| self.positions[v as usize]);
                let area = (b - a).perp_dot(c - a);
                let shares = [(b - place).perp_dot(c - place) / area, (c - place).perp_dot(a - place) / area];
                let shares = [shares[0], shares[1], 1.0 - shares[0] - shares[1]];
                if shares.iter().all(|share| *share >= -1e-12) {
                    return std::array::from_fn(|k| (corners[k] as usize, shares[k].max(0.0)));
                }
            }
        }
        let mut nearest = (f64::INFINITY, [(0, 1.0), (0, 0.0), (0, 0.0)]);
        for [from, to] in &self.rim {
            let (a, b) = (self.positions[*from as usize], self.positions[*to as usize]);
            let t = ((place - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            let squared = place.distance_squared(a.lerp(b, t));
            if squared < nearest.0 {
                nearest = (squared, [(*from as usize, 1.0 - t), (*to as usize, t), (*from as usize, 0.0)]);
            }
        }
        nearest.1
    }

    fn find_rim(&mut self) {
        let mut sides: Vec<[u32; 3]> = Vec::with_capacity(3 * self.triangles.len());
        for t in &self.triangles {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                sides.push([a.min(b), a.max(b), u32::from(a < b)]);
            }
        }
        sides.sort_unstable();
        for group in sides.chunk_by(|a, b| a[..2] == b[..2]) {
            if let [[a, b, _]] = group {
                self.rim.push([*a, *b]);
                self.on_cage[*a as usize] = true;
                self.on_cage[*b as usize] = true;
            }
        }
    }

    fn fill_bins(&mut self) {
        let low = self.positions.iter().copied().fold(DVec2::MAX, DVec2::min);
        let high = self.positions.iter().copied().fold(DVec2::MIN, DVec2::max);
        let wide = (high - low).max(DVec2::splat(1e-300));
        let size = (wide.x * wide.y / self.triangles.len() as f64).sqrt().max(wide.max_element() / 1024.0);
        let cells = (wide / size).floor();
        let (across, up) = (cells.x as usize + 1, cells.y as usize + 1);
        let range = |triangle: &[u32; 3]| {
            let corners = triangle.map(|v| (self.positions[v as usize] - low) / size);
            // Wider by rounding of places.
            let from = corners[0].min(corners[1]).min(corners[2]) - 1e-9;
            let to = corners[0].max(corners[1]).max(corners[2]) + 1e-9;
            let cell = |x: f64, count: usize| (x.max(0.0) as usize).min(count - 1);
            (cell(from.x, across)..=cell(to.x, across), cell(from.y, up)..=cell(to.y, up))
        };
        let mut entries = Vec::new();
        for (number, triangle) in self.triangles.iter().enumerate() {
            let (columns, rows) = range(triangle);
            entries.extend(rows.flat_map(|y| columns.clone().map(move |x| ((y * across + x) as u32, number as u32))));
        }
        entries.sort_unstable();
        let mut starts = vec![0; across * up + 1];
        entries.iter().for_each(|(bin, _)| starts[*bin as usize + 1] += 1);
        (0..across * up).for_each(|bin| starts[bin + 1] += starts[bin]);
        let triangles = entries.iter().map(|(_, triangle)| *triangle).collect();
        self.bins = Bins { low, size, across, up, starts, triangles };
    }
}
