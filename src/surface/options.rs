//! How a surface is to be built, and how far building has come.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// What to do with edges that have three or more faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum NonManifoldEdges {
    /// All their sides become boundary.
    #[default]
    Cut,
    /// Faces are paired by their order around the edge, so that each pair bounds one wedge of space.
    Pair,
    /// Building fails.
    Refuse,
}

/// What to do with vertices whose faces form several fans.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum NonManifoldVertices {
    /// Each fan gets a vertex of its own.
    #[default]
    Split,
    /// Building fails.
    Refuse,
}

/// What to do with components that cannot be oriented.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum NonOrientable {
    /// A seam is cut along the edges where neighbours cannot agree.
    #[default]
    Cut,
    /// Building fails.
    Refuse,
}

/// How a surface is to be built.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "document", serde(default, deny_unknown_fields))]
pub struct SurfaceOptions {
    /// Edges with three or more faces.
    pub nonmanifold_edges: NonManifoldEdges,
    /// Vertices with several fans.
    pub nonmanifold_vertices: NonManifoldVertices,
    /// Components that cannot be oriented.
    pub non_orientable: NonOrientable,
}

/// Watches a build from another thread, and can stop it.
#[derive(Debug, Default)]
pub struct BuildProgress {
    permille: AtomicU32,
    cancelled: AtomicBool,
}

impl BuildProgress {
    /// How far the build has come, from 0 to 1.
    pub fn fraction(&self) -> f32 {
        self.permille.load(Ordering::Relaxed) as f32 / 1000.0
    }

    /// Asks the build to stop; it ends with [`SurfaceError::Cancelled`](super::SurfaceError::Cancelled) at its next step.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    pub(crate) fn step(&self, permille: u32) -> Result<(), super::SurfaceError> {
        self.permille.store(permille, Ordering::Relaxed);
        self.check()
    }

    /// Ends a build that was cancelled.
    pub(crate) fn check(&self) -> Result<(), super::SurfaceError> {
        if self.cancelled.load(Ordering::Relaxed) { Err(super::SurfaceError::Cancelled) } else { Ok(()) }
    }
}
