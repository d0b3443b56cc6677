//! The steps of a frame that characters have of their own.

use bevy::app::AnimationSystems;
use bevy::asset::AssetEventSystems;
use bevy::prelude::*;

/// The steps of a frame for characters and painted paths: all in `PostUpdate` in this order. `Spawn` comes before the engine's animation, the others
/// after it and before assets are announced, so that the renderer sees the pose of this very frame.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CharacterSystems {
    /// Characters get their joints.
    Spawn,
    /// Joints move control points. They are looked up along their parents, so this need not wait for transforms to be propagated.
    Pose,
    /// Shapes that moved are tessellated.
    Tessellate,
}

#[derive(Resource)]
struct Configured;

/// Puts the sets in order; every plugin calls it, and calling it again changes nothing.
pub(super) fn configure(app: &mut App) {
    use CharacterSystems::{Pose, Spawn, Tessellate};
    if app.world().contains_resource::<Configured>() {
        return;
    }
    app.insert_resource(Configured)
        .configure_sets(PostUpdate, (Spawn, Pose, Tessellate).chain())
        .configure_sets(PostUpdate, Spawn.before(AnimationSystems))
        .configure_sets(PostUpdate, Pose.after(AnimationSystems))
        .configure_sets(PostUpdate, Tessellate.before(AssetEventSystems).before(TransformSystems::Propagate));
}
