//! What keys and panel ask for: edits of the selected spline, which leave as [`EditSpline`]s, and the history.

use bevy::prelude::*;
use bevy_surface_splines::curve::Spline;
use bevy_surface_splines::plugin::EndGesture;
use bevy_surface_splines::prelude::*;

use crate::curves;
use crate::history::{History, Step};
use crate::notices::Notices;
use crate::selection::Selection;
use crate::tools::Tool;

/// Something to be done.
#[derive(Message, Clone, Debug, PartialEq)]
pub(crate) enum Action {
    Take(Tool),
    Select(Entity),
    /// Takes the pen, for a new spline.
    BeginSpline,
    /// Deletes the selected anchor, or the selected spline where there is none or too few would be left.
    Delete,
    /// Removes a spline.
    Remove(Entity),
    /// Corner → smooth → mirrored → automatic.
    CycleJoin,
    SetJoin(Join),
    SetScheme(Scheme),
    SetJumps(JumpPolicy),
    /// A scheme on the way to another: all until [`Action::EndSlide`] are one step of the history.
    SlideScheme(Scheme),
    EndSlide,
    Undo,
    Redo,
}

/// A spline was made by the user.
#[derive(Message, Clone, Copy, Debug)]
pub(crate) struct Spawned(pub(crate) Entity);

pub(crate) fn plugin(app: &mut App) {
    app.add_message::<Action>()
        .add_message::<Spawned>()
        .add_observer(tell_refusal)
        .add_systems(PostUpdate, (note_spawned, perform).chain().before(SurfaceSplineSystems::Edit));
}

fn tell_refusal(refused: On<SplineEditRefused>, mut notices: ResMut<Notices>, mut history: ResMut<History>) {
    history.forget_pending(refused.entity);
    notices.warn(refused.reason.to_string());
}

fn note_spawned(mut spawned: MessageReader<Spawned>, mut history: ResMut<History>) {
    for Spawned(entity) in spawned.read() {
        history.push("Add spline", *entity, Step::Shelve);
    }
}

type Splines<'w, 's> = Query<'w, 's, (&'static SurfaceSpline, &'static OnSurface)>;

fn perform(
    mut commands: Commands,
    mut actions: MessageReader<Action>,
    (mut edits, mut ends): (MessageWriter<EditSpline>, MessageWriter<EndGesture>),
    mut slide: Local<Option<GestureId>>,
    (mut history, mut notices): (ResMut<History>, ResMut<Notices>),
    (mut selection, mut tool): (ResMut<Selection>, ResMut<Tool>),
    (splines, shelved, waiting): (Splines, Query<&curves::Shelved>, Query<(), With<PendingEdit>>),
) {
    for action in actions.read() {
        let selected = selection.spline.and_then(|entity| Some((entity, splines.get(entity).ok()?.0)));
        let anchor = selection.anchor;
        let mut send = |entity: Entity, edit: SplineEdit| {
            edits.write(EditSpline::new(entity, edit).undoable());
        };
        match action {
            Action::Take(taken) => *tool = *taken,
            Action::Select(entity) => selection.select(*entity),
            Action::BeginSpline => {
                selection.clear();
                *tool = Tool::Pen;
            }
            // What is computed yet would come before what is taken back, and have another version of the spline under it.
            Action::Undo | Action::Redo
                if history.next(matches!(action, Action::Undo)).is_some_and(|s| waiting.contains(s)) =>
            {
                notices.warn("The last edit is still being computed: undo and redo when it is done.");
            }
            Action::Undo => history.undo(&mut commands, &mut edits, &splines, &shelved),
            Action::Redo => history.redo(&mut commands, &mut edits, &splines, &shelved),
            Action::Remove(entity) => remove(&mut commands, &mut history, *entity, &splines),
            Action::Delete => match (selected, anchor) {
                (Some((entity, spline)), Some(anchor)) if spline.anchors().len() > 2 => {
                    send(entity, SplineEdit::Delete { anchor });
                    selection.anchor = None;
                }
                (Some((entity, _)), _) => remove(&mut commands, &mut history, entity, &splines),
                (None, _) => {}
            },
            Action::CycleJoin => {
                if let (Some((entity, spline)), Some(anchor)) = (selected, anchor)
                    && !spline.scheme().method.is_b_spline()
                    && let Some(join) = join_of(spline, anchor)
                {
                    set_join(spline, anchor, next_join(join), |edit| send(entity, edit));
                }
            }
            Action::SetJoin(join) => {
                if let (Some((entity, spline)), Some(anchor)) = (selected, anchor) {
                    set_join(spline, anchor, *join, |edit| send(entity, edit));
                }
            }
            Action::SetScheme(scheme) => {
                if let Some((entity, _)) = selected.filter(|(_, spline)| spline.scheme() != *scheme) {
                    send(entity, SplineEdit::SetScheme(*scheme));
                }
            }
            Action::SetJumps(jumps) => {
                if let Some((entity, _)) = selected.filter(|(_, spline)| spline.jumps() != *jumps) {
                    send(entity, SplineEdit::SetJumps(*jumps));
                }
            }
            Action::SlideScheme(scheme) => {
                if let Some((entity, _)) = selected {
                    let gesture = *slide.get_or_insert_with(GestureId::next);
                    let edit = EditSpline::new(entity, SplineEdit::SetScheme(*scheme));
                    edits.write(edit.undoable().in_gesture(gesture));
                }
            }
            Action::EndSlide => {
                ends.write_batch(slide.take().map(|gesture| EndGesture { gesture, cancel: false }));
            }
        }
    }
}

fn remove(commands: &mut Commands, history: &mut History, entity: Entity, splines: &Splines) {
    let Ok((spline, on)) = splines.get(entity) else { return };
    curves::shelve(commands, entity, spline, on.0);
    history.push("Remove spline", entity, Step::Unshelve);
}

fn join_of(spline: &Spline, anchor: u32) -> Option<Join> {
    spline.anchors().get(anchor as usize).map(|anchor| anchor.join())
}

fn next_join(join: Join) -> Join {
    match join {
        Join::Corner => Join::Smooth,
        Join::Smooth => Join::Mirrored,
        Join::Mirrored => Join::Automatic,
        Join::Automatic => Join::Corner,
    }
}

/// Sets a join. Handles of no length have no direction that could be smooth: they are placed first.
fn set_join(spline: &Spline, anchor: u32, join: Join, mut send: impl FnMut(SplineEdit)) {
    let Some(at) = spline.anchors().get(anchor as usize) else { return };
    let bare = at.incoming().leg().length() == 0.0 && at.outgoing().leg().length() == 0.0;
    if bare && matches!(join, Join::Smooth | Join::Mirrored) {
        send(SplineEdit::SetJoin { anchor, join: Join::Automatic });
    }
    send(SplineEdit::SetJoin { anchor, join });
}
