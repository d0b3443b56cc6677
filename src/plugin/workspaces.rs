//! Scratch memory for searches, shared by frames and background tasks.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::prelude::*;

use crate::curve::TraceWorkspace;

/// Workspaces that nobody uses at the moment: as many as were ever in use at once, which is one a thread.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct Workspaces(Arc<Mutex<Vec<TraceWorkspace>>>);

impl Workspaces {
    /// Lends a workspace.
    pub(crate) fn lend<R>(&self, work: impl FnOnce(&mut TraceWorkspace) -> R) -> R {
        let mut workspace = self.idle().pop().unwrap_or_default();
        let result = work(&mut workspace);
        self.idle().push(workspace);
        result
    }

    fn idle(&self) -> MutexGuard<'_, Vec<TraceWorkspace>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
