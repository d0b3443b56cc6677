//! What is selected: splines, and anchors of them. The one selected last is active.

use bevy::prelude::*;

use super::curves::Curve;
use crate::curve::{SplineEdit, SplineEnd};
use crate::plugin::{Editable, SplineEdited, SurfaceLine, SurfaceSpline, SurfaceSplineSystems};

/// Handles of at most so many splines are shown: more would hide what one looks for.
const MOST_EDITABLE: usize = 16;

/// What tools and actions work on.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Selected splines in the order in which they were; those of selected anchors are among them.
    splines: Vec<Entity>,
    anchors: Vec<(Entity, u32)>,
    /// What an edit of this frame makes, and is to be selected then.
    next: Option<(Entity, u32)>,
}

impl Selection {
    /// The splines; the last is active.
    pub fn splines(&self) -> &[Entity] {
        &self.splines
    }

    /// The anchors, each with its spline; the last is active.
    pub fn anchors(&self) -> &[(Entity, u32)] {
        &self.anchors
    }

    /// The spline that was selected last.
    pub fn spline(&self) -> Option<Entity> {
        self.splines.last().copied()
    }

    /// The anchor that was selected last, if it belongs to the active spline.
    pub fn anchor(&self) -> Option<u32> {
        let (spline, anchor) = *self.anchors.last()?;
        (self.spline() == Some(spline)).then_some(anchor)
    }

    /// The anchors of one spline.
    pub fn anchors_of(&self, spline: Entity) -> impl Iterator<Item = u32> {
        self.anchors.iter().filter(move |(of, _)| *of == spline).map(|(_, anchor)| *anchor)
    }

    /// Whether a spline is selected.
    pub fn has_spline(&self, spline: Entity) -> bool {
        self.splines.contains(&spline)
    }

    /// Whether an anchor is selected.
    pub fn has_anchor(&self, spline: Entity, anchor: u32) -> bool {
        self.anchors.contains(&(spline, anchor))
    }

    /// Whether nothing is selected.
    pub fn is_empty(&self) -> bool {
        self.splines.is_empty()
    }

    /// Selects a spline alone, and none of its anchors.
    pub fn select(&mut self, spline: Entity) {
        self.clear();
        self.splines.push(spline);
    }

    /// Selects an anchor alone.
    pub fn select_anchor(&mut self, spline: Entity, anchor: u32) {
        self.clear();
        self.splines.push(spline);
        self.anchors.push((spline, anchor));
    }

    /// Selects an anchor alone once the edits of this frame are applied, which may make it or give it its number.
    pub fn select_anchor_next(&mut self, spline: Entity, anchor: u32) {
        self.next = Some((spline, anchor));
    }

    /// Adds a spline, which becomes active.
    pub fn add(&mut self, spline: Entity) {
        self.splines.retain(|other| *other != spline);
        self.splines.push(spline);
    }

    /// Adds an anchor, which becomes active, and its spline.
    pub fn add_anchor(&mut self, spline: Entity, anchor: u32) {
        self.add(spline);
        self.anchors.retain(|other| *other != (spline, anchor));
        self.anchors.push((spline, anchor));
    }

    /// Takes a spline and its anchors out.
    pub fn remove(&mut self, spline: Entity) {
        self.splines.retain(|other| *other != spline);
        self.anchors.retain(|(of, _)| *of != spline);
    }

    /// Adds a spline, or takes it out.
    pub fn toggle(&mut self, spline: Entity) {
        if self.has_spline(spline) { self.remove(spline) } else { self.add(spline) }
    }

    /// Adds an anchor, or takes it out.
    pub fn toggle_anchor(&mut self, spline: Entity, anchor: u32) {
        if self.has_anchor(spline, anchor) {
            self.anchors.retain(|other| *other != (spline, anchor));
        } else {
            self.add_anchor(spline, anchor);
        }
    }

    /// Takes the anchors out.
    pub fn clear_anchors(&mut self) {
        self.anchors.clear();
    }

    /// Selects nothing.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

pub(crate) fn plugin(app: &mut App) {
    // An anchor that an edit of this frame adds may be selected in the same frame.
    let between = (follow_edits, forget_missing, mark_editable).chain().after(SurfaceSplineSystems::Edit);
    app.init_resource::<Selection>().add_systems(PostUpdate, between.before(SurfaceSplineSystems::Controls));
}

/// Anchors that were inserted or deleted before a selected one change its number; where more changes, none stays selected.
fn follow_edits(mut selection: ResMut<Selection>, mut edited: MessageReader<SplineEdited>) {
    for edit in edited.read().filter(|edit| edit.gesture.is_none()) {
        let moved = |anchor: u32| match &edit.edit {
            SplineEdit::Delete { anchor: gone } | SplineEdit::DeleteFitted { anchor: gone } if *gone == anchor => None,
            SplineEdit::Delete { anchor: gone } | SplineEdit::DeleteFitted { anchor: gone } if *gone < anchor => {
                Some(anchor - 1)
            }
            SplineEdit::Insert { at } if f64::from(anchor) > at.0 => Some(anchor + 1),
            SplineEdit::Restore(patch) if !patch.keeps_numbers() => None,
            SplineEdit::Replace(_) | SplineEdit::Open { .. } | SplineEdit::Reverse => None,
            SplineEdit::Cut { .. } | SplineEdit::Join { .. } => None,
            SplineEdit::Append { end: SplineEnd::Start, .. } => Some(anchor + 1),
            _ => Some(anchor),
        };
        let renumbered = |(spline, anchor): &(Entity, u32)| {
            let anchor = if *spline == edit.entity { moved(*anchor)? } else { *anchor };
            Some((*spline, anchor))
        };
        let anchors: Vec<_> = selection.anchors.iter().filter_map(renumbered).collect();
        if anchors != selection.anchors {
            selection.anchors = anchors;
        }
    }
    if let Some((spline, anchor)) = selection.next {
        selection.select_anchor(spline, anchor);
    }
}

/// What can be selected.
type Selectable<'w, 's> =
    Query<'w, 's, (AnyOf<(&'static SurfaceSpline, &'static SurfaceLine)>, Option<&'static Curve>)>;

/// Splines and anchors that are gone, hidden or locked are not selected.
fn forget_missing(mut selection: ResMut<Selection>, splines: Selectable) {
    if selection.is_empty() {
        return;
    }
    let count = |spline: Entity| {
        let (found, curve) = splines.get(spline).ok()?;
        curve.is_none_or(Curve::is_free).then(|| found.0.map_or(0, |spline| spline.anchors().len()))
    };
    let mut next = selection.clone();
    next.splines.retain(|spline| count(*spline).is_some());
    next.anchors.retain(|(spline, anchor)| count(*spline).is_some_and(|count| (*anchor as usize) < count));
    selection.set_if_neq(next);
}

fn mark_editable(
    mut commands: Commands,
    selection: Res<Selection>,
    splines: Query<(Entity, Has<Editable>), With<SurfaceSpline>>,
) {
    let first = selection.splines.len().saturating_sub(MOST_EDITABLE);
    let shown = &selection.splines[first..];
    for (entity, editable) in &splines {
        let wanted = shown.contains(&entity);
        if wanted && !editable {
            commands.entity(entity).try_insert(Editable);
        } else if editable && !wanted {
            commands.entity(entity).try_remove::<Editable>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_one_is_active() {
        let [a, b] = [1, 2].map(|i| Entity::from_raw_u32(i).expect("an entity"));
        let mut selection = Selection::default();
        selection.select_anchor(a, 3);
        assert_eq!((selection.spline(), selection.anchor()), (Some(a), Some(3)));
        selection.add(b);
        assert_eq!((selection.spline(), selection.anchor()), (Some(b), None));
        selection.toggle_anchor(a, 1);
        assert_eq!((selection.spline(), selection.anchor()), (Some(a), Some(1)));
        assert_eq!(selection.anchors_of(a).collect::<Vec<_>>(), [3, 1]);
        selection.toggle_anchor(a, 1);
        assert_eq!(selection.anchors(), [(a, 3)]);
        selection.remove(a);
        assert_eq!((selection.splines(), selection.anchors()), (&[b][..], &[][..]));
    }
}
