//! Closing a window: edits that are not saved are not lost without a question, and are kept where nobody could be asked.
//!
//! Windows must be left to this: `WindowPlugin::close_when_requested` is to be off. Where it is on, the engine closes them at once,
//! and what is not saved is kept for the next start.

use bevy::app::AppExit;
use bevy::prelude::*;
use bevy::window::WindowCloseRequested;

use super::save::Scene;
use super::{AutosaveSettings, DocumentFile, Question, Then, autosave};

/// Closes windows that are to be closed, after a question if there are edits that are not saved.
pub(super) fn ask(
    mut commands: Commands,
    mut requests: MessageReader<WindowCloseRequested>,
    mut files: ResMut<DocumentFile>,
    scene: Scene,
) {
    for request in requests.read() {
        if !scene.history.is_dirty() {
            commands.entity(request.window).try_despawn();
            continue;
        }
        // The edits are kept for the next start if an older question is still open and the window is closed by force.
        if files.question.as_ref().is_none_or(|question| !question.decides_for_good()) {
            let text = "There are edits that are not saved. Closing the editor loses them.".into();
            let then = Then::Close(request.window);
            files.question = Some(Question { text, yes: "Close, lose the edits", no: "Stay here", then });
        }
    }
}

/// When the program ends, whatever the reason, edits that are not saved are kept.
pub(super) fn keep_edits(
    mut exits: MessageReader<AppExit>,
    files: Res<DocumentFile>,
    settings: Res<AutosaveSettings>,
    scene: Scene,
) {
    let ends = exits.read().count() > 0;
    // A question about what is kept already has not been answered: that stays.
    let asked = files.question.as_ref().is_some_and(Question::decides_for_good);
    if ends && !asked && settings.enabled && scene.history.is_dirty() && !files.leaves_edits {
        // There is no frame after this one that could wait.
        if let Some(Err(error)) = autosave::work(&scene, &files, &settings).map(|work| work()) {
            error!("unsaved edits are lost: {error}");
        }
    }
}
