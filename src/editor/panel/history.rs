//! The tab of the history: what was done, and what could be done again.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;

use crate::editor::actions::EditorAction;
use crate::editor::history::History;

/// What the tab shows.
#[derive(SystemParam)]
pub(crate) struct Entries<'w> {
    history: Res<'w, History>,
}

/// So many entries to either side are listed.
const SHOWN: usize = 100;

pub(crate) fn show(ui: &mut egui::Ui, entries: &Entries, actions: &mut MessageWriter<EditorAction>) {
    let (done, undone) = entries.history.all_names();
    let (done_count, undone_count) = (done.len(), undone.len());
    ui.horizontal(|ui| {
        let enabled = |count: usize, text: &str| (count > 0, egui::Button::new(text.to_string()));
        for ((enabled, button), key, action) in [
            (enabled(done_count, "⟲ Undo"), "Ctrl+Z", EditorAction::Undo),
            (enabled(undone_count, "⟳ Redo"), "Ctrl+Shift+Z", EditorAction::Redo),
        ] {
            if ui.add_enabled(enabled, button).on_hover_text(key).clicked() {
                actions.write(action);
            }
        }
    });
    if done_count + undone_count == 0 {
        ui.label(egui::RichText::new("Nothing was done yet").weak());
    }
    if done_count > 0 && ui.selectable_label(false, "Beginning").on_hover_text("Go back to where it began").clicked() {
        actions.write_batch((0..done_count).map(|_| EditorAction::Undo));
    }
    if done_count > SHOWN {
        ui.label(egui::RichText::new(format!("{} older ones", done_count - SHOWN)).weak());
    }
    for (index, name) in done.enumerate().skip(done_count.saturating_sub(SHOWN)) {
        let current = index + 1 == done_count;
        if ui.selectable_label(current, name).on_hover_text("Go back to here").clicked() {
            actions.write_batch((index + 1..done_count).map(|_| EditorAction::Undo));
        }
    }
    for (index, name) in undone.enumerate().take(SHOWN) {
        let text = egui::RichText::new(name).weak();
        if ui.selectable_label(false, text).on_hover_text("Do again up to here").clicked() {
            actions.write_batch((0..=index).map(|_| EditorAction::Redo));
        }
    }
}
