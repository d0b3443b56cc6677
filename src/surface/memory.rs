//! How much memory a surface holds.

use std::fmt;

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
