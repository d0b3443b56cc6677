//! Scratch memory for searches, shared by frames and background tasks.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::prelude::*;

use crate::curve::TraceWorkspace;

/// Workspaces that nobody uses at the moment: as many as were ever in use at once, which is one a thread.
#[derive(Resource, Debug)]
pub(crate) struct Workspaces<W: Send + 'static = TraceWorkspace>(Arc<Mutex<Vec<W>>>);

// Derived, these would ask for workspaces that can be cloned.
impl<W: Send + 'static> Clone for Workspaces<W> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<W: Send + 'static> Default for Workspaces<W> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<W: Default + Send + 'static> Workspaces<W> {
    /// Lends a workspace.
    pub(crate) fn lend<R>(&self, work: impl FnOnce(&mut W) -> R) -> R {
        let mut workspace = self.idle().pop().unwrap_or_default();
        let result = work(&mut workspace);
        self.idle().push(workspace);
        result
    }

    fn idle(&self) -> MutexGuard<'_, Vec<W>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
