//! A path of the baseline, and points on it.

use bevy_surface_splines::surface::{FaceId, SurfacePoint};
use glam::DVec3;

use super::mesh::Mesh;

/// Where a path crosses a side, 0 at its left end and 1 at its right one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) left: u32,
    pub(super) right: u32,
    pub(super) at: f64,
}

/// A polyline over the faces of a strip.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    start: SurfacePoint,
    end: SurfacePoint,
    strip: Vec<u32>,
    crossings: Vec<Crossing>,
    /// Length up to the end of each face.
    lengths: Vec<f64>,
}

impl Path {
    pub(super) fn new(
        mesh: &Mesh,
        start: SurfacePoint,
        end: SurfacePoint,
        strip: Vec<u32>,
        crossings: Vec<Crossing>,
    ) -> Self {
        let mut sum = 0.0;
        let mut from = place(mesh, &start);
        let crossed = crossings.iter().map(|c| mesh.position(c.left).lerp(mesh.position(c.right), c.at));
        let lengths = crossed
            .chain([place(mesh, &end)])
            .map(|to| {
                sum += from.distance(to);
                from = to;
                sum
            })
            .collect();
        Self { start, end, strip, crossings, lengths }
    }

    pub(crate) fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or_default()
    }

    pub(super) fn at(&self, mesh: &Mesh, share: f64) -> SurfacePoint {
        let wanted = share * self.length();
        let i = self.lengths.partition_point(|&l| l < wanted).min(self.crossings.len());
        let before = if i == 0 { 0.0 } else { self.lengths[i - 1] };
        let local = if self.lengths[i] > before { (wanted - before) / (self.lengths[i] - before) } else { 0.0 };
        let face = self.strip[i];
        let from = if i == 0 { self.start.weights } else { weights(mesh, face, &self.crossings[i - 1]) };
        let to = self.crossings.get(i).map_or(self.end.weights, |crossing| weights(mesh, face, crossing));
        let mixed = [0, 1, 2].map(|k| (from[k] + (to[k] - from[k]) * local).max(0.0));
        let sum: f64 = mixed.iter().sum();
        SurfacePoint { face: FaceId(face), weights: mixed.map(|w| w / sum) }
    }
}

fn place(mesh: &Mesh, point: &SurfacePoint) -> DVec3 {
    let corners = mesh.faces[point.face.0 as usize];
    corners.iter().zip(point.weights).map(|(&c, w)| mesh.position(c) * w).sum()
}

/// The weights of a face's corners at a crossing of one of its sides.
fn weights(mesh: &Mesh, face: u32, crossing: &Crossing) -> [f64; 3] {
    mesh.faces[face as usize].map(|corner| match corner {
        c if c == crossing.left => 1.0 - crossing.at,
        c if c == crossing.right => crossing.at,
        _ => 0.0,
    })
}
