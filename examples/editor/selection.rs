//! What is selected: a spline, and perhaps one of its anchors. The selected spline is [`Editable`].

use bevy::prelude::*;
use bevy_surface_splines::prelude::*;

#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Selection {
    pub(crate) spline: Option<Entity>,
    pub(crate) anchor: Option<u32>,
}

impl Selection {
    /// Selects a spline; its anchor stays selected if it was the same spline.
    pub(crate) fn select(&mut self, spline: Entity) {
        if self.spline != Some(spline) {
            *self = Self { spline: Some(spline), anchor: None };
        }
    }

    pub(crate) fn select_anchor(&mut self, spline: Entity, anchor: u32) {
        *self = Self { spline: Some(spline), anchor: Some(anchor) };
    }

    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}

pub(crate) fn plugin(app: &mut App) {
    // An anchor that an edit of this frame adds may be selected in the same frame.
    let between = (forget_missing, mark_editable).chain().after(SurfaceSplineSystems::Edit);
    app.init_resource::<Selection>().add_systems(PostUpdate, between.before(SurfaceSplineSystems::Controls));
}

/// Splines and anchors that are gone are not selected.
fn forget_missing(mut selection: ResMut<Selection>, splines: Query<&SurfaceSpline>) {
    let mut next = *selection;
    if next.spline.is_some_and(|spline| !splines.contains(spline)) {
        next.clear();
    }
    let count = next.spline.and_then(|spline| splines.get(spline).ok()).map_or(0, |spline| spline.anchors().len());
    next.anchor = next.anchor.filter(|anchor| (*anchor as usize) < count);
    selection.set_if_neq(next);
}

fn mark_editable(
    mut commands: Commands,
    selection: Res<Selection>,
    splines: Query<(Entity, Has<Editable>), With<SurfaceSpline>>,
) {
    for (entity, editable) in &splines {
        let wanted = selection.spline == Some(entity);
        if wanted && !editable {
            commands.entity(entity).try_insert(Editable);
        } else if editable && !wanted {
            commands.entity(entity).try_remove::<Editable>();
        }
    }
}
