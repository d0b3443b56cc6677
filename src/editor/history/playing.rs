//! Playing entries back: undo and redo, and what a cancelled gesture leaves.
//!
//! An edit that is played comes round as [`SplineEdited`], with the inverse that plays the other way; until then what concerns its spline
//! waits.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::{Entry, History, PlayHistory, Step};
use crate::editor::curves::{self, Content, Curve, Shelved};
use crate::editor::notices::Notices;
use crate::plugin::{EditSpline, OnSurface, PendingEdit, SplineEditRefused, SplineEdited, SurfaceSpline};

/// An entry on its way back.
#[derive(Debug)]
pub(super) struct Playing {
    id: u64,
    name: String,
    direction: Direction,
    /// What is still to be played, the next one last.
    left: Vec<Step>,
    /// What plays the other way.
    played: Vec<Step>,
    /// The splines whose edits have been sent and have not come round.
    awaited: Vec<Entity>,
}

/// Where an entry goes that was played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Undo,
    Redo,
    /// Nowhere: a gesture was cancelled.
    Back,
}

/// What playing an entry back needs.
#[derive(SystemParam)]
pub(super) struct Player<'w, 's> {
    commands: Commands<'w, 's>,
    edits: MessageWriter<'w, EditSpline>,
    splines: Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>,
    shelved: Query<'w, 's, &'static Shelved>,
    curves: Query<'w, 's, &'static Curve>,
    lines: curves::Lines<'w, 's>,
    waiting: Query<'w, 's, (), With<PendingEdit>>,
    notices: ResMut<'w, Notices>,
}

pub(super) fn play(mut history: ResMut<History>, mut asked: MessageReader<PlayHistory>, mut player: Player) {
    for ask in asked.read() {
        history.asked.push_back(*ask);
    }
    if history.playing.is_none() && history.asked.is_empty() {
        return;
    }
    loop {
        if let Some(playing) = &mut history.playing {
            if !playing.go_on(&mut player) {
                return;
            }
            history.finish_playing();
        }
        let Some(ask) = history.asked.pop_front() else { return };
        history.begin_playing(ask, &mut player);
    }
}

impl History {
    fn begin_playing(&mut self, ask: PlayHistory, player: &mut Player) {
        let undoing = ask == PlayHistory::Undo;
        let next = if undoing { self.undo.back() } else { self.redo.last() };
        let Some(next) = next else { return };
        // What is computed yet would come before what is taken back, and have another version of the spline under it.
        let is_late = |step: &Step| matches!(step, Step::Edit(spline, _) if player.waiting.contains(*spline));
        if !self.groups.is_empty() || !self.gestures.is_empty() || next.steps.iter().any(is_late) {
            self.asked.clear();
            player.notices.warn("The last edit is still being computed: undo and redo when it is done.");
            return;
        }
        let entry = if undoing { self.undo.pop_back() } else { self.redo.pop() };
        let direction = if undoing { Direction::Undo } else { Direction::Redo };
        self.playing = entry.map(|entry| Playing::new(entry, direction));
    }

    /// An edit that was played back has come round, with the inverse that plays the other way.
    pub(super) fn come_round(&mut self, edited: &SplineEdited) {
        let Some(playing) = &mut self.playing else { return };
        if let Some(place) = playing.awaited.iter().position(|spline| *spline == edited.entity) {
            playing.awaited.remove(place);
            playing.played.push(Step::Edit(edited.entity, edited.inverse.clone()));
        }
    }

    fn finish_playing(&mut self) {
        let Some(Playing { id, name, direction, played, .. }) = self.playing.take() else { return };
        let entry = Entry { id, name, steps: played };
        match direction {
            Direction::Undo => self.redo.push(entry),
            Direction::Redo => self.undo.push_back(entry),
            Direction::Back => {}
        }
    }
}

impl Playing {
    pub(super) fn new(entry: Entry, direction: Direction) -> Self {
        let Entry { id, name, steps } = entry;
        let played = Vec::with_capacity(steps.len());
        Self { id, name, direction, left: steps, played, awaited: Vec::new() }
    }

    /// Plays as far as it gets without waiting; whether all is played.
    fn go_on(&mut self, player: &mut Player) -> bool {
        // Edits are applied in the order in which they are sent; all else must find its spline as it is then.
        let can_go =
            |step: &Step, awaited: &[Entity]| matches!(step, Step::Edit(..)) || !awaited.contains(&step.spline());
        while let Some(step) = self.left.pop_if(|step| can_go(step, &self.awaited)) {
            self.play(step, player);
        }
        self.left.is_empty() && self.awaited.is_empty()
    }

    fn play(&mut self, step: Step, player: &mut Player) {
        match step {
            Step::Edit(spline, edit) => {
                if player.splines.contains(spline) || player.shelved.contains(spline) {
                    player.edits.write(EditSpline::new(spline, edit));
                    self.awaited.push(spline);
                }
            }
            Step::Shelve(spline) => {
                let content = match (player.splines.get(spline), player.lines.get(spline)) {
                    (Ok((curve, on)), _) => Some((Content::Spline((**curve).clone()), on.0)),
                    (_, Ok((line, smoothing, on))) => Some((Content::Line(line.clone(), smoothing.copied()), on.0)),
                    _ => None,
                };
                if let Some((content, on)) = content {
                    curves::shelve(&mut player.commands, spline, content, on);
                    self.played.push(Step::Unshelve(spline));
                }
            }
            Step::Unshelve(spline) => {
                if let Ok(kept) = player.shelved.get(spline) {
                    curves::unshelve(&mut player.commands, spline, kept);
                    self.played.push(Step::Shelve(spline));
                }
            }
            Step::Restyle(spline, curve) => {
                if let Ok(now) = player.curves.get(spline) {
                    self.played.push(Step::Restyle(spline, now.clone()));
                    player.commands.entity(spline).try_insert(curve);
                }
            }
            Step::Redraw(entity, before) => {
                if let Ok((line, smoothing, _)) = player.lines.get(entity) {
                    self.played.push(Step::Redraw(entity, Box::new((line.clone(), smoothing.copied()))));
                    let (line, smoothing) = *before;
                    curves::set_line(&mut player.commands.entity(entity), line, smoothing);
                }
            }
        }
    }
}

/// An edit that is played back and refused does not come round: a game has changed the spline without the history.
pub(super) fn give_up(refused: On<SplineEditRefused>, mut history: ResMut<History>, mut notices: ResMut<Notices>) {
    if history.playing.as_ref().is_some_and(|playing| playing.awaited.contains(&refused.entity)) {
        history.forget();
        history.mark_touched();
        notices.warn("The curve was changed in other ways, so what came before cannot be taken back any more.");
    }
}
