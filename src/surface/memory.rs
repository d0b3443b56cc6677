//! How much memory a surface holds.

use std::fmt;

use super::Surface;

/// Bytes that a surface holds, array by array.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SurfaceMemory {
    /// The arrays, largest first.
    pub arrays: Vec<ArrayMemory>,
}

/// Bytes that one array holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArrayMemory {
    /// What is in it.
    pub name: &'static str,
    /// How much was allocated for it.
    pub bytes: usize,
}

/// # Memory
impl Surface {
    /// What the surface holds in memory, array by array.
    ///
    /// ```
    /// use bevy_surface_splines::surface::{Surface, SurfaceOptions, shapes};
    ///
    /// let surface = Surface::build(&shapes::icosphere(5), &SurfaceOptions::default())?;
    /// assert!(surface.memory().bytes() < 120 * surface.face_count());
    /// println!("{}", surface.memory());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn memory(&self) -> SurfaceMemory {
        let mut arrays = vec![
            array("corners of faces", &self.triangles),
            array("neighbours across sides", &self.twins),
            array("lengths of sides", &self.lengths),
            array("positions of vertices", &self.positions),
            array("a side at each vertex", &self.outgoing),
            array("angles about vertices", &self.angle),
            array("vertices on the boundary", &self.boundary),
            array("sheets of faces", &self.sheet),
            array("slack of sheets", &self.slack),
            array("mean edges of sheets", &self.mean_edge),
            array("input faces to faces", &self.inner_of),
            array("faces to input faces", &self.outer_of),
            array("faces dropped", &self.report.dropped),
            self.bvh.memory(),
            self.clusters.memory(),
        ];
        arrays.sort_by_key(|array| std::cmp::Reverse(array.bytes));
        SurfaceMemory { arrays }
    }
}

impl SurfaceMemory {
    /// All arrays together.
    pub fn bytes(&self) -> usize {
        self.arrays.iter().map(|array| array.bytes).sum()
    }
}

impl fmt::Display for SurfaceMemory {
    /// A line an array, and one with the sum.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for array in &self.arrays {
            writeln!(f, "{:>12} bytes  {}", array.bytes, array.name)?;
        }
        write!(f, "{:>12} bytes  in all", self.bytes())
    }
}

/// What was allocated for a vector.
pub(crate) fn array<T>(name: &'static str, items: &Vec<T>) -> ArrayMemory {
    ArrayMemory { name, bytes: items.capacity() * size_of::<T>() }
}
