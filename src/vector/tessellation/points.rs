//! Control points that move.

use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;

/// The control points of a picture as they are now, and how often those of each path moved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PicturePoints {
    points: Vec<Vec3>,
    paths: Arc<[Range<usize>]>,
    moved: Vec<u32>,
}

impl PicturePoints {
    pub(super) fn new(points: &[Vec3], paths: Arc<[Range<usize>]>) -> Self {
        Self { points: points.to_vec(), moved: vec![0; paths.len()], paths }
    }

    /// Number of paths.
    pub fn path_count(&self) -> usize {
        self.paths.len()
    }

    /// The control points of a path: anchor, handle, handle, anchor, … Empty if there is no such path.
    pub fn of(&self, path: usize) -> &[Vec3] {
        self.paths.get(path).map_or(&[], |range| &self.points[range.clone()])
    }

    /// How often the control points of a path moved, which is how often what is painted of it was made again; 0 if there is no such path.
    pub fn moved(&self, path: usize) -> u32 {
        self.moved.get(path).copied().unwrap_or(0)
    }

    /// Moves the control points of a path; whether one was elsewhere before. What is missing, too much or not finite stays as it is.
    pub fn set(&mut self, path: usize, points: impl IntoIterator<Item = Vec3>) -> bool {
        let (Some(range), Some(moved)) = (self.paths.get(path), self.moved.get_mut(path)) else { return false };
        let mut differs = false;
        for (point, to) in self.points[range.clone()].iter_mut().zip(points) {
            if *point != to && to.is_finite() {
                (*point, differs) = (to, true);
            }
        }
        *moved = moved.wrapping_add(u32::from(differs));
        differs
    }

    /// All control points.
    pub(super) fn all(&self) -> &[Vec3] {
        &self.points
    }
}
